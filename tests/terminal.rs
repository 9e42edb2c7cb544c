//! On a real pseudo-terminal: what is on the screen, and in what state it is left.
#![cfg(unix)]

mod pty;

use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

use pty::Pty;

const DONUT: &str = env!("CARGO_BIN_EXE_donut");
/// A donut that stands still, so that every frame is the same picture.
const STILL: [&str; 3] = ["-A=1", "-B=0.5", "--spin=0,0"];

fn donut(options: &[&str], size: (u16, u16)) -> Pty {
    Pty::run(DONUT, options, size, "xterm-256color")
}

/// A still donut, once it is on the screen.
#[track_caller]
fn still_donut(size: (u16, u16)) -> Pty {
    let pty = donut(&STILL, size);
    pty.wait_for("the picture", |pty| pty.lines() == picture(size, size));
    pty
}

/// The lines of a screen with the still donut of another size, or the same, on it.
fn picture((columns, rows): (u16, u16), (width, height): (u16, u16)) -> Vec<String> {
    let size =
        [format!("--width={width}"), format!("--height={}", height.saturating_sub(2).max(1))];
    let size = [&size[0][..], &size[1]];
    let output = Command::new(DONUT).args(STILL).args(size).arg("--frames=1").output().unwrap();
    let frame = String::from_utf8(output.stdout).unwrap().replace("\x1b[2J\x1b[H", "");
    let mut lines: Vec<_> = frame.lines().map(|line| line.trim_end().to_string()).collect();
    assert!(lines.iter().all(|line| line.len() < columns.into()));
    lines.resize(rows.into(), String::new());
    lines
}

/// Frames written so far.
fn frames(pty: &Pty) -> usize {
    pty.written().matches("\x1b[?2026l").count()
}

/// Presses q, which ends it.
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
        // Behind the last frame the terminal is given back.
        assert!(rest.is_empty() || rest.contains("\x1b[?25h"), "{rest:?}");
    }
}

