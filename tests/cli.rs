//! The command line: which options are accepted, what goes into a pipe, and how the program ends.

mod program;

use std::io::Read;
use std::process::Stdio;
use std::thread::sleep;
use std::time::{Duration, Instant};

use program::{Program, frames, in_time};
use proptest::prelude::*;

fn start(options: &str, stdout: impl Into<Stdio>) -> Program {
    Program::start(env!("CARGO_BIN_EXE_donut"), options, stdout)
}

/// Waits for donut to end, and returns what it draws, or why it refuses its options.
fn result(donut: Program) -> Result<String, String> {
    match donut.output() {
        (Some(0), drawn, error) if error.is_empty() => Ok(drawn),
        (Some(2), drawn, error) if error.starts_with("error: ") && drawn.is_empty() => Err(error),
        (code, drawn, error) => panic!("{code:?} with {} bytes of output: {error}", drawn.len()),
    }
}

fn run(options: &str) -> Result<String, String> {
    result(start(options, Stdio::piped()))
}

#[test]
fn the_summary_fits_on_a_screen_and_the_help_into_80_columns_with_examples() {
    let [summary, help] = ["-h", "--help"].map(|option| run(option).unwrap());
    for help in [&summary, &help] {
        for heading in ["Motion:", "Look:", "Size:", "Keys "] {
            assert!(help.lines().any(|line| line.starts_with(heading)), "no {heading} in {help}");
        }
        assert!(help.contains("[default: 30]"), "{help}");
        assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
    }
    // With the command before it and the prompt after it, the summary takes 40 rows.
    assert!(summary.lines().count() <= 38, "{summary}");
    assert!(!summary.contains("Examples:") && help.contains("Examples:"), "{summary}{help}");
}

/// {} stands for the value, which is empty between two blanks and after the last one.
#[test]
fn values_are_accepted_within_their_limits_and_no_others_are() {
    let fps = "expected a number from 0 to 1000";
    let frames = "expected an integer from 0 to 1000000000";
    let size = "expected an integer from 1 to 4096";
    let aspect = "a number from 0.1 to 10";
    let angle = "expected an angle in radians from -2000000 to 2000000";
    let spin = "expected two numbers from -1000 to 1000, such as 0.04,0.02";
    let no_angle = "2000000.1 -2000000.1 2e9 nan inf -inf north 1,2 ";
    let no_spin = "2e9,0 0,1000.001 inf,0 a,b 0.04, ,0.02 , 0.04 0.04;0.02  - 1,2,3 1,2,";
    let no_color = "crimson 256 -1 #0a7fff 0A7FFF  reset";
    let color = "expected a number from 0 to 255, or one of black, dark_red,";
    let r2 = "a number from 1.01 to 30";
    let k2 = "a number at least 1.01 more than --r2, and from 2.02 to 1000000";
    let far = "--k2 must be at least 1.01 more than --r2";
    let classic = "--method classic needs --r2 2 and --k2 5";
    for (options, refused, message, accepted) in [
        ("--width {}", "0 4097 -5 65536 1.5 x  1e3", ["'{}' for '--width", size], "1 4096"),
        ("--height {}", "0 4097 -5 65536 1.5 x  1e3", ["'{}' for '--height", size], "1 4096"),
        ("--fps {}", "-1 -0.5 -5 1000.1 1001 nan inf fast ", ["'{}' for '--fps", fps], "0 1000"),
        ("--frames {}", "-1 1000000001 4294967296 1.5 ", ["'{}' for '--frames", frames], "2"),
        ("--aspect {}", "0 0.09 10.1 11 -2 nan wide ", ["'{}' for '--aspect", aspect], "0.1 10"),
        ("-A {}", no_angle, ["'{}' for '-A", angle], "-2e6 -1.5 -1e-3 2000000"),
        ("-B {}", no_angle, ["'{}' for '-B", angle], "-2e6 -1.5 -1e-3 2000000"),
        ("--spin {}", no_spin, ["'{}' for '--spin", spin], "-1e3,1e3 -0.04,0.02 0,0"),
        ("--speed {}", "2", ["'2' for '--spin", spin], "0.01,0.005"),
        ("--method {}", "magic", ["'{}' for '--method", "classic, exact"], "classic exact EXACT"),
        ("--color {}", no_color, ["'{}' for '--color", color], "0 255"),
        ("--r2 {}", "1.009 30.1 -2 nan ", ["'{}' for '--r2", r2], "1.01 4 30"),
        ("--r2=10 --k2 {}", "11.0099 10", [far, "which is 10"], "11.01"),
        ("--r2=1.1 --k2 {}", "2.10999 2.02", [far, "which is 1.1"], "2.11"),
        ("--r2=30 --k2 {}", "31.00999 5", [far, "which is 30"], "31.01"),
        ("--k2 {}", "3.00999999", [far, "which is 2"], "3.01 1000000"),
        ("--k2 {}", "1000000.1 2.019 -5 NaN big 1,2", ["'{}' for '--k2", k2], "5"),
        ("--method=classic --k2=5 --r2 {}", "3", [classic, "5\n"], "2"),
        ("--method=classic --k2 {}", "5.000001", [classic, "5\n"], "5"),
        ("{}", "80", ["unexpected argument", "'{}'"], ""),
        ("{}", "--width", ["a value is required", "{}"], ""),
        ("--color {}", "--fps -A", ["a value is required for '--color", "none was supplied"], ""),
        ("-A {}", "-B --spin", ["'{}' for '-A", angle], "-.5"),
        ("--fps {}", "--spin", ["a value is required for '--fps", "none was supplied"], ""),
    ] {
        for value in refused.split(' ') {
            let options = options.replace("{}", value);
            let refusal = run(&options).err().unwrap_or_else(|| panic!("{options} is accepted"));
            for text in message.map(|text| text.replace("{}", value)) {
                assert!(refusal.contains(&text), "{options}: no {text:?} in {refusal}");
            }
        }
        for value in accepted.split_whitespace() {
            // The last --frames wins, so one frame is drawn even where the option is --frames.
            run(&(options.replace("{}", value) + " --frames=1")).unwrap();
        }
    }
}

