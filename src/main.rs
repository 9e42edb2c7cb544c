//! [donut.c], Andy Sloane's spinning ASCII torus of 2006, in Rust.
//!
//! donut.c draws a picture of 80 by 22 characters, for a terminal of 80 columns and 24 rows. In such a
//! terminal and in a pipe, this program draws the same picture unless an option asks for another; into a
//! pipe, it writes the same bytes. A picture of any other size has no original to match, so by default it
//! is ray-traced.
//!
//! # How donut.c draws a donut
//!
//! A torus is the surface swept by a small circle as its centre travels round a large one, the two always at
//! right angles. The surface is a tube, and the large circle, in the middle of the tube, is the ring. Here is
//! the torus of the first frame, cut in half and seen from the side. It is drawn to scale (except for the
//! screen, which may stand anywhere), and the viewer is on the left:
//! ```text
//!                         screen  .-"-.
//!                           |   .'     '.
//!                           |   :   +---:  R1, the radius of the tube
//!                           |   '.  |  .'
//!                           |     '-|-'
//!                           |       |      R2, the radius of the ring
//!     viewer    o-----------|-------+--------->  z, the axis of the ring
//!               :           |
//!               :           |     .-"-.
//!               :           |   .'     '.
//!               :           |   :   +   :
//!               :           |   '.     .'
//!               :           |     '-.-'
//!               :....K1.....:       :
//!               :........K2.........:
//! ```
//! K2 is the distance from the viewer to the centre of the donut. donut.c has R1 = 1, R2 = 2 and K2 = 5, so
//! its unit of length is the radius of the tube. The screen is a grid of cells, one for each character. K1,
//! the distance from the viewer to the screen, only sets the scale of the picture. So it is measured in
//! cells, like the picture: K1 is 30 columns, or 15 rows, since a cell is twice as tall as it is wide. To the
//! viewer, the x axis points right, the y axis points *down*, and the z axis points away.
//!
//! **Samples.** donut.c represents the surface by samples. The angle theta goes round the tube in steps of
//! 0.07, and the angle phi goes round the ring in steps of 0.02. Each pair of angles gives one sample: a
//! point of the surface, and the normal there, a vector of length 1 in the direction that the surface faces.
//! The point is at distance h from the axis, and at distance f from the plane of the ring (f is negative on
//! one side of it):
//! ```text
//! h = R2 + R1 cos theta      point   (h cos phi, h sin phi, f)
//! f = R1 sin theta           normal  (cos theta cos phi, cos theta sin phi, sin theta)
//! ```
//! **Rotation.** The donut is rotated by the angle A about the x axis, and then by B about the z axis. Each
//! frame adds 0.04 to A and 0.02 to B. The rotations take the point to (X, Y, Z), measured from the donut's
//! centre; t is the point's y after the first rotation. The normal is rotated by the same formulas, with cos
//! theta for h and sin theta for f.
//! ```text
//! t = h sin phi cos A - f sin A
//! X = h cos phi cos B - t sin B
//! Y = h cos phi sin B + t cos B
//! Z = h sin phi sin A + f cos A
//! ```
//! **Perspective.** The depth of the point, `z = Z + K2`, is its distance from the viewer along the z axis.
//! A length of 1 appears K1 cells long at depth 1, and K1 / z cells long at depth z. So the point appears
//! `K1 X / z` to the right of where the donut's centre appears, and `K1 Y / z` below it. donut.c shows the
//! centre at column 40 and row 12 of its 80x22 cells. That is below the middle, so in some poses the lowest
//! part is cut off. (A little is lost at the top, too, because donut.c draws nothing in row 0.)
//!
//! **The z-buffer.** Many samples fall into the same cell, and the cell shows the nearest of them. To find
//! it, a z-buffer keeps the largest 1/z so far for each cell. (The perspective needs 1/z anyway, and 0 can
//! stand for infinitely far away.)
//!
//! **Luminance.** The cell shows how bright its sample is. The luminance L is the dot product of the normal
//! and the vector (0, -1, -1), which points at the light, far away above and behind the viewer. This vector
//! is sqrt 2 long, so L is at most sqrt 2, and 8 L is less than 12. The integer part of 8 L is an index, from
//! 0 to 11, into a ramp of twelve characters from dark to bright, `.,-~:;=!*#$@`. Where L is negative, the
//! surface faces away from the light, and the index is 0.
//!
//! The letters R1, R2, K1, K2, A, B and L are those of the [article] in which Andy Sloane explains donut.c,
//! but the angles A and B are measured as in donut.c itself: its A is pi/2 minus the article's A, and its B
//! is minus the article's B. All angles are in radians.
//!
//! # Two methods
//!
//! `classic` is all of the above: for each sample, it asks which cell the sample falls into. `exact` goes the
//! other way: for each cell, it asks what is there. It follows the ray from the viewer through the centre of
//! the cell. A number s says where on the ray a point is, and the ray meets the surface where a polynomial
//! G(s), of degree four, is 0. There are at most four such points. The cell shows the first, lit as above.
//!
//! Below are the view, the rendering, the two methods, the options, the loop, and last the terminal.
//!
//! [donut.c]: https://www.a1k0n.net/2006/09/15/obfuscated-c-donut.html
//! [article]: https://www.a1k0n.net/2011/07/20/donut-math.html

use std::f64::consts::{PI, TAU};
use std::io::{self, IsTerminal, Write};
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::time::{Duration, Instant};
use std::{array, env, fmt::Display, mem, panic, process, str::FromStr, thread};

use clap::{CommandFactory, Parser, ValueEnum, ValueHint, error::ErrorKind};
use crossterm::style::{self, Color, Print};
use crossterm::{cursor, execute, queue, terminal as term};
use wide::{f32x8, f64x8};

#[cfg(windows)]
use crossterm::event::{self, KeyCode, KeyModifiers};
#[cfg(unix)]
use {
    rustix::event::{PollFd, PollFlags, poll},
    rustix::fs::{Mode, OFlags, fcntl_getfl, fcntl_setfl, open},
    rustix::process::{Signal, getpgrp, kill_current_process_group},
    rustix::termios,
    rustix::{io::Errno, io::read, stdio},
    signal_hook::consts::{SIGCONT, SIGHUP, SIGINT, SIGQUIT, SIGTERM, SIGWINCH},
    signal_hook::{flag, low_level},
    std::os::fd::{BorrowedFd, OwnedFd},
};

// ---- View ----------------------------------------------------------------------------------------

/// The donut's proportions, the size of the picture, and how the donut is projected onto the picture.
///
/// Lengths are in radii of the tube, so that R1 is 1. Positions in the picture are measured in cells: the
/// cell in column c and row r spans c to c + 1 across, and r to r + 1 down. The point (X, Y, Z) appears at
/// `x = cx + k1x X / (Z + K2)` and `y = cy + k1y Y / (Z + K2)`.
#[derive(Clone, Copy, PartialEq)]
struct View {
    /// The radius of the ring: more than 1, because otherwise there is no hole.
    r2: f64,
    /// The distance from the viewer to the donut's centre: more than 1 + R2, so that the donut is in front.
    k2: f64,
    /// Columns and rows of the picture.
    width: usize,
    height: usize,
    /// Where the centre of the donut appears.
    cx: f64,
    cy: f64,
    /// K1, measured in columns and in rows.
    k1x: f64,
    k1y: f64,
}

impl View {
    /// donut.c's view. donut.c never draws in its column 0 and row 0. Here, these are left out, so its column
    /// 40 is 39, and its row 12 is 11.
    const DONUT_C: View =
        View { r2: 2.0, k2: 5.0, width: 79, height: 21, cx: 39.0, cy: 11.0, k1x: 30.0, k1y: 15.0 };
    /// The height of a cell divided by its width in donut.c, and by default: 2.
    const ASPECT: f64 = View::DONUT_C.k1x / View::DONUT_C.k1y;

    /// A view in which the donut is in the middle, and as large as it can be without being cut off in any
    /// pose: a circle whose radius is K1 times `outline_radius` has to fit into the picture.
    fn fitted(width: usize, height: usize, aspect: f64, r2: f64, k2: f64) -> View {
        let (half_width, half_height) = (width as f64 / 2.0, height as f64 / 2.0);
        let k1x = f64::min(half_width, aspect * half_height) / outline_radius(r2, k2);
        View { r2, k2, width, height, cx: half_width, cy: half_height, k1x, k1y: k1x / aspect }
    }
}

/// How large the donut can look: the radius of the outline of its bounding sphere, on a screen at distance 1.
/// However the donut is rotated, it just fits into this sphere, whose radius is R1 + R2. A ray to the outline
/// touches the sphere, at a right angle to the sphere's radius there. So the angle at the viewer, between
/// this ray and the one to the centre, has the sine (R1 + R2) / K2. The result is its tangent.
fn outline_radius(r2: f64, k2: f64) -> f64 {
    // The tangent is (R1 + R2) / sqrt(K2^2 - (R1 + R2)^2). As a product, the difference keeps its digits even
    // if the viewer is near.
    (1.0 + r2) / ((k2 - r2 - 1.0) * (k2 + r2 + 1.0)).sqrt()
}

// ---- Rendering -----------------------------------------------------------------------------------

// clap takes the text of --help from the doc comments of `Options`, and that of completions from these, too.
#[derive(Clone, Copy, Debug, PartialEq, ValueEnum)]
enum Method {
    /// Plot many points, show the nearest
    Classic,
    /// Follow a ray through the middle of each character
    Exact,
}

