//! The donut on a pseudo-terminal: what is on the screen, and how the terminal is left.
//!
//! A pseudo-terminal is a terminal without a screen or a keyboard. `pty/mod.rs` makes them, and emulates
//! the screen that a person would see. Some tests run the donut in a shell there, with job control:
//! Ctrl-Z, `fg`, `bg` and `&`. A shell calls the processes of one command a job.
#![cfg(unix)]

mod pty;

use std::io::Write;
use std::process::Command;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::thread::{scope, sleep};
use std::time::{Duration, Instant};

use pty::Pty;
#[cfg(target_os = "linux")]
use rustix::process::{Resource, Rlimit, prlimit};
use rustix::process::{Signal, kill_process};

const DONUT: &str = env!("CARGO_BIN_EXE_donut");
/// A donut that stands still, so that every frame is the same picture.
const STILL: [&str; 3] = ["-A=1", "-B=0.5", "--spin=0,0"];
/// With this option, the second frame is due after 32 years.
const ONE_FRAME: &str = "--fps=1e-300";
/// The commands that end the updates and leave the terminal, as the terminal gets them.
const END_UPDATE: &str = "\x1b[?2026l";
const LEAVE: &str = "\x1b[1G\x1b[?25h\x1b[?1049h\x1b[2J\x1b[?1049l";

/// The signals that ask donut to end, and what a shell then calls its exit code.
const SIGNALS: [(Signal, u32); 4] =
    [(Signal::HUP, 129), (Signal::INT, 130), (Signal::QUIT, 131), (Signal::TERM, 143)];

fn run_donut(options: &[&str], size: (u16, u16)) -> Pty {
    Pty::run(DONUT, options, size, "xterm-256color")
}

/// The command line of a still donut.
fn still_command() -> String {
    format!("{DONUT} {}", STILL.join(" "))
}

/// Runs a still donut, and waits until it is on the screen.
#[track_caller]
fn run_still(size: (u16, u16)) -> Pty {
    let pty = run_donut(&STILL, size);
    wait_for_picture(&pty, size);
    pty
}

/// Whether the screen shows a donut without shading.
fn is_flat(pty: &Pty) -> bool {
    let cells = pty.lines().concat();
    cells.contains('.') && cells.chars().all(|cell| cell == '.' || cell == ' ')
}

/// Waits until the still donut fills a screen of this size.
#[track_caller]
fn wait_for_picture(pty: &Pty, size: (u16, u16)) {
    pty.wait_for("the picture", |pty| pty.lines() == picture(size));
}

/// The lines of a screen that the still donut fills.
fn picture((columns, rows): (u16, u16)) -> Vec<String> {
    last_picture(&STILL, (columns, rows.saturating_sub(2).max(1)), rows)
}

/// What a screen of this many rows shows after donut has exited. By default one frame is drawn.
fn last_picture(options: &[&str], (width, height): (u16, u16), rows: u16) -> Vec<String> {
    let size = [format!("--width={width}"), format!("--height={height}")];
    let mut command = Command::new(DONUT);
    let output =
        command.arg("--frames=1").args(options).args(size).arg("--fps=0").output().unwrap();
    let stream = String::from_utf8(output.stdout).unwrap();
    let frame = stream.rsplit("\x1b[H").next().unwrap();
    let mut lines: Vec<_> = frame.lines().map(|line| line.trim_end().to_string()).collect();
    lines.resize(rows.into(), String::new());
    lines
}

/// How many frames have been read so far.
fn frame_count(pty: &Pty) -> usize {
    pty.written().matches(END_UPDATE).count()
}

#[track_caller]
fn wait_for_first_frame(pty: &Pty) {
    pty.wait_for("the first frame", |pty| frame_count(pty) > 0);
}

/// Waits for this many more frames. Only of use while donut goes on drawing: where it draws a certain
/// number of frames, they may all be there already.
#[track_caller]
fn wait_for_more_frames(pty: &Pty, more: usize) {
    let now = frame_count(pty);
    pty.wait_for("more frames", |pty| frame_count(pty) >= now + more);
}

/// How often donut has entered the terminal so far: only then does it hide the cursor.
fn enter_count(pty: &Pty) -> usize {
    pty.written().matches("\x1b[?25l").count()
}

/// Presses q, and waits for donut to end.
#[track_caller]
fn assert_quits(pty: &Pty) {
    pty.type_bytes(b"q");
    assert_eq!(pty.wait_for_exit_and_output(), 0);
}

/// Whether this program is installed. If it is not, the test skips it, and this says so.
fn is_installed(program: &str) -> bool {
    let is_installed = Command::new(program).args(["-c", ":"]).output().is_ok();
    if !is_installed {
        println!("not tested with {program}, which is not installed");
    }
    is_installed
}

/// Whether the programs are installed that the tests of job control need: a shell, and one that tells the
/// states of processes.
fn has_job_control() -> bool {
    is_installed("bash") && is_installed("ps")
}

/// Whether this machine allows this command. If it does not, the test is skipped, and this says so.
#[cfg(target_os = "linux")]
fn is_allowed(command: &str) -> bool {
    let is_allowed = Command::new("sh").args(["-c", command]).status().unwrap().success();
    if !is_allowed {
        println!("not tested: this machine does not allow {command}");
    }
    is_allowed
}

/// The number that Linux has under this title in the status of the donut's process.
#[cfg(target_os = "linux")]
fn status(pty: &Pty, title: &str) -> u64 {
    let status =
        std::fs::read_to_string(format!("/proc/{}/status", pty.pid().as_raw_pid())).unwrap();
    status.split_once(title).unwrap().1.split_whitespace().next().unwrap().parse().unwrap()
}

// ---- The picture ---------------------------------------------------------------------------------

