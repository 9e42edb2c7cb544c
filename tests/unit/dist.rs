//! The files of tests/dist: the manual page, which is written by hand, has the program's options and keys,
//! and the completions for shells are those that the options give.

use super::*;
use clap::builder::PossibleValuesParser;
use clap_complete::{Generator, Shell, generate};
use std::collections::BTreeSet;

/// The text of the manual page, without the escape codes that choose a font.
fn manual_page() -> String {
    let mut page = read("tests/dist/donut.1");
    for (escape, text) in [("\\fB", ""), ("\\fI", ""), ("\\fR", ""), ("\\-", "-"), ("\\ ", " ")] {
        page = page.replace(escape, text);
    }
    page
}

/// The entry for an option, a key or a value: the line with its names, and the text below it.
fn entry<'a>(page: &'a str, name: &str) -> (&'a str, &'a str) {
    page.split("\n.")
        .filter_map(|part| part.strip_prefix("TP\n")?.split_once('\n'))
        .find(|(line, _)| *line == name || line.split([' ', ',']).any(|word| word == name))
        .unwrap_or_else(|| panic!("the manual page has no entry for {name}"))
}

/// Checks that a text has this part in it. "From 0 to 10" is not a part of "from 0 to 100".
fn assert_contains(text: &str, part: &str) {
    let mut rests = text.match_indices(part).map(|(start, _)| &text[start + part.len()..]);
    let is_whole = |rest: &str| !rest.starts_with(|next: char| next.is_ascii_digit());
    assert!(rests.any(is_whole), "no {part:?} in {text:?}");
}

/// The names of the colours, in the order in which the help of --color lists them.
fn color_names() -> Vec<&'static str> {
    let help = Options::command().render_long_help().to_string().replace(" and ", ",");
    let (_, names) = help.leak().split_once("The names are ").unwrap();
    names.split('.').next().unwrap().split(',').map(str::trim).collect()
}

/// The range of an option, taken from the error message for another value.
fn range(option: &str) -> String {
    let value = if option == "--spin" { "x,x" } else { "x" };
    let refused = Options::try_parse_from(["donut", option, value]).err().unwrap().to_string();
    let start = refused.find("from ").unwrap();
    refused[start..].split([',', '\n']).next().unwrap().into()
}

#[test]
fn the_manual_page_has_exactly_the_options_and_their_values() {
    let (page, mut command) = (manual_page(), Options::command());
    command.build();
    let mut options = BTreeSet::new();
    for option in command.get_arguments() {
        let is_builtin = ["help", "version"].contains(&option.get_id().as_str());
        assert!(is_builtin || option.get_help_heading().is_some(), "{option}");
        let short = option.get_short().map(|letter| format!("-{letter}"));
        let long = option.get_long().map(|word| format!("--{word}"));
        for name in short.iter().chain(&long) {
            let (line, text) = entry(&page, name);
            for value in option.get_value_names().unwrap_or_default() {
                assert_contains(line, value);
            }
            for default in option.get_default_values() {
                assert_contains(text, &format!("The default is {}.", default.display()));
            }
        }
        for value in option.get_possible_values() {
            entry(&page, value.get_name());
        }
        options.extend(long);
    }
    // `--foreground` is an option of `timeout`.
    let page = page.replace("timeout --foreground", "timeout");
    let words = page.split(|c: char| c != '-' && !c.is_ascii_alphanumeric());
    let named = words.filter(|word| word.starts_with("--")).map(String::from);
    assert_eq!(named.collect::<BTreeSet<_>>(), options);
}

#[test]
fn the_manual_page_and_the_help_say_which_values_are_allowed() {
    let (page, command) = (manual_page(), Options::command());
    let sizes = ["--width", "--height", "--aspect", "--r2", "--k2"];
    for name in ["-A", "-B", "--fps", "--frames", "--spin"].into_iter().chain(sizes) {
        // The least K2 depends on R2.
        let range = range(name).replace("from 2.02 to", "at most");
        assert_contains(entry(&page, name).1, &range);
        let id = name.trim_start_matches('-').to_lowercase();
        let option = command.get_arguments().find(|option| *option.get_id() == id).unwrap();
        let help = option.get_long_help().or(option.get_help()).unwrap().to_string();
        assert_contains(&help.replace("From", "from"), &range);
    }
    let colors: Vec<_> = entry(&page, "--color").1.split([' ', ',', '.', '\n']).collect();
    for name in color_names() {
        assert!(colors.contains(&name), "no {name} in {colors:?}");
    }
    let different: BTreeSet<_> = color_names().into_iter().map(parse_color).collect();
    assert!(different.len() == 16 && different.iter().all(Result::is_ok), "{different:?}");
}

#[test]
fn the_manual_page_and_the_readme_have_all_keys_and_the_page_the_version() {
    let (page, readme) = (manual_page(), read("README.md"));
    let (keys, _) = AFTER_HELP.split_once("\n\n").unwrap();
    for line in keys.lines().skip(1) {
        for name in line.trim().split("  ").next().unwrap().split(", ") {
            entry(&page, name);
            let is_row = |line: &str| line.starts_with('|') && line.contains(name);
            assert!(readme.lines().any(is_row), "the README's table of keys lacks {name}");
        }
    }
    let version = concat!("\"donut ", env!("CARGO_PKG_VERSION"), "\"");
    assert_contains(page.lines().next().unwrap(), version);
}

#[test]
fn the_readme_shows_the_donut_shaped_source() {
    assert!(read("README.md").contains(&format!("```rust\n{}```\n", read("tests/unit/donut.rs"))));
}

fn completion(shell: Shell) -> String {
    // --color takes numbers as well, but only names can be completed.
    let mut command = Options::command().mut_args(|option| match option.get_id().as_str() {
        "color" => option.value_parser(PossibleValuesParser::new(color_names())),
        _ => option,
    });
    let mut script = Vec::new();
    generate(shell, &mut command, "donut", &mut script);
    let script = String::from_utf8(script).unwrap();
    // Where no option is being typed, bash and fish would complete the names of files. donut takes none.
    match shell {
        Shell::Bash => script.replace(" -o bashdefault -o default", ""),
        Shell::Fish => format!("complete -c donut -f\n{script}"),
        _ => script,
    }
}

/// The completions offer the names of the colours and no files. In fish, an option with -r but without -f
/// would complete the names of files.
#[test]
fn the_stored_completions_are_those_for_the_options() {
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        let script = completion(shell);
        assert_current(&format!("tests/dist/{}", shell.file_name("donut")), &script);
        assert!(color_names().iter().all(|name| script.contains(name)), "{shell}: {script}");
        for files in ["compgen -f", "-o default", "-o bashdefault", "_default", "_files", "-r\n"] {
            assert!(!script.contains(files), "{shell} has {files}: {script}");
        }
    }
    assert!(completion(Shell::Fish).starts_with("complete -c donut -f\n"));
}
