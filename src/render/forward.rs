//! The forward path: one draw whose fragment shader looks up and shades. Driver of `glsl/render/forward.vert` and `.frag`.
//!
//! In: the arrays of a [`Picture`] on a device; its textures as images, sampled by the device. Out: the same pixels as
//! the deferred path up to the rasteriser's and the texture unit's own rounding. Textures of one size, colour space and
//! sampler are layers of one array ([`CLASSES`] of them), so that no array of images is indexed by a variable.

use super::device::{Arrays, Posed, upload};
use super::draw::ViewConstants;
use super::filter::Filter;
use super::function;
use super::known::Known;
use super::picture::Picture;
use super::shade::{Aov, NOTHING, Pixel};
use crate::attribute::arithmetic::srgb_decode_table;
use crate::attribute::texture::{
    FLAG_NEAREST, FLAG_NO_MIPS, FLAG_SRGB, LEVELS_AT, TEXTURE_WORDS, TextureSet,
};
use crate::gpu::shaders::render_forward::{Bindings, Push, Shader};
use crate::gpu::{
    Bound, Buffer, Clear, Context, GraphicsOptions, GraphicsPass, Image, ImageOptions, Sampler,
    SamplerOptions, Timings, Variant, vk,
};
use crate::{Error, Result};
use std::sync::{Mutex, PoisonError};

/// Kinds of textures (size, colour space, sampler) that one picture may have.
const CLASSES: usize = 8;
/// Words of a texture record that the forward path fills: its class, and its layer there.
const CLASS_AT: usize = 6;

/// Formats of the colour attachments: linear colour; triangle, draw, barycentrics; fetches.
const FORMATS: [vk::Format; 3] = [
    vk::Format::R32G32B32A32_SFLOAT,
    vk::Format::R32G32B32A32_UINT,
    vk::Format::R32_UINT,
];

/// A picture bound to the forward pipeline.
pub(crate) struct Forward {
    context: Context,
    /// What another pose writes anew.
    pub(super) posed: Posed,
    sources: Sources,
    /// The pipelines made so far.
    bound: Mutex<Vec<(Filter, Bound<Shader>)>>,
    draw_count: u32,
    triangle_count: u32,
}

/// What a pipeline is bound to.
struct Sources {
    arrays: Arrays,
    known: Known,
    /// The fragment shader, with what is shown in place of base colour.
    shading: Variant,
    textures: Buffer,
    classes: Vec<(Image, Sampler)>,
}

impl Sources {
    fn new(context: &Context, picture: &Picture, arrays: &Arrays) -> Result<Self> {
        let set = &picture.attributes.textures;
        let (records, members) = classes(set)?;
        let mut classes = Vec::with_capacity(CLASSES);
        for class in &members {
            classes.push((
                image(context, set, class)?,
                sampler(context, set, class[0])?,
            ));
        }
        while classes.len() < CLASSES {
            classes.push((
                blank(context)?,
                context.sampler(&SamplerOptions::default())?,
            ));
        }
        let fragment = vk::ShaderStageFlags::FRAGMENT;
        let path = "render/forward.frag";
        Ok(Sources {
            arrays: arrays.clone(),
            shading: function::variant(&picture.attributes, fragment, path)?,
            known: Known::of(picture).in_fragments(),
            textures: context.upload("texture classes", &records)?,
            classes,
        })
    }

    fn bind(&self, context: &Context, filter: Filter) -> Result<Bound<Shader>> {
        let options = GraphicsOptions {
            color_formats: &FORMATS,
            depth: Some(vk::Format::D32_SFLOAT),
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            cull: vk::CullModeFlags::NONE,
            depth_test: true,
        };
        let a = &self.arrays;
        let class = |k: usize| (&self.classes[k].0, &self.classes[k].1);
        let variant = self.known.variant(filter, &self.shading);
        let pipeline = context.graphics_variant::<Shader>(&options, &variant)?;
        pipeline.bind(&Bindings {
            draws: &a.draws,
            corners: &a.corners,
            positions: &a.positions,
            t3: &a.t3,
            attribute_triangles: &a.attribute_triangles,
            attribute_vertices: &a.attribute_vertices,
            materials: &a.materials,
            textures: &self.textures,
            igt_hash: &a.igt_hash,
            igt_list: &a.igt_list,
            igt_triangles: &a.igt_triangles,
            class_0: class(0),
            class_1: class(1),
            class_2: class(2),
            class_3: class(3),
            class_4: class(4),
            class_5: class(5),
            class_6: class(6),
            class_7: class(7),
        })
    }
}

/// Images of one size that a picture is drawn into.
struct Target {
    colour: Image,
    ids: Image,
    fetches: Image,
    depth: Image,
}

impl Forward {
    pub(crate) fn new(context: &Context, picture: &Picture, arrays: &Arrays) -> Result<Self> {
        let sources = Sources::new(context, picture, arrays)?;
        Ok(Forward {
            context: context.clone(),
            posed: Posed::new(context, arrays),
            sources,
            bound: Mutex::default(),
            draw_count: picture.draws.len() as u32,
            triangle_count: picture.triangle_count(),
        })
    }

