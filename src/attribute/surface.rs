//! What can be fetched at a point of the reference surface: the twin of `glsl/common/surface.glsl`.
//!
//! In: a reference triangle, barycentrics there and at the neighbouring pixels. Out: [`Surface`]: colour, two-level
//! normal, metalness, roughness, occlusion, emission, all filtered.
//!
//! Every mesh's triangles and vertices lie in two runs of words: for a triangle the word offsets of its three vertices,
//! its material and the artist's uv ([`uv_record`]); for a vertex normal, tangent, colour and the uv sets.

use super::arithmetic::{V3, add3, cross3, dot3, mul3, scale3, unit3};
use super::material::{
    FLAGS_AT, MATERIAL_WORDS, Material, NO_TEXTURE, RECORD_AT, SLOT_WORDS, SLOTS_AT,
};
use super::procedural::Procedural;
use super::sample::UvGradient;
#[cfg(feature = "gpu")]
use super::show::SHOWN_AT;
use super::shown::Extra;
use super::texture::TextureSet;
use super::uv_record::{self, CornerUv};
use crate::mesh::Mesh;
use crate::{Error, Result};
use std::sync::Arc;

/// Where the uv sets of a vertex begin: after normal (3), tangent (4) and colour (4).
pub(crate) const UV_AT: usize = 11;
/// Gradient of uv where the next pixel's has no meaning: the smallest mip level.
const STEEP: f32 = 1e6;
/// The texel of a normal map that tilts nothing.
const FLAT: [f32; 4] = [0.5, 0.5, 1.0, 1.0];

/// All that can be fetched of the reference meshes of a picture.
#[derive(Clone, Debug, Default)]
pub struct AttributeSet {
    /// Of each triangle word offsets of the three vertices and the material, then the uv record.
    pub(crate) triangles: Vec<[[u32; 4]; 2]>,
    /// Vertices, bits of floats.
    pub(crate) vertices: Vec<u32>,
    /// Material records.
    pub(crate) materials: Vec<u32>,
    /// Their textures.
    pub(crate) textures: TextureSet,
    uv_sets: usize,
    /// What vertices of a scene's meshes carry besides.
    pub(super) extra: Extra,
    /// Whether what is shown in place of base colour is data.
    pub(super) data: bool,
    /// Whether a solid texture, a 3-D image or a function is among its factors.
    pub(super) solid: bool,
    /// The user's function, where one is a factor of what is shown.
    pub(super) procedural: Option<Procedural>,
}

/// A point of the reference and how it moves to the next pixel in x and in y.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SurfacePoint {
    /// Number in [`AttributeSet::triangles`].
    pub triangle: u32,
    /// Barycentrics.
    pub b: [f32; 3],
    /// Change of the barycentrics to the next pixel in x; none where that has no meaning.
    pub dx: Option<[f32; 3]>,
    /// Likewise in y.
    pub dy: Option<[f32; 3]>,
    /// Texture samples along the longer gradient, at most; 0 and 1 are isotropic.
    pub taps: u32,
}

/// Rows of the transforms of one draw.
pub(crate) struct Frame<'a> {
    pub world: &'a [[f32; 4]; 3],
    pub normal: &'a [[f32; 4]; 3],
}

/// What the material says at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Surface {
    pub base: [f32; 4],
    /// Unit, world space.
    pub normal: V3,
    pub emissive: V3,
    pub metallic: f32,
    pub roughness: f32,
    pub occlusion: f32,
    /// The normal map's texel, 0..1.
    pub bump: V3,
    /// A masked pixel whose alpha is below the cutoff.
    pub masked: bool,
    pub unlit: bool,
}

impl AttributeSet {
    /// An empty set whose vertices carry `uv_sets` uv sets.
    pub fn new(textures: TextureSet, materials: &[Material], uv_sets: usize) -> Self {
        let materials = materials.iter().flat_map(|m| m.words(uv_sets)).collect();
        AttributeSet {
            materials,
            textures,
            uv_sets,
            ..AttributeSet::default()
        }
    }

    /// Number of materials.
    pub fn material_count(&self) -> usize {
        self.materials.len() / MATERIAL_WORDS
    }

    /// Whether these show data, which is written as it is and never lit: see [`Attribute::is_data`](super::Attribute::is_data).
    pub fn is_data(&self) -> bool {
        self.data
    }

    /// The function of the user's that these show, which a device compiles: the processor cannot draw it.
    pub fn procedural(&self) -> Option<&Procedural> {
        self.procedural.as_ref()
    }

    /// Whether anything is shown in place of the materials' base colour.
    #[cfg(feature = "gpu")]
    pub(crate) fn is_shown(&self) -> bool {
        self.materials
            .get(SHOWN_AT)
            .is_some_and(|&shown| shown != 0)
    }

    /// Whether that is a solid texture, a 3-D image or a function, alone or as a factor.
    #[cfg(feature = "gpu")]
    pub(crate) fn is_solid(&self) -> bool {
        self.solid
    }

