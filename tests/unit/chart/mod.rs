//! How long each method takes to draw the donut, and how many cells it gets wrong; the pictures that the
//! README and the study show; and the figures in their texts. The study is tests/chart/README.md.
//!
//! `cargo test --release chart -- --ignored --nocapture` measures again and writes the files of tests/chart.
//! Then `cargo test` says which figures of the two texts are stale.

mod other_methods;
mod picture;

use self::other_methods::*;
use super::classic::{donut_c, with_steps};
use super::one_ray::trace_one_by_one;
use super::*;

/// A method of this program, or another one to compare it with: its name, and how it draws a pose.
type NamedMethod = (String, Box<dyn FnMut(f64, f64) -> Vec<u8> + Send>);

const TABLE: &str = "tests/chart/speed-and-accuracy.csv";
const STUDY: &str = "tests/chart/README.md";

/// The frames of donut.c's own angle A, as donut.c adds it up, in which its error passes a whole turn, in
/// which it begins to turn too fast, and in which it stops.
const WHOLE_TURN: f64 = 192_750.0;
const FASTER: f64 = 3_345_245.0;
const STOPPED: f64 = FROZEN as f64;

fn own_method(name: &str, mut renderer: Renderer) -> NamedMethod {
    let draw = move |a, b| {
        renderer.render_frame(a, b);
        renderer.framebuffer.clone()
    };
    (name.into(), Box::new(draw))
}

/// A method that differs from exact only in how it finds the hits of eight rays.
fn tracing(
    name: &str,
    view: View,
    first_hits: impl Fn(&Torus, &Rays) -> f64x8 + Send + 'static,
) -> NamedMethod {
    (name.into(), Box::new(move |a, b| trace_eight_by_eight(&view, a, b, &first_hits)))
}

/// A method that follows one ray after another. `hit` finds the s of a ray's first hit.
fn ray_by_ray(
    name: &str,
    view: View,
    hit: impl Fn(&Torus, &Ray) -> f64 + Send + 'static,
) -> NamedMethod {
    (name.into(), Box::new(move |a, b| trace_one_by_one(&view, a, b, &hit)))
}

