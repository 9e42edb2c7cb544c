//! The command line, the bytes on a pipe, and the ways out.

use std::io::Read;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use proptest::prelude::*;

fn donut(options: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_donut"));
    command.args(options);
    command
}

/// Reads the first frame, then nothing for the time of `stall`, and then all that comes in half a second.
/// Returns how many frames of `size` bytes that is, and how long it really took.
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

/// Waits for the program to end, but not for ever.
fn wait(mut child: Child) -> Output {
    let start = Instant::now();
    while child.try_wait().unwrap().is_none() {
        if start.elapsed() > Duration::from_secs(20) {
            child.kill().unwrap();
            panic!("it does not end");
        }
        sleep(Duration::from_millis(1));
    }
    child.wait_with_output().unwrap()
}

/// Bad input: exit code 2, nothing on standard output, and a message that says all of `said`.
fn assert_refused(options: &[&str], said: &[&str]) {
    let mut command = donut(options);
    let refused = wait(command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap());
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!((refused.status.code(), &*refused.stdout), (Some(2), &b""[..]), "{options:?}");
    assert!(said.iter().all(|said| message.contains(said)), "no {said:?} in {message}");
    assert!(!message.contains("panicked"), "{message}");
}

/// Exit code 0, nothing on standard error, and what is on standard output.
fn succeeded(output: Output) -> String {
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), &*message), (Some(0), ""));
    String::from_utf8(output.stdout).unwrap()
}

fn output_of(options: &[&str]) -> String {
    succeeded(donut(options).output().unwrap())
}

#[test]
fn both_helps_tell_options_values_defaults_keys_and_examples() {
    for help in ["-h", "--help"] {
        let help = output_of(&[help]);
        for text in [
            "Motion:",
            "Look:",
            "Size:",
            "Geometry:",
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
            "[default: 30]",
            "classic",
            "exact",
            "Keys:",
            "q, Esc, Ctrl-C",
            "Ctrl-Z",
            "Examples:",
        ] {
            assert!(help.contains(text), "no {text} in {help}");
        }
    }
}

#[test]
fn no_line_of_either_help_is_longer_than_80_columns() {
    for help in ["-h", "--help"] {
        for line in output_of(&[help]).lines() {
            assert!(line.chars().count() <= 80, "{help}: {line}");
        }
    }
}

#[test]
fn the_short_help_fits_a_screen_of_40_lines() {
    assert!(output_of(&["-h"]).lines().count() <= 40);
}

#[test]
fn the_long_help_tells_the_ranges_the_colours_and_what_the_methods_are() {
    let help = output_of(&["--help"]);
    for text in [
        "0 to 1000",
        "-1e9 to 1e9",
        "1 to 4096",
        "0.1 to 10",
        "0.000001 to 1000000",
        "1.001 to 30 times --r1",
        "1.001 times the sum",
        "auto: ",
        "classic: ",
        "exact: ",
        "black, dark_grey",
        "draws from its top",
    ] {
        assert!(help.contains(text), "no {text} in {help}");
    }
}

#[test]
fn version_is_the_packages() {
    let version = concat!("donut ", env!("CARGO_PKG_VERSION"), "\n");
    assert_eq!(output_of(&["--version"]), version);
}

