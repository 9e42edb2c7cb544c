//! The donut on a pseudo-terminal: what is on the screen, and how the terminal is left.
//!
//! A pseudo-terminal is a terminal without a screen or a keyboard. `pty/mod.rs` makes them, and emulates
//! the screen that a person would see. Some tests run the donut in a shell there, with job control:
//! Ctrl-Z, `fg`, `bg` and `&`. All this needs Linux: macOS takes the terminal away from everybody when the
//! first process of its session ends.
#![cfg(target_os = "linux")]

mod program;
mod pty;

use std::collections::BTreeSet;
use std::fmt::Debug;
use std::fs::read_to_string;
use std::io::{self, Write};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::thread::{Builder, scope, sleep};
use std::time::{Duration, Instant};

use program::{Program, frames};
use pty::{Pty, stat};
use rustix::process::Signal;

const DONUT: &str = env!("CARGO_BIN_EXE_donut");
/// A donut that stands still, so that every frame is the same picture.
const STILL: &str = "-A=1 -B=0.5 --spin=0,0";
/// With this option, the second frame is due after 32 years.
const ONE_FRAME: &str = "--fps=1e-300";
const SIZE: (u16, u16) = (80, 24);
/// How each frame ends, as the terminal gets it: with the end of the update, and a newline.
const END_OF_FRAME: &str = "\x1b[?2026l\r\n";

/// The signals that ask donut to end.
const SIGNALS: [Signal; 4] = [Signal::HUP, Signal::INT, Signal::QUIT, Signal::TERM];

fn run_donut(options: &str, size: (u16, u16)) -> Pty {
    Pty::run(DONUT, &options.split_whitespace().collect::<Vec<_>>(), size)
}

/// A command line, with the program's path in place of DONUT, a still donut in place of STILL, and one
/// that draws a single frame in place of ONCE.
fn command(line: &str) -> String {
    let line = line.replace("ONCE", &format!("STILL {ONE_FRAME}"));
    line.replace("STILL", &format!("DONUT {STILL}")).replace("DONUT", &format!("\"{DONUT}\""))
}

/// Runs a command line in a shell without job control.
fn run_in_sh(line: &str) -> Pty {
    Pty::run("sh", &["-c", &command(line)], SIZE)
}

/// Types a command line into an interactive shell, which has job control. `None` if it is not installed.
fn run_as_job(shell: &str, line: &str) -> Option<Pty> {
    if !is_possible(&format!("{shell} -c :")) {
        return None;
    }
    // Whatever the user's own settings of these shells are.
    let options = match shell {
        "bash" => &["--norc", "-i"][..],
        "zsh" => &["-f", "-i"],
        _ => &["-i"],
    };
    let pty = Pty::run(shell, options, SIZE);
    pty.wait_for("a prompt", |pty| !pty.written().is_empty());
    type_line(&pty, line);
    Some(pty)
}

fn type_line(pty: &Pty, line: &str) {
    pty.type_bytes(format!("{}\n", command(line)).as_bytes());
}

/// The exit code that an interactive shell reports, and the terminal's settings while it runs a command.
#[track_caller]
fn code_and_settings(pty: &Pty) -> String {
    let before = pty.written().len();
    type_line(pty, "echo \"<$?=$(stty -g)>\"");
    let answer = || {
        let written = pty.written().split_off(before);
        let mut texts = written.split('<').filter_map(|text| text.split_once('>'));
        // The shell also echoes the question.
        let answer = texts.find(|(text, _)| text.starts_with(|first: char| first.is_ascii_digit()));
        answer.map(|(text, _)| text.to_string())
    };
    pty.wait_for("an answer", |_| answer().is_some());
    answer().unwrap()
}

/// Waits until the still donut fills a screen of this size, with these options.
#[track_caller]
fn wait_for_picture(pty: &Pty, options: &str, size: (u16, u16)) {
    let picture = picture(options, size);
    pty.wait_for("the picture", |pty| pty.lines() == picture);
}

/// The lines of a screen that the still donut fills, with these options.
fn picture(options: &str, (columns, rows): (u16, u16)) -> Vec<String> {
    // The cursor needs the last row. At 80x24, donut.c's picture leaves another one free.
    let height = if (columns, rows) == SIZE { 22 } else { rows.saturating_sub(1).max(1) };
    picture_of_size(options, (columns, height), rows.into())
}

/// The lines of a screen with so many rows, after the still donut has been drawn there in this size.
fn picture_of_size(options: &str, (width, height): (u16, u16), rows: usize) -> Vec<String> {
    let size = format!("--width={width} --height={height}");
    let written = in_a_pipe(&format!("{STILL} --frames=1 {size} {options}"));
    let mut lines: Vec<_> =
        frames(&written)[0].split('\n').map(|row| row.trim_end().to_string()).collect();
    // In a terminal of one row, the newline at the end of the picture moves it up and away.
    lines.drain(..lines.len().saturating_sub(rows));
    lines.resize(rows, String::new());
    lines
}

/// The lines of a screen without the shading.
fn flat(lines: &[String]) -> Vec<String> {
    lines.iter().map(|line| line.replace(|cell| cell != ' ', ".")).collect()
}

/// What donut writes with these options if there is no terminal.
fn in_a_pipe(options: &str) -> String {
    Program::start(DONUT, &format!("--fps=0 {}", options.trim_end()), Stdio::piped()).output().1
}

