//! An [`Attribute`] held against a scene: what a picture of it needs to show it.
//!
//! In: a [`Scene`], an attribute by name. Out: [`Shown`]: the factors as words, and for each mesh the numbers that its vertices
//! carry besides normal, tangent, colour and uv. All of it is of the model at rest, so a point of the reference shows the
//! same in every pose and on every level of detail.

use super::material::Slot;
use super::named::{Attribute, Factor, VertexAttribute, wrong};
use super::occlusion::{self, OcclusionOptions};
use super::show::{self, FACTOR_WORDS};
use super::surface::UV_AT;
use crate::mesh::{self, Mesh, Weld};
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
}

/// How what has to be computed is.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ShownOptions {
    /// Of [`VertexAttribute::Occlusion`].
    pub occlusion: OcclusionOptions,
}

/// Numbers that vertices carry behind their uv sets.
#[derive(Clone, Debug, Default)]
pub(super) struct Extra {
    /// Of each vertex.
    pub(super) width: usize,
    /// Of each mesh of the scene, vertex after vertex.
    pub(super) meshes: Arc<Vec<Vec<f32>>>,
}

/// Numbers of one factor.
struct Column {
    width: usize,
    meshes: Vec<Vec<f32>>,
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
            let column = column(scene, factor, options, progress)?;
            factors.push([word(factor, column.as_ref(), first + width), 0]);
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
        })
    }

    /// What is shown.
    pub fn attribute(&self) -> &Attribute {
        &self.attribute
    }

    fn has(&self, factor: &Factor) -> bool {
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

/// The numbers of a factor that are not among the vertices' words already.
fn column(
    scene: &Scene,
    factor: &Factor,
    options: &ShownOptions,
    progress: &dyn Fn(usize, usize),
) -> Result<Option<Column>> {
    let one = |meshes| Some(Column { width: 1, meshes });
    Ok(match factor {
        Factor::Part => one(parts(scene)),
        Factor::Vertex { of, .. } => match of {
            VertexAttribute::Color => None,
            VertexAttribute::Occlusion => {
                one(occlusion::cast(scene, &options.occlusion, progress)?)
            }
            VertexAttribute::Custom { name, range } => Some(custom(scene, name, *range)),
        },
        _ => None,
    })
}

/// For each vertex the number of its connected part, parts of all meshes counted in one run.
fn parts(scene: &Scene) -> Vec<Vec<f32>> {
    let mut before = 0;
    let mut of_mesh = |mesh: &Mesh| {
        let weld = Weld::by_position(&mesh.positions);
        let parts = mesh::components(&weld.triangles(&mesh.triangles), mesh.positions.len());
        let mut number = vec![0.0; mesh.positions.len()];
        for (triangle, part) in mesh.triangles.iter().zip(&parts.of) {
            triangle
                .iter()
                .for_each(|&v| number[v as usize] = (before + *part as usize) as f32);
        }
        before += parts.count;
        number
    };
    scene.meshes.iter().map(&mut of_mesh).collect()
}

/// A custom attribute; 0 where a mesh lacks it.
fn custom(scene: &Scene, name: &str, range: Option<[f32; 2]>) -> Column {
    let named = |m: &'_ Mesh| m.custom.iter().find(|c| c.name == name).map(|c| c.width);
    let width = scene.meshes.iter().filter_map(named).max().unwrap_or(1);
    let scaled = |x: f32| range.map_or(x, |[low, high]| (x - low) / (high - low));
    let of_mesh = |mesh: &Mesh| {
        let own = mesh.custom.iter().find(|c| c.name == name);
        let number = |i: usize| match own {
            Some(own) if i % width < own.width => own.values[i / width * own.width + i % width],
            _ => 0.0,
        };
        (0..mesh.positions.len() * width)
            .map(number)
            .map(scaled)
            .collect()
    };
    Column {
        width,
        meshes: scene.meshes.iter().map(of_mesh).collect(),
    }
}
