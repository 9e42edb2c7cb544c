//! The angles A and B of frame after frame, and the method that draws them by default.

use super::*;

/// From this frame on, donut.c's angles no longer change.
pub const FROZEN: u64 = 22_918_663;

const SPIN: [f64; 2] = [0.04, 0.02];

#[test]
fn exact_still_turns_after_2_to_the_40_frames() {
    for (frames, error) in [(0, 1e-9), (1_000_000, 1e-9), (FROZEN, 1e-9), (1 << 40, 1e-5)] {
        let [a, b] = SPIN.map(|step| frames as f64 * step);
        let [next_a, next_b] = advance(Method::Exact, [a, b], SPIN);
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
        angles = advance(Method::Classic, angles, SPIN);
        angles == before
    });
    assert_eq!(first_still_frame, Some(FROZEN));
    assert_eq!(angles, [1_048_576.0, 524_288.0]);
}

#[test]
fn classic_is_the_default_only_for_donut_cs_own_picture() {
    for (options, method) in [
        ("", Method::Classic),
        ("-A 1000 --spin=1000,0", Method::Classic),
        ("--width 81", Method::Exact),
        ("--height 23", Method::Exact),
        ("--aspect 1.9", Method::Exact),
        ("--k2 6", Method::Exact),
        ("--r2 2.1", Method::Exact),
    ] {
        let options = Options::parse_from(format!("donut {options}").split_whitespace());
        assert_eq!(options.renderer(None).method, method);
    }
}
