//! `inspect`: what is in a model, and which primary parameterizations fit each mesh.

use std::path::PathBuf;

use invertex::Result;
use invertex::asset::{Model, NAMED};
use invertex::igt::Ambiguous;
use invertex::mesh::Mesh;
use invertex::output::check_target;
use invertex::param::{Fit, PrimaryKind, PrimaryRequest, Weighed, fits, parameterize, parts};
use serde::Serialize;

use super::maps::{self, Asked};
use super::print::{self, Table, percent, thousands};
use super::progress::Bar;
use super::{Common, ambiguous, note};

/// Say what is in a model, and which primary parameterizations fit each mesh.
///
/// A primary parameterization should be one-to-one over the mesh: nothing turned away from its projection lines,
/// nothing covered twice. Seamless ones (from position: plane, cylinder, sphere) simplify best.
#[derive(clap::Args)]
#[command(after_help = "\
JSON: file, materials, textures, images, skins, animations, instances, warnings[], meshes[]: name, triangles, vertices,
materials, has_normals.., uv_sets[]: set, charts, overlap_fraction, inside_unit_square, mirrored_fraction;
primary[]: kind, bijective, turned_fraction, overlap_fraction, degenerate_fraction, centre, worst_triangles[];
automatic: kind, why (what `build --primary auto` would take; null where nothing fits), weighed[]: kind, cost, seam_share,
wrong_fraction, quality (as map below), why_not; ambiguous_triangles,
ambiguous_area_fraction, ambiguous_first[] (triangles that share a place with another of their part or layer); asked[]
(with --primary): kind, possible, why, milliseconds, pictures[], map {charts, stretch {l2, linf, angle}, seam_length,
filled_fraction, turned_triangles[]} or null. built[]: for a file that `build`
made, what it reported of each mesh; else null.

Examples:
  invertex inspect model.glb
  invertex inspect model.glb --mesh Hose_low           one mesh, with the triangles that do not fit
  invertex inspect model.glb --ambiguous twice.csv     the triangles that share a place with others, all of them
  invertex inspect scan.glb --primary all --pictures maps/     computed maps side by side, and what they look like
  invertex inspect model.gltf --json | jq '.meshes[].primary[] | select(.bijective) | .kind'")]
pub(super) struct Inspect {
    /// The model: .glb or .gltf.
    input: PathBuf,
    /// Only this mesh.
    #[arg(long, value_name = "NAME")]
    mesh: Option<String>,
    /// Find these primary parameterizations for each mesh and say how good they are: kinds as for `build --primary`,
    /// separated by commas, or all (those that are computed).
    #[arg(long, value_name = "KIND,..")]
    primary: Option<String>,
    /// With --primary: pictures of each, its layout, a checkerboard on the model and its stretch, into this folder.
    #[arg(long, value_name = "FOLDER", requires = "primary")]
    pictures: Option<PathBuf>,
    /// Write the triangles that share a place with another under what auto takes: mesh,triangle, one a line.
    #[arg(long, value_name = "FILE.csv")]
    ambiguous: Option<PathBuf>,
}

#[derive(Serialize)]
struct Report {
    file: String,
    materials: usize,
    textures: usize,
    images: usize,
    skins: usize,
    animations: Vec<String>,
    instances: usize,
    warnings: Vec<String>,
    meshes: Vec<MeshReport>,
    built: Option<Vec<serde_json::Value>>,
}

#[derive(Serialize)]
struct MeshReport {
    name: String,
    triangles: usize,
    vertices: usize,
    materials: usize,
    vertex_colours: bool,
    tangents: bool,
    skinned: bool,
    uv_sets: Vec<UvSetReport>,
    primary: Vec<PrimaryReport>,
    automatic: Option<Automatic>,
    /// What --primary named.
    asked: Vec<Asked>,
}

#[derive(Serialize)]
struct UvSetReport {
    set: usize,
    /// Null, like the others, where most of the surface has no area in this set.
    charts: Option<usize>,
    overlap_fraction: Option<f64>,
    overlap_within_charts: Option<f64>,
    inside_unit_square: bool,
    mirrored_fraction: Option<f64>,
}

#[derive(Serialize)]
struct PrimaryReport {
    kind: String,
    bijective: bool,
    seamless: bool,
    turned_fraction: f64,
    overlap_fraction: f64,
    overlap_within_parts: f64,
    degenerate_fraction: f64,
    centre: Option<[f64; 3]>,
    worst_triangles: Vec<u32>,
}

