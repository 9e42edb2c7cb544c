//! The two charts, as SVG: time to the right, and cells that are not as a rule wants them upward. They
//! follow the page, which may be light or dark, and can be read on a phone.

use super::picture::svg;
use super::*;

const STYLE: &str = "text{font:15px system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;\
    paint-order:stroke;stroke-width:4px;stroke-linejoin:round}text.title{font-size:17px}.title,.bold{font-weight:bold}\
    circle,text{fill:currentColor}\
    polyline{fill:none;stroke:currentColor}.thick{stroke-width:2}circle.open{fill:none;stroke:currentColor;stroke-width:2}\n\
    .page{fill:#ffffff}text{stroke:#ffffff}.grid{color:#e2e5e9}.ink{color:#24292f}.grey{color:#5c646e}\
    .orange{color:#bc4c00}.green{color:#116329}.blue{color:#0550ae}.purple{color:#7d35b5}\
    .red{color:#b3243c}\n\
    @media(prefers-color-scheme:dark){.page{fill:#0d1117}text{stroke:#0d1117}.grid{color:#2b313a}.ink{color:#e6edf3}\
    .grey{color:#a0a8b2}.orange{color:#f0883e}.green{color:#56d364}.blue{color:#79c0ff}\
    .purple{color:#d2a8ff}.red{color:#ff8b98}}";

