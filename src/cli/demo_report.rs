//! The demo's findings as a report: which pictures, numbers, bars and tables, in words.

use invertex::output::report::{BarChart, Level, Report, Series, Shot, Table};

use super::demo::{Findings, Level as Found, Shown};
use super::print::{percent, thousands};

/// The report of `found`.
pub(super) fn of(found: &Findings) -> Report {
    let reference = f64::from(found.reference.triangles);
    let share = |level: &Found| f64::from(level.inverse.triangles) / reference.max(1.0);
    let names: Vec<String> = found
        .levels
        .iter()
        .enumerate()
        .map(|(k, level)| format!("LoD {}: {}", k + 1, percent(share(level))))
        .collect();
    Report {
        title: capitalised(&found.name),
        lead: "One reference mesh, and levels of detail that all show its appearance: a level has no texture coordinates \
               of its own; each pixel asks an inverse geometric texture which point of the reference it stands for, and \
               fetches colour and detail there."
            .to_owned(),
        facts: facts(found),
        reference: Shot {
            caption: format!("Reference, {} triangles", thousands(found.reference.triangles.into())),
            png: found.reference.png.clone(),
        },
        showcase: found.showcase,
        levels: found.levels.iter().zip(&names).map(|(level, name)| section(level, name, share(level))).collect(),
        charts: charts(found, &names),
        tables: vec![level_table(found, &names), mesh_table(found)],
        footer: format!("invertex {}, drawn on {}", env!("CARGO_PKG_VERSION"), found.device),
    }
}

fn facts(found: &Findings) -> Vec<(String, String)> {
    let mut facts = Vec::new();
    let mut fact = |label: &str, value: String| facts.push((label.to_owned(), value));
    fact(
        "reference",
        format!("{} triangles", thousands(found.reference.triangles.into())),
    );
    let mut primaries: Vec<&str> = found
        .outcome
        .reports
        .iter()
        .map(|mesh| mesh.primary.as_str())
        .collect();
    primaries.sort_unstable();
    primaries.dedup();
    fact("primary", primaries.join(", "));
    fact(
        "tables",
        kibibytes(
            found
                .outcome
                .reports
                .iter()
                .map(|mesh| mesh.bytes.total)
                .sum(),
        ),
    );
    fact("built file", kibibytes(found.file_bytes));
    fact(
        "build",
        format!(
            "{:.1} s",
            found
                .outcome
                .milliseconds
                .iter()
                .map(|(_, ms)| ms)
                .sum::<f64>()
                / 1e3
        ),
    );
    fact("device", found.device.clone());
    facts
}

fn section(level: &Found, name: &str, share: f64) -> Level {
    let shot = |caption: String, shown: &Shown| Shot {
        caption,
        png: shown.png.clone(),
    };
    let triangles = thousands(level.inverse.triangles.into());
    let mut numbers = vec![
        ("triangles".to_owned(), triangles.clone()),
        ("of the reference".to_owned(), percent(share)),
        ("FLIP, inverse texture".to_owned(), flip(&level.inverse)),
        ("FLIP, plain".to_owned(), flip(&level.plain)),
        ("PSNR, inverse texture".to_owned(), psnr(&level.inverse)),
        (
            "mean fetches".to_owned(),
            format!("{:.2}", level.inverse.mean_fetches),
        ),
    ];
    if let Some(frame) = &level.frame {
        numbers.push(("frame, median".to_owned(), milliseconds(frame.median_ns)));
    }
    Level {
        name: name.to_owned(),
        inverse: shot(
            format!("LoD + inverse texture, {triangles} triangles"),
            &level.inverse,
        ),
        plain: shot(format!("Plain LoD, {triangles} triangles"), &level.plain),
        others: vec![
            shot("What is really drawn".to_owned(), &level.wireframe),
            shot("Table fetches of each pixel".to_owned(), &level.fetches),
        ],
        numbers,
    }
}

