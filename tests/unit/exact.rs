//! `exact`: every cell shows what the oracle sees at its centre.
//!
//! Along a ray, the quartic G falls and rises once or twice: it has one valley, or a left and a right
//! one. The ray hits the donut where G first falls to 0.

use super::*;
use oracle::dot;
use proptest::prelude::*;
use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, SQRT_2};

/// Numbers in 0..1 that are the same in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 =
            self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }
}

/// R2 of a donut that is as nearly closed as the options allow.
const CLOSED: f64 = 1.001;

/// What `exact` sees along (dx, dy, 1): 8 L, or nothing.
fn look(torus: &Torus, k2: f64, dx: f64, dy: f64) -> Option<f64> {
    let rays = torus.rays([dx; LANES], dy, k2);
    let hits = torus.first_hits(&rays);
    assert!(hits.iter().all(|s| !s.is_nan()));
    (hits[0] < MISS).then(|| 8.0 * torus.luminance(&rays, 0, hits[0]))
}

/// What it sees of donut.c's donut, turned by A and B.
fn look_at(a: f64, b: f64, dx: f64, dy: f64) -> Option<f64> {
    look(&Torus::new(2.0, a, b), 5.0, dx, dy)
}

/// Draws the donut at these angles A and B, and compares every cell with the oracle.
fn compare(view: View, poses: &[(f64, f64)]) -> Tally {
    let mut renderer = Renderer::new(view, Method::Exact, RAMP);
    let mut tally = Tally::default();
    for &(a, b) in poses {
        renderer.render_frame(a, b);
        tally.add(&oracle_of(&view, a, b), &view, &renderer.framebuffer);
    }
    tally
}

#[test]
fn a_million_random_rays_see_what_the_oracle_sees() {
    let mut random = Random(2006);
    let mut tally = Tally::default();
    for _ in 0..1000 {
        let (a, b) = (random.between(-10.0, 10.0), random.between(-10.0, 10.0));
        let oracle = Oracle::new(1.0, 2.0, 5.0, a, b);
        for _ in 0..1000 {
            // Up to just beyond the donut, which ends at 0.75 at the latest.
            let (dx, dy) = (random.between(-0.76, 0.76), random.between(-0.76, 0.76));
            let seen = look_at(a, b, dx, dy);
            let drawn = seen.map(|luminance| luminance.max(0.0) as usize);
            tally.surface += usize::from(drawn.is_some());
            tally.count(oracle.judge(dx, dy, drawn));
        }
    }
    tally.assert_right();
}

#[test]
fn sixty_poses_at_six_sizes_have_no_wrong_cell() {
    for (width, height) in [(40, 12), (80, 22), (100, 37), (132, 43), (160, 44), (320, 88)] {
        compare(fitted(width, height), &own_poses(60)).assert_right();
    }
}

#[test]
fn cells_where_other_methods_fail_are_right() {
    // A frame of donut.c at 80x22, a cell's column and row, and the level there, if not blank.
    let cells = [
        (0, 33, 2, None),      // inked by a splat, which any touch of the cell inks
        (0, 33, 7, Some(3)),   // 5 with a splat, whose nearest sample is at the cell's edge
        (0, 38, 2, Some(11)),  // blank with 16 steps of sphere tracing, which graze on
        (6, 24, 5, None),      // inked by sphere tracing, which passes within its tolerance
        (53, 41, 13, Some(0)), // 4 with sphere tracing, which stops on the near outline
        (0, 36, 9, Some(0)),   // blank with 12 Newton steps on the distance, not convex in the hole
        (38, 32, 9, Some(7)),  // 5 with Ferrari's formula in f32, nearly biquadratic
        (39, 32, 8, Some(8)),  // 0 with Ferrari's formula polished: a bad root gets worse
        (9, 39, 6, Some(1)),   // a hole with Ferrari's formula in f32
        (38, 54, 19, Some(1)), // 2 with a closed form that switches at fixed thresholds
    ];
    for (frame, column, row, expected) in cells {
        let (a, b) = (0.04 * f64::from(frame), 0.02 * f64::from(frame));
        let framebuffer = draw(Method::Exact, View::DONUT_C, a, b);
        let drawn = level(framebuffer[80 * row + column]);
        let (dx, dy) = direction(&View::DONUT_C, column as f64 + 0.5, row as f64 + 0.5);
        let verdict = Oracle::new(1.0, 2.0, 5.0, a, b).judge(dx, dy, drawn);
        assert_eq!((drawn, verdict), (expected, Verdict::Right), "frame {frame} ({column}, {row})");
    }
}

