//! donut.c, Andy Sloane's spinning ASCII torus of 2006. At 80x22 this draws donut.c's own picture. At
//! every other size, where donut.c's way makes errors, it computes each cell exactly.
//!
//! ```text
//! Options -> View -> render_frame(a, b) -> framebuffer -> Encoder -> terminal or pipe
//! ```
//!
//! # How donut.c draws a donut
//!
//! A torus is what a small circle, the tube, leaves behind when it goes round in a large one, the
//! ring. Here it is in the first frame, cut in two and seen from the side, with the viewer on the left:
//!
//! ```text
//!                                .-.
//!           screen              ( +-)--  R1, the radius of the tube
//!              |                 '-'
//!              |                  |
//!              |                  |      R2, the radius of the ring
//!              |                  |
//!  viewer  o---|------------------+---------->  z, the axis of the ring
//!          :   |                  |
//!          :   |                 .-.
//!          :   |                ( + )
//!          :   |                 '-'
//!          :.K1.                  :
//!          :......... K2 .........:
//! ```
//!
//! donut.c has R1 = 1, R2 = 2 and K2 = 5. K1 is 30 columns or 15 rows, for a cell of the screen is
//! twice as high as it is wide.
//!
//! Theta goes round the tube in steps of 0.07, and phi round the ring in steps of 0.02. Each pair of
//! them gives a sample: a point of the surface, and the normal there, which is the direction that the
//! surface faces. The sample is at the distance h from the axis, and at the height f over the plane of
//! the ring:
//!
//! ```text
//! h = R2 + R1 cos theta      point   (h cos phi, h sin phi, f)
//! f = R1 sin theta           normal  (cos theta cos phi, cos theta sin phi, sin theta)
//! ```
//!
//! The donut is turned by the angle A about the x axis, and then by B about the z axis. That takes the
//! point to (X, Y, Z), and the normal in the same way:
//!
//! ```text
//! t = h sin phi cos A - f sin A      X = h cos phi cos B - t sin B
//! Z = h sin phi sin A + f cos A      Y = h cos phi sin B + t cos B
//! ```
//!
//! From the viewer the point is `z = Z + K2` away. What is twice as far looks half as large, so the
//! point is seen at `K1 X / z`, `K1 Y / z` from the centre of the screen. Many samples are seen in the
//! same cell, and the nearest hides the others. To find it, a z-buffer keeps for each cell the largest
//! 1/z so far.
//!
//! The cell shows how bright that sample is. Its luminance L is the dot product of the normal and the
//! light, (0, -1, -1), which points up and back to the viewer. As the light is sqrt 2 long, 8 L is
//! 11.3 at most. Without its fraction that is the place of a glyph in the ramp `.,-~:;=!*#$@`, from 0
//! to 11. Where L is negative, the surface is turned away from the light, and the glyph is the darkest.
//!
//! Each frame adds 0.04 to A and 0.02 to B.
//!
//! # Two methods
//!
//! `classic` is all of that. It asks of each sample in which cell it is seen. `exact` asks the other
//! way round: it follows the ray through the centre of each cell, and finds what the ray hits first.
//!
//! The letters are those of the [article] that explains donut.c. The directions and the arithmetic are
//! those of donut.c itself, for the article has some of them otherwise: x goes right, y *down*, and z
//! away from the viewer. Angles are in radians.
//!
//! [article]: https://www.a1k0n.net/2011/07/20/donut-math.html

use std::convert::Infallible;
use std::f64::consts::TAU;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::ops::{ControlFlow, RangeInclusive};
use std::process::{self, ExitCode};
use std::str::FromStr;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, mpsc};
use std::time::{Duration, Instant};
use std::{env, panic, thread};

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, ValueEnum, ValueHint};
use crossterm::cursor::{Hide, Show};
use crossterm::event::{self, Event, KeyCode, KeyEvent, KeyModifiers};
use crossterm::queue;
use crossterm::style::{self, Color, ResetColor, SetForegroundColor};
use crossterm::terminal::{
    self, EndSynchronizedUpdate, EnterAlternateScreen, LeaveAlternateScreen,
};
#[cfg(unix)]
use signal_hook::{
    consts::{SIGCONT, SIGQUIT, SIGTSTP},
    iterator::Signals,
};

// ---- Options -------------------------------------------------------------------------------------

/// A spinning ASCII donut: donut.c at 80x22, and exact at every other size
///
/// On a terminal the donut fills the window, and spins until you press q. Into a
/// pipe or a file goes what donut.c prints, 80x22, at the rate of --fps. If a
/// window or options make the donut smaller than a cell, nothing may be seen.
#[derive(Parser)]
#[command(name = "donut", version, verbatim_doc_comment, after_help = AFTER_HELP)]
// Some people define `alias donut='donut --color cyan'`: what they type after that wins.
#[command(args_override_self = true)]
// Values may begin with a hyphen, as negative numbers do. No value is the name of a file, so the
// completions offer none.
#[command(mut_args(|arg| arg.allow_hyphen_values(true).value_hint(ValueHint::Other)))]
struct Options {
    /// Columns [default: all, or 80 in a pipe]
    ///
    /// From 1 to 4096. A terminal shows at most as many as it has.
    ///
    /// The first column is donut.c's newline, so N shows N-1 characters.
    #[arg(long, value_name = "COLS", value_parser = within(SIZES))]
    width: Option<u16>,

    /// Rows [default: all but 2, or 22 in a pipe]
    ///
    /// From 1 to 4096. A terminal shows at most 2 fewer than it has.
    #[arg(long, value_name = "ROWS", value_parser = within(SIZES))]
    height: Option<u16>,

    /// Frames a second; 0 is as fast as possible
    ///
    /// At most 1000. Each frame turns the donut by --spin.
    #[arg(long, value_name = "N", default_value = "30", value_parser = within(0.0..=1000.0))]
    fps: f64,

    /// Stop after N frames; the last one stays on the screen
    #[arg(long, value_name = "N", value_parser = within(0..=u64::MAX))]
    frames: Option<u64>,

    /// How to draw
    ///
    /// Classic needs --r1, --r2 and --k2 to be 1, 2 and 5.
    ///
    /// After 31 hours donut.c's angles are too coarse; then auto is exact.
    #[arg(long, value_enum, default_value_t, hide_default_value = true)]
    method: Method,

    /// Start angle about the x axis, in radians
    #[arg(short = 'A', value_name = "RAD", default_value = "0", value_parser = within(ANGLES))]
    a: f64,

    /// Start angle about the z axis, in radians
    #[arg(short = 'B', value_name = "RAD", default_value = "0", value_parser = within(ANGLES))]
    b: f64,

    /// What each frame adds to A and B
    #[arg(long, value_name = "DA,DB", default_value = "0.04,0.02", value_parser = two_angles)]
    spin: [f64; 2],

    /// One colour: a name, 0 to 255, or #rrggbb
    #[arg(long, value_parser = color)]
    color: Option<Color>,

    /// Height of a cell over its width, 0.1 to 10
    #[arg(long, value_name = "RATIO", default_value = "2", value_parser = within(0.1..=10.0))]
    aspect: f64,

    /// Radius of the tube
    #[arg(long, value_name = "R", default_value = "1", value_parser = within(LENGTHS))]
    r1: f64,