    /// Appends a mesh that belongs to no scene; returns the number of its first triangle.
    ///
    /// # Errors
    /// [`Error::Capacity`] where the vertices' words cannot be numbered.
    pub fn push_mesh(&mut self, mesh: &Mesh) -> Result<u32> {
        self.push(mesh, None)
    }

    /// Appends mesh `number` of the scene whose attributes these are, as it is or posed; returns the number of its first
    /// triangle.
    ///
    /// # Errors
    /// As [`AttributeSet::push_mesh`].
    pub fn push_mesh_of_scene(&mut self, mesh: &Mesh, number: usize) -> Result<u32> {
        self.push(mesh, Some(number))
    }

    fn push(&mut self, mesh: &Mesh, number: Option<usize>) -> Result<u32> {
        let base = self.vertices.len();
        let stride = UV_AT + 2 * self.uv_sets + self.extra.width;
        let words = (base + mesh.positions.len() * stride) as u64;
        if words > u64::from(u32::MAX) / 4 {
            return Err(Error::Capacity {
                what: "words of vertex attributes".into(),
                need: words,
                have: 1 << 30,
            });
        }
        let extra = Arc::clone(&self.extra.meshes);
        let extra = number
            .and_then(|m| extra.get(m))
            .map_or(&[][..], Vec::as_slice);
        for vertex in 0..mesh.positions.len() {
            self.push_vertex(mesh, vertex, extra);
        }
        let first = self.triangles.len() as u32;
        for (triangle, material) in mesh.triangles.iter().zip(&mesh.triangle_material) {
            let [a, b, c] = triangle.map(|v| (base + v as usize * stride) as u32);
            let material = (*material as usize).min(self.material_count().saturating_sub(1)) as u32;
            let corner = [a, b, c, material];
            let uv = self.vertex_uv(corner, self.recorded_uv(material));
            self.triangles.push([corner, uv_record::encode(&uv)]);
        }
        Ok(first)
    }

    fn push_vertex(&mut self, mesh: &Mesh, vertex: usize, extra: &[f32]) {
        let tangent = mesh.tangents.get(vertex).copied().unwrap_or([0.0; 4]);
        let color = mesh.colors.get(vertex).copied().unwrap_or([1.0; 4]);
        let mut put = |values: &[f32]| self.vertices.extend(values.iter().map(|v| v.to_bits()));
        put(&mesh.normals[vertex]);
        put(&tangent);
        put(&color);
        for set in 0..self.uv_sets {
            put(&mesh
                .uv_sets
                .get(set)
                .and_then(|s| s.get(vertex))
                .copied()
                .unwrap_or([0.0; 2]));
        }
        let begin = vertex * self.extra.width;
        let own = |k: usize| extra.get(begin + k).copied().unwrap_or(0.0);
        let own = (0..self.extra.width).map(own);
        self.vertices.extend(own.map(f32::to_bits));
    }

    /// The word of a vertex where the uv begins that a triangle's record holds.
    fn recorded_uv(&self, material: u32) -> u32 {
        let at = material as usize * MATERIAL_WORDS + RECORD_AT;
        self.materials.get(at).copied().unwrap_or(UV_AT as u32)
    }

    /// Uv of the three corners from their vertices.
    fn vertex_uv(&self, corner: [u32; 4], word: u32) -> CornerUv {
        [0, 1, 2].map(|i| [0, 1].map(|k| self.float(corner[i] + word + k)))
    }

    /// Loads of at most 128 bits that the artist's uv of a triangle takes: its record, or its vertices and their numbers.
    pub fn uv_fetches(&self, triangle: u32) -> u32 {
        match uv_record::decode(self.triangles[triangle as usize][1]) {
            Some(_) => 1,
            None => 5,
        }
    }

    pub(super) fn float(&self, at: u32) -> f32 {
        f32::from_bits(self.vertices[at as usize])
    }

    /// Word `word` of the three vertices, weighted.
    pub(super) fn weighted(&self, corner: [u32; 4], word: u32, b: [f32; 3]) -> f32 {
        b[0] * self.float(corner[0] + word)
            + b[1] * self.float(corner[1] + word)
            + b[2] * self.float(corner[2] + word)
    }

    pub(crate) fn weighted3(&self, corner: [u32; 4], word: u32, b: [f32; 3]) -> V3 {
        [0, 1, 2].map(|i| self.weighted(corner, word + i, b))
    }

    fn material_float(&self, at: u32) -> f32 {
        f32::from_bits(self.materials[at as usize])
    }

