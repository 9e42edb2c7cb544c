//! What a ray sees, found in another way: this shares no code and no method with the program.
//!
//! The ray is turned into the torus's own frame, where the signed distance to the surface is a
//! formula. That distance changes by no more than the way gone, so an interval whose midpoint is
//! further from the surface than its ends holds no surface. What is left is halved, nearest part
//! first, down to the last bits. There is no polynomial, no derivative and no step to converge.

/// A torus turned and seen from `k2` away, in any unit of length.
pub struct Oracle {
    pub r1: f64,
    pub r2: f64,
    pub k2: f64,
    /// The torus's own axes in view space; the third is its axis of revolution.
    pub frame: [[f64; 3]; 3],
}

/// From so far below a whole number on, 8 L counts as that number: `exact` adds a hair before it truncates.
const LEVEL_TIE: f64 = 1e-11;
/// How well the radius of the tube is known, over R1 + R2: distances are rounded in f64.
const GRAZE_TIE: f64 = 1e-13;

pub fn dot(u: [f64; 3], v: [f64; 3]) -> f64 {
    u[0] * v[0] + u[1] * v[1] + u[2] * v[2]
}

impl Oracle {
    /// donut.c's turns: about x by A, then about z by B.
    pub fn new(r1: f64, r2: f64, k2: f64, a: f64, b: f64) -> Oracle {
        let (sin_a, cos_a, sin_b, cos_b) = (a.sin(), a.cos(), b.sin(), b.cos());
        let frame = [
            [cos_b, sin_b, 0.0],
            [-cos_a * sin_b, cos_a * cos_b, sin_a],
            [sin_a * sin_b, -sin_a * cos_b, cos_a],
        ];
        Oracle { r1, r2, k2, frame }
    }

    /// 8 L at the first hit of the ray in the direction (dx, dy, 1), or nothing.
    pub fn look(&self, dx: f64, dy: f64) -> Option<f64> {
        self.look_at_tube(self.r1, dx, dy)
    }

    /// The same if the radius of the tube were another.
    fn look_at_tube(&self, r1: f64, dx: f64, dy: f64) -> Option<f64> {
        let (q, u) = self.ray(dx, dy);
        let t = self.first_hit(q, u, r1)?;
        let p = [0, 1, 2].map(|i| q[i] + t * u[i]);
        let ring = 1.0 - self.r2 / f64::hypot(p[0], p[1]);
        let normal = [p[0] * ring, p[1] * ring, p[2]];
        let light = self.frame.map(|axis| dot(axis, [0.0, -1.0, -1.0]));
        Some(8.0 * dot(normal, light) / r1)
    }

    /// Whether the drawn level (nothing for a blank) is right, or the truth cannot be told: that is
    /// where a torus thinner or thicker by next to nothing would show it.
    pub fn judge(&self, dx: f64, dy: f64, drawn: Option<usize>) -> Verdict {
        let level = |light: f64| light.max(0.0) as usize;
        let truth = self.look(dx, dy);
        if truth.map(level) == drawn {
            return Verdict::Right;
        }
        let blur = GRAZE_TIE * (self.r1 + self.r2);
        let undecided = [0.0, -blur, blur].into_iter().any(|blur| {
            let light = self.look_at_tube(self.r1 + blur, dx, dy);
            light.map(level) == drawn || light.map(|light| level(light + LEVEL_TIE)) == drawn
        });
        match (truth, drawn) {
            _ if undecided => Verdict::Tie,
            (Some(_), None) => Verdict::Hole,
            (None, _) => Verdict::Extra,
            _ => Verdict::Shade,
        }
    }

    /// The ray's point in the plane through the torus's centre, and its unit direction, in the
    /// torus's frame.
    fn ray(&self, dx: f64, dy: f64) -> ([f64; 3], [f64; 3]) {
        let length = (dx * dx + dy * dy + 1.0).sqrt();
        let into = |v: [f64; 3]| self.frame.map(|axis| dot(axis, v));
        let u = [dx / length, dy / length, 1.0 / length];
        (into([self.k2 * dx, self.k2 * dy, 0.0]), into(u))
    }

    /// The first t at which q + t u is no longer outside the torus.
    fn first_hit(&self, q: [f64; 3], u: [f64; 3], r1: f64) -> Option<f64> {
        let distance = |t: f64| {
            let p = [0, 1, 2].map(|i| q[i] + t * u[i]);
            let across = (p[0] * p[0] + p[1] * p[1]).sqrt() - self.r2;
            (across * across + p[2] * p[2]).sqrt() - r1
        };
        let (nearest, reach) = (-dot(q, u), 1.001 * (r1 + self.r2));
        search(&distance, nearest, reach, 1e-14 * reach)
    }
}

/// The first zero of `distance` within `half` of `middle`, to within `end`.
fn search(distance: &impl Fn(f64) -> f64, middle: f64, half: f64, end: f64) -> Option<f64> {
    if distance(middle) > half {
        None
    } else if half <= end {
        Some(middle)
    } else {
        let half = half / 2.0;
        search(distance, middle - half, half, end)
            .or_else(|| search(distance, middle + half, half, end))
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Verdict {
    Right,
    Tie,
    /// Blank where there is surface.
    Hole,
    /// Drawn where there is none.
    Extra,
    /// Another glyph: a wrong shade, or the far wall seen through the near one.
    Shade,
}
