//! What a panic leaves on the terminal.

use super::*;

#[path = "../pty/mod.rs"]
#[allow(dead_code, reason = "tests/terminal.rs uses the rest")]
mod pty;

use pty::Pty;

#[test]
#[ignore = "panics on purpose; the next test runs it on a terminal of its own"]
fn a_donut_that_panics() {
    // No command line can ask for rows without cells. They make the program panic in its first
    // frame, just after it has changed the terminal's settings.
    run(&Options { width: Some(0), ..Options::parse_from(["donut"]) }).unwrap();
}

#[test]
fn a_panic_restores_the_terminal_and_is_shown() {
    let program = env::current_exe().unwrap();
    let panics = ["--ignored", "--nocapture", "--exact", "tests::panic::a_donut_that_panics"];
    let pty = Pty::run(program.to_str().unwrap(), &panics, (80, 100));
    pty.assert_ends(101);
    assert_eq!(pty.written().matches("\x1b[?1049l").count(), 1);
    assert!(pty.written().contains("panicked at src/main.rs"), "{:?}", pty.lines());
}
