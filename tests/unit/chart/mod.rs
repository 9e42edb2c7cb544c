//! How long each method takes to draw the donut, and how many cells it gets wrong. From that follow
//! the tables and the charts of tests/chart, and the table in the README.
//!
//! To measure again and write all of these files, run
//! `cargo test --release chart -- --ignored --nocapture`.

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

/// How many cells do not show what the oracle sees at their centre, by kind of error.
#[derive(Clone, Copy, Default)]
struct Wrong {
    one_shade: usize,
    more_shades: usize,
    /// The cell shows the donut, but the oracle sees none.
    extra: usize,
    /// The cell is blank, but the oracle sees the donut.
    holes: usize,
}

impl Wrong {
    fn count(&mut self, verdict: Verdict, drawn: Option<usize>, seen: Option<usize>) {
        match verdict {
            Verdict::Right | Verdict::Tie => {}
            Verdict::Hole => self.holes += 1,
            Verdict::Extra => self.extra += 1,
            Verdict::Shade if drawn.unwrap().abs_diff(seen.unwrap()) == 1 => self.one_shade += 1,
            Verdict::Shade => self.more_shades += 1,
        }
    }

    fn sum(&self) -> usize {
        self.one_shade + self.more_shades + self.extra + self.holes
    }

    /// The wrong cells, in per cent of `surface`: the number of cells in which the oracle sees the
    /// donut.
    fn share(&self, surface: usize) -> f64 {
        100.0 * self.sum() as f64 / surface as f64
    }

    /// The last columns of the table.
    fn columns(&self, surface: usize) -> String {
        let &Wrong { one_shade, more_shades, extra, holes } = self;
        let (sum, share) = (self.sum(), self.share(surface));
        format!("{sum},{surface},{share:.4},{one_shade},{more_shades},{extra},{holes}")
    }
}

/// In how many of donut.c's own poses the cells are compared with the oracle.
const POSES: usize = 50;
const TITLES: &str = "method,size,us per frame (median),us (10th percentile),us (90th percentile),\
    wrong cells,cells of the donut,% wrong,one shade off,more shades off,extra outline,holes\n";

fn named(name: impl Into<String>, draw: impl FnMut(f64, f64, &mut [u8]) + 'static) -> NamedMethod {
    NamedMethod { name: name.into(), draw: Box::new(draw) }
}

