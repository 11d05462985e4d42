//! An [`Attribute`] held against a scene: what a picture of it needs to show it.
//!
//! In: a [`Scene`], an attribute by name. Out: [`Shown`]: the factors as words, and for each mesh the numbers that its vertices
//! carry besides normal, tangent, colour and uv. All of it is of the model at rest, so a point of the reference shows the
//! same in every pose and on every level of detail.

use super::columns::{Column, column};
use super::material::Slot;
use super::named::{Attribute, Factor, VertexAttribute, wrong};
use super::occlusion::OcclusionOptions;
use super::procedural::Procedural;
use super::show::{self, FACTOR_WORDS};
use super::surface::UV_AT;
use super::volume::Volume;
use crate::mesh::Mesh;
use crate::scene::{self, AlphaMode, Scene, TextureRef};
use crate::{Error, Result};
use std::collections::BTreeSet;
use std::sync::Arc;

/// Numbers smaller than this are zero: no product of them in a shader is subnormal.
const LEAST: f32 = 1e-20;

/// What a picture shows in place of base colour, made ready for one scene.
///
/// ```no_run
/// # use invertex::attribute::{Shown, ShownOptions, attributes_showing};
/// # use invertex::render::{Correspond, stage_with};
/// # fn main() -> invertex::Result<()> {
/// let scene = invertex::scene::Scene::load("model.glb".as_ref())?;
/// let attribute = "color*occlusion".parse()?;
/// let shown = Shown::new(&scene, &attribute, &ShownOptions::default(), &|_, _| ())?;
/// let (attributes, warnings) = attributes_showing(&scene, true, &shown)?;
/// let picture = stage_with(attributes, &scene, &[], Correspond::Reference, &scene.rest())?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Shown {
    attribute: Attribute,
    pub(super) factors: Vec<[u32; FACTOR_WORDS]>,
    pub(super) extra: Extra,
    pub(super) volume: Option<Volume>,
    pub(super) procedural: Option<Procedural>,
}

/// How what has to be computed is.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownOptions {
    /// Of [`VertexAttribute::Occlusion`].
    pub occlusion: OcclusionOptions,
    /// How many times as fine solid textures and volumes are.
    pub scale: f32,
    /// Whether solid textures stand still whatever the time.
    pub still: bool,
    /// What [`Factor::Volume`] is.
    pub volume: Option<Volume>,
    /// What [`Factor::Procedural`] is.
    pub procedural: Option<Procedural>,
}

impl Default for ShownOptions {
    fn default() -> Self {
        ShownOptions {
            occlusion: OcclusionOptions::default(),
            scale: 1.0,
            still: false,
            volume: None,
            procedural: None,
        }
    }
}

/// Numbers that vertices carry behind their uv sets.
#[derive(Clone, Debug, Default)]
pub(super) struct Extra {
    /// Of each vertex.
    pub(super) width: usize,
    /// Of each mesh of the scene, vertex after vertex.
    pub(super) meshes: Arc<Vec<Vec<f32>>>,
}

impl Shown {
    /// Makes `attribute` ready for `scene`. `progress` hears how many of how many steps are over.
    ///
    /// # Errors
    /// [`Error::Option`] where the scene has no such attribute, naming those it has, and where `options` are out of range;
    /// [`Error::Input`] where a mesh lacks the uv that a texture is laid out by.
    pub fn new(
        scene: &Scene,
        attribute: &Attribute,
        options: &ShownOptions,
        progress: &dyn Fn(usize, usize),
    ) -> Result<Shown> {
        let first = UV_AT + 2 * uv_sets(scene);
        let (mut factors, mut columns) = (Vec::new(), Vec::new());
        let mut width = 0;
        for factor in attribute.factors() {
            check(scene, factor)?;
            check_options(factor, options)?;
            let column = column(scene, factor, options, progress)?;
            let more = match factor {
                Factor::Solid(solid) => *solid as u32 | (u32::from(options.still) * show::STILL),
                _ => 0,
            };
            factors.push([word(factor, column.as_ref(), first + width), more]);
            width += column.as_ref().map_or(0, |c| c.width);
            columns.extend(column);
        }
        let side_by_side = |m: usize| {
            let vertices = scene.meshes[m].positions.len();
            let of = |v: usize| {
                let own = move |c: &Column| c.meshes[m][v * c.width..(v + 1) * c.width].to_vec();
                columns.iter().flat_map(own).collect::<Vec<f32>>()
            };
            (0..vertices).flat_map(of).map(large).collect()
        };
        let meshes = match width {
            0 => Vec::new(),
            _ => (0..scene.meshes.len()).map(side_by_side).collect(),
        };
        Ok(Shown {
            attribute: attribute.clone(),
            factors,
            extra: Extra {
                width,
                meshes: Arc::new(meshes),
            },
            volume: options.volume.clone(),
            procedural: options.procedural.clone(),
        })
    }

