//! The angles A and B of frame after frame, and the method that `auto` chooses by them.

use super::*;

/// The first frame of donut.c whose angles are also those of every frame after it.
const FROZEN: u64 = 22_918_663;

/// A clock that starts at these angles, with donut.c's spin.
fn clock(a: f64, b: f64) -> Clock {
    Clock { start: [a, b], ticks: 0, spin: [0.04, 0.02] }
}

#[test]
fn with_exact_the_donut_still_turns_as_it_should_after_2_to_the_40_frames() {
    for (frames, error) in [(0, 1e-9), (1_000_000, 1e-9), (FROZEN, 1e-9), (1 << 40, 1e-5)] {
        let mut clock = Clock { ticks: frames, ..clock(0.0, 0.0) };
        let [a, b] = clock.angles();
        clock.tick(Method::Exact);
        let [next_a, next_b] = clock.angles();
        assert!((next_a - a - 0.04).abs() < error && (next_b - b - 0.02).abs() < error);

        let view = fitted(100, 30);
        let picture = draw(Method::Exact, view, a, b);
        assert_ne!(picture, draw(Method::Exact, view, next_a, next_b));
        let mut tally = Tally::default();
        tally.add(&oracle_of(&view, a, b), &view, &picture);
        tally.assert_right();
    }
}

#[test]
fn with_classic_the_donut_stands_still_from_frame_22_918_663_on() {
    let mut clock = clock(0.0, 0.0);
    let first_still_frame = (0..=FROZEN).find(|_| {
        let before = clock.angles();
        clock.tick(Method::Classic);
        clock.angles() == before
    });
    assert_eq!(first_still_frame, Some(FROZEN));
    assert_eq!(clock.angles(), [1_048_576.0, 524_288.0]);
}

#[test]
fn auto_goes_on_with_exact_from_frame_3_345_245_and_the_donut_does_not_jump() {
    let mut clock = clock(0.0, 0.0);
    for _ in 0..3_345_245 {
        assert!(choose_method(MethodOption::Auto, &View::DONUT_C, &clock) == Method::Classic);
        clock.tick(Method::Classic);
    }
    let [a, b] = clock.angles();
    let [classic, exact] =
        [Method::Classic, Method::Exact].map(|method| draw(method, View::DONUT_C, a, b));
    let changed = classic.iter().zip(&exact).filter(|(classic, exact)| classic != exact).count();
    // The outline and the shades change, but the donut keeps its place.
    let share = changed as f64 / classic.len() as f64;
    assert!((0.05..0.2).contains(&share), "{share}");
    for _ in 0..1000 {
        assert!(choose_method(MethodOption::Auto, &View::DONUT_C, &clock) == Method::Exact);
        let [a, b] = clock.angles();
        clock.tick(Method::Exact);
        let [next_a, next_b] = clock.angles();
        assert!((next_a - a - 0.04).abs() < 1e-9 && (next_b - b - 0.02).abs() < 1e-9);
    }
}

#[test]
fn auto_is_classic_for_a_donut_that_does_not_spin() {
    let clock = Clock { spin: [0.0, 0.0], ..clock(1.1, 0.3) };
    assert!(choose_method(MethodOption::Auto, &View::DONUT_C, &clock) == Method::Classic);
}

#[test]
fn auto_is_exact_where_floats_cannot_follow_the_spin() {
    for (a, spin) in [(1_048_560.0, 0.04), (1.0, 1e-9), (1.0, -1e-9)] {
        for clock in [
            Clock { spin: [spin, 0.0], ..clock(a, 0.0) },
            Clock { spin: [0.0, spin], ..clock(0.0, a) },
        ] {
            assert!(choose_method(MethodOption::Auto, &View::DONUT_C, &clock) == Method::Exact);
        }
    }
}

#[test]
fn auto_is_exact_where_a_float_cannot_hold_the_angle() {
    // From 2^14 on, floats are 0.00195 apart, and from 2^15 on 0.0039. The second of these angles
    // is 0.0009 from the nearest float, and the third is 0.0019 from it.
    for (angle, method) in [
        (123_456_789.123, Method::Exact),
        (16_384.000_9, Method::Classic),
        (32_768.001_9, Method::Exact),
    ] {
        for [a, b] in [[angle, 0.0], [0.0, -angle]] {
            let clock = Clock { spin: [0.0, 0.0], ..clock(a, b) };
            assert!(choose_method(MethodOption::Auto, &View::DONUT_C, &clock) == method, "{a} {b}");
        }
    }
}

#[test]
fn auto_is_classic_if_floats_follow_the_spin_to_within_a_tenth_of_it() {
    // From 2^17 on, floats are this far apart. A spin of nearly this distance is rounded to it.
    let apart = 0.015_625;
    for (factor, method) in [
        (0.92, Method::Classic),
        (0.90, Method::Exact),
        (1.10, Method::Classic),
        (1.12, Method::Exact),
    ] {
        let clock = Clock { spin: [factor * apart, 0.0], ..clock(131_072.0, 0.0) };
        assert!(choose_method(MethodOption::Auto, &View::DONUT_C, &clock) == method, "{factor}");
    }
}

#[test]
fn auto_is_exact_at_every_size_and_scene_but_those_of_donut_c() {
    let views = [
        fitted(81, 22),
        fitted(80, 23),
        View::new(80, 22, 1.9, 2.0, 5.0),
        View::new(80, 22, 2.0, 2.0, 6.0),
        View::new(80, 22, 2.0, 2.1, 5.0),
    ];
    for view in views {
        assert!(choose_method(MethodOption::Auto, &view, &clock(0.0, 0.0)) == Method::Exact);
    }
    assert!(
        choose_method(MethodOption::Auto, &fitted(80, 22), &clock(0.0, 0.0)) == Method::Classic
    );
}
