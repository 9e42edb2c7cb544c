//! `exact`: every cell shows what the oracle sees at its centre.
//!
//! Most of these tests look for rays that are hard for the search in `first_hits`, whose comment
//! explains G. A ray grazes the donut if it only just touches the surface, or only just misses it. G then has a
//! valley whose bottom is next to 0.

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
const DONUT: Scene = (2.0, 5.0);
/// donut.c's donut, and others with small and large holes, seen from near and from afar.
pub const SCENES: [Scene; 8] = [
    DONUT,
    (2.0, 3.01),
    (2.0, 1e6),
    (CLOSED, 2.02),
    (CLOSED, 5.0),
    (1.1, 50.0),
    (OPEN, 31.01),
    (OPEN, 50.0),
];

/// What `exact` sees: 8 L, or nothing. What it sees has to be on the surface, and must not depend on the rays
/// beside this one.
fn look((r2, k2): Scene, [a, b, dx, dy]: Sight) -> Option<f64> {
    let torus = Torus { r2, axis: axis(a, b) };
    let beside = array::from_fn(|i| dx + 0.1 * outline_radius(r2, k2) * i as f64);
    let [(s, luminance), ..] = look_in_row(&torus, beside, dy, k2);
    if s == MISS {
        return None;
    }
    let ray = Ray::new(&torus, dx, dy, k2);
    let f = ray.f0 + ray.fu * s;
    let h = (ray.d0_squared + s * s - f * f).sqrt();
    let distance = f64::hypot(h - torus.r2, f) - 1.0;
    assert!(distance.abs() < 1e-13 * (1.0 + torus.r2), "{distance}: R2 {}, {ray:?}", torus.r2);
    Some(8.0 * luminance)
}

