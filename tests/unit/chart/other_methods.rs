//! Other methods, to compare with the program's own. Most of them only find in another way what a ray hits
//! first, and use the program's rays and its shading, in f64. So that their times can be compared, they follow
//! eight rays side by side, as it does, and leave out what none of the eight needs.

use crate::tests::*;

/// Follows N by N rays in each cell, eight neighbours in one line at a time, as exact follows one.
/// `first_hits` finds their hits, and `show` is told the cell and the luminance of each.
pub fn follow<const N: usize>(
    view: &View,
    (a, b): (f64, f64),
    mut first_hits: impl FnMut(&Torus, &Rays) -> f64x8,
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

/// Draws with N by N rays in a cell: the donut where at least so many of them hit, with the mean luminance of
/// those.
pub fn averaged<const N: usize, const LEAST: usize>(view: &View, a: f64, b: f64) -> Vec<u8> {
    let shown = |hits: Hits| match hits.count {
        count if count < LEAST => b' ',
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

/// Newton's method, which steps to the root of the tangent, from the point where the ray enters the sphere
/// round the donut. The ray misses if it leaves the sphere on the far side, or takes more than 64 steps.
pub fn newton_once(torus: &Torus, rays: &Rays) -> f64x8 {
    let (mut s, mut step) = (torus.entry(rays), f64x8::splat(MISS));
    let (half, Quartic { p, q, c }) = (-s, torus.quartic(rays));
    for _ in 0..64 {
        let goes_on = step.abs().simd_gt(1e-8) & s.simd_le(half);
        if !goes_on.any() {
            break;
        }
        let base = s * s + p;
        step =
            goes_on.select((base * base + (2.0 * q * s + c)) / (-4.0 * base * s - 2.0 * q), step);
        s = goes_on.select(s + step, s);
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

/// Draws as exact does, but all numbers of a ray are in f32. The formulas are those of `trace`, `Torus` and
/// `Quartic`.
pub fn exact_f32(view: &View, a: f64, b: f64) -> Vec<u8> {
    const TOLERANCE: f32 = 1e-3;
    const TIE_BIAS: f32 = 1e-6;
    let &View { r2, k2, width, height, cx, cy, k1x, k1y } = view;
    let numbers = [r2, k2, cx, cy, 1.0 / k1x, k1x, k1y, outline_radius(r2, k2)];
    let [r2, k2, cx, cy, dx_per_column, k1x, k1y, radius] = numbers.map(|number| number as f32);
    let [nx, ny, nz] = axis(a, b).map(|number| number as f32);
    let (r2_squared, sphere_squared) = (r2 * r2, (1.0 + r2) * (1.0 + r2));
    let mut framebuffer = vec![b' '; width * height];
    for (row, line) in framebuffer.chunks_exact_mut(width).enumerate() {
        let dy = (row as f32 + 0.5 - cy) / k1y;
        let half_width = (radius * radius - dy * dy).max(0.0).sqrt() * k1x;
        let (start, end) = ((cx - half_width) as usize, width.min((cx + half_width) as usize + 1));
        for (i, cells) in line[start..end].chunks_mut(8).enumerate() {
            let x = (start + 8 * i) as f32 + f32x8::new([0.5, 1.5, 2.5, 3.5, 4.5, 5.5, 6.5, 7.5]);
            let dx = (x - cx) * dx_per_column;
            let xy_squared = dx * dx + dy * dy;
            let uz = 1.0 / (1.0 + xy_squared).sqrt();
            let depth = k2 * uz * uz;
            let d0_squared = k2 * depth * xy_squared;
            let f0 = depth * (dx * nx + dy * ny - xy_squared * nz);
            let fu = uz * (dx * nx + dy * ny + nz);

            let m0 = d0_squared + r2_squared - 1.0;
            let p = m0 - 2.0 * r2_squared * (1.0 - fu * fu);
            let q = 4.0 * r2_squared * f0 * fu;
            let c = m0 * m0 - p * p - 4.0 * r2_squared * (d0_squared - f0 * f0);
            let mut s = -(sphere_squared - d0_squared).fast_max(f32x8::ZERO).sqrt();
            let hits = loop {
                let base = s * s + p;
                let g = base * base + (2.0 * q * s + c);
                let fall = (-2.0 * base * s - q).fast_max(f32x8::ZERO);
                let discriminant = fall * fall - 2.0 * base * g;
                let has_root = discriminant.simd_ge(f32x8::ZERO);
                let r = s + g / has_root.select(fall + discriminant.sqrt(), f32x8::ZERO);
                let goes_on = r.simd_gt(s + TOLERANCE) & r.simd_lt(f32x8::splat(f32::INFINITY));
                if !goes_on.any() {
                    break s.max(r);
                }
                s = goes_on.select(r, s);
            };
            if !hits.simd_lt(f32x8::splat(f32::INFINITY)).any() {
                continue;
            }
            let f = f0 + fu * hits;
            let p_dot_light = depth * (xy_squared - dy) - uz * (dy + 1.0) * hits;
            let n_dot_light = -(ny + nz);
            let r2_over_h = 2.0 * r2_squared / (d0_squared + hits * hits + r2_squared - 1.0);
            let luminances = (1.0 - r2_over_h) * (p_dot_light - f * n_dot_light) + f * n_dot_light;
            let luminances = (luminances + TIE_BIAS).to_array();
            for ((cell, hit), luminance) in cells.iter_mut().zip(hits.to_array()).zip(luminances) {
                if hit < f32::INFINITY {
                    *cell = glyph(luminance.into());
                }
            }
        }
    }
    framebuffer
}

/// Adds to the vector one at right angles, and so turns it by the angle whose tangent is this. It is now a
/// little too long: one step of Newton's method for 1 / sqrt, from 1, makes its length 1 again.
fn turn([cos, sin]: [f32; 2], tangent: f32) -> [f32; 2] {
    let (x, y) = (cos - tangent * sin, sin + tangent * cos);
    let scale = (3.0 - x * x - y * y) / 2.0;
    [scale * x, scale * y]
}

/// donut.c as Andy Sloane changed it in 2021, so that its loops need no sines and cosines: from one sample to
/// the next, the vector of an angle's cosine and sine is turned.
pub fn turning(view: &View, a: f64, b: f64) -> Vec<u8> {
    let &View { width, height, .. } = view;
    let numbers = [view.r2, view.k2, 1.0 + view.cx, 1.0 + view.cy, view.k1x, view.k1y];
    let [r2, k2, cx, cy, k1x, k1y] = numbers.map(|number| number as f32);
    let [(sin_a, cos_a), (sin_b, cos_b)] = [a, b].map(|angle| c_sin_cos(angle as f32));
    let (mut framebuffer, mut nearest) = (vec![b' '; width * height], vec![0.0; width * height]);
    let mut theta = [1.0, 0.0];
    for _ in 0..90 {
        let ([cos_theta, sin_theta], mut phi) = (theta, [1.0, 0.0]);
        let h = cos_theta + r2;
        for _ in 0..315 {
            let [cos_phi, sin_phi] = phi;
            let ooz = 1.0 / (sin_phi * h * sin_a + sin_theta * cos_a + k2);
            let t = sin_phi * h * cos_a - sin_theta * sin_a;
            let x = (cx + k1x * ooz * (cos_phi * h * cos_b - t * sin_b)) as usize;
            let y = (cy + k1y * ooz * (cos_phi * h * sin_b + t * cos_b)) as usize;
            let luminance = (sin_theta * sin_a - sin_phi * cos_theta * cos_a) * cos_b
                - sin_phi * cos_theta * sin_a
                - sin_theta * cos_a
                - cos_phi * cos_theta * sin_b;
            if (1..=width).contains(&x) && (1..=height).contains(&y) {
                let cell = (y - 1) * width + x - 1;
                if ooz > nearest[cell] {
                    (nearest[cell], framebuffer[cell]) = (ooz, glyph(luminance.into()));
                }
            }
            phi = turn(phi, 0.02);
        }
        theta = turn(theta, 0.07);
    }
    framebuffer
}
