//! donut.c, Andy Sloane's spinning ASCII torus of 2006, in Rust. At donut.c's own size, 80x22, it draws
//! the same picture, byte for byte. At any other size there is no original to match, and it ray-traces
//! every cell exactly.
//!
//! # How donut.c draws a donut
//!
//! A torus is the surface swept by a small circle, the tube, whose centre travels round a large one, the
//! ring. Here it is in the first frame, cut in half and seen from the side, with the viewer on the left:
//!
//! ```text
//!                                .-.
//!           screen              ( +-)--  R1, the radius of the tube
//!              |                 '-'
//!              |                  |
//!              |                  |      R2, the radius of the ring
//!  viewer  o---|------------------+---------->  z, the axis of the ring
//!          :   |                 .-.
//!          :   |                ( + )
//!          :   |                 '-'
//!          :.K1.                  :
//!          :......... K2 .........:
//! ```
//!
//! donut.c has R1 = 1, R2 = 2 and K2 = 5. K1 is 30 columns or 15 rows, because a cell is twice as tall as
//! it is wide.
//!
//! Theta goes round the tube in steps of 0.07, and phi round the ring in steps of 0.02. Each pair of
//! angles gives a sample: a point of the surface, and its normal, the direction that the surface faces
//! there. The point is at distance h from the axis, and at height f above the plane of the ring:
//!
//! ```text
//! h = R2 + R1 cos theta      point   (h cos phi, h sin phi, f)
//! f = R1 sin theta           normal  (cos theta cos phi, cos theta sin phi, sin theta)
//! ```
//!
//! The donut is turned by the angle A about the x axis, and then by B about the z axis. Each frame adds
//! 0.04 to A and 0.02 to B. This moves the point to (X, Y, Z), and turns the normal in the same way:
//!
//! ```text
//! t = h sin phi cos A - f sin A      X = h cos phi cos B - t sin B
//! Z = h sin phi sin A + f cos A      Y = h cos phi sin B + t cos B
//! ```
//!
//! The depth of the point, seen from the viewer, is `z = Z + K2`. Things twice as deep look half as
//! large, so it appears at `K1 X / z`, `K1 Y / z` from the centre of the screen. Many samples fall into
//! the same cell, and the nearest one wins: for each cell, a z-buffer keeps the largest 1/z so far.
//!
//! The cell shows how bright that sample is. Its luminance L is the dot product of its normal and the
//! vector (0, -1, -1), which points at the light, above and behind the viewer. That vector is sqrt 2
//! long, so 8 L is at most 11.3. Its whole part is an index into the ramp `.,-~:;=!*#$@`, from 0 to 11.
//! Where L is negative, the surface faces away from the light and gets the darkest glyph.
//!
//! # Two methods
//!
//! `classic` is all of the above: it asks of each sample which cell it falls into. `exact` asks of each
//! cell what is there: it follows the ray through the centre of the cell to the first thing it hits.
//!
//! The capital letters are those of the [article] that explains donut.c. The directions and the
//! arithmetic are those of donut.c itself: x goes right, y *down*, and z away from the viewer. Angles are
//! in radians.
//!
//! [article]: https://www.a1k0n.net/2011/07/20/donut-math.html

use std::f64::consts::TAU;
use std::fs::File;
use std::io::{self, IsTerminal, Write};
use std::ops::RangeInclusive;
#[cfg(unix)]
use std::os::fd::{AsFd, AsRawFd};
use std::process::{self, ExitCode};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::SeqCst};
use std::time::{Duration, Instant};
use std::{env, panic, thread};

use clap::error::ErrorKind;
use clap::{Arg, CommandFactory, Parser, ValueEnum, ValueHint};
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
        LocalModes, OptionalActions, QueueSelector, SpecialCodeIndex, tcflush, tcgetattr,
        tcgetpgrp, tcgetwinsize, tcsetattr,
    },
    signal_hook::consts::{SIGCONT, SIGQUIT, SIGSTOP, SIGTSTP, SIGWINCH},
};

// ---- Options -------------------------------------------------------------------------------------

/// A spinning ASCII donut: donut.c at 80x22, ray-traced at any other size
///
/// On a terminal the donut fills the window and spins until you press q. In a
/// pipe or a file it writes what donut.c writes, escape codes included, at 80x22
/// unless you set a size, and ends only with --frames.
#[derive(Parser)]
#[command(name = "donut", version, verbatim_doc_comment, after_help = AFTER_HELP)]
// A later option overrides an earlier one, e.g. from `alias donut='donut --color cyan'`.
#[command(args_override_self = true)]
#[command(mut_args(arrange))]
struct Options {
    /// Frames per second; 0 means no limit
    ///
    /// At most 1000. Each frame turns by --spin, so 60 doubles the speed.
    #[arg(long, value_name = "N", default_value = "30", value_parser = within(RATES))]
    fps: f64,

    /// Stop after N frames; the last one stays on the screen
    ///
    /// On a terminal this draws from the top of the screen, cleared first.
    #[arg(long, value_name = "N", value_parser = within(COUNTS))]
    frames: Option<u64>,

    /// Rotation per frame, in radians
    #[arg(long, value_name = "DA,DB", default_value = "0.04,0.02", value_parser = two_angles)]
    spin: [f64; 2],

    /// Starting angle about the x axis, in radians
    #[arg(short = 'A', value_name = "RAD", default_value = "0", value_parser = within(ANGLES))]
    a: f64,

    /// Starting angle about the z axis, in radians
    #[arg(short = 'B', value_name = "RAD", default_value = "0", value_parser = within(ANGLES))]
    b: f64,

    /// How to draw
    ///
    /// Classic needs --r1, --r2 and --k2 in the ratio 1 : 2 : 5.
    ///
    /// After 31 hours at 30 fps, donut.c's angles get too coarse for auto.
    #[arg(long, value_enum, default_value_t, hide_default_value = true)]
    method: Method,

    /// Colour: a name, 0 to 255, or '#rrggbb'
    ///
    /// The names are black, dark_grey, grey, white, red, green, yellow, blue,
    /// magenta, cyan, dark_red, dark_green, dark_yellow, dark_blue,
    /// dark_magenta and dark_cyan.
    #[arg(long, alias = "colour", value_parser = color, verbatim_doc_comment)]
    color: Option<Color>,