    /// Radius of the ring: above --r1
    ///
    /// From the donut's centre to the tube's; at most 1000 times --r1.
    #[arg(long, value_name = "R", default_value = "2", value_parser = within(LENGTHS))]
    r2: f64,

    /// Viewer's distance: above --r1 plus --r2
    ///
    /// From the donut's centre.
    #[arg(long, value_name = "D", default_value = "5", value_parser = within(LENGTHS))]
    k2: f64,
}

const AFTER_HELP: &str = "\
Keys:
  q, Esc, Ctrl-C  quit
  p               pause, and go on
  space           shading off, and on
  Ctrl-Z          suspend

Colours:
  black, dark_grey, grey, white, red, green, yellow, blue, magenta, cyan,
  dark_red, dark_green, dark_yellow, dark_blue, dark_magenta, dark_cyan

Examples:
  donut -A 1 -B 1 --spin 0.08,0.03 --color cyan
  donut --width 120 --height 40 --frames 1 > donut.txt";

/// How to draw the donut.
#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum Method {
    /// The default: classic for donut.c's own picture, else exact
    #[default]
    Auto,
    /// As donut.c: draws many points; a cell shows the nearest
    Classic,
    /// Follows a ray through each cell's centre: right at any size
    Exact,
}

/// Columns or rows.
const SIZES: RangeInclusive<u16> = 1..=4096;
/// In radians.
const ANGLES: RangeInclusive<f64> = -1e9..=1e9;
/// Of R1, R2 and K2, in any unit.
const LENGTHS: RangeInclusive<f64> = 1e-6..=1e6;
/// How many times R1 the radius R2 may be. With less, the hole is too small for its edge to be told
/// from its middle in f64.
const RING: RangeInclusive<f64> = 1.000_001..=1000.0;

/// Makes a parser of numbers within `range`. The parser's error is what it expected.
fn within<T>(range: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone
where
    T: FromStr + PartialOrd + Display + Clone,
{
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        // Whole numbers are those that refuse a half.
        let kind = if "0.5".parse::<T>().is_ok() { "number" } else { "whole number" };
        let (low, high) = (range.start(), range.end());
        number.ok_or_else(|| format!("expected a {kind} from {low} to {high}"))
    }
}

fn two_angles(text: &str) -> Result<[f64; 2], String> {
    let angles: Vec<_> = text.split(',').map(str::trim).collect();
    let [a, b] = angles[..] else {
        return Err("expected two numbers with a comma between them, as in 0.04,0.02".into());
    };
    let angle = within(ANGLES);
    Ok([angle(a)?, angle(b)?])
}

fn color(text: &str) -> Result<Color, String> {
    let hex = text.strip_prefix('#').filter(|hex| hex.len() == 6 && !hex.starts_with('+'));
    let color = if let Some(rgb) = hex.and_then(|hex| u32::from_str_radix(hex, 16).ok()) {
        let [_, r, g, b] = rgb.to_be_bytes();
        Some(Color::Rgb { r, g, b })
    } else if let Ok(index) = text.parse() {
        Some(Color::AnsiValue(index))
    } else {
        let name = text.to_lowercase().replace("gray", "grey");
        Color::try_from(name.as_str()).ok().filter(|&color| color != Color::Reset)
    };
    color.ok_or_else(|| "expected a name from --help, 0 to 255, or #rrggbb".into())
}

impl Options {
    /// R2 and K2, in units of R1.
    fn ratios(&self) -> (f64, f64) {
        (self.r2 / self.r1, self.k2 / self.r1)
    }

    /// Why the options do not fit together, if so. It tells the values of all that are concerned, for
    /// any of them may be the wrong one.
    fn refusal(&self) -> Option<String> {
        let (Options { r1, r2, k2, .. }, (ring, distance)) = (self, self.ratios());
        let refusal = if !RING.contains(&ring) {
            let (least, most) = (RING.start(), RING.end());
            format!("--r1 is {r1} and --r2 is {r2}: --r2 must be {least} to {most} times --r1")
        } else if distance <= sphere(ring) {
            format!("--k2 is {k2}: it must be more than --r1 plus --r2, which is {r1} + {r2}")
        } else if self.method == Method::Classic
            && (ring, distance) != (View::DONUT_C.r2, View::DONUT_C.k2)
        {
            let needs = "--method classic needs --r1, --r2 and --k2 to be 1, 2 and 5";
            format!("{needs}, and not {r1}, {r2} and {k2}")
        } else {
            return None;
        };
        Some(refusal)
    }
}

fn main() -> ExitCode {
    let options = Options::parse();
    if let Some(refusal) = options.refusal() {
        Options::command().error(ErrorKind::ValueValidation, refusal).exit()
    }
    match run(&options) {
        // A reader that goes away, as in `donut | head`, has seen enough.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            // Nothing is left to do if standard error is gone as well.
            let _ = writeln!(io::stderr(), "donut: {error}");
            ExitCode::FAILURE
        }
        _ => ExitCode::SUCCESS,
    }
}

// ---- View ----------------------------------------------------------------------------------------

/// What there is to see, and where on the screen it is seen.
///
/// Lengths are in units of the tube's radius, so that R1 is 1. The point (X, Y, Z) is seen at
/// `x = cx + k1x X / (Z + K2)`, `y = cy + k1y Y / (Z + K2)`. The cell in column c and row r is the
/// square from (c, r) to (c + 1, r + 1). Column 0 and row 0 stay empty: donut.c prints a newline in
/// place of column 0, and it never draws on row 0.
#[derive(Clone, Copy, PartialEq)]
struct View {
    /// Radius of the ring, from the donut's centre to the tube's.
    r2: f64,
    /// Distance from the viewer to the donut's centre.
    k2: f64,
    /// Columns and rows of the picture.
    width: usize,
    height: usize,
    /// Where the donut's centre is seen, in cells.
    cx: f64,
    cy: f64,
    /// The scale K1, in columns and in rows.
    k1x: f64,
    k1y: f64,
}

impl View {
    const DONUT_C: View =
        View { r2: 2.0, k2: 5.0, width: 80, height: 22, cx: 40.0, cy: 12.0, k1x: 30.0, k1y: 15.0 };

    /// donut.c's own view for its size and lengths; otherwise the largest in which nothing is cut off,
    /// however the donut is turned. `aspect` is the height of a cell over its width.
    fn new(width: usize, height: usize, aspect: f64, r2: f64, k2: f64) -> View {
        if (width, height, aspect, r2, k2) == (80, 22, 2.0, 2.0, 5.0) {
            return View::DONUT_C;
        }
        let (w, h) = (width as f64, height as f64);
        let k1x = f64::min((w - 1.0) / 2.0, aspect * (h - 1.0) / 2.0) / limb(r2, k2);
        let (cx, cy) = ((w + 1.0) / 2.0, (h + 1.0) / 2.0);
        View { r2, k2, width, height, cx, cy, k1x, k1y: k1x / aspect }
    }
}

/// The donut never leaves the sphere of this radius round its centre.
fn sphere(r2: f64) -> f64 {
    1.0 + r2
}

