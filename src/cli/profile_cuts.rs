//! What `profile --sweep cuts` says: tables and curves of cuts, by what decides them.

use invertex::asset::Built;
use invertex::lod::multiresolution::Limits;
use invertex::measure::{CutRun, EqualFlip};
use invertex::output::report::{Axis, Chart, Line, Marks, Plot, Section};
use invertex::{Error, Result};

use super::bad_option;
use super::print::thousands;
use super::profile_found::Report;
use super::profile_table::{DASH, Rows};

/// Whether all of an option's limits are ones.
pub(super) fn check(option: &'static str, limits: &[f64]) -> Result<()> {
    let is_limit = |&pixels: &f64| {
        let limits = Limits {
            pixels,
            ..Limits::default()
        };
        limits.check().is_ok()
    };
    match limits.iter().find(|limit| !is_limit(limit)) {
        Some(bad) => Err(bad_option(
            option,
            format!("{bad} is no limit; 0 or more, such as 0.5"),
        )),
        None => Ok(()),
    }
}

/// Whether a model can be cut, and knows its colours where `colours` were asked for.
pub(super) fn check_model(file: &str, built: &Built, colours: bool) -> Result<()> {
    let mut models = built.meshes.iter().filter_map(|m| m.hierarchy.as_ref());
    if models.clone().next().is_none() {
        let reason = "has no multiresolution model; run `invertex build --mrm` first";
        return Err(Error::input(file, "extensions", reason));
    }
    if colours && models.all(|model| model.colours.is_none()) {
        let reason =
            format!("{file} does not know what colours are off by (no texture, or --mrm=geometry)");
        return Err(bad_option("--colours", reason));
    }
    Ok(())
}

/// Both tables for stdout; nothing without cuts.
pub(super) fn text(report: &Report) -> String {
    if report.cuts.is_empty() {
        return String::new();
    }
    let cuts = cuts(report.cuts.iter()).text();
    let equal = equal(&report.equal_flip.iter().collect::<Vec<_>>()).text();
    format!("\nCuts\n{cuts}\nTriangles at equal FLIP\n{equal}")
}

/// The section of one mesh's cuts; none without any.
pub(super) fn section(report: &Report, (file, mesh): (&str, &str)) -> Option<Section> {
    let runs = report.cuts.iter();
    let runs: Vec<&CutRun> = runs.filter(|r| r.file == file && r.mesh == mesh).collect();
    let rows = report.equal_flip.iter();
    let rows: Vec<&EqualFlip> = rows.filter(|r| r.file == file && r.mesh == mesh).collect();
    (!runs.is_empty()).then(|| Section {
        heading: format!("{mesh}: cuts"),
        text: "Cuts of the same model by what decides: how far the surface moves, as where no texture is known; how \
               far anything that it shows moves; or, besides, how much colours change. FLIP against the reference from the \
               same place, both unlit."
            .to_owned(),
        charts: charts(&runs),
        tables: vec![
            equal(&rows).table("Triangles at equal FLIP", &["mesh"]),
            cuts(runs.iter().copied()).table("Cuts", &["mesh"]),
        ],
        ..Section::default()
    })
}

fn charts(runs: &[&CutRun]) -> Vec<Chart> {
    let mut distances: Vec<f64> = runs.iter().map(|run| run.distance).collect();
    distances.dedup();
    let from = |distance: f64| -> Vec<&CutRun> {
        let runs = runs.iter().copied();
        runs.filter(|run| run.distance == distance).collect()
    };
    let mut charts: Vec<Chart> = distances
        .iter()
        .map(|&distance| {
            let title = format!("FLIP over triangles, distance {distance}");
            let point = |run: &CutRun| [f64::from(run.triangles), run.flip_mean];
            plot(title, ["triangles", "mean FLIP"], &from(distance), point)
        })
        .collect();
    if let Some(&nearest) = distances.first() {
        let near = from(nearest);
        let at = |what: &str| format!("{what}, distance {nearest}");
        let by_limit = |what: &str, y, of: fn(&CutRun) -> f64| {
            plot(at(what), ["limit, pixels", y], &near, |run| {
                [run.pixels, of(run)]
            })
        };
        charts.extend([
            by_limit("Triangles by limit", "triangles", |r| r.triangles.into()),
            by_limit("Displacement that is proved", "pixels", |r| r.bound_pixels),
            by_limit("Displacement that is measured", "pixels", |r| {
                r.displaced.max.into()
            }),
        ]);
    }
    charts.push(selection(runs));
    charts
}

