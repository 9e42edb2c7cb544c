//! The README: its pictures are drawn again, and the figures in its text are compared with the tables in
//! tests/chart. (`tests/unit/chart` counts the wrong cells of its table again.)

mod stored;

use std::fmt::Write;
use std::ops::Range;
use std::process::Command;

use stored::{assert_current, read};

/// The frames that the program draws with these options, each as its rows.
fn frames(options: &str) -> Vec<Vec<String>> {
    let donut = Command::new(env!("CARGO_BIN_EXE_donut")).args(options.split(' ')).output();
    let stream = String::from_utf8(donut.unwrap().stdout).unwrap();
    let rows = |frame: &str| frame.lines().skip(1).map(String::from).collect();
    stream.split("\x1b[H").skip(1).map(rows).collect()
}

// ---- Pictures ------------------------------------------------------------------------------------

/// The width and the height of a cell, in pixels.
const CELL: (f64, f64) = (9.6, 19.2);

/// The start of a picture with a dark background, and with room for this many columns and rows of cells.
fn head(title: &str, columns: f64, rows: f64, style: &str) -> String {
    let (width, height) = (columns * CELL.0, rows * CELL.1);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.1} {height:.1}\" \
         width=\"{width:.1}\" height=\"{height:.1}\">\n\
         <title>{title}</title>\n\
         <style>\
         text{{font:16px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;\
         fill:#e6e6e6;white-space:pre}}\
         {style}\
         </style>\n\
         <rect width=\"100%\" height=\"100%\" rx=\"8\" fill=\"#16181d\"/>\n"
    )
}

/// Adds a run of glyphs to the picture. Its first glyph is in the cell with this column and row.
fn put(svg: &mut String, column: f64, row: f64, class: &str, glyphs: &str) {
    let (x, y) = (column * CELL.0, (row + 0.8) * CELL.1);
    let length = glyphs.len() as f64 * CELL.0;
    writeln!(
        svg,
        "<text{class} x=\"{x:.1}\" y=\"{y:.1}\" textLength=\"{length:.1}\">{glyphs}</text>"
    )
    .unwrap();
}