/// The limb is the edge of that sphere, as the viewer sees it. This is the tangent of the angle between
/// it and the donut's centre.
fn limb(r2: f64, k2: f64) -> f64 {
    sphere(r2) / ((k2 - sphere(r2)) * (k2 + sphere(r2))).sqrt()
}

// ---- Rendering -----------------------------------------------------------------------------------

/// The glyphs, from dark to bright.
const RAMP: &[u8; 12] = b".,-~:;=!*#$@";
/// The glyphs with the shading off.
const FLAT: &[u8; 12] = &[b'.'; 12];

/// The glyph of a luminance L, which is from -sqrt 2 to sqrt 2. What is turned away from the light has
/// a negative L, and is as dark as can be.
fn glyph(ramp: &[u8; 12], luminance: f64) -> u8 {
    // The cast takes all that is below 0 for 0; no other rounding may leave the ramp.
    ramp[usize::from((8.0 * luminance) as u8).min(11)]
}

/// What the z-buffer keeps of a sample: its 1/z and its number. The nearer sample has the larger entry,
/// for positive floats are in the order of their bits. Of two that are equally near the first has: that
/// is why the number is inverted.
fn entry(ooz: f32, number: u32) -> u64 {
    u64::from(ooz.to_bits()) << 32 | u64::from(!number)
}

/// The number of the sample in an entry.
fn number(entry: u64) -> u32 {
    !(entry as u32)
}

/// Draws one picture of the donut after another.
struct Renderer {
    view: View,
    method: Method,
    ramp: &'static [u8; 12],
    /// The glyph of each cell: `width * height` bytes, row after row, a blank where no donut is.
    framebuffer: Vec<u8>,
    /// The `entry` of the nearest sample of each cell, or 0. There is one more than cells: at the very
    /// edge of the picture rounding may put a sample there.
    zbuffer: Vec<u64>,
    /// Made when `splat` first needs them, for they can be many.
    samples: Option<Samples>,
}

impl Renderer {
    fn new(view: View, method: Method) -> Renderer {
        let cells = view.width * view.height;
        let (framebuffer, zbuffer) = (vec![b' '; cells], vec![0; cells + 1]);
        Renderer { view, method, ramp: RAMP, framebuffer, zbuffer, samples: None }
    }

    /// Draws the donut, turned by the angles A and B, into the framebuffer.
    fn render_frame(&mut self, a: f64, b: f64) {
        self.framebuffer.fill(b' ');
        match self.method {
            Method::Classic => self.splat(a as f32, b as f32),
            _ => self.trace(a, b),
        }
    }

    /// `classic`: donut.c's own loops. Of all samples that fall into a cell it shows the nearest.
    ///
    /// All is in f32 and in donut.c's order of operations: another order rounds to other glyphs. `ooz` is
    /// one over z.
    fn splat(&mut self, a: f32, b: f32) {
        let (width, height) = (self.view.width as i32, self.view.height as i32);
        let View { r2, k2, cx, cy, k1x, k1y, .. } = self.view;
        let [r2, k2, cx, cy, k1x, k1y] = [r2, k2, cx, cy, k1x, k1y].map(|value| value as f32);
        let turn @ [(sin_a, cos_a), (sin_b, cos_b)] = [sin_cos(a), sin_cos(b)];
        let samples = self.samples.get_or_insert_with(|| Samples::new(&self.view));
        let (mut ooz, mut cell) = ([0.0; BLOCK], [0; BLOCK]);
        self.zbuffer.fill(0);
        // The number of the first sample of a block.
        let mut first = 0;
        for &(sin_theta, cos_theta) in &samples.theta {
            let h = cos_theta + r2;
            for phi in &samples.phi {
                // Formulas alone make a loop that the compiler turns into vectors.
                for i in 0..BLOCK {
                    let (sin_phi, cos_phi) = (phi.sin[i], phi.cos[i]);
                    ooz[i] = 1.0 / (sin_phi * h * sin_a + sin_theta * cos_a + k2);
                    let t = sin_phi * h * cos_a - sin_theta * sin_a;
                    let x = truncate(cx + k1x * ooz[i] * (cos_phi * h * cos_b - t * sin_b));
                    let y = truncate(cy + k1y * ooz[i] * (cos_phi * h * sin_b + t * cos_b));
                    // Only donut.c's own view cuts anything off. What is seen below its last row goes to
                    // cell 0, and that is not shown, nor is anything else in row 0 and column 0.
                    cell[i] = if y < height { x + width * y } else { 0 };
                }
                for i in 0..BLOCK {
                    let nearest = &mut self.zbuffer[cell[i] as usize];
                    *nearest = (*nearest).max(entry(ooz[i], first + i as u32));
                }
                first += BLOCK as u32;
            }
        }
        // donut.c takes the luminance of all samples, and shows few of them.
        let width = self.view.width;
        let rows = self.framebuffer.chunks_exact_mut(width).zip(self.zbuffer.chunks_exact(width));
        for (cells, nearest) in rows.skip(1) {
            for (cell, &nearest) in cells.iter_mut().zip(nearest).skip(1) {
                if nearest > 0 {
                    let luminance = samples.luminance(number(nearest), turn);
                    *cell = glyph(self.ramp, luminance.into());
                }
            }
        }
    }

    /// `exact`: a cell shows what the ray through its centre hits first.
    fn trace(&mut self, a: f64, b: f64) {
        let View { r2, k2, width, cx, cy, k1x, k1y, .. } = self.view;
        let (torus, limb) = (Torus::new(r2, a, b), limb(r2, k2));
        for (row, cells) in self.framebuffer.chunks_exact_mut(width).enumerate().skip(1) {
            let dy = (row as f64 + 0.5 - cy) / k1y;
            // Rays beyond the limb have nothing to hit.
            let half = (limb * limb - dy * dy).max(0.0).sqrt() * k1x;
            let first = (cx - half) as usize;
            let last = ((cx + half) as usize + 1).min(width);
            for column in (first..last).step_by(LANES) {
                let dx = |i| ((column + i) as f64 + 0.5 - cx) / k1x;
                let rays = torus.cast(std::array::from_fn(dx), dy, k2);
                let hits = torus.first_hits(&rays);
                let luminance = torus.luminance(&rays, &hits);
                for ((cell, s), luminance) in
                    cells[column..last].iter_mut().zip(hits).zip(luminance)
                {
                    if s < MISS {
                        *cell = glyph(self.ramp, luminance);
                    }
                }
            }
        }
    }
}

// ---- classic: donut.c's samples ------------------------------------------------------------------

/// How many values of phi are worked on together.
const BLOCK: usize = 32;

/// The sines and cosines of theta and phi, from which `splat` makes its samples of the surface.
struct Samples {
    theta: Vec<(f32, f32)>,
    phi: Vec<Block>,
}

struct Block {
    sin: [f32; BLOCK],
    cos: [f32; BLOCK],
}

impl Samples {
    /// donut.c's steps, made smaller in proportion for a larger picture. The point nearest to the viewer
    /// then moves by about a cell in each step, as in donut.c. Larger steps would leave holes.
    fn new(view: &View) -> Samples {
        let shrink = f64::min(1.0, View::DONUT_C.k1x / view.k1x.max(view.k1y));
        Samples::with_steps(0.07 * shrink, 0.02 * shrink)
    }

