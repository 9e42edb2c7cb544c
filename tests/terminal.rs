//! The donut on a pseudo-terminal: what is on the screen, and how the terminal is left.
//!
//! A pseudo-terminal is a terminal without a screen or a keyboard. `pty/mod.rs` makes them, and keeps
//! the screen that a person would see. Some tests run the donut in a shell there, with job control:
//! Ctrl-Z, `fg`, `bg` and `&`. A shell calls the processes of one command a job.
#![cfg(unix)]

mod pty;

use std::io::Write;
use std::process::Command;
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use pty::Pty;
use rustix::process::{Pid, Signal, kill_process};

const DONUT: &str = env!("CARGO_BIN_EXE_donut");
/// A donut that stands still, so that every frame is the same picture.
const STILL: [&str; 3] = ["-A=1", "-B=0.5", "--spin=0,0"];
/// The commands that end the updates and leave the terminal, as the terminal gets them.
const END_UPDATE: &str = "\x1b[?2026l";
const LEAVE: &str = "\x1b[1G\x1b[?25h\x1b[?1049l";

fn donut(options: &[&str], size: (u16, u16)) -> Pty {
    Pty::run(DONUT, options, size, "xterm-256color")
}

/// The command line of a still donut.
fn still() -> String {
    format!("{DONUT} {}", STILL.join(" "))
}

