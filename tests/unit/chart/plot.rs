//! The charts of tests/chart: all of one width, with labels at the curves, in the colours of a light
//! or a dark page.

use std::error::Error;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::element::DashedPathElement;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos::{self, Center, Left, Right};
use plotters::style::text_anchor::{Pos, VPos};

use super::{Row, SIZES, size};

type Result<T> = std::result::Result<T, Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plane<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

const WIDTH: u32 = 830;

const GROUND: RGBColor = RGBColor(255, 255, 255);
const BAND: RGBColor = RGBColor(240, 242, 244);
const GRID: RGBColor = RGBColor(226, 229, 233);
const INK: RGBColor = RGBColor(36, 41, 47);
const GREY: RGBColor = RGBColor(92, 100, 110);
const ORANGE: RGBColor = RGBColor(188, 76, 0);
const GREEN: RGBColor = RGBColor(17, 99, 41);
const BLUE: RGBColor = RGBColor(5, 80, 174);
const PURPLE: RGBColor = RGBColor(125, 53, 181);

/// Each colour, and the one that takes its place on a dark page.
const DARK: [(RGBColor, RGBColor); 9] = [
    (GROUND, RGBColor(13, 17, 23)),
    (BAND, RGBColor(28, 33, 40)),
    (GRID, RGBColor(43, 49, 58)),
    (INK, RGBColor(230, 237, 243)),
    (GREY, RGBColor(160, 168, 178)),
    (ORANGE, RGBColor(240, 136, 62)),
    (GREEN, RGBColor(86, 211, 100)),
    (BLUE, RGBColor(121, 192, 255)),
    (PURPLE, RGBColor(210, 168, 255)),
];

/// A chart of this height, as SVG that follows the page's colours.
fn chart(height: u32, draw: impl Fn(&Area) -> Result<()>) -> Result<String> {
    let mut svg = String::new();
    let area = SVGBackend::with_string(&mut svg, (WIDTH, height)).into_drawing_area();
    area.fill(&GROUND)?;
    draw(&area.margin(8, 8, 8, 16))?;
    area.present()?;
    drop(area);
    let hex = |RGBColor(r, g, b): RGBColor| format!("#{r:02X}{g:02X}{b:02X}");
    let dark = DARK.map(|(light, dark)| {
        let (light, dark) = (hex(light), hex(dark));
        format!("[fill=\"{light}\"]{{fill:{dark}}}[stroke=\"{light}\"]{{stroke:{dark}}}\n")
    });
    let style = format!(
        "<style>\ntext{{font-family:system-ui,-apple-system,'Segoe UI','DejaVu Sans',sans-serif}}\n\
         @media (prefers-color-scheme:dark){{\n{}}}\n</style>\n",
        dark.concat()
    );
    let head = svg.find('\n').ok_or("no line in the SVG")? + 1;
    svg.insert_str(head, &style);
    Ok(svg)
}

/// A number with its thousands apart.
fn thousands(number: f64) -> String {
    if number < 1.0 {
        return number.to_string();
    }
    let digits = format!("{number:.0}").into_bytes();
    let groups = digits.rchunks(3).rev().map(String::from_utf8_lossy);
    groups.collect::<Vec<_>>().join(",")
}

/// The powers of ten from 10^first to 10^last, and how they are written.
fn decades(first: i32, last: i32) -> Vec<(f64, String)> {
    (first..=last).map(|n| 10_f64.powi(n)).map(|power| (power, thousands(power))).collect()
}

/// Text of this height in pixels; plotters makes it smaller by a factor of 1.24.
fn font(size: i32, color: &RGBColor) -> TextStyle<'static> {
    ("sans-serif", 1.24 * f64::from(size)).into_font().color(color)
}

/// Text on an area, at pixels from its top left corner.
fn note(area: &Area, at: (i32, i32), size: i32, text: &str) -> Result<()> {
    Ok(area.draw(&Text::new(text, at, font(size, &INK)))?)
}

/// An axis: what it shows, its scale, from where to where it goes, and its marks.
struct Axis<'a> {
    title: &'a str,
    scale: fn(f64) -> f64,
    range: [f64; 2],
    marks: Vec<(f64, String)>,
}

/// Two axes, and what is drawn on them.
struct Panel<'a> {
    plane: Plane<'a>,
    scales: [fn(f64) -> f64; 2],
}

