//! Pictures, byte for byte: donut.c's own, recorded from the C program, and ours at other sizes.

use std::fs;
use std::process::Command;
use std::sync::LazyLock;

use sha2::{Digest, Sha256};

/// The program's standard output.
fn donut(options: &[&str]) -> Vec<u8> {
    let output = Command::new(env!("CARGO_BIN_EXE_donut")).args(options).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    output.stdout
}

/// What it prints in its first 10,000 frames. It runs once for all the tests that look at them.
static FIRST_10_000: LazyLock<Vec<u8>> = LazyLock::new(|| donut(&["--frames=10000", "--fps=0"]));

/// The frames of a stream, each without its `ESC [ H`.
fn frames(stream: &[u8]) -> Vec<String> {
    let stream = String::from_utf8(stream.to_vec()).unwrap();
    let stream = stream.strip_prefix("\x1b[2J\x1b[H").expect("a cleared screen");
    stream.split("\x1b[H").map(String::from).collect()
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Compares a frame with the one stored, and shows both where they differ.
fn assert_golden(name: &str, frame: &str) {
    let path = format!("{}/tests/golden/{name}.txt", env!("CARGO_MANIFEST_DIR"));
    let golden = fs::read_to_string(path).unwrap();
    assert!(frame == golden, "{name}\nexpected:{golden}\ndrawn:{frame}");
}

#[test]
fn frames_are_those_recorded_from_donut_c() {
    let frames = frames(&FIRST_10_000);
    // Those where a wrong port breaks first: 17 with the loops' angles in f64, 49 with A and B in
    // f64, 58 with fast-math, 92 with fused multiply-add, 974 with products taken out of the loop.
    for n in [0, 17, 49, 58, 92, 974, 9999] {
        assert_golden(&format!("donut.c-frame-{n}"), &frames[n]);
    }
}

#[test]
fn the_first_10000_frames_have_donut_cs_hash() {
    // sha256 of donut.c's output, compiled by gcc -std=gnu89 -O2 on x86-64, after `ESC [ 2 J`.
    let expected = "351752a14d2a6de405e84f614d4011f429dc0350d84a4b233d52b7aecae65ff8";
    assert_eq!(sha256(&FIRST_10_000[4..]), expected);
}

/// Compares one pose at these sizes with the frames stored.
fn assert_as_it_was(method: &str, sizes: &[(&str, &str)]) {
    for (width, height) in sizes {
        let pose = ["-A=1", "-B=0.5", "--frames=1", "--method", method];
        let stream = donut(&[&pose[..], &["--width", width, "--height", height]].concat());
        assert_golden(&format!("{method}-{width}x{height}"), &frames(&stream)[0]);
    }
}

#[test]
fn classic_is_as_it_was_at_other_sizes() {
    assert_as_it_was("classic", &[("40", "12"), ("120", "36")]);
}

#[test]
fn exact_is_as_it_was() {
    assert_as_it_was("exact", &[("80", "22"), ("120", "36"), ("200", "60")]);
}

/// The one hash stands for debug and release builds, and for every machine.
#[test]
fn the_first_300_frames_of_exact_have_the_same_hash_in_every_build() {
    let stream = donut(&["--method=exact", "--frames=300", "--fps=0"]);
    let expected = "8b67a629f8c5cd2b925ecaeda45caa26b8c7c048c7afec7875ced76d4e16f166";
    assert_eq!(sha256(&stream), expected);
}

#[test]
fn auto_is_classic_at_donut_cs_size_and_exact_elsewhere() {
    let size = ["--width=120", "--height=36", "--frames=20", "--fps=0"];
    let exact = [&size[..], &["--method=exact"]].concat();
    assert!(donut(&size) == donut(&exact));
    let own = ["--frames=20", "--fps=0"];
    let classic = [&own[..], &["--method=classic"]].concat();
    assert!(donut(&own) == donut(&classic));
}

#[test]
fn classic_freezes_where_donut_c_does_and_exact_does_not() {
    let late = ["-A=1048560", "-B=524280", "--frames=260", "--fps=0"];
    let last_change = |method: &str| {
        let frames = frames(&donut(&[&late[..], &["--method", method]].concat()));
        (1..260).rfind(|&n| frames[n] != frames[n - 1])
    };
    assert_eq!(last_change("classic"), Some(256));
    assert_eq!(last_change("exact"), Some(259));
    assert_eq!(last_change("auto"), Some(259));
}