    /// Another picture of the same textures and tables.
    pub(super) fn restaged(&self, picture: &Picture) -> Result<Self> {
        Self::new(&self.context, picture, &upload(&self.context, picture)?)
    }

    /// The pipeline of a filter, made when it is first asked for.
    fn pipeline(&self, filter: Filter) -> Result<Bound<Shader>> {
        let mut made = self.bound.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, there)) = made.iter().find(|(of, _)| *of == filter) {
            return Ok(there.clone());
        }
        let new = self.sources.bind(&self.context, filter)?;
        made.push((filter, new.clone()));
        Ok(new)
    }

    /// What an image of this size is drawn into.
    fn target(&self, width: u32, height: u32) -> Result<Target> {
        let (context, usage) = (&self.context, vk::ImageUsageFlags::COLOR_ATTACHMENT);
        let colour = |name, k: usize| context.target(name, width, height, FORMATS[k], usage);
        let depth_usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        Ok(Target {
            colour: colour("colour", 0)?,
            ids: colour("ids", 1)?,
            fetches: colour("fetches", 2)?,
            depth: context.target("depth", width, height, vk::Format::D32_SFLOAT, depth_usage)?,
        })
    }

    /// Draws into `target` and waits; the time each pass took.
    fn run(&self, view: &ViewConstants, target: &Target) -> Result<Timings> {
        let pipeline = self.pipeline(view.filter())?;
        let mut recorder = self.context.recorder("forward picture")?;
        recorder.draw(&GraphicsPass {
            pipeline: &pipeline,
            push: self.push(view),
            color: &[
                (&target.colour, Clear::Float([0.0; 4])),
                (&target.ids, Clear::Uint([NOTHING, NOTHING, 0, 0])),
                (&target.fetches, Clear::Uint([0; 4])),
            ],
            depth: Some((&target.depth, Clear::Depth(1.0))),
            vertices: self.triangle_count * 3,
            instances: 1,
        });
        self.context.run(recorder)
    }

    /// Draws images, one after the other, and brings none back; each one's times go to `more`, until it says no.
    pub(crate) fn repeat(
        &self,
        view: &ViewConstants,
        mut more: impl FnMut(Timings) -> bool,
    ) -> Result<()> {
        let target = self.target(view.width, view.height)?;
        while more(self.run(view, &target)?) {}
        Ok(())
    }

    /// Draws, waits, and brings the pixels back. Colours are linear (or coded, for normals); the caller encodes them.
    pub(crate) fn draw(&self, view: &ViewConstants) -> Result<(Vec<Pixel>, Timings)> {
        let context = &self.context;
        let target = self.target(view.width, view.height)?;
        let timings = self.run(view, &target)?;
        let colour = context.download_image::<[f32; 4]>(&target.colour)?;
        let ids = context.download_image::<[u32; 4]>(&target.ids)?;
        let fetches = context.download_image::<u32>(&target.fetches)?;
        let depth = context.download_image::<f32>(&target.depth)?;
        let pixel = |(((linear, id), fetches), depth): ((([f32; 4], [u32; 4]), u32), f32)| {
            let [triangle, draw, b1, b2] = id;
            let barycentric = [f32::from_bits(b1), f32::from_bits(b2)];
            Pixel {
                linear,
                rgba8: 0,
                aov: Aov {
                    triangle,
                    draw,
                    barycentric,
                    fetches,
                    depth,
                },
            }
        };
        Ok((
            colour
                .into_iter()
                .zip(ids)
                .zip(fetches)
                .zip(depth)
                .map(pixel)
                .collect(),
            timings,
        ))
    }

    fn push(&self, view: &ViewConstants) -> Push {
        let [row_x, row_y, row_z, row_w] = view.rows;
        Push {
            row_x,
            row_y,
            row_z,
            row_w,
            eye: view.eye,
            light: view.light,
            width: view.width,
            height: view.height,
            flags: view.flags,
            draw_count: self.draw_count,
            vertex_count: 0,
            away_z: view.away[0],
            away_w: view.away[1],
            time: view.time,
        }
    }
}

/// Texture records with class and layer filled in, and for each class the textures that are its layers.
fn classes(set: &TextureSet) -> Result<(Vec<u32>, Vec<Vec<usize>>)> {
    let mut records = set.records.clone();
    let mut classes: Vec<Vec<usize>> = Vec::new();
    for id in 0..set.len() {
        // Width, height, levels, wrap modes and flags.
        let kind = |id: usize| &set.records[id * TEXTURE_WORDS + 1..id * TEXTURE_WORDS + CLASS_AT];
        let class = match classes.iter().position(|c| kind(c[0]) == kind(id)) {
            Some(class) => class,
            None => {
                classes.push(Vec::new());
                classes.len() - 1
            }
        };
        records[id * TEXTURE_WORDS + CLASS_AT] = class as u32;
        records[id * TEXTURE_WORDS + CLASS_AT + 1] = classes[class].len() as u32;
        classes[class].push(id);
    }
    if classes.len() > CLASSES {
        let what = "kinds of textures (size, colour space, sampler) of the forward path; --path deferred has no limit";
        return Err(Error::Capacity {
            what: what.into(),
            need: classes.len() as u64,
            have: CLASSES as u64,
        });
    }
    Ok((records, classes))
}

