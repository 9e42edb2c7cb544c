//! donut.c, Andy Sloane's spinning ASCII torus of 2006, in Rust.
//!
//! donut.c fills a terminal of 80 columns and 24 rows with a picture of 80 by 22 characters. At that
//! size this program draws the same picture, byte for byte. A picture of any other size has no original
//! that it could match, so it is ray-traced, unless an option says otherwise.
//!
//! # How donut.c draws a donut
//!
//! A torus is the surface swept by a small circle, the tube, whose centre travels round a large circle,
//! the ring. Here is the torus of the first frame, cut in half and seen from the side. The viewer is on
//! the left:
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
//! donut.c has R1 = 1, R2 = 2 and K2 = 5. The screen is a grid of cells, one for each character. K1,
//! the distance from the viewer to the screen, is measured in cells instead: it is as long as 30
//! columns are wide or 15 rows are high, because a cell is twice as tall as it is wide. The x axis
//! goes right, the y axis goes *down*, and the z axis goes away from the viewer.
//!
//! **Samples.** donut.c represents the surface by samples. The angle theta goes round the tube in steps
//! of 0.07, and the angle phi goes round the ring in steps of 0.02. Each pair of angles gives one
//! sample: a point of the surface, and the normal there, which is the direction that the surface faces.
//! The point is at the distance h from the axis, and at the distance f from the plane of the ring:
//! ```text
//! h = R2 + R1 cos theta      point   (h cos phi, h sin phi, f)
//! f = R1 sin theta           normal  (cos theta cos phi, cos theta sin phi, sin theta)
//! ```
//!
//! **Turns.** The donut is turned by the angle A about the x axis, and then by B about the z axis. Each
//! frame adds 0.04 to A and 0.02 to B. The two turns move the point to (X, Y, Z). In the formulas, t is
//! the point's y after the first turn. The normal is turned in the same way.
//! ```text
//! t = h sin phi cos A - f sin A      X = h cos phi cos B - t sin B
//! Z = h sin phi sin A + f cos A      Y = h cos phi sin B + t cos B
//! ```
//!
//! **Perspective.** Seen from the viewer, the point is at the depth `z = Z + K2`. Things twice as far
//! away look half as large, so the point appears `K1 X / z` to the right of the donut's centre, and `K1
//! Y / z` below it. donut.c has this centre at column 40 and row 12 of its 80x22 cells. That is below
//! the middle, and in some poses the lowest part of the donut is cut off.
//!
//! **The z-buffer.** Many samples fall into the same cell, and the cell shows the nearest of them. To
//! find it, a z-buffer keeps the largest 1/z so far for each cell.
//!
//! **Luminance.** The cell shows how bright its sample is. The luminance L is the dot product of the
//! normal and the vector (0, -1, -1), which points at the light, above and behind the viewer. This
//! vector is sqrt 2 long, so L is at most 1.41. donut.c multiplies L by 8, which gives at most 11.3. The
//! whole part of 8 L is an index, from 0 to 11, into a ramp of twelve characters from dark to bright,
//! `.,-~:;=!*#$@`. Where L is negative, the surface faces away from the light, and the index is 0.
//!
//! The letters R1, R2, K1, K2, A, B and L are those of the [article] in which Andy Sloane explains
//! donut.c. But A and B are the angles of donut.c itself: its A is pi/2 minus the article's A, and its B
//! is minus the article's B. All angles are in radians.
//!
//! # Two methods
//!
//! `classic` is all of the above: for each sample, it asks which cell the sample falls into. `exact`
//! goes the other way: for each cell, it asks what is there. It follows the ray from the viewer through
//! the centre of the cell, and the cell shows the first point of the donut that the ray hits.
//!
//! [article]: https://www.a1k0n.net/2011/07/20/donut-math.html

use std::f64::consts::TAU;
use std::fmt::Display;
use std::fs::File;
use std::io::{self, Write};
use std::ops::RangeInclusive;
use std::process::{self, ExitCode};
use std::str::FromStr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::SeqCst};
use std::time::{Duration, Instant};
use std::{env, panic, thread};

use clap::error::ErrorKind;
use clap::{CommandFactory, Parser, ValueEnum, ValueHint};
use crossterm::cursor::{Hide, MoveToColumn, Show};
use crossterm::queue;
use crossterm::style::{self, Color, ResetColor, SetForegroundColor};
use crossterm::terminal::{
    BeginSynchronizedUpdate, EndSynchronizedUpdate, EnterAlternateScreen, LeaveAlternateScreen,
};

// ---- Options -------------------------------------------------------------------------------------

/// A spinning ASCII donut: donut.c at 80x22, ray-traced at any other size
///
/// On a terminal the donut fills the window and spins until you press q. If the
/// output goes to a pipe or a file, it is what donut.c writes, escape codes
/// included. The size is then 80x22 unless you set another, and the donut spins
/// until you press Ctrl-C, or for as many frames as --frames says.
#[derive(Parser)]
#[command(name = "donut", version, verbatim_doc_comment, after_help = AFTER_HELP)]
// A later option overrides an earlier one, e.g. from `alias donut='donut --color cyan'`. Angles may be
// negative, and completions must not offer file names as values.
#[command(args_override_self = true)]
#[command(mut_args(|option| option.allow_hyphen_values(true).value_hint(ValueHint::Other)))]
struct Options {
    /// Frames per second; 0 means no limit
    ///
    /// From 0 to 1000. At 60, the donut spins twice as fast as at 30.
    #[arg(long, help_heading = "Motion", value_name = "N")]
    #[arg(default_value = "30", value_parser = within(0.0..=1000.0))]
    fps: f64,
    /// Stop after N frames; the last one stays on the screen
    ///
    /// On a terminal, the frames are drawn from the top of the screen, and
    /// the prompt comes below the last one.
    #[arg(long, help_heading = "Motion", value_name = "N", verbatim_doc_comment)]
    #[arg(value_parser = within(0..=1_000_000_000_000_u64))]
    frames: Option<u64>,
    /// Rotation per frame, in radians
    ///
    /// DA is about the x axis, which points right. DB is about the z axis,
    /// which points away from you. Both are from -1000000000 to 1000000000.
    #[arg(long, help_heading = "Motion", value_name = "DA,DB", verbatim_doc_comment)]
    #[arg(default_value = "0.04,0.02", value_parser = parse_angles)]
    spin: [f64; 2],
    /// Starting angle about the x axis, in radians
    #[arg(short = 'A', help_heading = "Motion", value_name = "RAD")]
    #[arg(default_value = "0", value_parser = within(ANGLES))]
    a: f64,
    /// Starting angle about the z axis, in radians
    #[arg(short = 'B', help_heading = "Motion", value_name = "RAD")]
    #[arg(default_value = "0", value_parser = within(ANGLES))]
    b: f64,
    /// How to draw
    #[arg(long, help_heading = "Look", value_enum, default_value_t, hide_default_value = true)]
    method: Method,
    /// Colour: a name, 0 to 255, or '#rrggbb'
    ///
    /// The # may be left out. The names are black, dark_grey, grey, white,
    /// red, green, yellow, blue, magenta, cyan, dark_red, dark_green,
    /// dark_yellow, dark_blue, dark_magenta and dark_cyan.
    #[arg(long, alias = "colour", help_heading = "Look", verbatim_doc_comment)]
    #[arg(value_parser = parse_color)]
    color: Option<Color>,
    /// Columns [default: all, or 80 in a pipe]
    ///
    /// From 1 to 4096, but at most the terminal's columns are used.
    #[arg(long, help_heading = "Size", value_name = "COLS", value_parser = within(SIZES))]
    width: Option<u16>,
    /// Rows [default: all but 2, or 22 in a pipe]
    ///
    /// From 1 to 4096, but at most the terminal's rows minus 2 are used.
    #[arg(long, help_heading = "Size", value_name = "ROWS", value_parser = within(SIZES))]
    height: Option<u16>,
    /// Height of a cell divided by its width
    ///
    /// From 0.1 to 10. A cell is the place of one character.
    #[arg(long, help_heading = "Size", value_name = "RATIO")]
    #[arg(default_value = "2", value_parser = within(0.1..=10.0))]
    aspect: f64,
    /// Radius of the tube
    ///
    /// In any unit, from 0.000001 to 10000.
    #[arg(long, help_heading = "Geometry", value_name = "R")]
    #[arg(default_value = "1", value_parser = within(1e-6..=1e4))]
    r1: f64,
    /// Radius of the ring, 1.01 to 30 times --r1
    ///
    /// The ring is the circle in the middle of the tube, all round the hole.
    #[arg(long, help_heading = "Geometry", value_name = "R")]
    #[arg(default_value = "2", value_parser = within(LENGTHS))]
    r2: f64,
    /// Distance from you to the centre of the donut
    ///
    /// At least 1.001 times the sum of --r1 and --r2.
    #[arg(long, help_heading = "Geometry", value_name = "D")]
    #[arg(default_value = "5", value_parser = within(LENGTHS))]
    k2: f64,
}

