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

use std::f64::consts::TAU;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::ops::RangeInclusive;
#[cfg(unix)]
use std::os::fd::{AsFd, AsRawFd};
#[cfg(windows)]
use std::os::windows::io::AsHandle;
use std::process::{self, ExitCode};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::time::{Duration, Instant};
use std::{env, panic, thread};

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, ValueEnum, ValueHint};
use crossterm::event::{self, Event, KeyCode};
use crossterm::style::{self, Color, SetForegroundColor};
use crossterm::terminal;
#[cfg(unix)]
use {
    filedescriptor::{POLLIN, POLLOUT, poll, pollfd},
    rustix::fs::{Mode, OFlags},
    rustix::io::Errno,
    rustix::process::{getpgrp, getsid},
    rustix::termios::{
        Action, LocalModes, OptionalActions, OutputModes, QueueSelector, SpecialCodeIndex, tcflow,
        tcflush, tcgetattr, tcgetpgrp, tcgetwinsize, tcsetattr,
    },
    signal_hook::consts::{SIGCONT, SIGQUIT, SIGSTOP, SIGTSTP, SIGWINCH},
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
    /// The view for the size of the options, clipped to the terminal of this size.
    fn view(&self, output: Output, (columns, rows): (u16, u16)) -> View {
        let clip = |asked: Option<u16>, most: u16| match asked {
            Some(asked) if output == Output::Pipe => asked,
            asked => asked.unwrap_or(4096).min(most),
        };
        let width = clip(self.width, columns);
        let height = clip(self.height, rows.saturating_sub(2).max(1));
        let (r2, k2) = self.ratios();
        View::new(width.into(), height.into(), self.aspect, r2, k2)
    }

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

// ---- The loop ------------------------------------------------------------------------------------

/// The donut on the screen, frame after frame.
struct Animation<'a> {
    options: &'a Options,
    screen: Arc<Screen>,
    /// Columns and rows of the terminal.
    size: (u16, u16),
    renderer: Renderer,
    clock: Clock,
    /// How many frames have been drawn.
    frames: u64,
    /// When the next one is due.
    deadline: Instant,
    paused: bool,
    /// Whether to draw the last frame again.
    redraw: bool,
    /// Bytes that are not written yet.
    out: Vec<u8>,
}

/// Spins the donut until the last frame is shown, somebody ends it, or its reader goes away.
fn run(options: &Options) -> io::Result<()> {
    let screen = Screen::open(Output::detect(), options)?;
    let played = Animation::new(options, screen.clone())?.play();
    played.and(screen.restore())
}

