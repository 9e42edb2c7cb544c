//! The two charts, as SVG: time to the right, and cells that are not as a rule wants them upward. They
//! follow the page, which may be light or dark, and can be read on a phone.

use super::picture::svg;
use super::*;

const STYLE: &str = "text{font:15px system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;\
    paint-order:stroke;stroke-width:4px;stroke-linejoin:round}text.title{font-size:18px;font-weight:bold}\
    circle,text{fill:currentColor}\
    polyline,.box{fill:none;stroke:currentColor}polyline.thick{stroke-width:2}\n\
    .page{fill:#ffffff}text{stroke:#ffffff}.grid{color:#e2e5e9}.ink{color:#24292f}.grey{color:#5c646e}\
    .orange{color:#bc4c00}.green{color:#116329}.blue{color:#0550ae}.purple{color:#7d35b5}\
    .red{color:#b3243c}\n\
    @media(prefers-color-scheme:dark){.page{fill:#0d1117}text{stroke:#0d1117}.grid{color:#2b313a}.ink{color:#e6edf3}\
    .grey{color:#a0a8b2}.orange{color:#f0883e}.green{color:#56d364}.blue{color:#79c0ff}\
    .purple{color:#d2a8ff}.red{color:#ff8b98}}";

const WIDTH: usize = 520;

fn chart(title: &str, height: usize, contents: &str) -> String {
    let page = "<rect class=\"page\" width=\"100%\" height=\"100%\" rx=\"8\"/>\n";
    svg(title, (WIDTH, height), 1.0, STYLE, &(page.to_string() + contents))
}

fn text(class: &str, (x, y): (f64, f64), anchor: &str, words: &str) -> String {
    format!(
        "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\" text-anchor=\"{anchor}\">{words}</text>\n"
    )
}

fn line(class: &str, points: &[(f64, f64)]) -> String {
    let points: Vec<_> = points.iter().map(|(x, y)| format!("{x:.1},{y:.1}")).collect();
    format!("<polyline class=\"{class}\" points=\"{}\"/>\n", points.join(" "))
}

fn dot(class: &str, (x, y): (f64, f64)) -> String {
    format!("<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5.5\"/>\n")
}

/// The README's chart: time against the difference from the average. Both axes are linear.
pub fn readme() -> String {
    const SIZE: &str = "80x22";
    const LEFT: f64 = 52.0;
    const BOTTOM: f64 = 322.0;
    /// Pixels for each per cent.
    const PER_CENT: f64 = 4.2;
    let names =
        ["donut.c (C)", "classic", "exact", "exact with 2 by 2 rays", "exact with 3 by 3 rays"];
    let [in_c, classic, exact, four, nine] = names.map(|name| find(SIZE, name).unwrap());
    let is_first = exact.time[0] < classic.time[0].min(in_c.time[0]);
    assert!(is_first && 5.0 * exact.different < classic.different, "the title is wrong");
    let micro = 430.0 / in_c.time[0];
    let at = |x: f64, y: f64| (LEFT + micro * x, BOTTOM - PER_CENT * y);
    let place = |measured: &Measured| at(measured.time[0], measured.different);
    let words = |name: &str, measured: &Measured| {
        format!("{name}: {:.0} µs, {}%", measured.time[0], share(measured.different))
    };
    let end = in_c.time[0] * 1.03;
    let mut contents =
        text("title ink", (12.0, 30.0), "start", "Exact is faster than donut.c, and more accurate");
    contents +=
        &text("ink", (12.0, 60.0), "start", "cells that differ from the average over the cell,");
    contents += &text("ink", (12.0, 80.0), "start", "in % of the donut's cells, at 80x22");
    contents += &text("ink", (at(end, 0.0).0, BOTTOM + 46.0), "end", "time per frame, in µs");
    let note = "donut.c's time includes putchar";
    contents += &text("grey", (12.0, BOTTOM + 46.0), "start", note);
    for share in [0, 10, 20, 30, 40, 50] {
        let (x, y) = at(0.0, share.into());
        contents += &line("grid", &[(x, y), at(end, share.into())]);
        contents += &text("grey", (x - 8.0, y + 5.0), "end", &share.to_string());
    }
    let step = if in_c.time[0] < 700.0 { 100.0 } else { 200.0 };
    for time in (0..).map(|n| f64::from(n) * step).take_while(|&time| time < end) {
        let (x, y) = at(time, 0.0);
        contents += &line("grid", &[(x, y), at(time, 52.0)]);
        contents += &text("grey", (x, y + 21.0), "middle", &time.to_string());
    }
    // A flag for each of the dots that are close together, each lower than the one to the left of it.
    for (measured, name, class, height) in [
        (&exact, "exact", "green", 26.0),
        (&four, "exact, mean of 2 by 2 rays", "grey", 18.5),
        (&nine, "exact, mean of 3 by 3 rays", "grey", 11.0),
    ] {
        let (x, top) = at(measured.time[0], height);
        contents += &line(class, &[place(measured), (x, top)]);
        contents += &dot(class, place(measured));
        contents += &text(class, (x + 5.0, top + 11.0), "start", &words(name, measured));
    }
    for (measured, name, class, (right, down), anchor) in [
        (&in_c, "donut.c in C", "ink", (6.0, 25.0), "end"),
        (&classic, "classic", "orange", (12.0, 5.0), "start"),
    ] {
        let (x, y) = place(measured);
        contents += &dot(class, (x, y));
        contents += &text(class, (x + right, y + down), anchor, &words(name, measured));
    }
    chart("Time and accuracy of donut.c, classic and exact", 380, &contents)
}