    fn with_steps(theta: f64, phi: f64) -> Samples {
        let mut phi = circle(phi);
        // The first sample fills up the last block: the second time it is not nearer, and changes
        // nothing.
        phi.resize(phi.len().next_multiple_of(BLOCK), phi[0]);
        let block = |phi: &[(f32, f32)]| Block {
            sin: std::array::from_fn(|i| phi[i].0),
            cos: std::array::from_fn(|i| phi[i].1),
        };
        Samples { theta: circle(theta), phi: phi.chunks(BLOCK).map(block).collect() }
    }

    /// The luminance of a sample: the formula of the first page, multiplied out as in donut.c.
    fn luminance(&self, number: u32, turn: [(f32, f32); 2]) -> f32 {
        let [(sin_a, cos_a), (sin_b, cos_b)] = turn;
        let (block, i) = (number as usize / BLOCK, number as usize % BLOCK);
        let (sin_theta, cos_theta) = self.theta[block / self.phi.len()];
        let phi = &self.phi[block % self.phi.len()];
        let (sin_phi, cos_phi) = (phi.sin[i], phi.cos[i]);
        (sin_theta * sin_a - sin_phi * cos_theta * cos_a) * cos_b
            - sin_phi * cos_theta * sin_a
            - sin_theta * cos_a
            - cos_phi * cos_theta * sin_b
    }
}

/// The sines and cosines of angles once round the circle, counted up as donut.c does.
fn circle(step: f64) -> Vec<(f32, f32)> {
    let angles = std::iter::successors(Some(0.0), |&angle| Some(advance(angle, step)));
    // donut.c stops at 6.28. At its own steps that is the same; smaller ones would leave a gap there.
    angles.take_while(|&angle| f64::from(angle) < TAU).map(sin_cos).collect()
}

/// donut.c's `angle += step`: C adds in `double`, and rounds the sum to `float`.
fn advance(angle: f32, step: f64) -> f32 {
    (f64::from(angle) + step) as f32
}

/// The sine and the cosine of an angle. C takes them in `double`, too, and rounds to `float`.
fn sin_cos(angle: f32) -> (f32, f32) {
    let (sin, cos) = f64::from(angle).sin_cos();
    (sin as f32, cos as f32)
}

/// `value as i32` where that is from 1 to 2^23, and some number below 1 where that is below 1.
///
/// Unlike the cast, all of this can be done on vectors on every machine.
fn truncate(value: f32) -> i32 {
    // From 2^23 on floats are whole numbers: the sum is rounded to one, which its last bits spell.
    const WHOLE: f32 = 8_388_608.0;
    let rounded = value + WHOLE;
    let up = rounded - WHOLE > value;
    rounded.to_bits() as i32 - WHOLE.to_bits() as i32 - i32::from(up)
}

// ---- exact: rays and a torus ---------------------------------------------------------------------

/// How many rays are solved side by side: while one waits for its division, others go on.
const LANES: usize = 8;
/// One number for each of these rays.
type Lanes = [f64; LANES];

/// Where a ray hits that misses.
const MISS: f64 = f64::INFINITY;

/// A step shorter than this, in units of R1, is a ray's last.
///
/// Each of Newton's steps doubles the digits that are right, so about 1e-12 is left. A ray that grazes
/// the donut gains only one binary digit in each step. It may be 1e-6 away from where it comes nearest,
/// but there it is within 1e-12 of the surface, and may as well hit it as miss it.
const LAST_STEP: f64 = 1e-6;
/// The most steps that a ray makes. None has been found that needs more than 40. One that did would
/// only graze the donut, for no step goes beyond the first root, and it counts as a hit.
const MOST_STEPS: usize = 64;

/// The donut of one frame, as a ray meets it.
///
/// A ray is P = P0 + s U. U is its direction, of length 1. P0 is its point nearest to the donut's
/// centre, which is the origin, so P0 and U are at right angles. Of a point P three numbers matter:
///
/// ```text
/// |P|^2 = d0 + s^2      the square of its distance from the centre
/// f     = f0 + fu s     its height over the plane of the ring
/// l     = l0 + lu s     its dot product with the light (0, -1, -1)
/// ```
///
/// P is on the surface if it is R1 = 1 away from the ring. At the distance h from the axis, that is
/// `(h - R2)^2 + f^2 = 1`. As `h^2 = |P|^2 - f^2`, it is `(|P|^2 + R2^2 - 1)^2 = 4 R2^2 h^2`, and along
/// the ray `G(s) = s^4 + p s^2 + q s + r = 0`. G is positive outside of the donut. Because s counts from
/// P0, there is no cubic term, and the coefficients stay small however far away the viewer is.
struct Torus {
    r2: f64,
    /// The axis of revolution, of length 1, once the donut is turned by A and B. That is all that can
    /// be seen of how it is turned: a donut turned about its own axis looks the same.
    axis: [f64; 3],
}

/// The three numbers of the points on each ray.
#[derive(Default)]
struct Rays {
    d0: Lanes,
    f0: Lanes,
    fu: Lanes,
    l0: Lanes,
    lu: Lanes,
}

impl Torus {
    fn new(r2: f64, a: f64, b: f64) -> Torus {
        let ((sin_a, cos_a), (sin_b, cos_b)) = (a.sin_cos(), b.sin_cos());
        Torus { r2, axis: [sin_a * sin_b, -sin_a * cos_b, cos_a] }
    }

    /// The rays from the viewer, who is at (0, 0, -K2), in the directions (dx, dy, 1).
    fn cast(&self, dx: Lanes, dy: f64, k2: f64) -> Rays {
        let [x, y, z] = self.axis;
        let mut rays = Rays::default();
        for (i, dx) in dx.into_iter().enumerate() {
            // U is (dx, dy, 1) times cos, and P0 is (dx, dy, -slant) times near.
            let slant = dx * dx + dy * dy;
            let cos = 1.0 / (1.0 + slant).sqrt();
            let near = k2 * cos * cos;
            rays.d0[i] = k2 * near * slant;
            rays.f0[i] = near * (dx * x + dy * y - slant * z);
            rays.fu[i] = cos * (dx * x + dy * y + z);
            rays.l0[i] = near * (slant - dy);
            rays.lu[i] = -cos * (dy + 1.0);
        }
        rays
    }

    /// The coefficients p, q and r of a ray's G.
    fn quartic(&self, d0: f64, f0: f64, fu: f64) -> [f64; 3] {
        let (inner, outer) = (self.r2 - 1.0, sphere(self.r2));
        let r2_r2 = self.r2 * self.r2;
        let p = 2.0 * (d0 - r2_r2 - 1.0) + 4.0 * r2_r2 * fu * fu;
        let q = 8.0 * r2_r2 * f0 * fu;
        let r = (d0 - inner * inner) * (d0 - outer * outer) + 4.0 * r2_r2 * f0 * f0;
        [p, q, r]
    }

