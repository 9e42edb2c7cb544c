//! How long each method takes for a frame, and how many of its cells are wrong; and the pictures and the
//! tables of the README and of the study, which is tests/chart/README.md.
//!
//! The study has the commands that measure again. They write its CSV file, and all that follows from it.

mod average;
mod film;
mod other_methods;
mod picture;
mod plot;

use self::average::Average;
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
        for (name, factor) in [("x2", 2.0), ("x1/2", 0.5)] {
            let renderer = with_steps(view, factor * theta, factor * phi);
            methods.push(own_method(&format!("classic steps {name}"), renderer));
        }
    }
    for n in [2, 3, 4] {
        let draw = move |a, b| averaged(&view, a, b, n);
        methods.push((format!("exact with {n} by {n} rays"), Box::new(draw)));
    }
    methods.extend([
        own_method("exact", Renderer::new(view, Method::Exact)),
        // These two are measured in another build.
        own_method("exact with AVX2", Renderer::new(view, Method::Exact)),
        tracing("closed form with AVX2", view, closed_form),
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

/// The pictures in which both are measured: donut.c's own, and a full screen.
const SIZES: [&str; 2] = ["80x22", "200x60"];

/// For each of the two, its name, its view, and the number of poses in which cells are counted.
fn sizes() -> [(&'static str, View, usize); 2] {
    [(SIZES[0], View::DONUT_C, 50), (SIZES[1], fitted(200, 60), 10)]
}

/// The microseconds that a method takes for a frame: the median, and the lowest and the highest median
/// of a series.
type Time = [f64; 3];

/// The contents of TIMES: a row for each method, with its time for a frame, and with what the two rules
/// say.
fn table_of_times(time: impl Fn(&str, &str) -> Time) -> String {
    let times = "us per frame,lowest,highest";
    let by_centre = "cells of the donut,wrong shades,extra outline,holes";
    let by_average = "cells of the average,different,far off";
    let mut table = format!("size,method,{times},{by_centre},{by_average}\n");
    for (size, view, poses) in sizes() {
        let poses = donut_c_poses(poses);
        let averages = average::count(methods(view), view, poses.clone());
        for ((name, tally), average) in count(methods(view), view, poses).into_iter().zip(averages)
        {
            let [median, lowest, highest] = time(size, &name);
            table += &format!("{size},{name},{median:.1},{lowest:.1},{highest:.1}");
            let Tally { surface, shades, extra, holes, .. } = tally;
            table += &format!(",{surface},{shades},{extra},{holes}");
            let Average { surface, different, far_off } = average;
            table += &format!(",{surface},{different},{far_off}\n");
        }
    }
    table
}

/// The median of these, which become sorted.
fn median(numbers: &mut [f64]) -> f64 {
    numbers.sort_by(f64::total_cmp);
    numbers[numbers.len() / 2]
}

/// The time of each method. The methods take turns until the time is up, so that whatever else the
/// computer does slows all of them down. In its turn, a method draws a series of 200 frames, 40
/// consecutive ones from each of five poses, as it would in the program.
fn times_in_turns(mut methods: Vec<NamedMethod>, seconds: u64) -> Vec<Time> {
    let mut medians = vec![Vec::new(); methods.len()];
    let start = Instant::now();
    while start.elapsed().as_secs() < seconds {
        for ((_, draw), medians) in methods.iter_mut().zip(&mut medians) {
            let mut series = Vec::new();
            for (a, b) in donut_c_poses(5) {
                for frame in (0..40).map(f64::from) {
                    let start = Instant::now();
                    draw(a + 0.04 * frame, b + 0.02 * frame);
                    series.push(start.elapsed().as_secs_f64() * 1e6);
                }
            }
            medians.push(median(&mut series));
        }
    }
    medians.iter_mut().map(|medians| summary(medians)).collect()
}

/// The time of a method that took these microseconds for a frame, in several series.
fn summary(series: &mut [f64]) -> Time {
    [median(series), series[0], series[series.len() - 1]]
}

/// The time of the C program, in five series of 2,000 frames. It is processor time in user mode: writing
/// is not counted, since the system does that. The frames must be those of classic, byte for byte.
fn time_in_c(source: &str) -> Time {
    const FRAMES: u32 = 2_000;
    let program = env::temp_dir().join(format!("donut-c-{}", process::id()));
    let program = program.to_str().unwrap();
    let options = ["-std=gnu89", "-O2", "-w", source, "-o", program, "-lm"];
    assert!(Command::new("gcc").args(options).status().unwrap().success());
    let mut donut_c = Program::start(program, "", Stdio::piped());
    fs::remove_file(program).unwrap();
    let mut pipe = donut_c.0.stdout.take().unwrap();
    let (mut classic, mut angles) = (Renderer::new(View::DONUT_C, Method::Classic), [0.0; 2]);
    let (mut ticks, mut series) = (0.0, [0.0; 5]);
    for (n, micros) in series.iter_mut().enumerate() {
        for frame in 0..FRAMES {
            classic.render_frame(angles[0], angles[1]);
            angles = classic.advance(angles, [0.04, 0.02]);
            let expected = classic.encode(None, false, n == 0 && frame == 0).unwrap();
            let mut written = vec![0; expected.len()];
            pipe.read_exact(&mut written).unwrap();
            assert!(written == expected, "frame {frame} of series {n}");
        }
        // Of the columns after the name in brackets, this is the 12th. It is in hundredths of a second.
        // The C program is ahead by what fits into the pipe, about 40 frames.
        let status = fs::read_to_string(format!("/proc/{}/stat", donut_c.0.id())).unwrap();
        let (_, columns) = status.rsplit_once(") ").unwrap();
        let ticks_before = ticks;
        ticks = columns.split(' ').nth(11).unwrap().parse().unwrap();
        *micros = (ticks - ticks_before) * 1e4 / f64::from(FRAMES);
    }
    summary(&mut series)
}

/// The processor, and the versions of what built the two programs.
fn machine() -> String {
    let first_line = |program: &str, option: &str| {
        let output = Command::new(program).arg(option).output().unwrap();
        String::from_utf8(output.stdout).unwrap().lines().next().unwrap().to_string()
    };
    let processor = fs::read_to_string("/proc/cpuinfo").unwrap();
    let model = processor.lines().find_map(|line| line.strip_prefix("model name\t: ")).unwrap();
    let [rustc, gcc] = ["rustc", "gcc"].map(|program| first_line(program, "--version"));
    let library = first_line("getconf", "GNU_LIBC_VERSION");
    format!("- {model}\n- {rustc}\n- {gcc}\n- {library}\n")
}

/// A row of TIMES. Wrong and different cells are in per cent of those that show the donut.
struct Measured {
    name: String,
    time: Time,
    holes: f64,
    wrong: f64,
    different: f64,
    far_off: f64,
}

fn measured(size: &str) -> Vec<Measured> {
    let (table, size) = (read(TIMES), format!("{size},"));
    let rows = table.lines().filter_map(|line| line.strip_prefix(&size)?.split_once(','));
    let rows = rows.map(|(name, figures)| {
        let figures: Vec<f64> = figures.split(',').map(|figure| figure.parse().unwrap()).collect();
        Measured {
            name: name.into(),
            time: [figures[0], figures[1], figures[2]],
            holes: 100.0 * figures[6] / figures[3],
            wrong: 100.0 * figures[4..7].iter().sum::<f64>() / figures[3],
            different: 100.0 * figures[8] / figures[7],
            far_off: 100.0 * figures[9] / figures[7],
        }
    });
    rows.collect()
}

fn find(size: &str, method: &str) -> Option<Measured> {
    measured(size).into_iter().find(|row| row.name == method)
}

/// A column of a table: its head, where # stands for a size, and its figures.
type Column = (&'static str, fn(&Measured) -> String);

/// A table with a row for each of these methods, and with these columns for each of the sizes. A method
/// is given by its name in TIMES, after which its name in the text may follow. Where it does not draw a
/// size, it has no figures.
fn table(methods: &[&str], sizes: &[&str], columns: &[Column]) -> String {
    let row = |first: &str, cell: &dyn Fn(&str, &Column) -> String| {
        let cells = sizes.iter().flat_map(|size| columns.iter().map(|column| cell(size, column)));
        std::iter::once(first.into()).chain(cells).collect::<Vec<_>>()
    };
    let mut rows = vec![row("", &|size, (head, _)| head.replace('#', size))];
    for method in methods {
        let (method, name) = method.split_once(": ").unwrap_or((method, method));
        rows.push(row(name, &|size, (_, figure)| {
            find(size, method).as_ref().map_or("".into(), figure)
        }));
    }
    markdown(rows)
}

/// A number of per cent: without decimals from 10 on, and 0 only for none.
fn share(number: f64) -> String {
    match number {
        0.0 => "0".into(),
        ..0.05 => "<0.05".into(),
        ..9.95 => format!("{number:.1}"),
        _ => format!("{number:.0}"),
    }
}

/// A time and its range.
fn micros(measured: &Measured) -> String {
    let [median, lowest, highest] =
        measured.time.map(|time| format!("{time:.*}", usize::from(time < 99.95)));
    format!("{median} ({lowest} to {highest})")
}

/// The README's table.
fn times() -> String {
    let methods = [
        "donut.c (C): donut.c in C (`gcc -O2`), with `putchar`",
        "classic: classic, which draws the same at 80x22",
        "exact",
    ];
    table(&methods, &SIZES, &[("#", |measured| format!("{:.0} µs", measured.time[0]))])
}

/// The study's tables of TIMES, and the name of each.
fn study_tables() -> [(&'static str, String); 4] {
    let averages = [
        "classic",
        "exact",
        "exact with 2 by 2 rays",
        "exact with 3 by 3 rays",
        "exact with 4 by 4 rays",
    ];
    let all = [
        "donut.c (C): donut.c in C, with `putchar`",
        "donut.c (translated): donut.c in Rust",
        "classic: **classic**",
        "exact: **exact**",
        "closed form: **closed form**",
        averages[2],
        averages[3],
        averages[4],
        "Newton from one start",
        "Ferrari f32: Ferrari in f32",
        "Ferrari f64: Ferrari in f64",
        "sphere tracing 8: sphere tracing, 8 steps",
        "sphere tracing 16: 16 steps",
        "sphere tracing 32: 32 steps",
        "sphere tracing 64: 64 steps",
        "sphere tracing 256: 256 steps",
    ];
    let rays = [
        "exact one ray at a time: exact, one ray at a time",
        "exact",
        "exact with AVX2",
        "closed form one ray at a time: closed form, one ray at a time",
        "closed form",
        "closed form with AVX2",
    ];
    let steps = [
        "classic",
        "classic steps x2: steps twice as long",
        "classic steps x1/2: steps half as long",
        "classic with donut.c's steps: donut.c's steps",
    ];
    let times: Column = ("#: µs", micros);
    let wrong: Column = ("wrong", |measured| share(measured.wrong));
    let different: Column = ("different", |measured| share(measured.different));
    let far_off: Column = ("far off", |measured| share(measured.far_off));
    let blank: Column = ("blank", |measured| share(measured.holes));
    [
        ("average", table(&averages, &SIZES[..1], &[different, far_off])),
        ("methods", table(&all, &SIZES, &[times, wrong, different])),
        ("rays", table(&rays, &SIZES, &[times])),
        ("steps", table(&steps, &SIZES, &[times, wrong, blank, far_off])),
    ]
}

/// The study in short.
fn short() -> String {
    let [exact, closed_form, classic] = ["exact", "closed form", "classic"]
        .map(|method| SIZES.map(|size| find(size, method).unwrap()));
    let times = |method: &[Measured; 2]| {
        let [small, large] = [0, 1].map(|i| method[i].time[0] / exact[i].time[0]);
        format!(
            "{small:.1} times as long as exact, and {large:.1} times as\n  long for a full screen."
        )
    };
    format!(
        "- By its own rule, exact draws no wrong cell in any scene of this study. It takes {:.0} µs for a frame\n  \
         of donut.c's own picture, and {:.0} µs for a full screen.\n\
         - The closed form draws the same pictures. It takes {}\n\
         - Classic draws donut.c's picture, byte for byte. It takes {}\n\
         - By a rule that no method follows, the average over each cell, classic differs in {} cells for every\n  \
         100 that the donut covers, and exact in {}.\n",
        exact[0].time[0],
        exact[1].time[0],
        times(&closed_form),
        times(&classic),
        share(classic[0].different),
        share(exact[0].different),
    )
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

/// Two tables: the wrong cells of each method in each scene, in per cent of the donut's cells; and for
/// each scene, the number of its poses, of the donut's cells, and of the ties.
fn failure_tables() -> [(&'static str, String); 2] {
    let mut failures = vec![vec![String::new()]];
    failures.extend(COMPARED.map(|name| vec![name.into()]));
    let mut cells = vec![["scene", "poses", "the donut's cells", "ties"].map(String::from).into()];
    for (scene, view, poses) in scenes() {
        let compared = methods(view).into_iter().filter(|method| COMPARED.contains(&&*method.0));
        let tallies = count(compared.collect(), view, poses.clone());
        let tally = |name| tallies.iter().find(|(other, _)| other == name).map(|(_, tally)| tally);
        let wrong = |tally: &Tally| share(100.0 * tally.wrong() as f64 / tally.surface as f64);
        let [exact, closed_form] = ["exact", "closed form"].map(|name| tally(name).unwrap());
        assert_eq!(exact.wrong() + closed_form.wrong(), 0, "the study says that none is wrong");
        let numbers = [poses.len(), exact.surface, exact.ties].map(|number| number.to_string());
        cells.push([&[scene.into()], &numbers[..]].concat());
        failures[0].push(scene.into());
        for (row, name) in failures[1..].iter_mut().zip(COMPARED) {
            row.push(tally(name).map_or("-".into(), wrong));
        }
    }
    [("failures", markdown(failures)), ("scenes", markdown(cells))]
}

// ---- Files ---------------------------------------------------------------------------------------

/// A table in Markdown. The first row is its head, and all columns but the first are aligned to the
/// right.
fn markdown(mut rows: Vec<Vec<String>>) -> String {
    let width = |i: usize| rows.iter().map(|row| row[i].chars().count()).max().unwrap().max(3);
    let widths: Vec<_> = (0..rows[0].len()).map(width).collect();
    let rule = |(i, &width): (usize, _)| "-".repeat(width - 1) + if i == 0 { "-" } else { ":" };
    rows.insert(1, widths.iter().enumerate().map(rule).collect());
    let line = |row: &Vec<String>| {
        let cells = row.iter().zip(&widths).map(|(cell, &width)| format!("| {cell:width$} "));
        cells.collect::<String>() + "|\n"
    };
    rows.iter().map(line).collect()
}

/// The text with this part between its marks, `<!-- name -->` and `<!-- /name -->`.
fn with_part(text: &str, name: &str, part: &str) -> String {
    let [start, end] = ["", "/"].map(|slash| format!("<!-- {slash}{name} -->\n"));
    let (before, rest) = text.split_once(&start).expect(&start);
    let (_, after) = rest.split_once(&end).expect(&end);
    format!("{before}{start}{part}{end}{after}")
}

/// The names and contents of the files that follow from TIMES and from the program.
fn derived_files() -> [(&'static str, String); 7] {
    let mut study = with_part(&read(STUDY), "short", &short());
    for (name, table) in study_tables().into_iter().chain(failure_tables()) {
        study = with_part(&study, name, &table);
    }
    [
        ("README.md", with_part(&read("README.md"), "times", &times())),
        (STUDY, study),
        ("tests/donut.svg", film::film()),
        ("tests/methods.svg", picture::two_methods()),
        ("tests/chart/failures.svg", picture::failures()),
        ("tests/speed-and-accuracy.svg", plot::readme()),
        ("tests/chart/speed-and-accuracy.svg", plot::study()),
    ]
}

/// Measures all methods and writes all files; or, in a build with AVX2, only measures the two methods
/// that have it in their name, and writes their times into TIMES. (In such a build, wide's functions
/// round in another way, and some methods that fail get other cells wrong.)
#[test]
#[ignore = "measures for minutes"]
fn measure() {
    let has_avx2 = cfg!(target_feature = "avx2");
    let mut times = HashMap::new();
    for (size, view, _) in sizes() {
        let mut methods = methods(view);
        methods.retain(|(name, _)| name.ends_with("AVX2") == has_avx2);
        let names: Vec<_> = methods.iter().map(|(name, _)| format!("{size},{name}")).collect();
        times.extend(names.into_iter().zip(times_in_turns(methods, 30)));
    }
    if has_avx2 {
        let table = read(TIMES);
        let rows = table.lines().map(|row| {
            let mut columns: Vec<_> = row.split(',').map(String::from).collect();
            if let Some(time) = times.get(&columns[..2].join(",")) {
                columns.splice(2..5, time.map(|time| format!("{time:.1}")));
            }
            columns.join(",") + "\n"
        });
        return fs::write(path(TIMES), rows.collect::<String>()).unwrap();
    }
    for pose in donut_c_poses(50) {
        average::compare_with_oracle(View::DONUT_C, pose);
    }
    let source = env::var("DONUT_C").expect("DONUT_C, the path of donut.c's source");
    times.insert("80x22,donut.c (C)".into(), time_in_c(&source));
    let table = table_of_times(|size, method| {
        let measured = times.get(&format!("{size},{method}")).copied();
        measured.unwrap_or_else(|| find(size, method).expect(method).time)
    });
    println!("{table}");
    fs::write(path(TIMES), table).unwrap();
    fs::write(path(STUDY), with_part(&read(STUDY), "machine", &machine())).unwrap();
    for (name, contents) in derived_files() {
        fs::write(path(name), contents).unwrap();
    }
}

/// Of TIMES, only the times are measured.
#[test]
fn the_pictures_and_the_tables_are_up_to_date() {
    let stored = |size: &str, method: &str| find(size, method).expect(method).time;
    assert_current(TIMES, &table_of_times(stored));
    for (name, contents) in derived_files() {
        assert!(contents.len() < 400_000, "{name} is too much for a page to load");
        assert_current(name, &contents);
    }
}
