//! `build`: a reference model becomes a file with LoDs and inverse geometric textures.

use std::path::{Path, PathBuf};

use invertex::asset::{self, BuildSettings, MeshReport};
use invertex::output::{check_target, write_bytes};
use invertex::param::PrimaryRequest;
use invertex::recover::prefilter;
use invertex::scene::{Scene, read_file};
use invertex::{Error, Result};
use serde::{Serialize, Serializer};
use std::time::Instant;

use super::build_choices::{LayoutName, Mrm, Simplifier};
use super::device::Device;
use super::print::{self, Table, percent, thousands};
use super::progress::Bar;
use super::{Common, ambiguous, bad_option, note};

/// Turn a model into one GLB with its LoDs and inverse geometric textures.
///
/// Any other viewer shows the file as the original model. The tables are the same bytes wherever they are built.
#[derive(clap::Args)]
#[command(after_help = "\
JSON: file, output, output_bytes, device, warnings[], meshes[]: name, triangles, parts, primary, why, weighed[] (by auto: kind, cost, seam_share,
wrong_fraction, quality, why_not), hash [w,h],
map {charts, stretch {l2, linf, angle}, seam_length, filled_fraction, turned_triangles[]} of a computed primary or null,
layout, entries, mean_list, max_list, gutter_entries, gutter_width (texels), unreached_texels, collapsed_triangles,
ambiguous_fraction (of the covered domain), ambiguous_triangles, ambiguous_area_fraction (of the surface, at most),
ambiguous_first[] (up to 64 of them), overlap_fraction, turned_fraction, bytes {hash, list, triangle, attribute, total}, tables_sha256,
multiresolution (of --mrm, else null) {collapses, triangles (of all ages), coarsest, colour_levels, colour_distance},
lods[]: triangles, vertices, deviation_max, deviation_rms, deviation_bound (of --simplifier progressive, else null), turned,
reached; build_ms {load, primary, parts, lods, tables, ambiguous, deviations, write, total}.

Examples:
  invertex build helmet.glb -o built.glb
  invertex build apple.glb -o built.glb --primary sphere --lods 0.2,0.05,0.01
  invertex build boat.glb -o built.glb --primary sphere:-3.25,1.29,0.57 --hash 512
  invertex build helmet.glb -o built.glb --primary uv0 --primary Lenses_low=sphere     one mesh its own way
  invertex build scan.glb -o built.glb --primary lscm              charts, for a scan that has no uv
  invertex build helmet.glb -o built.glb --primary Hose_low=cylinder:map          a tube, without a seam
  invertex build bottle.glb -o built.glb --ambiguous twice.csv        which triangles share a place with others
  invertex build apple.glb -o built.glb --shader-lod 256              far away one fetch does
  invertex build globe.glb -o built.glb --simplifier progressive      says how far any detail is displaced, at most
  invertex build apple.glb -o built.glb --layout classic --device cpu --json | jq '.meshes[].tables_sha256'")]
pub(super) struct Build {
    /// The model: .glb or .gltf.
    input: PathBuf,
    /// The file to write.
    #[arg(short, long, value_name = "OUT.glb")]
    output: PathBuf,
    /// Primary parameterization: auto, uv0, uv1, .., plane[:AXIS], cylinder[:AXIS], sphere[:X,Y,Z], or computed:
    /// lscm, abf, isochart (each with :STRETCH, 1.1 by default), geometry-image, sphere:map, cylinder:map; or
    /// MESH=KIND for one mesh. May be given several times.
    #[arg(long, value_name = "[MESH=]KIND", allow_hyphen_values = true)]
    primary: Vec<String>,
    /// Texels along each side of the hash texture: a power of two up to 8192, or auto (about two texels a triangle).
    #[arg(
        long,
        value_name = "N",
        default_value = "auto",
        allow_hyphen_values = true
    )]
    hash: String,
    /// Layout of the tables: ours, or the paper's.
    #[arg(long, value_enum, default_value_t = LayoutName::Packed)]
    layout: LayoutName,
    /// Fractions of the triangles, one for each LoD.
    #[arg(
        long,
        value_name = "F,F,..",
        default_value = "0.5,0.2,0.1,0.05",
        allow_hyphen_values = true
    )]
    lods: String,
    /// Write the triangles that share a place with another, where colours may be wrong: mesh,triangle, one a line.
    #[arg(long, value_name = "FILE.csv")]
    ambiguous: Option<PathBuf>,
    /// Filter the appearance beforehand, so many texels along each side (a power of two from 32 to 4096): `render
    /// --shader-lod` then shows it where it is as good as the lookup.
    #[arg(long, value_name = "N")]
    shader_lod: Option<u32>,
    /// What simplifies.
    #[arg(long, value_enum, default_value_t = Simplifier::Meshopt)]
    simplifier: Simplifier,
    /// Keep every step of the simplification, so that `render --lod pixels:X` draws triangles of every age side by side, as
    /// many as the view needs. Meshes that an animation deforms go without.
    #[arg(long, value_enum, value_name = "WHAT", num_args = 0..=1, require_equals = true, default_missing_value = "lab")]
    mrm: Option<Mrm>,
}

