//! `bake`: attributes of a reference as textures of a simpler surface.

use std::path::PathBuf;
use std::time::Instant;

use super::attribute::Computed;
use super::bake_report::{MeshReport, Report, TextureReport};
use super::print;
use super::progress::Bar;
use super::view::Size;
use super::{Common, bad_option, mesh_named, note};
use invertex::asset::{Built, Model, Progress};
use invertex::attribute::Attribute;
use invertex::output::{
    TexturePlace, TexturedMesh, encode_exr, encode_glb, encode_png, make_folder, write_bytes,
};
use invertex::recover::{BakeAttribute, BakeSettings, Baked, Baker, Mapping, Over};
use invertex::{Error, Result};

/// Resample attributes of a reference into textures of a simpler surface.
///
/// The mapping uv-match takes each texel's point of the LoD through the inverse texture to the reference; the file has to be
/// one that `build` made. Over a LoD the textures come with the LoD itself, cut along its atlas, as baked.glb.
#[derive(clap::Args)]
#[command(after_help = "\
Attributes: normal (tangent space of the LoD, +Y up), object-normal, position, color (base colour, vertex colours
included), vertex-color (COLOR_0), and all that `render --attribute` knows: occlusion, metallic-roughness, emissive,
triangle-color, material, part, _NAME, wood, ... and products of them.

