//! Materials as words, and the light that a surface sends out as its material says.
//!
//! In: glTF's metallic-roughness numbers and texture slots. Out: one record of [`MATERIAL_WORDS`] for each material,
//! read by [`super::surface`] and by `glsl/common/surface.glsl`.

use super::surface::AttributeSet;

/// Words of one material record.
pub(crate) const MATERIAL_WORDS: usize = 64;
/// Where the texture slots begin, and the words of each.
pub(crate) const SLOTS_AT: usize = 16;
pub(crate) const SLOT_WORDS: usize = 8;
/// Where a record says which uv triangles' records hold, as a word of a vertex.
pub(crate) const RECORD_AT: usize = 14;
/// Where a record says whether it is unlit (bit 0), and which slots have a texture (a bit each from this one on).
pub(crate) const FLAGS_AT: usize = 13;
pub(crate) const USED_SHIFT: u32 = 8;
/// A slot without a texture.
pub(crate) const NO_TEXTURE: u32 = u32::MAX;

/// The texture slots of a material, in the order of the record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// Colour, sRGB; alpha.
    BaseColor,
    /// Roughness in green, metalness in blue.
    MetallicRoughness,
    /// Tangent-space normal.
    Normal,
    /// Ambient occlusion in red.
    Occlusion,
    /// Emitted light, sRGB.
    Emissive,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotBinding {
    /// Id in the [`super::TextureSet`].
    pub texture: u32,
    /// Which TEXCOORD set.
    pub uv_set: u32,
    /// KHR_texture_transform as rows: `u' = m[0].(u, v, 1)`.
    pub transform: [[f32; 3]; 2],
}

/// What happens to a pixel's alpha.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Alpha {
    /// Ignored.
    #[default]
    Opaque,
    /// Below the cutoff a pixel is left uncovered (nothing behind it shows: ids and depth know no textures).
    Mask,
    /// Drawn opaque.
    Blend,
}

/// A material with its textures already in a [`super::TextureSet`].
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Linear RGBA factor.
    pub base_color: [f32; 4],
    /// Linear RGB factor.
    pub emissive: [f32; 3],
    /// Factor of metalness.
    pub metallic: f32,
    /// Factor of roughness.
    pub roughness: f32,
    /// Scale of the normal map's x and y.
    pub normal_scale: f32,
    /// 0: occlusion ignored, 1: whole.
    pub occlusion_strength: f32,
    /// Below this alpha a masked pixel is not drawn.
    pub alpha_cutoff: f32,
    /// What alpha does.
    pub alpha: Alpha,
    /// Never lit (KHR_materials_unlit).
    pub unlit: bool,
    /// One for each [`Slot`].
    pub slots: [Option<SlotBinding>; 5],
}

impl Default for Material {
    fn default() -> Self {
        Material {
            base_color: [1.0; 4],
            emissive: [0.0; 3],
            metallic: 1.0,
            roughness: 1.0,
            normal_scale: 1.0,
            occlusion_strength: 1.0,
            alpha_cutoff: 0.5,
            alpha: Alpha::Opaque,
            unlit: false,
            slots: [None; 5],
        }
    }
}

impl Material {
    /// The word of a vertex where the uv begins that triangles' records hold: the base colour's, or the first set.
    fn recorded_uv(&self, uv_sets: usize) -> u32 {
        let set = self.slots[0].map_or(0, |slot| slot.uv_set);
        let set = if (set as usize) < uv_sets { set } else { 0 };
        super::surface::UV_AT as u32 + 2 * set
    }

    /// The record. `uv_sets` is how many uv sets the vertices carry; a slot that asks for another is left out.
    pub(crate) fn words(&self, uv_sets: usize) -> [u32; MATERIAL_WORDS] {
        let mut words = [0u32; MATERIAL_WORDS];
        let mut put = |at: usize, values: &[f32]| {
            values
                .iter()
                .enumerate()
                .for_each(|(i, v)| words[at + i] = v.to_bits());
        };
        put(0, &self.base_color);
        put(4, &self.emissive);
        put(
            7,
            &[
                self.metallic,
                self.roughness,
                self.normal_scale,
                self.occlusion_strength,
                self.alpha_cutoff,
            ],
        );
        words[12] = self.alpha as u32;
        words[FLAGS_AT] = u32::from(self.unlit);
        words[RECORD_AT] = self.recorded_uv(uv_sets);
        for (k, slot) in self.slots.iter().enumerate() {
            let at = SLOTS_AT + k * SLOT_WORDS;
            match slot {
                Some(s) if (s.uv_set as usize) < uv_sets => {
                    words[at] = s.texture;
                    words[FLAGS_AT] |= 1 << (USED_SHIFT + k as u32);
                    words[at + 1] = super::surface::UV_AT as u32 + 2 * s.uv_set;
                    let [u, v] = s.transform;
                    let rows = [u[0], u[1], v[0], v[1], u[2], v[2]];
                    rows.iter()
                        .enumerate()
                        .for_each(|(i, r)| words[at + 2 + i] = r.to_bits());
                }
                _ => words[at] = NO_TEXTURE,
            }
        }
        words
    }
}

impl AttributeSet {
    /// The slots in which some material has a texture, a bit each.
    #[cfg(feature = "gpu")]
    pub(crate) fn used_slots(&self) -> u32 {
        let records = self.materials.chunks(MATERIAL_WORDS);
        records
            .map(|m| m[FLAGS_AT] >> USED_SHIFT)
            .fold(0, |a, b| a | b)
    }

    /// Whether the triangles' uv records hold the uv of every texture of every material.
    #[cfg(feature = "gpu")]
    pub(crate) fn all_recorded(&self) -> bool {
        let of_record = |m: &[u32]| {
            (0..5)
                .filter(|k| m[FLAGS_AT] >> USED_SHIFT & 1 << k != 0)
                .all(|k| m[SLOTS_AT + k * SLOT_WORDS + 1] == m[RECORD_AT])
        };
        self.materials.chunks(MATERIAL_WORDS).all(of_record)
            && self
                .triangles
                .iter()
                .all(|t| super::uv_record::is_one(t[1]))
    }

    /// How many textures the material of triangle `triangle` reads.
    pub(crate) fn textures_of(&self, triangle: usize) -> u32 {
        let material = self.triangles[triangle][0][3] as usize * MATERIAL_WORDS;
        (self.materials[material + FLAGS_AT] >> USED_SHIFT).count_ones()
    }
}
