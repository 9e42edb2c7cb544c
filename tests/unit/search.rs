//! The search of `exact`, from one step to the first hit. Mostly, all lanes have the same plain numbers.

use super::*;

/// p, q and c of a quartic.
pub type Numbers = [f64; 3];

/// The numbers of one of eight rays.
pub fn numbers(Quartic { p, q, c }: &Quartic, lane: usize) -> Numbers {
    [p, q, c].map(|lanes| lanes.to_array()[lane])
}

/// Where a search arrives, from the entry on.
pub fn places(numbers: Numbers, entry: f64) -> impl Iterator<Item = f64> {
    std::iter::successors(Some(entry), move |&s| {
        Some(step(numbers, s)).filter(|&r| r > s + TOLERANCE && r < MISS)
    })
}

fn first_hits(numbers: [Numbers; 8], entry: [f64; 8]) -> [f64; 8] {
    let [p, q, c] = [0, 1, 2].map(|i| f64x8::new(numbers.map(|numbers| numbers[i])));
    Quartic { p, q, c }.first_hits(f64x8::new(entry)).to_array()
}

pub fn step([p, q, c]: Numbers, s: f64) -> f64 {
    Quartic { p: p.into(), q: q.into(), c: c.into() }.parabola_root(s.into()).to_array()[0]
}

pub fn g([p, q, c]: Numbers, s: f64) -> f64 {
    (s * s + p) * (s * s + p) + 2.0 * q * s + c
}

/// Quartics with two factors, (s^2 - 2 u s + u^2 - i) (s^2 + 2 u s + u^2 - j), and their real roots in order.
/// The roots are integers, so f64 computes each G without rounding, and some of them are multiple ones.
fn quartics() -> impl Iterator<Item = (Numbers, Vec<f64>)> {
    let squares = [-9.0, -4.0, -1.0, 0.0, 1.0, 4.0, 9.0, 16.0, 25.0];
    let numbers = (-5..=5).map(f64::from).flat_map(move |u| squares.map(|i| (u, i)));
    numbers.flat_map(move |(u, i)| squares.map(|j| (u, i, j))).map(|(u, i, j): (f64, f64, f64)| {
        let (m, n) = (u * u - i, u * u - j);
        let p = (m + n) / 2.0 - 2.0 * u * u;
        let roots = [u - i.sqrt(), u + i.sqrt(), -u - j.sqrt(), -u + j.sqrt()];
        let mut roots: Vec<_> = roots.into_iter().filter(|root| !root.is_nan()).collect();
        roots.sort_by(f64::total_cmp);
        ([p, u * (m - n), m * n - p * p], roots)
    })
}

#[test]
fn a_step_leads_to_the_first_root_of_a_parabola_that_is_nowhere_above_g() {
    for (numbers, _) in quartics() {
        for s in (-40..=40).map(|s| 0.5 * f64::from(s)).filter(|&s| g(numbers, s) > 0.0) {
            let [p, q, _] = numbers;
            let (height, base) = (g(numbers, s), s * s + p);
            // Where G rises, the parabola starts level.
            let slope = (4.0 * base * s + 2.0 * q).min(0.0);
            let parabola = |t: f64| height + slope * t + 2.0 * base * t * t;
            for t in (0..=80).map(|t| 0.5 * f64::from(t)) {
                let (above, w) = (g(numbers, s + t) - parabola(t), 2.0 * s * t + t * t);
                assert!(above == w * w || slope == 0.0 && above > w * w, "{numbers:?}, {s}, {t}");
            }
            let t = step(numbers, s) - s;
            let is_root = parabola(t).abs() < 1e-12 * (height - slope * t + base.abs() * t * t);
            // If the parabola has two roots on the right, its lowest point is between them.
            let is_first = base <= 0.0 || 4.0 * base * t < -1.0001 * slope;
            let has_root = base < 0.0 || slope < 0.0 && slope * slope >= 8.0 * base * height;
            let is_right = if has_root { is_root && is_first } else { t == MISS };
            assert!(is_right, "{numbers:?}: from {s} by {t}");
        }
    }
}

