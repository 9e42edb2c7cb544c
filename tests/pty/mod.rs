//! A program on a pseudo-terminal, and the screen that a person would see.

use std::cell::RefCell;
use std::fs::{DirEntry, File, read_dir, read_to_string};
use std::io::{Read, Write};
use std::num::NonZeroU16;
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use portable_pty::{Child, CommandBuilder, MasterPty, PtySize, SlavePty, native_pty_system};
use rustix::fs::{self, Mode, OFlags};
use rustix::process::{Pid, Resource, Rlimit, Signal, kill_process, kill_process_group, setrlimit};
use rustix::termios;
use vt100::{Parser, Screen};

use super::program::{MINUTE, within_a_minute};

pub struct Pty {
    /// The side of the terminal that the person sees. `None` after the person has hung up.
    master: Option<Box<dyn MasterPty + Send>>,
    /// The side of the program. It is kept here, because a terminal that no program has open is closed.
    _slave: Box<dyn SlavePty + Send>,
    child: RefCell<Box<dyn Child + Send + Sync>>,
    keys: Option<Arc<Mutex<dyn Write + Send>>>,
    seen: Arc<Mutex<Seen>>,
    /// The terminal's settings before the program started.
    settings: String,
}

/// A terminal that, like Vim's, has room for one saved cursor: each `ESC[?1049h` overwrites it. And as in
/// xterm, both screens have the same scroll margins. vt100 has a saved cursor and margins for each
/// screen, and does not know code 1047, which switches screens without saving a cursor.
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
            } else if self.bytes.ends_with(b"\x1b[?1047h") {
                self.terminal.process(b"\x1b[?47h");
            } else if self.bytes.ends_with(b"\x1b[?1049l") {
                self.terminal.process(&self.margins);
                let (row, column) = self.saved_cursor;
                self.terminal.process(format!("\x1b[{};{}H", row + 1, column + 1).as_bytes());
            }
        }
    }
}

pub struct Job {
    pub pid: Pid,
    /// Whether all its threads are stopped.
    pub is_stopped: bool,
    /// The processor time so far, of the user and of the system, in hundredths of a second.
    pub ticks: [u32; 2],
}

/// A terminal's modes and special characters.
fn settings(terminal: &File) -> String {
    format!("{:?}", termios::tcgetattr(terminal).unwrap())
}

fn tty_name(master: &dyn MasterPty) -> String {
    master.tty_name().unwrap().to_str().unwrap().to_string()
}

fn open(path: &str, flags: OFlags) -> File {
    // Without NOCTTY, this could become the terminal that the tests themselves are run from.
    fs::open(path, flags | OFlags::RDWR | OFlags::NOCTTY, Mode::empty()).unwrap().into()
}

fn rows_and_columns((columns, rows): (u16, u16)) -> (NonZeroU16, NonZeroU16) {
    (rows.try_into().unwrap_or(NonZeroU16::MIN), columns.try_into().unwrap_or(NonZeroU16::MIN))
}

fn pty_size((cols, rows): (u16, u16)) -> PtySize {
    PtySize { rows, cols, ..PtySize::default() }
}

impl Pty {
    /// Runs a program on a terminal with this number of columns and of rows.
    pub fn run(program: &str, arguments: &[&str], size: (u16, u16)) -> Pty {
        let pty = Pty::run_unread(program, arguments, size);
        pty.start_reading(1 << 16, Duration::ZERO);
        pty
    }

    /// Begins to read what the program writes: `bytes` at a time, and then a pause.
    pub fn start_reading(&self, bytes: usize, pause: Duration) {
        let mut reader = self.master().try_clone_reader().unwrap();
        let seen = Arc::downgrade(&self.seen);
        thread::spawn(move || {
            while seen.upgrade().is_some_and(|seen| Pty::read_once(&seen, &mut reader, bytes) > 0) {
                thread::sleep(pause);
            }
        });
    }

    /// Writes to the terminal, as another program might, until the result is called or dropped.
    pub fn start_writing(&self, bytes: usize) -> impl FnOnce() + use<> {
        let (mut terminal, is_wanted) = (self.open(), Arc::new(()));
        let wanted = Arc::downgrade(&is_wanted);
        let writer = thread::spawn(move || {
            while wanted.strong_count() > 0 {
                terminal.write_all(&vec![0; bytes]).unwrap();
            }
        });
        move || {
            drop(is_wanted);
            writer.join().unwrap();
        }
    }

