//! What a ray sees, found in another way: the oracle shares no code and no method with the program.
//!
//! The oracle works in the torus's own coordinates, where a point's distance from the surface is a
//! simple formula. It searches an interval of the ray for the first point whose distance is 0:
//!
//! - Going along the ray by some length changes the distance from the surface by that length at most. So
//!   if the distance at the middle of the interval is larger than half the interval's length, there is
//!   no hit in the interval.
//! - Drawn over the ray, the distance is a smooth curve, which bends no more sharply than a circle of
//!   known radius. So if the distance is large enough at both ends of the interval, the curve cannot sag
//!   to 0 between them, and there is no hit in the interval.
//! - Any other interval is halved, and the nearer half is searched first, until the halves are as short
//!   as rounding allows.
//!
//! In some cells, f64 has too few digits to decide what is right. Such a cell is a *tie*, and two kinds of
//! answers are right there as well:
//!
//! - the next glyph, where 8 L is less than 1e-11 below a whole number,
//! - what some other tube shows, thinner or thicker by at most 1e-13 (R1 + R2).

/// A rotated torus, seen from `k2` away. Lengths are in radii of the tube.
pub struct Oracle {
    pub r2: f64,
    pub k2: f64,
    /// The torus's own axes in view space; the third is its axis of revolution.
    pub axes: [[f64; 3]; 3],
}

/// How far below a whole number 8 L may be. `exact` adds `TIE_BIAS` to L, and its sums are rounded.
const LEVEL_TIE: f64 = 1e-11;
/// How much thinner or thicker the other tube may be, in units of R1 + R2.
const GRAZE_TIE: f64 = 1e-13;

pub fn dot(u: [f64; 3], v: [f64; 3]) -> f64 {
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
        let (q, u) = self.ray(dx, dy);
        let t = self.first_hit(q, u, r1)?;
        let p = [0, 1, 2].map(|i| q[i] + t * u[i]);
        let ring = 1.0 - self.r2 / f64::hypot(p[0], p[1]);
        let normal = [p[0] * ring, p[1] * ring, p[2]];
        let light = self.axes.map(|axis| dot(axis, [0.0, -1.0, -1.0]));
        Some(8.0 * dot(normal, light) / r1)
    }

    /// Judges what was drawn: a level from 0 to 11, or nothing for a blank.
    pub fn judge(&self, dx: f64, dy: f64, drawn: Option<usize>) -> Verdict {
        let truth = self.look(dx, dy);
        if truth.map(level_of) == drawn {
            return Verdict::Right;
        }
        let explains = |light: &Option<f64>| {
            light.map(level_of) == drawn || light.map(|light| level_of(light + LEVEL_TIE)) == drawn
        };
        match (truth, drawn) {
            _ if explains(&truth) || self.blurred(dx, dy).iter().any(explains) => Verdict::Tie,
            (Some(_), None) => Verdict::Hole,
            (None, _) => Verdict::Extra,
            _ => Verdict::Shade,
        }
    }

    /// What the ray sees with tubes that are a little thinner or thicker.
    fn blurred(&self, dx: f64, dy: f64) -> Vec<Option<f64>> {
        let blur = GRAZE_TIE * (1.0 + self.r2);
        let (mut thin, mut thick) = (1.0 - blur, 1.0 + blur);
        let look = |r1| self.look_at_tube(r1, dx, dy);
        let mut lights = vec![look(thin), look(thick)];
        // If the two differ, there is a tube between them that the ray only just touches. This bisection
        // closes in on it.
        let mut middle = 1.0;
        while differ(lights[0], lights[1]) && thin < middle && middle < thick {
            let light = look(middle);
            lights.push(light);
            if differ(lights[0], light) {
                thick = middle
            } else {
                thin = middle
            }
            middle = (thin + thick) / 2.0;
        }
        lights
    }

    /// The ray's point in the plane z = 0, through the torus's centre, and the ray's unit direction. Both
    /// are in the torus's own coordinates.
    fn ray(&self, dx: f64, dy: f64) -> ([f64; 3], [f64; 3]) {
        let length = (dx * dx + dy * dy + 1.0).sqrt();
        let into = |v: [f64; 3]| self.axes.map(|axis| dot(axis, v));
        let u = [dx / length, dy / length, 1.0 / length];
        (into([self.k2 * dx, self.k2 * dy, 0.0]), into(u))
    }

    /// The first t at which q + t u is no longer outside the torus.
    fn first_hit(&self, q: [f64; 3], u: [f64; 3], r1: f64) -> Option<f64> {
        let measure = |t: f64| {
            let p = [0, 1, 2].map(|i| q[i] + t * u[i]);
            let from_axis = (p[0] * p[0] + p[1] * p[1]).sqrt();
            let from_ring = ((from_axis - self.r2).powi(2) + p[2] * p[2]).sqrt();
            // The second derivative of the distance is at most 1 / from_ring in a plane through the
            // axis, and at most 1 / from_axis round the axis. So the smaller of from_ring and from_axis
            // is a safe radius for `search`.
            (from_ring - r1, from_ring.min(from_axis))
        };
        let (nearest, reach) = (-dot(q, u), 1.001 * (r1 + self.r2));
        search(&measure, nearest, reach, 1e-14 * reach)
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

/// The first t at which the distance is 0, between `middle - half` and `middle + half`. Intervals are
/// halved until `half` is at most `least_half`.
///
/// For a t, `measure` gives the distance, and a radius: the curve of the distance bends no more sharply
/// there than a circle of this radius. If t changes by some amount, both change by that amount at most.
fn search(
    measure: &impl Fn(f64) -> (f64, f64),
    middle: f64,
    half: f64,
    least_half: f64,
) -> Option<f64> {
    let (distance, radius) = measure(middle);
    let at_ends = || measure(middle - half).0.min(measure(middle + half).0);
    // In the whole interval, the radius is at least `radius - half`. If that is positive, the curve sags
    // between the ends of the interval by this much at most.
    let sag = half * half / (2.0 * (radius - half));
    if distance > half || radius > half && at_ends() > sag {
        None
    } else if half <= least_half {
        Some(middle)
    } else {
        let half = half / 2.0;
        search(measure, middle - half, half, least_half)
            .or_else(|| search(measure, middle + half, half, least_half))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    Right,
    /// Not what the oracle sees, but f64 cannot tell the two apart.
    Tie,
    /// Blank where the oracle sees the donut.
    Hole,
    /// A glyph where the oracle sees nothing.
    Extra,
    /// A glyph other than the oracle's: a wrong shade, or the far wall seen through the near one.
    Shade,
}