#[test]
fn no_step_passes_a_root_and_every_search_ends_at_the_next_one() {
    in_time(|| {
        for (numbers, roots) in quartics() {
            // At a root of an even multiplicity, G turns back, which rounding may hide.
            let multiplicity = |root: f64| roots.iter().filter(|&&other| other == root).count();
            let entries = (-60..=20).map(|entry| 0.5 * f64::from(entry) + 0.125);
            // Inside the donut, no search starts.
            for entry in entries.filter(|&entry| g(numbers, entry) >= 0.0) {
                let ahead = roots.iter().copied().filter(|&root| root >= entry).chain([MISS]);
                let is_last = |root: f64| root == MISS || multiplicity(root) % 2 == 1;
                let last = ahead.clone().find(|&root| is_last(root)).unwrap();
                for s in places(numbers, entry) {
                    assert!(s <= last + 1e-7, "{numbers:?}: {s} is beyond {last}");
                }
                let hit = first_hits([numbers; 8], [entry; 8])[0];
                let error = |root| if multiplicity(root) > 1 { 1e-4 } else { 1e-12 };
                let is_at = |root: f64| hit == root || (hit - root).abs() < error(root);
                let mut ends = ahead.filter(|&root| root <= last);
                assert!(ends.any(is_at), "{numbers:?}: {hit}, not {last}, from {entry}");
            }
        }
    })
}

#[test]
fn hits_in_the_most_special_places_are_found() {
    // p, q and c; the entry; and the first hit.
    let cases = [
        // G does not fall at the entry, and base is 1 or 0; or G neither falls nor rises.
        ([0.0, 0.0, 3.0], 1.0, MISS),
        ([-1.0, 1.0, 3.0], 1.0, MISS),
        ([-1.0, 0.0, 3.0], 1.0, MISS),
        // G rises at the entry, and falls later.
        ([-2.0, 0.0, -0.5], -1.0, (2.0 - 0.5_f64.sqrt()).sqrt()),
        // The parabola has no root, although base is positive and G falls.
        ([3.0, 0.0, 0.0], -1.0, MISS),
        ([-3.0, 4.0, 20.0], -2.0, MISS),
        // The entry is the hit, or next to it.
        ([1.0, -1.0, -6.0], -1.0, -1.0),
        ([1.0, -1.0, -6.0], (-1.0_f64).next_up(), -1.0),
        ([1.0, -1.0, -6.0], (-1.0_f64).next_down(), -1.0),
        // G is 0 at the entry, and rises there, or neither falls nor rises.
        ([-1.0, 1.0, -2.0], 1.0, 1.0),
        ([-1.0, 0.0, 0.0], 1.0, 1.0),
        // (s + 1)^3 (s - 3), and s^4.
        ([-3.0, -4.0, -12.0], -5.0, -1.0),
        ([-3.0, -4.0, -12.0], -1.0, -1.0),
        ([0.0, 0.0, 0.0], -3.0, 0.0),
        // G, or its terms, are too large for f64.
        ([-1.0, 3.0, 2.0], 1e100, MISS),
        ([-1.0, -3.0, 2.0], f64::INFINITY, MISS),
    ];
    // Each case comes into each lane. Its neighbours must not change a bit.
    for first in 0..cases.len() {
        let eight: [_; 8] = array::from_fn(|i| cases[(first + i) % cases.len()]);
        let search = move || first_hits(eight.map(|case| case.0), eight.map(|case| case.1));
        let hits = in_time(search);
        for (s, case) in hits.into_iter().zip(eight) {
            assert!(s == case.2 || (s - case.2).abs() < 1e-4, "{s}: {case:?}");
            assert_eq!(s, first_hits([case.0; 8], [case.1; 8])[0], "{case:?}");
        }
    }
}

#[test]
fn the_radius_of_the_outline_has_all_its_digits_even_if_the_viewer_is_near() {
    for (r2, k2, tangent) in [(1.01, 2.02, 10.012523175873025), (29.9, 30.91, 39.303308263380174)] {
        let error = outline_radius(r2, k2) / tangent - 1.0;
        assert!(error.abs() < 1e-15, "R2 {r2}, K2 {k2}: {error}");
    }
}