#[derive(Serialize)]
struct Automatic {
    kind: String,
    why: String,
    /// What was weighed against each other; empty where nothing had to be.
    weighed: Vec<Weighed>,
    ambiguous_triangles: usize,
    ambiguous_area_fraction: f64,
    ambiguous_first: Vec<u32>,
    #[serde(skip)]
    ambiguous: Ambiguous,
}

impl Inspect {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        self.ambiguous.as_deref().map_or(Ok(()), check_target)?;
        let requests = self.primary.as_deref().map_or(Ok(vec![]), maps::requests)?;
        let model = Model::load(&self.input)?;
        let built = match &model {
            Model::Plain(_) => None,
            Model::Built(built) => Some(
                built
                    .meshes
                    .iter()
                    .map(|mesh| mesh.report.clone())
                    .collect(),
            ),
        };
        let scene = model.scene();
        if let Some(name) = &self.mesh {
            super::mesh_named(
                &scene.name,
                scene.meshes.iter().map(|m| m.name.as_str()),
                name,
            )?;
        }
        let bar = Bar::new(common, scene.meshes.len() as u64);
        let mut meshes = Vec::new();
        for (k, mesh) in scene.meshes.iter().enumerate() {
            if self.mesh.as_ref().is_none_or(|name| *name == mesh.name) {
                bar.at(&mesh.name, k as u64, scene.meshes.len() as u64);
                let mut report = mesh_report(mesh);
                if !mesh.triangles.is_empty() {
                    report.asked = maps::asked(mesh, &requests, self.pictures.as_deref())?;
                }
                meshes.push(report);
            }
        }
        drop(bar);
        if let Some(path) = &self.ambiguous {
            let found = meshes.iter().filter_map(|mesh| {
                let automatic = mesh.automatic.as_ref()?;
                Some((mesh.name.as_str(), &automatic.ambiguous))
            });
            ambiguous::write(path, found)?;
        }
        let report = Report {
            materials: scene.materials.len(),
            textures: scene.textures.len(),
            images: scene.images.len(),
            skins: scene.skins.len(),
            animations: scene.animations.iter().map(|a| a.name.clone()).collect(),
            instances: scene.instances().len(),
            warnings: scene.warnings.clone(),
            meshes,
            file: scene.name.clone(),
            built,
        };
        if common.json {
            return print::json(&report);
        }
        report
            .warnings
            .iter()
            .for_each(|warning| note(common, warning));
        print::text(&readable(&report, self.mesh.is_some()))
    }
}

fn mesh_report(mesh: &Mesh) -> MeshReport {
    let fits = if mesh.triangles.is_empty() {
        Vec::new()
    } else {
        fits(mesh)
    };
    let set_fit = |set: usize| {
        fits.iter()
            .find(|fit| fit.kind == PrimaryKind::UvSet(set as u8))
    };
    let mut materials = mesh.triangle_material.clone();
    materials.sort_unstable();
    materials.dedup();
    MeshReport {
        name: mesh.name.clone(),
        triangles: mesh.triangles.len(),
        vertices: mesh.positions.len(),
        materials: materials.len(),
        vertex_colours: !mesh.colors.is_empty(),
        tangents: !mesh.tangents.is_empty(),
        skinned: !mesh.joints.is_empty(),
        uv_sets: (0..mesh.uv_sets.len())
            .map(|set| uv_set_report(mesh, set, set_fit(set)))
            .collect(),
        automatic: automatic(mesh),
        primary: fits.iter().map(primary_report).collect(),
        asked: vec![],
    }
}

/// What `build` would take, and what would be ambiguous.
fn automatic(mesh: &Mesh) -> Option<Automatic> {
    let chosen = parameterize(mesh, &PrimaryRequest::Auto).ok()?;
    let open = chosen
        .computed
        .as_ref()
        .map(|computed| computed.embedding.cut_open(mesh));
    let (mesh, primary, why) = (open.as_ref().unwrap_or(mesh), chosen.primary, chosen.why);
    let layer = parts(mesh, &primary).triangle_layer;
    let ambiguous = Ambiguous::of(mesh, &primary, &layer).unwrap_or_default();
    Some(Automatic {
        kind: primary.kind.to_string(),
        why,
        weighed: chosen.weighed,
        ambiguous_triangles: ambiguous.triangles.len(),
        ambiguous_area_fraction: ambiguous.area_fraction,
        ambiguous_first: ambiguous.triangles.iter().copied().take(NAMED).collect(),
        ambiguous,
    })
}

