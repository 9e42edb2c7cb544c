//! The texts. What the help, the README and the manual page say of options, defaults, keys and exit codes is
//! true of the program, and the completions for shells are those that the options give. Names, numbers and
//! the words for what a key does are looked for, so that sentences may be changed.

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
#[track_caller]
fn assert_contains(text: &str, part: &str) {
    let mut rests = text.match_indices(part).map(|(start, _)| &text[start + part.len()..]);
    let is_whole = |rest: &str| !rest.starts_with(|next: char| next.is_ascii_digit());
    assert!(rests.any(is_whole), "no {part:?} in {text:?}");
}

/// The rows of a table of the README, as the text in each cell, without backticks.
fn table(header: &str) -> Vec<Vec<String>> {
    let readme = read("README.md").replace('`', "");
    let (_, rows) = readme.split_once(&format!("\n| {header} |")).unwrap();
    let rows = rows.lines().skip(2).take_while(|row| row.starts_with("| "));
    rows.map(|row| row.split('|').map(|cell| cell.trim().into()).collect()).collect()
}

/// The size of a picture in a window. donut.c's has a column and a row that are always blank.
fn size(window: Option<(u16, u16)>) -> [f64; 2] {
    let window = window.map(|(columns, rows)| Window { columns, rows, aspect: View::ASPECT });
    let view = options("").view(window);
    [view.width, view.height].map(|cells| (cells + usize::from(view == View::DONUT_C)) as f64)
}

/// The names of the colours, in the order in which the help of --color lists them.
fn color_names() -> Vec<&'static str> {
    let help = Options::command().render_long_help().to_string().replace(" and ", ",");
    let (_, names) = help.leak().split_once("The names are ").unwrap();
    names.split('.').next().unwrap().split(',').map(str::trim).collect()
}

/// The range of an option, such as "0 to 1000", taken from the error message for another value.
fn range(option: &str) -> String {
    let value = if option == "--spin" { "x,x" } else { "x" };
    let refused = Options::try_parse_from(["donut", option, value]).err().unwrap().to_string();
    refused.split_once("from ").unwrap().1.split([',', '\n']).next().unwrap().into()
}

