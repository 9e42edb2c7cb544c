//! A second truth, which is nobody's rule: the average of each cell of donut.c's own picture. The cell shows
//! the donut if at least half of 16 by 16 rays through it hit, and its level is the mean of theirs, rounded.

use super::*;

const STORED: &str = "tests/chart/average.csv";
const COLUMNS: &str = "pose,method,cells of the donut,wrong,drawn in both,levels off in these";

/// The rows of a pose, for classic and for exact. The last column is the sum of the differences between the
/// levels that are drawn and the means, before these are rounded.
fn rows(pose: usize) -> String {
    let (view, (a, b)) = (View::DONUT_C, donut_c_poses(pose + 1)[pose]);
    let oracle = Oracle::new(view.r2, view.k2, a, b);
    let part = |i: usize| (i as f64 + 0.5) / 16.0;
    let means = cells(&view, &oracle).map(|(cell, ..)| {
        let (column, row) = ((cell % view.width) as f64, (cell / view.width) as f64);
        let rays = (0..256).map(|i| direction(&view, column + part(i % 16), row + part(i / 16)));
        let levels = rays.filter_map(|(dx, dy)| oracle.look(dx, dy).map(level_of));
        let (hits, sum) = levels.fold((0, 0), |(hits, sum), level| (hits + 1, sum + level));
        (cell, (hits >= 128).then(|| sum as f64 / f64::from(hits)))
    });
    let means: Vec<_> = means.collect();
    let rows = [Method::Classic, Method::Exact].map(|method| {
        let picture = draw(method, view, a, b);
        let (mut surface, mut wrong, mut both, mut off) = (0, 0, 0, 0.0);
        for &(cell, mean) in &means {
            let drawn = level(picture[cell]);
            surface += usize::from(mean.is_some());
            wrong += usize::from(mean.map(|mean| mean.round() as usize) != drawn);
            if let (Some(mean), Some(drawn)) = (mean, drawn) {
                both += 1;
                off += (mean - drawn as f64).abs();
            }
        }
        format!("{pose},{method:?},{surface},{wrong},{both},{off:.3}\n").to_lowercase()
    });
    rows.concat()
}

pub fn table() -> String {
    let table = read(STORED);
    let row = |name: &str| {
        let rows = table.lines().map(|line| line.split(',').collect::<Vec<_>>());
        let rows: Vec<_> = rows.filter(|row| row[1] == name).collect();
        let sum = |i: usize| rows.iter().map(|row| row[i].parse::<f64>().unwrap()).sum::<f64>();
        let (wrong, off) = (100.0 * sum(3) / sum(2), sum(5) / sum(4));
        vec![name.into(), format!("{wrong:.1}%"), format!("{off:.2}")]
    };
    let head = ["", "wrong cells", "levels off"].map(String::from);
    markdown(vec![head.into(), row("classic"), row("exact")])
}

/// Takes half a minute.
pub fn measure() {
    let rows: String = (0..50).map(rows).collect();
    fs::write(path(STORED), format!("{COLUMNS}\n{rows}")).unwrap();
}

#[test]
fn one_of_the_poses_is_as_stored() {
    assert!(read(STORED).contains(&rows(7)), "{STORED} is stale: measure again");
}
