//! How long each method takes to draw the donut, and how many cells it gets wrong; the pictures that the
//! README shows; and the figures in its text.
//!
//! To measure again and write the files of tests/chart, run
//! `cargo test --release chart -- --ignored --nocapture`. Then `cargo test` says which figures of the
//! README are stale.

mod other_methods;
mod picture;

use self::other_methods::*;
use super::classic::{donut_c, with_steps};
use super::*;

/// A method of this program, or another one to compare it with: its name, and how it draws the donut, turned
/// by A and B, into a blank framebuffer.
type NamedMethod = (String, Box<dyn FnMut(f64, f64, &mut [u8])>);

/// In how many of donut.c's own poses the cells are compared with the oracle.
const POSES: usize = 50;
const TABLE: &str = "tests/chart/speed-and-accuracy.csv";
const TITLES: &str =
    "method at 80x22,us per frame (median),cells of the donut,wrong shades,extra outline,holes\n";

/// The frames of donut.c's own angle A, as donut.c adds it up, in which its error passes a whole turn, in
/// which it begins to turn too fast, and in which it stops.
const WHOLE_TURN: f64 = 192_750.0;
const FASTER: f64 = 3_345_245.0;
const STOPPED: f64 = FROZEN as f64;

fn own_method(name: impl Into<String>, mut renderer: Renderer) -> NamedMethod {
    let draw = move |a, b, cells: &mut [u8]| {
        renderer.render_frame(a, b);
        cells.copy_from_slice(&renderer.framebuffer);
    };
    (name.into(), Box::new(draw))
}

/// A method that differs from exact only in how it finds the hits of N rays.
fn tracing<const N: usize>(
    name: impl Into<String>,
    view: View,
    first_hits: impl Fn(&Torus, &[Ray; N]) -> [f64; N] + 'static,
) -> NamedMethod {
    let mut renderer = Renderer::new(view, Method::Exact);
    let draw = move |a, b, cells: &mut [u8]| {
        renderer.framebuffer.fill(b' ');
        renderer.trace(a, b, &first_hits);
        cells.copy_from_slice(&renderer.framebuffer);
    };
    (name.into(), Box::new(draw))
}

fn sphere_tracing(name: impl Into<String>, view: View, most_steps: usize) -> NamedMethod {
    tracing(name, view, move |torus, rays| sphere_trace(torus.r2, rays, most_steps))
}

/// A method that follows one ray after another. `first_hit` finds the s of a ray's first hit.
fn ray_by_ray(
    name: &str,
    view: View,
    first_hit: impl Fn(&Torus, &Ray) -> f64 + 'static,
) -> NamedMethod {
    tracing(name, view, move |torus, [ray]| [first_hit(torus, ray)])
}

/// The methods to measure, in donut.c's own view.
fn methods() -> Vec<NamedMethod> {
    let view = View::DONUT_C;
    let mut methods = vec![
        own_method("classic x1", renderer(view, Method::Classic)),
        own_method("exact", renderer(view, Method::Exact)),
        tracing("exact one ray at a time", view, Torus::first_hits::<1>),
        ray_by_ray("closed form f64", view, closed_form),
    ];
    for (name, factor) in [("x4", 4.0), ("x2", 2.0), ("x1/2", 0.5), ("x1/4", 0.25)] {
        let renderer = with_steps(view, 0.07 * factor, 0.02 * factor);
        methods.push(own_method(format!("classic {name}"), renderer));
    }
    for most_steps in [8, 16, 32, 64, 256] {
        methods.push(sphere_tracing(format!("sphere tracing {most_steps}"), view, most_steps));
    }
    let mut zbuffer = vec![0.0; view.width * view.height];
    let literal = move |a, b, cells: &mut [u8]| {
        donut_c(a as f32, b as f32, &view, &mut zbuffer, cells);
    };
    methods.push(("donut.c as written".into(), Box::new(literal)));
    methods
}

/// The tally of each method in these poses.
fn tallies(methods: &mut [NamedMethod], view: &View, poses: &[(f64, f64)]) -> Vec<Tally> {
    let mut tallies: Vec<_> = methods.iter().map(|_| Tally::default()).collect();
    for &(a, b) in poses {
        let mut pictures = vec![vec![b' '; view.width * view.height]; methods.len()];
        for ((_, draw), picture) in methods.iter_mut().zip(&mut pictures) {
            draw(a, b, picture);
        }
        add_pictures(&mut tallies, view, (a, b), &pictures);
    }
    tallies
}

/// The last columns of the table.
fn columns(&Tally { surface, shades, extra, holes, .. }: &Tally) -> String {
    format!("{surface},{shades},{extra},{holes}")
}

