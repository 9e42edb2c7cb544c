//! The study, tests/chart/README.md: its tables, and its pictures and those of the README.
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
use super::search::{g, numbers, places};
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
    let with = |name: &str, draw: fn(&View, f64, f64) -> Vec<u8>| -> NamedMethod {
        (name.into(), Box::new(move |a, b| draw(&view, a, b)))
    };
    let own = |name, method| own_method(name, Renderer::new(view, method));
    let mut methods = Vec::new();
    if view == View::DONUT_C {
        // The C program's frames are those of classic. Its time is measured in another way.
        methods.push(own("donut.c in C", Method::Classic));
        methods.push(with("turning by steps", turning));
    }
    if (view.r2, view.k2) == (2.0, 5.0) {
        methods.push(own("classic", Method::Classic));
    }
    if view != View::DONUT_C {
        methods.push(own_method("classic with donut.c's steps", with_steps(view, 0.07, 0.02)));
    }
    methods.extend([
        own("exact", Method::Exact),
        with("exact in f32", exact_f32),
        with("exact with 2 by 2 rays", averaged::<2, 2>),
        with("exact with 3 by 3 rays", averaged::<3, 5>),
        tracing("closed form", view, closed_form),
        tracing("Ferrari in f64", view, move |torus, rays| textbook_f64(torus, view.k2, rays)),
        tracing("Ferrari in f32", view, move |torus, rays| textbook_f32(torus, view.k2, rays)),
        tracing("Newton from one start", view, newton_once),
    ]);
    for most_steps in [8, 16, 32, 64, 256] {
        let name = format!("sphere tracing in {most_steps} steps");
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
fn table_of_times(time: impl Fn(&str, &str) -> f64) -> String {
    let by_centre = "cells of the donut,wrong shades,extra outline,holes";
    let by_average = "cells of the average,different,far off";
    let in_motion = "cells in motion,flickering";
    let mut table = format!("size,method,us per frame,{by_centre},{by_average},{in_motion}\n");
    for (size, view, poses) in sizes() {
        let poses = donut_c_poses(poses);
        let flickers = methods(view).into_iter().map(|(_, draw)| thread::spawn(|| flicker(draw)));
        let flickers: Vec<_> = flickers.collect();
        let averages = average::count(methods(view), view, poses.clone());
        let tallies = count(methods(view), view, poses).into_iter();
        for (((name, tally), average), flicker) in tallies.zip(averages).zip(flickers) {
            table += &format!("{size},{name},{:.1}", time(size, &name));
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
fn times_in_turns(mut methods: Vec<NamedMethod>, seconds: u64) -> Vec<f64> {
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
    medians.iter_mut().map(|medians| median(medians)).collect()
}

/// The time of the C program, in five series of 2,000 frames. It is processor time in user mode: writing
/// is not counted, since the system does that. The frames must be those of classic, byte for byte.
fn time_in_c(source: &str) -> f64 {
    const FRAMES: u32 = 2_000;
    let program = env::temp_dir().join(format!("donut-c-{}", process::id()));
    let program = program.to_str().unwrap();
    let options = ["-std=gnu89", "-O2", "-w", source, "-o", program, "-lm"];
    assert!(Command::new("gcc").args(options).status().unwrap().success());
    let mut donut_c = Program::start(program, "", Stdio::piped());
    fs::remove_file(program).unwrap();
    let mut pipe = donut_c.0.stdout.take().unwrap();
    let (mut classic, mut angles) = (Renderer::new(View::DONUT_C, Method::Classic), [0.0; 2]);
    let (mut ticks, mut series, mut clear) = (0.0, [0.0; 5], true);
    for micros in &mut series {
        for _ in 0..FRAMES {
            classic.render_frame(angles[0], angles[1]);
            angles = classic.advance(angles, [0.04, 0.02]);
            let expected = classic.encode(None, false, mem::take(&mut clear)).unwrap();
            let mut written = vec![0; expected.len()];
            pipe.read_exact(&mut written).unwrap();
            assert!(written == expected, "{angles:?}");
        }
        // Of the columns after the name in brackets, this is the 12th. It is in hundredths of a second.
        // The C program is ahead by what fits into the pipe, about 40 frames.
        let status = fs::read_to_string(format!("/proc/{}/stat", donut_c.0.id())).unwrap();
        let (_, columns) = status.rsplit_once(") ").unwrap();
        let ticks_before = ticks;
        ticks = columns.split(' ').nth(11).unwrap().parse().unwrap();
        *micros = (ticks - ticks_before) * 1e4 / f64::from(FRAMES);
    }
    median(&mut series)
}

/// The processor, and the versions of what built the two programs.
fn machine() -> String {
    let script = "sed -n 's/^model name.*: //p' /proc/cpuinfo | head -1; rustc --version
        gcc --version | head -1; getconf GNU_LIBC_VERSION";
    let output = Command::new("sh").args(["-c", script]).output().unwrap();
    let lines = String::from_utf8(output.stdout).unwrap();
    lines.lines().map(|line| format!("- {line}\n")).collect()
}

/// A row of TIMES. Wrong, different and flickering cells are in per cent of those that show the donut.
struct Measured {
    name: String,
    /// In microseconds per frame.
    time: f64,
    /// How many cells show the donut, and how many are wrong.
    counts: [f64; 2],
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
        let wrong = figures[2..5].iter().sum::<f64>();
        Measured {
            name: name.into(),
            time: figures[0],
            counts: [figures[1], wrong],
            wrong: 100.0 * wrong / figures[1],
            different: 100.0 * figures[6] / figures[5],
            far_off: 100.0 * figures[7] / figures[5],
            flicker: 100.0 * figures[9] / figures[8],
        }
    });
    rows.collect()
}

fn find(size: &str, method: &str) -> Option<Measured> {
    measured(size).into_iter().find(|row| row.name == method)
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

fn micros(measured: &Measured) -> String {
    format!("{:.*}", usize::from(measured.time < 9.95), measured.time)
}

/// The study's table of TIMES.
fn table() -> String {
    let heads = ["", "80x22: µs", "different", "far off", "flicker", "wrong"];
    let large_heads = ["200x60: µs", "different", "far off", "flicker"];
    let mut rows = vec![heads.into_iter().chain(large_heads).map(String::from).collect::<Vec<_>>()];
    let only_large = "classic with donut.c's steps";
    for name in measured(SIZES[0]).into_iter().map(|row| row.name).chain([only_large.into()]) {
        let [small, large] = SIZES.map(|size| match find(size, &name) {
            Some(row) => {
                let [different, far_off] = [row.different, row.far_off].map(share);
                let other_rule = ["donut.c", "turning", "classic", "exact with"];
                let is_other = other_rule.iter().any(|start| name.starts_with(start));
                let wrong = if is_other { "-".into() } else { share(row.wrong) };
                vec![micros(&row), different, far_off, format!("{:.2}", row.flicker), wrong]
            }
            None => vec![String::new(); 5],
        });
        let is_own = ["classic", "exact"].contains(&&*name);
        let first = if is_own { format!("**{name}**") } else { name };
        rows.push([vec![first], small, large[..4].into()].concat());
    }
    markdown(rows)
}

// ---- Where methods fail --------------------------------------------------------------------------

/// The methods that are compared in many scenes.
const COMPARED: [&str; 8] = [
    "sphere tracing in 16 steps",
    "sphere tracing in 64 steps",
    "Newton from one start",
    "Ferrari in f32",
    "Ferrari in f64",
    "closed form",
    "exact in f32",
    "exact",
];

/// The name of each scene, and what the oracle says of each method: first in various scenes, then for values of
/// K2, with donut.c's R2, and then for values of R2, with the default K2.
type Failures = [Scenes; 3];
type Scenes = Vec<(String, HashMap<String, Tally>)>;

fn count_failures() -> Failures {
    let k2s = [3.011, 3.03, 3.1, 3.3, 4.0, 5.0, 7.0, 10.0, 15.0, 25.0, 50.0, 120.0, 300.0];
    let far_k2s = [1e3, 3e3, 1e4, 3e4, 1e5];
    let r2s = [1.01, 1.03, 1.1, 1.3, 1.6, 2.0, 3.0, 5.0, 9.0, 16.0, 30.0];
    let scene = |r2, k2| View::fitted(160, 44, 2.0, r2, k2);
    let poses = donut_c_poses(10);
    let edge_on = poses.iter().map(|&(_, b)| (TAU / 4.0 + 1e-4, b)).collect();
    let face_on = poses.iter().map(|&(_, b)| (0.0, b)).collect();
    let scenes = [
        ("edge-on", scene(2.0, 5.0), edge_on),
        ("face-on", scene(2.0, 5.0), face_on),
        ("`--r2 6 --k2 7.01`", scene(6.0, 7.01), poses),
    ];
    let of_curve = |number: f64, r2, k2| (number.to_string(), scene(r2, k2), donut_c_poses(5));
    [
        scenes.map(|(name, view, poses)| (name.into(), view, poses)).into(),
        k2s.into_iter().chain(far_k2s).map(|k2| of_curve(k2, 2.0, k2)).collect::<Vec<_>>(),
        r2s.map(|r2| of_curve(r2, r2, 5.0 * (1.0 + r2) / 3.0)).into(),
    ]
    .map(|scenes| {
        let tallies = scenes.into_iter().map(|(name, view, poses)| {
            let mut methods = methods(view);
            methods.retain(|method| COMPARED.contains(&&*method.0));
            (name, count(methods, view, poses).into_iter().collect())
        });
        tallies.collect()
    })
}

/// The wrong cells, in per cent of the donut's.
fn wrong(tally: &Tally) -> f64 {
    100.0 * tally.wrong() as f64 / tally.surface as f64
}

/// The study's table of scenes.
fn table_of_scenes([scenes, ..]: &Failures) -> String {
    let names = scenes.iter().map(|(name, _)| name.clone());
    let mut rows = vec![std::iter::once(String::new()).chain(names).collect()];
    rows.extend(COMPARED.map(|method| {
        let shares = scenes.iter().map(|(_, tallies)| share(wrong(&tallies[method])));
        std::iter::once(method.into()).chain(shares).collect()
    }));
    markdown(rows)
}

/// How many steps exact takes for a ray that enters the bounding sphere, in so many poses of each scene: the mean,
/// the 99th percentile, and the most.
fn table_of_steps(poses: u32) -> String {
    let scenes = [
        ("donut.c's", 2.0, 5.0),
        ("edge-on", 2.0, 5.0),
        ("`--k2 3.01`", 2.0, 3.01),
        ("`--k2 1000000`", 2.0, 1e6),
        ("`--r2 1.01`", 1.01, 3.35),
        ("`--r2 30`", 30.0, 155.0 / 3.0),
    ];
    let heads = ["", "mean", "99% of the rays: at most", "all: at most"].map(String::from);
    let mut rows = vec![heads.into()];
    for (name, r2, k2) in scenes {
        let (view, mut counts) = (View::fitted(160, 44, 2.0, r2, k2), Vec::new());
        for n in (0..poses).map(f64::from) {
            // The fractional parts of the multiples of an irrational number are spread evenly.
            let [a, b] = [2.0_f64, 3.0].map(|number| TAU * (n * number.sqrt()).fract());
            let a = if name == "edge-on" { TAU / 4.0 + 1e-4 } else { a };
            let search = |torus: &Torus, rays: &Rays| {
                let (quartic, entries) = (torus.quartic(rays), torus.entry(rays).to_array());
                // A ray that does not enter the sphere has the entry 0.
                for (lane, entry) in (0..8).zip(entries).filter(|&(_, entry)| entry < 0.0) {
                    counts.push(places(numbers(&quartic, lane), entry).count());
                }
                f64x8::splat(MISS)
            };
            follow::<1>(&view, (a, b), search, |_, _| {});
        }
        counts.sort_unstable();
        let mean = counts.iter().sum::<usize>() as f64 / counts.len() as f64;
        let [most_take, all_take] =
            [counts.len() * 99 / 100, counts.len() - 1].map(|i| counts[i].to_string());
        rows.push(vec![name.into(), format!("{mean:.1}"), most_take, all_take]);
    }
    markdown(rows)
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
fn derived_files() -> Vec<(&'static str, String)> {
    let failures = count_failures();
    let mut study = read(STUDY);
    for (name, part) in [("methods", table()), ("scenes", table_of_scenes(&failures))] {
        study = with_part(&study, name, &part);
    }
    // donut.c's R2 is among those of both curves.
    let scenes = || failures.iter().flatten().filter(|(name, _)| name != "2");
    let sum = |method| {
        let of_scenes = scenes().map(|(_, tallies)| &tallies[method]);
        let counts = of_scenes.map(|tally| [tally.surface, tally.wrong()].map(|n| n as f64));
        let of_sizes = SIZES.into_iter().map(|size| find(size, method).unwrap().counts);
        counts.chain(of_sizes).fold([0.0; 2], |sum, counts| [0, 1].map(|i| sum[i] + counts[i]))
    };
    assert_eq!(["exact", "closed form"].map(|method| sum(method)[1]), [0.0; 2]);
    let [surface, wrong] = sum("exact in f32");
    let words = format!("{wrong} of {surface} characters");
    assert!(study.replace(',', "").contains(&words), "{words} in f32");
    vec![
        (STUDY, study),
        ("tests/donut.svg", film::film()),
        ("tests/methods.svg", picture::two_methods()),
        ("tests/speed-and-accuracy.svg", plot::readme()),
        ("tests/chart/speed-and-accuracy.svg", plot::study()),
        ("tests/chart/stability.svg", plot::stability(&failures)),
        ("tests/chart/failures.svg", picture::failures()),
        ("tests/chart/one-ray.svg", plot::one_ray()),
    ]
}

/// Measures all methods, counts steps, and writes all files.
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
    times.insert("80x22,donut.c in C".into(), time_in_c(&source));
    let table = table_of_times(|size, method| times[&format!("{size},{method}")]);
    println!("{table}");
    fs::write(path(TIMES), table).unwrap();
    let study = with_part(&read(STUDY), "machine", &machine());
    fs::write(path(STUDY), with_part(&study, "steps", &table_of_steps(20_000))).unwrap();
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
fn the_words_of_the_readme_and_of_the_study_are_those_of_the_figures() {
    let text = |file| read(file).split_whitespace().collect::<Vec<_>>().join(" ");
    let all = |method| SIZES.map(|size| find(size, method).unwrap());
    let (exact, classic, finer) = (all("exact"), all("classic"), all("exact with 3 by 3 rays"));
    // Computers differ in times, so the texts round them, and may be off by a half.
    let ratio = |one: &Measured, other: &Measured| one.time / other.time;
    let to_exact = |method: &[Measured; 2]| [0, 1].map(|i| ratio(&method[i], &exact[i])).to_vec();
    let in_c = find(SIZES[0], "donut.c in C").unwrap();
    for (file, words, said, ratios) in [
        ("README.md", "about three times as fast", 3.0, to_exact(&classic)),
        ("README.md", "a tenth of the C program's time", 0.1, vec![ratio(&classic[0], &in_c)]),
        (STUDY, "about three times exact's time", 3.0, to_exact(&classic)),
        (STUDY, "eight to nine times the time", 8.5, to_exact(&finer)),
        (STUDY, "about 0.6 of the time", 0.6, to_exact(&all("exact in f32"))),
        (STUDY, "about 1.5 times exact's time", 1.5, to_exact(&all("closed form"))),
    ] {
        assert!(text(file).contains(words), "{file}: {words}");
        let fits = |ratio: &f64| (said / 1.5..said * 1.5).contains(ratio);
        assert!(ratios.iter().all(fits), "{file}: {words}: {ratios:?}");
    }
    let view = View::DONUT_C;
    let [surface, flickering] = flicker(|a, b| averaged::<2, 3>(&view, a, b)).map(|n| n as f64);
    let if_three = 100.0 * flickering / surface;
    let if_two = find(SIZES[0], "exact with 2 by 2 rays").unwrap().flicker;
    let (mut covered, mut turned) = (0, 0);
    for (a, b) in donut_c_poses(50) {
        let pair = turning(&view, a, b).into_iter().zip(donut_c(&view, a, b));
        turned += pair.filter(|(one, other)| one != other).count();
        covered += draw(Method::Exact, view, a, b).into_iter().filter(|&cell| cell != b' ').count();
    }
    let different = |method: &[Measured; 2]| method.each_ref().map(|row| share(row.different));
    let [exact, classic, finer] = [&exact, &classic, &finer].map(different);
    for words in [
        format!("leaves {}% of the donut's characters different", exact[0]),
        format!("from the average in {}% ({}% at 200x60)", classic[0], classic[1]),
        format!(
            "256 rays at 80x22, and {}% at 200x60. With 3 by 3 rays, {}% and {}% are left",
            exact[1], finer[0], finer[1]
        ),
        format!("{if_three:.2}% flicker instead of {if_two:.2}%"),
        format!("In {}% of the donut's cells", 100 * turned / covered),
    ] {
        assert!(text(STUDY).contains(&words), "{words}");
    }
}
