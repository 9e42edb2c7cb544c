//! The method classic: its parts, and how its picture differs from what the oracle sees.

use super::*;

/// A renderer that draws as classic does, but with these steps of theta and phi.
pub fn with_steps(view: View, theta: f64, phi: f64) -> Renderer {
    let mut renderer = renderer(view, Method::Classic);
    renderer.tables = Some([trig_table(theta), trig_table(phi)]);
    renderer
}

/// Draws the donut edge-on, rotated by B, and counts two kinds of its cells: those that are blank, and
/// those whose level is off by more than one. Nearly all of the second kind show the far wall of the tube
/// through a gap in the near one.
fn holes_and_see_through(mut renderer: Renderer, b: f64) -> (usize, usize) {
    let (view, edge_on) = (renderer.view, std::f64::consts::FRAC_PI_2);
    renderer.render_frame(edge_on, b);
    let oracle = oracle_of(&view, edge_on, b);
    let (mut holes, mut through) = (0, 0);
    for (column, row) in cells(&view) {
        let (dx, dy) = cell_direction(&view, (column, row));
        let truth = oracle.look(dx, dy).map(level_of);
        match (level(renderer.framebuffer[row * view.width + column]), truth) {
            (None, Some(_)) => holes += 1,
            (Some(drawn), Some(truth)) => through += usize::from(drawn.abs_diff(truth) > 1),
            _ => {}
        }
    }
    (holes, through)
}

#[test]
fn steps_are_shorter_in_a_larger_picture() {
    let view = enlarged(4);
    let shrunk = holes_and_see_through(renderer(view, Method::Classic), 0.0);
    let fixed = holes_and_see_through(with_steps(view, 0.07, 0.02), 0.0);
    println!("holes and see-through: {shrunk:?}, with fixed steps {fixed:?}");
    assert_eq!(shrunk, (0, 0));
    assert!(fixed.0 > 50 && fixed.1 > 3000, "{fixed:?}");
}

#[test]
fn steps_are_short_enough_for_narrow_cells() {
    // If the steps were those for cells twice as tall as wide, each of these aspects would have at least 30
    // cells that show the far wall, in one of the two poses.
    let [lying, upright] = [0.0, std::f64::consts::FRAC_PI_2];
    for (aspect, poses) in [
        (0.25, &[lying][..]),
        (0.5, &[lying, upright]),
        (1.0, &[lying, upright]),
        (1.2, &[lying, upright]),
    ] {
        let view = View::new(300, 300, aspect, 2.0, 5.0);
        for &b in poses {
            let counts = holes_and_see_through(renderer(view, Method::Classic), b);
            assert_eq!(counts, (0, 0), "aspect {aspect}, B {b}");
        }
    }
}

#[test]
fn luminance_is_multiplied_in_donut_cs_order() {
    // donut.c multiplies in this order: (sin_phi * cos_theta) * cos_a. If cos_theta and cos_a were
    // multiplied first, frame 53,167 would be the first one to change. It has these angles, and the
    // glyph would be `$`.
    let (a, b) = (2_127.510_7_f32, 1_063.755_4_f32);
    let framebuffer = draw(Method::Classic, View::DONUT_C, a.into(), b.into());
    assert_eq!(framebuffer[80 * 3 + 53], b'@');
}

#[test]
fn steps_of_any_size_go_round_the_circle_exactly_once() {
    for step in [0.07, 0.02, 0.01, 0.001, 0.0001] {
        let (sin, cos) = trig_table(step);
        // Between the last angle and a full turn, at most one step is missing, apart from rounding.
        let left = f64::from(-sin.last().unwrap()).atan2((*cos.last().unwrap()).into());
        assert!(left > 0.0 && left < 1.01 * step, "{step}: {left}");
        assert!((sin.len() as f64 - TAU / step).abs() < 1.0 + 0.01 * TAU / step, "{step}");
    }
}

#[test]
fn floor_equals_a_cast_in_c() {
    for value in [
        0.0_f32,
        1e-30,
        0.3,
        0.5,
        0.999_999_94,
        1.0,
        1.5,
        2.5,
        39.999_996,
        40.0,
        41.0,
        4_095.999_8,
        4096.0,
    ] {
        assert_eq!(floor(value), value as u32, "{value}");
    }
}

#[test]
fn samples_on_the_edge_leave_row_0_and_column_0_blank() {
    for (width, height, aspect) in [(2, 2, 2.0), (3, 2, 2.0), (11, 2, 10.0), (40, 5, 10.0)] {
        let view = View::new(width, height, aspect, 2.0, 5.0);
        let mut renderer = Renderer::new(view, Method::Classic);
        for n in 0..2000 {
            // The donut is edge-on and turns slowly from lying to upright and beyond. In some of these
            // poses, samples fall exactly on the edge of the donut, which touches the edge of the
            // picture.
            renderer.render_frame(std::f64::consts::FRAC_PI_2, 0.001 * f64::from(n));
            let edge =
                renderer.framebuffer.iter().step_by(width).chain(&renderer.framebuffer[..width]);
            assert!(edge.clone().all(|&cell| cell == b' '), "{width}x{height}");
        }
    }
}