const AFTER_HELP: &str = "\
Keys:
  q, Esc, Ctrl-C  quit
  p               pause or resume
  space           turn the shading off or on
  Ctrl-Z          suspend

Examples:
  donut --fps 60 --spin 0.02,0.01   # smoother, at the same speed
  donut -A 1 -B 1 --color cyan";

#[derive(Clone, Copy, Debug, Default, PartialEq, ValueEnum)]
enum Method {
    /// Default: classic for donut.c's own picture, else exact
    #[default]
    Auto,
    /// As donut.c does: plot many points, and let the nearest win
    Classic,
    /// Follow a ray through the middle of each character
    Exact,
}

const SIZES: RangeInclusive<u16> = 1..=4096;
const ANGLES: RangeInclusive<f64> = -1e9..=1e9;
const LENGTHS: RangeInclusive<f64> = 1e-6..=1e6;

/// A parser for the numbers in a range.
fn within<T: FromStr + PartialOrd + Display + Clone>(
    range: RangeInclusive<T>,
) -> impl Fn(&str) -> Result<T, String> + Clone {
    move |text| {
        let number = text.parse().ok().filter(|number| range.contains(number));
        // Types of whole numbers cannot parse 0.5.
        let kind = if "0.5".parse::<T>().is_ok() { "number" } else { "whole number" };
        let (least, most) = (range.start(), range.end());
        number.ok_or_else(|| format!("expected a {kind} from {least} to {most}"))
    }
}

fn parse_angles(text: &str) -> Result<[f64; 2], String> {
    let angle = within(ANGLES);
    match text.split_once(',') {
        Some((a, b)) => Ok([angle(a.trim())?, angle(b.trim())?]),
        None => Err("expected two angles with a comma between them, such as 0.04,0.02".into()),
    }
}

fn parse_color(text: &str) -> Result<Color, String> {
    let hex = text.strip_prefix('#').unwrap_or(text);
    if hex.len() == 6 && hex.bytes().all(|digit| digit.is_ascii_hexdigit()) {
        let [r, g, b] = [0, 2, 4].map(|i| u8::from_str_radix(&hex[i..i + 2], 16).unwrap());
        return Ok(Color::Rgb { r, g, b });
    }
    if let Ok(index) = text.parse() {
        return Ok(Color::AnsiValue(index));
    }
    let name = text.to_lowercase().replace("gray", "grey");
    let color = Color::try_from(name.as_str()).ok().filter(|&color| color != Color::Reset);
    color.ok_or("expected a name from --help, 0 to 255, or '#rrggbb'".into())
}

/// The range of R2 / R1. Beyond it, the hole or the tube is too small to see in most pictures.
const RING_RATIOS: RangeInclusive<f64> = 1.01..=30.0;
/// The least K2 / (R1 + R2). At this distance, a donut that is seen edge-on already fills 175 degrees of
/// the view.
const LEAST_DISTANCE_RATIO: f64 = 1.001;

/// Undoes the rounding of a product or quotient of two lengths: in f64, 0.35 / 0.07 is slightly less than
/// 5. If a number with at most six decimals is only a rounding error away, that number was meant.
fn snap_to_decimal(result: f64) -> f64 {
    let decimal = (1e6 * result).round() / 1e6;
    if (result - decimal).abs() < 1e-15 * result { decimal } else { result }
}

impl Options {
    /// R2 and K2 in units of R1.
    fn proportions(&self) -> (f64, f64) {
        (snap_to_decimal(self.r2 / self.r1), snap_to_decimal(self.k2 / self.r1))
    }

    /// What is wrong with options that are allowed one by one, but not together.
    fn conflict(&self) -> Option<String> {
        let &Options { r1, r2, k2, .. } = self;
        let (least, most) = (RING_RATIOS.start(), RING_RATIOS.end());
        if !RING_RATIOS.contains(&self.proportions().0) {
            let [from, to] = [least, most].map(|ratio| snap_to_decimal(ratio * r1));
            Some(format!("--r2 is {r2}, but must be {from} to {to}: {least} to {most} times --r1"))
        } else if snap_to_decimal(k2 / (r1 + r2)) < LEAST_DISTANCE_RATIO {
            let from = snap_to_decimal(LEAST_DISTANCE_RATIO * (r1 + r2));
            let rule = format!("{LEAST_DISTANCE_RATIO} times the sum of --r1 and --r2");
            Some(format!("--k2 is {k2}, but must be at least {from}: {rule}"))
        } else if self.method == Method::Classic && self.proportions() != (2.0, 5.0) {
            // With other proportions, the steps of `classic` could leave gaps: see `angle_steps`.
            let rule = "--method classic needs --r1, --r2 and --k2 in the ratio 1 : 2 : 5";
            Some(format!("{rule}, but these are {r1}, {r2} and {k2}"))
        } else {
            None
        }
    }