/// The microseconds that each method takes for a frame: the median.
///
/// The methods take turns until the time is up, so that whatever else the computer does slows all of
/// them down and not just one. In its turn, a method draws five runs of 40 consecutive frames, as it
/// would in the program.
fn micros(methods: &mut [NamedMethod], seconds: u64) -> Vec<f64> {
    let mut cells = vec![b' '; View::DONUT_C.width * View::DONUT_C.height];
    let mut samples = vec![Vec::new(); methods.len()];
    let start = Instant::now();
    while start.elapsed().as_secs() < seconds {
        for ((_, draw), samples) in methods.iter_mut().zip(&mut samples) {
            for (a, b) in donut_c_poses(5) {
                for frame in (0..40).map(f64::from) {
                    let start = Instant::now();
                    cells.fill(b' ');
                    draw(a + 0.04 * frame, b + 0.02 * frame, &mut cells);
                    samples.push(start.elapsed().as_secs_f64() * 1e6);
                }
            }
        }
    }
    let median = |samples: &mut Vec<f64>| {
        samples.sort_by(f64::total_cmp);
        samples[samples.len() / 2]
    };
    samples.iter_mut().map(median).collect()
}

/// The largest error of donut.c's angle A up to frame n, in radians, for several frames n. The
/// error is the difference from `0.04 n`: A is a sum, and each addition is rounded.
///
/// The frames go from 1,000 to 30 million, each a tenth more than the one before, and the three frames that
/// have a name above are among them.
fn drift() -> Vec<(f64, f64)> {
    let frames = std::iter::successors(Some(1000_u32), |n| Some(n + n / 10));
    let mut frames: Vec<_> = frames.take_while(|&n| n < 30_000_000).map(f64::from).collect();
    frames.extend([WHOLE_TURN, FASTER, STOPPED, 30e6]);
    frames.sort_by(f64::total_cmp);
    let (mut frame, mut angle, mut largest) = (0.0, 0.0, 0.0);
    let mut error_at = |n| {
        while frame < n {
            (frame, angle) = (frame + 1.0, add_step(angle, 0.04));
            largest = f64::max(largest, (f64::from(angle) - 0.04 * frame).abs());
        }
        (n, largest)
    };
    frames.into_iter().map(&mut error_at).collect()
}

/// The methods in TABLE, and their figures in the order of its columns.
fn measured() -> Vec<(String, Vec<f64>)> {
    let row = |line: &str| {
        let (name, figures) = line.split_once(',').unwrap();
        (name.into(), figures.split(',').map(|figure| figure.parse().unwrap()).collect())
    };
    read(TABLE).lines().skip(1).map(row).collect()
}