/// The textures of a class as layers of one image, with our own mip levels.
fn image(context: &Context, set: &TextureSet, class: &[usize]) -> Result<Image> {
    let record = |id: usize| &set.records[id * TEXTURE_WORDS..][..TEXTURE_WORDS];
    let first = record(class[0]);
    let srgb = first[5] & FLAG_SRGB != 0;
    let decode = srgb_decode_table();
    let (width, height, levels) = (first[1], first[2], first[3]);
    let mut texels: Vec<Vec<u8>> = Vec::with_capacity(levels as usize);
    for level in 0..levels {
        let area = (width >> level).max(1) as usize * (height >> level).max(1) as usize;
        let mut bytes = Vec::with_capacity(area * 4 * class.len());
        for &id in class {
            let begin = (record(id)[0] + record(id)[LEVELS_AT + level as usize]) as usize;
            let words = &set.texels[begin..begin + area];
            if srgb {
                bytes.extend(words.iter().flat_map(|&word| linear_half(&decode, word)));
            } else {
                bytes.extend_from_slice(bytemuck::cast_slice(words));
            }
        }
        texels.push(bytes);
    }
    let options = ImageOptions {
        size: [width, height],
        layers: Some(class.len() as u32),
        levels,
        format: if srgb {
            vk::Format::R16G16B16A16_SFLOAT
        } else {
            vk::Format::R8G8B8A8_UNORM
        },
        usage: vk::ImageUsageFlags::SAMPLED,
    };
    let levels: Vec<&[u8]> = texels.iter().map(Vec::as_slice).collect();
    context.texture("texture class", &options, &levels)
}

/// An sRGB texel as linear half floats: some devices decode sRGB by a polynomial that is a seventh of a step off.
fn linear_half(decode: &[f32; 256], word: u32) -> [u8; 8] {
    let [r, g, b, a] = word.to_le_bytes();
    let [r, g, b] = [r, g, b].map(|code| half_bits(decode[usize::from(code)]).to_le_bytes());
    let a = half_bits(f32::from(a) / 255.0).to_le_bytes();
    [r[0], r[1], g[0], g[1], b[0], b[1], a[0], a[1]]
}

/// The half float nearest to a value that is 0 or lies in [2^-14, 1].
fn half_bits(value: f32) -> u16 {
    if value <= 0.0 {
        return 0;
    }
    let bits = value.to_bits();
    let rounded = (bits + 0x0fff + ((bits >> 13) & 1)) >> 13;
    (rounded - ((127 - 15) << 10)) as u16
}

/// What an unused class holds.
fn blank(context: &Context) -> Result<Image> {
    let options = ImageOptions {
        size: [1, 1],
        layers: Some(1),
        levels: 1,
        format: vk::Format::R8G8B8A8_UNORM,
        usage: vk::ImageUsageFlags::SAMPLED,
    };
    context.texture("no texture", &options, &[&[255; 4]])
}

fn sampler(context: &Context, set: &TextureSet, id: usize) -> Result<Sampler> {
    let record = &set.records[id * TEXTURE_WORDS..][..TEXTURE_WORDS];
    let wrap = |mode: u32| match mode {
        0 => vk::SamplerAddressMode::REPEAT,
        1 => vk::SamplerAddressMode::MIRRORED_REPEAT,
        _ => vk::SamplerAddressMode::CLAMP_TO_EDGE,
    };
    let filter = if record[5] & FLAG_NEAREST != 0 {
        vk::Filter::NEAREST
    } else {
        vk::Filter::LINEAR
    };
    context.sampler(&SamplerOptions {
        magnify: filter,
        minify: filter,
        mipmap: vk::SamplerMipmapMode::LINEAR,
        mipmapped: record[5] & FLAG_NO_MIPS == 0,
        wrap: [wrap(record[4] & 3), wrap((record[4] >> 2) & 3)],
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn half_floats_of_known_values() {
        let known = [
            (0.0, 0),
            (1.0, 0x3c00),
            (0.5, 0x3800),
            (0.333_251_95, 0x3555),
            (6.103_515_6e-5, 0x0400),
        ];
        for (value, bits) in known {
            assert_eq!(half_bits(value), bits, "{value}");
        }
        // To nearest, ties to even.
        assert_eq!(half_bits(1.0 - 1.0 / 8192.0), 0x3c00);
        assert_eq!(half_bits(0.5 + 1.0 / 4096.0), 0x3800);
    }
}
