//! The figures of the README: those of the committed table, at 80x22 where nothing else is said.

use std::fs;

fn read(path: &str) -> String {
    fs::read_to_string(format!("{}/{path}", env!("CARGO_MANIFEST_DIR"))).unwrap()
}

/// What the README says of the first chart.
fn reading(table: &str) -> String {
    // Microseconds a frame, wrong cells, and cells of the donut.
    let figures = |method: &str, size: &str| {
        let start = format!("{method},{size},");
        let line = table.lines().find(|line| line.starts_with(&start));
        let columns: Vec<_> = line.expect(&start).split(',').collect();
        [2, 5, 6].map(|n| columns[n].parse::<f64>().unwrap())
    };
    let time = |method| format!("{:.0} us", figures(method, "80x22")[0]);
    let share = |method| {
        let [_, wrong, cells] = figures(method, "80x22");
        format!("{}, {:.2} % wrong", time(method), 100.0 * wrong / cells)
    };
    let sizes = ["80x22", "160x44", "320x88"];
    let sum = |method, n: usize| sizes.iter().map(|size| figures(method, size)[n]).sum::<f64>();
    let [own, quarter] = ["classic x1", "classic x1/4"].map(share);
    let [few, many] = ["sphere tracing 32", "sphere tracing 256"].map(share);
    let right = ["exact", "closed form f32", "closed form f64"];
    let ([exact, f32, f64], [a, b, c]) = (right.map(time), right.map(|method| sum(method, 1)));
    let cells = sum("exact", 2);
    format!(
        "- classic: {own}; with steps a quarter as long, {quarter}.\n  \
         Finer is slower and no better, for the nearest dot in a cell is not at its centre.\n\
         - sphere tracing: {few}, in 32 steps; {many}, in 256.\n  \
         Rays that graze the donut need more and more.\n\
         - exact: {exact}; the closed form: {f32} in f32, {f64} in f64.\n  \
         At the three sizes together they draw {a}, {b} and {c} of {cells} cells wrong.\n"
    )
}

#[test]
fn the_readme_has_the_figures_of_the_table() {
    let reading = reading(&read("tests/chart/speed-and-accuracy.csv"));
    let same = read("README.md").contains(&reading);
    assert!(same, "the README should say:\n{reading}");
}
