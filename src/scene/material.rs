//! Materials, with glTF's defaults filled in.
//!
//! In: the JSON structures. Out: plain values: factors finite and in range, texture indices that exist.

use super::json::{MaterialJson, Root, TextureInfo, TransformJson, at};
use crate::{Error, Result};
use serde::Deserialize;

/// A metallic-roughness material (glTF 2.0, 3.9). Factors are linear.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name in the file, or `material_N`; `default` for the one of primitives without.
    pub name: String,
    /// Linear RGBA, multiplied with the texture.
    pub base_color: [f32; 4],
    /// sRGB colour, linear alpha.
    pub base_color_texture: Option<TextureRef>,
    /// 0 to 1, multiplied with blue of the texture.
    pub metallic: f32,
    /// 0 to 1, multiplied with green of the texture.
    pub roughness: f32,
    /// Linear; green is roughness, blue is metallic.
    pub metallic_roughness_texture: Option<TextureRef>,
    /// Linear; tangent-space normal, +Y up.
    pub normal_texture: Option<TextureRef>,
    /// Scale of the x and y of the normal texture.
    pub normal_scale: f32,
    /// Linear; red is occlusion.
    pub occlusion_texture: Option<TextureRef>,
    /// 0 to 1: how much of the occlusion applies.
    pub occlusion_strength: f32,
    /// Linear RGB, multiplied with the texture.
    pub emissive: [f32; 3],
    /// sRGB.
    pub emissive_texture: Option<TextureRef>,
    /// What alpha means.
    pub alpha: AlphaMode,
    /// Below this alpha a [`AlphaMode::Mask`] material is not there.
    pub alpha_cutoff: f32,
    /// Back faces are seen.
    pub double_sided: bool,
    /// KHR_materials_unlit.
    pub unlit: bool,
}

/// What the alpha of the base colour means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AlphaMode {
    /// Nothing.
    Opaque,
    /// There or not, by the cutoff.
    Mask,
    /// Coverage.
    Blend,
}

/// A texture as a material uses it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TextureRef {
    /// Index into the scene's textures.
    pub texture: usize,
    /// TEXCOORD set, KHR_texture_transform's override applied. A mesh that lacks the set reads uv (0, 0).
    pub uv_set: usize,
    /// KHR_texture_transform; the identity without.
    pub transform: UvTransform,
}

/// KHR_texture_transform: uv' = offset + R(rotation) * (scale * uv).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform {
    /// In texture widths and heights.
    pub offset: [f32; 2],
    /// Radians, counter-clockwise as the extension draws it (v downwards).
    pub rotation: f32,
    /// Factors of u and v.
    pub scale: [f32; 2],
}

impl UvTransform {
    /// Changes nothing.
    pub const IDENTITY: UvTransform = UvTransform {
        offset: [0.0; 2],
        rotation: 0.0,
        scale: [1.0; 2],
    };

    /// Rows of the affine map: `u' = r[0] . (u, v, 1)`, `v' = r[1] . (u, v, 1)`.
    pub fn rows(&self) -> [[f32; 3]; 2] {
        let (sin, cos) = f64::from(self.rotation).sin_cos();
        let [sx, sy] = self.scale.map(f64::from);
        let row = |a: f64, b: f64, c: f32| [a as f32, b as f32, c];
        [
            row(cos * sx, sin * sy, self.offset[0]),
            row(-sin * sx, cos * sy, self.offset[1]),
        ]
    }
}

impl Default for Material {
    /// glTF's material of a primitive without one.
    fn default() -> Material {
        Material {
            name: "default".into(),
            base_color: [1.0; 4],
            base_color_texture: None,
            metallic: 1.0,
            roughness: 1.0,
            metallic_roughness_texture: None,
            normal_texture: None,
            normal_scale: 1.0,
            occlusion_texture: None,
            occlusion_strength: 1.0,
            emissive: [0.0; 3],
            emissive_texture: None,
            alpha: AlphaMode::Opaque,
            alpha_cutoff: 0.5,
            double_sided: false,
            unlit: false,
        }
    }
}

impl Material {
    /// Every texture the material uses.
    pub fn textures(&self) -> impl Iterator<Item = TextureRef> {
        [
            self.base_color_texture,
            self.metallic_roughness_texture,
            self.normal_texture,
            self.occlusion_texture,
            self.emissive_texture,
        ]
        .into_iter()
        .flatten()
    }
}

/// All materials of a document.
pub(super) fn materials(file: &str, root: &Root) -> Result<Vec<Material>> {
    root.materials
        .iter()
        .enumerate()
        .map(|(i, m)| Reading { file, root, i }.material(m))
        .collect()
}

/// One material being read.
struct Reading<'a> {
    file: &'a str,
    root: &'a Root,
    i: usize,
}

