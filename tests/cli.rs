//! The command line: which options are accepted, what goes into a pipe, and how the program ends.

use std::io::Read;
use std::process::{Child, ChildStdout, Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use proptest::prelude::*;

const DONUT: &str = env!("CARGO_BIN_EXE_donut");

fn command(options: &[&str]) -> Command {
    let mut command = Command::new(DONUT);
    // In a pipe or a file, the program writes its escape codes whatever the terminal is.
    command.args(options).env("TERM", "dumb");
    command
}

/// More than any test reads. Without a limit, a program that never stops writing would fill the memory.
const MOST_BYTES: u64 = 1_000_000;

/// Waits for the program to end, and returns its exit status and its output.
fn wait(mut child: Child) -> Output {
    let (mut stdout, mut stderr) = (Vec::new(), Vec::new());
    if let Some(pipe) = child.stdout.take() {
        pipe.take(MOST_BYTES).read_to_end(&mut stdout).unwrap();
    }
    if let Some(mut pipe) = child.stderr.take() {
        pipe.read_to_end(&mut stderr).unwrap();
    }
    Output { status: child.wait().unwrap(), stdout, stderr }
}

/// Runs the program to its end.
fn run(command: &mut Command) -> Output {
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    wait(command.spawn().unwrap())
}

/// Checks that the program refuses these options: exit code 2, nothing on stdout, and a message with all
/// the texts of `expected` in it.
fn assert_refused(options: &[&str], expected: &[&str]) {
    let refused = run(&mut command(options));
    let message = String::from_utf8(refused.stderr).unwrap();
    assert_eq!((refused.status.code(), &*refused.stdout), (Some(2), &b""[..]), "{options:?}");
    for text in expected {
        assert!(message.contains(text), "{options:?}: no {text:?} in {message}");
    }
    assert!(!message.contains("panicked"), "{message}");
}

/// Checks that the exit code is 0 and that stderr is empty, and returns what is on stdout.
fn succeeded(output: Output) -> String {
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), &*message), (Some(0), ""));
    String::from_utf8(output.stdout).unwrap()
}

fn output_of(options: &[&str]) -> String {
    succeeded(run(&mut command(options)))
}

#[test]
fn both_helps_have_headings_defaults_and_values_and_no_line_longer_than_80_columns() {
    for help in ["-h", "--help"].map(|help| output_of(&[help])) {
        for heading in ["Motion:", "Look:", "Size:", "Geometry:", "Keys:", "Examples:"] {
            assert!(help.lines().any(|line| line == heading), "no {heading} in {help}");
        }
        for text in ["[default: 30]", "classic", "exact"] {
            assert!(help.contains(text), "no {text} in {help}");
        }
        assert!(help.lines().all(|line| line.chars().count() <= 80), "{help}");
    }
}

#[test]
fn numbers_are_accepted_within_their_range() {
    let size = "a whole number from 1 to 4096";
    let angle = "a number from -1000 to 1000";
    for (options, allowed, accepted, refused) in [
        ("--width --height", size, "1 4096", "0 4097 -5 65536 1.5 x  1e3"),
        ("--fps", "a number from 0 to 1000", "0 1000", "-1 -0.5 1000.1 1001 nan inf -inf fast "),
        (
            "--frames",
            "a whole number from 0 to 1000000000000",
            "0 1000000000000",
            "-1 1000000000001 18446744073709551616 1.5 many ",
        ),
        ("--aspect", "a number from 0.1 to 10", "0.1 10", "0 0.09 10.1 11 -2 nan wide "),
        ("-A -B", angle, "-1000 -1.5 1e3", "1000.001 -1000.001 2e9 nan inf -inf north 1,2 "),
        (
            "--spin",
            angle,
            "-1e3,1e3 -0.04,0.02",
            "2e9,0 0,1000.001 inf,0 a,b 0.04, ,0.02 , 1,2,3 1,2,",
        ),
        ("--spin", "two angles with a comma", "0,0", "0.04 0.04;0.02  -"),
        ("--r2", "a number from 1.01 to 30", "1.01 3.99", "1.009 30.1 -2 nan "),
        ("--k2", "invalid float literal", "3.003 1000000", "big 1,2"),
    ] {
        for option in options.split(' ') {
            for value in accepted.split(' ') {
                // The last --frames wins, so one frame is drawn even where the option is --frames.
                output_of(&[option, value, "--frames=1"]);
            }
            // The empty text between two blanks, or after the last one, is refused as well.
            for value in refused.split(' ') {
                assert_refused(&[option, value], &[option, &format!("'{value}'"), allowed]);
            }
        }
    }
}

