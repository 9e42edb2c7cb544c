//! Pictures of frames, as SVG, with the cells marked in which two methods differ.

use super::*;
use std::ops::Range;

/// Blanks in a text are kept: the first attribute is for programs that do not know CSS's `white-space`.
/// `scale` says how large the picture is on a page with enough space.
pub fn svg(title: &str, size: (usize, usize), scale: f64, style: &str, contents: &str) -> String {
    let (width, height) = size;
    let [shown_width, shown_height] = [width, height].map(|size| scale * size as f64);
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xml:space=\"preserve\" \
         viewBox=\"0 0 {width} {height}\" width=\"{shown_width:.0}\" height=\"{shown_height:.0}\">\n\
         <title>{title}</title>\n<style>{style}</style>\n{contents}</svg>\n"
    )
}

/// The width and the height of a cell, in pixels, and how far its text's baseline is below its top.
pub const CELL: (usize, usize) = (10, 20);
pub const BASELINE: usize = 16;

pub fn pixels(columns: usize, rows: usize) -> (usize, usize) {
    (columns * CELL.0, rows * CELL.1)
}

fn words(class: &str, (x, y): (usize, usize), words: &str) -> String {
    format!("<text class=\"{class}\" x=\"{x}\" y=\"{y}\">{words}</text>\n")
}

/// Glyphs, one in each cell from this place on.
fn run(class: &str, (x, y): (usize, usize), glyphs: &str) -> String {
    let blanks = glyphs.len() - glyphs.trim_start().len();
    let (glyphs, class) =
        (glyphs.trim(), if class.is_empty() { "".into() } else { format!("class=\"{class}\" ") });
    if glyphs.is_empty() {
        return String::new();
    }
    let (x, y, length) = (x + CELL.0 * blanks, y + BASELINE, CELL.0 * glyphs.len());
    format!("<text {class}x=\"{x}\" y=\"{y}\" textLength=\"{length}\">{glyphs}</text>\n")
}

/// Filled cells, from this place on.
fn block(class: &str, (x, y): (usize, usize), count: usize) -> String {
    let (width, height) = pixels(count, 1);
    format!("<rect class=\"{class}\" x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"/>\n")
}

/// The part of a picture in these columns and rows, with its top left corner at this place. `mark` gives
/// the class of each cell, or nothing where it is not marked.
fn part(
    (picture, width): (&[u8], usize),
    (columns, rows): (Range<usize>, Range<usize>),
    (x, y): (usize, usize),
    mark: impl Fn(usize) -> &'static str,
) -> String {
    let mut svg = String::new();
    for (i, row) in rows.enumerate() {
        let cells: Vec<_> = columns.clone().map(|column| row * width + column).collect();
        for alike in cells.chunk_by(|&a, &b| mark(a) == mark(b)) {
            let class = mark(alike[0]);
            let (right, down) = pixels(alike[0] - cells[0], i);
            if !class.is_empty() {
                svg += &block(class, (x + right, y + down), alike.len());
            }
            let glyphs = std::str::from_utf8(&picture[alike[0]..][..alike.len()]).unwrap();
            svg += &run(class, (x + right, y + down), glyphs);
        }
    }
    svg
}

/// The marks differ in lightness, too, for those who cannot tell their colours.
const STYLE: &str = "text{font:16.6px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;\
    fill:#e6e6e6;white-space:pre}rect{shape-rendering:crispEdges}.page{fill:#16181d}\
    .title,.caption{font:24px system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;fill:#c3cad3}\
    .title{font-size:32px;font-weight:bold;fill:#ffffff}\
    rect.shade{fill:#2a66b8}rect.extra{fill:#cf7c2c}text.extra{fill:#16181d}rect.hole{fill:#f2c9d8}\
    .note{font:19px system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;fill:#8b949e}";

fn picture(title: &str, (width, height): (usize, usize), contents: &str) -> String {
    let page = "<rect class=\"page\" width=\"100%\" height=\"100%\" rx=\"12\"/>\n";
    svg(title, (width, height), 0.75, STYLE, &(page.to_string() + contents))
}

/// How a cell is marked, in which this is drawn, and exact draws that.
fn mark(drawn: u8, exact: u8) -> &'static str {
    match (drawn, exact) {
        _ if drawn == exact => "",
        (b' ', _) => "hole",
        (_, b' ') => "extra",
        _ => "shade",
    }
}

fn key(class: &str, (x, y): (usize, usize), meaning: &str) -> String {
    block(class, (x, y), 3) + &words("caption", (x + 42, y + BASELINE + 2), meaning)
}

