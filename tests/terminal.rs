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
        let frame = frame.trim_start_matches("\x1b[2J");
        assert!(frame.starts_with("\x1b[H\r\n") && frame.matches("\r\n").count() == 22);
        // Behind the last frame the terminal is given back.
        assert!(rest.is_empty() || rest.contains("\x1b[?25h"), "{rest:?}");
    }
}

#[test]
fn q_escape_and_ctrl_c_quit_at_once_and_restore() {
    for key in [&b"q"[..], b"\x1b", b"\x03"] {
        for fps in ["--fps=30", "--fps=0.01", "--fps=0"] {
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
        sleep(Duration::from_millis(1));
        pty.type_bytes(b"[A");
        sleep(Duration::from_millis(300));
        pty.is_running()
    };
    // A machine under load may take longer over the pieces than the donut waits for them.
    assert!((0..3).any(|_| goes_on()));
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
    // A terminal that does not know its size is taken for 80x24.
    let pty = donut(&STILL, (0, 0));
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    pty.resize((80, 24));
    pty.wait_for("80x24", |pty| pty.lines() == picture((80, 24), (80, 24)));
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
    for signal in ["TERM", "INT", "HUP"] {
        let mut pty = donut(&["--fps=0.01"], (80, 24));
        pty.wait_for("a frame", |pty| frames(pty) > 0);
        pty.signal(signal);
        assert_eq!(pty.exit(), 0, "{signal}");
        pty.assert_restored();
    }
}

#[test]
fn ctrl_z_and_sigtstp_give_the_terminal_back_and_fg_redraws() {
    for stop in [|pty: &mut Pty| pty.type_bytes(b"\x1a"), |pty: &mut Pty| pty.signal("TSTP")] {
        let mut pty = still_donut((80, 24));
        for _ in 0..2 {
            stop(&mut pty);
            pty.wait_for("the stop", Pty::is_stopped);
            pty.wait_for("the screen it found", |pty| {
                pty.screen(|screen| !screen.alternate_screen() && !screen.hide_cursor())
            });
            pty.assert_restored();
            pty.resize((90, 30));
            pty.signal("CONT");
            pty.wait_for("the picture", |pty| pty.lines() == picture((90, 30), (90, 30)));
            assert!(pty.screen(|screen| screen.alternate_screen() && screen.hide_cursor()));
        }
        assert_quits(&mut pty);
        pty.assert_restored();
    }
}

#[test]
fn ctrl_z_stops_the_whole_job() {
    let command = format!("{DONUT}; true");
    let mut pty = Pty::run("sh", &["-c", &command], (80, 24), "xterm");
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    pty.type_bytes(b"\x1a");
    pty.wait_for("the shell's stop", Pty::is_stopped);
    pty.signal("CONT");
    let now = frames(&pty);
    pty.wait_for("more frames", |pty| frames(pty) > now);
    assert_quits(&mut pty);
}

#[test]
fn it_ends_when_the_terminal_goes() {
    for fps in ["--fps=5", "--fps=0.01"] {
        let mut pty = Pty::run_unread(DONUT, &[fps], (80, 24), "xterm");
        sleep(Duration::from_millis(300));
        pty.hang_up();
        pty.exit();
    }
}

#[test]
fn it_ends_when_the_terminal_does_not_read() {
    for stop in [|pty: &mut Pty| pty.type_bytes(b"q"), |pty: &mut Pty| pty.signal("TERM")] {
        let mut pty = Pty::run_unread(DONUT, &["--fps=0"], (80, 24), "xterm");
        sleep(Duration::from_secs(1));
        stop(&mut pty);
        pty.exit();
    }
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
fn a_dumb_terminal_gets_one_still_frame_without_an_escape() {
    let options = [&STILL[..], &["--color=red"]].concat();
    let mut pty = Pty::run(DONUT, &options, (80, 24), "dumb");
    assert_eq!(pty.exit(), 0);
    assert!(!pty.written().contains('\x1b'));
    assert_eq!(pty.lines(), picture((80, 24), (80, 24)));
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

#[test]
fn thirty_frames_a_second_are_ninety_in_three() {
    let pty = donut(&[], (80, 24));
    pty.wait_for("a frame", |pty| frames(pty) > 0);
    let (start, first) = (Instant::now(), frames(&pty));
    sleep(Duration::from_secs(3));
    let (count, time) = ((frames(&pty) - first) as f64, start.elapsed().as_secs_f64());
    // A machine under load may lose frames; none are made up for.
    assert!(15.0 * time < count && count < 30.0 * time + 5.0, "{count} in {time} s");
}