#[test]
fn each_frame_sets_and_resets_the_colour_however_it_is_written() {
    let plain = run("--frames=2 --fps=0").unwrap();
    for (colors, set) in [
        ("cyan CYAN 14", "\x1b[38;5;14m"),
        ("dark_red dark-red Dark-Red", "\x1b[38;5;1m"),
        ("grey gray GRAY", "\x1b[38;5;7m"),
        ("dark_grey dark_gray", "\x1b[38;5;8m"),
        ("208", "\x1b[38;5;208m"),
    ] {
        let expected: Vec<_> = frames(&plain)
            .iter()
            .map(|frame| format!("{set}{}\x1b[0m\n", frame.trim_end_matches('\n')))
            .collect();
        for color in colors.split(' ') {
            for option in ["--color", "--colour"] {
                let drawn = run(&format!("--frames=2 --fps=0 {option}={color}")).unwrap();
                assert_eq!(frames(&drawn), expected, "{option}={color}");
            }
        }
    }
}

#[test]
fn an_option_that_is_given_twice_has_its_last_value() {
    let last = "--frames=2 --color=red -A 2 --spin=3,4";
    let repeated = format!("--color=cyan -A 1 --spin=1,2 --frames=7 {last}");
    assert_eq!(run(&repeated), run(last));
    assert_eq!(run("--frames=7 --frames=0"), Ok(String::new()));
}

#[test]
fn the_program_ends_silently_when_its_reader_goes_away() {
    let mut donut = start("--fps=0", Stdio::piped());
    let mut pipe = donut.0.stdout.take().unwrap();
    in_time(move || pipe.read_exact(&mut [0; 1000])).unwrap();
    result(donut).unwrap();
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_gives_one_line_of_message_and_exit_code_1() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let (code, _, message) = start("--frames=1", full).output();
    assert_eq!((code, message.lines().count()), (Some(1), 1), "{message}");
    assert!(message.starts_with("donut: "), "{message}");
}

#[cfg(unix)]
#[test]
fn every_frame_is_one_write() {
    use std::os::{fd::OwnedFd, unix::net::UnixDatagram};
    // On a datagram socket, each write is a packet of its own.
    let (reader, writer) = UnixDatagram::pair().unwrap();
    let donut = start("--frames=3 --fps=20 --color=red", OwnedFd::from(writer));
    let packets = in_time(move || [0; 3].map(|_| reader.recv(&mut [0; 4000]).unwrap()));
    result(donut).unwrap();
    let frame = 1764 + "\x1b[38;5;9m\x1b[0m".len();
    assert_eq!(packets, [4 + frame, frame, frame]);
}