/// The characters that show the luminance, from dark to bright.
const RAMP: &[u8; 12] = b".,-~:;=!*#$@";

/// The character for a luminance L: the one at index 8 L of the ramp. L is at most sqrt 2, so 8 L is about
/// 11.3 at most, and 11 is the last index: 8 and the length of the ramp belong together.
fn glyph(luminance: f64) -> u8 {
    // `as u8` drops the fraction, and makes a negative number 0. `min` only saves a bounds check.
    RAMP[usize::from((8.0 * luminance) as u8).min(RAMP.len() - 1)]
}

struct Renderer {
    view: View,
    /// The character in each cell: `width * height` bytes, row by row, blank where there is no donut.
    framebuffer: Vec<u8>,
    /// What only `classic` needs. Without it, the method is `exact`.
    classic: Option<Classic>,
}

impl Renderer {
    fn new(view: View, method: Method) -> Renderer {
        let classic = (method == Method::Classic).then(|| Classic::new(&view, angle_steps(&view)));
        Renderer { view, framebuffer: vec![b' '; view.width * view.height], classic }
    }

    /// Draws the donut, rotated by the angles A and B, into the framebuffer.
    fn render_frame(&mut self, a: f64, b: f64) {
        let Renderer { view, framebuffer, classic } = self;
        framebuffer.fill(b' ');
        match classic {
            Some(classic) => classic.plot_samples(view, a as f32, b as f32, framebuffer),
            None => trace(view, a, b, framebuffer),
        }
    }

    /// The angles A and B of the next frame. donut.c keeps its angles in variables of type `float`, so each
    /// sum is rounded, and the errors add up. Eventually the angles are so large that adding a step no longer
    /// changes them, and the donut stands still. `classic` has to make the very same errors.
    fn advance(&self, angles: [f64; 2], spin: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|i| match self.classic {
            Some(_) => add_step(angles[i] as f32, spin[i]).into(),
            None => angles[i] + spin[i],
        })
    }

    /// Makes every glyph of the frame the darkest one.
    fn remove_shading(&mut self) {
        self.framebuffer.iter_mut().filter(|cell| **cell != b' ').for_each(|cell| *cell = RAMP[0]);
    }

    /// The bytes that show the frame. `clear` says whether to clear the screen first.
    fn encode(&self, color: Option<u8>, is_terminal: bool, clear: bool) -> io::Result<Vec<u8>> {
        // In raw mode, `\n` only moves the cursor down.
        let newline: &[u8] = if is_terminal { b"\r\n" } else { b"\n" };
        let mut bytes = Vec::with_capacity(self.framebuffer.len() + 100);
        // A terminal that supports synchronized updates shows the frame only when it is complete.
        if is_terminal {
            queue!(bytes, term::BeginSynchronizedUpdate)?;
        }
        // donut.c's own codes: to clear the screen, and to move the cursor to its top left corner.
        bytes.extend_from_slice(if clear { b"\x1b[2J\x1b[H" } else { b"\x1b[H" });
        if let Some(color) = color {
            queue!(bytes, style::SetForegroundColor(Color::AnsiValue(color)))?;
        }
        // donut.c begins each row with a newline, in place of column 0. So an empty line comes first, and
        // then its row 0, which its test `y > 0` leaves blank.
        let blank_row = [b' '; View::DONUT_C.width];
        let above: &[&[u8]] = if self.view == View::DONUT_C { &[b"", &blank_row] } else { &[] };
        let rows = self.framebuffer.chunks_exact(self.view.width);
        for (i, row) in above.iter().copied().chain(rows).enumerate() {
            if i > 0 {
                bytes.extend_from_slice(newline);
            }
            let trimmed = if is_terminal { row.trim_ascii_end() } else { row };
            bytes.extend_from_slice(trimmed);
            if trimmed.len() < row.len() {
                // Clears the rest of the row, usually in fewer bytes than blanks take.
                queue!(bytes, term::Clear(term::ClearType::UntilNewLine))?;
            }
        }
        if color.is_some() {
            queue!(bytes, style::ResetColor)?;
        }
        if is_terminal {
            queue!(bytes, term::EndSynchronizedUpdate)?;
        }
        bytes.extend_from_slice(newline); // Last, because `io::stdout` holds back what follows the last one.
        Ok(bytes)
    }
}

// The two methods follow. Both work on eight numbers at a time, in vector instructions. A value of the types
// `f32x8` and `f64x8`, from the crate wide, is eight numbers, its *lanes*. A formula is written as for one
// number, and computed in every lane; in a formula, a plain number stands for eight of itself. Each lane
// rounds as a single number would. Otherwise, `classic` could not match byte for byte.

// ---- classic: samples of the surface -------------------------------------------------------------

struct Classic {
    /// A grid of cells like donut.c's, row by row. Only the view's cells are shown. On the left and above are
    /// donut.c's column 0 and row 0; below, two rows more, because in some poses, its donut reaches down to
    /// 12 + 15 * 3/4, where 3/4 is its `outline_radius`.
    ///
    /// A cell holds a key for the nearest sample so far: its upper half has the bits of 1/z, and its lower
    /// half the sample's index, inverted. The nearer of two samples has the larger key, because the bits of
    /// positive floats are in the order of the floats. 0 stands for none, infinitely far away.
    zbuffer: Vec<u64>,
    /// The sine and the cosine of each theta in donut.c's loop.
    thetas: Vec<(f32, f32)>,
    /// The same of each phi, in groups of eight.
    phis: Vec<(f32x8, f32x8)>,
}

impl Classic {
    /// The steps are those of theta and of phi: `angle_steps`, except in tests, which try others.
    fn new(view: &View, steps: [f64; 2]) -> Classic {
        let [thetas, phis] = steps.map(trig_table);
        let group = |phis: &[(f32, f32)]| {
            // The last group is padded with the last phi: repeated samples change nothing.
            let lanes: [_; 8] = array::from_fn(|i| phis[i.min(phis.len() - 1)]);
            (f32x8::new(lanes.map(|(sin, _)| sin)), f32x8::new(lanes.map(|(_, cos)| cos)))
        };
        let phis = phis.chunks(8).map(group).collect();
        let zbuffer = vec![0; (1 + view.width) * (1 + view.height + 2)];
        Classic { zbuffer, thetas, phis }
    }

    /// donut.c's double loop over theta and phi. All arithmetic is in f32 and in donut.c's order of
    /// operations: in another order, rounding would change characters. donut.c has names of one letter:
    /// `sin_phi` is its c, `cos_theta` d, `sin_a` e, `sin_theta` f, `cos_a` g, `ooz` (1/z) D, `cos_phi` l,
    /// `cos_b` m, `sin_b` n and `cell` o.
    ///
    /// donut.c lights every sample. Here, the loop only finds the nearest sample of each cell, and then these
    /// are lit: of donut.c's samples, one in fifty. This is called *deferred shading*.
    #[inline(never)] // Inlined into its caller, the loop has too few registers, and takes a quarter longer.
    fn plot_samples(&mut self, view: &View, a: f32, b: f32, framebuffer: &mut [u8]) {
        let Classic { zbuffer, thetas, phis } = self;
        let &View { width, r2, k2, cx, cy, k1x, k1y, .. } = view;
        // Counted as in donut.c, from a column 0 and a row 0 that are not shown.
        let numbers = [r2, k2, 1.0 + cx, 1.0 + cy, k1x, k1y];
        let [r2, k2, cx, cy, k1x, k1y] = numbers.map(|number| number as f32);
        let [(sin_a, cos_a), (sin_b, cos_b)] = [a, b].map(c_sin_cos);
        let stride = 1 + width;

        zbuffer.fill(0);
        let mut index: u32 = 0; // Of a sample. Even at 4096x4096, it stays below 10^9.
        for &(sin_theta, cos_theta) in thetas.iter() {
            let h = cos_theta + r2;
            for &(sin_phi, cos_phi) in phis.iter() {
                let ooz = 1.0 / (sin_phi * h * sin_a + sin_theta * cos_a + k2);
                let t = sin_phi * h * cos_a - sin_theta * sin_a;
                let x = cx + k1x * ooz * (cos_phi * h * cos_b - t * sin_b);
                let y = cy + k1y * ooz * (cos_phi * h * sin_b + t * cos_b);
                // `fast_trunc_int` is C's cast to `int`. No x or y is negative: on the left and at the top,
                // all of the bounding sphere is inside the grid. A sample on the right edge counts as one in
                // column 0 of the next row, which is not shown.
                let cells = y.fast_trunc_int() * stride as i32 + x.fast_trunc_int();
                for (cell, ooz) in cells.to_array().into_iter().zip(ooz.to_array()) {
                    // The index is inverted so that of equally near samples, the first wins, as in donut.c.
                    // An `if` in place of `max` would be slow, because a processor can hardly predict it.
                    let key = u64::from(ooz.to_bits()) << 32 | u64::from(!index);
                    let nearest = &mut zbuffer[cell as usize];
                    *nearest = key.max(*nearest);
                    index += 1;
                }
            }
        }

        let grid_rows = zbuffer.chunks_exact(stride).skip(1);
        for (row, grid_row) in framebuffer.chunks_exact_mut(width).zip(grid_rows) {
            for (character, &nearest) in row.iter_mut().zip(&grid_row[1..]) {
                if nearest == 0 {
                    continue;
                }
                let index = !(nearest as u32) as usize; // From the lower half.
                let (group, lane) = (index / 8, index % 8);
                let (sin_theta, cos_theta) = thetas[group / phis.len()];
                let (sin_phi, cos_phi) = phis[group % phis.len()];
                let [sin_phi, cos_phi] = [sin_phi, cos_phi].map(|lanes| lanes.to_array()[lane]);
                // -y - z of the rotated normal: its dot product with (0, -1, -1).
                let luminance = (sin_theta * sin_a - sin_phi * cos_theta * cos_a) * cos_b
                    - sin_phi * cos_theta * sin_a
                    - sin_theta * cos_a
                    - cos_phi * cos_theta * sin_b;
                *character = glyph(luminance.into());
            }
        }
    }
}

