//! The charts, as SVG. They follow the page, which may be light or dark, and can be read on a phone.

use super::picture::svg;
use super::*;

const STYLE: &str = "text{font:15px system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif;\
    paint-order:stroke;stroke-width:4px;stroke-linejoin:round}text.title{font-size:17px}.title,.bold{font-weight:bold}\
    text{fill:currentColor}\
    polyline{fill:none;stroke:currentColor}.thick{stroke-width:2}.dashed{stroke-dasharray:6 4}\
    rect,circle{fill:currentColor}.faint{opacity:.45}\n\
    .page{color:#ffffff}text{stroke:#ffffff}.grid{color:#e2e5e9}.ink{color:#24292f}.grey{color:#5c646e}\
    .orange{color:#bc4c00}.green{color:#116329}.blue{color:#0550ae}.purple{color:#7d35b5}\
    .red{color:#b3243c}\n\
    @media(prefers-color-scheme:dark){.page{color:#0d1117}text{stroke:#0d1117}.grid{color:#2b313a}.ink{color:#e6edf3}\
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

fn bar(class: &str, (left, top): (f64, f64), width: f64) -> String {
    format!(
        "<rect class=\"{class}\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{width:.1}\" height=\"16\"/>\n"
    )
}

/// A dot, and words that begin or end so far to the right of it, and below.
fn dot(class: &str, (x, y): (f64, f64), ((right, down), anchor): Beside, words: &str) -> String {
    format!("<circle class=\"{class}\" cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"5\"/>\n")
        + &text(class, (x + right, y + down), anchor, words)
}

type Beside = ((f64, f64), &'static str);

/// A logarithmic scale: the first of the numbers is at the first of the pixels, and the second at the second.
fn log(pixels: (f64, f64), numbers: (f64, f64)) -> impl Fn(f64) -> f64 + Copy {
    move |number| {
        pixels.0 + (pixels.1 - pixels.0) * (number / numbers.0).ln() / (numbers.1 / numbers.0).ln()
    }
}

/// Lines across and up at these numbers, which are separated by blanks, and their names.
fn grid(
    (left, right): (f64, f64),
    (top, bottom): (f64, f64),
    (across, y): (&str, impl Fn(f64) -> f64),
    (up, x): (&str, impl Fn(f64) -> f64),
) -> String {
    let number = |name: &str| name.replace([',', '%'], "").parse().unwrap();
    let across = across.split(' ').map(|name| {
        let y = y(number(name));
        line("grid", &[(left, y), (right, y)]) + &text("grey", (left - 8.0, y + 5.0), "end", name)
    });
    let up = up.split(' ').map(|name| {
        let x = x(number(name));
        line("grid", &[(x, top), (x, bottom)]) + &text("grey", (x, bottom + 20.0), "middle", name)
    });
    across.chain(up).collect()
}

/// The colour of a method, or of words about it.
fn color(method: &str) -> &'static str {
    match method.split([' ', ',']).next().unwrap() {
        "classic" => "orange",
        "exact" => "green",
        "closed" | "Ferrari" => "purple",
        "Newton" => "red",
        "sphere" | "64" => "blue",
        _ => "ink",
    }
}

/// The README's chart: two bars for each size, for the time and for what differs from the average.
pub fn readme() -> String {
    const LEFT: f64 = 148.0;
    const WIDTH: f64 = 288.0;
    let pairs = SIZES.map(|size| ["classic", "exact"].map(|name| find(size, name).unwrap()));
    let longest = pairs.iter().flatten().map(|row| row.time).fold(0.0, f64::max);
    let mut contents = String::new();
    for (n, (size, pair)) in SIZES.into_iter().zip(&pairs).enumerate() {
        for (i, (measured, class)) in pair.iter().zip(["orange", "green"]).enumerate() {
            let &Measured { ref name, time, different, far_off, .. } = measured;
            let down = (60 * n + 23 * i) as f64;
            let time_width = WIDTH * time / longest;
            let [width, far_width] = [different, far_off].map(|share| WIDTH / 50.0 * share);
            for (top, width, number) in [
                (84.0 + down, time_width, format!("{} µs", micros(measured))),
                (262.0 + down, width, format!("{}%", share(different))),
            ] {
                let words = [if i == 0 { size } else { "" }, name];
                contents += &text("bold ink", (12.0, top + 13.0), "start", words[0]);
                contents += &text("ink", (LEFT - 8.0, top + 13.0), "end", words[1]);
                contents += &text("ink", (LEFT + width + 8.0, top + 13.0), "start", &number);
            }
            contents += &bar(class, (LEFT, 84.0 + down), time_width);
            contents += &bar(class, (LEFT, 262.0 + down), far_width);
            let faint = format!("faint {class}");
            contents += &bar(&faint, (LEFT + far_width, 262.0 + down), width - far_width);
        }
    }
    let head = [
        ("title ink", 30.0, "Exact is faster, and closer to the average"),
        ("ink", 68.0, "time per frame"),
        ("ink", 226.0, "cells that differ from the average of 256 rays, in %"),
        ("grey", 246.0, "(faint: by one shade of twelve; full colour: by more)"),
    ];
    chart("Time and accuracy of classic and exact", 386.0, &head, &contents)
}

