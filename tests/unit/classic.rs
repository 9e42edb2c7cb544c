//! `classic`: the parts that its picture is made of, and where that picture differs from the truth.

use super::*;

/// How many cells of a frame change for that frame only, and then back, on average.
fn flicker(method: Method) -> f64 {
    let mut renderer = Renderer::new(View::DONUT_C, method, RAMP);
    let pictures: Vec<_> = (0..600)
        .map(|n| {
            renderer.render_frame(0.04 * n as f64, 0.02 * n as f64);
            renderer.framebuffer.clone()
        })
        .collect();
    let back =
        |w: &[Vec<u8>]| (0..1760).filter(|&i| w[0][i] == w[2][i] && w[0][i] != w[1][i]).count();
    pictures.windows(3).map(back).sum::<usize>() as f64 / 598.0
}

#[test]
fn exact_barely_flickers_where_classic_shimmers() {
    let (classic, exact) = (flicker(Method::Classic), flicker(Method::Exact));
    println!("classic {classic}, exact {exact}");
    assert!((16.0..20.0).contains(&classic) && exact <= 1.0, "classic {classic}, exact {exact}");
}

/// Draws as `classic` does, with these steps of theta and phi.
pub fn with_steps(view: View, theta: f64, phi: f64) -> Renderer {
    let mut renderer = renderer(view, Method::Classic);
    renderer.tables = Some([trig_table(theta), trig_table(phi)]);
    renderer
}

/// The share of the cells that are wrong, over twelve poses, with donut.c's steps divided by `finer`.
fn wrong_share(finer: f64) -> f64 {
    let mut renderer = with_steps(View::DONUT_C, 0.07 / finer, 0.02 / finer);
    let mut tally = Tally::default();
    for (a, b) in own_poses(12) {
        renderer.render_frame(a, b);
        tally.add(&oracle_of(&renderer.view, a, b), &renderer.view, &renderer.framebuffer);
    }
    tally.wrong() as f64 / tally.drawn as f64
}

#[test]
fn a_finer_splat_is_further_from_the_truth() {
    let (own, finer) = (wrong_share(1.0), wrong_share(4.0));
    println!("{own} {finer}");
    assert!(own > 0.4 && finer > own + 0.04, "{own} {finer}");
}

/// Edge-on, the cells of the donut that are blank, and those that are off by more than one glyph:
/// nearly all of them show the far wall.
fn holes_and_see_through(mut renderer: Renderer) -> (usize, usize) {
    let (view, edge_on) = (renderer.view, std::f64::consts::FRAC_PI_2);
    renderer.render_frame(edge_on, 0.0);
    let oracle = oracle_of(&view, edge_on, 0.0);
    let (mut holes, mut through) = (0, 0);
    for row in 1..view.height {
        for column in 1..view.width {
            let (dx, dy) = direction(&view, column as f64 + 0.5, row as f64 + 0.5);
            let truth = oracle.look(dx, dy).map(|light| light.max(0.0) as usize);
            match (level(renderer.framebuffer[row * view.width + column]), truth) {
                (None, Some(_)) => holes += 1,
                (Some(drawn), Some(truth)) => through += usize::from(drawn.abs_diff(truth) > 1),
                _ => {}
            }
        }
    }
    (holes, through)
}

#[test]
fn the_steps_shrink_with_the_size_or_the_far_wall_shows_through() {
    let view = enlarged(4);
    let shrunk = holes_and_see_through(renderer(view, Method::Classic));
    let fixed = holes_and_see_through(with_steps(view, 0.07, 0.02));
    println!("holes and see-through: {shrunk:?}, with fixed steps {fixed:?}");
    assert!(shrunk.0 == 0 && shrunk.1 < 100, "{shrunk:?}");
    assert!(fixed.0 > 50 && fixed.1 > 3000, "{fixed:?}");
}

#[test]
fn the_steps_shrink_with_the_height_of_flat_cells_as_well() {
    let view = View::new(100, 400, 0.25, 2.0, 5.0);
    let (holes, through) = holes_and_see_through(renderer(view, Method::Classic));
    assert!(holes == 0 && through < 100, "{holes} {through}");
}

#[test]
fn products_of_the_luminance_are_multiplied_in_donut_cs_order() {
    // donut.c's frame 53,167 is the first in which `sin_phi * (cos_theta * cos_a)` shows: as `$`.
    let (a, b) = (2_127.510_7_f32, 1_063.755_4_f32);
    let framebuffer = draw(Method::Classic, View::DONUT_C, a.into(), b.into());
    assert_eq!(framebuffer[80 * 3 + 53], b'@');
}

#[test]
fn steps_of_any_size_go_once_round_the_circle() {
    for step in [0.07, 0.02, 0.01, 0.001, 0.0001] {
        let (sin, cos) = trig_table(step);
        // What is left from the last angle to the first is at most a step, up to rounding.
        let left = f64::from(-sin.last().unwrap()).atan2((*cos.last().unwrap()).into());
        assert!(left > 0.0 && left < 1.01 * step, "{step}: {left}");
        assert!((sin.len() as f64 - TAU / step).abs() < 1.0 + 0.01 * TAU / step, "{step}");
    }
}

#[test]
fn floor_is_the_cast_of_c() {
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
fn samples_at_the_very_edge_of_the_picture_do_no_harm() {
    for (width, height, aspect) in [(2, 2, 2.0), (3, 2, 2.0), (11, 2, 10.0), (40, 5, 10.0)] {
        let mut renderer =
            Renderer::new(View::new(width, height, aspect, 2.0, 5.0), Method::Classic, RAMP);
        for n in 0..2000 {
            // Edge-on, and lying or nearly so: some samples are seen just where the donut ends.
            renderer.render_frame(std::f64::consts::FRAC_PI_2, 0.001 * f64::from(n));
            let edge =
                renderer.framebuffer.iter().step_by(width).chain(&renderer.framebuffer[..width]);
            assert!(edge.clone().all(|&cell| cell == b' '), "{width}x{height}");
        }
    }
}