#[test]
fn options_that_do_not_fit_together_are_refused() {
    let viewer = "(1.001 times the sum of 1 and --r2) to 1000000";
    let classic = "--method classic needs --r2 2 and --k2 5";
    for (options, values, rule) in [
        ("--r2=10", "--k2 is 5, but must be from 11.011", viewer),
        ("--r2=10 --k2=11.0109", "--k2 is 11.0109, but must be from 11.011", viewer),
        ("--k2=3.0029999999999997", "--k2 is 3.0029999999999997, but must be from 3.003", viewer),
        ("--k2=1000000.1", "--k2 is 1000000.1, but must be from 3.003", viewer),
        ("--k2=-5", "--k2 is -5, but must be from 3.003", viewer),
        ("--k2=nan", "--k2 is NaN, but must be from 3.003", viewer),
        ("--method=classic --r2=3", "but these are 3 and 5", classic),
        ("--method=classic --k2=5.000001", "but these are 2 and 5.000001", classic),
    ] {
        assert_refused(&options.split(' ').collect::<Vec<_>>(), &[values, rule]);
    }
}

#[test]
fn the_least_distance_that_a_message_names_is_accepted() {
    // In f64, 1.001 * (1 + 15.06) is a little more than 16.07606.
    for r2 in ["1.01", "30", "15.06", "1.1", "2.2", "1.2345678901234567", "29.999999999999996"] {
        let r2 = format!("--r2={r2}");
        let refused = run(&mut command(&["--frames=0", &r2, "--k2=1"]));
        let message = String::from_utf8(refused.stderr).unwrap();
        let (_, least) = message.split_once("must be from ").unwrap();
        output_of(&["--frames=0", &r2, "--k2", least.split(' ').next().unwrap()]);
    }
}

/// The escape sequence that sets a colour at the start of each frame.
fn sequence(color: &str) -> String {
    let stream = output_of(&["--frames=1", "--width=1", "--height=1", "--color", color]);
    stream.split("\x1b[H").nth(1).unwrap().split('\n').next().unwrap().into()
}

#[test]
fn the_help_lists_16_colours_and_all_of_them_differ() {
    let help = output_of(&["--help"]);
    let colors = help.split("The names are").nth(1).unwrap().split('.').next().unwrap();
    let colors = colors.replace(" and ", ",");
    let sequences = colors.split(',').map(|color| sequence(color.trim()));
    assert_eq!(sequences.collect::<std::collections::BTreeSet<_>>().len(), 16);
}

#[test]
fn colours_may_be_written_in_several_ways() {
    assert_eq!(sequence("ff8800"), "\x1b[38;2;255;136;0m");
    for (one, other) in [
        ("gray", "grey"),
        ("dark_gray", "dark_grey"),
        ("GRAY", "grey"),
        ("FF8800", "ff8800"),
        ("#ff8800", "ff8800"),
    ] {
        assert_eq!(sequence(one), sequence(other));
    }
    let [colour, color] = ["--colour=red", "--color=red"];
    assert_eq!(output_of(&[colour, "--frames=1"]), output_of(&[color, "--frames=1"]));
}

#[test]
fn colours_that_do_not_exist_are_refused() {
    for color in "crimson 256 -1 #12345 #1234567 #12345g #+12345 +12345  reset".split(' ') {
        let value = format!("'{color}'");
        let expected = ["--color", &value, "a name from --help", "0 to 255", "'#rrggbb'"];
        assert_refused(&["--color", color], &expected);
    }
}

