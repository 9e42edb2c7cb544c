//! The command line, the bytes on a pipe, and the ways out.

use std::io::Read;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use assert_cmd::assert::OutputAssertExt;
use predicates::prelude::*;
use predicates::str::contains;

fn donut(options: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_donut"));
    command.args(options);
    command
}

/// Starts the program, lets it run against a reader that does not read for the time of `stall`,
/// and says how many frames of `size` bytes then come in half a second or a little more.
fn count_frames(options: &[&str], size: usize, stall: Duration) -> (f64, Duration) {
    let mut child = donut(options).stdout(Stdio::piped()).spawn().unwrap();
    let mut stream = child.stdout.take().unwrap();
    stream.read_exact(&mut vec![0; size + 4]).unwrap();
    sleep(stall);
    let (start, mut bytes, mut buffer) = (Instant::now(), 0, vec![0; size]);
    while start.elapsed() < Duration::from_millis(500) {
        bytes += stream.read(&mut buffer).unwrap();
    }
    let time = start.elapsed();
    child.kill().unwrap();
    child.wait().unwrap();
    (bytes as f64 / size as f64, time)
}

/// Bad input: exit code 2, nothing on standard output, and a message that says all of `said`.
fn assert_refused(options: &[&str], said: &[&str]) {
    let mut refused = donut(options).assert().code(2).stdout("");
    for said in said {
        refused = refused.stderr(contains(*said));
    }
    refused.stderr(contains("panicked").not());
}

#[test]
fn help_tells_options_units_ranges_defaults_keys_and_examples() {
    let mut help = donut(&["--help"]).assert().success().stderr("");
    for text in [
        "--width <COLS>",
        "--height <ROWS>",
        "--fps <N>",
        "--frames <N>",
        "--method <METHOD>",
        "-A <RAD>",
        "-B <RAD>",
        "--spin <DA,DB>",
        "--color <COLOR>",
        "--aspect <RATIO>",
        "--r1 <R>",
        "--r2 <R>",
        "--k2 <D>",
        "radians",
        "1 to 4096",
        "[default: 30]",
        "Keys:",
        "q, Esc, Ctrl-C",
        "Ctrl-Z",
        "Examples:",
    ] {
        help = help.stdout(contains(text));
    }
}

#[test]
fn version_is_the_packages() {
    let version = concat!("donut ", env!("CARGO_PKG_VERSION"), "\n");
    donut(&["--version"]).assert().success().stdout(version);
}

#[test]
fn sizes_from_1_to_4096_are_accepted_and_no_other() {
    for size in ["1", "4096"] {
        donut(&["--width", size, "--height=2", "--frames=1"]).assert().success();
        donut(&["--height", size, "--width=2", "--frames=1"]).assert().success();
    }
    for size in ["0", "4097", "-5", "65536", "1.5", "x", "", "1e3"] {
        for option in ["--width", "--height"] {
            let value = format!("'{size}'");
            assert_refused(&[option, size], &[option, &value, "from 1 to 4096"]);
        }
    }
}

#[test]
fn rates_that_are_negative_not_finite_or_no_number_are_refused() {
    for fps in ["-1", "-0.5", "nan", "inf", "-inf", "1001", "fast", ""] {
        assert_refused(&["--fps", fps], &["--fps", &format!("'{fps}'"), "from 0 to 1000"]);
    }
    for frames in ["-1", "1.5", "many", ""] {
        assert_refused(
            &["--frames", frames],
            &["--frames", &format!("'{frames}'"), "whole number"],
        );
    }
    for aspect in ["0", "-2", "nan", "11", "wide", ""] {
        assert_refused(&["--aspect", aspect], &["--aspect", &format!("'{aspect}'"), "0.1 to 10"]);
    }
}

#[test]
fn angles_that_are_no_finite_number_are_refused() {
    for option in ["-A", "-B"] {
        for angle in ["north", "nan", "inf", "-inf", "2e9", "1,2", ""] {
            let value = format!("'{angle}'");
            assert_refused(&[option, angle], &[option, &value, "from -1000000000 to 1000000000"]);
        }
    }
    for spin in ["0.04", "0.04,", ",0.02", "0.04,0.02,0.01", "0.04;0.02", "a,b", "inf,0", "", "-"] {
        assert_refused(&["--spin", spin], &["--spin", &format!("'{spin}'"), "expected"]);
    }
}

#[test]
fn scenes_that_cannot_be_drawn_are_refused() {
    for length in ["0", "-1", "nan", "inf", "1e7", "big", ""] {
        for option in ["--r1", "--r2", "--k2"] {
            let value = format!("'{length}'");
            assert_refused(&[option, length], &[option, &value, "from 0.000001 to 1000000"]);
        }
    }
    assert_refused(&["--r1=2"], &["--r1", "'2'", "less than --r2, 2"]);
    assert_refused(&["--r1=0.0019"], &["--r1", "'0.0019'", "thousandth of --r2, 2"]);
    assert_refused(&["--k2=3"], &["--k2", "'3'", "more than --r1 plus --r2, 3"]);
    assert_refused(&["--method=classic", "--r1=0.5"], &["--method", "'classic'", "exact or auto"]);
}