Files in OUT: MESH_ATTRIBUTE.png, MESH_mask.png (white: from the reference; grey: a neighbour's; black: the mean), baked.glb.

JSON: mapping, over, size, samples, padding, filled_fraction (texels with a point of the reference, of all texels),
missed_fraction (texels on the surface without one), meshes[]: name, triangles, filled_fraction, missed_fraction;
textures[]: mesh, attribute, path, sha256; files[]; ms{}; warnings[].

Examples:
  invertex bake built.glb -o textures/ --lod 2 --attributes color,normal,metallic-roughness --size 2048
  invertex bake built.glb -o textures/ --attributes occlusion,_HEAT:0..100 --format exr
  invertex bake built.glb -o wood/ --lod 3 --attributes 'wood*occlusion' --samples 4
  invertex bake built.glb -o square/ --over primary --attributes color,object-normal,position")]
pub(super) struct Bake {
    /// The model: a file that `build` made.
    high: PathBuf,
    /// The folder for all files.
    #[arg(short, long, value_name = "OUT")]
    output: PathBuf,
    /// Which point of the reference a texel stands for.
    #[arg(long, value_enum, default_value_t = Map::UvMatch)]
    map: Map,
    /// What textures are laid out over: a LoD, or the primary parameterization's square of addresses, for all LoDs.
    #[arg(long, value_enum, default_value_t = Layout::Lod)]
    over: Layout,
    /// The level of detail; 0 is the reference's own geometry. Default: 1.
    #[arg(long, value_name = "N")]
    lod: Option<usize>,
    /// What is baked, one texture for each.
    #[arg(long, value_name = "NAME,..", value_delimiter = ',', required = true)]
    attributes: Vec<String>,
    /// Texels along each side.
    #[arg(long, value_name = "N", default_value = "1024")]
    size: Size,
    /// Samples along each side of a texel.
    #[arg(long, value_name = "N", default_value_t = 2)]
    samples: u32,
    /// Texels that borders grow by.
    #[arg(long, value_name = "N", default_value_t = 8)]
    padding: u32,
    /// 8 bits, or also linear floats.
    #[arg(long, value_enum, default_value_t = Format::Png)]
    format: Format,
    /// Bake this mesh alone.
    #[arg(long, value_name = "NAME")]
    mesh: Option<String>,
    #[command(flatten)]
    computed: Computed,
}

/// Correspondences.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Map {
    /// The inverse geometric texture.
    UvMatch,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Layout {
    /// A LoD, cut along an atlas of its own (over a uv primary: the artist's).
    Lod,
    /// The primary parameterization.
    Primary,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
enum Format {
    /// 8 bits: colours as sRGB, data as it is, directions from -1..1.
    Png,
    /// Those, and linear floats beside them.
    Exr,
}

/// A bar that hears how a bake goes.
struct Heard(Bar);

impl Progress for Heard {
    fn at(&self, stage: &'static str, subject: &str, done: usize, of: usize) {
        self.0
            .at(&format!("{stage}: {subject}"), done as u64, of as u64);
    }
}

impl Bake {
    pub(super) fn run(&self, common: &Common) -> Result<()> {
        let settings = self.settings()?;
        let Model::Built(built) = Model::load(&self.high)? else {
            let reason = "this model has no inverse textures; run `invertex build` first";
            return Err(Error::input(
                self.high.display().to_string(),
                "extensions",
                reason,
            ));
        };
        let chosen = self.chosen(&built)?;
        let heard = Heard(Bar::new(common, 1));
        let start = Instant::now();
        let mut baker = Baker::new(&built, &settings, &heard)?;
        let prepared = start.elapsed();
        let mut all = Vec::new();
        for &k in &chosen {
            all.push((k, baker.mesh(k, &heard)?));
        }
        let baked = start.elapsed();
        make_folder(&self.output)?;
        let mut report = Report::new(self.high.display().to_string(), &settings);
        report.warnings = baker.warnings.clone();
        for (k, baked) in &all {
            self.write_mesh(&built, *k, baked, &mut report)?;
        }
        if settings.over != Over::Primary {
            self.write_glb(&built, &all, &mut report)?;
        }
        let ms = |d: std::time::Duration| d.as_secs_f64() * 1e3;
        report.ms = vec![
            ("prepare", ms(prepared)),
            ("resample", ms(baked - prepared)),
            ("write", ms(start.elapsed() - baked)),
        ];
        drop(heard);
        report
            .warnings
            .iter()
            .for_each(|warning| note(common, warning));
        report.print(common)
    }

    /// What is asked for, as far as it can be told without the model.
    fn settings(&self) -> Result<BakeSettings> {
        if self.over == Layout::Primary && self.lod.is_some() {
            let reason = "says nothing about --over primary, whose texture serves all levels";
            return Err(bad_option("--lod", reason));
        }
        let Size(width, height) = self.size;
        if width != height {
            return Err(bad_option(
                "--size",
                "baked textures are square: give one number",
            ));
        }
        let attributes = self.attributes.iter().map(|text| text.parse());
        Ok(BakeSettings {
            mapping: match self.map {
                Map::UvMatch => Mapping::UvMatch,
            },
            over: match self.over {
                Layout::Lod => Over::Lod(self.lod.unwrap_or(1)),
                Layout::Primary => Over::Primary,
            },
            attributes: attributes.collect::<Result<_>>()?,
            size: width,
            samples: self.samples,
            padding: self.padding,
            shown: self.computed.options()?,
        })
    }

    /// The built meshes that are baked.
    fn chosen(&self, built: &Built) -> Result<Vec<usize>> {
        let Some(name) = &self.mesh else {
            return Ok((0..built.meshes.len()).collect());
        };
        let names = built
            .meshes
            .iter()
            .map(|m| built.scene.meshes[m.mesh].name.as_str());
        Ok(vec![mesh_named(&built.scene.name, names, name)?])
    }

    fn write_mesh(
        &self,
        built: &Built,
        k: usize,
        baked: &Baked,
        report: &mut Report,
    ) -> Result<()> {
        let number = built.meshes[k].mesh;
        let mesh = &built.scene.meshes[number];
        // Two meshes may have one name.
        let alike = |m: &invertex::asset::BuiltMesh| built.scene.meshes[m.mesh].name == mesh.name;
        let name = match built.meshes.iter().filter(|m| alike(m)).count() {
            1 => plain(&mesh.name),
            _ => format!("{}_{number}", plain(&mesh.name)),
        };
        let Size(size, _) = self.size;
        for texture in &baked.textures {
            let attribute = texture.attribute.to_string();
            let stem = format!("{name}_{}", plain(&attribute));
            let png = encode_png(size, size, &texture.rgba8)?;
            let mut files = vec![(format!("{stem}.png"), png)];
            if self.format == Format::Exr {
                files.push((
                    format!("{stem}.exr"),
                    encode_exr(size, size, &texture.values, None)?,
                ));
            }
            for (file, bytes) in files {
                let path = self.output.join(file);
                write_bytes(&path, &bytes)?;
                report
                    .textures
                    .push(TextureReport::new(&mesh.name, &attribute, &path, &bytes));
            }
        }
        let shade = |&m: &u8| [m, m, m, 255];
        let mask: Vec<u8> = baked.mask.iter().flat_map(shade).collect();
        report.file(
            &self.output.join(format!("{name}_mask.png")),
            &encode_png(size, size, &mask)?,
        )?;
        let triangles = baked.low.as_ref().map(|low| low.triangles.len());
        report.mesh(MeshReport::new(&mesh.name, triangles, baked, size));
        Ok(())
    }

    /// The LoD with what its material can have of the textures.
    fn write_glb(&self, built: &Built, all: &[(usize, Baked)], report: &mut Report) -> Result<()> {
        let encoded = all
            .iter()
            .map(|(_, baked)| self.material(baked))
            .collect::<Result<Vec<_>>>()?;
        let instances = built.scene.instances();
        let mut meshes = Vec::new();
        for ((k, baked), textures) in all.iter().zip(&encoded) {
            let number = built.meshes[*k].mesh;
            let own = instances.iter().filter(|i| i.mesh == number);
            let textures = textures.iter().map(|(place, png)| (*place, png.as_slice()));
            meshes.extend(baked.low.as_ref().map(|mesh| TexturedMesh {
                mesh,
                textures: textures.collect(),
                places: own.map(|i| i.world.as_mat4().to_cols_array_2d()).collect(),
            }));
        }
        report.file(&self.output.join("baked.glb"), &encode_glb(&meshes)?)
    }

    /// The first texture for each place of a material.
    fn material(&self, baked: &Baked) -> Result<Vec<(TexturePlace, Vec<u8>)>> {
        let Size(size, _) = self.size;
        let mut textures: Vec<(TexturePlace, Vec<u8>)> = Vec::new();
        for texture in &baked.textures {
            let free = |place: &TexturePlace| !textures.iter().any(|(p, _)| p == place);
            if let Some(place) = place(&texture.attribute).filter(free) {
                textures.push((place, encode_png(size, size, &texture.rgba8)?));
            }
        }
        Ok(textures)
    }
}

/// Where a material has room for an attribute.
fn place(attribute: &BakeAttribute) -> Option<TexturePlace> {
    match attribute {
        BakeAttribute::Normal => Some(TexturePlace::Normal),
        BakeAttribute::ObjectNormal | BakeAttribute::Position => None,
        BakeAttribute::Shown(shown) => match shown.to_string().as_str() {
            "metallic-roughness" => Some(TexturePlace::MetallicRoughness),
            "occlusion" | "occlusion-map" => Some(TexturePlace::Occlusion),
            "emissive" => Some(TexturePlace::Emissive),
            _ => Some(shown)
                .filter(|s: &&Attribute| !s.is_data())
                .map(|_| TexturePlace::BaseColor),
        },
    }
}

/// A name as a part of a file's name.
fn plain(name: &str) -> String {
    let keep = |c: char| {
        if c.is_alphanumeric() || "-_.".contains(c) {
            c
        } else {
            '-'
        }
    };
    name.chars().map(keep).collect()
}

impl Report {
    fn print(&self, common: &Common) -> Result<()> {
        if common.json {
            print::json(self)
        } else {
            print::text(&self.text())
        }
    }
}
