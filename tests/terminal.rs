//! The donut on a pseudo-terminal: what is on the screen, and how the terminal is left.
//!
//! A pseudo-terminal is a terminal without a screen or a keyboard. `pty/mod.rs` makes them, and keeps
//! the screen that a person would see. Some tests run the donut in a shell there, with job control:
//! Ctrl-Z, `fg`, `bg` and `&`. A shell calls the processes of one command a job.
#![cfg(unix)]

mod pty;

use std::fs::File;
use std::io::Write;
use std::process::Command;
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

use pty::Pty;
use rustix::process::{Pid, Signal, kill_process};
use rustix::termios::{Action, InputModes, OptionalActions, tcflow, tcgetattr, tcsetattr};

const DONUT: &str = env!("CARGO_BIN_EXE_donut");
/// Options for a donut that stands still, so that every frame is the same picture.
const STILL: [&str; 3] = ["-A=1", "-B=0.5", "--spin=0,0"];

fn donut(options: &[&str], size: (u16, u16)) -> Pty {
    Pty::run(DONUT, options, size, "xterm-256color")
}

/// Runs a still donut, and waits until it is on the screen.
#[track_caller]
fn still_donut(size: (u16, u16)) -> Pty {
    let pty = donut(&STILL, size);
    pty.wait_for("the picture", |pty| pty.lines() == picture(size, size));
    pty
}

/// The lines of a screen with the still donut on it. The donut is as large as it would be on a screen
/// of the size `fitted_to`, where two rows stay free.
fn picture(screen: (u16, u16), fitted_to: (u16, u16)) -> Vec<String> {
    last_picture(&[&STILL[..], &["--frames=1"]].concat(), screen, fitted_to)
}

/// The same for the last frame that is drawn with these options.
fn last_picture(
    options: &[&str],
    (columns, rows): (u16, u16),
    (width, height): (u16, u16),
) -> Vec<String> {
    let size =
        [format!("--width={width}"), format!("--height={}", height.saturating_sub(2).max(1))];
    let output = Command::new(DONUT).args(options).args(size).arg("--fps=0").output().unwrap();
    let stream = String::from_utf8(output.stdout).unwrap();
    let frame = stream.rsplit("\x1b[H").next().unwrap();
    let mut lines: Vec<_> = frame.lines().map(|line| line.trim_end().to_string()).collect();
    assert!(lines.iter().all(|line| line.len() < columns.into()));
    lines.resize(rows.into(), String::new());
    lines
}

/// How many frames have been written so far.
fn frames(pty: &Pty) -> usize {
    pty.written().matches("\x1b[?2026l").count()
}

/// Presses q, and waits for the donut to end.
#[track_caller]
fn assert_quits(pty: &mut Pty) {
    pty.type_bytes(b"q");
    assert_eq!(pty.exit(), 0);
}

#[test]
fn the_picture_fits_the_screen_at_every_size() {
    for size in [(80, 24), (120, 40), (200, 50), (20, 6), (3, 4), (2, 3)] {
        let mut pty = still_donut(size);
        pty.wait_for("some frames", |pty| frames(pty) > 5);
        assert_eq!(pty.lines(), picture(size, size));
        assert_quits(&mut pty);
    }
}