fn frame_count(pty: &Pty) -> usize {
    pty.written().matches(END_OF_FRAME).count()
}

fn wait_for_first_frame(pty: &Pty) {
    pty.wait_for("the first frame", |pty| frame_count(pty) > 0);
}

/// Waits for this many more frames of a donut that goes on drawing.
#[track_caller]
fn wait_for_more_frames(pty: &Pty, more: usize) {
    let now = frame_count(pty);
    pty.wait_for("more frames", |pty| frame_count(pty) >= now + more);
}

/// How often donut has entered the terminal so far: only then does it hide the cursor.
fn enter_count(pty: &Pty) -> usize {
    pty.written().matches("\x1b[?25l").count()
}

#[track_caller]
fn assert_quits(pty: &Pty) {
    pty.type_bytes(b"q");
    pty.assert_ends(0);
}

/// Whether this machine can run this command. If it cannot, the test skips it, and says so once.
fn is_possible(command: &str) -> bool {
    static MISSING: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());
    let output = Command::new("sh").args(["-c", command]).output().unwrap();
    if !output.status.success() && MISSING.lock().unwrap().insert(command.into()) {
        // Unlike `eprintln`, this shows even if the test succeeds.
        let message = format!("skipped, because this machine cannot run `{command}`\n");
        io::stderr().write_all(message.as_bytes()).unwrap();
    }
    output.status.success()
}

/// Runs a test's cases, eight at a time, because most of the time they wait.
fn side_by_side<T: Debug + Sync>(cases: &[T], run: impl Fn(&T) + Sync) {
    for cases in cases.chunks(8) {
        scope(|scope| {
            for case in cases {
                // The message of a panic begins with the name of the thread.
                let thread = Builder::new().name(format!("{case:?}"));
                thread.spawn_scoped(scope, || run(case)).unwrap();
            }
        });
    }
}

// ---- The picture ---------------------------------------------------------------------------------

#[test]
fn the_picture_is_donut_cs_in_80x24_and_where_its_size_is_given_and_its_24_rows_fit() {
    let given = "--width=80 --height=22";
    // In a pipe, 80x22 is donut.c's picture. With this aspect it is not, but it looks as with 2.
    let whole = "--aspect=2.000001";
    // A terminal, and donut's options there. What it shows is a picture of this size, with this option.
    // 80x23 is what tmux leaves of 80x24 if it shows its status line. A terminal with a 0 does not know
    // its size.
    let cases = [
        (SIZE, "", (80, 22), ""),
        ((0, 0), "", (80, 22), ""),
        ((80, 0), "", (80, 22), ""),
        ((0, 24), "", (80, 22), ""),
        ((81, 24), "", (81, 23), ""),
        ((80, 23), "", (80, 22), whole),
        ((81, 24), given, (80, 22), ""),
        ((1, 1), "", (1, 1), ""),
        (SIZE, whole, (80, 22), whole),
    ];
    let sizes = cases.map(|(size, ..)| size);
    side_by_side(&cases, |&(size, options, picture_size, option)| {
        let pty = run_donut(&format!("{STILL} {options}"), size);
        let picture = picture_of_size(option, picture_size, pty.lines().len());
        wait_for_first_frame(&pty);
        pty.wait_for("the picture", |pty| pty.lines() == picture);
        assert!(pty.screen(|screen| screen.alternate_screen() && screen.hide_cursor()));
        wait_for_more_frames(&pty, 2);
        assert_eq!(pty.lines(), picture);
        assert_eq!(pty.written().matches("\x1b[2J").count(), 1);
        // The same, whatever the size was before.
        for before in sizes {
            pty.resize(before);
            wait_for_more_frames(&pty, 1);
            pty.resize(size);
            pty.wait_for("the picture again", |pty| pty.lines() == picture);
        }
        assert_quits(&pty);
    });
}

#[test]
fn every_frame_is_a_synchronized_update_and_lacks_only_the_blanks_at_the_ends_of_rows() {
    let cases = [("", SIZE), ("--color=red", SIZE), ("--width=100 --height=29", (100, 30))];
    side_by_side(&cases, |&(options, size)| {
        let pty = run_donut(options, size);
        wait_for_more_frames(&pty, 6);
        assert_quits(&pty);
        let written = pty.written();
        let updates: Vec<_> = written.split("\x1b[?2026h").skip(1).collect();
        // The q may have come within the last one.
        let (_, whole) = updates.split_last().unwrap();
        let frames = whole.iter().map(|update| update.strip_suffix(END_OF_FRAME).expect("an end"));
        // Each newline becomes a carriage return and a newline, and the blanks at the end of a row, ESC [ K.
        let in_a_pipe = in_a_pipe(&format!("--frames={} {options}", whole.len()));
        let rows = in_a_pipe.lines().map(|row| {
            let (cells, reset) = row.split_at(row.find("\x1b[0m").unwrap_or(row.len()));
            let cut = cells.trim_end_matches(' ');
            format!("{cut}{}{reset}\r\n", if cut.len() < cells.len() { "\x1b[K" } else { "" })
        });
        let expected: String = rows.collect();
        assert_eq!(frames.map(|frame| format!("{frame}\r\n")).collect::<String>(), expected);
    });
}

