//! How long each method takes for a frame, and how many of its cells are wrong; and the pictures and the
//! tables of the README and of the study, which is tests/chart/README.md.
//!
//! `cargo test --release chart -- --ignored --nocapture` measures again. It writes the two tables of
//! tests/chart, and all that follows from them. If the environment variable `DONUT_C` is the path of
//! donut.c's source, the C program is measured as well; otherwise, its stored time is kept.

mod average;
mod other_methods;
mod picture;

use self::other_methods::*;
use super::classic::{donut_c, with_steps};
use super::one_ray::trace_one_by_one;
use super::program::Program;
use super::*;
use std::collections::HashMap;
use std::io::Read;
use std::process::{Command, Stdio};

/// A method of this program, or another one to compare it with: its name, and how it draws a pose.
type NamedMethod = (String, Box<dyn FnMut(f64, f64) -> Vec<u8> + Send>);

const TIMES: &str = "tests/chart/speed-and-accuracy.csv";
const STUDY: &str = "tests/chart/README.md";

fn own_method(name: &str, mut renderer: Renderer) -> NamedMethod {
    let draw = move |a, b| {
        renderer.render_frame(a, b);
        renderer.framebuffer.clone()
    };
    (name.into(), Box::new(draw))
}

/// A method that differs from exact only in how it finds the hits of eight rays.
fn tracing(
    name: &str,
    view: View,
    first_hits: impl Fn(&Torus, &Rays) -> f64x8 + Send + 'static,
) -> NamedMethod {
    (name.into(), Box::new(move |a, b| trace_eight_by_eight(&view, a, b, &first_hits)))
}

/// A method that follows one ray after another. `hit` finds the s of a ray's first hit.
fn ray_by_ray(
    name: &str,
    view: View,
    hit: impl Fn(&Torus, &Ray) -> f64 + Send + 'static,
) -> NamedMethod {
    (name.into(), Box::new(move |a, b| trace_one_by_one(&view, a, b, &hit)))
}

/// All methods that can draw a view.
fn methods(view: View) -> Vec<NamedMethod> {
    let mut methods =
        vec![own_method("classic with donut.c's steps", with_steps(view, 0.07, 0.02))];
    if view == View::DONUT_C {
        // The C program's frames are those of classic. Its time is measured in another way.
        methods.push(own_method("donut.c (C)", Renderer::new(view, Method::Classic)));
        let translated = move |a, b| donut_c(&view, a, b);
        methods.push(("donut.c (translated)".into(), Box::new(translated)));
    }
    if (view.r2, view.k2) == (2.0, 5.0) {
        let [theta, phi] = angle_steps(&view);
        methods.push(own_method("classic", Renderer::new(view, Method::Classic)));
        for (name, factor) in [("x2", 2.0), ("x1/2", 0.5), ("x1/4", 0.25)] {
            let renderer = with_steps(view, factor * theta, factor * phi);
            methods.push(own_method(&format!("classic steps {name}"), renderer));
        }
    }
    methods.extend([
        own_method("exact", Renderer::new(view, Method::Exact)),
        ray_by_ray("exact one ray at a time", view, |torus, ray| {
            ray.first_hit(ray.entry(torus.r2))
        }),
        tracing("closed form", view, closed_form),
        ray_by_ray("closed form one ray at a time", view, |_, ray| closed_form_alone(ray)),
        tracing("Newton from one start", view, newton_once),
        tracing("Ferrari f32", view, move |torus, rays| textbook_f32(torus, view.k2, rays)),
        tracing("Ferrari f64", view, move |torus, rays| textbook_f64(torus, view.k2, rays)),
    ]);
    for most_steps in [8, 16, 32, 64, 256] {
        let name = format!("sphere tracing {most_steps}");
        methods.push(tracing(&name, view, sphere_tracing(most_steps)));
    }
    methods
}

/// The name of each method, and its tally in these poses.
fn count(
    mut methods: Vec<NamedMethod>,
    view: View,
    poses: Vec<(f64, f64)>,
) -> Vec<(String, Tally)> {
    within_a_minute(move || {
        let mut tallies: Vec<_> = methods.iter().map(|_| Tally::default()).collect();
        for (a, b) in poses {
            let pictures: Vec<_> = methods.iter_mut().map(|(_, draw)| draw(a, b)).collect();
            add_pictures(&mut tallies, &view, (a, b), &pictures);
        }
        methods.into_iter().map(|(name, _)| name).zip(tallies).collect()
    })
}

// ---- Speed and accuracy --------------------------------------------------------------------------

