//! A LoD with a conventionally baked atlas: what inverse textures are measured against.
//!
//! In: a scene, for each mesh its tables and LoD, the size of the textures. Out: a picture of the same LoD triangles
//! whose colour and normal come from one baked texture each, at texture coordinates of their own (see `atlas.rs`).
//!
//! The detail is brought over by the inverse texture itself: each texel's point of the LoD is looked up, the reference's
//! base colour and two-level normal are taken there, filtered over the texel's footprint, and the normal is written in
//! the LoD's tangent frame. Metalness, roughness and emission become their means over the texels; occlusion is left out.

use super::atlas::{self, PADDING};
use super::fill;
use super::low::{Corners, ROWS, UPRIGHT, unwrapped};
use super::texel::{self, Flat};
use crate::attribute::arithmetic::{V3, srgb_encode, unit_encode};
use crate::attribute::surface::{Frame, Surface};
use crate::attribute::{
    Alpha, AttributeSet, Material, Pixels, Sampler, Slot, SlotBinding, TextureSet, Wrap,
};
use crate::igt::{Asker, Tables};
use crate::lod::Lod;
use crate::mesh::Mesh;
use crate::render::{Drawn, Picture, Subject, THRESHOLDS_AT, constants, inverse_at, level_zero};
use crate::scene::{self, Deformation, Scene};
use crate::{Error, Result};
use rayon::prelude::*;

/// The largest baked texture's side.
const MOST: u32 = 8192;

/// The picture of `scene` whose LoDs carry baked textures of `size` x `size` texels. `attributes` are the scene's, as
/// [`attributes_of`](crate::attribute::attributes_of) reads them. A mesh without tables is drawn white.
///
/// # Errors
/// [`Error::Option`] for a size out of range; [`Error::Capacity`] where the atlas of a LoD does not fit.
pub fn stage_baked(
    attributes: &AttributeSet,
    scene: &Scene,
    subjects: &[Subject],
    size: u32,
) -> Result<Picture> {
    if !(16..=MOST).contains(&size) {
        return Err(Error::Option {
            option: "--bake-size",
            reason: format!("{size} is outside 16 to {MOST}"),
        });
    }
    let pose = scene.rest();
    let instances = scene.instances_in(&pose);
    let mut baking = Baking {
        source: attributes.clone(),
        constants: constants(),
        size,
        textures: TextureSet::default(),
        materials: vec![Material::default()],
    };
    let mut baked: Vec<Option<(Mesh, f32)>> = vec![None; scene.meshes.len()];
    for instance in &instances {
        if baked[instance.mesh].is_none() {
            let subject = subjects.get(instance.mesh).cloned().unwrap_or_default();
            baked[instance.mesh] = Some(baking.mesh(scene, instance.mesh, &subject)?);
        }
    }
    let attributes = AttributeSet::new(baking.textures, &baking.materials, 1);
    let mut picture = Picture::new(attributes);
    for instance in &instances {
        let Some((mesh, slack)) = &baked[instance.mesh] else {
            continue;
        };
        let deformation = Deformation::of(scene, instance, &pose);
        let posed = deformation.as_ref().map(|d| d.mesh(mesh)).transpose()?;
        let world = deformation
            .as_ref()
            .map_or(instance.world, Deformation::world);
        let handed = deformation.as_ref().map_or(1.0, |d| d.handed(mesh.into()));
        let mesh = posed.as_ref().unwrap_or(mesh);
        let base = picture.attributes.push_mesh(mesh)?;
        let geometry = picture.add_geometry(&mesh.positions, &mesh.triangles, &[], &[], *slack)?;
        let geometry = geometry.with_handed(handed);
        picture.draw(geometry, base, None, world)?;
    }
    Ok(picture)
}

struct Baking {
    /// The reference's attributes.
    source: AttributeSet,
    constants: Vec<f32>,
    size: u32,
    /// What has been baked.
    textures: TextureSet,
    materials: Vec<Material>,
}

impl Baking {
    /// A mesh's LoD with its baked material; and how far it may lie from the reference.
    fn mesh(&mut self, scene: &Scene, mesh: usize, subject: &Subject) -> Result<(Mesh, f32)> {
        let reference = &scene.meshes[mesh];
        let Some(tables) = &subject.tables else {
            let mut white = reference.clone();
            white.triangle_material.fill(0);
            return Ok((white, 0.0));
        };
        let level_zero = || level_zero(reference, tables, subject.layers);
        let lod = subject.lod.cloned().unwrap_or_else(level_zero);
        let atlas = atlas::of(&lod, &tables.primary, self.size)?;
        let mut low = unwrapped(reference, &lod, &atlas);
        let base = self.source.push_mesh_of_scene(reference, mesh)?;
        let texels = self.texels(&lod, &low, tables, base);
        let material = self.material(scene, reference, &texels)?;
        low.triangle_material.fill(self.materials.len() as u32);
        self.materials.push(material);
        Ok((low, lod.error))
    }

