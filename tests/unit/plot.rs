//! The charts of tests/chart: each on a light ground of its own, with its labels at the curves.

use std::error::Error;
use std::ops::Range;

use plotters::coord::Shift;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos::{self, Center, Left, Right};
use plotters::style::text_anchor::{Pos, VPos};

use super::chart::{Row, size};

type Result<T> = std::result::Result<T, Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Panel<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<LogCoord<f64>, LogCoord<f64>>>;

const GROUND: RGBColor = RGBColor(252, 251, 248);
const GRID: RGBColor = RGBColor(226, 223, 215);
const INK: RGBColor = RGBColor(45, 45, 45);
const GREY: RGBColor = RGBColor(110, 110, 110);
const ORANGE: RGBColor = RGBColor(190, 80, 20);
const GREEN: RGBColor = RGBColor(0, 110, 75);
const BLUE: RGBColor = RGBColor(35, 90, 170);
const PURPLE: RGBColor = RGBColor(125, 60, 150);

/// Where no cell is wrong, in per cent: below the least share that can be.
const FLOOR: f64 = 1e-4;

/// A number with its thousands apart.
fn thousands(number: f64) -> String {
    if number < 1.0 {
        return number.to_string();
    }
    let digits = format!("{number:.0}").into_bytes();
    let groups = digits.rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join(",")
}

fn font(size: i32, color: &RGBColor) -> TextStyle<'static> {
    ("sans-serif", size).into_font().color(color)
}

/// A canvas with its title, and what is left below.
fn canvas<'a>(path: &'a str, size: (u32, u32), title: &str) -> Result<Area<'a>> {
    let area = SVGBackend::new(path, size).into_drawing_area();
    area.fill(&GROUND)?;
    Ok(area.margin(6, 6, 6, 12).titled(title, font(21, &INK))?)
}

/// Log-log axes below a caption, with their titles, and how to write the numbers of the second.
fn panel<'a>(
    area: &Area<'a>,
    caption: &str,
    [x, y]: [Range<f64>; 2],
    [x_title, y_title]: [&str; 2],
    y_label: &dyn Fn(&f64) -> String,
) -> Result<Panel<'a>> {
    let decades = |range: &Range<f64>| (range.end / range.start).log10() as usize + 1;
    let [x_labels, y_labels] = [&x, &y].map(decades);
    let mut panel = ChartBuilder::on(area)
        .caption(caption, font(19, &INK))
        .x_label_area_size(46)
        .y_label_area_size(76)
        .build_cartesian_2d(x.log_scale(), y.log_scale())?;
    panel
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(GRID)
        .axis_style(GREY)
        .label_style(font(16, &INK))
        .axis_desc_style(font(17, &INK))
        .x_labels(x_labels)
        .y_labels(y_labels)
        .x_label_formatter(&|&x| thousands(x))
        .y_label_formatter(y_label)
        .x_desc(x_title)
        .y_desc(y_title)
        .draw()?;
    Ok(panel)
}

/// Text with this end beside a point, in pixels from it.
fn label(
    panel: &Panel,
    at: (f64, f64),
    beside: (i32, i32),
    end: HPos,
    text: &str,
    color: &RGBColor,
) -> Result<()> {
    let style = font(16, color).pos(Pos::new(end, VPos::Center));
    let text = Text::new(text.to_string(), beside, style);
    Ok(panel.plotting_area().draw(&(EmptyElement::at(at) + text))?)
}

fn line(panel: &Panel, points: Vec<(f64, f64)>, color: &RGBColor) -> Result<()> {
    let line = PathElement::new(points, color.stroke_width(2));
    Ok(panel.plotting_area().draw(&line)?)
}

fn dashes(panel: &Panel, from: (f64, f64), to: (f64, f64)) -> Result<()> {
    let dashes = DashedPathElement::new([from, to], 6, 5, GREY.stroke_width(1));
    Ok(panel.plotting_area().draw(&dashes)?)
}

