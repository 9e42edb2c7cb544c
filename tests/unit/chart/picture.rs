//! The pictures of the README and of the study, as SVG: three of frames, and two charts. The charts follow
//! the page, which may be light or dark. All can be read even on a phone, where they are 400 pixels wide.

use super::*;
use std::ops::Range;

/// Blanks in a text are kept: the first attribute is for programs that do not know CSS's `white-space`.
fn svg(title: &str, (width, height): (f64, f64), style: &str, contents: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" xml:space=\"preserve\" \
         viewBox=\"0 0 {width:.1} {height:.1}\" width=\"{width:.1}\" height=\"{height:.1}\">\n\
         <title>{title}</title>\n\
         <style>{style}</style>\n\
         <rect class=\"page\" width=\"100%\" height=\"100%\" rx=\"8\"/>\n\
         {contents}</svg>\n"
    )
}

fn text(class: &str, (x, y): (f64, f64), anchor: &str, words: &str) -> String {
    format!(
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>\n"
    )
}

// ---- Frames --------------------------------------------------------------------------------------

/// The width and the height of a cell, in pixels.
const CELL: (f64, f64) = (9.6, 19.2);
const CELLS: &str = "text{font:16px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;\
    fill:#e6e6e6;white-space:pre}rect{shape-rendering:crispEdges}.page{fill:#16181d}\
    text.title{font-size:22px;font-weight:bold}text.caption{font-size:18px;fill:#c3cad3}\
    text.extra{fill:#ffc08a}rect.extra{fill:#894813}rect.shade{fill:#1f3857}\
    rect.hole{fill:#a8325e}";

fn pixels(columns: usize, rows: usize) -> (f64, f64) {
    (columns as f64 * CELL.0, rows as f64 * CELL.1)
}

fn words(class: &str, (column, row): (usize, usize), words: &str) -> String {
    let (x, y) = pixels(column, row);
    text(class, (x, y + 0.8 * CELL.1), "start", words)
}

/// Glyphs, one in each cell from this one on.
fn run(class: &str, (column, row): (usize, usize), glyphs: &str) -> String {
    let column = column + glyphs.len() - glyphs.trim_start().len();
    let ((x, y), glyphs) = (pixels(column, row), glyphs.trim());
    if glyphs.is_empty() {
        return String::new();
    }
    let class = if class.is_empty() { "".into() } else { format!(" class=\"{class}\"") };
    let (y, (length, _)) = (y + 0.8 * CELL.1, pixels(glyphs.len(), 0));
    format!("<text{class} x=\"{x:.1}\" y=\"{y:.1}\" textLength=\"{length:.1}\">{glyphs}</text>\n")
}

