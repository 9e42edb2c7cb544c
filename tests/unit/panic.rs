//! What a panic leaves on the terminal.

use super::*;

#[path = "../pty/mod.rs"]
#[allow(dead_code, reason = "tests/terminal.rs uses the rest")]
mod pty;

use pty::Pty;
use signal_hook::consts::SIGUSR1;
use std::panic::{set_hook, take_hook};

#[test]
#[ignore = "panics on purpose; a test below runs it on a terminal of its own"]
fn a_donut_that_panics() {
    // No command line can ask for such a ring. Some of it is outside of the picture, which makes the
    // program panic in its first frame, just after it has entered the terminal.
    let ring = Options { r2: -3.0, k2: Some(5.0), ..Options::parse_from(["donut"]) };
    run(&Options { method: Some(Method::Classic), ..ring }).unwrap();
}

#[test]
#[ignore = "panics on purpose; tests below run it on a terminal of its own"]
fn a_donut_with_a_thread_that_panics_at_sigusr1() {
    let has_come = Arc::new(AtomicBool::new(false));
    flag::register(SIGUSR1, has_come.clone()).unwrap();
    thread::spawn(move || {
        while !has_come.load(SeqCst) {
            thread::sleep(Duration::from_millis(5));
        }
        panic!("here is SIGUSR1");
    });
    // The message takes a while, in which the loop goes on. It must not enter the terminal again.
    let hook = take_hook();
    set_hook(Box::new(move |info| {
        thread::sleep(Duration::from_millis(200));
        hook(info);
    }));
    run(&Options::parse_from(["donut"])).unwrap();
}

/// Runs one of the tests above on a terminal that does not read its output, until `start_reading` is
/// called.
fn run_unread(name: &str) -> Pty {
    let program = env::current_exe().unwrap();
    let test = ["--ignored", "--nocapture", "--exact", &format!("tests::panic::{name}")];
    Pty::run_unread(program.to_str().unwrap(), &test, (80, 100))
}

#[track_caller]
fn assert_restores_and_shows(pty: &Pty, message: &str) {
    pty.assert_ends(101);
    assert_eq!(pty.written().matches("\x1b[?1049l").count(), 1);
    assert!(pty.lines().iter().any(|line| line.contains(message)), "{:?}", pty.lines());
}

#[test]
fn a_panic_restores_the_terminal_and_is_shown() {
    let pty = run_unread("a_donut_that_panics");
    pty.start_reading(1 << 16, Duration::ZERO);
    assert_restores_and_shows(&pty, "panicked at src/main.rs");
}

#[test]
fn a_panic_in_another_thread_does_so_too() {
    let pty = run_unread("a_donut_with_a_thread_that_panics_at_sigusr1");
    pty.start_reading(1 << 16, Duration::ZERO);
    pty.wait_for("a frame", |pty| pty.written().contains("\x1b[?2026l"));
    pty.signal(rustix::process::Signal::USR1);
    assert_restores_and_shows(&pty, "here is SIGUSR1");
}

#[test]
fn a_panic_in_another_thread_ends_the_program_even_if_the_loop_is_stuck_in_a_write() {
    let pty = run_unread("a_donut_with_a_thread_that_panics_at_sigusr1");
    pty.wait_until_full();
    thread::sleep(Duration::from_millis(100)); // By then, the next frame is due.
    pty.signal(rustix::process::Signal::USR1);
    assert_eq!(pty.wait_for_exit(), 101);
    pty.assert_settings_restored();
}
