//! A profile as a page: heat maps, histograms, plots of sweeps, tables.

use std::path::Path;

use invertex::Result;
use invertex::measure::{Run, Sweep, Variant};
use invertex::output::report::{
    self, Axis, BarChart, Chart, Line, Marks, Page, Plot, Section, Series, Shot,
};
use invertex::output::{encode_png, heat_map, write_bytes};

use super::profile_found::Report;
use super::{profile_cuts, profile_table as table};

/// What a section's heading says already.
const SAID: [&str; 3] = ["mesh", "distance", "frames"];

/// Writes `profile.html` and the heat maps into `folder`; the paths written.
pub(super) fn write(folder: &Path, report: &Report) -> Result<Vec<String>> {
    let (mut written, mut sections) = (Vec::new(), Vec::new());
    for subject in subjects(report) {
        let section = section(report, &subject, |name, png| {
            let path = folder.join(name);
            write_bytes(&path, png)?;
            written.push(path.display().to_string());
            Ok(())
        })?;
        sections.push(section);
        sections.extend(sweeps(&subject));
        let of = (subject.file, subject.mesh);
        sections.extend(profile_cuts::section(report, of));
    }
    sections.push(Section {
        heading: "Memory".to_owned(),
        text: "Each table of every mesh, as in the file.".to_owned(),
        tables: vec![table::memory(&report.memory).table("Tables", &[])],
        ..Section::default()
    });
    let page = Page {
        title: "Profile".to_owned(),
        lead: "Where fetches and time go. A fetch is one load of at most 128 bits. Fetches are counted in one run, times \
               are taken in another."
            .to_owned(),
        facts: facts(report),
        sections,
        footer: format!("invertex {}, drawn on {}", env!("CARGO_PKG_VERSION"), report.device),
    };
    let path = folder.join("profile.html");
    write_bytes(&path, report::render_page(&page).as_bytes())?;
    written.push(path.display().to_string());
    Ok(written)
}

/// The rows of one mesh of one file.
struct Subject<'a> {
    file: &'a str,
    mesh: &'a str,
    runs: Vec<&'a Run>,
}

fn subjects(report: &Report) -> Vec<Subject<'_>> {
    let mut out: Vec<Subject> = Vec::new();
    for run in &report.runs {
        match out
            .iter_mut()
            .find(|s| s.file == run.file && s.mesh == run.mesh)
        {
            Some(subject) => subject.runs.push(run),
            None => out.push(Subject {
                file: &run.file,
                mesh: &run.mesh,
                runs: vec![run],
            }),
        }
    }
    out
}

fn facts(report: &Report) -> Vec<(String, String)> {
    let clock = serde_json::to_value(report.clock).unwrap_or_default();
    let fact = |label: &str, value: String| (label.to_owned(), value);
    vec![
        fact("device", report.device.clone()),
        fact("clock", clock.as_str().unwrap_or("–").to_owned()),
        fact("path", report.path.to_owned()),
        fact("shading", report.shading.to_owned()),
        fact(
            "picture",
            format!("{} × {}", report.size[0], report.size[1]),
        ),
    ]
}

/// The rows that every profile has, with heat maps of what was counted at distance 1.
fn section(
    report: &Report,
    subject: &Subject,
    mut keep: impl FnMut(&str, &[u8]) -> Result<()>,
) -> Result<Section> {
    let rows = || subject.runs.iter().filter(|run| run.sweep.is_none());
    // A few pixels of many fetches must not take all colours from the rest.
    let top = rows().map(|run| run.p99_fetches).max().unwrap_or(1).max(4);
    let (mut shots, mut charts) = (Vec::new(), Vec::new());
    for run in rows().filter(|run| !run.fetches.is_empty()) {
        let caption = format!(
            "{}: {:.2} fetches a pixel, p99 {}, most {}",
            run.variant.name(),
            run.mean_fetches,
            run.p99_fetches,
            run.max_fetches
        );
        let (width, height, rgba) = heat_map(report.size, &run.fetches, top, &caption)?;
        let png = encode_png(width, height, &rgba)?;
        keep(&file_name(subject, run), &png)?;
        shots.push(Shot { caption, png });
        charts.push(Chart::Plot(histogram(run)));
        if !run.tests_histogram.is_empty() {
            charts.push(Chart::Plot(tests(run)));
        }
    }
    charts.push(Chart::Bars(times(rows())));
    charts.push(Chart::Plot(passes(rows())));
    Ok(Section {
        heading: if subject.mesh == invertex::measure::WHOLE {
            format!("{}: all meshes", subject.file)
        } else {
            subject.mesh.to_owned()
        },
        text: String::new(),
        shots,
        charts,
        tables: vec![table::runs(rows().copied()).table("Counted and timed", &SAID)],
    })
}

