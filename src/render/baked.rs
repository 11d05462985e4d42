//! A LoD with a conventionally baked atlas: what inverse textures are measured against.
//!
//! In: a scene, for each mesh its tables and LoD, the size of the textures. Out: a picture of the same LoD triangles
//! whose colour and normal come from one baked texture each, at texture coordinates of their own (see `atlas.rs`).
//!
//! The detail is brought over by the inverse texture itself: each texel's point of the LoD is looked up, the reference's
//! base colour and two-level normal are taken there, filtered over the texel's footprint, and the normal is written in
//! the LoD's tangent frame. Metalness, roughness and emission become their means over the texels; occlusion is left out.

use super::atlas::{self, Atlas, PADDING};
use super::constants::{THRESHOLDS_AT, constants};
use super::correspond::inverse_at;
use super::picture::Picture;
use super::shade::Drawn;
use super::stage::{Subject, level_zero};
use crate::attribute::arithmetic::{V3, cross3, dot3, srgb_encode, sub3, unit_encode, unit3};
use crate::attribute::surface::{Frame, Surface};
use crate::attribute::{
    Alpha, AttributeSet, Material, Pixels, Sampler, Slot, SlotBinding, TextureSet, Wrap,
};
use crate::igt::{Asker, Tables};
use crate::lod::Lod;
use crate::mesh::{Mesh, MorphTarget};
use crate::scene::{self, Deformation, Scene};
use crate::{Error, Result};
use rayon::prelude::*;
use std::collections::HashMap;

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
        let owner = owners(low, self.size);
        let texel = |(at, &t): (usize, &u32)| {
            let t = t as usize;
            let corners = *low.triangles.get(t)?;
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
            let tangent_space = into_frame(low, corners, drawn.b, surface.normal);
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
        let corners = texel_corners(low, t, self.size);
        let b = |dx: f64, dy: f64| barycentric(&corners, [centre[0] + dx, centre[1] + dy]);
        let layer = lod.triangle_layer.get(t).copied();
        let t3 = lod.triangles[t].map(|v| lod.t3[v as usize]);
        Drawn {
            b: b(0.0, 0.0).unwrap_or([1.0, 0.0, 0.0]),
            bx: b(1.0, 0.0),
            by: b(0.0, 1.0),
            local: 0,
            vertex: [0; 3],
            asker: Asker::of(tables.primary.line(), &t3, layer).word(),
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

/// Rows of no transform at all.
const ROWS: [[f32; 4]; 3] = [
    [1.0, 0.0, 0.0, 0.0],
    [0.0, 1.0, 0.0, 0.0],
    [0.0, 0.0, 1.0, 0.0],
];
/// The same for normals: the fourth of the first row is the handedness.
const UPRIGHT: [[f32; 4]; 3] = [[1.0, 0.0, 0.0, 1.0], ROWS[1], ROWS[2]];

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

/// The LoD as a mesh whose vertices are split where charts meet, with tangents along its texture coordinates. Triangles
/// keep their numbers.
fn unwrapped(reference: &Mesh, lod: &Lod, atlas: &Atlas) -> Mesh {
    let mut out = Mesh {
        name: reference.name.clone(),
        uv_sets: vec![Vec::new()],
        triangle_material: vec![0; lod.triangles.len()],
        targets: vec![MorphTarget::default(); lod.targets.len()],
        target_weights: reference.target_weights.clone(),
        ..Mesh::default()
    };
    let mut known: HashMap<(u32, u32), u32> = HashMap::new();
    for (t, triangle) in lod.triangles.iter().enumerate() {
        let corners = [0, 1, 2].map(|k| {
            let v = triangle[k];
            *known.entry((v, atlas.chart[t])).or_insert_with(|| {
                out.positions.push(lod.positions[v as usize]);
                out.normals.push(lod.normals[v as usize]);
                out.joints.extend(lod.joints.get(v as usize));
                out.weights.extend(lod.weights.get(v as usize));
                for (to, from) in out.targets.iter_mut().zip(&lod.targets) {
                    to.positions.extend(from.positions.get(v as usize));
                    to.normals.extend(from.normals.get(v as usize));
                }
                out.uv_sets[0].push(atlas.uv[t][k]);
                out.positions.len() as u32 - 1
            })
        });
        out.triangles.push(corners);
    }
    out.tangents = vec![[0.0; 4]; out.positions.len()];
    out.generate_tangents(&vec![Some(0); out.triangles.len()]);
    out
}

/// A triangle's corners in texels.
fn texel_corners(low: &Mesh, t: usize, size: u32) -> [[f64; 2]; 3] {
    let uv = &low.uv_sets[0];
    low.triangles[t].map(|v| uv[v as usize].map(|c| f64::from(c) * f64::from(size)))
}

/// Barycentrics of `at`; none in a triangle without area.
fn barycentric(corners: &[[f64; 2]; 3], at: [f64; 2]) -> Option<[f32; 3]> {
    let [a, b, c] = *corners;
    let cross = |p: [f64; 2], q: [f64; 2]| p[0] * q[1] - p[1] * q[0];
    let less = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let area = cross(less(b, a), less(c, a));
    if area == 0.0 {
        return None;
    }
    let b1 = cross(less(at, a), less(c, a)) / area;
    let b2 = cross(less(b, a), less(at, a)) / area;
    Some([1.0 - b1 - b2, b1, b2].map(|x| x as f32))
}

/// For each texel the first triangle that covers its centre; `u32::MAX` where there is none.
fn owners(low: &Mesh, size: u32) -> Vec<u32> {
    let mut owner = vec![u32::MAX; (size * size) as usize];
    let within = |x: f64| x.clamp(0.0, f64::from(size)) as u32;
    for t in 0..low.triangles.len() {
        let corners = texel_corners(low, t, size);
        let bounds = |k: usize| {
            let c = corners.map(|p| p[k]);
            let low = c.iter().copied().fold(f64::INFINITY, f64::min);
            let high = c.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            within(low.floor())..within(high.ceil())
        };
        for y in bounds(1) {
            for x in bounds(0) {
                let slot = &mut owner[(y * size + x) as usize];
                let at = [x, y].map(|c| f64::from(c) + 0.5);
                let inside = barycentric(&corners, at).is_some_and(|b| b.iter().all(|&b| b >= 0.0));
                if inside && *slot == u32::MAX {
                    *slot = t as u32;
                }
            }
        }
    }
    owner
}

/// `normal` (object space) as a tangent-space normal at barycentrics `b` of a triangle of `low`: what undoes the shading.
fn into_frame(low: &Mesh, corners: [u32; 3], b: [f32; 3], normal: V3) -> V3 {
    let weighted = |at: &dyn Fn(usize) -> V3| -> V3 {
        std::array::from_fn(|i| (0..3).map(|k| b[k] * at(corners[k] as usize)[i]).sum())
    };
    let n = unit3(weighted(&|v| low.normals[v]), normal);
    let t = weighted(&|v| {
        let [x, y, z, _] = low.tangents[v];
        [x, y, z]
    });
    // The shading does not make them perpendicular; the small difference is taken out here.
    let t = sub3(t, n.map(|c| c * dot3(n, t)));
    let t = unit3(t, cross3(n, [0.0, 1.0, 0.0]));
    let side = low.tangents[corners[0] as usize][3];
    let bitangent = cross3(n, t).map(|c| c * side);
    [dot3(normal, t), dot3(normal, bitangent), dot3(normal, n)]
}

/// RGBA of texels, those without an owner filled from their neighbours as far as filtering may reach, then with the mean.
fn spread(texels: impl Iterator<Item = Option<[u8; 4]>>, size: u32) -> Vec<u8> {
    let mut known: Vec<Option<[u8; 4]>> = texels.collect();
    let size = size as usize;
    for _ in 0..2 * PADDING {
        let grown = (0..known.len()).into_par_iter().map(|at| {
            let (x, y) = (at % size, at / size);
            let near = [
                (x > 0).then(|| at - 1),
                (x + 1 < size).then_some(at + 1),
                (y > 0).then(|| at - size),
                (y + 1 < size).then_some(at + size),
            ];
            known[at].or_else(|| near.into_iter().flatten().find_map(|n| known[n]))
        });
        known = grown.collect();
    }
    let (mut sum, mut count) = ([0u64; 4], 0u64);
    for texel in known.iter().flatten() {
        (0..4).for_each(|k| sum[k] += u64::from(texel[k]));
        count += 1;
    }
    let mean = sum.map(|s| (s / count.max(1)) as u8);
    known.iter().flat_map(|t| t.unwrap_or(mean)).collect()
}