#[test]
fn an_option_that_is_given_twice_has_its_last_value() {
    let last = output_of(&["--frames=1", "--color=red", "-A", "2", "--spin=3,4"]);
    let options = ["--color=cyan", "-A", "1", "--spin=1,2", "--frames=7"];
    let repeated = [&options[..], &["--frames=1", "--color=red", "-A", "2", "--spin=3,4"]].concat();
    assert_eq!(output_of(&repeated), last);
}

#[test]
fn unknown_options_and_arguments_are_refused_and_no_frames_are_nothing() {
    assert_refused(&["--speed", "3"], &["--speed"]);
    assert_refused(&["--method", "magic"], &["--method", "'magic'", "classic, exact"]);
    assert_refused(&["80"], &["'80'"]);
    assert_refused(&["--width"], &["--width"]);
    assert_eq!(output_of(&["--frames=0"]), "");
}

#[test]
fn a_colour_is_set_and_reset_in_each_frame() {
    let plain = output_of(&["--frames=2", "--fps=0"]);
    let (clear, frames) = plain.split_once("\x1b[H").unwrap();
    for (color, set) in [
        ("cyan", "\x1b[38;5;14m"),
        ("dark_red", "\x1b[38;5;1m"),
        ("208", "\x1b[38;5;208m"),
        ("#0a7Fff", "\x1b[38;2;10;127;255m"),
    ] {
        let frames = frames.split("\x1b[H").map(|rows| format!("\x1b[H{set}{rows}\x1b[0m"));
        let expected = clear.to_owned() + &frames.collect::<String>();
        let mut command = command(&["--frames=2", "--fps=0", "--color", color]);
        assert_eq!(succeeded(run(command.env("NO_COLOR", "1"))), expected);
    }
}