/// donut.c's steps of theta and phi, or shorter ones for a larger picture. Where donut.c's donut is nearest
/// to the viewer, its samples are at most about a cell apart, and leave almost no gaps. With donut.c's R2 and
/// K2, and with n times its K1 (in columns or in rows, whichever is more), steps divided by n keep them so.
fn angle_steps(view: &View) -> [f64; 2] {
    let n = f64::max(view.k1x / View::DONUT_C.k1x, view.k1y / View::DONUT_C.k1y).max(1.0);
    [0.07 / n, 0.02 / n]
}

/// The sine and the cosine of each angle in one of donut.c's loops: from 0 in steps of `step`, once round.
fn trig_table(step: f64) -> Vec<(f32, f32)> {
    let angles = std::iter::successors(Some(0.0), |&angle| Some(add_step(angle, step)));
    // donut.c stops at 6.28. With its own steps, TAU gives the same angles (in f32, the last phi is 6.279995,
    // not 6.28). With much shorter steps, stopping at 6.28 would leave a gap.
    angles.take_while(|&angle| f64::from(angle) < TAU).map(c_sin_cos).collect()
}

/// donut.c's `angle += step`: C adds in `double` and rounds the sum to `float`.
fn add_step(angle: f32, step: f64) -> f32 {
    (f64::from(angle) + step) as f32
}

/// The sine and the cosine of an angle: C computes them in `double`, and rounds them to `float`. (The last
/// digit of f32's own `sin_cos` is not the same on every system.)
fn c_sin_cos(angle: f32) -> (f32, f32) {
    let (sin, cos) = f64::from(angle).sin_cos();
    (sin as f32, cos as f32)
}

// ---- exact: a ray for each cell ------------------------------------------------------------------

/// Added to each luminance, too little to be seen. In symmetric poses, the true 8 L may be exactly an
/// integer, and the rounding of sines and cosines, which differs between systems, would choose between two
/// glyphs. With this, the brighter one is drawn (unless rounding errors exceed it, as they may if R2 is large
/// or the ray almost grazes the donut).
const TIE_BIAS: f64 = 1e-12;

/// Shows in each cell what the ray through its centre hits first.
fn trace(view: &View, a: f64, b: f64, framebuffer: &mut [u8]) {
    let &View { r2, k2, width, cx, cy, k1x, k1y, .. } = view;
    let torus = Torus { r2, axis: axis(a, b) };
    let outline_radius = outline_radius(r2, k2);
    let dx_per_column = 1.0 / k1x;
    for (row, line) in framebuffer.chunks_exact_mut(width).enumerate() {
        // A ray can hit only inside the outline of the bounding sphere, where dx^2 + dy^2 is at most
        // `outline_radius`^2. In this row, that is from cx - half_width to cx + half_width. (Above and below
        // the outline, half_width is 0: one cell is left, and its ray misses.)
        let dy = (row as f64 + 0.5 - cy) / k1y;
        let half_width = (outline_radius * outline_radius - dy * dy).max(0.0).sqrt() * k1x;
        let (start, end) = ((cx - half_width) as usize, width.min((cx + half_width) as usize + 1));
        // The last group of rays may reach beyond `end`, where there is no cell for them.
        for (i, cells) in line[start..end].chunks_mut(8).enumerate() {
            let x = (start + 8 * i) as f64 + f64x8::new([0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]);
            let rays = torus.rays((x - cx) * dx_per_column, dy, k2);
            let hits = torus.quartic(&rays).first_hits(torus.entry(&rays));
            // A comparison gives a mask: `any` asks whether it is true in any lane.
            if !hits.simd_lt(f64x8::splat(MISS)).any() {
                continue; // No luminance is needed.
            }
            let luminances = (torus.luminance(&rays, hits) + TIE_BIAS).to_array();
            for ((cell, hit), luminance) in cells.iter_mut().zip(hits.to_array()).zip(luminances) {
                if hit < MISS {
                    *cell = glyph(luminance);
                }
            }
        }
    }
}

/// The donut of one frame.
struct Torus {
    r2: f64,
    /// The axis of revolution n, of length 1.
    axis: [f64; 3],
}

/// The axis of the donut after the rotation: the essay's (X, Y, Z) for h = 0 and f = 1.
fn axis(a: f64, b: f64) -> [f64; 3] {
    let [(sin_a, cos_a), (sin_b, cos_b)] = [a, b].map(f64::sin_cos);
    [sin_a * sin_b, -sin_a * cos_b, cos_a]
}

/// Eight rays, reduced to the five numbers that decide where they hit one torus, and how bright the hits are.
///
/// A point of a ray is P = P0 + s U. U is the direction of the ray, of length 1. P0 is the point of the ray
/// that is nearest to the donut's centre, the origin, so P0 . U = 0. The number s says where on the ray P is:
/// s is 0 at P0, and negative on the viewer's side of it. With n for the axis, and `light` for the vector
/// (0, -1, -1), three quantities at P matter:
/// ```text
/// |P|^2   = d0^2 + s^2             the distance from the centre, squared; at P0, the distance is d0
/// f       = P.n = f0 + fu s        the distance from the plane of the ring, negative on one side
/// P.light = light0 + light_u s     which the luminance needs
/// ```
/// So f0 is P0.n, fu is U.n, and light0 and light_u are the same with `light` in place of n.
struct Rays {
    d0_squared: f64x8,
    f0: f64x8,
    fu: f64x8,
    light0: f64x8,
    light_u: f64x8,
}

impl Torus {
    /// The rays from the viewer at V = (0, 0, -K2) in the directions (dx, dy, 1): X / z is dx, and Y / z is
    /// dy.
    ///
    /// U is (dx, dy, 1) divided by its length. So U = Uz (dx, dy, 1), and Uz^2 (dx^2 + dy^2 + 1) = 1. P0 is V
    /// without its part along U, and V.U = -K2 Uz:
    /// ```text
    /// P0   = V - (V.U) U = (0, 0, -K2) + depth (dx, dy, 1)      where depth = K2 Uz^2, the depth of P0
    ///                    = depth (dx, dy, -(dx^2 + dy^2))       because K2 = depth (dx^2 + dy^2 + 1)
    /// d0^2 = |V|^2 - (V.U)^2 = K2^2 - K2^2 Uz^2 = K2 (K2 - depth) = K2 depth (dx^2 + dy^2)
    /// ```
    /// The last form subtracts nothing, so it loses no digits, however large K2 is.
    fn rays(&self, dx: f64x8, dy: f64, k2: f64) -> Rays {
        let [nx, ny, nz] = self.axis;
        let xy_squared = dx * dx + dy * dy;
        let uz = 1.0 / (1.0 + xy_squared).sqrt();
        let depth = k2 * uz * uz;
        Rays {
            d0_squared: k2 * depth * xy_squared,
            f0: depth * (dx * nx + dy * ny - xy_squared * nz),
            fu: uz * (dx * nx + dy * ny + nz),
            light0: depth * (xy_squared - dy),
            light_u: -uz * (dy + 1.0),
        }
    }

    /// The s where each ray enters the bounding sphere, whose radius is R1 + R2: no hit comes before it. For
    /// a ray that misses the sphere, any s will do. (`fast_max` is `max` for numbers other than NaN.)
    fn entry(&self, &Rays { d0_squared, .. }: &Rays) -> f64x8 {
        let sphere_radius = 1.0 + self.r2;
        -(sphere_radius * sphere_radius - d0_squared).fast_max(f64x8::ZERO).sqrt()
    }

    /// Each ray's G (see `Quartic`). Let h be the distance of P from the axis. The square of P's distance
    /// from the ring is (h - R2)^2 + f^2: 1 on the surface, more outside, and less inside. So G can be
    /// (h - R2)^2 + f^2 - 1 times anything positive, such as (h + R2)^2 + f^2 - 1, which is positive because
    /// R2 > 1. In the product, h appears only as h^2, a polynomial in s. With m = h^2 + f^2 + R2^2 - 1, or
    /// |P|^2 + R2^2 - 1:
    /// ```text
    /// G = (m - 2 R2 h) (m + 2 R2 h) = m^2 - 4 R2^2 h^2 = m^2 - 4 R2^2 (|P|^2 - f^2)
    ///   = (s^2 + m0)^2 - 4 R2^2 (d0^2 + s^2 - (f0 + fu s)^2)     where m0 = d0^2 + R2^2 - 1
    ///   = s^4 + 2 p s^2 + 2 q s + (p^2 + c)      so, comparing coefficients:
    /// p = m0 - 2 R2^2 (1 - fu^2)
    /// q = 4 R2^2 f0 fu
    /// c = m0^2 - p^2 - 4 R2^2 (d0^2 - f0^2)
    /// ```
    /// Because s is measured from P0, there is no s^3, and the coefficients stay small, however far away the
    /// viewer is.
    fn quartic(&self, &Rays { d0_squared, f0, fu, .. }: &Rays) -> Quartic {
        let r2_squared = self.r2 * self.r2;
        let m0 = d0_squared + r2_squared - 1.0;
        let p = m0 - 2.0 * r2_squared * (1.0 - fu * fu);
        let q = 4.0 * r2_squared * f0 * fu;
        let c = m0 * m0 - p * p - 4.0 * r2_squared * (d0_squared - f0 * f0);
        Quartic { p, q, c }
    }

