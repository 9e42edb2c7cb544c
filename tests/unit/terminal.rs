use super::*;

#[path = "../pty/mod.rs"]
#[allow(dead_code, reason = "tests/terminal.rs uses the rest")]
mod pty;

use pty::Pty;

#[test]
#[ignore = "panics on purpose, on the terminal of the test below"]
fn a_donut_that_falls() {
    let (sender, actions) = mpsc::channel();
    let options = Options::parse_from(["donut", "--fps=0"]);
    let mut animation = Animation::new(&options, Output::Terminal).unwrap();
    animation.screen.watch(&sender).unwrap();
    // In a thread that does not draw, while another one does.
    thread::spawn(|| {
        thread::sleep(Duration::from_millis(200));
        panic!("the donut fell")
    });
    animation.play(&actions).unwrap();
}

#[test]
fn a_panic_restores_the_terminal_and_can_be_read() {
    let program = env::current_exe().unwrap();
    let falls = ["--ignored", "--nocapture", "--exact", "tests::terminal::a_donut_that_falls"];
    let mut pty = Pty::run(program.to_str().unwrap(), &falls, (80, 100), "xterm");
    assert_eq!(pty.exit(), 101);
    pty.assert_restored();
    assert_eq!(pty.written().matches("\x1b[?1049l").count(), 1);
    assert!(pty.lines().contains(&"the donut fell".to_string()), "{:?}", pty.lines());
}

#[test]
fn only_a_press_of_a_key_is_an_action() {
    use crossterm::event::KeyEventKind;
    let q = |kind| KeyEvent::new_with_kind(KeyCode::Char('q'), KeyModifiers::NONE, kind);
    assert_eq!(Action::of(q(KeyEventKind::Press)), Some(Action::Quit(None)));
    assert_eq!(Action::of(q(KeyEventKind::Release)), None);
}
