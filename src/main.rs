//! donut.c, Andy Sloane's spinning ASCII torus of 2006, byte for byte.
//!
//! The whole program, in the order of the data:
//!
//! ```text
//! Options -> Camera -> render_frame(a, b) -> framebuffer -> encode -> standard output
//! ```
//!
//! # Letters
//!
//! The names are those of the article that explains donut.c,
//! <https://www.a1k0n.net/2011/07/20/donut-math.html>:
//!
//! | letter | what it is |
//! |---|---|
//! | R1 | radius of the tube, and the unit of length: 1 |
//! | R2 | radius of the ring, from the donut's centre to the tube's: 2 |
//! | K2 | distance from the viewer to the donut's centre: 5 |
//! | K1 | scale of the projection, in cells; `k1x` across and `k1y` down |
//! | theta | angle round the tube |
//! | phi | angle round the ring |
//! | A, B | the donut's turn about the x axis and the z axis |
//!
//! Axes: x to the right, y *down* the screen, z away from the viewer. Angles are in radians.
//! The names come from the article but the arithmetic from donut.c, and where the two differ
//! (the article turns other ways, draws larger, and has y upwards) donut.c wins.

use std::f64::consts::TAU;
use std::fs::File;
use std::io::{self, ErrorKind, IsTerminal, Write};
#[cfg(unix)]
use std::os::fd::AsFd;
#[cfg(windows)]
use std::os::windows::io::AsHandle;
use std::process::ExitCode;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::{Duration, Instant};
use std::{fmt::Display, ops::RangeInclusive, panic, str::FromStr};

use clap::{Parser, ValueEnum};
use crossterm::cursor::{Hide, Show};
use crossterm::execute;
use crossterm::style::{self, Color, SetForegroundColor};
use crossterm::terminal::{self, EnterAlternateScreen, LeaveAlternateScreen};

// ---------------------------------------------------------------------------------------------
// Options
// ---------------------------------------------------------------------------------------------

/// A spinning ASCII donut: donut.c, byte for byte.
///
/// On a terminal the donut fills the screen until Ctrl-C. Into a pipe or a file go donut.c's own
/// bytes, paced by --fps.
#[derive(Parser)]
#[command(version, after_help = EXAMPLES)]
struct Options {
    /// Columns, 1 to 4096 [default: the terminal's, otherwise 80]
    #[arg(long, value_name = "COLS", allow_hyphen_values = true, value_parser = cells)]
    width: Option<u16>,

    /// Rows, 1 to 4096 [default: the terminal's less 2, otherwise 22]
    #[arg(long, value_name = "ROWS", allow_hyphen_values = true, value_parser = cells)]
    height: Option<u16>,

    /// Frames a second: 0.001 to 1000, or 0 for as fast as possible
    #[arg(
        long,
        value_name = "N",
        default_value = "30",
        allow_hyphen_values = true
    )]
    #[arg(value_parser = frame_rate)]
    fps: f64,

    /// Stop after N frames [default: never]
    #[arg(long, value_name = "N", allow_hyphen_values = true, value_parser = frame_count)]
    frames: Option<u64>,

    /// How a cell gets its glyph
    #[arg(long, value_enum, default_value_t)]
    method: Method,

    /// The first frame's turn about the x axis, in radians, -1e9 to 1e9
    #[arg(
        short = 'A',
        value_name = "RAD",
        default_value = "0",
        allow_hyphen_values = true
    )]
    #[arg(value_parser = angle)]
    a: f64,

    /// The first frame's turn about the z axis, in radians, -1e9 to 1e9
    #[arg(
        short = 'B',
        value_name = "RAD",
        default_value = "0",
        allow_hyphen_values = true
    )]
    #[arg(value_parser = angle)]
    b: f64,

    /// Radians that A and B advance each frame, each -1e9 to 1e9
    #[arg(
        long,
        value_name = "DA,DB",
        default_value = "0.04,0.02",
        allow_hyphen_values = true
    )]
    #[arg(value_parser = angle_pair)]
    spin: (f64, f64),

    /// One colour for the donut: a name (red, dark_cyan, ...), 0 to 255, or #rrggbb
    #[arg(long, allow_hyphen_values = true, value_parser = color)]
    color: Option<Color>,

    /// Height of a character cell over its width, 0.1 to 10
    #[arg(
        long,
        value_name = "RATIO",
        default_value = "2",
        allow_hyphen_values = true
    )]
    #[arg(value_parser = aspect)]
    aspect: f64,
}