    /// Columns [default: all, or 80 in a pipe]
    ///
    /// From 1 to 4096; on a terminal, at most its columns.
    ///
    /// Column 0 stays empty, as in donut.c: N draws N-1 characters.
    #[arg(long, value_name = "COLS", value_parser = within(SIZES))]
    width: Option<u16>,

    /// Rows [default: all but 2, or 22 in a pipe]
    ///
    /// From 1 to 4096; on a terminal, at most its rows minus 2.
    #[arg(long, value_name = "ROWS", value_parser = within(SIZES))]
    height: Option<u16>,

    /// Height of a character cell over its width
    #[arg(long, value_name = "RATIO", default_value = "2", value_parser = within(ASPECTS))]
    aspect: f64,

    /// Radius of the tube
    #[arg(long, value_name = "R", default_value = "1", value_parser = within(LENGTHS))]
    r1: f64,

    /// Radius of the ring, 1.001 to 30 times --r1
    #[arg(long, value_name = "R", default_value = "2", value_parser = within(LENGTHS))]
    r2: f64,

    /// Distance of the viewer
    ///
    /// At least 1.001 times the sum of --r1 and --r2.
    #[arg(long, value_name = "D", default_value = "5", value_parser = within(LENGTHS))]
    k2: f64,
}

const AFTER_HELP: &str = "\
Keys:
  q, Esc, Ctrl-C  quit
  p               pause or resume
  space           toggle shading
  Ctrl-Z          suspend

Examples:
  donut --fps 60 --spin 0.02,0.01   # smoother, at the same speed
  donut -A 1 -B 1 --color cyan";

#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum Method {
    /// The default: classic for donut.c's own picture, else exact
    #[default]
    Auto,
    /// donut.c's way: plots many points, and the nearest wins
    Classic,
    /// Follows a ray through each cell's centre: right at any size
    Exact,
}

/// Sets the heading of an option in the help, and what all options share.
fn arrange(option: Arg) -> Arg {
    let heading = match option.get_id().as_str() {
        "fps" | "frames" | "spin" | "a" | "b" => "Motion",
        "method" | "color" => "Look",
        "width" | "height" | "aspect" => "Size",
        _ => "Geometry",
    };
    // Angles may be negative, and completions must not offer file names as values.
    option.help_heading(heading).allow_hyphen_values(true).value_hint(ValueHint::Other)
}

/// The numbers that an option takes, as a range and in words.
type Numbers<T> = (RangeInclusive<T>, &'static str);
const RATES: Numbers<f64> = (0.0..=1000.0, "a number from 0 to 1000");
const COUNTS: Numbers<u64> = (0..=u64::MAX, "a whole number, 0 or more");
const SIZES: Numbers<u16> = (1..=4096, "a whole number from 1 to 4096");
const ANGLES: Numbers<f64> = (-1e9..=1e9, "an angle in radians, such as 1.57 (at most 1e9)");
const ASPECTS: Numbers<f64> = (0.1..=10.0, "a number from 0.1 to 10");
const LENGTHS: Numbers<f64> = (1e-6..=1e6, "a number from 0.000001 to 1000000");

fn within<T: FromStr + PartialOrd + Clone>(
    (range, words): Numbers<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.ok_or_else(|| format!("expected {words}"))
    }
}

fn two_angles(text: &str) -> Result<[f64; 2], String> {
    let angle = within(ANGLES);
    match text.split_once(',') {
        Some((a, b)) => Ok([angle(a.trim())?, angle(b.trim())?]),
        None => Err("expected two angles with a comma between them, such as 0.04,0.02".into()),
    }
}

fn color(text: &str) -> Result<Color, String> {
    let hex = text.strip_prefix('#').unwrap_or(text);
    let is_hex = hex.len() == 6 && hex.bytes().all(|digit| digit.is_ascii_hexdigit());
    let name = text.to_lowercase().replace("gray", "grey");
    match (u32::from_str_radix(hex, 16), text.parse(), Color::try_from(name.as_str())) {
        (Ok(rgb), ..) if is_hex => {
            let [_, r, g, b] = rgb.to_be_bytes();
            Ok(Color::Rgb { r, g, b })
        }
        (_, Ok(index), _) => Ok(Color::AnsiValue(index)),
        (.., Ok(color)) if color != Color::Reset => Ok(color),
        _ => Err("expected a name from --help, 0 to 255, or '#rrggbb'".into()),
    }
}

/// The range of R2 / R1. Below it, no screen shows the hole. At its end, the tube is less than three
/// columns thick on a screen of 80.
const RING: RangeInclusive<f64> = 1.001..=30.0;
/// The least K2 / (R1 + R2). From there, the field of view is 175 degrees.
const NEAREST: f64 = 1.001;

/// The quotient of two lengths. In f64, 0.35 / 0.07 is a little less than 5; this makes it 5, and so for
/// each quotient whose nearest number of six decimals is only rounding away.
fn ratio(length: f64, unit: f64) -> f64 {
    let (ratio, rounded) = (length / unit, (1e6 * length / unit).round() / 1e6);
    if (ratio - rounded).abs() < 1e-15 * ratio { rounded } else { ratio }
}

impl Options {
    /// The first rule that two or more of the options break together.
    fn conflict(&self) -> Option<String> {
        let &Options { r1, r2, k2, .. } = self;
        let (ring, distance) = (ratio(r2, r1), ratio(k2, r1));
        let (thickest, thinnest) = (RING.start(), RING.end());
        if !RING.contains(&ring) {
            Some(format!(
                "--r2 must be {thickest} to {thinnest} times --r1, but --r1 is {r1} and --r2 is {r2}"
            ))
        } else if ratio(k2, r1 + r2) < NEAREST {
            Some(format!(
                "--k2 must be at least {NEAREST} times the sum of --r1 and --r2, but --k2 is {k2}, --r1 is {r1} \
                 and --r2 is {r2}"
            ))
        } else if self.method == Method::Classic && (ring, distance) != (2.0, 5.0) {
            Some(format!(
                "--method classic needs --r1, --r2 and --k2 in the ratio 1 : 2 : 5, but they are {r1}, \
                 {r2} and {k2}"
            ))
        } else {
            None
        }
    }