/// A chart below these words: for each line, its class, how far down it is, and its text.
fn chart(title: &str, height: f64, head: &[(&str, f64, &str)], contents: &str) -> String {
    let page = "<rect class=\"page\" width=\"100%\" height=\"100%\" rx=\"8\"/>\n".to_string();
    let head = head.iter().map(|&(class, down, words)| text(class, (12.0, down), "start", words));
    svg(title, (520, height as usize), 1.0, STYLE, &(page + &head.collect::<String>() + contents))
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

/// Where the words for a dot begin or end, seen from it.
type Beside = ((f64, f64), &'static str);

fn dot(class: &str, (x, y): (f64, f64), ((right, down), anchor): Beside, words: &str) -> String {
    format!("<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5.5\"/>\n")
        + &text(class, (x + right, y + down), anchor, words)
}

/// The README's chart: time against the difference from the average. An arrow leads from classic to exact at
/// the same size. The scale depends on the times, so that those of any computer fit.
pub fn readme() -> String {
    const LEFT: f64 = 52.0;
    const RIGHT: f64 = 508.0;
    const BOTTOM: f64 = 338.0;
    let in_c = find(SIZES[0], "donut.c (C)").unwrap();
    let pairs = SIZES.map(|size| ["classic", "exact"].map(|name| find(size, name).unwrap()));
    let ratios = pairs.each_ref().map(|[classic, exact]| {
        assert!(exact.different < classic.different, "the title is wrong");
        (classic.time[0] / exact.time[0]).round()
    });
    let [least, most] = [f64::min, f64::max].map(|pick| pick(ratios[0], ratios[1]));
    assert!(least >= 2.0, "the title is wrong");
    let times = if least == most { format!("about {least}") } else { format!("{least} to {most}") };
    let begin = pairs[0][1].time[0] / 2.4;
    let end = pairs[1][0].time[0].max(in_c.time[0]) * 1.9;
    let x = |time: f64| LEFT + (RIGHT - LEFT) * (time / begin).ln() / (end / begin).ln();
    let y = |share: f64| BOTTOM - 4.1 * share;
    let place = |measured: &Measured| (x(measured.time[0]), y(measured.different));
    let mut contents = text("ink", (RIGHT, BOTTOM + 47.0), "end", "µs per frame (logarithmic)");
    for share in [0.0, 10.0, 20.0, 30.0, 40.0, 50.0] {
        contents += &line("grid", &[(LEFT, y(share)), (RIGHT, y(share))]);
        contents += &text("grey", (LEFT - 8.0, y(share) + 5.0), "end", &share.to_string());
    }
    let is_shown = |time: &f64| (LEFT..RIGHT - 12.0).contains(&x(*time));
    for time in [1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0].into_iter().filter(is_shown) {
        contents += &line("grid", &[(x(time), y(53.0)), (x(time), BOTTOM)]);
        contents += &text("grey", (x(time), BOTTOM + 20.0), "middle", &time.to_string());
    }
    for (size, pair) in SIZES.into_iter().zip(&pairs) {
        let [from, to] = pair.each_ref().map(place);
        let (dx, dy) = (from.0 - to.0, from.1 - to.1);
        let length = dx.hypot(dy);
        // So many pixels before the arrow's end, and so many to its side.
        let at = |back: f64, side: f64| {
            (to.0 + (back * dx - side * dy) / length, to.1 + (back * dy + side * dx) / length)
        };
        contents += &line("thick grey", &[at(length - 10.0, 0.0), at(11.0, 0.0)]);
        contents += &line("thick grey", &[at(20.0, 5.0), at(11.0, 0.0), at(20.0, -5.0)]);
        contents += &text("bold ink", at(length / 2.0, -10.0), "end", size);
    }
    let [[classic, exact], [large_classic, large_exact]] = &pairs;
    let above = ((50.0, -16.0), "end");
    for (measured, class, beside, name) in [
        (classic, "orange", ((-12.0, 5.0), "end"), "classic"),
        (exact, "green", ((16.0, 5.0), "start"), "exact"),
        (large_classic, "orange", above, "classic"),
        (large_exact, "green", ((26.0, 5.0), "start"), "exact"),
        (&in_c, "ink", above, "donut.c in C (80x22)"),
    ] {
        let [time, different] = [measured.time[0].round().to_string(), share(measured.different)];
        contents +=
            &dot(class, place(measured), beside, &format!("{name}: {time} µs, {different}%"));
    }
    let head = [
        ("title ink", 30.0, &*format!("Exact: {times} times as fast as classic, and closer")),
        ("ink", 58.0, "donut's cells that differ from the average"),
        ("ink", 77.0, "of 256 rays through the cell, in %"),
        ("grey", BOTTOM + 47.0, "← faster, ↓ closer"),
    ];
    chart("Time and accuracy of donut.c, classic and exact", BOTTOM + 58.0, &head, &contents)
}

/// The study's chart: a panel for each size, with the same axes, both of them logarithmic.
pub fn study() -> String {
    const LEFT: f64 = 58.0;
    const RIGHT: f64 = 496.0;
    /// The pixels of a factor of 10, across and up.
    const DECADE: (f64, f64) = (206.0, 70.0);
    /// The scale begins at 10 µs, and ends below at so many per cent. The methods without a wrong cell
    /// are below that, at 0, each a little lower than the one before.
    const LEAST: f64 = 0.03;
    const ROWS: [(&str, f64); 3] = [("exact", 34.0), ("closed form", 57.0), ("Ferrari f64", 80.0)];
    const PANEL: f64 = 422.0;
    const TOP: f64 = 154.0;
    let bottom = DECADE.1 * (100.0 / LEAST).log10();
    let x = |time: f64| LEFT + DECADE.0 * (time / 10.0).log10();
    let y = |share: f64| bottom - DECADE.1 * (share / LEAST).log10();
    let mut contents = String::new();
    let titles =
        ["80x22, donut.c's own picture", "200x60, a full screen (donut.c draws only 80x22)"];
    for (n, (size, title)) in SIZES.into_iter().zip(titles).enumerate() {
        let top = TOP + n as f64 * PANEL;
        let place = |method: &Measured| {
            let row = ROWS.iter().find(|row| row.0 == method.name && method.wrong == 0.0);
            (x(method.time[0]), top + row.map_or_else(|| y(method.wrong), |row| bottom + row.1))
        };
        let end = top + bottom + 96.0;
        contents += &text("ink", (LEFT, top - 14.0), "start", title);
        for (share, name) in [(100.0, "100%"), (10.0, "10%"), (1.0, "1%"), (0.1, "0.1%")] {
            contents += &line("grid", &[(LEFT, top + y(share)), (RIGHT, top + y(share))]);
            contents += &text("grey", (LEFT - 8.0, top + y(share) + 5.0), "end", name);
        }
        for (time, name) in [(10.0, "10 µs"), (100.0, "100 µs"), (1000.0, "1 ms")] {
            contents += &line("grid", &[(x(time), top), (x(time), end)]);
            contents += &text("grey", (x(time), end + 20.0), "middle", name);
        }
        // The axis is broken between the logarithmic scale and 0.
        let tooth = |n: usize| (LEFT + 4.0 * n as f64, top + bottom + 11.0 + 4.0 * (n % 2) as f64);
        contents += &line("grey", &(0..110).map(tooth).collect::<Vec<_>>());
        contents += &text("grey", (LEFT - 8.0, top + bottom + 62.0), "end", "0");

        let methods = measured(size);
        let right = methods.iter().filter(|method| method.wrong == 0.0);
        let fastest = right.min_by(|one, other| one.time[0].total_cmp(&other.time[0]));
        assert_eq!(fastest.unwrap().name, "exact", "the title is wrong");
        let spheres = methods.iter().filter(|method| method.name.starts_with("sphere"));
        contents += &line("thick blue", &spheres.map(place).collect::<Vec<_>>());
        // In the first panel there is more space on the right, and in the second one on the left.
        let (right, below) = (((12.0, 5.0), "start"), ((6.0, 24.0), "end"));
        let above_line = ((13.0, 2.0), "start");
        let free = [right, ((-12.0, 5.0), "end")][n];
        for (name, class, beside, words) in [
            ("donut.c (C)", "ink", below, "donut.c in C"),
            ("classic", "orange", free, "classic"),
            ("sphere tracing 8", "blue", free, "sphere tracing, 8 steps"),
            ("sphere tracing 16", "blue", above_line, "16"),
            ("sphere tracing 32", "blue", above_line, "32"),
            ("sphere tracing 64", "blue", above_line, "64"),
            ("sphere tracing 256", "blue", right, "256"),
            ("Newton from one start", "red", right, "Newton"),
            ("Ferrari f32", "purple", below, "Ferrari, f32"),
            ("Ferrari f64", "open purple", free, "Ferrari, f64: fails in other scenes"),
            ("closed form", "green", free, "closed form"),
            ("exact", "green", free, "exact"),
        ] {
            if let Some(method) = find(size, name) {
                contents += &dot(class, place(&method), beside, words);
            }
        }
    }
    let height = TOP + 2.0 * PANEL - 14.0;
    contents += &text("ink", (RIGHT, height - 14.0), "end", "time per frame");
    let head = [
        ("title ink", 30.0, "Of the methods without a wrong cell, exact"),
        ("title ink", 53.0, "is the fastest here, eight rays at a time"),
        ("ink", 83.0, "cells that are wrong by the ray through their centre,"),
        ("ink", 103.0, "in % of the donut's cells"),
    ];
    chart("Time and wrong cells of each method, in two sizes", height, &head, &contents)
}
