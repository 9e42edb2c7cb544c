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

/// From A = 2^20 on, neighbouring floats are 1/8 apart, and adding 0.04 changes nothing.
#[test]
fn classic_stands_still_after_nearly_nine_days() {
    let classic = Renderer::new(View::DONUT_C, Method::Classic);
    let all = std::iter::successors(Some([0.0; 2]), |&angles| {
        Some(classic.advance(angles, SPIN)).filter(|&next| next != angles)
    });
    let (frame, angles) = (0..).zip(all).last().unwrap();
    assert_eq!((frame, angles), (FROZEN, [1_048_576.0, 524_288.0]));
}

/// An arrow key turns the donut by an angle to the right, or down.
#[test]
fn an_arrow_key_turns_the_near_side_the_way_it_points_and_the_angles_little() {
    // All round, and many turns away from 0. Last, the donut faces the viewer, where B means nothing.
    let a = [0.3, 1.0, FRAC_PI_2, 2.5, 3.5, 4.7, 6.0, -0.3, -2.0, 100.0, -999.0, 0.0, PI, TAU];
    let poses = a.into_iter().flat_map(|a| (0..12).map(move |n| [a, 0.05 + f64::from(n) * 1.3]));
    for [right, down] in [[-0.1, 0.0], [0.1, 0.0], [0.0, -0.1], [0.0, 0.1]] {
        for pose in poses.clone() {
            let turn = |times: f64| turned(pose, times * right, times * down);
            let [[x, y, z], [new_x, new_y, new_z]] = [pose, turn(1.0)].map(|[a, b]| axis(a, b));
            // The axis turns about the screen's other axis. Its near end is at -z.
            let [stays, across, new_across] =
                if down == 0.0 { [new_y - y, x, new_x] } else { [new_x - x, y, new_y] };
            let angle = new_across.atan2(-new_z) - across.atan2(-z) - (right + down);
            assert!(stays.abs() < 1e-12 && (angle / TAU - (angle / TAU).round()).abs() < 1e-12);
            let [a, b] = [0, 1].map(|i| (turn(1e-6)[i] - pose[i]).abs());
            assert!(a.max(b) < 1e-5 || pose[0].sin().abs() < 1e-9, "{pose:?} {right} {down}");
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
        let parsed = Options::parse_from(format!("donut {options}").split_whitespace());
        let view = parsed.view(window);
        let expected = shown.map_or(View::DONUT_C, |(columns, rows, aspect)| {
            View::fitted(columns, rows, aspect, 2.0, 5.0)
        });
        assert!(view == expected, "{options:?}: {}x{}", view.width, view.height);
        // By default, classic draws donut.c's own picture, and exact all others.
        assert_eq!(parsed.renderer(window, None).classic.is_some(), shown.is_none(), "{options}");
    }
}

#[test]
fn by_default_every_donut_is_seen_from_as_far_as_donut_cs_for_its_size() {
    for (r2, k2) in [(5.0, 10.0), (29.0, 50.0)] {
        let options = Options::parse_from(["donut".into(), format!("--r2={r2}")]);
        let window = Some(Window { columns: 80, rows: 24, aspect: 2.2 });
        for (window, aspect) in [(None, 2.0), (window, 2.2)] {
            assert!(options.view(window) == View::fitted(80, 22, aspect, r2, k2), "{r2}");
        }
    }
}