    /// The view for the size that the options ask for, clipped to the terminal if there is one.
    fn view(&self, terminal: Option<(u16, u16)>) -> View {
        let (mut width, mut height) = (self.width.unwrap_or(80), self.height.unwrap_or(22));
        if let Some((columns, rows)) = terminal {
            // One row stays free above the picture, and one below it.
            width = self.width.unwrap_or(4096).min(columns);
            height = self.height.unwrap_or(4096).min(rows.saturating_sub(2).max(1));
        }
        let (r2, k2) = (ratio(self.r2, self.r1), ratio(self.k2, self.r1));
        View::new(width.into(), height.into(), self.aspect, r2, k2)
    }
}

fn main() -> ExitCode {
    let options = Options::parse();
    if let Some(conflict) = options.conflict() {
        Options::command().error(ErrorKind::ValueValidation, conflict).exit()
    }
    match run(&options) {
        // A reader that goes away, as in `donut | head`, has seen enough.
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            // If standard error is gone as well, there is nobody left to tell.
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
    renderer: Renderer,
    clock: Clock,
    /// How many frames have been drawn.
    frames: u64,
    /// When the next frame is due; `None` while the donut is paused.
    deadline: Option<Instant>,
    /// Whether to draw the last frame again.
    redraw: bool,
    /// The bytes that are not written yet.
    out: Vec<u8>,
}

/// Spins the donut until the last frame is shown, somebody ends it, or its reader goes away.
fn run(options: &Options) -> io::Result<()> {
    let screen = Screen::open(options)?;
    let mut animation = Animation {
        options,
        screen: screen.clone(),
        renderer: Renderer::new(View::DONUT_C, options.method, RAMP),
        clock: Clock { origin: [options.a, options.b], steps: 0, spin: options.spin },
        frames: 0,
        deadline: Some(Instant::now()),
        redraw: false,
        out: Vec::new(),
    };
    let (played, restored) = (animation.play(), screen.restore());
    played.and(restored)
}

impl Animation<'_> {
    /// donut.c's `for (;;)`.
    ///
    /// It never waits for its own terminal to accept output, so it always obeys keys and signals.
    fn play(&mut self) -> io::Result<()> {
        // On a dumb terminal further frames would only scroll by.
        let last = self.options.frames.unwrap_or(if self.screen.is_dumb { 1 } else { u64::MAX });
        while !self.screen.quit.load(SeqCst)
            && (self.frames < last || self.redraw || !self.out.is_empty())
        {
            let deadline = self.deadline.filter(|_| self.out.is_empty());
            let key_pressed = self.screen.wait(deadline, !self.out.is_empty())?;
            if !self.screen.may_draw()? {
                (self.out, self.redraw) = (Vec::new(), true);
                self.screen.wait(None, false)?;
                continue;
            }
            let mut mid_frame = !self.out.is_empty();
            // This and `take` put in `out` what belongs before the next frame.
            self.fit()?;
            if self.screen.take()? {
                self.out = self.screen.escapes.take.into();
                (self.redraw, mid_frame) = (true, false);
            }
            if key_pressed {
                self.obey_keys()?;
            }
            let is_due =
                self.frames < last && self.deadline.is_some_and(|time| time <= Instant::now());
            if (is_due || self.redraw) && !mid_frame {
                self.draw(is_due);
            }
            self.screen.write(&mut self.out)?;
        }
        Ok(())
    }

    fn fit(&mut self) -> io::Result<()> {
        let view = self.options.view(self.screen.size()?);
        if self.screen.resize.swap(false, SeqCst) || view != self.renderer.view {
            self.renderer = Renderer::new(view, self.options.method, self.renderer.ramp);
            self.out.extend(self.screen.escapes.clear.bytes());
            self.redraw = true;
        }
        Ok(())
    }

    fn obey_keys(&mut self) -> io::Result<()> {
        for key in self.screen.keys()? {
            match key {
                KeyCode::Char('q') | KeyCode::Esc => self.screen.quit.store(true, SeqCst),
                KeyCode::Char('p') if self.deadline.is_some() => self.deadline = None,
                KeyCode::Char('p') => self.deadline = Some(Instant::now()),
                KeyCode::Char(' ') => {
                    let is_flat = self.renderer.ramp == FLAT;
                    (self.renderer.ramp, self.redraw) = (if is_flat { RAMP } else { FLAT }, true);
                }
                _ => {}
            }
        }
        Ok(())
    }

    /// Draws the next frame if it is due, or else the last one again.
    fn draw(&mut self, is_due: bool) {
        if is_due && self.frames > 0 {
            self.clock.tick(self.renderer.method);
        }
        self.renderer.method = self.clock.choose(self.options.method, &self.renderer.view);
        let [a, b] = self.clock.angles();
        self.renderer.render_frame(a, b);
        self.screen.escapes.encode(&self.renderer, &mut self.out);
        self.redraw = false;
        if is_due {
            self.frames += 1;
            // 1e9 s, or 31 years, is enough; more may not fit into a Duration.
            let seconds =
                if self.options.fps > 0.0 { (1.0 / self.options.fps).min(1e9) } else { 0.0 };
            // Each deadline counts from the last, so they do not drift. A missed one becomes now.
            let next = self.deadline.map(|deadline| deadline + Duration::from_secs_f64(seconds));
            self.deadline = next.max(Some(Instant::now()));
        }
    }
}

/// The angles A and B, frame after frame.
///
/// They are `origin + steps * spin`. For `exact` the steps are counted. donut.c adds the spin to a
/// `float` in each frame, so for `classic` the sum becomes the new origin and the count stays 0.
struct Clock {
    origin: [f64; 2],
    steps: u64,
    spin: [f64; 2],
}

impl Clock {
    fn angles(&self) -> [f64; 2] {
        [0, 1].map(|i| self.origin[i] + self.steps as f64 * self.spin[i])
    }

    /// donut.c's next angles.
    fn next_floats(&self) -> [f64; 2] {
        let angles = self.angles();
        [0, 1].map(|i| advance(angles[i] as f32, self.spin[i]).into())
    }

    /// Whether rounding to `float` shifts the angles by a thousandth of a radian at most, and donut.c's
    /// next step by a tenth of the spin at most.
    ///
    /// From frame 3,345,245 on, where A passes 2^17, a step of 0.04 is rounded to 0.047. From frame
    /// 22,918,663 on, where A is 2^20, it is rounded to 0 and A stands still.
    fn floats_are_fine(&self) -> bool {
        let (angles, next) = (self.angles(), self.next_floats());
        (0..2).all(|i| {
            let float = f64::from(angles[i] as f32);
            let error = next[i] - float - self.spin[i];
            (float - angles[i]).abs() <= 1e-3 && error.abs() <= 0.1 * self.spin[i].abs()
        })
    }