impl<'a> Panel<'a> {
    /// Axes with their titles and marks, below a caption.
    fn new(area: &Area<'a>, caption: &str, x: &Axis, y: &Axis) -> Result<Panel<'a>> {
        let [horizontal, vertical] = [x, y].map(|axis| {
            let [start, end] = axis.range.map(axis.scale);
            start..end
        });
        let plane = ChartBuilder::on(area)
            .margin_top(50)
            .margin_right(6)
            .x_label_area_size(46)
            .y_label_area_size(62)
            .build_cartesian_2d(horizontal, vertical)?
            .plotting_area()
            .clone();
        let panel = Panel { plane, scales: [x.scale, y.scale] };
        note(area, (8, 0), 15, caption)?;
        note(area, (8, 22), 13, y.title)?;
        let ([left, right], [bottom, top]) = (x.range, y.range);
        for (at, mark) in &x.marks {
            panel.line(&[(*at, bottom), (*at, top)], GRID.stroke_width(1))?;
            panel.label((*at, bottom), (0, 13), Center, mark, &GREY)?;
        }
        for (at, mark) in &y.marks {
            panel.line(&[(left, *at), (right, *at)], GRID.stroke_width(1))?;
            panel.label((left, *at), (-8, 0), Right, mark, &GREY)?;
        }
        panel.label((right, bottom), (0, 33), Right, x.title, &INK)?;
        Ok(panel)
    }

    /// Where a point is on the scaled plane.
    fn scaled(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.scales[0](x), self.scales[1](y))
    }

    /// Text with this end beside a point, in pixels from it.
    fn label(
        &self,
        at: (f64, f64),
        beside: (i32, i32),
        end: HPos,
        text: &str,
        color: &RGBColor,
    ) -> Result<()> {
        self.text(at, beside, text, font(13, color).pos(Pos::new(end, VPos::Center)))
    }

    /// Text from beside a point upwards.
    fn label_upwards(&self, at: (f64, f64), beside: (i32, i32), text: &str) -> Result<()> {
        let style = font(13, &GREY).transform(FontTransform::Rotate270);
        self.text(at, beside, text, style.pos(Pos::new(Left, VPos::Center)))
    }

    fn text(&self, at: (f64, f64), beside: (i32, i32), text: &str, style: TextStyle) -> Result<()> {
        let text = Text::new(text.to_string(), beside, style);
        Ok(self.plane.draw(&(EmptyElement::at(self.scaled(at)) + text))?)
    }

    fn line(&self, points: &[(f64, f64)], style: ShapeStyle) -> Result<()> {
        let points: Vec<_> = points.iter().map(|&point| self.scaled(point)).collect();
        Ok(self.plane.draw(&PathElement::new(points, style))?)
    }

    fn dashes(&self, ends: [(f64, f64); 2]) -> Result<()> {
        let ends = ends.map(|end| self.scaled(end));
        Ok(self.plane.draw(&DashedPathElement::new(ends, 6, 5, GREY.stroke_width(1)))?)
    }

    fn band(&self, corners: [(f64, f64); 2]) -> Result<()> {
        let corners = corners.map(|corner| self.scaled(corner));
        Ok(self.plane.draw(&Rectangle::new(corners, BAND.filled()))?)
    }

    fn circle(&self, at: (f64, f64), radius: i32, style: ShapeStyle) -> Result<()> {
        Ok(self.plane.draw(&Circle::new(self.scaled(at), radius, style))?)
    }
}

// ---- Time against wrong cells --------------------------------------------------------------------

/// How to read the first chart.
const LEGEND: [&str; 7] = [
    "Dots: medians. Bars: from the 10th to the 90th percentile.",
    "classic x1: the program's own steps at this size.",
    "x4, x2, x1/2, x1/4: steps that many times as long.",
    "Circle: the steps of donut.c, 0.07 and 0.02.",
    "sphere tracing 8 to 256: the most steps along a ray.",
    "Sphere tracing and the closed form are not in the",
    "program. They are here for comparison.",
];

