//! Pictures, compared byte for byte. Those of classic at 80x22 are compared with frames recorded from
//! donut.c itself. Other sizes, and the pictures of exact, are compared with frames that this program
//! has drawn before.

mod program;

use std::io::{Read, Write, stderr};
use std::process::{Command, Stdio};
use std::{env, fs};

use program::{Program, frames, in_time};
use sha2::{Digest, Sha256};

fn output_of(options: &str) -> String {
    let donut = Program::start(env!("CARGO_BIN_EXE_donut"), options, Stdio::piped());
    let (code, written, message) = donut.output();
    assert_eq!(code, Some(0), "{message}");
    written
}

fn sha256(text: &str) -> String {
    Sha256::digest(text).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// An x86 without SSE2 rounds the numbers of classic otherwise than donut.c on all other processors.
const ROUNDS_AS_DONUT_C: bool = cfg!(any(not(target_arch = "x86"), target_feature = "sse2"));

/// Compares a frame with the one stored under this name. If the two differ, the message shows both.
fn assert_golden(name: &str, frame: &str) {
    if !ROUNDS_AS_DONUT_C && !name.starts_with("exact") {
        return;
    }
    let path = format!("{}/tests/golden/{name}.txt", env!("CARGO_MANIFEST_DIR"));
    let golden = fs::read_to_string(path).unwrap();
    assert!(frame == golden, "{name}\nexpected:\n{golden}\ndrawn:\n{frame}");
}

#[test]
fn the_first_10000_frames_are_those_recorded_from_donut_c() {
    let stream = output_of("--frames=10000 --fps=0");
    let frames = frames(&stream);
    // Five of these frames are the first that a common mistake changes:
    // - 17: theta and phi are in f64,
    // - 49: A and B are in f64,
    // - 58: the compiler has `-ffast-math`,
    // - 92: products and sums are fused, so that they are rounded only once,
    // - 974: products are taken out of the inner loop, which changes the order of the multiplications.
    for n in [0, 17, 49, 58, 92, 974, 9999] {
        assert_golden(&format!("donut.c-frame-{n}"), frames[n]);
    }
    // The SHA-256 of what donut.c writes after the `ESC [ 2 J` at its start, in its first 10,000 frames.
    // donut.c was compiled by `gcc -std=gnu89 -O2` on x86-64.
    let expected = "351752a14d2a6de405e84f614d4011f429dc0350d84a4b233d52b7aecae65ff8";
    assert!(sha256(&stream[4..]) == expected || !ROUNDS_AS_DONUT_C);
}

/// donut.c's last 32 steps, which it reaches after nearly nine days: from A = 2^20 on, adding 0.04 changes
/// nothing. The frame was recorded from donut.c, started close to its end.
#[test]
fn in_the_end_donut_c_stands_still() {
    let stream = output_of("-A 1048574 -B 524287 --frames=50 --fps=0");
    let frames = frames(&stream);
    assert_eq!(frames.windows(2).rposition(|pair| pair[0] != pair[1]), Some(31));
    assert_golden("donut.c-frame-22918663", frames[49]);
}

/// tests/unit/donut.rs is a program as well. It never ends by itself.
#[test]
fn the_donut_shaped_source_is_a_program_that_writes_donut_cs_frames() {
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/unit/donut.rs");
    let program = concat!(env!("CARGO_TARGET_TMPDIR"), "/donut-shaped");
    let rustc = env::var("RUSTC").unwrap_or("rustc".into());
    if Command::new(&rustc).arg("--version").output().is_err() || !ROUNDS_AS_DONUT_C {
        return drop(writeln!(stderr(), "skipped: no {rustc}, or an x86 without SSE2"));
    }
    let options = ["--edition=2024", "-O", "-o", program, source];
    assert!(Command::new(&rustc).args(options).status().unwrap().success());
    let mut shaped = Program::start(program, "", Stdio::piped());
    let expected = output_of("--frames=5 --fps=0");
    let mut written = vec![0; expected.len()];
    let mut pipe = shaped.0.stdout.take().unwrap();
    let written = in_time(move || pipe.read_exact(&mut written).map(|()| written));
    assert!(written.unwrap() == expected.as_bytes());
}

#[test]
fn other_pictures_are_those_stored() {
    for (method, width, height) in [
        ("classic", 40, 12),
        ("classic", 120, 36),
        ("exact", 80, 22),
        ("exact", 120, 36),
        ("exact", 200, 60),
    ] {
        let pose = "-A=1 -B=0.5 --frames=1";
        let options = format!("{pose} --method={method} --width={width} --height={height}");
        assert_golden(&format!("{method}-{width}x{height}"), frames(&output_of(&options))[0]);
    }
}

/// `.ci/run` runs this test twice, in a debug build and in a release build. So the pictures must
/// depend neither on the optimiser nor on the systems that CI runs on.
#[test]
fn the_first_300_frames_of_exact_have_the_stored_hash() {
    let stream = output_of("--method=exact --frames=300 --fps=0");
    let expected = "8b67a629f8c5cd2b925ecaeda45caa26b8c7c048c7afec7875ced76d4e16f166";
    assert_eq!(sha256(&stream), expected);
}
