//! The film at the top of the README: a window that shrinks and grows, keys that are pressed, and what the
//! program draws.

use super::picture::{BASELINE, CELL, pixels, svg};
use super::*;

const COMMAND: &str = "donut --color 208";
/// Half as many as the program shows in a second, so that a browser has less to do, and the file is smaller.
const FRAMES_PER_SECOND: usize = 15;
const FRAMES: usize = 185;
/// The keys that are pressed, the frame of the first one, and the frames from one to the next. An arrow key is
/// held down: it is pressed again in each of some frames.
const PRESSED: [&str; 12] = [" ", "←", "→", "↑", "↓", " ", "c", "c", "c", "+", "+", "+"];
const FIRST: usize = 45;
const NEXT: usize = 11;
const HELD: usize = 9;
/// All keys that are shown, and where.
const KEYS: [(&str, usize); 7] =
    [(" ", 122), ("←", 302), ("↑", 362), ("↓", 362), ("→", 422), ("c", 516), ("+", 576)];
/// The window when it is largest, at the start and at the end, and smallest, above the keys.
const LARGE: Window = Window { columns: 72, rows: 28, aspect: View::ASPECT };
const SMALL: Window = Window { columns: 56, rows: 20, aspect: View::ASPECT };
/// The frame in which the window begins to shrink, and how many frames it takes to shrink, and to grow.
const SHRINKS: usize = 20;
const RESIZING: usize = 10;
/// The frame that is shown where nothing may move, and in which the film stops after so many rounds.
const STILL: usize = 43;
const ROUNDS: usize = 9;
/// What is around the cells: the bar of the window, and the margin on the other sides.
const BAR: usize = 44;
const MARGIN: usize = 16;
const WIDTH: usize = LARGE.columns as usize * CELL.0 + 2 * MARGIN;
const HEIGHT: usize = BAR + LARGE.rows as usize * CELL.1 + MARGIN;
/// From one frame of the strip to the next. No line of the next one must be seen.
const STEP: usize = HEIGHT + 20;

/// The window in frame n.
fn window(n: usize) -> Window {
    let part = |start| ((n as f64 - start as f64) / RESIZING as f64).clamp(0.0, 1.0);
    let slow_at_ends = |part: f64| part * part * (3.0 - 2.0 * part);
    let small = slow_at_ends(part(SHRINKS)) - slow_at_ends(part(FRAMES - RESIZING));
    let size = |large, small_size| large - (f64::from(large - small_size) * small).round() as u16;
    let (columns, rows) = (size(LARGE.columns, SMALL.columns), size(LARGE.rows, SMALL.rows));
    Window { columns, rows, ..LARGE }
}

fn frame_of(Window { columns, rows, .. }: Window) -> String {
    let (width, height) = pixels(columns.into(), rows.into());
    let left = (WIDTH - width) / 2 - MARGIN;
    format!(
        "<rect x=\"{}\" y=\"1\" width=\"{}\" height=\"{}\" rx=\"12\"/>\
         <path d=\"M{} 22h0m22 0h0m22 0h0\"/><text class=\"bar\" x=\"{}\" y=\"31\">{COMMAND}</text>\
         <text class=\"size\" x=\"{}\" y=\"31\">{columns}x{rows}</text>",
        left + 1,
        width + 2 * MARGIN - 2,
        BAR + height + MARGIN - 2,
        left + 24,
        left + 94,
        WIDTH - left - 20,
    )
}

/// Each row is centred. Its glyphs are not stretched to the cells, because that costs a browser much time.
fn glyphs(Renderer { view, framebuffer, .. }: &Renderer) -> String {
    let row = |(row, glyphs): (usize, &[u8])| {
        let [left, right] = [glyphs.trim_ascii_start(), glyphs.trim_ascii_end()].map(<[u8]>::len);
        let (x, y) = ((WIDTH + CELL.0 * right - CELL.0 * left) / 2, BAR + row * CELL.1 + BASELINE);
        let glyphs = str::from_utf8(glyphs.trim_ascii()).unwrap();
        (left > 0).then(|| format!("<text x=\"{x}\" y=\"{y}\">{glyphs}</text>"))
    };
    framebuffer.chunks(view.width).enumerate().filter_map(row).collect()
}