/// Text from a point upwards, `beside` pixels to the right.
fn label_upwards(panel: &Panel, at: (f64, f64), beside: i32, text: &str) -> Result<()> {
    let style = font(16, &GREY).transform(FontTransform::Rotate270);
    let style = style.pos(Pos::new(Left, VPos::Center));
    let text = Text::new(text.to_string(), (beside, 0), style);
    Ok(panel.plotting_area().draw(&(EmptyElement::at(at) + text))?)
}

fn dot(panel: &Panel, at: (f64, f64), color: &RGBColor) -> Result<()> {
    let dot = Circle::new(at, 4, color.filled());
    Ok(panel.plotting_area().draw(&dot)?)
}

/// Medians, and behind them bars from the 10th to the 90th percentile.
fn curve(panel: &Panel, rows: &[&Row], color: &RGBColor) -> Result<()> {
    line(panel, rows.iter().map(|row| point(row)).collect(), color)?;
    for row in rows {
        let [low, _, high] = row.micros.map(|micros| (micros, share(row)));
        let bar = PathElement::new([low, high], color.mix(0.3).stroke_width(9));
        panel.plotting_area().draw(&bar)?;
        dot(panel, point(row), color)?;
    }
    Ok(())
}

/// Time against wrong cells, a panel for each size.
pub fn speed_and_accuracy(path: &str, rows: &[Row]) -> Result<()> {
    let title = "Time of a frame, and how many of the donut's cells are wrong in it";
    let area = canvas(path, (1080, 580), title)?;
    for (area, times) in area.split_evenly((1, 3)).iter().zip([1, 2, 4]) {
        let rows: Vec<_> = rows.iter().filter(|row| row.times == times).collect();
        // What grows with the cells is at the same place in each panel.
        let scale = (times * times) as f64;
        let y_title = ["wrong cells, % of the donut's", ""][usize::from(times > 1)];
        let panel = panel(
            area,
            &size(times),
            [6.0 * scale..4000.0 * scale, FLOOR / 3.0..300.0],
            ["microseconds a frame", y_title],
            &|&y| match y < 2.0 * FLOOR {
                true => "0 wrong".into(),
                false => format!("{y} %"),
            },
        )?;
        let corners = [(6.0 * scale, FLOOR / 3.0), (4000.0 * scale, FLOOR * 3.0)];
        let floor = Rectangle::new(corners, GRID.mix(0.5).filled());
        panel.plotting_area().draw(&floor)?;
        rivals(&panel, &rows)?;
        own(&panel, &rows)?;
    }
    Ok(area.present()?)
}

fn share(row: &Row) -> f64 {
    row.wrong_share().max(FLOOR)
}

fn point(row: &Row) -> (f64, f64) {
    (row.micros[1], share(row))
}

/// The rows whose names start so, from the fastest.
fn named<'a>(rows: &[&'a Row], start: &str) -> Vec<&'a Row> {
    let mut named = rows.to_vec();
    named.retain(|row| row.name.starts_with(start));
    named.sort_by(|a, b| a.micros[1].total_cmp(&b.micros[1]));
    named
}

fn rivals(panel: &Panel, rows: &[&Row]) -> Result<()> {
    let written = named(rows, "donut.c")[0];
    let time = written.micros[1];
    dashes(panel, (time, 5.0), (time, 10.0 * FLOOR))?;
    label_upwards(panel, (time, 12.0 * FLOOR), 10, &written.name)?;

    let tracing = named(rows, "sphere tracing ");
    curve(panel, &tracing, &BLUE)?;
    for row in &tracing {
        let (at, steps) = ((row.micros[0], share(row)), &row.name[15..]);
        label(panel, at, (-6, 0), Right, steps, &BLUE)?;
    }
    let last = point(tracing[4]);
    label(panel, last, (16, 19), Right, "steps of", &BLUE)?;
    label(panel, last, (16, 34), Right, "sphere tracing", &BLUE)?;

    let closed = named(rows, "closed form ");
    curve(panel, &closed, &PURPLE)?;
    let (at, text) = ((closed[1].micros[2], FLOOR), "closed form, f32 and f64");
    label(panel, at, (8, 0), Left, text, &PURPLE)
}