    /// The view for the size that the options ask for. `terminal` is the terminal's columns and rows,
    /// which limit the size, or `None` where standard output is no terminal.
    fn view(&self, terminal: Option<(u16, u16)>) -> View {
        let (width, height) = match terminal {
            None => (self.width.unwrap_or(80), self.height.unwrap_or(22)),
            Some((columns, rows)) => {
                // One row stays free above the picture, and one below it.
                let rows = rows.saturating_sub(2).max(1);
                (self.width.unwrap_or(columns).min(columns), self.height.unwrap_or(rows).min(rows))
            }
        };
        let (r2, k2) = self.proportions();
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
            let _ = writeln!(io::stderr(), "donut: {error}");
            ExitCode::FAILURE
        }
        _ => ExitCode::SUCCESS,
    }
}

// ---- The loop ------------------------------------------------------------------------------------

/// Spins the donut until the last frame is drawn, somebody ends it, or its reader goes away.
fn run(options: &Options) -> io::Result<()> {
    let console = Console::open(options)?;
    let played = play(options, console);
    let restored = console.leave();
    console.end_by_signal();
    played.and(restored)
}

/// donut.c's `for (;;)`. In a pipe, there is nothing to do but to draw each frame when it is due. On a
/// terminal, the loop also looks for signals, keys and a new size, about every 50 ms. So in some of its
/// rounds no frame is due, for example while the donut is paused.
fn play(options: &Options, console: &Console) -> io::Result<()> {
    let interval = match options.fps {
        0.0 => Duration::ZERO,
        // A Duration cannot hold 1 / fps seconds if fps is tiny. 1e9 seconds, nearly 32 years, will do.
        fps => Duration::from_secs_f64((1.0 / fps).min(1e9)),
    };
    let most_frames = options.frames.unwrap_or(u64::MAX);
    let (mut frame_count, mut due, mut is_paused) = (0, Instant::now(), false);
    let mut angles = [options.a, options.b];
    let mut size = console.size()?;
    let mut renderer = Renderer::new(options.view(size), options.method, RAMP);
    'rounds: while frame_count < most_frames {
        let until_due = due.saturating_duration_since(Instant::now());
        thread::sleep(if is_paused { PATIENCE } else { until_due.min(PATIENCE) });
        if console.end_signal.load(SeqCst) != 0 {
            break;
        }
        let is_in_foreground = console.is_in_foreground();
        // In the background, the program leaves the terminal and waits. If it was stopped, it leaves the
        // terminal to enter it anew, because another program may have changed the screen or the settings.
        if console.was_continued.swap(false, SeqCst) || !is_in_foreground {
            console.leave()?;
        }
        if !is_in_foreground {
            thread::sleep(PATIENCE);
            continue;
        }
        // After `enter` has entered the terminal, the screen has to be cleared. In a pipe there is nothing to
        // enter, but `enter` returns true in the first round: donut.c also begins by clearing the screen.
        let mut clear = console.enter()?;
        let new_size = console.size()?;
        if new_size != size {
            (size, clear) = (new_size, true);
            renderer = Renderer::new(options.view(size), renderer.method, renderer.ramp);
        }
        let mut redraw = clear;
        for key in console.keys() {
            match key {
                b'q' | ESCAPE => return Ok(()),
                b'p' => is_paused = !is_paused,
                b' ' => {
                    renderer.ramp = if renderer.ramp == RAMP { FLAT } else { RAMP };
                    redraw = true;
                }
                CTRL_Z => {
                    console.leave()?;
                    system::stop_job();
                    continue 'rounds;
                }
                _ => {}
            }
        }
        let is_due = !is_paused && due <= Instant::now();
        if is_due {
            // The first frame shows the starting angles.
            if frame_count > 0 {
                angles = next_angles(renderer.method, angles, options.spin);
            }
            frame_count += 1;
            // Each frame is due one interval after the one before was due, so that delays do not add up.
            // But after a stall, the missed frames do not come in a burst.
            due = (due + interval).max(Instant::now());
        }
        if is_due || redraw {
            renderer.method = method_now(options.method, &renderer.view, angles, options.spin);
            renderer.render_frame(angles[0], angles[1]);
            console.show(&renderer, clear)?;
        }
    }
    Ok(())
}

/// The method, `Classic` or `Exact`, that draws the frame with these angles.
///
/// `Auto` draws donut.c's own picture with `Classic`, as long as floats are fine enough for it: the gap
/// between an angle and the next float must be at most a quarter of the angle's spin. (If the spin is 0,
/// a gap of 0.0002 is too small to show.) With donut.c's own start and spin, this ends at frame
/// 3,345,245. There A passes 2^17, where the gap is 1/64, more than 0.04 / 4, and adding 0.04 adds 3/64.
fn method_now(option: Method, view: &View, angles: [f64; 2], spin: [f64; 2]) -> Method {
    let floats_are_fine = (0..2).all(|i| {
        let float = angles[i].abs() as f32;
        let gap = f32::from_bits(float.to_bits() + 1) - float;
        let largest_gap = if spin[i] == 0.0 { 2e-4 } else { spin[i].abs() / 4.0 };
        f64::from(gap) <= largest_gap
    });
    match option {
        Method::Auto if *view == View::DONUT_C && floats_are_fine => Method::Classic,
        Method::Auto => Method::Exact,
        method => method,
    }
}

/// The angles A and B of the next frame. donut.c keeps its angles in variables of type `float`, so each
/// of its sums is rounded, and the errors add up. `Classic` has to make the very same errors.
fn next_angles(method: Method, angles: [f64; 2], spin: [f64; 2]) -> [f64; 2] {
    [0, 1].map(|i| match method {
        Method::Classic => add_step(angles[i] as f32, spin[i]).into(),
        _ => angles[i] + spin[i],
    })
}

// ---- View ----------------------------------------------------------------------------------------

/// The donut's proportions, the size of the picture, and how the donut is projected onto the picture.
///
/// The proportions are in units of the tube's radius, so that R1 is 1. Places on the screen are measured
/// in cells: cell (c, r), in column c and row r, reaches from c to c + 1 across and from r to r + 1
/// down. The point (X, Y, Z) appears at `x = cx + k1x X / (Z + K2)`, `y = cy + k1y Y / (Z + K2)`.
///
/// Nothing is drawn in column 0 or in row 0. In place of column 0, donut.c prints a newline, and its
/// test `y > 0` leaves out row 0.
#[derive(Clone, Copy, PartialEq)]
struct View {
    r2: f64,
    k2: f64,
    /// Columns and rows of the picture.
    width: usize,
    height: usize,
    /// Where the centre of the donut appears.
    cx: f64,
    cy: f64,
    /// The scale K1, in columns and in rows.
    k1x: f64,
    k1y: f64,
}

impl View {
    const DONUT_C: View =
        View { r2: 2.0, k2: 5.0, width: 80, height: 22, cx: 40.0, cy: 12.0, k1x: 30.0, k1y: 15.0 };

    /// donut.c's own view if everything is as in donut.c. Otherwise, the donut is in the middle of the
    /// picture, and as large as it can be without being cut off at any angle. `aspect` is the height of
    /// a cell divided by its width.
    fn new(width: usize, height: usize, aspect: f64, r2: f64, k2: f64) -> View {
        if (width, height, aspect, r2, k2) == (80, 22, 2.0, 2.0, 5.0) {
            return View::DONUT_C;
        }
        let (w, h) = (width as f64, height as f64);
        let k1x = f64::min((w - 1.0) / 2.0, aspect * (h - 1.0) / 2.0) / apparent_radius(r2, k2);
        // Column 0 and row 0 stay empty, so the middle of the other cells is half a cell further right,
        // and half a cell further down.
        let (cx, cy) = ((w + 1.0) / 2.0, (h + 1.0) / 2.0);
        View { r2, k2, width, height, cx, cy, k1x, k1y: k1x / aspect }
    }
}

