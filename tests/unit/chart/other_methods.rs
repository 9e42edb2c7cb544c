//! Other ways to find what a ray hits first, to compare with the program's own. They use its rays and its
//! shading, in f64. Those whose times the chart compares should not be slow for no reason, so sphere tracing
//! follows RAYS rays side by side, as exact does.

use crate::tests::*;

const RAYS: usize = 16;

/// Sphere tracing, in f32, from the sphere round the donut. Each step along the ray is as long as the
/// distance to the surface, so it cannot pass the surface. A ray has hit when the distance is at most a
/// tolerance. If that is small, more rays run out of steps before they hit; if it is large, more rays stop
/// beside an outline that they should pass. `1 / most_steps^2` is a compromise.
pub fn sphere_tracing(most_steps: usize) -> impl Fn(&Torus, &[Ray; RAYS]) -> [f64; RAYS] {
    let tolerance = (most_steps as f32).powi(-2);
    move |torus, rays| {
        let r2 = torus.r2 as f32;
        let d0_squared = rays.map(|ray| ray.d0_squared as f32);
        let (f0, fu) = (rays.map(|ray| ray.f0 as f32), rays.map(|ray| ray.fu as f32));
        let half = d0_squared.map(|square| ((1.0 + r2) * (1.0 + r2) - square).max(0.0).sqrt());
        let (mut s, mut distance) = (half.map(|half| -half), [f32::INFINITY; RAYS]);
        for _ in 0..most_steps {
            let mut running = false;
            for i in 0..RAYS {
                let f = f0[i] + s[i] * fu[i];
                let h = (d0_squared[i] + s[i] * s[i] - f * f).max(0.0).sqrt();
                distance[i] = ((h - r2) * (h - r2) + f * f).sqrt() - 1.0;
                let open = (distance[i] > tolerance) & (s[i] < half[i]);
                s[i] += if open { distance[i] } else { 0.0 };
                running |= open;
            }
            if !running {
                break;
            }
        }
        std::array::from_fn(|i| if distance[i] <= tolerance { s[i].into() } else { MISS })
    }
}

/// The coefficients of `s^4 + p s^2 + q s + r`, which is the program's G multiplied out.
fn plain_quartic(torus: &Torus, ray: &Ray) -> [f64; 3] {
    let Quartic { p, q, r, .. } = Quartic::new(torus.r2, ray);
    [2.0 * p, q, p * p + r]
}

/// The closed form: the first root of G(s) = 0 by Ferrari's solution. It writes G as a product, which is
/// possible if `y = alpha^2` solves another equation, the resolvent:
/// ```text
/// G(s) = s^4 + p s^2 + q s + r = (s^2 + alpha s + beta) (s^2 - alpha s + gamma)
/// y^3 + 2 p y^2 + (p^2 - 4 r) y - q^2 = 0
/// ```
///
/// The largest solution y puts the two smaller roots of G into the first factor, whose smaller root is the
/// first hit. If that factor has no roots, the first hit is the smaller root of the second one.
///
/// With `y = v - 2/3 p` the resolvent becomes `v^3 - 3 m v - 2 n = 0`. If this has three roots, the
/// largest is found by a cosine. If it has one, the root is found by Cardano's formula.
pub fn closed_form(torus: &Torus, ray: &Ray) -> f64 {
    let [p, q, r] = plain_quartic(torus, ray);
    let m = (p * p + 12.0 * r) / 9.0;
    let n = p * p * p / 27.0 - 4.0 / 3.0 * p * r + q * q / 2.0;
    let discriminant = n * n - m * m * m;
    let v = if discriminant < 0.0 {
        let root = m.sqrt();
        2.0 * root * ((n / (m * root)).clamp(-1.0, 1.0).acos() / 3.0).cos()
    } else {
        let t = (n + discriminant.sqrt().copysign(n)).cbrt();
        if t == 0.0 { 0.0 } else { t + m / t }
    };
    let y = (v - 2.0 / 3.0 * p).max(0.0);
    let alpha = y.sqrt();
    // This is gamma - beta. Where alpha is almost 0, so is q, and rounding spoils q / alpha. There, it is
    // the square root of (beta + gamma)^2 - 4 beta gamma, with beta + gamma = p + y and beta gamma = r.
    let apart = if y < p.abs() / 8.0 {
        ((p + y) * (p + y) - 4.0 * r).max(0.0).sqrt().copysign(q)
    } else {
        q / alpha
    };
    // The discriminants of the two factors: alpha^2 - 4 beta and alpha^2 - 4 gamma. A factor with a negative
    // one has no roots: its square root is NaN, which `min` ignores.
    let (first, second) = (2.0 * (apart - p) - y, -2.0 * (apart + p) - y);
    let root = if first >= 0.0 { -alpha - first.sqrt() } else { alpha - second.sqrt() };
    f64::min(root / 2.0, MISS)
}

