//! The tests that look inside the program. Those in the folder above only run it.
//!
//! This file has what several of them need: files, views, poses, and the judgement of pictures.

mod angles;
mod aspect;
// Which cells an unstable method gets wrong depends on how the system rounds sines, cosines and roots.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
mod chart;
// Without SSE2, classic rounds otherwise than donut.c.
#[cfg(any(not(target_arch = "x86"), target_feature = "sse2"))]
mod classic;
mod dist;
#[rustfmt::skip]
#[allow(dead_code, reason = "it is a program, too")]
mod donut;
mod exact;
#[cfg(unix)]
mod keys;
mod oracle;
#[cfg(target_os = "linux")]
mod panic;
#[path = "../program/mod.rs"]
#[allow(dead_code, reason = "tests/cli.rs and tests/golden.rs use the rest")]
mod program;
mod search;

use super::*;
use oracle::{Oracle, Verdict, differ, level_of};
use program::in_time;
use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::fs;

/// The full path of a file of the source tree.
fn path(name: &str) -> String {
    format!("{}/{name}", env!("CARGO_MANIFEST_DIR"))
}

fn read(name: &str) -> String {
    fs::read_to_string(path(name)).unwrap()
}

/// Checks that a file that the program makes, or that is made from its options, has these contents. With
/// `UPDATE=1` in the environment, writes them first.
#[track_caller]
fn assert_current(name: &str, contents: &str) {
    if env::var_os("UPDATE").is_some() {
        fs::write(path(name), contents).unwrap();
    }
    assert!(read(name) == contents, "{name} is stale: run UPDATE=1 cargo test, and commit it");
}

fn options(line: &str) -> Options {
    Options::parse_from(format!("donut {line}").split_whitespace())
}

/// donut.c's view, with each cell divided into `scale` by `scale` cells.
fn enlarged(scale: usize) -> View {
    let View { r2, k2, width, height, cx, cy, k1x, k1y } = View::DONUT_C;
    let [cx, cy, k1x, k1y] = [cx, cy, k1x, k1y].map(|number| scale as f64 * number);
    View { r2, k2, width: scale * width, height: scale * height, cx, cy, k1x, k1y }
}

/// The program's view of donut.c's donut in a picture of another size.
fn fitted(columns: usize, rows: usize) -> View {
    View::fitted(columns, rows, 2.0, 2.0, 5.0)
}

/// The direction (dx, dy, 1) of the ray through a point of the screen.
fn direction(view: &View, x: f64, y: f64) -> (f64, f64) {
    ((x - view.cx) / view.k1x, (y - view.cy) / view.k1y)
}

/// The cells of a picture: for each, its index, the direction of the ray through its centre, and what the
/// oracle sees there.
fn cells(view: &View, oracle: &Oracle) -> impl Iterator<Item = (usize, (f64, f64), Option<f64>)> {
    let columns_and_rows =
        (0..view.height).flat_map(|row| (0..view.width).map(move |column| (column, row)));
    columns_and_rows.map(|(column, row)| {
        let (dx, dy) = direction(view, column as f64 + 0.5, row as f64 + 0.5);
        (row * view.width + column, (dx, dy), oracle.look(dx, dy))
    })
}

/// The level of a glyph: its place in the ramp, from 0 for the darkest to 11. A blank has none.
fn level(glyph: u8) -> Option<usize> {
    let level = RAMP.iter().position(|&ramp| ramp == glyph);
    assert!(level.is_some() || glyph == b' ', "{glyph:?} is not a glyph");
    level
}

/// Poses of donut.c itself, 61 frames apart.
fn donut_c_poses(count: usize) -> Vec<(f64, f64)> {
    (0..count).map(|n| (2.44 * n as f64, 1.22 * n as f64)).collect()
}

fn draw(method: Method, view: View, a: f64, b: f64) -> Vec<u8> {
    in_time(move || {
        let mut renderer = Renderer::new(view, method);
        renderer.render_frame(a, b);
        renderer.framebuffer
    })
}

/// Counts the cells of pictures: all, those in which the oracle sees the donut, and those of each of its
/// verdicts but `Right`. `oracle.rs` explains the verdicts.
#[derive(Debug, Default)]
struct Tally {
    cells: usize,
    surface: usize,
    ties: usize,
    holes: usize,
    extra: usize,
    shades: usize,
}

impl Tally {
    fn count(&mut self, is_surface: bool, verdict: Verdict) {
        self.cells += 1;
        self.surface += usize::from(is_surface);
        match verdict {
            Verdict::Right => {}
            Verdict::Tie => self.ties += 1,
            Verdict::Hole => self.holes += 1,
            Verdict::Extra => self.extra += 1,
            Verdict::Shade => self.shades += 1,
        }
    }

    fn wrong(&self) -> usize {
        self.holes + self.extra + self.shades
    }

    /// Checks that no cell is wrong, that some cells show the donut, and that almost none are ties.
    #[track_caller]
    fn assert_right(&self) {
        assert!(self.surface > 0 && self.wrong() == 0, "{self:?}");
        assert!(self.ties * 10_000 <= self.cells, "{self:?}");
    }
}

/// Lets the oracle judge every cell of several pictures of one pose. Each picture has a tally of its own.
fn add_pictures(tallies: &mut [Tally], view: &View, (a, b): (f64, f64), pictures: &[Vec<u8>]) {
    let oracle = Oracle::new(view.r2, view.k2, a, b);
    for (cell, (dx, dy), light) in cells(view, &oracle) {
        for (tally, picture) in tallies.iter_mut().zip(pictures) {
            tally.count(light.is_some(), oracle.judge(dx, dy, light, level(picture[cell])));
        }
    }
}

/// Draws the donut by exact at each pair of angles A and B, and lets the oracle judge every cell.
fn compare(view: View, poses: &[(f64, f64)]) -> Tally {
    let mut tally = Tally::default();
    for &(a, b) in poses {
        let picture = draw(Method::Exact, view, a, b);
        add_pictures(std::slice::from_mut(&mut tally), &view, (a, b), &[picture]);
    }
    tally
}