impl Animation<'_> {
    fn new(options: &Options, screen: Arc<Screen>) -> io::Result<Animation<'_>> {
        let size = screen.size()?;
        Ok(Animation {
            options,
            renderer: Renderer::new(options.view(screen.output, size), options.method),
            screen,
            size,
            clock: Clock { origin: [options.a, options.b], frames: 0, spin: options.spin },
            frames: 0,
            deadline: Instant::now(),
            paused: false,
            redraw: false,
            out: Vec::new(),
        })
    }

    /// donut.c's `for (;;)`.
    ///
    /// Nothing waits but its last line. Bytes that the terminal has no room for are kept until it has,
    /// so that keys and signals are obeyed even if it is stalled.
    fn play(&mut self) -> io::Result<()> {
        let most = if self.screen.output == Output::DumbTerminal { 1 } else { u64::MAX };
        let last = self.options.frames.unwrap_or(most).min(most);
        let mut key_pressed = false;
        while !self.screen.quit.load(SeqCst) && (self.frames < last || !self.out.is_empty()) {
            if !self.screen.may_draw()? {
                self.out.clear();
                key_pressed = self.screen.wait(LOOK, false)?;
                continue;
            }
            let mut is_behind = !self.out.is_empty();
            self.fit()?;
            if self.screen.take()? {
                self.out = self.screen.escapes.take.into();
                (self.redraw, is_behind) = (true, false);
            }
            if key_pressed {
                self.obey_keys()?;
            }
            let is_due = !self.paused && self.deadline <= Instant::now();
            if (is_due || self.redraw) && !is_behind {
                self.draw(is_due);
            }
            self.screen.write(&mut self.out)?;
            let unwritten = !self.out.is_empty();
            let until_due = self.deadline.saturating_duration_since(Instant::now());
            let time = if self.paused || unwritten { LOOK } else { until_due.min(LOOK) };
            key_pressed = self.screen.wait(time, unwritten)?;
        }
        Ok(())
    }

    /// Makes the picture fit the terminal.
    fn fit(&mut self) -> io::Result<()> {
        let size = self.screen.size()?;
        if self.screen.resize.swap(false, SeqCst) || size != self.size {
            (self.size, self.redraw) = (size, true);
            self.out.extend(CLEAR.bytes());
            let view = self.options.view(self.screen.output, size);
            if view != self.renderer.view {
                let ramp = self.renderer.ramp;
                self.renderer = Renderer { ramp, ..Renderer::new(view, self.options.method) };
            }
        }
        Ok(())
    }

    fn obey_keys(&mut self) -> io::Result<()> {
        for key in self.screen.keys()? {
            match key {
                KeyCode::Char('q') | KeyCode::Esc => self.screen.quit.store(true, SeqCst),
                KeyCode::Char('p') => {
                    (self.paused, self.deadline) = (!self.paused, Instant::now());
                }
                KeyCode::Char(' ') => {
                    let is_flat = self.renderer.ramp == FLAT;
                    (self.renderer.ramp, self.redraw) = (if is_flat { RAMP } else { FLAT }, true);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Draws the next frame or, if that is not due yet, the last one again.
    fn draw(&mut self, is_due: bool) {
        if is_due && self.frames > 0 {
            self.clock.tick(self.renderer.method);
        }
        self.renderer.method = self.options.method.choose(&self.renderer.view, &self.clock);
        let [a, b] = self.clock.angles();
        self.renderer.render_frame(a, b);
        self.screen.escapes.encode(&self.renderer, &mut self.out);
        self.redraw = false;
        if is_due {
            // Deadlines count from one another, so they do not drift. A stall moves them all.
            self.deadline = (self.deadline + interval(self.options.fps)).max(Instant::now());
            self.frames += 1;
        }
    }
}

/// The time from one frame to the next. At 0 frames a second every frame is due at once.
fn interval(fps: f64) -> Duration {
    // 31 years are long enough. A longer time may not fit into a Duration.
    Duration::from_secs_f64(if fps > 0.0 { (1.0 / fps).min(1e9) } else { 0.0 })
}

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

/// Where the frames go.
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
        let is_dumb = || env::var_os("TERM").is_some_and(|term| term == "dumb");
        match io::stdout().is_terminal() {
            false => Output::Pipe,
            true if is_dumb() => Output::DumbTerminal,
            true => Output::Terminal,
        }
    }
}

const CLEAR: &str = "\x1b[2J";

/// What is written before the first frame, around each frame, and after the last.
struct Escapes {
    take: &'static str,
    begin: String,
    end: String,
    restore: &'static str,
}

impl Escapes {
    fn new(output: Output, options: &Options) -> Escapes {
        // 25 is the cursor, 1049 the alternate screen, and 2026 a synchronized update, in which no
        // half-drawn frame is seen.
        let (take, [begin, end], restore) = match output {
            // donut.c's own bytes.
            Output::Pipe => (CLEAR, ["\x1b[H", "\n"], ""),
            Output::DumbTerminal => ("", ["", "\n"], ""),
            Output::Terminal => {
                let frame = ["\x1b[?2026h\x1b[H", "\x1b[?2026l"];
                if options.frames.is_some() {
                    ("\x1b[?25l\x1b[2J", frame, "\x1b[?2026l\x1b[0m\x1b[?25h\n")
                } else {
                    ("\x1b[?1049h\x1b[?25l\x1b[2J", frame, "\x1b[?2026l\x1b[0m\x1b[?25h\x1b[?1049l")
                }
            }
        };
        let color = options.color.filter(|_| output != Output::DumbTerminal);
        // The option is explicit, and so stronger than NO_COLOR.
        style::force_color_output(true);
        let sgr = color.map(|color| SetForegroundColor(color).to_string()).unwrap_or_default();
        let reset = if color.is_some() { "\x1b[0m" } else { "" };
        Escapes { take, begin: begin.to_string() + &sgr, end: end.to_string() + reset, restore }
    }

    /// Appends a frame to `out`.
    fn encode(&self, renderer: &Renderer, out: &mut Vec<u8>) {
        out.extend(self.begin.bytes());
        for row in renderer.framebuffer.chunks_exact(renderer.view.width) {
            // The newline stands for column 0, which stays empty.
            out.push(b'\n');
            out.extend(&row[1..]);
        }
        out.extend(self.end.bytes());
    }
}

// ---- Terminal ------------------------------------------------------------------------------------

/// The longest wait before the loop looks whether the terminal has another size or another owner.
const LOOK: Duration = Duration::from_millis(100);
/// The code of an arrow key begins as Esc does. This is how long the rest of it may take.
const ESCAPE: Duration = Duration::from_millis(20);
/// How long it may take to restore the terminal.
const PATIENCE: Duration = Duration::from_secs(1);

/// Standard output and, if that is a terminal, its state.
///
/// The donut takes the terminal when it runs in the foreground. It restores it before another job has
/// it, at the end, and when the program panics.
struct Screen {
    output: Output,
    escapes: Escapes,
    file: File,
    /// Whether keys can be read from standard input.
    has_keys: bool,
    taken: AtomicBool,
    /// What signals ask for.
    quit: Arc<AtomicBool>,
    suspend: Arc<AtomicBool>,
    resume: Arc<AtomicBool>,
    resize: Arc<AtomicBool>,
}

impl Screen {
    fn open(output: Output, options: &Options) -> io::Result<Arc<Screen>> {
        let screen = Arc::new(Screen {
            output,
            escapes: Escapes::new(output, options),
            file: open_output()?,
            has_keys: output == Output::Terminal && io::stdin().is_terminal(),
            taken: AtomicBool::new(false),
            quit: Arc::default(),
            suspend: Arc::default(),
            resume: Arc::default(),
            resize: Arc::default(),
        });
        if output == Output::Terminal {
            screen.guard()?;
        }
        if screen.has_keys {
            // This reads nothing yet, but it fails if no keys can be read.
            event::poll(Duration::ZERO)?;
        }
        Ok(screen)
    }

    /// Makes signals and panics restore the terminal.
    fn guard(self: &Arc<Screen>) -> io::Result<()> {
        let (screen, report) = (self.clone(), panic::take_hook());
        panic::set_hook(Box::new(move |panic| {
            let _ = screen.restore();
            report(panic);
        }));
        let screen = self.clone();
        // SIGINT, SIGTERM and SIGHUP.
        let handler = move || {
            screen.quit.store(true, SeqCst);
            // The loop now ends the program, unless it hangs in a write that waits for room.
            thread::sleep(2 * PATIENCE);
            if screen.is_in_foreground().unwrap_or(false) {
                let _ = screen.drop_unread();
                thread::sleep(PATIENCE / 2);
                let _ = terminal::disable_raw_mode();
            }
            process::exit(1)
        };
        ctrlc::set_handler(handler).map_err(io::Error::other)?;
        #[cfg(unix)]
        for (signal, flag) in [
            (SIGQUIT, &self.quit),
            (SIGTSTP, &self.suspend),
            (SIGCONT, &self.resume),
            (SIGWINCH, &self.resize),
        ] {
            signal_hook::flag::register(signal, flag.clone())?;
        }
        Ok(())
    }

    /// Whether the terminal may be the donut's. When it may not be, or somebody else may have used it
    /// meanwhile, it is restored. After Ctrl-Z this stops, until a shell continues the program.
    fn may_draw(&self) -> io::Result<bool> {
        #[cfg(unix)]
        // In the first job of a session nobody could continue it.
        if self.suspend.swap(false, SeqCst) && getsid(None) != Ok(getpgrp()) {
            // An error will be one again when the program is continued.
            let _ = self.restore();
            signal_hook::low_level::raise(SIGSTOP)?;
            // A second Ctrl-Z, pressed just before the stop, must not stop it again.
            self.suspend.store(false, SeqCst);
        }
        let is_in_foreground = self.is_in_foreground()?;
        if !is_in_foreground || self.resume.swap(false, SeqCst) {
            self.restore()?;
        }
        Ok(is_in_foreground)
    }

    /// A program in the background that reads from the terminal, or changes its settings, is stopped.
    fn is_in_foreground(&self) -> io::Result<bool> {
        #[cfg(unix)]
        if self.output == Output::Terminal {
            let group =
                if self.has_keys { tcgetpgrp(io::stdin()) } else { tcgetpgrp(io::stdout()) };
            return match group {
                Ok(group) => Ok(group == getpgrp()),
                Err(Errno::IO) => Err(Errno::IO.into()),
                // A terminal that controls no session has no background.
                Err(_) => Ok(true),
            };
        }
        Ok(true)
    }

    /// Takes the terminal. False if the donut has it already.
    fn take(&self) -> io::Result<bool> {
        let is_new = !self.taken.swap(true, SeqCst);
        #[cfg(unix)]
        if is_new && self.has_keys {
            // crossterm may believe that raw mode is on, where a shell has ended it since.
            terminal::disable_raw_mode()?;
            terminal::enable_raw_mode()?;
            // Ctrl-C, Ctrl-Z and Ctrl-\ stay signals, and a newline still begins a line. No read waits:
            // crossterm reads on after half of a key's code.
            let mut settings = tcgetattr(io::stdin())?;
            settings.local_modes.insert(LocalModes::ISIG);
            settings.output_modes.insert(OutputModes::OPOST);
            settings.special_codes[SpecialCodeIndex::VMIN] = 0;
            tcsetattr(io::stdin(), OptionalActions::Now, &settings)?;
        }
        Ok(is_new)
    }

    /// Leaves the terminal as it was found, if the donut has it.
    fn restore(&self) -> io::Result<()> {
        if !self.taken.swap(false, SeqCst) {
            return Ok(());
        }
        // Standard input's terminal may be gone while standard output's is still there.
        let is_in_foreground = self.is_in_foreground().unwrap_or(true);
        let mut settings = Ok(());
        if is_in_foreground && self.has_keys {
            settings = terminal::disable_raw_mode();
        }
        #[cfg(unix)]
        if !is_in_foreground && tcgetattr(io::stdout())?.local_modes.contains(LocalModes::TOSTOP) {
            // The shell has restored the settings, and nothing may be written.
            return Ok(());
        }
        let (mut out, start) = (self.escapes.restore.into(), Instant::now());
        self.write(&mut out)?;
        while !out.is_empty() && start.elapsed() < PATIENCE {
            self.wait(LOOK, true)?;
            self.write(&mut out)?;
        }
        if !out.is_empty() && is_in_foreground {
            self.drop_unread()?;
            self.write(&mut out)?;
            return Err(io::Error::other("the terminal accepts no more output"));
        }
        settings
    }

    /// Drops what a stalled terminal has not read.
    fn drop_unread(&self) -> io::Result<()> {
        #[cfg(unix)]
        {
            tcflush(io::stdout(), QueueSelector::OFlush)?;
            // Linux may leave a write asleep that has room again. This wakes it.
            tcflow(io::stdout(), Action::OOff)?;
            tcflow(io::stdout(), Action::OOn)?;
        }
        Ok(())
    }

    /// Writes what there is room for, and leaves the rest in `out`.
    fn write(&self, out: &mut Vec<u8>) -> io::Result<()> {
        while !out.is_empty() {
            match (&self.file).write(out) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(bytes) => drop(out.drain(..bytes)),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Waits for `time` at most: for a key, for a signal or, if something is `unwritten`, for room. True
    /// if a key has come.
    fn wait(&self, time: Duration, unwritten: bool) -> io::Result<bool> {
        let has_keys = self.has_keys && self.taken.load(SeqCst);
        if !has_keys && !unwritten {
            thread::sleep(time);
            return Ok(false);
        }
        #[cfg(unix)]
        {
            let wanted = |fd, events| pollfd { fd, events, revents: 0 };
            let key = wanted(io::stdin().as_raw_fd(), POLLIN);
            let room = wanted(self.file.as_raw_fd(), POLLOUT);
            let mut both = [key, room];
            let wanted = &mut both[usize::from(!has_keys)..1 + usize::from(unwritten)];
            // It counts whole milliseconds, and drops the rest. A signal is an error.
            let _ = poll(wanted, Some(time + Duration::from_micros(999)));
            Ok(both[0].revents & POLLIN != 0)
        }
        #[cfg(windows)]
        event::poll(time)
    }

    /// The keys that were pressed, without Ctrl or Alt.
    fn keys(&self) -> io::Result<Vec<KeyCode>> {
        let mut keys = Vec::new();
        // A program that was continued may be in the background. (A poll for no time does not look.)
        while !self.resume.load(SeqCst) && event::poll(Duration::from_millis(1))? {
            let mut event = event::read()?;
            // A person who presses Esc presses nothing else so soon: what follows it is the rest of
            // another key's code, which came late over a slow line.
            while cfg!(unix) && event == Event::Key(KeyCode::Esc.into()) && event::poll(ESCAPE)? {
                match event::read()? {
                    next @ Event::Key(_) => event = next,
                    _ => break,
                }
            }
            let key = event.as_key_press_event().filter(|key| key.modifiers.is_empty());
            keys.extend(key.map(|key| key.code));
        }
        Ok(keys)
    }

    /// Columns and rows of the terminal; 80x24 for one that does not know, and for a pipe.
    fn size(&self) -> io::Result<(u16, u16)> {
        if self.output == Output::Pipe {
            return Ok((80, 24));
        }
        #[cfg(unix)]
        let size = tcgetwinsize(io::stdout()).map(|size| (size.ws_col, size.ws_row))?;
        #[cfg(windows)]
        let size = terminal::size()?;
        Ok(if size.0 > 0 && size.1 > 0 { size } else { (80, 24) })
    }
}

/// Standard output without a buffer. The program's own terminal is opened once more, so that writes do
/// not wait for room. (To ask that of standard output itself would ask it of the shell's, too.)
#[cfg(unix)]
fn open_output() -> io::Result<File> {
    let flags = OFlags::WRONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
    let is_own_terminal = tcgetpgrp(io::stdout()).is_ok();
    match rustix::fs::open("/dev/tty", flags, Mode::empty()) {
        Ok(terminal) if is_own_terminal => Ok(terminal.into()),
        _ => Ok(io::stdout().as_fd().try_clone_to_owned()?.into()),
    }
}

/// Standard output without a buffer.
#[cfg(windows)]
fn open_output() -> io::Result<File> {
    // To ask is to make the console understand escapes.
    crossterm::ansi_support::supports_ansi();
    Ok(io::stdout().as_handle().try_clone_to_owned()?.into())
}

#[cfg(test)]
#[path = "../tests/unit/mod.rs"]
mod tests;