/// The study's chart: a panel for each size, with the same axes.
pub fn study() -> String {
    const LEFT: f64 = 52.0;
    const RIGHT: f64 = 508.0;
    const TOPS: [f64; 2] = [152.0, 532.0];
    const HEIGHT: f64 = 318.0;
    let times = SIZES.into_iter().flat_map(measured).map(|row| row.time).collect::<Vec<_>>();
    let [least, most] = [f64::min, f64::max].map(|f| times.iter().copied().reduce(f).unwrap());
    let x = log((LEFT, RIGHT), (least / 1.3, most * 1.6));
    let mut contents = String::new();
    let titles = ["80x22, donut.c's own picture", "200x60, a full screen"];
    for (n, (size, top)) in SIZES.into_iter().zip(TOPS).enumerate() {
        let bottom = top + HEIGHT;
        let y = log((bottom, top), (0.25, 70.0));
        let place = |row: &Measured| (x(row.time), y(row.different));
        contents += &text("bold ink", (LEFT, top - 14.0), "start", titles[n]);
        contents += &grid((LEFT, RIGHT), (top, bottom), ("50% 10% 1%", y), ("10 100 1,000", x));
        let floor = find(size, "exact").unwrap().different;
        let words = format!("one ray, solved exactly: {floor:.1}%");
        contents += &line("dashed grey", &[(LEFT, y(floor)), (RIGHT, y(floor))]);
        contents += &match n {
            0 => text("grey", (RIGHT, y(floor) + 18.0), "end", &words),
            _ => text("grey", (LEFT + 6.0, y(floor) - 8.0), "start", &words),
        };
        let exact = ["exact in f32", "exact", "exact with 2 by 2 rays", "exact with 3 by 3 rays"];
        let places = exact.map(|name| place(&find(size, name).unwrap()));
        contents += &line("thick green", &places[1..]); // Without f32.
        let rows = measured(size);
        let spheres = rows.iter().filter(|row| row.name.starts_with("sphere")).map(place);
        contents += &line("thick blue", &spheres.collect::<Vec<_>>());
        // Words far below or above a dot hang on a line: those below the floor the lower the farther left.
        let (left, right) = (((-10.0, 5.0), "end"), ((10.0, 5.0), "start"));
        let (above, hung) = (((-6.0, -12.0), "start"), |down| ((4.0, down), "start"));
        for (name, beside, words) in [
            ("donut.c in C", ((14.0, -12.0), "end"), "donut.c in C (scalar, with putchar)"),
            ("turning by steps", ((6.0, 22.0), "end"), "turning by steps (scalar)"),
            ("classic", [left, right][n], "classic"),
            ("classic with donut.c's steps", above, "classic with donut.c's steps"),
            ("sphere tracing in 8 steps", [above, left][n], "sphere tracing, 8 to 256 steps"),
            ("sphere tracing in 16 steps", right, "16"),
            ("sphere tracing in 32 steps", right, ""),
            ("sphere tracing in 64 steps", right, ""),
            ("sphere tracing in 256 steps", [((-4.0, -11.0), "middle"), right][n], "256"),
            ("Newton from one start", ((-10.0, -26.0), "end"), "Newton"),
            ("Ferrari in f32", left, "Ferrari, f32"),
            ("Ferrari in f64", hung(26.0), "Ferrari, f64"),
            ("closed form", hung(44.0), "closed form"),
            (exact[1], hung(62.0), "exact"),
            (exact[0], hung(80.0), "exact in f32"),
            (exact[2], ((12.0, -12.0), "start"), "2 by 2 rays"),
            (exact[3], ((0.0, 22.0), "middle"), "3 by 3 rays"),
        ] {
            if let Some(row) = find(size, name) {
                let ((x, y), ((right, down), anchor)) = (place(&row), beside);
                if f64::abs(down) > 25.0 {
                    let end = right + if anchor == "end" { 4.0 } else { -4.0 };
                    contents += &line(color(name), &[(x, y), (x + end, y + down)]);
                }
                contents += &dot(color(name), (x, y), beside, words);
            }
        }
    }
    let height = TOPS[1] + HEIGHT + 62.0;
    let axes = "µs per frame; both axes are logarithmic";
    contents += &text("ink", (RIGHT, height - 14.0), "end", axes);
    let head = [
        ("title ink", 30.0, "One ray for each cell, solved exactly, has a floor;"),
        ("title ink", 53.0, "3 by 3 rays go below it"),
        ("ink", 83.0, "cells that differ from the average of 256 rays,"),
        ("ink", 103.0, "in % of the donut's cells"),
    ];
    chart("Time and accuracy of each method, in two sizes", height, &head, &contents)
}

