//! What `bake` says of its textures.

use std::path::Path;
use std::time::Duration;

use invertex::Result;
use invertex::output::write_bytes;
use invertex::recover::{BakeSettings, Baked, Over, PairSettings};
use serde::Serialize;
use serde::ser::{SerializeMap, Serializer};
use sha2::{Digest, Sha256};

use super::print::{Table, percent};

/// A share of misses that is worth a warning.
const MANY: f64 = 0.01;

#[derive(Serialize)]
pub(super) struct Report {
    file: String,
    /// The model that is baked for, where there are two.
    low: Option<String>,
    device: String,
    mapping: &'static str,
    over: &'static str,
    lod: Option<usize>,
    size: u32,
    samples: u32,
    padding: u32,
    filled_fraction: f64,
    missed_fraction: f64,
    meshes: Vec<MeshReport>,
    pub(super) textures: Vec<TextureReport>,
    files: Vec<String>,
    /// Time that writing took.
    #[serde(skip)]
    pub(super) writing: Duration,
    #[serde(serialize_with = "by_name")]
    pub(super) ms: Vec<(&'static str, f64)>,
    pub(super) warnings: Vec<String>,
}

fn by_name<S: Serializer>(times: &[(&str, f64)], to: S) -> std::result::Result<S::Ok, S::Error> {
    let mut map = to.serialize_map(Some(times.len()))?;
    for (name, ms) in times {
        map.serialize_entry(name, ms)?;
    }
    map.end()
}

#[derive(Serialize)]
pub(super) struct MeshReport {
    name: String,
    /// The UDIM number, where the mesh has several tiles.
    #[serde(skip_serializing_if = "Option::is_none")]
    tile: Option<u32>,
    /// Of the LoD.
    triangles: Option<usize>,
    filled_fraction: f64,
    missed_fraction: f64,
    #[serde(skip)]
    counts: [u64; 4],
}

#[derive(Serialize)]
pub(super) struct TextureReport {
    mesh: String,
    attribute: String,
    path: String,
    sha256: String,
}

impl TextureReport {
    pub(super) fn new(mesh: &str, attribute: &str, path: &Path, bytes: &[u8]) -> Self {
        let digest = Sha256::digest(bytes);
        TextureReport {
            mesh: mesh.to_owned(),
            attribute: attribute.to_owned(),
            path: path.display().to_string(),
            sha256: digest.iter().map(|byte| format!("{byte:02x}")).collect(),
        }
    }
}

impl MeshReport {
    pub(super) fn new((name, tile): (&str, Option<u32>), baked: &Baked, size: u32) -> Self {
        let counts = [
            baked.filled,
            baked.missed,
            baked.filled + baked.empty,
            u64::from(size) * u64::from(size),
        ];
        let (filled_fraction, missed_fraction) = fractions(counts);
        MeshReport {
            name: name.to_owned(),
            tile,
            triangles: baked.low.as_ref().map(|low| low.triangles.len()),
            filled_fraction,
            missed_fraction,
            counts,
        }
    }
}

/// Texels with a point of the reference, of all; texels whose point was not found, of those on the surface.
fn fractions([filled, missed, on, all]: [u64; 4]) -> (f64, f64) {
    let share = |part: u64, of: u64| part as f64 / of.max(1) as f64;
    (share(filled, all), share(missed, on))
}

impl Report {
    pub(super) fn new(file: String, settings: &BakeSettings) -> Self {
        let (over, lod) = match settings.over {
            Over::Lod(level) => ("lod", Some(level)),
            Over::Primary => ("primary", None),
        };
        Report {
            file,
            low: None,
            device: "cpu".into(),
            mapping: settings.mapping.name(),
            over,
            lod,
            size: settings.size,
            samples: settings.samples,
            padding: settings.padding,
            filled_fraction: 0.0,
            missed_fraction: 0.0,
            meshes: vec![],
            textures: vec![],
            files: vec![],
            writing: Duration::ZERO,
            ms: vec![],
            warnings: vec![],
        }
    }

    /// Of the detail of `high` on `low`.
    pub(super) fn of_pair([high, low]: [String; 2], device: &str, settings: &PairSettings) -> Self {
        let one = BakeSettings {
            mapping: settings.mapping,
            size: settings.size,
            samples: settings.samples,
            padding: settings.padding,
            ..BakeSettings::default()
        };
        Report {
            low: Some(low),
            device: device.to_owned(),
            over: "low",
            lod: None,
            ..Report::new(high, &one)
        }
    }

    /// Says of each mesh what was not found, where that is much.
    pub(super) fn warn_of_misses(&mut self) {
        for mesh in &self.meshes {
            if mesh.missed_fraction > MANY {
                let (name, missed) = (&mesh.name, percent(mesh.missed_fraction));
                self.warnings.push(format!(
                    "mesh \"{name}\": no point of the reference was found for {missed} of its texels; its mask shows which"
                ));
            }
        }
    }

    /// Writes a file that is no texture.
    pub(super) fn file(&mut self, path: &Path, bytes: &[u8]) -> Result<()> {
        write_bytes(path, bytes)?;
        self.files.push(path.display().to_string());
        Ok(())
    }

    /// Adds a mesh.
    pub(super) fn mesh(&mut self, mesh: MeshReport) {
        self.meshes.push(mesh);
        let sum = |k: usize| self.meshes.iter().map(|m| m.counts[k]).sum::<u64>();
        (self.filled_fraction, self.missed_fraction) = fractions([sum(0), sum(1), sum(2), sum(3)]);
    }

    pub(super) fn text(&self) -> String {
        let mut table = Table::new(&["mesh", "attribute", "file"]);
        for texture in &self.textures {
            table.row([&texture.mesh, &texture.attribute, &texture.path]);
        }
        let mut text = table.text();
        let mut table = Table::new(&["mesh", "filled", "missed"]);
        for mesh in &self.meshes {
            let [filled, missed] = [mesh.filled_fraction, mesh.missed_fraction].map(percent);
            let tile = mesh.tile.map_or(String::new(), |tile| format!(".{tile}"));
            table.row([format!("{}{tile}", mesh.name), filled, missed]);
        }
        text += &format!("\n{}", table.text());
        for file in &self.files {
            text += &format!("{file}\n");
        }
        text
    }
}
