//! The drawing of the two charts in tests/chart. Their titles say what they show, and their curves
//! have labels instead of a key. Their colours follow the page, which may be light or dark. They can be
//! read even on a phone, where they are 390 pixels wide.

use std::error::Error;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;
use plotters::style::text_anchor::HPos::{self, Center, Left, Right};
use plotters::style::text_anchor::{Pos, VPos};

type Result<T> = std::result::Result<T, Box<dyn Error>>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Plane<'a> = DrawingArea<SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

const WIDTH: u32 = 520;

const GROUND: RGBColor = RGBColor(255, 255, 255);
const FAINT: RGBColor = RGBColor(226, 164, 120);
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
    (FAINT, RGBColor(122, 76, 42)),
    (GRID, RGBColor(43, 49, 58)),
    (INK, RGBColor(230, 237, 243)),
    (GREY, RGBColor(160, 168, 178)),
    (ORANGE, RGBColor(240, 136, 62)),
    (GREEN, RGBColor(86, 211, 100)),
    (BLUE, RGBColor(121, 192, 255)),
    (PURPLE, RGBColor(210, 168, 255)),
];

/// A chart of this height, as an SVG picture whose colours follow the page's.
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

/// The style of text of this height in pixels. (plotters divides it by 1.24.)
fn font(size: i32, color: &RGBColor) -> TextStyle<'static> {
    ("sans-serif", 1.24 * f64::from(size)).into_font().color(color)
}

/// An axis of a chart: its scale, the values at its two ends, and the values that are marked, with
/// their names.
struct Axis {
    scale: fn(f64) -> f64,
    range: [f64; 2],
    marks: Vec<(f64, String)>,
}

/// The part of a chart that has two axes, and curves on them.
struct Panel<'a> {
    plane: Plane<'a>,
    scales: [fn(f64) -> f64; 2],
}

impl<'a> Panel<'a> {
    /// Draws the axes with their marks, and three texts: the title, what the y axis shows, and what the
    /// x axis shows.
    fn new(
        area: &Area<'a>,
        [title, y_title, x_title]: [&str; 3],
        x: &Axis,
        y: &Axis,
    ) -> Result<Panel<'a>> {
        let [horizontal, vertical] = [x, y].map(|axis| {
            let [start, end] = axis.range.map(axis.scale);
            start..end
        });
        let plane = ChartBuilder::on(area)
            .margin_top(54)
            .margin_right(8)
            .x_label_area_size(44)
            .y_label_area_size(52)
            .build_cartesian_2d(horizontal, vertical)?
            .plotting_area()
            .clone();
        let panel = Panel { plane, scales: [x.scale, y.scale] };
        area.draw(&Text::new(title, (4, 0), font(17, &INK)))?;
        area.draw(&Text::new(y_title, (4, 27), font(13, &INK)))?;
        let ([left, end], [bottom, top]) = (x.range, y.range);
        for (at, mark) in &x.marks {
            panel.line(&[(*at, bottom), (*at, top)], GRID.stroke_width(1))?;
            panel.label((*at, bottom), (0, 13), Center, mark, &GREY)?;
        }
        for (at, mark) in &y.marks {
            panel.line(&[(left, *at), (end, *at)], GRID.stroke_width(1))?;
            panel.label((left, *at), (-8, 0), Right, mark, &GREY)?;
        }
        panel.label((end, bottom), (0, 33), Right, x_title, &INK)?;
        Ok(panel)
    }

    /// The place of a point on the plane, after both scales.
    fn scaled(&self, (x, y): (f64, f64)) -> (f64, f64) {
        (self.scales[0](x), self.scales[1](y))
    }

    /// Draws a text beside a point. `anchor` is the start, the centre or the end of the text, which is
    /// placed `offset` pixels from the point.
    fn label(
        &self,
        at: (f64, f64),
        offset: (i32, i32),
        anchor: HPos,
        text: &str,
        color: &RGBColor,
    ) -> Result<()> {
        let style = font(13, color).pos(Pos::new(anchor, VPos::Center));
        let text = Text::new(text.to_string(), offset, style);
        Ok(self.plane.draw(&(EmptyElement::at(self.scaled(at)) + text))?)
    }

    fn line(&self, points: &[(f64, f64)], style: ShapeStyle) -> Result<()> {
        let points: Vec<_> = points.iter().map(|&point| self.scaled(point)).collect();
        Ok(self.plane.draw(&PathElement::new(points, style))?)
    }

    fn dot(&self, at: (f64, f64), radius: i32, color: &RGBColor) -> Result<()> {
        Ok(self.plane.draw(&Circle::new(self.scaled(at), radius, color.filled()))?)
    }
}

// ---- Time against wrong cells --------------------------------------------------------------------