#[test]
fn a_resize_and_a_storm_of_them_draw_what_a_fresh_start_draws() {
    let pty = run_donut(STILL, SIZE);
    wait_for_picture(&pty, "", SIZE);
    for rows in 1..=6 {
        for step in 1..=12 {
            // There and back, so that each time, only the columns or only the rows change.
            let columns = if rows % 2 == 1 { step } else { 13 - step };
            pty.resize((columns, rows));
            wait_for_more_frames(&pty, 1);
            wait_for_picture(&pty, "", (columns, rows));
        }
    }
    for size in [(1, 1), (0, 0), (1, 50), (50, 1), (1000, 500), (2, 2), SIZE, (33, 11)].repeat(5) {
        pty.resize(size);
        sleep(Duration::from_millis(3));
    }
    pty.resize((100, 30));
    wait_for_picture(&pty, "", (100, 30));
    assert!(pty.screen(|screen| (0..30).all(|row| !screen.row_wrapped(row))));
    assert_quits(&pty);
}

#[test]
fn cells_have_the_shape_that_the_terminal_tells() {
    let size = (100, 36);
    // donut's options, a cell's size in pixels, and the aspect of the cells in the picture.
    let cases = [("", (9, 20), 20.0 / 9.0), ("", (0, 13), 2.0), ("--aspect=1.5", (9, 20), 1.5)];
    side_by_side(&cases, |&(options, (width, height), aspect)| {
        let pty = run_donut(&format!("{STILL} {ONE_FRAME} {options}"), size);
        wait_for_first_frame(&pty);
        let clear_count = || pty.written().matches("\x1b[2J").count();
        // The pixels change, and later only a border. Even that clears the screen, where terminals may have
        // rearranged what was on it.
        for border in [35, 0, 35] {
            let before = clear_count();
            pty.resize_window(size, (100 * width + border, 36 * height + border));
            pty.wait_for("a cleared screen", |_| clear_count() > before);
            wait_for_picture(&pty, &format!("--aspect={aspect}"), size);
        }
        // At 80x24, it is donut.c's own picture all the same.
        pty.resize_window(SIZE, (80 * width, 24 * height));
        wait_for_picture(&pty, options, SIZE);
        assert_quits(&pty);
    });
}

#[test]
fn with_frames_nothing_is_lost_and_the_prompt_comes_below_the_last_picture() {
    let cases = [(SIZE, 3), (SIZE, 23), (SIZE, 50), ((100, 30), 3), ((100, 30), 50), ((9, 2), 5)];
    side_by_side(&cases, |&(size, line_count)| {
        let line = format!("seq {line_count}; printf last; STILL --frames=5; printf prompt");
        let pty = Pty::run("sh", &["-c", &command(&line)], size);
        pty.assert_ends(0);
        assert!(!pty.written().contains("\x1b[?1049h"));
        let mut lines = picture("", size);
        *lines.last_mut().unwrap() = "prompt".into();
        assert_eq!(pty.lines(), lines);
        let mut screen = pty.screen(Clone::clone);
        let scrollback = (1..=screen.scrollback_len()).rev().map(|distance| {
            screen.set_scrollback(distance);
            screen.rows(0, 80).next().unwrap()
        });
        let lines = (1..=line_count).map(|number| number.to_string()).chain(["last".to_string()]);
        assert!(scrollback.eq(lines));
    });
}

// ---- Keys ----------------------------------------------------------------------------------------

#[test]
fn each_key_that_quits_restores_the_terminal() {
    // The last two are Ctrl-C and Ctrl-\, which send SIGINT and SIGQUIT.
    let cases = [(b"q", 0), (b"Q", 0), (b"\x1b", 0), (b"\x03", -2), (b"\x1c", -3)];
    side_by_side(&cases, |&(key, code)| {
        for fps in ["--fps=30", ONE_FRAME, "--fps=0"] {
            let pty = run_donut(fps, SIZE);
            wait_for_first_frame(&pty);
            pty.type_bytes(key);
            pty.assert_ends(code);
        }
    });
}

#[test]
fn space_and_p_pause_and_resume_and_a_paused_donut_wakes_up_once_a_second() {
    side_by_side(&["p", "P", " "], |key| {
        let pty = run_donut("", SIZE);
        wait_for_first_frame(&pty);
        pty.type_bytes(key.as_bytes());
        pty.wait_for("the pause", |pty| {
            let before = frame_count(pty);
            sleep(Duration::from_secs(1));
            frame_count(pty) == before
        });
        // How often its loop has gone to sleep, to wait for something.
        let sleep_count = || -> usize {
            let status = read_to_string(format!("/proc/{}/status", pty.pid())).unwrap();
            let (_, count) = status.split_once("\nvoluntary_ctxt_switches:\t").unwrap();
            count.lines().next().unwrap().parse().unwrap()
        };
        let (paused, before) = (frame_count(&pty), sleep_count());
        sleep(Duration::from_secs(3));
        let count = sleep_count() - before;
        assert!((2..10).contains(&count), "{count}");
        assert_eq!(frame_count(&pty), paused);
        pty.resize((100, 30));
        pty.wait_for("the paused picture at the new size", |pty| frame_count(pty) > paused);
        pty.type_bytes(key.as_bytes());
        wait_for_more_frames(&pty, 5);
        pty.type_bytes(key.as_bytes());
        assert_quits(&pty);
    });
}

