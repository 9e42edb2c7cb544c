//! `exact` for one ray, in plain numbers and with plain branches, as a textbook would have it: the
//! reference for eight rays side by side. Its formulas are the program's, which explains them, in the same
//! order, so each of its numbers is the one in a lane, bit for bit.

use super::exact::{CLOSED, OPEN, SCENES};
use super::*;

/// A ray and its quartic.
#[derive(Clone, Copy, Debug, Default)]
pub struct Ray {
    pub d0_squared: f64,
    pub f0: f64,
    pub fu: f64,
    light0: f64,
    light_u: f64,
    pub p: f64,
    pub q: f64,
    pub c: f64,
}

impl Ray {
    pub fn new(torus: &Torus, dx: f64, dy: f64, k2: f64) -> Ray {
        let [nx, ny, nz] = torus.axis;
        let xy_squared = dx * dx + dy * dy;
        let uz = 1.0 / (1.0 + xy_squared).sqrt();
        let depth = k2 * uz * uz;
        Ray {
            light0: depth * (xy_squared - dy),
            light_u: -uz * (dy + 1.0),
            ..Ray::from_numbers(
                torus.r2,
                k2 * depth * xy_squared,
                depth * (dx * nx + dy * ny - xy_squared * nz),
                uz * (dx * nx + dy * ny + nz),
            )
        }
    }

    /// A ray with these numbers, without those for the luminance.
    fn from_numbers(r2: f64, d0_squared: f64, f0: f64, fu: f64) -> Ray {
        let r2_squared = r2 * r2;
        let m0 = d0_squared + r2_squared - 1.0;
        let p = m0 - 2.0 * r2_squared * (1.0 - fu * fu);
        let q = 4.0 * r2_squared * f0 * fu;
        let c = m0 * m0 - p * p - 4.0 * r2_squared * (d0_squared - f0 * f0);
        Ray { d0_squared, f0, fu, ..Ray::from_quartic(p, q, c) }
    }

    fn from_quartic(p: f64, q: f64, c: f64) -> Ray {
        Ray { p, q, c, ..Ray::default() }
    }

    pub fn entry(&self, r2: f64) -> f64 {
        let sphere_radius = 1.0 + r2;
        let sphere_entry = -(sphere_radius * sphere_radius - self.d0_squared).max(0.0).sqrt();
        let plane = if self.fu.is_sign_negative() { 1.0 } else { -1.0 };
        sphere_entry.max((plane - self.f0) / self.fu)
    }

    pub fn first_hit(&self, entry: f64) -> f64 {
        let mut s = entry;
        loop {
            let r = self.step(s);
            if r.is_nan() || r <= s + TOLERANCE {
                return s.max(r);
            }
            s = r;
        }
    }

    /// Where the search steps to from s. If that is not to the right of s, the search is at its end.
    fn step(&self, s: f64) -> f64 {
        let (g, fall, base) = self.parabola(s);
        s + g / (fall + (fall * fall - 2.0 * base * g).sqrt()).max(0.0)
    }

    /// The numbers of the parabola at s, which is g - 2 fall t + 2 base t^2.
    fn parabola(&self, s: f64) -> (f64, f64, f64) {
        let &Ray { p, q, c, .. } = self;
        let base = s * s + p;
        (base * base + (2.0 * q * s + c), (-2.0 * base * s - q).max(0.0), base)
    }

    fn luminance(&self, torus: &Torus, s: f64) -> f64 {
        let r2_squared = torus.r2 * torus.r2;
        let f = self.f0 + self.fu * s;
        let p_dot_light = self.light0 + self.light_u * s;
        let n_dot_light = -(torus.axis[1] + torus.axis[2]);
        let r2_over_h = 2.0 * r2_squared / (self.d0_squared + s * s + r2_squared - 1.0);
        (1.0 - r2_over_h) * (p_dot_light - f * n_dot_light) + f * n_dot_light
    }
}

