//! The moving picture of the README, made of the program's own frames.

use std::fmt::Write;
use std::process::Command;

/// Half of donut.c's turns: in twice its steps B goes round once and A twice, and it begins again.
const FRAMES: usize = 157;
const SECONDS: f64 = FRAMES as f64 / 15.0;
/// The cells in which the donut is ever seen.
const COLUMNS: std::ops::Range<usize> = 14..64;
const ROWS: usize = 22;
/// The size of a cell, in pixels.
const CELL: (f64, f64) = (9.6, 19.2);

fn frames() -> Vec<String> {
    let turn = std::f64::consts::TAU / FRAMES as f64;
    let spin = format!("--spin={},{}", 2.0 * turn, turn);
    let frames = format!("--frames={FRAMES}");
    let output =
        Command::new(env!("CARGO_BIN_EXE_donut")).args([&spin, &frames, "--fps=0"]).output();
    let stream = String::from_utf8(output.unwrap().stdout).unwrap();
    stream.split("\x1b[H").skip(1).map(String::from).collect()
}

/// A film strip: the frames below one another, drawn upwards past a window of one frame.
fn svg() -> String {
    let (width, height) = (COLUMNS.len() as f64 * CELL.0, ROWS as f64 * CELL.1);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\">\n\
         <title>A spinning donut of ASCII characters</title>\n\
         <style>\
         text{{font:16px ui-monospace,Menlo,Consolas,'DejaVu Sans Mono',monospace;fill:#e6e6e6;white-space:pre}}\
         g{{animation:film {SECONDS:.2}s steps({FRAMES}) infinite}}\
         @keyframes film{{to{{transform:translateY(-{}px)}}}}\
         </style>\n\
         <rect width=\"100%\" height=\"100%\" rx=\"8\" fill=\"#16181d\"/>\n<g>\n",
        FRAMES as f64 * height
    );
    for (n, frame) in frames().iter().enumerate() {
        for (row, line) in frame.lines().skip(1).enumerate() {
            let line = line.trim_end();
            let glyphs = line.trim_start();
            if !glyphs.is_empty() {
                let column = line.len() - glyphs.len() - COLUMNS.start;
                assert!(line.len() <= COLUMNS.end);
                let x = column as f64 * CELL.0;
                let y = n as f64 * height + (row as f64 + 0.8) * CELL.1;
                let length = glyphs.len() as f64 * CELL.0;
                writeln!(
                    svg,
                    "<text x=\"{x:.1}\" y=\"{y:.1}\" textLength=\"{length:.1}\">{glyphs}</text>"
                )
                .unwrap();
            }
        }
    }
    svg + "</g>\n</svg>\n"
}

#[test]
fn the_moving_picture_shows_the_programs_own_frames() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/donut.svg");
    let svg = svg();
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(path, &svg).unwrap();
    }
    assert!(svg.len() < 400_000, "{} bytes", svg.len());
    let stored = std::fs::read_to_string(path).unwrap();
    assert!(stored == svg, "tests/donut.svg is stale: run UPDATE=1 cargo test, and commit");
}