    /// Reads what the program writes until something comes true, and then no more.
    pub fn read_until(&self, is_true: impl Fn(&Pty) -> bool) {
        self.wait_for("what is read", |pty| {
            let (seen, mut reader) = (pty.seen.clone(), pty.master().try_clone_reader().unwrap());
            let read = move || Pty::read_once(&seen, &mut reader, 1000);
            is_true(pty) || {
                assert_ne!(within_a_minute(read), 0, "nobody can write any more");
                false
            }
        });
    }

    /// How many bytes have been read. 0 if nobody can write any more.
    fn read_once(seen: &Mutex<Seen>, reader: &mut dyn Read, bytes: usize) -> usize {
        let mut buffer = vec![0; bytes];
        let count = reader.read(&mut buffer).unwrap_or(0);
        seen.lock().unwrap().add(&buffer[..count]);
        count
    }

    /// Runs a program on a terminal that does not read its output, until `start_reading` is called.
    pub fn run_unread(program: &str, arguments: &[&str], size: (u16, u16)) -> Pty {
        let pair = native_pty_system().openpty(pty_size(size)).unwrap_or_else(|error| {
            panic!("this test needs a pseudo-terminal, and this machine gives it none: {error}")
        });
        let settings = settings(&open(&tty_name(&*pair.master), OFlags::empty()));
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
        let child = pair.slave.spawn_command(command).unwrap();
        let keys = pair.master.take_writer().unwrap();
        let (rows, columns) = rows_and_columns(size);
        let terminal = Parser::new(rows, columns, 1000);
        let seen = Seen { terminal, saved_cursor: (0, 0), margins: Vec::new(), bytes: Vec::new() };
        let seen = Arc::new(Mutex::new(seen));
        Pty {
            master: Some(pair.master),
            _slave: pair.slave,
            child: RefCell::new(child),
            keys: Some(Arc::new(Mutex::new(keys))),
            seen,
            settings,
        }
    }

    fn master(&self) -> &dyn MasterPty {
        self.master.as_deref().unwrap()
    }

    /// Types on the keyboard. This panics if the program reads no keys until the terminal takes no more.
    pub fn type_bytes(&self, bytes: &[u8]) {
        let (keys, bytes) = (self.keys.clone().unwrap(), bytes.to_vec());
        within_a_minute(move || keys.lock().unwrap().write_all(&bytes)).unwrap();
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
        Pid::from_raw(self.child.borrow().process_id().unwrap() as i32).unwrap()
    }

    /// Sends a signal to the program's process group.
    #[track_caller]
    pub fn signal(&self, signal: Signal) {
        kill_process_group(self.pid(), signal).unwrap();
    }

    /// The child of a process. `None` if it has ended.
    pub fn child_of(parent: Pid) -> Option<Job> {
        read_dir("/proc").unwrap().flatten().find_map(|process| {
            let stat = read_to_string(process.path().join("stat")).ok()?;
            // A number, a name in parentheses, the state, and more numbers: see `man 5 proc`.
            let (pid, rest) = stat.split_once(" (")?;
            let (_, rest) = rest.rsplit_once(") ")?;
            let fields: Vec<_> = rest.split(' ').collect();
            let is_child = fields[1] == parent.to_string() && fields[0] != "Z";
            // A thread that is not stopped yet might still wait for a key, see what is typed for the
            // shell, and read it in the background, which would stop the program once more.
            let is_stopped = |thread: DirEntry| {
                let stat = read_to_string(thread.path().join("stat"));
                stat.is_ok_and(|stat| stat.contains(") T "))
            };
            is_child.then(|| Job {
                pid: Pid::from_raw(pid.parse().unwrap()).unwrap(),
                is_stopped: read_dir(process.path().join("task"))
                    .is_ok_and(|mut threads| threads.all(|thread| thread.is_ok_and(is_stopped))),
                ticks: [fields[11], fields[12]].map(|ticks| ticks.parse().unwrap()),
            })
        })
    }

    /// The process that the program runs: for a shell, its job. `None` if it has ended.
    pub fn job(&self) -> Option<Job> {
        Pty::child_of(self.pid())
    }

    /// Whether the process that the program runs is stopped.
    pub fn is_stopped(&self) -> bool {
        self.job().is_some_and(|job| job.is_stopped)
    }

