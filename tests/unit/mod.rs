//! The mathematics, from inside.

mod chart;
mod clock;
mod dist;
mod exact;
mod oracle;
mod splat;
#[cfg(unix)]
mod terminal;

use super::*;
use oracle::{Oracle, Verdict};

/// donut.c's camera enlarged: what `--width` and `--height` draw is fitted instead.
fn enlarged(times: usize) -> Camera {
    let Camera { width, height, cx, cy, k1x, k1y } = Camera::DONUT_C;
    let s = times as f64;
    Camera {
        width: times * width,
        height: times * height,
        cx: s * cx,
        cy: s * cy,
        k1x: s * k1x,
        k1y: s * k1y,
    }
}

fn fitted(width: usize, height: usize) -> Camera {
    Camera::new(width, height, 2.0, &Scene::DONUT_C)
}

/// The direction (dx, dy, 1) of the ray through a point of the screen.
fn direction(camera: &Camera, x: f64, y: f64) -> (f64, f64) {
    ((x - camera.cx) / camera.k1x, (y - camera.cy) / camera.k1y)
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

fn draw(method: Method, scene: Scene, camera: Camera, a: f64, b: f64) -> Vec<u8> {
    let mut renderer = Renderer::new(scene, camera, method);
    renderer.render_frame(a, b);
    renderer.framebuffer
}

/// How cells stand to the oracle.
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
    /// Adds the cells of a picture, in which `oracle`'s torus should be seen.
    fn add(&mut self, oracle: &Oracle, camera: &Camera, framebuffer: &[u8]) {
        for row in 1..camera.height {
            for column in 1..camera.width {
                let (dx, dy) = direction(camera, column as f64 + 0.5, row as f64 + 0.5);
                let drawn = level(framebuffer[row * camera.width + column]);
                self.count(oracle.judge(dx, dy, drawn));
                self.surface += usize::from(drawn.is_some());
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

    /// Right everywhere, with surface to be right about, and next to no ties.
    #[track_caller]
    fn assert_right(&self) {
        println!("{self:?}");
        assert!(self.surface > 0 && self.wrong() == 0, "{self:?}");
        assert!(self.ties * 10_000 <= self.cells, "{self:?}");
    }
}
