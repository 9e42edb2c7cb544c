//! What a frame is drawn with: its angles A and B, its colour, its size, and its method by default.

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
fn classic_stands_still_when_the_readme_says_so() {
    let classic = Renderer::new(View::DONUT_C, Method::Classic);
    let all = std::iter::successors(Some([0.0; 2]), |&angles| {
        Some(classic.advance(angles, SPIN)).filter(|&next| next != angles)
    });
    let (frame, angles) = (0..).zip(all).last().unwrap();
    assert_eq!((frame, angles), (FROZEN, [1_048_576.0, 524_288.0]));
    assert_eq!(FROZEN / 30 / 60, (8 * 24 + 20) * 60 + 12);
    // tests/golden.rs shows that this command shows the last second.
    for claim in ["22,918,663 frames", "8 days, 20 hours and 12 minutes", "-A 1048574 -B 524287"] {
        assert!(read("README.md").replace('\n', " ").contains(claim), "{claim}");
    }
}

/// An arrow key turns the donut by an angle to the right, or down.
#[test]
fn an_arrow_key_turns_the_near_side_the_way_it_points_and_the_angles_little() {
    // All round, and many turns away from 0. Last, the donut faces the viewer, where B means nothing.
    let a = [
        0.3, 1.0, FRAC_PI_2, 2.5, 3.5, 4.7, 6.0, -0.3, -2.0, 100.0, -999.0, 1e6, 2e6, 0.0, PI, TAU,
    ];
    let poses = a.into_iter().flat_map(|a| (0..12).map(move |n| [a, 0.05 + f64::from(n) * 1.3]));
    let float = |angle: f64| f64::from(angle as f32);
    for [right, down] in [[-0.1, 0.0], [0.1, 0.0], [0.0, -0.1], [0.0, 0.1]] {
        for pose in poses.clone().map(|pose| pose.map(float)) {
            let turn = |times: f64| turned(pose, times * right, times * down);
            // Exact draws these angles, and classic makes floats of them, which at 2e6 are 1/8 apart.
            for ([new_a, new_b], error) in [(turn(1.0), 1e-9), (turn(1.0).map(float), 1e-6)] {
                let ([x, y, z], [new_x, new_y, new_z]) =
                    (axis(pose[0], pose[1]), axis(new_a, new_b));
                // The axis turns about the screen's other axis. Its near end is at -z.
                let [stays, across, new_across] =
                    if down == 0.0 { [new_y - y, x, new_x] } else { [new_x - x, y, new_y] };
                let (radius, angle) = (f64::hypot(across, z), across.atan2(-z) + right + down);
                let errors =
                    [stays, new_across - radius * angle.sin(), new_z + radius * angle.cos()];
                assert!(errors.iter().all(|e| e.abs() < error), "{pose:?} {right} {down}");
            }
            let turns = [0, 1].map(|i| (turn(1e-6)[i] - pose[i]) / TAU);
            let is_little = turns.iter().all(|turns| (turns - turns.round()).abs() < 1e-5);
            assert!(is_little || pose[0].sin().abs() < 1e-6, "{pose:?} {right} {down}");
        }
    }
}

#[test]
fn the_rate_of_frames_does_not_change_how_fast_the_donut_spins() {
    for (options, spin) in [
        ("", SPIN),
        ("--fps 0", SPIN),
        ("--fps 60", [0.02, 0.01]),
        ("--fps 7.5", [0.16, 0.08]),
        ("--fps 60 --spin 1,2", [1.0, 2.0]),
    ] {
        assert_eq!(super::options(options).spin(), spin);
    }
}

#[test]
fn plus_and_minus_change_the_speed_by_a_quarter() {
    let options = options("--method=exact --spin=0.4,0.2");
    let (held, most) = ("+".repeat(4000), 1.25_f64.powi(20));
    let keys = [("+", 1.25), ("=", 1.25), ("-", 0.8), ("--", 0.64), ("-+x", 1.0), (&held, most)];
    for (keys, times) in keys {
        let mut show = Show::new(&options);
        keys.chars().for_each(|key| show.obey(key));
        show.advance();
        assert_eq!(show.angles, [0.4 * times, 0.2 * times], "{keys}");
    }
}

#[test]
fn c_takes_the_next_of_seven_bright_colours() {
    for (option, first) in
        [("", 9), ("--color=12", 13), ("--color=15", 9), ("--color=3", 9), ("--color=208", 9)]
    {
        let options = options(option);
        let mut show = Show::new(&options);
        for color in (9..=15).cycle().skip(first - 9).take(8) {
            show.obey('c');
            assert_eq!(show.color, Some(color), "{option}");
        }
    }
}

#[test]
fn a_picture_has_the_size_that_is_asked_for_or_all_that_the_window_can_show() {
    for (options, window, shown) in [
        ("", None, None),
        ("", Some((80, 24)), None),
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
        ("--r2 5", None, Some((80, 22, 2.0))),
        ("--r2 5 --k2 7", Some((80, 24)), Some((80, 22, 1.5))),
    ] {
        let window = window.map(|(columns, rows)| Window { columns, rows, aspect: 1.5 });
        let parsed = super::options(options);
        let view = parsed.view(window);
        let expected = shown.map_or(View::DONUT_C, |(columns, rows, aspect)| {
            View::fitted(columns, rows, aspect, parsed.r2, parsed.k2())
        });
        assert!(view == expected, "{options:?}: {}x{}", view.width, view.height);
        // By default, classic draws donut.c's own picture, and exact all others.
        assert_eq!(parsed.renderer(window, None).classic.is_some(), shown.is_none(), "{options}");
    }
}