/// Where methods fail: the wrong cells of each, over K2 and over R2.
pub fn stability([_, by_k2, by_r2]: &Failures) -> String {
    let k2_words: [(f64, f64, _); 6] = [
        (3.08, 13.0, "sphere tracing, 16 steps"),
        (48.0, 0.5, "64 steps"),
        (4.2, 40.0, "Ferrari, f32"),
        (220.0, 30.0, "Ferrari, f64"),
        (12_000.0, 2.2, "Newton"),
        (4.6, 0.013, "exact in f32: 1 wrong cell each"),
    ];
    let r2_words = [
        (1.012, 6.6, "sphere tracing, 16 steps"),
        (1.012, 0.2, "64 steps"),
        (4.6, 2.4, "Ferrari, f32"),
        (1.7, 2.4, "Newton"),
    ];
    let head = [
        ("title ink", 30.0, "The textbook's Ferrari fails far away, and sphere"),
        ("title ink", 53.0, "tracing gets worse close up; exact (f64) stays at 0"),
        ("ink", 83.0, "cells that are wrong by the ray through their centre,"),
        ("ink", 103.0, "in % of the donut's cells"),
        ("bold ink", 150.0, "--k2, the viewer's distance (5 in donut.c)"),
        ("bold ink", 550.0, "--r2, the radius of the ring (2 in donut.c)"),
    ];
    // What is subtracted makes K2 the distance to the donut's near side, and R2 the radius of its hole.
    let k2_ticks = "3.011 3.1 5 10 100 1,000 100,000";
    let zero = "exact, closed form, Ferrari in f64 (up to 300): 0";
    let contents = curves(by_k2, (166.0, 3.0, k2_ticks), zero, &k2_words)
        + &curves(
            by_r2,
            (566.0, 1.0, "1.01 1.1 2 10 30"),
            "exact (in f32, too), closed form, Ferrari in f64: 0",
            &r2_words,
        );
    let title = "Wrong cells of each method, over the distance and over the radius of the ring";
    chart(title, 924.0, &head, &contents)
}

/// The curves of one panel: its top, what is subtracted from each number, and the numbers on its axis; what is
/// 0; and other words, with the places where they begin.
fn curves(
    scenes: &Scenes,
    (top, subtracted, ticks): (f64, f64, &str),
    zero: &str,
    words: &[(f64, f64, &str)],
) -> String {
    let (left, right, bottom) = (58.0, 490.0, top + 306.0);
    let number = |i: usize| scenes[i].0.parse::<f64>().unwrap() - subtracted;
    let x = log((left + 4.0, right - 10.0), (number(0), number(scenes.len() - 1)));
    let log_y = log((bottom - 34.0, top), (0.01, 160.0));
    let y = |share| if share == 0.0 { bottom } else { log_y(share) };
    let shares = ("100% 10% 1% 0.1% 0.01% 0", y);
    let mut svg = grid((left, right), (top, bottom), shares, (ticks, |n| x(n - subtracted)));
    for method in &COMPARED {
        let dashed = if *method == "Ferrari in f64" { "dashed " } else { "" };
        let place = |i: usize| (x(number(i)), y(wrong(&scenes[i].1[*method])));
        let mut places: Vec<_> = (0..scenes.len()).map(place).collect();
        if ["Ferrari in f64", "exact in f32"].contains(method) {
            places.retain(|place| place.1 < bottom); // Without its zeros.
        }
        svg += &match *method {
            "exact in f32" => places
                .into_iter()
                .map(|place| dot("green", place, ((0.0, 0.0), "end"), ""))
                .collect(),
            _ => line(&format!("thick {dashed}{}", color(method)), &places),
        };
    }
    for &(number, share, words) in words {
        svg += &text(color(words), (x(number - subtracted), y(share)), "start", words);
    }
    let scale = format!("logarithmic in the number less {subtracted}");
    svg += &text("grey", (right, bottom + 40.0), "end", &scale);
    svg + &text("green", (left + 8.0, bottom - 8.0), "start", zero)
}