    /// The method for this picture: this is where `auto` is decided.
    fn choose(&self, method: Method, view: &View) -> Method {
        match method {
            Method::Auto if *view == View::DONUT_C && self.floats_are_fine() => Method::Classic,
            Method::Auto => Method::Exact,
            chosen => chosen,
        }
    }

    fn tick(&mut self, method: Method) {
        if method == Method::Classic {
            (self.origin, self.steps) = (self.next_floats(), 0);
        } else {
            self.steps += 1;
        }
    }
}

// ---- View ----------------------------------------------------------------------------------------

/// The donut's proportions, and how it is projected onto the screen.
///
/// Lengths are in units of the tube's radius, so R1 is 1. The point (X, Y, Z) appears at
/// `x = cx + k1x X / (Z + K2)`, `y = cy + k1y Y / (Z + K2)`. The cell in column c and row r is the square
/// from (c, r) to (c + 1, r + 1). Column 0 and row 0 stay empty: donut.c prints a newline in place of
/// column 0, and never draws in row 0.
#[derive(Clone, Copy, PartialEq)]
struct View {
    /// Radius of the ring.
    r2: f64,
    /// Distance from the viewer to the donut's centre.
    k2: f64,
    /// Columns and rows of the picture.
    width: usize,
    height: usize,
    /// Where the donut's centre appears, in cells.
    cx: f64,
    cy: f64,
    /// The scale K1, in columns and in rows.
    k1x: f64,
    k1y: f64,
}

impl View {
    const DONUT_C: View =
        View { r2: 2.0, k2: 5.0, width: 80, height: 22, cx: 40.0, cy: 12.0, k1x: 30.0, k1y: 15.0 };

    /// donut.c's own view for its size and proportions. For others, the largest that fits every pose.
    /// `aspect` is the height of a cell over its width.
    fn new(width: usize, height: usize, aspect: f64, r2: f64, k2: f64) -> View {
        if (width, height, aspect, r2, k2) == (80, 22, 2.0, 2.0, 5.0) {
            return View::DONUT_C;
        }
        let (w, h) = (width as f64, height as f64);
        let k1x = f64::min((w - 1.0) / 2.0, aspect * (h - 1.0) / 2.0) / apparent_radius(r2, k2);
        let (cx, cy) = ((w + 1.0) / 2.0, (h + 1.0) / 2.0);
        View { r2, k2, width, height, cx, cy, k1x, k1y: k1x / aspect }
    }
}

/// The apparent radius of the sphere of radius R1 + R2, which the donut never leaves: the tangent of the
/// angle between the rays to its centre and to its edge.
fn apparent_radius(r2: f64, k2: f64) -> f64 {
    let radius = 1.0 + r2;
    radius / ((k2 - r2 - 1.0) * (k2 + radius)).sqrt()
}

// ---- Rendering -----------------------------------------------------------------------------------

/// The glyphs, from dark to bright.
const RAMP: &[u8; 12] = b".,-~:;=!*#$@";
/// The glyphs with the shading off.
const FLAT: &[u8; 12] = &[b'.'; 12];

/// The glyph of a luminance L, which is from -sqrt 2 to sqrt 2.
fn glyph(ramp: &[u8; 12], luminance: f64) -> u8 {
    // `as u8` saturates, so a negative L becomes 0. `min` is only for safety.
    ramp[usize::from((8.0 * luminance) as u8).min(11)]
}

/// Draws pictures of the donut.
struct Renderer {
    view: View,
    method: Method,
    ramp: &'static [u8; 12],
    /// The glyph of each cell: `width * height` bytes, row by row, blank where there is no donut.
    framebuffer: Vec<u8>,
    /// For `classic`, 1/z of the nearest sample in each cell so far. There are two more rows than in the
    /// framebuffer, because donut.c's own view reaches below the picture.
    zbuffer: Vec<f32>,
    /// The sines and the cosines of theta and of phi. They can be many, so only `classic` makes them.
    circles: Option<[(Vec<f32>, Vec<f32>); 2]>,
}

impl Renderer {
    fn new(view: View, method: Method, ramp: &'static [u8; 12]) -> Renderer {
        let View { width, height, .. } = view;
        let (framebuffer, zbuffer) = (vec![b' '; width * height], vec![0.0; width * (height + 2)]);
        Renderer { view, method, ramp, framebuffer, zbuffer, circles: None }
    }

    /// Draws the donut, turned by the angles A and B, into the framebuffer.
    fn render_frame(&mut self, a: f64, b: f64) {
        self.framebuffer.fill(b' ');
        match self.method {
            Method::Classic => self.splat(a as f32, b as f32),
            _ => self.trace(a, b),
        }
    }

