//! The pictures of the README and of the study, as SVG: three of frames, and two charts. The charts follow
//! the page, which may be light or dark, and can be read even on a phone, 390 pixels wide.

use super::*;
use std::ops::Range;

fn svg(title: &str, (width, height): (f64, f64), style: &str, contents: &str) -> String {
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width:.1} {height:.1}\" \
         width=\"{width:.1}\" height=\"{height:.1}\">\n\
         <title>{title}</title>\n\
         <style>{style}</style>\n\
         <rect width=\"100%\" height=\"100%\" rx=\"8\" fill=\"#16181d\"/>\n\
         {contents}</svg>\n"
    )
}

// ---- Frames --------------------------------------------------------------------------------------

/// The width and the height of a cell, in pixels.
const CELL: (f64, f64) = (9.6, 19.2);
const CELLS: &str = "text{font:16px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;\
                     fill:#e6e6e6;white-space:pre}";
/// For the cells that differ from exact's.
const WRONG: &str = ".wrong,.hole{fill:#ff9d5c}rect.wrong{fill:#5a3418}";

fn pixels(columns: usize, rows: usize) -> (f64, f64) {
    (columns as f64 * CELL.0, rows as f64 * CELL.1)
}

/// A run of glyphs. The first one is in the cell with this column and row.
fn run(column: usize, row: usize, class: &str, glyphs: &str) -> String {
    let ((x, top), (length, _)) = (pixels(column, row), pixels(glyphs.len(), 0));
    let y = top + 0.8 * CELL.1;
    format!("<text{class} x=\"{x:.1}\" y=\"{y:.1}\" textLength=\"{length:.1}\">{glyphs}</text>\n")
}