/// The quartic of a ray that passes just beside the near part of the tube and hits the far one, and the parabola
/// of each step of its search.
pub fn one_ray() -> String {
    let (left, right, axis_y) = (40.0, 508.0, 380.0);
    // The pose and the cell are those of frame 33 of donut.c.
    let view = View::DONUT_C;
    let torus = Torus { r2: view.r2, axis: axis(1.32, 0.66) };
    let (dx, dy) = direction(&view, 35.5, 13.5);
    let rays = torus.rays(dx.into(), dy, view.k2);
    let quartic = torus.quartic(&rays);
    let [p, q, c] = numbers(&quartic, 0);
    let g = |s| g([p, q, c], s);
    let place = |(s, height)| (left + 78.0 * (s + 3.0), axis_y - 11.0 * height);
    let curve = |from: f64, to: f64, height: &dyn Fn(f64) -> f64| {
        let at = |n: i32| from + (to - from) * f64::from(n) / 120.0;
        (0..=120).map(at).map(|s| place((s, height(s)))).collect::<Vec<_>>()
    };
    let entry = torus.entry(&rays).to_array()[0];
    let places: Vec<_> = places([p, q, c], entry).collect();
    let hit = quartic.first_hits(entry.into()).to_array()[0];

    let (x, y) = (|s| place((s, 0.0)).0, |g| place((0.0, g)).1);
    let heights = (y(22.0), y(-5.4));
    let mut contents = grid((left, right), heights, ("20 10 0", y), ("-3 -2 -1 0 1 2 3", x));
    contents += &line("ink", &[(left, axis_y), (right, axis_y)]);
    contents += &line("thick green", &curve(entry - 0.03, 2.7, &g));
    for (class, s, height, anchor, words) in [
        ("green", -0.1, 16.7, "middle", "G(s)"),
        ("grey", -1.75, -1.9, "middle", "near part: just missed"),
        ("grey", 2.05, -4.6, "middle", "far part"),
        ("blue", -1.07, 0.5, "middle", "parabola from s2"),
        ("orange", 1.47, -1.9, "end", "the hit"),
        ("ink", 3.0, -9.6, "end", "s, along the ray"),
    ] {
        contents += &text(class, place((s, height)), anchor, words);
    }
    for (n, step) in places.windows(2).enumerate() {
        let [s, r] = [step[0], step[1]];
        let (base, height) = (s * s + p, g(s));
        let slope = (4.0 * base * s + 2.0 * q).min(0.0);
        let parabola = |t: f64| height + slope * (t - s) + 2.0 * base * (t - s) * (t - s);
        contents += &line("thick blue", &curve(s, r, &parabola));
        contents += &line("dashed grey", &[place((r, 0.0)), place((r, g(r)))]);
        // The last ones are too near to the hit.
        if n < 5 {
            contents += &dot("blue", place((s, height)), ((8.0, -8.0), "start"), &format!("s{n}"));
        }
    }
    // Seen from behind, the ray's last root is the first one.
    let exit = -Quartic { q: -quartic.q, ..quartic }.first_hits(entry.into()).to_array()[0];
    contents += &dot("orange", place((hit, 0.0)), ((0.0, 0.0), "end"), "");
    contents += &dot("ink", place((exit, 0.0)), ((8.0, -8.0), "start"), "out");
    let head = [
        ("title ink", 30.0, "No parabola goes above G, so no step"),
        ("title ink", 53.0, "passes a place where the ray meets the donut"),
        ("ink", 83.0, "along one ray: G is positive outside the donut,"),
        ("ink", 103.0, "and negative inside"),
    ];
    chart("The quartic of a ray, and the parabolas of its search", 500.0, &head, &contents)
}