/// The pictures in which both are measured, donut.c's own and a full screen: for each, its name, its view,
/// and the number of poses in which wrong cells are counted.
fn sizes() -> [(&'static str, View, usize); 2] {
    [("80x22", View::DONUT_C, 50), ("200x60", fitted(200, 60), 10)]
}

/// The contents of TIMES: a row for each method, with its time for a frame, and with its wrong cells.
fn table_of_times(time: impl Fn(&str, &str) -> f64) -> String {
    let columns = "us per frame,cells of the donut,wrong shades,extra outline,holes";
    let mut table = format!("size,method,{columns}\n");
    for (size, view, poses) in sizes() {
        for (name, tally) in count(methods(view), view, donut_c_poses(poses)) {
            let Tally { surface, shades, extra, holes, .. } = tally;
            let time = time(size, &name);
            table += &format!("{size},{name},{time:.1},{surface},{shades},{extra},{holes}\n");
        }
    }
    table
}

/// The median of the microseconds that each method takes for a frame. The methods take turns until the time
/// is up, so that whatever else the computer does slows all of them down. In its turn, a method draws five
/// runs of 40 consecutive frames, as it would in the program.
fn micros(mut methods: Vec<NamedMethod>, seconds: u64) -> Vec<f64> {
    let mut samples = vec![Vec::new(); methods.len()];
    let start = Instant::now();
    while start.elapsed().as_secs() < seconds {
        for ((_, draw), samples) in methods.iter_mut().zip(&mut samples) {
            for (a, b) in donut_c_poses(5) {
                for frame in (0..40).map(f64::from) {
                    let start = Instant::now();
                    draw(a + 0.04 * frame, b + 0.02 * frame);
                    samples.push(start.elapsed().as_secs_f64() * 1e6);
                }
            }
        }
    }
    samples.iter_mut().for_each(|samples| samples.sort_by(f64::total_cmp));
    samples.iter().map(|samples| samples[samples.len() / 2]).collect()
}

/// The microseconds that the C program takes for a frame, of processor time in user mode: writing is not
/// counted, since the system does that. Its first 10,000 frames must be those of classic, byte for byte.
fn micros_in_c(source: &str) -> f64 {
    const FRAMES: u32 = 10_000;
    let program = env::temp_dir().join(format!("donut-c-{}", process::id()));
    let program = program.to_str().unwrap();
    let options = ["-std=gnu89", "-O2", "-w", source, "-o", program, "-lm"];
    assert!(Command::new("gcc").args(options).status().unwrap().success());
    let mut donut_c = Program::start(program, "", Stdio::piped());
    fs::remove_file(program).unwrap();
    let mut pipe = donut_c.0.stdout.take().unwrap();
    let (mut classic, mut angles) = (Renderer::new(View::DONUT_C, Method::Classic), [0.0; 2]);
    for frame in 0..FRAMES {
        classic.render_frame(angles[0], angles[1]);
        angles = classic.advance(angles, [0.04, 0.02]);
        let expected = classic.encode(None, false, frame == 0).unwrap();
        let mut written = vec![0; expected.len()];
        pipe.read_exact(&mut written).unwrap();
        assert!(written == expected, "frame {frame}");
    }
    // Of the columns after the name in brackets, this is the 12th. It is in hundredths of a second. The C
    // program is ahead by what fits into the pipe, about 40 frames.
    let status = fs::read_to_string(format!("/proc/{}/stat", donut_c.0.id())).unwrap();
    let (_, columns) = status.rsplit_once(") ").unwrap();
    let ticks: f64 = columns.split(' ').nth(11).unwrap().parse().unwrap();
    ticks * 1e4 / f64::from(FRAMES)
}

/// The methods in TIMES at a size: the name of each, its time for a frame in microseconds, and its wrong
/// cells in per cent.
fn measured(size: &str) -> Vec<(String, f64, f64)> {
    let (table, size) = (read(TIMES), format!("{size},"));
    let rows = table.lines().filter_map(|line| line.strip_prefix(&size)?.split_once(','));
    let rows = rows.map(|(name, figures)| {
        let figures: Vec<f64> = figures.split(',').map(|figure| figure.parse().unwrap()).collect();
        (name.into(), figures[0], 100.0 * figures[2..].iter().sum::<f64>() / figures[1])
    });
    rows.collect()
}

fn time(size: &str, method: &str) -> Option<f64> {
    measured(size).into_iter().find(|row| row.0 == method).map(|row| row.1)
}

/// What computing 30 frames a second takes, in per cent of a core, with two digits.
fn load_table() -> String {
    let load = |micros: f64| {
        let load = 100.0 * 30.0 * micros / 1e6;
        format!("{load:.*}%", (1.0 - load.log10().floor()).max(0.0) as usize)
    };
    let mut rows = vec![["", "80x22", "200x60, a full screen"].map(String::from).into()];
    for (method, name) in [
        ("donut.c (C)", "donut.c in C (`gcc -O2`)"),
        ("donut.c (translated)", "donut.c, translated"),
        ("classic", "classic"),
        ("exact", "exact"),
    ] {
        let cells = ["80x22", "200x60"].map(|size| time(size, method).map_or("".into(), load));
        rows.push([&[name.into()], &cells[..]].concat());
    }
    markdown(rows)
}

// ---- Where methods fail --------------------------------------------------------------------------

const COMPARED: [&str; 9] = [
    "classic",
    "classic with donut.c's steps",
    "sphere tracing 16",
    "sphere tracing 64",
    "Newton from one start",
    "Ferrari f32",
    "Ferrari f64",
    "closed form",
    "exact",
];

/// A scene in which the study compares methods: its name, its view, and its poses.
type NamedScene = (&'static str, View, Vec<(f64, f64)>);

fn scenes() -> [NamedScene; 8] {
    let scene = |r2, k2| View::fitted(160, 44, 2.0, r2, k2);
    let poses = donut_c_poses(10);
    let edge_on = poses.iter().map(|&(_, b)| (TAU / 4.0 + 1e-4, b)).collect();
    [
        ("80x22", View::DONUT_C, donut_c_poses(50)),
        ("160x44", scene(2.0, 5.0), poses.clone()),
        ("320x88", fitted(320, 88), poses.clone()),
        ("edge-on", scene(2.0, 5.0), edge_on),
        ("`--r2 9 --k2 25`", scene(9.0, 25.0), poses.clone()),
        ("`--k2 3.03`", scene(2.0, 3.03), poses.clone()),
        ("`--k2 50`", scene(2.0, 50.0), poses.clone()),
        ("`--k2 50000`", scene(2.0, 50_000.0), poses),
    ]
}

/// The wrong cells of each method in each scene, in per cent of the donut's cells.
fn failure_table() -> String {
    let mut rows = vec![vec![String::new()]];
    rows.extend(
        COMPARED.iter().chain(&["the donut's cells", "ties"]).map(|&name| vec![name.into()]),
    );
    for (scene, view, poses) in scenes() {
        let compared = methods(view).into_iter().filter(|method| COMPARED.contains(&&*method.0));
        let tallies = count(compared.collect(), view, poses);
        let tally = |name| tallies.iter().find(|(other, _)| other == name).map(|(_, tally)| tally);
        let share = |tally: &Tally| {
            let share = 100.0 * tally.wrong() as f64 / tally.surface as f64;
            let decimals = usize::from(share > 0.0 && share < 10.0);
            format!("{share:.decimals$}")
        };
        let mut column = vec![scene.into()];
        column.extend(COMPARED.map(|name| tally(name).map_or("-".into(), share)));
        let exact = tally("exact").unwrap();
        column.extend([exact.surface.to_string(), exact.ties.to_string()]);
        rows.iter_mut().zip(column).for_each(|(row, cell)| row.push(cell));
    }
    markdown(rows)
}

// ---- Files ---------------------------------------------------------------------------------------

/// A table in Markdown. The first row is its head, and all columns but the first are aligned to the right.
fn markdown(mut rows: Vec<Vec<String>>) -> String {
    let width = |i: usize| rows.iter().map(|row| row[i].len()).max().unwrap();
    let widths: Vec<_> = (0..rows[0].len()).map(width).collect();
    let rule = |(i, &width): (usize, _)| "-".repeat(width - 1) + if i == 0 { "-" } else { ":" };
    rows.insert(1, widths.iter().enumerate().map(rule).collect());
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("| {cell:width$} "));
        cells.collect::<String>() + "|\n"
    };
    rows.iter().map(line).collect()
}