#[test]
fn the_same_scene_in_other_units_is_donut_cs() {
    let scaled = ["--r1=20", "--r2=40", "--k2=100", "--frames=2", "--fps=0"];
    let own = donut(&["--frames=2", "--fps=0"]).output().unwrap().stdout;
    donut(&scaled).assert().success().stdout(own);
}

#[test]
fn negative_angles_and_spins_work() {
    let options = ["--frames=3", "--fps=0", "-A", "-1.5", "-B", "-2", "--spin", "-0.04,0.02"];
    donut(&options).assert().success().stderr("");
}

#[test]
fn colours_that_do_not_exist_are_refused() {
    for color in
        ["chartreuse", "256", "-1", "#12345", "#1234567", "#12345g", "#+12345", "", "reset"]
    {
        assert_refused(&["--color", color], &["--color", &format!("'{color}'"), "#rrggbb"]);
    }
}

#[test]
fn unknown_options_methods_and_arguments_are_refused() {
    assert_refused(&["--speed", "3"], &["--speed"]);
    assert_refused(&["--method", "magic"], &["--method", "'magic'", "auto, classic, exact"]);
    assert_refused(&["80"], &["'80'"]);
    assert_refused(&["--width"], &["--width"]);
}

#[test]
fn a_pipe_gets_one_clear_and_then_frames_of_1764_bytes() {
    let stream = donut(&["--frames=3", "--fps=0"]).assert().success().stderr("");
    let stream = &stream.get_output().stdout;
    assert_eq!(stream.len(), 4 + 3 * 1764);
    assert!(stream.starts_with(b"\x1b[2J\x1b[H\n"));
    for frame in stream[4..].chunks(1764) {
        assert!(frame.starts_with(b"\x1b[H\n") && frame.ends_with(b"\n"));
        assert_eq!(frame.iter().filter(|&&byte| byte == b'\n').count(), 23);
    }
}

#[test]
fn the_size_of_a_pipe_is_that_of_the_options() {
    let stream = donut(&["--frames=1", "--width=7", "--height=3"]).assert().success();
    let stream = String::from_utf8(stream.get_output().stdout.clone()).unwrap();
    let rows: Vec<_> = stream.strip_prefix("\x1b[2J\x1b[H\n").unwrap().lines().collect();
    assert_eq!(rows.iter().map(|row| row.len()).collect::<Vec<_>>(), [6, 6, 6]);
}

#[test]
fn no_frames_are_no_bytes() {
    donut(&["--frames=0"]).assert().success().stdout("").stderr("");
}

#[test]
fn a_colour_wraps_each_frame_in_one_sequence_and_changes_nothing_else() {
    let plain = donut(&["--frames=2", "--fps=0"]).assert();
    let plain = String::from_utf8(plain.get_output().stdout.clone()).unwrap();
    for (color, sgr) in [
        ("cyan", "\x1b[38;5;14m"),
        ("dark_red", "\x1b[38;5;1m"),
        ("208", "\x1b[38;5;208m"),
        ("#0a7Fff", "\x1b[38;2;10;127;255m"),
    ] {
        let expected = plain.replace("\x1b[H", &format!("\x1b[0m\x1b[H{sgr}")) + "\x1b[0m";
        let expected = expected.replacen("\x1b[0m", "", 1);
        let options = ["--frames=2", "--fps=0", "--color", color];
        donut(&options).env("NO_COLOR", "1").assert().success().stdout(expected);
    }
}

#[test]
fn a_reader_that_goes_away_ends_it_silently() {
    let mut child =
        donut(&["--fps=0"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdout.as_mut().unwrap().read_exact(&mut [0; 1000]).unwrap();
    drop(child.stdout.take());
    child.wait_with_output().unwrap().assert().code(0).stderr("");
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_message_and_exit_code_1() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let error = predicates::str::starts_with("donut: ")
        .and(predicate::function(|e: &str| e.lines().count() == 1));
    donut(&["--frames=1"]).stdout(full).assert().code(1).stderr(error);
}

#[cfg(unix)]
#[test]
fn every_frame_is_one_write() {
    use std::os::{fd::OwnedFd, unix::net::UnixDatagram};
    let (reader, writer) = UnixDatagram::pair().unwrap();
    let child =
        donut(&["--frames=3", "--fps=5", "--color=red"]).stdout(OwnedFd::from(writer)).spawn();
    reader.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let packets = [0; 3].map(|_| reader.recv(&mut [0; 4000]).unwrap());
    child.unwrap().wait_with_output().unwrap().assert().success();
    let frame = 1764 + "\x1b[38;5;9m\x1b[0m".len();
    assert_eq!(packets, [4 + frame, frame, frame]);
}

#[test]
fn frames_come_at_the_rate_asked_for() {
    let (frames, time) = count_frames(&["--fps=50"], 1764, Duration::ZERO);
    assert!(frames <= 50.0 * time.as_secs_f64() + 3.0, "{frames} frames in {time:?}");
    assert!(frames >= 8.0, "{frames} frames in {time:?}");
}

#[test]
fn after_a_stall_it_goes_on_from_now_without_a_burst() {
    // A pipe holds only one or two frames this large; the other hundred were due during the stall.
    let options = ["--fps=100", "--width=400", "--height=100"];
    let (frames, time) = count_frames(&options, 40_004, Duration::from_secs(1));
    assert!(frames > 3.0);
    assert!(frames <= 100.0 * time.as_secs_f64() + 10.0, "{frames} frames in {time:?}");
}