#[test]
fn the_program_ends_silently_when_its_reader_goes_away() {
    let mut child =
        command(&["--fps=0"]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    child.stdout.as_mut().unwrap().read_exact(&mut [0; 1000]).unwrap();
    drop(child.stdout.take());
    succeeded(wait(child));
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_gives_one_line_of_message_and_exit_code_1() {
    let full = std::fs::OpenOptions::new().write(true).open("/dev/full").unwrap();
    let mut command = command(&["--frames=1"]);
    let output = wait(command.stdout(full).stderr(Stdio::piped()).spawn().unwrap());
    let message = String::from_utf8(output.stderr).unwrap();
    assert_eq!((output.status.code(), message.lines().count()), (Some(1), 1), "{message}");
    assert!(message.starts_with("donut: "), "{message}");
}

#[cfg(unix)]
#[test]
fn in_a_pipe_even_a_full_one_signals_have_their_default_action() {
    use portable_pty::{CommandBuilder, PtySize, native_pty_system};
    use rustix::process::{Pid, Signal, kill_process};
    for (signal, description) in [
        (Signal::HUP, "Hangup"),
        (Signal::INT, "Interrupt"),
        (Signal::QUIT, "Quit"),
        (Signal::TERM, "Terminated"),
    ] {
        let pipe = format!("{}/{description}-{}", env!("CARGO_TARGET_TMPDIR"), std::process::id());
        // This test may run in the background of a script, where SIGINT is ignored, and the program
        // would inherit that. So it is started by portable-pty, which first gives the four signals
        // their default action.
        let pty = native_pty_system().openpty(PtySize::default()).expect("a pseudo-terminal");
        let mut shell = CommandBuilder::new("sh");
        shell.cwd("/");
        shell.args(["-c", r#"ulimit -c 0; mkfifo "$1"; exec "$0" --fps=0 > "$1""#, DONUT, &pipe]);
        let mut child = pty.slave.spawn_command(shell).unwrap();
        let mut reader = std::fs::File::open(&pipe);
        while reader.is_err() {
            sleep(Duration::from_millis(1));
            reader = std::fs::File::open(&pipe);
        }
        reader.as_mut().unwrap().read_exact(&mut [0; 1000]).unwrap();
        // Now the pipe gets full.
        sleep(Duration::from_millis(200));
        let process = Pid::from_raw(child.process_id().unwrap() as i32).unwrap();
        kill_process(process, signal).unwrap();
        let start = Instant::now();
        while child.try_wait().unwrap().is_none() {
            assert!(start.elapsed() < Duration::from_secs(60), "{signal:?} does not end it");
            sleep(Duration::from_millis(1));
        }
        let status = child.wait().unwrap();
        assert!(status.signal().unwrap().starts_with(description), "{signal:?}: {status:?}");
        std::fs::remove_file(&pipe).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn every_frame_is_one_write() {
    use std::os::{fd::OwnedFd, unix::net::UnixDatagram};
    // On a datagram socket, each write is a packet of its own.
    let (reader, writer) = UnixDatagram::pair().unwrap();
    let options = ["--frames=3", "--fps=0", "--color=red"];
    let child = command(&options).stdout(OwnedFd::from(writer)).spawn().unwrap();
    let packets = [0; 3].map(|_| reader.recv(&mut [0; 4000]).unwrap());
    succeeded(wait(child));
    let frame = 1764 + "\x1b[38;5;9m\x1b[0m".len();
    assert_eq!(packets, [4 + frame, frame, frame]);
}

#[cfg(unix)]
#[test]
fn a_nonblocking_pipe_gets_every_byte_all_the_same() {
    use std::os::{fd::OwnedFd, unix::net::UnixStream};
    let (mut reader, writer) = UnixStream::pair().unwrap();
    // A program that shares a terminal or a pipe with the donut may have made it nonblocking.
    writer.set_nonblocking(true).unwrap();
    let options = ["--frames=300", "--fps=0"];
    let child = command(&options).stdout(OwnedFd::from(writer)).spawn().unwrap();
    sleep(Duration::from_millis(300));
    let mut stream = Vec::new();
    reader.by_ref().take(MOST_BYTES).read_to_end(&mut stream).unwrap();
    succeeded(wait(child));
    assert_eq!(stream.len(), 4 + 300 * 1764);
}

/// Runs the program, lets a test read what it writes, and ends it.
fn while_it_writes<T>(options: &[&str], read: impl FnOnce(&mut ChildStdout) -> T) -> T {
    let mut child = command(options).stdout(Stdio::piped()).spawn().unwrap();
    let result = read(child.stdout.as_mut().unwrap());
    child.kill().unwrap();
    child.wait().unwrap();
    result
}

/// How long it takes to read so many bytes.
fn time_to_read(stream: &mut ChildStdout, bytes: usize) -> Duration {
    let start = Instant::now();
    stream.read_exact(&mut vec![0; bytes]).unwrap();
    start.elapsed()
}

#[test]
fn frames_come_at_the_rate_asked_for() {
    // Frame 25 is due after half a second. On a busy machine it may be late, so one try of ten in which it
    // is not is enough: a program that is too slow never succeeds.
    let is_in_time = |_| {
        let start = Instant::now();
        while_it_writes(&["--fps=50"], |stream| time_to_read(stream, 4 + 26 * 1764));
        let time = start.elapsed();
        assert!(time >= Duration::from_millis(500), "{time:?}");
        time < Duration::from_millis(750)
    };
    assert!((0..10).any(is_in_time), "the frames come too slowly");
}

#[test]
fn after_a_stall_the_missed_frames_do_not_come_in_a_burst() {
    // A pipe holds only one or two frames of this size. A hundred more come due while nobody reads it.
    let (options, frame) = (["--fps=100", "--width=400", "--height=100"], 40_004);
    let time = while_it_writes(&options, |stream| {
        time_to_read(stream, 4 + frame);
        sleep(Duration::from_secs(1));
        time_to_read(stream, 30 * frame)
    });
    // A few frames come at once: those in the pipe, the one that was being written, and the two after it.
    assert!(time >= Duration::from_millis(200), "{time:?}");
}

/// Frames that are larger than a pipe come late when their reader pauses. In intervals of 400 ms:
///
/// - 0.0: The reader takes frame 0, and pauses.
/// - 1.0: Frame 1 is due. It fills the pipe, so the program waits for the reader.
/// - 2.5: The reader goes on. Frame 2 is half an interval late.
/// - 3.0: Frame 3 is due, half an interval after the pause. If frame 2's delay were added, frame 3 would
///   come a whole interval after the pause.
///
/// On a busy machine frame 3 may be late for other reasons. So this test tries up to ten times, and one
/// success is enough: a program that adds the delay never succeeds.
#[test]
fn a_frame_that_comes_late_does_not_delay_the_frames_after_it() {
    let (options, frame) = (["--fps=2.5", "--width=400", "--height=400"], 4 + 400 * 400);
    let interval = Duration::from_millis(400);
    let frame_3_is_in_time = |_| {
        let time = while_it_writes(&options, |stream| {
            time_to_read(stream, 4 + frame);
            sleep(interval.mul_f64(2.5));
            time_to_read(stream, 3 * frame)
        });
        time < interval
    };
    assert!((0..10).any(frame_3_is_in_time), "a frame that comes late delays the frames after it");
}

/// A number from `low` to `high`, and often one of the two themselves.
fn number(low: f64, high: f64) -> impl Strategy<Value = f64> {
    prop_oneof![2 => Just(low), 2 => Just(high), 6 => low..=high]
}

fn angle() -> impl Strategy<Value = f64> {
    let special = [0.0, 1e-300, -1e-300, std::f64::consts::FRAC_PI_2];
    prop_oneof![number(-1e3, 1e3), -7.0..7.0, prop::sample::select(special.to_vec())]
}

fn size(most: u16) -> impl Strategy<Value = u16> {
    prop_oneof![1 => 1..=2_u16, 1 => Just(most), 4 => 1..=most]
}

/// R2 and K2. K2 is refused where it is too small for R2.
fn lengths() -> impl Strategy<Value = (f64, f64)> {
    // Often K2 is only just large enough, because that is where rounding can make the program accept or
    // refuse it.
    let barely = (-16.0..0.0).prop_map(|power| 1.0 + 10_f64.powf(power));
    let distance = prop_oneof![4 => barely, 1 => Just(3e4), 4 => 1.0..=3e4];
    let any = (number(1.01, 30.0), distance).prop_map(|(r2, distance)| (r2, (1.0 + r2) * distance));
    prop_oneof![1 => Just((2.0, 5.0)), 3 => any]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 500,
        // A case that fails is printed, not kept in the source tree.
        failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn whatever_the_options_it_draws_or_says_why_not(
        (width, height) in (size(300), size(150)),
        [a, b, da, db] in [angle(), angle(), angle(), angle()],
        (r2, k2) in lengths(),
        aspect in prop_oneof![Just(2.0), number(0.1, 10.0)],
        method in prop::option::of(prop::sample::select(vec!["classic", "exact"])),
    ) {
        let mut options = vec![
            format!("--width={width}"),
            format!("--height={height}"),
            format!("-A{a}"),
            format!("-B{b}"),
            format!("--spin={da},{db}"),
            format!("--r2={r2}"),
            format!("--k2={k2}"),
            format!("--aspect={aspect}"),
        ];
        options.extend(method.map(|method| format!("--method={method}")));
        let output = run(command(&["--frames=2", "--fps=0"]).args(&options));
        let (stream, message) = (output.stdout, String::from_utf8_lossy(&output.stderr));
        match output.status.code() {
            Some(0) => {
                prop_assert_eq!(message, "");
                let frame = usize::from(width) * usize::from(height) + 4;
                prop_assert_eq!(stream.len(), 4 + 2 * frame);
                for frame in stream[4..].chunks(frame) {
                    let cells = frame.strip_prefix(b"\x1b[H").unwrap();
                    prop_assert!(cells.iter().all(|cell| b".,-~:;=!*#$@ \n".contains(cell)));
                }
            }
            Some(2) => {
                prop_assert!(message.starts_with("error: "), "{}", message);
                prop_assert!(stream.is_empty());
            }
            code => prop_assert!(false, "{code:?}: {message}"),
        }
    }
}