#[test]
fn a_luminance_on_the_border_of_two_glyphs_falls_on_the_right_side() {
    let (column, row) = (298, 174);
    let framebuffer = draw(Method::Exact, enlarged(8), 41.48, 20.74);
    assert_eq!(level(framebuffer[640 * row + column]), Some(1));
}

#[test]
fn glyphs_next_to_a_step_and_rays_that_graze_are_right() {
    // 8 L is 7.5e-11 below a whole number; a ray passes the near side of the tube by 5e-13.
    for (width, height, a, b, cell, expected) in [
        (82, 22, 1.0473961953184974, 1.6697611863666963, (41, 11), Some(0)),
        (178, 109, -3.1542549458682063, 3.6819074412533057, (99, 44), None),
    ] {
        let view = fitted(width, height);
        let framebuffer = draw(Method::Exact, view, a, b);
        let drawn = level(framebuffer[width * cell.1 + cell.0]);
        let (dx, dy) = direction(&view, cell.0 as f64 + 0.5, cell.1 as f64 + 0.5);
        let verdict = oracle_of(&view, a, b).judge(dx, dy, drawn);
        println!("{:?}", oracle_of(&view, a, b).look(dx, dy));
        assert_eq!((drawn, verdict), (expected, Verdict::Right), "{width}x{height}");
    }
}

#[test]
fn a_luminance_that_is_a_whole_number_of_glyphs_never_falls_below_it() {
    let framebuffer = draw(Method::Exact, fitted(16, 24), 0.0, 0.0);
    assert_eq!(framebuffer[16 * 13 + 8], b'*');
    let (oracle, mut ties) = (Oracle::new(1.0, 2.0, 5.0, 0.0, 0.0), 0);
    for (width, height) in (2..=60).flat_map(|width| (2..=40).map(move |height| (width, height))) {
        let view = fitted(width, height);
        let framebuffer = draw(Method::Exact, view, 0.0, 0.0);
        for (row, column) in (1..height).flat_map(|row| (1..width).map(move |x| (row, x))) {
            let (dx, dy) = direction(&view, column as f64 + 0.5, row as f64 + 0.5);
            let light = oracle.look(dx, dy).unwrap_or(0.5);
            if light > 0.5 && (light - light.round()).abs() < 1e-12 {
                let drawn = level(framebuffer[row * width + column]);
                assert_eq!(drawn, Some(light.round() as usize), "{width}x{height} {column}, {row}");
                ties += 1;
            }
        }
    }
    assert!(ties > 100, "{ties}");
}

#[test]
fn no_luminance_has_a_glyph_beyond_the_ramp() {
    for level in 0..=u8::MAX {
        let expected = if level < 12 { RAMP[usize::from(level)] } else { b'@' };
        assert_eq!(glyph(RAMP, f64::from(level) / 8.0), expected, "{level}");
    }
    for (luminance, expected) in [
        (f64::NAN, b'.'),
        (f64::NEG_INFINITY, b'.'),
        (-SQRT_2, b'.'),
        (SQRT_2, b'@'),
        (1e300, b'@'),
        (f64::INFINITY, b'@'),
    ] {
        assert_eq!(glyph(RAMP, luminance), expected, "{luminance}");
    }
}