#[test]
fn sizes_from_1_to_4096_are_accepted_and_no_other() {
    for size in ["1", "4096"] {
        output_of(&["--width", size, "--height=2", "--frames=1"]);
        output_of(&["--height", size, "--width=2", "--frames=1"]);
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
    for frames in ["-1", "1.5", "many", "18446744073709551616", ""] {
        assert_refused(
            &["--frames", frames],
            &["--frames", &format!("'{frames}'"), "a whole number from 0 to 2^64 - 1"],
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
            assert_refused(
                &[option, angle],
                &[option, &value, "an angle in radians, such as 1.57"],
            );
        }
    }
    for spin in ["0.04,", ",0.02", "a,b", "inf,0", "2e9,0", ",", "1,2,3", "0.04,0.02,"] {
        assert_refused(&["--spin", spin], &["--spin", &format!("'{spin}'"), "an angle in radians"]);
    }
    for spin in ["0.04", "0.04;0.02", "", "-"] {
        assert_refused(&["--spin", spin], &["--spin", &format!("'{spin}'"), "two angles"]);
    }
}

#[test]
fn lengths_out_of_range_are_refused() {
    for length in ["0", "-1", "nan", "inf", "1e7", "big", ""] {
        for option in ["--r1", "--r2", "--k2"] {
            let value = format!("'{length}'");
            assert_refused(&[option, length], &[option, &value, "from 0.000001 to 1000000"]);
        }
    }
}

#[test]
fn options_that_do_not_fit_together_are_refused_with_the_rule_they_break() {
    for (options, said) in [
        (&["--r2=10"][..], "--k2 must be at least 1.001 times the sum of --r1 and --r2"),
        (&["--r2=10", "--k2=11.0109"], "--k2 must be at least 1.001 times"),
        (&["--r1=.1", "--r2=.7", "--k2=.8"], "--k2 must be at least 1.001 times"),
        (&["--r2=0.5"], "--r2 must be 1.001 to 30 times --r1"),
        (&["--r1=2"], "--r2 must be 1.001 to 30 times --r1"),
        (&["--r2=1.0009"], "--r2 must be 1.001 to 30 times --r1"),
        (&["--r1=.0666"], "--r2 must be 1.001 to 30 times --r1"),
        (
            &["--method=classic", "--r2=3"],
            "--method classic needs --r1, --r2 and --k2 in the ratio 1 : 2 : 5",
        ),
    ] {
        assert_refused(options, &[said]);
    }
}

#[test]
fn the_ends_of_the_range_of_scenes_are_accepted() {
    for (r1, r2, k2) in [
        ("1", "2", "3.003"),
        ("0.7", "21", "21.7217"),
        ("0.1", "0.1001", "1"),
        ("0.3", "9", "9.3093"),
    ] {
        output_of(&["--frames=0", "--r1", r1, "--r2", r2, "--k2", k2]);
    }
}

#[test]
fn the_same_scene_in_other_units_is_donut_cs() {
    let own = output_of(&["--frames=2", "--fps=0"]);
    // In floating point 0.35 / 0.07 is less than 5.
    for [r1, r2, k2] in [["20", "40", "100"], ["0.07", "0.14", "0.35"], ["0.23", "0.46", "1.15"]] {
        let scaled = ["--r1", r1, "--r2", r2, "--k2", k2, "--frames=2", "--fps=0"];
        assert_eq!(output_of(&scaled), own);
        assert_eq!(output_of(&[&scaled[..], &["--method=classic"]].concat()), own);
    }
}

#[test]
fn negative_angles_and_spins_work() {
    output_of(&["--frames=3", "--fps=0", "-A", "-1.5", "-B", "-2", "--spin", "-0.04,0.02"]);
}

/// The escape sequence that sets a colour at the start of each frame.
fn sequence(color: &str) -> String {
    let stream = output_of(&["--frames=1", "--width=1", "--height=1", "--color", color]);
    stream.split("\x1b[H").nth(1).unwrap().split('\n').next().unwrap().into()
}

#[test]
fn every_colour_that_the_help_lists_is_a_different_one() {
    let help = output_of(&["--help"]);
    let colors = help.split("The names are").nth(1).unwrap().split('.').next().unwrap();
    let colors = colors.replace(" and ", ",");
    let sequences = colors.split(',').map(|color| sequence(color.trim()));
    assert_eq!(sequences.collect::<std::collections::BTreeSet<_>>().len(), 16);
}

#[test]
fn gray_is_grey() {
    for (gray, grey) in [("gray", "grey"), ("dark_gray", "dark_grey"), ("GRAY", "grey")] {
        assert_eq!(sequence(gray), sequence(grey));
    }
}

#[test]
fn the_hash_of_a_colour_may_be_left_out_because_a_shell_takes_it_for_a_comment() {
    assert_eq!(sequence("ff8800"), "\x1b[38;2;255;136;0m");
    for color in ["ff8800", "FF8800", "#ff8800"] {
        assert_eq!(sequence(color), sequence("#ff8800"));
    }
}

#[test]
fn colour_is_color() {
    let [colour, color] = ["--colour=red", "--color=red"];
    assert_eq!(output_of(&[colour, "--frames=1"]), output_of(&[color, "--frames=1"]));
}

#[test]
fn colours_that_do_not_exist_are_refused() {
    for color in
        ["crimson", "256", "-1", "#12345", "#1234567", "#12345g", "#+12345", "+12345", "", "reset"]
    {
        let said =
            ["--color", &format!("'{color}'"), "a name from --help", "0 to 255", "'#rrggbb'"];
        assert_refused(&["--color", color], &said);
    }
}

#[test]
fn the_last_of_a_repeated_option_wins() {
    let last = output_of(&["--frames=1", "--color=red", "-A", "2", "--spin=3,4"]);
    let options = ["--color=cyan", "-A", "1", "--spin=1,2", "--frames=7"];
    let repeated = [&options[..], &["--frames=1", "--color=red", "-A", "2", "--spin=3,4"]].concat();
    assert_eq!(output_of(&repeated), last);
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
    let stream = output_of(&["--frames=3", "--fps=0"]);
    assert_eq!(stream.len(), 4 + 3 * 1764);
    assert!(stream.starts_with("\x1b[2J\x1b[H\n"));
    for frame in stream.as_bytes()[4..].chunks(1764) {
        assert!(frame.starts_with(b"\x1b[H\n") && frame.ends_with(b"\n"));
        assert_eq!(frame.iter().filter(|&&byte| byte == b'\n').count(), 23);
    }
}

#[test]
fn the_size_of_a_pipe_is_that_of_the_options() {
    let stream = output_of(&["--frames=1", "--width=7", "--height=3"]);
    let rows: Vec<_> = stream.strip_prefix("\x1b[2J\x1b[H\n").unwrap().lines().collect();
    assert_eq!(rows.iter().map(|row| row.len()).collect::<Vec<_>>(), [6, 6, 6]);
}

#[test]
fn no_frames_are_no_bytes() {
    assert_eq!(output_of(&["--frames=0"]), "");
}

#[test]
fn a_colour_wraps_each_frame_in_one_sequence_and_changes_nothing_else() {
    let plain = output_of(&["--frames=2", "--fps=0"]);
    for (color, sgr) in [
        ("cyan", "\x1b[38;5;14m"),
        ("dark_red", "\x1b[38;5;1m"),
        ("208", "\x1b[38;5;208m"),
        ("#0a7Fff", "\x1b[38;2;10;127;255m"),
    ] {
        let expected = plain.replace("\x1b[H", &format!("\x1b[0m\x1b[H{sgr}")) + "\x1b[0m";
        let expected = expected.replacen("\x1b[0m", "", 1);
        let options = ["--frames=2", "--fps=0", "--color", color];
        let colored = donut(&options).env("NO_COLOR", "1").output().unwrap();
        assert_eq!(succeeded(colored), expected);
    }
}

#[test]
fn a_reader_that_goes_away_ends_it_silently() {
    let mut child =
        donut(&["--fps=0"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdout.as_mut().unwrap().read_exact(&mut [0; 1000]).unwrap();
    drop(child.stdout.take());
    succeeded(wait(child));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_one_message_and_exit_code_1() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let output = donut(&["--frames=1"]).stdout(full).output().unwrap();
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    assert!(message.starts_with("donut: "), "{message}");
}

#[cfg(unix)]
#[test]
fn on_a_pipe_a_signal_ends_it_by_default() {
    use std::os::unix::process::ExitStatusExt;
    for (name, number) in [("HUP", 1), ("INT", 2), ("QUIT", 3), ("TERM", 15)] {
        let command = format!("ulimit -c 0; exec {}", env!("CARGO_BIN_EXE_donut"));
        let mut shell = Command::new("sh");
        let mut child = shell.args(["-c", &command]).stdout(Stdio::piped()).spawn().unwrap();
        child.stdout.as_mut().unwrap().read_exact(&mut [0; 1000]).unwrap();
        let mut kill = Command::new("kill");
        assert!(kill.args(["-s", name, &child.id().to_string()]).status().unwrap().success());
        assert_eq!(wait(child).status.signal(), Some(number));
    }
}

#[cfg(unix)]
#[test]
fn every_frame_is_one_write() {
    use std::os::{fd::OwnedFd, unix::net::UnixDatagram};
    let (reader, writer) = UnixDatagram::pair().unwrap();
    let options = ["--frames=3", "--fps=5", "--color=red"];
    let child = donut(&options).stdout(OwnedFd::from(writer)).spawn().unwrap();
    reader.set_read_timeout(Some(Duration::from_secs(10))).unwrap();
    let packets = [0; 3].map(|_| reader.recv(&mut [0; 4000]).unwrap());
    succeeded(wait(child));
    let frame = 1764 + "\x1b[38;5;9m\x1b[0m".len();
    assert_eq!(packets, [4 + frame, frame, frame]);
}

#[cfg(unix)]
#[test]
fn a_pipe_whose_writes_do_not_wait_gets_all_the_same() {
    use std::os::{fd::OwnedFd, unix::net::UnixStream};
    let (mut reader, writer) = UnixStream::pair().unwrap();
    // Another program may leave a terminal or a pipe like this, if they share it.
    writer.set_nonblocking(true).unwrap();
    let options = ["--frames=300", "--fps=0"];
    let child = donut(&options).stdout(OwnedFd::from(writer)).spawn().unwrap();
    sleep(Duration::from_millis(300));
    let mut stream = Vec::new();
    reader.read_to_end(&mut stream).unwrap();
    succeeded(wait(child));
    assert_eq!(stream.len(), 4 + 300 * 1764);
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

/// Numbers of a range, its ends among them.
fn number(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![2 => Just(low), 2 => Just(high), 6 => low..=high]
}

/// How many times larger one length is than another. Nearly half of them are barely larger.
fn ratio(most: f64) -> impl Strategy<Value = f64> {
    let barely = (-16.0..0.0).prop_map(|power| 1.0 + 10_f64.powf(power));
    prop_oneof![4 => barely, 1 => Just(most), 4 => 1.0..=most]
}

fn angle() -> impl Strategy<Value = f64> {
    let special = [0.0, 1e-300, -1e-300, std::f64::consts::FRAC_PI_2, 3_345_245.0 * 0.04];
    prop_oneof![number(-1e9, 1e9), -7.0..7.0, prop::sample::select(special.to_vec())]
}

fn size(most: u16) -> impl Strategy<Value = u16> {
    prop_oneof![1 => 1..=2_u16, 1 => Just(most), 4 => 1..=most]
}

/// R1, R2 and K2: some of them do not fit together, by rounding or by being out of range.
fn lengths() -> impl Strategy<Value = [f64; 3]> {
    let unit = prop_oneof![Just(1.0), Just(1e-6), (-6.0..3.0).prop_map(|power| 10_f64.powf(power))];
    let scene = (unit, ratio(30.0), ratio(1e6));
    let any = scene.prop_map(|(r1, ring, viewer)| [r1, r1 * ring, r1 * (1.0 + ring) * viewer]);
    prop_oneof![1 => Just([1.0, 2.0, 5.0]), 3 => any]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 500,
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn whatever_the_options_it_draws_or_says_why_not(
        (width, height) in (size(300), size(150)),
        [a, b, da, db] in [angle(), angle(), angle(), angle()],
        [r1, r2, k2] in lengths(),
        aspect in prop_oneof![Just(2.0), number(0.1, 10.0)],
        method in prop::sample::select(vec!["auto", "classic", "exact"]),
    ) {
        let options = [
            format!("--width={width}"),
            format!("--height={height}"),
            format!("-A{a}"),
            format!("-B{b}"),
            format!("--spin={da},{db}"),
            format!("--r1={r1}"),
            format!("--r2={r2}"),
            format!("--k2={k2}"),
            format!("--aspect={aspect}"),
            format!("--method={method}"),
        ];
        let output = donut(&["--frames=2", "--fps=0"]).args(&options).output().unwrap();
        let (stream, said) = (output.stdout, String::from_utf8_lossy(&output.stderr));
        match output.status.code() {
            Some(0) => {
                prop_assert_eq!(said, "");
                let frame = usize::from(width) * usize::from(height) + 4;
                prop_assert_eq!(stream.len(), 4 + 2 * frame);
                for frame in stream[4..].chunks(frame) {
                    let cells = frame.strip_prefix(b"\x1b[H").unwrap();
                    prop_assert!(cells.iter().all(|cell| b".,-~:;=!*#$@ \n".contains(cell)));
                }
            }
            Some(2) => {
                prop_assert!(said.starts_with("error: "), "{}", said);
                prop_assert!(stream.is_empty());
            }
            code => prop_assert!(false, "{code:?}: {said}"),
        }
    }
}