    /// `classic`: donut.c's double loop. The nearest sample in each cell wins.
    ///
    /// donut.c calls `sin_phi` c, `cos_theta` d, `sin_a` e, `sin_theta` f, `cos_a` g, `ooz` (1/z) D,
    /// `cos_phi` l, `cos_b` m, `sin_b` n and `cell` o. Everything is in f32 and in donut.c's order of
    /// operations: another order rounds to other glyphs.
    fn splat(&mut self, a: f32, b: f32) {
        let View { width, r2, k2, cx, cy, k1x, k1y, .. } = self.view;
        let [r2, k2, cx, cy, k1x, k1y] = [r2, k2, cx, cy, k1x, k1y].map(|value| value as f32);
        let ((sin_a, cos_a), (sin_b, cos_b)) = (sin_cos(a), sin_cos(b));
        let [(sin_thetas, cos_thetas), (sin_phis, cos_phis)] =
            self.circles.get_or_insert_with(|| steps(&self.view).map(circle));
        // No 1/z exceeds infinity, so row 0, column 0 and the rows below the picture stay empty.
        self.zbuffer.fill(f32::INFINITY);
        for row in self.zbuffer[..self.framebuffer.len()].chunks_exact_mut(width).skip(1) {
            row[1..].fill(0.0);
        }
        let phis = sin_phis.len();
        let (sin_phis, cos_phis) = (&sin_phis[..phis], &cos_phis[..phis]);
        let (mut ooz, mut x, mut y) = (vec![0.0; phis], vec![0.0; phis], vec![0.0; phis]);
        let mut cell = vec![0; phis];
        for (&sin_theta, &cos_theta) in sin_thetas.iter().zip(cos_thetas.iter()) {
            let h = cos_theta + r2;
            // No branches, and no bounds checks because all lengths are `phis`: the compiler vectorises
            // the first two loops.
            for i in 0..phis {
                let (sin_phi, cos_phi) = (sin_phis[i], cos_phis[i]);
                ooz[i] = 1.0 / (sin_phi * h * sin_a + sin_theta * cos_a + k2);
                let t = sin_phi * h * cos_a - sin_theta * sin_a;
                x[i] = cx + k1x * ooz[i] * (cos_phi * h * cos_b - t * sin_b);
                y[i] = cy + k1y * ooz[i] * (cos_phi * h * sin_b + t * cos_b);
            }
            for i in 0..phis {
                cell[i] = floor(x[i]) + width as u32 * floor(y[i]);
            }
            for i in 0..phis {
                let (cell, sin_phi, cos_phi) = (cell[i] as usize, sin_phis[i], cos_phis[i]);
                if self.zbuffer[cell] < ooz[i] {
                    self.zbuffer[cell] = ooz[i];
                    let luminance = (sin_theta * sin_a - sin_phi * cos_theta * cos_a) * cos_b
                        - sin_phi * cos_theta * sin_a
                        - sin_theta * cos_a
                        - cos_phi * cos_theta * sin_b;
                    self.framebuffer[cell] = glyph(self.ramp, luminance.into());
                }
            }
        }
    }

    /// `exact`: a cell shows what the ray through its centre hits first.
    fn trace(&mut self, a: f64, b: f64) {
        let View { r2, k2, width, cx, cy, k1x, k1y, .. } = self.view;
        let (torus, edge) = (Torus::new(r2, a, b), apparent_radius(r2, k2));
        for (row, cells) in self.framebuffer.chunks_exact_mut(width).enumerate().skip(1) {
            let dy = (row as f64 + 0.5 - cy) / k1y;
            // Rays beyond the edge have nothing to hit.
            let half = (edge * edge - dy * dy).max(0.0).sqrt() * k1x;
            let (first, last) = ((cx - half) as usize, ((cx + half) as usize + 1).min(width));
            for column in (first..last).step_by(LANES) {
                let dx = |i| ((column + i) as f64 + 0.5 - cx) / k1x;
                let rays = torus.rays(std::array::from_fn(dx), dy, k2);
                let hits = torus.first_hits(&rays);
                for (i, cell) in cells[column..last].iter_mut().take(LANES).enumerate() {
                    if hits[i] < MISS {
                        *cell = glyph(self.ramp, torus.luminance(&rays, i, hits[i]) + HAIR);
                    }
                }
            }
        }
    }
}

// ---- classic: donut.c's arithmetic ---------------------------------------------------------------

/// donut.c's steps of theta and phi, or proportionally smaller ones for a larger picture. The nearest
/// point then moves by about a cell a step, as in donut.c. Larger steps would leave gaps.
fn steps(view: &View) -> [f64; 2] {
    let shrink = f64::min(1.0, View::DONUT_C.k1x / view.k1x.max(view.k1y));
    [0.07 * shrink, 0.02 * shrink]
}

/// The angles round a circle, summed as in donut.c: their sines and their cosines.
fn circle(step: f64) -> (Vec<f32>, Vec<f32>) {
    let angles = std::iter::successors(Some(0.0), |&angle| Some(advance(angle, step)));
    // donut.c stops at 6.28. That is the same at its own steps, but leaves a gap at smaller ones.
    angles.take_while(|&angle| f64::from(angle) < TAU).map(sin_cos).unzip()
}

/// donut.c's `angle += step`: C adds in `double` and rounds the sum to `float`.
fn advance(angle: f32, step: f64) -> f32 {
    (f64::from(angle) + step) as f32
}

/// The sine and the cosine of an angle: C computes them in `double`, and rounds them to `float`.
fn sin_cos(angle: f32) -> (f32, f32) {
    let (sin, cos) = f64::from(angle).sin_cos();
    (sin as f32, cos as f32)
}

/// The whole part of a value from 0 to 2^23.
///
/// This is `value as u32` in plain arithmetic, which vectorises on every machine: adding 2^23 rounds to
/// a whole number, which is then in the low bits of the sum.
fn floor(value: f32) -> u32 {
    const WHOLE: f32 = 8_388_608.0;
    let rounded = value + WHOLE;
    let is_up = rounded - WHOLE > value;
    rounded.to_bits() - WHOLE.to_bits() - u32::from(is_up)
}

// ---- exact: rays and a torus ---------------------------------------------------------------------

/// How many rays are solved side by side: while one waits for its division, others go on.
const LANES: usize = 8;
type Lanes = [f64; LANES];
/// The s of a ray that misses (see `Torus`).
const MISS: f64 = f64::INFINITY;
/// A search ends once a step is shorter than this, in units of R1. At a simple root, each step doubles
/// the correct digits, so what is left is below rounding. Where a ray grazes the donut, a step only halves
/// the distance to the root. But there, 1e-8 to either side, the surface is within 1e-16 of the ray.
const LAST_STEP: f64 = 1e-8;
/// Most rays take about 5 steps. A search that takes more than this never ends: see `hits_at_cusps`.
const MOST_STEPS: usize = 100;
/// Added to each luminance, far below what can be seen. In symmetric poses 8 L may be a whole number, and
/// rounding would choose between two glyphs. This way all machines choose the brighter one.
const HAIR: f64 = 1e-12;

