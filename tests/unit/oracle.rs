//! What a ray sees, found in another way: the oracle shares no code and no method with the program.
//!
//! The oracle works in the torus's own coordinates, where a point's distance from the surface is a
//! simple formula. `search` looks for the first point of the ray whose distance is 0.
//!
//! In some cells, f64 has too few digits to decide what is right. Such a cell is a *tie*. The next glyph
//! is right there as well if 8 L is almost a whole number, and so is what some other tube shows, a little
//! thinner or thicker.

/// A rotated torus, seen from `k2` away. Lengths are in radii of the tube.
pub struct Oracle {
    r2: f64,
    k2: f64,
    /// The torus's own axes in view space; the third is its axis of revolution.
    axes: [[f64; 3]; 3],
}

/// How far below a whole number 8 L may be. `exact` adds `TIE_BIAS` to L, and its sums are rounded.
const LEVEL_TIE: f64 = 1e-11;
/// By how much the other tube may be thinner or thicker, in units of R1 + R2.
const GRAZE_TIE: f64 = 1e-13;

fn dot(u: [f64; 3], v: [f64; 3]) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

impl Oracle {
    /// A torus rotated as in donut.c: about x by A, then about z by B.
    pub fn new(r2: f64, k2: f64, a: f64, b: f64) -> Oracle {
        let (sin_a, cos_a, sin_b, cos_b) = (a.sin(), a.cos(), b.sin(), b.cos());
        let axes = [
            [cos_b, sin_b, 0.0],
            [-cos_a * sin_b, cos_a * cos_b, sin_a],
            [sin_a * sin_b, -sin_a * cos_b, cos_a],
        ];
        Oracle { r2, k2, axes }
    }

    /// 8 L at the first hit of the ray in the direction (dx, dy, 1), or nothing.
    pub fn look(&self, dx: f64, dy: f64) -> Option<f64> {
        self.look_at_tube(1.0, dx, dy)
    }

    /// What `look` would see with a tube of another radius.
    fn look_at_tube(&self, r1: f64, dx: f64, dy: f64) -> Option<f64> {
        let length = (dx * dx + dy * dy + 1.0).sqrt();
        let into = |v: [f64; 3]| self.axes.map(|axis| dot(axis, v));
        // A point of the ray, t away from where the ray passes the torus's centre.
        let q = into([self.k2 * dx, self.k2 * dy, 0.0]);
        let u = into([dx / length, dy / length, 1.0 / length]);
        let point = |t: f64| [0, 1, 2].map(|i| q[i] + t * u[i]);
        let measure = |t: f64| {
            let [x, y, z] = point(t);
            let from_axis = (x * x + y * y).sqrt();
            let from_ring = ((from_axis - self.r2).powi(2) + z * z).sqrt();
            // The second derivative of the distance is at most 1 / from_ring in a plane through the
            // axis, and at most 1 / from_axis round the axis.
            (from_ring - r1, from_ring.min(from_axis))
        };
        let reach = 1.001 * (r1 + self.r2);
        let [x, y, z] = point(search(&measure, -dot(q, u), reach, 1e-14 * reach)?);
        let ring = 1.0 - self.r2 / f64::hypot(x, y);
        Some(8.0 * dot([x * ring, y * ring, z], into([0.0, -1.0, -1.0])) / r1)
    }

    /// Judges what was drawn, a level from 0 to 11, or nothing for a blank. `truth` is what `look` sees.
    pub fn judge(&self, dx: f64, dy: f64, truth: Option<f64>, drawn: Option<usize>) -> Verdict {
        if truth.map(level_of) == drawn {
            return Verdict::Right;
        }
        let blur = GRAZE_TIE * (1.0 + self.r2);
        let (mut thin, mut middle, mut thick) = (1.0 - blur, 1.0, 1.0 + blur);
        let look = |r1| self.look_at_tube(r1, dx, dy);
        let mut lights = vec![look(thin), truth, look(thick)];
        // If the thinnest tube and the thickest differ, there is one between them that the ray only just
        // touches. What the ray sees of the tubes on the way there is right as well.
        while differ(lights[0], lights[2]) && thin < middle && middle < thick {
            let light = look(middle);
            lights.push(light);
            [thin, thick] = if differ(lights[0], light) { [thin, middle] } else { [middle, thick] };
            middle = (thin + thick) / 2.0;
        }
        let explains = |light: Option<f64>| {
            light.map(level_of) == drawn || light.map(|light| level_of(light + LEVEL_TIE)) == drawn
        };
        match (truth, drawn) {
            _ if lights.into_iter().any(explains) => Verdict::Tie,
            (Some(_), None) => Verdict::Hole,
            (None, _) => Verdict::Extra,
            _ => Verdict::Shade,
        }
    }
}

/// The level of a light: the whole part of 8 L, or 0 where L is negative.
pub fn level_of(light: f64) -> usize {
    light.max(0.0) as usize
}

/// Whether two lights are those of different places, or of a place and of none.
pub fn differ(one: Option<f64>, other: Option<f64>) -> bool {
    match (one, other) {
        (Some(one), Some(other)) => (one - other).abs() > 0.5,
        _ => one.is_some() != other.is_some(),
    }
}

/// The first t at which the distance is 0, between `middle - half` and `middle + half`. An interval is
/// halved, and its nearer half is searched first, until `half` is at most `least`.
///
/// For a t, `measure` gives the distance, and a radius: drawn over t, the curve of the distance bends no
/// more sharply there than a circle of this radius. If t changes by some amount, both change by that
/// amount at most.
fn search(measure: &impl Fn(f64) -> (f64, f64), middle: f64, half: f64, least: f64) -> Option<f64> {
    let (distance, radius) = measure(middle);
    let at_ends = || measure(middle - half).0.min(measure(middle + half).0);
    // In the whole interval, the radius is at least `radius - half`. If that is positive, the curve sags
    // between its ends by this much at most.
    let sag = half * half / (2.0 * (radius - half));
    if distance > half || radius > half && at_ends() > sag {
        None
    } else if half <= least {
        Some(middle)
    } else {
        let half = half / 2.0;
        search(measure, middle - half, half, least)
            .or_else(|| search(measure, middle + half, half, least))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    Right,
    Tie,
    /// Blank where the oracle sees the donut.
    Hole,
    /// A glyph where the oracle sees nothing.
    Extra,
    /// A glyph other than the oracle's: a wrong shade, or the far wall seen through the near one.
    Shade,
}