/// Over a slow line, the bytes of a key may come one by one.
#[test]
fn the_arrow_keys_turn_the_near_side_the_way_they_point_even_in_pieces() {
    // A and B after a turn by a tenth of a radian. Before it, they are 1 and 0, and then up and down
    // change only A. Then the milliseconds between two pieces.
    let (right, left) = ("-A=1.0032044973 -B=-0.0640147145", "-A=1.0032044973 -B=0.0640147145");
    let arrows =
        [('A', "-A=0.9 -B=0", 1), ('B', "-A=1.1 -B=0", 10), ('C', right, 20), ('D', left, 40)];
    // The last two are Alt and an arrow, and an arrow while the donut is paused.
    let starts = ["\x1b[", "\x1bO", "\x1b[1;2", "\x1b\x1b[", "p\x1b["];
    let keys = starts.iter().flat_map(|start| arrows.map(|arrow| (start, arrow)));
    side_by_side(&keys.collect::<Vec<_>>(), |&(start, (letter, turned, pause))| {
        let comes_in_time = |_| {
            let pty = run_donut(&format!("-A=1 -B=0 {ONE_FRAME}"), SIZE);
            wait_for_picture(&pty, "-B=0", SIZE);
            let (mut last, mut longest) = (Instant::now(), Duration::ZERO);
            for piece in format!("{start}{letter}").as_bytes().chunks(1) {
                let now = Instant::now();
                pty.type_bytes(piece);
                longest = longest.max(last.elapsed());
                last = now;
                sleep(Duration::from_millis(pause));
            }
            // On a busy machine, a piece may come later than the donut waits for it.
            if longest > Duration::from_millis(48) {
                return false;
            }
            wait_for_picture(&pty, turned, SIZE);
            pty.type_bytes(b"s");
            let dots = flat(&picture(turned, SIZE));
            pty.wait_for("the same without shading", |pty| pty.lines() == dots);
            assert_quits(&pty);
            true
        };
        assert!((0..100).any(comes_in_time), "this machine is too busy");
    });
}

#[test]
fn m_and_s_redraw_the_same_frame_and_a_new_size_keeps_their_choice() {
    // Before the first m, the method depends on the size.
    let both_methods = [
        ("", SIZE, "--method=classic", false),
        ("", (100, 30), "--method=exact", false),
        ("m", (100, 30), "--method=classic", false),
        ("s", (100, 30), "--method=classic", true),
        ("", (90, 30), "--method=classic", true),
        ("S", SIZE, "--method=classic", false),
        ("m", SIZE, "--method=exact", false),
        ("", (100, 30), "--method=exact", false),
        ("s", SIZE, "--method=exact", true),
        ("M", SIZE, "--method=classic", true),
        ("mms", SIZE, "--method=classic", false),
    ];
    // Where classic is refused, m does nothing. Once the s has been obeyed, so has the m.
    let other_lengths = |option| [("", SIZE, option, false), ("ms", SIZE, option, true)];
    let (other_r2, other_k2) = (other_lengths("--r2=3"), other_lengths("--k2=6"));
    let cases = [("", &both_methods[..]), ("--r2=3", &other_r2), ("--k2=6", &other_k2)];
    side_by_side(&cases, |&(option, steps)| {
        let pty = run_donut(&format!("{STILL} {ONE_FRAME} {option}"), SIZE);
        for &(keys, size, option, is_flat) in steps {
            pty.resize(size);
            pty.type_bytes(keys.as_bytes());
            let shaded = picture(option, size);
            let picture = if is_flat { flat(&shaded) } else { shaded };
            pty.wait_for(keys, |pty| pty.lines() == picture);
        }
        // Neither clears the screen. A new size may do so twice.
        assert!(option.is_empty() || pty.written().matches("\x1b[2J").count() == 1);
        assert_quits(&pty);
    });
}

#[test]
fn frames_come_where_another_program_reads_the_same_keys() {
    // cat waits for a key and gets nearly all. Of two donuts, each gets some.
    side_by_side(&["cat | DONUT --fps=200", "DONUT & DONUT --fps=200"].repeat(2), |line| {
        let pty = run_in_sh(&format!("trap : TERM; {line}; exit $?"));
        for _ in 0..200 {
            wait_for_more_frames(&pty, 1);
            pty.type_bytes(b"x");
        }
        pty.signal(Signal::TERM);
        assert_eq!(pty.wait_for_exit(), 143);
    });
}

// ---- Other terminals -----------------------------------------------------------------------------

#[test]
fn in_tmux_a_new_size_leaves_no_rows_in_the_shells_screen() {
    if !is_possible("tmux -V") {
        return;
    }
    let session = "new-session 'echo before; STILL; echo after; read line'";
    // With these settings, the server ends when the test does.
    let settings = "set destroy-unattached on \\; set status off";
    let tmux = format!("SHELL=/bin/sh TMUX_TMPDIR=$dir tmux -f /dev/null {session} \\; {settings}");
    let pty = run_in_sh(&format!("dir=$(mktemp -d); {tmux}; rm -r $dir"));
    wait_for_picture(&pty, "", SIZE);
    pty.resize((120, 40));
    wait_for_picture(&pty, "", (120, 40));
    pty.type_bytes(b"q");
    pty.wait_for("the shell's screen", |pty| {
        pty.lines().join(" ").split_whitespace().eq(["before", "after"])
    });
    pty.type_bytes(b"\r");
    pty.assert_ends(0);
}

