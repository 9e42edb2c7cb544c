//! `exact`: every cell shows what the oracle sees at its centre.
//!
//! Most of these tests look for rays that are hard for the search in `first_hits`, whose comment explains G.
//! A ray grazes the donut if it only just touches the surface, or only just misses it. G then has a valley
//! whose bottom is next to 0.

use super::search::follow;
use super::*;
use proptest::prelude::*;
use std::f64::consts::SQRT_2;

/// R2 and K2 of a donut.
type Scene = (f64, f64);
/// The angles A and B of a donut, and dx and dy of a ray in the direction (dx, dy, 1).
type Sight = [f64; 4];

/// Random numbers that are the same in every run.
struct Random(u64);

impl Random {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        low + (high - low) * (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// R2 of the donuts with the smallest and the largest hole that the options allow.
pub const CLOSED: f64 = 1.01;
pub const OPEN: f64 = 30.0;
/// donut.c's donut, and others with small and large holes, seen from near and from afar.
const SCENES: [Scene; 8] = [
    (2.0, 5.0),
    (2.0, 3.01),
    (2.0, 1e6),
    (CLOSED, 2.02),
    (CLOSED, 5.0),
    (1.1, 50.0),
    (OPEN, 31.01),
    (OPEN, 50.0),
];

/// What `exact` sees: 8 L, or nothing. What it sees has to be on the surface.
fn look((r2, k2): Scene, [a, b, dx, dy]: Sight) -> Option<f64> {
    let torus = Torus { r2, axis: axis(a, b) };
    let rays = torus.rays(dx.into(), dy, k2);
    let (s, luminance) = follow(&torus, &rays)[0];
    if s == MISS {
        return None;
    }
    let f = rays.f0 + rays.fu * s;
    let from_ring = (rays.d0_squared + s * s - f * f).sqrt() - r2;
    let distance = (from_ring * from_ring + f * f).sqrt().to_array()[0] - 1.0;
    assert!(distance.abs() < 1e-13 * (1.0 + r2), "{distance}: R2 {r2}, {a} {b} {dx} {dy}");
    Some(8.0 * luminance)
}

/// Lets the oracle judge what `exact` sees. `rays` chooses rays at random, `count` times for each scene.
fn judge<F>(count: usize, scenes: &[Scene], rays: F) -> Tally
where
    F: Fn(&mut Random, Scene) -> Vec<Sight> + Send + 'static,
{
    let scenes = scenes.to_vec();
    in_time(move || {
        let (mut random, mut tally) = (Random(2011), Tally::default());
        for &(r2, k2) in (0..count).flat_map(|_| &scenes) {
            for [a, b, dx, dy] in rays(&mut random, (r2, k2)) {
                let drawn = look((r2, k2), [a, b, dx, dy]).map(level_of);
                let oracle = Oracle::new(r2, k2, a, b);
                let verdict = oracle.judge(dx, dy, oracle.look(dx, dy), drawn);
                tally.count(drawn.is_some(), verdict);
            }
        }
        assert_eq!(tally.wrong(), 0, "{scenes:?} {tally:?}");
        tally
    })
}

/// If `is_past` is not the same for both rays, looks for the place between them where it changes: halves
/// the interval again and again, and returns the rays in the middle.
fn bisect(from: Sight, to: Sight, is_past: impl Fn(Sight) -> bool) -> Vec<Sight> {
    let (mut low, mut high, mut middles) = (0.0, 1.0, Vec::new());
    let at_start = is_past(from);
    if is_past(to) != at_start {
        for _ in 0..60 {
            let t = (low + high) / 2.0;
            let middle = array::from_fn(|i| from[i] + t * (to[i] - from[i]));
            middles.push(middle);
            if is_past(middle) == at_start { low = t } else { high = t }
        }
    }
    middles
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
    let tally = judge(130, &SCENES, |random, (r2, k2)| {
        let radius = outline_radius(r2, k2);
        let mut within = |most: f64| random.between(-most, most);
        let (b, dy, mut rays) = (within(7.0), within(radius), Vec::new());
        // Many rays graze a donut that is nearly edge-on, or that faces the viewer nearly squarely.
        for (a, hair, reach) in [(0.0, 7.0, radius), (FRAC_PI_2, 1e-3, 0.0), (0.0, 1e-3, radius)] {
            let [from, to] = [(); 2].map(|_| [a + within(hair), b, within(reach), dy]);
            let first = look((r2, k2), from);
            let middles = bisect(from, to, |ray| differ(first, look((r2, k2), ray)));
            // From step 40 on, f64 cannot tell a hit from a miss.
            rays.extend(middles.into_iter().take(40).skip(16).step_by(4));
        }
        rays
    });
    assert!(tally.cells > 1500, "{tally:?}");
}

/// The plane f = -1 touches the tube all the way round, as a board does that lies on a swimming ring. So
/// a ray in this plane grazes the tube twice. If the ray just misses both times, the search creeps up to
/// both places, and each step only halves the distance. Such rays take many steps.
#[test]
fn rays_that_touch_the_tube_twice_are_right() {
    let tally = judge(5000, &SCENES, |random, (r2, k2)| {
        // At the angle acos(1 / K2), the viewer is in this plane.
        let mut hair = || 10_f64.powf(random.between(-16.0, -9.0));
        let (a, lean) = ((1.0 / k2).acos() - hair(), hair() - hair());
        let dx = outline_radius(r2, k2) * random.between(-1.0, 1.0);
        // A ray stays in this plane if its dy is 1 / tan A. `lean` tilts it a little out of the plane.
        vec![turned([a, random.between(0.0, 7.0), dx, a.tan().recip() + lean])]
    });
    assert!(tally.surface > 1000 && tally.ties < tally.cells / 10, "{tally:?}");
}

/// Takes a ray that was chosen for B = 0, and turns it by B with the donut, so that it meets the same points.
fn turned([a, b, dx, dy]: Sight) -> Sight {
    [a, b, dx * b.cos() - dy * b.sin(), dx * b.sin() + dy * b.cos()]
}

/// On the inner side of the tube, as where theta is between pi / 2 and pi, the surface is a saddle: it
/// bends one way round the tube, and the other way round the ring. Between these two directions there
/// is one in which the surface does not bend. A ray in this direction meets the surface three times in
/// one point, where its G, (s + w)^3 (s - 3 w), has a triple root. It is seen as a cusp of the outline. The
/// search takes many steps to it.
#[test]
fn rays_to_a_cusp_of_the_outline_are_right() {
    let tally = judge(4000, &SCENES, |random, (r2, k2)| {
        let (sin, cos) = random.between(FRAC_PI_2 + 0.05, PI - 0.05).sin_cos();
        // `across` is the part of the direction that goes round the tube. The surface bends by 1 round the
        // tube, and by cos theta / h round the ring, where h is R2 + cos theta. In this direction the two
        // cancel: across^2 + (1 - across^2) cos theta / h = 0.
        let across = (-cos / r2).sqrt();
        // At the point, s is the dot product of P and U, which is -R2 sin theta times `across`. It has to
        // be -w. There f is sin theta, so f0 is sin theta + w fu, which is sin^3 theta.
        let (f0, fu, w) = (sin.powi(3), cos * across, r2 * sin * across);
        let d0 = (r2 + cos).powi(2) + sin * sin - w * w;
        // From the viewer to P0. At the viewer s is -distance, and f is -K2 cos A.
        let distance = (k2 * k2 - d0).sqrt();
        let a = ((fu * distance - f0) / k2).acos();
        // dy follows from f0 (see `Torus::rays`), and dx from dx^2 + dy^2 = d0 / distance^2.
        let dy = -(fu * d0 + f0 * distance) / (k2 * distance * a.sin());
        let dx = (d0 / (distance * distance) - dy * dy).max(0.0).sqrt();
        let mut hair = || 10_f64.powf(random.between(-17.0, -10.0));
        let (a, dy) = (a + hair(), dy + hair());
        vec![turned([a, random.between(0.0, 7.0), dx, dy])]
    });
    assert_eq!(tally.surface, tally.cells);
    tally.assert_right();
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
