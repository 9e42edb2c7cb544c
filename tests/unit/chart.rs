//! What each way to draw the donut costs, and how wrong it is.
//!
//! `cargo test --release chart -- --ignored --nocapture` measures, and writes the tables and the
//! charts in tests/chart.

use std::fmt::Write as _;
use std::fs;

use super::rivals::{donut_c, first_root_f32, first_root_f64, sphere_trace, trace_with};
use super::splat::with_steps;
use super::*;

/// How many of donut.c's own poses are drawn.
const POSES: usize = 50;

/// Draws the donut turned by A and B into a blank framebuffer.
type Draw = Box<dyn FnMut(f64, f64, &mut [u8])>;

struct Way {
    name: String,
    draw: Draw,
}

/// A line of the table.
pub struct Row {
    pub name: String,
    /// How often donut.c's camera is enlarged.
    pub times: usize,
    /// Microseconds a frame: 10th percentile, median, and 90th.
    pub micros: [f64; 3],
    pub wrong: usize,
    /// Cells at whose centre the oracle sees the donut.
    pub surface: usize,
}

impl Row {
    pub fn cells(&self) -> usize {
        self.times * self.times * Camera::DONUT_C.width * Camera::DONUT_C.height
    }

    /// Wrong cells, in per cent of the donut's.
    pub fn wrong_share(&self) -> f64 {
        100.0 * self.wrong as f64 / self.surface as f64
    }

    /// The last columns of the table.
    fn accuracy(&self) -> String {
        let Row { wrong, surface, .. } = self;
        format!("{wrong},{surface},{:.4}", self.wrong_share())
    }
}

pub fn size(times: usize) -> String {
    let Camera { width, height, .. } = enlarged(times);
    format!("{width}x{height}")
}

fn way(name: impl Into<String>, draw: impl FnMut(f64, f64, &mut [u8]) + 'static) -> Way {
    let (name, draw) = (name.into(), Box::new(draw));
    Way { name, draw }
}

fn splat(name: &str, camera: Camera, mut splat: Splat) -> Way {
    way(name, move |a, b, cells| {
        splat.draw(a as f32, b as f32, &camera, cells);
    })
}

fn closed_form(name: &str, camera: Camera, first_root: impl Fn([f64; 3]) -> f64 + 'static) -> Way {
    way(name, move |a, b, cells| {
        trace_with((a, b), &camera, cells, |[Rays { p, q, r, .. }]| {
            [std::array::from_fn(|i| first_root([p[i], q[i], r[i]]))]
        });
    })
}

/// The program's own.
fn own_ways(times: usize) -> Vec<Way> {
    let camera = enlarged(times);
    vec![
        splat("classic x1", camera, Splat::new(&camera)),
        way("exact", move |a, b, cells| {
            trace(a, b, &Scene::DONUT_C, &camera, cells);
        }),
    ]
}

/// What to compare them with.
fn other_ways(times: usize) -> Vec<Way> {
    let camera = enlarged(times);
    let coarser = |factor| {
        let factor: f64 = factor / times as f64;
        with_steps(&camera, 0.07 * factor, 0.02 * factor)
    };
    let mut ways = vec![
        splat("classic x4", camera, coarser(4.0)),
        splat("classic x2", camera, coarser(2.0)),
        splat("classic x1/2", camera, coarser(0.5)),
        splat("classic x1/4", camera, coarser(0.25)),
        splat("fixed 0.07/0.02", camera, with_steps(&camera, 0.07, 0.02)),
        closed_form("closed form f32", camera, |g| first_root_f32(g, 1)),
        closed_form("closed form f64", camera, |g| first_root_f64(g, 0)),
    ];
    ways.extend([8, 16, 32, 64, 256].map(|steps| {
        way(format!("sphere tracing {steps}"), move |a, b, cells| {
            trace_with((a, b), &camera, cells, |rays| sphere_trace(rays, steps));
        })
    }));
    let mut zbuffer = vec![0.0; camera.width * camera.height];
    ways.push(way("donut.c as written", move |a, b, cells| {
        donut_c(a as f32, b as f32, &camera, &mut zbuffer, cells);
    }));
    ways
}

/// The wrong cells of each way, and the cells of the donut, over all poses.
fn wrong_cells(ways: &mut [Way], camera: &Camera) -> (Vec<usize>, usize) {
    let (mut wrong, mut surface) = (vec![0; ways.len()], 0);
    for (a, b) in own_poses(POSES) {
        let oracle = Oracle::new(1.0, 2.0, 5.0, a, b);
        let rays = (1..camera.height).flat_map(|row| (1..camera.width).map(move |x| (row, x)));
        let truth = rays.map(|(row, column)| {
            let (dx, dy) = direction(camera, column as f64 + 0.5, row as f64 + 0.5);
            let seen = oracle.look(dx, dy).map(|light| light.max(0.0) as usize);
            (row * camera.width + column, (dx, dy), seen)
        });
        let truth: Vec<_> = truth.collect();
        surface += truth.iter().filter(|(.., seen)| seen.is_some()).count();
        for (way, wrong) in ways.iter_mut().zip(&mut wrong) {
            let mut cells = vec![b' '; camera.width * camera.height];
            (way.draw)(a, b, &mut cells);
            let judge = |&&(cell, (dx, dy), seen): &&(usize, (f64, f64), Option<usize>)| {
                let drawn = level(cells[cell]);
                drawn != seen && oracle.judge(dx, dy, drawn) != Verdict::Tie
            };
            *wrong += truth.iter().filter(judge).count();
        }
    }
    (wrong, surface)
}