#[test]
fn the_picture_fits_the_screen_at_every_size() {
    for size in [(80, 24), (120, 40), (200, 50), (20, 6), (3, 4), (2, 3)] {
        let pty = run_still(size);
        wait_for_more_frames(&pty, 5);
        assert_eq!(pty.lines(), picture(size));
        assert_quits(&pty);
    }
    // Here there is no room for the donut.
    for size in [(80, 2), (80, 1)] {
        let pty = run_donut(&["--method=classic"], size);
        wait_for_more_frames(&pty, 2);
        assert_quits(&pty);
    }
}

#[test]
fn the_alternate_screen_is_cleared_once_and_has_no_cursor() {
    let pty = run_still((80, 24));
    wait_for_more_frames(&pty, 5);
    assert!(pty.screen(|screen| screen.alternate_screen() && screen.hide_cursor()));
    let cells = (0..24).flat_map(|row| (0..80).map(move |column| (row, column)));
    let plain = |screen: &vt100::Screen, (row, column)| {
        let cell = screen.cell(row, column).unwrap();
        cell.bgcolor() == vt100::Color::Default && cell.fgcolor() == vt100::Color::Default
    };
    assert!(pty.screen(|screen| cells.clone().all(|cell| plain(screen, cell))));
    assert_eq!(pty.written().matches("\x1b[2J").count(), 1);
}

#[test]
fn every_frame_is_a_synchronized_update_of_donut_cs_bytes() {
    let pty = run_donut(&[], (80, 24));
    wait_for_more_frames(&pty, 6);
    assert_quits(&pty);
    let written = pty.written();
    let (_, updates) = written.split_once("\x1b[?2026h").unwrap();
    let updates: Vec<_> = updates.split("\x1b[?2026h").collect();
    let (_, last) = updates.split_last().unwrap();
    let frames = last.iter().map(|update| update.strip_suffix(END_UPDATE).expect("an end"));
    // The terminal writes each newline as a carriage return and a newline.
    let frames = frames.collect::<String>().replace("\r\n", "\n");
    let options = [&format!("--frames={}", last.len()), "--fps=0"];
    let in_a_pipe = Command::new(DONUT).args(options).output().unwrap();
    assert_eq!(frames, String::from_utf8(in_a_pipe.stdout).unwrap());
}

#[test]
fn space_and_resizes_redraw_the_same_frame() {
    let pty = run_donut(&["-A=1", "-B=0.5", ONE_FRAME, "--frames=2"], (80, 24));
    let flat = |line: &String| line.replace(|cell| cell != ' ', ".");
    let flat_picture: Vec<_> = picture((80, 24)).iter().map(flat).collect();
    wait_for_picture(&pty, (80, 24));
    for n in 1..=3 {
        pty.type_bytes(b" ");
        pty.wait_for("dots", |pty| pty.lines() == flat_picture);
        pty.type_bytes(b" ");
        wait_for_picture(&pty, (80, 24));
        pty.resize((90, 30));
        wait_for_picture(&pty, (90, 30));
        pty.signal(Signal::CONT);
        pty.wait_for("entering again", |pty| enter_count(pty) == 1 + n);
        pty.resize((80, 24));
        wait_for_picture(&pty, (80, 24));
    }
    assert_quits(&pty);
    assert_eq!(enter_count(&pty), 4);
}

#[test]
fn a_storm_of_resizes_ends_with_the_picture_of_the_last_size() {
    let pty = run_still((80, 24));
    for size in
        [(1, 1), (0, 0), (1, 50), (50, 1), (1000, 500), (2, 2), (80, 24), (33, 11)].repeat(5)
    {
        pty.resize(size);
        sleep(Duration::from_millis(3));
    }
    for size in [(1, 1), (1, 24), (80, 1), (100, 30)] {
        pty.resize(size);
        wait_for_more_frames(&pty, 5);
    }
    wait_for_picture(&pty, (100, 30));
    assert!(pty.screen(|screen| (0..30).all(|row| !screen.row_wrapped(row))));
    assert_quits(&pty);
    pty.assert_restored();
}

#[test]
fn a_terminal_that_does_not_know_its_size_is_taken_for_80x24() {
    for size in [(0, 0), (80, 0), (0, 24)] {
        let pty = run_donut(&STILL, size);
        wait_for_first_frame(&pty);
        let written = pty.written();
        let frame = written.split("\x1b[H").nth(1).unwrap().split(END_UPDATE).next().unwrap();
        let rows: Vec<_> = frame.lines().map(str::len).collect();
        // A newline takes the place of the first of the 80 columns.
        assert_eq!((rows[0], &rows[1..]), (0, &[79; 22][..]), "{size:?}");
    }
}

#[test]
fn a_size_that_is_given_stays_and_is_clipped_to_the_screen() {
    let pty = run_donut(&[&STILL[..], &["--width=60", "--height=20"]].concat(), (80, 24));
    pty.wait_for("60x20", |pty| pty.lines() == last_picture(&STILL, (60, 20), 24));
    pty.scribble();
    pty.resize((120, 40));
    pty.wait_for("60x20 again", |pty| pty.lines() == last_picture(&STILL, (60, 20), 40));
    pty.resize((30, 10));
    wait_for_picture(&pty, (30, 10));
}

#[test]
fn with_frames_the_last_picture_stays_in_place() {
    let pty = run_donut(&[&STILL[..], &["--frames=5"]].concat(), (80, 24));
    assert_eq!(pty.wait_for_exit_and_output(), 0);
    assert!(!pty.written().contains("\x1b[?1049h"));
    assert_eq!(pty.lines(), picture((80, 24)));
    // The shell's prompt comes below the picture.
    assert_eq!(pty.screen(vt100::Screen::cursor_position), (23, 0));
    pty.assert_restored();
}

#[test]
fn with_frames_0_nothing_is_written() {
    let pty = run_donut(&["--frames=0"], (80, 24));
    assert_eq!(pty.wait_for_exit_and_output(), 0);
    assert_eq!(pty.written(), "");
}