/// Name of a heat map; whatever a mesh is called, it names a file in the folder.
fn file_name(subject: &Subject, run: &Run) -> String {
    let plain = |text: &str| -> String {
        let keep = |c: char| {
            if c.is_ascii_alphanumeric() || "-_".contains(c) {
                c
            } else {
                '_'
            }
        };
        text.chars().map(keep).collect()
    };
    let stem = Path::new(subject.file).file_stem().unwrap_or_default();
    let mesh = if subject.mesh == invertex::measure::WHOLE {
        "all"
    } else {
        subject.mesh
    };
    format!(
        "fetches-{}-{}-{}-lod{}.png",
        plain(&stem.to_string_lossy()),
        plain(mesh),
        plain(run.variant.name()),
        run.lod
    )
}

fn histogram(run: &Run) -> Plot {
    columns(run, "fetches", &run.histogram)
}

fn tests(run: &Run) -> Plot {
    columns(run, "triangles tested", &run.tests_histogram)
}

/// Pixels by a number of something.
fn columns(run: &Run, what: &'static str, counts: &[u64]) -> Plot {
    let pixels = run.covered_pixels.max(1) as f64;
    let share = |(number, &count): (usize, &u64)| [number as f64, 100.0 * count as f64 / pixels];
    Plot {
        title: format!("Pixels by {what}, {}", run.variant.name()),
        x: axis(what, false),
        y: axis("% of covered pixels", false),
        lines: vec![Line {
            name: run.variant.name().to_owned(),
            points: counts.iter().enumerate().map(share).collect(),
        }],
        marks: Marks::Columns,
    }
}

fn times<'a>(rows: impl Iterator<Item = &'a &'a Run> + Clone) -> BarChart {
    let series = |name: &str, of: fn(&Run) -> u64| Series {
        name: name.to_owned(),
        values: rows.clone().map(|run| of(run) as f64 / 1e6).collect(),
    };
    BarChart {
        title: "Frame, milliseconds".to_owned(),
        categories: rows
            .clone()
            .map(|run| run.variant.name().to_owned())
            .collect(),
        series: vec![
            series("median", |run| run.frame_ns_median),
            series("95 % at most", |run| run.frame_ns_p95),
        ],
        digits: 2,
    }
}

/// Frame times in the order drawn: whether they are steady.
fn passes<'a>(rows: impl Iterator<Item = &'a &'a Run>) -> Plot {
    let line = |run: &&Run| Line {
        name: run.variant.name().to_owned(),
        points: run
            .times
            .iter()
            .enumerate()
            .map(|(k, frame)| [k as f64, frame.total as f64 / 1e6])
            .collect(),
    };
    Plot {
        title: "Every timed frame".to_owned(),
        x: axis("frame", false),
        y: axis("ms", false),
        lines: rows.map(line).collect(),
        marks: Marks::Line,
    }
}

fn axis(name: &str, log: bool) -> Axis {
    Axis {
        name: name.to_owned(),
        log,
    }
}

