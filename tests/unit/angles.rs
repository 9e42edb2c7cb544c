//! What a frame is drawn with: its angles A and B, its size, and its method by default.

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
        assert_eq!(options.renderer(None, None).classic.is_some(), is_classic);
    }
}

/// What an arrow key does: the axis along which it moves the near side, and the angle.
const ARROWS: [(usize, f64); 4] = [(1, -0.1), (1, 0.1), (0, -0.1), (0, 0.1)];

/// Poses all round, many turns away from 0 as well, without those in which the donut faces the viewer squarely.
fn poses() -> impl Iterator<Item = [f64; 2]> {
    let a = [0.3, 1.0, FRAC_PI_2, 2.5, 3.5, 4.7, 6.0, -0.3, -2.0, 100.0, -999.0];
    a.into_iter().flat_map(|a| (0..12).map(move |n| [a, 0.05 + f64::from(n) * TAU / 12.0]))
}

#[test]
fn an_arrow_key_moves_the_near_side_the_way_it_points_in_every_pose() {
    for ([a, b], (along, angle)) in poses().flat_map(|pose| ARROWS.map(|arrow| (pose, arrow))) {
        let [before, after] = [[a, b], turned([a, b], along, angle)].map(|[a, b]| axis(a, b));
        // A mark at the end of the axis that is nearer to the viewer.
        let near = -before[2].signum();
        let moved = near * (after[along] - before[along]);
        assert!(moved * angle.signum() > 0.0 || before[2].abs() < 0.06, "{a} {b}: {moved}");
        // It turns about the other axis of the screen, by this angle.
        assert!((after[1 - along] - before[1 - along]).abs() < 1e-12, "{a} {b}");
        let [before, after] = [before, after].map(|n| f64::atan2(n[along], -n[2]));
        let turn = (after - before).rem_euclid(TAU);
        assert!((turn - angle.rem_euclid(TAU)).abs() < 1e-9, "{a} {b}: {turn}, not {angle}");
    }
}

#[test]
fn an_arrow_key_and_its_opposite_lead_back_to_the_same_angles() {
    for (angles, (along, angle)) in poses().flat_map(|pose| ARROWS.map(|arrow| (pose, arrow))) {
        let there = (0..4).fold(angles, |angles, _| turned(angles, along, angle));
        let back = (0..4).fold(there, |angles, _| turned(angles, along, -angle));
        let [before, after] = [angles, back].map(|[a, b]| axis(a, b));
        assert!((0..3).all(|i| (after[i] - before[i]).abs() < 1e-12), "{angles:?} {back:?}");
    }
}

/// The spin goes on in its direction only if both angles are the nearest to the old ones.
#[test]
fn a_small_turn_changes_both_angles_little() {
    for (angles, (along, angle)) in poses().flat_map(|pose| ARROWS.map(|arrow| (pose, arrow))) {
        let new = turned(angles, along, 1e-6 * angle);
        assert!((0..2).all(|i| (new[i] - angles[i]).abs() < 1e-5), "{angles:?} {new:?}");
    }
}

#[test]
fn the_donut_turns_steadily_even_where_b_means_nothing() {
    for start in [[0.0, 0.0], [0.0, 1.0], [PI, 0.0], [TAU, -2.0]] {
        for (along, angle) in ARROWS {
            let mut angles = start;
            for _ in 0..70 {
                let next = turned(angles, along, angle);
                let [before, after] = [angles, next].map(|[a, b]| axis(a, b));
                let product: f64 = (0..3).map(|i| before[i] * after[i]).sum();
                assert!((product - 0.1_f64.cos()).abs() < 1e-12, "{angles:?} {next:?}");
                angles = next;
            }
        }
    }
}

#[test]
fn the_rate_of_frames_does_not_change_how_fast_the_donut_spins() {
    for (options, spin) in [
        ("", SPIN),
        ("--fps 30", SPIN),
        ("--fps 0", SPIN),
        ("--fps 60", [0.02, 0.01]),
        ("--fps 7.5", [0.16, 0.08]),
        ("--fps 60 --spin 1,2", [1.0, 2.0]),
    ] {
        let options = Options::parse_from(format!("donut {options}").split_whitespace());
        assert_eq!(options.spin(), spin);
    }
}

#[test]
fn a_picture_has_the_size_that_is_asked_for_or_all_that_the_window_can_show() {
    for (options, window, shown) in [
        ("", None, None),
        ("", Some((80, 24)), None),
        ("--method exact", Some((80, 24)), None),
        ("--width 80 --height 22", Some((200, 60)), None),
        ("--width 80 --height 22", Some((80, 24)), None),
        ("--width 80 --height 22 --aspect 2", Some((81, 25)), None),
        // Not enough rows, another shape, or another donut.
        ("", Some((80, 23)), Some((80, 22, 1.5))),
        ("--aspect 2", Some((80, 23)), Some((80, 22, 2.0))),
        ("--width 80 --height 22", Some((80, 23)), Some((80, 22, 1.5))),
        ("--aspect 1.9", Some((80, 24)), Some((80, 22, 1.9))),
        ("--height 23", Some((80, 24)), Some((80, 23, 1.5))),
        ("--width 79", Some((80, 24)), Some((79, 22, 1.5))),
        ("", Some((81, 24)), Some((81, 23, 1.5))),
        ("", Some((80, 25)), Some((80, 24, 1.5))),
        ("", Some((200, 60)), Some((200, 59, 1.5))),
        ("", Some((20, 6)), Some((20, 5, 1.5))),
        ("", Some((1, 1)), Some((1, 1, 1.5))),
        ("", Some((65_535, 65_535)), Some((4096, 4096, 1.5))),
        ("--width 30 --height 10", Some((20, 6)), Some((20, 5, 1.5))),
        ("--width 30 --height 10", Some((200, 60)), Some((30, 10, 1.5))),
        ("--width 4096 --height 4096", None, Some((4096, 4096, 2.0))),
        ("--height 1", None, Some((80, 1, 2.0))),
    ] {
        let window = window.map(|(columns, rows)| Window { columns, rows, aspect: 1.5 });
        let view = Options::parse_from(format!("donut {options}").split_whitespace()).view(window);
        let expected = shown.map_or(View::DONUT_C, |(columns, rows, aspect)| {
            View::fitted(columns, rows, aspect, 2.0, 5.0)
        });
        assert!(view == expected, "{options:?}: {}x{}", view.width, view.height);
    }
    let [own, other] = [None, Some(Window { columns: 80, rows: 24, aspect: 2.2 })]
        .map(|window| Options::parse_from(["donut", "--r2=5"]).view(window));
    assert!(own == View::fitted(80, 22, 2.0, 5.0, 10.0));
    assert!(other == View::fitted(80, 22, 2.2, 5.0, 10.0));
}