/// The donut of one frame, as a ray meets it.
///
/// A ray is P = P0 + s U. U is its direction, of length 1. P0 is its point nearest to the donut's centre,
/// which is the origin, so P0 and U are at right angles. Three numbers matter about a point P:
///
/// ```text
/// |P|^2 = d0 + s^2      the square of its distance from the centre
/// f     = f0 + fu s     its height above the plane of the ring
/// l     = l0 + lu s     its dot product with (0, -1, -1), the vector to the light
/// ```
///
/// At the distance h from the axis, P is on the surface if it is R1 = 1 away from the ring:
///
/// ```text
/// (h - R2)^2 + f^2 = 1
/// |P|^2 + R2^2 - 1 = 2 R2 h                        because |P|^2 = h^2 + f^2
/// (|P|^2 + R2^2 - 1)^2 = 4 R2^2 (|P|^2 - f^2)      squared
/// G(s) = s^4 + p s^2 + q s + r = 0                 left minus right, along the ray
/// ```
///
/// G is positive outside the donut. Because s counts from P0, there is no cubic term, and the
/// coefficients stay small however far away the viewer is.
///
/// Two kinds of cell may be wrong, because f64 cannot tell what is right: one whose 8 L is less than
/// 1e-11 below a whole number, and one that a tube thinner or thicker by 1e-13 (R1 + R2) would change.
struct Torus {
    r2: f64,
    /// The axis of revolution, of length 1, after the turns by A and B. No third angle matters: a donut
    /// turned about its own axis looks the same.
    axis: [f64; 3],
}

/// d0 to lu, for each ray.
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

    /// The rays from the viewer at (0, 0, -K2) in the directions (dx, dy, 1).
    fn rays(&self, dx: Lanes, dy: f64, k2: f64) -> Rays {
        let [x, y, z] = self.axis;
        let mut rays = Rays::default();
        for (i, dx) in dx.into_iter().enumerate() {
            // U is (dx, dy, 1) times cos, and P0 is (dx, dy, -tan2) times depth.
            let tan2 = dx * dx + dy * dy;
            let cos = 1.0 / (1.0 + tan2).sqrt();
            let depth = k2 * cos * cos;
            rays.d0[i] = k2 * depth * tan2;
            rays.f0[i] = depth * (dx * x + dy * y - tan2 * z);
            rays.fu[i] = cos * (dx * x + dy * y + z);
            rays.l0[i] = depth * (tan2 - dy);
            rays.lu[i] = -cos * (dy + 1.0);
        }
        rays
    }

    /// The coefficients p, q and r of a ray's G.
    fn quartic(&self, d0: f64, f0: f64, fu: f64) -> [f64; 3] {
        let (inner, outer, r2_r2) = (self.r2 - 1.0, self.r2 + 1.0, self.r2 * self.r2);
        let p = 2.0 * (d0 - r2_r2 - 1.0) + 4.0 * r2_r2 * fu * fu;
        let q = 8.0 * r2_r2 * f0 * fu;
        let r = (d0 - inner * inner) * (d0 - outer * outer) + 4.0 * r2_r2 * f0 * f0;
        [p, q, r]
    }

    /// The s of each ray's first hit: the first root of its G, found by Newton's method.
    ///
    /// ```text
    ///  G  \           .---.           /
    ///      \        .'     '.        /     -w and w are the inflections of G: it is concave between
    ///  -----a------b---------c------d--> s them, and convex to the left and to the right. (Without
    ///        '.  .'           '.  .'       inflections it is convex everywhere, and w is 0.)
    ///          '' -w         w  ''
    /// ```
    ///
    /// The ray enters the donut where G falls to 0: at a or at c, or nowhere.
    ///
    /// 1. Left of -w, the steps lead to a from the left and never pass it. If there is no a, they lead to
    ///    where G rises, or to -w or past it. Then the search starts again, at w.
    /// 2. If G is positive at w, the steps lead to c from the left. If there is no c, they lead to where G
    ///    rises, and the ray misses.
    /// 3. If G is negative at w, c is between -w and w. The steps lead to it from the right.
    ///
    /// All rays take steps until the last has arrived. At a simple root this changes no more than the last
    /// bits of the others. A ray that misses stays at infinity, where the slope is infinite.
    fn first_hits(&self, rays: &Rays) -> Lanes {
        let [mut p, mut q, mut r, mut w, mut s] = [[0.0; LANES]; 5];
        for i in 0..LANES {
            let (d0, f0, fu) = (rays.d0[i], rays.f0[i], rays.fu[i]);
            [p[i], q[i], r[i]] = self.quartic(d0, f0, fu);
            w[i] = inflection(p[i]);
            // A search that would begin to the right of -w may begin at w. Up to w, G is concave, so if it
            // is positive at both ends there is no root between them, and if not, this is case 3.
            let entry = self.entry(d0, f0, fu);
            s[i] = if entry < -w[i] { entry } else { w[i] };
        }
        let mut searching = true;
        for _ in 0..MOST_STEPS {
            searching = false;
            // `|` and `&` make no branches, so the compiler vectorises this loop.
            for i in 0..LANES {
                let (slope, step) = newton([p[i], q[i], r[i]], s[i]);
                let next = s[i] - step;
                let no_root = (slope >= 0.0) | ((s[i] < -w[i]) & (next >= -w[i]));
                // In case 3 G only seems to rise, by rounding at a triple root. The ray hits all the same.
                let is_before_w = s[i] < w[i];
                let restart = if is_before_w { w[i] } else { MISS };
                s[i] = if no_root { restart } else { next };
                searching |= (no_root & is_before_w) | (!no_root & (step.abs() > LAST_STEP));
            }
            if !searching {
                break;
            }
        }
        if searching { self.hits_at_cusps(rays, s) } else { s }
    }

    /// Ends the searches that do not end by themselves.
    ///
    /// Where the visible outline of the donut ends, in a cusp, a ray has a triple root at -w. Rounding
    /// sends its search from one side of -w to the other and back. Such a ray hits at -w.
    #[cold] // Inlined, it would slow the loop above by a tenth.
    fn hits_at_cusps(&self, rays: &Rays, mut s: Lanes) -> Lanes {
        for i in 0..LANES {
            let [p, q, r] = self.quartic(rays.d0[i], rays.f0[i], rays.fu[i]);
            let (_, step) = newton([p, q, r], s[i]);
            if step.abs() > LAST_STEP {
                s[i] = -inflection(p);
            }
        }
        s
    }

    /// The s where the ray enters the space that the donut is in: the sphere of radius R1 + R2, between
    /// the planes f = -1 and f = 1. No hit comes before it.
    fn entry(&self, d0: f64, f0: f64, fu: f64) -> f64 {
        let radius = 1.0 + self.r2;
        let sphere = -(radius * radius - d0).max(0.0).sqrt();
        // If fu is 0, this is at infinity, or NaN, which `max` ignores.
        let planes = -(1.0 + f0 * 1_f64.copysign(fu)) / fu.abs();
        sphere.max(planes)
    }

    /// The luminance where ray i hits: the dot product of the normal and the vector to the light.
    ///
    /// With the axis n, the normal at P is `(P - f n) (1 - R2 / h) + f n`. On the surface h is
    /// `(|P|^2 + R2^2 - 1) / (2 R2)`, which takes no square root.
    fn luminance(&self, rays: &Rays, i: usize, s: f64) -> f64 {
        let r2_r2 = self.r2 * self.r2;
        let axis_light = -(self.axis[1] + self.axis[2]);
        let f = rays.f0[i] + rays.fu[i] * s;
        let light = rays.l0[i] + rays.lu[i] * s;
        let across = 1.0 - 2.0 * r2_r2 / (rays.d0[i] + s * s + r2_r2 - 1.0);
        (light - f * axis_light) * across + f * axis_light
    }
}

