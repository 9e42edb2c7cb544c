//! What each way to draw the donut costs, and how wrong it is: the tables of tests/chart, and the
//! charts that are drawn from them.
//!
//! `cargo test --release chart -- --ignored --nocapture` measures, and writes all of them.

mod plot;
mod rivals;

use std::fmt::Write as _;
use std::fs;

use self::rivals::{donut_c, first_root_f32, first_root_f64, sphere_trace, trace_with};
use super::classic::with_steps;
use super::*;

/// How many of donut.c's own poses are drawn.
const POSES: usize = 50;

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
}

/// A line of the table.
struct Row {
    name: String,
    /// How often donut.c's view is enlarged.
    times: usize,
    /// Microseconds a frame: median, 10th and 90th percentile.
    micros: [f64; 3],
    wrong: Wrong,
    /// Cells at whose centre the oracle sees the donut.
    surface: usize,
}

impl Row {
    const TITLES: &str = "method,size,us per frame (median),us (10th percentile),\
        us (90th percentile),wrong cells,cells of the donut,% wrong,\
        one shade off,more shades off,extra outline,holes\n";

    /// Wrong cells, in per cent of the donut's.
    fn wrong_share(&self) -> f64 {
        100.0 * self.wrong.sum() as f64 / self.surface as f64
    }

    /// The last columns of the table.
    fn accuracy(&self) -> String {
        let Wrong { one_shade, more_shades, extra, holes } = self.wrong;
        let (sum, surface, share) = (self.wrong.sum(), self.surface, self.wrong_share());
        format!("{sum},{surface},{share:.4},{one_shade},{more_shades},{extra},{holes}")
    }

    fn line(&self) -> String {
        let [median, low, high] = self.micros;
        let (name, size, accuracy) = (&self.name, size(self.times), self.accuracy());
        format!("{name},{size},{median:.1},{low:.1},{high:.1},{accuracy}\n")
    }

    fn parse(line: &str) -> Row {
        let columns: Vec<_> = line.split(',').collect();
        let count = |n: usize| columns[n].parse().unwrap();
        let [one_shade, more_shades, extra, holes] = [8, 9, 10, 11].map(count);
        Row {
            name: columns[0].into(),
            times: SIZES.into_iter().find(|&times| size(times) == columns[1]).unwrap(),
            micros: [2, 3, 4].map(|n| columns[n].parse().unwrap()),
            wrong: Wrong { one_shade, more_shades, extra, holes },
            surface: count(6),
        }
    }
}

/// How often donut.c's view is enlarged.
const SIZES: [usize; 5] = [1, 2, 4, 8, 16];

fn size(times: usize) -> String {
    let View { width, height, .. } = enlarged(times);
    format!("{width}x{height}")
}

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

fn closed_form(name: &str, view: View, first_root: impl Fn([f64; 3]) -> f64 + 'static) -> Way {
    way(name, move |a, b, cells| {
        trace_with((a, b), &view, cells, |torus, [rays]: &[Rays; 1]| {
            let root = |i| first_root(torus.quartic(rays.d0[i], rays.f0[i], rays.fu[i]));
            [std::array::from_fn(root)]
        });
    })
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
    ways.extend([8, 16, 32, 64, 256].map(|most_steps| {
        way(format!("sphere tracing {most_steps}"), move |a, b, cells| {
            trace_with((a, b), &view, cells, |_, rays| sphere_trace(rays, most_steps));
        })
    }));
    let mut zbuffer = vec![0.0; view.width * view.height];
    ways.push(way("donut.c as written", move |a, b, cells| {
        donut_c(a as f32, b as f32, &view, &mut zbuffer, cells);
    }));
    ways
}

/// The wrong cells of each way, and the cells of the donut, over all poses.
fn wrong_cells(ways: &mut [Way], view: &View) -> (Vec<Wrong>, usize) {
    let (mut wrong, mut surface) = (vec![Wrong::default(); ways.len()], 0);
    for (a, b) in own_poses(POSES) {
        let oracle = Oracle::new(1.0, 2.0, 5.0, a, b);
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

/// Microseconds a frame of each way, as in its row: rounds of all poses, one way after another, until it is time.
fn micros(ways: &mut [Way], view: &View, seconds: u64) -> Vec<[f64; 3]> {
    let mut cells = vec![b' '; view.width * view.height];
    let mut samples = vec![Vec::new(); ways.len()];
    let start = Instant::now();
    loop {
        for (way, samples) in ways.iter_mut().zip(&mut samples) {
            for (a, b) in own_poses(POSES) {
                let start = Instant::now();
                cells.fill(b' ');
                (way.draw)(a, b, &mut cells);
                samples.push(start.elapsed().as_secs_f64() * 1e6);
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

fn measure(mut ways: Vec<Way>, times: usize, seconds: u64) -> Vec<Row> {
    let view = enlarged(times);
    let micros = micros(&mut ways, &view, seconds);
    let (wrong, surface) = wrong_cells(&mut ways, &view);
    let rows = ways.into_iter().zip(micros).zip(wrong);
    let rows =
        rows.map(|((way, micros), wrong)| Row { name: way.name, times, micros, wrong, surface });
    rows.collect()
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

const TABLE: &str = "speed-and-accuracy.csv";

fn path(name: &str) -> String {
    format!("{}/tests/chart/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    fs::read_to_string(path(name)).unwrap()
}

/// The charts and the table of the clock, as file names and contents: all that follows from the
/// measured table and from donut.c's arithmetic.
fn drawn() -> [(&'static str, String); 3] {
    let table = read(TABLE);
    let rows: Vec<_> = table.lines().skip(1).map(Row::parse).collect();
    let errors = clock_errors();
    let mut clock = String::from("frame,largest error of A up to it in radians\n");
    for (frame, error) in &errors {
        writeln!(clock, "{frame},{error:.6}").unwrap();
    }
    [
        ("speed-and-accuracy.svg", plot::speed_and_accuracy(&rows).unwrap()),
        ("clock.csv", clock),
        ("clock.svg", plot::clock(&errors).unwrap()),
    ]
}

#[test]
#[ignore = "measures for two minutes"]
fn the_charts_are_measured() {
    let mut table = String::from(Row::TITLES);
    for (times, seconds) in SIZES.into_iter().zip([15, 20, 30, 5, 10]) {
        let mut ways = own_ways(times);
        if times <= 4 {
            ways.extend(other_ways(times));
        }
        table.extend(measure(ways, times, seconds).iter().map(Row::line));
    }
    println!("{TABLE}\n{table}");
    fs::write(path(TABLE), table).unwrap();
    for (name, contents) in drawn() {
        fs::write(path(name), contents).unwrap();
    }
}

#[test]
fn the_charts_show_the_table() {
    for (name, contents) in drawn() {
        if env::var_os("UPDATE").is_some() {
            fs::write(path(name), &contents).unwrap();
        }
        let stale = read(name) != contents;
        assert!(!stale, "tests/chart/{name} is stale: run UPDATE=1 cargo test, and commit");
    }
}

#[test]
fn the_table_counts_the_wrong_cells_of_classic_and_exact() {
    let table = read(TABLE);
    for row in measure(own_ways(1), 1, 0) {
        let (start, end) = (format!("{},80x22,", row.name), row.accuracy());
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
    let edges = (0..=32).flat_map(|a| (0..=32).map(move |b| (a, b)));
    let edges = edges.map(|(a, b)| (f64::from(a) * TAU / 32.0, f64::from(b) * TAU / 32.0));
    let poses: Vec<_> = own_poses(12).into_iter().chain(edges).collect();
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