/// The study's chart: a panel for each size, with the same axes, both of them logarithmic.
pub fn study() -> String {
    const LEFT: f64 = 58.0;
    const RIGHT: f64 = 496.0;
    /// The pixels of a factor of 10, across and up.
    const DECADE: (f64, f64) = (206.0, 70.0);
    /// The scale begins at 10 µs, and ends below at so many per cent. The methods without a wrong cell
    /// are below that, in rows of their own.
    const LEAST: f64 = 0.03;
    const ROWS: [(&str, f64); 3] = [("exact", 26.0), ("closed form", 52.0), ("Ferrari f64", 86.0)];
    const PANEL: f64 = 430.0;
    const TOP: f64 = 130.0;
    let bottom = DECADE.1 * (100.0 / LEAST).log10();
    let x = |time: f64| LEFT + DECADE.0 * (time / 10.0).log10();
    let y = |share: f64| bottom - DECADE.1 * (share / LEAST).log10();
    let mut contents =
        text("title ink", (12.0, 30.0), "start", "Exact is the fastest without a wrong cell");
    contents += &text(
        "ink",
        (12.0, 60.0),
        "start",
        "cells that are wrong by the ray through their centre,",
    );
    contents += &text("ink", (12.0, 80.0), "start", "in % of the donut's cells");
    let titles = ["80x22, donut.c's own picture", "200x60, a full screen"];
    for (n, (size, title)) in SIZES.into_iter().zip(titles).enumerate() {
        let top = TOP + n as f64 * PANEL;
        let place = |method: &Measured| {
            let row = ROWS.iter().find(|row| row.0 == method.name && method.wrong == 0.0);
            (x(method.time[0]), top + row.map_or_else(|| y(method.wrong), |row| bottom + row.1))
        };
        let (box_top, end) = (top + bottom + 9.0, top + bottom + 104.0);
        contents += &text("ink", (LEFT, top - 14.0), "start", title);
        for (share, name) in [(100.0, "100%"), (10.0, "10%"), (1.0, "1%"), (0.1, "0.1%")] {
            contents += &line("grid", &[(LEFT, top + y(share)), (RIGHT, top + y(share))]);
            contents += &text("grey", (LEFT - 8.0, top + y(share) + 5.0), "end", name);
        }
        for (time, name) in [(10.0, "10 µs"), (100.0, "100 µs"), (1000.0, "1 ms")] {
            contents += &line("grid", &[(x(time), top), (x(time), end)]);
            contents += &text("grey", (x(time), end + 20.0), "middle", name);
        }
        contents += &format!(
            "<rect class=\"box green\" x=\"{LEFT}\" y=\"{box_top:.1}\" width=\"{}\" height=\"60\" rx=\"6\"/>\n",
            RIGHT - LEFT
        );
        contents += &text("grey", (LEFT - 8.0, box_top + 35.0), "end", "0");
        contents += &text("grey", (LEFT - 8.0, top + bottom + 91.0), "end", "0*");

        let methods = measured(size);
        let without_wrong = methods.iter().filter(|method| method.wrong == 0.0);
        let fastest = without_wrong.min_by(|one, other| one.time[0].total_cmp(&other.time[0]));
        assert!(fastest.unwrap().name.starts_with("exact"), "the title is wrong");
        let spheres = methods.iter().filter(|method| method.name.starts_with("sphere"));
        contents += &line("thick blue", &spheres.map(place).collect::<Vec<_>>());
        // In the first panel there is more space on the right, and in the second one on the left.
        let (right, below) = (((12.0, 5.0), "start"), ((6.0, 24.0), "end"));
        let above_line = ((13.0, 2.0), "start");
        let free = [right, ((-12.0, 5.0), "end")][n];
        for (name, class, ((right, down), anchor), words) in [
            ("donut.c (C)", "ink", below, "donut.c in C"),
            ("classic", "orange", free, "classic"),
            ("sphere tracing 8", "blue", free, "sphere tracing, 8 steps"),
            ("sphere tracing 16", "blue", above_line, "16"),
            ("sphere tracing 32", "blue", above_line, "32"),
            ("sphere tracing 64", "blue", above_line, "64"),
            ("sphere tracing 256", "blue", right, "256"),
            ("Newton from one start", "red", right, "Newton"),
            ("Ferrari f32", "purple", ((0.0, 24.0), "middle"), "Ferrari, f32"),
            ("Ferrari f64", "purple", free, "Ferrari, f64"),
            ("closed form", "green", free, "closed form"),
            ("exact", "green", free, "exact"),
        ] {
            if let Some(method) = find(size, name) {
                let (x, y) = place(&method);
                contents += &dot(class, (x, y));
                contents += &text(class, (x + right, y + down), anchor, words);
            }
        }
    }
    let height = TOP + 2.0 * PANEL - 14.0;
    contents += &text("grey", (12.0, height - 14.0), "start", "* but wrong in other scenes");
    contents += &text("ink", (RIGHT, height - 14.0), "end", "time per frame");
    chart("Time and wrong cells of each method, in two sizes", height as usize, &contents)
}