/// The slope of G at s, and the step that Newton's method takes from there, to the left if positive.
fn newton([p, q, r]: [f64; 3], s: f64) -> (f64, f64) {
    let ss = s * s;
    let ss_p = ss + p;
    let slope = 2.0 * (ss_p + ss) * s + q;
    (slope, ((ss_p * s + q) * s + r) / slope)
}

/// The inflection w of G, which has another at -w; 0 if it has none.
fn inflection(p: f64) -> f64 {
    (p * (-1.0 / 6.0)).max(0.0).sqrt()
}

// ---- Terminal ------------------------------------------------------------------------------------

const CLEAR: &str = "\x1b[2J";
const UPDATE: [&str; 3] = ["\x1b[?2026h\x1b[H", "\r\n", "\x1b[?2026l"];

/// What is written before the first frame, on a resize, around each frame and row, and after the last.
struct Escapes {
    take: &'static str,
    clear: &'static str,
    frame: [String; 3],
    restore: &'static str,
}

impl Escapes {
    fn new(is_terminal: bool, is_dumb: bool, options: &Options) -> Escapes {
        // Mode 25 is the cursor, 1049 the alternate screen, and 2026 a synchronised update, which hides
        // half-drawn frames. In raw mode a newline needs its \r.
        let (take, [begin, newline, end], restore) = if is_dumb {
            ("", ["", "\n", "\n"], "")
        } else if !is_terminal {
            // donut.c's own bytes.
            (CLEAR, ["\x1b[H", "\n", "\n"], "")
        } else if options.frames.is_some() {
            ("\x1b[?25l\x1b[2J", UPDATE, "\x1b[?2026l\x1b[0m\x1b[?25h\n")
        } else {
            ("\x1b[?1049h\x1b[?25l\x1b[2J", UPDATE, "\x1b[?2026l\x1b[0m\x1b[?25h\x1b[?1049l")
        };
        // The option is explicit, so it overrides NO_COLOR.
        style::force_color_output(true);
        let color = options.color.filter(|_| !is_dumb).map(SetForegroundColor);
        let color = color.map(|color| (color.to_string(), "\x1b[0m")).unwrap_or_default();
        let frame = [begin.to_owned() + &color.0, newline.to_owned(), end.to_owned() + color.1];
        Escapes { take, clear: if is_dumb { "" } else { CLEAR }, frame, restore }
    }

    fn encode(&self, renderer: &Renderer, out: &mut Vec<u8>) {
        let [begin, newline, end] = self.frame.each_ref().map(String::as_bytes);
        out.extend_from_slice(begin);
        for row in renderer.framebuffer.chunks_exact(renderer.view.width) {
            // The newline stands for column 0, which stays empty.
            out.extend_from_slice(newline);
            out.extend_from_slice(&row[1..]);
        }
        out.extend_from_slice(end);
    }
}

/// Standard output and, if that is a terminal, its state.
///
/// The donut takes the terminal while it is in the foreground, and restores it on Ctrl-Z, on losing the
/// foreground, at the end, and on a panic.
struct Screen {
    is_terminal: bool,
    /// Whether TERM is dumb: no escape codes.
    is_dumb: bool,
    escapes: Escapes,
    file: File,
    /// Whether keys can be read from standard input.
    has_keys: bool,
    taken: AtomicBool,
    // What signals have asked for.
    quit: Arc<AtomicBool>,
    #[cfg_attr(windows, allow(dead_code, reason = "no job control on Windows"))]
    suspend: Arc<AtomicBool>,
    resume: Arc<AtomicBool>,
    resize: Arc<AtomicBool>,
}

