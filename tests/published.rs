//! The pictures and the figures of the README are those of the program and of the measured table.

use std::fmt::Write;
use std::ops::Range;
use std::process::Command;
use std::{env, fs};

fn path(name: &str) -> String {
    format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    fs::read_to_string(path(name)).unwrap()
}

/// The frames that the program draws with these options, each as its rows.
fn frames(options: &str) -> Vec<Vec<String>> {
    let donut = Command::new(env!("CARGO_BIN_EXE_donut")).args(options.split(' ')).output();
    let stream = String::from_utf8(donut.unwrap().stdout).unwrap();
    let rows = |frame: &str| frame.lines().skip(1).map(String::from).collect();
    stream.split("\x1b[H").skip(1).map(rows).collect()
}

#[track_caller]
fn assert_current(name: &str, svg: &str) {
    if env::var_os("UPDATE").is_some() {
        fs::write(path(name), svg).unwrap();
    }
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
    assert!(read(name) == svg, "{name} is stale: run UPDATE=1 cargo test, and commit");
}

// ---- Pictures ------------------------------------------------------------------------------------

/// The size of a cell, in pixels.
const CELL: (f64, f64) = (9.6, 19.2);

/// The start of a picture with this number of columns and rows of cells, on a dark ground.
fn head(title: &str, columns: f64, rows: f64, style: &str) -> String {
    let (width, height) = (columns * CELL.0, rows * CELL.1);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.1} {height:.1}\" width=\"{width:.1}\" height=\"{height:.1}\">\n\
         <title>{title}</title>\n\
         <style>\
         text{{font:16px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;fill:#e6e6e6;white-space:pre}}\
         {style}\
         </style>\n\
         <rect width=\"100%\" height=\"100%\" rx=\"8\" fill=\"#16181d\"/>\n"
    )
}

/// Text whose first cell has this column and row.
fn put(svg: &mut String, column: f64, row: f64, class: &str, glyphs: &str) {
    let (x, y) = (column * CELL.0, (row + 0.8) * CELL.1);
    let length = glyphs.len() as f64 * CELL.0;
    writeln!(
        svg,
        "<text{class} x=\"{x:.1}\" y=\"{y:.1}\" textLength=\"{length:.1}\">{glyphs}</text>"
    )
    .unwrap();
}

/// A strip of the donut's frames, one below another, that moves up past a window of one frame.
///
/// Each turns it twice as far as one of donut.c's. In 157 of them, B goes once round and A twice: then it
/// begins again.
fn moving_picture() -> String {
    const FRAMES: usize = 157;
    /// An empty row, 21 rows that are drawn on, and another empty one.
    const ROWS: f64 = 23.0;
    /// The cells in which the donut is ever seen.
    const COLUMNS: Range<usize> = 14..64;
    let turn = std::f64::consts::TAU / FRAMES as f64;
    let options = format!("--spin={},{turn} --frames={FRAMES} --fps=0", 2.0 * turn);
    let style = format!(
        "g{{animation:film {:.2}s steps({FRAMES}) infinite}}\
         @keyframes film{{to{{transform:translateY(-{}px)}}}}\
         @media(prefers-reduced-motion:reduce){{g{{animation:none}}}}",
        FRAMES as f64 / 15.0,
        FRAMES as f64 * ROWS * CELL.1
    );
    let title = "A spinning donut of ASCII characters";
    let mut svg = head(title, COLUMNS.len() as f64, ROWS, &style) + "<g>\n";
    for (n, frame) in frames(&options).iter().enumerate() {
        assert!(frame[0].trim().is_empty());
        for (row, line) in frame.iter().enumerate() {
            let line = line.trim_end();
            let glyphs = line.trim_start();
            if !glyphs.is_empty() {
                let column = line.len() - glyphs.len() - COLUMNS.start;
                assert!(line.len() <= COLUMNS.end);
                put(&mut svg, column as f64, n as f64 * ROWS + row as f64, "", glyphs);
            }
        }
    }
    svg + "</g>\n</svg>\n"
}

/// One pose in both methods, side by side. The cells of classic that differ have another colour.
fn two_methods() -> String {
    /// The cells in which this donut is seen.
    const COLUMNS: Range<usize> = 5..36;
    const ROWS: usize = 15;
    let pose = "--width=40 --height=17 -A=0.35 -B=0.5 --frames=1 --method";
    let [classic, exact] =
        ["classic", "exact"].map(|method| frames(&format!("{pose}={method}")).remove(0));
    let title = "A donut in the method classic, and the same donut in the method exact";
    // A cell of margin all round, two between the pictures, and a row for their names.
    let right = 1.0 + COLUMNS.len() as f64 + 2.0;
    let (columns, rows) = (2.0 * right, ROWS as f64 + 3.0);
    let mut svg = head(title, columns - 2.0, rows, ".wrong{fill:#ff8c42}");
    for (picture, name, left) in [(&classic, "classic", 1.0), (&exact, "exact", right)] {
        put(&mut svg, left, 1.0, "", name);
        for (row, (line, truth)) in picture.iter().zip(&exact).enumerate() {
            let cells: Vec<_> = line.bytes().zip(truth.bytes()).collect();
            assert!(
                cells.iter().position(|cell| cell.0 != b' ').is_none_or(|x| x >= COLUMNS.start)
            );
            assert!(cells.iter().rposition(|cell| cell.0 != b' ') < Some(COLUMNS.end));
            let kind = |cell: &(u8, u8)| (cell.0 != b' ', cell.0 != cell.1);
            let mut column = 0;
            for run in cells.chunk_by(|a, b| kind(a) == kind(b)) {
                let (seen, wrong) = kind(&run[0]);
                if seen {
                    assert!(row < ROWS);
                    let glyphs: String = run.iter().map(|cell| char::from(cell.0)).collect();
                    let class = if wrong { " class=\"wrong\"" } else { "" };
                    let at = left + (column - COLUMNS.start) as f64;
                    put(&mut svg, at, row as f64 + 2.0, class, &glyphs);
                }
                column += run.len();
            }
        }
    }
    svg + "</svg>\n"
}