/// How large the donut can look. However it is turned, it just fits into a sphere of radius R1 + R2, which
/// looks like a circle. This is the circle's radius on a screen at the distance 1.
fn apparent_radius(r2: f64, k2: f64) -> f64 {
    let radius = 1.0 + r2;
    radius / (k2 * k2 - radius * radius).sqrt()
}

// ---- Rendering -----------------------------------------------------------------------------------

/// The characters that show the luminance, from dark to bright.
const RAMP: &[u8; 12] = b".,-~:;=!*#$@";
/// What takes the place of the ramp while the shading is off.
const FLAT: &[u8; 12] = &[b'.'; 12];

/// The character of a luminance L: the whole part of 8 L is its place in the ramp.
fn glyph(ramp: &[u8; 12], luminance: f64) -> u8 {
    // Where the surface faces away from the light, L is negative, and `as u8` makes it 0.
    ramp[usize::from((8.0 * luminance) as u8).min(11)]
}

struct Renderer {
    view: View,
    /// `Classic` or `Exact`, once a frame is drawn.
    method: Method,
    ramp: &'static [u8; 12],
    /// The character in each cell: `width * height` bytes, row by row, blank where there is no donut.
    framebuffer: Vec<u8>,
    /// For `classic`: 1/z of the nearest sample so far, in each cell. It has two rows more than the
    /// framebuffer, because in donut.c's own view some samples fall below the picture, by up to two
    /// rows.
    zbuffer: Vec<f32>,
    /// For `classic`: the tables of theta and of phi. They can be long, so they are made when they are
    /// first needed.
    tables: Option<[TrigTable; 2]>,
}

impl Renderer {
    fn new(view: View, method: Method, ramp: &'static [u8; 12]) -> Renderer {
        let View { width, height, .. } = view;
        let (framebuffer, zbuffer) = (vec![b' '; width * height], vec![0.0; width * (height + 2)]);
        Renderer { view, method, ramp, framebuffer, zbuffer, tables: None }
    }

    /// Draws the donut, turned by the angles A and B, into the framebuffer.
    fn render_frame(&mut self, a: f64, b: f64) {
        self.framebuffer.fill(b' ');
        if self.method == Method::Classic {
            self.plot_samples(a as f32, b as f32);
        } else {
            self.trace(a, b, Torus::first_hits);
        }
    }