#[test]
fn the_manual_page_and_the_help_have_exactly_the_options_and_their_values() {
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
            if !is_builtin && name != "--method" {
                let help = option.get_long_help().unwrap().to_string();
                // The least K2 depends on R2.
                let range = range(name).replace("2.02 to", "at most");
                assert_contains(text, &range);
                assert_contains(&help, &range);
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
fn the_help_the_manual_page_and_the_message_name_the_colours() {
    let (page, refused) = (manual_page(), parse_color("pink").unwrap_err());
    for text in [&refused, entry(&page, "--color").1] {
        let words: Vec<_> = text.split([' ', ',', '.', '\n']).collect();
        assert!(color_names().iter().all(|name| words.contains(name)), "{words:?}");
    }
    let different: BTreeSet<_> = color_names().into_iter().map(parse_color).collect();
    assert!(different.len() == 16 && different.iter().all(Result::is_ok), "{different:?}");
}

/// Defaults that clap does not know are compared with what the program computes.
#[test]
fn the_help_the_manual_page_and_the_readme_have_the_programs_defaults() {
    let (page, mut command, usual) = (manual_page(), Options::command(), options(""));
    let ([da, db], [columns, rows]) = (usual.spin(), size(None));
    assert_eq!(size(Some((80, 24))), [columns, rows]);
    let spare = 40.0 - size(Some((100, 40)))[1];
    for (name, in_the_help, in_the_page) in [
        ("--spin", format!("[default: {da},{db}]"), format!("The default is {da},{db}")),
        ("--k2", format!("[default: {},", usual.k2()), "The default is 5 (1 + R) / 3".into()),
        ("--width", format!("in a pipe, {columns}]"), format!("the default is {columns}.")),
        ("--height", format!("all but {spare}; at 80x24"), format!("less {spare} row")),
        ("--height", format!("80x24 or in a pipe, {rows}]"), format!("80x24, it is {rows}")),
        ("--height", format!("in a pipe, {rows}]"), format!("the default is {rows}.")),
        ("--aspect", "terminal's, or 2]".into(), "2 is assumed".into()),
        (
            "--method",
            format!("[default: classic for donut.c's {columns}x{rows}"),
            "classic draws donut.c's".into(),
        ),
    ] {
        assert_contains(entry(&page, name).1, &in_the_page);
        let mut arguments = command.get_arguments();
        let option = arguments.find(|option| option.get_long() == name.get(2..)).unwrap();
        for help in [option.get_help(), option.get_long_help()] {
            assert_contains(&help.unwrap().to_string().replace('\n', " "), &in_the_help);
        }
    }
    assert_contains(entry(&page, "--spin").1, "30 / N");
    assert_contains(&command.render_long_help().to_string(), "5 (1 + R) / 3");
    assert_eq!(options("--r2 8").k2(), 5.0 * (1.0 + 8.0) / 3.0);

    let table = table("everyday option");
    for (row, (name, default)) in table.iter().zip([
        ("--color COLOR", "the terminal's".into()),
        ("--fps N", usual.fps.to_string()),
        ("--frames N", "no limit".into()),
        ("--spin DA,DB", format!("{da},{db}")),
        ("--width COLS, --height ROWS", format!("the window, less {spare} row")),
    ]) {
        assert_eq!([&row[1], &row[2]], [name, &default]);
        if row[3].contains("from ") {
            let range = range(name.split(' ').next().unwrap());
            assert_contains(&row[3], &format!("from {range}"));
        }
    }
    assert_contains(&table[4][3], &format!("in a pipe, {columns}x{rows}"));
}

/// The help's list of keys, and the words that every text about them must have, in this order. Other
/// tests check that the keys do so.
const EFFECTS: &str = "q, Esc, Ctrl-C: quit / space, p: pause resume / arrow keys: turn / +, -: faster \
    slower / c: colour / m: method / s: shading / Ctrl-L: redraw / Ctrl-Z: suspend";

#[test]
fn the_help_the_readme_and_the_manual_page_have_the_same_keys_with_the_same_effects() {
    let (page, rows, effects) = (manual_page(), table("key"), EFFECTS.split(" / "));
    let lines: Vec<_> =
        KEYS.lines().skip(1).filter_map(|line| line.trim().split_once("  ")).collect();
    assert_eq!([lines.len(), rows.len()], [9; 2]);
    for ((effect, line), row) in effects.zip(lines).zip(rows) {
        let (keys, words) = effect.split_once(": ").unwrap();
        assert_eq!([line.0, &row[1]], [keys; 2]);
        let entries = keys.split(", ").map(|key| entry(&page, key).1);
        for text in entries.chain([line.1, &row[2]]).map(str::to_lowercase) {
            let rest =
                words.split(' ').try_fold(&*text, |rest, word| Some(rest.split_once(word)?.1));
            assert!(rest.is_some(), "{keys}: not {words:?} in {text:?}");
        }
    }
}

#[test]
fn the_manual_page_has_the_version_and_the_exit_codes() {
    let page = manual_page();
    let version = concat!("\"donut ", env!("CARGO_PKG_VERSION"), "\"");
    assert_contains(page.lines().next().unwrap(), version);
    for (code, reason) in [("0", "last frame"), ("1", "disk"), ("2", "option"), ("101", "panic")] {
        assert_contains(entry(&page, code).1, reason);
    }
    // 128 and the number of the signal.
    let (signals, text) = entry(&page, "SIGINT");
    assert_eq!(signals, "SIGINT, SIGTERM, SIGHUP, SIGQUIT");
    assert_contains(text, "130, 143, 129 and 131");
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
}
