//! The manual page and the completions in tests/dist, made from the options and their help.

use super::*;
use clap::builder::PossibleValuesParser;
use clap_complete::{Shell, generate};
use clap_mangen::Man;
use clap_mangen::roff::{Roff, bold, italic, roman};

/// What the help does not say: it would be too long.
const EXIT_STATUS: &str = "\
  0  A key or --frames ended it, or the reader of the pipe went away, or, on a terminal, SIGINT, SIGTERM, \
     SIGHUP or SIGQUIT came.
  1  Output or input failed, or the terminal was gone or stopped accepting output.
  2  An option was invalid.
  101  It panicked, which is a bug.

In a pipe or a file, signals end it as usual: shells report 130 for SIGINT, 143 for SIGTERM, 129 for \
     SIGHUP and 131 for SIGQUIT. The terminal is restored, unless SIGKILL or another signal that donut \
     does not handle ends it.";

/// What the help does not say of jobs.
const JOBS: &str = "In the background the donut waits, and is not drawn until fg brings it back. Where no \
    shell can do that, as in ssh -t host donut, Ctrl-Z does nothing.";

/// The sections after the options of the help, as headings and lines.
fn help_sections() -> impl Iterator<Item = (&'static str, &'static str)> {
    AFTER_HELP.split("\n\n").map(|section| section.split_once(":\n").unwrap())
}

/// The names of the colours, as the help of --color lists them.
fn color_names() -> Vec<&'static str> {
    let command = Options::command();
    let color = command.get_arguments().find(|option| option.get_id() == "color").unwrap();
    let help = color.get_long_help().unwrap().to_string().replace(" and ", ", ");
    let (_, names) = help.leak().split_once("The names are ").unwrap();
    names.trim_end_matches('.').split(',').map(str::trim).collect()
}

/// The help's second paragraph: the first is NAME.
fn description(page: &mut Roff) {
    let about = Options::command().get_long_about().unwrap().to_string();
    page.control("SH", ["DESCRIPTION"]);
    page.text([roman(about.split_once("\n\n").unwrap().1)]);
    page.control("PP", []);
    page.text([roman(JOBS)]);
}

fn synopsis(page: &mut Roff) {
    let mut command = Options::command();
    command.build();
    page.control("SH", ["SYNOPSIS"]);
    page.text([bold("donut")]);
    for option in command.get_arguments() {
        let mut text = vec![roman("[")];
        if let Some(short) = option.get_short() {
            text.push(bold(format!("-{short}")));
        }
        if let Some(long) = option.get_long() {
            text.extend(option.get_short().map(|_| roman("|")));
            text.push(bold(format!("--{long}")));
        }
        if option.get_action().takes_values() {
            // No line ends between an option and its value.
            text.extend([roman("\u{a0}"), italic(option.get_value_names().unwrap().concat())]);
        }
        text.push(roman("]"));
        page.text(text);
    }
}

/// A line with two columns, which are two blanks apart, is an entry of a list. Examples are no lists.
fn section(page: &mut Roff, heading: &str, lines: &str) {
    page.control("SH", [heading.to_uppercase().as_str()]);
    for line in lines.lines().map(str::trim) {
        let columns = line.split_once("  ").filter(|_| heading != "Examples");
        if let Some((term, meaning)) = columns {
            page.control("TP", ["16"]);
            page.text([bold(term)]);
            page.text([roman(meaning.trim())]);
        } else if line.is_empty() {
            page.control("PP", []);
        } else {
            page.text([roman(line)]);
            page.control("br", []);
        }
    }
}

fn manual_page() -> String {
    let mut page = Vec::new();
    // A date that is empty would be left out, and what follows would take its place.
    let man = Man::new(Options::command()).title("DONUT").date(" ").manual("User Commands");
    let (mut usage, mut sections) = (Roff::new(), Roff::new());
    synopsis(&mut usage);
    description(&mut usage);
    for (heading, lines) in help_sections() {
        if heading == "Examples" {
            section(&mut sections, "Exit status", EXIT_STATUS);
        }
        section(&mut sections, heading, lines);
    }
    man.render_title(&mut page).unwrap();
    man.render_name_section(&mut page).unwrap();
    usage.to_writer(&mut page).unwrap();
    man.render_options_section(&mut page).unwrap();
    sections.to_writer(&mut page).unwrap();
    let page = String::from_utf8(page).unwrap().replace('\u{a0}', "\\ ").replace("\n\n", "\n.sp\n");
    // Each part defines the apostrophe. The first definition is enough.
    let (apostrophe, _) = page.split_at(page.find(".TH").unwrap());
    apostrophe.to_owned() + &page.replace(apostrophe, "")
}

fn completion(shell: Shell) -> String {
    // The options take other colours too, but only names can be completed.
    let mut command = Options::command().mut_args(|option| match option.get_id().as_str() {
        "color" => option.value_parser(PossibleValuesParser::new(color_names())),
        _ => option,
    });
    let mut script = Vec::new();
    generate(shell, &mut command, "donut", &mut script);
    let script = String::from_utf8(script).unwrap();
    // What is left is to forbid the names of files where no option is typed.
    match shell {
        Shell::Bash => script.replace(" -o bashdefault -o default", ""),
        Shell::Fish => format!("complete -c donut -f\n{script}"),
        _ => script,
    }
}

/// File names and contents.
fn dist() -> [(&'static str, String); 4] {
    [
        ("donut.1", manual_page()),
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
        let stored = std::fs::read_to_string(&path).unwrap();
        assert!(
            stored == contents,
            "tests/dist/{name} is stale: run UPDATE=1 cargo test, and commit"
        );
    }
}

#[test]
fn the_manual_page_has_the_values_keys_colours_exit_codes_and_examples() {
    let page = manual_page();
    for text in [
        "[\\fB\\-\\-width\\fR\\ \\fICOLS\\fR]",
        "[\\fB\\-h\\fR|\\fB\\-\\-help\\fR]",
        ".SH KEYS\n.TP 16\n\\fBq, Esc, Ctrl\\-C\\fR\nquit\n",
        "black, dark_grey,",
        ".SH \"EXIT STATUS\"\n.TP 16\n\\fB0\\fR\n",
        ".SH EXAMPLES\ndonut",
    ] {
        assert!(page.contains(text), "no {text} in {page}");
    }
    assert!(!page.contains("EXTRA"));
}

#[test]
fn completions_offer_the_names_of_the_colours_and_no_files() {
    for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
        let script = completion(shell);
        assert!(color_names().iter().all(|name| script.contains(name)), "{shell}: {script}");
        for files in ["compgen -f", "-o default", "-o bashdefault", "_default", "_files", "-r\n"] {
            assert!(!script.contains(files), "{shell} has {files}: {script}");
        }
    }
    assert!(completion(Shell::Fish).starts_with("complete -c donut -f\n"));
}