#[derive(Serialize)]
struct Report<'a> {
    file: String,
    output: String,
    output_bytes: u64,
    device: String,
    warnings: &'a [String],
    meshes: &'a [MeshReport],
    #[serde(serialize_with = "in_order")]
    build_ms: Vec<(&'static str, f64)>,
}

/// Pairs as a JSON object that keeps their order.
fn in_order<S: Serializer>(
    pairs: &[(&'static str, f64)],
    serializer: S,
) -> std::result::Result<S::Ok, S::Error> {
    serializer.collect_map(
        pairs
            .iter()
            .map(|(name, ms)| (name, (ms * 1e3).round() / 1e3)),
    )
}

impl Build {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        let settings = self.settings()?;
        self.check_output()?;
        self.ambiguous.as_deref().map_or(Ok(()), check_target)?;
        let start = Instant::now();
        let scene = load_original(&self.input)?;
        let mut times = vec![("load", milliseconds(start))];
        scene
            .warnings
            .iter()
            .for_each(|warning| note(common, warning));
        let device = Device::open(common)?;
        let mut outcome = {
            let bar = Bar::new(common, 0);
            asset::build(scene, &settings, device.processor(), &bar)?
        };
        times.extend(&outcome.milliseconds);
        outcome.notes.iter().for_each(|words| note(common, words));
        if let Some(size) = self.shader_lod {
            let filtering = Instant::now();
            let bar = Bar::new(common, 0);
            let warnings = prefilter(&mut outcome.built, size, &bar)?;
            drop(bar);
            warnings.iter().for_each(|warning| note(common, warning));
            times.push(("shader_lod", milliseconds(filtering)));
        }
        let writing = Instant::now();
        write_bytes(&self.output, &asset::to_bytes(&outcome.built)?)?;
        if let Some(path) = &self.ambiguous {
            let names = outcome.reports.iter().map(|mesh| mesh.name.as_str());
            ambiguous::write(path, names.zip(&outcome.ambiguous))?;
        }
        times.push(("write", milliseconds(writing)));
        times.push(("total", milliseconds(start)));
        device.check();
        outcome.reports.iter().for_each(|mesh| warn(common, mesh));
        let report = Report {
            file: self.input.display().to_string(),
            output: self.output.display().to_string(),
            output_bytes: std::fs::metadata(&self.output).map_or(0, |meta| meta.len()),
            device: device.name(),
            warnings: &[outcome.built.scene.warnings.as_slice(), &outcome.notes].concat(),
            meshes: &outcome.reports,
            build_ms: times,
        };
        if common.json {
            print::json(&report)
        } else {
            print::text(&readable(&report))
        }
    }

    fn settings(&self) -> Result<BuildSettings> {
        let mut settings = BuildSettings {
            hash: hash(&self.hash)?,
            lods: fractions(&self.lods)?,
            layout: self.layout.into(),
            simplifier: self.simplifier.into(),
            multiresolution: Mrm::of(self.mrm),
            ..BuildSettings::default()
        };
        for text in &self.primary {
            // A mesh's name may hold `=`; a kind never does.
            match text.rsplit_once('=') {
                Some((mesh, kind)) => settings.primary_of.push((mesh.to_owned(), kind.parse()?)),
                None if settings.primary != PrimaryRequest::Auto => {
                    return Err(bad_option(
                        "--primary",
                        "given twice for all meshes; write MESH=KIND for one of them",
                    ));
                }
                None => settings.primary = text.parse()?,
            }
        }
        Ok(settings)
    }

    /// Everything that can be said about the output before any work.
    fn check_output(&self) -> Result<()> {
        let known = self
            .output
            .extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("glb"));
        if !known && !is_device(&self.output) {
            return Err(bad_option(
                "-o",
                format!(
                    "{}: the file's name must end in .glb",
                    self.output.display()
                ),
            ));
        }
        check_target(&self.output)?;
        let same = |a: &Path, b: &Path| {
            a.canonicalize()
                .is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b))
        };
        if same(&self.input, &self.output) {
            let reason = format!(
                "{} is the input; the original would be lost",
                self.output.display()
            );
            return Err(bad_option("-o", reason));
        }
        Ok(())
    }
}

/// A pipe or device takes any bytes, whatever its name.
fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|meta| !meta.is_file() && !meta.is_dir())
}

