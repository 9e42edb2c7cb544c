//! What each way to draw the donut costs, and how wrong it is: the tables and the charts of tests/chart,
//! and the table in the README.
//!
//! `cargo test --release chart -- --ignored --nocapture` measures, and writes all of them.

mod plot;
mod rivals;

use std::fmt::Write as _;
use std::fs;

use self::rivals::*;
use super::classic::with_steps;
use super::*;

/// Draws the donut turned by A and B into a blank framebuffer.
type Draw = Box<dyn FnMut(f64, f64, &mut [u8])>;

struct Way {
    name: String,
    draw: Draw,
}

/// Cells that show another glyph than the oracle sees at their centre, by kind.
#[derive(Clone, Copy, Default)]
struct Wrong {
    one_shade: usize,
    more_shades: usize,
    /// Drawn where the oracle sees no donut.
    extra: usize,
    /// Blank where it does.
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

    /// Wrong cells, in per cent of those at whose centre the oracle sees the donut.
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

/// In how many of donut.c's own poses cells are compared.
const POSES: usize = 50;
const TITLES: &str = "method,size,us per frame (median),us (10th percentile),us (90th percentile),\
    wrong cells,cells of the donut,% wrong,one shade off,more shades off,extra outline,holes\n";

fn way(name: impl Into<String>, draw: impl FnMut(f64, f64, &mut [u8]) + 'static) -> Way {
    let (name, draw) = (name.into(), Box::new(draw));
    Way { name, draw }
}

fn program(name: impl Into<String>, mut renderer: Renderer) -> Way {
    way(name, move |a, b, cells| {
        renderer.render_frame(a, b);
        cells.copy_from_slice(&renderer.framebuffer);
    })
}

fn sphere_tracing(view: View, most_steps: usize) -> Way {
    way(format!("sphere tracing {most_steps}"), move |a, b, cells| {
        trace_with((a, b), &view, cells, |torus, rays| sphere_trace(torus.r2, rays, most_steps));
    })
}

/// Finds the first hit of one ray after another, from its d0, f0 and fu.
fn ray_by_ray(
    name: &str,
    view: View,
    first_hit: impl Fn(&Torus, f64, f64, f64) -> f64 + 'static,
) -> Way {
    way(name, move |a, b, cells| {
        trace_with((a, b), &view, cells, |torus, [rays]: &[Rays; 1]| {
            [std::array::from_fn(|i| first_hit(torus, rays.d0[i], rays.f0[i], rays.fu[i]))]
        });
    })
}

fn closed_form(name: &str, view: View, first_root: impl Fn([f64; 3]) -> f64 + 'static) -> Way {
    ray_by_ray(name, view, move |torus, d0, f0, fu| first_root(torus.quartic(d0, f0, fu)))
}

/// The program's own.
fn own_ways(times: usize) -> Vec<Way> {
    [("classic x1", Method::Classic), ("exact", Method::Exact)]
        .map(|(name, method)| program(name, renderer(enlarged(times), method)))
        .into()
}

/// What to compare them with.
fn other_ways(times: usize) -> Vec<Way> {
    let view = enlarged(times);
    let steps =
        |name: &str, factor: f64| program(name, with_steps(view, 0.07 * factor, 0.02 * factor));
    let own = 1.0 / times as f64;
    let mut ways = vec![
        steps("classic x4", 4.0 * own),
        steps("classic x2", 2.0 * own),
        steps("classic x1/2", 0.5 * own),
        steps("classic x1/4", 0.25 * own),
        steps("fixed 0.07/0.02", 1.0),
        closed_form("closed form f32", view, |g| first_root_f32(g, 1)),
        closed_form("closed form f64", view, |g| first_root_f64(g, 0)),
    ];
    ways.extend([8, 16, 32, 64, 256].map(|most_steps| sphere_tracing(view, most_steps)));
    let mut zbuffer = vec![0.0; view.width * view.height];
    ways.push(way("donut.c as written", move |a, b, cells| {
        donut_c(a as f32, b as f32, &view, &mut zbuffer, cells);
    }));
    ways
}

/// The wrong cells of each way, and the cells of the donut, over these poses.
fn wrong_cells(ways: &mut [Way], view: &View, poses: &[(f64, f64)]) -> (Vec<Wrong>, usize) {
    let (mut wrong, mut surface) = (vec![Wrong::default(); ways.len()], 0);
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
        for (way, wrong) in ways.iter_mut().zip(&mut wrong) {
            let mut cells = vec![b' '; view.width * view.height];
            (way.draw)(a, b, &mut cells);
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

/// Microseconds a frame of each way, in the order of the table's columns. All ways are timed in turn, round
/// after round, until the time is up.
///
/// Each round has five runs of 40 frames that follow one another, as in the program. Unrelated frames
/// take a few per cent longer.
fn micros(ways: &mut [Way], view: &View, seconds: u64) -> Vec<[f64; 3]> {
    let mut cells = vec![b' '; view.width * view.height];
    let mut samples = vec![Vec::new(); ways.len()];
    let start = Instant::now();
    loop {
        for (way, samples) in ways.iter_mut().zip(&mut samples) {
            for (a, b) in own_poses(5) {
                for frame in 0..40 {
                    let frame = f64::from(frame);
                    let start = Instant::now();
                    cells.fill(b' ');
                    (way.draw)(a + 0.04 * frame, b + 0.02 * frame, &mut cells);
                    samples.push(start.elapsed().as_secs_f64() * 1e6);
                }
            }
        }
        let elapsed = start.elapsed().as_secs();
        let View { width, height, .. } = view;
        eprint!("\r{width}x{height}: timed for {elapsed:2} of {seconds} s, then judged ");
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

/// The lines of the table for these ways.
fn measure(mut ways: Vec<Way>, view: &View, seconds: u64) -> String {
    let micros = micros(&mut ways, view, seconds);
    let (wrong, surface) = wrong_cells(&mut ways, view, &own_poses(POSES));
    let mut lines = String::new();
    for ((way, [median, low, high]), wrong) in ways.iter().zip(micros).zip(wrong) {
        let (size, accuracy) = (format!("{}x{}", view.width, view.height), wrong.columns(surface));
        writeln!(lines, "{},{size},{median:.1},{low:.1},{high:.1},{accuracy}", way.name).unwrap();
    }
    lines
}

/// The README's table of where methods fail.
fn failures() -> String {
    let scene = |r2, k2| View::new(160, 44, 2.0, r2, k2);
    let poses = own_poses(10);
    let edge_on: Vec<_> = poses.iter().map(|&(_, b)| (TAU / 4.0 + 1e-4, b)).collect();
    let rows = [
        ("donut.c's donut, at 160x44", scene(2.0, 5.0), &poses),
        ("larger: 320x88", fitted(320, 88), &poses),
        ("edge-on, within 0.0001 rad", scene(2.0, 5.0), &edge_on),
        ("a thin ring: `--r2 9 --k2 25`", scene(9.0, 25.0), &poses),
        ("close up: `--k2 3.003`", scene(2.0, 3.003), &poses),
        ("far away: `--k2 50`", scene(2.0, 50.0), &poses),
        ("further away: `--k2 50000`", scene(2.0, 50_000.0), &poses),
    ];
    let mut table = String::from(
        "| wrong cells, in % of the donut's | donut.c's steps | sphere tracing | Newton, one start \
         | Ferrari f32 | Ferrari f64 | closed form | exact |\n|---|--:|--:|--:|--:|--:|--:|--:|\n",
    );
    for (name, view, poses) in rows {
        let k2 = view.k2;
        let mut ways = [
            program("classic", with_steps(view, 0.07, 0.02)),
            sphere_tracing(view, 64),
            ray_by_ray("Newton", view, newton_once),
            ray_by_ray("f32", view, move |torus, d0, _, fu| textbook_f32(torus, k2, d0, fu)),
            ray_by_ray("f64", view, move |torus, d0, _, fu| textbook_f64(torus, k2, d0, fu)),
            closed_form("closed form", view, |g| first_root_f64(g, 0)),
            program("exact", renderer(view, Method::Exact)),
        ];
        let (wrong, surface) = wrong_cells(&mut ways, &view, poses);
        write!(table, "| {name} |").unwrap();
        for wrong in wrong {
            let share = wrong.share(surface);
            let decimals = match share {
                10.0.. | 0.0 => 0,
                1.0.. => 1,
                _ => -share.log10().floor() as usize,
            };
            write!(table, " {share:.decimals$} |").unwrap();
        }
        table.push('\n');
    }
    table
}

/// The README with that table up to date.
fn readme() -> String {
    let readme = read("README.md");
    let section = readme.find("## Where methods fail").unwrap();
    let start = section + readme[section..].find("\n|").unwrap() + 1;
    let end = start + readme[start..].find("\n\n").unwrap() + 1;
    [&readme[..start], &failures(), &readme[end..]].concat()
}

/// donut.c's running angle A against `0.04 n`: the largest error up to frame n, in radians, at frames
/// a tenth apart from 1,000 to 30 million.
fn clock_errors() -> Vec<(u32, f64)> {
    const LAST: u32 = 30_000_000;
    let frames = std::iter::successors(Some(1000), |n| Some(n + n / 10));
    let mut frames: Vec<_> = frames.take_while(|&n| n < LAST).collect();
    frames.extend([3_345_245, 22_918_663, LAST]);
    frames.sort_unstable();
    let (mut frame, mut angle, mut largest) = (0, 0.0, 0.0);
    let mut error_at = |n| {
        while frame < n {
            (frame, angle) = (frame + 1, advance(angle, 0.04));
            largest = f64::max(largest, (f64::from(angle) - 0.04 * f64::from(frame)).abs());
        }
        (n, largest)
    };
    frames.into_iter().map(&mut error_at).collect()
}

const TABLE: &str = "tests/chart/speed-and-accuracy.csv";

fn path(name: &str) -> String {
    format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    fs::read_to_string(path(name)).unwrap()
}

/// The files that follow from the measured table, or from no measurement of time: names and contents.
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
fn the_charts_are_measured() {
    let mut table = String::from(TITLES);
    // How often donut.c's view is enlarged, and for how long its frames are timed.
    for (times, seconds) in [(1, 15), (2, 20), (4, 30), (8, 5), (16, 10)] {
        let mut ways = own_ways(times);
        if times <= 4 {
            ways.extend(other_ways(times));
        }
        table.push_str(&measure(ways, &enlarged(times), seconds));
    }
    println!("{TABLE}\n{table}");
    fs::write(path(TABLE), table).unwrap();
    for (name, contents) in drawn() {
        fs::write(path(name), contents).unwrap();
    }
}

#[test]
fn the_charts_and_the_readme_show_what_was_measured() {
    for (name, contents) in drawn() {
        if env::var_os("UPDATE").is_some() {
            fs::write(path(name), &contents).unwrap();
        }
        let stale = read(name) != contents;
        assert!(!stale, "{name} is stale: run UPDATE=1 cargo test, and commit");
    }
}

#[test]
fn the_table_counts_the_wrong_cells_of_classic_and_exact() {
    let (table, mut ways) = (read(TABLE), own_ways(1));
    let (wrong, surface) = wrong_cells(&mut ways, &View::DONUT_C, &own_poses(POSES));
    for (way, wrong) in ways.iter().zip(wrong) {
        let (start, end) = (format!("{},80x22,", way.name), wrong.columns(surface));
        assert!(
            table.lines().any(|line| line.starts_with(&start) && line.ends_with(&end)),
            "no line {start}...,{end} in\n{table}"
        );
    }
}

/// A plain loop with donut.c's own tests of each sample draws the same, also where the outline passes the
/// edges of the picture, and where the back shows through the holes between the samples.
#[test]
fn donut_c_as_written_draws_what_classic_draws() {
    let eighths = (0..64).map(|n| (f64::from(n % 8) * TAU / 8.0, f64::from(n / 8) * TAU / 8.0));
    let poses: Vec<_> = own_poses(12).into_iter().chain(eighths).collect();
    // At these sizes classic takes donut.c's own steps.
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