    /// The s of each ray's first hit: the first root of its G, found by Newton's method.
    ///
    /// G is concave between its inflections -w and w, and convex to both sides of them. (It may have
    /// no inflections. Then it is convex all over, and w is 0.) The search begins outside of the donut,
    /// to the left of the first root. Where G is convex and falls, no step goes beyond that root.
    ///
    /// 1. To the left of -w a step may go beyond -w, or find G rising. Then there is no root so far, and
    ///    the search goes on from w.
    /// 2. If G is positive at w, the first root is further on, where G is convex again. If it rises there,
    ///    there is no root: the ray misses.
    /// 3. If G is negative at w, the first root is between -w and w. There G is concave and falls. The
    ///    steps go back to the root, and not beyond it.
    fn first_hits(&self, rays: &Rays) -> Lanes {
        let radius = sphere(self.r2);
        let mut p = [0.0; LANES];
        let (mut q, mut r, mut w, mut s) = (p, p, p, p);
        for i in 0..LANES {
            let (d0, f0, fu) = (rays.d0[i], rays.f0[i], rays.fu[i]);
            [p[i], q[i], r[i]] = self.quartic(d0, f0, fu);
            w[i] = (p[i] * (-1.0 / 6.0)).max(0.0).sqrt();
            // The donut is inside of the sphere, and between the planes f = -1 and f = 1. Before the
            // ray has entered both there is no root.
            let enters_sphere = -(radius * radius - d0).max(0.0).sqrt();
            let enters_planes = -(1.0 + f0 * 1_f64.copysign(fu)) / fu.abs();
            let start = enters_sphere.max(enters_planes);
            // From beyond -w it may begin at w as well, for G is not negative before the donut.
            s[i] = if start > -w[i] { w[i] } else { start };
        }
        for _ in 0..MOST_STEPS {
            let mut searching = false;
            for i in 0..LANES {
                let ss = s[i] * s[i];
                let slope = 2.0 * (ss + p[i] + ss) * s[i] + q[i];
                let step = (((ss + p[i]) * s[i] + q[i]) * s[i] + r[i]) / slope;
                let next = s[i] - step;
                let left = s[i] < -w[i];
                let no_root = (slope >= 0.0) | (left & (next > -w[i]));
                let go_on = if left { w[i] } else { MISS };
                s[i] = if no_root { go_on } else { next };
                searching |= (no_root & left) | (!no_root & (step.abs() > LAST_STEP));
            }
            if !searching {
                break;
            }
        }
        s
    }

    /// The luminance where each ray hits: the dot product of the surface's normal and the light.
    ///
    /// With the axis n the normal at P is `(P - f n) (1 - R2 / h) + f n`. On the surface h is
    /// `(|P|^2 + R2^2 - 1) / (2 R2)`, which takes no square root.
    fn luminance(&self, rays: &Rays, hits: &Lanes) -> Lanes {
        let r2 = self.r2;
        let axis_light = -(self.axis[1] + self.axis[2]);
        let mut luminance = [0.0; LANES];
        for (i, s) in hits.iter().enumerate() {
            let f = rays.f0[i] + rays.fu[i] * s;
            let light = rays.l0[i] + rays.lu[i] * s;
            let across = 1.0 - 2.0 * r2 * r2 / (rays.d0[i] + s * s + r2 * r2 - 1.0);
            luminance[i] = (light - f * axis_light) * across + f * axis_light;
        }
        luminance
    }
}

// ---- Output --------------------------------------------------------------------------------------

/// Where frames go to.
#[derive(Clone, Copy, PartialEq)]
enum Output {
    /// A pipe or a file.
    Pipe,
    Terminal,
    /// A terminal that understands no escapes.
    DumbTerminal,
}

impl Output {
    fn detect() -> Output {
        if !io::stdout().is_terminal() {
            Output::Pipe
        } else if env::var_os("TERM").is_some_and(|term| term == "dumb") {
            Output::DumbTerminal
        } else {
            Output::Terminal
        }
    }
}

/// How a framebuffer becomes bytes.
struct Encoder {
    output: Output,
    /// The sequences that begin and end the colour, or two empty ones.
    color: (String, &'static str),
    /// Whether the next frame clears the screen, where something else may have been left.
    clear: bool,
}

impl Encoder {
    fn new(output: Output, color: Option<Color>) -> Encoder {
        // The option is explicit, and so stronger than NO_COLOR.
        style::force_color_output(true);
        let color = color.filter(|_| output != Output::DumbTerminal).map(SetForegroundColor);
        let color = color.map(|color| (color.to_string(), "\x1b[0m")).unwrap_or_default();
        Encoder { output, color, clear: output != Output::DumbTerminal }
    }

    /// Appends a frame to `out`.
    fn encode(&mut self, framebuffer: &[u8], width: usize, out: &mut Vec<u8>) {
        let (begin, newline, end) = match self.output {
            // A synchronized update shows no half frame. In raw mode a newline needs its \r.
            Output::Terminal => ("\x1b[?2026h", "\r\n", "\x1b[?2026l"),
            // donut.c's own bytes.
            Output::Pipe | Output::DumbTerminal => ("", "\n", "\n"),
        };
        let clear = if self.clear { "\x1b[2J" } else { "" };
        let home = if self.output == Output::DumbTerminal { "" } else { "\x1b[H" };
        for text in [begin, clear, home, &self.color.0] {
            out.extend_from_slice(text.as_bytes());
        }
        for row in framebuffer.chunks_exact(width) {
            // The newline stands for column 0, which stays empty.
            out.extend_from_slice(newline.as_bytes());
            out.extend_from_slice(&row[1..]);
        }
        out.extend_from_slice(end.as_bytes());
        out.extend_from_slice(self.color.1.as_bytes());
        self.clear = false;
    }
}

// ---- Terminal ------------------------------------------------------------------------------------

/// What the loop is asked to do while it waits for the next frame.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Action {
    /// End; by this signal if there is one.
    Quit(Option<i32>),
    Pause,
    /// Switch the shading off or on.
    Shade,
    /// Stop, until the shell continues the program.
    Suspend,
    /// Go on after a stop.
    #[cfg_attr(windows, allow(dead_code, reason = "Windows stops no programs"))]
    Resume,
    Redraw,
}

type Sender = mpsc::Sender<io::Result<Action>>;
type Receiver = mpsc::Receiver<io::Result<Action>>;

impl Action {
    fn of(key: KeyEvent) -> Option<Action> {
        match (key.code, key.modifiers) {
            _ if !key.is_press() => None,
            (KeyCode::Char('c'), KeyModifiers::CONTROL) => Some(Action::Quit(None)),
            (KeyCode::Char('z'), KeyModifiers::CONTROL) => Some(Action::Suspend),
            (KeyCode::Char('q') | KeyCode::Esc, KeyModifiers::NONE) => Some(Action::Quit(None)),
            (KeyCode::Char('p'), KeyModifiers::NONE) => Some(Action::Pause),
            (KeyCode::Char(' '), KeyModifiers::NONE) => Some(Action::Shade),
            _ => None,
        }
    }
}

/// The code of an arrow key begins as Esc does. This is how long the rest of it may take.
const ESCAPE: Duration = Duration::from_millis(20);
/// In this time the other threads surely see that the terminal was given back.
const SETTLE: Duration = Duration::from_millis(50);
/// How long the loop waits at most before it looks again whether the terminal is there, in front, and
/// as large as before.
const LOOK: Duration = Duration::from_millis(500);
/// How many bytes are written to a terminal at once. A frame of 80x22 is one piece.
const PIECE: usize = 2048;