/// Draws as `exact` does, but one ray after another. `hit` finds the s of a ray's first hit.
pub fn trace_one_by_one(view: &View, a: f64, b: f64, hit: impl Fn(&Torus, &Ray) -> f64) -> Vec<u8> {
    let torus = Torus { r2: view.r2, axis: axis(a, b) };
    let mut framebuffer = vec![b' '; view.width * view.height];
    // Rays outside the outline miss. This only saves time, so it need not be exact.
    let reach = 1.001 * outline_radius(view.r2, view.k2).powi(2);
    for (row, line) in framebuffer.chunks_exact_mut(view.width).enumerate().skip(1) {
        for (column, cell) in line.iter_mut().enumerate().skip(1) {
            let (dx, dy) = direction(view, column as f64 + 0.5, row as f64 + 0.5);
            if dx * dx + dy * dy < reach {
                let ray = Ray::new(&torus, dx, dy, view.k2);
                let s = hit(&torus, &ray);
                if s < MISS {
                    *cell = glyph(ray.luminance(&torus, s) + TIE_BIAS);
                }
            }
        }
    }
    framebuffer
}

/// The first hits of eight rays, side by side. `alone` has each of the rays, and its entry. The hit must be
/// the same when the ray is followed alone, bit for bit.
#[track_caller]
fn first_hits(quartic: &Quartic, entry: f64x8, alone: [(Ray, f64); 8]) -> f64x8 {
    let hits = quartic.first_hits(entry);
    for (s, (ray, entry)) in hits.to_array().into_iter().zip(alone) {
        let expected = ray.first_hit(entry);
        assert_eq!(s, expected, "{ray:?}, entry {entry}");
    }
    hits
}

/// The s of the first hits of eight rays, side by side, and the luminances there. Both must be the same when
/// each ray is followed alone, bit for bit.
#[track_caller]
fn follow(torus: &Torus, rays: &Rays, alone: [Ray; 8]) -> [(f64, f64); 8] {
    let with_entry = alone.map(|ray| (ray, ray.entry(torus.r2)));
    let hits = first_hits(&Quartic::new(torus.r2, rays), torus.entry(rays), with_entry);
    let (s, luminances) = (hits.to_array(), torus.luminance(rays, hits).to_array());
    array::from_fn(|i| {
        let expected = alone[i].luminance(torus, s[i]);
        assert!(s[i] == MISS || luminances[i].to_bits() == expected.to_bits(), "{:?}", alone[i]);
        (s[i], luminances[i])
    })
}

/// The same for the rays from the viewer in the directions (dx, dy, 1).
#[track_caller]
pub fn look_in_row(torus: &Torus, dx: [f64; 8], dy: f64, k2: f64) -> [(f64, f64); 8] {
    let alone = dx.map(|dx| Ray::new(torus, dx, dy, k2));
    follow(torus, &torus.rays(f64x8::new(dx), dy, k2), alone)
}

#[test]
fn every_ray_of_a_picture_is_as_if_it_were_alone() {
    let mut views = vec![View::DONUT_C, enlarged(2)];
    for (width, height) in [(1, 40), (9, 1), (60, 18), (101, 30), (200, 61)] {
        views.extend(SCENES.map(|(r2, k2)| View::fitted(width, height, 2.0, r2, k2)));
    }
    let poses = [(0.0, 0.0), (FRAC_PI_2, 0.0), (FRAC_PI_2, 0.7), (1.0, 0.5), (-1000.0, 123.4)];
    for (view, (a, b)) in views.into_iter().flat_map(|view| poses.map(|pose| (view, pose))) {
        let picture = within_a_minute(move || {
            let torus = Torus { r2: view.r2, axis: axis(a, b) };
            for y in (0..view.height).map(|row| row as f64 + 0.5) {
                for column in (0..view.width).step_by(8) {
                    let eight = array::from_fn(|i| direction(&view, (column + i) as f64 + 0.5, y));
                    look_in_row(&torus, eight.map(|(dx, _)| dx), eight[0].1, view.k2);
                }
            }
            trace_one_by_one(&view, a, b, |torus, ray| ray.first_hit(ray.entry(torus.r2)))
        });
        assert!(draw(Method::Exact, view, a, b) == picture, "A {a}, B {b}");
    }
}