fn uv_set_report(mesh: &Mesh, set: usize, fit: Option<&Fit>) -> UvSetReport {
    let inside = |uv: &[f32; 2]| uv.iter().all(|c| (0.0..=1.0).contains(c));
    UvSetReport {
        set,
        charts: fit.map(|f| f.charts),
        overlap_fraction: fit.map(|f| f.overlap_fraction),
        overlap_within_charts: fit.map(|f| f.overlap_within_parts),
        inside_unit_square: mesh.uv_sets[set].iter().all(inside),
        mirrored_fraction: fit.map(|f| f.mirrored_fraction),
    }
}

fn primary_report(fit: &Fit) -> PrimaryReport {
    let centred = matches!(fit.kind, PrimaryKind::Sphere | PrimaryKind::Cylinder(_));
    PrimaryReport {
        kind: fit.kind.to_string(),
        bijective: fit.bijective,
        seamless: fit.is_seamless(),
        turned_fraction: fit.turned_fraction,
        overlap_fraction: fit.overlap_fraction,
        overlap_within_parts: fit.overlap_within_parts,
        degenerate_fraction: fit.degenerate_fraction,
        centre: centred.then(|| object_space(fit)),
        worst_triangles: fit.worst_triangles.clone(),
    }
}

/// The centre in object space: a fit has it in T3, where the axis comes third.
fn object_space(fit: &Fit) -> [f64; 3] {
    match fit.kind {
        PrimaryKind::Cylinder(axis) => axis.from_third(fit.centre),
        _ => fit.centre,
    }
}

fn readable(report: &Report, detail: bool) -> String {
    let mut text = format!(
        "{}: {} meshes, {} instances, {} materials, {} textures, {} skins, {} animations\n",
        report.file,
        report.meshes.len(),
        report.instances,
        report.materials,
        report.textures,
        report.skins,
        report.animations.len()
    );
    if let Some(built) = &report.built {
        text += &format!("{} of its meshes have inverse textures\n", built.len());
    }
    for mesh in &report.meshes {
        text += &format!(
            "\n{}: {} triangles, {} vertices\n",
            mesh.name,
            thousands(mesh.triangles as u64),
            thousands(mesh.vertices as u64)
        );
        for set in &mesh.uv_sets {
            let charts = set
                .charts
                .map_or("most of the surface has no area".to_owned(), |n| {
                    format!("{n} charts")
                });
            let inside = if set.inside_unit_square {
                "inside"
            } else {
                "reaching outside"
            };
            text += &format!("  uv{}: {charts}, {inside} the unit square\n", set.set);
        }
        text += &primary_table(mesh, detail);
        text += &maps::readable(&mesh.asked);
        match &mesh.automatic {
            Some(automatic) => {
                text += &format!("  auto takes {}\n", automatic.why);
                if automatic.ambiguous_triangles > 0 {
                    text += &format!(
                        "  {} triangles, {} of the surface, share a place with others\n",
                        thousands(automatic.ambiguous_triangles as u64),
                        percent(automatic.ambiguous_area_fraction)
                    );
                }
            }
            None => text += "  nothing fits\n",
        }
    }
    text
}

fn primary_table(mesh: &MeshReport, detail: bool) -> String {
    if mesh.primary.is_empty() {
        return String::new();
    }
    let mut headings = vec![
        "  primary",
        "one-to-one",
        "turned",
        "covered twice",
        "no image",
    ];
    if detail {
        headings.push("worst triangles");
    }
    let mut table = Table::new(&headings);
    for primary in &mesh.primary {
        let mut row = vec![
            format!("  {}", primary.kind),
            if primary.bijective { "yes" } else { "no" }.to_owned(),
            percent(primary.turned_fraction),
            percent(primary.overlap_fraction),
            percent(primary.degenerate_fraction),
        ];
        if detail {
            row.push(
                primary
                    .worst_triangles
                    .iter()
                    .take(6)
                    .map(u32::to_string)
                    .collect::<Vec<_>>()
                    .join(" "),
            );
        }
        table.row(row);
    }
    table.text()
}
