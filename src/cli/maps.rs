//! Primary parameterizations that are computed, for `inspect`: how good each is, and pictures of it.

use std::path::Path;
use std::time::Instant;

use invertex::mesh::Mesh;
use invertex::output::{encode_png, make_folder, map_pictures, write_bytes};
use invertex::param::{Map, PrimaryRequest, Quality, parameterize};
use invertex::{Error, Result};
use serde::Serialize;

use super::build::milliseconds;
use super::plain;
use super::print::{Table, percent};

/// Pixels along a side of a picture.
const SIDE: u32 = 768;

/// A primary that was asked for, over one mesh.
#[derive(Serialize)]
pub(super) struct Asked {
    kind: String,
    /// What a computed map is like; null for others, and where it cannot be had.
    map: Option<Quality>,
    /// What was found, or why it cannot be had.
    why: String,
    possible: bool,
    milliseconds: f64,
    /// Files of pictures: layout, checkerboard, stretch.
    pictures: Vec<String>,
}

/// The primaries that `text` names: kinds separated by commas, or `all` for those that are computed.
pub(super) fn requests(text: &str) -> Result<Vec<PrimaryRequest>> {
    if text == "all" {
        return Ok(Map::ALL
            .map(|map| PrimaryRequest::Computed(map, None))
            .to_vec());
    }
    // A centre has commas of its own: a part without a letter belongs to the one before.
    let mut kinds: Vec<String> = vec![];
    for part in text.split(',') {
        match kinds.last_mut() {
            Some(last) if !part.contains(|c: char| c.is_ascii_alphabetic()) => {
                *last += &format!(",{part}")
            }
            _ => kinds.push(part.to_owned()),
        }
    }
    kinds.iter().map(|kind| kind.parse()).collect()
}

/// Finds each of `requests` for `mesh`; pictures go to `folder`, if there is one.
pub(super) fn asked(
    mesh: &Mesh,
    requests: &[PrimaryRequest],
    folder: Option<&Path>,
) -> Result<Vec<Asked>> {
    requests
        .iter()
        .map(|request| one(mesh, request, folder))
        .collect()
}

fn one(mesh: &Mesh, request: &PrimaryRequest, folder: Option<&Path>) -> Result<Asked> {
    let start = Instant::now();
    let chosen = match parameterize(mesh, request) {
        Ok(chosen) => chosen,
        Err(Error::Parameterization { reason, .. }) => {
            return Ok(Asked {
                kind: name(request),
                map: None,
                why: reason,
                possible: false,
                milliseconds: milliseconds(start),
                pictures: vec![],
            });
        }
        Err(other) => return Err(other),
    };
    let milliseconds = milliseconds(start);
    // With its stretch, where one was given: several of a kind are told apart.
    let kind = match request {
        PrimaryRequest::Computed(_, Some(_)) => name(request),
        _ => chosen.primary.kind.to_string(),
    };
    let mut pictures = vec![];
    if let Some(folder) = folder {
        make_folder(folder)?;
        let open = chosen
            .computed
            .as_ref()
            .map(|computed| computed.embedding.cut_open(mesh));
        let made = map_pictures(open.as_ref().unwrap_or(mesh), &chosen.primary, SIDE);
        for (what, pixels) in [
            ("layout", &made.layout),
            ("checkerboard", &made.checkerboard),
            ("stretch", &made.stretch),
        ] {
            let file = plain(&format!("{}-{kind}-{what}", mesh.name));
            let path = folder.join(file + ".png");
            write_bytes(&path, &encode_png(made.side, made.side, pixels)?)?;
            pictures.push(path.display().to_string());
        }
    }
    let map = chosen.computed.map(|computed| computed.quality);
    Ok(Asked {
        kind,
        map,
        why: chosen.why,
        possible: true,
        milliseconds,
        pictures,
    })
}

/// What a request is called where there is no primary to ask.
fn name(request: &PrimaryRequest) -> String {
    match request {
        PrimaryRequest::Auto => "auto".into(),
        PrimaryRequest::UvSet(set) => format!("uv{set}"),
        PrimaryRequest::Plane(_) => "plane".into(),
        PrimaryRequest::Cylinder(_) => "cylinder".into(),
        PrimaryRequest::Sphere(_) => "sphere".into(),
        PrimaryRequest::Computed(map, None) => map.to_string(),
        PrimaryRequest::Computed(map, Some(stretch)) => format!("{map}:{stretch}"),
    }
}

/// A table of computed maps, and a line for each that is none or cannot be had.
pub(super) fn readable(asked: &[Asked]) -> String {
    if asked.is_empty() {
        return String::new();
    }
    let headings = [
        "  map", "charts", "stretch", "largest", "angles", "seams", "filled", "turned", "ms",
    ];
    let mut table = Table::new(&headings);
    let mut lines = String::new();
    for one in asked {
        match &one.map {
            Some(map) => table.row([
                format!("  {}", one.kind),
                map.charts.to_string(),
                format!("{:.4}", map.stretch.l2),
                format!("{:.2}", map.stretch.linf),
                format!("{:.5}", map.stretch.angle),
                format!("{:.2}", map.seam_length),
                percent(map.filled_fraction),
                map.turned_triangles.len().to_string(),
                format!("{:.0}", one.milliseconds),
            ]),
            None => lines += &format!("  {}: {}\n", one.kind, one.why),
        }
        one.pictures
            .iter()
            .for_each(|path| lines += &format!("  {path}\n"));
    }
    match asked.iter().any(|one| one.map.is_some()) {
        true => table.text() + &lines,
        false => lines,
    }
}
