//! The film at the top of the README: a command, a window that grows, and what the program draws in it.

use super::picture::{CELL, part, pixels, svg};
use super::*;

/// The frames of a round, and how many are shown in a second. That is half as many as the program shows, so
/// that a browser has less to do, and the file is smaller.
const FRAMES: usize = 79;
const FRAMES_PER_SECOND: f64 = 15.0;
/// What is typed first, a key for each step. There are more steps, to wait in before and after it.
const TYPED: &str = "donut --color 208";
const STEPS: usize = TYPED.len() + 10;
const STEPS_PER_SECOND: f64 = 12.0;
/// Columns and rows of the window: at first, and when it is largest.
const SMALL: (usize, usize) = (80, 24);
const LARGE: (usize, usize) = (120, 36);
/// The frames in which the window begins and ends to grow, and begins to shrink. It shrinks until the
/// end.
const GROWS: (usize, usize) = (25, 37);
const SHRINKS: usize = 66;
/// The frame that is shown where nothing may move, and in which the film stops in its third round.
const STILL: usize = 42;
/// What is around the cells: the bar of the window, and the margin on the other sides.
const BAR: usize = 40;
const MARGIN: usize = 16;

/// The columns and the rows of the window in frame n.
fn window(n: usize) -> (usize, usize) {
    let part = |(start, end): (usize, usize)| {
        ((n as f64 - start as f64) / (end - start) as f64).clamp(0.0, 1.0)
    };
    let slow_at_ends = |part: f64| part * part * (3.0 - 2.0 * part);
    let large = slow_at_ends(part(GROWS)) - slow_at_ends(part((SHRINKS, FRAMES)));
    let size = |small, large_size| small + ((large_size - small) as f64 * large).round() as usize;
    (size(SMALL.0, LARGE.0), size(SMALL.1, LARGE.1))
}

/// All frames are in one strip, one below another, and the strip moves up behind an opening that is as
/// high as one frame: first once through the frames of the command, then through those of the donut. A goes
/// round once, and B half. In the first frame of the donut, and in the one that would come after the last,
/// the viewer looks along the donut's axis, so these two look the same.
pub fn film() -> String {
    let (width, height) = (pixels(LARGE.0, 0).0 + 2 * MARGIN, pixels(0, LARGE.1).1 + BAR + MARGIN);
    let (mut strip, mut windows) = (String::new(), Vec::new());
    for n in 0..STEPS + FRAMES {
        let frame = n.checked_sub(STEPS);
        let (columns, rows) = window(frame.unwrap_or(0));
        let is_small = (columns, rows) == SMALL;
        // The left and the top end of the window, and of its cells.
        let left = pixels(LARGE.0 - columns, 0).0 / 2;
        let top = pixels(0, LARGE.1 - rows).1 / 2;
        let (x, y) = (left + MARGIN, n * height + top + BAR);
        let method_name = frame.map_or("", |_| if is_small { ": classic" } else { ": exact" });
        let window = format!(
            "<rect x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\" rx=\"12\"/>\
             <path d=\"M{} {}h0m22 0h0m22 0h0\"/>\
             <text class=\"bar\" x=\"{}\" y=\"{}\">{columns} x {rows}{method_name}</text>",
            width - 2 * left,
            height - 2 * top,
            left + 26,
            top + 22,
            width / 2,
            top + 30,
        );
        let id = windows.iter().position(|other| *other == window).unwrap_or(windows.len());
        if id == windows.len() {
            windows.push(window);
        }
        strip += &format!("<use href=\"#w{id}\" y=\"{}\"/>\n", n * height);
        let Some(frame) = frame else {
            let typed = &TYPED[..n.saturating_sub(4).min(TYPED.len())];
            strip +=
                &format!("<text class=\"typed\" x=\"{x}\" y=\"{}\">$ {typed}_</text>\n", y + 36);
            continue;
        };
        let [a, b] = [2.0, 1.0].map(|half_turns| half_turns * PI * frame as f64 / FRAMES as f64);
        // At 80x24, donut.c's picture begins in the third row. In other windows, the program leaves only the
        // last row, to the cursor.
        let (view, method, down) = if is_small {
            (View::DONUT_C, Method::Classic, 2 * CELL.1)
        } else {
            (fitted(columns, rows - 1), Method::Exact, 0)
        };
        let picture = draw(method, view, a, b);
        let cells = (0..view.width, 0..view.height);
        strip += &part((&picture, view.width), cells, (x, y + down), |_| "");
    }
    let [begin, end] = [STEPS, STEPS + FRAMES].map(|n| format!("translateY(-{}px)", n * height));
    let style = format!(
        "text{{font:16.6px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;fill:#ff8700;\
         white-space:pre}}rect{{fill:#16181d;stroke:#444c56;stroke-width:2}}\
         path{{stroke:#5c646e;stroke-width:13;stroke-linecap:round}}\
         text.bar{{font-size:28px;text-anchor:middle;fill:#a0a8b2}}text.typed{{font-size:33px;fill:#e6e6e6}}\
         @media(prefers-reduced-motion:no-preference){{#film{{\
         animation:typed {typed:.2}s steps({STEPS}),film {round:.2}s {typed:.2}s steps({FRAMES}) {rounds:.4}}}\
         @keyframes typed{{from{{transform:none}}to{{transform:{begin}}}}}\
         @keyframes film{{from{{transform:{begin}}}to{{transform:{end}}}}}}}",
        typed = STEPS as f64 / STEPS_PER_SECOND,
        round = FRAMES as f64 / FRAMES_PER_SECOND,
        rounds = 2.0 + STILL as f64 / FRAMES as f64,
    );
    let still = format!("transform=\"translate(0 -{})\"", (STEPS + STILL) * height);
    let windows: String =
        (0..).zip(windows).map(|(id, w)| format!("<g id=\"w{id}\">{w}</g>\n")).collect();
    let contents = format!("<defs>\n{windows}</defs>\n<g id=\"film\" {still}>\n{strip}</g>\n");
    let title = "A donut of ASCII characters spins in a window, which grows, and the donut with it";
    svg(title, (width, height), 1.0, &style, &contents)
}