/// Keys come from the terminal of standard input. If a process without a controlling terminal opens it once
/// more, it must not acquire it, because with it would come its signals.
#[test]
fn another_terminal_may_show_the_picture_or_send_the_keys_too() {
    let with_null = "STILL < /dev/null > OTHER";
    side_by_side(&["STILL > OTHER", with_null, "setsid -w STILL < OTHER > OTHER"], |line| {
        let is_leader = line.contains("setsid");
        if is_leader && !is_possible("setsid -w true") {
            return;
        }
        let other = Pty::run("true", &[], SIZE);
        assert_eq!(other.wait_for_exit(), 0);
        let pty =
            run_in_sh(&format!("{line}; exit $?").replace("OTHER", other.path().to_str().unwrap()));
        if *line == with_null {
            // Raw mode would be set on one terminal, and keys would come from the other.
            pty.assert_ends(1);
            return assert!(!other.has_changed_settings());
        }
        wait_for_picture(&other, "", SIZE);
        let (keyboard, idle) = if is_leader { (&other, &pty) } else { (&pty, &other) };
        assert!(keyboard.has_changed_settings() && !idle.has_changed_settings());
        // The number of the controlling terminal.
        assert_eq!(stat(pty.job().unwrap()).unwrap()[4] == "0", is_leader);
        keyboard.type_bytes(b"q");
        pty.assert_ends(0);
        other.wait_for("the shell's screen", Pty::is_shells_screen);
        assert!(!other.has_changed_settings());
    });
}

// ---- Signals -------------------------------------------------------------------------------------

/// signal-hook loses a signal that comes just while it registers the handler. That takes some microseconds,
/// longer on a busy machine, so two of the early signals may have to come again.
#[test]
fn a_signal_ends_donut_at_once_and_restores_the_terminal_however_early_it_comes() {
    let (lost, late) = (AtomicUsize::new(0), AtomicUsize::new(0));
    let cases = (0..160).map(|n| (n, SIGNALS[n as usize % 4]));
    side_by_side(&cases.collect::<Vec<_>>(), |&(n, signal)| {
        // The others come while it draws, or while it waits for the next frame.
        let is_early = n < 100;
        let pty = run_donut(if n < 130 { "--fps=0" } else { ONE_FRAME }, SIZE);
        if !is_early {
            wait_for_first_frame(&pty);
        }
        sleep(Duration::from_micros(60 * (n % 100)));
        pty.signal(signal);
        let sent = Instant::now();
        while pty.is_running() && sent.elapsed() < Duration::from_secs(10) {
            sleep(Duration::from_millis(5));
        }
        if is_early && pty.is_running() {
            lost.fetch_add(1, SeqCst);
            pty.signal(signal);
        } else if !is_early && sent.elapsed() > Duration::from_millis(800) {
            late.fetch_add(1, SeqCst);
        }
        pty.assert_ends(-signal.as_raw());
    });
    assert!(lost.into_inner() <= 2, "early signals are lost");
    assert!(late.into_inner() <= 3, "signals have to wait");
}

#[test]
fn donut_ends_when_the_terminal_goes_even_without_sighup() {
    // When the terminal goes, the first process of its session gets a SIGHUP. With `trap`, that is the shell,
    // which ignores the signal, and after `setsid`, the terminal is not that of the donut's session. So in
    // all but the first, the donut gets none. The last one shows its picture on another terminal, which stays.
    let cases = [
        ("exec DONUT --fps=5", &b"x"[..]),
        ("trap '' HUP; DONUT --fps=0", b""),
        ("trap '' HUP; DONUT --fps=1e-300 < /dev/null", b""),
        ("trap '' HUP; DONUT", b"p"),
        ("trap '' HUP; setsid -w DONUT --fps=0.1", b""),
        ("trap '' HUP; DONUT > OTHER", b""),
    ];
    side_by_side(&cases.repeat(4), |&(line, key)| {
        let line = if line.starts_with("exec") { line } else { &format!("{line}; exit $?") };
        if line.contains("setsid") && !is_possible("setsid -w true") {
            return;
        }
        let other = Pty::run("true", &[], SIZE);
        let line = line.replace("OTHER", other.path().to_str().unwrap());
        let mut pty = Pty::run_unread("sh", &["-c", &command(&line)], SIZE);
        pty.wait_for("entering", Pty::has_changed_settings);
        pty.type_bytes(key);
        sleep(Duration::from_millis(300));
        pty.hang_up();
        // The donut may notice by itself a moment before the signal comes.
        let code = pty.wait_for_exit();
        assert!(code == 1 || code == -1 && line.starts_with("exec"), "{code}");
    });
}

#[test]
fn a_signal_on_a_terminal_that_takes_no_output_ends_donut_once_it_takes_some() {
    let cases = SIGNALS.iter().flat_map(|end| [(end, SIZE), (end, (1000, 500))]);
    side_by_side(&cases.collect::<Vec<_>>(), |&(&signal, size)| {
        // It does not read its output until `start_reading` is called.
        let pty = Pty::run_unread(DONUT, &["--fps=0", "--color=red"], size);
        pty.wait_until_full();
        pty.signal(signal);
        sleep(Duration::from_millis(100));
        pty.start_reading();
        pty.assert_ends(-signal.as_raw());
    });
}

// ---- Job control ---------------------------------------------------------------------------------

/// What stands for keys in a scenario, and what they send.
const CODES: [(&str, &str); 5] =
    [("^C", "\x03"), ("^D", "\x04"), ("^L", "\x0c"), ("^Z", "\x1a"), ("Enter", "\r")];

