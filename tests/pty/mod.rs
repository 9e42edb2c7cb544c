//! A program on a pseudo-terminal, and the screen that a person would see.

use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use portable_pty::{Child, CommandBuilder, MasterPty, PtySize, SlavePty, native_pty_system};
use vt100::{Parser, Screen};

pub struct Pty {
    /// Gone once it is hung up.
    master: Option<Box<dyn MasterPty + Send>>,
    /// Kept, or the terminal would be closed with the program.
    _slave: Box<dyn SlavePty + Send>,
    child: Box<dyn Child + Send + Sync>,
    keys: Option<Box<dyn Write + Send>>,
    seen: Arc<Mutex<Seen>>,
    /// The terminal's settings before the program came, as text.
    settings: String,
}

struct Seen {
    terminal: Parser,
    bytes: Vec<u8>,
}

fn rows_and_columns((columns, rows): (u16, u16)) -> (NonZeroU16, NonZeroU16) {
    (rows.try_into().unwrap_or(NonZeroU16::MIN), columns.try_into().unwrap_or(NonZeroU16::MIN))
}

fn pty_size((cols, rows): (u16, u16)) -> PtySize {
    PtySize { rows, cols, ..PtySize::default() }
}

impl Pty {
    /// Runs a program on a terminal of so many columns and rows.
    pub fn run(program: &str, arguments: &[&str], size: (u16, u16), term: &str) -> Pty {
        let pty = Pty::run_unread(program, arguments, size, term);
        let (seen, mut reader) = (pty.seen.clone(), pty.master().try_clone_reader().unwrap());
        thread::spawn(move || {
            let mut buffer = [0; 65536];
            while let Ok(1..) = reader.read(&mut buffer).inspect(|&count| {
                let mut seen = seen.lock().unwrap();
                seen.terminal.process(&buffer[..count]);
                seen.bytes.extend_from_slice(&buffer[..count]);
            }) {}
        });
        pty
    }

    /// The same on a terminal that never reads what the program writes.
    pub fn run_unread(program: &str, arguments: &[&str], size: (u16, u16), term: &str) -> Pty {
        let pair = native_pty_system().openpty(pty_size(size)).unwrap();
        let settings = format!("{:?}", pair.master.get_termios().unwrap());
        let mut command = CommandBuilder::new(program);
        command.args(arguments);
        command.env("TERM", term);
        let child = pair.slave.spawn_command(command).unwrap();
        let keys = pair.master.take_writer().unwrap();
        let (rows, columns) = rows_and_columns(size);
        let terminal = Parser::new(rows, columns, 1000);
        let seen = Arc::new(Mutex::new(Seen { terminal, bytes: Vec::new() }));
        Pty {
            master: Some(pair.master),
            _slave: pair.slave,
            child,
            keys: Some(keys),
            seen,
            settings,
        }
    }

    fn master(&self) -> &dyn MasterPty {
        self.master.as_deref().unwrap()
    }

    pub fn type_bytes(&mut self, bytes: &[u8]) {
        let keys = self.keys.as_mut().unwrap();
        keys.write_all(bytes).unwrap();
        keys.flush().unwrap();
    }

    pub fn resize(&self, size: (u16, u16)) {
        let mut seen = self.seen.lock().unwrap();
        let (rows, columns) = rows_and_columns(size);
        seen.terminal.screen_mut().set_size(rows, columns);
        self.master().resize(pty_size(size)).unwrap();
    }

    /// Leaves something on the screen, as a terminal may that rearranges it for a new size.
    pub fn scribble(&self) {
        self.seen.lock().unwrap().terminal.process(b"\x1b[2;1Hscribble\x1b[22;1Hscribble");
    }

    /// Closes the terminal, as when its window goes.
    pub fn hang_up(&mut self) {
        self.keys = None;
        self.master = None;
    }

    /// Sends a signal to the program and to all that it runs.
    pub fn signal(&self, name: &str) {
        let group = format!("-{}", self.child.process_id().unwrap());
        let mut kill = Command::new("kill");
        assert!(kill.args(["-s", name, "--", &group]).status().unwrap().success());
    }

    pub fn is_stopped(&self) -> bool {
        let process = self.child.process_id().unwrap().to_string();
        let state = Command::new("ps").args(["-o", "state=", "-p", &process]).output().unwrap();
        state.stdout.starts_with(b"T")
    }

    /// What `look` finds on the screen.
    pub fn screen<T>(&self, look: impl Fn(&Screen) -> T) -> T {
        look(self.seen.lock().unwrap().terminal.screen())
    }

    /// The lines of the screen, without the blanks at their ends.
    pub fn lines(&self) -> Vec<String> {
        self.screen(|screen| {
            let (_, columns) = screen.size();
            screen.rows(0, columns.get()).map(|line| line.trim_end().to_string()).collect()
        })
    }

    /// All that was written so far.
    pub fn written(&self) -> String {
        String::from_utf8(self.seen.lock().unwrap().bytes.clone()).unwrap()
    }

    /// Waits up to ten seconds for something to come true.
    #[track_caller]
    pub fn wait_for(&self, what: &str, is_true: impl Fn(&Pty) -> bool) {
        let start = Instant::now();
        while !is_true(self) {
            let lines = self.lines().join("\n");
            assert!(start.elapsed() < Duration::from_secs(10), "{what} never came true:\n{lines}");
            thread::sleep(Duration::from_millis(5));
        }
    }

    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Waits up to five seconds for the program to end, and says how it did.
    #[track_caller]
    pub fn exit(&mut self) -> u32 {
        let start = Instant::now();
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                // What it wrote last is still on its way.
                thread::sleep(Duration::from_millis(100));
                return status.exit_code();
            }
            if start.elapsed() > Duration::from_secs(5) {
                self.child.kill().unwrap();
                panic!("it goes on");
            }
            thread::sleep(Duration::from_millis(5));
        }
    }

    /// Cursor, screen, synchronized updates and settings are as they were before the program came.
    #[track_caller]
    pub fn assert_restored(&self) {
        let (hidden, alternate) = self.screen(|s| (s.hide_cursor(), s.alternate_screen()));
        assert!(!hidden, "the cursor is hidden");
        assert!(!alternate, "the alternate screen is still there");
        let written = self.written();
        assert!(written.rfind("\x1b[?2026h") < written.rfind("\x1b[?2026l"), "an update is open");
        assert_eq!(format!("{:?}", self.master().get_termios().unwrap()), self.settings);
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}
