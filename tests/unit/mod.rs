//! The tests that look inside the program. Those in the folder above only run it.
//!
//! - `exact.rs`: every cell that `exact` draws shows what the oracle sees there.
//! - `oracle.rs`: what a ray truly sees, found slowly and in another way than the program's.
//! - `classic.rs`: what `classic` is built of, and where its picture differs from the truth.
//! - `clock.rs`: the angles A and B, frame after frame, and which method `auto` then chooses.
//! - `terminal.rs`: what a panic leaves on the terminal.
//! - `dist.rs`: whether the manual page and the completions of tests/dist say what the program does.
//! - `chart/`: measures speed and accuracy, and draws the charts of tests/chart: `plot.rs` is how they
//!   are drawn, `rivals.rs` the other methods that they compare with ours.
//!
//! This file has what several of them need: views, poses, and the comparison of a picture with the
//! oracle.

mod chart;
mod classic;
mod clock;
mod dist;
mod exact;
mod oracle;
#[cfg(unix)]
mod terminal;

use super::*;
use oracle::{Oracle, Verdict};

/// donut.c's view enlarged: what `--width` and `--height` draw is fitted instead.
fn enlarged(times: usize) -> View {
    let View { r2, k2, width, height, .. } = View::DONUT_C;
    let [cx, cy, k1x, k1y] = [40.0, 12.0, 30.0, 15.0].map(|value| times as f64 * value);
    View { r2, k2, width: times * width, height: times * height, cx, cy, k1x, k1y }
}

/// donut.c's donut in a picture of another size.
fn fitted(width: usize, height: usize) -> View {
    View::new(width, height, 2.0, 2.0, 5.0)
}

/// What the oracle sees in such a view.
fn oracle_of(view: &View, a: f64, b: f64) -> Oracle {
    Oracle::new(1.0, view.r2, view.k2, a, b)
}

/// The direction (dx, dy, 1) of the ray through a point of the screen.
fn direction(view: &View, x: f64, y: f64) -> (f64, f64) {
    ((x - view.cx) / view.k1x, (y - view.cy) / view.k1y)
}

/// The level of a glyph, from 0, the darkest, to 11; nothing for a blank.
fn level(glyph: u8) -> Option<usize> {
    let level = RAMP.iter().position(|&ramp| ramp == glyph);
    assert!(level.is_some() || glyph == b' ', "{glyph:?} is no glyph");
    level
}

/// Every 61st of donut.c's own poses.
fn own_poses(count: usize) -> Vec<(f64, f64)> {
    (0..count).map(|n| (2.44 * n as f64, 1.22 * n as f64)).collect()
}

/// A renderer for any view. An enlarged one reaches further below the picture than the program's own, so
/// its z-buffer needs more rows.
fn renderer(view: View, method: Method) -> Renderer {
    let mut renderer = Renderer::new(view, method, RAMP);
    renderer.zbuffer.resize(view.width * (view.height + 2 + view.height / 10), 0.0);
    renderer
}

fn draw(method: Method, view: View, a: f64, b: f64) -> Vec<u8> {
    let mut renderer = renderer(view, method);
    renderer.render_frame(a, b);
    renderer.framebuffer
}

/// How many cells there are, how many of them show the donut, and how many are ties or wrong.
#[derive(Debug, Default)]
struct Tally {
    cells: usize,
    drawn: usize,
    ties: usize,
    holes: usize,
    extra: usize,
    shades: usize,
}

impl Tally {
    /// Adds the cells of a picture, in which `oracle`'s torus should be seen.
    fn add(&mut self, oracle: &Oracle, view: &View, framebuffer: &[u8]) {
        for row in 1..view.height {
            for column in 1..view.width {
                let (dx, dy) = direction(view, column as f64 + 0.5, row as f64 + 0.5);
                let drawn = level(framebuffer[row * view.width + column]);
                self.count(oracle.judge(dx, dy, drawn));
                self.drawn += usize::from(drawn.is_some());
            }
        }
    }

    fn count(&mut self, verdict: Verdict) {
        self.cells += 1;
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

    /// No cell is wrong, some show the donut, and next to none are ties.
    #[track_caller]
    fn assert_right(&self) {
        println!("{self:?}");
        assert!(self.drawn > 0 && self.wrong() == 0, "{self:?}");
        assert!(self.ties * 10_000 <= self.cells, "{self:?}");
    }
}