/// A step of a scenario: something that is typed, a signal, or something to wait for.
#[track_caller]
fn step(pty: &Pty, step: &str) {
    match step {
        "frames" => wait_for_more_frames(pty, 3),
        "picture" => {
            wait_for_picture(pty, "", SIZE);
            assert!(!pty.is_shells_screen() && !pty.is_stopped());
        }
        "resize" => {
            pty.resize((60, 20));
            wait_for_picture(pty, "", (60, 20));
        }
        // A newline on the last row moves the picture up, so that its first row reaches the one that stays
        // free.
        "scribble" => {
            pty.open().write_all(b"\x1b[24;1Hscribble\n").unwrap();
            pty.wait_for("the scribble", |pty| pty.lines() != picture("", SIZE));
        }
        "drawn" => {
            pty.wait_for("the frame's end", |pty| pty.written().ends_with(END_OF_FRAME));
        }
        "entered-again" => {
            pty.wait_for("entering again", |pty| {
                enter_count(pty) >= 2 && pty.has_changed_settings()
            });
            // Some terminals forget the shell's cursor if the alternate screen is entered twice.
            let written = pty.written();
            let (before, _) = written.rsplit_once("\x1b[?1049h").unwrap();
            assert!(before.rfind("\x1b[?1049l") > before.rfind("\x1b[?1049h"));
        }
        "stopped" => pty.wait_for("the stop", Pty::is_stopped),
        "shell" => pty.wait_for("the shell's screen", Pty::is_shells_screen),
        "settings" => assert!(!pty.has_changed_settings()),
        "STOP" => pty.signal_job(Signal::STOP),
        "TSTP" => pty.signal_job(Signal::TSTP),
        // Another program uses the alternate screen, and leaves something on the shell's.
        "less" => {
            type_line(pty, "printf '\\033[?1049h\\033[?1049l\\033[?25h\\nkept\\n'");
            self::step(pty, "kept");
        }
        "kept" => pty.wait_for("what was on the shell's screen", |pty| {
            pty.is_shells_screen() && pty.lines().contains(&"kept".to_string())
        }),
        "fg" => {
            let before = frame_count(pty);
            type_line(pty, step);
            pty.wait_for("a frame", |pty| frame_count(pty) > before);
        }
        // In the background, the donut is stopped again, and leaves what is typed to the shell.
        "bg" => {
            type_line(pty, step);
            self::step(pty, "prompt");
            sleep(Duration::from_millis(400));
            pty.wait_for("the stop", Pty::is_stopped);
        }
        "kill" => type_line(pty, "kill %1"),
        // bash resumes a stopped job that it kills, but not for SIGINT.
        "kill-INT" => type_line(pty, "kill -INT %1; bg"),
        "prompt" => {
            let answers = || pty.written().matches("42\r\n").count();
            let before = answers();
            type_line(pty, "echo $((6 * 7))");
            pty.wait_for("the shell", |_| answers() > before);
        }
        "end" => pty.wait_for("its end", |pty| pty.job().is_none()),
        "unwritten" => assert_eq!(pty.written(), ""),
        "message" => {
            assert!(pty.lines()[0].starts_with("donut: "), "{:?}", pty.lines());
            assert!(!pty.written().contains('\x1b'));
        }
        "lines" => assert_eq!(pty.lines()[..3], ["one", "two", "three"]),
        _ => match step.split_once('=') {
            // bash also says that a job has stopped or ended when another job ends. Before the answer to
            // `bg-says`, it resumes the job, again and again.
            Some((question @ ("says" | "bg-says"), text)) => pty.wait_for(text, |pty| {
                type_line(pty, if question == "says" { "(:)" } else { "bg" });
                sleep(Duration::from_millis(50));
                pty.written().contains(text)
            }),
            // The exit code that the shell reports of its job.
            Some(("code", _)) => {
                self::step(pty, "end");
                type_line(pty, "echo code=$?");
                // A prompt may stand before the answer.
                pty.wait_for(step, |pty| pty.lines().iter().any(|line| line.ends_with(step)));
            }
            Some(("restored", code)) => pty.assert_ends(code.parse().unwrap()),
            Some(("exit", code)) => assert_eq!(pty.wait_for_exit(), code.parse().unwrap()),
            _ => {
                // What is typed stands between quotation marks.
                let typed = step.strip_prefix('\'').and_then(|step| step.strip_suffix('\''));
                let typed = typed.unwrap_or_else(|| panic!("{step} is no step"));
                let start = typed.to_string();
                let text = CODES.iter().fold(start, |text, (key, code)| text.replace(key, code));
                pty.type_bytes(text.as_bytes());
            }
        },
    }
}

/// In each line are shells, a command, and steps. A `-` stands for a shell without job control, which runs
/// only this command. There, Ctrl-Z makes donut leave the terminal and enter it again.
fn run_scenarios(table: &str) {
    let setpriv = command("setpriv --reuid 65534 --clear-groups DONUT --version");
    let tools = [
        "bash -c :",
        "timeout --version",
        "setsid -w true",
        "xargs true < /dev/null",
        "unshare --pid --fork true",
        "env --block-signal=INT true",
        "dd oflag=nonblock count=0 < /dev/null",
        &setpriv,
    ];
    let scenarios: Vec<_> = table.lines().map(str::trim).filter(|s| s.contains(" | ")).collect();
    side_by_side(&scenarios, |scenario| {
        let (shells, rest) = scenario.split_once(" | ").unwrap();
        let (line, steps) = rest.rsplit_once(" | ").unwrap();
        let is_used = |tool: &&&str| line.contains(tool.split(' ').next().unwrap());
        if tools.iter().filter(is_used).any(|tool| !is_possible(tool)) {
            return;
        }
        for shell in shells.split_whitespace() {
            let pty = if shell == "-" { Some(run_in_sh(line)) } else { run_as_job(shell, line) };
            if let Some(pty) = pty {
                steps.split_whitespace().for_each(|name| step(&pty, name));
            }
        }
    });
}

