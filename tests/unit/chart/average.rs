//! A second rule, which no method follows: a cell should show the average of 16 by 16 rays through it.

use super::other_methods::{Hits, trace_n_by_n};
use super::*;

const RAYS: usize = 16;

/// Counts the cells of pictures: those that show the donut by the rule, those where a picture differs
/// from it, and, of the latter, those where it differs in more than the next level.
#[derive(Clone, Default)]
pub struct Average {
    pub surface: usize,
    pub different: usize,
    pub far_off: usize,
}

impl Average {
    fn count(&mut self, wanted: Option<usize>, drawn: Option<usize>) {
        let is_next = wanted.zip(drawn).is_some_and(|(wanted, drawn)| wanted.abs_diff(drawn) == 1);
        self.surface += usize::from(wanted.is_some());
        self.different += usize::from(wanted != drawn);
        self.far_off += usize::from(wanted != drawn && !is_next);
    }
}

/// What the rule says of the pictures that each method draws in these poses.
pub fn count(mut methods: Vec<NamedMethod>, view: View, poses: Vec<(f64, f64)>) -> Vec<Average> {
    within_a_minute(move || {
        let mut averages = vec![Average::default(); methods.len()];
        for (a, b) in poses {
            let wanted = averaged(&view, a, b, RAYS);
            for ((_, draw), average) in methods.iter_mut().zip(&mut averages) {
                for (&wanted, drawn) in wanted.iter().zip(draw(a, b)) {
                    average.count(level(wanted), level(drawn));
                }
            }
        }
        averages
    })
}

/// The program follows the rays of the rule. The oracle has to see the same.
pub fn compare_with_oracle(view: View, (a, b): (f64, f64)) {
    let oracle = Oracle::new(view.r2, view.k2, a, b);
    let traced = trace_n_by_n(&view, a, b, RAYS);
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
        assert!(is_same, "A {a}, B {b}, cell {cell}: {:?}, not {seen:?}", traced[cell]);
    }
}

#[test]
fn the_oracle_sees_the_same_average() {
    compare_with_oracle(View::DONUT_C, donut_c_poses(8)[7]);
}
