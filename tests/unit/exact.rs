//! `exact`: every cell shows what the oracle sees at its centre.
//!
//! A ray grazes the donut if it only just touches the surface, or only just misses it. Such rays are hard for
//! the search in `first_hits`, whose comment explains G: it has a valley whose bottom is next to 0.

use super::*;
use proptest::prelude::*;
use std::f64::consts::SQRT_2;

/// R2 of the donuts with the smallest and the largest hole that the options allow.
const CLOSED: f64 = 1.01;
const OPEN: f64 = 30.0;
/// R2 and K2 of donut.c's donut, and of others with small and large holes, seen from near and from afar.
const SCENES: [(f64, f64); 8] = [
    (2.0, 5.0),
    (2.0, 3.01),
    (2.0, 1e6),
    (CLOSED, 2.02),
    (CLOSED, 5.0),
    (1.1, 50.0),
    (OPEN, 31.01),
    (OPEN, 50.0),
];

/// What `exact` sees of a donut with the angles A and B, by a ray in the direction (dx, dy, 1): 8 L, or
/// nothing. What it sees has to be on the surface.
fn look((r2, k2): (f64, f64), [a, b, dx, dy]: [f64; 4]) -> Option<f64> {
    let torus = Torus { r2, axis: axis(a, b) };
    let rays = torus.rays(dx.into(), dy, k2);
    let s = torus.quartic(&rays).first_hits(torus.entry(&rays));
    if s.to_array()[0] == MISS {
        return None;
    }
    let f = rays.f0 + rays.fu * s;
    let from_ring = (rays.d0_squared + s * s - f * f).sqrt() - r2;
    let distance = (from_ring * from_ring + f * f).sqrt().to_array()[0] - 1.0;
    assert!(distance.abs() < 1e-13 * (1.0 + r2), "{distance}: R2 {r2}, {a} {b} {dx} {dy}");
    Some(8.0 * torus.luminance(&rays, s).to_array()[0])
}

#[test]
fn of_two_glyphs_that_rounding_allows_the_brighter_is_drawn() {
    assert_eq!(draw(Method::Exact, fitted(15, 23), 0.0, 0.0)[15 * 12 + 7], b'*');
    let (oracle, mut ties) = (Oracle::new(2.0, 5.0, 0.0, 0.0), 0);
    for (width, height) in (1..=60).flat_map(|width| (1..=40).map(move |height| (width, height))) {
        let view = fitted(width, height);
        let framebuffer = draw(Method::Exact, view, 0.0, 0.0);
        for (cell, _, light) in cells(&view, &oracle) {
            let light = light.unwrap_or(0.5);
            if light > 0.5 && (light - light.round()).abs() < 1e-12 {
                let drawn = level(framebuffer[cell]);
                assert_eq!(drawn, Some(light.round() as usize), "{width}x{height} {cell}");
                ties += 1;
            }
        }
    }
    assert!(ties > 100, "{ties}");
    // In the only cell of this picture, 8 L is 7.5e-11 below a whole number, which is not a tie.
    compare(fitted(1, 1), &[(1.0473961953184974, 1.6697611863666963)]).assert_right();
}

#[test]
fn no_luminance_has_a_glyph_beyond_the_ramp() {
    for level in 0..=u8::MAX {
        assert_eq!(glyph(f64::from(level) / 8.0), RAMP[usize::from(level).min(11)], "{level}");
    }
    assert_eq!([f64::NAN, f64::NEG_INFINITY, -SQRT_2].map(glyph), *b"...");
    assert_eq!([SQRT_2, 1e300, f64::INFINITY].map(glyph), *b"@@@");
}

#[test]
fn a_donut_seen_edge_on_or_nearly_so_has_no_wrong_cell() {
    let hairs = (3..=12).map(|exponent| 10_f64.powi(-exponent));
    let angles = hairs.flat_map(|hair| [FRAC_PI_2 + hair, FRAC_PI_2 - hair]).chain([FRAC_PI_2]);
    let poses: Vec<_> = angles.flat_map(|a| [0.0, FRAC_PI_2, 0.7].map(|b| (a, b))).collect();
    // As near as the options allow.
    let near = [(CLOSED, 2.02), (2.0, 3.01), (OPEN, 31.01)];
    let near = near.map(|(r2, k2)| View::fitted(160, 44, 2.0, r2, k2));
    // The middle row of a large picture, from edge to edge.
    let row = View { height: 1, cy: 0.5, ..fitted(4000, 2000) };
    for view in [enlarged(1), enlarged(4), row].into_iter().chain(near) {
        compare(view, &poses).assert_right();
    }
}