#[test]
fn donut_is_well_behaved_without_job_control() {
    run_scenarios(
        "
        - | exec DONUT --frames=0 | restored=0
        - | TERM=dumb exec DONUT | restored=1 message

        # Where there is no terminal to read keys from.
        - | setsid -w DONUT < /dev/null; exit $? | restored=1 message

        # timeout makes the donut a job of its own, and without job control, nothing puts it into the
        # foreground.
        - | timeout 0.5 DONUT; exit $? | restored=124 unwritten
        - | timeout 0.5 DONUT; exit $? | 'Enter' restored=124

        # This sends SIGTERM to the donut, and then to its process group.
        - | exec timeout 0.5 DONUT --fps=0 | restored=124

        # In a pipe, even in a full one, signals have their default action.
        - | bash -c 'set -o pipefail; timeout -k1 0.5 DONUT --fps=0 | sleep 3' | restored=124 unwritten
        - | bash -c 'set -o pipefail; timeout -k1 -sINT 0.5 DONUT --fps=0 | sleep 3' | restored=124 unwritten

        # Typed ahead, and Ctrl-L, which draws the screen again.
        - | sleep 0.5; STILL; exit $? | '^Dq' restored=0
        - | exec ONCE | picture scribble '^L' picture 'q' restored=0

        # Whatever standard input is, keys are obeyed.
        - | STILL < /dev/null; exit $?   | picture 'abc' resize '^Z' entered-again frames 'q' restored=0
        - | echo --fps=20 | xargs STILL  | picture 'abc' resize '^Z' entered-again frames 'q' restored=0

        # The terminal is another user's, and cannot be opened once more.
        - | exec setpriv --reuid 65534 --clear-groups STILL | picture 'abc' resize frames 'q' restored=0

        # The first process of a container cannot end itself by a signal.
        - | exec unshare --pid --fork DONUT | frames '^C' restored=130

        # The program that runs the donut has blocked SIGINT.
        - | exec env --block-signal=INT DONUT | frames '^C' restored=-2

        # Whatever the settings are, Ctrl-C sends a signal, a newline starts a new line, and they come back.
        - | stty -isig; exec STILL       | picture '^Z' entered-again frames '^C' exit=-2
        - | stty -opost -onlcr; STILL; stty -a | grep -qe '-opost .* -onlcr' | picture 'q' exit=0

        # Even if its output is nonblocking, the donut waits for a slow terminal, and leaves it blocking.
        - | dd oflag=nonblock count=0 2> /dev/null; DONUT --fps=0 && ! grep -q 'flags:.*[4567]...$' /proc/self/fdinfo/1 | frames 'q' restored=0

        # Scroll margins, and an origin at the upper one, that another program has left.
        - | printf '\\033[5;10r\\033[?6h'; exec STILL | picture resize 'q' restored=0
        - | printf '\\033[5;10r\\033[?6h'; exec STILL --frames=1000000 | picture resize 'q' restored=0

        # Where only one cursor can be saved, the shell's comes back.
        - | printf 'one\\ntwo\\n'; STILL; printf three | picture '^Z' entered-again picture 'q' restored=0 lines
        ",
    );
}

#[test]
fn jobs_give_the_terminal_back_and_take_it_again() {
    run_scenarios(
        "
        sh bash | STILL | picture '^Z' stopped shell fg picture '^Z' stopped shell fg picture 'q' code=0

        # If the donut were still on the alternate screen when the shell writes its prompt, the prompt would
        # vanish with that screen.
        bash | sh -c 'STILL; exit 5' | picture '^Z' stopped shell says=Stopped prompt fg picture 'q' code=5

        # bash changes the settings for its prompt, so only dash shows whether they are restored. Where a
        # stopped job has changed them, dash leaves them so, and the donut has to remember the old ones.
        dash | sh -c 'STILL; exit 5' | picture '^Z' stopped shell settings fg picture 'q' code=5 settings

        # What the shell has written on the picture goes.
        bash | STILL --frames=1000000 | picture '^Z' stopped shell says=Stopped fg picture 'q' code=0

        # Ctrl-Z stops the donut once, whatever is typed with it.
        bash | STILL | picture '^Z^Z' stopped shell fg frames picture
        bash | STILL | picture '^Zq' stopped shell fg frames picture

        # In the background, the system stops the donut, and the shell can kill it.
        bash | STILL & | stopped says=Stopped shell fg picture 'q' code=0
        bash | STILL & | stopped says=Stopped shell kill end says=Terminated shell
        bash | STILL   | picture '^Z' stopped kill end says=Terminated shell
        bash | STILL   | picture '^Z' stopped says=Stopped kill-INT end says=Interrupt shell
        bash | STILL   | picture '^Z' stopped shell bg says=Stopped shell fg picture 'q' code=0
        bash | STILL   | picture '^Z' stopped shell bg kill end says=Terminated shell

        # What another program stops is left as it is. After fg, it is entered anew.
        bash dash | STILL | picture STOP stopped fg entered-again picture 'q' code=0 shell prompt
        bash dash | STILL | picture TSTP stopped fg entered-again picture '^C' code=130 shell prompt
        dash      | STILL | picture STOP stopped fg picture 'q' code=0 settings
        bash      | STILL | picture STOP stopped bg fg entered-again picture 'q' code=0 shell prompt
        bash      | STILL | picture STOP stopped kill end says=Terminated shell prompt
        bash      | STILL | picture TSTP stopped bg kill end says=Terminated shell prompt

        # Where STOP cuts a frame off, its rest is drawn after fg, here on the shell's screen. So these
        # draw only one frame, and are stopped after it.
        bash | ONCE | picture drawn STOP stopped less fg entered-again picture 'q' code=0 kept
        bash | ONCE | picture drawn STOP stopped less bg kill end says=Terminated kept

        # No shell can bring this to the foreground.
        bash dash | bash -c 'STILL & sleep 1' | says=donut: shell
        bash      | bash -c 'STILL & sleep 1' & | stopped bg-says=donut: shell

        # Ctrl-C ends the list, loop or script around the donut.
        bash dash | for i in 1 2 3; do STILL; done; exit 7     | picture '^C' end prompt
        bash dash | sh -c 'while :; do STILL; done'; exit 7    | picture '^C' end prompt
        ",
    );
}