/// A reader takes frame 0, pauses, and takes some more. All this has to take at least the first time, and
/// what comes after the pause less than the second. (On a busy machine, a frame may be late, so one try of
/// ten is enough: a program that is too slow never succeeds.) All times are in milliseconds.
#[test]
fn frames_come_at_their_rate_and_after_a_stall_neither_in_a_burst_nor_late() {
    for (options, size, pause, count, least, most) in [
        // Frame 25 is due after half a second.
        ("--fps=50", 80 * 22, 0, 25, 500, 750),
        // A pipe holds only a few frames of this size. A hundred more come due in the pause. A few frames
        // come at once after it: those in the pipe, the one that was being written, and the two after it.
        ("--fps=100 --width=400 --height=100", 401 * 100 - 1, 1000, 60, 1500, u128::MAX),
        // Frame 1, which is due at 400, fills the pipe, so the program waits, and frame 2 is 200 late. Frame
        // 3 is due 200 after the pause. If frame 2's delay were added, it would come 400 after the pause.
        ("--fps=2.5 --width=400 --height=400", 401 * 400 - 1, 1000, 3, 1200, 400),
    ] {
        let is_in_time = |_| {
            let start_of_all = Instant::now();
            let mut donut = start(options, Stdio::piped());
            let mut stream = donut.0.stdout.take().unwrap();
            let after_pause = in_time(move || {
                // Of a frame, `size` leaves out `ESC [ H` and the last newline.
                let mut read = |bytes| stream.read_exact(&mut vec![0; bytes]).unwrap();
                read(4 + (4 + size));
                sleep(Duration::from_millis(pause));
                let start = Instant::now();
                read(count * (4 + size));
                start.elapsed().as_millis()
            });
            assert!(start_of_all.elapsed().as_millis() >= least, "{options}: too soon");
            after_pause < most
        };
        assert!((0..10).any(is_in_time), "{options}: too late");
    }
}

/// A number from `low` to `high`, and often one of the two themselves.
fn number(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![2 => Just(low), 2 => Just(high), 6 => low..=high]
}

fn size(most: usize) -> impl Strategy<Value = usize> {
    prop_oneof![1 => 1..=2_usize, 1 => Just(most), 4 => 1..=most]
}

/// R2 and K2. Often K2 is only just large enough for R2, where rounding must not decide.
fn lengths() -> impl Strategy<Value = (f64, f64)> {
    let any = (number(1.01, 30.0), number(1.0, 3e4));
    let any = any.prop_map(|(r2, distance)| (r2, r2 + 1.01 * distance));
    prop_oneof![1 => Just((2.0, 5.0)), 3 => any]
}

proptest! {
    // A case that fails is printed, not kept, and not shrunk: if the program hangs, each try takes a minute.
    #![proptest_config(ProptestConfig {
        failure_persistence: None, max_shrink_iters: 0, ..ProptestConfig::with_cases(500)
    })]

    #[test]
    fn whatever_the_options_it_draws_or_says_why_not(
        (width, height) in (size(300), size(150)),
        [a, b, da, db] in [number(-1e3, 1e3), number(-7.0, 7.0), number(-1e3, 1e3), number(-1e-300, 0.0)],
        (r2, k2) in lengths(),
        aspect in prop_oneof![Just(2.0), number(0.1, 10.0)],
        method in prop::sample::select(vec!["", " --method=classic", " --method=exact"]),
    ) {
        let drawn = run(&format!(
            "--frames=2 --fps=0 --width={width} --height={height} -A{a} -B{b} --spin={da},{db} \
             --r2={r2} --k2={k2} --aspect={aspect}{method}"
        ));
        let is_possible = k2 > 1.0101 + r2 && method != " --method=classic";
        prop_assert!(drawn.is_ok() || !is_possible);
        if let Ok(drawn) = drawn {
            prop_assert_eq!(frames(&drawn).len(), 2);
            for frame in frames(&drawn) {
                prop_assert!(frame.chars().all(|cell| ".,-~:;=!*#$@ \n".contains(cell)));
                prop_assert!(frame.ends_with('\n'));
                let rows: Vec<_> = frame.lines().map(str::len).collect();
                let is_donut_cs = frame.starts_with('\n');
                prop_assert!(!is_donut_cs || (width, height, r2, k2, aspect) == (80, 22, 2.0, 5.0, 2.0));
                prop_assert!(is_donut_cs || rows == vec![width; height], "{:?}", rows);
            }
        }
    }
}