    /// The luminance L of each hit: the dot product of the normal and `light`. For a miss, it means nothing.
    ///
    /// In the plane of the ring, the point nearest to P is P - f n, at distance h from the centre. The
    /// nearest point of the ring lies in the same direction, at distance R2 from the centre. It is the middle
    /// of the tube there, and the normal leads from it to P:
    /// ```text
    /// normal = P - (R2 / h) (P - f n) = (1 - R2 / h) (P - f n) + f n
    /// L      = (1 - R2 / h) (P.light - f (n.light)) + f (n.light)
    /// ```
    /// As P is 1 away from the ring, (h - R2)^2 + f^2 = 1; and h^2 + f^2 = |P|^2. Subtract one from the other
    /// to get h: 2 R2 h = |P|^2 + R2^2 - 1.
    fn luminance(&self, rays: &Rays, s: f64x8) -> f64x8 {
        let r2_squared = self.r2 * self.r2;
        let f = rays.f0 + rays.fu * s;
        let p_dot_light = rays.light0 + rays.light_u * s;
        let n_dot_light = -(self.axis[1] + self.axis[2]);
        let r2_over_h = 2.0 * r2_squared / (rays.d0_squared + s * s + r2_squared - 1.0);
        (1.0 - r2_over_h) * (p_dot_light - f * n_dot_light) + f * n_dot_light
    }
}

/// Each ray's quartic G: a polynomial in s, which is 0 where the ray meets the surface, positive outside the
/// donut, and negative inside. In this form, G is a square plus a linear function, which `first_hits` needs:
/// ```text
/// G(s) = (s^2 + p)^2 + 2 q s + c
/// ```
struct Quartic {
    p: f64x8,
    q: f64x8,
    c: f64x8,
}

/// The s of a ray that misses the donut.
const MISS: f64 = f64::INFINITY;

/// A step no longer than this, in units of R1, is the last one of a search. It decides how far outside the
/// surface a search may end: see `first_hits`. This is the largest power of ten with which, in the tests,
/// every hit is within 1e-13 (1 + R2) of the surface.
const TOLERANCE: f64 = 1e-7;

impl Quartic {
    /// The s of each ray's first hit, or `MISS`.
    ///
    /// All of the donut is in front of the viewer, so the first hit is the first root of G. The search starts
    /// at `entry`, which no root precedes, and only steps to the right. At each s, a parabola (colons) starts
    /// at the height of G (stars) and, from there on, is nowhere above G. The search steps to r, the first
    /// root of the parabola right of s. Before r, both are positive: except for rounding, no root is passed,
    /// and G is not negative at r.
    /// ```text
    ///         *                                                        * :
    ///          *                                                      *  :
    ///           s                ************                         * :  G
    ///            *            ***            ***                     * :
    ///             **       ***                  **                   *:
    ///              :*******                       **                *:
    ///      ---------r:-------------------------------**-------------*:------>
    ///                :                                *           *:
    ///                 :                                ***       *
    ///                  :                                  *******
    /// ```
    /// For a step to s + t, let base = s^2 + p, and w = (s + t)^2 - s^2:
    /// ```text
    /// G(s + t) = (base + w)^2 + 2 q (s + t) + c
    ///         >= base^2 + 2 base w + 2 q (s + t) + c         because w^2 >= 0
    ///          = g + 2 (2 base s + q) t + 2 base t^2         where g = G(s), as w = 2 s t + t^2
    ///         >= g - 2 fall t + 2 base t^2                   where fall = max(-2 base s - q, 0), as t >= 0
    /// ```
    /// The last line is the parabola. `fall` is half the slope at which G falls. Where G falls, only w^2 is
    /// left out: the parabola has G's value and slope at s, and touches G again where w is 0, at -s. Where G
    /// rises, its slope is left out as well, because with it, the sum below would be a difference, and lose
    /// digits. That costs some steps, but no root.
    ///
    /// If g > 0, division by t^2 makes the parabola a quadratic in 1/t. The first root right of s has the
    /// largest 1/t, which is `(fall + sqrt(fall^2 - 2 base g)) / g`.
    ///
    /// A search ends in one of three ways:
    /// - g > 0, and the parabola has no root right of s, so G has none: r is infinite, and the ray misses.
    /// - g is 0, or negative by rounding: r is not right of s, or NaN, which `max` ignores. The hit is at s.
    /// - The step is at most TOLERANCE. The hit is at r. (It may be a graze: G comes so near 0, and turns.)
    ///
    /// It does end: all other steps are longer than TOLERANCE, and far enough beyond the donut, base > 0 and
    /// fall = 0, so that the parabola has no root.
    ///
    /// How far outside the surface is the point P of the third ending? Let D be the square of its distance
    /// from the ring, minus 1, so that P is about D / 2 outside. If G falls at s:
    /// ```text
    /// G(r) = D (D + 4 R2 h)                                         as G = (m - 2 R2 h) (m + 2 R2 h), and
    ///                                                               m = |P|^2 + R2^2 - 1 = 2 R2 h + D
    /// G(r) = w^2 = (r - s)^2 (r + s)^2 <= about TOLERANCE^2 4 r^2   because the parabola is 0 at r
    /// r^2 <= |P|^2 = 2 R2 h + D - (R2^2 - 1) < 2 R2 h + D           by the definition of D
    /// D <= 4 TOLERANCE^2 (2 R2 h + D) / (4 R2 h + D)                from the three lines above
    /// ```
    /// The fraction is at most 1, so D is tiny. Then the fraction is about 1/2, so D is at most about
    /// 2 TOLERANCE^2.
    ///
    /// If G does not fall at s, then g <= -2 base TOLERANCE^2. As G has not been negative before s, it curves
    /// upward where it is so small: G'' = 8 s^2 + 4 base >= 0, about. So g <= 4 s^2 TOLERANCE^2, and as
    /// above, D is at most about 2 TOLERANCE^2 at s. At r, the parabola is 0, so G is what it leaves out:
    /// w^2, and the step times G's slope, which is at most sqrt(2 G'' g). Each of these is at most about
    /// 4 s^2 TOLERANCE^2, so there, D is at most about 4 TOLERANCE^2.
    ///
    /// Near a simple root, the search is as fast as Newton's method. Usually it takes three or four steps, as
    /// counted in the study in tests/chart. But for rays made to have a multiple root, it may take more than
    /// a thousand, and rounding may end it up to 0.1 along the ray from the root, with 8 L off by less than
    /// 0.05. A graze may or may not count as a hit.
    fn first_hits(&self, entry: f64x8) -> f64x8 {
        let mut s = entry;
        loop {
            let r = self.parabola_root(s);
            let goes_on = r.simd_gt(s + TOLERANCE) & r.simd_lt(f64x8::splat(MISS));
            if !goes_on.any() {
                return s.max(r);
            }
            // `select` takes r in the lanes whose search goes on. The others stay at their s, so that no ray
            // depends on its neighbours.
            s = goes_on.select(r, s);
        }
    }

    /// If g > 0, the first root of the parabola right of s, or infinity. Otherwise no place right of s, or
    /// NaN.
    fn parabola_root(&self, s: f64x8) -> f64x8 {
        let &Quartic { p, q, c } = self;
        let base = s * s + p;
        let g = base * base + (2.0 * q * s + c);
        let fall = (-2.0 * base * s - q).fast_max(f64x8::ZERO);
        let discriminant = fall * fall - 2.0 * base * g;
        let has_root = discriminant.simd_ge(f64x8::ZERO);
        // Without a root, or if base and fall are 0, the divisor is 0: if g > 0, the quotient is infinite.
        s + g / has_root.select(fall + discriminant.sqrt(), f64x8::ZERO)
    }
}

// ---- Options -------------------------------------------------------------------------------------

/// A spinning ASCII donut for your terminal, after donut.c, a C program of 2006
///
/// The donut fills the window, and spins until you press q. In a window of 80x24
/// it is donut.c's own picture, which has 80x22 characters.
///
/// In a pipe or a file, donut writes frames as donut.c does, escape codes
/// included. By default these are 80x22; Ctrl-C ends them.
#[derive(Parser)]
#[command(name = "donut", version, verbatim_doc_comment)]
#[command(after_help = KEYS, after_long_help = format!("{KEYS}\n\n{EXAMPLES}"))]
// A later option overrides an earlier one, such as one from `alias donut='donut --color cyan'`.
#[command(args_override_self = true)]
// A number such as -5 is a value, even where it is refused. (For clap, -.5, -1e-3 and -1,2 are no numbers, so
// the angles also allow hyphens.) Completions must not offer file names as values.
#[command(mut_args(|option| option.allow_negative_numbers(true).value_hint(ValueHint::Other)))]
struct Options {
    /// Frames per second; 0 means no limit
    ///
    /// From 0 to 1000. Higher is smoother, not faster (see --spin); 0 spins
    /// as fast as it can. Pipes and files get frames at the same rate.
    #[arg(long, help_heading = "Motion", value_name = "N", verbatim_doc_comment)]
    #[arg(default_value = "30", value_parser = within("a number", 0.0..=1000.0))]
    fps: f64,

