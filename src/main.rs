//! donut.c, Andy Sloane's spinning ASCII torus of 2006: byte for byte where donut.c is right, and
//! right in every cell where it is not.
//!
//! ```text
//! Options -> Scene, Camera -> render_frame(a, b) -> framebuffer -> encode -> terminal or pipe
//! ```
//!
//! # From the circle to the glyph
//!
//! Letters are those of the [article] that explains donut.c, and its arithmetic is that of donut.c
//! itself; where the two differ (the article turns other ways and has y upwards) donut.c wins. x goes
//! right, y *down*, z away from the viewer, angles are in radians.
//!
//! A donut is a circle of radius R1 = 1, the tube, that goes round an axis at a distance of R2 = 2,
//! the ring. Theta goes round the tube; each of its points has a distance h from the axis and a
//! height f over the plane of the ring. Phi goes round the ring:
//!
//! ```text
//! h = R2 + R1 cos theta      point  (h cos phi, h sin phi, f)
//! f = R1 sin theta           normal (cos theta cos phi, cos theta sin phi, sin theta)
//! ```
//!
//! Turned by A about the x axis and then by B about the z axis, the point is (X, Y, Z):
//!
//! ```text
//! t = h sin phi cos A - f sin A      X = h cos phi cos B - t sin B
//! Z = h sin phi sin A + f cos A      Y = h cos phi sin B + t cos B
//! ```
//!
//! and so is the normal. The viewer is K2 = 5 away from the centre. What is twice as far looks half
//! as large, so that a point is seen at X / (Z + K2), Y / (Z + K2), times a scale K1 in cells. Many
//! points fall into one cell: the nearest shows, whose 1 / (Z + K2), kept for each cell in a z-buffer,
//! is the largest.
//!
//! How bright it is, L, is the normal times the light, (0, -1, -1), which comes from above and from
//! behind the viewer. That light is sqrt 2 long, so that 8 L reaches 11.3: just the twelve glyphs.
//!
//! Each frame turns A by 0.04 and B by 0.02. That is donut.c, and [`Splat`]. [`trace`] asks the other
//! way round: not where each point is seen, but what is seen in each cell, along a ray.
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
/// pipe or a file goes what donut.c prints, 80x22, at the rate of --fps. Options
/// that make the donut smaller than a cell may leave the picture empty.
#[derive(Parser)]
#[command(name = "donut", version, verbatim_doc_comment, after_help = AFTER_HELP)]
// Some people define `alias donut='donut --color cyan'`: what they type after that wins.
#[command(args_override_self = true)]
// Values may begin with a hyphen, as negative numbers do. None is the name of a file.
#[command(mut_args(|arg| arg.allow_hyphen_values(true).value_hint(ValueHint::Other)))]
struct Options {
    /// Columns [default: all, or 80 in a pipe]
    ///
    /// From 1 to 4096. A terminal shows at most as many as it has.
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
/// How many times R1 the radius R2 may be.
const MOST_R2: f64 = 1000.0;

/// Makes a parser of numbers within `range`. The parser's error is what it expected.
fn within<T>(range: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone
where
    T: FromStr + PartialOrd + Display + Clone,
{
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        let kind = if "0.5".parse::<T>().is_ok() { "number" } else { "whole number" };
        let (low, high) = (range.start(), range.end());
        number.ok_or_else(|| format!("expected a {kind} from {low} to {high}"))
    }
}

fn two_angles(text: &str) -> Result<[f64; 2], String> {
    let angles: Vec<_> = text.split(',').collect();
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
    fn scene(&self) -> Scene {
        Scene { r2: self.r2 / self.r1, k2: self.k2 / self.r1 }
    }

    /// Why the options do not fit together, if so. It tells the values of all that are concerned, for
    /// any of them may be the wrong one.
    fn refusal(&self) -> Option<String> {
        let (Options { r1, r2, k2, .. }, scene) = (self, self.scene());
        let refusal = if scene.r2 <= 1.0 {
            format!("--r2 is {r2}: it must be more than --r1, which is {r1}")
        } else if scene.r2 > MOST_R2 {
            format!("--r2 is {r2}: it must be at most {MOST_R2} times --r1, which is {r1}")
        } else if scene.k2 <= scene.sphere() {
            format!("--k2 is {k2}: it must be more than --r1 plus --r2, which is {r1} + {r2}")
        } else if self.method == Method::Classic && scene != Scene::DONUT_C {
            let others = "--method is classic: it must be exact or auto";
            format!("{others} where --r1, --r2, --k2 are {r1}, {r2}, {k2}, not 1, 2, 5")
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
    match run(&options, options.scene()) {
        // A reader that goes away, as in `donut | head`, has seen enough.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            // Nothing is left to do if standard error is gone as well.
            let _ = writeln!(io::stderr(), "donut: {error}");
            ExitCode::FAILURE
        }
        _ => ExitCode::SUCCESS,
    }
}

// ---- Scene and camera ----------------------------------------------------------------------------

/// The donut and its viewer, in units of the tube's radius: R1 is 1.
#[derive(Clone, Copy, PartialEq)]
struct Scene {
    /// Radius of the ring, from the donut's centre to the tube's.
    r2: f64,
    /// Distance from the viewer to the donut's centre.
    k2: f64,
}

impl Scene {
    const DONUT_C: Scene = Scene { r2: 2.0, k2: 5.0 };

    /// Radius of the sphere that no pose of the donut leaves.
    fn sphere(&self) -> f64 {
        1.0 + self.r2
    }

    /// Tangent under which the viewer sees that sphere's radius.
    fn limb(&self) -> f64 {
        self.sphere() / ((self.k2 - self.sphere()) * (self.k2 + self.sphere())).sqrt()
    }
}

/// Where on the screen a point is seen: at `x = cx + k1x X / (Z + K2)`, `y = cy + k1y Y / (Z + K2)`.
///
/// In cells from the top left corner: cell (c, r) is the square [c, c+1) x [r, r+1). Column 0 and row
/// 0 stay empty: donut.c's first column is its newline, and it never draws on its first row.
#[derive(Clone, Copy, PartialEq)]
struct Camera {
    width: usize,
    height: usize,
    cx: f64,
    cy: f64,
    k1x: f64,
    k1y: f64,
}

impl Camera {
    const DONUT_C: Camera =
        Camera { width: 80, height: 22, cx: 40.0, cy: 12.0, k1x: 30.0, k1y: 15.0 };

    /// donut.c's own camera for its size and scene, and otherwise the largest that cuts off no pose.
    /// `aspect` is the height of a cell over its width.
    fn new(width: usize, height: usize, aspect: f64, scene: &Scene) -> Camera {
        if (width, height, aspect) == (80, 22, 2.0) && *scene == Scene::DONUT_C {
            return Camera::DONUT_C;
        }
        let (w, h) = (width as f64, height as f64);
        let k1x = f64::min((w - 1.0) / 2.0, aspect * (h - 1.0) / 2.0) / scene.limb();
        let (cx, cy) = ((w + 1.0) / 2.0, (h + 1.0) / 2.0);
        Camera { width, height, cx, cy, k1x, k1y: k1x / aspect }
    }
}

// ---- Rendering -----------------------------------------------------------------------------------

/// From dark to bright.
const RAMP: &[u8; 12] = b".,-~:;=!*#$@";

/// The glyph of a luminance L, from -sqrt 2 to sqrt 2; what faces away from the light is dark.
fn glyph(luminance: f64) -> u8 {
    // A cast saturates: everything negative is 0.
    RAMP[usize::from((8.0 * luminance) as u8)]
}

/// Draws one picture of the donut after another.
struct Renderer {
    scene: Scene,
    camera: Camera,
    method: Method,
    /// The glyphs: `width * height` bytes, row by row from the top, a blank where the donut is not.
    framebuffer: Vec<u8>,
    splat: Option<Splat>,
}

impl Renderer {
    fn new(scene: Scene, camera: Camera, method: Method) -> Renderer {
        let framebuffer = vec![b' '; camera.width * camera.height];
        Renderer { scene, camera, method, framebuffer, splat: None }
    }

    /// Draws the donut turned by A and B into the framebuffer.
    fn render_frame(&mut self, a: f64, b: f64) {
        self.framebuffer.fill(b' ');
        if self.method == Method::Classic {
            let splat = self.splat.get_or_insert_with(|| Splat::new(&self.camera));
            splat.draw(a as f32, b as f32, &self.camera, &mut self.framebuffer);
        } else {
            trace(a, b, &self.scene, &self.camera, &mut self.framebuffer);
        }
    }
}

// ---- classic: donut.c's splat --------------------------------------------------------------------

/// An angle's sine and cosine, taken in f64 and rounded to f32 as C does with `double sin()`.
fn sin_cos(angle: f32) -> (f32, f32) {
    let (sin, cos) = f64::from(angle).sin_cos();
    (sin as f32, cos as f32)
}

/// donut.c's clock: an angle is a `float`, advanced in `double` and rounded again.
fn advance(angle: f32, step: f64) -> f32 {
    (f64::from(angle) + step) as f32
}

/// Sines and cosines once round a circle, as in donut.c's `for (float i = 0; 6.28 > i; i += step)`.
///
/// At donut.c's steps no sample lies between 6.28 and 2 pi, and at finer ones it leaves a seam.
struct Circle {
    sin: Vec<f32>,
    cos: Vec<f32>,
}

impl Circle {
    fn new(step: f64) -> Circle {
        let angles = std::iter::successors(Some(0.0), |&angle| Some(advance(angle, step)));
        let angles = angles.take_while(|&angle| f64::from(angle) < TAU);
        let (sin, cos) = angles.map(sin_cos).unzip();
        Circle { sin, cos }
    }
}

/// The surface as a cloud of samples, of which the nearest in each cell shows.
struct Splat {
    theta: Circle,
    phi: Circle,
    ring: Ring,
    /// 1/z of what each cell shows, larger is nearer; 0 where the donut is not.
    zbuffer: Vec<f32>,
}

impl Splat {
    /// At larger scales than donut.c's the two angles' steps shrink in proportion, so that the nearest
    /// point of the surface again moves at most a cell in a step, or there would be holes.
    fn new(camera: &Camera) -> Splat {
        let shrink = f64::min(1.0, Camera::DONUT_C.k1x / camera.k1x.max(camera.k1y));
        let (theta, phi) = (Circle::new(0.07 * shrink), Circle::new(0.02 * shrink));
        let ring = Ring::new(phi.sin.len());
        Splat { theta, phi, ring, zbuffer: vec![0.0; camera.width * camera.height] }
    }

    fn draw(&mut self, a: f32, b: f32, camera: &Camera, framebuffer: &mut [u8]) {
        let pose = (sin_cos(a), sin_cos(b));
        self.zbuffer.fill(0.0);
        // Samples that fall outside the picture go to cell 0, where nothing is ever nearer.
        self.zbuffer[0] = f32::INFINITY;
        for (&sin_theta, &cos_theta) in self.theta.sin.iter().zip(&self.theta.cos) {
            self.ring.sample((sin_theta, cos_theta), &self.phi, pose, camera);
            self.ring.locate(camera);
            self.ring.plot(&mut self.zbuffer, framebuffer);
        }
    }
}

/// The samples round the ring at one theta, one for each phi.
///
/// An array to a quantity, each filled in a loop of its own, is what the compiler makes vectors of:
/// it costs a seventh of donut.c's time.
struct Ring {
    /// 1/z, seen from the viewer.
    ooz: Vec<f32>,
    /// Screen position, in cells.
    x: Vec<f32>,
    y: Vec<f32>,
    luminance: Vec<f32>,
    /// Index into the framebuffer.
    cell: Vec<u32>,
}

impl Ring {
    fn new(samples: usize) -> Ring {
        let zeros = || vec![0.0; samples];
        Ring { ooz: zeros(), x: zeros(), y: zeros(), luminance: zeros(), cell: vec![0; samples] }
    }

    /// donut.c's formulas, in f32 and in its order of operations, for one theta and every phi.
    fn sample(
        &mut self,
        (sin_theta, cos_theta): (f32, f32),
        phi: &Circle,
        ((sin_a, cos_a), (sin_b, cos_b)): ((f32, f32), (f32, f32)),
        camera: &Camera,
    ) {
        let (r2, k2) = (Scene::DONUT_C.r2 as f32, Scene::DONUT_C.k2 as f32);
        let (cx, cy) = (camera.cx as f32, camera.cy as f32);
        let (k1x, k1y) = (camera.k1x as f32, camera.k1y as f32);
        let h = cos_theta + r2;
        let phi = phi.sin.iter().zip(&phi.cos);
        let samples = phi.zip(&mut self.ooz).zip(&mut self.x).zip(&mut self.y);
        for (((((&sin_phi, &cos_phi), ooz), x), y), luminance) in samples.zip(&mut self.luminance) {
            *ooz = 1.0 / (sin_phi * h * sin_a + sin_theta * cos_a + k2);
            let t = sin_phi * h * cos_a - sin_theta * sin_a;
            *x = cx + k1x * *ooz * (cos_phi * h * cos_b - t * sin_b);
            *y = cy + k1y * *ooz * (cos_phi * h * sin_b + t * cos_b);
            *luminance = (sin_theta * sin_a - sin_phi * cos_theta * cos_a) * cos_b
                - sin_phi * cos_theta * sin_a
                - sin_theta * cos_a
                - cos_phi * cos_theta * sin_b;
        }
    }

    /// The cell of each sample, or 0 for one outside the picture.
    fn locate(&mut self, camera: &Camera) {
        let (width, height) = (camera.width as i32, camera.height as i32);
        for ((&x, &y), cell) in self.x.iter().zip(&self.y).zip(&mut self.cell) {
            let (column, row) = (truncate(x), truncate(y));
            let inside = (0 < column) & (column < width) & (0 < row) & (row < height);
            *cell = if inside { (column + width * row) as u32 } else { 0 };
        }
    }

    /// Puts each sample that is nearer than what its cell shows into the picture.
    fn plot(&self, zbuffer: &mut [f32], framebuffer: &mut [u8]) {
        for ((&cell, &ooz), &luminance) in self.cell.iter().zip(&self.ooz).zip(&self.luminance) {
            let cell = cell as usize;
            if ooz > zbuffer[cell] {
                zbuffer[cell] = ooz;
                framebuffer[cell] = glyph(luminance.into());
            }
        }
    }
}

/// `value as i32` for 0 <= value < 2^23, nothing positive below, in operations that vectorise on every
/// machine.
fn truncate(value: f32) -> i32 {
    /// 2^23: from here on a float's last bit is worth 1, so a sum is rounded to a whole number.
    const WHOLE: f32 = 8_388_608.0;
    let rounded = value + WHOLE;
    let up = rounded - WHOLE > value;
    rounded.to_bits() as i32 - WHOLE.to_bits() as i32 - i32::from(up)
}

// ---- exact: one ray a cell -----------------------------------------------------------------------

/// Rays are solved four at a time, an array to a quantity, which the compiler makes vectors of.
const LANES: usize = 4;
type Lanes = [f64; LANES];

/// Where a ray arrives that misses.
const FAR: f64 = f64::INFINITY;

/// Draws what the ray through each cell's centre hits first.
///
/// Of how the donut is turned only its axis matters, for it is a surface of revolution. That is why
/// two angles are enough.
fn trace(a: f64, b: f64, scene: &Scene, camera: &Camera, framebuffer: &mut [u8]) {
    let ((sin_a, cos_a), (sin_b, cos_b)) = (a.sin_cos(), b.sin_cos());
    let axis = [sin_a * sin_b, -sin_a * cos_b, cos_a];
    let limb = scene.limb();
    for (row, cells) in framebuffer.chunks_exact_mut(camera.width).enumerate().skip(1) {
        let dy = (row as f64 + 0.5 - camera.cy) / camera.k1y;
        // Rays beyond the limb have nothing to hit.
        let half = (limb * limb - dy * dy).max(0.0).sqrt() * camera.k1x;
        let first = (camera.cx - half) as usize;
        let last = ((camera.cx + half) as usize + 1).min(camera.width);
        for column in (first..last).step_by(LANES) {
            let x = |lane| (column + lane) as f64 + 0.5;
            let dx = std::array::from_fn(|lane| (x(lane) - camera.cx) / camera.k1x);
            let rays = Rays::cast(&dx, dy, scene, &axis);
            let hits = rays.first_hits();
            let luminance = rays.luminance(&hits, scene, &axis);
            for ((cell, s), luminance) in cells[column..].iter_mut().zip(hits).zip(luminance) {
                if s < FAR {
                    *cell = glyph(luminance);
                }
            }
        }
    }
}

/// Rays from the viewer, and where they meet the donut.
///
/// A ray is `P = P0 + s U`: U is its unit direction, P0 its point nearest to the donut's centre. The
/// donut is where `(|P|^2 + R2^2 - R1^2)^2 = 4 R2^2 (|P|^2 - z^2)`, z being the height over the plane
/// of the ring. Along the ray this is `G(s) = s^4 + p s^2 + q s + r = 0`; G is positive outside.
/// Measured from P0 it has no cubic term, and small coefficients however far away the viewer is.
#[derive(Default)]
struct Rays {
    p: Lanes,
    q: Lanes,
    r: Lanes,
    /// `|P0|^2`, and half of the chord in the sphere that the donut never leaves.
    q0: Lanes,
    h: Lanes,
    /// Height over the plane of the ring: of P0, and gained with each unit of s.
    z0: Lanes,
    uz: Lanes,
    /// Product with the light (0, -1, -1): of P0, and of U.
    l0: Lanes,
    lu: Lanes,
}

impl Rays {
    /// The rays in the directions (dx, dy, 1), for a donut whose axis is the unit vector `axis`.
    fn cast(dx: &Lanes, dy: f64, scene: &Scene, axis: &[f64; 3]) -> Rays {
        let Scene { r2, k2 } = *scene;
        let (inner, outer) = ((r2 - 1.0) * (r2 - 1.0), (r2 + 1.0) * (r2 + 1.0));
        let dot = |[x, y, z]: [f64; 3]| x * axis[0] + y * axis[1] + z * axis[2];
        debug_assert!(dy.is_finite() && dx.iter().all(|dx| dx.is_finite()));
        let mut rays = Rays::default();
        for (i, &dx) in dx.iter().enumerate() {
            let cos = 1.0 / (1.0 + dx * dx + dy * dy).sqrt();
            let u = [dx * cos, dy * cos, cos];
            // The viewer is at (0, 0, -K2). Over K2, this is how P0 lies from the centre.
            let p0 = [u[0] * cos, u[1] * cos, -(u[0] * u[0] + u[1] * u[1])];
            let (q0, z0, uz) = (k2 * k2 * -p0[2], k2 * dot(p0), dot(u));
            rays.p[i] = 2.0 * (q0 - r2 * r2 - 1.0) + 4.0 * r2 * r2 * uz * uz;
            rays.q[i] = 8.0 * r2 * r2 * z0 * uz;
            rays.r[i] = (q0 - inner) * (q0 - outer) + 4.0 * r2 * r2 * z0 * z0;
            (rays.q0[i], rays.h[i]) = (q0, (outer - q0).max(0.0).sqrt());
            (rays.z0[i], rays.uz[i]) = (z0, uz);
            (rays.l0[i], rays.lu[i]) = (-k2 * (p0[1] + p0[2]), -(u[1] + u[2]));
        }
        rays
    }

    /// Distance s of each ray's first hit, infinite where it misses.
    fn first_hits(&self) -> Lanes {
        let mut search = Search::new(self);
        let mut steps = 0;
        while search.is_running() && steps < Search::MOST_STEPS {
            search.step(self);
            steps += 1;
        }
        debug_assert!(!search.is_running(), "Newton takes too many steps");
        search.s
    }

    /// Light times normal where each ray hits. At the point P, of height z and at rho from the axis n,
    /// the normal is `(P - z n) (1 - R2 / rho) + z n`.
    fn luminance(&self, s: &Lanes, scene: &Scene, axis: &[f64; 3]) -> Lanes {
        let axis_light = -(axis[1] + axis[2]);
        std::array::from_fn(|i| {
            let z = self.z0[i] + s[i] * self.uz[i];
            let rho = (self.q0[i] + s[i] * s[i] - z * z).sqrt();
            let light = self.l0[i] + s[i] * self.lu[i];
            (light - z * axis_light) * (1.0 - scene.r2 / rho) + z * axis_light
        })
    }
}

/// Newton's search for the first root of each ray's G.
///
/// G has two valleys at most, and is convex outside of its inflections -w and w. Coming from the left
/// Newton goes down to the first root and never beyond, if the left valley holds one. If not, a step
/// finds G rising, or goes beyond -w. The search then starts again at w, from where Newton reaches a
/// root in the right valley from either side, or finds G rising once more: the ray misses.
struct Search {
    s: Lanes,
    last_step: Lanes,
    /// How far s may go: to -w in the left valley.
    limit: Lanes,
    /// Where to start again: at w, and then nowhere.
    second: Lanes,
}

impl Search {
    /// Where to stop, in units of the tube's radius.
    const TOLERANCE: f64 = 1e-9;
    /// Five steps are the mean. Rays that graze the donut take up to 18.
    const MOST_STEPS: usize = 32;

    fn new(rays: &Rays) -> Search {
        let far = [FAR; LANES];
        let mut search = Search { s: far, last_step: far, limit: far, second: far };
        for i in 0..LANES {
            let w = (-rays.p[i] / 6.0).max(0.0).sqrt();
            (search.s[i], search.limit[i], search.second[i]) = (-rays.h[i], -w, w);
        }
        search
    }

    /// Whether any lane has neither arrived at a root nor run out of starts.
    fn is_running(&self) -> bool {
        let open = |i: usize| self.last_step[i].abs() > Search::TOLERANCE && self.s[i] < FAR;
        (0..LANES).any(open)
    }

    /// One step of each lane, without branches, so that it vectorises.
    fn step(&mut self, rays: &Rays) {
        for i in 0..LANES {
            let (s, p, q, r) = (self.s[i], rays.p[i], rays.q[i], rays.r[i]);
            let slope = (4.0 * s * s + 2.0 * p) * s + q;
            let step = (((s * s + p) * s + q) * s + r) / slope;
            let lost = (slope >= 0.0) | (s - step > self.limit[i]);
            self.s[i] = select(lost, self.second[i], s - step);
            self.last_step[i] = select(lost, FAR, step);
            self.limit[i] = select(lost, FAR, self.limit[i]);
            self.second[i] = select(lost, FAR, self.second[i]);
        }
    }
}

fn select(condition: bool, yes: f64, no: f64) -> f64 {
    if condition { yes } else { no }
}

// ---- Encoding ------------------------------------------------------------------------------------

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

    /// What begins a frame that clears the screen, what begins any other frame, what comes before each
    /// row, and what ends the frame.
    fn around_rows(self) -> (&'static str, &'static str, &'static str, &'static str) {
        match self {
            // donut.c's own bytes.
            Output::Pipe => ("\x1b[2J\x1b[H", "\x1b[H", "\n", "\n"),
            // A synchronized update shows no half frame. In raw mode a newline needs its \r.
            Output::Terminal => {
                ("\x1b[?2026h\x1b[2J\x1b[H", "\x1b[?2026h\x1b[H", "\r\n", "\x1b[?2026l")
            }
            Output::DumbTerminal => ("", "", "\n", "\n"),
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
        Encoder { output, color, clear: true }
    }

    /// Appends a frame to `out`.
    fn encode(&mut self, framebuffer: &[u8], width: usize, out: &mut Vec<u8>) {
        let (clear, home, newline, end) = self.output.around_rows();
        out.extend_from_slice(if self.clear { clear } else { home }.as_bytes());
        out.extend_from_slice(self.color.0.as_bytes());
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

/// How long the code of a key may pause behind its Esc.
const ESCAPE: Duration = Duration::from_millis(20);
/// In this time the other threads have surely seen that the terminal was given back.
const SETTLE: Duration = Duration::from_millis(50);
/// How long the loop waits at most before it looks whether the terminal is still there.
const LOOK: Duration = Duration::from_millis(500);
/// Bytes that are written to a terminal at once: a picture of 80x22 is one piece.
const PIECE: usize = 2048;

/// Standard output and, if it is a terminal, what the donut does with it.
///
/// The main thread takes the terminal, writes to it and gives it back. Other threads read keys and
/// receive signals, and send actions to the main thread.
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

    /// Starts to send what keys and signals ask for, and has a panic give the terminal back.
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

    /// Every signal that is not left to its default.
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
            // To read in the background stops the program, with all its threads.
            while !self.taken.load(SeqCst) {
                thread::sleep(SETTLE);
            }
            // A new size ends this, also the one that is made up when the terminal is given back.
            while let Event::Key(mut key) = event::read()? {
                // Behind an Esc that was pressed comes no key at once; behind one that begins the code of
                // some other key, and came first over a slow line, comes the rest.
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

    /// Sends an action to the loop. After a Quit it does not return: it watches the end.
    fn send(&self, sender: &Sender, action: Action) {
        let quit = matches!(action, Action::Quit(_));
        self.ending.fetch_or(quit, SeqCst);
        let _ = sender.send(Ok(action));
        if quit {
            self.end_if_nobody_reads();
        }
    }

    /// Waits for the main thread to end the program, unless one write takes 0.7 s: then the terminal
    /// does not read. What it did not read is dropped, so that the main thread can go on.
    fn end_if_nobody_reads(&self) -> ! {
        let (mut writes, mut waits) = (0, 0);
        while waits < 7 {
            let now = self.writes.load(SeqCst);
            waits = if now == writes && now % 2 == 1 { waits + 1 } else { 0 };
            writes = now;
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

    /// Whether the terminal is the donut's to use. In its background it is the shell's or another
    /// job's: to change its settings there stops the program, with all its threads.
    fn is_in_front(&self) -> io::Result<bool> {
        if self.output == Output::Terminal { system::is_in_front(self.keys) } else { Ok(true) }
    }

    /// Takes the terminal. False if the donut has it already.
    fn take(&self) -> io::Result<bool> {
        if self.output != Output::Terminal || self.taken.swap(true, SeqCst) {
            return Ok(false);
        }
        if self.keys {
            // Enabling does nothing while crossterm believes in a raw mode that a shell has undone.
            terminal::disable_raw_mode()?;
            terminal::enable_raw_mode()?;
        }
        let mut bytes = Vec::new();
        if self.alternate {
            queue!(bytes, EnterAlternateScreen)?;
        }
        queue!(bytes, Hide)?;
        self.write(&bytes)?;
        Ok(true)
    }

    /// Gives the terminal back as it was found, if the donut has it. In the background that is all but
    /// its settings, which the shell has restored.
    fn give_back(&self) -> io::Result<()> {
        if !self.taken.swap(false, SeqCst) {
            return Ok(());
        }
        system::wake_reader();
        let in_front = self.is_in_front()?;
        let mut bytes = Vec::new();
        queue!(bytes, EndSynchronizedUpdate, ResetColor, Show)?;
        if self.alternate {
            queue!(bytes, LeaveAlternateScreen)?;
        } else {
            bytes.extend(b"\r\n");
        }
        if in_front {
            terminal::disable_raw_mode()?;
        }
        if in_front || system::may_write_in_background()? { self.write(&bytes) } else { Ok(()) }
    }

    /// Writes a frame: at once on a pipe, and in pieces on a terminal. Once the program is about to
    /// end, what is left of it is not worth waiting for.
    fn write_frame(&self, frame: &[u8]) -> io::Result<()> {
        let size = if self.output == Output::Terminal { PIECE } else { frame.len() };
        let mut pieces = frame.chunks(size).take_while(|_| !self.ending.load(SeqCst));
        pieces.try_for_each(|piece| self.write(piece))
    }

    fn write(&self, piece: &[u8]) -> io::Result<()> {
        self.writes.fetch_add(1, SeqCst);
        let written = (&self.stdout).write_all(piece);
        self.writes.fetch_add(1, SeqCst);
        written
    }

    /// Columns and rows of the terminal; 80x24 for one that does not know, and for a pipe.
    fn size(&self) -> io::Result<(u16, u16)> {
        let size = if self.output == Output::Pipe { (0, 0) } else { system::terminal_size()? };
        Ok(if size.0 > 0 && size.1 > 0 { size } else { (80, 24) })
    }
}

/// What differs between operating systems.
#[cfg(unix)]
mod system {
    use std::fs::File;
    use std::io;
    use std::os::fd::AsFd;

    use rustix::io::Errno;
    use rustix::process::{Signal, getpgrp, getsid, kill_current_process_group};
    use rustix::termios::{
        self, Action, LocalModes, QueueSelector, tcflow, tcflush, tcgetattr, tcgetpgrp,
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
            // It controls no session of ours: nobody can be in front of us.
            Err(_) => Ok(true),
        }
    }

    /// Whether the terminal lets programs in its background write.
    pub fn may_write_in_background() -> io::Result<bool> {
        Ok(!tcgetattr(io::stdout())?.local_modes.contains(LocalModes::TOSTOP))
    }

    /// Whether there is a shell to continue what is stopped: none waits for a session's first group.
    pub fn can_suspend() -> bool {
        getsid(None) != Ok(getpgrp())
    }

    /// Stops the whole job, as the terminal's own Ctrl-Z does: its shell waits for the first process.
    pub fn suspend() -> io::Result<()> {
        Ok(kill_current_process_group(Signal::STOP)?)
    }

    /// Has the reader of keys look up from them: crossterm reports a new size.
    pub fn wake_reader() {
        let _ = signal_hook::low_level::raise(signal_hook::consts::SIGWINCH);
    }

    /// Drops what is written but not read, also where Ctrl-S holds it, and wakes a write that waits.
    pub fn drop_unread_output() -> io::Result<()> {
        tcflush(io::stdout(), QueueSelector::OFlush)?;
        tcflow(io::stdout(), Action::OOff)?;
        Ok(tcflow(io::stdout(), Action::OOn)?)
    }

    /// Ends the program as the signal would have.
    pub fn end_by(signal: i32) -> io::Result<()> {
        signal_hook::low_level::emulate_default_handler(signal)
    }
}

/// What differs between operating systems: Windows has no background and no job to suspend.
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

    pub fn wake_reader() {}

    pub fn drop_unread_output() -> io::Result<()> {
        Ok(())
    }

    pub fn end_by(_signal: i32) -> io::Result<()> {
        Ok(())
    }
}

// ---- Loop ----------------------------------------------------------------------------------------

/// The angles A and B, frame after frame.
///
/// The exact clock counts: it is at `origin + frames * spin`. donut.c's adds to a `float` each frame,
/// so that its origin moves along.
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

    /// Whether floats still follow the spin, to a tenth.
    ///
    /// From 2^17 radians, which A reaches at frame 3,345,245, they turn steps of 0.04 into 0.047;
    /// at 2^20, from frame 22,918,663, they stand still.
    fn floats_follow(&self) -> bool {
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
    /// What `auto` comes to for this picture.
    fn choose(self, camera: &Camera, clock: &Clock) -> Method {
        match self {
            Method::Auto if *camera == Camera::DONUT_C && clock.floats_follow() => Method::Classic,
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
    /// Whether the shading is off: every cell of the donut a dot.
    flat: bool,
    paused: bool,
    /// When the next frame is to be drawn.
    due: Instant,
    /// The bytes of a frame.
    out: Vec<u8>,
}

/// Shows the donut until there are frames enough, somebody says stop, or nobody reads any more.
fn run(options: &Options, scene: Scene) -> io::Result<()> {
    if options.frames == Some(0) {
        return Ok(());
    }
    let output = Output::detect();
    let mut animation = Animation::new(options, scene, output)?;
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
    // 31 years are as good as any longer time.
    Duration::from_secs_f64(if fps > 0.0 { (1.0 / fps).min(1e9) } else { 0.0 })
}

/// The camera for the size of the options, clipped to the terminal.
fn fit(options: &Options, scene: &Scene, output: Output, (columns, rows): (u16, u16)) -> Camera {
    let clip = |asked: Option<u16>, most: u16| match asked {
        Some(asked) if output == Output::Pipe => asked,
        asked => asked.unwrap_or(4096).min(most),
    };
    let width = clip(options.width, columns);
    let height = clip(options.height, rows.saturating_sub(2).max(1));
    Camera::new(width.into(), height.into(), options.aspect, scene)
}

impl Animation<'_> {
    fn new(options: &Options, scene: Scene, output: Output) -> io::Result<Animation<'_>> {
        let screen = Arc::new(Screen::new(output, options.frames.is_none())?);
        let size = screen.size()?;
        Ok(Animation {
            options,
            screen,
            size,
            renderer: Renderer::new(scene, fit(options, &scene, output, size), options.method),
            clock: Clock { origin: [options.a, options.b], frames: 0, spin: options.spin },
            encoder: Encoder::new(output, options.color),
            flat: false,
            paused: false,
            due: Instant::now(),
            out: Vec::new(),
        })
    }

    /// Draws frames as they come due, and obeys in between. Returns the signal that ended it, if any.
    fn play(&mut self, actions: &Receiver) -> io::Result<Option<i32>> {
        let interval = interval(self.options.fps);
        let (mut frames, mut wait) = (0, Duration::ZERO);
        while frames < self.options.frames.unwrap_or(u64::MAX) {
            // All that waits is obeyed before the next drawing.
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
            let left = self.due.saturating_duration_since(Instant::now());
            wait = if self.paused { LOOK } else { left.min(LOOK) };
        }
        Ok(None)
    }

    fn obey(&mut self, action: Action, actions: &Receiver) -> io::Result<ControlFlow<Option<i32>>> {
        match action {
            Action::Quit(signal) => return Ok(ControlFlow::Break(signal)),
            Action::Pause => (self.paused, self.due) = (!self.paused, Instant::now()),
            Action::Shade => self.flat = !self.flat,
            Action::Redraw => self.encoder.clear = true,
            // Whoever had the terminal meanwhile: the loop takes it anew.
            Action::Resume => self.screen.give_back()?,
            Action::Suspend if system::can_suspend() => return self.suspend(actions),
            Action::Suspend => {}
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Gives the terminal back and stops, until the shell says `fg` or `bg`.
    fn suspend(&mut self, actions: &Receiver) -> io::Result<ControlFlow<Option<i32>>> {
        self.screen.give_back()?;
        for stop in [true, false] {
            // Before the stop the reader of keys must have seen that it may no longer read. What was
            // pressed around the stop is dropped: a second Ctrl-Z must not stop it at once again.
            let end = Instant::now() + SETTLE;
            while let Ok(action) =
                actions.recv_timeout(end.saturating_duration_since(Instant::now()))
            {
                if let Action::Quit(signal) = action? {
                    return Ok(ControlFlow::Break(signal));
                }
            }
            if stop {
                system::suspend()?;
            }
        }
        Ok(ControlFlow::Continue(()))
    }

    /// Makes the picture fit the terminal. True if its size has changed.
    fn fit(&mut self) -> io::Result<bool> {
        let size = self.screen.size()?;
        let changed = size != self.size;
        if changed {
            (self.size, self.encoder.clear) = (size, true);
            let scene = self.renderer.scene;
            let camera = fit(self.options, &scene, self.screen.output, size);
            if camera != self.renderer.camera {
                self.renderer = Renderer::new(scene, camera, self.options.method);
            }
        }
        Ok(changed)
    }

    fn draw(&mut self) -> io::Result<()> {
        let camera = self.renderer.camera;
        self.renderer.method = self.options.method.choose(&camera, &self.clock);
        let [a, b] = self.clock.angles();
        self.renderer.render_frame(a, b);
        if self.flat {
            self.flatten();
        }
        self.out.clear();
        self.encoder.encode(&self.renderer.framebuffer, camera.width, &mut self.out);
        self.screen.write_frame(&self.out)
    }

    fn flatten(&mut self) {
        let donut = self.renderer.framebuffer.iter_mut().filter(|cell| **cell != b' ');
        donut.for_each(|cell| *cell = RAMP[0]);
    }
}

#[cfg(test)]
#[path = "../tests/unit/mod.rs"]
mod tests;