const EXAMPLES: &str = "\
Keys:
  Ctrl-C  quit

Examples:
  donut -A 1 -B 1 --spin 0.08,0.03 --color cyan
  donut --width 120 --height 40 --frames 1 > donut.txt";

/// How a cell gets its glyph.
#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum Method {
    /// donut.c's own: dots strewn over the surface, the nearest in each cell wins
    #[default]
    Classic,
}

/// A number within `range`, or what was expected instead.
fn number<T>(text: &str, range: RangeInclusive<T>, kind: &str) -> Result<T, String>
where
    T: FromStr + PartialOrd + Display,
{
    let (low, high) = (range.start(), range.end());
    let expected = format!("expected {kind} from {low} to {high}");
    let value = text.parse().map_err(|_| &expected);
    value
        .ok()
        .filter(|value| range.contains(value))
        .ok_or(expected)
}

fn cells(text: &str) -> Result<u16, String> {
    number(text, 1..=4096, "a whole number")
}

fn frame_count(text: &str) -> Result<u64, String> {
    number(text, 0..=u64::MAX, "a whole number")
}

fn frame_rate(text: &str) -> Result<f64, String> {
    number(text, 0.0..=0.0, "").or_else(|_| number(text, 0.001..=1000.0, "0, or a number"))
}

fn angle(text: &str) -> Result<f64, String> {
    number(text, -1e9..=1e9, "a number")
}

fn angle_pair(text: &str) -> Result<(f64, f64), String> {
    let (a, b) = text
        .split_once(',')
        .ok_or("expected two numbers with a comma between them")?;
    Ok((angle(a)?, angle(b)?))
}

fn aspect(text: &str) -> Result<f64, String> {
    number(text, 0.1..=10.0, "a number")
}

fn color(text: &str) -> Result<Color, String> {
    let hex = text
        .strip_prefix('#')
        .filter(|hex| hex.len() == 6 && !hex.starts_with('+'));
    let color = if let Some(rgb) = hex.and_then(|hex| u32::from_str_radix(hex, 16).ok()) {
        let [_, r, g, b] = rgb.to_be_bytes();
        Some(Color::Rgb { r, g, b })
    } else if let Ok(index) = text.parse() {
        Some(Color::AnsiValue(index))
    } else {
        Color::try_from(text)
            .ok()
            .filter(|color| *color != Color::Reset)
    };
    color.ok_or_else(|| "expected a colour's name, a number from 0 to 255, or #rrggbb".into())
}

fn main() -> ExitCode {
    match run(&Options::parse()) {
        // A reader that goes away, as in `donut | head`, has seen enough.
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            // Nothing is left to do if standard error is gone as well.
            let _ = writeln!(io::stderr(), "donut: {error}");
            ExitCode::FAILURE
        }
        _ => ExitCode::SUCCESS,
    }
}

// ---------------------------------------------------------------------------------------------
// Scene and camera
// ---------------------------------------------------------------------------------------------

/// Radius of the tube: the unit of length.
const R1: f64 = 1.0;
/// Radius of the ring, from the donut's centre to the tube's.
const R2: f64 = 2.0;
/// Distance from the viewer to the donut's centre.
const K2: f64 = 5.0;

/// Where a point of space falls on the screen.
///
/// The point (X, Y, Z), relative to the donut's centre, is seen at
/// `x = cx + k1x X / (Z + K2)`, `y = cy + k1y Y / (Z + K2)`, in cells from the top left corner.
/// Cell (c, r) is the square [c, c+1) x [r, r+1). Column 0 and row 0 stay empty: donut.c's first
/// column is its newline, and it never draws on its first row.
#[derive(Clone, Copy)]
struct Camera {
    width: usize,
    height: usize,
    cx: f64,
    cy: f64,
    k1x: f64,
    k1y: f64,
}