    /// Stop after N frames; the last one stays on the screen
    ///
    /// From 0 to 1000000000. On a terminal, what was on the screen scrolls
    /// up, and the prompt comes below the last frame.
    #[arg(long, help_heading = "Motion", value_name = "N", verbatim_doc_comment)]
    #[arg(value_parser = within("an integer", 0..=1_000_000_000_u32))]
    frames: Option<u32>,

    /// Speed, in radians per frame [default: 0.04,0.02]
    ///
    /// DA is added to the angle A, and DB to B. Both are from -1000 to 1000.
    /// Half of both is half as fast. The default is for 30 frames a second:
    /// without --spin, the speed is the same at any --fps but 0. With it,
    /// doubling --fps doubles the speed.
    #[arg(long, help_heading = "Motion", value_name = "DA,DB", verbatim_doc_comment)]
    #[arg(alias = "speed", value_parser = parse_angles, allow_hyphen_values = true)]
    spin: Option<[f64; 2]>,

    /// Starting angle A, the tilt, in radians
    ///
    /// At 0, you look straight through the hole. A tilts the donut about the
    /// horizontal; at 1.57, you see it from the side.
    /// From -2000000 to 2000000.
    #[arg(short = 'A', help_heading = "Motion", value_name = "RAD", verbatim_doc_comment)]
    #[arg(default_value = "0", value_parser = within("an angle in radians", ANGLES), allow_hyphen_values = true)]
    a: f64,

    /// Starting angle B, clockwise, in radians
    ///
    /// After the tilt by A, B turns the donut clockwise.
    /// From -2000000 to 2000000.
    #[arg(short = 'B', help_heading = "Motion", value_name = "RAD", verbatim_doc_comment)]
    #[arg(default_value = "0", value_parser = within("an angle in radians", ANGLES), allow_hyphen_values = true)]
    b: f64,

    /// classic (grainy, as in 2006) or exact (smooth)
    /// [default: classic for donut.c's 80x22, else exact]
    ///
    /// classic plots many points, as donut.c does, and shows the nearest in
    /// each character. It needs --r2 2 and --k2 5. exact follows a ray
    /// through the middle of each character. The default is classic for
    /// donut.c's picture (80x22, default --r2, --k2 and --aspect), and exact
    /// for all others.
    #[arg(long, help_heading = "Look", value_enum, ignore_case = true, verbatim_doc_comment)]
    #[arg(hide_possible_values = true)]
    method: Option<Method>,

    /// Colour: a name, such as cyan, or 0 to 255
    ///
    /// The names are black, dark_grey, grey, white, red, green, yellow, blue,
    /// magenta, cyan, dark_red, dark_green, dark_yellow, dark_blue,
    /// dark_magenta and dark_cyan. The numbers are those of the 256 colours
    /// that most terminals know; 208 is orange. You may also write --colour,
    /// and gray.
    #[arg(long, alias = "colour", help_heading = "Look", verbatim_doc_comment)]
    #[arg(value_parser = parse_color)]
    color: Option<u8>,

    /// Radius of the ring; 8 makes it a thin ring
    ///
    /// From 1.01 to 30. The ring is the circle in the middle of the tube, all
    /// round the hole. The tube's radius is 1, so larger is thinner.
    #[arg(long, help_heading = "Look", value_name = "R", verbatim_doc_comment)]
    #[arg(default_value_t = View::DONUT_C.r2, value_parser = within("a number", R2_RANGE))]
    r2: f64,

    /// Your distance from it [default: 5, scaled with --r2]
    ///
    /// At least 1.01 more than --r2, and at most 1000000. The default is
    /// 5 (1 + R) / 3 with --r2 R. From farther away, the perspective is
    /// flatter. Except in donut.c's picture, the donut is scaled so that it
    /// is never cut off: from very near, most of the time it is only a few
    /// characters.
    #[arg(long, help_heading = "Look", value_name = "D", verbatim_doc_comment)]
    #[arg(value_parser = within("a number at least 1.01 more than --r2, and", K2_RANGE))]
    k2: Option<f64>,

    /// Columns [default: all; in a pipe, 80]
    ///
    /// From 1 to 4096. On a terminal, at most its columns.
    #[arg(long, help_heading = "Size", value_name = "COLS")]
    #[arg(value_parser = within("an integer", 1..=MAX_SIZE))]
    width: Option<u16>,

    /// Rows [default: all but 1; at 80x24 or in a pipe, 22]
    ///
    /// From 1 to 4096. On a terminal, at most its rows minus 1, because the
    /// cursor needs one, but at least 1.
    #[arg(long, help_heading = "Size", value_name = "ROWS", verbatim_doc_comment)]
    #[arg(value_parser = within("an integer", 1..=MAX_SIZE))]
    height: Option<u16>,

    /// Height of a character divided by its width
    /// [default: the terminal's, or 2]
    ///
    /// From 0.1 to 10. If the donut is not round, try 1.8 or 2.2.
    #[arg(long, help_heading = "Size", value_name = "RATIO", verbatim_doc_comment)]
    #[arg(value_parser = within("a number", ASPECTS))]
    aspect: Option<f64>,
}

const KEYS: &str = "Keys (letters in either case):
  q, Esc, Ctrl-C  quit (in a pipe, only Ctrl-C)
  space, p        pause or resume
  arrow keys      turn it: up and down tilt, left and right swing
  +, -            spin faster or slower
  c               next of seven bright colours
  m               switch the method (needs default --r2 and --k2)
  s               shading off (a flat shape of dots) or on
  Ctrl-L          redraw the screen
  Ctrl-Z          suspend (not on Windows)";

const EXAMPLES: &str = "Examples:
  donut --fps 60 --color cyan     # smoother, and in colour
  donut --spin 0,0                # stands still until an arrow key turns it
  donut --r2 8 --spin 0.01,0.005  # a thin ring that spins slowly
  donut --frames 1 | tail -c +8 > donut.txt   # plain text, without --color";

const MAX_SIZE: u16 = 4096;
// Every frame of donut.c can be asked for: its A stops growing at 2^20, and its B at 2^19.
const ANGLES: RangeInclusive<f64> = -2e6..=2e6;
const SPINS: RangeInclusive<f64> = -1e3..=1e3;
const ASPECTS: RangeInclusive<f64> = 0.1..=10.0;
/// The least K2 - R2. When the donut is edge-on, the ring comes this near to the viewer, and the tube,
/// nearer by R1, within 0.01.
const NEAREST: f64 = 1.01;
// Beyond these, the hole or the tube is too small to see in most pictures.
const R2_RANGE: RangeInclusive<f64> = 1.01..=30.0;
const K2_RANGE: RangeInclusive<f64> = *R2_RANGE.start() + NEAREST..=1e6;

/// A parser for the numbers in a range.
fn within<T: Copy + Display + FromStr + PartialOrd>(
    kind: &str,
    range: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("expected {kind} from {} to {}", range.start(), range.end()))
    }
}

fn parse_angles(text: &str) -> Result<[f64; 2], String> {
    let angle = |text: &str| within("a number", SPINS)(text.trim()).ok();
    let angles = text.split_once(',').and_then(|(a, b)| Some([angle(a)?, angle(b)?]));
    let (least, most) = (SPINS.start(), SPINS.end());
    angles.ok_or_else(|| format!("expected two numbers from {least} to {most}, such as 0.04,0.02"))
}

/// The names of colours 0 to 15.
const COLORS: &str = "black, dark_red, dark_green, dark_yellow, dark_blue, dark_magenta, dark_cyan, grey, \
    dark_grey, red, green, yellow, blue, magenta, cyan, white";

fn parse_color(text: &str) -> Result<u8, String> {
    let name = text.to_lowercase().replace("gray", "grey").replace(['-', ' '], "_");
    let named = COLORS.split(", ").position(|color| color == name).map(|number| number as u8);
    let number = named.or_else(|| text.parse().ok());
    number.ok_or_else(|| format!("expected a number from 0 to 255, or one of {COLORS}"))
}

/// The terminal's size, and the aspect of its cells.
#[derive(Clone, Copy, PartialEq)]
struct Window {
    columns: u16,
    rows: u16,
    aspect: f64,
}

/// What a pipe counts as, and a terminal that does not know its size.
const USUAL_WINDOW: Window = Window { columns: 80, rows: 24, aspect: View::ASPECT };

impl Options {
    /// By default, the viewer is as far away as in donut.c, compared with the size of the donut.
    fn k2(&self) -> f64 {
        self.k2.unwrap_or(View::DONUT_C.k2 * (1.0 + self.r2) / (1.0 + View::DONUT_C.r2))
    }

    /// donut.c turns by the frame. By default, the donut spins at every rate as fast as at 30 frames a
    /// second.
    fn spin(&self) -> [f64; 2] {
        let times = if self.fps > 0.0 { 30.0 / self.fps } else { 1.0 };
        self.spin.unwrap_or([0.04 * times, 0.02 * times])
    }

    /// Whether `classic` can draw this: with other lengths, its steps may be too long (see `angle_steps`).
    fn fits_classic(&self) -> bool {
        (self.r2, self.k2()) == (View::DONUT_C.r2, View::DONUT_C.k2)
    }

    /// What is wrong with --k2 or --method, whose rules depend on other options.
    fn conflict(&self) -> Option<String> {
        let (r2, k2, c) = (self.r2, self.k2(), View::DONUT_C);
        // 1e-9, because in binary, the difference of two decimals may be a little too small.
        if k2 - r2 < NEAREST - 1e-9 {
            return Some(format!("--k2 must be at least {NEAREST} more than --r2, which is {r2}"));
        }
        let is_refused = self.method == Some(Method::Classic) && !self.fits_classic();
        is_refused.then(|| format!("--method classic needs --r2 {} and --k2 {}", c.r2, c.k2))
    }

