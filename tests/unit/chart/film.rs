//! The film at the top of the README: a window that grows, and what the program draws in it.

use super::picture::{CELL, part, pixels, svg};
use super::*;
use std::fmt::Write;

const FRAMES: usize = 157;
/// The program's own, unless --fps says otherwise.
const FRAMES_PER_SECOND: f64 = 30.0;
/// Columns and rows of the window: at first, and when it is largest.
const SMALL: (usize, usize) = (80, 24);
const LARGE: (usize, usize) = (120, 36);
/// The frames in which the window begins and ends to grow, and begins to shrink. It shrinks until the
/// end.
const GROWS: (usize, usize) = (50, 74);
const SHRINKS: usize = 133;
/// The frame that is shown where nothing may move.
const STILL: usize = 84;
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
/// high as one frame. A goes round once, and B half. In the first frame, and in the one that would come
/// after the last, the viewer looks along the donut's axis, so these two look the same: the film has no
/// end.
pub fn film() -> String {
    let (width, height) = (pixels(LARGE.0, 0).0 + 2 * MARGIN, pixels(0, LARGE.1).1 + BAR + MARGIN);
    let (mut strip, mut windows) = (String::new(), String::new());
    for n in 0..FRAMES {
        let (columns, rows) = window(n);
        let is_small = (columns, rows) == SMALL;
        // The left and the top end of the window, and of its cells.
        let left = pixels(LARGE.0 - columns, 0).0 / 2;
        let top = pixels(0, LARGE.1 - rows).1 / 2;
        let at = (left + MARGIN, top + BAR);
        let id = format!("w{columns}x{rows}");
        if !windows.contains(&format!("\"{id}\"")) {
            let (w, h) = (width - 2 * left, height - 2 * top);
            writeln!(
                windows,
                "<g id=\"{id}\"><rect x=\"{left}\" y=\"{top}\" width=\"{w}\" height=\"{h}\" rx=\"12\"/>\
                 <path d=\"M{} {}h0m22 0h0m22 0h0\"/><text class=\"size\" x=\"{}\" y=\"{}\">\
                 {columns} x {rows}</text></g>",
                left + 26,
                top + 22,
                left + w / 2,
                top + 29
            )
            .unwrap();
        }
        let [a, b] = [2.0, 1.0].map(|half_turns| half_turns * PI * n as f64 / FRAMES as f64);
        // In other windows than one of 80x24, the program leaves only the last row to the cursor.
        let (view, method) = if is_small {
            (View::DONUT_C, Method::Classic)
        } else {
            (fitted(columns, rows - 1), Method::Exact)
        };
        let picture = draw(method, view, a, b);
        // donut.c's picture begins in the second row of the window, and all others in the first.
        let y = n * height + at.1 + if is_small { CELL.1 } else { 0 };
        writeln!(strip, "<use href=\"#{id}\" y=\"{}\"/>", n * height).unwrap();
        let cells = (1..view.width, if is_small { 0 } else { 1 }..view.height);
        strip += &part((&picture, view.width), cells, (at.0, y), |_| "");
    }
    let style = format!(
        "text{{font:16.6px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;fill:#ff8800;\
         white-space:pre}}rect{{fill:#16181d;stroke:#444c56;stroke-width:2}}\
         path{{stroke:#5c646e;stroke-width:13;stroke-linecap:round}}\
         text.size{{font-size:24px;text-anchor:middle;fill:#a0a8b2}}\
         @media(prefers-reduced-motion:no-preference){{\
         #film{{animation:film {:.2}s steps({FRAMES}) infinite}}\
         @keyframes film{{from{{transform:none}}to{{transform:translateY(-{}px)}}}}}}",
        FRAMES as f64 / FRAMES_PER_SECOND,
        FRAMES * height
    );
    let still = format!("transform=\"translate(0 -{})\"", STILL * height);
    let contents = format!("<defs>\n{windows}</defs>\n<g id=\"film\" {still}>\n{strip}</g>\n");
    let title = "A donut of ASCII characters spins in a window, which grows, and the donut with it";
    svg(title, (width, height), 1.0, &style, &contents)
}