/// The moving picture. All frames are in one strip, one below another, and the strip moves up behind a
/// window that is as high as one frame. It shows 15 frames a second, half as many as the program does by
/// default, so the donut turns about twice as far from one to the next. After 157 frames A has gone round
/// twice and B once, and the animation starts again without a jump.
pub fn moving() -> String {
    const FRAMES: usize = 157;
    /// The rows of a frame, and an empty one as a margin.
    const ROWS: usize = 23;
    /// The columns that are shown: those that the donut is seen in, in any of the frames, and a margin.
    const COLUMNS: Range<usize> = 15..65;
    let spin = [2.0, 1.0].map(|turns| turns * TAU / FRAMES as f64);
    let (mut renderer, mut angles) = (Renderer::new(View::DONUT_C, Method::Classic), [0.0; 2]);
    let mut strip = String::new();
    for n in 0..FRAMES {
        renderer.render_frame(angles[0], angles[1]);
        angles = renderer.advance(angles, spin);
        for (row, line) in renderer.framebuffer.chunks(80).enumerate() {
            let line = std::str::from_utf8(line).unwrap().trim_end();
            let glyphs = line.trim_start();
            if !glyphs.is_empty() {
                let column = line.len() - glyphs.len() - COLUMNS.start;
                assert!(line.len() <= COLUMNS.end);
                strip += &run(column, n * ROWS + row, "", glyphs);
            }
        }
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

/// The part of a picture in these columns and rows, with its top left corner in the cell `at`. Cells that
/// differ from exact's picture are filled.
fn compared(
    [drawn, exact]: [&[u8]; 2],
    width: usize,
    (columns, rows): (Range<usize>, Range<usize>),
    at: (usize, usize),
) -> String {
    let mut cells = String::new();
    for row in rows.clone() {
        let (drawn, exact) = (&drawn[row * width..], &exact[row * width..]);
        let kind = |&i: &usize| (drawn[i] != b' ', drawn[i] != exact[i]);
        for part in columns.clone().collect::<Vec<_>>().chunk_by(|a, b| kind(a) == kind(b)) {
            let (column, row) = (at.0 + part[0] - columns.start, at.1 + row - rows.start);
            let glyphs: String = part.iter().map(|&i| char::from(drawn[i])).collect();
            let (is_drawn, is_wrong) = kind(&part[0]);
            if is_wrong {
                let class = if is_drawn { "wrong" } else { "hole" };
                cells += &block(class, column, row, part.len());
            }
            if is_drawn {
                cells += &run(column, row, if is_wrong { " class=\"wrong\"" } else { "" }, &glyphs);
            }
        }
    }
    cells
}

/// Filled cells, from this column and row on.
fn block(class: &str, column: usize, row: usize, count: usize) -> String {
    let ((x, y), (length, height)) = (pixels(column, row), pixels(count, 1));
    let size = format!("width=\"{length:.1}\" height=\"{height:.1}\"");
    format!("<rect class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" {size}/>\n")
}

/// One pose in both methods, side by side. Where classic differs from exact, it has another colour.
pub fn two_methods() -> String {
    /// The columns that are shown. (The rows from 15 on are below the donut.)
    const COLUMNS: Range<usize> = 6..37;
    let view = fitted(40, 17);
    let [classic, exact] =
        [Method::Classic, Method::Exact].map(|method| draw(method, view, 0.35, 0.5));
    // One cell of margin all round, two cells between the pictures, and a row for the methods' names.
    let right = 1 + COLUMNS.len() + 2;
    let mut texts = String::new();
    for (picture, name, left) in [(&classic, "classic", 1), (&exact, "exact", right)] {
        texts += &run(left, 1, "", name);
        texts += &compared([picture, &exact], view.width, (COLUMNS, 0..15), (left, 2));
    }
    let title = "A donut drawn by classic, and the same donut drawn by exact";
    svg(title, pixels(right + COLUMNS.len() + 1, 18), &format!("{CELLS}{WRONG}"), &texts)
}

/// Methods that fail, each in a scene of the study's table. Of the ten poses, this shows the one with the
/// most wrong cells, and of its picture, the part with the most.
pub fn failures() -> String {
    /// The columns and rows of a part.
    const PART: (usize, usize) = (46, 20);
    let mut texts = String::new();
    let shown = [
        ("donut.c's steps", "gaps", "--k2 3.003"),
        ("Sphere tracing", "the outline is nibbled", "--k2 3.003"),
        ("Newton", "the far wall shows", "--k2 50"),
        ("Ferrari, f32", "large terms cancel", "--k2 50"),
        ("Ferrari, f64", "division by almost 0", "edge-on"),
        ("Ferrari, f64", "large terms cancel", "--k2 50000"),
    ];
    for (n, (name, failure, scene)) in shown.into_iter().enumerate() {
        let (_, view, poses) = scenes().into_iter().find(|other| other.0 == scene).unwrap();
        let mut methods = compared_methods(view);
        methods.retain(|method| [name, "Exact"].contains(&&*method.0));
        let pictures = poses.into_iter().map(|(a, b)| [0, 1].map(|i| methods[i].1(a, b)));
        let wrong = |[drawn, exact]: &[Vec<u8>; 2], columns: Range<usize>, rows: Range<usize>| {
            let cells = rows.flat_map(|row| columns.clone().map(move |i| row * view.width + i));
            cells.filter(|&cell| drawn[cell] != exact[cell]).count()
        };
        let pictures = pictures.max_by_key(|both| wrong(both, 0..view.width, 0..view.height));
        let pictures = pictures.unwrap();
        let part = |(column, row)| (column..column + PART.0, row..row + PART.1);
        let count = |corner| wrong(&pictures, part(corner).0, part(corner).1);
        let columns_and_rows = (0..=view.height - PART.1)
            .flat_map(|row| (0..=view.width - PART.0).map(move |column| (column, row)));
        let corners: Vec<_> = columns_and_rows.map(|corner| (count(corner), corner)).collect();
        // If the donut has room in several parts, it is in the middle of this one.
        let most = corners.iter().map(|corner| corner.0).max().unwrap();
        let mut best = corners.iter().filter(|corner| corner.0 == most).map(|corner| corner.1);
        let (first, last) = (best.clone().next().unwrap(), best.next_back().unwrap());
        let corner = ((first.0 + last.0) / 2, (first.1 + last.1) / 2);
        let (left, top) = (2 + n % 3 * (PART.0 + 4), 4 + n / 3 * (PART.1 + 6));
        let (x, y) = pixels(left, top);
        let title = format!("{failure}<tspan x=\"{x:.1}\" dy=\"28\">{name}, {scene}</tspan>");
        texts += &format!("<text class=\"name\" x=\"{x:.1}\" y=\"{y:.1}\">{title}</text>\n");
        let both = pictures.each_ref().map(Vec::as_slice);
        texts += &compared(both, view.width, part(corner), (left, top + 2));
    }
    // The key.
    for (class, column, name) in [("wrong", 2, "a wrong character"), ("hole", 38, "a wrong blank")]
    {
        let (x, y) = pixels(column, 2);
        texts += &block(class, column, 1, 3);
        let x = x + 4.0 * CELL.0;
        texts += &format!("<text class=\"name\" x=\"{x:.1}\" y=\"{y:.1}\">{name}</text>\n");
    }
    let style = format!("{CELLS}{WRONG}.name{{font-size:25px}}tspan{{fill:#9aa3ad}}");
    let title = "Frames of methods that fail, with the wrong cells in orange";
    svg(title, pixels(3 * (PART.0 + 4), 2 * (PART.1 + 6) + 1), &style, &texts)
}

// ---- Charts --------------------------------------------------------------------------------------

const STYLE: &str = "rect,circle,text{fill:currentColor}\
    polyline{fill:none;stroke:currentColor;stroke-width:2}.grid{stroke-width:1}\
    text{font:13px system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;paint-order:stroke;\
    stroke:#ffffff;stroke-width:4px;stroke-linejoin:round}.title{font-size:16px}\
    circle{stroke:#ffffff;stroke-width:1px}\n\
    rect{color:#ffffff}.grid{color:#e2e5e9}.ink{color:#24292f}.grey{color:#5c646e}\
    .faint{color:#e2a478}.orange{color:#bc4c00}.green{color:#116329}.blue{color:#0550ae}\
    .purple{color:#7d35b5}\n\
    @media(prefers-color-scheme:dark){text,circle{stroke:#0d1117}\
    rect{color:#0d1117}.grid{color:#2b313a}.ink{color:#e6edf3}.grey{color:#a0a8b2}\
    .faint{color:#7a4c2a}.orange{color:#f0883e}.green{color:#56d364}.blue{color:#79c0ff}\
    .purple{color:#d2a8ff}}";

struct Axis {
    title: &'static str,
    scale: fn(f64) -> f64,
    /// The values at the two ends.
    ends: [f64; 2],
    /// The marked values, and their names.
    marks: &'static [f64],
    names: &'static [&'static str],
}

const TIME_AT_80X22: Axis = Axis {
    title: "time of a frame in µs (logarithmic scale)",
    scale: f64::log10,
    ends: [5.0, 3000.0],
    marks: &[10.0, 30.0, 100.0, 300.0, 1000.0],
    names: &["10", "30", "100", "300", "1000"],
};

const TIME_AT_200X60: Axis = Axis {
    ends: [35.0, 21_000.0],
    marks: &[100.0, 300.0, 1000.0, 3000.0, 10_000.0],
    names: &["100", "300", "1000", "3000", "10,000"],
    ..TIME_AT_80X22
};

const WRONG_CELLS: Axis = Axis {
    title: "wrong cells, as % of the donut's cells (cube-root scale)",
    // A cube root spreads small shares out, as a logarithm does, but it also has a place for 0.
    scale: f64::cbrt,
    ends: [-0.3, 95.0],
    marks: &[0.0, 0.1, 1.0, 5.0, 10.0, 20.0, 40.0, 60.0],
    names: &["0%", "0.1%", "1%", "5%", "10%", "20%", "40%", "60%"],
};

const MINUTE: f64 = 60.0 * 30.0;
const HOUR: f64 = 60.0 * MINUTE;
const DAY: f64 = 24.0 * HOUR;

const RUNNING_TIME: Axis = Axis {
    title: "running time, at 30 frames a second (logarithmic scale)",
    scale: f64::log10,
    ends: [0.6 * MINUTE, 30.0 * DAY],
    marks: &[MINUTE, HOUR, 31.0 * HOUR, 9.0 * DAY],
    names: &["1 minute", "1 hour", "31 hours", "9 days"],
};

const TURNS: Axis = Axis {
    title: "largest error of A so far, in turns (logarithmic scale)",
    scale: f64::log10,
    ends: [5e-5, 1e5],
    marks: &[0.001, 0.1, 1.0, 10.0, 1000.0],
    names: &["0.001", "0.1", "1", "10", "1,000"],
};

/// A chart, whose title says what it shows, and whose curves have labels instead of a key.
struct Chart {
    height: f64,
    x: &'static Axis,
    y: &'static Axis,
    svg: String,
}

impl Chart {
    fn new(title: &str, height: f64, x: &'static Axis, y: &'static Axis) -> Chart {
        let ([left, right], [bottom, top]) = (x.ends, y.ends);
        let mut chart = Chart { height, x, y, svg: String::new() };
        for (&at, name) in x.marks.iter().zip(x.names) {
            chart.line("grid", &[(at, bottom), (at, top)]);
            chart.text("grey", (at, bottom), (0.0, 13.0), "middle", name);
        }
        for (&at, name) in y.marks.iter().zip(y.names) {
            chart.line("grid", &[(left, at), (right, at)]);
            chart.text("grey", (left, at), (-8.0, 0.0), "end", name);
        }
        chart.text("ink title", (left, top), (-48.0, -44.0), "start", title);
        chart.text("ink", (left, top), (-48.0, -20.0), "start", y.title);
        chart.text("ink", (right, bottom), (0.0, 33.0), "end", x.title);
        chart
    }

    /// Where a point is, in pixels.
    fn place(&self, (x, y): (f64, f64)) -> (f64, f64) {
        let part = |axis: &Axis, value| {
            let [start, end, value] = [axis.ends[0], axis.ends[1], value].map(axis.scale);
            (value - start) / (end - start)
        };
        (60.0 + 435.0 * part(self.x, x), 62.0 + (self.height - 115.0) * (1.0 - part(self.y, y)))
    }

    fn line(&mut self, color: &str, points: &[(f64, f64)]) {
        let places = points.iter().map(|&point| self.place(point));
        let places = places.map(|(x, y)| format!("{x:.1},{y:.1}")).collect::<Vec<_>>().join(" ");
        self.svg += &format!("<polyline class=\"{color}\" points=\"{places}\"/>\n");
    }

    fn dot(&mut self, color: &str, at: (f64, f64), radius: u32) {
        let (x, y) = self.place(at);
        self.svg +=
            &format!("<circle class=\"{color}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>\n");
    }

    /// Writes a text, so many pixels from a point. `anchor` says which part of the text is there.
    fn text(&mut self, color: &str, at: (f64, f64), by: (f64, f64), anchor: &str, text: &str) {
        let (x, y) = self.place(at);
        let (x, y) = (x + by.0, y + by.1 + 4.5);
        let place = format!("x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\"");
        self.svg += &format!("<text class=\"{color}\" {place}>{text}</text>\n");
    }
}

/// The name of a method, how to draw its dot, and where its label is: how far from the dot, and which part of
/// the label is there. In the label, # stands for the time.
type Label = (&'static str, &'static str, u32, (f64, f64), &'static str, &'static str);

const LABELS: [Label; 16] = [
    ("classic x4", "faint", 3, (-3.0, -13.0), "start", "classic, steps 4x as long"),
    ("classic x2", "faint", 3, (-3.0, -13.0), "start", "2x as long"),
    ("classic x1", "orange", 6, (0.0, 18.0), "middle", "classic, # µs"),
    ("classic x1/2", "faint", 3, (-3.0, -13.0), "start", "half as long"),
    ("classic x1/4", "faint", 3, (-3.0, -13.0), "start", "1/4 as long"),
    ("donut.c as written", "ink", 6, (0.0, 18.0), "middle", "literal donut.c, # µs"),
    ("donut.c's steps", "orange", 3, (4.0, -14.0), "start", "donut.c's steps"),
    ("sphere tracing 8", "blue", 3, (9.0, -2.0), "start", "sphere tracing, 8 steps"),
    ("sphere tracing 64", "blue", 3, (-9.0, 2.0), "end", "64 steps"),
    ("sphere tracing 256", "blue", 3, (9.0, -6.0), "start", "256 steps"),
    ("Ferrari f32", "purple", 3, (9.0, 0.0), "start", "Ferrari, f32"),
    ("Ferrari f64", "purple", 3, (9.0, 0.0), "start", "Ferrari, f64"),
    ("Newton", "purple", 3, (9.0, 0.0), "start", "Newton"),
    ("exact", "green", 8, (0.0, 18.0), "middle", "exact, # µs"),
    ("exact one ray at a time", "green", 7, (-5.0, 17.0), "start", "exact, one ray at a time"),
    ("closed form f64", "purple", 3, (-5.0, 33.0), "start", "closed form"),
];

/// A dot for each method: to the right is the time of a frame in microseconds, and upward the share of
/// wrong cells in per cent.
fn panel(title: &str, size: &str, time: &'static Axis) -> Chart {
    let mut chart = Chart::new(&format!("{size}: {title}"), 400.0, time, &WRONG_CELLS);
    let steps = ["x4", "x2", "x1", "x1/2", "x1/4"];
    chart.line("faint", &steps.map(|steps| time_and_share(size, &format!("classic {steps}"))));
    let tracing = [8, 16, 32, 64, 256].map(|steps| format!("sphere tracing {steps}"));
    let tracing = tracing.map(|name| time_and_share(size, &name));
    chart.line("blue", &tracing);
    tracing.iter().for_each(|&at| chart.dot("blue", at, 3));
    for (name, color, radius, by, anchor, label) in LABELS {
        let by = match (size, name) {
            // In this picture, classic has donut.c's steps.
            ("80x22", "donut.c's steps") => continue,
            // Here, these would be in the way of others.
            ("200x60", "classic x2") => (2.0, -10.0),
            ("200x60", "sphere tracing 8") => (16.0, 20.0),
            _ => by,
        };
        let at = time_and_share(size, name);
        let decimals = usize::from(at.0 < 100.0);
        let label = label.replace('#', &format!("{:.decimals$}", at.0));
        chart.dot(color, at, radius);
        chart.text(if color == "faint" { "grey" } else { color }, at, by, anchor, &label);
    }
    chart
}

/// Both sizes, one above the other.
pub fn speed_and_accuracy() -> String {
    let small = panel("donut.c's own picture", "80x22", &TIME_AT_80X22);
    let large = panel("a full screen", "200x60", &TIME_AT_200X60);
    let title = "The fastest without a wrong cell: exact, eight rays at a time";
    let panels = format!(
        "<text class=\"ink title\" x=\"12\" y=\"26\">{title}</text>\n\
         <g transform=\"translate(0 34)\">\n{}</g>\n<g transform=\"translate(0 {})\">\n{}</g>\n",
        small.svg,
        34.0 + small.height,
        large.svg
    );
    svg(title, (520.0, 34.0 + small.height + large.height), STYLE, &panels)
}

/// The largest error of donut.c's angle A so far, over the running time.
pub fn drift(errors: &[(f64, f64)]) -> String {
    let title = "donut.c's angle A is a whole turn off in 1.8 hours";
    let mut chart = Chart::new(title, 360.0, &RUNNING_TIME, &TURNS);
    let points = errors.iter().map(|&(frame, error)| (frame, error / TAU));
    let shown = points.filter(|point| (RUNNING_TIME.ends[0]..=STOPPED).contains(&point.0));
    let points: Vec<_> = shown.collect();
    chart.line("orange", &points);
    for (event, name) in
        [(FASTER, "here A begins to turn 17% too fast"), (STOPPED, "A stands still")]
    {
        let at = *points.iter().find(|&&(frame, _)| frame == event).unwrap();
        chart.dot("ink", at, 5);
        chart.text("ink", at, (-10.0, -4.0), "end", name);
    }
    svg(title, (520.0, chart.height), STYLE, &chart.svg)
}
