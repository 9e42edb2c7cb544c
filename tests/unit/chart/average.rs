//! A second rule, which no method follows: a cell should show the average of 16 by 16 rays through it.

use super::other_methods::{Hits, hits};
use super::*;

const RAYS: usize = 16;

/// Counts the cells that show the donut by the rule; and in the pictures that each method draws in these
/// poses, the cells that differ from it, and those of them that differ by more than one level.
pub fn count(mut methods: Vec<NamedMethod>, view: View, poses: Vec<(f64, f64)>) -> Vec<[usize; 3]> {
    in_time(move || {
        let mut counts = vec![[0; 3]; methods.len()];
        for (a, b) in poses {
            let wanted: Vec<_> =
                averaged::<RAYS, { RAYS * RAYS / 2 }>(&view, a, b).into_iter().map(level).collect();
            for ((_, draw), [surface, different, far_off]) in methods.iter_mut().zip(&mut counts) {
                for (&wanted, drawn) in wanted.iter().zip(draw(a, b).into_iter().map(level)) {
                    let is_next =
                        wanted.zip(drawn).is_some_and(|(one, other)| one.abs_diff(other) == 1);
                    *surface += usize::from(wanted.is_some());
                    *different += usize::from(wanted != drawn);
                    *far_off += usize::from(wanted != drawn && !is_next);
                }
            }
        }
        counts
    })
}

/// The program follows the rays of the rule. The oracle has to see the same.
#[test]
fn the_oracle_sees_the_same_average() {
    let (view, (a, b)) = (View::DONUT_C, donut_c_poses(8)[7]);
    let oracle = Oracle::new(view.r2, view.k2, a, b);
    let traced = hits::<RAYS>(&view, a, b);
    let part = |i: usize| (i as f64 + 0.5) / RAYS as f64;
    for (cell, ..) in cells(&view, &oracle) {
        let (column, row) = ((cell % view.width) as f64, (cell / view.width) as f64);
        let rays = (0..RAYS * RAYS)
            .map(|i| direction(&view, column + part(i % RAYS), row + part(i / RAYS)));
        let mut seen = Hits::default();
        for light in rays.filter_map(|(dx, dy)| oracle.look(dx, dy)) {
            seen.count += 1;
            seen.light += light.max(0.0) / 8.0;
        }
        let is_same =
            traced[cell].count == seen.count && (traced[cell].light - seen.light).abs() < 1e-6;
        assert!(is_same, "cell {cell}: {:?}, not {seen:?}", traced[cell]);
    }
}