#[test]
fn a_flat_left_valley_does_not_hide_the_right_one() {
    // The left valley has no root, and its bottom is so flat that a Newton step from there jumps far
    // beyond the right valley.
    let (a, b) = (4.309330, 2.323927);
    let (dx, dy) = direction(&enlarged(15), 482.225, 170.230);
    let seen = look_at(a, b, dx, dy).expect("a hit");
    let truth = Oracle::new(1.0, 2.0, 5.0, a, b).look(dx, dy).unwrap();
    assert!((seen - truth).abs() < 1e-9, "{seen} {truth}");
}

#[test]
fn edge_on_and_a_hair_off_it_no_cell_is_wrong() {
    for view in [enlarged(1), enlarged(4)] {
        let mut poses = vec![(FRAC_PI_2, 0.0)];
        for exponent in [3, 4, 5, 6, 7, 8, 9, 10, 11, 12] {
            let hair = 10_f64.powi(-exponent);
            for b in [0.0, FRAC_PI_2, 0.7] {
                poses.extend([(FRAC_PI_2 + hair, b), (FRAC_PI_2 - hair, b)]);
            }
        }
        compare(view, &poses).assert_right();
    }
}

#[test]
fn multiples_of_an_eighth_turn_have_no_wrong_cell() {
    let turns = |n: usize| ((n / 8) as f64 * FRAC_PI_4, (n % 8) as f64 * FRAC_PI_4);
    let poses: Vec<_> = (0..64).map(turns).collect();
    compare(View::DONUT_C, &poses).assert_right();
    compare(fitted(101, 30), &poses).assert_right();
}

/// A torus whose axis is exactly upright in the picture. No angle A that is a float makes it so.
fn edge_on() -> Torus {
    Torus { r2: 2.0, axis: [0.0, -1.0, 0.0] }
}

#[test]
fn a_ray_in_the_plane_of_the_ring_hits_the_outer_equator() {
    // Here z0, uz and q are exactly 0, and the two valleys of G are equal. The outer equator is a
    // circle of radius 3. Its normal at (X, 0, Z) is (X, 0, Z) / 3, so that 8 L is -8 Z / 3.
    for dx in [0.0_f64, 0.3] {
        let length = (1.0 + dx * dx).sqrt();
        let (along, aside) = (5.0 / length, 5.0 * dx / length);
        let way = along - (9.0 - aside * aside).sqrt();
        let z = way / length - 5.0;
        let seen = look(&edge_on(), 5.0, dx, 0.0).unwrap();
        assert!((seen - 8.0 * -z / 3.0).abs() < 1e-9, "{seen} {z}");
    }
}

#[test]
fn rays_that_touch_the_bounding_sphere_miss_or_have_a_finite_luminance() {
    let edge = apparent_radius(2.0, 5.0);
    for n in 0..1000 {
        let (sin, cos) = (0.01 * f64::from(n)).sin_cos();
        for edge in [edge, edge * (1.0 + 1e-15), edge * (1.0 - 1e-15)] {
            let seen = look_at(1.0, 0.5, edge * cos, edge * sin);
            assert!(seen.is_none_or(f64::is_finite));
        }
    }
    // This one touches the donut as well, and may hit or miss.
    let seen = look(&edge_on(), 5.0, edge, 0.0);
    assert!(seen.is_none_or(f64::is_finite));
}

#[test]
fn far_near_thin_closed_large_and_tiny_scenes_have_no_wrong_cell() {
    for (r1, r2, k2) in [
        (1.0, 2.0, 50.0),
        (1.0, 2.0, 5e3),
        (1.0, 2.0, 1e6),
        (1.0, 2.0, 3.0001),
        (0.05, 2.0, 5.0),
        (0.002, 2.0, 5.0),
        (1.999, 2.0, 5.0),
        (1.0, CLOSED, 2.1),
        (1.0, CLOSED, 100.0),
        (1.0, 2.0, 3.0 * LEAST_DISTANCE),
        (1.0, CLOSED, (1.0 + CLOSED) * LEAST_DISTANCE),
        (300.0, 700.0, 2000.0),
        (0.01, 0.02, 0.05),
    ] {
        println!("R1 {r1}, R2 {r2}, K2 {k2}");
        let view = View::new(160, 44, 2.0, r2 / r1, k2 / r1);
        compare(view, &own_poses(20)).assert_right();
    }
}