fn keys(pressed: &str) -> String {
    let key = |(name, x)| {
        let y = if name == "↑" { 486 } else { 542 };
        let (label, width) = if name == " " { ("space", 140) } else { (name, 54) };
        let class = if name == pressed { "key pressed" } else { "key" };
        format!(
            "<g class=\"{class}\"><rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"50\" rx=\"9\"/>\
             <text x=\"{}\" y=\"{}\">{label}</text></g>",
            x + width / 2,
            y + 33
        )
    };
    KEYS.map(key).concat()
}

/// All frames are in one strip, one below another, and the strip moves behind an opening that is as high as one
/// frame. In the first frame, and in the one that would come after the last, the viewer looks along the donut's
/// axis, so these two look the same.
pub fn film() -> String {
    let options = Options::try_parse_from(COMMAND.split(' ')).unwrap();
    let mut show = Show::new(&options);
    let (mut parts, mut strip) = (Vec::new(), String::new());
    for n in 0..FRAMES {
        let pressed = n.checked_sub(FIRST).and_then(|n| Some((*PRESSED.get(n / NEXT)?, n % NEXT)));
        let (key, since) = pressed.unwrap_or_default();
        let is_held = "←→↑↓".contains(key);
        if since < if is_held { HELD } else { 1 } {
            key.chars().for_each(|key| show.obey(key));
        }
        show.fit(Some(window(n)));
        show.renderer.render_frame(show.angles[0], show.angles[1]);
        let mut frame = vec![frame_of(window(n)), glyphs(&show.renderer)];
        if window(n) == SMALL {
            let is_down = since < if is_held { HELD } else { 3 };
            frame.push(keys(if is_down { key } else { "" }));
        }
        let color = show.color.map_or(String::new(), |color| format!("c{color}"));
        strip += &format!("<g class=\"{color}\" transform=\"translate(0 {})\">", n * STEP);
        for part in frame {
            let id = parts.iter().position(|other| *other == part).unwrap_or(parts.len());
            strip += &format!("<use href=\"#{id}\"/>");
            if id == parts.len() {
                parts.push(part);
            }
        }
        strip += "</g>\n";
        for _ in 0..if show.is_paused { 0 } else { 30 / FRAMES_PER_SECOND } {
            show.advance();
        }
    }
    assert!(show.angles[0].sin().abs() < 0.04, "the last frame leads to the first");
    let style = format!(
        "text{{font:16.6px Menlo,'DejaVu Sans Mono','Lucida Console','Liberation Mono','Courier New',monospace;\
         text-anchor:middle;white-space:pre}}rect{{fill:#16181d;stroke:#444c56;stroke-width:2}}\
         path{{stroke:#5c646e;stroke-width:13;stroke-linecap:round}}\
         #film{{fill:#ff8700}}.c9{{fill:#ff6b6b}}.c10{{fill:#5fd75f}}.c11{{fill:#ffe14d}}\
         .bar,.size,.key text{{font-size:23px;fill:#d0d7de}}.bar{{text-anchor:start}}.size{{text-anchor:end}}\
         .key rect{{fill:#2b3038;stroke:#6b7480}}.pressed rect{{fill:#ff8700}}.key.pressed text{{fill:#16181d}}\
         #film{{transform:translateY(-{still}px)}}@media(prefers-reduced-motion:no-preference){{#film{{\
         animation:film {seconds:.2}s steps({FRAMES}) {rounds:.4}}}\
         @keyframes film{{from{{transform:none}}to{{transform:translateY(-{end}px)}}}}}}",
        still = STILL * STEP,
        end = FRAMES * STEP,
        seconds = FRAMES as f64 / FRAMES_PER_SECOND as f64,
        rounds = ROUNDS as f64 + STILL as f64 / FRAMES as f64,
    );
    let parts: String =
        (0..).zip(parts).map(|(id, part)| format!("<g id=\"{id}\">{part}</g>\n")).collect();
    let contents = format!("<defs>\n{parts}</defs>\n<g id=\"film\">\n{strip}</g>\n");
    let title = "A donut spins in a terminal window, and keys turn it, change its colour and make it faster";
    svg(title, (WIDTH, HEIGHT), 0.85, &style, &contents)
}