/// The names and contents of the files that follow from the stored table and from the program, without
/// measuring anything.
fn derived_files() -> [(&'static str, String); 5] {
    let dot = |(name, row): (String, Vec<f64>)| {
        (name, (row[0], 100.0 * row[2..].iter().sum::<f64>() / row[1]))
    };
    let (dots, errors) = (measured().into_iter().map(dot).collect::<Vec<_>>(), drift());
    let line = |(frame, error): &(f64, f64)| format!("{frame},{error:.6}\n");
    let lines = errors.iter().map(line).collect::<String>();
    [
        ("tests/chart/speed-and-accuracy.svg", picture::speed_and_accuracy(&dots)),
        ("tests/chart/drift.csv", format!("frame,largest error of A up to it in radians\n{lines}")),
        ("tests/chart/drift.svg", picture::drift(&errors)),
        ("tests/donut.svg", picture::moving()),
        ("tests/methods.svg", picture::two_methods()),
    ]
}

#[test]
#[ignore = "measures for half a minute"]
fn measure_and_write_the_table_and_the_charts() {
    let mut methods = methods();
    let (mut table, micros) = (String::from(TITLES), micros(&mut methods, 30));
    let tallies = tallies(&mut methods, &View::DONUT_C, &donut_c_poses(POSES));
    for (((name, _), micros), tally) in methods.iter().zip(micros).zip(tallies) {
        table += &format!("{name},{micros:.1},{}\n", columns(&tally));
    }
    println!("{TABLE}\n{table}");
    fs::write(path(TABLE), table).unwrap();
    for (name, contents) in derived_files() {
        fs::write(path(name), contents).unwrap();
    }
}

#[test]
fn the_pictures_and_the_table_of_the_drift_are_up_to_date() {
    for (name, contents) in derived_files() {
        assert!(contents.len() < 400_000, "{name} is too much for a page to load");
        assert_current(name, &contents);
    }
}

#[test]
fn the_table_has_the_wrong_cells() {
    let (table, mut methods) = (read(TABLE), methods());
    let tallies = tallies(&mut methods, &View::DONUT_C, &donut_c_poses(POSES));
    for ((name, _), tally) in methods.iter().zip(tallies) {
        let (start, end) = (format!("{name},"), format!(",{}", columns(&tally)));
        let is_current = |line: &str| line.starts_with(&start) && line.ends_with(&end);
        assert!(table.lines().any(is_current), "no line {start}...{end} in\n{table}");
    }
}

// ---- The figures of the README -------------------------------------------------------------------

/// The README's words are its own; only the numbers of its table are checked. The names of the rows and
/// of the columns tell which number is which.
#[test]
fn the_readmes_table_has_the_wrong_cells_where_methods_fail() {
    let readme = read("README.md");
    let row = |name: &str| -> Vec<&str> {
        let mut rows =
            readme.lines().map(|line| line.split('|').map(str::trim).collect::<Vec<_>>());
        let row = rows.find(|row| row.get(1) == Some(&name));
        row.unwrap_or_else(|| panic!("the README has no row {name:?}"))
    };
    let scene = |r2, k2| View::new(160, 44, 2.0, r2, k2);
    let poses = donut_c_poses(10);
    let edge_on: Vec<_> = poses.iter().map(|&(_, b)| (TAU / 4.0 + 1e-4, b)).collect();
    let mut stale = Vec::new();
    for (scene, view, poses) in [
        ("160x44", scene(2.0, 5.0), &poses),
        ("320x88", fitted(320, 88), &poses),
        ("edge-on", scene(2.0, 5.0), &edge_on),
        ("`--r2 9 --k2 25`", scene(9.0, 25.0), &poses),
        ("`--k2 3.003`", scene(2.0, 3.003), &poses),
        ("`--k2 50`", scene(2.0, 50.0), &poses),
        ("`--k2 50000`", scene(2.0, 50_000.0), &poses),
    ] {
        let k2 = view.k2;
        let mut methods = [
            own_method("donut.c's steps", with_steps(view, 0.07, 0.02)),
            sphere_tracing("Sphere tracing", view, 64),
            ray_by_ray("Newton", view, newton_once),
            ray_by_ray("Ferrari, f32", view, move |torus, ray| textbook_f32(torus, k2, ray)),
            ray_by_ray("Ferrari, f64", view, move |torus, ray| textbook_f64(torus, k2, ray)),
            ray_by_ray("Closed form, f64", view, closed_form),
            own_method("Exact", renderer(view, Method::Exact)),
        ];
        let column = row("method").iter().position(|&name| name == scene);
        let column = column.unwrap_or_else(|| panic!("the README has no column {scene:?}"));
        let tallies = tallies(&mut methods, &view, poses);
        for ((name, _), tally) in methods.iter().zip(tallies) {
            let percentage = 100.0 * tally.wrong() as f64 / tally.surface as f64;
            let decimals = usize::from(percentage > 0.0 && percentage < 10.0);
            let (figure, current) = (row(name)[column], format!("{percentage:.decimals$}"));
            if figure != current {
                stale.push(format!("{name} ({scene}): {current}, not {figure}"));
            }
        }
    }
    assert!(stale.is_empty(), "the README's table should have\n{}", stale.join("\n"));
}

/// The figures in the README's text. In its words, `#` stands for a figure, which must be this value, rounded
/// to as many decimals as the README gives it. After "about" it may be a tenth more or less, because times
/// differ from one run to the next.
#[test]
fn the_readmes_figures_are_those_measured() {
    let table = measured();
    let row = |name: &str| &table.iter().find(|row| row.0 == name).unwrap().1;
    let times_as_fast = |fast, slow| row(slow)[0] / row(fast)[0];
    let in_classic = |columns: &[usize]| {
        let row = row("classic x1");
        100.0 * columns.iter().map(|&column| row[column]).sum::<f64>() / row[1]
    };
    let (errors, hours) = (drift(), |frame: f64| frame / 30.0 / 3600.0);
    let whole_turn = errors.iter().find(|error| error.1 > TAU).unwrap().0;
    // Two frames well after A has begun to turn too fast. Between them, the error grows by the excess of A's
    // turn.
    let late: Vec<_> = errors.iter().filter(|error| error.0 > 1.2 * FASTER).take(2).collect();
    let excess = (late[1].1 - late[0].1) / (late[1].0 - late[0].0);
    let readme = read("README.md").split_whitespace().collect::<Vec<_>>().join(" ");
    let mut stale = Vec::new();
    for (words, value) in [
        ("It is about # times as fast as a literal", times_as_fast("exact", "donut.c as written")),
        ("about # times as fast as the closed form", times_as_fast("exact", "closed form f64")),
        ("Classic is about # times as fast", times_as_fast("classic x1", "donut.c as written")),
        ("in #% of the donut's cells", in_classic(&[2, 4])),
        ("a rim of wrong cells, #% as many", in_classic(&[3])),
        ("errors add up to a whole turn in # hours", hours(whole_turn)),
        ("After # hours the floats", hours(FASTER)),
        ("the donut turns #% too fast", 100.0 * excess / 0.04),
        ("after # days it stands still", hours(STOPPED) / 24.0),
    ] {
        let (before, after) = words.split_once('#').unwrap();
        let between = readme.split(before).skip(1).filter_map(|rest| rest.split_once(after));
        let mut found = between.map(|(text, _)| text).filter(|text| text.parse::<f64>().is_ok());
        let figure = found.next().unwrap_or_else(|| panic!("the README does not say {words:?}"));
        let decimals = figure.split_once('.').map_or(0, |(_, decimals)| decimals.len());
        let current = format!("{value:.decimals$}");
        let off = (figure.parse::<f64>().unwrap() / value - 1.0).abs();
        if figure != current && !(before.ends_with("about ") && off < 0.1) {
            stale.push(format!("{words}: {current}, not {figure}"));
        }
    }
    assert!(stale.is_empty(), "in the README, # should be\n{}", stale.join("\n"));
}