/// A chart with a dot for each method: to the right is the time of a frame in microseconds, and
/// upward the share of wrong cells in per cent.
pub fn speed_and_accuracy(dots: &[(&str, (f64, f64))]) -> Result<String> {
    let starting_with = |start: &str| -> Vec<_> {
        dots.iter().filter(|dot| dot.0.starts_with(start)).map(|dot| dot.1).collect()
    };
    // Several names begin with "classic x1", and "classic x1" itself is the first of them.
    let [exact, one_by_one, closed, classic, literal] =
        ["exact", "exact one", "closed form", "classic x1", "donut.c"]
            .map(|name| starting_with(name)[0]);
    let title = "Eight rays at a time, exact is fastest with no wrong cell";
    let y_title = "wrong cells, as % of the donut's cells (cube-root scale)";
    let x_title = "time of a frame in µs, at 80x22 (logarithmic scale)";
    let times = [10.0, 30.0, 100.0, 300.0, 1000.0];
    let x = Axis {
        scale: f64::log10,
        range: [5.0, 3000.0],
        marks: times.map(|micros| (micros, format!("{micros}"))).into(),
    };
    let shares = [0.0, 0.1, 1.0, 5.0, 10.0, 20.0, 40.0, 60.0];
    let y = Axis {
        // A cube root spreads small shares out, as a logarithm does, but it also has a place for 0.
        scale: f64::cbrt,
        range: [-0.06, 95.0],
        marks: shares.map(|share| (share, format!("{share}%"))).into(),
    };
    chart(430, |area| {
        let panel = Panel::new(area, [title, y_title, x_title], &x, &y)?;
        // A line through classic with longer and shorter steps.
        let mut steps = starting_with("classic ");
        steps.sort_by(|a, b| a.0.total_cmp(&b.0));
        panel.line(&steps, FAINT.stroke_width(2))?;
        for &(name, at) in dots {
            if let Some(name) = name.strip_prefix("classic ").filter(|&name| name != "x1") {
                panel.dot(at, 3, &FAINT)?;
                panel.label(at, (0, -13), Center, name, &GREY)?;
            }
        }
        for (at, radius, name, color) in [
            (classic, 6, "classic", ORANGE),
            (literal, 6, "literal donut.c", INK),
            (exact, 8, "exact", GREEN),
        ] {
            panel.dot(at, radius, &color)?;
            let decimals = usize::from(at.0 < 100.0);
            let name = format!("{name}, {:.decimals$} µs", at.0);
            panel.label(at, (0, 18), Center, &name, &color)?;
        }
        panel.dot(one_by_one, 4, &GREEN)?;
        panel.label(one_by_one, (-2, 16), Left, "exact, one ray at a time", &GREEN)?;

        let tracing = starting_with("sphere tracing ");
        panel.line(&tracing, BLUE.stroke_width(2))?;
        for &at in &tracing {
            panel.dot(at, 3, &BLUE)?;
        }
        panel.label(tracing[0], (9, -2), Left, "sphere tracing, 8 steps", &BLUE)?;
        panel.label(tracing[4], (9, -4), Left, "256 steps", &BLUE)?;
        panel.dot(closed, 3, &PURPLE)?;
        panel.label(closed, (16, 0), Left, "closed form", &PURPLE)?;

        // An arrow towards less time and fewer wrong cells.
        let [tail, head] = [(9.3, 0.25), (6.0, 0.02)];
        panel.line(&[tail, head], GREY.stroke_width(2))?;
        panel.line(&[(6.1, 0.06), head, (7.6, 0.025)], GREY.stroke_width(2))?;
        panel.label(tail, (-2, -11), Center, "better", &GREY)
    })
}

// ---- The drift of donut.c's angles ---------------------------------------------------------------

/// A chart of the largest error of donut.c's angle A so far, over the running time.
pub fn drift(errors: &[(u32, f64)]) -> Result<String> {
    const MINUTE: f64 = 60.0 * 30.0;
    const HOUR: f64 = 60.0 * MINUTE;
    const DAY: f64 = 24.0 * HOUR;
    let x = Axis {
        scale: f64::log10,
        range: [0.6 * MINUTE, 30.0 * DAY],
        marks: [
            ("1 minute", MINUTE),
            ("1 hour", HOUR),
            ("31 hours", 31.0 * HOUR),
            ("9 days", 9.0 * DAY),
        ]
        .map(|(name, frames)| (frames, name.to_string()))
        .into(),
    };
    let turns = [(0.001, "0.001"), (0.1, "0.1"), (1.0, "1"), (10.0, "10"), (1000.0, "1,000")];
    let y = Axis {
        scale: f64::log10,
        range: [5e-5, 1e5],
        marks: turns.map(|(turns, name)| (turns, name.to_string())).into(),
    };
    let title = "donut.c's angle A is a whole turn off in 1.8 hours";
    let y_title = "largest error of A so far, in turns (logarithmic scale)";
    let x_title = "running time, at 30 frames a second (logarithmic scale)";
    chart(360, |area| {
        let panel = Panel::new(area, [title, y_title, x_title], &x, &y)?;
        let points: Vec<_> = errors
            .iter()
            .map(|&(frame, error)| (f64::from(frame), error / std::f64::consts::TAU))
            .filter(|&(frame, _)| (0.6 * MINUTE..22_918_663.5).contains(&frame))
            .collect();
        panel.line(&points, ORANGE.stroke_width(2))?;
        let at = |event: f64| *points.iter().find(|&&(frame, _)| frame == event).unwrap();
        for (event, name) in
            [(3_345_245.0, "here A begins to turn 17% too fast"), (22_918_663.0, "A stands still")]
        {
            panel.dot(at(event), 5, &INK)?;
            panel.label(at(event), (-10, -4), Right, name, &INK)?;
        }
        Ok(())
    })
}
