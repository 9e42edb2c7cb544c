//! A program without a terminal. If it hangs, its test fails within a minute, and the program is killed.

use std::io::{Read, read_to_string};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc;
use std::thread;
use std::time::Duration;

/// More than any test reads. Without a limit, a program that never stops writing would fill the memory.
pub const MOST_BYTES: u64 = 20_000_000;

/// How long to wait for something that has to happen, even on a busy machine.
pub const MINUTE: Duration = Duration::from_secs(60);

/// Runs this in a thread. The test fails if it takes more than a minute, as it does if a program hangs.
pub fn within_a_minute<T: Send + 'static>(run: impl FnOnce() -> T + Send + 'static) -> T {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || sender.send(run()));
    let result = receiver.recv_timeout(MINUTE);
    result.expect("there is a panic above, or something hangs")
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
        let (stdout, stderr) = (self.0.stdout.take(), self.0.stderr.take().unwrap());
        let (written, message) = within_a_minute(move || {
            let written = stdout.map(|pipe| read_to_string(pipe.take(MOST_BYTES)).unwrap());
            (written.unwrap_or_default(), read_to_string(stderr).unwrap())
        });
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