    /// The surface under every texel that has an owner.
    fn texels(&self, lod: &Lod, low: &Mesh, tables: &Tables, base: u32) -> Vec<Option<Texel>> {
        let all = 0..low.triangles.len() as u32;
        let owner = texel::owners(low, all, self.size, 0..self.size);
        let texel = |(at, &t): (usize, &u32)| {
            let t = t as usize;
            low.triangles.get(t)?;
            let at = [at as u32 % self.size, at as u32 / self.size];
            let drawn = self.drawn(low, lod, tables, t, at);
            let t3 = lod.triangles[t].map(|v| {
                let [x, y, z] = lod.t3[v as usize];
                [x, y, z, 0]
            });
            let point = inverse_at(tables, base, &t3, &drawn).point?;
            let frame = Frame {
                world: &ROWS,
                normal: &UPRIGHT,
            };
            let surface = self.source.surface(&self.constants[..256], &point, &frame);
            let tangent_space = Corners::of(low, t).in_frame(drawn.b, surface.normal);
            Some(Texel {
                surface,
                tangent_space,
            })
        };
        owner.par_iter().enumerate().map(texel).collect()
    }

    /// A texel's centre and its neighbours' as barycentrics of triangle `t`.
    fn drawn(&self, low: &Mesh, lod: &Lod, tables: &Tables, t: usize, at: [u32; 2]) -> Drawn {
        let centre = at.map(|c| f64::from(c) + 0.5);
        let flat = Flat::new(&texel::corners(low, t, self.size));
        let b = |dx: f64, dy: f64| flat.barycentric([centre[0] + dx, centre[1] + dy]);
        Drawn {
            b: b(0.0, 0.0).unwrap_or([1.0, 0.0, 0.0]),
            bx: b(1.0, 0.0),
            by: b(0.0, 1.0),
            local: 0,
            vertex: [0; 3],
            asker: Asker::of_lod(tables.primary.line(), lod, t).word(),
        }
    }

    fn material(
        &mut self,
        scene: &Scene,
        reference: &Mesh,
        texels: &[Option<Texel>],
    ) -> Result<Material> {
        let thresholds = &self.constants[THRESHOLDS_AT..THRESHOLDS_AT + 256];
        let colour = |t: &Texel| {
            let [r, g, b, a] = t.surface.base;
            let [r, g, b] = [r, g, b].map(|c| srgb_encode(thresholds, c) as u8);
            [r, g, b, unit_encode(a) as u8]
        };
        let tilt = |t: &Texel| {
            let [x, y, z] = t.tangent_space.map(|c| unit_encode(c * 0.5 + 0.5) as u8);
            [x, y, z, 255]
        };
        let base = spread(texels.iter().map(|t| t.as_ref().map(colour)), self.size);
        let normal = spread(texels.iter().map(|t| t.as_ref().map(tilt)), self.size);
        let base = self.texture(&base, true)?;
        let normal = self.texture(&normal, false)?;
        let slot = |texture| SlotBinding {
            texture,
            uv_set: 0,
            transform: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        };
        let mut slots = [None; 5];
        slots[Slot::BaseColor as usize] = Some(slot(base));
        slots[Slot::Normal as usize] = Some(slot(normal));
        let mean = |of: &dyn Fn(&Surface) -> f32| mean(texels, of);
        let (alpha, alpha_cutoff) = masked(scene, reference);
        Ok(Material {
            metallic: mean(&|s| s.metallic),
            roughness: mean(&|s| s.roughness),
            emissive: [0, 1, 2].map(|k| mean(&|s: &Surface| s.emissive[k])),
            unlit: mean(&|s| f32::from(u8::from(s.unlit))) > 0.5,
            alpha,
            alpha_cutoff,
            slots,
            ..Material::default()
        })
    }

    fn texture(&mut self, rgba: &[u8], srgb: bool) -> Result<u32> {
        let sampler = Sampler {
            wrap_u: Wrap::Clamp,
            wrap_v: Wrap::Clamp,
            ..Sampler::default()
        };
        let (size, number) = (self.size, self.textures.len());
        self.textures.add(number, srgb, sampler, || {
            Ok(Pixels {
                width: size,
                height: size,
                rgba,
            })
        })
    }
}

/// What a texel holds.
struct Texel {
    surface: Surface,
    /// The reference's normal in the LoD's tangent frame.
    tangent_space: V3,
}

fn mean(texels: &[Option<Texel>], of: &dyn Fn(&Surface) -> f32) -> f32 {
    let (sum, count) = texels.iter().flatten().fold((0.0, 0u32), |(sum, n), t| {
        (sum + f64::from(of(&t.surface)), n + 1)
    });
    (sum / f64::from(count.max(1))) as f32
}

/// Whether any material of the mesh cuts holes, and at which alpha.
fn masked(scene: &Scene, mesh: &Mesh) -> (Alpha, f32) {
    let mut used = mesh.triangle_material.iter();
    let cut = used.find_map(|&m| {
        let material = scene.materials.get(m as usize)?;
        (material.alpha == scene::AlphaMode::Mask).then_some(material.alpha_cutoff)
    });
    cut.map_or((Alpha::Opaque, 0.5), |cutoff| (Alpha::Mask, cutoff))
}

/// RGBA of texels, those without an owner filled from their neighbours as far as filtering may reach, then with the mean.
fn spread(texels: impl Iterator<Item = Option<[u8; 4]>>, size: u32) -> Vec<u8> {
    let known = fill::spread(texels.collect(), size, 2 * PADDING);
    let (mut sum, mut count) = ([0u64; 4], 0u64);
    for texel in known.iter().flatten() {
        (0..4).for_each(|k| sum[k] += u64::from(texel[k]));
        count += 1;
    }
    let mean = sum.map(|s| (s / count.max(1)) as u8);
    known.iter().flat_map(|t| t.unwrap_or(mean)).collect()
}