/// If fu is 0, a ray stays at the distance f0 from the plane of the ring. At this distance, the surface is
/// two circles round the axis, and the ray hits the outer one or misses. It grazes if f0 is 1 or -1.
#[test]
fn rays_parallel_to_the_plane_of_the_ring_are_right() {
    let heights = [0.0, 0.5, 1.0_f64.next_down(), 1.0, 1.0_f64.next_up(), 1.5].into_iter();
    let heights = heights.flat_map(|f0| [f0, -f0]);
    for (f0, fu) in heights.flat_map(|f0| [0.0, -0.0].map(|fu| (f0, fu))) {
        for r2 in [CLOSED, 2.0, OPEN] {
            // How far the rays pass from the axis.
            let distances =
                [0.0, 0.1, 0.3, 0.5, 0.66, 0.9, 0.95, 1.1].map(|part| part * (1.0 + r2));
            let alone = distances.map(|d| Ray::from_numbers(r2, d * d + f0 * f0, f0, fu));
            let rays = Rays {
                d0_squared: f64x8::new(alone.map(|ray| ray.d0_squared)),
                f0: f64x8::splat(f0),
                fu: f64x8::splat(fu),
                light0: f64x8::ZERO,
                light_u: f64x8::ZERO,
            };
            let torus = Torus { r2, axis: axis(0.0, 0.0) };
            let seen = within_a_minute(move || follow(&torus, &rays, alone));
            for ((s, _), distance) in seen.into_iter().zip(distances) {
                // A square root is NaN if the ray misses.
                let outer = r2 + (1.0 - f0 * f0).sqrt();
                let expected = -(outer * outer - distance * distance).sqrt();
                let is_graze = (f0.abs() - 1.0).abs() < 1e-14;
                let is_right = (s - expected).abs() < 1e-6 || s == MISS && expected.is_nan();
                assert!(is_right || is_graze, "{s}, not {expected}: f0 {f0}, fu {fu}, R2 {r2}");
            }
        }
    }
}

/// Where these lines pass the tube for the first time, they miss it by less than f64 can tell, and G rises
/// slowly from almost 0. The step from there must not cancel: the search would leap over the second place.
#[test]
fn a_line_that_just_misses_the_near_side_of_the_tube_hits_the_far_side() {
    for (r2, d0_squared, f0, fu, hit) in [
        (2.0, 1.0718191465525035, 0.9999999809072501, -9.63324823695471e-9, 1.98168501033904),
        (30.0, 675.6470912791639, -0.9999991331709889, 5.774333715030304e-8, 15.00803755688958),
    ] {
        let ray = Ray::from_numbers(r2, d0_squared, f0, fu);
        let s = first_hits_of_one(ray, ray.entry(r2));
        assert!((s - hit).abs() < 1e-9, "{s}, not {hit}");
    }
}

/// A line that is almost parallel to the plane of the ring enters the slice where |s| is huge.
#[test]
fn a_search_that_overflows_is_a_miss() {
    let line =
        Ray::from_numbers(2.0, 4.478644161237842, -1.2537824909170252, 1.3459194245119975e-52);
    assert_eq!(first_hits_of_one(line, line.entry(2.0)), MISS);
    for entry in [1e70, 1e100, 1e200, f64::INFINITY] {
        for q in [-3.0, 0.0, 3.0] {
            assert_eq!(first_hits_of_one(Ray::from_quartic(-1.0, q, 2.0), entry), MISS, "{entry}");
        }
    }
}

/// Quartics with two factors, (s^2 - 2 u s + u^2 - i) (s^2 + 2 u s + u^2 - j), and their real roots in order.
/// The roots are integers, so f64 computes each G without rounding, and some of them are multiple ones.
fn quartics() -> impl Iterator<Item = (Ray, Vec<f64>)> {
    let squares = [-9.0, -4.0, -1.0, 0.0, 1.0, 4.0, 9.0, 16.0, 25.0];
    let numbers = (-5..=5).map(f64::from).flat_map(move |u| squares.map(|i| (u, i)));
    numbers.flat_map(move |(u, i)| squares.map(|j| (u, i, j))).map(|(u, i, j): (f64, f64, f64)| {
        let (m, n) = (u * u - i, u * u - j);
        let p = (m + n) / 2.0 - 2.0 * u * u;
        let roots = [u - i.sqrt(), u + i.sqrt(), -u - j.sqrt(), -u + j.sqrt()];
        let mut roots: Vec<_> = roots.into_iter().filter(|root| !root.is_nan()).collect();
        roots.sort_by(f64::total_cmp);
        (Ray::from_quartic(p, u * (m - n), m * n - p * p), roots)
    })
}

#[test]
fn the_parabola_is_nowhere_above_g_and_differs_from_it_by_a_square_where_g_falls() {
    for (ray, _) in quartics() {
        for s in (-40..=40).map(|s| 0.5 * f64::from(s)) {
            let (g, fall, base) = ray.parabola(s);
            for t in (0..=80).map(|t| 0.5 * f64::from(t)) {
                let above = ray.parabola(s + t).0 - (g - 2.0 * fall * t + 2.0 * base * t * t);
                let w = 2.0 * s * t + t * t;
                assert!(above == w * w || fall == 0.0 && above > w * w, "{ray:?}, s {s}, t {t}");
            }
        }
    }
}

