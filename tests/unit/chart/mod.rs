//! How long each method takes to draw the donut, and how many cells it gets wrong. The table and the
//! charts of tests/chart are made from that. The README's table counts the wrong cells of other scenes.
//!
//! To measure again and write the files of tests/chart, run
//! `cargo test --release chart -- --ignored --nocapture`. Then `cargo test` says which figures of the
//! README are stale.

mod other_methods;
mod plot;

use std::fmt::Write as _;
use std::fs;

use self::other_methods::*;
use super::classic::with_steps;
use super::stored::{assert_current, path, read};
use super::*;

/// Draws the donut turned by A and B into a blank framebuffer.
type Draw = Box<dyn FnMut(f64, f64, &mut [u8])>;

/// A method of this program, or another one to compare it with.
struct NamedMethod {
    name: String,
    draw: Draw,
}

/// A method's cells in pictures, compared with the oracle.
#[derive(Default)]
struct Score {
    /// The cells that do not show what the oracle sees at their centre.
    differing: Tally,
    /// Those of the wrong shades that are only one level off.
    one_shade: usize,
    /// The cells in which the oracle sees the donut.
    surface: usize,
}

impl Score {
    /// The wrong cells, in per cent of the donut's cells.
    fn percentage(&self) -> f64 {
        100.0 * self.differing.wrong() as f64 / self.surface as f64
    }

    /// The last columns of the table.
    fn columns(&self) -> String {
        let (wrong, percentage) = (self.differing.wrong(), self.percentage());
        let &Score { differing: Tally { shades, extra, holes, .. }, one_shade, surface } = self;
        let more_shades = shades - one_shade;
        format!("{wrong},{surface},{percentage:.4},{one_shade},{more_shades},{extra},{holes}")
    }
}

/// In how many of donut.c's own poses the cells are compared with the oracle.
const POSES: usize = 50;
const TITLES: &str = "method,size,us per frame (median),us (10th percentile),us (90th percentile),\
    wrong cells,cells of the donut,% wrong,one shade off,more shades off,extra outline,holes\n";

fn method(name: impl Into<String>, draw: impl FnMut(f64, f64, &mut [u8]) + 'static) -> NamedMethod {
    NamedMethod { name: name.into(), draw: Box::new(draw) }
}

fn own_method(name: impl Into<String>, mut renderer: Renderer) -> NamedMethod {
    method(name, move |a, b, cells| {
        renderer.render_frame(a, b);
        cells.copy_from_slice(&renderer.framebuffer);
    })
}

/// A method that differs from exact only in how it finds the hits of N rays.
fn tracing<const N: usize>(
    name: impl Into<String>,
    view: View,
    first_hits: impl Fn(&Torus, &[Ray; N]) -> [f64; N] + 'static,
) -> NamedMethod {
    let mut renderer = Renderer::new(view, Method::Exact);
    method(name, move |a, b, cells| {
        renderer.framebuffer.fill(b' ');
        renderer.trace(a, b, &first_hits);
        cells.copy_from_slice(&renderer.framebuffer);
    })
}

fn sphere_tracing(name: impl Into<String>, view: View, most_steps: usize) -> NamedMethod {
    tracing(name, view, move |torus, rays| sphere_trace(torus.r2, rays, most_steps))
}

/// A method that follows one ray after another. `first_hit` finds the s of a ray's first hit.
fn ray_by_ray(
    name: &str,
    view: View,
    first_hit: impl Fn(&Torus, &Ray) -> f64 + 'static,
) -> NamedMethod {
    tracing(name, view, move |torus, [ray]| [first_hit(torus, ray)])
}

fn closed_form(name: &str, view: View) -> NamedMethod {
    ray_by_ray(name, view, |torus, ray| first_root(plain_quartic(torus, ray)))
}