/// Ctrl-C and Ctrl-\ end the program that runs the donut, too, and then the shell takes the terminal back.
#[test]
fn ctrl_c_through_another_program_gives_the_shell_its_terminal_back() {
    let programs = [
        ("xargs", "echo --fps=30 | xargs DONUT"),
        ("find", "find /dev/null -exec DONUT \\;"),
        ("true", "(DONUT; exit $?)"),
        ("python3", "python3 -c 'import subprocess; subprocess.call(DONUT)'"),
    ];
    let shells = ["bash", "zsh", "dash", "mksh"];
    let cases = programs.iter().flat_map(|program| shells.map(|shell| (shell, *program)));
    side_by_side(&cases.collect::<Vec<_>>(), |&(shell, (tool, program))| {
        if !is_possible(&format!("{tool} --version")) {
            return;
        }
        let Some(pty) = run_as_job(shell, ":") else { return };
        let before = code_and_settings(&pty);
        let (_, settings) = before.split_once('=').unwrap();
        for (key, code) in [(b"\x03", 130), (b"\x1c", 131)].repeat(5) {
            type_line(&pty, program);
            wait_for_more_frames(&pty, 1);
            pty.type_bytes(key);
            step(&pty, "end");
            assert_eq!(code_and_settings(&pty), format!("{code}={settings}"));
            assert!(pty.is_shells_screen());
        }
    });
}

/// In a job that no shell can bring to the foreground, the donut ends with an error. It starts in the
/// foreground, but must not change the settings before the shell takes the terminal back.
#[test]
fn a_donut_that_starts_in_an_orphaned_job_leaves_the_shell_its_settings() {
    // On a busy machine, the shell may take it back too late, so one success in three tries is enough.
    side_by_side(&["bash", "dash", "mksh"].repeat(2), |shell| {
        let keeps_settings = |_| {
            let Some(pty) = run_as_job(shell, ":") else { return true };
            let settings = code_and_settings(&pty);
            (0..10).all(|_| {
                let errors = || pty.written().matches("donut: ").count();
                let before = errors();
                type_line(&pty, "(STILL &)");
                pty.wait_for("an error", |_| errors() > before);
                code_and_settings(&pty) == settings
            })
        };
        assert!((0..3).any(keeps_settings));
    });
}

/// (On a busy machine, the handler of a signal may be late, so one success in ten tries is enough.)
#[test]
fn after_ctrl_z_and_fg_donut_enters_the_terminal_only_once() {
    assert!((0..10).any(|_| {
        let Some(pty) = run_as_job("bash", "STILL") else { return true };
        "picture '^Z' stopped fg frames".split(' ').for_each(|name| step(&pty, name));
        enter_count(&pty) == 2
    }));
}

/// The donut waits for a key when it is stopped. After `bg`, it must not read what is typed for the shell,
/// because the system would stop it for that, and once more after each `kill`.
#[test]
fn the_first_kill_ends_a_donut_that_was_stopped_while_it_waited_for_a_key() {
    run_scenarios(
        &"bash | ONCE | picture drawn STOP stopped bg kill end says=Terminated shell\n".repeat(24),
    );
}

#[test]
fn donut_takes_little_processor_time() {
    // While it spins, while it is paused, and where it does not draw on the terminal.
    let cases = [
        ("DONUT < /dev/null; true", &b""[..]),
        ("DONUT; true", b"p"),
        ("DONUT > /dev/null; true", b""),
    ];
    side_by_side(&cases, |&(line, keys)| {
        let pty = run_in_sh(line);
        pty.wait_for("the start", |pty| pty.job().is_some());
        sleep(Duration::from_millis(100));
        pty.type_bytes(keys);
        sleep(Duration::from_millis(500));
        // In hundredths of a second, of the user and of the system.
        let times = &stat(pty.job().expect("a job")).unwrap()[11..13];
        let ticks = times.iter().map(|time| time.parse::<u32>().unwrap());
        assert!(ticks.sum::<u32>() < 10);
    });
}
