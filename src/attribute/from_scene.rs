//! Materials and textures of a scene as an [`AttributeSet`].
//!
//! In: a [`Scene`], and whether pictures of it will be lit. Out: a set with all materials and no mesh yet; only textures
//! that the shading reads are decoded. An image that cannot be decoded is replaced by a neutral texel, with a warning.

use super::material::{Alpha, MATERIAL_WORDS, Material, Slot, SlotBinding};
use super::named::Factor;
use super::show::{FACTOR_WORDS, FACTORS_AT, KEEP, SHOWN_AT, SOLID, VOLUME, kind};
use super::shown::{Shown, missing_uv, uv_sets};
use super::surface::AttributeSet;
use super::texture::{Pixels, Sampler, TextureSet, Wrap};
use crate::Result;
use crate::scene::{self, AlphaMode, Mipmap, Scene, TextureRef, TextureUse};

/// Stand-in numbers of "no image", one for each [`TextureUse`]: beyond any index of a scene.
const NEUTRAL: usize = usize::MAX - 1;

/// The materials of `scene` and what was replaced on the way. `lit`: whether more than base colour is needed.
///
/// # Errors
/// [`Error::Capacity`](crate::Error::Capacity) where the textures exceed 512 MiB with their mip levels.
pub fn attributes_of(scene: &Scene, lit: bool) -> Result<(AttributeSet, Vec<String>)> {
    read(scene, lit, None)
}

/// As [`attributes_of`], with `shown`, which was made for this scene, in place of base colour.
///
/// # Errors
/// As [`attributes_of`].
pub fn attributes_showing(
    scene: &Scene,
    lit: bool,
    shown: &Shown,
) -> Result<(AttributeSet, Vec<String>)> {
    let (mut set, warnings) = read(scene, lit, Some(shown))?;
    let volume = match &shown.volume {
        Some(volume) if shown.has(&Factor::Volume) => volume.add(&mut set.textures)?,
        _ => 0,
    };
    let count = shown.factors.len() as u32;
    let keep = u32::from(shown.keeps_material()) * KEEP;
    for record in set.materials.chunks_mut(MATERIAL_WORDS) {
        record[SHOWN_AT] = count | keep;
        for (k, &[word, more]) in shown.factors.iter().enumerate() {
            let more = if kind(word) == VOLUME { volume } else { more };
            record[FACTORS_AT + k * FACTOR_WORDS..][..FACTOR_WORDS].copy_from_slice(&[word, more]);
        }
    }
    set.extra = shown.extra.clone();
    set.data = shown.attribute().is_data();
    set.solid = shown.factors.iter().any(|f| kind(f[0]) >= SOLID);
    let function = shown.procedural.clone();
    set.procedural = function.filter(|_| shown.has(&Factor::Procedural));
    Ok((set, warnings))
}

fn read(scene: &Scene, lit: bool, shown: Option<&Shown>) -> Result<(AttributeSet, Vec<String>)> {
    let mut reading = Reading {
        scene,
        shown,
        textures: TextureSet::default(),
        warnings: Vec::new(),
    };
    let materials = scene
        .materials
        .iter()
        .map(|m| reading.material(m, lit))
        .collect::<Result<Vec<_>>>()?;
    if shown.is_none() {
        reading.warn_of_missing_uv();
    }
    let Reading {
        textures, warnings, ..
    } = reading;
    let set = AttributeSet::new(textures, &materials, uv_sets(scene));
    Ok((set, warnings))
}

struct Reading<'a> {
    scene: &'a Scene,
    shown: Option<&'a Shown>,
    textures: TextureSet,
    warnings: Vec<String>,
}