    /// The view for a window, which limits the size of the picture. `None` stands for a pipe, or for a
    /// terminal that does not know its size: nothing limits it.
    fn view(&self, window: Option<Window>) -> View {
        let Window { columns, rows, aspect } = window.unwrap_or(USUAL_WINDOW);
        // The cursor needs the last row. At 80x24, donut.c's picture leaves another one free.
        let free_rows = rows.saturating_sub(1).max(1);
        let default_height = if (columns, rows) == (80, 24) { 22 } else { free_rows };
        let [max_width, max_height] =
            if window.is_some() { [columns, free_rows] } else { [MAX_SIZE; 2] };
        let width = self.width.unwrap_or(columns).min(max_width).min(MAX_SIZE);
        let height = self.height.unwrap_or(default_height).min(max_height).min(MAX_SIZE);
        // donut.c's picture begins with a newline, so it needs 24 rows. It is the same in every font.
        let is_usual_aspect = self.aspect.is_none_or(|aspect| aspect == View::ASPECT);
        if (width, height) == (80, 22) && rows >= 24 && self.fits_classic() && is_usual_aspect {
            return View::DONUT_C;
        }
        let aspect = self.aspect.unwrap_or(aspect);
        View::fitted(width.into(), height.into(), aspect, self.r2, self.k2())
    }

    /// By default, classic draws donut.c's own picture, and exact draws all others.
    fn renderer(&self, window: Option<Window>, method: Option<Method>) -> Renderer {
        let view = self.view(window);
        let default = if view == View::DONUT_C { Method::Classic } else { Method::Exact };
        Renderer::new(view, method.unwrap_or(default))
    }
}

// ---- main and the loop ---------------------------------------------------------------------------

fn main() -> process::ExitCode {
    let options = Options::parse();
    if let Some(conflict) = options.conflict() {
        Options::command().error(ErrorKind::ValueValidation, conflict).exit()
    }
    match run(&options) {
        // A reader that goes away, as in `donut | head`, has seen enough.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            let _ = writeln!(io::stderr(), "donut: {error}");
            process::ExitCode::FAILURE
        }
        _ => process::ExitCode::SUCCESS,
    }
}

/// Spins the donut until the last frame is drawn, a key or a signal ends it, or its output cannot be written.
fn run(options: &Options) -> io::Result<()> {
    style::force_color_output(true); // --color is explicit, so it overrides NO_COLOR.
    if !io::stdout().is_terminal() {
        return play(options, None);
    }
    if env::var_os("TERM").is_some_and(|name| name == "dumb") {
        return Err(io::Error::other("TERM is dumb, but the picture needs escape codes"));
    }
    let uses_alternate_screen = options.frames.is_none();
    let terminal = Terminal::new(uses_alternate_screen)?;
    let played = play(options, Some(&terminal));
    let restored = leave(uses_alternate_screen);
    match terminal.end_signal() {
        Some(signal) => end_by(signal), // Whatever `play` has returned.
        None => played.and(restored),
    }
}

/// donut.c's `for (;;)`. Each iteration waits until the next frame is due, and then draws it. On a terminal,
/// the wait also ends after a second, or at a key, a new size or another signal, and the current frame may
/// have to be drawn again.
fn play(options: &Options, terminal: Option<&Terminal>) -> io::Result<()> {
    // 0 means no limit. If --fps is tiny, a Duration cannot hold the seconds. 1e9, nearly 32 years, will do.
    let seconds = if options.fps > 0.0 { f64::min(1.0 / options.fps, 1e9) } else { 0.0 };
    let interval = Duration::from_secs_f64(seconds);
    let mut show = Show::new(options);
    let mut frame_count: u64 = 0;
    let mut due = Instant::now();

    while options.frames.is_none_or(|frames| frame_count < frames.into()) {
        let until_due = due.saturating_duration_since(Instant::now());
        let mut redraw = false;
        if let Some(terminal) = terminal {
            let keys = terminal.keys(if show.is_paused { Duration::MAX } else { until_due })?;
            redraw = !keys.is_empty(); // Any key redraws, which does no harm.
            for key in keys {
                match key {
                    'q' | 'Q' | '\x1b' => return Ok(()), // \x1b is Esc.
                    #[cfg(unix)] // Ctrl-C, Ctrl-\ and Ctrl-Z.
                    '\x03' | '\x1c' | '\x1a' => {
                        terminal.send_signal(key)?;
                        break; // Keys that were read after it are dropped.
                    }
                    _ => show.obey(key),
                }
            }
            show.clear |= terminal.was_resized.swap(false, SeqCst); // Even if the old size is back.
            show.clear |= terminal.ensure_entered()?;
            if terminal.end_signal().is_some() {
                return Ok(());
            }
            show.fit(terminal.window()?);
        } else {
            thread::sleep(until_due);
        }

        let is_due = !show.is_paused && due <= Instant::now();
        if is_due {
            if frame_count > 0 {
                show.advance();
            }
            frame_count += 1;
            // Each frame is due one interval after the one before was due, so that delays do not add up. But
            // after a stall, the next is due now, so that the missed frames do not come in a burst.
            due = (due + interval).max(Instant::now());
        }
        if is_due || redraw || show.clear {
            let frame = show.encode_frame(terminal.is_some())?;
            io::stdout().write_all(&frame)?; // The newline at the end flushes it.
        }
    }
    Ok(())
}

/// What is shown: at first, what the options say.
struct Show<'a> {
    options: &'a Options,
    /// The window that the picture is fitted into, if it is known.
    window: Option<Window>,
    renderer: Renderer,
    /// What --method or a key has chosen, if anything: see `Options::renderer`.
    method: Option<Method>,
    /// A and B of the current frame.
    angles: [f64; 2],
    /// The donut spins 1.25^speed times as fast as the options say.
    speed: i32,
    color: Option<u8>,
    is_paused: bool,
    is_shaded: bool,
    /// Whether to clear the screen before the next frame.
    clear: bool,
}