/// A section for each sweep that was made.
fn sweeps(subject: &Subject) -> Vec<Section> {
    let of = |sweep: Sweep| -> Vec<&Run> {
        let runs = subject.runs.iter().copied();
        runs.filter(|run| run.sweep == Some(sweep)).collect()
    };
    let section = |sweep: Sweep, what: &str, text: &str, charts: Vec<Chart>| {
        let runs = of(sweep);
        (!runs.is_empty()).then(|| Section {
            heading: format!("{}: {what}", subject.mesh),
            text: text.to_owned(),
            charts,
            tables: vec![table::runs(runs.into_iter()).table(what, &SAID)],
            ..Section::default()
        })
    };
    let all = [
        section(
            Sweep::Hash,
            "hash resolution",
            "The same LoD with tables of other resolutions: shorter lists for more memory.",
            hash_charts(&of(Sweep::Hash)),
        ),
        section(
            Sweep::Layout,
            "layouts",
            "The packed tables beside the paper's.",
            of(Sweep::Layout)
                .into_iter()
                .map(|run| Chart::Plot(of_layout(run)))
                .collect(),
        ),
        section(
            Sweep::Filter,
            "filters",
            "One point a pixel, one for each triangle of its footprint, five.",
            of(Sweep::Filter)
                .into_iter()
                .map(|run| Chart::Plot(of_filter(run)))
                .collect(),
        ),
        section(
            Sweep::Lod,
            "levels of detail",
            "Every level from the same place.",
            vec![Chart::Plot(by(&of(Sweep::Lod), "triangles", |run| {
                f64::from(run.triangles)
            }))],
        ),
        section(
            Sweep::Distance,
            "distance",
            "Frame time as the model goes away; at 1 it fills the view.",
            distance_charts(&of(Sweep::Distance)),
        ),
    ];
    all.into_iter().flatten().collect()
}

fn of_layout(run: &Run) -> Plot {
    let layout = run
        .layout
        .map_or(String::new(), |l| format!("{l:?}").to_lowercase());
    Plot {
        title: format!("Pixels by fetches, {layout}"),
        ..histogram(run)
    }
}

fn of_filter(run: &Run) -> Plot {
    let filter = format!("{:?}", run.filter).to_lowercase();
    Plot {
        title: format!("Pixels by fetches, {filter}"),
        ..histogram(run)
    }
}

fn hash_charts(runs: &[&Run]) -> Vec<Chart> {
    let curve = |title: &str, name: &str, of: &dyn Fn(&Run) -> f64| {
        let hash = |run: &&Run| [run.hash.map_or(f64::NAN, f64::from), of(run)];
        Chart::Plot(Plot {
            title: title.to_owned(),
            x: axis("texels a side of the hash", true),
            y: axis(name, false),
            lines: vec![Line {
                name: name.to_owned(),
                points: runs.iter().map(hash).collect(),
            }],
            marks: Marks::Line,
        })
    };
    vec![
        curve("Mean list length", "triangles", &|run| {
            run.mean_list.unwrap_or(f64::NAN)
        }),
        curve("Mean fetches", "fetches", &|run| run.mean_fetches),
        curve("Frame, median", "ms", &|run| {
            run.frame_ns_median as f64 / 1e6
        }),
        curve("Tables", "MB", &|run| run.tables_bytes as f64 / 1e6),
    ]
}

/// One plot for each variant of a LoD, the reference in all of them.
fn distance_charts(runs: &[&Run]) -> Vec<Chart> {
    let others = Variant::ALL
        .into_iter()
        .filter(|v| *v != Variant::Reference);
    others
        .map(|variant| {
            let shown: Vec<&Run> = runs
                .iter()
                .copied()
                .filter(|run| run.variant == variant || run.variant == Variant::Reference)
                .collect();
            let plot = by(&shown, "distance", |run| run.distance);
            Chart::Plot(Plot {
                title: format!("Frame, median: {}", variant.name()),
                ..plot
            })
        })
        .collect()
}

/// Median frame times over `x`: a line for each variant, of each level where `x` is the distance.
fn by(runs: &[&Run], name: &str, x: fn(&Run) -> f64) -> Plot {
    let mut lines: Vec<Line> = Vec::new();
    for run in runs {
        let label = match (run.variant, name) {
            (Variant::Reference, _) => "reference".to_owned(),
            (variant, "distance") => format!("LoD {} ({})", run.lod, variant.name()),
            (variant, _) => variant.name().to_owned(),
        };
        let point = [x(run), run.frame_ns_median as f64 / 1e6];
        match lines.iter_mut().find(|line| line.name == label) {
            Some(line) => line.points.push(point),
            None => lines.push(Line {
                name: label,
                points: vec![point],
            }),
        }
    }
    Plot {
        title: "Frame, median".to_owned(),
        x: axis(name, true),
        y: axis("ms", true),
        lines,
        marks: Marks::Line,
    }
}
