//! Other ways to find what a ray hits first, to compare with the program's own, and more rays in a cell.
//! They use the program's rays and its shading, in f64. So that their times can be compared, they follow
//! eight rays side by side, as it does, and leave out what none of the eight needs.

use crate::tests::*;

/// Follows N by N rays in each cell, eight neighbours in one line at a time, as exact follows one.
/// `first_hits` finds their hits, and `show` is told the cell and the luminance of each.
pub fn follow<const N: usize>(
    view: &View,
    (a, b): (f64, f64),
    first_hits: impl Fn(&Torus, &Rays) -> f64x8,
    mut show: impl FnMut(usize, f64),
) {
    let &View { r2, k2, width, cx, cy, k1x, k1y, .. } = view;
    let torus = Torus { r2, axis: axis(a, b) };
    let outline_radius = outline_radius(r2, k2);
    for line in 0..N * view.height {
        let dy = ((line as f64 + 0.5) / N as f64 - cy) / k1y;
        let half_width = (outline_radius * outline_radius - dy * dy).max(0.0).sqrt() * k1x;
        let (start, end) = ((cx - half_width) as usize, width.min((cx + half_width) as usize + 1));
        for first in (N * start..N * end).step_by(8) {
            let middles = f64x8::new([0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]);
            let x = (first as f64 + middles) / N as f64;
            let rays = torus.rays((x - cx) / k1x, dy, k2);
            let hits = first_hits(&torus, &rays);
            let luminances = torus.luminance(&rays, hits).to_array();
            for (i, (hit, luminance)) in hits.to_array().into_iter().zip(luminances).enumerate() {
                // The last rays may be beyond the outline.
                if hit < MISS && first + i < N * end {
                    show(line / N * width + (first + i) / N, luminance);
                }
            }
        }
    }
}

/// Of the rays in a cell, those that hit, and the sum of their luminances. A negative one counts as 0.
#[derive(Clone, Copy, Debug, Default)]
pub struct Hits {
    pub count: usize,
    pub light: f64,
}

/// What N by N rays hit in each cell.
pub fn hits<const N: usize>(view: &View, a: f64, b: f64) -> Vec<Hits> {
    let mut cells = vec![Hits::default(); view.width * view.height];
    let exact = |torus: &Torus, rays: &Rays| torus.quartic(rays).first_hits(torus.entry(rays));
    follow::<N>(view, (a, b), exact, |cell, luminance| {
        cells[cell].count += 1;
        cells[cell].light += luminance.max(0.0);
    });
    cells
}

/// Draws with N by N rays in a cell: the donut where at least half of them hit, with the mean luminance of
/// those.
pub fn averaged<const N: usize>(view: &View, a: f64, b: f64) -> Vec<u8> {
    let shown = |hits: Hits| match hits.count {
        count if 2 * count < N * N => b' ',
        count => glyph(hits.light / count as f64 + TIE_BIAS),
    };
    hits::<N>(view, a, b).into_iter().map(shown).collect()
}

/// Sphere tracing, in f32, from the sphere round the donut. Each step along the ray is as long as the
/// distance to the surface, so it cannot pass the surface. A ray has hit when the distance is at most a
/// tolerance. If that is small, more rays run out of steps before they hit; if it is large, more rays
/// stop beside an outline that they should pass. `1 / most_steps^2` is a compromise.
pub fn sphere_tracing(most_steps: usize) -> impl Fn(&Torus, &Rays) -> f64x8 {
    let tolerance = (most_steps as f32).powi(-2);
    move |torus, rays| {
        let r2 = torus.r2 as f32;
        let [d0_squared, f0, fu] = [rays.d0_squared, rays.f0, rays.fu]
            .map(|numbers| f32x8::new(numbers.to_array().map(|number| number as f32)));
        let half = ((1.0 + r2) * (1.0 + r2) - d0_squared).fast_max(f32x8::ZERO).sqrt();
        let (mut s, mut distance) = (-half, f32x8::ZERO);
        for _ in 0..most_steps {
            let f = f0 + s * fu;
            let h = (d0_squared + s * s - f * f).fast_max(f32x8::ZERO).sqrt();
            distance = ((h - r2) * (h - r2) + f * f).sqrt() - 1.0;
            let steps = distance.simd_gt(tolerance) & s.simd_lt(half);
            if !steps.any() {
                break;
            }
            s += steps.select(distance, f32x8::ZERO);
        }
        let hits = distance.simd_le(tolerance).select(s, f32x8::splat(f32::INFINITY));
        f64x8::new(hits.to_array().map(f64::from))
    }
}