impl<'a> Show<'a> {
    fn new(options: &'a Options) -> Show<'a> {
        Show {
            options,
            window: None,
            renderer: options.renderer(None, options.method),
            method: options.method,
            angles: [options.a, options.b],
            speed: 0,
            color: options.color,
            is_paused: false,
            is_shaded: true,
            clear: true, // donut.c, too, begins by clearing the screen.
        }
    }

    /// Obeys a key that changes what is shown. Other keys do nothing.
    fn obey(&mut self, key: char) {
        match key {
            ' ' | 'p' | 'P' => self.is_paused = !self.is_paused,
            '↑' => self.angles = turned(self.angles, 0.0, -0.1),
            '↓' => self.angles = turned(self.angles, 0.0, 0.1),
            '←' => self.angles = turned(self.angles, -0.1, 0.0),
            '→' => self.angles = turned(self.angles, 0.1, 0.0),
            // = is often + without Shift.
            '+' | '=' => self.speed = i32::min(self.speed + 1, 20),
            '-' => self.speed = i32::max(self.speed - 1, -20),
            // The bright colours are 8 to 15, and 8 is a bright black.
            'c' | 'C' => {
                self.color = match self.color {
                    Some(number @ 9..15) => Some(number + 1),
                    _ => Some(9),
                }
            }
            'm' | 'M' if self.options.fits_classic() => {
                let is_classic = self.renderer.classic.is_some();
                self.method = Some(if is_classic { Method::Exact } else { Method::Classic });
                self.renderer = self.options.renderer(self.window, self.method);
            }
            's' | 'S' => self.is_shaded = !self.is_shaded,
            '\x0c' => self.clear = true, // Ctrl-L.
            _ => {}
        }
    }

    /// Fits the picture into a window.
    fn fit(&mut self, window: Option<Window>) {
        if window != self.window {
            self.window = window;
            self.renderer = self.options.renderer(window, self.method);
            self.clear = true;
        }
    }

    /// Goes on to the next frame.
    fn advance(&mut self) {
        let faster = 1.25_f64.powi(self.speed);
        let spin = self.options.spin().map(|step| faster * step);
        self.angles = self.renderer.advance(self.angles, spin);
    }

    /// The bytes that show the current frame. The next frame need not clear the screen.
    fn encode_frame(&mut self, is_terminal: bool) -> io::Result<Vec<u8>> {
        let [a, b] = self.angles;
        self.renderer.render_frame(a, b);
        if !self.is_shaded {
            self.renderer.remove_shading();
        }
        let clear = mem::take(&mut self.clear);
        self.renderer.encode(self.color, is_terminal, clear)
    }
}

/// The angles A and B after the side that faces the viewer has been turned by an angle to the right, and by
/// one down. Negative angles turn it to the left, and up.
///
/// The donut looks the same however it is turned about its axis n, so it is n that is rotated: about y,
/// then about x. From the formula of n, see `axis`, A = atan2(hypot(nx, ny), nz) and B = atan2(nx, -ny).
/// But -A with B + pi gives the same n, and so do whole turns. Of all these pairs, this one is the nearest
/// to the old angles (less their own whole turns), so that the spin changes as little as it can. Where A is
/// near 0 or pi, B may jump.
fn turned(angles: [f64; 2], right: f64, down: f64) -> [f64; 2] {
    // Without whole turns, because f32, in which `classic` keeps its angles, is coarse where they are large.
    let [a, b] = angles.map(|angle| angle % TAU);
    // At the point that faces the viewer, x is 0 and z is negative, so it moves to the right, or down.
    let rotate = |x: f64, z: f64, (sin, cos)| (x * cos - z * sin, x * sin + z * cos);
    let [nx, ny, nz] = axis(a, b);
    let (nx, nz) = rotate(nx, nz, right.sin_cos());
    let (ny, nz) = rotate(ny, nz, down.sin_cos());
    let (new_a, new_b) = (f64::hypot(nx, ny).atan2(nz), nx.atan2(-ny));
    let nearest = |new: f64, old: f64| new + ((old - new) / TAU).round() * TAU;
    let pairs = [[new_a, new_b], [-new_a, new_b + PI]];
    let [one, other] = pairs.map(|[new_a, new_b]| [nearest(new_a, a), nearest(new_b, b)]);
    let distance = |[new_a, new_b]: [f64; 2]| f64::hypot(new_a - a, new_b - b);
    if distance(one) <= distance(other) { one } else { other }
}

// ---- Terminal ------------------------------------------------------------------------------------

// To *enter* the terminal is to set three things: raw mode, in which each key is sent at once, is not
// echoed, and sends no signal; the alternate screen, a second screen for programs that fill it; and a
// hidden cursor. To *leave* it is to undo these. crossterm knows whether raw mode is set, and so whether the
// program has entered.
//
// A *job* is what a shell runs as one command, with all its processes: a process group. One job at a time
// is in the *foreground*: it has the terminal. The others are in the *background*, and if one of them reads
// keys or changes settings there, the system stops it, by SIGTTIN or SIGTTOU. The shell's `fg` gives a
// stopped job the terminal and resumes it, by SIGCONT; `bg` only resumes it. A job that no shell can resume
// (an *orphaned* process group) is stopped only by SIGSTOP.
//
// All this is done in the main thread. The handlers of signals only store a number or a flag. (ctrlc's wakes
// a thread of its own, which does so.) A signal also interrupts the wait for keys; if it comes just before,
// or in ctrlc's thread, the loop sees it within a second.
//
// What ends the program, and the exit status that a shell then reports:
// - q, Esc or the last frame: the loop ends, and `run` leaves. 0.
// - An error: the same, and `main` shows the message. 1.
// - SIGINT, SIGTERM, SIGHUP or SIGQUIT: the loop ends, `run` leaves, and ends the program by the signal. 130,
//   143, 129 or 131. (Where the terminal takes no output, the loop is in a write, and the signal waits, like
//   any key, until the whole frame is written.)
// - Ctrl-C and Ctrl-\ are keys. The loop leaves, sends the job SIGINT or SIGQUIT, and ends as above. (On
//   Windows, Ctrl-C is a q.)
// - The terminal is gone: by SIGHUP, 129. If none comes, the loop finds out within a second: an error, 1.
// - A panic: its hook leaves, and shows the message; then the main thread unwinds. 101.
//
// What stops the program, until `fg`:
// - Ctrl-Z is a key. The loop leaves, stops the job, and enters again (at once if no shell can resume it).
// - SIGSTOP and SIGTSTP stop the program as it is, without leaving. Once it is in the foreground again, the
//   loop leaves and enters.
// - In the background, the loop stops the job before it enters, or begins a frame. If no shell can resume
//   the job, this is an error.

struct Terminal {
    /// With --frames, the alternate screen is not used, because the last frame has to stay.
    uses_alternate_screen: bool,
    /// The terminal that keys come from, opened again: see `Terminal::open_tty`.
    #[cfg(unix)]
    tty: OwnedFd,
    /// The number of the last signal that has asked the program to end, or 0.
    last_signal: Arc<AtomicUsize>,
    /// Set by SIGCONT: the program has been resumed.
    was_resumed: Arc<AtomicBool>,
    /// Set by SIGWINCH: the window has a new size.
    was_resized: Arc<AtomicBool>,
}

impl Terminal {
    fn new(uses_alternate_screen: bool) -> io::Result<Terminal> {
        let previous_hook = panic::take_hook();
        panic::set_hook(Box::new(move |info| {
            let _ = leave(uses_alternate_screen);
            previous_hook(info);
        }));
        let terminal = Terminal {
            uses_alternate_screen,
            #[cfg(unix)]
            tty: Terminal::open_tty()?,
            last_signal: Default::default(),
            was_resumed: Default::default(),
            was_resized: Default::default(),
        };
        terminal.handle_signals()?;
        if !io::stdin().is_terminal() {
            // Without a terminal as input, crossterm sets raw mode on the controlling terminal. Keys have to
            // come from that one: for any other, this fails.
            #[cfg(unix)]
            termios::tcgetpgrp(keyboard()).map_err(no_keys)?;
            // `(donut &)` starts in the foreground, with /dev/null as input, and a moment later, the shell
            // takes the terminal back. If the program had entered by then, the shell would take raw mode for
            // the user's own settings.
            thread::sleep(Duration::from_millis(50));
        }
        Ok(terminal)
    }

    fn handle_signals(&self) -> io::Result<()> {
        // ctrlc replaces a handler that it finds, and signal-hook adds to it, so ctrlc comes first. 2 is
        // SIGINT, whose name is imported only on Unix.
        let last = self.last_signal.clone();
        ctrlc::set_handler(move || last.store(2, SeqCst)).map_err(io::Error::other)?;
        #[cfg(unix)]
        {
            // SIGINT, too, because ctrlc's thread may come late.
            for signal in [SIGHUP, SIGINT, SIGQUIT, SIGTERM] {
                flag::register_usize(signal, self.last_signal.clone(), signal as usize)?;
            }
            flag::register(SIGCONT, self.was_resumed.clone())?;
            flag::register(SIGWINCH, self.was_resized.clone())?;
        }
        Ok(())
    }

    /// The signal that has asked the program to end.
    fn end_signal(&self) -> Option<i32> {
        Some(self.last_signal.load(SeqCst) as i32).filter(|&signal| signal != 0)
    }

    /// `None` if the terminal does not know its size. Fails if the terminal is gone.
    fn window(&self) -> io::Result<Option<Window>> {
        // crossterm's `window_size` opens the terminal each time, and on Windows, it always fails.
        #[cfg(unix)]
        let (columns, rows, pixels) = termios::tcgetwinsize(stdio::stdout())
            .map(|size| (size.ws_col, size.ws_row, (size.ws_xpixel, size.ws_ypixel)))?;
        #[cfg(windows)]
        let ((columns, rows), pixels) = (term::size()?, (0, 0));
        let aspect = cell_aspect((columns, rows), pixels);
        Ok((columns > 0 && rows > 0).then_some(Window { columns, rows, aspect }))
    }

    /// Enters at the start, after Ctrl-Z, and after another stop, but not if a signal asks the program to
    /// end. Says whether it has entered, because all has to be drawn again then.
    fn ensure_entered(&self) -> io::Result<bool> {
        #[cfg(unix)]
        self.wait_for_foreground()?;
        let inside = term::is_raw_mode_enabled()?;
        let resumed = self.was_resumed.swap(false, SeqCst);
        if self.end_signal().is_some() || (inside && !resumed) {
            return Ok(false);
        }
        let mut stdout = io::stdout().lock();
        if inside {
            // The program was stopped before it could leave. The shell may have changed the settings, but
            // crossterm would not set raw mode twice, and some terminals forget the shell's cursor if the
            // alternate screen is entered twice. The screen may be the shell's, so it is not cleared here.
            if self.uses_alternate_screen {
                queue!(stdout, term::LeaveAlternateScreen)?;
            }
            term::disable_raw_mode()?;
        }
        term::enable_raw_mode().map_err(no_keys)?;
        // If another program has made the terminal nonblocking, a write would fail instead of waiting. (When
        // the program leaves, it stays blocking.)
        #[cfg(unix)]
        fcntl_setfl(stdio::stdout(), fcntl_getfl(stdio::stdout())? - OFlags::NONBLOCK)?;
        if self.uses_alternate_screen {
            queue!(stdout, term::EnterAlternateScreen)?;
        } else if let Some(window) = self.window()? {
            // What is on the screen scrolls up into the scrollback.
            queue!(stdout, Print("\r\n".repeat(window.rows.into())))?;
        }
        // `ESC [ r` removes scroll margins that another program has left. They would cut the picture.
        execute!(stdout, Print("\x1b[r"), cursor::Hide)?;
        Ok(true)
    }
}

/// What may stand in the code of a key before its last letter: digits and punctuation.
#[cfg(unix)]
const PARAMETERS: RangeInclusive<u8> = b' '..=b'?';

#[cfg(unix)]
impl Terminal {
    /// Opens a second time, as nonblocking, the terminal that keys come from, because another program may
    /// take the keys between `poll` and `read`. (The first one, which the shell shares, must stay blocking.)
    ///
    /// The name is that of the terminal, because macOS's `poll` does not know /dev/tty. After `su`, the
    /// terminal is another user's, and cannot be opened. Then the first one is read, where reading may wait.
    fn open_tty() -> io::Result<OwnedFd> {
        termios::ttyname(keyboard(), Vec::new())
            .and_then(|name| open(&name, OFlags::NONBLOCK | OFlags::NOCTTY, Mode::empty()))
            .or_else(|_| keyboard().try_clone_to_owned())
    }