/// The pictures in which speed and accuracy are measured: donut.c's own, and a full screen. For each, its
/// name, its view, and the number of poses in which wrong cells are counted.
fn sizes() -> [(&'static str, View, usize); 2] {
    [("80x22", View::DONUT_C, 50), ("200x60", fitted(200, 60), 10)]
}

/// The methods to measure in a view.
fn methods(view: View) -> Vec<NamedMethod> {
    let steps = angle_steps(&view);
    let mut methods = vec![
        own_method("classic x1", Renderer::new(view, Method::Classic)),
        own_method("exact", Renderer::new(view, Method::Exact)),
        ray_by_ray("exact one ray at a time", view, |torus, ray| {
            ray.first_hit(ray.entry(torus.r2))
        }),
        tracing("closed form f64", view, closed_form),
        ray_by_ray("closed form one ray at a time", view, |_, ray| closed_form_alone(ray)),
        tracing("Newton", view, newton_once),
        tracing("Ferrari f32", view, move |torus, rays| textbook_f32(torus, view.k2, rays)),
        tracing("Ferrari f64", view, move |torus, rays| textbook_f64(torus, view.k2, rays)),
    ];
    for (name, factor) in [("x4", 4.0), ("x2", 2.0), ("x1/2", 0.5), ("x1/4", 0.25)] {
        let renderer = with_steps(view, steps[0] * factor, steps[1] * factor);
        methods.push(own_method(&format!("classic {name}"), renderer));
    }
    for most_steps in [8, 16, 32, 64, 256] {
        let name = format!("sphere tracing {most_steps}");
        methods.push(tracing(&name, view, sphere_tracing(most_steps)));
    }
    let mut zbuffer = vec![0.0; view.width * view.height];
    let literal = move |a, b| {
        let mut cells = vec![b' '; view.width * view.height];
        donut_c(a as f32, b as f32, &view, steps, &mut zbuffer, &mut cells);
        cells
    };
    methods.push(("donut.c as written".into(), Box::new(literal)));
    if steps != [0.07, 0.02] {
        methods.push(own_method("donut.c's steps", with_steps(view, 0.07, 0.02)));
    }
    methods
}

/// A scene in which the study compares methods: its name, its view, and its poses.
type NamedScene = (&'static str, View, Vec<(f64, f64)>);

fn scenes() -> [NamedScene; 8] {
    let scene = |r2, k2| View::new(160, 44, 2.0, r2, k2);
    let poses = donut_c_poses(10);
    let edge_on = poses.iter().map(|&(_, b)| (TAU / 4.0 + 1e-4, b)).collect();
    [
        ("80x22", View::DONUT_C, donut_c_poses(50)),
        ("160x44", scene(2.0, 5.0), poses.clone()),
        ("320x88", fitted(320, 88), poses.clone()),
        ("edge-on", scene(2.0, 5.0), edge_on),
        ("--r2 9 --k2 25", scene(9.0, 25.0), poses.clone()),
        ("--k2 3.003", scene(2.0, 3.003), poses.clone()),
        ("--k2 50", scene(2.0, 50.0), poses.clone()),
        ("--k2 50000", scene(2.0, 50_000.0), poses),
    ]
}

/// The methods that the study compares in each scene.
fn compared_methods(view: View) -> Vec<NamedMethod> {
    let mut methods = vec![
        own_method("donut.c's steps", with_steps(view, 0.07, 0.02)),
        tracing("Sphere tracing", view, sphere_tracing(64)),
        tracing("Newton", view, newton_once),
        tracing("Ferrari, f32", view, move |torus, rays| textbook_f32(torus, view.k2, rays)),
        tracing("Ferrari, f64", view, move |torus, rays| textbook_f64(torus, view.k2, rays)),
        tracing("Closed form, f64", view, closed_form),
        own_method("Exact", Renderer::new(view, Method::Exact)),
    ];
    let classic = || own_method("Classic", Renderer::new(view, Method::Classic));
    methods.extend((view.k2 == View::DONUT_C.k2).then(classic));
    methods
}

/// The name of each method, and its tally in these poses.
fn count(mut methods: Vec<NamedMethod>, view: &View, poses: &[(f64, f64)]) -> Vec<(String, Tally)> {
    let (view, poses) = (*view, poses.to_vec());
    within_a_minute(move || {
        let mut tallies: Vec<_> = methods.iter().map(|_| Tally::default()).collect();
        for (a, b) in poses {
            let pictures: Vec<_> = methods.iter_mut().map(|(_, draw)| draw(a, b)).collect();
            add_pictures(&mut tallies, &view, (a, b), &pictures);
        }
        methods.into_iter().map(|(name, _)| name).zip(tallies).collect()
    })
}

/// For each size and method, its name, and the last columns of its row in TABLE.
fn wrong_cells() -> Vec<(&'static str, String, String)> {
    let columns = |tally: Tally| [tally.surface, tally.shades, tally.extra, tally.holes];
    let rows = sizes().into_iter().flat_map(|(size, view, poses)| {
        let tallies = count(methods(view), &view, &donut_c_poses(poses));
        tallies.into_iter().map(move |(name, tally)| (size, name, columns(tally)))
    });
    rows.map(|(size, name, columns)| (size, name, columns.map(|n| n.to_string()).join(",")))
        .collect()
}

/// The median of the microseconds that each method takes for a frame. The methods take turns until the time
/// is up, so that whatever else the computer does slows all of them down. In its turn, a method draws five
/// runs of 40 consecutive frames, as it would in the program.
fn micros(mut methods: Vec<NamedMethod>, seconds: u64) -> Vec<f64> {
    let mut samples = vec![Vec::new(); methods.len()];
    let start = Instant::now();
    while start.elapsed().as_secs() < seconds {
        for ((_, draw), samples) in methods.iter_mut().zip(&mut samples) {
            for (a, b) in donut_c_poses(5) {
                for frame in (0..40).map(f64::from) {
                    let start = Instant::now();
                    draw(a + 0.04 * frame, b + 0.02 * frame);
                    samples.push(start.elapsed().as_secs_f64() * 1e6);
                }
            }
        }
    }
    samples.iter_mut().for_each(|samples| samples.sort_by(f64::total_cmp));
    samples.iter().map(|samples| samples[samples.len() / 2]).collect()
}

/// The largest error of donut.c's angle A up to frame n, in radians: the difference from `0.04 n`. A is a
/// sum, and each addition is rounded. The frames n are the four named here, and others from 1,000 on, each a
/// tenth more than the one before.
fn drift() -> Vec<(f64, f64)> {
    let (mut angle, mut largest, mut next) = (0.0, 0.0, 1000);
    let mut errors = Vec::new();
    for n in 1..=30_000_000 {
        let frame = f64::from(n);
        let next_angle = add_step(angle, 0.04);
        // From 2^17 on, A is a multiple of 1/64, so instead of 0.04, each step adds 3/64.
        assert_eq!(frame == FASTER, angle < 131_072.0 && next_angle >= 131_072.0);
        angle = next_angle;
        largest = f64::max(largest, (f64::from(angle) - 0.04 * frame).abs());
        if n == next || [WHOLE_TURN, FASTER, STOPPED, 30e6].contains(&frame) {
            errors.push((frame, largest));
        }
        if n == next {
            next += next / 10;
        }
    }
    errors
}

/// The figures of a method in TABLE, in the order of its columns.
fn measured(size: &str, method: &str) -> Vec<f64> {
    let (table, name) = (read(TABLE), format!("{size},{method},"));
    let mut figures = table.lines().filter_map(|line| line.strip_prefix(&name));
    let figures = figures.next().unwrap_or_else(|| panic!("no row {name}"));
    figures.split(',').map(|figure| figure.parse().unwrap()).collect()
}

/// The time that a method takes for a frame, in microseconds, and its wrong cells, in per cent.
fn time_and_share(size: &str, method: &str) -> (f64, f64) {
    let figures = measured(size, method);
    (figures[0], 100.0 * figures[2..].iter().sum::<f64>() / figures[1])
}

/// The names and contents of the files that follow from the stored table and from the program, without
/// measuring anything.
fn derived_files() -> [(&'static str, String); 6] {
    let errors = drift();
    let line = |(frame, error): &(f64, f64)| format!("{frame},{error:.6}\n");
    let lines = errors.iter().map(line).collect::<String>();
    [
        ("tests/chart/speed-and-accuracy.svg", picture::speed_and_accuracy()),
        ("tests/chart/drift.csv", format!("frame,largest error of A up to it in radians\n{lines}")),
        ("tests/chart/drift.svg", picture::drift(&errors)),
        ("tests/chart/failures.svg", picture::failures()),
        ("tests/donut.svg", picture::moving()),
        ("tests/methods.svg", picture::two_methods()),
    ]
}

#[test]
#[ignore = "measures for a minute"]
fn measure_and_write_the_table_and_the_charts() {
    let columns = "us per frame (median),cells of the donut,wrong shades,extra outline,holes";
    let mut table = format!("size,method,{columns}\n");
    let times = sizes().into_iter().flat_map(|(_, view, _)| micros(methods(view), 30));
    for ((size, name, columns), micros) in wrong_cells().iter().zip(times) {
        table += &format!("{size},{name},{micros:.1},{columns}\n");
    }
    println!("{TABLE}\n{table}");
    fs::write(path(TABLE), table).unwrap();
    for (name, contents) in derived_files() {
        fs::write(path(name), contents).unwrap();
    }
}

/// Rounding decides which cells an unstable method gets wrong, and not all systems round sines and cosines
/// alike. So what is stored holds on one of them, and this test and the next two run only there.
#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn the_pictures_and_the_table_of_the_drift_are_up_to_date() {
    for (name, contents) in derived_files() {
        assert!(contents.len() < 400_000, "{name} is too much for a page to load");
        assert_current(name, &contents);
    }
}

#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn the_table_has_the_wrong_cells() {
    for (size, name, columns) in wrong_cells() {
        let counts = measured(size, &name).into_iter().skip(1).map(|count| count.to_string());
        assert_eq!(counts.collect::<Vec<_>>().join(","), columns, "{size} {name}");
    }
}

// ---- The figures of the texts --------------------------------------------------------------------

/// Only the numbers are checked. The names of the rows and of the columns tell which number is which.
#[test]
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
fn the_studys_table_has_the_wrong_cells_where_methods_fail() {
    let study = read(STUDY).replace('`', "");
    let cells = |line| str::trim_matches(line, '|').split('|').map(str::trim).collect();
    let rows: Vec<Vec<_>> = study.lines().map(cells).collect();
    let row = |name: &str| {
        let row = rows.iter().find(|row| row[0] == name);
        row.unwrap_or_else(|| panic!("the study has no row {name:?}"))
    };
    let columns = row("method");
    let mut stale = Vec::new();
    for (scene, view, poses) in scenes() {
        let column = columns.iter().position(|&name| name == scene);
        let column = column.unwrap_or_else(|| panic!("the study has no column {scene:?}"));
        let mut check = |name: &str, current: String| {
            let figure = row(name)[column];
            if figure != current {
                stale.push(format!("{name} ({scene}): {current}, not {figure}"));
            }
        };
        for (name, tally) in count(compared_methods(view), &view, &poses) {
            let percentage = 100.0 * tally.wrong() as f64 / tally.surface as f64;
            let decimals = usize::from(percentage > 0.0 && percentage < 10.0);
            check(&name, format!("{percentage:.decimals$}"));
            if name == "Exact" {
                check("Donut's cells", tally.surface.to_string());
                check("Ties", tally.ties.to_string());
            }
        }
    }
    assert!(stale.is_empty(), "the study's table should have\n{}", stale.join("\n"));
}

/// The figures in the two texts. In their words, `#` stands for a figure, which must be this value, rounded
/// to as many decimals as the text gives it. After "about" it may be a tenth off, because times differ.
#[test]
fn the_figures_in_the_texts_are_those_measured() {
    let time = |size, method| measured(size, method)[0];
    let ratio = |size, slow, fast| time(size, slow) / time(size, fast);
    let faster = |size, method| ratio(size, "donut.c as written", method);
    // The share of a core, in per cent, at 30 frames a second.
    let load = |size, method| 100.0 * 30.0 * time(size, method) / 1e6;
    let classic = measured("80x22", "classic x1");
    let in_classic = |cells: f64| 100.0 * cells / classic[1];
    let (shades, rim) = (in_classic(classic[2] + classic[4]), in_classic(classic[3]));
    let share = |method| time_and_share("80x22", method).1;
    let (errors, hours) = (drift(), |frame: f64| frame / 30.0 / 3600.0);
    let whole_turn = errors.iter().find(|error| error.1 > TAU).unwrap().0;
    // A is about 0.04 times the frame, so it has this value a while after frame FASTER.
    let angle = (0.05 * FASTER) as f32;
    let excess = f64::from(add_step(angle, 0.04) - angle) / 0.04 - 1.0;
    let mut stale = Vec::new();
    for (name, words, value) in [
        ("README.md", "about # of its cells are wrong at 80x22 for every 100", share("classic x1")),
        ("README.md", "Exact is about # times as fast as the", faster("80x22", "exact")),
        ("README.md", "and about # times at 200x60", faster("200x60", "exact")),
        ("README.md", "translated to Rust | #% |", load("80x22", "donut.c as written")),
        ("README.md", "% | #% | | classic |", load("200x60", "donut.c as written")),
        ("README.md", "classic | #% |", load("80x22", "classic x1")),
        ("README.md", "% | #% | | exact |", load("200x60", "classic x1")),
        ("README.md", "exact | #% |", load("80x22", "exact")),
        ("README.md", "% | #% | Exact", load("200x60", "exact")),
        ("README.md", "stands still after nearly # days", hours(STOPPED) / 24.0),
        (STUDY, "picture, exact is about # times as fast", faster("80x22", "exact")),
        (STUDY, "sines and cosines, is about # times", faster("80x22", "classic x1")),
        (STUDY, "200x60, it is about # and", faster("200x60", "exact")),
        (STUDY, "and about # times; there", faster("200x60", "classic x1")),
        (
            STUDY,
            "takes about # times as long as exact",
            ratio("80x22", "sphere tracing 64", "exact"),
        ),
        (STUDY, "and #% of its cells are wrong", share("sphere tracing 64")),
        (
            STUDY,
            "closed form takes about # times as long",
            ratio("80x22", "closed form f64", "exact"),
        ),
        (STUDY, "at its centre: #% of the donut's cells", shades),
        (STUDY, "all round, # for every 100 of the donut's own", rim),
        (STUDY, "So donut.c's error is #%.", share("classic x1")),
        (STUDY, "half as long, it is #%;", share("classic x1/2")),
        (STUDY, "a quarter as long, #%. With", share("classic x1/4")),
        (STUDY, "twice as long, it is #%.", share("classic x2")),
        (STUDY, "errors of A add up to a whole turn in # hours", hours(whole_turn)),
        (STUDY, "After # hours the floats", hours(FASTER)),
        (STUDY, "the donut begins to turn #% too fast", 100.0 * excess),
        (STUDY, "and after nearly # days it stands still", hours(STOPPED) / 24.0),
    ] {
        let text = read(name).split_whitespace().collect::<Vec<_>>().join(" ");
        let (before, after) = words.split_once('#').unwrap();
        let rests = text.match_indices(before).map(|(at, _)| &text[at + before.len()..]);
        let between = rests.filter_map(|rest| rest.split_once(after));
        let mut found = between.map(|(text, _)| text).filter(|text| text.parse::<f64>().is_ok());
        let figure = found.next().unwrap_or_else(|| panic!("{name} does not say {words:?}"));
        let decimals = figure.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let current = format!("{value:.decimals$}");
        let off = (figure.parse::<f64>().unwrap() / value - 1.0).abs();
        if figure != current && !(before.ends_with("about ") && off < 0.1) {
            stale.push(format!("{name}: {words}: {current}, not {figure}"));
        }
    }
    assert!(stale.is_empty(), "# should be\n{}", stale.join("\n"));
}
