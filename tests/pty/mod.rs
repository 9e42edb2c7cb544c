//! A program on a pseudo-terminal, and the screen that a person would see.

use std::cell::RefCell;
use std::fs::{File, read_dir, read_to_string};
use std::io::Write;
use std::num::NonZeroU16;
use std::os::unix::process::ExitStatusExt;
use std::path::PathBuf;
use std::process;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use portable_pty::{Child, CommandBuilder, MasterPty, PtySize, SlavePty, native_pty_system};
use rustix::fs::{self, Mode, OFlags};
use rustix::process::{Pid, Resource, Rlimit, Signal, kill_process, kill_process_group, setrlimit};
use vt100::{Parser, Screen};

use super::program::{LIMIT, in_time};

pub struct Pty {
    /// The side of the terminal that the person sees. `None` after the person has hung up.
    master: Option<Box<dyn MasterPty + Send>>,
    /// The side of the program. It is kept here, because a terminal that no program has open is closed.
    _slave: Box<dyn SlavePty + Send>,
    child: RefCell<Box<process::Child>>,
    keys: Option<Arc<Mutex<dyn Write + Send>>>,
    seen: Arc<Mutex<Seen>>,
    /// The terminal's settings before the program started.
    settings: String,
}

/// A terminal that, like Vim's, has room for one saved cursor: each `ESC[?1049h` overwrites it. And as in
/// xterm, both screens have the same scroll margins. vt100 has a saved cursor and margins for each screen.
struct Seen {
    terminal: Parser,
    saved_cursor: (u16, u16),
    /// The code that has set the scroll margins.
    margins: Vec<u8>,
    bytes: Vec<u8>,
}

impl Seen {
    fn add(&mut self, bytes: &[u8]) {
        assert!(self.bytes.len() < 50_000_000, "the program does not stop writing");
        // A code that ends in h or l is taken apart, to know the cursor before it takes effect. One that
        // ends in r may set the margins.
        for part in bytes.split_inclusive(|byte| b"hlr".contains(byte)) {
            let (last, start) = part.split_last().unwrap();
            self.terminal.process(start);
            let cursor = self.terminal.screen().cursor_position();
            self.terminal.process(&[*last]);
            self.bytes.extend_from_slice(part);
            if *last == b'r'
                && let Some(start) = self.bytes.iter().rposition(|&byte| byte == b'\x1b')
                && let [b'[', numbers @ .., _] = &self.bytes[start + 1..]
                && numbers.iter().all(|byte| b"0123456789;".contains(byte))
            {
                self.margins = self.bytes[start..].to_vec();
            } else if self.bytes.ends_with(b"\x1b[?1049h") {
                self.saved_cursor = cursor;
                self.terminal.process(&self.margins);
            } else if self.bytes.ends_with(b"\x1b[?1049l") {
                self.terminal.process(&self.margins);
                let (row, column) = self.saved_cursor;
                self.terminal.process(format!("\x1b[{};{}H", row + 1, column + 1).as_bytes());
            }
        }
    }
}

/// The size of the screen. A terminal that does not know its size has one all the same.
fn rows_and_columns((columns, rows): (u16, u16)) -> (NonZeroU16, NonZeroU16) {
    let (columns, rows) = if columns > 0 && rows > 0 { (columns, rows) } else { (80, 24) };
    (rows.try_into().unwrap(), columns.try_into().unwrap())
}

fn pty_size((cols, rows): (u16, u16)) -> PtySize {
    PtySize { rows, cols, ..PtySize::default() }
}

/// What the system says of a process, beginning with its state and its parent: see `man 5 proc`.
pub fn stat(pid: Pid) -> Option<Vec<String>> {
    let stat = read_to_string(format!("/proc/{pid}/stat")).ok()?;
    // A number and a name in parentheses come before.
    Some(stat.rsplit_once(") ")?.1.split(' ').map(String::from).collect())
}

impl Pty {
    /// Runs a program on a terminal with this number of columns and of rows.
    pub fn run(program: &str, arguments: &[&str], size: (u16, u16)) -> Pty {
        let pty = Pty::run_unread(program, arguments, size);
        pty.start_reading();
        pty
    }

