//! The method classic: its parts, and how its picture differs from what the oracle sees.

use super::*;

/// A renderer that draws as classic does, but with these steps of theta and phi.
pub fn with_steps(view: View, theta: f64, phi: f64) -> Renderer {
    let mut renderer = Renderer::new(view, Method::Classic);
    renderer.classic = Some(Classic::new(&view, [theta, phi]));
    renderer
}

/// Draws the donut edge-on, rotated by B, and counts two kinds of its cells: those that are blank, and
/// those whose level is off by more than one. Nearly all of the second kind show the far wall of the tube
/// through a gap in the near one.
fn holes_and_see_through(mut renderer: Renderer, b: f64) -> (usize, usize) {
    renderer.render_frame(FRAC_PI_2, b);
    let (view, mut holes, mut through) = (renderer.view, 0, 0);
    for (cell, _, light) in cells(&view, &Oracle::new(view.r2, view.k2, FRAC_PI_2, b)) {
        match (level(renderer.framebuffer[cell]), light.map(level_of)) {
            (None, Some(_)) => holes += 1,
            (Some(drawn), Some(truth)) => through += usize::from(drawn.abs_diff(truth) > 1),
            _ => {}
        }
    }
    (holes, through)
}

#[test]
fn steps_are_short_enough_in_large_pictures_of_any_shape() {
    let fixed = holes_and_see_through(with_steps(enlarged(4), 0.07, 0.02), 0.0);
    assert!(fixed.0 > 50 && fixed.1 > 3000, "{fixed:?}");
    assert_eq!(holes_and_see_through(Renderer::new(enlarged(4), Method::Classic), 0.0), (0, 0));
    // How many cells may show the far wall in a donut that is lying, and in one that is upright.
    let shapes = [(0.25, [0, 6]), (0.5, [0, 2]), (1.0, [0, 0]), (1.2, [0, 0]), (4.0, [0, 40])];
    for (aspect, most) in shapes {
        let view = View::fitted(300, 300, aspect, 2.0, 5.0);
        for (b, most) in [0.0, FRAC_PI_2].into_iter().zip(most) {
            let counts = holes_and_see_through(Renderer::new(view, Method::Classic), b);
            assert!(counts.0 == 0 && counts.1 <= most, "aspect {aspect}, B {b}: {counts:?}");
        }
    }
}

#[test]
fn luminance_is_multiplied_in_donut_cs_order() {
    // If cos_theta and cos_a were multiplied first, frame 53,167 would be the first to change, to `$` here.
    let framebuffer = draw(Method::Classic, View::DONUT_C, 2_127.510_7, 1_063.755_4);
    assert_eq!(framebuffer[79 * 2 + 52], b'@');
}

#[test]
fn sines_and_cosines_are_rounded_from_f64() {
    // On Linux, f32's own cosine of this angle ends in another digit.
    // (`black_box`, because the compiler would compute it, and round as f64.)
    assert_eq!(c_sin_cos(std::hint::black_box(2.1599991)), (0.83138394, -0.55569845));
}

#[test]
fn steps_of_any_size_go_round_the_circle_exactly_once() {
    for step in [0.07, 0.02, 0.01, 0.001, 0.0001] {
        let table = trig_table(step);
        let &(sin, cos) = table.last().unwrap();
        // Between the last angle and a full turn, at most one step is missing, apart from rounding.
        let left = f64::from(-sin).atan2(cos.into());
        assert!(left > 0.0 && left < 1.01 * step, "{step}: {left}");
        assert!((table.len() as f64 - TAU / step).abs() < 1.0 + 0.01 * TAU / step, "{step}");
    }
}

/// donut.rs is donut.c, step by step, in the shape of a donut. Here it draws the picture of a view. It counts
/// columns and rows from 1, and leaves column 0 and row 0 blank.
pub fn donut_c(view: &View, a: f64, b: f64) -> Vec<u8> {
    let &View { width, height, cx, cy, k1x, k1y, .. } = view;
    let numbers = [1.0 + cx, 1.0 + cy, k1x, k1y].map(|number| number as f32);
    let frame = donut::frame(a as f32, b as f32, [1 + width, 1 + height], numbers);
    frame.chunks(1 + width).skip(1).flat_map(|row| row[1..].to_vec()).collect()
}

/// classic leaves out donut.c's conditions for each sample. It must still draw the same where the outline
/// passes the edges of the picture, and where the back shows through gaps between the samples.
#[test]
fn classic_draws_the_same_as_a_literal_translation_of_donut_c() {
    let eighths = (0..64).map(|n| (f64::from(n % 8) * TAU / 8.0, f64::from(n / 8) * TAU / 8.0));
    // Edge-on, the donut turns slowly from lying to upright, and some samples fall exactly on the right edge.
    let edge_on = (0..800).map(|n| (FRAC_PI_2, 0.002 * f64::from(n)));
    let poses: Vec<_> = donut_c_poses(12).into_iter().chain(eighths).chain(edge_on).collect();
    // At these sizes classic has donut.c's own steps of theta and phi.
    let sizes = [(79, 21), (40, 12), (33, 17), (61, 9), (2, 1), (1, 1)];
    let fitted = sizes.map(|(width, height)| fitted(width, height));
    let flat = View::fitted(39, 4, 10.0, 2.0, 5.0);
    for view in fitted.into_iter().chain([View::DONUT_C, flat]) {
        let mut renderer = Renderer::new(view, Method::Classic);
        for &(a, b) in &poses {
            renderer.render_frame(a, b);
            let View { width, height, .. } = view;
            assert!(renderer.framebuffer == donut_c(&view, a, b), "A {a}, B {b}, {width}x{height}");
        }
    }
}