/// Standard output and, if that is a terminal, who has it.
///
/// The main thread takes the terminal, writes to it, and gives it back. Other threads read keys and
/// receive signals, and send actions to the main thread. After a panic the terminal is given back by
/// the thread that it happens in.
struct Screen {
    output: Output,
    /// Standard output without std's line buffer, so that one write is one system call.
    stdout: File,
    /// Whether there are keys to read, in raw mode.
    keys: bool,
    /// Whether the donut has a screen of its own, or stays behind on the one it found.
    alternate: bool,
    /// Whether the donut has the terminal. Only then does it read keys and draw.
    taken: AtomicBool,
    /// The writes that began plus those that ended: odd during a write.
    writes: AtomicUsize,
    /// Whether the program is about to end.
    ending: AtomicBool,
    /// Whether it ends because the terminal does not read.
    unread: AtomicBool,
}

impl Screen {
    fn new(output: Output, alternate: bool) -> io::Result<Screen> {
        Ok(Screen {
            output,
            stdout: system::stdout()?,
            keys: output == Output::Terminal && io::stdin().is_terminal(),
            alternate,
            taken: AtomicBool::new(false),
            writes: AtomicUsize::new(0),
            ending: AtomicBool::new(false),
            unread: AtomicBool::new(false),
        })
    }

    /// Starts to send what keys and signals ask for, and makes a panic give the terminal back.
    fn watch(self: &Arc<Screen>, sender: &Sender) -> io::Result<()> {
        let (screen, report) = (self.clone(), panic::take_hook());
        panic::set_hook(Box::new(move |panic| {
            screen.ending.store(true, SeqCst);
            let _ = screen.give_back();
            report(panic);
            // Whichever thread it was: 101 is the exit code of a panic.
            process::exit(101);
        }));
        self.watch_signals(sender)?;
        if self.keys {
            let (screen, sender) = (self.clone(), sender.clone());
            thread::spawn(move || {
                let Err(error) = screen.read_keys(&sender);
                sender.send(Err(error))
            });
        }
        Ok(())
    }

    /// Sends the action that each of these signals asks for.
    fn watch_signals(self: &Arc<Screen>, sender: &Sender) -> io::Result<()> {
        let (screen, quit) = (self.clone(), sender.clone());
        // SIGINT, SIGTERM and SIGHUP.
        ctrlc::set_handler(move || screen.send(&quit, Action::Quit(None)))
            .map_err(io::Error::other)?;
        #[cfg(unix)]
        {
            let (screen, sender) = (self.clone(), sender.clone());
            let mut signals = Signals::new([SIGTSTP, SIGCONT, SIGQUIT])?;
            thread::spawn(move || {
                for signal in signals.forever() {
                    let action = match signal {
                        SIGTSTP => Action::Suspend,
                        SIGCONT => Action::Resume,
                        _ => Action::Quit(Some(signal)),
                    };
                    screen.send(&sender, action);
                }
            });
        }
        Ok(())
    }

    fn read_keys(&self, sender: &Sender) -> io::Result<Infallible> {
        loop {
            // A program that reads in the background is stopped, with all its threads.
            while !self.taken.load(SeqCst) {
                thread::sleep(SETTLE);
            }
            // A new size ends this loop. `give_back` makes one up, for the donut must not read then.
            while let Event::Key(mut key) = event::read()? {
                // A person who presses Esc presses nothing else so soon: what follows it is the rest of
                // another key's code, which came late over a slow line.
                while cfg!(unix) && key == KeyCode::Esc.into() && event::poll(ESCAPE)? {
                    let Event::Key(next) = event::read()? else { break };
                    key = next;
                }
                if let Some(action) = Action::of(key) {
                    self.send(sender, action);
                }
            }
            self.send(sender, Action::Redraw);
        }
    }

    /// Sends an action to the loop. After a Quit it does not return, but waits until the program ends.
    fn send(&self, sender: &Sender, action: Action) {
        let quit = matches!(action, Action::Quit(_));
        self.ending.fetch_or(quit, SeqCst);
        let _ = sender.send(Ok(action));
        if quit {
            self.end_if_nobody_reads();
        }
    }

    /// Waits for the main thread to end the program. If one write takes 0.7 s, the terminal does not
    /// read. Then what it has not read is dropped, so that the main thread can go on, and end. If it
    /// still does not, this ends the program.
    fn end_if_nobody_reads(&self) -> ! {
        let (mut writes, mut waits) = (0, 0);
        while waits < 7 {
            let now = self.writes.load(SeqCst);
            waits = if now == writes && now % 2 == 1 { waits + 1 } else { 0 };
            writes = now;
            if waits > 0 && self.is_in_front().unwrap_or(false) {
                let _ = system::wake_write();
            }
            thread::sleep(Duration::from_millis(100));
        }
        self.unread.store(true, SeqCst);
        let in_front = self.is_in_front().unwrap_or(false);
        if in_front {
            let _ = system::drop_unread_output();
        }
        thread::sleep(Duration::from_millis(300));
        if in_front {
            let _ = terminal::disable_raw_mode();
        }
        process::exit(1)
    }

    /// Whether the donut runs in the foreground of the terminal. In the background the terminal is the
    /// shell's or another job's, and a program that changes its settings is stopped.
    fn is_in_front(&self) -> io::Result<bool> {
        if self.output == Output::Terminal { system::is_in_front(self.keys) } else { Ok(true) }
    }

    /// Takes the terminal. False if the donut has it already, or is about to end.
    fn take(&self) -> io::Result<bool> {
        let ending = self.ending.load(SeqCst);
        if self.output != Output::Terminal || ending || self.taken.swap(true, SeqCst) {
            return Ok(false);
        }
        if self.keys {
            // crossterm may believe that raw mode is on, where a shell has ended it since.
            terminal::disable_raw_mode()?;
            terminal::enable_raw_mode()?;
            system::never_wait_to_read()?;
        }
        let mut bytes = Vec::new();
        if self.alternate {
            queue!(bytes, EnterAlternateScreen)?;
        }
        queue!(bytes, Hide)?;
        self.write(&bytes)?;
        Ok(true)
    }

    /// Gives the terminal back as it was found, if the donut has it. In the background its settings are
    /// left alone: the shell has restored them.
    fn give_back(&self) -> io::Result<()> {
        if !self.taken.swap(false, SeqCst) {
            return Ok(());
        }
        system::wake_reader();
        // The terminal of the keys may be gone, and that of the picture still there.
        let in_front = self.is_in_front().unwrap_or(true);
        let mut bytes = Vec::new();
        queue!(bytes, EndSynchronizedUpdate, ResetColor, Show)?;
        if self.alternate {
            queue!(bytes, LeaveAlternateScreen)?;
        } else {
            bytes.extend(b"\r\n");
        }
        let settings = if in_front { terminal::disable_raw_mode() } else { Ok(()) };
        if in_front || system::may_write_in_background()? {
            self.write(&bytes)?;
        }
        settings
    }