impl Screen {
    fn open(options: &Options) -> io::Result<Arc<Screen>> {
        let is_terminal = io::stdout().is_terminal();
        let is_dumb = is_terminal && env::var_os("TERM").is_some_and(|term| term == "dumb");
        let screen = Arc::new(Screen {
            is_terminal,
            is_dumb,
            escapes: Escapes::new(is_terminal, is_dumb, options),
            file: open_stdout()?,
            has_keys: is_terminal && !is_dumb && io::stdin().is_terminal(),
            taken: AtomicBool::new(false),
            quit: Arc::default(),
            suspend: Arc::default(),
            resume: Arc::default(),
            resize: Arc::default(),
        });
        if is_terminal {
            screen.guard()?;
        }
        if screen.has_keys {
            // This reads nothing yet, but fails if keys cannot be read.
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
        let end = move || {
            screen.quit.store(true, SeqCst);
            // The loop now ends the program, unless a write blocks it. Then this does.
            thread::sleep(Duration::from_secs(2));
            if screen.is_in_foreground().unwrap_or(false) {
                let _ = terminal::disable_raw_mode();
            }
            process::exit(1)
        };
        ctrlc::set_handler(end).map_err(io::Error::other)?; // SIGINT, SIGTERM and SIGHUP.
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

    /// Whether the donut may use the terminal. If not, or after a stop, this restores the terminal. After
    /// Ctrl-Z, the program stops here until a shell continues it.
    fn may_draw(&self) -> io::Result<bool> {
        #[cfg(unix)]
        // A session's first job has no shell to continue it.
        if self.suspend.swap(false, SeqCst) && getsid(None) != Ok(getpgrp()) {
            // If this fails now, it will fail again after the stop.
            let _ = self.restore();
            signal_hook::low_level::raise(SIGSTOP)?;
            // A second Ctrl-Z, pressed just before the stop, must not stop it again.
            self.suspend.store(false, SeqCst);
        }
        let is_in_foreground = self.is_in_foreground()?;
        if self.resume.swap(false, SeqCst) || !is_in_foreground {
            self.restore()?;
        }
        Ok(is_in_foreground)
    }

    /// In the background, reading from the terminal or changing its settings stops the program.
    fn is_in_foreground(&self) -> io::Result<bool> {
        #[cfg(unix)]
        if self.is_terminal {
            let job = if self.has_keys { tcgetpgrp(io::stdin()) } else { tcgetpgrp(io::stdout()) };
            if job == Err(Errno::IO) {
                return Err(Errno::IO.into()); // The terminal is gone.
            }
            // A terminal that controls no session has no background.
            return Ok(job.is_err() || job == Ok(getpgrp()));
        }
        Ok(true)
    }

    /// Takes the terminal. False if the donut has it already.
    fn take(&self) -> io::Result<bool> {
        let is_new = !self.taken.swap(true, SeqCst);
        #[cfg(unix)]
        if is_new && self.has_keys {
            // crossterm may think raw mode is on when a shell has turned it off.
            terminal::disable_raw_mode()?;
            terminal::enable_raw_mode()?;
            // Ctrl-C and Ctrl-Z stay signals. A read never waits, not even for the rest of a key's code.
            let mut settings = tcgetattr(io::stdin())?;
            settings.local_modes.insert(LocalModes::ISIG);
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
        let foreground = self.is_in_foreground().unwrap_or(true);
        let cooked =
            if foreground && self.has_keys { terminal::disable_raw_mode() } else { Ok(()) };
        #[cfg(unix)]
        if !foreground && tcgetattr(io::stdout())?.local_modes.contains(LocalModes::TOSTOP) {
            // The shell has reset the settings, and TOSTOP bars writing.
            return Ok(());
        }
        let (mut out, start) = (self.escapes.restore.into(), Instant::now());
        self.write(&mut out)?;
        while !out.is_empty() && start.elapsed() < Duration::from_secs(1) {
            self.wait(None, true)?;
            self.write(&mut out)?;
        }
        #[cfg(unix)]
        if !out.is_empty() && foreground {
            tcflush(io::stdout(), QueueSelector::OFlush)?;
            self.write(&mut out)?;
            return Err(io::Error::other("the terminal accepts no more output"));
        }
        cooked
    }

    /// Writes what there is room for, and leaves the rest in `out`.
    fn write(&self, out: &mut Vec<u8>) -> io::Result<()> {
        while !out.is_empty() {
            match (&self.file).write(out) {
                Ok(0) => return Err(io::ErrorKind::WriteZero.into()),
                Ok(bytes) => drop(out.drain(..bytes)),
                Err(error) => match error.kind() {
                    io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted => break,
                    _ => return Err(error),
                },
            }
        }
        Ok(())
    }

    /// Waits for a key, or for room if output is `unwritten`, until `deadline`, but 100 ms at most: then
    /// the loop checks the terminal's size and foreground job again. True if a key came.
    fn wait(&self, deadline: Option<Instant>, unwritten: bool) -> io::Result<bool> {
        let has_keys = self.has_keys && self.taken.load(SeqCst);
        let until = |deadline: Instant| deadline.saturating_duration_since(Instant::now());
        let time = deadline.map_or(Duration::MAX, until).min(Duration::from_millis(100));
        if !has_keys && !unwritten {
            thread::sleep(time);
            return Ok(false);
        }
        #[cfg(windows)]
        let key_pressed = event::poll(time)?;
        #[cfg(unix)]
        let key_pressed = {
            let stdin = (has_keys, io::stdin().as_raw_fd(), POLLIN);
            let file = (unwritten, self.file.as_raw_fd(), POLLOUT);
            let wanted = [stdin, file].into_iter().filter(|(is_wanted, ..)| *is_wanted);
            let fds = wanted.map(|(_, fd, events)| pollfd { fd, events, revents: 0 });
            let mut fds: Vec<_> = fds.collect();
            // `poll` counts whole milliseconds and drops the rest. A signal ends it with an error.
            let _ = poll(&mut fds, Some(time + Duration::from_micros(999)));
            has_keys && fds[0].revents & POLLIN != 0
        };
        Ok(key_pressed)
    }

    /// The keys that were pressed, each without a modifier.
    fn keys(&self) -> io::Result<Vec<KeyCode>> {
        let mut keys = Vec::new();
        // After a stop the donut may be in the background. (A poll of 0 ms reads nothing.)
        while !self.resume.load(SeqCst) && event::poll(Duration::from_millis(1))? {
            let mut event = event::read()?;
            // An arrow key's code begins like Esc. Nobody presses another key within 20 ms of Esc, so
            // what comes then is the rest of such a code, over a slow line.
            let soon = Duration::from_millis(20);
            while cfg!(unix) && event == Event::Key(KeyCode::Esc.into()) && event::poll(soon)? {
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

    /// The terminal's columns and rows, if there is one: 80x24 if it reports none.
    fn size(&self) -> io::Result<Option<(u16, u16)>> {
        #[cfg(unix)]
        let size = || tcgetwinsize(io::stdout()).map(|size| (size.ws_col, size.ws_row));
        #[cfg(windows)]
        let size = terminal::size;
        let or_default = |size: (u16, u16)| if size.0 > 0 && size.1 > 0 { size } else { (80, 24) };
        Ok(if self.is_terminal { Some(or_default(size()?)) } else { None })
    }
}

/// Standard output, without a buffer.
fn open_stdout() -> io::Result<File> {
    #[cfg(windows)]
    {
        // Asking turns on the console's escape codes.
        crossterm::ansi_support::supports_ansi();
        Ok(std::os::windows::io::AsHandle::as_handle(&io::stdout()).try_clone_to_owned()?.into())
    }
    #[cfg(unix)]
    {
        // If this is the controlling terminal, open it again, so that no write blocks. Making descriptor
        // 1 nonblocking would affect the shell's, too.
        let flags = OFlags::WRONLY | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
        let terminal = rustix::fs::open("/dev/tty", flags, Mode::empty());
        match terminal.and_then(|terminal| tcgetpgrp(io::stdout()).map(|_| terminal)) {
            Ok(terminal) => Ok(terminal.into()),
            Err(_) => Ok(io::stdout().as_fd().try_clone_to_owned()?.into()),
        }
    }
}

#[cfg(test)]
#[path = "../tests/unit/mod.rs"]
mod tests;