/// Microseconds a frame of each way: rounds of all poses, one way after another, until it is time.
fn micros(ways: &mut [Way], camera: &Camera, seconds: u64) -> Vec<[f64; 3]> {
    let mut cells = vec![b' '; camera.width * camera.height];
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
        let Camera { width, height, .. } = camera;
        eprint!("\r{width}x{height}: timed for {elapsed:2} of {seconds} s, then judged ");
        if elapsed >= seconds {
            break;
        }
    }
    eprintln!();
    let percentiles = |mut samples: Vec<f64>| {
        samples.sort_by(f64::total_cmp);
        [1, 5, 9].map(|tenths| samples[samples.len() * tenths / 10])
    };
    samples.into_iter().map(percentiles).collect()
}

fn measure(mut ways: Vec<Way>, times: usize, seconds: u64) -> Vec<Row> {
    let camera = enlarged(times);
    let micros = micros(&mut ways, &camera, seconds);
    let (wrong, surface) = wrong_cells(&mut ways, &camera);
    let rows = ways.into_iter().zip(micros).zip(wrong);
    let rows =
        rows.map(|((way, micros), wrong)| Row { name: way.name, times, micros, wrong, surface });
    rows.collect()
}

fn csv(rows: &[Row]) -> String {
    let mut table = String::from(
        "method,size,us per frame (median),us (10th percentile),us (90th percentile),\
         wrong cells,cells of the donut,% wrong\n",
    );
    for row in rows {
        let [low, median, high] = row.micros;
        let (name, size, accuracy) = (&row.name, size(row.times), row.accuracy());
        let times = format!("{median:.1},{low:.1},{high:.1}");
        writeln!(table, "{name},{size},{times},{accuracy}").unwrap();
    }
    table
}

/// donut.c's running angle A against `0.04 n`, in radians, at frames n from 10^3 to 3 x 10^7.
fn clock_errors() -> Vec<(u32, f64)> {
    const LAST: u32 = 30_000_000;
    let mut frames: Vec<_> =
        (72..).map(|n| 10_f64.powf(f64::from(n) / 24.0) as u32).take_while(|&n| n < LAST).collect();
    frames.extend([3_345_245, 22_918_663, LAST]);
    frames.sort_unstable();
    let (mut frame, mut angle) = (0, 0.0);
    frames
        .into_iter()
        .map(|next| {
            while frame < next {
                (frame, angle) = (frame + 1, advance(angle, 0.04));
            }
            (frame, (f64::from(angle) - 0.04 * f64::from(frame)).abs())
        })
        .collect()
}

fn path(name: &str) -> String {
    format!("{}/tests/chart/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// Writes and prints a table.
fn publish(name: &str, table: &str) {
    fs::write(path(name), table).unwrap();
    println!("{name}\n{table}");
}

#[test]
#[ignore = "measures for two minutes"]
fn speed_against_accuracy_is_charted() {
    let mut rows = Vec::new();
    for (times, seconds) in [(1, 15), (2, 20), (4, 30)] {
        let mut ways = own_ways(times);
        ways.extend(other_ways(times));
        rows.extend(measure(ways, times, seconds));
    }
    publish("speed-and-accuracy.csv", &csv(&rows));
    plot::speed_and_accuracy(&path("speed-and-accuracy.svg"), &rows).unwrap();

    let grown = [1, 2, 4, 8, 16].map(|times| measure(own_ways(times), times, 3));
    let grown: Vec<_> = grown.into_iter().flatten().collect();
    publish("growth.csv", &csv(&grown));
    plot::growth(&path("growth.svg"), &grown).unwrap();

    let errors = clock_errors();
    let mut table = String::from("frame,error of A in radians\n");
    for (frame, error) in &errors {
        writeln!(table, "{frame},{error:.6}").unwrap();
    }
    publish("clock.csv", &table);
    plot::clock(&path("clock.svg"), &errors).unwrap();
}

#[test]
fn the_table_counts_the_wrong_cells_of_classic_and_exact() {
    let table = fs::read_to_string(path("speed-and-accuracy.csv")).unwrap();
    for row in measure(own_ways(1), 1, 0) {
        let (start, end) = (format!("{},80x22,", row.name), row.accuracy());
        assert!(
            table.lines().any(|line| line.starts_with(&start) && line.ends_with(&end)),
            "no line {start}...,{end} in\n{table}"
        );
    }
}

#[test]
fn donut_c_as_written_draws_what_classic_draws() {
    let [mut classic, mut donut_c] = [own_ways(1).swap_remove(0), other_ways(1).pop().unwrap()];
    for (a, b) in own_poses(12) {
        let pictures = [&mut classic, &mut donut_c].map(|way| {
            let mut cells = vec![b' '; 1760];
            (way.draw)(a, b, &mut cells);
            cells
        });
        assert!(pictures[0] == pictures[1], "A {a}, B {b}");
    }
}
