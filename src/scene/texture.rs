//! Textures and samplers, with glTF's defaults filled in.
//!
//! In: the JSON structures. Out: plain values whose indices exist.

use super::json::{Root, SamplerJson, TextureJson, at};
use crate::{Error, Result};

/// An image and how to sample it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Texture {
    /// Index into the scene's images; `None` where only an unknown extension names one (use the neutral value).
    pub image: Option<usize>,
    /// Index into the scene's samplers; `None` for [`Sampler::default`].
    pub sampler: Option<usize>,
}

/// How to sample an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampler {
    /// Linear or nearest under magnification.
    pub magnify_linear: bool,
    /// Linear or nearest within a level under minification.
    pub minify_linear: bool,
    /// Which levels are used.
    pub mipmap: Mipmap,
    /// Outside of [0, 1] in u.
    pub wrap_u: Wrap,
    /// Outside of [0, 1] in v.
    pub wrap_v: Wrap,
}

/// Which levels of an image are used under minification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mipmap {
    /// The base level only.
    None,
    /// The nearest.
    Nearest,
    /// Two, blended.
    Linear,
}

/// What lies outside of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    Repeat,
    /// The image again, every second one mirrored.
    Mirror,
    /// Its border texels.
    Clamp,
}

impl Default for Sampler {
    /// Trilinear, repeating: what glTF leaves open is answered with the best quality.
    fn default() -> Sampler {
        Sampler {
            magnify_linear: true,
            minify_linear: true,
            mipmap: Mipmap::Linear,
            wrap_u: Wrap::Repeat,
            wrap_v: Wrap::Repeat,
        }
    }
}

/// All samplers of a document.
pub(super) fn samplers(file: &str, root: &Root) -> Result<Vec<Sampler>> {
    root.samplers
        .iter()
        .enumerate()
        .map(|(i, s)| sampler(file, i, s))
        .collect()
}

fn sampler(file: &str, i: usize, json: &SamplerJson) -> Result<Sampler> {
    let bad = |what: &str, value: u32| {
        Error::input(
            file,
            format!("samplers[{i}].{what}"),
            format!("{value} does not exist"),
        )
    };
    let wrap = |what: &str, value: Option<u32>| match value.unwrap_or(10_497) {
        10_497 => Ok(Wrap::Repeat),
        33_648 => Ok(Wrap::Mirror),
        33_071 => Ok(Wrap::Clamp),
        other => Err(bad(what, other)),
    };
    let magnify_linear = match json.mag_filter.unwrap_or(9729) {
        9728 => false,
        9729 => true,
        other => return Err(bad("magFilter", other)),
    };
    let (minify_linear, mipmap) = match json.min_filter.unwrap_or(9987) {
        9728 => (false, Mipmap::None),
        9729 => (true, Mipmap::None),
        9984 => (false, Mipmap::Nearest),
        9985 => (true, Mipmap::Nearest),
        9986 => (false, Mipmap::Linear),
        9987 => (true, Mipmap::Linear),
        other => return Err(bad("minFilter", other)),
    };
    Ok(Sampler {
        magnify_linear,
        minify_linear,
        mipmap,
        wrap_u: wrap("wrapS", json.wrap_s)?,
        wrap_v: wrap("wrapT", json.wrap_t)?,
    })
}

/// All textures of a document, their indices checked.
pub(super) fn textures(
    file: &str,
    root: &Root,
    warnings: &mut Vec<String>,
) -> Result<Vec<Texture>> {
    let texture = |(i, json): (usize, &TextureJson)| {
        if let Some(sampler) = json.sampler {
            at(file, &root.samplers, "samplers", sampler, || {
                format!("textures[{i}].sampler")
            })?;
        }
        // WebP is decoded; any other extension's image is not.
        let webp = json
            .extensions
            .get("EXT_texture_webp")
            .and_then(|e| e.get("source")?.as_u64());
        let image = webp.map(|source| source as usize).or(json.source);
        match image {
            Some(image) => {
                at(file, &root.images, "images", image, || {
                    format!("textures[{i}].source")
                })?;
            }
            None => warnings.push(format!(
                "textures[{i}] has no image that can be read: a neutral one stands in"
            )),
        }
        Ok(Texture {
            image,
            sampler: json.sampler,
        })
    };
    root.textures.iter().enumerate().map(texture).collect()
}