impl Camera {
    /// donut.c's own camera at its 80x22, and otherwise the largest that cuts off no pose.
    ///
    /// `aspect` is the height of a cell over its width. No pose leaves the sphere of radius
    /// R1 + R2, which is seen as a circle of radius `limb` at the distance 1.
    fn new(width: usize, height: usize, aspect: f64) -> Camera {
        if (width, height, aspect) == (80, 22, 2.0) {
            return Camera {
                width,
                height,
                cx: 40.0,
                cy: 12.0,
                k1x: 30.0,
                k1y: 15.0,
            };
        }
        let (w, h) = (width as f64, height as f64);
        let limb = (R1 + R2) / (K2 * K2 - (R1 + R2) * (R1 + R2)).sqrt();
        let k1x = f64::min((w - 1.0) / 2.0, aspect * (h - 1.0) / 2.0) / limb;
        let (cx, cy) = ((w + 1.0) / 2.0, (h + 1.0) / 2.0);
        Camera {
            width,
            height,
            cx,
            cy,
            k1x,
            k1y: k1x / aspect,
        }
    }
}

// ---------------------------------------------------------------------------------------------
// Rendering
// ---------------------------------------------------------------------------------------------

/// From dark to bright, indexed by 8 L: L reaches sqrt 2, and 8 sqrt 2 is 11.3.
const RAMP: &[u8; 12] = b".,-~:;=!*#$@";

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
struct Turn {
    sin: Vec<f32>,
    cos: Vec<f32>,
}

impl Turn {
    fn new(step: f64) -> Turn {
        let angles = std::iter::successors(Some(0.0), |&angle| Some(advance(angle, step)));
        let angles = angles.take_while(|&angle| f64::from(angle) < TAU);
        let (sin, cos) = angles.map(sin_cos).unzip();
        Turn { sin, cos }
    }
}

/// One picture of the donut after another.
struct Renderer {
    camera: Camera,
    /// The glyphs: `width * height` bytes, row by row from the top; a blank where the donut is not.
    framebuffer: Vec<u8>,
    /// 1/z of what each cell shows, larger is nearer; 0 where the donut is not.
    zbuffer: Vec<f32>,
    theta: Turn,
    phi: Turn,
    ring: Ring,
}

impl Renderer {
    /// At other sizes than donut.c's the two angles' steps shrink until the nearest point of the
    /// surface, at `K2 - R1 - R2`, again moves at most a cell in a step, or there would be holes.
    fn new(camera: Camera) -> Renderer {
        let shrink = f64::min(1.0, 15.0 / (camera.k1x.max(camera.k1y) / (K2 - R1 - R2)));
        let phi = Turn::new(0.02 * shrink);
        Renderer {
            camera,
            framebuffer: vec![b' '; camera.width * camera.height],
            zbuffer: vec![0.0; camera.width * camera.height],
            theta: Turn::new(0.07 * shrink),
            ring: Ring::new(phi.sin.len()),
            phi,
        }
    }

    /// Draws the donut turned by A and B into the framebuffer.
    fn render_frame(&mut self, a: f32, b: f32) {
        let pose = (sin_cos(a), sin_cos(b));
        self.framebuffer.fill(b' ');
        self.zbuffer.fill(0.0);
        // Samples that fall outside the picture go to cell 0, where nothing is ever nearer.
        self.zbuffer[0] = f32::INFINITY;
        for (&sin_theta, &cos_theta) in self.theta.sin.iter().zip(&self.theta.cos) {
            self.ring
                .sample((sin_theta, cos_theta), &self.phi, pose, &self.camera);
            self.ring.locate(&self.camera);
            self.ring.plot(&mut self.zbuffer, &mut self.framebuffer);
        }
    }
}