#[test]
fn a_viewer_who_nearly_touches_the_donut_sees_no_wrong_cell() {
    for r2 in [CLOSED, 1.001, 2.0, 7.0, 50.0, 1000.0] {
        let view = View::new(40, 24, 2.0, r2, (1.0 + r2) * LEAST_DISTANCE);
        let poses = [0.0, 3.2e-8, 1e-7, -1e-4].map(|hair| (FRAC_PI_2 + hair, 3.04980045));
        let tally = compare(view, &poses);
        assert!(tally.surface > 0 && tally.wrong() == 0, "R2 {r2}: {tally:?}");
    }
}

#[test]
fn sizes_from_1x1_to_1280x352_have_no_wrong_cell() {
    let mut tally = Tally::default();
    let small = (1..=40).flat_map(|width| (1..=20).map(move |height| (width, height)));
    let large = [(79, 22), (81, 23), (200, 60), (300, 20), (30, 200), (640, 176), (1280, 352)];
    for (n, (width, height)) in small.chain(large).enumerate() {
        let view = fitted(width, height);
        let (a, b) = (0.7 * n as f64, 0.3 * n as f64);
        let framebuffer = draw(Method::Exact, view, a, b);
        tally.add(&Oracle::new(1.0, 2.0, 5.0, a, b), &view, &framebuffer);
    }
    tally.assert_right();
}

#[test]
fn pictures_of_one_row_or_one_column_are_blank() {
    for (width, height) in [(1, 1), (1, 2), (2, 1), (1, 4096), (4096, 1)] {
        for method in [Method::Exact, Method::Classic] {
            let framebuffer = draw(method, fitted(width, height), 1.0, 1.0);
            assert!(framebuffer.iter().all(|&cell| cell == b' '), "{width}x{height}");
        }
    }
}

#[track_caller]
fn assert_mirrored(view: View, a: f64) {
    let framebuffer = draw(Method::Exact, view, a, 0.0);
    let across = 2.0 * view.cx - 1.0;
    for row in framebuffer.chunks(view.width) {
        for column in 1..view.width {
            let mirrored = (across - column as f64) as usize;
            let mirrored = row.get(mirrored).copied().unwrap_or(b' ');
            assert_eq!(row[column], mirrored, "A {a}, {}x{}", view.width, view.height);
        }
    }
}

/// A block of lanes steps until its last ray has arrived, and none of its cells may depend on that.
#[test]
fn a_donut_that_does_not_lean_is_its_own_mirror_image() {
    for a in [0.0, 1.0, FRAC_PI_2, 3.0 * FRAC_PI_2] {
        assert_mirrored(enlarged(1), a);
        assert_mirrored(enlarged(4), a);
        for (width, height) in [(60, 18), (101, 30), (102, 26), (200, 61)] {
            for (r2, k2) in [
                (2.0, 5.0),
                (2.0, 3.0 * LEAST_DISTANCE),
                (50.0, 100.0),
                (1000.0, 1001.0 * LEAST_DISTANCE),
                (CLOSED, 5.0),
                (CLOSED, (1.0 + CLOSED) * LEAST_DISTANCE),
            ] {
                assert_mirrored(View::new(width, height, 2.0, r2, k2), a);
            }
        }
    }
}