#[test]
fn a_dumb_terminal_gets_an_error() {
    let pty = Pty::run(DONUT, &[], (80, 24), "dumb");
    assert_eq!(pty.wait_for_exit_and_output(), 1);
    assert!(pty.lines()[0].starts_with("donut: TERM is dumb"), "{:?}", pty.lines());
    assert!(!pty.written().contains('\x1b'));
    pty.assert_settings_restored();
}

// ---- Keys ----------------------------------------------------------------------------------------

#[test]
fn each_key_that_quits_restores_the_terminal() {
    // The last two are Ctrl-C and Ctrl-\. They send signals, which a shell reports as 130 and 131.
    for (key, code) in [(&b"q"[..], 0), (b"\x1b", 0), (b"\x03", 130), (b"\x1c", 131)] {
        for fps in ["--fps=30", ONE_FRAME, "--fps=0"] {
            let pty = run_donut(&[fps], (80, 24));
            wait_for_first_frame(&pty);
            pty.type_bytes(key);
            assert_eq!(pty.wait_for_exit_and_output(), code, "{key:?} {fps}");
            pty.assert_restored();
        }
    }
}

#[test]
fn p_pauses_and_resumes() {
    let pty = run_donut(&[], (80, 24));
    wait_for_first_frame(&pty);
    // The keys are obeyed in this order, so once a whole frame is without shading, donut has paused.
    pty.type_bytes(b"p ");
    pty.wait_for("dots", |pty| is_flat(pty) && pty.written().ends_with(END_UPDATE));
    let paused = frame_count(&pty);
    sleep(Duration::from_millis(300));
    assert_eq!(frame_count(&pty), paused);
    pty.resize((100, 30));
    pty.wait_for("the paused picture at the new size", |pty| frame_count(pty) > paused);
    pty.type_bytes(b"p");
    wait_for_more_frames(&pty, 5);
    pty.type_bytes(b"pq");
    assert_eq!(pty.wait_for_exit_and_output(), 0);
}

#[test]
fn other_keys_do_nothing_and_are_not_echoed() {
    let pty = run_still((80, 24));
    // Among them is Ctrl-S, which stops the output of a terminal in its usual settings.
    let keys = b"abcQP\r\n\t\x7f\x01\x13\x1b[A\x1bOP\x1b[5~\x1b[<0;10;10M\xff\xfe\xc3(";
    let mut bytes = keys.repeat(50);
    bytes.extend(b"\x1b[<35;40;12M".repeat(500));
    // So many that the q below cannot be taken for a part of the last code.
    bytes.extend(b"abcdefgh".repeat(1100));
    pty.type_bytes(&bytes);
    wait_for_more_frames(&pty, 10);
    assert_eq!(pty.lines(), picture((80, 24)));
    assert_quits(&pty);
}

/// Types a code in pieces. Returns false if the pieces came so far apart, because the machine is busy,
/// that the donut need not take them for one code.
fn type_in_pieces(pty: &Pty, pieces: &[&str]) -> bool {
    let start = Instant::now();
    for piece in pieces {
        pty.type_bytes(piece.as_bytes());
        sleep(Duration::from_millis(2));
    }
    start.elapsed() < Duration::from_millis(40)
}

#[test]
fn an_escape_code_does_nothing_whole_or_in_pieces() {
    // An arrow key, a key of the keypad, Alt and a letter, and a terminal's answer to a question.
    for code in ["\x1b[A", "\x1bOq", "\x1bq", "\x1bP>|a terminal q p\x1b\\"] {
        let (one, two) = (code.split_at(1), code.split_at(2));
        for pieces in [&[code][..], &[one.0, one.1], &[two.0, two.1], &[one.0, &code[1..2], two.1]]
        {
            let mut pty = run_still((80, 24));
            while !type_in_pieces(&pty, pieces) {
                pty = run_still((80, 24));
            }
            // Once the new size is there, the code has been read to its end.
            pty.resize((60, 20));
            wait_for_picture(&pty, (60, 20));
            wait_for_more_frames(&pty, 2);
            assert_quits(&pty);
        }
    }
}

#[test]
fn escape_quits_when_held_down_or_pressed_again() {
    for keys in [&b"\x1b\x1b"[..], b"\x1b\x1b\x1b\x1b", b"x\x1b"] {
        let pty = run_still((80, 24));
        pty.type_bytes(keys);
        assert_eq!(pty.wait_for_exit_and_output(), 0, "{keys:?}");
    }
    let pty = run_still((80, 24));
    // A key that is held down repeats about thirty times a second.
    for _ in 0..10 {
        pty.type_bytes(b"\x1b");
        sleep(Duration::from_millis(33));
    }
    assert_eq!(pty.wait_for_exit_and_output(), 0);
}

#[test]
fn keys_come_from_the_terminal_whatever_standard_input_is() {
    for command in [
        "DONUT < /dev/null",
        "yes | DONUT",
        "yes | head -1 | while read line; do DONUT; done",
        "echo --fps=20 | xargs DONUT",
    ] {
        let command = command.replace("DONUT", &still_command());
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        wait_for_picture(&pty, (80, 24));
        pty.type_bytes(b"abc\r\n");
        pty.resize((60, 20));
        wait_for_picture(&pty, (60, 20));
        assert_quits(&pty);
        pty.assert_restored();
    }
}

/// Only one of the two programs gets each key: the other program while it is waiting for one, otherwise the
/// donut. But Ctrl-C sends a signal to both.
#[test]
fn another_reader_of_the_keys_does_not_freeze_donut() {
    for (reader, key, code) in [
        ("cat", &b"\x03"[..], 130),
        ("while read line; do :; done", b"\x03", 130),
        // The q's are for both. After donut has ended, head needs whole lines.
        ("head -c 9", b"q\n", 0),
    ] {
        let command = format!("{reader} | {DONUT}");
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        wait_for_first_frame(&pty);
        for _ in 0..5 {
            pty.type_bytes(b"x");
            sleep(Duration::from_millis(30));
        }
        wait_for_more_frames(&pty, 10);
        pty.type_bytes(key);
        // One Ctrl-C is enough. Another one would make the terminal discard what donut writes as it ends.
        while code == 0 && pty.is_running() {
            pty.type_bytes(key);
            sleep(Duration::from_millis(30));
        }
        assert_eq!(pty.wait_for_exit_and_output(), code, "{reader}");
        pty.assert_restored();
    }
}