/// The methods to measure, in donut.c's view enlarged by this scale. In the largest views these are only
/// the program's own two, because the others would take too long.
fn methods(scale: usize) -> Vec<NamedMethod> {
    let view = enlarged(scale);
    let mut methods = vec![
        own_method("classic x1", renderer(view, Method::Classic)),
        own_method("exact", renderer(view, Method::Exact)),
    ];
    if scale > 4 {
        return methods;
    }
    let steps =
        |name: &str, factor: f64| own_method(name, with_steps(view, 0.07 * factor, 0.02 * factor));
    // In an enlarged view, classic's own steps are shorter by this factor, so that the samples are
    // still about a cell apart.
    let own = 1.0 / scale as f64;
    methods.extend([
        tracing("exact one ray at a time", view, Torus::first_hits::<1>),
        steps("classic x4", 4.0 * own),
        steps("classic x2", 2.0 * own),
        steps("classic x1/2", 0.5 * own),
        steps("classic x1/4", 0.25 * own),
        steps("fixed 0.07/0.02", 1.0),
        closed_form("closed form f64", view),
    ]);
    methods.extend([8, 16, 32, 64, 256].map(|most_steps| {
        sphere_tracing(format!("sphere tracing {most_steps}"), view, most_steps)
    }));
    let mut zbuffer = vec![0.0; view.width * view.height];
    methods.push(method("donut.c as written", move |a, b, cells| {
        donut_c(a as f32, b as f32, &view, &mut zbuffer, cells);
    }));
    methods
}

/// The score of each method in these poses.
fn scores(methods: &mut [NamedMethod], view: &View, poses: &[(f64, f64)]) -> Vec<Score> {
    let mut scores: Vec<_> = methods.iter().map(|_| Score::default()).collect();
    for &(a, b) in poses {
        let oracle = oracle_of(view, a, b);
        let mut pictures = vec![vec![b' '; view.width * view.height]; methods.len()];
        for (method, picture) in methods.iter_mut().zip(&mut pictures) {
            (method.draw)(a, b, picture);
        }
        for (column, row) in cells(view) {
            let (dx, dy) = cell_direction(view, (column, row));
            let seen = oracle.look(dx, dy).map(level_of);
            for (score, picture) in scores.iter_mut().zip(&pictures) {
                score.surface += usize::from(seen.is_some());
                let drawn = level(picture[row * view.width + column]);
                if drawn != seen {
                    let verdict = oracle.judge(dx, dy, drawn);
                    score.differing.count(verdict);
                    let is_shade = verdict == Verdict::Shade;
                    let is_one_off = is_shade && drawn.unwrap().abs_diff(seen.unwrap()) == 1;
                    score.one_shade += usize::from(is_one_off);
                }
            }
        }
    }
    scores
}

/// The microseconds that each method takes for a frame: the median and two percentiles, in the
/// order of the table's columns.
///
/// The methods take turns until the time is up, so that whatever else the computer does slows all of
/// them down and not just one. In its turn, a method draws five runs of 40 consecutive frames, as it
/// would in the program.
fn micros(methods: &mut [NamedMethod], view: &View, seconds: u64) -> Vec<[f64; 3]> {
    let mut cells = vec![b' '; view.width * view.height];
    let mut samples = vec![Vec::new(); methods.len()];
    let start = Instant::now();
    loop {
        for (method, samples) in methods.iter_mut().zip(&mut samples) {
            for (a, b) in donut_c_poses(5) {
                for frame in 0..40 {
                    let frame = f64::from(frame);
                    let start = Instant::now();
                    cells.fill(b' ');
                    (method.draw)(a + 0.04 * frame, b + 0.02 * frame, &mut cells);
                    samples.push(start.elapsed().as_secs_f64() * 1e6);
                }
            }
        }
        let elapsed = start.elapsed().as_secs();
        let View { width, height, .. } = view;
        eprint!("\r{width}x{height}: timing, {elapsed:2} of {seconds} s; judging comes next ");
        if elapsed >= seconds {
            break;
        }
    }
    eprintln!();
    let percentiles = |mut samples: Vec<f64>| {
        samples.sort_by(f64::total_cmp);
        [5, 1, 9].map(|tenths| samples[samples.len() * tenths / 10])
    };
    samples.into_iter().map(percentiles).collect()
}