/// A method of the program itself.
fn program(name: impl Into<String>, mut renderer: Renderer) -> NamedMethod {
    named(name, move |a, b, cells| {
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
    let mut renderer = Renderer::new(view, Method::Exact, RAMP);
    named(name, move |a, b, cells| {
        renderer.framebuffer.fill(b' ');
        renderer.trace(a, b, &first_hits);
        cells.copy_from_slice(&renderer.framebuffer);
    })
}

fn sphere_tracing(view: View, most_steps: usize) -> NamedMethod {
    tracing(format!("sphere tracing {most_steps}"), view, move |torus, rays| {
        sphere_trace(torus.r2, rays, most_steps)
    })
}

/// A method that follows one ray after another. `first_hit` finds the s of a ray's first hit.
fn ray_by_ray(
    name: &str,
    view: View,
    first_hit: impl Fn(&Torus, &Ray) -> f64 + 'static,
) -> NamedMethod {
    tracing(name, view, move |torus, [ray]| [first_hit(torus, ray)])
}

fn closed_form(
    name: &str,
    view: View,
    first_root: impl Fn([f64; 3]) -> f64 + 'static,
) -> NamedMethod {
    ray_by_ray(name, view, move |torus, ray| first_root(plain_quartic(torus, ray)))
}

/// The program's own two methods, in donut.c's view enlarged by this scale.
fn program_methods(scale: usize) -> Vec<NamedMethod> {
    [("classic x1", Method::Classic), ("exact", Method::Exact)]
        .map(|(name, method)| program(name, renderer(enlarged(scale), method)))
        .into()
}

/// The methods to compare the program's own with, in the same view.
fn methods_to_compare(scale: usize) -> Vec<NamedMethod> {
    let view = enlarged(scale);
    let steps =
        |name: &str, factor: f64| program(name, with_steps(view, 0.07 * factor, 0.02 * factor));
    // In an enlarged view, classic's own steps are shorter by this factor, so that the samples are
    // still about a cell apart.
    let own = 1.0 / scale as f64;
    let mut methods = vec![
        steps("classic x4", 4.0 * own),
        steps("classic x2", 2.0 * own),
        steps("classic x1/2", 0.5 * own),
        steps("classic x1/4", 0.25 * own),
        steps("fixed 0.07/0.02", 1.0),
        // In f32, the closed form needs a step of Newton's method to get all its digits right.
        closed_form("closed form f32", view, |g| first_root_f32(g, 1)),
        closed_form("closed form f64", view, |g| first_root_f64(g, 0)),
    ];
    methods.extend([8, 16, 32, 64, 256].map(|most_steps| sphere_tracing(view, most_steps)));
    let mut zbuffer = vec![0.0; view.width * view.height];
    methods.push(named("donut.c as written", move |a, b, cells| {
        donut_c(a as f32, b as f32, &view, &mut zbuffer, cells);
    }));
    methods
}

/// The wrong cells of each method in these poses, and the number of cells in which the oracle sees
/// the donut.
fn wrong_cells(
    methods: &mut [NamedMethod],
    view: &View,
    poses: &[(f64, f64)],
) -> (Vec<Wrong>, usize) {
    let (mut wrong, mut surface) = (vec![Wrong::default(); methods.len()], 0);
    for &(a, b) in poses {
        let oracle = oracle_of(view, a, b);
        let rays = (1..view.height).flat_map(|row| (1..view.width).map(move |x| (row, x)));
        let truth = rays.map(|(row, column)| {
            let (dx, dy) = direction(view, column as f64 + 0.5, row as f64 + 0.5);
            let seen = oracle.look(dx, dy).map(|light| light.max(0.0) as usize);
            (row * view.width + column, (dx, dy), seen)
        });
        let truth: Vec<_> = truth.collect();
        surface += truth.iter().filter(|(.., seen)| seen.is_some()).count();
        for (method, wrong) in methods.iter_mut().zip(&mut wrong) {
            let mut cells = vec![b' '; view.width * view.height];
            (method.draw)(a, b, &mut cells);
            for &(cell, (dx, dy), seen) in &truth {
                let drawn = level(cells[cell]);
                if drawn != seen {
                    wrong.count(oracle.judge(dx, dy, drawn), drawn, seen);
                }
            }
        }
    }
    (wrong, surface)
}

/// The microseconds that each method takes for a frame: the median and two percentiles, in the
/// order of the table's columns.
///
/// All methods are timed in turn, round after round, until the time is up. So whatever else the computer
/// does slows all of them down, and not just one. In each round, each method draws five runs of 40
/// consecutive frames, as it would in the program.
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

/// The lines of the table for these methods.
fn measure(mut methods: Vec<NamedMethod>, view: &View, seconds: u64) -> String {
    let micros = micros(&mut methods, view, seconds);
    let (wrong, surface) = wrong_cells(&mut methods, view, &donut_c_poses(POSES));
    let mut lines = String::new();
    for ((method, [median, low, high]), wrong) in methods.iter().zip(micros).zip(wrong) {
        let (name, size) = (&method.name, format!("{}x{}", view.width, view.height));
        let accuracy = wrong.columns(surface);
        writeln!(lines, "{name},{size},{median:.1},{low:.1},{high:.1},{accuracy}").unwrap();
    }
    lines
}

/// The README's table of where methods fail: how each method works, and its wrong cells in each scene.
fn failures() -> String {
    let scene = |r2, k2| View::new(160, 44, 2.0, r2, k2);
    let poses = donut_c_poses(10);
    let edge_on: Vec<_> = poses.iter().map(|&(_, b)| (TAU / 4.0 + 1e-4, b)).collect();
    let scenes = [
        ("160x44", scene(2.0, 5.0), &poses),
        ("320x88", fitted(320, 88), &poses),
        ("edge-on", scene(2.0, 5.0), &edge_on),
        ("`--r2 9 --k2 25`", scene(9.0, 25.0), &poses),
        ("`--k2 3.003`", scene(2.0, 3.003), &poses),
        ("`--k2 50`", scene(2.0, 50.0), &poses),
        ("`--k2 50000`", scene(2.0, 50_000.0), &poses),
    ];
    let mut rows = [
        "**Classic, with donut.c's steps**: plot a point every 0.07 radians round the tube and every 0.02 \
         round the ring. The nearest point in a cell is seldom the one at its centre, and a larger picture \
         has gaps (`--method classic` takes shorter steps there)",
        "**Sphere tracing**: walk along the ray, in steps as long as the distance to the surface. A ray \
         that creeps past an outline has not arrived after 64 steps",
        "**Newton, one start**: solve the ray's equation of degree four step by step, from a start near \
         the donut. A step may jump past the first solution",
        "**Ferrari f32**: solve this equation by Ferrari's formula. Far away, its huge terms cancel; \
         edge-on, it divides by nearly 0",
        "**Ferrari f64**: the same with twice the digits. It fails further away",
        "**Closed form**: Ferrari's formula in f64, but with distances from a point near the donut \
         instead of from the viewer, and without the division by nearly 0. It takes longer than exact",
        "**Exact**: Newton's method, from starts where no step can jump past the first solution",
    ]
    .map(|text| format!("| {text} |"));
    let mut head = "| method |".to_string();
    for (name, view, poses) in &scenes {
        let (view, k2) = (*view, view.k2);
        let mut methods = [
            program("classic", with_steps(view, 0.07, 0.02)),
            sphere_tracing(view, 64),
            ray_by_ray("Newton", view, newton_once),
            ray_by_ray("f32", view, move |torus, ray| textbook_f32(torus, k2, ray)),
            ray_by_ray("f64", view, move |torus, ray| textbook_f64(torus, k2, ray)),
            closed_form("closed form", view, |g| first_root_f64(g, 0)),
            program("exact", renderer(view, Method::Exact)),
        ];
        let (wrong, surface) = wrong_cells(&mut methods, &view, poses);
        write!(head, " {name} |").unwrap();
        for (row, wrong) in rows.iter_mut().zip(wrong) {
            let share = wrong.share(surface);
            // One decimal from 1 to 10, and one significant digit below.
            let decimals = match share {
                10.0.. | 0.0 => 0,
                1.0.. => 1,
                _ => -share.log10().floor() as usize,
            };
            write!(row, " {share:.decimals$} |").unwrap();
        }
    }
    format!("{head}\n|---|{}\n{}\n", "--:|".repeat(scenes.len()), rows.join("\n"))
}

/// The README with that table made anew.
fn readme() -> String {
    let readme = read("README.md");
    let section = readme.find("## Where methods fail").unwrap();
    let start = section + readme[section..].find("\n|").unwrap() + 1;
    let end = start + readme[start..].find("\n\n").unwrap() + 1;
    [&readme[..start], &failures(), &readme[end..]].concat()
}

/// The largest error of donut.c's angle A up to frame n, in radians, for several frames n. The
/// error is the difference from `0.04 n`: A is a sum, and each addition is rounded.
///
/// The frames go from 1,000 to 30 million, each a tenth more than the one before. Three others are among
/// them: where the error passes a whole turn, where A begins to turn too fast, and where A stops.
fn clock_errors() -> Vec<(u32, f64)> {
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

/// The files that can be made without measuring any times: their names and contents. The first is drawn
/// from the times stored in the table.
fn drawn() -> [(&'static str, String); 4] {
    let table = read(TABLE);
    let column = |line: &str, n| line.split(',').nth(n).unwrap().parse::<f64>().unwrap();
    let dots = table.lines().filter_map(|line| {
        let (method, _) = line.split_once(",80x22,")?;
        Some((method, (column(line, 2), column(line, 7))))
    });
    let errors = clock_errors();
    let mut clock = String::from("frame,largest error of A up to it in radians\n");
    for (frame, error) in &errors {
        writeln!(clock, "{frame},{error:.6}").unwrap();
    }
    [
        (
            "tests/chart/speed-and-accuracy.svg",
            plot::speed_and_accuracy(&dots.collect::<Vec<_>>()).unwrap(),
        ),
        ("tests/chart/clock.csv", clock),
        ("tests/chart/clock.svg", plot::clock(&errors).unwrap()),
        ("README.md", readme()),
    ]
}

#[test]
#[ignore = "measures for two minutes"]
fn measure_and_write_the_tables_and_the_charts() {
    let mut table = String::from(TITLES);
    // By how much donut.c's view is enlarged, and for how many seconds its frames are timed.
    for (scale, seconds) in [(1, 15), (2, 20), (4, 30), (8, 5), (16, 10)] {
        let mut methods = program_methods(scale);
        if scale <= 4 {
            methods.extend(methods_to_compare(scale));
        }
        table.push_str(&measure(methods, &enlarged(scale), seconds));
    }
    println!("{TABLE}\n{table}");
    fs::write(path(TABLE), table).unwrap();
    for (name, contents) in drawn() {
        fs::write(path(name), contents).unwrap();
    }
}

#[test]
fn the_charts_and_the_tables_of_the_clock_and_of_the_readme_are_up_to_date() {
    for (name, contents) in drawn() {
        assert_current(name, &contents);
    }
}

/// The rows of larger pictures are not counted again, which would take minutes.
#[test]
fn the_wrong_cells_in_the_tables_rows_for_80x22_are_those_counted_now() {
    let (table, mut methods) = (read(TABLE), program_methods(1));
    methods.extend(methods_to_compare(1));
    let (wrong, surface) = wrong_cells(&mut methods, &View::DONUT_C, &donut_c_poses(POSES));
    for (method, wrong) in methods.iter().zip(wrong) {
        let (start, end) = (format!("{},80x22,", method.name), wrong.columns(surface));
        assert!(
            table.lines().any(|line| line.starts_with(&start) && line.ends_with(&end)),
            "no line {start}...,{end} in\n{table}"
        );
    }
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
        let mut renderer = Renderer::new(view, Method::Classic, RAMP);
        let (mut zbuffer, mut cells) = (vec![0.0; width * height], vec![b' '; width * height]);
        for &(a, b) in &poses {
            cells.fill(b' ');
            donut_c(a as f32, b as f32, &view, &mut zbuffer, &mut cells);
            renderer.render_frame(a, b);
            assert!(renderer.framebuffer == cells, "A {a}, B {b}, {width}x{height}");
        }
    }
}
