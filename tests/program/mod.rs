//! A program without a terminal. If it hangs, its test fails in the end, and the program is killed.

use std::io::{Read, read_to_string};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// More than any test reads. Without a limit, a program that never stops writing would fill the memory.
const MOST_BYTES: usize = 20_000_000;

/// How long a test waits for a program. Even on a very busy machine, nothing that it waits for has taken a
/// fifth of this.
pub const LIMIT: Duration = Duration::from_secs(30);

/// Runs this in a thread. The test fails if it takes ten minutes, as it does if a program hangs.
pub fn in_time<T: Send + 'static>(run: impl FnOnce() -> T + Send + 'static) -> T {
    let (sender, receiver) = channel();
    thread::spawn(move || sender.send(run()));
    receiver.recv_timeout(20 * LIMIT).expect("there is a panic above, or something hangs")
}

/// Reads a pipe to its end. The test fails if nothing comes for half a minute.
fn read_all(mut pipe: impl Read + Send + 'static) -> String {
    let (sender, receiver) = channel();
    thread::spawn(move || {
        let mut buffer = vec![0; 1 << 16];
        while let count @ 1.. = pipe.read(&mut buffer).unwrap() {
            let _ = sender.send(buffer[..count].to_vec());
        }
    });
    let mut bytes = Vec::new();
    loop {
        match receiver.recv_timeout(LIMIT) {
            Ok(more) => bytes.extend(more),
            Err(RecvTimeoutError::Disconnected) => return String::from_utf8(bytes).unwrap(),
            Err(RecvTimeoutError::Timeout) => panic!("nothing has come for half a minute"),
        }
        assert!(bytes.len() < MOST_BYTES, "the program does not stop writing");
    }
}

/// A program that is killed if its test ends before it.
pub struct Program(pub Child);

impl Program {
    /// Starts a program with options that are separated by blanks.
    pub fn start(program: &str, options: &str, stdout: impl Into<Stdio>) -> Program {
        let mut command = Command::new(program);
        // In a pipe or a file, donut writes its escape codes whatever these variables say.
        command.args(options.split(' ')).env("TERM", "dumb").env("NO_COLOR", "1");
        command.stdin(Stdio::null()).stdout(stdout).stderr(Stdio::piped());
        Program(command.spawn().unwrap())
    }

    /// Waits for the program's end. Returns its exit code, the rest of what it has written, and its message.
    pub fn output(mut self) -> (Option<i32>, String, String) {
        let written = self.0.stdout.take().map(read_all).unwrap_or_default();
        let stderr = self.0.stderr.take().unwrap();
        let message = in_time(|| read_to_string(stderr).unwrap());
        (self.0.wait().unwrap().code(), written, message)
    }
}

impl Drop for Program {
    fn drop(&mut self) {
        let _ = self.0.kill().and_then(|()| self.0.wait());
    }
}

/// The frames that donut has drawn, without the escape codes that clear the screen and move the cursor.
pub fn frames(written: &str) -> Vec<&str> {
    written.strip_prefix("\x1b[2J\x1b[H").expect("a cleared screen").split("\x1b[H").collect()
}