/// The samples round the ring at one theta, one for each phi.
///
/// Kept as an array for each quantity, and filled one after another, so that the compiler can work
/// on several samples at once: this makes the program several times faster than donut.c.
struct Ring {
    /// 1/z, seen from the viewer.
    ooz: Vec<f32>,
    /// Screen position, in cells.
    x: Vec<f32>,
    y: Vec<f32>,
    /// 8 L, from -11.3 to 11.3.
    luminance: Vec<f32>,
    /// Index into the framebuffer.
    cell: Vec<u32>,
}

impl Ring {
    fn new(samples: usize) -> Ring {
        let zeros = || vec![0.0; samples];
        Ring {
            ooz: zeros(),
            x: zeros(),
            y: zeros(),
            luminance: zeros(),
            cell: vec![0; samples],
        }
    }

    /// donut.c's formulas, in f32 and in its order of operations, for one theta and every phi.
    fn sample(
        &mut self,
        (sin_theta, cos_theta): (f32, f32),
        phi: &Turn,
        ((sin_a, cos_a), (sin_b, cos_b)): ((f32, f32), (f32, f32)),
        camera: &Camera,
    ) {
        let (r2, k2) = (R2 as f32, K2 as f32);
        let (cx, cy) = (camera.cx as f32, camera.cy as f32);
        let (k1x, k1y) = (camera.k1x as f32, camera.k1y as f32);
        // Distance from the axis: the article's circlex.
        let h = cos_theta + r2;
        let phi = phi.sin.iter().zip(&phi.cos);
        let samples = phi.zip(&mut self.ooz).zip(&mut self.x).zip(&mut self.y);
        for (((((&sin_phi, &cos_phi), ooz), x), y), luminance) in samples.zip(&mut self.luminance) {
            *ooz = 1.0 / (sin_phi * h * sin_a + sin_theta * cos_a + k2);
            let t = sin_phi * h * cos_a - sin_theta * sin_a;
            *x = cx + k1x * *ooz * (cos_phi * h * cos_b - t * sin_b);
            *y = cy + k1y * *ooz * (cos_phi * h * sin_b + t * cos_b);
            *luminance = 8.0
                * ((sin_theta * sin_a - sin_phi * cos_theta * cos_a) * cos_b
                    - sin_phi * cos_theta * sin_a
                    - sin_theta * cos_a
                    - cos_phi * cos_theta * sin_b);
        }
    }

    /// The cell of each sample, or 0 for one outside the picture.
    fn locate(&mut self, camera: &Camera) {
        let (width, height) = (camera.width as i32, camera.height as i32);
        for ((&x, &y), cell) in self.x.iter().zip(&self.y).zip(&mut self.cell) {
            let (column, row) = (truncate(x), truncate(y));
            let inside = (0 < column) & (column < width) & (0 < row) & (row < height);
            *cell = if inside {
                (column + width * row) as u32
            } else {
                0
            };
        }
    }

    /// Puts each sample that is nearer than what its cell shows into the picture.
    fn plot(&self, zbuffer: &mut [f32], framebuffer: &mut [u8]) {
        for ((&cell, &ooz), &luminance) in self.cell.iter().zip(&self.ooz).zip(&self.luminance) {
            let cell = cell as usize;
            if ooz > zbuffer[cell] {
                zbuffer[cell] = ooz;
                // A negative luminance saturates to 0: what faces away from the light is dark.
                framebuffer[cell] = RAMP[usize::from(luminance as u8)];
            }
        }
    }
}

/// `value as i32` for 0 <= value < 2^22, in operations that vectorise on every machine.
fn truncate(value: f32) -> i32 {
    /// 2^23: from here on a float's last bit is worth 1, so a sum is rounded to a whole number.
    const WHOLE: f32 = 8_388_608.0;
    let rounded = value + WHOLE;
    let up = rounded - WHOLE > value;
    rounded.to_bits() as i32 - WHOLE.to_bits() as i32 - i32::from(up)
}

// ---------------------------------------------------------------------------------------------
// Encoding
// ---------------------------------------------------------------------------------------------