/// Filled cells, from this one on.
fn block(class: &str, (column, row): (usize, usize), count: usize) -> String {
    let ((x, y), (length, height)) = (pixels(column, row), pixels(count, 1));
    let size = format!("width=\"{length:.1}\" height=\"{height:.1}\"");
    format!("<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" {size}/>\n")
}

/// The part of a picture in these columns and rows, with its top left corner in the cell `at`. `mark` gives
/// the class of each cell, or nothing where it is not marked.
fn part(
    (picture, width): (&[u8], usize),
    (columns, rows): (Range<usize>, Range<usize>),
    at: (usize, usize),
    mark: impl Fn(usize) -> &'static str,
) -> String {
    let mut svg = String::new();
    for (y, row) in rows.enumerate() {
        let cells: Vec<_> = columns.clone().map(|column| row * width + column).collect();
        for alike in cells.chunk_by(|&a, &b| mark(a) == mark(b)) {
            let (class, at) = (mark(alike[0]), (at.0 + alike[0] - cells[0], at.1 + y));
            if !["", "wrong"].contains(&class) {
                svg += &block(class, at, alike.len());
            }
            svg +=
                &run(class, at, std::str::from_utf8(&picture[alike[0]..][..alike.len()]).unwrap());
        }
    }
    svg
}

/// The moving picture. All frames are in one strip, one below another, and the strip moves up behind a
/// window that is as high as one frame. It shows 15 frames a second, half as many as the program does by
/// default, so the donut turns about twice as far from one to the next. After 157 frames A has gone round
/// twice and B once, and the animation starts again without a jump.
pub fn moving() -> String {
    const FRAMES: usize = 157;
    /// The rows of a frame, and an empty one as a margin.
    const ROWS: usize = 23;
    /// The columns that the donut is seen in, in any of the frames, and a margin.
    const COLUMNS: Range<usize> = 15..65;
    let spin = [2.0, 1.0].map(|turns| turns * TAU / FRAMES as f64);
    let (mut renderer, mut angles) = (Renderer::new(View::DONUT_C, Method::Classic), [0.0; 2]);
    let mut strip = String::new();
    for n in 0..FRAMES {
        renderer.render_frame(angles[0], angles[1]);
        angles = renderer.advance(angles, spin);
        strip += &part((&renderer.framebuffer, 80), (COLUMNS, 0..22), (0, n * ROWS), |_| "");
    }
    let style = format!(
        "{CELLS}g{{animation:film {:.2}s steps({FRAMES}) infinite}}\
         @keyframes film{{to{{transform:translateY(-{}px)}}}}\
         @media(prefers-reduced-motion:reduce){{g{{animation:none}}}}",
        FRAMES as f64 / 15.0,
        pixels(0, FRAMES * ROWS).1
    );
    let title = "A spinning donut of ASCII characters";
    svg(title, pixels(COLUMNS.len(), ROWS), &style, &format!("<g>\n{strip}</g>\n"))
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

/// Frame 252 of donut.c, by classic and by exact, side by side.
pub fn two_methods() -> String {
    /// The columns and the rows that the donut is seen in.
    const PART: (Range<usize>, Range<usize>) = (17..54, 1..22);
    let view = View::DONUT_C;
    let [classic, exact] =
        [Method::Classic, Method::Exact].map(|method| draw(method, view, 10.08, 5.04));
    let mark = |cell: usize| mark(classic[cell], exact[cell]);
    let count = |wanted| (0..classic.len()).filter(|&cell| mark(cell) == wanted).count();
    let surface = exact.iter().filter(|&&glyph| glyph != b' ').count();
    let [shade, extra] = ["shade", "extra"].map(count);
    let different = 100 * (shade + extra) / surface;
    let (left, right, below) = (2, 2 + PART.0.len() + 4, 5 + PART.1.len());
    let contents = [
        words("title", (left, 1), "classic"),
        words("caption", (left, 2), "the nearest point in a cell"),
        part((&classic, view.width), PART, (left, 4), mark),
        words("title", (right, 1), "exact"),
        words("caption", (right, 2), "the point at a cell's centre"),
        part((&exact, view.width), PART, (right, 4), |_| ""),
        block("shade", (left, below), 2),
        words("caption", (left + 3, below), &format!("another character: {shade} cells")),
        block("extra", (left, below + 1), 2),
        words("caption", (left + 3, below + 1), &format!("blank in exact: {extra} cells")),
        words("caption", (right, below), &format!("the donut: {surface} cells")),
        words("caption", (right, below + 1), &format!("different: {different}%")),
    ];
    let title = "A donut drawn by classic, and the same donut drawn by exact";
    svg(title, pixels(right + PART.0.len() + 2, below + 3), CELLS, &contents.concat())
}

/// Methods that fail, each in a scene of the study's table, beside the same part of the picture by exact.
pub fn failures() -> String {
    /// The columns and the rows of a part.
    const PART: (usize, usize) = (35, 12);
    let (left, right) = (2, 2 + PART.0 + 3);
    let mut contents = [
        block("hole", (left, 1), 2),
        words("caption", (left + 3, 1), "blank, but not in exact"),
        block("extra", (right, 1), 2),
        words("caption", (right + 3, 1), "blank in exact"),
        block("shade", (left, 2), 2),
        words("caption", (left + 3, 2), "another character"),
        words("caption", (right, 2), "right: the same by exact"),
    ]
    .concat();
    let titles = [
        ("Gaps", "donut.c's steps at --k2 3.03: too few samples"),
        ("A bitten outline", "sphere tracing: grazing rays run out of their 16 steps"),
        ("Noise", "Ferrari's formula in f32 at --k2 50: rounding errors"),
    ];
    let shown = [
        ("classic with donut.c's steps", "`--k2 3.03`", 2, (40, 8)),
        ("sphere tracing 16", "80x22", 6, (19, 4)),
        ("Ferrari f32", "`--k2 50`", 9, (76, 13)),
    ];
    for (n, ((title, caption), (name, scene, pose, corner))) in
        titles.into_iter().zip(shown).enumerate()
    {
        let (_, view, poses) = scenes().into_iter().find(|other| other.0 == scene).unwrap();
        let [drawn, exact] = [name, "exact"].map(|name| {
            let (_, mut draw) = methods(view).into_iter().find(|method| method.0 == name).unwrap();
            draw(poses[pose].0, poses[pose].1)
        });
        let mark = |cell: usize| mark(drawn[cell], exact[cell]);
        let cells = || (corner.0..corner.0 + PART.0, corner.1..corner.1 + PART.1);
        let top = 4 + n * (PART.1 + 5);
        contents += &words("title", (left, top), title);
        contents += &words("caption", (left, top + 1), caption);
        contents += &part((&drawn, view.width), cells(), (left, top + 3), mark);
        contents += &part((&exact, view.width), cells(), (right, top + 3), |_| "");
    }
    let title = "Three methods that fail, beside exact, with their wrong cells marked";
    svg(title, pixels(right + PART.0 + 2, 3 + 3 * (PART.1 + 5)), CELLS, &contents)
}

// ---- Charts --------------------------------------------------------------------------------------

const STYLE: &str = "circle,text,path{fill:currentColor}polyline,.arrow,.box{fill:none;stroke:currentColor}\
    polyline,.arrow{stroke-width:2}polyline.grid{stroke-width:1}.box{stroke-width:1.5}\
    text{font:15px system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;paint-order:stroke;\
    stroke-width:4px;stroke-linejoin:round}text.title{font-size:18px;font-weight:bold}\
    circle.ring{stroke:currentColor;stroke-width:2px}\n\
    .page,circle.ring{fill:#ffffff}text{stroke:#ffffff}\
    .grid{color:#e2e5e9}.ink{color:#24292f}.grey{color:#5c646e}.orange{color:#bc4c00}\
    .green{color:#116329}.blue{color:#0550ae}.purple{color:#7d35b5}.red{color:#b3243c}\n\
    @media(prefers-color-scheme:dark){.page,circle.ring{fill:#0d1117}text{stroke:#0d1117}\
    .grid{color:#2b313a}.ink{color:#e6edf3}.grey{color:#a0a8b2}.orange{color:#f0883e}\
    .green{color:#56d364}.blue{color:#79c0ff}.purple{color:#d2a8ff}.red{color:#ff8b98}}";

/// Where the scales of a chart are, in pixels: the left end and the right end, and the top and the bottom.
const ENDS: (f64, f64) = (58.0, 500.0);
const SPAN: (f64, f64) = (92.0, 310.0);
/// The scale of wrong cells ends here. Being logarithmic, it has no place for 0, so the methods without a
/// wrong cell are in a box below it.
const LEAST: f64 = 0.03;
const BOX: (f64, f64) = (324.0, 402.0);
const ROWS: [&str; 3] = ["exact", "closed form", "Ferrari f64"];

fn line(class: &str, points: &[(f64, f64)]) -> String {
    let points: Vec<_> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    format!("<polyline class=\"{class}\" points=\"{}\"/>\n", points.join(" "))
}

fn circle(class: &str, (x, y): (f64, f64), radius: u32) -> String {
    format!("<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>\n")
}

/// The label of a dot: its size and method, how far from it the label is, which end of the label is there,
/// and the words, with # for the time.
type Label<'a> = (&'a str, &'a str, (f64, f64), &'a str, &'a str);

/// A chart of the time of a frame, to the right, and of the wrong cells, upward. Methods whose names begin
/// with `hidden` are left out. At the second size, the dots are rings.
fn chart(times: (f64, f64), sizes: &[&str], hidden: &str, labels: &[Label]) -> String {
    let ((left, right), (top, bottom), (box_top, end)) = (ENDS, SPAN, BOX);
    let x = |time: f64| left + (right - left) * (time / times.0).ln() / (times.1 / times.0).ln();
    let y = |name: &str, share: f64| match ROWS.iter().position(|row| name.starts_with(row)) {
        Some(row) if share == 0.0 => {
            box_top + (end - box_top) * (row as f64 + 0.5) / ROWS.len() as f64
        }
        _ => bottom - (bottom - top) * (share / LEAST).ln() / (100.0 / LEAST).ln(),
    };
    let color = |name: &str| match name.split(' ').next().unwrap() {
        "exact" => "green",
        "classic" => "orange",
        "sphere" => "blue",
        "Newton" => "red",
        "donut.c" => "ink",
        _ => "purple",
    };
    let mut contents = format!(
        "<rect class=\"box green\" x=\"{left}\" y=\"{box_top}\" width=\"{}\" height=\"{}\" rx=\"6\"/>\n\
         <path class=\"arrow grey\" d=\"M106 264l-28 28\"/>\n\
         <path class=\"grey\" d=\"M72 298l4 -15l11 11z\"/>\n",
        right - left,
        end - box_top
    );
    for (class, at, anchor, words) in [
        ("title ink", (12.0, 30.0), "start", "Exact is the fastest method with no wrong cells"),
        ("ink", (12.0, 60.0), "start", "wrong cells, in % of the donut's cells"),
        ("ink", (right, end + 46.0), "end", "time per frame"),
        ("grey", (left - 8.0, (box_top + end) / 2.0 + 5.0), "end", "0"),
        ("grey", (112.0, 264.0), "start", "better"),
    ] {
        contents += &text(class, at, anchor, words);
    }
    for (time, name) in [(10.0, "10 µs"), (100.0, "100 µs"), (1000.0, "1 ms"), (10_000.0, "10 ms")]
    {
        if time < times.1 {
            contents += &line("grid", &[(x(time), top), (x(time), end)]);
            contents += &text("grey", (x(time), end + 21.0), "middle", name);
        }
    }
    for (share, name) in [(100.0, "100%"), (10.0, "10%"), (1.0, "1%"), (0.1, "0.1%")] {
        let y = y("", share);
        contents += &line("grid", &[(left, y), (right, y)]);
        contents += &text("grey", (left - 8.0, y + 5.0), "end", name);
    }
    let mut words = String::new();
    for (n, &size) in sizes.iter().enumerate() {
        let ring = ["", " ring"][n];
        contents += &circle(&format!("ink{ring}"), (330.0 + 90.0 * n as f64, 55.0), 5);
        contents += &text("ink", (342.0 + 90.0 * n as f64, 60.0), "start", size);
        let mut methods = measured(size);
        methods.retain(|method| !method.0.starts_with(hidden));
        methods.sort_by(|one, other| one.1.total_cmp(&other.1));
        let fastest = methods.iter().find(|method| method.2 == 0.0).unwrap();
        assert_eq!(fastest.0, "exact", "the title is wrong");
        for family in ["sphere", "classic", "exact", "closed"] {
            let members = methods.iter().filter(|method| method.0.starts_with(family));
            let points: Vec<_> =
                members.map(|(name, time, share)| (x(*time), y(name, *share))).collect();
            contents += &line(color(family), &points);
        }
        for (name, time, share) in methods {
            let (x, y) = (x(time), y(&name, share));
            let radius = if ["exact", "classic", "closed form", "donut.c (C)"].contains(&&*name) {
                6
            } else {
                4
            };
            contents += &circle(&format!("{}{ring}", color(&name)), (x, y), radius);
            for &(_, _, by, anchor, label) in
                labels.iter().filter(|label| (label.0, label.1) == (size, &*name))
            {
                let label = label.replace('#', &format!("{time:.0} µs"));
                words += &text(color(&name), (x + by.0, y + by.1 + 5.0), anchor, &label);
            }
        }
    }
    svg("Speed and accuracy of each method", (520.0, end + 62.0), STYLE, &(contents + &words))
}

/// The chart of the README.
pub fn one_size() -> String {
    const SIZE: &str = "80x22";
    let (left, right) = ((-12.0, 0.0), (11.0, 0.0));
    let labels = [
        (SIZE, "donut.c (C)", (8.0, -17.0), "end", "donut.c in C, #"),
        (SIZE, "donut.c (translated)", (8.0, 17.0), "end", "translated, #"),
        (SIZE, "classic", left, "end", "classic, #"),
        (SIZE, "sphere tracing 8", right, "start", "8 steps"),
        (SIZE, "sphere tracing 16", left, "end", "sphere tracing"),
        (SIZE, "sphere tracing 64", right, "start", "64 steps"),
        (SIZE, "sphere tracing 256", right, "start", "256 steps"),
        (SIZE, "Newton from one start", right, "start", "Newton, one start"),
        (SIZE, "Ferrari f32", left, "end", "Ferrari, f32"),
        (SIZE, "Ferrari f64", left, "end", "Ferrari, f64"),
        (SIZE, "closed form", left, "end", "closed form"),
        (SIZE, "exact", left, "end", "exact, #"),
        (SIZE, "exact one ray at a time", right, "start", "one ray at a time"),
    ];
    chart((3.0, 1300.0), &[SIZE], "classic ", &labels)
}

/// The chart of the study.
pub fn two_sizes() -> String {
    let (small, large) = ("80x22", "200x60");
    let (left, right) = ((-12.0, 0.0), (11.0, 0.0));
    let labels = [
        (small, "classic steps x2", (-10.0, -18.0), "start", "classic, steps twice as long"),
        (small, "classic steps x1/4", (11.0, -2.0), "start", "a quarter as long"),
        (large, "classic", (0.0, 18.0), "middle", "classic"),
        (small, "sphere tracing 8", left, "end", "8 steps"),
        (small, "sphere tracing 16", left, "end", "sphere tracing"),
        (large, "sphere tracing 256", right, "start", "256 steps"),
        (small, "Newton from one start", (-2.0, -17.0), "middle", "Newton, one start"),
        (large, "Newton from one start", right, "start", "Newton"),
        (small, "Ferrari f32", left, "end", "Ferrari, f32"),
        (large, "Ferrari f32", (6.0, 17.0), "middle", "Ferrari, f32"),
        (small, "Ferrari f64", left, "end", "Ferrari, f64"),
        (small, "closed form", left, "end", "closed form"),
        (small, "exact", left, "end", "exact"),
        (large, "exact one ray at a time", right, "start", "one ray at a time"),
    ];
    chart((3.0, 12_000.0), &[small, large], "donut.c ", &labels)
}