/// Lets the oracle judge what `exact` sees. `rays` chooses rays at random, `count` times for each scene.
fn judge<F>(count: usize, scenes: &[Scene], rays: F) -> Tally
where
    F: Fn(&mut Random, Scene) -> Vec<Sight> + Send + 'static,
{
    let scenes = scenes.to_vec();
    within_a_minute(move || {
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
    assert_eq!(draw(Method::Exact, fitted(15, 23), 0.0, 0.0)[16 * 13 + 8], b'*');
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
}

/// This ray touches the tube 2e-14 deep, where 8 L is 8.0000012. It touches a slightly thinner tube where
/// 8 L is below 8, and misses an even thinner one.
#[test]
fn a_grazing_ray_at_a_whole_8_l_is_a_tie() {
    let (r2, k2) = (15.318159874289174, 16.34123364576848);
    let [a, b] = [1.4088894535754117, 2.62206694610734];
    let [dx, dy] = [8.702701371361806, 4.177296658253668];
    let oracle = Oracle::new(r2, k2, a, b);
    let verdict = |drawn| oracle.judge(dx, dy, oracle.look(dx, dy), drawn);
    let verdicts = [None, Some(7), Some(8), Some(6)].map(verdict);
    assert_eq!(verdicts, [Verdict::Tie, Verdict::Tie, Verdict::Right, Verdict::Shade]);
    let seen = within_a_minute(move || look((r2, k2), [a, b, dx, dy]));
    assert_ne!(verdict(seen.map(level_of)), Verdict::Shade);
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
    for view in [enlarged(1), enlarged(4)].into_iter().chain(near) {
        compare(view, &poses).assert_right();
    }
}

/// No angle A in f64 gives exactly this axis, which is upright in the picture. Here f0, fu and q are exactly
/// 0, and the two valleys of G are equal.
#[test]
fn a_ray_in_the_plane_of_the_ring_hits_the_outer_equator_or_misses() {
    for dx in [0.0_f64, 0.3] {
        let edge_on = Torus { r2: 2.0, axis: [0.0, -1.0, 0.0] };
        // The outer equator has the radius 3, and the normal (X, 0, Z) / 3. So L is -Z / 3.
        let squared = 1.0 + dx * dx;
        let z = (5.0 - (9.0 * squared - 25.0 * dx * dx).sqrt()) / squared - 5.0;
        let [(_, seen), ..] = within_a_minute(move || look_in_row(&edge_on, [dx; 8], 0.0, 5.0));
        assert!((seen - -z / 3.0).abs() < 1e-10, "{seen} {z}");
    }
    // This one misses even the bounding sphere, and never leaves the slice of it.
    let edge_on = Torus { r2: 2.0, axis: [0.0, -1.0, 0.0] };
    assert_eq!(look_in_row(&edge_on, [0.76; 8], 0.0, 5.0)[0].0, MISS);
}

#[test]
fn pictures_of_one_row_or_one_column_have_no_wrong_cell() {
    let poses = [(0.0, 0.0), (1.0, 1.0), (FRAC_PI_2, 0.0), (FRAC_PI_2, FRAC_PI_2), (1.6, 0.1)];
    for (width, height) in [(1, 1), (1, 2), (2, 1), (1, 40), (40, 1), (1, 4096), (4096, 1)] {
        for view in SCENES.map(|(r2, k2)| View::fitted(width, height, 2.0, r2, k2)) {
            assert_eq!(compare(view, &poses).wrong(), 0, "{width}x{height}");
        }
    }
    // Seen edge-on, the near side of the tube fills the only cell.
    assert_ne!(draw(Method::Exact, fitted(1, 1), FRAC_PI_2, 0.0)[3], b' ');
}

#[test]
fn the_largest_terminal_gets_the_largest_picture_and_no_z_buffer() {
    let window = Window { columns: u16::MAX, rows: u16::MAX, aspect: 2.0 };
    let mut renderer = Options::parse_from(["donut"]).renderer(Some(window), None);
    renderer.render_frame(1.0, 1.0);
    let View { width, height, .. } = renderer.view;
    assert_eq!((width - 1, height - 1), (4096, 4096));
    assert!(renderer.classic.is_none());
}

/// In a mirror image, a ray is in another lane, and beside other rays. Neither may change what it shows.
#[test]
fn a_donut_that_does_not_lean_is_its_own_mirror_image() {
    let mut views = vec![enlarged(1), enlarged(4)];
    for (width, height) in [(60, 18), (101, 30), (102, 26), (200, 61)] {
        views.extend(SCENES.map(|(r2, k2)| View::fitted(width, height, 2.0, r2, k2)));
    }
    let angles = [0.0, 1.0, FRAC_PI_2, 3.0 * FRAC_PI_2];
    for (view, a) in views.iter().flat_map(|view| angles.map(|a| (view, a))) {
        for row in draw(Method::Exact, *view, a, 0.0).chunks(view.width) {
            for column in 1..view.width {
                let mirrored = row.get((2.0 * view.cx) as usize - 1 - column).unwrap_or(&b' ');
                assert_eq!(row[column], *mirrored, "A {a}, {}x{}", view.width, view.height);
            }
        }
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
fn rays_that_lead_the_search_astray_are_right() {
    for (scene, ray) in ASTRAY {
        let tally = judge(1, &[scene], move |_, _| vec![ray]);
        assert_eq!(tally.ties, 0, "{scene:?} {ray:?}");
    }
}

/// Rays that some search got wrong.
const ASTRAY: [(Scene, Sight); 11] = [
    // 8 L is 7.5e-11 below a whole number.
    (DONUT, [1.0473961953184974, 1.6697611863666963, 0.0, 0.0]),
    // The ray passes the near side of the tube by 5e-13.
    (DONUT, [-3.1542549458682063, 3.6819074412533057, 0.0847457627118644, -0.17796610169491525]),
    // The ray passes the near side by less than f64 can tell, and clearly hits the far side.
    (
        (18.789827682516794, 20.944072142213724),
        [1.618560693465204, 0.2697105141953724, -0.20942113663545192, -0.10748736910658796],
    ),
    (
        (30.0, 39.43750749422965),
        [1.5961556168260072, -0.2896372735639008, 0.2162901639013694, -0.09092546879143666],
    ),
    // G has no inflections.
    (DONUT, [41.48, 20.74, -0.08958333333333333, 0.6541666666666667]),
    // G has a triple root, seen from near and from very far away, or almost one.
    (DONUT, [1.128556698156245, -2.255571872220948, -0.105, -0.255]),
    (
        (1.7366240459519966, 3.756153063041099),
        [1.9355622349708181, 1.5978780229975185, 0.1994349957229091, 0.3988699914458182],
    ),
    (
        (3.0, 4000.0),
        [1.1586194627339714, 6.145211166676791, 0.0005238093365520147, -6.834555477815305e-6],
    ),
    (DONUT, [1.0651313784904202, 3.0747339917003544, -0.24474357728326537, -0.032225520259920905]),
    (
        (1.01, 2.016716897357975),
        [2.3840407789078397, 0.0, 0.1502328628464559, -0.23872492911632734],
    ),
    (
        (1.01, 2.02),
        [2.341788020273717, 0.6666287167273747, 0.31304781862284786, -0.10284807914334286],
    ),
];

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
            let (w, h) = (1.0 + width as f64, 1.0 + height as f64);
            for (a, b) in donut_c_poses(12) {
                for n in (0..=100).map(|n| f64::from(n) / 100.0) {
                    let (x, y) = (n * w, n * h);
                    for (x, y) in [(0.999, y), (w + 0.001, y), (x, 0.999), (x, h + 0.001)] {
                        assert!(!sees(a, b, x, y), "{width}x{height}");
                    }
                }
            }
            // Seen edge-on, lying or upright, the donut reaches two edges of the picture.
            let inside = 1.0 + 0.001 * (w + h);
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
    // A case that fails is printed, not kept, and not shrunk: if the search hangs, each try takes a minute.
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