impl Reading<'_> {
    fn material(&self, json: &MaterialJson) -> Result<Material> {
        let pbr = &json.pbr_metallic_roughness;
        let alpha = match json.alpha_mode.as_deref() {
            None | Some("OPAQUE") => AlphaMode::Opaque,
            Some("MASK") => AlphaMode::Mask,
            Some("BLEND") => AlphaMode::Blend,
            Some(_) => return Err(self.fault("alphaMode", "is not OPAQUE, MASK or BLEND")),
        };
        let strength = json.occlusion_texture.as_ref().and_then(|t| t.strength);
        let scale = json.normal_texture.as_ref().and_then(|t| t.scale);
        Ok(Material {
            name: json
                .name
                .clone()
                .unwrap_or_else(|| format!("material_{}", self.i)),
            base_color: self.numbers(
                "baseColorFactor",
                pbr.base_color_factor.unwrap_or([1.0; 4]),
                0.0,
                1.0,
            )?,
            base_color_texture: self.texture("baseColorTexture", &pbr.base_color_texture)?,
            metallic: self.number(
                "metallicFactor",
                pbr.metallic_factor.unwrap_or(1.0),
                0.0,
                1.0,
            )?,
            roughness: self.number(
                "roughnessFactor",
                pbr.roughness_factor.unwrap_or(1.0),
                0.0,
                1.0,
            )?,
            metallic_roughness_texture: self
                .texture("metallicRoughnessTexture", &pbr.metallic_roughness_texture)?,
            normal_texture: self.texture("normalTexture", &json.normal_texture)?,
            normal_scale: self.number("normalTexture.scale", scale.unwrap_or(1.0), -1e6, 1e6)?,
            occlusion_texture: self.texture("occlusionTexture", &json.occlusion_texture)?,
            occlusion_strength: self.number(
                "occlusionTexture.strength",
                strength.unwrap_or(1.0),
                0.0,
                1.0,
            )?,
            emissive: self.numbers("emissiveFactor", json.emissive_factor, 0.0, 1e6)?,
            emissive_texture: self.texture("emissiveTexture", &json.emissive_texture)?,
            alpha,
            alpha_cutoff: self.number("alphaCutoff", json.alpha_cutoff.unwrap_or(0.5), 0.0, 1e6)?,
            double_sided: json.double_sided,
            unlit: json.extensions.contains_key("KHR_materials_unlit"),
        })
    }

    fn fault(&self, what: &str, reason: impl Into<String>) -> Error {
        Error::input(self.file, format!("materials[{}].{what}", self.i), reason)
    }

    fn number(&self, what: &str, value: f64, low: f64, high: f64) -> Result<f32> {
        if !(low..=high).contains(&value) {
            return Err(self.fault(what, format!("{value} is not from {low} to {high}")));
        }
        Ok(value as f32)
    }

    fn numbers<const N: usize>(
        &self,
        what: &str,
        values: [f64; N],
        low: f64,
        high: f64,
    ) -> Result<[f32; N]> {
        let mut out = [0.0; N];
        for (out, value) in out.iter_mut().zip(values) {
            *out = self.number(what, value, low, high)?;
        }
        Ok(out)
    }

    fn texture(&self, what: &str, info: &Option<TextureInfo>) -> Result<Option<TextureRef>> {
        let Some(info) = info else { return Ok(None) };
        at(
            self.file,
            &self.root.textures,
            "textures",
            info.index,
            || format!("materials[{}].{what}", self.i),
        )?;
        let mut uv_set = info.tex_coord;
        let mut transform = UvTransform::IDENTITY;
        if let Some(value) = info.extensions.get("KHR_texture_transform") {
            let json =
                TransformJson::deserialize(value).map_err(|e| self.fault(what, e.to_string()))?;
            uv_set = json.tex_coord.unwrap_or(uv_set);
            transform = UvTransform {
                offset: self.numbers(what, json.offset, -1e6, 1e6)?,
                rotation: self.number(what, json.rotation, -1e6, 1e6)?,
                scale: self.numbers(what, json.scale.unwrap_or([1.0; 2]), -1e6, 1e6)?,
            };
        }
        Ok(Some(TextureRef {
            texture: info.index,
            uv_set,
            transform,
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The extension's own figure: a quarter turn takes +u to -v (counter-clockwise with v downwards).
    #[test]
    fn uv_transforms() {
        let apply =
            |t: UvTransform, uv: [f32; 2]| t.rows().map(|r| r[0] * uv[0] + r[1] * uv[1] + r[2]);
        assert_eq!(apply(UvTransform::IDENTITY, [0.3, 0.7]), [0.3, 0.7]);
        let quarter = UvTransform {
            rotation: std::f32::consts::FRAC_PI_2,
            ..UvTransform::IDENTITY
        };
        let [u, v] = apply(quarter, [1.0, 0.0]);
        assert!(u.abs() < 1e-6 && (v + 1.0).abs() < 1e-6);
        let all = UvTransform {
            offset: [0.5, 1.0],
            rotation: std::f32::consts::PI,
            scale: [2.0, 3.0],
        };
        let [u, v] = apply(all, [1.0, 1.0]);
        assert!((u + 1.5).abs() < 1e-6 && (v + 2.0).abs() < 1e-6);
    }
}
