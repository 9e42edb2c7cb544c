//! What a panic leaves on the terminal.

use super::*;

#[path = "../pty/mod.rs"]
#[allow(dead_code, reason = "tests/terminal.rs uses the rest")]
mod pty;

use pty::Pty;

#[test]
#[ignore = "panics on purpose; a test below runs it on a terminal of its own"]
fn a_donut_that_panics() {
    // No command line can ask for such a ring. Some of it is outside of the picture, which makes the
    // program panic in its first frame, just after it has entered the terminal.
    let ring = Options { r2: -3.0, k2: Some(5.0), ..Options::parse_from(["donut"]) };
    run(&Options { method: Some(Method::Classic), ..ring }).unwrap();
}

#[test]
fn a_panic_restores_the_terminal_and_is_shown() {
    let program = env::current_exe().unwrap();
    let test = ["--ignored", "--nocapture", "--exact", "tests::panic::a_donut_that_panics"];
    let pty = Pty::run(program.to_str().unwrap(), &test, (80, 100));
    pty.assert_ends(101);
    assert_eq!(pty.written().matches("\x1b[?1049l").count(), 1);
    let is_shown = |line: &String| line.contains("panicked at src/main.rs");
    assert!(pty.lines().iter().any(is_shown), "{:?}", pty.lines());
}