fn own(panel: &Panel, rows: &[&Row]) -> Result<()> {
    let classic = named(rows, "classic ");
    curve(panel, &classic, &ORANGE)?;
    for row in &classic {
        let (at, times) = (point(row), &row.name[8..]);
        label(panel, at, (0, -15), Center, times, &ORANGE)?;
    }
    let (last, text) = (point(classic[4]), "classic, its steps");
    label(panel, last, (16, 20), Right, text, &ORANGE)?;

    let fixed = named(rows, "fixed")[0];
    let ring = Circle::new(point(fixed), 8, ORANGE.stroke_width(2));
    panel.plotting_area().draw(&ring)?;
    let (at, text) = (point(fixed), &fixed.name);
    label(panel, at, (-11, -33), Left, text, &ORANGE)?;

    let exact = named(rows, "exact");
    curve(panel, &exact, &GREEN)?;
    label(panel, point(exact[0]), (0, -18), Center, "exact", &GREEN)
}

/// Time against cells, and the slope of each line.
pub fn growth(path: &str, rows: &[Row]) -> Result<()> {
    let title = "Time of a frame, by the cells of the picture";
    let area = canvas(path, (760, 440), title)?;
    let panel = panel(
        &area,
        "80x22, 160x44, 320x88, 640x176, 1280x352",
        [1e3..7e5, 10.0..1e5],
        ["cells", "microseconds a frame"],
        &|&y| thousands(y),
    )?;
    for (name, color, end, beside) in
        [("classic", ORANGE, Right, (-10, -10)), ("exact", GREEN, Left, (8, 14))]
    {
        let rows = rows.iter().filter(|row| row.name.starts_with(name));
        let points = rows.map(|row| (row.cells() as f64, row.micros[1]));
        let points: Vec<_> = points.collect();
        line(&panel, points.clone(), &color)?;
        for &point in &points {
            dot(&panel, point, &color)?;
        }
        let text = format!("{name}: slope {:.2}", slope(&points));
        println!("growth of {text}");
        label(&panel, points[2], beside, end, &text, &color)?;
    }
    Ok(area.present()?)
}

/// The slope of the line through the points' logarithms that has the least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<_> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(&|log| log.0), mean(&|log| log.1));
    mean(&|log| (log.0 - x) * (log.1 - y)) / mean(&|log| (log.0 - x) * (log.0 - x))
}

/// The error of donut.c's running angle, frame after frame.
pub fn clock(path: &str, errors: &[(u32, f64)]) -> Result<()> {
    let area = canvas(path, (760, 440), "How wrong donut.c's clock is")?;
    let panel = panel(
        &area,
        "its running angle A against 0.04 n",
        [1e3..3e7, 1e-4..1e6],
        ["frame n", "error of A, radians"],
        &|&y| thousands(y),
    )?;
    for (frame, text) in [(3_345_245.0, "17 % fast"), (22_918_663.0, "frozen")] {
        dashes(&panel, (frame, 1e-4), (frame, 1e6))?;
        let text = format!("{text} from frame {}", thousands(frame));
        label_upwards(&panel, (frame, 1.5e-4), -10, &text)?;
    }
    let turn = std::f64::consts::TAU;
    dashes(&panel, (1e3, turn), (2e6, turn))?;
    let text = "a whole turn";
    label(&panel, (1e3, turn), (8, -11), Left, text, &GREY)?;
    let points = errors.iter().map(|&(n, error)| (f64::from(n), error));
    line(&panel, points.collect(), &ORANGE)?;
    Ok(area.present()?)
}
