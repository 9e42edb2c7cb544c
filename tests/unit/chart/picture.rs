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
pub fn part(
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
    .title,.head,.caption{font:24px system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;fill:#c3cad3}\
    .title{font-size:32px;font-weight:bold;fill:#ffffff}.head{font-weight:bold}\
    rect.shade{fill:#2a66b8}rect.extra{fill:#cf7c2c}text.extra{fill:#16181d}rect.hole{fill:#f2c9d8}\
    .command{font-size:19px;fill:#ffffff}.Cyan text{fill:#34e2e2}\
    .window{fill:none;stroke:#5c646e;stroke-width:2}";

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

/// Frame 252 of donut.c by classic and by exact, and the cells in which they differ.
pub fn two_methods() -> String {
    /// The columns and the rows that the donut is seen in.
    const PART: (Range<usize>, Range<usize>) = (16..53, 0..21);
    const LEFT: usize = 24;
    const RIGHT: usize = 440;
    const BELOW: usize = 606;
    let view = View::DONUT_C;
    let [classic, exact] =
        [Method::Classic, Method::Exact].map(|method| draw(method, view, 10.08, 5.04));
    let mark = |cell: usize| mark(classic[cell], exact[cell]);
    let count = |class| (0..classic.len()).filter(|&cell| mark(cell) == class).count();
    let surface = exact.iter().filter(|&&glyph| glyph != b' ').count();
    let [shades, extra, holes] = ["shade", "extra", "hole"].map(count);
    assert_eq!(holes, 0, "another mark needs an explanation");
    let (differ, drawn) = (shades + extra, surface + extra);
    let sum = format!("{differ} of the {drawn} cells drawn differ from each other");
    let contents = [
        words("caption", (LEFT, 44), "frame 252 of donut.c (A 10.08, B 5.04), 80x22"),
        words("title", (LEFT, 100), "classic"),
        words("caption", (LEFT, 134), "the nearest point in a cell"),
        words("title", (RIGHT, 100), "exact"),
        words("caption", (RIGHT, 134), "the point at a cell's centre"),
        part((&classic, view.width), PART, (LEFT, 158), mark),
        part((&exact, view.width), PART, (RIGHT, 158), |_| ""),
        key("shade", (LEFT, BELOW), &format!("another character: {shades}")),
        key("extra", (RIGHT, BELOW), &format!("only in classic: {extra}")),
        words("caption", (LEFT, BELOW + 62), &sum),
    ];
    let title = "A donut drawn by classic and by exact, and the cells in which these differ";
    picture(title, (RIGHT + pixels(PART.0.len(), 0).0 + LEFT, BELOW + 86), &contents.concat())
}

/// What options look like: a frame by each of four commands, in small windows.
pub fn options() -> String {
    const WINDOW: Window = Window { columns: 32, rows: 17, aspect: View::ASPECT };
    const COMMANDS: [&str; 4] = [
        "donut --color cyan",
        "donut --r2 6",
        "donut -A 0.6 -B 1.6 --spin 0,0",
        "donut --width 20 --height 10",
    ];
    let (width, height) = pixels(WINDOW.columns.into(), WINDOW.rows.into());
    let mut contents = String::new();
    for (n, command) in COMMANDS.into_iter().enumerate() {
        let options = Options::try_parse_from(command.split(' ')).unwrap();
        assert_eq!(options.conflict(), None);
        let mut renderer = options.renderer(Some(WINDOW), options.method);
        let start = [options.a, options.b];
        let [a, b] = (0..84).fold(start, |angles, _| renderer.advance(angles, options.spin()));
        renderer.render_frame(a, b);
        let (x, y) = (24 + n % 2 * (width + 44), 24 + n / 2 * (height + 72));
        let View { width: columns, height: rows, .. } = renderer.view;
        let drawn =
            part((&renderer.framebuffer, columns), (0..columns, 0..rows), (x + 10, y + 46), |_| "");
        let class = options.color.map_or(String::new(), |color| format!("{color:?}"));
        contents += &words("command", (x, y + 20), command);
        contents += &format!(
            "<rect class=\"window\" x=\"{x}\" y=\"{}\" width=\"{}\" height=\"{height}\" rx=\"8\"/>\n\
             <g class=\"{class}\">\n{drawn}</g>\n",
            y + 36,
            width + 20
        );
    }
    let title = "What the donut looks like with four sets of options";
    picture(title, (2 * width + 112, 2 * height + 156), &contents)
}

/// Methods that fail, each in a scene of the study's table, beside the same part of the picture by
/// exact.
pub fn failures() -> String {
    /// The columns and the rows of a part.
    const PART: (usize, usize) = (35, 12);
    const LEFT: usize = 24;
    const RIGHT: usize = 404;
    const HEIGHT: usize = 456;
    let mut contents = key("hole", (LEFT, 24), "missing");
    contents += &key("extra", (LEFT + 180, 24), "extra");
    contents += &key("shade", (LEFT + 340, 24), "wrong character");
    let shown = [
        ("classic with donut.c's steps", "`--k2 3.03`", 2, (40, 7), "donut.c's steps"),
        ("sphere tracing 16", "80x22", 6, (18, 3), "sphere tracing"),
        ("Ferrari f32", "`--k2 50`", 9, (75, 12), "Ferrari, f32"),
    ];
    let captions = [
        ["Gaps", "donut.c's steps at --k2 3.03:", "too few points this close up"],
        ["A bitten outline", "sphere tracing with 16 steps:", "grazing rays run out of steps"],
        ["Noise", "Ferrari's formula in f32 at --k2 50:", "rounding errors"],
    ];
    for (n, (name, scene, pose, corner, head)) in shown.into_iter().enumerate() {
        let [title, first, second] = captions[n];
        let (_, view, poses) = scenes().into_iter().find(|other| other.0 == scene).unwrap();
        let [drawn, exact] = [name, "exact"].map(|name| {
            let (_, mut draw) = methods(view).into_iter().find(|method| method.0 == name).unwrap();
            draw(poses[pose].0, poses[pose].1)
        });
        let mark = |cell: usize| mark(drawn[cell], exact[cell]);
        let cells = || (corner.0..corner.0 + PART.0, corner.1..corner.1 + PART.1);
        let top = 84 + n * HEIGHT;
        contents += &words("title", (LEFT, top + 34), title);
        contents += &words("caption", (LEFT, top + 72), first);
        contents += &words("caption", (LEFT, top + 102), second);
        contents += &words("head", (LEFT, top + 152), head);
        contents += &words("head", (RIGHT, top + 152), "exact");
        contents += &part((&drawn, view.width), cells(), (LEFT, top + 166), mark);
        contents += &part((&exact, view.width), cells(), (RIGHT, top + 166), |_| "");
    }
    let title = "Three methods that fail, beside exact, with their wrong cells marked";
    let width = RIGHT + pixels(PART.0, 0).0 + LEFT;
    picture(title, (width, 84 + 3 * HEIGHT - 20), &contents)
}