/// Between a ray that hits and one that misses, or hits somewhere else, there is a ray that grazes.
#[test]
fn rays_between_a_hit_and_a_miss_are_right() {
    let tally = in_time(|| {
        let (mut seed, mut tally) = (2011_u64, Tally::default());
        // A random number between -most and most, which is the same in every run.
        let mut within = |most: f64| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            most * (seed as i64 >> 11) as f64 / 2_f64.powi(52)
        };
        for (r2, k2) in (0..130).flat_map(|_| SCENES) {
            let radius = outline_radius(r2, k2);
            let (b, dy) = (within(7.0), within(radius));
            // Many rays graze a donut that is nearly edge-on, or that faces the viewer nearly squarely.
            let kinds = [(0.0, 7.0, radius), (FRAC_PI_2, 1e-3, 0.0), (0.0, 1e-3, radius)];
            for (a, hair, reach) in kinds {
                let [from, to] = [(); 2].map(|_| [a + within(hair), b, within(reach), dy]);
                let first = look((r2, k2), from);
                let is_past = |ray| differ(first, look((r2, k2), ray));
                let (mut low, mut high) = (0.0, 1.0);
                // After 40 halves, f64 cannot tell a hit from a miss.
                for n in 0..if is_past(to) { 40 } else { 0 } {
                    let t = (low + high) / 2.0;
                    let ray = array::from_fn(|i| from[i] + t * (to[i] - from[i]));
                    [low, high] = if is_past(ray) { [low, t] } else { [t, high] };
                    if n >= 16 && n % 4 == 0 {
                        let ([a, b, dx, dy], drawn) = (ray, look((r2, k2), ray).map(level_of));
                        let oracle = Oracle::new(r2, k2, a, b);
                        let verdict = oracle.judge(dx, dy, oracle.look(dx, dy), drawn);
                        tally.count(drawn.is_some(), verdict);
                    }
                }
            }
        }
        tally
    });
    assert!(tally.wrong() == 0 && tally.cells > 1500, "{tally:?}");
}

#[test]
fn the_donut_is_as_large_as_it_can_be_uncut() {
    let shapes = [(2.0, 2.0, 6.0), (5.0, 2.0, 3.01), (0.25, CLOSED, 50.0), (2.0, OPEN, 100.0)];
    for (aspect, r2, k2) in shapes {
        for (width, height) in [(1, 1), (2, 8), (79, 22), (80, 22), (300, 20), (30, 90)] {
            let view = View::fitted(width, height, aspect, r2, k2);
            let sees = |a, b, x, y| {
                let (dx, dy) = direction(&view, x, y);
                Oracle::new(r2, k2, a, b).look(dx, dy).is_some()
            };
            // No ray just outside the picture hits the donut.
            let (w, h) = (width as f64, height as f64);
            for (a, b) in donut_c_poses(12) {
                for n in (0..=100).map(|n| f64::from(n) / 100.0) {
                    let (x, y) = (n * w, n * h);
                    for (x, y) in [(-0.001, y), (w + 0.001, y), (x, -0.001), (x, h + 0.001)] {
                        assert!(!sees(a, b, x, y), "{width}x{height}");
                    }
                }
            }
            // Seen edge-on, lying or upright, the donut reaches two edges of the picture.
            let inside = 0.001 * (w + h);
            let lying = sees(FRAC_PI_2, 0.0, inside, view.cy);
            let upright = sees(FRAC_PI_2, FRAC_PI_2, view.cx, inside);
            assert!(lying || upright, "{width}x{height}");
        }
    }
}

/// Any angle, or one at which the donut nearly faces the viewer or is nearly edge-on.
fn angle() -> impl Strategy<Value = f64> {
    let hair = (-6.0..-1.0_f64).prop_map(|exponent| 10_f64.powf(exponent));
    let near = (-8..=8, hair).prop_map(|(n, hair)| f64::from(n) * FRAC_PI_2 + hair);
    prop_oneof![ANGLES, near]
}

proptest! {
    // A case that fails is printed, not kept, and not shrunk: if the search hangs, a try takes ten minutes.
    #![proptest_config(ProptestConfig {
        failure_persistence: None, max_shrink_iters: 0, ..ProptestConfig::with_cases(1000)
    })]

    /// The ranges are those of the options, but the pictures are smaller: the oracle takes its time.
    #[test]
    fn small_pictures_are_right_with_any_options(
        (width, height) in (1_usize..=70, 1_usize..=40),
        aspect in 0.1..=10.0,
        (a, b) in (angle(), angle()),
        // `gap` is the viewer's distance from the bounding sphere.
        r2 in (-2.0..=29_f64.log10()).prop_map(|exponent| 1.0 + 10_f64.powf(exponent)),
        gap in (-2.0..=6.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
    ) {
        let k2 = f64::min(1e6, 1.0 + r2 + gap);
        let view = View::fitted(width, height, aspect, r2, k2);
        let tally = compare(view, &[(a, b)]);
        prop_assert_eq!(tally.wrong(), 0, "{:?}", tally);
    }
}