/// The closed form: the first root of G(s) = 0 by Ferrari's solution. It writes G as a product, which is
/// possible if `y = alpha^2` solves another equation, the resolvent:
/// ```text
/// G(s) = s^4 + p s^2 + q s + r = (s^2 + alpha s + beta) (s^2 - alpha s + gamma)
/// y^3 + 2 p y^2 + (p^2 - 4 r) y - q^2 = 0
/// ```
///
/// The largest solution y puts the two smaller roots of G into the first factor, whose smaller root is
/// the first hit. If that factor has no roots, the first hit is the smaller root of the second one.
///
/// With `y = v - 2/3 p` the resolvent becomes `v^3 - 3 m v - 2 n = 0`. If this has three roots, the
/// largest is found by a cosine. If it has one, the root is found by Cardano's formula.
pub fn closed_form(torus: &Torus, rays: &Rays) -> f64x8 {
    let Quartic { p, q, c } = torus.quartic(rays);
    let (p, q, r) = (2.0 * p, 2.0 * q, p * p + c);
    let m = (p * p + 12.0 * r) / 9.0;
    let n = p * p * p / 27.0 - 4.0 / 3.0 * p * r + q * q / 2.0;
    let discriminant = n * n - m * m * m;
    let (three, mut v) = (discriminant.simd_lt(0.0), f64x8::ZERO);
    if three.any() {
        let root = m.sqrt();
        let ratio = (n / (m * root)).clamp(-f64x8::ONE, f64x8::ONE);
        v = 2.0 * root * (ratio.acos() / 3.0).cos();
    }
    if !three.all() {
        let t = (n + discriminant.sqrt().copysign(n)).cbrt();
        v = three.select(v, t.simd_eq(0.0).select(t, t + m / t));
    }
    let y = (v - 2.0 / 3.0 * p).max(f64x8::ZERO);
    let alpha = y.sqrt();
    // This is gamma - beta. Where alpha is almost 0, so is q, and rounding spoils q / alpha. There, it
    // is the square root of (beta + gamma)^2 - 4 beta gamma, with beta + gamma = p + y and beta gamma =
    // r.
    let safe = ((p + y) * (p + y) - 4.0 * r).max(f64x8::ZERO).sqrt().copysign(q);
    let apart = y.simd_lt(p.abs() / 8.0).select(safe, q / alpha);
    // The discriminants of the two factors: alpha^2 - 4 beta and alpha^2 - 4 gamma. A factor with a
    // negative one has no roots: its square root is NaN, which `min` ignores.
    let (first, second) = (2.0 * (apart - p) - y, -2.0 * (apart + p) - y);
    let root = first.simd_ge(0.0).select(-alpha - first.sqrt(), alpha - second.sqrt());
    (root / 2.0).min(f64x8::splat(MISS))
}

/// Newton's method, which steps to the root of the tangent, from the point where the ray enters the
/// sphere round the donut. The ray misses if the search ends outside the sphere, or takes more than 64
/// steps.
pub fn newton_once(torus: &Torus, rays: &Rays) -> f64x8 {
    let radius = 1.0 + torus.r2;
    let half = (radius * radius - rays.d0_squared).max(f64x8::ZERO).sqrt();
    let Quartic { p, q, c } = torus.quartic(rays);
    let (mut s, mut step) = (-half, f64x8::splat(MISS));
    for _ in 0..64 {
        let steps = step.abs().simd_gt(1e-8);
        if !steps.any() {
            break;
        }
        let base = s * s + p;
        step = steps.select((base * base + (2.0 * q * s + c)) / (-4.0 * base * s - 2.0 * q), step);
        s = steps.select(s + step, s);
    }
    let hits = step.abs().simd_le(1e-8) & s.abs().simd_le(half);
    hits.select(s, f64x8::splat(MISS))
}

/// The textbook's solution, in f32 or in f64: the formulas of `closed_form`, without its precautions
/// against rounding, for the distance t from the viewer. In t, the surface is where
/// ```text
/// (t^2 - 2 t0 t + k)^2 = 4 R2^2 (t^2 - 2 t0 t + K2^2 - (f + fu t)^2)
/// ```
///
/// Here f is the viewer's height above the plane of the ring, t0 is the distance from the viewer to P0,
/// the point of the ray nearest to the donut's centre, and k is `K2^2 + R2^2 - 1`.
macro_rules! textbook {
    ($name:ident, $float:ident, $lanes:ident) => {
        pub fn $name(torus: &Torus, k2: f64, rays: &Rays) -> f64x8 {
            let [t0, fu] = [(k2 * k2 - rays.d0_squared).sqrt(), rays.fu]
                .map(|numbers| $lanes::new(numbers.to_array().map(|number| number as $float)));
            let [f, k2, r2] = [-k2 * torus.axis[2], k2, torus.r2].map(|number| number as $float);
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
            let (three, mut v) = (discriminant.simd_lt(0.0), $lanes::ZERO);
            if three.any() {
                v = 2.0 * m.sqrt() * ((n / (m * m.sqrt())).acos() / 3.0).cos();
            }
            if !three.all() {
                let root = discriminant.sqrt();
                v = three.select(v, (n + root).cbrt() + (n - root).cbrt());
            }
            let y = v - 2.0 / 3.0 * p;
            let alpha = y.sqrt();
            // The square roots of the factors' discriminants: NaN where a factor has no roots. These are
            // dropped below, because NaN is not above 0.
            let [first, second] =
                [q / alpha, -q / alpha].map(|apart| (2.0 * (apart - p) - y).sqrt());
            let roots = [-alpha - first, first - alpha, alpha - second, second + alpha];
            let miss = $lanes::splat($float::INFINITY);
            let ts = roots.map(|root| root / 2.0 - a / 4.0);
            let first =
                ts.into_iter().fold(miss, |first, t| t.simd_gt(0.0).select(t, miss).min(first));
            f64x8::new((first - t0).to_array().map(Into::into))
        }
    };
}

textbook!(textbook_f32, f32, f32x8);
textbook!(textbook_f64, f64, f64x8);