fn charts(found: &Findings, names: &[String]) -> Vec<BarChart> {
    let flips = |shown: fn(&Found) -> &Shown| -> Vec<f64> {
        let mean = |level| {
            shown(level)
                .against_reference
                .as_ref()
                .map_or(f64::NAN, |c| c.flip_mean)
        };
        found.levels.iter().map(mean).collect()
    };
    let (stages, times): (Vec<String>, Vec<f64>) = found
        .outcome
        .milliseconds
        .iter()
        .map(|(stage, ms)| ((*stage).to_owned(), *ms))
        .unzip();
    let bytes = |of: fn(&invertex::asset::MeshReport) -> u64| -> f64 {
        found.outcome.reports.iter().map(of).sum::<u64>() as f64 / 1024.0
    };
    vec![
        BarChart {
            title: "Mean FLIP against the reference (lower is better)".to_owned(),
            categories: names.to_vec(),
            series: vec![
                Series {
                    name: "inverse texture".to_owned(),
                    values: flips(|level| &level.inverse),
                },
                Series {
                    name: "plain LoD".to_owned(),
                    values: flips(|level| &level.plain),
                },
            ],
            digits: 3,
        },
        BarChart {
            title: "Triangles drawn".to_owned(),
            categories: [vec!["reference".to_owned()], names.to_vec()].concat(),
            series: vec![Series {
                name: "triangles".to_owned(),
                values: std::iter::once(&found.reference)
                    .chain(found.levels.iter().map(|level| &level.inverse))
                    .map(|shown| f64::from(shown.triangles))
                    .collect(),
            }],
            digits: 0,
        },
        BarChart {
            title: "Build, milliseconds".to_owned(),
            categories: stages,
            series: vec![Series {
                name: "ms".to_owned(),
                values: times,
            }],
            digits: 0,
        },
        BarChart {
            title: "Tables, KiB".to_owned(),
            categories: ["hash", "lists", "triangles"].map(str::to_owned).to_vec(),
            series: vec![Series {
                name: "KiB".to_owned(),
                values: vec![
                    bytes(|m| m.bytes.hash),
                    bytes(|m| m.bytes.list),
                    bytes(|m| m.bytes.triangle),
                ],
            }],
            digits: 0,
        },
    ]
}

fn level_table(found: &Findings, names: &[String]) -> Table {
    let columns = [
        "",
        "triangles",
        "FLIP inverse",
        "FLIP plain",
        "PSNR inverse",
        "PSNR plain",
        "fetches",
        "frame median",
        "p95",
    ];
    let dash = || "–".to_owned();
    let frame = |time: Option<u64>| time.map_or_else(dash, milliseconds);
    let reference_frame = found.reference_frame.as_ref();
    let mut rows = vec![vec![
        "reference".to_owned(),
        thousands(found.reference.triangles.into()),
        dash(),
        dash(),
        dash(),
        dash(),
        dash(),
        frame(reference_frame.map(|f| f.median_ns)),
        frame(reference_frame.map(|f| f.p95_ns)),
    ]];
    for (level, name) in found.levels.iter().zip(names) {
        rows.push(vec![
            name.clone(),
            thousands(level.inverse.triangles.into()),
            flip(&level.inverse),
            flip(&level.plain),
            psnr(&level.inverse),
            psnr(&level.plain),
            format!("{:.2}", level.inverse.mean_fetches),
            frame(level.frame.as_ref().map(|f| f.median_ns)),
            frame(level.frame.as_ref().map(|f| f.p95_ns)),
        ]);
    }
    Table {
        title: "Levels of detail".to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows,
    }
}

fn mesh_table(found: &Findings) -> Table {
    let columns = [
        "mesh",
        "triangles",
        "primary",
        "hash",
        "list entries",
        "mean list",
        "longest list",
        "ambiguous",
        "gutter",
        "bytes",
    ];
    let row = |mesh: &invertex::asset::MeshReport| {
        vec![
            mesh.name.clone(),
            thousands(mesh.triangles as u64),
            mesh.primary.clone(),
            format!("{} × {}", mesh.hash[0], mesh.hash[1]),
            thousands(mesh.entries),
            format!("{:.2}", mesh.mean_list),
            mesh.max_list.to_string(),
            percent(mesh.ambiguous_fraction),
            format!("{} texels", mesh.gutter_width),
            thousands(mesh.bytes.total),
        ]
    };
    Table {
        title: "Inverse geometric textures".to_owned(),
        columns: columns.map(str::to_owned).to_vec(),
        rows: found.outcome.reports.iter().map(row).collect(),
    }
}

fn flip(shown: &Shown) -> String {
    shown
        .against_reference
        .as_ref()
        .map_or("–".to_owned(), |c| format!("{:.4}", c.flip_mean))
}

fn psnr(shown: &Shown) -> String {
    let Some(comparison) = &shown.against_reference else {
        return "–".to_owned();
    };
    comparison
        .psnr_db
        .map_or("identical".to_owned(), |db| format!("{db:.1} dB"))
}

fn milliseconds(nanoseconds: u64) -> String {
    format!("{:.1} ms", nanoseconds as f64 / 1e6)
}

fn kibibytes(bytes: u64) -> String {
    format!("{} KiB", thousands(bytes.div_ceil(1024)))
}

fn capitalised(name: &str) -> String {
    let mut letters = name.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().collect::<String>() + letters.as_str()
    })
}