/// Appends one frame as a terminal is to read it: home, then each row behind its newline.
///
/// The newline stands for column 0, which the framebuffer leaves empty; `color` is the SGR
/// sequence to draw in, or empty.
fn encode(framebuffer: &[u8], width: usize, color: &str, out: &mut Vec<u8>) {
    out.extend_from_slice(b"\x1b[H");
    out.extend_from_slice(color.as_bytes());
    for row in framebuffer.chunks_exact(width) {
        out.push(b'\n');
        out.extend_from_slice(&row[1..]);
    }
    out.push(b'\n');
    if !color.is_empty() {
        out.extend_from_slice(b"\x1b[0m");
    }
}

// ---------------------------------------------------------------------------------------------
// Terminal
// ---------------------------------------------------------------------------------------------

/// The terminal while the donut has it: alternate screen, no cursor. Dropping it gives it back.
struct Screen;

impl Screen {
    fn enter() -> io::Result<Screen> {
        // Made before the first escape, so that a failure halfway is undone as well.
        let screen = Screen;
        let report = panic::take_hook();
        panic::set_hook(Box::new(move |panic| {
            Screen::leave();
            report(panic);
        }));
        execute!(io::stdout(), EnterAlternateScreen, Hide)?;
        Ok(screen)
    }

    fn leave() {
        // Nothing is left to do if the terminal is gone.
        let _ = execute!(io::stdout(), Show, LeaveAlternateScreen);
    }
}

impl Drop for Screen {
    fn drop(&mut self) {
        Screen::leave();
    }
}

/// Columns and rows of the terminal; 80x24 for one that does not know.
fn terminal_size() -> (u16, u16) {
    match terminal::size() {
        Ok((columns, rows)) if columns > 0 && rows > 0 => (columns, rows),
        _ => (80, 24),
    }
}

/// Standard output without std's line buffer, so that one write is one system call.
fn unbuffered_stdout() -> io::Result<File> {
    #[cfg(unix)]
    let handle = io::stdout().as_fd().try_clone_to_owned()?;
    #[cfg(windows)]
    let handle = io::stdout().as_handle().try_clone_to_owned()?;
    Ok(File::from(handle))
}

// ---------------------------------------------------------------------------------------------
// Loop
// ---------------------------------------------------------------------------------------------

/// Shows frame after frame until there are enough, somebody says stop, or nobody reads any more.
fn run(options: &Options) -> io::Result<()> {
    let (stop, stopped) = channel();
    let (mut width, mut height) = (80, 22);
    let _screen = if io::stdout().is_terminal() {
        let (columns, rows) = terminal_size();
        (width, height) = (columns, rows.saturating_sub(2).max(1));
        let stop = stop.clone();
        // The loop may have ended already: then nobody needs to hear it.
        ctrlc::set_handler(move || stop.send(()).unwrap_or(())).map_err(io::Error::other)?;
        Some(Screen::enter()?)
    } else {
        None
    };
    let width = usize::from(options.width.unwrap_or(width));
    let height = usize::from(options.height.unwrap_or(height));
    let mut renderer = Renderer::new(Camera::new(width, height, options.aspect));

    let mut color = String::new();
    if let Some(foreground) = options.color {
        style::force_color_output(true);
        color = SetForegroundColor(foreground).to_string();
    }
    let mut stdout = unbuffered_stdout()?;
    let mut out = b"\x1b[2J".to_vec();

    // An fps of 0 has no interval: every frame is due at once.
    let interval = Duration::try_from_secs_f64(1.0 / options.fps).unwrap_or_default();
    let mut due = Instant::now();
    let (mut a, mut b) = (options.a as f32, options.b as f32);
    let mut frame = 0;
    while options.frames != Some(frame) {
        // Absolute deadlines do not drift; after a stall it goes on from now, without a burst.
        let now = Instant::now();
        due = due.max(now);
        if stopped.recv_timeout(due - now) != Err(RecvTimeoutError::Timeout) {
            break;
        }
        renderer.render_frame(a, b);
        encode(&renderer.framebuffer, width, &color, &mut out);
        stdout.write_all(&out)?;
        out.clear();
        (a, b) = (advance(a, options.spin.0), advance(b, options.spin.1));
        frame += 1;
        due += interval;
    }
    Ok(())
}