/// The text with this table between its marks, `<!-- name -->` and `<!-- /name -->`.
fn with_table(text: &str, name: &str, table: &str) -> String {
    let [start, end] = ["", "/"].map(|slash| format!("<!-- {slash}{name} -->\n"));
    let (before, rest) = text.split_once(&start).expect(&start);
    let (_, after) = rest.split_once(&end).expect(&end);
    format!("{before}{start}{table}{end}{after}")
}

/// The names and contents of the files that follow from the measurements and from the program. Of TIMES, only
/// the times are measured.
fn derived_files() -> [(&'static str, String); 8] {
    let study = with_table(&read(STUDY), "failures", &failure_table());
    [
        (TIMES, table_of_times(|size, method| time(size, method).expect(method))),
        ("README.md", with_table(&read("README.md"), "load", &load_table())),
        (STUDY, with_table(&study, "average", &average::table())),
        ("tests/donut.svg", picture::moving()),
        ("tests/methods.svg", picture::two_methods()),
        ("tests/chart/failures.svg", picture::failures()),
        ("tests/speed-and-accuracy.svg", picture::one_size()),
        ("tests/chart/speed-and-accuracy.svg", picture::two_sizes()),
    ]
}

#[test]
#[ignore = "measures for minutes"]
fn measure_and_write_all_that_follows() {
    let mut times = HashMap::new();
    for (size, view, _) in sizes() {
        let names = methods(view).into_iter().map(|(name, _)| format!("{size},{name}"));
        times.extend(names.zip(micros(methods(view), 30)));
    }
    let in_c = match env::var("DONUT_C") {
        Ok(source) => micros_in_c(&source),
        Err(_) => time("80x22", "donut.c (C)").unwrap(),
    };
    times.insert("80x22,donut.c (C)".into(), in_c);
    let table = table_of_times(|size, method| times[&format!("{size},{method}")]);
    fs::write(path(TIMES), &table).unwrap();
    println!("{table}");
    average::measure();
    for (name, contents) in derived_files() {
        fs::write(path(name), contents).unwrap();
    }
}

#[test]
fn the_pictures_and_the_tables_are_up_to_date() {
    for (name, contents) in derived_files() {
        assert!(contents.len() < 400_000, "{name} is too much for a page to load");
        assert_current(name, &contents);
    }
}