    /// The texture of slot `slot`, or `missing` where there is none.
    fn slot(
        &self,
        decode: &[f32],
        [corner, record]: [[u32; 4]; 2],
        slot: u32,
        p: &SurfacePoint,
        missing: [f32; 4],
    ) -> [f32; 4] {
        let at = corner[3] * MATERIAL_WORDS as u32 + SLOTS_AT as u32 + slot * SLOT_WORDS as u32;
        let texture = self.materials[at as usize];
        if texture == NO_TEXTURE {
            return missing;
        }
        let word = self.materials[at as usize + 1];
        let m = [2, 3, 4, 5, 6, 7].map(|i| self.material_float(at + i));
        let recorded = (word == self.recorded_uv(corner[3]))
            .then(|| uv_record::decode(record))
            .flatten();
        let c = recorded.unwrap_or_else(|| self.vertex_uv(corner, word));
        let weighted =
            |b: [f32; 3]| [0, 1].map(|k| b[0] * c[0][k] + b[1] * c[1][k] + b[2] * c[2][k]);
        let [u, v] = weighted(p.b);
        let uv = [m[0] * u + m[1] * v + m[4], m[2] * u + m[3] * v + m[5]];
        let gradient = |d: Option<[f32; 3]>| match d {
            Some(d) => {
                let [u, v] = weighted(d);
                [m[0] * u + m[1] * v, m[2] * u + m[3] * v]
            }
            None => [STEEP, STEEP],
        };
        let at = UvGradient {
            uv,
            dx: gradient(p.dx),
            dy: gradient(p.dy),
        };
        self.textures.sample_along(decode, texture, &at, p.taps)
    }

    /// The normal of [`AttributeSet::surface`] alone.
    pub(crate) fn shading_normal(&self, decode: &[f32], p: &SurfacePoint, frame: &Frame) -> V3 {
        let triangle = self.triangles[p.triangle as usize];
        let bump = self.slot(decode, triangle, 2, p, FLAT);
        self.normal(triangle[0], bump, p, frame)
    }

    /// Everything the material says at `p`.
    pub(crate) fn surface(&self, decode: &[f32], p: &SurfacePoint, frame: &Frame) -> Surface {
        let triangle = self.triangles[p.triangle as usize];
        let corner = triangle[0];
        let m = corner[3] * MATERIAL_WORDS as u32;
        let white = [1.0; 4];
        let texel = self.slot(decode, triangle, 0, p, white);
        let color = [0, 1, 2, 3].map(|i| self.weighted(corner, 7 + i, p.b));
        let base: [f32; 4] =
            std::array::from_fn(|i| texel[i] * self.material_float(m + i as u32) * color[i]);
        let orm = self.slot(decode, triangle, 1, p, white);
        let occlusion = self.slot(decode, triangle, 3, p, white)[0];
        let bump = self.slot(decode, triangle, 2, p, FLAT);
        let emissive = self.slot(decode, triangle, 4, p, white);
        let strength = self.material_float(m + 10);
        let factor = [0, 1, 2].map(|i| self.material_float(m + 4 + i));
        Surface {
            base,
            normal: self.normal(corner, bump, p, frame),
            emissive: mul3(factor, [emissive[0], emissive[1], emissive[2]]),
            metallic: orm[2] * self.material_float(m + 7),
            roughness: orm[1] * self.material_float(m + 8),
            occlusion: 1.0 + strength * (occlusion - 1.0),
            bump: [bump[0], bump[1], bump[2]],
            masked: self.materials[m as usize + 12] == 1 && base[3] < self.material_float(m + 11),
            unlit: self.materials[m as usize + FLAGS_AT] & 1 != 0,
        }
    }

    /// Two-level normal: the reference's interpolated one, tilted by the artist's map in the reference's tangent frame.
    fn normal(&self, corner: [u32; 4], texel: [f32; 4], p: &SurfacePoint, frame: &Frame) -> V3 {
        let row = |r: &[f32; 4]| [r[0], r[1], r[2]];
        let object = self.weighted3(corner, 0, p.b);
        let n = unit3(
            frame.normal.each_ref().map(|r| dot3(row(r), object)),
            [0.0, 0.0, 1.0],
        );
        let slot = corner[3] * MATERIAL_WORDS as u32 + SLOTS_AT as u32 + 2 * SLOT_WORDS as u32;
        if self.materials[slot as usize] == NO_TEXTURE {
            return n;
        }
        let object = self.weighted3(corner, 3, p.b);
        let t = frame.world.each_ref().map(|r| dot3(row(r), object));
        if dot3(t, t) <= 1e-30 {
            return n;
        }
        let scale = self.material_float(corner[3] * MATERIAL_WORDS as u32 + 9);
        let t = unit3(t, [1.0, 0.0, 0.0]);
        let side = self.float(corner[0] + 6) * frame.normal[0][3];
        let bitangent = scale3(cross3(n, t), side);
        let x = (texel[0] * 2.0 - 1.0) * scale;
        let y = (texel[1] * 2.0 - 1.0) * scale;
        let z = texel[2] * 2.0 - 1.0;
        unit3(
            add3(add3(scale3(t, x), scale3(bitangent, y)), scale3(n, z)),
            n,
        )
    }
}
