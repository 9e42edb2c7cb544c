//! The angles A and B of frame after frame, and the method that draws them by default.

use super::*;

/// From this frame on, donut.c's angles no longer change.
const FROZEN: u64 = 22_918_663;

const SPIN: [f64; 2] = [0.04, 0.02];

#[test]
fn exact_still_turns_after_2_to_the_40_frames() {
    for (frames, error) in [(0, 1e-9), (1_000_000, 1e-9), (FROZEN, 1e-9), (1 << 40, 1e-5)] {
        let [a, b] = SPIN.map(|step| frames as f64 * step);
        let view = fitted(100, 30);
        let [next_a, next_b] = Renderer::new(view, Method::Exact).advance([a, b], SPIN);
        assert!((next_a - a - 0.04).abs() < error && (next_b - b - 0.02).abs() < error);
        let [picture, next] =
            [(a, b), (next_a, next_b)].map(|(a, b)| draw(Method::Exact, view, a, b));
        assert_ne!(picture, next);
        compare(view, &[(a, b)]).assert_right();
    }
}

/// Where A reaches a power of two, the distance between neighbouring floats doubles, and each step is rounded
/// to a multiple of it. At 30 frames a second, A is 2.3% too slow from about 4 hours on, 17% too fast from 31
/// hours on, then 22% too slow, and 56% too fast in the last days. After nearly 9 days, it stands still.
#[test]
fn classics_steps_change_in_these_frames_until_it_stands_still() {
    let (classic, mut angles) = (Renderer::new(View::DONUT_C, Method::Classic), [0.0; 2]);
    let (mut changes, mut power) = (Vec::new(), 16_384.0);
    for frame in 0..=FROZEN {
        let next = classic.advance(angles, SPIN);
        if angles[0] >= power {
            let step = next[0] - angles[0];
            if changes.last().is_none_or(|&(_, last)| step != last) {
                changes.push((frame, step));
            }
            power *= 2.0;
        }
        assert!(next != angles || frame == FROZEN);
        angles = next;
    }
    let expected = [
        (409_232, 5.0 / 128.0),
        (3_345_245, 3.0 / 64.0),
        (6_141_447, 1.0 / 32.0),
        (14_530_055, 1.0 / 16.0),
        (FROZEN, 0.0),
    ];
    assert_eq!(changes, expected);
    assert_eq!(angles, [1_048_576.0, 524_288.0]);
}

#[test]
fn classic_is_the_default_only_for_donut_cs_own_picture() {
    for (options, is_classic) in [
        ("", true),
        ("-A 1000 --spin=1000,0", true),
        ("--aspect 2", true),
        ("--width 81", false),
        ("--height 23", false),
        ("--aspect 1.9", false),
        ("--k2 6", false),
        ("--r2 2.1", false),
    ] {
        let options = Options::parse_from(format!("donut {options}").split_whitespace());
        assert_eq!(options.renderer(None).classic.is_some(), is_classic);
    }
    // An 80x24 terminal gets donut.c's own picture, whatever the shape of its cells.
    let window = Some(Window { columns: 80, rows: 24, aspect: 2.2 });
    for options in [&["donut"][..], &["donut", "--method=exact"]] {
        let renderer = Options::parse_from(options).renderer(window);
        assert!(renderer.view == View::DONUT_C);
    }
    let renderer = Options::parse_from(["donut", "--r2=5"]).renderer(window);
    assert!(renderer.view == View::new(80, 22, 2.2, 5.0, 10.0));
}