#[test]
fn the_moving_picture_shows_the_programs_own_frames() {
    assert_current("tests/donut.svg", &moving_picture());
}

#[test]
fn the_picture_of_the_two_methods_shows_the_programs_own_frames() {
    assert_current("tests/methods.svg", &two_methods());
}

// ---- The figures of the README -------------------------------------------------------------------

/// What the measured table has for a method at a size, in the column of this title.
fn measured(method: &str, size: &str, title: &str) -> f64 {
    let table = read("tests/chart/speed-and-accuracy.csv");
    let column = table.lines().next().unwrap().split(',').position(|name| name == title);
    let line = table.lines().find(|line| line.starts_with(&format!("{method},{size},")));
    line.unwrap().split(',').nth(column.unwrap()).unwrap().parse().unwrap()
}

fn micros(method: &str) -> f64 {
    measured(method, "80x22", "us per frame (median)")
}

/// Cells of a kind in classic at 80x22, in per cent of the donut's.
fn classic_share(kind: &str) -> f64 {
    let count = |title| measured("classic x1", "80x22", title);
    100.0 * count(kind) / count("cells of the donut")
}

/// The error of donut.c's angle A up to each frame in the clock's table.
fn clock_errors() -> Vec<(f64, f64)> {
    let row = |line: &str| {
        let (frame, error) = line.split_once(',').unwrap();
        (frame.parse().unwrap(), error.parse().unwrap())
    };
    read("tests/chart/clock.csv").lines().skip(1).map(row).collect()
}

#[test]
fn the_figures_of_the_readme_are_those_of_the_tables() {
    let ratio = |slow, fast| micros(slow) / micros(fast);
    let [one_shade, more_shades, holes, extra] =
        ["one shade off", "more shades off", "holes", "extra outline"].map(classic_share);
    let errors = clock_errors();
    let hours = |frame: f64| frame / 30.0 / 3600.0;
    let whole_turn = errors.iter().find(|row| row.1 > std::f64::consts::TAU).unwrap().0;
    // From the first of these frames on, A turns faster. At the second it has stopped.
    let [faster, stopped] = [3_345_245.0, 22_918_663.0];
    let late = errors.iter().filter(|row| row.0 > 1.2 * faster).take(2).collect::<Vec<_>>();
    let too_fast = 100.0 * (late[1].1 - late[0].1) / (late[1].0 - late[0].0) / 0.04;

    let readme = read("README.md").split_whitespace().collect::<Vec<_>>().join(" ");
    let mut stale = Vec::new();
    for (sentence, value) in [
        ("at 80x22, #% of the donut's cells are wrong", one_shade + more_shades + holes),
        ("are wrong: #% by one shade", one_shade),
        ("one shade, and #% by more", more_shades),
        ("wrong as well: another #%.", extra),
        ("and is # times as fast as a literal", ratio("donut.c as written", "exact")),
        ("picture, is # times as fast", ratio("donut.c as written", "classic x1")),
        ("closed form, which takes # times as long", ratio("closed form f64", "exact")),
        ("After # hours at 30", hours(faster)),
        ("second it turns #% too fast", too_fast),
        ("after # days it stands still. Classic", hours(stopped) / 24.0),
        ("after those # hours", hours(faster)),
        ("a whole turn in # hours", hours(whole_turn)),
        ("After # hours A turns", hours(faster)),
        ("A turns #% too fast", too_fast),
        ("after # days it stands still.]", hours(stopped) / 24.0),
    ] {
        let (before, after) = sentence.split_once('#').unwrap();
        let figures = readme.split(before).skip(1).filter_map(|rest| rest.split_once(after));
        let figure = figures.map(|(figure, _)| figure).find(|figure| figure.parse::<f64>().is_ok());
        let figure = figure.unwrap_or_else(|| panic!("no \"{sentence}\" in the README"));
        let decimals = figure.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let current = format!("{value:.decimals$}");
        if figure != current {
            stale.push(format!("{sentence}: {current}, not {figure}"));
        }
    }
    assert!(stale.is_empty(), "in the README, # should be\n{}", stale.join("\n"));
}

#[test]
fn what_the_readme_says_about_the_methods_is_true_in_the_table() {
    for size in ["80x22", "160x44", "320x88"] {
        let wrong = |method: &str| measured(method, size, "wrong cells");
        assert_eq!(wrong("exact") + wrong("closed form f32") + wrong("closed form f64"), 0.0);
        let steps = [8, 16, 32, 64, 256].map(|n| wrong(&format!("sphere tracing {n}")));
        assert!(steps.is_sorted_by(|fewer, more| fewer > more), "{size}: {steps:?}");
    }
    for closed_form in ["closed form f32", "closed form f64"] {
        assert!(micros("exact") < micros(closed_form), "{closed_form}");
    }
    let finer = ["classic x1", "classic x1/2", "classic x1/4"];
    let finer = finer.map(|method| measured(method, "80x22", "wrong cells"));
    assert!(finer.is_sorted(), "finer steps help: {finer:?}");
}