#[test]
fn a_third_turn_changes_nothing_that_is_seen() {
    // First the donut turns about y, then about x, then about z. Two angles lead to the same axis.
    for time in [0.3, 1.0, 2.5, 7.0, 31.0] {
        let turn = |[x, y]: [f64; 2], angle: f64| {
            let (sin, cos) = f64::sin_cos(angle);
            [x * cos - y * sin, x * sin + y * cos]
        };
        let frame = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|[x, y, z]| {
            let [z, x] = turn([z, x], time);
            let [y, z] = turn([y, z], 1.13 * time);
            let [x, y] = turn([x, y], 1.74 * time);
            [x, y, z]
        });
        let [x, y, z] = frame[2];
        assert!((dot(frame[2], frame[2]) - 1.0).abs() < 1e-12);
        let (a, b) = (z.acos(), f64::atan2(x, -y));
        let framebuffer = draw(Method::Exact, fitted(120, 40), a, b);
        let mut tally = Tally::default();
        tally.add(&Oracle { r1: 1.0, r2: 2.0, k2: 5.0, frame }, &fitted(120, 40), &framebuffer);
        tally.assert_right();
    }
}

/// How far from the surface a ray's first hit was found; nothing if it misses.
fn error(torus: &Torus, k2: f64, dx: f64, dy: f64) -> Option<f64> {
    let rays = torus.rays([dx; LANES], dy, k2);
    let s = torus.first_hits(&rays)[0];
    let z = rays.f0[0] + rays.fu[0] * s;
    let rho = (rays.d0[0] + s * s - z * z).sqrt();
    (s < MISS).then(|| (f64::hypot(rho - torus.r2, z) - 1.0).abs())
}

/// Rays that graze the donut take Newton's method the most steps. If the search ends too early for
/// them, the picture is wrong. Random rays are never among them, so this test searches for them:
/// between a ray that hits and one that misses, or that hits far away from it, there is one that
/// grazes. Halving the way between the two, in the angle A and in dx, leads there.
///
/// It found that a last step of 1e-6 draws cells where no donut is. So does a limit of 20 steps, after
/// which a ray can be far from the donut; 36 are enough for all rays found so far.
#[test]
fn rays_between_a_hit_and_a_miss_are_right() {
    let mut random = Random(2011);
    let (mut tally, mut worst) = (Tally::default(), 0.0);
    for (r2, k2) in
        [(2.0, 5.0), (2.0, 3.01), (2.0, 1e6), (CLOSED, 5.0), (1.1, 50.0), (1000.0, 1500.0)]
    {
        let edge = apparent_radius(r2, k2);
        for n in 0..150 {
            let (b, dy) = (random.between(0.0, 7.0), edge * random.between(-1.0, 1.0));
            let [near, far] = [(); 2].map(|_| match n % 3 {
                0 => (random.between(0.0, 7.0), edge * random.between(-1.0, 1.0)),
                // Nearly edge-on, and nearly flat before the viewer, many rays graze.
                1 => (FRAC_PI_2 + random.between(-1e-3, 1e-3), 0.0),
                _ => (random.between(-1e-3, 1e-3), edge * random.between(-1.0, 1.0)),
            });
            let between = |t: f64| [near.0 + t * (far.0 - near.0), near.1 + t * (far.1 - near.1)];
            let look = |[a, dx]: [f64; 2]| look(&Torus::new(r2, a, b), k2, dx, dy);
            let differ = |one: Option<f64>, other: Option<f64>| match (one, other) {
                (Some(one), Some(other)) => (one - other).abs() > 0.5,
                (one, other) => one.is_some() != other.is_some(),
            };
            let (mut low, mut high) = (0.0, 1.0);
            if !differ(look(between(low)), look(between(high))) {
                continue;
            }
            for step in 0..52 {
                let middle = (low + high) / 2.0;
                let [a, dx] = between(middle);
                let seen = look([a, dx]);
                if differ(look(between(low)), seen) {
                    high = middle
                } else {
                    low = middle
                }
                let drawn = seen.map(|light| light.max(0.0) as usize);
                // From step 40 on the rays pass the surface so near that the oracle cannot tell.
                if step % 4 == 0 && (16..40).contains(&step) {
                    tally.count(Oracle::new(1.0, r2, k2, a, b).judge(dx, dy, drawn));
                }
                tally.surface += usize::from(drawn.is_some());
                worst = error(&Torus::new(r2, a, b), k2, dx, dy).unwrap_or(0.0).max(worst);
            }
        }
    }
    println!("{tally:?}, {worst} from the surface");
    assert!(tally.cells > 1500 && tally.wrong() == 0 && worst < 1e-10, "{tally:?} {worst}");
}