/// Time against wrong cells: a large panel for donut.c's size, and a small one for each larger size.
pub fn speed_and_accuracy(rows: &[Row]) -> Result<String> {
    chart(850, |area| {
        note(area, (8, 0), 17, "What a frame costs, and how many of its cells are wrong")?;
        let (_, area) = area.split_vertically(36);
        let (large, small) = area.split_vertically(494);
        size_panel(&large, rows, 1)?;
        for (area, times) in small.split_evenly((1, 2)).iter().zip([2, 4]) {
            size_panel(area, rows, times)?;
        }
        Ok(())
    })
}

fn size_panel(area: &Area, rows: &[Row], times: usize) -> Result<()> {
    let rows: Vec<_> = rows.iter().filter(|row| row.times == times).collect();
    // What grows with the cells is at the same place in each panel.
    let range = [2.5, 12_000.0].map(|micros| micros * (times * times) as f64);
    let mut decades = decades(1, 5);
    // No number goes beyond the end of the axis.
    decades.retain(|(micros, _)| (range[0]..0.6 * range[1]).contains(micros));
    let x = Axis { title: "microseconds for a frame", scale: f64::log10, range, marks: decades };
    let shares = [0.0, 0.1, 1.0, 5.0, 10.0, 20.0, 40.0, 60.0];
    let y = Axis {
        title: "wrong cells, in per cent of the donut's",
        // On this scale 0 has its place, and small shares are still apart.
        scale: f64::cbrt,
        range: [-0.027, 90.0],
        marks: shares.map(|share| (share, format!("{share} %"))).into(),
    };
    let mut caption = size(times);
    if times == 1 {
        caption += ", donut.c's own size";
    }
    let panel = Panel::new(area, &caption, &x, &y)?;
    panel.band([(range[0], -0.027), (range[1], 0.004)])?;
    panel.label((range[1], 0.0), (-8, 2), Right, "no wrong cell", &INK)?;
    if times == 1 {
        legend(area)?;
    }
    others(&panel, &rows, times == 1)?;
    own(&panel, &rows)
}

fn legend(area: &Area) -> Result<()> {
    area.draw(&Rectangle::new([(390, 176), (800, 334)], GROUND.filled()))?;
    for (line, text) in (0..).zip(LEGEND) {
        note(area, (398, 184 + 21 * line), 13, text)?;
    }
    Ok(())
}

/// Medians, and behind them bars from the 10th to the 90th percentile.
fn curve(panel: &Panel, rows: &[&Row], color: &RGBColor) -> Result<()> {
    let points: Vec<_> = rows.iter().map(|row| point(row)).collect();
    panel.line(&points, color.stroke_width(2))?;
    for row in rows {
        let [low, high] = ends(row);
        panel.line(&[low, high], color.mix(0.3).stroke_width(9))?;
        panel.circle(point(row), 4, color.filled())?;
    }
    Ok(())
}

fn point(row: &Row) -> (f64, f64) {
    (row.micros[0], row.wrong_share())
}

/// The ends of the bar.
fn ends(row: &Row) -> [(f64, f64); 2] {
    [1, 2].map(|n| (row.micros[n], row.wrong_share()))
}

/// The rows whose names start so, from the fastest.
fn named<'a>(rows: &[&'a Row], start: &str) -> Vec<&'a Row> {
    let mut named = rows.to_vec();
    named.retain(|row| row.name.starts_with(start));
    named.sort_by(|a, b| a.micros[0].total_cmp(&b.micros[0]));
    named
}

fn others(panel: &Panel, rows: &[&Row], large: bool) -> Result<()> {
    let written = named(rows, "donut.c as written");
    curve(panel, &written, &INK)?;
    let text = if large { "donut.c as written" } else { "donut.c" };
    // Away from the curve of classic.
    let above = written[0].wrong_share() > named(rows, "classic x1")[0].wrong_share();
    let beside = (0, if above { -17 } else { 17 });
    panel.label(point(written[0]), beside, Center, text, &INK)?;

    let tracing = named(rows, "sphere tracing ");
    curve(panel, &tracing, &BLUE)?;
    for row in &tracing {
        panel.label(ends(row)[0], (-7, 0), Right, &row.name[15..], &BLUE)?;
    }
    let (at, beside, end) = match large {
        true => (ends(tracing[0])[0], (-22, 0), Right),
        false => (ends(tracing[1])[1], (8, 0), Left),
    };
    panel.label(at, beside, end, "sphere tracing", &BLUE)?;

    let closed = named(rows, "closed form ");
    curve(panel, &closed, &PURPLE)?;
    let text = if large { "closed form, f32 and f64" } else { "closed form" };
    panel.label(ends(closed[1])[1], (8, 2), Left, text, &PURPLE)
}

