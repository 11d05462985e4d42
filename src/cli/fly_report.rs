//! What `fly` says: a row for each picture, and a page with plots over time.

use std::path::Path;

use invertex::Result;
use invertex::asset::Built;
use invertex::lod::multiresolution::{Criterion, Limits};
use invertex::measure::Displacements;
use invertex::output::report::{self, Axis, Chart, Line, Marks, Page, Plot, Section, Shot};
use invertex::output::write_bytes;
use serde::Serialize;

use super::print::{Table, thousands};
use super::render_stages::Drawn;

/// A whole flight.
#[derive(Serialize)]
pub(super) struct Flight {
    file: String,
    device: String,
    limits: Within,
    /// Triangles of the meshes that are cut.
    reference_triangles: usize,
    frames: Vec<Moment>,
    page: Option<String>,
    #[serde(skip)]
    shots: Vec<Shot>,
}

#[derive(Serialize)]
struct Within {
    pixels: f64,
    colour: Option<f64>,
    surface: bool,
    hysteresis: f64,
    outside: &'static str,
}

/// One picture of it.
#[derive(Serialize)]
pub(super) struct Moment {
    path: String,
    distance: f64,
    turn: f64,
    triangles: u32,
    asked: usize,
    changed: usize,
    selection_ms: f64,
    bound_pixels: f64,
    displaced: Displacements,
}

/// A frame's pictures as PNG.
pub(super) struct Pictures {
    pub(super) shown: Vec<u8>,
    pub(super) cut: Vec<u8>,
    pub(super) displaced: Vec<u8>,
}

impl Moment {
    pub(super) fn new(
        path: String,
        (distance, turn): (f64, f64),
        drawn: &Drawn,
        off: &[Option<f32>],
    ) -> Self {
        let cut = drawn.cut.as_ref();
        Moment {
            path,
            distance,
            turn,
            triangles: drawn.triangles,
            asked: cut.map_or(0, |cut| cut.asked),
            changed: cut.map_or(0, |cut| cut.changed),
            selection_ms: cut.map_or(0.0, |cut| cut.selection_ms),
            bound_pixels: cut.map_or(0.0, |cut| cut.bound_pixels),
            displaced: Displacements::of(off),
        }
    }
}

impl Flight {
    pub(super) fn new(file: &Path, device: String, limits: Limits, built: &Built) -> Self {
        let cut = built.meshes.iter().filter(|mesh| mesh.hierarchy.is_some());
        Flight {
            file: file.display().to_string(),
            device,
            limits: Within {
                pixels: limits.pixels,
                colour: limits.criterion.colour(),
                surface: limits.criterion == Criterion::Surface,
                hysteresis: limits.hysteresis,
                outside: if limits.outside { "fine" } else { "coarse" },
            },
            reference_triangles: cut
                .map(|mesh| built.scene.meshes[mesh.mesh].triangles.len())
                .sum(),
            frames: Vec::new(),
            page: None,
            shots: Vec::new(),
        }
    }

    /// Adds a picture; the page shows the first, the last and two between.
    pub(super) fn add(&mut self, moment: Moment, pictures: Pictures, of: u32) {
        let k = self.frames.len() as u32;
        if [0, of / 3, of * 2 / 3, of - 1].contains(&k) {
            let said = |what: &str| format!("Frame {k}: {what}");
            let triangles = thousands(moment.triangles.into());
            let most = moment.displaced.max;
            self.shots.extend([
                Shot {
                    caption: said("as it looks"),
                    png: pictures.shown,
                },
                Shot {
                    caption: said(&format!("{triangles} triangles")),
                    png: pictures.cut,
                },
                Shot {
                    caption: said(&format!("displaced by {most:.2} pixels at most")),
                    png: pictures.displaced,
                },
            ]);
        }
        self.frames.push(moment);
    }

    pub(super) fn table(&self) -> Table {
        let mut table = Table::new(&[
            "frame",
            "distance",
            "triangles",
            "changed",
            "asked",
            "selection ms",
            "bound",
            "displaced: mean",
            "p99",
            "max",
        ]);
        for frame in &self.frames {
            table.row(vec![
                frame.path.clone(),
                format!("{:.2}", frame.distance),
                thousands(frame.triangles.into()),
                thousands(frame.changed as u64),
                thousands(frame.asked as u64),
                format!("{:.3}", frame.selection_ms),
                format!("{:.3}", frame.bound_pixels),
                format!("{:.3}", frame.displaced.mean),
                format!("{:.3}", frame.displaced.p99),
                format!("{:.3}", frame.displaced.max),
            ]);
        }
        table
    }

    fn plot(&self, title: &str, y: &str, lines: &[(&str, fn(&Moment) -> f64)]) -> Chart {
        let axis = |name: &str| Axis {
            name: name.to_owned(),
            log: false,
        };
        let line = |&(name, value): &(&str, fn(&Moment) -> f64)| Line {
            name: name.to_owned(),
            points: self
                .frames
                .iter()
                .enumerate()
                .map(|(k, frame)| [k as f64, value(frame)])
                .collect(),
        };
        Chart::Plot(Plot {
            title: title.to_owned(),
            x: axis("frame"),
            y: axis(y),
            lines: lines.iter().map(line).collect(),
            marks: Marks::Line,
        })
    }

    fn charts(&self) -> Vec<Chart> {
        vec![
            self.plot(
                "Triangles",
                "triangles",
                &[
                    ("drawn", |f| f64::from(f.triangles)),
                    ("changed", |f| f.changed as f64),
                ],
            ),
            self.plot(
                "Displacement on the screen",
                "pixels",
                &[
                    ("bound", |f| f.bound_pixels),
                    ("most", |f| f.displaced.max.into()),
                    ("99 % at most", |f| f.displaced.p99.into()),
                    ("mean", |f| f.displaced.mean),
                ],
            ),
            self.plot("Selection", "ms", &[("all cores", |f| f.selection_ms)]),
            self.plot(
                "Collapses and blocks that were asked",
                "asked",
                &[("asked", |f| f.asked as f64)],
            ),
        ]
    }
}

/// Writes `fly.html` into `folder`.
pub(super) fn write(folder: &Path, flight: &mut Flight) -> Result<()> {
    let fact = |label: &str, value: String| (label.to_owned(), value);
    let colour = flight
        .limits
        .colour
        .map_or("any".to_owned(), |c| c.to_string());
    let shots = std::mem::take(&mut flight.shots);
    let page = Page {
        title: "Flight".to_owned(),
        lead: "Triangles of every age, side by side: each picture has those that it needs, so that no detail of the reference \
               stands farther from its place on the screen than the limit."
            .to_owned(),
        facts: vec![
            fact("file", flight.file.clone()),
            fact("device", flight.device.clone()),
            fact("pixels", flight.limits.pixels.to_string()),
            fact("colour", colour),
            fact("reference", thousands(flight.reference_triangles as u64)),
        ],
        sections: vec![
            Section {
                heading: "On the way".to_owned(),
                text: "How it looks, its triangles, and how far each pixel's detail stands from its true place (the limit is at the \
                       top of the scale)."
                    .to_owned(),
                shots,
                ..Section::default()
            },
            Section {
                heading: "Over time".to_owned(),
                charts: flight.charts(),
                ..Section::default()
            },
        ],
        footer: format!("invertex {}, drawn on {}", env!("CARGO_PKG_VERSION"), flight.device),
    };
    let path = folder.join("fly.html");
    write_bytes(&path, report::render_page(&page).as_bytes())?;
    flight.page = Some(path.display().to_string());
    Ok(())
}