    /// Begins to read what the program writes.
    pub fn start_reading(&self) {
        let mut reader = self.master().try_clone_reader().unwrap();
        let seen = Arc::downgrade(&self.seen);
        let mut buffer = vec![0; 1 << 16];
        thread::spawn(move || {
            // After the end, nobody can write any more.
            while let count @ 1.. = reader.read(&mut buffer).unwrap_or(0)
                && let Some(seen) = seen.upgrade()
            {
                seen.lock().unwrap().add(&buffer[..count]);
            }
        });
    }

    /// Runs a program on a terminal that does not read its output, until `start_reading` is called.
    pub fn run_unread(program: &str, arguments: &[&str], size: (u16, u16)) -> Pty {
        let pair = native_pty_system().openpty(pty_size(size)).unwrap_or_else(|error| {
            panic!("this test needs a pseudo-terminal, and this machine gives it none: {error}")
        });
        let mut command = CommandBuilder::new(program);
        command.args(arguments);
        // By default, this would be the home folder, which a build machine may lack.
        command.cwd("/");
        // SIGQUIT must not leave a core file there.
        let _ = setrlimit(Resource::Core, Rlimit { current: Some(0), maximum: Some(0) });
        // The shells have to speak English, and must not write to anybody's history.
        for (name, value) in [("TERM", "xterm"), ("LC_ALL", "C"), ("HISTFILE", "")] {
            command.env(name, value);
        }
        let settings = format!("{:?}", pair.master.get_termios());
        let child: Box<dyn Child> = pair.slave.spawn_command(command).unwrap();
        let keys = pair.master.take_writer().unwrap();
        let (rows, columns) = rows_and_columns(size);
        let terminal = Parser::new(rows, columns, 1000);
        let seen = Seen { terminal, saved_cursor: (0, 0), margins: Vec::new(), bytes: Vec::new() };
        let seen = Arc::new(Mutex::new(seen));
        Pty {
            master: Some(pair.master),
            _slave: pair.slave,
            child: RefCell::new(child.downcast().unwrap()),
            keys: Some(Arc::new(Mutex::new(keys))),
            seen,
            settings,
        }
    }

    fn master(&self) -> &dyn MasterPty {
        self.master.as_deref().unwrap()
    }

    /// Types on the keyboard. Fails if the program reads no keys until the terminal takes no more.
    pub fn type_bytes(&self, bytes: &[u8]) {
        let (keys, bytes) = (self.keys.clone().unwrap(), bytes.to_vec());
        in_time(move || keys.lock().unwrap().write_all(&bytes)).unwrap();
    }

    pub fn resize(&self, size: (u16, u16)) {
        self.resize_window(size, (0, 0));
    }

    /// Changes the size of the terminal, and that of its window in pixels.
    pub fn resize_window(&self, size: (u16, u16), (pixel_width, pixel_height): (u16, u16)) {
        let mut seen = self.seen.lock().unwrap();
        let (rows, columns) = rows_and_columns(size);
        seen.terminal.screen_mut().set_size(rows, columns);
        self.master().resize(PtySize { pixel_width, pixel_height, ..pty_size(size) }).unwrap();
    }

    /// Closes the terminal, as when its window is closed. `start_reading` would keep it open.
    pub fn hang_up(&mut self) {
        self.keys = None;
        self.master = None;
    }

    pub fn pid(&self) -> Pid {
        Pid::from_child(&self.child.borrow())
    }

    /// Sends a signal to the program's process group.
    #[track_caller]
    pub fn signal(&self, signal: Signal) {
        kill_process_group(self.pid(), signal).unwrap();
    }

    /// The process that the program runs: for a shell, its job. `None` if it has ended.
    pub fn job(&self) -> Option<Pid> {
        read_dir("/proc").unwrap().flatten().find_map(|process| {
            let pid = Pid::from_raw(process.file_name().to_str()?.parse().ok()?)?;
            let [state, parent, ..] = &stat(pid)?[..] else { return None };
            (state != "Z" && *parent == self.pid().to_string()).then_some(pid)
        })
    }

    /// Whether the process that the program runs is stopped.
    pub fn is_stopped(&self) -> bool {
        self.job().and_then(stat).is_some_and(|stat| stat[0] == "T")
    }