/// The lines of the table for donut.c's view enlarged by this scale. The methods are timed for so many
/// seconds.
fn measure(scale: usize, seconds: u64) -> String {
    let (view, mut methods) = (enlarged(scale), methods(scale));
    let micros = micros(&mut methods, &view, seconds);
    let scores = scores(&mut methods, &view, &donut_c_poses(POSES));
    let mut lines = String::new();
    for ((method, [median, low, high]), score) in methods.iter().zip(micros).zip(scores) {
        let (name, size) = (&method.name, format!("{}x{}", view.width, view.height));
        let accuracy = score.columns();
        writeln!(lines, "{name},{size},{median:.1},{low:.1},{high:.1},{accuracy}").unwrap();
    }
    lines
}

/// The largest error of donut.c's angle A up to frame n, in radians, for several frames n. The
/// error is the difference from `0.04 n`: A is a sum, and each addition is rounded.
///
/// The frames go from 1,000 to 30 million, each a tenth more than the one before. Three others are among
/// them: where the error passes a whole turn, where A begins to turn too fast, and where A stops.
fn drift() -> Vec<(u32, f64)> {
    const LAST: u32 = 30_000_000;
    let frames = std::iter::successors(Some(1000), |n| Some(n + n / 10));
    let mut frames: Vec<_> = frames.take_while(|&n| n < LAST).collect();
    frames.extend([192_750, 3_345_245, 22_918_663, LAST]);
    frames.sort_unstable();
    let (mut frame, mut angle, mut largest) = (0, 0.0, 0.0);
    let mut error_at = |n| {
        while frame < n {
            (frame, angle) = (frame + 1, add_step(angle, 0.04));
            largest = f64::max(largest, (f64::from(angle) - 0.04 * f64::from(frame)).abs());
        }
        (n, largest)
    };
    frames.into_iter().map(&mut error_at).collect()
}

const TABLE: &str = "tests/chart/speed-and-accuracy.csv";