impl Reading<'_> {
    fn material(&mut self, m: &scene::Material, lit: bool) -> Result<Material> {
        let used = [
            (Slot::BaseColor, m.base_color_texture),
            (Slot::MetallicRoughness, m.metallic_roughness_texture),
            (Slot::Normal, m.normal_texture),
            (Slot::Occlusion, m.occlusion_texture),
            (Slot::Emissive, m.emissive_texture),
        ];
        let wanted = |slot| match self.shown {
            Some(shown) => shown.wants(slot, m, lit),
            None => slot == Slot::BaseColor || lit && !m.unlit,
        };
        let used = used.map(|(slot, texture)| (slot, texture.filter(|_| wanted(slot))));
        let mut slots = [None; 5];
        for (slot, texture) in used {
            if let Some(texture) = texture {
                slots[slot as usize] = Some(self.binding(slot, &texture)?);
            }
        }
        Ok(Material {
            base_color: m.base_color,
            emissive: m.emissive,
            metallic: m.metallic,
            roughness: m.roughness,
            normal_scale: m.normal_scale,
            occlusion_strength: m.occlusion_strength,
            alpha_cutoff: m.alpha_cutoff,
            alpha: match m.alpha {
                AlphaMode::Opaque => Alpha::Opaque,
                AlphaMode::Mask => Alpha::Mask,
                AlphaMode::Blend => Alpha::Blend,
            },
            unlit: m.unlit,
            slots,
        })
    }

    /// A texture without the uv that it is laid out by shows one texel: glTF's readers take uv (0, 0) there.
    fn warn_of_missing_uv(&mut self) {
        for mesh in &self.scene.meshes {
            if let Some((material, set)) = missing_uv(self.scene, mesh, |m| m.base_color_texture) {
                self.warnings.push(format!(
                    "mesh \"{}\" has no TEXCOORD_{set}, which the base colour texture of material \"{}\" is laid out by: it is left out",
                    mesh.name, self.scene.materials[material].name
                ));
            }
        }
    }

    fn binding(&mut self, slot: Slot, reference: &TextureRef) -> Result<SlotBinding> {
        let texture = &self.scene.textures[reference.texture];
        let sampler = sampler(&self.scene.sampler_of(texture));
        let srgb = matches!(slot, Slot::BaseColor | Slot::Emissive);
        let texture_use = if slot == Slot::Normal {
            TextureUse::Normal
        } else {
            TextureUse::Factor
        };
        let id = match texture.image {
            Some(image) => self.image(image, srgb, sampler, texture_use)?,
            None => {
                let texel: &[u8] = if slot == Slot::Normal {
                    &[128, 128, 255, 255]
                } else {
                    &[255; 4]
                };
                let number = NEUTRAL - usize::from(slot == Slot::Normal);
                self.textures.add(number, srgb, sampler, || {
                    Ok(Pixels {
                        width: 1,
                        height: 1,
                        rgba: texel,
                    })
                })?
            }
        };
        let uv_set = u32::try_from(reference.uv_set).unwrap_or(u32::MAX);
        Ok(SlotBinding {
            texture: id,
            uv_set,
            transform: reference.transform.rows(),
        })
    }

    fn image(
        &mut self,
        image: usize,
        srgb: bool,
        sampler: Sampler,
        texture_use: TextureUse,
    ) -> Result<u32> {
        if let Some(id) = self.textures.find(image, srgb, sampler) {
            return Ok(id);
        }
        let (pixels, fault) = self.scene.images[image].decode_or_neutral(texture_use);
        self.warnings
            .extend(fault.map(|e| format!("images[{image}]: a neutral texture stands in: {e}")));
        let (width, height) = pixels.dimensions();
        self.textures.add(image, srgb, sampler, || {
            Ok(Pixels {
                width,
                height,
                rgba: pixels.as_raw(),
            })
        })
    }
}

fn sampler(of: &scene::Sampler) -> Sampler {
    let wrap = |w| match w {
        scene::Wrap::Repeat => Wrap::Repeat,
        scene::Wrap::Mirror => Wrap::Mirror,
        scene::Wrap::Clamp => Wrap::Clamp,
    };
    Sampler {
        wrap_u: wrap(of.wrap_u),
        wrap_v: wrap(of.wrap_v),
        nearest: !of.magnify_linear && !of.minify_linear,
        no_mips: of.mipmap == Mipmap::None,
    }
}