/// Runs a still donut, and waits until it is on the screen.
#[track_caller]
fn still_donut(size: (u16, u16)) -> Pty {
    let pty = donut(&STILL, size);
    wait_for_picture(&pty, size);
    pty
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

/// What a screen of this many rows shows when the donut has ended. It draws one frame, unless the options
/// set another --frames.
fn last_picture(options: &[&str], (width, height): (u16, u16), rows: u16) -> Vec<String> {
    let size = [format!("--width={width}"), format!("--height={height}")];
    let mut donut = Command::new(DONUT);
    let output = donut.arg("--frames=1").args(options).args(size).arg("--fps=0").output().unwrap();
    let stream = String::from_utf8(output.stdout).unwrap();
    let frame = stream.rsplit("\x1b[H").next().unwrap();
    let mut lines: Vec<_> = frame.lines().map(|line| line.trim_end().to_string()).collect();
    lines.resize(rows.into(), String::new());
    lines
}

/// How many frames have been written so far.
fn frames(pty: &Pty) -> usize {
    pty.written().matches(END_UPDATE).count()
}

/// Waits until this many more frames have been written.
#[track_caller]
fn wait_for_frames(pty: &Pty, more: usize) {
    let now = frames(pty);
    pty.wait_for("more frames", |pty| frames(pty) >= now + more);
}

/// Presses q, and waits for the donut to end.
#[track_caller]
fn assert_quits(pty: &mut Pty) {
    pty.type_bytes(b"q");
    assert_eq!(pty.wait_for_exit(), 0);
}

/// Whether this shell is installed. If it is not, the test skips it, and this says so.
fn is_installed(shell: &str) -> bool {
    let is_installed = Command::new(shell).args(["-c", ":"]).status().is_ok();
    if !is_installed {
        println!("not tested with {shell}, which is not installed");
    }
    is_installed
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

// ---- The picture ---------------------------------------------------------------------------------

#[test]
fn the_picture_fits_the_screen_at_every_size() {
    for size in [(80, 24), (120, 40), (200, 50), (20, 6), (3, 4), (2, 3)] {
        let mut pty = still_donut(size);
        wait_for_frames(&pty, 5);
        assert_eq!(pty.lines(), picture(size));
        assert_quits(&mut pty);
    }
    // Here there is no room for the donut.
    for size in [(80, 2), (80, 1)] {
        let mut pty = donut(&["--method=classic"], size);
        wait_for_frames(&pty, 2);
        assert_quits(&mut pty);
    }
}

#[test]
fn the_donut_has_the_alternate_screen_no_cursor_no_background_and_clears_once() {
    let pty = still_donut((80, 24));
    wait_for_frames(&pty, 5);
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
    let mut pty = donut(&[], (80, 24));
    wait_for_frames(&pty, 6);
    assert_quits(&mut pty);
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
fn drawing_again_neither_turns_the_donut_nor_counts_as_a_frame() {
    // The second frame is due after a hundred seconds, so the donut has to stand still.
    let mut pty = donut(&["-A=1", "-B=0.5", "--fps=0.01"], (80, 24));
    wait_for_picture(&pty, (80, 24));
    for _ in 0..3 {
        let now = frames(&pty);
        pty.type_bytes(b" ");
        pty.wait_for("dots", |pty| frames(pty) > now);
        pty.type_bytes(b" ");
        wait_for_picture(&pty, (80, 24));
        pty.resize((90, 30));
        wait_for_picture(&pty, (90, 30));
        pty.signal("CONT");
        pty.resize((80, 24));
        wait_for_picture(&pty, (80, 24));
    }
    // The donut has entered the terminal at the start, and after each SIGCONT.
    assert_eq!(pty.written().matches("\x1b[?1049h").count(), 4);
    assert_quits(&mut pty);

    let options = ["--frames=3", "--fps=1"];
    let mut pty = donut(&options, (80, 24));
    for _ in 0..4 {
        let now = frames(&pty);
        pty.type_bytes(b"  ");
        pty.wait_for("a frame", |pty| frames(pty) > now);
    }
    assert_eq!(pty.wait_for_exit(), 0);
    assert_eq!(pty.lines(), last_picture(&options, (80, 22), 24));
}

#[test]
fn a_storm_of_resizes_ends_with_the_picture_of_the_last_size() {
    let mut pty = still_donut((80, 24));
    for size in
        [(1, 1), (0, 0), (1, 50), (50, 1), (1000, 500), (2, 2), (80, 24), (33, 11)].repeat(5)
    {
        pty.resize(size);
        sleep(Duration::from_millis(3));
    }
    for size in [(1, 1), (1, 24), (80, 1), (100, 30)] {
        pty.resize(size);
        wait_for_frames(&pty, 5);
    }
    wait_for_picture(&pty, (100, 30));
    assert!(pty.screen(|screen| (0..30).all(|row| !screen.row_wrapped(row))));
    assert_quits(&mut pty);
    pty.assert_restored();
}

#[test]
fn a_terminal_that_does_not_know_its_size_is_taken_for_80x24() {
    for size in [(0, 0), (80, 0), (0, 24)] {
        let pty = donut(&STILL, size);
        wait_for_frames(&pty, 1);
        let written = pty.written();
        let frame = written.split("\x1b[H").nth(1).unwrap().split(END_UPDATE).next().unwrap();
        let rows: Vec<_> = frame.lines().map(str::len).collect();
        // A newline takes the place of the first of the 80 columns.
        assert_eq!((rows[0], &rows[1..]), (0, &[79; 22][..]), "{size:?}");
    }
}

#[test]
fn a_size_that_is_given_stays_and_is_clipped_to_the_screen() {
    let pty = donut(&[&STILL[..], &["--width=60", "--height=20"]].concat(), (80, 24));
    pty.wait_for("60x20", |pty| pty.lines() == last_picture(&STILL, (60, 20), 24));
    pty.scribble();
    pty.resize((120, 40));
    pty.wait_for("60x20 again", |pty| pty.lines() == last_picture(&STILL, (60, 20), 40));
    pty.resize((30, 10));
    wait_for_picture(&pty, (30, 10));
}

#[test]
fn a_colour_is_one_sequence_a_frame_whatever_the_variable_no_color_says() {
    for (color, expected) in [
        ("red", vt100::Color::Idx(9)),
        ("208", vt100::Color::Idx(208)),
        ("#123456", vt100::Color::Rgb(0x12, 0x34, 0x56)),
    ] {
        let command = format!("NO_COLOR=1 exec {} --color '{color}'", still());
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        wait_for_picture(&pty, (80, 24));
        assert_eq!(pty.screen(|screen| screen.cell(12, 30).unwrap().fgcolor()), expected);
        wait_for_frames(&pty, 5);
        let written = pty.written();
        let last = written.rsplit("\x1b[?2026h").nth(1).unwrap();
        // The top left, the colour, the end of the colour, and the end of the update.
        assert_eq!(last.matches("\x1b[").count(), 4, "{last:?}");
    }
}

#[test]
fn with_frames_the_donut_is_drawn_in_place_and_the_last_picture_stays() {
    let mut pty = donut(&[&STILL[..], &["--frames=5"]].concat(), (80, 24));
    assert_eq!(pty.wait_for_exit(), 0);
    assert!(!pty.written().contains("\x1b[?1049h"));
    assert_eq!(pty.lines(), picture((80, 24)));
    // The shell's prompt comes below the picture.
    assert_eq!(pty.screen(vt100::Screen::cursor_position), (23, 0));
    pty.assert_restored();
}

#[test]
fn with_frames_0_nothing_is_written() {
    let mut pty = donut(&["--frames=0"], (80, 24));
    assert_eq!(pty.wait_for_exit(), 0);
    assert_eq!(pty.written(), "");
}

#[test]
fn a_dumb_terminal_gets_an_error() {
    let mut pty = Pty::run(DONUT, &[], (80, 24), "dumb");
    assert_eq!(pty.wait_for_exit(), 1);
    assert!(pty.lines()[0].starts_with("donut: TERM is dumb"), "{:?}", pty.lines());
    assert!(!pty.written().contains('\x1b'));
    pty.assert_settings_restored();
}

// ---- Keys ----------------------------------------------------------------------------------------

#[test]
fn q_escape_ctrl_c_and_ctrl_backslash_end_the_donut_and_restore_the_terminal() {
    // The last two are Ctrl-C and Ctrl-\. They send signals, which a shell reports as 130 and 131.
    for (key, code) in [(&b"q"[..], 0), (b"\x1b", 0), (b"\x03", 130), (b"\x1c", 131)] {
        for fps in ["--fps=30", "--fps=1e-300", "--fps=0"] {
            let mut pty = donut(&[fps], (80, 24));
            wait_for_frames(&pty, 1);
            pty.type_bytes(key);
            assert_eq!(pty.wait_for_exit(), code, "{key:?} {fps}");
            pty.assert_restored();
        }
    }
}

#[test]
fn p_pauses_and_resumes() {
    let mut pty = donut(&[], (80, 24));
    wait_for_frames(&pty, 5);
    pty.type_bytes(b"p");
    sleep(Duration::from_millis(300));
    let paused = frames(&pty);
    sleep(Duration::from_millis(300));
    assert_eq!(frames(&pty), paused);
    pty.resize((100, 30));
    pty.wait_for("the paused picture at the new size", |pty| frames(pty) > paused);
    pty.type_bytes(b"p");
    wait_for_frames(&pty, 5);
    pty.type_bytes(b"pq");
    assert_eq!(pty.wait_for_exit(), 0);
}

#[test]
fn space_switches_the_shading_off_and_on() {
    let mut pty = still_donut((80, 24));
    let dot = |c| if c == ' ' { ' ' } else { '.' };
    let flat = picture((80, 24)).iter().map(|line| line.chars().map(dot).collect()).collect();
    let flat: Vec<String> = flat;
    pty.type_bytes(b" ");
    pty.wait_for("dots", |pty| pty.lines() == flat);
    pty.type_bytes(b" ");
    wait_for_picture(&pty, (80, 24));
}

#[test]
fn other_keys_do_nothing_and_are_not_echoed_however_fast_they_come() {
    let mut pty = still_donut((80, 24));
    // Among them is Ctrl-S, which stops the output of a terminal in its usual settings.
    let keys = b"abcQP\r\n\t\x7f\x01\x13\x1b[A\x1bOP\x1b[5~\x1b[<0;10;10M\xff\xfe\xc3(";
    let mut bytes = keys.repeat(50);
    bytes.extend(b"wide open spaces".repeat(500).iter().filter(|byte| !b" pq".contains(byte)));
    bytes.extend(b"\x1b[<35;40;12M".repeat(500));
    pty.type_bytes(&bytes);
    wait_for_frames(&pty, 10);
    assert_eq!(pty.lines(), picture((80, 24)));
    assert_quits(&mut pty);
}

/// Types a code in pieces. Returns false if the pieces came so far apart, because the machine is busy,
/// that the donut need not take them for one code.
fn type_in_pieces(pty: &mut Pty, pieces: &[&str]) -> bool {
    let start = Instant::now();
    for piece in pieces {
        pty.type_bytes(piece.as_bytes());
        sleep(Duration::from_millis(2));
    }
    start.elapsed() < Duration::from_millis(40)
}

#[test]
fn a_code_that_begins_with_escape_does_nothing_whole_or_in_pieces() {
    // An arrow key, a key of the keypad, Alt and a letter, and a terminal's answer to a question.
    for code in ["\x1b[A", "\x1bOq", "\x1bq", "\x1bP>|a terminal q p\x1b\\"] {
        let (one, two) = (code.split_at(1), code.split_at(2));
        for pieces in [&[code][..], &[one.0, one.1], &[two.0, two.1], &[one.0, &code[1..2], two.1]]
        {
            let mut pty = still_donut((80, 24));
            while !type_in_pieces(&mut pty, pieces) {
                pty = still_donut((80, 24));
            }
            // The first of these frames may have been on its way.
            wait_for_frames(&pty, 4);
            assert_eq!(pty.lines(), picture((80, 24)), "{pieces:?}");
            assert_quits(&mut pty);
        }
    }
}

#[test]
fn escape_ends_the_donut_when_it_is_held_down_or_pressed_again() {
    for keys in [&b"\x1b\x1b"[..], b"\x1b\x1b\x1b\x1b", b"x\x1b"] {
        let mut pty = still_donut((80, 24));
        pty.type_bytes(keys);
        assert_eq!(pty.wait_for_exit(), 0, "{keys:?}");
    }
    let mut pty = still_donut((80, 24));
    // A key that is held down repeats about thirty times a second.
    for _ in 0..10 {
        pty.type_bytes(b"\x1b");
        sleep(Duration::from_millis(33));
    }
    assert_eq!(pty.wait_for_exit(), 0);
}

#[test]
fn keys_come_from_the_terminal_whatever_standard_input_is() {
    for command in [
        "DONUT < /dev/null",
        "yes | DONUT",
        "yes | head -1 | while read line; do DONUT; done",
        "echo --fps=20 | xargs DONUT",
    ] {
        let command = command.replace("DONUT", &still());
        let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        wait_for_picture(&pty, (80, 24));
        pty.type_bytes(b"abc\r\n");
        pty.resize((60, 20));
        wait_for_picture(&pty, (60, 20));
        assert_quits(&mut pty);
        pty.assert_restored();
    }
}

/// Only one of the two programs gets each key: the other program while it is waiting for one, otherwise the
/// donut. But Ctrl-C sends a signal to both.
#[test]
fn another_program_that_reads_the_same_keys_does_not_freeze_the_donut() {
    for (reader, key, code) in [
        ("cat", b"\x03", 130),
        ("while read line; do :; done", b"\x03", 130),
        ("head -c 9", b"q", 0),
    ] {
        let command = format!("{reader} | {DONUT}");
        let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        wait_for_frames(&pty, 1);
        for _ in 0..12 {
            pty.type_bytes(b"x");
            sleep(Duration::from_millis(30));
        }
        wait_for_frames(&pty, 10);
        pty.type_bytes(key);
        assert_eq!(pty.wait_for_exit(), code, "{reader}");
        pty.assert_restored();
    }
}

#[test]
fn a_q_typed_ahead_ends_the_donut_before_the_first_frame() {
    let mut pty = Pty::shell("bash", (80, 24));
    pty.type_bytes(format!("sleep 0.5; {DONUT}; echo $((6 * 7))\nq").as_bytes());
    pty.wait_for("the shell", |pty| pty.lines().contains(&"42".to_string()));
    let written = pty.written();
    assert!(written.find("\x1b[?1049h") < written.find("\x1b[?1049l"));
    assert_eq!(written.matches("\x1b[?1049h").count(), 1);
    assert!(!written.contains("\x1b[?2026h"));
}

// ---- Other terminals -----------------------------------------------------------------------------

#[test]
fn a_picture_on_another_terminal_fits_it_and_its_keys_end_the_donut() {
    let mut shown = Pty::run("sleep", &["100"], (60, 20), "xterm");
    let command = format!("exec {} > {}", still(), shown.path());
    let mut pty = Pty::run("sh", &["-c", &command], (100, 30), "xterm");
    wait_for_picture(&shown, (60, 20));
    shown.type_bytes(b"xq");
    assert_eq!(pty.wait_for_exit(), 0);
    shown.assert_restored();
}

/// After `su` without -c, the terminal belongs to another user, but can still be opened as /dev/tty.
#[cfg(target_os = "linux")]
#[test]
fn a_terminal_that_may_not_be_opened_by_its_name_is_drawn_on() {
    let is_root = Command::new("sh").args(["-c", "[ $(id -u) = 0 ]"]).status().unwrap().success();
    // root may open everything, unless it gives up this right.
    let prefix = if is_root { "setpriv --bounding-set=-all" } else { "env" };
    if !is_allowed(&format!("{prefix} true")) {
        return;
    }
    let command = format!("chmod 0 $(tty); exec {prefix} {}", still());
    let mut pty = Pty::run("sh", &["-c", &command], (60, 20), "xterm");
    wait_for_picture(&pty, (60, 20));
    pty.type_bytes(b"q");
    assert_eq!(pty.exit_code(), 0);
}

#[cfg(target_os = "linux")]
#[test]
fn a_terminal_that_cannot_be_opened_is_treated_as_a_pipe() {
    let unshare = "unshare --user --map-root-user --mount";
    let hide_names = "mount -t tmpfs none /dev/pts";
    if !is_allowed(&format!("{unshare} {hide_names}")) {
        return;
    }
    let run = format!("{hide_names} && setsid -w {DONUT} --frames=1");
    let command = format!("{unshare} sh -c '{run}'; exit $?");
    let mut pty = Pty::run("sh", &["-c", &command], (100, 40), "xterm");
    assert_eq!(pty.wait_for_exit(), 0);
    assert_eq!(pty.lines(), last_picture(&[], (80, 22), 40));
    assert!(!pty.written().contains("\x1b[?"));
}

// ---- Signals -------------------------------------------------------------------------------------

#[test]
fn the_donut_ends_by_the_signal_that_came_but_restores_the_terminal_first() {
    for (signal, code) in [("HUP", 129), ("INT", 130), ("QUIT", 131), ("TERM", 143)] {
        let mut pty = donut(&["--fps=0.01"], (80, 24));
        wait_for_frames(&pty, 1);
        pty.signal(signal);
        assert_eq!(pty.wait_for_exit(), code, "{signal}");
        pty.assert_restored();
    }
}

#[test]
fn a_signal_at_the_start_ends_the_donut_however_early_it_comes() {
    for n in 0..100 {
        let mut pty = Pty::run(DONUT, &[], (80, 24), "xterm");
        sleep(Duration::from_micros(60 * n));
        let process = Pid::from_raw(pty.process() as i32).unwrap();
        // While the program registers its handlers, the first signal may get lost.
        for _ in 0..2 {
            let _ = kill_process(process, Signal::TERM);
            sleep(Duration::from_millis(2));
        }
        assert_eq!(pty.exit_code(), 143);
        pty.assert_settings_restored();
    }
}

#[test]
fn ctrl_c_ends_the_list_the_loop_and_the_script_that_the_donut_is_in() {
    for command in [
        "DONUT --frames 1000 && echo next; exit 7",
        "for i in 1 2 3; do DONUT; done; exit 7",
        "sh -c 'while :; do DONUT; done'; exit 7",
    ] {
        for shell in ["bash", "dash"].into_iter().filter(|shell| is_installed(shell)) {
            let mut pty = Pty::shell(shell, (80, 24));
            type_line(&mut pty, &command.replace("DONUT", DONUT));
            wait_for_frames(&pty, 1);
            pty.type_bytes(b"\x03");
            // The shell only reads this line when the command above has ended.
            sleep(Duration::from_millis(300));
            type_line(&mut pty, "exit 5");
            assert_eq!(pty.wait_for_exit(), 5, "{shell}: {command}");
            assert!(!pty.lines().contains(&"next".to_string()));
            pty.assert_settings_restored();
        }
    }
}

#[test]
fn the_donut_ends_when_the_terminal_goes_even_without_sighup() {
    // When the terminal goes, the first process of its session gets a SIGHUP. With this command, that is
    // the shell, which ignores the signal. So the donut gets none.
    let ignoring_sighup = |options| format!("trap '' HUP; {DONUT} {options}; exit $?");
    for (command, key) in [
        (format!("exec {DONUT} --fps=5"), &b"x"[..]),
        (ignoring_sighup("--fps=5"), b"x"),
        (ignoring_sighup("--fps=0.01 < /dev/null"), b""),
        (ignoring_sighup(""), b"p"),
    ] {
        let mut pty = Pty::run_unread("sh", &["-c", &command], (80, 24), "xterm");
        pty.read_until(|pty| frames(pty) > 0);
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
    sleep(Duration::from_millis(300));
    pty
}

#[test]
fn on_a_terminal_that_reads_nothing_signals_end_the_donut_and_restore() {
    for size in [(80, 24), (1000, 500)] {
        let signals = [("HUP", 129), ("INT", 130), ("QUIT", 131), ("TERM", 143)];
        let mut ptys = signals.map(|(signal, code)| (stuck_donut(&[], size), signal, code));
        for (pty, signal, _) in &mut ptys {
            match *signal {
                "INT" => pty.type_bytes(b"\x03"),
                signal => pty.signal(signal),
            }
        }
        for (mut pty, signal, code) in ptys {
            assert_eq!(pty.wait_for_exit(), code, "{signal} {size:?}");
            pty.start_reading(1 << 16, Duration::ZERO);
            pty.wait_for("the end", |pty| pty.written().ends_with(LEAVE));
            pty.assert_restored();
        }
    }
}

#[test]
fn where_a_signal_cuts_a_frame_short_the_prompt_starts_in_column_0() {
    let mut pty = stuck_donut(&["--frames=1000000"], (80, 24));
    pty.signal("TERM");
    assert_eq!(pty.wait_for_exit(), 143);
    pty.start_reading(1 << 16, Duration::ZERO);
    pty.wait_for("the end", |pty| pty.written().ends_with("\x1b[1G\x1b[?25h"));
    pty.assert_restored();
}

#[test]
fn a_signal_restores_the_terminal_even_while_another_program_writes_there() {
    for _ in 0..3 {
        let mut pty = still_donut((80, 24));
        let mut terminal = pty.open();
        // Linux lets only one program write at a time, and a write that does not block then fails.
        let end = Instant::now() + Duration::from_millis(300);
        let writer = spawn(move || {
            while Instant::now() < end {
                terminal.write_all(b"\0").unwrap();
            }
        });
        sleep(Duration::from_millis(20));
        pty.signal("TERM");
        assert_eq!(pty.exit_code(), 143);
        pty.wait_for("the end", |pty| !pty.screen(|screen| screen.alternate_screen()));
        writer.join().unwrap();
        pty.assert_restored();
    }
}

#[test]
fn a_terminal_that_reads_nothing_for_a_while_goes_on_afterwards() {
    let mut pty = Pty::run_unread(DONUT, &STILL, (200, 50), "xterm");
    pty.wait_for("the start", Pty::has_changed_settings);
    sleep(Duration::from_millis(500));
    pty.signal("CONT");
    pty.type_bytes(b"x");
    sleep(Duration::from_millis(500));
    pty.start_reading(1 << 16, Duration::ZERO);
    wait_for_picture(&pty, (200, 50));
    assert_quits(&mut pty);
    pty.assert_restored();
}

#[test]
fn keys_and_signals_are_obeyed_on_a_terminal_that_reads_slowly() {
    let ends: [fn(&mut Pty); 2] = [|pty| pty.type_bytes(b"q"), |pty| pty.signal("TERM")];
    for (end, code) in ends.into_iter().zip([0, 143]) {
        // The terminal reads 25 kB a second, and there are 53 kB of frames.
        let mut pty = Pty::run_unread(DONUT, &[], (80, 24), "xterm");
        pty.start_reading(1000, Duration::from_millis(40));
        wait_for_frames(&pty, 2);
        end(&mut pty);
        assert_eq!(pty.wait_for_exit(), code);
        pty.assert_restored();
    }
}

// ---- Job control ---------------------------------------------------------------------------------

fn type_line(pty: &mut Pty, line: &str) {
    pty.type_bytes(format!("{line}\n").as_bytes());
}

/// Runs a still donut in a shell, and waits until it is on the screen.
#[track_caller]
fn donut_in_a_shell(shell: &str) -> Pty {
    let mut pty = Pty::shell(shell, (80, 24));
    type_line(&mut pty, &still());
    wait_for_picture(&pty, (80, 24));
    pty
}

/// Waits until the job is stopped and the shell has the screen that it had before.
#[track_caller]
fn wait_for_the_stop(pty: &Pty) {
    pty.wait_for("the stop", Pty::is_stopped);
    pty.wait_for("the shell's screen", |pty| {
        pty.screen(|screen| !screen.alternate_screen() && !screen.hide_cursor())
    });
}

/// Waits until the shell says that it has noticed a stop.
#[track_caller]
fn wait_for_stopped(pty: &Pty) {
    pty.wait_for("the stop", Pty::is_stopped);
    pty.wait_for("the shell", |pty| pty.written().contains("Stopped"));
}

/// Waits for the end of the job, and asks the shell for its exit code.
#[track_caller]
fn assert_code(pty: &mut Pty, code: u32) {
    pty.wait_for("its end", |pty| pty.job_process().is_none());
    type_line(pty, "echo code=$?");
    let said = format!("code={code}");
    // A prompt may stand before the answer.
    pty.wait_for(&said, |pty| pty.lines().iter().any(|line| line.ends_with(&said)));
}

#[test]
fn ctrl_z_gives_the_terminal_back_and_fg_redraws() {
    for shell in ["sh", "bash"] {
        let mut pty = donut_in_a_shell(shell);
        for _ in 0..2 {
            pty.type_bytes(b"\x1a");
            wait_for_the_stop(&pty);
            pty.resize((90, 30));
            type_line(&mut pty, "fg");
            wait_for_picture(&pty, (90, 30));
            assert!(pty.screen(|screen| screen.alternate_screen() && screen.hide_cursor()));
        }
        pty.type_bytes(b"q");
        assert_code(&mut pty, 0);
    }
}

/// If the donut were still on the alternate screen when the shell writes its prompt, the prompt would
/// vanish with that screen.
#[test]
fn after_ctrl_z_under_a_script_or_in_a_subshell_the_prompt_can_be_read() {
    for shell in ["bash", "dash"].into_iter().filter(|shell| is_installed(shell)) {
        for command in [format!("sh -c '{}; exit 5'", still()), format!("({}; exit 5)", still())] {
            let mut pty = Pty::shell(shell, (80, 24));
            type_line(&mut pty, &command);
            for _ in 0..2 {
                wait_for_picture(&pty, (80, 24));
                pty.type_bytes(b"\x1a");
                wait_for_the_stop(&pty);
                pty.wait_for("the shell", |pty| {
                    pty.lines().iter().any(|line| line.contains("Stopped"))
                });
                // bash changes the settings for its prompt, so there they cannot be compared.
                if shell == "dash" {
                    pty.assert_settings_restored();
                }
                type_line(&mut pty, "echo $((6 * 7)); fg");
            }
            wait_for_picture(&pty, (80, 24));
            pty.type_bytes(b"q");
            assert_code(&mut pty, 5);
            assert!(pty.lines().contains(&"42".to_string()), "{:?}", pty.lines());
        }
    }
}

#[test]
fn ctrl_z_stops_the_donut_once_whatever_keys_are_typed_with_it() {
    for keys in [&b"\x1a\x1a"[..], b"\x1aq", b"pp\x1app"] {
        let mut pty = donut_in_a_shell("bash");
        pty.type_bytes(keys);
        wait_for_the_stop(&pty);
        type_line(&mut pty, "fg");
        wait_for_frames(&pty, 10);
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
    for _ in 0..10 {
        let mut pty = Pty::shell("bash", (80, 24));
        type_line(&mut pty, &format!("sh -c '{DONUT}; exit $?'"));
        wait_for_frames(&pty, 1);
        let job = pty.job_process().unwrap();
        let signal_donut = |signal| {
            let status = Command::new("pkill").args([signal, "-P", &job]).status();
            assert!(status.unwrap().success());
        };
        signal_donut("-STOP");
        pty.type_bytes(b"\x1a");
        signal_donut("-TERM");
        sleep(Duration::from_millis(100));
        signal_donut("-CONT");
        pty.wait_for("its end or stop", |pty| pty.job_process().is_none() || pty.is_stopped());
        if pty.job_process().is_none() {
            assert_code(&mut pty, 143);
            return;
        }
    }
    panic!("Ctrl-Z has stopped it each time");
}

#[test]
fn ctrl_z_does_nothing_where_no_shell_could_continue_the_donut() {
    let command = format!("{DONUT}; exit $?");
    for (program, arguments) in [(DONUT, &[][..]), ("sh", &["-c", &command])] {
        let mut pty = Pty::run(program, arguments, (80, 24), "xterm");
        wait_for_frames(&pty, 1);
        pty.type_bytes(b"\x1a");
        sleep(Duration::from_millis(300));
        wait_for_frames(&pty, 5);
        assert!(pty.screen(|screen| screen.alternate_screen()));
        assert_quits(&mut pty);
    }
}

/// Where the job in the foreground is outside of the program's pid namespace, the system cannot name it.
#[cfg(target_os = "linux")]
#[test]
fn in_a_pid_namespace_of_its_own_the_donut_draws_and_a_signal_ends_it() {
    let unshare = "unshare --user --map-root-user --pid --fork";
    if !is_allowed(&format!("{unshare} true")) {
        return;
    }
    // In the first case, the donut is the first process of its namespace.
    for command in [DONUT.to_string(), format!("sh -c '{DONUT}; exit $?'")] {
        let mut pty = Pty::shell("bash", (80, 24));
        type_line(&mut pty, &format!("{unshare} {command}"));
        wait_for_frames(&pty, 5);
        pty.type_bytes(b"\x03");
        assert_code(&mut pty, 130);
    }
}

#[test]
fn a_stopped_donut_takes_the_terminal_again_whoever_stopped_it() {
    for (shell, signal, lines) in
        [("bash", "STOP", &["fg"][..]), ("bash", "TSTP", &["bg", "fg"]), ("dash", "STOP", &["fg"])]
    {
        if !is_installed(shell) {
            continue;
        }
        let mut pty = donut_in_a_shell(shell);
        pty.signal_job(signal);
        wait_for_stopped(&pty);
        for line in lines {
            type_line(&mut pty, line);
            sleep(Duration::from_millis(300));
        }
        wait_for_picture(&pty, (80, 24));
        // The settings are the donut's again: the key is read without a newline, and not echoed.
        pty.type_bytes(b"q");
        assert_code(&mut pty, 0);
        assert!(!pty.lines().iter().any(|line| line.starts_with('q')), "{:?}", pty.lines());
        // Where a stopped job has changed the settings, dash leaves them as they are, so the donut has
        // to remember the ones from before.
        if shell == "dash" {
            pty.assert_settings_restored();
        }
    }
}

#[test]
fn in_the_background_the_donut_waits_for_the_foreground_and_draws_nothing() {
    let mut pty = Pty::shell("bash", (80, 24));
    type_line(&mut pty, &format!("{} &", still()));
    pty.wait_for("the job", |pty| pty.job_process().is_some());
    sleep(Duration::from_millis(500));
    assert!(!pty.is_stopped());
    assert_eq!(frames(&pty), 0);
    assert!(!pty.written().contains("\x1b[?1049h"));
    type_line(&mut pty, "fg");
    wait_for_picture(&pty, (80, 24));
    pty.type_bytes(b"q");
    assert_code(&mut pty, 0);
}

#[test]
fn a_background_donut_can_be_killed_and_leaves_the_screen_to_the_shell() {
    type Step = fn(&mut Pty);
    let start: Step = |pty| {
        type_line(pty, &still());
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
        wait_for_the_stop(pty);
    };
    let stop: Step = |pty| {
        pty.signal_job("STOP");
        wait_for_stopped(pty);
    };
    let bg: Step = |pty| {
        type_line(pty, "bg");
        pty.wait_for("the continuation", |pty| !pty.is_stopped());
        sleep(Duration::from_millis(300));
        assert!(!pty.is_stopped() && !pty.screen(|screen| screen.alternate_screen()));
    };
    let kill: Step = |pty| type_line(pty, "kill %1");
    for steps in [
        &[start, ctrl_z, kill][..],
        &[start, ctrl_z, bg, kill],
        &[start, stop, kill],
        &[start, stop, bg, kill],
        &[start_in_background, kill],
    ] {
        let mut pty = Pty::shell("bash", (80, 24));
        steps.iter().for_each(|step| step(&mut pty));
        pty.wait_for("its end", |pty| pty.job_process().is_none());
        // bash reports how a job has ended, at the latest when another job ends as well.
        type_line(&mut pty, "(:)");
        pty.wait_for("its signal", |pty| pty.written().contains("Terminated"));
        assert!(pty.screen(|screen| !screen.alternate_screen() && !screen.hide_cursor()));
    }
}

#[test]
fn in_the_background_of_a_terminal_that_reads_nothing_a_signal_ends_the_donut() {
    let mut pty = Pty::run_unread("bash", &["--norc", "-i"], (80, 24), "xterm");
    type_line(&mut pty, &format!("{DONUT} --fps=0"));
    pty.wait_for("the job", |pty| pty.job_process().is_some());
    sleep(Duration::from_millis(500));
    pty.signal_job("STOP");
    pty.wait_for("the stop", Pty::is_stopped);
    sleep(Duration::from_millis(300));
    pty.signal_job("CONT");
    sleep(Duration::from_millis(300));
    pty.signal_job("TERM");
    pty.wait_for("its end", |pty| pty.job_process().is_none());
}

/// Without job control, a script runs the donut in the script's own job, and may end before it.
#[test]
fn after_a_script_that_ends_first_the_shell_has_its_screen() {
    let mut pty = Pty::shell("bash", (80, 24));
    type_line(&mut pty, &format!("sh -c '{DONUT} & sleep 1'"));
    wait_for_frames(&pty, 1);
    pty.wait_for("the shell's screen", |pty| !pty.screen(|screen| screen.alternate_screen()));
    let now = frames(&pty);
    type_line(&mut pty, "echo $((6 * 7))");
    pty.wait_for("the shell", |pty| pty.lines().contains(&"42".to_string()));
    sleep(Duration::from_millis(200));
    assert_eq!(frames(&pty), now);
}

#[cfg(target_os = "linux")]
#[test]
fn timeout_ends_the_donut_in_the_foreground_and_in_the_background() {
    let mut pty = Pty::shell("bash", (80, 24));
    type_line(&mut pty, &format!("timeout 0.5 {DONUT}"));
    wait_for_frames(&pty, 1);
    assert_code(&mut pty, 124);
    // timeout makes the donut a job of its own. Where there is no job control, nothing puts this job
    // into the foreground.
    let command = format!("timeout 0.5 {DONUT}; exit $?");
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    assert_eq!(pty.wait_for_exit(), 124);
    assert_eq!(pty.written(), "");
    pty.assert_settings_restored();
}

#[test]
fn after_kill_9_a_shell_still_works() {
    for shell in ["dash", "bash"].into_iter().filter(|shell| is_installed(shell)) {
        let mut pty = donut_in_a_shell(shell);
        pty.signal_job("KILL");
        pty.wait_for("its end", |pty| pty.job_process().is_none());
        sleep(Duration::from_millis(300));
        type_line(&mut pty, "echo $((6 * 7))");
        pty.wait_for("the shell", |pty| pty.lines().iter().any(|line| line.contains("42")));
        assert!(pty.is_running());
    }
}

#[cfg(target_os = "linux")]
#[test]
fn the_donut_takes_little_processor_time_in_the_foreground_and_in_the_background() {
    for (command, draws) in
        [(format!("{DONUT} < /dev/null; true"), true), (format!("set -m; {DONUT} & wait"), false)]
    {
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        pty.wait_for("the start", |pty| frames(pty) > 0 || !draws && pty.job_process().is_some());
        sleep(Duration::from_millis(500));
        let process = pty.job_process().expect("a job");
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
        // User and system time, in hundredths of a second.
        let ticks: u32 = stat.split(' ').skip(13).take(2).map(|n| n.parse::<u32>().unwrap()).sum();
        assert!(ticks < 10, "{ticks} ticks: {command}");
    }
}
