//! The angles A and B of frame after frame, and the method that draws each by default.

use super::*;

/// From this frame on, donut.c's angles no longer change.
pub const FROZEN: u64 = 22_918_663;

/// From this frame on, exact draws donut.c's own picture by default.
pub const HANDOVER: u64 = 3_345_245;

const SPIN: [f64; 2] = [0.04, 0.02];

fn options_with(spin: [f64; 2]) -> Options {
    Options { spin, ..Options::parse_from(["donut"]) }
}

/// The method that draws donut.c's own picture at these angles.
fn own_method(options: &Options, angles: [f64; 2]) -> Method {
    options.method_for(&View::DONUT_C, angles)
}

#[test]
fn exact_still_turns_after_2_to_the_40_frames() {
    for (frames, error) in [(0, 1e-9), (1_000_000, 1e-9), (FROZEN, 1e-9), (1 << 40, 1e-5)] {
        let [a, b] = SPIN.map(|step| frames as f64 * step);
        let [next_a, next_b] = next_angles(Method::Exact, [a, b], SPIN);
        assert!((next_a - a - 0.04).abs() < error && (next_b - b - 0.02).abs() < error);

        let view = fitted(100, 30);
        let [picture, next] =
            [(a, b), (next_a, next_b)].map(|(a, b)| draw(Method::Exact, view, a, b));
        assert_ne!(picture, next);
        compare(view, &[(a, b)]).assert_right();
    }
}

#[test]
fn classic_stands_still_from_the_frozen_frame_on() {
    let mut angles = [0.0; 2];
    let first_still_frame = (0..=FROZEN).find(|_| {
        let before = angles;
        angles = next_angles(Method::Classic, angles, SPIN);
        angles == before
    });
    assert_eq!(first_still_frame, Some(FROZEN));
    assert_eq!(angles, [1_048_576.0, 524_288.0]);
}

#[test]
fn exact_takes_over_without_a_jump() {
    let (mut angles, options) = ([0.0; 2], options_with(SPIN));
    for _ in 0..HANDOVER {
        assert_eq!(own_method(&options, angles), Method::Classic);
        angles = next_angles(Method::Classic, angles, SPIN);
    }
    let [a, b] = angles;
    let [classic, exact] =
        [Method::Classic, Method::Exact].map(|method| draw(method, View::DONUT_C, a, b));
    let changed = classic.iter().zip(&exact).filter(|(classic, exact)| classic != exact).count();
    // The outline and the shades change, but the donut keeps its place.
    let share = changed as f64 / classic.len() as f64;
    assert!((0.05..0.2).contains(&share), "{share}");
    for _ in 0..1000 {
        assert_eq!(own_method(&options, angles), Method::Exact);
        angles = next_angles(Method::Exact, angles, SPIN);
    }
}

#[test]
fn the_default_is_classic_where_floats_are_fine_enough() {
    for (angle, spin, method) in [
        // From 2^15 on floats are 1/256 apart, and from 2^17 on 1/64.
        (40_000.001_5, 4.0 / 256.0, Method::Classic),
        (40_000.001_5, 3.99 / 256.0, Method::Exact),
        (131_072.0, 4.0 / 64.0, Method::Classic),
        (131_071.98, 0.04, Method::Classic),
        (131_072.0, 0.04, Method::Exact),
        (123_456_789.123, 1.0, Method::Exact),
        // A very slow donut, which would stand still with floats, and one that does stand still.
        (1500.0, 0.000_05, Method::Exact),
        (1.0, 1e-9, Method::Exact),
        (1.1, 0.0, Method::Classic),
        (2047.9, 0.0, Method::Classic),
        (2048.1, 0.0, Method::Exact),
    ] {
        for sign in [1.0, -1.0] {
            let (angle, spin) = (sign * angle, sign * spin);
            let [about_x, about_z] = [[spin, 0.0], [0.0, spin]].map(options_with);
            assert_eq!(own_method(&about_x, [angle, 0.0]), method, "{angle} {spin}");
            assert_eq!(own_method(&about_z, [0.0, angle]), method, "{angle} {spin}");
        }
    }
}

#[test]
fn the_default_is_exact_in_any_view_but_donut_cs() {
    for (view, method) in [
        (fitted(80, 22), Method::Classic),
        (fitted(81, 22), Method::Exact),
        (fitted(80, 23), Method::Exact),
        (View::new(80, 22, 1.9, 2.0, 5.0), Method::Exact),
        (View::new(80, 22, 2.0, 2.0, 6.0), Method::Exact),
        (View::new(80, 22, 2.0, 2.1, 5.0), Method::Exact),
    ] {
        assert_eq!(options_with(SPIN).method_for(&view, [0.0; 2]), method);
    }
}