/// A line for each criterion, both axes logarithmic.
fn plot(
    title: String,
    [x, y]: [&str; 2],
    runs: &[&CutRun],
    point: impl Fn(&CutRun) -> [f64; 2],
) -> Chart {
    let mut lines: Vec<Line> = Vec::new();
    for run in runs {
        let name = name(run.criterion, run.colour);
        match lines.iter_mut().find(|line| line.name == name) {
            Some(line) => line.points.push(point(run)),
            None => lines.push(Line {
                name,
                points: vec![point(run)],
            }),
        }
    }
    Chart::Plot(Plot {
        title,
        x: axis(x),
        y: axis(y),
        lines,
        marks: Marks::Line,
    })
}

/// What selections take over the triangles that they give.
fn selection(runs: &[&CutRun]) -> Chart {
    let line = |name: &str, of: &dyn Fn(&CutRun) -> Option<u64>| {
        let point = |run: &&CutRun| Some([f64::from(run.triangles), of(run)? as f64 / 1e6]);
        let mut points: Vec<[f64; 2]> = runs.iter().filter_map(point).collect();
        points.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Line {
            name: name.to_owned(),
            points,
        }
    };
    let lines = [
        line("one core", &|run| Some(run.selection_ns_median)),
        line("device", &|run| run.device_selection_ns_median),
    ];
    Chart::Plot(Plot {
        title: "Selection".to_owned(),
        x: axis("triangles"),
        y: axis("ms"),
        lines: lines.into_iter().filter(|l| !l.points.is_empty()).collect(),
        marks: Marks::Line,
    })
}

fn axis(name: &str) -> Axis {
    Axis {
        name: name.to_owned(),
        log: true,
    }
}

fn name(criterion: &str, colour: Option<f64>) -> String {
    match colour {
        Some(limit) => format!("{criterion} {limit}"),
        None => criterion.to_owned(),
    }
}

fn cuts<'a>(runs: impl Iterator<Item = &'a CutRun>) -> Rows {
    let milliseconds = |ns: u64| format!("{:.3}", ns as f64 / 1e6);
    let row = |run: &CutRun| {
        vec![
            run.mesh.clone(),
            run.distance.to_string(),
            name(run.criterion, run.colour),
            run.pixels.to_string(),
            thousands(run.triangles.into()),
            thousands(run.asked as u64),
            milliseconds(run.selection_ns_median),
            run.device_selection_ns_median
                .map_or(DASH.to_owned(), milliseconds),
            format!("{:.3}", run.bound_pixels),
            format!("{:.3}", run.displaced.p99),
            format!("{:.3}", run.displaced.max),
            format!("{:.4}", run.flip_mean),
            format!("{:.3}", run.flip_max),
        ]
    };
    Rows {
        headings: vec![
            "mesh",
            "distance",
            "decides",
            "pixels",
            "triangles",
            "asked",
            "selection ms",
            "device ms",
            "bound",
            "displaced p99",
            "max",
            "FLIP",
            "FLIP max",
        ],
        rows: runs.map(row).collect(),
    }
}

fn equal(rows: &[&EqualFlip]) -> Rows {
    let whole = |triangles: f64| thousands(triangles.round() as u64);
    let known = |triangles: Option<f64>| triangles.map_or(DASH.to_owned(), whole);
    let row = |row: &EqualFlip| {
        let colours = row.colours.iter();
        let colours = colours.map(|c| format!("{}: {}", c.colour, known(c.triangles)));
        vec![
            row.mesh.clone(),
            row.distance.to_string(),
            row.pixels.to_string(),
            format!("{:.4}", row.flip),
            known(row.surface),
            whole(row.triangles),
            match row.colours.is_empty() {
                true => DASH.to_owned(),
                false => colours.collect::<Vec<_>>().join(", "),
            },
        ]
    };
    Rows {
        headings: vec![
            "mesh",
            "distance",
            "pixels",
            "FLIP",
            "surface",
            "pixels alone",
            "with colours",
        ],
        rows: rows.iter().map(|r| row(r)).collect(),
    }
}