/// The moving picture. All frames are in one strip, one below another, and the strip moves up
/// behind a window that is as high as one frame.
///
/// The picture shows 15 frames a second, half as many as the program does by default, so the donut
/// turns about twice as far from one frame to the next. After 157 frames A has gone round twice and B
/// once, and the animation starts again without a jump.
fn moving_picture() -> String {
    const FRAMES: usize = 157;
    /// The rows of a frame: one that is always empty, 21 that the donut is drawn in, and an empty
    /// one as a margin.
    const ROWS: f64 = 23.0;
    /// The columns that are shown: those that the donut is seen in, in any of the frames, and a margin.
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

/// The picture of one pose in both methods, side by side. The cells in which classic differs from
/// exact have another colour.
fn two_methods() -> String {
    /// The columns that are shown: those that the donut is seen in, and a margin.
    const COLUMNS: Range<usize> = 5..36;
    /// The rows that are shown. The others are below the donut.
    const ROWS: usize = 15;
    let pose = "--width=40 --height=17 -A=0.35 -B=0.5 --frames=1 --method";
    let [classic, exact] =
        ["classic", "exact"].map(|method| frames(&format!("{pose}={method}")).remove(0));
    let title = "A donut drawn by classic, and the same donut drawn by exact";
    // One cell of margin all round, two cells between the pictures, and a row for the methods' names.
    let right = 1.0 + COLUMNS.len() as f64 + 2.0;
    let (columns, rows) = (right + COLUMNS.len() as f64 + 1.0, ROWS as f64 + 3.0);
    let mut svg = head(title, columns, rows, ".wrong{fill:#ff8c42}");
    for (picture, name, left) in [(&classic, "classic", 1.0), (&exact, "exact", right)] {
        put(&mut svg, left, 1.0, "", name);
        for (row, (line, truth)) in picture.iter().zip(&exact).enumerate() {
            let cells: Vec<_> = line.bytes().zip(truth.bytes()).collect();
            let kind = |cell: &(u8, u8)| (cell.0 != b' ', cell.0 != cell.1);
            let mut column = 0;
            for run in cells.chunk_by(|a, b| kind(a) == kind(b)) {
                let (shows_donut, wrong) = kind(&run[0]);
                if shows_donut {
                    assert!(row < ROWS && COLUMNS.start <= column);
                    assert!(column + run.len() <= COLUMNS.end);
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
    let svg = moving_picture();
    assert!(svg.len() < 400_000, "{} bytes are too much for a page to load", svg.len());
    assert_current("tests/donut.svg", &svg);
}

#[test]
fn the_picture_of_the_two_methods_shows_the_programs_own_frames() {
    assert_current("tests/methods.svg", &two_methods());
}

// ---- The figures ---------------------------------------------------------------------------------

/// The figure that tests/chart/speed-and-accuracy.csv has for a method at a size, in the column
/// with this title.
fn measured(method: &str, size: &str, title: &str) -> f64 {
    let table = read("tests/chart/speed-and-accuracy.csv");
    let column = table.lines().next().unwrap().split(',').position(|name| name == title);
    let line = table.lines().find(|line| line.starts_with(&format!("{method},{size},")));
    line.unwrap().split(',').nth(column.unwrap()).unwrap().parse().unwrap()
}

/// How many times as fast as the method `slow` the method `fast` is, at 80x22.
fn times_as_fast(fast: &str, slow: &str) -> f64 {
    let [fast, slow] = [fast, slow].map(|name| measured(name, "80x22", "us per frame (median)"));
    slow / fast
}

/// The wrong cells of one kind in classic at 80x22, in per cent of the donut's cells.
fn wrong_in_classic(kind: &str) -> f64 {
    let count = |title| measured("classic x1", "80x22", title);
    100.0 * count(kind) / count("cells of the donut")
}

/// The lines of tests/chart/drift.csv: the number of a frame, and the largest error of donut.c's
/// angle A up to that frame.
fn drift() -> Vec<(f64, f64)> {
    let row = |line: &str| {
        let (frame, error) = line.split_once(',').unwrap();
        (frame.parse().unwrap(), error.parse().unwrap())
    };
    read("tests/chart/drift.csv").lines().skip(1).map(row).collect()
}

/// Words of the README, with `#` in place of a figure, and the figure's value. The figure must be this
/// value, rounded to as many decimals as the README gives it. After "about" it may be a tenth more or less,
/// because times differ from one run to the next.
fn figures() -> Vec<(&'static str, f64)> {
    let [one_shade, more_shades, holes, rim] =
        ["one shade off", "more shades off", "holes", "extra outline"].map(wrong_in_classic);
    let drift = drift();
    let hours = |frame: f64| frame / 30.0 / 3600.0;
    let whole_turn = drift.iter().find(|row| row.1 > std::f64::consts::TAU).unwrap().0;
    // From the first of these frames on, A turns too fast. At the second one, it has stopped.
    let [faster, stopped] = [3_345_245.0, 22_918_663.0];
    // Two lines of the table, well after A has begun to turn too fast. Between them, the error grows by
    // the excess of A's turn.
    let late: Vec<_> = drift.iter().filter(|row| row.0 > 1.2 * faster).take(2).collect();
    let excess = (late[1].1 - late[0].1) / (late[1].0 - late[0].0);
    vec![
        (
            "exact is about # times as fast as a literal translation",
            times_as_fast("exact", "donut.c as written"),
        ),
        ("about # times as fast as the closed form", times_as_fast("exact", "closed form f64")),
        ("Classic is about # times as fast", times_as_fast("classic x1", "donut.c as written")),
        ("in #% of the donut's cells", one_shade + more_shades + holes),
        ("a rim of wrong cells, #% as many", rim),
        ("errors add up to a whole turn in # hours", hours(whole_turn)),
        ("After # hours the floats", hours(faster)),
        ("the donut turns #% too fast", 100.0 * excess / 0.04),
        ("after # days it stands still", hours(stopped) / 24.0),
        ("after those # hours", hours(faster)),
    ]
}

#[test]
fn the_readmes_figures_are_those_measured() {
    let readme = read("README.md").split_whitespace().collect::<Vec<_>>().join(" ");
    let mut stale = Vec::new();
    for (words, value) in figures() {
        let (before, after) = words.split_once('#').unwrap();
        let between = readme.split(before).skip(1).filter_map(|rest| rest.split_once(after));
        let mut found = between.map(|(text, _)| text).filter(|text| text.parse::<f64>().is_ok());
        let figure = found.next().unwrap_or_else(|| panic!("the README does not say {words:?}"));
        let decimals = figure.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let current = format!("{value:.decimals$}");
        let off = (figure.parse::<f64>().unwrap() / value - 1.0).abs();
        if figure != current && !(before.ends_with("about ") && off < 0.1) {
            stale.push(format!("{words}: {current}, not {figure}"));
        }
    }
    assert!(stale.is_empty(), "in the README, # should be\n{}", stale.join("\n"));
}

#[test]
fn the_readme_has_every_key_of_the_help() {
    let help = Command::new(env!("CARGO_BIN_EXE_donut")).arg("-h").output().unwrap();
    let help = String::from_utf8(help.stdout).unwrap();
    let (readme, keys) = (read("README.md"), help.split_once("Keys:\n").unwrap().1);
    for line in keys.lines().take_while(|line| !line.is_empty()) {
        for key in line.trim().split("  ").next().unwrap().split(", ") {
            let is_in_table =
                |line: &str| line.starts_with('|') && line.contains(&format!("`{key}`"));
            assert!(readme.lines().any(is_in_table), "the README's table of keys lacks {key}");
        }
    }
}