#[test]
fn no_pose_is_cut_off_and_the_donut_is_as_large_as_it_can_be() {
    for (aspect, r2, k2) in
        [(2.0, 2.0, 6.0), (5.0, 2.0, 3.01), (0.25, 1.001, 50.0), (2.0, 40.0, 100.0)]
    {
        for (width, height) in [(2, 2), (3, 9), (79, 22), (80, 22), (300, 20), (30, 90)] {
            let view = View::new(width, height, aspect, r2, k2);
            let sees = |a, b, x, y| {
                let (dx, dy) = direction(&view, x, y);
                Oracle::new(1.0, r2, k2, a, b).look(dx, dy).is_some()
            };
            // No ray just outside of the picture's edges hits.
            let (w, h) = (width as f64, height as f64);
            let (left, right, top, bottom) = (0.999, w + 0.001, 0.999, h + 0.001);
            for (a, b) in own_poses(12) {
                for n in 0..=100 {
                    let (x, y) = (w * f64::from(n) / 100.0, h * f64::from(n) / 100.0);
                    assert!(!sees(a, b, left, y) && !sees(a, b, right, y), "{width}x{height}");
                    assert!(!sees(a, b, x, top) && !sees(a, b, x, bottom), "{width}x{height}");
                }
            }
            // Edge-on, lying or upright, it reaches the edges.
            let inside = 0.001 * (w + h);
            let lying = sees(FRAC_PI_2, 0.0, 1.0 + inside, view.cy);
            let upright = sees(FRAC_PI_2, FRAC_PI_2, view.cx, 1.0 + inside);
            assert!(lying || upright, "{width}x{height}");
        }
    }
}

#[test]
fn the_edge_is_right_however_near_the_viewer_is() {
    // To subtract the squares of K2 and R1 + R2 would lose most bits.
    for gap in (1..=20).map(|exponent| 0.5_f64.powi(exponent)) {
        let expected = 3.0 / (gap * (6.0 + gap)).sqrt();
        assert!((apparent_radius(2.0, 3.0 + gap) / expected - 1.0).abs() < 1e-15, "{gap}");
    }
}

/// Any angle, or one at which the donut is nearly flat or nearly edge-on.
fn angle() -> impl Strategy<Value = f64> {
    let hair = (-6.0..-1.0_f64).prop_map(|exponent| 10_f64.powf(exponent));
    let near = (-8..=8, hair).prop_map(|(n, hair)| f64::from(n) * FRAC_PI_2 + hair);
    prop_oneof![-1e9..=1e9, near]
}

proptest! {
    // A case that fails is printed, not kept in the tree.
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn anywhere_in_the_domain_of_the_options_the_picture_is_right(
        (width, height) in (1_usize..70, 1_usize..40),
        aspect in 0.1..=10.0,
        (a, b) in (angle(), angle()),
        // How far the viewer is from the sphere round the donut, over its radius.
        gap in (-6.0..6.0_f64).prop_map(|exponent| 10_f64.powf(exponent)),
        r2 in prop_oneof![
            (0.0..3.0_f64).prop_map(|exponent| CLOSED * 10_f64.powf(exponent)),
            (-6.0..0.0_f64).prop_map(|exponent| CLOSED + 10_f64.powf(exponent)),
        ],
    ) {
        let k2 = (1.0 + r2) * (1.0 + gap);
        let view = View::new(width, height, aspect, r2, k2);
        let tally = compare(view, &[(a, b)]);
        prop_assert_eq!(tally.wrong(), 0, "{:?}", tally);
    }
}