    /// What is shown.
    pub fn attribute(&self) -> &Attribute {
        &self.attribute
    }

    pub(super) fn has(&self, factor: &Factor) -> bool {
        self.attribute.factors().contains(factor)
    }

    /// Whether metalness and emission stay as the material has them.
    pub(super) fn keeps_material(&self) -> bool {
        self.has(&Factor::BaseColor)
    }

    /// Whether a texture of a material is read. `lit`: whether the picture is.
    pub(super) fn wants(&self, slot: Slot, material: &scene::Material, lit: bool) -> bool {
        let lit = lit && !self.attribute.is_data() && !material.unlit;
        match slot {
            Slot::BaseColor => self.has(&Factor::BaseColor) || material.alpha == AlphaMode::Mask,
            Slot::MetallicRoughness => lit || self.has(&Factor::MetallicRoughness),
            Slot::Normal => lit || self.has(&Factor::NormalMap) || self.has(&Factor::Normal),
            Slot::Occlusion => lit || self.has(&Factor::OcclusionMap),
            Slot::Emissive => self.has(&Factor::Emissive) || lit && self.keeps_material(),
        }
    }
}

fn large(x: f32) -> f32 {
    if x.abs() < LEAST { 0.0 } else { x }
}

/// Uv sets that every vertex carries.
pub(super) fn uv_sets(scene: &Scene) -> usize {
    let sets = scene.meshes.iter().map(|m| m.uv_sets.len());
    sets.max().unwrap_or(0).max(1)
}

/// The first word of a factor whose numbers, if any, begin at `at`.
fn word(factor: &Factor, column: Option<&Column>, at: usize) -> u32 {
    let width = column.map_or(0, |c| c.width);
    let plain = |kind| show::word(kind, 0, false, 0);
    match factor {
        Factor::BaseColor => plain(show::BASE_COLOR),
        Factor::NormalMap => plain(show::NORMAL_MAP),
        Factor::MetallicRoughness => plain(show::METALLIC_ROUGHNESS),
        Factor::Emissive => plain(show::EMISSIVE),
        Factor::OcclusionMap => plain(show::OCCLUSION_MAP),
        Factor::Normal => plain(show::NORMAL),
        Factor::TriangleColor => plain(show::TRIANGLE_COLOR),
        Factor::Material => plain(show::MATERIAL),
        Factor::Part => show::word(show::PART, 1, true, at),
        Factor::Solid(_) => show::word(show::SOLID, 3, false, at),
        Factor::Volume => show::word(show::VOLUME, 3, false, at),
        Factor::Procedural => show::word(show::FUNCTION, 3, false, at),
        Factor::Vertex { of, flat } => match of {
            VertexAttribute::Color => show::word(show::VERTEX, 3, *flat, 7),
            _ => show::word(show::VERTEX, width, *flat, at),
        },
    }
}