    /// Writes a frame: at once to a pipe, and in pieces to a terminal. When the program is about to end,
    /// the rest of the frame is left out.
    fn write_frame(&self, frame: &[u8]) -> io::Result<()> {
        let size = if self.output == Output::Terminal { PIECE } else { frame.len() };
        let mut pieces = frame.chunks(size).take_while(|_| !self.ending.load(SeqCst));
        pieces.try_for_each(|piece| self.write(piece))
    }

    fn write(&self, mut piece: &[u8]) -> io::Result<()> {
        self.writes.fetch_add(1, SeqCst);
        let mut written = Ok(());
        while !piece.is_empty() && written.is_ok() {
            match (&self.stdout).write(piece) {
                Ok(0) => written = Err(io::ErrorKind::WriteZero.into()),
                Ok(bytes) => piece = &piece[bytes..],
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                // Another program may have left the terminal so that no write waits for it.
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    thread::sleep(Duration::from_millis(5));
                }
                Err(error) => written = Err(error),
            }
        }
        self.writes.fetch_add(1, SeqCst);
        written
    }

    /// Columns and rows of the terminal; 80x24 for one that does not know, and for a pipe.
    fn size(&self) -> io::Result<(u16, u16)> {
        let size = if self.output == Output::Pipe { (0, 0) } else { system::terminal_size()? };
        Ok(if size.0 > 0 && size.1 > 0 { size } else { (80, 24) })
    }
}

// ---- Loop ----------------------------------------------------------------------------------------

/// The angles A and B, frame after frame.
///
/// They are `origin + frames * spin`. `exact` counts the frames. donut.c adds the spin to a `float` in
/// each frame, so for `classic` the sum becomes the new origin, and the count stays 0.
struct Clock {
    origin: [f64; 2],
    frames: u64,
    spin: [f64; 2],
}

impl Clock {
    fn angles(&self) -> [f64; 2] {
        [0, 1].map(|i| self.origin[i] + self.frames as f64 * self.spin[i])
    }

    /// donut.c's next angles.
    fn next_floats(&self) -> [f64; 2] {
        let angles = self.angles();
        [0, 1].map(|i| advance(angles[i] as f32, self.spin[i]).into())
    }

    /// Whether the next step of donut.c's clock is right to a tenth of the spin.
    ///
    /// From frame 3,345,245 on, where A reaches 2^17, a step of 0.04 is rounded to 0.047. From frame
    /// 22,918,663 on, where it reaches 2^20, the step is rounded to 0, and A stands still.
    fn floats_are_fine(&self) -> bool {
        let (angles, next) = (self.angles(), self.next_floats());
        let error = |i: usize| next[i] - f64::from(angles[i] as f32) - self.spin[i];
        (0..2).all(|i| error(i).abs() <= 0.1 * self.spin[i].abs())
    }

    fn tick(&mut self, method: Method) {
        if method == Method::Classic {
            (self.origin, self.frames) = (self.next_floats(), 0);
        } else {
            self.frames += 1;
        }
    }
}

impl Method {
    /// The method for this picture: `auto` is decided here.
    fn choose(self, view: &View, clock: &Clock) -> Method {
        match self {
            Method::Auto if *view == View::DONUT_C && clock.floats_are_fine() => Method::Classic,
            Method::Auto => Method::Exact,
            chosen => chosen,
        }
    }
}

/// The donut as it is shown, frame after frame.
struct Animation<'a> {
    options: &'a Options,
    screen: Arc<Screen>,
    /// Columns and rows of the terminal when the last frame was drawn.
    size: (u16, u16),
    renderer: Renderer,
    clock: Clock,
    encoder: Encoder,
    paused: bool,
    /// When the next frame is to be drawn.
    due: Instant,
    /// The bytes of a frame.
    out: Vec<u8>,
}

/// Shows the donut until the last frame is drawn, or somebody ends it, or its reader goes away.
fn run(options: &Options) -> io::Result<()> {
    if options.frames == Some(0) {
        return Ok(());
    }
    let output = Output::detect();
    let mut animation = Animation::new(options, output)?;
    let (sender, actions) = mpsc::channel();
    match output {
        Output::Pipe => animation.play(&actions).map(drop),
        Output::DumbTerminal => animation.draw(),
        Output::Terminal => {
            let screen = animation.screen.clone();
            screen.watch(&sender)?;
            let played = animation.play(&actions);
            let given_back = screen.give_back();
            let signal = played?;
            given_back?;
            if screen.unread.load(SeqCst) {
                return Err(io::Error::other("the terminal does not read"));
            }
            signal.map_or(Ok(()), system::end_by)
        }
    }
}

/// The time from one frame to the next. At 0 frames a second every frame is due at once.
fn interval(fps: f64) -> Duration {
    // 31 years are long enough. A longer time may not fit into a Duration.
    Duration::from_secs_f64(if fps > 0.0 { (1.0 / fps).min(1e9) } else { 0.0 })
}

/// The view for the size of the options, clipped to the terminal.
fn view(options: &Options, output: Output, (columns, rows): (u16, u16)) -> View {
    let clip = |asked: Option<u16>, most: u16| match asked {
        Some(asked) if output == Output::Pipe => asked,
        asked => asked.unwrap_or(4096).min(most),
    };
    let width = clip(options.width, columns);
    let height = clip(options.height, rows.saturating_sub(2).max(1));
    let (r2, k2) = options.ratios();
    View::new(width.into(), height.into(), options.aspect, r2, k2)
}

/// Drops the actions that come within 50 ms, but for a Quit, which it returns.
fn drop_actions(actions: &Receiver) -> io::Result<Option<Option<i32>>> {
    let end = Instant::now() + SETTLE;
    let wait = || end.saturating_duration_since(Instant::now());
    while let Ok(action) = actions.recv_timeout(wait()) {
        if let Action::Quit(signal) = action? {
            return Ok(Some(signal));
        }
    }
    Ok(None)
}