    /// Sends a signal to the process that the program runs, or to the program itself if it runs none.
    #[track_caller]
    pub fn signal_job(&self, signal: Signal) {
        kill_process(self.job().map_or(self.pid(), |job| job.pid), signal).unwrap();
    }

    pub fn path(&self) -> String {
        tty_name(self.master())
    }

    /// Opens the terminal as another program would.
    pub fn open(&self) -> File {
        open(&self.path(), OFlags::empty())
    }

    /// Waits until the program has written all that the terminal holds while nobody reads it.
    #[track_caller]
    pub fn wait_until_full(&self) {
        let terminal = open(&self.path(), OFlags::NONBLOCK);
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

    /// The lines that have scrolled up and off the screen, without the blanks at their ends.
    pub fn scrollback(&self) -> Vec<String> {
        let mut seen = self.seen.lock().unwrap();
        let screen = seen.terminal.screen_mut();
        let (_, columns) = screen.size();
        let lines = (1..=screen.scrollback_len()).rev().map(|distance| {
            screen.set_scrollback(distance);
            screen.rows(0, columns.get()).next().unwrap().trim_end().to_string()
        });
        let lines = lines.collect();
        screen.set_scrollback(0);
        lines
    }

    /// All that the program has written so far, escape codes included.
    pub fn written(&self) -> String {
        String::from_utf8(self.seen.lock().unwrap().bytes.clone()).unwrap()
    }

    /// Waits until something is true. `what` names it, in case the wait is in vain.
    #[track_caller]
    pub fn wait_for(&self, what: &str, is_true: impl Fn(&Pty) -> bool) {
        let start = Instant::now();
        while !is_true(self) {
            let is_late = start.elapsed() > MINUTE;
            assert!(!is_late, "{what} never came true:\n{}", self.lines().join("\n"));
            thread::sleep(Duration::from_millis(5));
        }
    }

    pub fn is_running(&self) -> bool {
        self.child.borrow_mut().try_wait().unwrap().is_none()
    }

    /// Waits for the program to end with what a shell would call this exit code, and until all that it has
    /// written is read. The terminal has to be as it was.
    #[track_caller]
    pub fn assert_ends(&self, code: u32) {
        assert_eq!(self.wait_for_exit(), code);
        self.wait_for_output();
        self.assert_restored();
    }

    /// Waits until all that has been written so far is read.
    #[track_caller]
    pub fn wait_for_output(&self) {
        // A terminal ignores this byte. What has been written before is read before it.
        const END: u8 = 6;
        let mut terminal = self.open();
        within_a_minute(move || terminal.write_all(&[END])).unwrap();
        self.wait_for("the end of the output", |pty| pty.seen.lock().unwrap().bytes.contains(&END));
        self.seen.lock().unwrap().bytes.retain(|&byte| byte != END);
    }

    /// Waits for the program to end. Returns what a shell would call its exit code.
    #[track_caller]
    pub fn wait_for_exit(&self) -> u32 {
        self.wait_for("the program's end", |pty| !pty.is_running());
        let status = self.child.borrow_mut().wait().unwrap();
        let signals = [("Hangup", 129), ("Interrupt", 130), ("Quit", 131), ("Terminated", 143)];
        status.signal().map_or(status.exit_code(), |name| {
            let signal = signals.iter().find(|signal| name.starts_with(signal.0));
            signal.unwrap_or_else(|| panic!("{name} ended it")).1
        })
    }

    /// Asserts that cursor, screen, colour, synchronized updates and settings are as they were at the start.
    #[track_caller]
    pub fn assert_restored(&self) {
        let (hidden, alternate) = self.screen(|s| (s.hide_cursor(), s.alternate_screen()));
        assert!(!hidden, "the cursor is hidden");
        assert!(!alternate, "the alternate screen is still there");
        assert_eq!(self.screen(Screen::fgcolor), vt100::Color::Default);
        let written = self.written();
        // Where there was no update, both are `None`.
        assert!(written.rfind("\x1b[?2026h") <= written.rfind("\x1b[?2026l"), "an update is open");
        self.assert_settings_restored();
    }

    #[track_caller]
    pub fn assert_settings_restored(&self) {
        assert_eq!(settings(&self.open()), self.settings);
    }

    pub fn has_changed_settings(&self) -> bool {
        settings(&self.open()) != self.settings
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