/// Frame 252 of donut.c by classic and by exact, and below them classic's again, with the cells marked in
/// which it differs from exact.
pub fn two_methods() -> String {
    /// The columns and the rows that the donut is seen in.
    const PART: (Range<usize>, Range<usize>) = (16..53, 0..21);
    const LEFT: usize = 24;
    const RIGHT: usize = 440;
    const BELOW: usize = 554;
    let view = View::DONUT_C;
    let [classic, exact] =
        [Method::Classic, Method::Exact].map(|method| draw(method, view, 10.08, 5.04));
    let mark = |cell: usize| mark(classic[cell], exact[cell]);
    let count = |class| (0..classic.len()).filter(|&cell| mark(cell) == class).count();
    let [shades, extra, holes] = ["shade", "extra", "hole"].map(count);
    assert_eq!(holes, 0, "another mark needs an explanation");
    let levels = |cell: usize| level(classic[cell]).zip(level(exact[cell]));
    let is_next = |cell: &usize| levels(*cell).is_some_and(|(one, other)| one.abs_diff(other) == 1);
    let next = (0..classic.len()).filter(is_next).count();
    let sum = format!("{} cells differ from exact", shades + extra);
    let plain = |picture, left| part((picture, view.width), PART, (left, 104), |_| "");
    let contents = [
        words("title", (LEFT, 50), "classic"),
        words("caption", (LEFT, 82), "the original, as in 2006"),
        plain(&classic, LEFT),
        words("title", (RIGHT, 50), "exact"),
        words("caption", (RIGHT, 82), "a truer outline, truer shades"),
        plain(&exact, RIGHT),
        part((&classic, view.width), PART, (LEFT, BELOW), mark),
        words("title", (RIGHT, BELOW + 100), "classic, marked"),
        words("caption", (RIGHT, BELOW + 132), &sum),
        key("shade", (RIGHT, BELOW + 174), &format!("another character: {shades}")),
        words("caption", (RIGHT + 42, BELOW + 222), &format!("{next} of them by one shade")),
        key("extra", (RIGHT, BELOW + 260), &format!("only in classic: {extra}")),
        words("caption", (RIGHT + 42, BELOW + 308), "a rim along the outline"),
        words("note", (LEFT, BELOW + 468), "Frame 252 of donut.c, 80x22: A 10.08, B 5.04"),
    ];
    let title =
        "A donut drawn by classic and by exact, and the cells in which classic differs from exact";
    picture(title, (RIGHT + pixels(PART.0.len(), 0).0 + LEFT, BELOW + 490), &contents.concat())
}

/// Methods that fail, each with a donut as it draws it, and with its wrong cells marked.
pub fn failures() -> String {
    const LEFT: usize = 24;
    const RIGHT: usize = 450;
    const TOP: usize = 96;
    const HEIGHTS: [usize; 3] = [0, 540, 990];
    let mut contents = key("hole", (LEFT, 24), "missing");
    contents += &key("extra", (LEFT + 190, 24), "extra");
    contents += &key("shade", (LEFT + 350, 24), "wrong character");
    contents += &words("caption", (LEFT, 72), "as the method draws it");
    contents += &words("caption", (RIGHT, 72), "wrong cells marked");
    let shown = [
        (
            "sphere tracing in 16 steps",
            (2.0, 5.0),
            6,
            "Sphere tracing, 16 steps",
            "grazing rays miss",
        ),
        ("Newton from one start", (9.0, 50.0 / 3.0), 2, "Newton, --r2 9", "steps jump past hits"),
        ("Ferrari in f32", (2.0, 50.0), 9, "Ferrari in f32, --k2 50", "rounding errors"),
    ];
    for ((name, (r2, k2), pose, title, failure), down) in shown.into_iter().zip(HEIGHTS) {
        let (view, (a, b)) = (View::fitted(40, 20, 2.0, r2, k2), donut_c_poses(10)[pose]);
        let method =
            || methods(view).into_iter().filter(|method| method.0 == name).collect::<Vec<_>>();
        let counted = |poses| wrong(&count(method(), view, poses).pop().unwrap().1);
        let [here, in_ten] = [vec![(a, b)], donut_c_poses(10)].map(|poses| share(counted(poses)));
        let drawn = method().pop().unwrap().1(a, b);
        let exact = draw(Method::Exact, view, a, b);
        let top = TOP + down;
        let shares = format!("{failure}: {here}% wrong in this pose, {in_ten}% over ten");
        contents += &words("title", (LEFT, top + 34), title);
        contents += &words("caption", (LEFT, top + 70), &shares);
        let all = || (0..view.width, 0..view.height);
        contents += &part((&drawn, view.width), all(), (LEFT, top + 84), |_| "");
        let mark = |cell: usize| mark(drawn[cell], exact[cell]);
        contents += &part((&drawn, view.width), all(), (RIGHT, top + 84), mark);
    }
    let title =
        "Donuts as three methods draw them where they fail, and with their wrong cells marked";
    picture(title, (RIGHT + pixels(40, 0).0 + LEFT, TOP + 1510), &contents)
}