/// Newton's method with a single start: the point where the ray enters the sphere round the donut. The ray
/// misses if the search ends outside the sphere, or takes more than 64 steps.
pub fn newton_once(torus: &Torus, ray: &Ray) -> f64 {
    let radius = 1.0 + torus.r2;
    let half = (radius * radius - ray.d0_squared).max(0.0).sqrt();
    let ([p, q, r], mut s) = (plain_quartic(torus, ray), -half);
    for _ in 0..64 {
        let slope = (4.0 * s * s + 2.0 * p) * s + q;
        let step = (((s * s + p) * s + q) * s + r) / slope;
        s -= step;
        if step.abs() <= TOLERANCE {
            return if s.abs() <= half { s } else { MISS };
        }
    }
    MISS
}

/// The textbook's solution, in f32 or in f64: the formulas of `closed_form`, without its precautions against
/// rounding, for the distance t from the viewer. In t, the surface is where
/// ```text
/// (t^2 - 2 t0 t + k)^2 = 4 R2^2 (t^2 - 2 t0 t + K2^2 - (f + fu t)^2)
/// ```
///
/// Here f is the viewer's height above the plane of the ring, t0 is the distance from the viewer to
/// P0, the point of the ray nearest to the donut's centre, and k is `K2^2 + R2^2 - 1`.
macro_rules! textbook {
    ($name:ident, $float:ident) => {
        pub fn $name(torus: &Torus, k2: f64, &Ray { d0_squared, fu, .. }: &Ray) -> f64 {
            let (t0, f) = ((k2 * k2 - d0_squared).sqrt(), -k2 * torus.axis[2]);
            let [t0, f, fu, k2, r2] = [t0, f, fu, k2, torus.r2].map(|value| value as $float);
            let four_r2_r2 = 4.0 * r2 * r2;
            // t^4 + a t^3 + b t^2 + c t + d
            let k = k2 * k2 + r2 * r2 - 1.0;
            let a = -4.0 * t0;
            let b = 4.0 * t0 * t0 + 2.0 * k - four_r2_r2 * (1.0 - fu * fu);
            let c = -4.0 * t0 * k + 2.0 * four_r2_r2 * (t0 + f * fu);
            let d = k * k - four_r2_r2 * (k2 * k2 - f * f);
            // x^4 + p x^2 + q x + r, where x = t + a / 4
            let aa = a * a;
            let p = b - 3.0 * aa / 8.0;
            let q = c - a * b / 2.0 + a * aa / 8.0;
            let r = d - a * c / 4.0 + aa * b / 16.0 - 3.0 * aa * aa / 256.0;
            // y solves the resolvent.
            let m = (p * p + 12.0 * r) / 9.0;
            let n = p * p * p / 27.0 - 4.0 / 3.0 * p * r + q * q / 2.0;
            let discriminant = n * n - m * m * m;
            let v = if discriminant < 0.0 {
                2.0 * m.sqrt() * ((n / (m * m.sqrt())).acos() / 3.0).cos()
            } else {
                (n + discriminant.sqrt()).cbrt() + (n - discriminant.sqrt()).cbrt()
            };
            let y = v - 2.0 / 3.0 * p;
            let alpha = y.sqrt();
            // The square roots of the factors' discriminants: NaN where a factor has no roots. The
            // filter below drops these, because NaN is not above 0.
            let [first, second] =
                [q / alpha, -q / alpha].map(|apart| (2.0 * (apart - p) - y).sqrt());
            let roots = [-alpha - first, first - alpha, alpha - second, second + alpha];
            let ts = roots.into_iter().map(|root| root / 2.0 - a / 4.0).filter(|&t| t > 0.0);
            (ts.fold($float::INFINITY, $float::min) - t0).into()
        }
    };
}

textbook!(textbook_f32, f32);
textbook!(textbook_f64, f64);