fn own(panel: &Panel, rows: &[&Row]) -> Result<()> {
    let classic = named(rows, "classic ");
    curve(panel, &classic, &ORANGE)?;
    for row in &classic {
        panel.label(point(row), (0, -16), Center, &row.name[8..], &ORANGE)?;
    }
    panel.label(ends(classic[4])[1], (8, 0), Left, "classic", &ORANGE)?;
    let fixed = named(rows, "fixed");
    panel.circle(point(fixed[0]), 8, ORANGE.stroke_width(2))?;

    let exact = named(rows, "exact");
    curve(panel, &exact, &GREEN)?;
    panel.label(ends(exact[0])[0], (-8, 2), Right, "exact", &GREEN)
}

// ---- Time against cells --------------------------------------------------------------------------

/// Time against cells, and how much more time four times the cells take.
pub fn growth(rows: &[Row]) -> Result<String> {
    chart(420, |area| {
        let [classic, exact] = ["classic x1", "exact"].map(|name| {
            let rows = rows.iter().filter(|row| row.name == name);
            rows.map(|row| (row.cells() as f64, row.micros[0])).collect::<Vec<_>>()
        });
        let x = Axis {
            title: "size of the picture",
            scale: f64::log10,
            range: [1.2e3, 7.5e5],
            marks: classic.iter().map(|point| point.0).zip(SIZES.map(size)).collect(),
        };
        let y = Axis {
            title: "microseconds for a frame",
            scale: f64::log10,
            range: [7.0, 1e5],
            marks: decades(1, 5),
        };
        let panel = Panel::new(area, "The time of a frame grows with its cells", &x, &y)?;
        for (name, points, color, end, beside) in [
            ("classic", &classic, ORANGE, Right, (-10, -14)),
            ("exact", &exact, GREEN, Left, (12, 14)),
        ] {
            panel.line(points, color.stroke_width(2))?;
            for &point in points {
                panel.circle(point, 4, color.filled())?;
            }
            let factor = 4_f64.powf(slope(points));
            let text = format!("{name}: four times the cells take {factor:.1} times as long");
            panel.label(points[2], beside, end, &text, &color)?;
        }
        Ok(())
    })
}

/// The slope of the line through the points' logarithms that has the least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<_> = points.iter().map(|(x, y)| (x.ln(), y.ln())).collect();
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(&|log| log.0), mean(&|log| log.1));
    mean(&|log| (log.0 - x) * (log.1 - y)) / mean(&|log| (log.0 - x) * (log.0 - x))
}

// ---- donut.c's clock -----------------------------------------------------------------------------

/// The largest error of donut.c's running angle up to each frame.
pub fn clock(errors: &[(u32, f64)]) -> Result<String> {
    chart(420, |area| {
        let x = Axis { title: "frame", scale: f64::log10, range: [1e3, 5e7], marks: decades(3, 7) };
        let y = Axis {
            title: "the largest error of the angle A so far, in radians",
            scale: f64::log10,
            range: [1e-4, 2e6],
            marks: decades(-3, 5).into_iter().step_by(2).collect(),
        };
        let caption = "donut.c's clock: it adds 0.04 to a float each frame, and rounds";
        let panel = Panel::new(area, caption, &x, &y)?;
        for (frame, text) in [(3_345_245.0, "17 % fast"), (22_918_663.0, "stands still")] {
            panel.dashes([(frame, 1e-4), (frame, 2e6)])?;
            let text = format!("{text} from {}", thousands(frame));
            panel.label_upwards((frame, 1e-4), (-11, -8), &text)?;
        }
        let turn = std::f64::consts::TAU;
        panel.dashes([(1e3, turn), (1.2e6, turn)])?;
        panel.label((1e3, turn), (8, -12), Left, "a whole turn", &GREY)?;
        let points: Vec<_> = errors.iter().map(|&(n, error)| (f64::from(n), error)).collect();
        panel.line(&points, ORANGE.stroke_width(2))
    })
}