/// The names and contents of the files that follow from the stored table and from donut.c's arithmetic,
/// without measuring anything.
fn derived_files() -> [(&'static str, String); 3] {
    let table = read(TABLE);
    let column = |line: &str, n| line.split(',').nth(n).unwrap().parse::<f64>().unwrap();
    let dots = table.lines().filter_map(|line| {
        let (method, _) = line.split_once(",80x22,")?;
        Some((method, (column(line, 2), column(line, 7))))
    });
    let errors = drift();
    let mut drift = String::from("frame,largest error of A up to it in radians\n");
    for (frame, error) in &errors {
        writeln!(drift, "{frame},{error:.6}").unwrap();
    }
    [
        (
            "tests/chart/speed-and-accuracy.svg",
            plot::speed_and_accuracy(&dots.collect::<Vec<_>>()).unwrap(),
        ),
        ("tests/chart/drift.csv", drift),
        ("tests/chart/drift.svg", plot::drift(&errors).unwrap()),
    ]
}

#[test]
#[ignore = "measures for two minutes"]
fn measure_and_write_the_table_and_the_charts() {
    let mut table = String::from(TITLES);
    // By how much donut.c's view is enlarged, and for how many seconds its frames are timed.
    for (scale, seconds) in [(1, 15), (2, 20), (4, 30), (8, 5), (16, 10)] {
        table.push_str(&measure(scale, seconds));
    }
    println!("{TABLE}\n{table}");
    fs::write(path(TABLE), table).unwrap();
    for (name, contents) in derived_files() {
        fs::write(path(name), contents).unwrap();
    }
}

#[test]
fn the_charts_and_the_table_of_the_drift_are_up_to_date() {
    for (name, contents) in derived_files() {
        assert_current(name, &contents);
    }
}

/// The rows of larger pictures are not counted again, which would take minutes.
#[test]
fn the_table_has_the_wrong_cells_at_80x22() {
    let (table, mut methods) = (read(TABLE), methods(1));
    let scores = scores(&mut methods, &View::DONUT_C, &donut_c_poses(POSES));
    for (method, score) in methods.iter().zip(scores) {
        let (start, end) = (format!("{},80x22,", method.name), score.columns());
        assert!(
            table.lines().any(|line| line.starts_with(&start) && line.ends_with(&end)),
            "no line {start}...,{end} in\n{table}"
        );
    }
}

/// The README's words are its own; only the numbers of its table are checked. The names of the rows and
/// of the columns tell which number is which.
#[test]
fn the_readmes_table_has_the_wrong_cells_where_methods_fail() {
    let readme = read("README.md");
    let row = |name: &str| -> Vec<&str> {
        let mut rows =
            readme.lines().map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
        let row = rows.find(|row| row.get(1) == Some(&name));
        row.unwrap_or_else(|| panic!("the README has no row {name:?}"))
    };
    let scene = |r2, k2| View::new(160, 44, 2.0, r2, k2);
    let poses = donut_c_poses(10);
    let edge_on: Vec<_> = poses.iter().map(|&(_, b)| (TAU / 4.0 + 1e-4, b)).collect();
    let mut stale = Vec::new();
    for (scene, view, poses) in [
        ("160x44", scene(2.0, 5.0), &poses),
        ("320x88", fitted(320, 88), &poses),
        ("edge-on", scene(2.0, 5.0), &edge_on),
        ("`--r2 9 --k2 25`", scene(9.0, 25.0), &poses),
        ("`--k2 3.003`", scene(2.0, 3.003), &poses),
        ("`--k2 50`", scene(2.0, 50.0), &poses),
        ("`--k2 50000`", scene(2.0, 50_000.0), &poses),
    ] {
        let k2 = view.k2;
        let mut methods = [
            own_method("donut.c's steps", with_steps(view, 0.07, 0.02)),
            sphere_tracing("Sphere tracing", view, 64),
            ray_by_ray("Newton", view, newton_once),
            ray_by_ray("Ferrari, f32", view, move |torus, ray| textbook_f32(torus, k2, ray)),
            ray_by_ray("Ferrari, f64", view, move |torus, ray| textbook_f64(torus, k2, ray)),
            closed_form("Closed form, f64", view),
            own_method("Exact", renderer(view, Method::Exact)),
        ];
        let column = row("method").iter().position(|&name| name == scene);
        let column = column.unwrap_or_else(|| panic!("the README has no column {scene:?}"));
        let scores = scores(&mut methods, &view, poses);
        for (name, score) in methods.iter().map(|method| &method.name).zip(scores) {
            let (figure, percentage) = (row(name)[column], score.percentage());
            let decimals = usize::from(percentage > 0.0 && percentage < 10.0);
            let current = format!("{percentage:.decimals$}");
            if figure != current {
                stale.push(format!("{name} ({scene}): {current}, not {figure}"));
            }
        }
    }
    assert!(stale.is_empty(), "the README's table should have\n{}", stale.join("\n"));
}

/// `donut_c` is a literal translation of donut.c's loop, with donut.c's own conditions for each
/// sample. The program's classic leaves these conditions out, and must still draw the same picture,
/// even where the outline passes the edges of the picture, and where the back shows through gaps
/// between the samples.
#[test]
fn classic_draws_the_same_as_a_literal_translation_of_donut_c() {
    let eighths = (0..64).map(|n| (f64::from(n % 8) * TAU / 8.0, f64::from(n / 8) * TAU / 8.0));
    let poses: Vec<_> = donut_c_poses(12).into_iter().chain(eighths).collect();
    // At these sizes classic has donut.c's own steps of theta and phi.
    for (width, height) in [(80, 22), (40, 12), (33, 17), (60, 19), (61, 9), (3, 2)] {
        let view = fitted(width, height);
        let mut renderer = Renderer::new(view, Method::Classic);
        let (mut zbuffer, mut cells) = (vec![0.0; width * height], vec![b' '; width * height]);
        for &(a, b) in &poses {
            cells.fill(b' ');
            donut_c(a as f32, b as f32, &view, &mut zbuffer, &mut cells);
            renderer.render_frame(a, b);
            assert!(renderer.framebuffer == cells, "A {a}, B {b}, {width}x{height}");
        }
    }
}