    /// `classic`: donut.c's double loop over theta and phi.
    ///
    /// All arithmetic is in f32 and in donut.c's order of operations, because another order would round
    /// to other characters. donut.c has names of one letter: `sin_phi` is its c, `cos_theta` d, `sin_a`
    /// e, `sin_theta` f, `cos_a` g, `ooz` (1/z) D, `cos_phi` l, `cos_b` m, `sin_b` n and `cell` o.
    fn plot_samples(&mut self, a: f32, b: f32) {
        self.reset_zbuffer();
        let View { width, r2, k2, cx, cy, k1x, k1y, .. } = self.view;
        let [r2, k2, cx, cy, k1x, k1y] = [r2, k2, cx, cy, k1x, k1y].map(|value| value as f32);
        let ((sin_a, cos_a), (sin_b, cos_b)) = (sin_cos(a), sin_cos(b));
        let [(sin_thetas, cos_thetas), (sin_phis, cos_phis)] =
            self.tables.get_or_insert_with(|| angle_steps(&self.view).map(trig_table));
        // donut.c's loop over phi is three loops here. The compiler vectorises the first two, which it
        // would not do with a single one. The slices tell it that the tables are equally long, so
        // that these loops need no bounds checks.
        let count = sin_phis.len();
        let (sin_phis, cos_phis) = (&sin_phis[..count], &cos_phis[..count]);
        let (mut ooz, mut x, mut y) = (vec![0.0; count], vec![0.0; count], vec![0.0; count]);
        let mut cells = vec![0; count];
        for (&sin_theta, &cos_theta) in sin_thetas.iter().zip(cos_thetas.iter()) {
            let h = cos_theta + r2;
            for i in 0..count {
                let (sin_phi, cos_phi) = (sin_phis[i], cos_phis[i]);
                ooz[i] = 1.0 / (sin_phi * h * sin_a + sin_theta * cos_a + k2);
                let t = sin_phi * h * cos_a - sin_theta * sin_a;
                x[i] = cx + k1x * ooz[i] * (cos_phi * h * cos_b - t * sin_b);
                y[i] = cy + k1y * ooz[i] * (cos_phi * h * sin_b + t * cos_b);
            }
            // donut.c skips the samples that are not in the picture. Here the z-buffer keeps them from
            // showing: see `reset_zbuffer`. (A sample on the right edge of the picture, where x is
            // `width`, is taken for one in column 0 of the next row.)
            for i in 0..count {
                cells[i] = floor(x[i]) + width as u32 * floor(y[i]);
            }
            for i in 0..count {
                let (cell, sin_phi, cos_phi) = (cells[i] as usize, sin_phis[i], cos_phis[i]);
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

    /// Prepares the z-buffer for a frame. It holds 1/z. 0 means infinitely far, so any sample is nearer.
    /// Infinity means z = 0, at the viewer's eye, so no sample is nearer: row 0, column 0 and the rows
    /// below the picture stay blank.
    fn reset_zbuffer(&mut self) {
        let View { width, height, .. } = self.view;
        self.zbuffer.fill(f32::INFINITY);
        for row in 1..height {
            self.zbuffer[row * width + 1..(row + 1) * width].fill(0.0);
        }
    }

    /// `exact`: a cell shows what the ray through its centre hits first. `first_hits` finds these hits for
    /// N rays at a time. (The tests pass other methods, to compare them.)
    fn trace<const N: usize>(
        &mut self,
        a: f64,
        b: f64,
        first_hits: impl Fn(&Torus, &[Ray; N]) -> [f64; N],
    ) {
        let View { r2, k2, width, cx, cy, k1x, k1y, .. } = self.view;
        let (torus, radius) = (Torus::new(r2, a, b), apparent_radius(r2, k2));
        for (row, cells) in self.framebuffer.chunks_exact_mut(width).enumerate().skip(1) {
            let dy = (row as f64 + 0.5 - cy) / k1y;
            // The donut stays in a sphere, which appears as a circle. Only the cells of a row that are
            // in the circle can show the donut.
            let half_width = (radius * radius - dy * dy).max(0.0).sqrt() * k1x;
            let end = width.min((cx + half_width) as usize + 1);
            for column in ((cx - half_width) as usize..end).step_by(N) {
                let dx = |i| ((column + i) as f64 + 0.5 - cx) / k1x;
                let rays = std::array::from_fn(|i| torus.ray(dx(i), dy, k2));
                let hits = first_hits(&torus, &rays);
                let lights: [f64; N] = std::array::from_fn(|i| torus.luminance(&rays[i], hits[i]));
                for (i, cell) in cells[column..end].iter_mut().take(N).enumerate() {
                    if hits[i] < MISS {
                        *cell = glyph(self.ramp, lights[i] + TIE_BIAS);
                    }
                }
            }
        }
    }
}

// ---- classic: donut.c's arithmetic ---------------------------------------------------------------

/// donut.c's steps of theta and phi, or shorter ones for a picture that is larger than donut.c's.
///
/// Where the donut is nearest to the viewer, donut.c's samples are about a cell apart. In a larger
/// picture the same steps would leave gaps. So if the larger of k1x and k1y is n times donut.c's k1x, the
/// steps are an n-th of donut.c's.
fn angle_steps(view: &View) -> [f64; 2] {
    let shrink = f64::min(1.0, View::DONUT_C.k1x / view.k1x.max(view.k1y));
    [0.07 * shrink, 0.02 * shrink]
}

/// The sines and the cosines of the angles that one of donut.c's loops runs through.
type TrigTable = (Vec<f32>, Vec<f32>);

/// The table for the angles 0, `step`, and so on, once round.
fn trig_table(step: f64) -> TrigTable {
    let angles = std::iter::successors(Some(0.0), |&angle| Some(add_step(angle, step)));
    // donut.c stops at 6.28. With its own steps, TAU gives the same angles. Shorter steps would leave a
    // gap between 6.28 and TAU.
    angles.take_while(|&angle| f64::from(angle) < TAU).map(sin_cos).unzip()
}

/// donut.c's `angle += step`: C adds in `double` and rounds the sum to `float`.
fn add_step(angle: f32, step: f64) -> f32 {
    (f64::from(angle) + step) as f32
}

/// The sine and the cosine of an angle: C computes them in `double`, and rounds them to `float`.
fn sin_cos(angle: f32) -> (f32, f32) {
    let (sin, cos) = f64::from(angle).sin_cos();
    (sin as f32, cos as f32)
}

/// The whole part of a value from 0 to 2^23.
///
/// This is `value as u32`, but in plain arithmetic, which the compiler vectorises even if the processor
/// has no vector instruction for the cast. From 2^23 to 2^24 floats are 1 apart. So adding 2^23 rounds
/// the value to a whole number, and leaves this number in the low bits of the sum. If it was rounded up,
/// it is one too large.
fn floor(value: f32) -> u32 {
    const TWO_TO_23: f32 = 8_388_608.0;
    let rounded = value + TWO_TO_23;
    let is_up = rounded - TWO_TO_23 > value;
    rounded.to_bits() - TWO_TO_23.to_bits() - u32::from(is_up)
}

// ---- exact: rays and a torus ---------------------------------------------------------------------

/// How many rays are followed side by side. The compiler turns a loop over them into vector
/// instructions, and while one ray waits for a division, others go on.
const LANES: usize = 8;
/// One number for each of these rays.
type Lanes = [f64; LANES];
/// The s of a ray that misses (see `Torus`).
const MISS: f64 = f64::INFINITY;
/// A search for a hit ends with a step no longer than this, in units of R1. After so short a step of
/// Newton's method, hardly more than rounding errors are left. Only where a ray grazes the donut may the
/// search end further from the true hit. But there the ray runs along the surface, so this does not show.
const LAST_STEP: f64 = 1e-8;
/// Added to each luminance, too little to be seen. In symmetric poses, the true 8 L may be exactly a
/// whole number, and rounding would choose between two glyphs. With this added, the brighter one is drawn
/// on every machine.
const TIE_BIAS: f64 = 1e-12;

/// The donut of one frame.
///
/// A ray is P = P0 + s U. U is its direction, of length 1. P0 is its point nearest to the donut's
/// centre, which is the origin, so P0 and U are at right angles. The number s says where on the ray P
/// is: s is 0 at P0, and negative on the viewer's side of it. Three numbers matter about a point P:
/// ```text
/// |P|^2 = d0 + s^2      the square of its distance from the centre
/// f     = f0 + fu s     how far it is from the plane of the ring: negative on one side of it
/// l     = l0 + lu s     its dot product with (0, -1, -1), the vector to the light
/// ```
///
/// Let h be the distance of P from the axis. P is on the surface if it is R1 = 1 away from the ring:
/// ```text
/// (h - R2)^2 + f^2 = 1
/// |P|^2 + R2^2 - 1 = 2 R2 h                        because |P|^2 = h^2 + f^2
/// (|P|^2 + R2^2 - 1)^2 = 4 R2^2 (|P|^2 - f^2)      squared
/// G(s) = (s^2 + p)^2 + q s + r = 0                 left minus right, along the ray
/// ```
///
/// G is positive outside the donut, and negative inside. Because s is measured from P0, there is no
/// cubic term, and the coefficients stay small however far away the viewer is.
struct Torus {
    r2: f64,
    /// The axis of revolution, of length 1, after the turns by A and B.
    axis: [f64; 3],
}

/// A ray, as the numbers that `Torus` explains.
#[derive(Clone, Copy, Debug)]
struct Ray {
    d0: f64,
    f0: f64,
    fu: f64,
    l0: f64,
    lu: f64,
}

impl Torus {
    fn new(r2: f64, a: f64, b: f64) -> Torus {
        let ((sin_a, cos_a), (sin_b, cos_b)) = (a.sin_cos(), b.sin_cos());
        Torus { r2, axis: [sin_a * sin_b, -sin_a * cos_b, cos_a] }
    }

    /// The ray from the viewer at (0, 0, -K2) in the direction (dx, dy, 1).
    fn ray(&self, dx: f64, dy: f64, k2: f64) -> Ray {
        let [x, y, z] = self.axis;
        // Let alpha be the angle between the ray and the z axis. Then U is (dx, dy, 1) times cos alpha.
        // P0 is (dx, dy, -tan^2 alpha) times `depth`, its distance from the viewer along the z axis.
        let tan_squared = dx * dx + dy * dy;
        let cos = 1.0 / (1.0 + tan_squared).sqrt();
        let depth = k2 * cos * cos;
        Ray {
            d0: k2 * depth * tan_squared,
            f0: depth * (dx * x + dy * y - tan_squared * z),
            fu: cos * (dx * x + dy * y + z),
            l0: depth * (tan_squared - dy),
            lu: -cos * (dy + 1.0),
        }
    }

    /// The coefficients p, q and r of the ray's G. They come from the squared equation, with |P|^2 and f
    /// written out: p from the terms with s^2, q from those with s, and r is the rest, less p^2.
    fn quartic(&self, &Ray { d0, f0, fu, .. }: &Ray) -> [f64; 3] {
        let r2_r2 = self.r2 * self.r2;
        // The square of the sine of the angle between the ray and the axis. Where the ray looks through a
        // nearly closed hole, fu is nearly 1 or -1, and p and r are small differences of larger terms.
        // Computing 1 - fu^2 first keeps more of their digits than multiplying it out.
        let sine_squared = 1.0 - fu * fu;
        let p = d0 + r2_r2 - 1.0 - 2.0 * r2_r2 * sine_squared;
        let q = 8.0 * r2_r2 * f0 * fu;
        let r = 4.0 * r2_r2 * (f0 * f0 - d0 * fu * fu - sine_squared * (1.0 - r2_r2 * fu * fu));
        [p, q, r]
    }

    /// The s where the ray enters the space that the donut stays in: a sphere of radius R1 + R2,
    /// between two planes, f = -1 and f = 1. No hit comes before it.
    fn entry(&self, &Ray { d0, f0, fu, .. }: &Ray) -> f64 {
        let radius = 1.0 + self.r2;
        let sphere = -(radius * radius - d0).max(0.0).sqrt();
        // If fu is 0, this is at infinity, or NaN, which `max` ignores.
        let planes = -(1.0 + f0 * fu.signum()) / fu.abs();
        sphere.max(planes)
    }

    /// The s of each ray's first hit. G is positive at the viewer, who is outside the donut, so the first
    /// hit is where G first falls to 0. G can have two valleys, and it falls to 0 in the first one that is
    /// deep enough: at s1 in the drawing, or at s3. If no valley is deep enough, the ray misses.
    /// ```text
    ///  G  \           .---.           /
    ///      \        .'     '.        /
    ///  -----s1----s2---------s3----s4---> s
    ///        '.  .'           '.  .'
    ///          ''  -w        w  ''
    /// ```
    ///
    /// -w and w are the inflections of G, where its second derivative, 12 s^2 + 4 p, is 0. They need not
    /// be at s2 and s3. Between them G bends down, and to the left and to the right of them it bends up.
    /// If there are no inflections, G bends up everywhere, and w is 0. The bottom of a valley is where G
    /// bends up. So the bottom of the left valley is left of -w, and s1 is further left still.
    ///
    /// Without inflections there is only one valley. Its first root is s1 if it is left of 0, and otherwise
    /// s3.
    ///
    /// Each ray has a search, which walks along the ray by Newton's method: it steps from s to where the
    /// tangent of G at s is 0. Where G bends up, it lies above its tangents, so a step that starts where G
    /// is positive never passes a root. Where G bends down, the same holds for a step that starts where G
    /// is negative.
    ///
    /// 1. If the ray's entry is left of -w, the search starts at the entry and moves right, towards s1. If
    ///    there is no s1, it comes to a dead end: a place where G rises, or a step that leads to -w or past
    ///    it. The search then starts again, at w. If the entry is further right, there is no s1, and the
    ///    search starts at w.
    /// 2. If G is positive at w, there is no root before w: without an s1, G is positive at -w as well, and a
    ///    curve that bends down stays above 0 between two such ends. The search moves right, towards s3. If
    ///    there is no s3, it comes to where G rises, and stays there: the ray misses.
    /// 3. If G is negative at w, s3 is between -w and w, and the search moves left, towards s3.
    ///
    /// In each of the three cases a search moves in one direction, and a step that would lead the other way
    /// is not taken. So rounding cannot make it go to and fro for ever.
    fn first_hits(&self, rays: &[Ray; LANES]) -> Lanes {
        let [mut p, mut q, mut r, mut w, mut s] = [[0.0; LANES]; 5];
        for (i, ray) in rays.iter().enumerate() {
            [p[i], q[i], r[i]] = self.quartic(ray);
            w[i] = (p[i] / -3.0).max(0.0).sqrt();
            let entry = self.entry(ray);
            s[i] = if entry < -w[i] { entry } else { w[i] };
        }
        // Cases 1 and 2. The compiler vectorises this loop, because `|`, `&` and an `if` that only
        // chooses between two values need no branches.
        let mut moving_right = true;
        while moving_right {
            moving_right = false;
            for i in 0..LANES {
                let (next, slope) = newton([p[i], q[i], r[i]], s[i]);
                let dead_end = (s[i] < -w[i]) & ((slope >= 0.0) | (next >= -w[i]));
                moving_right |= dead_end | (next - s[i] > LAST_STEP);
                let next = if next > s[i] { next } else { s[i] };
                s[i] = if dead_end { w[i] } else { next };
            }
        }
        // Now each search that is not at s1 is at w or to the right of it. If G rises there, the ray misses:
        // G is positive and goes on rising. (If G is negative at w, it falls all the way from s3 to w.) If G
        // falls and the search is still at w, G is negative: from a positive G, a step would have led to the
        // right. That is case 3.
        let mut moving_left = false;
        for i in 0..LANES {
            let (_, slope) = newton([p[i], q[i], r[i]], s[i]);
            let misses = (s[i] >= w[i]) & (slope >= 0.0);
            s[i] = if misses { MISS } else { s[i] };
            moving_left |= s[i] == w[i];
        }
        while moving_left {
            moving_left = false;
            for i in 0..LANES {
                let (next, _) = newton([p[i], q[i], r[i]], s[i]);
                // s3 is right of -w. Only rounding can make a step seem to lead past -w.
                let next = if next > -w[i] { next } else { -w[i] };
                // All other searches stay. Those right of w, or at MISS, fail `s <= w`. Those left of -w
                // are left of `next`, too.
                let goes_left = (s[i] <= w[i]) & (next < s[i]);
                moving_left |= goes_left & (s[i] - next > LAST_STEP);
                s[i] = if goes_left { next } else { s[i] };
            }
        }
        s
    }

    /// The luminance where the ray hits: the dot product of the normal and the vector to the light.
    /// With the axis n, the normal at P is `(P - f n) (1 - R2 / h) + f n`. On the surface h is
    /// `(|P|^2 + R2^2 - 1) / (2 R2)`, which takes no square root.
    fn luminance(&self, ray: &Ray, s: f64) -> f64 {
        let (r2_r2, n_dot_light) = (self.r2 * self.r2, -(self.axis[1] + self.axis[2]));
        let f = ray.f0 + ray.fu * s;
        let p_dot_light = ray.l0 + ray.lu * s;
        let radial = 1.0 - 2.0 * r2_r2 / (ray.d0 + s * s + r2_r2 - 1.0);
        (p_dot_light - f * n_dot_light) * radial + f * n_dot_light
    }
}

/// Where Newton's method steps from s, and the slope of G at s.
fn newton([p, q, r]: [f64; 3], s: f64) -> (f64, f64) {
    let u = s * s + p;
    let slope = 4.0 * u * s + q;
    (s - (u * u + (q * s + r)) / slope, slope)
}

// ---- Terminal ------------------------------------------------------------------------------------

/// How long the loop sleeps at most before it looks around, how long it waits for the rest of a key's code,
/// and how long a write may last before a signal cuts it short.
const PATIENCE: Duration = Duration::from_millis(50);

const ESCAPE: u8 = 0x1b;
const CTRL_Z: u8 = 0x1a;

/// Standard output, and what the program has to remember to leave a terminal as it was.
///
/// Before the program draws on a terminal, it *enters* the terminal: it hides the cursor, has each key
/// sent at once and not echoed, and switches to the alternate screen, a second screen for programs that
/// fill it. To *leave* the terminal is to undo all this.
struct Console {
    /// The terminal of standard output, opened once more, or standard output itself if it is a pipe or a
    /// file.
    file: File,
    is_terminal: bool,
    /// With --frames there is no alternate screen, because the last frame has to stay.
    has_alternate_screen: bool,
    color: Option<Color>,
    /// Whether the program has entered the terminal and not left it since.
    is_entered: AtomicBool,
    /// The number of the signal that asks the program to end, or 0. The handlers of these signals set it.
    end_signal: Arc<AtomicUsize>,
    /// Whether the program was stopped and goes on. SIGCONT's handler sets it.
    was_continued: Arc<AtomicBool>,
}

impl Console {
    /// Opens the console for the rest of the program's life, so that the handlers of signals and panics
    /// may use it.
    fn open(options: &Options) -> io::Result<&'static Console> {
        let (file, is_terminal) = system::open_output()?;
        if is_terminal && env::var_os("TERM").is_some_and(|term| term == "dumb") {
            return Err(io::Error::other("TERM is dumb, but the picture needs escape codes"));
        }
        style::force_color_output(true); // --color is explicit, so it overrides NO_COLOR.
        let console: &Console = Box::leak(Box::new(Console {
            file,
            is_terminal,
            has_alternate_screen: options.frames.is_none(),
            color: options.color,
            is_entered: AtomicBool::new(false),
            end_signal: Arc::default(),
            was_continued: Arc::default(),
        }));
        if is_terminal {
            let previous_hook = panic::take_hook();
            panic::set_hook(Box::new(move |info| {
                let _ = console.leave();
                previous_hook(info);
            }));
            // ctrlc works on Windows, too. The other signals exist only on Unix.
            let obey_ctrl_c = || console.end_signal.store(2, SeqCst); // 2 is SIGINT.
            ctrlc::set_handler(obey_ctrl_c).map_err(io::Error::other)?;
            console.catch_signals()?;
        }
        Ok(console)
    }

    /// If a signal has come, ends the program by the same signal. So a shell, and a loop or script
    /// around the program, can tell what ended it.
    fn end_by_signal(&self) {
        let signal = self.end_signal.load(SeqCst) as i32;
        if signal != 0 {
            system::raise(signal);
            process::exit(128 + signal) // What a shell would say of a program that the signal ended.
        }
    }

    /// Enters the terminal, unless the program has entered already. Returns true if it has entered just
    /// now.
    fn enter(&self) -> io::Result<bool> {
        let just_entered = !self.is_entered.swap(true, SeqCst);
        if just_entered && self.is_terminal {
            self.take_keys()?;
            let mut bytes = Vec::new();
            if self.has_alternate_screen {
                queue!(bytes, EnterAlternateScreen)?;
            }
            queue!(bytes, Hide)?;
            self.write(&bytes)?;
        }
        Ok(just_entered)
    }

    /// Leaves the terminal as it was found, if the program has entered it.
    fn leave(&self) -> io::Result<()> {
        if !self.is_entered.swap(false, SeqCst) || !self.is_terminal {
            return Ok(());
        }
        let mut bytes = Vec::new();
        // A signal may have cut a frame short, in the middle of a row.
        queue!(bytes, EndSynchronizedUpdate, ResetColor, MoveToColumn(0), Show)?;
        if self.has_alternate_screen {
            queue!(bytes, LeaveAlternateScreen)?;
        }
        let written = self.write(&bytes);
        self.give_back_keys();
        written
    }

    /// Writes a whole frame at once. `clear` says whether to clear the screen first.
    fn show(&self, renderer: &Renderer, clear: bool) -> io::Result<()> {
        // The escape codes take a few bytes beside the cells.
        let mut bytes = Vec::with_capacity(renderer.framebuffer.len() + 100);
        // The terminal holds the output back until the end of the update, so that nobody sees half a
        // frame.
        if self.is_terminal {
            queue!(bytes, BeginSynchronizedUpdate)?;
        }
        bytes.extend_from_slice(if clear { b"\x1b[2J\x1b[H" } else { b"\x1b[H" });
        if let Some(color) = self.color {
            queue!(bytes, SetForegroundColor(color))?;
        }
        for row in renderer.framebuffer.chunks_exact(renderer.view.width) {
            bytes.push(b'\n'); // In place of column 0.
            bytes.extend_from_slice(&row[1..]);
        }
        bytes.push(b'\n');
        if self.color.is_some() {
            queue!(bytes, ResetColor)?;
        }
        if self.is_terminal {
            queue!(bytes, EndSynchronizedUpdate)?;
        }
        self.write(&bytes)
    }

    /// Writes all bytes, and waits while there is no room for them.
    ///
    /// A terminal whose window hangs may never take another byte. So once a signal has come, this drops the
    /// output that the terminal has not taken, and gives up on a write that has lasted longer than
    /// PATIENCE. Then there is room for what `leave` writes.
    fn write(&self, mut bytes: &[u8]) -> io::Result<()> {
        let start = Instant::now();
        while !bytes.is_empty() {
            match (&self.file).write(bytes) {
                Ok(count) => bytes = &bytes[count..],
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => {
                    if self.end_signal.load(SeqCst) != 0 {
                        self.drop_unread_output();
                        if start.elapsed() > PATIENCE {
                            return Err(error);
                        }
                    }
                    thread::sleep(Duration::from_millis(1));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// The columns and rows of the terminal, or `None` if there is none. A terminal that does not know
    /// its size reports 0, and is taken for 80x24.
    fn size(&self) -> io::Result<Option<(u16, u16)>> {
        if !self.is_terminal {
            return Ok(None);
        }
        let (columns, rows) = self.reported_size()?;
        Ok(Some(if columns > 0 && rows > 0 { (columns, rows) } else { (80, 24) }))
    }
}

#[cfg(unix)]
mod system {
    use super::*;
    use rustix::fs::{self, Mode, OFlags};
    use rustix::io::Errno;
    use rustix::process::{Signal, getpgrp, kill_current_process_group};
    use rustix::termios::{
        self, InputModes, LocalModes, OptionalActions, QueueSelector, SpecialCodeIndex, Termios,
    };
    use signal_hook::consts::{SIGCONT, SIGHUP, SIGQUIT, SIGTERM};
    use signal_hook::{flag, low_level};
    use std::io::Read;
    use std::os::fd::AsFd;
    use std::sync::OnceLock;

    /// The terminal's settings when the program first entered it. Only those of the first time are kept:
    /// after a stop, some shells leave the donut's own settings in place.
    static SETTINGS: OnceLock<Termios> = OnceLock::new();

    /// The file for the output, and whether it is a terminal.
    ///
    /// A terminal is opened once more, for keys and output, and in nonblocking mode: otherwise a terminal
    /// that takes no output, or another program that reads the same keys, would block the loop. The mode
    /// applies only to the new open file, so it makes no difference to other programs. A terminal that
    /// cannot be opened is treated as a pipe.
    pub fn open_output() -> io::Result<(File, bool)> {
        let stdout = io::stdout();
        let path = match termios::tcgetpgrp(&stdout) {
            // This is not the controlling terminal, which is the terminal that the program was started
            // from. If it is another terminal, it has a name. If it is a pipe or a file, `ttyname` fails.
            Err(Errno::NOTTY) => termios::ttyname(&stdout, Vec::new()),
            // The controlling terminal, which any user may open under this name.
            _ => Ok(c"/dev/tty".into()),
        };
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        match path.and_then(|path| fs::open(path, flags, Mode::empty())) {
            Ok(terminal) => Ok((terminal.into(), true)),
            _ => Ok((stdout.as_fd().try_clone_to_owned()?.into(), false)),
        }
    }

    /// Ends the program by this signal.
    pub fn raise(signal: i32) {
        // The first process of a container cannot end itself by a signal: the system ignores it. Then the
        // exit code has to do.
        if process::id() != 1 {
            let _ = low_level::emulate_default_handler(signal);
        }
    }

    /// Stops the program's whole job, on Ctrl-Z, until the shell's `fg` continues it. Where no shell could
    /// continue it, the system ignores this.
    ///
    /// Normally the system does this by itself, and stops all processes of the job at once: the program,
    /// and the script that has started it, if there is one. As soon as the script has stopped, the shell
    /// writes its prompt, and if the program were still on the alternate screen, the prompt would be lost
    /// there. So the program has to leave the terminal first.
    pub fn stop_job() {
        let _ = kill_current_process_group(Signal::TSTP);
    }

    impl Console {
        pub fn catch_signals(&self) -> io::Result<()> {
            for signal in [SIGTERM, SIGHUP, SIGQUIT] {
                flag::register_usize(signal, self.end_signal.clone(), signal as usize)?;
            }
            flag::register(SIGCONT, self.was_continued.clone())?;
            Ok(())
        }

        pub fn reported_size(&self) -> io::Result<(u16, u16)> {
            let size = termios::tcgetwinsize(&self.file)?;
            Ok((size.ws_col, size.ws_row))
        }

        /// Has each key sent at once, and not echoed. But Ctrl-C and Ctrl-\ stay signals, so that they
        /// work while the terminal takes no output.
        pub fn take_keys(&self) -> io::Result<()> {
            let settings = termios::tcgetattr(&self.file)?;
            let mut changed = SETTINGS.get_or_init(|| settings).clone();
            changed.local_modes -= LocalModes::ICANON | LocalModes::ECHO | LocalModes::IEXTEN;
            changed.input_modes -= InputModes::IXON;
            // No key may suspend, because Ctrl-Z has to arrive as a byte: see `stop_job`. The value that
            // means "no key" differs between systems, so the key that suspends is set to the one that
            // interrupts, Ctrl-C. The system looks for an interrupt first, so Ctrl-C still interrupts.
            let interrupt = changed.special_codes[SpecialCodeIndex::VINTR];
            changed.special_codes[SpecialCodeIndex::VSUSP] = interrupt;
            Ok(termios::tcsetattr(&self.file, OptionalActions::Now, &changed)?)
        }

        /// Gives the settings back, but not in the background, where that would stop the program.
        pub fn give_back_keys(&self) {
            if let Some(settings) = SETTINGS.get().filter(|_| self.is_in_foreground()) {
                let _ = termios::tcsetattr(&self.file, OptionalActions::Now, settings);
            }
        }

        /// The pressed keys that send a single byte.
        ///
        /// An arrow key, for one, sends a code: an ESC and more bytes. The terminal's answer to a
        /// question of an earlier program is such a code as well, and may arrive late and in pieces.
        /// So after an ESC, this function waits for PATIENCE, reads once more, and drops the ESC and
        /// all that follows it. But if nothing except ESCs has come, that is the Esc key, pressed once
        /// or held down.
        pub fn keys(&self) -> Vec<u8> {
            let mut keys = self.read();
            if let Some(escape) = keys.iter().position(|&key| key == ESCAPE) {
                let mut code = keys.split_off(escape);
                thread::sleep(PATIENCE);
                code.extend(self.read());
                if code.iter().all(|&byte| byte == ESCAPE) {
                    keys.push(ESCAPE);
                }
            }
            keys
        }

        /// Reads what the terminal has. What does not fit is read in the next round of the loop. If the
        /// terminal is gone, `size` reports it.
        fn read(&self) -> Vec<u8> {
            if !self.is_terminal {
                return Vec::new();
            }
            let mut bytes = [0; 4096];
            let count = (&self.file).read(&mut bytes).unwrap_or(0);
            bytes[..count].to_vec()
        }

        /// Makes room on a terminal that takes no output, but not in the background, where that would stop
        /// the program.
        pub fn drop_unread_output(&self) {
            if self.is_in_foreground() {
                let _ = termios::tcflush(&self.file, QueueSelector::OFlush);
            }
        }

        /// Whether the program may use the terminal.
        ///
        /// A shell lends the terminal to one of its jobs at a time. This job is in the *foreground*. A job
        /// that was started with `&`, or continued with `bg`, is in the *background*, and the system stops
        /// it if it reads keys or changes the settings.
        ///
        /// There is no answer if the terminal is not the controlling terminal, if it is gone, or if the job
        /// in the foreground is outside of the program's container. Then this function returns true.
        pub fn is_in_foreground(&self) -> bool {
            match termios::tcgetpgrp(&self.file) {
                Ok(group) => group == getpgrp(),
                Err(_) => true,
            }
        }
    }
}

/// Windows has neither jobs nor most of the signals, and each key arrives as one event, not as bytes.
#[cfg(windows)]
mod system {
    use super::*;
    use crossterm::event::{self, KeyCode};
    use std::io::IsTerminal;
    use std::os::windows::io::AsHandle;

    pub fn open_output() -> io::Result<(File, bool)> {
        crossterm::ansi_support::supports_ansi(); // Asking turns on the console's escape codes.
        let stdout = io::stdout();
        Ok((stdout.as_handle().try_clone_to_owned()?.into(), stdout.is_terminal()))
    }

    pub fn raise(_: i32) {}

    pub fn stop_job() {}

    impl Console {
        pub fn catch_signals(&self) -> io::Result<()> {
            Ok(())
        }

        pub fn reported_size(&self) -> io::Result<(u16, u16)> {
            crossterm::terminal::size()
        }

        pub fn take_keys(&self) -> io::Result<()> {
            Ok(())
        }

        pub fn give_back_keys(&self) {}

        /// The pressed keys that are a single byte.
        pub fn keys(&self) -> Vec<u8> {
            let mut keys = Vec::new();
            while self.is_terminal && event::poll(Duration::ZERO).unwrap_or(false) {
                let Ok(event) = event::read() else { break };
                let key = event.as_key_press_event().filter(|key| key.modifiers.is_empty());
                keys.extend(key.and_then(|key| match key.code {
                    KeyCode::Esc => Some(ESCAPE),
                    code => code.as_char()?.try_into().ok(),
                }));
            }
            keys
        }

        pub fn drop_unread_output(&self) {}

        pub fn is_in_foreground(&self) -> bool {
            true
        }
    }
}

#[cfg(test)]
#[path = "../tests/unit/mod.rs"]
mod tests;
