use super::*;

/// Cells that show something for one frame only, going back to what they were, each frame.
fn flicker(method: Method) -> f64 {
    let mut renderer = Renderer::new(Scene::DONUT_C, Camera::DONUT_C, method);
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
fn exact_hardly_flickers_where_classic_shimmers() {
    let (classic, exact) = (flicker(Method::Classic), flicker(Method::Exact));
    println!("classic {classic}, exact {exact}");
    assert!((16.0..20.0).contains(&classic) && exact <= 1.0, "classic {classic}, exact {exact}");
}

/// A splat with these steps of theta and phi.
pub fn with_steps(camera: &Camera, theta: f64, phi: f64) -> Splat {
    let mut splat = Splat::new(camera);
    (splat.theta, splat.phi) = (Circle::new(theta), Circle::new(phi));
    splat.ring = Ring::new(splat.phi.sin.len());
    splat
}

/// The share of a splat's cells that are wrong, over twelve poses, with its steps divided by `finer`.
fn wrong_share(camera: Camera, finer: f64) -> f64 {
    let mut splat = with_steps(&camera, 0.07 / finer, 0.02 / finer);
    let mut tally = Tally::default();
    for (a, b) in own_poses(12) {
        let mut framebuffer = vec![b' '; camera.width * camera.height];
        splat.draw(a as f32, b as f32, &camera, &mut framebuffer);
        tally.add(&Oracle::new(1.0, 2.0, 5.0, a, b), &camera, &framebuffer);
    }
    tally.wrong() as f64 / tally.surface as f64
}

#[test]
fn a_finer_splat_is_further_from_the_truth() {
    let (own, finer) = (wrong_share(Camera::DONUT_C, 1.0), wrong_share(Camera::DONUT_C, 4.0));
    println!("{own} {finer}");
    assert!(own > 0.4 && finer > own + 0.04, "{own} {finer}");
}

/// Edge-on, the cells of the donut that are blank, and those that are off by more than one glyph:
/// nearly all of them show the far wall.
fn holes_and_see_through(camera: &Camera, splat: &mut Splat) -> (usize, usize) {
    let oracle = Oracle::new(1.0, 2.0, 5.0, std::f64::consts::FRAC_PI_2, 0.0);
    let mut framebuffer = vec![b' '; camera.width * camera.height];
    splat.draw(std::f32::consts::FRAC_PI_2, 0.0, camera, &mut framebuffer);
    let (mut holes, mut through) = (0, 0);
    for row in 1..camera.height {
        for column in 1..camera.width {
            let (dx, dy) = direction(camera, column as f64 + 0.5, row as f64 + 0.5);
            let truth = oracle.look(dx, dy).map(|light| light.max(0.0) as usize);
            match (level(framebuffer[row * camera.width + column]), truth) {
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
    let camera = enlarged(4);
    let shrunk = holes_and_see_through(&camera, &mut Splat::new(&camera));
    let fixed = holes_and_see_through(&camera, &mut with_steps(&camera, 0.07, 0.02));
    println!("holes and see-through: {shrunk:?}, with fixed steps {fixed:?}");
    assert!(shrunk.0 == 0 && shrunk.1 < 100, "{shrunk:?}");
    assert!(fixed.0 > 50 && fixed.1 > 3000, "{fixed:?}");
}

#[test]
fn the_steps_shrink_with_the_height_of_flat_cells_as_well() {
    let camera = Camera::new(100, 400, 0.25, &Scene::DONUT_C);
    let (holes, through) = holes_and_see_through(&camera, &mut Splat::new(&camera));
    assert!(holes == 0 && through < 100, "{holes} {through}");
}

#[test]
fn truncating_is_the_cast_of_c() {
    for value in [
        0.0_f32,
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
        assert_eq!(truncate(value), value as i32, "{value}");
    }
    for below in [-0.0, -0.3, -0.5, -1.0, -4096.0] {
        assert!(truncate(below) <= 0, "{below}");
    }
}