#[test]
fn a_q_typed_ahead_ends_the_donut_before_the_first_frame() {
    if !has_job_control() {
        return;
    }
    let pty = Pty::shell("bash", (80, 24));
    pty.type_bytes(format!("sleep 0.5; {DONUT}; echo $((6 * 7))\nq").as_bytes());
    pty.wait_for("the shell", |pty| pty.lines().contains(&"42".to_string()));
    let written = pty.written();
    assert!(written.find("\x1b[?1049h") < written.find("\x1b[?1049l"));
    assert_eq!(enter_count(&pty), 1);
    assert!(!written.contains("\x1b[?2026h"));
}

// ---- Other terminals -----------------------------------------------------------------------------

#[test]
fn donut_can_be_shown_on_another_terminal() {
    let shown = Pty::run("sleep", &["100"], (60, 20), "xterm");
    let command = format!("exec {} > {}", still_command(), shown.path());
    let pty = Pty::run("sh", &["-c", &command], (100, 30), "xterm");
    wait_for_picture(&shown, (60, 20));
    shown.type_bytes(b"xq");
    assert_eq!(pty.wait_for_exit(), 0);
    shown.wait_for_output();
    shown.assert_restored();
}

/// After `su` without -c, the terminal belongs to another user, but can still be opened as /dev/tty.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_of_another_user_is_drawn_on() {
    let is_root = Command::new("sh").args(["-c", "[ $(id -u) = 0 ]"]).status().unwrap().success();
    // root may open everything, unless it gives up this right.
    let prefix = if is_root { "setpriv --bounding-set=-all" } else { "env" };
    if !is_allowed(&format!("{prefix} true")) {
        return;
    }
    let command = format!("chmod 0 $(tty); exec {prefix} {}", still_command());
    let pty = Pty::run("sh", &["-c", &command], (60, 20), "xterm");
    wait_for_picture(&pty, (60, 20));
    pty.type_bytes(b"q");
    assert_eq!(pty.wait_for_exit(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_terminal_that_cannot_be_opened_is_treated_as_a_pipe() {
    let unshare = "unshare --user --map-root-user --mount";
    for (hidden, run) in [
        ("/dev/pts", format!("setsid -w {DONUT} --frames=1")),
        // A pipe is written to even in the background.
        ("/dev", format!("set -m; {DONUT} --frames=1 & wait")),
    ] {
        let hide = format!("mount -t tmpfs none {hidden}");
        if !is_allowed(&format!("{unshare} {hide}")) {
            return;
        }
        let command = format!("{unshare} sh -c '{hide} && {run}'; exit $?");
        let pty = Pty::run("sh", &["-c", &command], (100, 40), "xterm");
        assert_eq!(pty.wait_for_exit_and_output(), 0);
        assert_eq!(pty.lines(), last_picture(&[], (80, 22), 40));
        assert!(!pty.written().contains("\x1b[?"));
    }
}

#[test]
fn a_device_gets_the_picture_and_the_screen_does_not() {
    for device in ["/dev/null", "/dev/zero", "/dev/urandom"] {
        let command = format!("{DONUT} --frames=2 --fps=0 > {device}");
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        assert_eq!(pty.wait_for_exit_and_output(), 0, "{device}");
        assert_eq!(pty.written(), "", "{device}");
    }
}

#[test]
fn the_picture_is_upright_on_a_terminal_that_does_not_process_output() {
    let command = format!("stty -opost -onlcr; {}; stty -a", still_command());
    let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    wait_for_picture(&pty, (80, 24));
    pty.type_bytes(b"q");
    assert_eq!(pty.wait_for_exit_and_output(), 0);
    let lines = pty.lines().join(" ");
    assert!(lines.contains("-opost") && lines.contains("-onlcr"), "{lines}");
}

#[test]
fn ctrl_c_works_on_a_terminal_that_sends_no_signals() {
    let command = format!("stty -isig; exec {DONUT}");
    let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    wait_for_first_frame(&pty);
    pty.type_bytes(b"\x03");
    assert_eq!(pty.wait_for_exit_and_output(), 130);
}

#[test]
fn in_tmux_a_new_size_leaves_no_rows_in_the_shells_screen() {
    if !is_installed("tmux") {
        return;
    }
    let server = format!("donut-{}", std::process::id());
    let tmux = |arguments: &[&str]| {
        let start = ["-L", &server, "-f", "/dev/null"];
        let output = Command::new("tmux").args(start).args(arguments).output().unwrap();
        assert!(output.status.success(), "{arguments:?}: {output:?}");
        String::from_utf8(output.stdout).unwrap()
    };
    let becomes_true = |is_true: &dyn Fn() -> bool| {
        let start = Instant::now();
        while !is_true() {
            assert!(start.elapsed() < Duration::from_secs(60), "{}", tmux(&["capture-pane", "-p"]));
            sleep(Duration::from_millis(10));
        }
    };
    let shows = |text: &str| tmux(&["capture-pane", "-p"]).contains(text);
    let command = format!("echo before; {}; echo after; sleep 100", still_command());
    tmux(&["new-session", "-d", "-x", "80", "-y", "24", &command]);
    becomes_true(&|| shows("@"));
    tmux(&["resize-window", "-x", "120", "-y", "40"]);
    let longest = picture((120, 40)).into_iter().max_by_key(String::len).unwrap();
    becomes_true(&|| shows(&longest));
    tmux(&["send-keys", "q"]);
    becomes_true(&|| shows("after"));
    let screen = tmux(&["capture-pane", "-p"]);
    tmux(&["kill-server"]);
    assert_eq!(screen.split_whitespace().collect::<Vec<_>>(), ["before", "after"]);
}

// ---- Signals -------------------------------------------------------------------------------------

#[test]
fn a_signal_ends_donut_after_restoring_the_terminal() {
    for (signal, code) in SIGNALS {
        let pty = run_donut(&[ONE_FRAME], (80, 24));
        wait_for_first_frame(&pty);
        pty.signal(signal);
        assert_eq!(pty.wait_for_exit_and_output(), code, "{signal:?}");
        pty.assert_restored();
    }
}

#[test]
fn a_signal_ends_donut_however_early_it_comes() {
    for n in 0..100 {
        let pty = Pty::run(DONUT, &[], (80, 24), "xterm");
        sleep(Duration::from_micros(60 * n));
        // While the program registers its handlers, a signal may get lost.
        pty.wait_for("its end", |pty| {
            pty.is_running().then(|| kill_process(pty.pid(), Signal::TERM)).is_none()
        });
        assert_eq!(pty.wait_for_exit(), 143);
        pty.assert_settings_restored();
    }
}

#[test]
fn ctrl_c_ends_the_list_loop_or_script_around_donut() {
    if !has_job_control() {
        return;
    }
    for command in [
        "DONUT --frames 1000 && echo next; exit 7",
        "for i in 1 2 3; do DONUT; done; exit 7",
        "sh -c 'while :; do DONUT; done'; exit 7",
    ] {
        for shell in ["bash", "dash"].into_iter().filter(|shell| is_installed(shell)) {
            let pty = Pty::shell(shell, (80, 24));
            type_line(&pty, &command.replace("DONUT", DONUT));
            wait_for_first_frame(&pty);
            pty.type_bytes(b"\x03");
            pty.wait_for("its end", |pty| pty.job_pid().is_none());
            type_line(&pty, "exit 5");
            assert_eq!(pty.wait_for_exit_and_output(), 5, "{shell}: {command}");
            assert!(!pty.lines().contains(&"next".to_string()));
            pty.assert_settings_restored();
        }
    }
}

#[test]
fn donut_ends_when_the_terminal_goes_even_without_sighup() {
    // When the terminal goes, the first process of its session gets a SIGHUP. With this command, that is
    // the shell, which ignores the signal. So the donut gets none.
    let ignoring_sighup = |options: &str| format!("trap '' HUP; {DONUT} {options}; exit $?");
    for (command, key) in [
        (format!("exec {DONUT} --fps=5"), &b"x"[..]),
        (ignoring_sighup("--fps=5"), b"x"),
        (ignoring_sighup(&format!("{ONE_FRAME} < /dev/null")), b""),
        (ignoring_sighup(""), b"p"),
    ] {
        let mut pty = Pty::run_unread("sh", &["-c", &command], (80, 24), "xterm");
        pty.read_until(|pty| frame_count(pty) > 0);
        pty.type_bytes(key);
        sleep(Duration::from_millis(300));
        pty.hang_up();
        // After `exec`, the donut itself is the first process, and gets a SIGHUP. But it may notice
        // first that the terminal is gone.
        let code = pty.wait_for_exit();
        assert!(code == 1 || (code == 129 && command.starts_with("exec")), "{code}: {command}");
    }
}

/// A donut on a terminal that reads nothing, once it has written as much as the terminal holds.
fn stuck_donut(options: &[&str], size: (u16, u16)) -> Pty {
    let options = [options, &["--fps=0", "--color=red"]].concat();
    let pty = Pty::run_unread(DONUT, &options, size, "xterm");
    pty.wait_for("the start", Pty::has_changed_settings);
    pty.wait_until_full();
    pty
}

#[test]
fn a_signal_restores_a_stuck_terminal() {
    for size in [(80, 24), (1000, 500)] {
        let ptys = SIGNALS.map(|(signal, code)| (stuck_donut(&[], size), signal, code));
        for (pty, signal, _) in &ptys {
            match *signal {
                Signal::INT => pty.type_bytes(b"\x03"),
                signal => pty.signal(signal),
            }
        }
        for (pty, signal, code) in ptys {
            assert_eq!(pty.wait_for_exit(), code, "{signal:?} {size:?}");
            pty.start_reading(1 << 16, Duration::ZERO);
            pty.wait_for_output();
            assert!(pty.written().ends_with(LEAVE));
            pty.assert_restored();
        }
    }
}

/// Without a shell that could resume it, Ctrl-Z makes donut leave the terminal and enter it again.
#[test]
fn a_signal_restores_a_terminal_that_is_stuck_after_a_ctrl_z() {
    let pty = Pty::run_unread(DONUT, &["--fps=0"], (80, 24), "xterm");
    pty.read_until(|pty| frame_count(pty) > 0);
    pty.type_bytes(b"\x1a");
    pty.read_until(|pty| enter_count(pty) == 2);
    pty.wait_until_full();
    pty.signal(Signal::TERM);
    assert_eq!(pty.wait_for_exit(), 143);
    pty.start_reading(1 << 16, Duration::ZERO);
    pty.wait_for_output();
    pty.assert_restored();
}

#[test]
fn after_a_frame_cut_short_the_prompt_is_in_column_0() {
    let pty = stuck_donut(&["--frames=1000000"], (80, 24));
    pty.signal(Signal::TERM);
    assert_eq!(pty.wait_for_exit(), 143);
    pty.start_reading(1 << 16, Duration::ZERO);
    pty.wait_for_output();
    pty.assert_restored();
    assert_eq!(pty.screen(vt100::Screen::cursor_position).1, 0);
}

/// Linux lets one program at a time write to a terminal. Here another program is inside its write, and waits
/// for room on a full terminal, when the signal comes. It goes on to write until donut has ended. The
/// terminal is read slowly, or not at all.
#[test]
fn a_signal_restores_while_another_program_writes() {
    let is_over = AtomicBool::new(false);
    let cases = [1, 100, 4096, 65_536].into_iter().flat_map(|size| SIGNALS.map(|end| (size, end)));
    for (n, (size, (signal, code))) in cases.enumerate() {
        let pty = stuck_donut(&[], (80, 24));
        let mut terminal = pty.open();
        is_over.store(false, SeqCst);
        scope(|scope| {
            scope.spawn(|| {
                while !is_over.load(SeqCst) {
                    terminal.write_all(&vec![0; size]).unwrap();
                }
            });
            sleep(Duration::from_millis(20));
            let is_read = n % 2 == 0;
            if is_read {
                pty.start_reading(1000, Duration::from_millis(10));
            }
            pty.signal(signal);
            assert_eq!(pty.wait_for_exit(), code);
            is_over.store(true, SeqCst);
            if !is_read {
                pty.start_reading(1 << 16, Duration::ZERO);
            }
        });
        pty.wait_for_output();
        assert!(pty.written().contains(LEAVE), "{signal:?}, {size} bytes");
        pty.assert_restored();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_stuck_donut_seldom_wakes() {
    let pty = stuck_donut(&[], (80, 24));
    let wakes = || status(&pty, "\nvoluntary_ctxt_switches:");
    sleep(Duration::from_millis(200));
    let before = wakes();
    let start = Instant::now();
    sleep(Duration::from_millis(500));
    let most = 10 + start.elapsed().as_millis() / 20;
    assert!(u128::from(wakes() - before) < most, "{} wakes", wakes() - before);
}

#[test]
fn donut_goes_on_after_a_terminal_was_stuck() {
    let pty = Pty::run_unread(DONUT, &STILL, (200, 50), "xterm");
    pty.wait_until_full();
    pty.signal(Signal::CONT);
    pty.type_bytes(b"x");
    sleep(Duration::from_millis(100));
    pty.start_reading(1 << 16, Duration::ZERO);
    wait_for_picture(&pty, (200, 50));
    assert_quits(&pty);
    pty.assert_restored();
}

#[test]
fn keys_and_signals_are_obeyed_on_a_slow_terminal() {
    let ends: [fn(&Pty); 2] = [|pty| pty.type_bytes(b"q"), |pty| pty.signal(Signal::TERM)];
    for (end, code) in ends.into_iter().zip([0, 143]) {
        // The terminal reads 25 kB a second, and there are 53 kB of frames.
        let pty = Pty::run_unread(DONUT, &[], (80, 24), "xterm");
        pty.start_reading(1000, Duration::from_millis(40));
        wait_for_more_frames(&pty, 2);
        end(&pty);
        assert_eq!(pty.wait_for_exit_and_output(), code);
        pty.assert_restored();
    }
}

// ---- Job control ---------------------------------------------------------------------------------

fn type_line(pty: &Pty, line: &str) {
    pty.type_bytes(format!("{line}\n").as_bytes());
}

/// Runs a still donut in a shell, and waits until it is on the screen.
#[track_caller]
fn donut_in_a_shell(shell: &str) -> Pty {
    let pty = Pty::shell(shell, (80, 24));
    type_line(&pty, &still_command());
    wait_for_picture(&pty, (80, 24));
    pty
}

#[track_caller]
fn wait_for_the_shells_screen(pty: &Pty) {
    pty.wait_for("the shell's screen", |pty| {
        pty.screen(|screen| !screen.alternate_screen() && !screen.hide_cursor())
    });
}

/// Waits until the job is stopped and the shell has the screen that it had before.
#[track_caller]
fn wait_until_screen_given_back(pty: &Pty) {
    pty.wait_for("the stop", Pty::is_stopped);
    wait_for_the_shells_screen(pty);
}

/// Waits until the shell says that it has noticed a stop.
#[track_caller]
fn wait_until_shell_reports_stop(pty: &Pty) {
    pty.wait_for("the stop", Pty::is_stopped);
    pty.wait_for("the shell", |pty| pty.written().contains("Stopped"));
}

/// Waits for the end of the job, and asks the shell for its exit code.
#[track_caller]
fn assert_code(pty: &Pty, code: u32) {
    pty.wait_for("its end", |pty| pty.job_pid().is_none());
    type_line(pty, "echo code=$?");
    let said = format!("code={code}");
    // A prompt may stand before the answer.
    pty.wait_for(&said, |pty| pty.lines().iter().any(|line| line.ends_with(&said)));
}

#[test]
fn ctrl_z_gives_the_terminal_back_and_fg_redraws() {
    if !has_job_control() {
        return;
    }
    for shell in ["sh", "bash"] {
        let pty = donut_in_a_shell(shell);
        for _ in 0..2 {
            pty.type_bytes(b"\x1a");
            wait_until_screen_given_back(&pty);
            pty.resize((90, 30));
            type_line(&pty, "fg");
            wait_for_picture(&pty, (90, 30));
            assert!(pty.screen(|screen| screen.alternate_screen() && screen.hide_cursor()));
        }
        pty.type_bytes(b"q");
        assert_code(&pty, 0);
    }
}

/// If the donut were still on the alternate screen when the shell writes its prompt, the prompt would
/// vanish with that screen.
#[test]
fn after_ctrl_z_in_a_script_the_prompt_can_be_read() {
    if !has_job_control() {
        return;
    }
    for shell in ["bash", "dash"].into_iter().filter(|shell| is_installed(shell)) {
        for command in [
            format!("sh -c '{}; exit 5'", still_command()),
            format!("({}; exit 5)", still_command()),
        ] {
            let pty = Pty::shell(shell, (80, 24));
            type_line(&pty, &command);
            for _ in 0..2 {
                wait_for_picture(&pty, (80, 24));
                pty.type_bytes(b"\x1a");
                wait_until_screen_given_back(&pty);
                pty.wait_for("the shell", |pty| {
                    pty.lines().iter().any(|line| line.contains("Stopped"))
                });
                // bash changes the settings for its prompt, so there they cannot be compared.
                if shell == "dash" {
                    pty.assert_settings_restored();
                }
                type_line(&pty, "echo $((6 * 7)); fg");
            }
            wait_for_picture(&pty, (80, 24));
            pty.type_bytes(b"q");
            assert_code(&pty, 5);
            assert!(pty.lines().contains(&"42".to_string()), "{:?}", pty.lines());
        }
    }
}

#[test]
fn ctrl_z_stops_donut_once_whatever_is_typed_with_it() {
    if !has_job_control() {
        return;
    }
    for keys in [&b"\x1a\x1a"[..], b"\x1aq", b"pp\x1app"] {
        let pty = donut_in_a_shell("bash");
        pty.type_bytes(keys);
        wait_until_screen_given_back(&pty);
        type_line(&pty, "fg");
        wait_for_more_frames(&pty, 3);
        assert!(!pty.is_stopped(), "{keys:?}");
    }
}

/// This test stops the donut, types Ctrl-Z, sends SIGTERM and continues it, so the donut finds both at
/// once. It runs in a child shell, so that bash does not notice the stop.
///
/// The donut has two threads: the loop's, and one that ctrlc starts. If the signal goes to
/// that one, the loop may read the key first, and obey Ctrl-Z. So this test tries up to ten times, and
/// one success is enough: a loop that reads its keys before it looks for signals never succeeds.
#[test]
fn a_signal_that_comes_with_a_ctrl_z_ends_the_donut() {
    if !has_job_control() {
        return;
    }
    for _ in 0..10 {
        let pty = Pty::shell("bash", (80, 24));
        type_line(&pty, &format!("sh -c '{DONUT}; exit $?'"));
        wait_for_first_frame(&pty);
        let donut = pty.child_pid(pty.job_pid().unwrap()).unwrap();
        let signal_donut = |signal| kill_process(donut, signal).unwrap();
        signal_donut(Signal::STOP);
        pty.type_bytes(b"\x1a");
        signal_donut(Signal::TERM);
        sleep(Duration::from_millis(100));
        signal_donut(Signal::CONT);
        pty.wait_for("its end or stop", |pty| pty.job_pid().is_none() || pty.is_stopped());
        if pty.job_pid().is_none() {
            assert_code(&pty, 143);
            return;
        }
    }
    panic!("Ctrl-Z has stopped it each time");
}

#[test]
fn ctrl_z_does_nothing_where_no_shell_could_resume() {
    let command = format!("{DONUT}; exit $?");
    for (program, arguments) in [(DONUT, &[][..]), ("sh", &["-c", &command])] {
        let pty = Pty::run(program, arguments, (80, 24), "xterm");
        wait_for_first_frame(&pty);
        pty.type_bytes(b"\x1a");
        pty.wait_for("entering again", |pty| enter_count(pty) == 2);
        wait_for_more_frames(&pty, 2);
        assert_quits(&pty);
    }
}

/// Where the job in the foreground is outside of the program's pid namespace, the system cannot name it.
#[cfg(target_os = "linux")]
#[test]
fn ctrl_c_ends_donut_in_a_pid_namespace() {
    if !has_job_control() {
        return;
    }
    let unshare = "unshare --user --map-root-user --pid --fork";
    if !is_allowed(&format!("{unshare} true")) {
        return;
    }
    // In the first case, the donut is the first process of its namespace.
    for command in [DONUT.to_string(), format!("sh -c '{DONUT}; exit $?'")] {
        let pty = Pty::shell("bash", (80, 24));
        type_line(&pty, &format!("{unshare} {command}"));
        wait_for_more_frames(&pty, 5);
        pty.type_bytes(b"\x03");
        assert_code(&pty, 130);
    }
}

#[test]
fn a_stopped_donut_enters_the_terminal_again() {
    if !has_job_control() {
        return;
    }
    for (shell, signal, lines) in [
        ("bash", Signal::STOP, &["fg"][..]),
        ("bash", Signal::TSTP, &["bg", "fg"]),
        ("dash", Signal::STOP, &["fg"]),
    ] {
        if !is_installed(shell) {
            continue;
        }
        let pty = donut_in_a_shell(shell);
        pty.signal_job(signal);
        wait_until_shell_reports_stop(&pty);
        for &line in lines {
            type_line(&pty, line);
            if line == "bg" {
                wait_for_the_shells_screen(&pty);
            }
        }
        wait_for_picture(&pty, (80, 24));
        // The settings are the donut's again: the key is read without a newline, and not echoed.
        pty.type_bytes(b"q");
        assert_code(&pty, 0);
        assert!(!pty.lines().iter().any(|line| line.starts_with('q')), "{:?}", pty.lines());
        // Where a stopped job has changed the settings, dash leaves them as they are, so the donut has
        // to remember the ones from before.
        if shell == "dash" {
            pty.assert_settings_restored();
        }
    }
}

#[test]
fn what_was_on_the_shells_screen_during_a_stop_stays_there() {
    if !has_job_control() {
        return;
    }
    // No other frame is due, so the stop cannot come just before one, which would be drawn after it.
    let pty = Pty::shell("bash", (80, 24));
    type_line(&pty, &format!("{} {ONE_FRAME}", still_command()));
    wait_for_picture(&pty, (80, 24));
    pty.signal_job(Signal::STOP);
    wait_until_shell_reports_stop(&pty);
    // As a program does that has had the alternate screen in the meantime.
    type_line(&pty, r"printf '\033[?1049l\033[?25h\033[2J\033[Hkept\n'");
    wait_for_the_shells_screen(&pty);
    pty.wait_for("the text", |pty| pty.lines().contains(&"kept".to_string()));
    type_line(&pty, "fg");
    wait_for_picture(&pty, (80, 24));
    pty.type_bytes(b"q");
    assert_code(&pty, 0);
    assert!(pty.lines().contains(&"kept".to_string()), "{:?}", pty.lines());
}

/// Without room for a thread's stack, the system starts no threads.
#[cfg(target_os = "linux")]
#[test]
fn a_signal_restores_where_no_thread_can_be_started() {
    let pty = run_donut(&[], (80, 24));
    wait_for_first_frame(&pty);
    // Another MB is enough for what donut writes, but not for the stack, which has 2 MiB.
    let most = Some(1024 * (status(&pty, "VmSize:") + 1000));
    prlimit(Some(pty.pid()), Resource::As, Rlimit { current: most, maximum: most }).unwrap();
    pty.signal(Signal::TERM);
    assert_eq!(pty.wait_for_exit_and_output(), 143);
    pty.assert_restored();
}

#[test]
fn in_the_background_nothing_is_drawn() {
    if !has_job_control() {
        return;
    }
    let pty = Pty::shell("bash", (80, 24));
    type_line(&pty, &format!("{} &", still_command()));
    pty.wait_for("the job", |pty| pty.job_pid().is_some());
    sleep(Duration::from_millis(500));
    assert!(!pty.is_stopped());
    assert_eq!(frame_count(&pty), 0);
    assert!(!pty.written().contains("\x1b[?1049h"));
    type_line(&pty, "fg");
    wait_for_picture(&pty, (80, 24));
    pty.type_bytes(b"q");
    assert_code(&pty, 0);
}

#[test]
fn a_killed_background_donut_leaves_the_shells_screen() {
    if !has_job_control() {
        return;
    }
    type Step = fn(&Pty);
    let start: Step = |pty| {
        type_line(pty, &still_command());
        wait_for_picture(pty, (80, 24));
    };
    let start_in_background: Step = |pty| {
        type_line(pty, &format!("{DONUT} &"));
        if cfg!(target_os = "linux") {
            pty.wait_for("its handlers", Pty::has_sigterm_handler);
        } else {
            // The ps of macOS does not tell which signals are caught.
            sleep(Duration::from_secs(1));
        }
    };
    let ctrl_z: Step = |pty| {
        pty.type_bytes(b"\x1a");
        wait_until_screen_given_back(pty);
    };
    let stop: Step = |pty| {
        pty.signal_job(Signal::STOP);
        wait_until_shell_reports_stop(pty);
    };
    let bg: Step = |pty| {
        type_line(pty, "bg");
        pty.wait_for("the continuation", |pty| !pty.is_stopped());
        wait_for_the_shells_screen(pty);
        sleep(Duration::from_millis(200));
        assert!(!pty.is_stopped());
    };
    let kill: Step = |pty| type_line(pty, "kill %1");
    for steps in [
        &[start, ctrl_z, kill][..],
        &[start, ctrl_z, bg, kill],
        &[start, stop, kill],
        &[start, stop, bg, kill],
        &[start_in_background, kill],
    ] {
        let pty = Pty::shell("bash", (80, 24));
        steps.iter().for_each(|step| step(&pty));
        pty.wait_for("its end", |pty| pty.job_pid().is_none());
        // bash reports how a job has ended, at the latest when another job ends as well.
        type_line(&pty, "(:)");
        pty.wait_for("its signal", |pty| pty.written().contains("Terminated"));
        assert!(pty.screen(|screen| !screen.alternate_screen() && !screen.hide_cursor()));
    }
}

#[test]
fn a_signal_ends_a_background_donut_on_a_stuck_terminal() {
    if !has_job_control() {
        return;
    }
    let pty = Pty::run_unread("bash", &["--norc", "-i"], (80, 24), "xterm");
    type_line(&pty, &format!("{DONUT} --fps=0"));
    pty.wait_for("the job", |pty| pty.job_pid().is_some());
    pty.wait_until_full();
    pty.signal_job(Signal::STOP);
    pty.wait_for("the stop", |pty| pty.is_stopped() && !pty.has_job_in_foreground());
    pty.signal_job(Signal::CONT);
    sleep(Duration::from_millis(300));
    pty.signal_job(Signal::TERM);
    pty.wait_for("its end", |pty| pty.job_pid().is_none());
}

/// Without job control, a script runs the donut in the script's own job, and may end before it.
#[test]
fn after_a_script_that_ends_first_the_shell_has_its_screen() {
    if !has_job_control() {
        return;
    }
    let pty = Pty::shell("bash", (80, 24));
    type_line(&pty, &format!("sh -c '{DONUT} & exec sleep 100'"));
    wait_for_first_frame(&pty);
    pty.signal_job(Signal::TERM);
    wait_for_the_shells_screen(&pty);
    let now = frame_count(&pty);
    type_line(&pty, "echo $((6 * 7))");
    pty.wait_for("the shell", |pty| pty.lines().contains(&"42".to_string()));
    sleep(Duration::from_millis(200));
    assert_eq!(frame_count(&pty), now);
}

#[cfg(target_os = "linux")]
#[test]
fn timeout_ends_donut() {
    if !has_job_control() {
        return;
    }
    let pty = Pty::shell("bash", (80, 24));
    type_line(&pty, &format!("timeout 100 {DONUT}"));
    wait_for_first_frame(&pty);
    // This is how timeout learns that the time is over.
    pty.signal_job(Signal::ALARM);
    assert_code(&pty, 124);
    // timeout makes the donut a job of its own. Where there is no job control, nothing puts this job
    // into the foreground.
    let command = format!("timeout 0.5 {DONUT}; exit $?");
    let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    assert_eq!(pty.wait_for_exit_and_output(), 124);
    assert_eq!(pty.written(), "");
    pty.assert_settings_restored();
}

#[cfg(target_os = "linux")]
#[test]
fn donut_takes_little_processor_time() {
    if !has_job_control() {
        return;
    }
    for (command, draws) in
        [(format!("{DONUT} < /dev/null; true"), true), (format!("set -m; {DONUT} & wait"), false)]
    {
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        pty.wait_for("the start", |pty| frame_count(pty) > 0 || !draws && pty.job_pid().is_some());
        sleep(Duration::from_millis(500));
        let process = pty.job_pid().expect("a job");
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", process.as_raw_pid())).unwrap();
        // User and system time, in hundredths of a second.
        let ticks: u32 = stat.split(' ').skip(13).take(2).map(|n| n.parse::<u32>().unwrap()).sum();
        assert!(ticks < 10, "{ticks} ticks: {command}");
    }
}
