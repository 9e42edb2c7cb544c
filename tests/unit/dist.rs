use super::*;
use clap_complete::{Shell, generate};
use clap_mangen::Man;

/// The manual page and the completions, as file names and contents.
fn dist() -> [(&'static str, Vec<u8>); 4] {
    let mut page = Vec::new();
    Man::new(Options::command()).render(&mut page).unwrap();
    let completion = |shell| {
        let mut script = Vec::new();
        generate(shell, &mut Options::command(), "donut", &mut script);
        script
    };
    [
        ("donut.1", page),
        ("donut.bash", completion(Shell::Bash)),
        ("_donut", completion(Shell::Zsh)),
        ("donut.fish", completion(Shell::Fish)),
    ]
}

#[test]
fn the_manual_page_and_the_completions_say_what_the_options_are() {
    for (name, contents) in dist() {
        let path = format!("{}/tests/dist/{name}", env!("CARGO_MANIFEST_DIR"));
        if env::var_os("UPDATE").is_some() {
            std::fs::write(&path, &contents).unwrap();
        }
        let stored = std::fs::read(&path).unwrap();
        assert!(
            stored == contents,
            "tests/dist/{name} is stale: run UPDATE=1 cargo test, and commit"
        );
    }
}
