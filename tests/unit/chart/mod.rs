//! How long each method takes for a frame, and how many of its cells are wrong; the pictures of the README
//! and of the study, which is tests/chart/README.md; and the tables of the study.
//!
//! The study has the command that measures again. It writes its CSV file, and all that follows from it.

mod average;
mod film;
mod other_methods;
mod picture;
mod plot;

use self::other_methods::*;
use super::classic::{donut_c, with_steps};
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
    let draw = move |a, b| {
        let mut framebuffer = vec![b' '; view.width * view.height];
        follow::<1>(&view, (a, b), &first_hits, |cell, luminance| {
            framebuffer[cell] = glyph(luminance + TIE_BIAS);
        });
        framebuffer
    };
    (name.into(), Box::new(draw))
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
        methods.push(own_method("classic", Renderer::new(view, Method::Classic)));
    }
    methods.extend([
        ("exact with 2 by 2 rays".into(), Box::new(move |a, b| averaged::<2>(&view, a, b)) as _),
        ("exact with 3 by 3 rays".into(), Box::new(move |a, b| averaged::<3>(&view, a, b)) as _),
        own_method("exact", Renderer::new(view, Method::Exact)),
        tracing("closed form", view, closed_form),
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
    in_time(move || {
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

/// In frames 0 to 599 of donut.c's own motion, but the first and the last: how many cells show the donut, and
/// how many flicker, because they show the same before and after, and something else in between.
fn flicker(mut draw: impl FnMut(f64, f64) -> Vec<u8>) -> [usize; 2] {
    let frames: Vec<_> = (0..600).map(f64::from).map(|n| draw(0.04 * n, 0.02 * n)).collect();
    let (mut surface, mut flickering) = (0, 0);
    for three in frames.windows(3) {
        for ((before, now), after) in three[0].iter().zip(&three[1]).zip(&three[2]) {
            surface += usize::from(*now != b' ');
            flickering += usize::from(before == after && before != now);
        }
    }
    [surface, flickering]
}

/// The contents of TIMES: a row for each method, with its time for a frame, with what the two rules say, and
/// with what flickers.
fn table_of_times(time: impl Fn(&str, &str) -> Time) -> String {
    let times = "us per frame,lowest,highest";
    let by_centre = "cells of the donut,wrong shades,extra outline,holes";
    let by_average = "cells of the average,different,far off";
    let in_motion = "cells in motion,flickering";
    let mut table = format!("size,method,{times},{by_centre},{by_average},{in_motion}\n");
    for (size, view, poses) in sizes() {
        let poses = donut_c_poses(poses);
        let flickers = methods(view).into_iter().map(|(_, draw)| thread::spawn(|| flicker(draw)));
        let flickers: Vec<_> = flickers.collect();
        let averages = average::count(methods(view), view, poses.clone());
        let tallies = count(methods(view), view, poses).into_iter();
        for (((name, tally), average), flicker) in tallies.zip(averages).zip(flickers) {
            let [median, lowest, highest] = time(size, &name);
            table += &format!("{size},{name},{median:.1},{lowest:.1},{highest:.1}");
            let by_centre = [tally.surface, tally.shades, tally.extra, tally.holes];
            for count in by_centre.into_iter().chain(average).chain(flicker.join().unwrap()) {
                table += &format!(",{count}");
            }
            table += "\n";
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

/// A row of TIMES. Wrong, different and flickering cells are in per cent of those that show the donut.
struct Measured {
    name: String,
    time: Time,
    wrong: f64,
    different: f64,
    far_off: f64,
    flicker: f64,
}

fn measured(size: &str) -> Vec<Measured> {
    let (table, size) = (read(TIMES), format!("{size},"));
    let rows = table.lines().filter_map(|line| line.strip_prefix(&size)?.split_once(','));
    let rows = rows.map(|(name, figures)| {
        let figures: Vec<f64> = figures.split(',').map(|figure| figure.parse().unwrap()).collect();
        Measured {
            name: name.into(),
            time: [figures[0], figures[1], figures[2]],
            wrong: 100.0 * figures[4..7].iter().sum::<f64>() / figures[3],
            different: 100.0 * figures[8] / figures[7],
            far_off: 100.0 * figures[9] / figures[7],
            flicker: 100.0 * figures[11] / figures[10],
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

/// The study's tables of TIMES, and the name of each.
fn study_tables() -> [(&'static str, String); 2] {
    let averages = ["classic", "exact", "exact with 2 by 2 rays", "exact with 3 by 3 rays"];
    let all = [
        "donut.c (C): donut.c in C, with `putchar`",
        "donut.c (translated): donut.c in Rust",
        "classic: **classic**",
        "classic with donut.c's steps",
        "exact: **exact**",
        "closed form: **closed form**",
        averages[2],
        averages[3],
        "Newton from one start",
        "Ferrari f32: Ferrari in f32",
        "Ferrari f64: Ferrari in f64",
        "sphere tracing 8: sphere tracing, 8 steps",
        "sphere tracing 16: 16 steps",
        "sphere tracing 32: 32 steps",
        "sphere tracing 64: 64 steps",
        "sphere tracing 256: 256 steps",
    ];
    let times: Column = ("#: µs", micros);
    let wrong: Column = ("wrong", |measured| share(measured.wrong));
    let different: Column = ("different", |measured| share(measured.different));
    let far_off: Column = ("far off", |measured| share(measured.far_off));
    let flicker: Column = ("flicker", |measured| format!("{:.2}", measured.flicker));
    [
        ("average", table(&averages, &SIZES[..1], &[different, far_off])),
        ("methods", table(&all, &SIZES, &[times, wrong, different, flicker])),
    ]
}

/// The study in short.
fn short() -> String {
    let [exact, closed_form, classic] = ["exact", "closed form", "classic"]
        .map(|method| SIZES.map(|size| find(size, method).unwrap()));
    let times = |method: &[Measured; 2]| {
        let [small, large] = [0, 1].map(|i| method[i].time[0] / exact[i].time[0]);
        format!(
            "{small:.1} times as long as exact for that picture, and {large:.1} times for a full screen."
        )
    };
    format!(
        "- By its own rule, exact draws no wrong cell in any scene of this study. It takes {:.0} µs for a frame\n  \
         of donut.c's own picture, and {:.0} µs for a full screen.\n\
         - A closed form, which is Ferrari's formula with two precautions, draws the same pictures. It takes\n  {}\n\
         - Classic draws donut.c's picture, byte for byte. It takes\n  {}\n\
         - By a rule that neither follows, the average over each cell, classic differs in {} cells of 100, and\n  \
         exact in {}.\n",
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

/// The wrong cells of each method in each scene, in per cent of the donut's cells.
fn failures() -> String {
    let mut failures = vec![vec![String::new()]];
    failures.extend(COMPARED.map(|name| vec![name.into()]));
    for (scene, view, poses) in scenes() {
        let compared = methods(view).into_iter().filter(|method| COMPARED.contains(&&*method.0));
        let tallies = count(compared.collect(), view, poses);
        let tally = |name| tallies.iter().find(|(other, _)| other == name).map(|(_, tally)| tally);
        let wrong = |tally: &Tally| share(100.0 * tally.wrong() as f64 / tally.surface as f64);
        let [exact, closed_form] = ["exact", "closed form"].map(|name| tally(name).unwrap());
        let undecided = exact.wrong() + exact.ties + closed_form.wrong();
        assert_eq!(undecided, 0, "the study says that no cell is wrong, or cannot be decided");
        failures[0].push(scene.into());
        for (row, name) in failures[1..].iter_mut().zip(COMPARED) {
            row.push(tally(name).map_or("-".into(), wrong));
        }
    }
    markdown(failures)
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
    for (name, table) in study_tables().into_iter().chain([("failures", failures())]) {
        study = with_part(&study, name, &table);
    }
    [
        (STUDY, study),
        ("tests/donut.svg", film::film()),
        ("tests/methods.svg", picture::two_methods()),
        ("tests/options.svg", picture::options()),
        ("tests/chart/failures.svg", picture::failures()),
        ("tests/speed-and-accuracy.svg", plot::readme()),
        ("tests/chart/speed-and-accuracy.svg", plot::study()),
    ]
}

/// Measures all methods and writes all files.
#[test]
#[ignore = "measures for minutes"]
fn measure() {
    let mut times = HashMap::new();
    for (size, view, _) in sizes() {
        let methods = methods(view);
        let names: Vec<_> = methods.iter().map(|(name, _)| format!("{size},{name}")).collect();
        times.extend(names.into_iter().zip(times_in_turns(methods, 30)));
    }
    let source = env::var("DONUT_C").expect("DONUT_C, the path of donut.c's source");
    times.insert("80x22,donut.c (C)".into(), time_in_c(&source));
    let table = table_of_times(|size, method| times[&format!("{size},{method}")]);
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
        assert!(contents.len() < 200_000, "{name} is too much for a page to load");
        assert_current(name, &contents);
    }
}

#[test]
fn the_figures_of_the_readme_are_those_of_the_study() {
    let [in_c, classic, exact] =
        ["donut.c (C)", "classic", "exact"].map(|name| find(SIZES[0], name).unwrap());
    let [large_classic, large_exact] =
        ["classic", "exact"].map(|name| find(SIZES[1], name).unwrap());
    assert!((45.0..55.0).contains(&classic.different), "about half");
    assert!(classic.far_off < classic.different / 2.0, "most by one shade");
    let parts = ["third", "quarter", "fifth", "sixth", "seventh", "eighth"];
    let readme = read("README.md").replace('\n', " ");
    for claim in [
        format!(
            "{:.0} to {:.0} times as fast",
            classic.time[0] / exact.time[0],
            large_classic.time[0] / large_exact.time[0]
        ),
        format!("exact is {:.0} times as fast", large_classic.time[0] / large_exact.time[0]),
        "half of classic's cells differ from it".into(),
        format!("one in {:.0} of exact's", 100.0 / exact.different),
        format!("{:.1}% of the donut's cells flicker", exact.flicker),
        format!("with exact, against {:.1}% with classic", classic.flicker),
        format!("({:.1}% on a full screen)", large_classic.flicker),
        format!(
            "in a {} of the C program's",
            parts[(in_c.time[0] / classic.time[0]).round() as usize - 3]
        ),
    ] {
        assert!(readme.contains(&claim), "{claim}");
    }
}