impl Animation<'_> {
    fn new(options: &Options, output: Output) -> io::Result<Animation<'_>> {
        let screen = Arc::new(Screen::new(output, options.frames.is_none())?);
        let size = screen.size()?;
        Ok(Animation {
            options,
            screen,
            size,
            renderer: Renderer::new(view(options, output, size), options.method),
            clock: Clock { origin: [options.a, options.b], frames: 0, spin: options.spin },
            encoder: Encoder::new(output, options.color),
            paused: false,
            due: Instant::now(),
            out: Vec::new(),
        })
    }

    /// donut.c's `for (;;)`: draws a frame when it is due, and obeys in between. Returns the signal that
    /// ended it, if any.
    fn play(&mut self, actions: &Receiver) -> io::Result<Option<i32>> {
        let interval = interval(self.options.fps);
        let (mut frames, mut wait) = (0, Duration::ZERO);
        while frames < self.options.frames.unwrap_or(u64::MAX) {
            // All waiting actions are obeyed before the next drawing.
            let first = actions.recv_timeout(wait).ok();
            let mut redraw = first.is_some();
            for action in first.into_iter().chain(actions.try_iter()) {
                if let ControlFlow::Break(signal) = self.obey(action?, actions)? {
                    return Ok(signal);
                }
            }
            if !self.screen.is_in_front()? {
                self.screen.give_back()?;
                // A shell that brings a running job to its foreground does not say so.
                wait = Duration::from_millis(100);
                continue;
            }
            if self.screen.take()? {
                (self.encoder.clear, redraw) = (true, true);
            }
            redraw |= self.fit()?;
            let due = !self.paused && self.due <= Instant::now();
            if due && frames > 0 {
                self.clock.tick(self.renderer.method);
            }
            if due || redraw && frames > 0 {
                self.draw()?;
            }
            if due {
                // Absolute deadlines do not drift; after a stall it goes on from now.
                self.due = (self.due + interval).max(Instant::now());
                frames += 1;
            }
            let until_due = self.due.saturating_duration_since(Instant::now());
            wait = if self.paused { LOOK } else { until_due.min(LOOK) };
        }
        Ok(None)
    }

    fn obey(&mut self, action: Action, actions: &Receiver) -> io::Result<ControlFlow<Option<i32>>> {
        match action {
            Action::Quit(signal) => return Ok(ControlFlow::Break(signal)),
            Action::Pause => (self.paused, self.due) = (!self.paused, Instant::now()),
            Action::Shade => {
                self.renderer.ramp = if self.renderer.ramp == RAMP { FLAT } else { RAMP };
            }
            Action::Redraw => self.encoder.clear = true,
            // Others may have used the terminal meanwhile. Once it is given back, the loop takes it
            // again.
            Action::Resume => self.screen.give_back()?,
            Action::Suspend if system::can_suspend() => return self.suspend(actions),
            Action::Suspend => {}
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Gives the terminal back and stops, until the shell says `fg` or `bg`.
    fn suspend(&mut self, actions: &Receiver) -> io::Result<ControlFlow<Option<i32>>> {
        self.screen.give_back()?;
        // The reader of keys must see first that it may not read in the background.
        if let Some(signal) = drop_actions(actions)? {
            return Ok(ControlFlow::Break(signal));
        }
        system::suspend()?;
        // A second Ctrl-Z that was pressed around the stop must not stop it at once again.
        let quit = drop_actions(actions)?;
        Ok(quit.map_or(ControlFlow::Continue(()), ControlFlow::Break))
    }

    /// Makes the picture fit the terminal. True if its size has changed.
    fn fit(&mut self) -> io::Result<bool> {
        let size = self.screen.size()?;
        let changed = size != self.size;
        if changed {
            (self.size, self.encoder.clear) = (size, true);
            let view = view(self.options, self.screen.output, size);
            if view != self.renderer.view {
                let ramp = self.renderer.ramp;
                self.renderer = Renderer { ramp, ..Renderer::new(view, self.options.method) };
            }
        }
        Ok(changed)
    }

    fn draw(&mut self) -> io::Result<()> {
        let view = self.renderer.view;
        self.renderer.method = self.options.method.choose(&view, &self.clock);
        let [a, b] = self.clock.angles();
        self.renderer.render_frame(a, b);
        self.out.clear();
        self.encoder.encode(&self.renderer.framebuffer, view.width, &mut self.out);
        self.screen.write_frame(&self.out)
    }
}

// ---- System --------------------------------------------------------------------------------------

/// What differs between operating systems, on Unix.
#[cfg(unix)]
mod system {
    use std::fs::File;
    use std::io;
    use std::os::fd::AsFd;

    use rustix::io::Errno;
    use rustix::process::{Signal, getpgrp, getsid, kill_current_process_group};
    use rustix::termios::{
        self, Action, LocalModes, OptionalActions, QueueSelector, SpecialCodeIndex, tcflow,
        tcflush, tcgetattr, tcgetpgrp, tcsetattr,
    };

    pub fn stdout() -> io::Result<File> {
        Ok(io::stdout().as_fd().try_clone_to_owned()?.into())
    }

    pub fn terminal_size() -> io::Result<(u16, u16)> {
        let size = termios::tcgetwinsize(io::stdout())?;
        Ok((size.ws_col, size.ws_row))
    }

    pub fn is_in_front(keys: bool) -> io::Result<bool> {
        match if keys { tcgetpgrp(io::stdin()) } else { tcgetpgrp(io::stdout()) } {
            Ok(group) => Ok(group == getpgrp()),
            Err(Errno::IO) => Err(Errno::IO.into()),
            // A terminal that controls no session has no background.
            Err(_) => Ok(true),
        }
    }

    /// Whether the terminal lets programs in its background write.
    pub fn may_write_in_background() -> io::Result<bool> {
        Ok(!tcgetattr(io::stdout())?.local_modes.contains(LocalModes::TOSTOP))
    }

    /// Whether a shell waits to continue a program that is stopped. None does where the program belongs
    /// to the first process of the session.
    pub fn can_suspend() -> bool {
        getsid(None) != Ok(getpgrp())
    }

    /// Stops the whole job, as the terminal's own Ctrl-Z does: its shell waits for the first process.
    pub fn suspend() -> io::Result<()> {
        Ok(kill_current_process_group(Signal::STOP)?)
    }

    /// Makes a read return where no key waits. crossterm reads on after half of a key's code, and a read
    /// in the background would stop the program.
    pub fn never_wait_to_read() -> io::Result<()> {
        let mut settings = tcgetattr(io::stdin())?;
        settings.special_codes[SpecialCodeIndex::VMIN] = 0;
        Ok(tcsetattr(io::stdin(), OptionalActions::Now, &settings)?)
    }

    /// Ends a wait for keys: crossterm takes this signal for a new size.
    pub fn wake_reader() {
        let _ = signal_hook::low_level::raise(signal_hook::consts::SIGWINCH);
    }

    /// Drops what is written but not read.
    pub fn drop_unread_output() -> io::Result<()> {
        tcflush(io::stdout(), QueueSelector::OFlush)?;
        wake_write()
    }

    /// Wakes a write that waits: where Ctrl-S holds it, or where it has room again and Linux lets it
    /// sleep on.
    pub fn wake_write() -> io::Result<()> {
        tcflow(io::stdout(), Action::OOff)?;
        Ok(tcflow(io::stdout(), Action::OOn)?)
    }

    /// Ends the program as the signal would have.
    pub fn end_by(signal: i32) -> io::Result<()> {
        signal_hook::low_level::emulate_default_handler(signal)
    }
}

/// The same on Windows, which has no background and no job to suspend.
#[cfg(windows)]
mod system {
    use std::fs::File;
    use std::io;
    use std::os::windows::io::AsHandle;

    pub use crossterm::terminal::size as terminal_size;

    pub fn stdout() -> io::Result<File> {
        Ok(io::stdout().as_handle().try_clone_to_owned()?.into())
    }

    pub fn is_in_front(_keys: bool) -> io::Result<bool> {
        Ok(true)
    }

    pub fn may_write_in_background() -> io::Result<bool> {
        Ok(true)
    }

    pub fn can_suspend() -> bool {
        false
    }

    pub fn suspend() -> io::Result<()> {
        Ok(())
    }

    pub fn never_wait_to_read() -> io::Result<()> {
        Ok(())
    }

    pub fn wake_reader() {}

    pub fn drop_unread_output() -> io::Result<()> {
        Ok(())
    }

    pub fn wake_write() -> io::Result<()> {
        Ok(())
    }

    pub fn end_by(_signal: i32) -> io::Result<()> {
        Ok(())
    }
}

#[cfg(test)]
#[path = "../tests/unit/mod.rs"]
mod tests;