#[test]
fn no_step_passes_a_root_and_every_search_ends_at_the_next_one() {
    for (ray, roots) in quartics() {
        for entry in (-60..=20).map(|entry| 0.5 * f64::from(entry) + 0.125) {
            // Inside the donut, no search starts.
            if ray.parabola(entry).0 < 0.0 {
                continue;
            }
            // At a root of an even multiplicity, G turns back, which rounding may hide.
            let multiplicity = |root: f64| roots.iter().filter(|&&other| other == root).count();
            let mut ahead: Vec<_> = roots.iter().copied().filter(|&root| root >= entry).collect();
            ahead.push(MISS);
            let last = ahead
                .iter()
                .position(|&root| multiplicity(root) % 2 == 1)
                .unwrap_or(ahead.len() - 1);
            let (mut s, mut r) = (entry, ray.step(entry));
            while r > s + TOLERANCE {
                assert!(r <= ahead[last] + 1e-7, "{ray:?}: from {s} to {r} passes {ahead:?}");
                (s, r) = (r, ray.step(r));
            }
            let hit = first_hits_of_one(ray, entry);
            let error = |root| if multiplicity(root) > 1 { 1e-4 } else { 1e-12 };
            let is_at = |root: f64| hit == root || (hit - root).abs() < error(root);
            assert!(
                ahead[..=last].iter().any(|&root| is_at(root)),
                "{ray:?}: {hit}, not {ahead:?}"
            );
        }
    }
}

/// The first hit of a line, found in each lane, and alone.
fn first_hits_of_one(ray: Ray, entry: f64) -> f64 {
    let quartic = Quartic { p: ray.p.into(), q: ray.q.into(), c: ray.c.into() };
    first_hits(&quartic, entry.into(), [(ray, entry); 8]).to_array()[0]
}

#[test]
fn hits_in_the_most_special_places_are_found() {
    // p, q and c; the entry; and the first hit.
    let cases = [
        // G does not fall at the entry, and base is 1 or 0; or G neither falls nor rises.
        ([0.0, 0.0, 3.0], 1.0, MISS),
        ([-1.0, 1.0, 3.0], 1.0, MISS),
        ([-1.0, 0.0, 3.0], 1.0, MISS),
        // G rises at the entry, and falls later.
        ([-2.0, 0.0, -0.5], -1.0, (2.0 - 0.5_f64.sqrt()).sqrt()),
        // The parabola has no root, although base is positive and G falls.
        ([3.0, 0.0, 0.0], -1.0, MISS),
        ([-3.0, 4.0, 20.0], -2.0, MISS),
        // The entry is the hit, or next to it.
        ([1.0, -1.0, -6.0], -1.0, -1.0),
        ([1.0, -1.0, -6.0], (-1.0_f64).next_up(), -1.0),
        ([1.0, -1.0, -6.0], (-1.0_f64).next_down(), -1.0),
        // G is 0 at the entry, and rises there, or neither falls nor rises.
        ([-1.0, 1.0, -2.0], 1.0, 1.0),
        ([-1.0, 0.0, 0.0], 1.0, 1.0),
        // (s + 1)^3 (s - 3), and s^4.
        ([-3.0, -4.0, -12.0], -5.0, -1.0),
        ([-3.0, -4.0, -12.0], -1.0, -1.0),
        ([0.0, 0.0, 0.0], -3.0, 0.0),
    ];
    // Each case comes into each lane.
    for first in 0..cases.len() {
        let eight = array::from_fn::<_, 8, _>(|i| cases[(first + i) % cases.len()]);
        let alone = eight.map(|([p, q, c], entry, _)| (Ray::from_quartic(p, q, c), entry));
        let lanes = |number: fn(&Ray) -> f64| f64x8::new(alone.map(|(ray, _)| number(&ray)));
        let quartic =
            Quartic { p: lanes(|ray| ray.p), q: lanes(|ray| ray.q), c: lanes(|ray| ray.c) };
        let entry = f64x8::new(alone.map(|(_, entry)| entry));
        let hits = within_a_minute(move || first_hits(&quartic, entry, alone));
        for (s, case) in hits.to_array().into_iter().zip(eight) {
            assert!(s == case.2 || (s - case.2).abs() < 1e-4, "{s}: {case:?}");
        }
    }
}