/// A model that has no inverse textures yet.
pub(super) fn load_original(path: &Path) -> Result<Scene> {
    if asset::is_built(&read_file(path)?) {
        let reason = "this model has inverse textures already; build from the original";
        return Err(Error::input(
            path.display().to_string(),
            asset::EXTENSION,
            reason,
        ));
    }
    Scene::load(path)
}

fn hash(text: &str) -> Result<Option<u32>> {
    if text == "auto" {
        return Ok(None);
    }
    let number = text.parse::<u32>().ok().filter(|n| n.is_power_of_two());
    let number = number.ok_or_else(|| {
        bad_option(
            "--hash",
            format!("\"{text}\" is not auto or a power of two up to 8192"),
        )
    })?;
    Ok(Some(number))
}

fn fractions(text: &str) -> Result<Vec<f32>> {
    let one = |part: &str| {
        part.trim().parse::<f32>().map_err(|_| {
            bad_option(
                "--lods",
                format!("\"{part}\" is not a number; write fractions such as 0.5,0.2,0.05"),
            )
        })
    };
    text.split(',').map(one).collect()
}

pub(super) fn milliseconds(since: Instant) -> f64 {
    since.elapsed().as_secs_f64() * 1e3
}

/// What will show in pictures.
fn warn(common: &Common, mesh: &MeshReport) {
    if mesh.ambiguous_fraction > 0.001 {
        let share = percent(mesh.ambiguous_fraction);
        note(
            common,
            &format!(
                "{}: {share} of {} is ambiguous, in {} triangles; wrong colours may show there",
                mesh.name,
                mesh.primary,
                thousands(mesh.ambiguous_triangles as u64)
            ),
        );
    }
    if mesh.unreached_texels > 0 {
        let count = thousands(mesh.unreached_texels);
        note(
            common,
            &format!(
                "{}: LoDs reach {count} texels that no gutter does; holes may show there",
                mesh.name
            ),
        );
    }
    if let Some(k) = mesh.lods.iter().position(|lod| !lod.reached) {
        note(
            common,
            &format!(
                "{}: LoD {} could not come down to the triangles asked for",
                mesh.name,
                k + 1
            ),
        );
    }
}

fn readable(report: &Report) -> String {
    let mut tables = Table::new(&[
        "mesh",
        "triangles",
        "primary",
        "hash",
        "entries",
        "mean list",
        "longest",
        "ambiguous",
        "gutter",
        "KiB",
    ]);
    for mesh in report.meshes {
        tables.row([
            mesh.name.clone(),
            thousands(mesh.triangles as u64),
            mesh.primary.clone(),
            format!("{}x{}", mesh.hash[0], mesh.hash[1]),
            thousands(mesh.entries),
            format!("{:.2}", mesh.mean_list),
            mesh.max_list.to_string(),
            percent(mesh.ambiguous_fraction),
            mesh.gutter_width.to_string(),
            thousands(mesh.bytes.total.div_ceil(1024)),
        ]);
    }
    let mut lods = Table::new(&[
        "mesh",
        "LoD",
        "triangles",
        "of the reference",
        "largest deviation",
        "detail displaced at most",
    ]);
    for mesh in report.meshes {
        for (k, lod) in mesh.lods.iter().enumerate() {
            lods.row([
                mesh.name.clone(),
                (k + 1).to_string(),
                thousands(lod.triangles as u64),
                percent(lod.triangles as f64 / mesh.triangles.max(1) as f64),
                format!("{:.4e}", lod.deviation_max),
                lod.deviation_bound
                    .map_or_else(|| "-".into(), |bound| format!("{bound:.4e}")),
            ]);
        }
    }
    let why: String = report
        .meshes
        .iter()
        .map(|mesh| format!("{}: {}\n", mesh.name, mesh.why))
        .collect();
    let cut = |mesh: &MeshReport| {
        let model = mesh.multiresolution.as_ref()?;
        Some(format!(
            "{}: views take cuts of {} to {} triangles{}\n",
            mesh.name,
            thousands(model.coarsest as u64),
            thousands(mesh.triangles as u64),
            if model.colour_distance.is_some() {
                ", by pixels and colour"
            } else {
                ""
            },
        ))
    };
    let cuts: String = report.meshes.iter().filter_map(cut).collect();
    let times: Vec<String> = report
        .build_ms
        .iter()
        .map(|(stage, ms)| format!("{stage} {ms:.0}"))
        .collect();
    format!(
        "{}\n{}\n{why}{cuts}\n{} written ({} KiB), tables built on {}\nmilliseconds: {}\n",
        tables.text(),
        lods.text(),
        report.output,
        thousands(report.output_bytes.div_ceil(1024)),
        report.device,
        times.join(", ")
    )
}