#[test]
fn q_escape_ctrl_c_and_ctrl_backslash_quit_and_restore() {
    // The last two are Ctrl-C and Ctrl-\.
    for key in [&b"q"[..], b"\x1b", b"\x03", b"\x1c"] {
        for fps in ["--fps=30", "--fps=1e-300", "--fps=0"] {
            let mut pty = donut(&[fps], (80, 24));
            pty.wait_for("a frame", |pty| frames(pty) > 0);
            pty.type_bytes(key);
            assert_eq!(pty.exit(), 0, "{key:?} {fps}");
            pty.assert_restored();
        }
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

#[test]
fn an_arrow_key_that_comes_in_pieces_is_no_escape() {
    let goes_on = || {
        let mut pty = still_donut((80, 24));
        pty.type_bytes(b"\x1b");
        sleep(Duration::from_millis(5));
        pty.type_bytes(b"[A");
        sleep(Duration::from_millis(300));
        pty.is_running()
    };
    // A machine under load may take longer over the pieces than the donut waits for them.
    assert!((0..5).any(|_| goes_on()));
}

#[test]
fn half_of_a_keys_code_does_not_stop_the_picture() {
    let mut pty = still_donut((80, 24));
    // As Alt-[ is: an arrow key would go on.
    pty.type_bytes(b"\x1b[");
    sleep(Duration::from_millis(100));
    let now = frames(&pty);
    pty.wait_for("more frames", |pty| frames(pty) > now + 10);
}

#[test]
fn keys_in_one_paste_are_all_obeyed() {
    for keys in [&b"qx"[..], b"xq", b"  q", b"ppq"] {
        let mut pty = still_donut((80, 24));
        pty.type_bytes(keys);
        assert_eq!(pty.exit(), 0, "{keys:?}");
    }
}

#[test]
fn an_escape_before_a_resize_or_another_key_is_not_lost() {
    let mut pty = still_donut((80, 24));
    pty.type_bytes(b"\x1b");
    pty.resize((100, 30));
    assert_eq!(pty.exit(), 0);
    let quits = || {
        let mut pty = still_donut((80, 24));
        pty.type_bytes(b"\x1b");
        sleep(Duration::from_millis(5));
        pty.type_bytes(b"q");
        sleep(Duration::from_millis(500));
        !pty.is_running()
    };
    // On a machine under load both may be read at once, which is Alt-q.
    assert!((0..5).any(|_| quits()));
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
fn sizes_of_one_and_nothing_are_survived() {
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
        // Of a row of 80 columns the first is empty.
        let written = pty.written();
        let frame = written.split("\x1b[?2026h\x1b[H").nth(1).unwrap();
        let frame = frame.split("\x1b[?2026l").next().unwrap();
        let rows: Vec<_> = frame.split("\r\n").skip(1).map(str::len).collect();
        assert_eq!(rows, [79; 22].map(|_| 79), "{size:?}");
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
fn signals_end_it_and_restore() {
    for signal in ["TERM", "INT", "HUP", "QUIT"] {
        let mut pty = donut(&["--fps=0.01"], (80, 24));
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        pty.signal(signal);
        assert_eq!(pty.exit(), 0, "{signal}");
        pty.assert_restored();
    }
}

/// Types a line into a shell.
fn type_line(pty: &mut Pty, line: &str) {
    pty.type_bytes(format!("{line}\n").as_bytes());
}

/// A shell with a still donut that is on the screen.
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

/// Waits for the end of the job, and has the shell say its exit code.
#[track_caller]
fn assert_code(pty: &mut Pty, code: u32) {
    pty.wait_for("its end", |pty| pty.job().is_none());
    type_line(pty, "echo code=$?");
    let said = format!("code={code}");
    pty.wait_for(&said, |pty| pty.lines().contains(&said));
}

#[test]
fn ctrl_z_and_sigtstp_give_the_terminal_back_and_fg_redraws() {
    let stops = [|pty: &mut Pty| pty.type_bytes(b"\x1a"), |pty: &mut Pty| pty.signal_job("TSTP")];
    for (shell, stop) in ["sh", "bash"].iter().flat_map(|shell| stops.map(|stop| (shell, stop))) {
        let mut pty = donut_in_a_shell(shell);
        for _ in 0..2 {
            stop(&mut pty);
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
    let mut pty = Pty::run("sh", &["-c", &format!("set -m; {DONUT}; exec cat")], (80, 24), "xterm");
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    pty.type_bytes(b"\x1a");
    pty.wait_for("the stop", |pty| pty.is_stopped());
    sleep(Duration::from_millis(100));
    pty.assert_restored();
    pty.signal_job("KILL");
}

#[test]
fn ctrl_z_stops_the_whole_job() {
    let mut pty = Pty::shell("bash", (80, 24));
    type_line(&mut pty, &format!("sh -c '{DONUT}; true'"));
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    pty.type_bytes(b"\x1a");
    // The job that the shell knows is the other shell, and not the donut.
    wait_for_the_stop(&pty);
    let now = frames(&pty);
    type_line(&mut pty, "fg");
    pty.wait_for("more frames", |pty| frames(pty) > now);
    pty.type_bytes(b"q");
    assert_code(&mut pty, 0);
}

#[test]
fn two_ctrl_z_at_once_are_one() {
    let mut pty = donut_in_a_shell("bash");
    pty.type_bytes(b"\x1a\x1a");
    wait_for_the_stop(&pty);
    let now = frames(&pty);
    type_line(&mut pty, "fg");
    pty.wait_for("many frames", |pty| frames(pty) > now + 20);
    assert!(!pty.is_stopped());
}

#[test]
fn where_nobody_can_say_fg_ctrl_z_and_sigtstp_change_nothing() {
    let command = format!("{DONUT}; exit $?");
    for (program, arguments) in [(DONUT, &[][..]), ("sh", &["-c", &command])] {
        let mut pty = Pty::run(program, arguments, (80, 24), "xterm");
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        pty.type_bytes(b"\x1a");
        // The other shell would be stopped by a signal to the group.
        let stop = |pty: &Pty| {
            if program == DONUT {
                pty.signal("TSTP")
            }
        };
        stop(&pty);
        sleep(Duration::from_millis(300));
        let now = frames(&pty);
        pty.wait_for("more frames", |pty| frames(pty) > now + 5);
        assert!(pty.screen(|screen| screen.alternate_screen()));
        assert_quits(&mut pty);
    }
}

#[test]
fn a_stopped_donut_takes_the_terminal_again_whoever_stopped_it() {
    for lines in [&["fg"][..], &["bg", "fg"]] {
        let mut pty = donut_in_a_shell("bash");
        pty.signal_job("STOP");
        pty.wait_for("the stop", Pty::is_stopped);
        pty.wait_for("the shell", |pty| pty.written().contains("Stopped"));
        for line in lines {
            type_line(&mut pty, line);
            sleep(Duration::from_millis(300));
        }
        pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
        // In raw mode the key is not echoed, and need not wait for a newline.
        pty.type_bytes(b"q");
        assert_code(&mut pty, 0);
        assert!(!pty.lines().iter().any(|line| line.starts_with('q')), "{:?}", pty.lines());
    }
}

#[test]
fn in_the_background_it_waits_for_the_foreground_and_draws_nothing() {
    let mut pty = Pty::shell("bash", (80, 24));
    type_line(&mut pty, &format!("{DONUT} {} &", STILL.join(" ")));
    pty.wait_for("the job", |pty| pty.job().is_some());
    sleep(Duration::from_millis(500));
    assert!(!pty.is_stopped());
    assert_eq!(frames(&pty), 0);
    assert!(!pty.written().contains("\x1b[?1049h"));
    type_line(&mut pty, "fg");
    pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
    pty.type_bytes(b"q");
    assert_code(&mut pty, 0);
}

#[test]
fn a_background_donut_can_be_killed_and_leaves_the_screen_to_the_shell() {
    type Step = fn(&mut Pty);
    let ctrl_z: Step = |pty| {
        pty.type_bytes(b"\x1a");
        wait_for_the_stop(pty);
    };
    // Half of an arrow key's code, as Alt-[ is: the other half never comes.
    let half_a_key: Step = |pty| {
        pty.type_bytes(b"\x1b[");
        sleep(Duration::from_millis(100));
        pty.signal_job("TSTP");
        wait_for_the_stop(pty);
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
    let start_behind: Step = |pty| {
        type_line(pty, &format!("{DONUT} &"));
        if cfg!(target_os = "linux") {
            pty.wait_for("its handlers", Pty::is_ready_to_be_killed);
        } else {
            // No other ps tells which signals are caught.
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
        &[start_behind, kill],
        &[start_behind, hang_up],
    ] {
        let mut pty = Pty::shell("bash", (80, 24));
        steps.iter().for_each(|step| step(&mut pty));
        pty.wait_for("its end", |pty| pty.job().is_none());
        // So the shell calls a job that ended with exit code 0.
        type_line(&mut pty, "");
        pty.wait_for("exit code 0", |pty| pty.written().contains("Done"));
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
    // Without job control timeout puts it into the background of its own terminal.
    let command = format!("timeout 1 {DONUT}; exit $?");
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    assert_eq!(pty.exit(), 124);
    assert_eq!(pty.written(), "");
    pty.assert_settings_restored();
}

#[test]
fn where_the_background_may_not_write_it_is_not_stopped_by_it() {
    let mut pty = Pty::shell("bash", (80, 24));
    type_line(&mut pty, "stty tostop");
    type_line(&mut pty, DONUT);
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    pty.signal_job("STOP");
    pty.wait_for("the shell", |pty| pty.written().contains("Stopped"));
    type_line(&mut pty, "bg");
    sleep(Duration::from_millis(500));
    assert!(!pty.is_stopped());
    type_line(&mut pty, "kill %1");
    pty.wait_for("its end", |pty| pty.job().is_none());
}

#[test]
fn it_ends_when_the_terminal_goes_also_without_sighup() {
    // A shell that ignores SIGHUP, or that is not told of it, passes none on.
    let quiet = |options| format!("trap '' HUP; {DONUT} {options}; exit $?");
    for (command, key) in [
        (format!("exec {DONUT} --fps=5"), &b"x"[..]),
        (format!("exec {DONUT} --fps=0.01"), b"x"),
        (format!("exec {DONUT}"), b"p"),
        (quiet("--fps=5"), b"x"),
        (quiet("--fps=0.01"), b"x"),
        (quiet(""), b"p"),
        (quiet("--fps=0.01 < /dev/null"), b""),
    ] {
        let mut pty = Pty::run_unread("sh", &["-c", &command], (80, 24), "xterm");
        pty.read_until(|pty| frames(pty) > 0);
        pty.type_bytes(key);
        sleep(Duration::from_millis(300));
        pty.hang_up();
        assert_eq!(pty.exit(), 1, "{command}");
    }
}

/// The two ways to end it, on a terminal that may be stalled.
const ENDS: [fn(&mut Pty); 2] = [|pty| pty.type_bytes(b"q"), |pty| pty.signal("TERM")];

/// Ends it, which may take so many seconds, and returns its exit code.
#[track_caller]
fn exit_within(seconds: u64, pty: &mut Pty, end: fn(&mut Pty)) -> u32 {
    let start = Instant::now();
    end(pty);
    let code = pty.exit();
    assert!(start.elapsed() < Duration::from_secs(seconds), "{:?}", start.elapsed());
    code
}

#[test]
fn a_stalled_terminal_is_restored_within_two_seconds() {
    for end in ENDS {
        let mut pty = Pty::run_unread(DONUT, &["--fps=0", "--color=red"], (200, 50), "xterm");
        pty.wait_for("the start", Pty::is_changed);
        // Soon it has written as much as the terminal holds.
        sleep(Duration::from_millis(500));
        assert_eq!(exit_within(2, &mut pty, end), 1);
        pty.read(1 << 16, Duration::ZERO);
        let message = "\x1b[?1049ldonut: the terminal accepts no more output\r\n";
        pty.wait_for("the message", |pty| pty.written().ends_with(message));
        pty.assert_restored();
    }
}

#[test]
fn a_stalled_terminal_that_is_not_its_own_ends_with_a_signal() {
    // Only a program's own terminal can be opened once more. Elsewhere writes wait for room.
    let shown = Pty::run_unread("sleep", &["100"], (200, 50), "xterm");
    let command = format!("exec {DONUT} --fps=0 > {}", shown.path());
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    pty.wait_for("the start", Pty::is_changed);
    sleep(Duration::from_millis(500));
    exit_within(3, &mut pty, |pty| pty.signal("TERM"));
    pty.assert_settings_restored();
}

#[test]
fn a_terminal_that_reads_slowly_is_restored_within_two_seconds() {
    for end in ENDS {
        // 5 kB a second, where a frame is 1.8 kB.
        let mut pty = Pty::run_unread(DONUT, &[], (80, 24), "xterm");
        pty.read(200, Duration::from_millis(40));
        pty.wait_for("two frames", |pty| frames(pty) > 1);
        sleep(Duration::from_secs(1));
        assert_eq!(exit_within(2, &mut pty, end), 0);
        pty.wait_for("the end", |pty| pty.written().ends_with("\x1b[?1049l"));
        pty.assert_restored();
    }
}

#[test]
fn keys_and_resizes_in_the_middle_of_a_slow_frame_are_obeyed() {
    // 50 kB a second, where a frame is 10 kB.
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
fn a_frame_that_takes_long_to_read_is_cut_short_at_the_end() {
    // A frame of a megabyte takes most of a minute.
    let mut pty = Pty::run_unread(DONUT, &["--color=red", "--frames=9"], (2000, 500), "xterm");
    pty.read_until(|pty| pty.written().contains("\x1b[38;5;9m"));
    pty.read(1000, Duration::from_millis(50));
    pty.type_bytes(b"q");
    assert_eq!(pty.exit(), 0);
    pty.wait_for("the end", |pty| pty.written().ends_with("\x1b[?25h\r\n"));
    pty.assert_restored();
}

#[test]
fn a_frame_that_takes_long_to_draw_is_waited_for() {
    let mut pty = donut(&["--method=classic", "--aspect=3"], (4096, 1002));
    pty.wait_for("the start", |pty| pty.written().contains("\x1b[?25l"));
    assert_quits(&mut pty);
}

#[test]
fn the_size_is_that_of_the_terminal_it_draws_on() {
    let shown = Pty::run("sleep", &["100"], (60, 20), "xterm");
    let command = format!("exec {DONUT} {} > {}", STILL.join(" "), shown.path());
    let mut pty = Pty::run("sh", &["-c", &command], (100, 30), "xterm");
    shown.wait_for("the picture", |shown| shown.lines() == picture((60, 20), (60, 20)));
    assert_quits(&mut pty);
    shown.assert_restored();
}

#[test]
fn when_the_terminal_of_the_keys_goes_that_of_the_picture_is_given_back() {
    let shown = Pty::run("sleep", &["100"], (60, 20), "xterm");
    let command = format!("trap '' HUP; exec {DONUT} > {}", shown.path());
    let mut pty = Pty::run_unread("sh", &["-c", &command], (80, 24), "xterm");
    shown.wait_for("a frame", |shown| frames(shown) > 0);
    pty.hang_up();
    assert_eq!(pty.exit(), 1);
    shown.assert_restored();
}

#[test]
fn when_keys_cannot_be_read_it_says_so() {
    let command = format!("ulimit -n 5; exec {DONUT}");
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    assert_eq!(pty.exit(), 1);
    assert!(pty.lines().iter().any(|line| line.starts_with("donut: ")), "{:?}", pty.lines());
    assert!(!pty.written().contains('\x1b'));
    pty.assert_settings_restored();
}

#[test]
fn without_keys_it_runs_on_signals() {
    let command = format!("exec {DONUT} --spin 0,0 -A 1 -B 0.5 < /dev/null");
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    pty.wait_for("the picture", |pty| pty.lines() == picture((80, 24), (80, 24)));
    pty.resize((60, 20));
    pty.wait_for("the new size", |pty| pty.lines() == picture((60, 20), (60, 20)));
    pty.signal("TERM");
    assert_eq!(pty.exit(), 0);
    pty.assert_restored();
}

#[cfg(target_os = "linux")]
#[test]
fn without_keys_it_does_not_spin() {
    for command in [format!("{DONUT} < /dev/null; true"), format!("true | {DONUT}")] {
        let pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        sleep(Duration::from_secs(1));
        let process = pty.job().expect("a job");
        let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).unwrap();
        // User and system time, in hundredths of a second.
        let ticks: u32 = stat.split(' ').skip(13).take(2).map(|n| n.parse::<u32>().unwrap()).sum();
        assert!(ticks < 20, "{ticks} ticks: {command}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn it_has_two_threads_at_most() {
    let pty = still_donut((80, 24));
    let threads = std::fs::read_dir(format!("/proc/{}/task", pty.process())).unwrap();
    assert!(threads.count() <= 2);
}

#[test]
fn with_frames_it_draws_in_place_and_the_last_picture_stays() {
    let options = [&STILL[..], &["--frames=5"]].concat();
    let mut pty = donut(&options, (80, 24));
    assert_eq!(pty.exit(), 0);
    assert!(!pty.written().contains("\x1b[?1049h"));
    assert_eq!(pty.lines(), picture((80, 24), (80, 24)));
    // The shell's prompt comes below.
    assert_eq!(pty.screen(vt100::Screen::cursor_position), (23, 0));
    pty.assert_restored();
}

#[test]
fn a_resize_or_a_stop_during_the_last_frame_does_not_lose_it() {
    let options = [&STILL[..], &["--frames=1"]].concat();
    for stop in [false, true] {
        // The frame is larger than what a terminal holds.
        let mut pty = Pty::run_unread(DONUT, &options, (600, 300), "xterm");
        pty.wait_for("the start", Pty::is_changed);
        sleep(Duration::from_millis(300));
        if stop {
            pty.signal("STOP");
            pty.signal("CONT");
        } else {
            pty.resize((500, 250));
        }
        sleep(Duration::from_millis(300));
        pty.read(1 << 16, Duration::ZERO);
        assert_eq!(pty.exit(), 0);
        let size = if stop { (600, 300) } else { (500, 250) };
        pty.wait_for("the picture", |pty| pty.lines() == picture(size, size));
        pty.assert_restored();
    }
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
fn no_frames_are_no_bytes_on_any_terminal() {
    for term in ["dumb", "xterm"] {
        let mut pty = Pty::run(DONUT, &["--frames=0"], (80, 24), term);
        assert_eq!(pty.exit(), 0);
        assert_eq!(pty.written(), "");
    }
}

#[test]
fn a_colour_is_one_sequence_a_frame_also_with_no_color() {
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
        assert_eq!(last.matches("\x1b[").count(), 4, "{last:?}");
    }
}