    /// Sends a signal to the process that the program runs.
    #[track_caller]
    pub fn signal_job(&self, signal: Signal) {
        kill_process(self.job().unwrap(), signal).unwrap();
    }

    /// The path of the terminal, such as `/dev/pts/7`.
    pub fn path(&self) -> PathBuf {
        self.master().tty_name().unwrap()
    }

    /// Opens the terminal as another program would. A write there fails instead of waiting.
    pub fn open(&self) -> File {
        // Without NOCTTY, this could become the terminal that the tests themselves are run from.
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK;
        fs::open(self.path(), flags, Mode::empty()).unwrap().into()
    }

    /// Waits until the program has written all that the terminal holds while nobody reads it.
    #[track_caller]
    pub fn wait_until_full(&self) {
        let terminal = self.open();
        // A terminal that is full takes no more NULs, which do not show, either. Nor does one take any
        // while another program is inside its write, so it is tried several times.
        self.wait_for("a full terminal", |_| {
            (0..10).all(|_| {
                thread::sleep(Duration::from_millis(1));
                (&terminal).write(&[0; 64]).is_err()
            })
        });
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

    /// All that the program has written so far, escape codes included.
    pub fn written(&self) -> String {
        String::from_utf8(self.seen.lock().unwrap().bytes.clone()).unwrap()
    }

    /// Waits until something is true, for at most half a minute. `what` names it if it never is.
    #[track_caller]
    pub fn wait_for(&self, what: &str, is_true: impl Fn(&Pty) -> bool) {
        let start = Instant::now();
        while !is_true(self) {
            let is_late = start.elapsed() > LIMIT;
            assert!(!is_late, "{what} never came true:\n{}", self.lines().join("\n"));
            thread::sleep(Duration::from_millis(5));
        }
    }

    pub fn is_running(&self) -> bool {
        self.child.borrow_mut().try_wait().unwrap().is_none()
    }

    /// Waits for the program to end (see `wait_for_exit`), and until all that it has written is read. Cursor,
    /// screen, colour, synchronized updates and settings have to be as they were at the start.
    #[track_caller]
    pub fn assert_ends(&self, code: i32) {
        assert_eq!(self.wait_for_exit(), code);
        self.wait_for_output();
        assert!(self.is_shells_screen(), "the cursor is hidden, or the alternate screen is there");
        assert_eq!(self.screen(Screen::fgcolor), vt100::Color::Default);
        let written = self.written();
        // Where there was no update, both are `None`.
        assert!(written.rfind("\x1b[?2026h") <= written.rfind("\x1b[?2026l"), "an update is open");
        assert!(!self.has_changed_settings());
    }

    /// Waits until all that has been written so far is read.
    #[track_caller]
    fn wait_for_output(&self) {
        // A terminal ignores this byte. What has been written before is read before it.
        const END: u8 = 6;
        self.wait_for("room for a byte", |pty| pty.open().write(&[END]).is_ok());
        self.wait_for("the end of the output", |pty| pty.seen.lock().unwrap().bytes.contains(&END));
        self.seen.lock().unwrap().bytes.retain(|&byte| byte != END);
    }

    /// Waits for the program to end. Returns its exit code, or -2 if signal 2 has ended it, and so on. (A shell
    /// would say 130, whether the signal or `exit(130)` has.)
    #[track_caller]
    pub fn wait_for_exit(&self) -> i32 {
        self.wait_for("the program's end", |pty| !pty.is_running());
        let status = self.child.borrow_mut().wait().unwrap();
        status.code().unwrap_or_else(|| -status.signal().unwrap())
    }

    /// Whether the screen is the shell's, with the cursor.
    pub fn is_shells_screen(&self) -> bool {
        self.screen(|screen| !screen.alternate_screen() && !screen.hide_cursor())
    }

    /// Whether the terminal's modes and special characters are not what they were before the program started.
    pub fn has_changed_settings(&self) -> bool {
        format!("{:?}", self.master().get_termios()) != self.settings
    }
}

impl Drop for Pty {
    fn drop(&mut self) {
        if self.is_running() {
            let _ = kill_process_group(self.pid(), Signal::KILL);
            let _ = self.child.get_mut().wait();
        }
    }
}