    /// The keys that have been pressed: characters, and arrows for the arrow keys. Waits for one, but no
    /// longer than `timeout`, and not after a signal. (At least once a second, the loop looks whether a
    /// signal came, and whether the terminal is gone.) Keys that were typed ahead count, too.
    fn keys(&self, timeout: Duration) -> io::Result<Vec<char>> {
        let mut bytes = self.read(timeout.min(Duration::from_secs(1)))?;
        // Over a slow line, an arrow key's code may come in pieces, each a little later.
        while Terminal::ends_in_code(&bytes) {
            let more = self.read(Duration::from_millis(50))?;
            if more.is_empty() {
                break;
            }
            bytes.extend(more);
        }
        Ok(Terminal::parse_keys(&bytes))
    }

    /// What the terminal sends within this time. It is empty if that is nothing, or after a signal.
    fn read(&self, timeout: Duration) -> io::Result<Vec<u8>> {
        let timeout = timeout.try_into().map_err(io::Error::other)?;
        let ready = poll(&mut [PollFd::new(&self.tty, PollFlags::IN)], Some(&timeout));
        // In the background, reading would stop the job.
        if ready != Ok(1) || is_in_background() {
            return Ok(Vec::new());
        }
        let mut bytes = vec![0; 4096];
        let count = match read(&self.tty, &mut bytes) {
            // The terminal is gone. (Before raw mode, it may be a Ctrl-D that was typed ahead.)
            Ok(0) if term::is_raw_mode_enabled()? => {
                return Err(no_keys(io::ErrorKind::UnexpectedEof));
            }
            Err(Errno::AGAIN) => 0, // Another program has read them, or waits for them.
            count => count?,
        };
        bytes.truncate(count);
        Ok(bytes)
    }

    /// Whether the last bytes may be the beginning of an arrow key's code. (Esc alone may also be the Esc
    /// key. Three in a row are that key, held down; the wait for more might never end.)
    fn ends_in_code(bytes: &[u8]) -> bool {
        let last = bytes.iter().rposition(|&byte| byte == 0x1b);
        last.is_some_and(|last| match &bytes[last + 1..] {
            [b'[' | b'O', rest @ ..] => rest.iter().all(|byte| PARAMETERS.contains(byte)),
            rest => rest.is_empty() && !bytes.ends_with(b"\x1b\x1b\x1b"),
        })
    }

    /// The keys in what a terminal has sent. Each byte is a character, at most ÿ, so that a typed ↑ is not
    /// taken for the arrow key.
    fn parse_keys(bytes: &[u8]) -> Vec<char> {
        let (mut keys, mut bytes) = (Vec::new(), bytes.iter().copied().peekable());
        while let Some(byte) = bytes.next() {
            if byte != 0x1b {
                keys.push(byte.into());
                continue;
            }
            // A code ends with its last letter, or before a control character such as Ctrl-C, which is a key.
            match bytes.next_if(|byte| *byte >= b' ') {
                // The arrow keys send `ESC [ A` to `ESC [ D`, or with O in place of [. Before the letter,
                // there may be parameters, such as for Shift. Other letters are other keys, or answers of
                // the terminal.
                Some(b'[' | b'O') => {
                    while bytes.next_if(|byte| PARAMETERS.contains(byte)).is_some() {}
                    match bytes.next_if(|byte| *byte >= b' ') {
                        Some(letter @ b'A'..=b'D') => {
                            keys.push(['↑', '↓', '→', '←'][usize::from(letter - b'A')])
                        }
                        // On Linux's console, F1 to F5 send `ESC [ [ A` to `ESC [ [ E`.
                        Some(b'[') => _ = bytes.next_if(|byte| *byte >= b' '),
                        _ => {}
                    }
                }
                // Other answers are texts, which end with BEL or `ESC \`.
                Some(b'P' | b']' | b'_') => while bytes.next_if(|byte| *byte >= b' ').is_some() {},
                Some(_) => {} // Alt and a key.
                // At the end, the Esc key. Before a control character, such as another Esc, it is Alt.
                None if bytes.peek().is_none() => keys.push('\x1b'),
                None => {}
            }
        }
        keys
    }

    /// Ctrl-C, Ctrl-\ or Ctrl-Z: sends the job the signal that the terminal would send outside raw mode.
    /// Leaves first, because the signal also ends or stops the program that runs this one, such as xargs, and
    /// then the shell takes the terminal back.
    fn send_signal(&self, key: char) -> io::Result<()> {
        leave(self.uses_alternate_screen)?;
        if key == '\x1a' {
            return Ok(kill_current_process_group(Signal::TSTP)?);
        }
        let signal = if key == '\x03' { Signal::INT } else { Signal::QUIT };
        self.last_signal.store(signal.as_raw() as usize, SeqCst);
        Ok(kill_current_process_group(signal)?)
    }

    /// In the background, stops the job until the shell's `fg`, or until a signal asks the program to end.
    ///
    /// If the program entered here, crossterm would first save the shell's settings as those to restore, and
    /// only then would the system stop the job.
    fn wait_for_foreground(&self) -> io::Result<()> {
        while is_in_background() {
            // The shell may be about to give the job the terminal. Or it kills the job: most shells resume a
            // stopped job for that, and their signal comes a moment later.
            if becomes_true(|| self.end_signal().is_some() || !is_in_background()) {
                break;
            }
            self.was_resumed.store(false, SeqCst);
            kill_current_process_group(Signal::TTOU)?; // The job is stopped here, until SIGCONT.
            if !becomes_true(|| self.was_resumed.load(SeqCst)) {
                // It was not stopped: the system ignores the signal in a job that no shell can resume.
                return Err(io::Error::other("no shell can bring this job to the foreground"));
            }
        }
        Ok(())
    }
}

/// Waits until something is true, but no longer than a tenth of a second. (The handler of a signal may come
/// a little late, because the system may run it in ctrlc's thread.)
#[cfg(unix)]
fn becomes_true(condition: impl Fn() -> bool) -> bool {
    (0..10).any(|_| {
        thread::sleep(Duration::from_millis(10));
        condition()
    })
}

/// The terminal that keys come from: standard input's, which is the one that crossterm sets to raw mode, or
/// else standard output's.
#[cfg(unix)]
fn keyboard() -> BorrowedFd<'static> {
    if io::stdin().is_terminal() { stdio::stdin() } else { stdio::stdout() }
}

#[cfg(windows)]
impl Terminal {
    /// The key that has been pressed, as the character that it sends on Unix; for Ctrl-C, a q.
    fn keys(&self, timeout: Duration) -> io::Result<Vec<char>> {
        let has_event = event::poll(timeout.min(Duration::from_secs(1)))?;
        let key = if has_event { event::read()?.as_key_press_event() } else { None };
        Ok(Vec::from_iter(key.and_then(|key| {
            match (key.modifiers - KeyModifiers::SHIFT, key.code) {
                (KeyModifiers::CONTROL, KeyCode::Char('c')) => Some('q'),
                (KeyModifiers::CONTROL, KeyCode::Char('l')) => Some('\x0c'),
                (KeyModifiers::NONE, KeyCode::Char(letter)) => Some(letter),
                (_, KeyCode::Esc) => Some('\x1b'),
                (_, KeyCode::Up) => Some('↑'),
                (_, KeyCode::Down) => Some('↓'),
                (_, KeyCode::Left) => Some('←'),
                (_, KeyCode::Right) => Some('→'),
                _ => None,
            }
        })))
    }
}

/// Leaves the terminal, if the program has entered it.
fn leave(uses_alternate_screen: bool) -> io::Result<()> {
    if !term::is_raw_mode_enabled()? {
        return Ok(());
    }
    let mut bytes = Vec::new();
    if uses_alternate_screen {
        // After a change of size, tmux would copy what is there into the shell's screen. (In the background,
        // the screen may be the shell's.)
        if !is_in_background() {
            queue!(bytes, term::Clear(term::ClearType::All))?;
        }
        queue!(bytes, term::LeaveAlternateScreen)?;
    }
    queue!(bytes, cursor::Show)?;
    let mut stdout = io::stdout().lock();
    let written = stdout.write_all(&bytes).and_then(|()| stdout.flush());
    // In the background, it is for the shell to change the settings.
    if is_in_background() { written } else { term::disable_raw_mode().and(written) }
}

/// The aspect of a cell, from the size of the window in cells and in pixels, or 2 if these cannot be right.
fn cell_aspect((columns, rows): (u16, u16), (width, height): (u16, u16)) -> f64 {
    // In whole pixels, because some terminals count a border in. (0 / 0 is NaN, which is in no range.)
    let aspect = f64::from(height / rows.max(1)) / f64::from(width / columns.max(1));
    // OpenSSH for Windows says 640x480 of any window.
    if ASPECTS.contains(&aspect) && (width, height) != (640, 480) { aspect } else { View::ASPECT }
}

/// Whether another job of this session, such as the shell, has the terminal.
fn is_in_background() -> bool {
    #[cfg(unix)]
    return termios::tcgetpgrp(keyboard()).is_ok_and(|group| group != getpgrp());
    #[cfg(windows)]
    false
}

fn no_keys(error: impl Into<io::Error>) -> io::Error {
    io::Error::other(format!("cannot read keys from the terminal: {}", error.into()))
}

/// Ends the program by this signal, so that the shell or script that runs it can tell what ended it.
fn end_by(signal: i32) -> ! {
    // The first process of a container cannot end itself by a signal: the system ignores it.
    #[cfg(unix)]
    if process::id() != 1 {
        let _ = low_level::emulate_default_handler(signal);
    }
    process::exit(128 + signal) // What a shell would say of a program that the signal ended.
}

#[cfg(test)]
#[path = "../tests/unit/mod.rs"]
mod tests;