#[test]
fn it_has_the_alternate_screen_no_cursor_no_background_and_clears_once() {
    let pty = still_donut((80, 24));
    pty.wait_for("some frames", |pty| frames(pty) > 5);
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
fn every_frame_is_a_synchronized_update() {
    let mut pty = still_donut((80, 24));
    pty.wait_for("some frames", |pty| frames(pty) > 5);
    pty.type_bytes(b"q");
    pty.exit();
    let written = pty.written();
    let (_, updates) = written.split_once("\x1b[?2026h").unwrap();
    for update in updates.split("\x1b[?2026h") {
        let (frame, rest) = update.split_once("\x1b[?2026l").expect("an end");
        assert!(frame.starts_with("\x1b[H\r\n") && frame.matches("\r\n").count() == 22);
        // Between two updates nothing is written. What follows the last one restores the terminal.
        assert!(rest.is_empty() || rest.contains("\x1b[?25h"), "{rest:?}");
    }
}

#[test]
fn q_escape_ctrl_c_and_ctrl_backslash_end_it_and_restore_the_terminal() {
    // The last two are Ctrl-C and Ctrl-\. They send signals, which a shell reports as 130 and 131.
    for (key, code) in [(&b"q"[..], 0), (b"\x1b", 0), (b"\x03", 130), (b"\x1c", 131)] {
        for fps in ["--fps=30", "--fps=1e-300", "--fps=0"] {
            let mut pty = donut(&[fps], (80, 24));
            pty.wait_for("a frame", |pty| frames(pty) > 0);
            pty.type_bytes(key);
            assert_eq!(pty.exit(), code, "{key:?} {fps}");
            pty.assert_restored();
        }
    }
}

#[test]
fn drawing_again_neither_turns_the_donut_nor_counts_as_a_frame() {
    // The second frame is due after a hundred seconds, so the donut has to stand still.
    let mut pty = donut(&["-A=1", "-B=0.5", "--fps=0.01"], (80, 24));
    pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
    for _ in 0..3 {
        let now = frames(&pty);
        pty.type_bytes(b" ");
        pty.wait_for("dots", |pty| frames(pty) > now);
        pty.type_bytes(b" ");
        pty.wait_for("the same picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
        pty.resize((90, 30));
        pty.wait_for("the picture", |pty| pty.lines() == picture((90, 30), (90, 30)));
        pty.signal("CONT");
        pty.resize((80, 24));
        pty.wait_for("the same picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
    }
    assert_quits(&mut pty);

    let options = ["--frames=3", "--fps=1"];
    let mut pty = donut(&options, (80, 24));
    for _ in 0..4 {
        let now = frames(&pty);
        pty.type_bytes(b"  ");
        pty.wait_for("a frame", |pty| frames(pty) > now);
    }
    assert_eq!(pty.exit(), 0);
    assert_eq!(pty.lines(), last_picture(&options, (80, 24), (80, 24)));
}

#[test]
fn a_new_size_is_seen_before_the_next_frame_but_one() {
    let mut pty = donut(&["--spin=0,0", "-A=1", "-B=0.5", "--fps=2"], (80, 24));
    pty.wait_for("some frames", |pty| frames(pty) > 1);
    pty.resize((100, 30));
    let now = frames(&pty);
    pty.wait_for("the new size", |pty| pty.lines() == picture((100, 30), (100, 30)));
    // One frame of the old size may have been on its way, and the other one is the first of the new
    // size.
    assert!(frames(&pty) <= now + 2, "{} frames", frames(&pty) - now);
    assert_quits(&mut pty);
}

#[test]
fn no_picture_is_larger_than_4096x4096() {
    for (options, rows, columns) in [("--height=3", 3, 4095), ("--width=3", 4096, 2)] {
        let command = format!("stty rows 65535 cols 65535; exec {DONUT} --frames=1 {options}");
        let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        assert_eq!(pty.exit(), 0);
        let written = pty.written();
        let (_, frame) = written.split_once("\x1b[?2026h\x1b[H").unwrap();
        let (frame, _) = frame.split_once("\x1b[?2026l").unwrap();
        let lengths: Vec<_> = frame.split("\r\n").skip(1).map(str::len).collect();
        assert_eq!(lengths, vec![columns; rows], "{options}");
    }
}

#[test]
fn p_pauses_and_resumes() {
    let mut pty = donut(&[], (80, 24));
    pty.wait_for("some frames", |pty| frames(pty) > 5);
    pty.type_bytes(b"p");
    sleep(Duration::from_millis(500));
    let paused = frames(&pty);
    sleep(Duration::from_millis(500));
    assert_eq!(frames(&pty), paused);
    pty.resize((100, 30));
    pty.wait_for("the paused picture at the new size", |pty| frames(pty) > paused);
    let resized = frames(&pty);
    pty.type_bytes(b"p");
    pty.wait_for("more frames", |pty| frames(pty) > resized + 5);
    pty.type_bytes(b"pq");
    assert_eq!(pty.exit(), 0);
}

#[test]
fn space_switches_the_shading_off_and_on() {
    let mut pty = still_donut((80, 24));
    let flat: Vec<String> = picture((80, 24), (80, 24))
        .iter()
        .map(|line| line.chars().map(|c| if c == ' ' { ' ' } else { '.' }).collect())
        .collect();
    pty.type_bytes(b" ");
    pty.wait_for("dots", |pty| pty.lines() == flat);
    pty.type_bytes(b" ");
    pty.wait_for("shades", |pty| pty.lines() == picture((80, 24), (80, 24)));
}

#[test]
fn other_keys_do_nothing_and_are_not_echoed_however_fast_they_come() {
    let mut pty = still_donut((80, 24));
    let mut bytes = b"abcQP\r\n\t\x7f\x01\x1b[A\x1bOP\x1b[5~\x1b[<0;10;10M\xff\xfe\xc3(".repeat(50);
    bytes.extend(b"wide open spaces".repeat(500).iter().filter(|byte| !b" pq".contains(byte)));
    bytes.extend(b"\x1b[<35;40;12M".repeat(500));
    pty.type_bytes(&bytes);
    let now = frames(&pty);
    pty.wait_for("more frames", |pty| frames(pty) > now + 10);
    assert_eq!(pty.lines(), picture((80, 24), (80, 24)));
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
    for code in [
        "\x1b[A",
        "\x1bOq",
        "\x1bq",
        "\x1b[?",
        "\x1b[?2026;2$y",
        "\x1b[?997;1n",
        "\x1bP>|a terminal q p\x1b\\",
        "\x1b]11;rgb:0000/0000/0000\x07",
    ] {
        let (one, two) = (code.split_at(1), code.split_at(2));
        for pieces in [&[code][..], &[one.0, one.1], &[two.0, two.1], &[one.0, &code[1..2], two.1]]
        {
            let mut pty = still_donut((80, 24));
            // A resize keeps the loop busy, so that the pieces meet it at different points.
            pty.resize((90, 30));
            while !type_in_pieces(&mut pty, pieces) {
                pty = still_donut((90, 30));
            }
            sleep(Duration::from_millis(150));
            let now = frames(&pty);
            pty.wait_for("more frames", |pty| frames(pty) > now + 1);
            assert_eq!(pty.lines(), picture((90, 30), (90, 30)), "{pieces:?}");
            assert_quits(&mut pty);
        }
    }
}

#[test]
fn q_is_obeyed_wherever_it_stands_in_a_paste() {
    for keys in [&b"qx"[..], b"xq", b"  q", b"ppq"] {
        let mut pty = still_donut((80, 24));
        pty.type_bytes(keys);
        assert_eq!(pty.exit(), 0, "{keys:?}");
    }
}

#[test]
fn escape_ends_it_when_it_is_held_down_or_pressed_again() {
    for keys in [&b"\x1b\x1b"[..], b"\x1b\x1b\x1b\x1b", b"x\x1b"] {
        let mut pty = still_donut((80, 24));
        pty.type_bytes(keys);
        assert_eq!(pty.exit(), 0, "{keys:?}");
    }
    let mut pty = still_donut((80, 24));
    // A key that is held down repeats about thirty times a second.
    for _ in 0..10 {
        pty.type_bytes(b"\x1b");
        sleep(Duration::from_millis(33));
    }
    assert_eq!(pty.exit(), 0);
}

#[test]
fn an_escape_before_a_resize_is_not_lost() {
    let mut pty = still_donut((80, 24));
    pty.type_bytes(b"\x1b");
    pty.resize((100, 30));
    assert_eq!(pty.exit(), 0);
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
    pty.resize((100, 30));
    pty.wait_for("the last picture", |pty| pty.lines() == picture((100, 30), (100, 30)));
    assert!(pty.screen(|screen| (0..30).all(|row| !screen.row_wrapped(row))));
    assert_quits(&mut pty);
    pty.assert_restored();
}

#[test]
fn sizes_without_room_for_a_donut_are_survived() {
    for size in [(1, 1), (1, 24), (80, 1), (80, 2)] {
        let mut pty = donut(&["--fps=0"], size);
        pty.wait_for("some frames", |pty| frames(pty) > 20);
        assert!(pty.lines().iter().all(String::is_empty));
        assert_quits(&mut pty);
    }
}

#[test]
fn a_terminal_that_does_not_know_its_size_is_taken_for_80x24() {
    for size in [(0, 0), (80, 0), (0, 24)] {
        let pty = donut(&STILL, size);
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        // A newline takes the place of the first of the 80 columns.
        let written = pty.written();
        let frame = written.split("\x1b[?2026h\x1b[H").nth(1).unwrap();
        let frame = frame.split("\x1b[?2026l").next().unwrap();
        let rows: Vec<_> = frame.split("\r\n").skip(1).map(str::len).collect();
        assert_eq!(rows, [79; 22], "{size:?}");
    }
}

#[test]
fn a_size_that_is_given_stays_and_is_clipped_to_the_screen() {
    let options = [&STILL[..], &["--width=60", "--height=20"]].concat();
    let pty = donut(&options, (80, 24));
    pty.wait_for("60x20", |pty| pty.lines() == picture((80, 24), (60, 22)));
    pty.scribble();
    pty.resize((120, 40));
    pty.wait_for("60x20 again", |pty| pty.lines() == picture((120, 40), (60, 22)));
    pty.resize((30, 10));
    pty.wait_for("30x8", |pty| pty.lines() == picture((30, 10), (30, 10)));
}

#[test]
fn it_ends_by_the_signal_that_came_but_restores_the_terminal_first() {
    for (signal, code) in [("HUP", 129), ("INT", 130), ("QUIT", 131), ("TERM", 143)] {
        let mut pty = donut(&["--fps=0.01"], (80, 24));
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        pty.signal(signal);
        assert_eq!(pty.exit(), code, "{signal}");
        pty.assert_restored();
    }
}

#[test]
fn a_signal_at_the_start_ends_it_however_early_it_comes() {
    // The handlers are set up one after another. The first one does not know which signal has come, and
    // takes it for Ctrl-C's.
    let codes = [130, 143];
    for n in 0..400 {
        let mut pty = Pty::run(DONUT, &[], (80, 24), "xterm");
        sleep(Duration::from_micros(15 * n));
        let process = Pid::from_raw(pty.process() as i32).unwrap();
        kill_process(process, Signal::TERM).unwrap();
        let code = pty.exit_code();
        assert!(codes.contains(&code), "{code}");
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
            pty.wait_for("a frame", |pty| frames(pty) > 0);
            pty.type_bytes(b"\x03");
            // The shell only reads this line when the command above has ended.
            sleep(Duration::from_millis(300));
            type_line(&mut pty, "exit 5");
            assert_eq!(pty.exit(), 5, "{shell}: {command}");
            assert!(!pty.lines().contains(&"next".to_string()));
            pty.assert_settings_restored();
        }
    }
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

#[test]
fn the_prompt_is_below_the_picture_where_there_is_no_alternate_screen() {
    let mut pty = still_donut((80, 24));
    assert_quits(&mut pty);
    let written = pty.written();
    // As on the Linux console, or in GNU screen with its default settings.
    let (rows, columns) = (24.try_into().unwrap(), 80.try_into().unwrap());
    let mut console = vt100::Parser::new(rows, columns, 0);
    console.process(written.replace("\x1b[?1049h", "").replace("\x1b[?1049l", "").as_bytes());
    assert_eq!(console.screen().cursor_position(), (23, 0));
    let lines = console.screen().rows(0, 80).map(|row| row.trim_end().to_string());
    assert_eq!(lines.collect::<Vec<_>>(), picture((80, 24), (80, 24)));
}

/// Types a line into a shell.
fn type_line(pty: &mut Pty, line: &str) {
    pty.type_bytes(format!("{line}\n").as_bytes());
}

/// Runs a still donut in a shell, and waits until it is on the screen.
#[track_caller]
fn donut_in_a_shell(shell: &str) -> Pty {
    let mut pty = Pty::shell(shell, (80, 24));
    type_line(&mut pty, &format!("{DONUT} {}", STILL.join(" ")));
    pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
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

/// Waits for the end of the job, and asks the shell for its exit code.
#[track_caller]
fn assert_code(pty: &mut Pty, code: u32) {
    pty.wait_for("its end", |pty| pty.job().is_none());
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
            pty.wait_for("the picture", |pty| pty.lines() == picture((90, 30), (90, 30)));
            assert!(pty.screen(|screen| screen.alternate_screen() && screen.hide_cursor()));
        }
        pty.type_bytes(b"q");
        assert_code(&mut pty, 0);
    }
}

#[test]
fn ctrl_z_gives_back_the_settings_of_the_terminal() {
    // After the stop, cat has the terminal. It leaves the settings as they are.
    let mut pty = Pty::run("sh", &["-c", &format!("set -m; {DONUT}; exec cat")], (80, 24), "xterm");
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    pty.type_bytes(b"\x1a");
    pty.wait_for("the stop", |pty| pty.is_stopped());
    sleep(Duration::from_millis(100));
    pty.assert_restored();
    pty.signal_job("KILL");
}

/// Ctrl-Z stops a whole job: the donut, and the script or subshell that it is in. As soon as the script
/// has stopped, the shell writes its prompt. If the donut were still on the alternate screen at that
/// time, the prompt would vanish with that screen.
#[test]
fn after_ctrl_z_under_a_script_or_in_a_subshell_the_prompt_can_be_read() {
    for shell in ["bash", "dash"].into_iter().filter(|shell| is_installed(shell)) {
        let still = format!("{DONUT} {}", STILL.join(" "));
        for command in [format!("sh -c '{still}; exit 5'"), format!("({still}; exit 5)")] {
            let mut pty = Pty::shell(shell, (80, 24));
            type_line(&mut pty, &command);
            for _ in 0..3 {
                pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
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
            pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
            pty.type_bytes(b"q");
            assert_code(&mut pty, 5);
            assert!(pty.lines().contains(&"42".to_string()), "{:?}", pty.lines());
        }
    }
}

#[test]
fn ctrl_z_stops_it_once_whatever_keys_are_typed_with_it() {
    for keys in [&b"\x1a\x1a"[..], b"x\x1a", b"  \x1a", b"\x1aq", b"pp\x1app"] {
        let mut pty = donut_in_a_shell("bash");
        pty.type_bytes(keys);
        wait_for_the_stop(&pty);
        let now = frames(&pty);
        type_line(&mut pty, "fg");
        pty.wait_for("many frames", |pty| frames(pty) > now + 20);
        assert!(!pty.is_stopped(), "{keys:?}");
    }
}

/// The job in this test is a shell, and the donut is a child of it. If only the donut is stopped, bash
/// does not notice. So the key and the signal are both there when the donut goes on.
///
/// The donut has two threads. If it is the other thread that gets the signal, the loop may read the key
/// a moment earlier, and Ctrl-Z is obeyed. So this test tries up to ten times, and one success is
/// enough: a loop that reads its keys before it looks for signals never succeeds.
#[test]
fn a_signal_that_comes_with_a_ctrl_z_ends_it() {
    for _ in 0..10 {
        let mut pty = Pty::shell("bash", (80, 24));
        type_line(&mut pty, &format!("sh -c '{DONUT}; exit $?'"));
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        let job = pty.job().unwrap();
        let signal_donut = |signal| {
            let status = Command::new("pkill").args([signal, "-P", &job]).status();
            assert!(status.unwrap().success());
        };
        signal_donut("-STOP");
        pty.type_bytes(b"\x1a");
        signal_donut("-TERM");
        sleep(Duration::from_millis(100));
        signal_donut("-CONT");
        pty.wait_for("its end or stop", |pty| pty.job().is_none() || pty.is_stopped());
        if pty.job().is_none() {
            assert_code(&mut pty, 143);
            return;
        }
    }
    panic!("Ctrl-Z has stopped it each time");
}

#[test]
fn ctrl_z_does_nothing_where_no_shell_could_continue_it() {
    let command = format!("{DONUT}; exit $?");
    for (program, arguments) in [(DONUT, &[][..]), ("sh", &["-c", &command])] {
        let mut pty = Pty::run(program, arguments, (80, 24), "xterm");
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        pty.type_bytes(b"\x1a");
        sleep(Duration::from_millis(300));
        let now = frames(&pty);
        pty.wait_for("more frames", |pty| frames(pty) > now + 5);
        assert!(pty.screen(|screen| screen.alternate_screen()));
        assert_quits(&mut pty);
    }
}

#[cfg(target_os = "linux")]
#[test]
fn in_a_pid_namespace_ctrl_z_stops_it_unless_it_is_the_first_process() {
    let unshare = "unshare --user --map-root-user --pid --fork";
    if !is_allowed(&format!("{unshare} true")) {
        return;
    }
    // Here the donut is the first process of its namespace, and signals do not stop that process.
    let mut pty = Pty::shell("bash", (80, 24));
    type_line(&mut pty, &format!("{unshare} {DONUT}"));
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    pty.type_bytes(b"\x1a");
    sleep(Duration::from_millis(300));
    let now = frames(&pty);
    pty.wait_for("more frames", |pty| frames(pty) > now + 5);
    pty.type_bytes(b"\x03");
    assert_code(&mut pty, 130);
    // Here it is not the first process. The shell that continues it is outside of the namespace in the
    // first case, and inside in the second.
    let shells = [format!("sh -c '{DONUT}; exit 5'"), "bash --norc -i".to_string()];
    for (shell, command) in shells.iter().zip(["", DONUT]) {
        let mut pty = Pty::shell("bash", (80, 24));
        type_line(&mut pty, &format!("{unshare} {shell}"));
        type_line(&mut pty, command);
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        for _ in 0..2 {
            pty.type_bytes(b"\x1a");
            pty.wait_for("the shell", |pty| {
                pty.lines().iter().any(|line| line.contains("Stopped"))
                    && pty.screen(|screen| !screen.alternate_screen() && !screen.hide_cursor())
            });
            sleep(Duration::from_millis(300));
            let now = frames(&pty);
            sleep(Duration::from_millis(300));
            assert_eq!(frames(&pty), now, "{shell}");
            type_line(&mut pty, "fg");
            pty.wait_for("more frames", |pty| frames(pty) > now + 2);
        }
        pty.type_bytes(b"q");
        if !command.is_empty() {
            sleep(Duration::from_millis(300));
            type_line(&mut pty, "exit 5");
        }
        assert_code(&mut pty, 5);
    }
}

#[test]
fn a_stopped_donut_takes_the_terminal_again_whoever_stopped_it() {
    for (shell, signal, lines) in [
        ("bash", "STOP", &["fg"][..]),
        ("bash", "TSTP", &["fg"]),
        ("bash", "STOP", &["bg", "fg"]),
        ("dash", "STOP", &["bg", "fg"]),
        ("dash", "TSTP", &["bg", "fg"]),
    ] {
        if !is_installed(shell) {
            continue;
        }
        let mut pty = donut_in_a_shell(shell);
        pty.signal_job(signal);
        pty.wait_for("the stop", Pty::is_stopped);
        pty.wait_for("the shell", |pty| pty.written().contains("Stopped"));
        for line in lines {
            type_line(&mut pty, line);
            sleep(Duration::from_millis(300));
        }
        pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
        // The settings are the donut's again: the key is read without a newline, and not echoed.
        pty.type_bytes(b"q");
        assert_code(&mut pty, 0);
        assert!(!pty.lines().iter().any(|line| line.starts_with('q')), "{:?}", pty.lines());
        // Where a stopped job has changed the settings, dash leaves them as they are, so the donut has
        // to remember the ones from before. bash changes the settings for its prompt, so there they
        // cannot be compared.
        if shell == "dash" {
            pty.assert_settings_restored();
        }
    }
}

#[test]
fn in_the_background_it_waits_for_the_foreground_and_draws_nothing() {
    let other = Pty::run("sleep", &["100"], (80, 24), "xterm");
    for input in ["", "< /dev/null", &format!("< {}", other.path())] {
        let mut pty = Pty::shell("bash", (80, 24));
        type_line(&mut pty, &format!("{DONUT} {} {input} &", STILL.join(" ")));
        pty.wait_for("the job", |pty| pty.job().is_some());
        sleep(Duration::from_millis(500));
        assert!(!pty.is_stopped());
        assert_eq!(frames(&pty), 0, "{input}");
        assert!(!pty.written().contains("\x1b[?1049h"));
        type_line(&mut pty, "fg");
        pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
        pty.type_bytes(b"q");
        assert_code(&mut pty, 0);
    }
}

#[test]
fn a_background_donut_can_be_killed_and_leaves_the_screen_to_the_shell() {
    type Step = fn(&mut Pty);
    fn ctrl_z(pty: &mut Pty) {
        pty.type_bytes(b"\x1a");
        wait_for_the_stop(pty);
    }
    // Alt-[ sends the first half of an arrow key's code, and the other half never comes.
    let half_a_key: Step = |pty| {
        pty.type_bytes(b"\x1b[");
        sleep(Duration::from_millis(100));
        ctrl_z(pty);
    };
    let stop: Step = |pty| {
        pty.signal_job("STOP");
        pty.wait_for("the stop", Pty::is_stopped);
        pty.wait_for("the shell", |pty| pty.written().contains("Stopped"));
    };
    let bg: Step = |pty| {
        type_line(pty, "bg");
        pty.wait_for("the continuation", |pty| !pty.is_stopped());
        sleep(Duration::from_millis(300));
        assert!(!pty.is_stopped() && !pty.screen(|screen| screen.alternate_screen()));
    };
    let kill: Step = |pty| type_line(pty, "kill %1");
    let hang_up: Step = |pty| type_line(pty, "kill -HUP %1");
    let typed_ahead: Step = |pty| type_line(pty, "bg\nkill %1");
    let start: Step = |pty| {
        type_line(pty, &format!("{DONUT} {}", STILL.join(" ")));
        pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
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
    for steps in [
        &[start, ctrl_z, kill][..],
        &[start, ctrl_z, hang_up],
        &[start, ctrl_z, bg, kill],
        &[start, ctrl_z, typed_ahead],
        &[start, half_a_key, bg, kill],
        &[start, stop, kill],
        &[start, stop, bg, kill],
        &[start_in_background, kill],
        &[start_in_background, hang_up],
    ] {
        let mut pty = Pty::shell("bash", (80, 24));
        steps.iter().for_each(|step| step(&mut pty));
        pty.wait_for("its end", |pty| pty.job().is_none());
        // bash reports how a job has ended, at the latest when another job ends as well.
        type_line(&mut pty, "(:)");
        let ends = ["Terminated", "Hangup"];
        pty.wait_for("its signal", |pty| ends.iter().any(|end| pty.written().contains(end)));
        assert!(pty.screen(|screen| !screen.alternate_screen() && !screen.hide_cursor()));
    }
}

#[cfg(target_os = "linux")]
#[test]
fn timeout_ends_it_in_the_foreground_and_in_the_background() {
    let mut pty = Pty::shell("bash", (80, 24));
    type_line(&mut pty, &format!("timeout 1 {DONUT}"));
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    assert_code(&mut pty, 124);
    // timeout makes the donut a job of its own. Where there is no job control, nothing puts this job
    // into the foreground.
    let command = format!("timeout 1 {DONUT}; exit $?");
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    assert_eq!(pty.exit(), 124);
    assert_eq!(pty.written(), "");
    pty.assert_settings_restored();
}

#[test]
fn it_ends_when_the_terminal_goes_even_without_sighup() {
    // When the terminal goes, the first process of its session gets a SIGHUP. With this command, that is
    // the shell, which ignores the signal. So the donut gets none.
    let ignoring_sighup = |options| format!("trap '' HUP; {DONUT} {options}; exit $?");
    for (command, key) in [
        (format!("exec {DONUT} --fps=5"), &b"x"[..]),
        (format!("exec {DONUT} --fps=0.01"), b"x"),
        (format!("exec {DONUT}"), b"p"),
        (ignoring_sighup("--fps=5"), b"x"),
        (ignoring_sighup("--fps=0.01"), b"x"),
        (ignoring_sighup(""), b"p"),
        (ignoring_sighup("--fps=0.01 < /dev/null"), b""),
    ] {
        let mut pty = Pty::run_unread("sh", &["-c", &command], (80, 24), "xterm");
        pty.read_until(|pty| frames(pty) > 0);
        pty.type_bytes(key);
        sleep(Duration::from_millis(300));
        pty.hang_up();
        // After `exec`, the donut itself is the first process, and gets a SIGHUP. But it may notice
        // first that the terminal is gone.
        let code = pty.exit();
        assert!(code == 1 || (code == 129 && command.starts_with("exec")), "{code}: {command}");
    }
}

/// A donut on a terminal that reads nothing, once it has written as much as the terminal holds.
fn stuck_donut(size: (u16, u16)) -> Pty {
    let pty = Pty::run_unread(DONUT, &["--fps=0", "--color=red"], size, "xterm");
    pty.wait_for("the start", Pty::has_changed_settings);
    sleep(Duration::from_millis(300));
    pty
}

#[test]
fn on_a_terminal_that_reads_nothing_signals_end_it_and_restore() {
    for size in [(80, 24), (2000, 1000)] {
        let signals = [("HUP", 129), ("INT", 130), ("QUIT", 131), ("TERM", 143)];
        let mut ptys = signals.map(|(signal, code)| (stuck_donut(size), signal, code));
        for (pty, signal, _) in &mut ptys {
            match *signal {
                "INT" => pty.type_bytes(b"\x03"),
                signal => pty.signal(signal),
            }
        }
        for (mut pty, signal, code) in ptys {
            assert_eq!(pty.exit(), code, "{signal} {size:?}");
            pty.read(1 << 16, Duration::ZERO);
            pty.wait_for("the end", |pty| pty.written().ends_with("\x1b[?1049l"));
            pty.assert_restored();
        }
    }
}

#[test]
fn where_somebody_has_stopped_the_output_a_signal_ends_it_and_restores() {
    // Output that a program has stopped and output that a key has stopped go on in different ways. And
    // the signal may come in the middle of a frame, or long after a whole one.
    for (by_key, fps) in [(false, "0"), (true, "0"), (false, "0.01"), (true, "0.01")] {
        let mut pty = donut(&["--fps", fps], (80, 24));
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        let terminal = File::open(pty.path()).unwrap();
        if by_key {
            // In raw mode Ctrl-S is a key like any other, unless a program changes this setting.
            let mut settings = tcgetattr(&terminal).unwrap();
            settings.input_modes.insert(InputModes::IXON);
            tcsetattr(&terminal, OptionalActions::Now, &settings).unwrap();
            pty.type_bytes(b"\x13");
        } else {
            tcflow(&terminal, Action::OOff).unwrap();
        }
        sleep(Duration::from_millis(300));
        let now = frames(&pty);
        sleep(Duration::from_millis(300));
        assert_eq!(frames(&pty), now);
        pty.signal("TERM");
        assert_eq!(pty.exit(), 143);
        pty.assert_restored();
    }
}

#[test]
fn a_signal_restores_the_terminal_even_while_another_program_writes_there() {
    for _ in 0..5 {
        let mut pty = still_donut((80, 24));
        let mut terminal = File::options().write(true).open(pty.path()).unwrap();
        // Linux lets only one program write at a time, and a write that does not block then fails.
        let end = Instant::now() + Duration::from_millis(500);
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
fn in_the_background_of_a_terminal_that_reads_nothing_signals_end_it() {
    for signal in ["HUP", "INT", "QUIT", "TERM"] {
        let mut pty = Pty::run_unread("bash", &["--norc", "-i"], (80, 24), "xterm");
        type_line(&mut pty, &format!("{DONUT} --fps=0"));
        pty.wait_for("the job", |pty| pty.job().is_some());
        sleep(Duration::from_millis(500));
        pty.signal_job("STOP");
        pty.wait_for("the stop", Pty::is_stopped);
        sleep(Duration::from_millis(300));
        pty.signal_job("CONT");
        sleep(Duration::from_millis(300));
        pty.signal_job(signal);
        pty.wait_for("its end", |pty| pty.job().is_none());
    }
}

#[test]
fn a_terminal_that_reads_nothing_for_a_while_goes_on_afterwards() {
    let mut pty = Pty::run_unread(DONUT, &STILL, (200, 50), "xterm");
    pty.wait_for("the start", Pty::has_changed_settings);
    sleep(Duration::from_millis(1500));
    pty.signal("CONT");
    pty.type_bytes(b"x");
    sleep(Duration::from_millis(1500));
    pty.read(1 << 16, Duration::ZERO);
    pty.wait_for("the picture", |pty| pty.lines() == picture((200, 50), (200, 50)));
    assert_quits(&mut pty);
    pty.assert_restored();
}

#[test]
fn a_signal_ends_it_on_a_terminal_that_is_not_its_own_and_reads_nothing() {
    let shown = Pty::run_unread("sleep", &["100"], (200, 50), "xterm");
    let command = format!("exec {DONUT} --fps=0 > {}", shown.path());
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    pty.wait_for("the start", Pty::has_changed_settings);
    sleep(Duration::from_millis(300));
    pty.signal("TERM");
    assert_eq!(pty.exit(), 143);
    pty.assert_settings_restored();
    shown.read(1 << 16, Duration::ZERO);
    shown.wait_for("the end", |shown| shown.written().ends_with("\x1b[?1049l"));
}

#[test]
fn keys_and_signals_are_obeyed_on_a_terminal_that_reads_slowly() {
    let ends: [fn(&mut Pty); 2] = [|pty| pty.type_bytes(b"q"), |pty| pty.signal("TERM")];
    for (end, code) in ends.into_iter().zip([0, 143]) {
        // The terminal reads 5 kB a second, and a frame is 1.8 kB long.
        let mut pty = Pty::run_unread(DONUT, &[], (80, 24), "xterm");
        pty.read(200, Duration::from_millis(40));
        pty.wait_for("two frames", |pty| frames(pty) > 1);
        end(&mut pty);
        assert_eq!(pty.exit(), code);
        pty.wait_for("the end", |pty| pty.written().ends_with("\x1b[?1049l"));
        pty.assert_restored();
    }
}

#[test]
fn keys_and_resizes_in_the_middle_of_a_slow_frame_are_obeyed() {
    // The terminal reads 50 kB a second, and a frame is 10 kB long.
    let mut pty = Pty::run_unread(DONUT, &["--fps=0"], (200, 50), "xterm");
    pty.read(2000, Duration::from_millis(40));
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    for columns in 180..200 {
        pty.type_bytes(&b" ".repeat(20));
        pty.resize((columns, 50));
        sleep(Duration::from_millis(10));
    }
    assert_quits(&mut pty);
    pty.wait_for("the end", |pty| pty.written().ends_with("\x1b[?1049l"));
    pty.assert_restored();
}

#[test]
fn after_kill_9_a_shell_still_works() {
    for shell in ["dash", "bash"].into_iter().filter(|shell| is_installed(shell)) {
        let mut pty = donut_in_a_shell(shell);
        pty.signal_job("KILL");
        pty.wait_for("its end", |pty| pty.job().is_none());
        sleep(Duration::from_millis(300));
        type_line(&mut pty, "echo $((6 * 7))");
        pty.wait_for("the shell", |pty| pty.lines().iter().any(|line| line.contains("42")));
        assert!(pty.is_running());
    }
}

#[test]
fn a_q_that_comes_in_the_middle_of_a_long_frame_is_obeyed() {
    let mut pty = donut(&["--method=classic", "--aspect=3"], (4096, 1002));
    pty.wait_for("the start", |pty| pty.written().contains("\x1b[?25l"));
    assert_quits(&mut pty);
}

#[test]
fn the_picture_fits_the_terminal_that_it_is_drawn_on() {
    let shown = Pty::run("sleep", &["100"], (60, 20), "xterm");
    let command = format!("exec {DONUT} {} > {}", STILL.join(" "), shown.path());
    let mut pty = Pty::run("sh", &["-c", &command], (100, 30), "xterm");
    shown.wait_for("the picture", |shown| shown.lines() == picture((60, 20), (60, 20)));
    assert_quits(&mut pty);
    shown.assert_restored();
}

#[test]
fn losing_the_terminal_of_the_keys_restores_that_of_the_picture() {
    let shown = Pty::run("sleep", &["100"], (60, 20), "xterm");
    let command = format!("trap '' HUP; exec {DONUT} > {}", shown.path());
    let mut pty = Pty::run_unread("sh", &["-c", &command], (80, 24), "xterm");
    shown.wait_for("a frame", |shown| frames(shown) > 0);
    pty.hang_up();
    // After `exec`, the donut is the first process of its session, so it gets a SIGHUP. It handles the
    // signal, although the shell has ignored it. But it may notice first that the terminal is gone.
    assert!([1, 129].contains(&pty.exit()));
    shown.assert_restored();
}

#[test]
fn keys_come_from_the_terminal_whatever_standard_input_is() {
    for command in [
        "DONUT < /dev/null",
        "yes | DONUT",
        "yes | head -1 | while read line; do DONUT; done",
        "echo 1 | xargs DONUT --frames 1000 -A",
    ] {
        let donut = format!("{DONUT} {}", STILL[1..].join(" "));
        let still = if command.contains("-A") { donut } else { format!("{donut} {}", STILL[0]) };
        let mut pty = Pty::run("sh", &["-c", &command.replace("DONUT", &still)], (80, 24), "xterm");
        pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
        pty.type_bytes(b"abc\r\n");
        pty.resize((60, 20));
        pty.wait_for("the new size", |pty| pty.lines() == picture((60, 20), (60, 20)));
        assert_quits(&mut pty);
        pty.assert_restored();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn keys_come_from_standard_input_where_the_session_has_no_terminal() {
    let mut pty = Pty::shell("bash", (80, 24));
    // In a session of its own, the program cannot open /dev/tty.
    type_line(&mut pty, &format!("setsid --wait {DONUT} {}; echo code=$?", STILL.join(" ")));
    pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
    pty.type_bytes(b"abcq");
    pty.wait_for("exit code 0", |pty| pty.lines().contains(&"code=0".to_string()));
}

#[cfg(target_os = "linux")]
#[test]
fn a_terminal_whose_name_cannot_be_found_is_drawn_on() {
    let unshare = "unshare --user --map-root-user --mount";
    let hide_names = "mount -t tmpfs none /dev/pts";
    if !is_allowed(&format!("{unshare} {hide_names}")) {
        return;
    }
    let run = format!("{hide_names} && setsid -w {DONUT} --frames=1");
    let command = format!("{unshare} sh -c '{run}'; exit $?");
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    assert_eq!(pty.exit(), 0);
    assert!(frames(&pty) > 0);
}

#[cfg(target_os = "linux")]
#[test]
fn without_any_keys_it_still_obeys_signals() {
    use std::os::unix::process::ExitStatusExt;
    let shown = Pty::run("sleep", &["100"], (80, 24), "xterm");
    let command = format!("exec setsid {DONUT} < /dev/null > {}", shown.path());
    let mut donut = Command::new("sh").args(["-c", &command]).spawn().unwrap();
    let process = donut.id().to_string();
    shown.wait_for("a frame", |shown| frames(shown) > 0);
    pty::kill("CONT", &process);
    let enters = |shown: &Pty| shown.written().matches("\x1b[?1049h").count();
    shown.wait_for("another entering", |shown| enters(shown) == 2);
    let now = frames(&shown);
    shown.wait_for("more frames", |shown| frames(shown) > now + 5);
    assert_eq!(enters(&shown), 2);
    pty::kill("TERM", &process);
    assert_eq!(donut.wait().unwrap().signal(), Some(15));
    shown.wait_for("the end", |shown| shown.written().ends_with("\x1b[?1049l"));
    shown.assert_restored();
}

#[cfg(target_os = "linux")]
#[test]
fn it_takes_little_processor_time_whatever_standard_input_is_and_in_the_background() {
    // The last command runs the donut in the background, where it waits.
    for (command, draws) in [
        (format!("{DONUT} < /dev/null; true"), true),
        (format!("true | {DONUT}"), true),
        (format!("set -m; {DONUT} & wait"), false),
    ] {
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        pty.wait_for("the start", |pty| frames(pty) > 0 || !draws && pty.job().is_some());
        sleep(Duration::from_secs(1));
        let process = pty.job().expect("a job");
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
        // User and system time, in hundredths of a second.
        let ticks: u32 = stat.split(' ').skip(13).take(2).map(|n| n.parse::<u32>().unwrap()).sum();
        assert!(ticks < 20, "{ticks} ticks: {command}");
    }
}

#[test]
fn with_frames_it_draws_in_place_and_the_last_picture_stays() {
    let options = [&STILL[..], &["--frames=5"]].concat();
    let mut pty = donut(&options, (80, 24));
    assert_eq!(pty.exit(), 0);
    assert!(!pty.written().contains("\x1b[?1049h"));
    assert_eq!(pty.lines(), picture((80, 24), (80, 24)));
    // The shell's prompt comes below the picture.
    assert_eq!(pty.screen(vt100::Screen::cursor_position), (23, 0));
    pty.assert_restored();
}

#[test]
fn a_dumb_terminal_gets_one_still_frame_without_an_escape() {
    let options = [&STILL[..], &["--color=red"]].concat();
    let mut pty = Pty::run(DONUT, &options, (80, 24), "dumb");
    assert_eq!(pty.exit(), 0);
    assert!(!pty.written().contains('\x1b'));
    assert_eq!(pty.lines(), picture((80, 24), (80, 24)));
}

#[test]
fn with_frames_0_nothing_is_written_to_any_terminal() {
    for term in ["dumb", "xterm"] {
        let mut pty = Pty::run(DONUT, &["--frames=0"], (80, 24), term);
        assert_eq!(pty.exit(), 0);
        assert_eq!(pty.written(), "");
    }
}

#[test]
fn a_colour_is_one_sequence_a_frame_whatever_the_variable_no_color_says() {
    for (color, expected) in [
        ("red", vt100::Color::Idx(9)),
        ("208", vt100::Color::Idx(208)),
        ("#123456", vt100::Color::Rgb(0x12, 0x34, 0x56)),
    ] {
        let command = format!("NO_COLOR=1 exec {DONUT} --color '{color}' -A 1 -B 0.5 --spin 0,0");
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
        assert_eq!(pty.screen(|screen| screen.cell(12, 30).unwrap().fgcolor()), expected);
        pty.wait_for("some frames", |pty| frames(pty) > 5);
        let written = pty.written();
        let last = written.rsplit("\x1b[?2026h").nth(1).unwrap();
        // The top left, the colour, the end of the update, and the end of the colour.
        assert_eq!(last.matches("\x1b[").count(), 4, "{last:?}");
    }
}

#[test]
fn a_q_typed_ahead_ends_it_before_the_first_frame() {
    let mut pty = Pty::shell("bash", (80, 24));
    pty.type_bytes(format!("sleep 0.5; {DONUT}; echo $((6 * 7))\nq").as_bytes());
    pty.wait_for("the shell", |pty| pty.lines().contains(&"42".to_string()));
    let written = pty.written();
    assert!(written.find("\x1b[?1049h") < written.find("\x1b[?1049l"));
    assert_eq!(written.matches("\x1b[?1049h").count(), 1);
    assert!(!written.contains("\x1b[?2026h"));
}