/// Refuses what the scene does not have.
fn check(scene: &Scene, factor: &Factor) -> Result<()> {
    let drawn = || scene.meshes.iter().filter(|m| !m.triangles.is_empty());
    match factor {
        Factor::BaseColor => has_uv(scene, "base colour", |m| m.base_color_texture),
        Factor::MetallicRoughness => has_uv(scene, "metallic-roughness", |m| {
            m.metallic_roughness_texture
        }),
        Factor::Emissive => has_uv(scene, "emissive", |m| m.emissive_texture),
        Factor::NormalMap => {
            has_map(scene, "normal map", |m| m.normal_texture)?;
            has_uv(scene, "normal map", |m| m.normal_texture)
        }
        Factor::OcclusionMap => {
            has_map(scene, "occlusion map", |m| m.occlusion_texture)?;
            has_uv(scene, "occlusion map", |m| m.occlusion_texture)
        }
        Factor::Vertex {
            of: VertexAttribute::Color,
            ..
        } if drawn().all(|m| m.colors.is_empty()) => {
            Err(wrong("no mesh of the model has vertex colours (COLOR_0)"))
        }
        Factor::Vertex {
            of: VertexAttribute::Custom { name, .. },
            ..
        } => {
            let there: BTreeSet<&str> = drawn()
                .flat_map(|m| &m.custom)
                .map(|c| c.name.as_str())
                .collect();
            if there.contains(name.as_str()) {
                return Ok(());
            }
            let there: Vec<&str> = there.into_iter().collect();
            Err(wrong(match there.len() {
                0 => format!("there is no {name}: the model has no custom attributes"),
                _ => format!(
                    "there is no {name}; the model's custom attributes are: {}",
                    there.join(", ")
                ),
            }))
        }
        _ => Ok(()),
    }
}

/// Refuses what the options do not give.
fn check_options(factor: &Factor, options: &ShownOptions) -> Result<()> {
    match factor {
        Factor::Solid(_) | Factor::Volume if !(1e-3..=1e3).contains(&options.scale) => {
            Err(Error::Option {
                option: "--solid-scale",
                reason: format!("{} is outside 0.001 to 1000", options.scale),
            })
        }
        Factor::Volume if options.volume.is_none() => {
            Err(wrong("volume needs a 3-D image: --volume FILE or FOLDER"))
        }
        Factor::Procedural if options.procedural.is_none() => {
            Err(wrong("procedural needs a function: --procedural FILE.glsl"))
        }
        Factor::Procedural if !cfg!(feature = "compile-shaders") => Err(wrong(
            "procedural needs an invertex that can compile shaders: cargo install --path . --features compile-shaders",
        )),
        _ => Ok(()),
    }
}

type Texture = fn(&scene::Material) -> Option<TextureRef>;

fn has_map(scene: &Scene, what: &str, texture: Texture) -> Result<()> {
    let used = scene.meshes.iter().flat_map(|m| &m.triangle_material);
    let used: BTreeSet<u32> = used.copied().collect();
    let mut materials = used.iter().filter_map(|&m| scene.materials.get(m as usize));
    match materials.any(|m| texture(m).is_some()) {
        true => Ok(()),
        false => Err(wrong(format!("no material of the model has a {what}"))),
    }
}

fn has_uv(scene: &Scene, what: &str, texture: Texture) -> Result<()> {
    for mesh in &scene.meshes {
        if let Some((material, set)) = missing_uv(scene, mesh, texture) {
            let reason = format!(
                "has no TEXCOORD_{set}, which the {what} texture of material \"{}\" is laid out by",
                scene.materials[material].name
            );
            return Err(Error::input(
                &scene.name,
                format!("mesh \"{}\"", mesh.name),
                reason,
            ));
        }
    }
    Ok(())
}

/// The first material whose texture is laid out by a uv set that `mesh` lacks, and the set.
pub(super) fn missing_uv(
    scene: &Scene,
    mesh: &Mesh,
    texture: impl Fn(&scene::Material) -> Option<TextureRef>,
) -> Option<(usize, usize)> {
    let used: BTreeSet<u32> = mesh.triangle_material.iter().copied().collect();
    used.into_iter().find_map(|m| {
        let set = texture(scene.materials.get(m as usize)?)?.uv_set;
        (set >= mesh.uv_sets.len()).then_some((m as usize, set))
    })
}
