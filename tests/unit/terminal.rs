use super::*;

#[path = "../pty/mod.rs"]
#[allow(dead_code, reason = "tests/terminal.rs uses the rest")]
mod pty;

use pty::Pty;

#[test]
#[ignore = "panics on purpose, on the terminal of the test below"]
fn a_donut_that_panics() {
    // No command line asks for rows of no cells. They make it panic in its first frame, just after it
    // took the terminal.
    run(&Options { width: Some(0), ..Options::parse_from(["donut"]) }).unwrap();
}

#[test]
fn a_panic_restores_the_terminal_and_can_be_read() {
    let program = env::current_exe().unwrap();
    let panics = ["--ignored", "--nocapture", "--exact", "tests::terminal::a_donut_that_panics"];
    let mut pty = Pty::run(program.to_str().unwrap(), &panics, (80, 100), "xterm");
    assert_eq!(pty.exit(), 101);
    pty.assert_restored();
    assert_eq!(pty.written().matches("\x1b[?1049l").count(), 1);
    assert!(
        pty.lines().iter().any(|line| line.contains("panicked at src/main.rs")),
        "{:?}",
        pty.lines()
    );
}
