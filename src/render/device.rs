//! The deferred path on a device: the picture's arrays as buffers, and the three passes.
//!
//! In: a [`Picture`] (uploaded once), a view. Out: a [`Target`] that holds the pixels. [`Device::record`] only records:
//! everything it needs exists once a target of the right size does.

use super::draw::{DrawRecord, Projected, ViewConstants};
use super::filter::Filter;
use super::function;
use super::known::Known;
use super::picture::Picture;
use super::shade::{Aov, NOTHING, Pixel};
use crate::gpu::shaders::{render_project, render_raster, render_shade};
use crate::gpu::{
    Bound, Buffer, Clear, Context, GraphicsOptions, GraphicsPass, Image, Recorder, Timings,
    Variant, vk,
};
use crate::igt::Tables;
use crate::{Error, Result};
use std::sync::Mutex;

/// Bytes of one pixel in the largest of the result's buffers.
const AOV_BYTES: u64 = size_of::<Aov>() as u64;

/// A picture on a device.
pub(crate) struct Device {
    context: Context,
    /// What another pose writes anew.
    pub(super) posed: Posed,
    arrays: Arrays,
    project: Bound<render_project::Shader>,
    draw_count: u32,
    vertex_count: u32,
    triangle_count: u32,
    known: Known,
    /// The shading pass, with what is shown in place of base colour.
    shading: Variant,
    /// The last target, kept because most images of a run have one size.
    target: Mutex<Option<Target>>,
}

/// The picture's arrays.
#[derive(Clone)]
pub(crate) struct Arrays {
    pub(super) draws: Buffer,
    pub(super) corners: Buffer,
    pub(super) projected: Buffer,
    pub(super) positions: Buffer,
    pub(super) constants: Buffer,
    pub(super) attribute_triangles: Buffer,
    pub(super) attribute_vertices: Buffer,
    pub(super) materials: Buffer,
    pub(super) textures: Buffer,
    pub(super) texels: [Buffer; 4],
    pub(super) t3: Buffer,
    pub(super) igt_hash: Buffer,
    pub(super) igt_list: Buffer,
    pub(super) igt_triangles: Buffer,
}

/// The arrays that depend on the pose.
pub(crate) struct Posed {
    context: Context,
    draws: Buffer,
    positions: Buffer,
    attribute_vertices: Buffer,
}

impl Posed {
    pub(super) fn new(context: &Context, arrays: &Arrays) -> Self {
        Posed {
            context: context.clone(),
            draws: arrays.draws.clone(),
            positions: arrays.positions.clone(),
            attribute_vertices: arrays.attribute_vertices.clone(),
        }
    }

    /// Writes them as `picture` has them, which differs from the uploaded one by its pose alone.
    pub(super) fn write(&self, picture: &Picture) -> Result<()> {
        let vertices: &[u8] = bytemuck::cast_slice(&picture.attributes.vertices);
        for (buffer, bytes) in [
            (&self.draws, bytemuck::cast_slice(&picture.draws)),
            (&self.positions, bytemuck::cast_slice(&picture.positions)),
            (&self.attribute_vertices, vertices),
        ] {
            let name = buffer.name();
            assert_eq!(
                buffer.bytes(),
                bytes.len() as u64,
                "{name} of another picture"
            );
            self.context.write(buffer, 0, bytes)?;
        }
        Ok(())
    }
}

/// Images and buffers of one size that a picture is drawn into.
pub(crate) struct Target {
    size: [u32; 2],
    filter: Filter,
    ids: Image,
    depth: Image,
    /// sRGB RGBA of 8 bits, a word each.
    colour: Buffer,
    linear: Buffer,
    aov: Buffer,
    raster: Bound<render_raster::Shader>,
    shade: Bound<render_shade::Shader>,
}

impl Device {
    pub(crate) fn new(context: &Context, picture: &Picture) -> Result<Self> {
        Self::of(context, picture, upload(context, picture)?)
    }

    /// Another picture of the same textures and tables.
    pub(super) fn restaged(&self, picture: &Picture) -> Result<Self> {
        let arrays = geometry(&self.context, picture, self.arrays.clone())?;
        Self::of(&self.context, picture, arrays)
    }

    fn of(context: &Context, picture: &Picture, arrays: Arrays) -> Result<Self> {
        let compute = vk::ShaderStageFlags::COMPUTE;
        let shading = function::variant(&picture.attributes, compute, "render/shade.comp")?;
        let project =
            context
                .compute::<render_project::Shader>()?
                .bind(&render_project::Bindings {
                    positions: &arrays.positions,
                    draws: &arrays.draws,
                    projected: &arrays.projected,
                })?;
        Ok(Device {
            context: context.clone(),
            posed: Posed::new(context, &arrays),
            arrays,
            project,
            draw_count: picture.draws.len() as u32,
            vertex_count: picture.vertex_count(),
            triangle_count: picture.triangle_count(),
            known: Known::of(picture),
            shading,
            target: Mutex::new(None),
        })
    }

    /// What an image of this size is drawn into, and the pipelines that do.
    pub(crate) fn target(&self, width: u32, height: u32, filter: Filter) -> Result<Target> {
        let (context, a) = (&self.context, &self.arrays);
        let pixels = u64::from(width) * u64::from(height);
        let have = context.info().limits.storage_buffer_bytes;
        if pixels * AOV_BYTES > have {
            let what = "bytes of one image's pixels on the device (draw it smaller)".into();
            return Err(Error::Capacity {
                what,
                need: pixels * AOV_BYTES,
                have,
            });
        }
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT | vk::ImageUsageFlags::STORAGE;
        let ids = context.target("triangle ids", width, height, vk::Format::R32_UINT, usage)?;
        let usage = vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT;
        let depth = context.target("depth", width, height, vk::Format::D32_SFLOAT, usage)?;
        let colour = context.storage("colour", pixels * 4)?;
        let linear = context.storage("linear colour", pixels * 16)?;
        let aov = context.storage("aov", pixels * AOV_BYTES)?;
        let options = GraphicsOptions {
            color_formats: &[vk::Format::R32_UINT],
            depth: Some(vk::Format::D32_SFLOAT),
            topology: vk::PrimitiveTopology::TRIANGLE_LIST,
            cull: vk::CullModeFlags::NONE,
            depth_test: true,
        };
        let raster = context.graphics::<render_raster::Shader>(&options)?.bind(
            &render_raster::Bindings {
                draws: &a.draws,
                corners: &a.corners,
                projected: &a.projected,
            },
        )?;
        let shade = context
            .compute_variant::<render_shade::Shader>(&self.known.variant(filter, &self.shading))?
            .bind(&render_shade::Bindings {
                draws: &a.draws,
                corners: &a.corners,
                projected: &a.projected,
                positions: &a.positions,
                constants: &a.constants,
                attribute_triangles: &a.attribute_triangles,
                attribute_vertices: &a.attribute_vertices,
                materials: &a.materials,
                textures: &a.textures,
                texels_0: &a.texels[0],
                texels_1: &a.texels[1],
                texels_2: &a.texels[2],
                texels_3: &a.texels[3],
                t3: &a.t3,
                igt_hash: &a.igt_hash,
                igt_list: &a.igt_list,
                igt_triangles: &a.igt_triangles,
                colour: &colour,
                linear: &linear,
                aov: &aov,
                ids: &ids,
            })?;
        Ok(Target {
            size: [width, height],
            filter,
            ids,
            depth,
            colour,
            linear,
            aov,
            raster,
            shade,
        })
    }

    /// Records the three passes; the target's buffers hold the image once they have run.
    pub(crate) fn record(&self, recorder: &mut Recorder, view: &ViewConstants, target: &Target) {
        let push = self.push(view);
        if self.vertex_count > 0 {
            recorder.dispatch(&self.project, &push, groups(self.vertex_count, 64));
        }
        recorder.draw(&GraphicsPass {
            pipeline: &target.raster,
            push: bytemuck::cast(push),
            color: &[(&target.ids, Clear::Uint([NOTHING; 4]))],
            depth: Some((&target.depth, Clear::Depth(1.0))),
            vertices: self.triangle_count * 6,
            instances: 1,
        });
        let tiles = [target.size[0].div_ceil(8), target.size[1].div_ceil(8), 1];
        recorder.dispatch(&target.shade, &bytemuck::cast(push), tiles);
    }

    fn push(&self, view: &ViewConstants) -> render_project::Push {
        let [row_x, row_y, row_z, row_w] = view.rows;
        render_project::Push {
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
            vertex_count: self.vertex_count,
            away_z: view.away[0],
            away_w: view.away[1],
            time: view.time,
        }
    }

    /// Draws, waits, and brings the pixels back.
    pub(crate) fn draw(&self, view: &ViewConstants) -> Result<(Vec<Pixel>, Timings)> {
        self.with_target(view, |target| {
            let timings = self.run(view, target)?;
            Ok((self.read(target)?, timings))
        })
    }

    /// Draws images, one after the other, and brings none back; each one's times go to `more`, until it says no.
    pub(crate) fn repeat(
        &self,
        view: &ViewConstants,
        mut more: impl FnMut(Timings) -> bool,
    ) -> Result<()> {
        self.with_target(view, |target| {
            while more(self.run(view, target)?) {}
            Ok(())
        })
    }

    /// Calls `work` with a target of the view's size: the last one where it fits.
    fn with_target<T>(
        &self,
        view: &ViewConstants,
        work: impl FnOnce(&Target) -> Result<T>,
    ) -> Result<T> {
        let mut kept = self
            .target
            .lock()
            .unwrap_or_else(std::sync::PoisonError::into_inner);
        let filter = view.filter();
        let target = match kept.take() {
            Some(target) if target.size == [view.width, view.height] && target.filter == filter => {
                target
            }
            _ => self.target(view.width, view.height, filter)?,
        };
        let done = work(&target)?;
        *kept = Some(target);
        Ok(done)
    }

    fn run(&self, view: &ViewConstants, target: &Target) -> Result<Timings> {
        let mut recorder = self.context.recorder("picture")?;
        self.record(&mut recorder, view, target);
        self.context.run(recorder)
    }

    fn read(&self, target: &Target) -> Result<Vec<Pixel>> {
        let colour = self.context.download::<u32>(&target.colour)?;
        let linear = self.context.download::<[f32; 4]>(&target.linear)?;
        let aov = self.context.download::<Aov>(&target.aov)?;
        let pixels = colour.into_iter().zip(linear).zip(aov);
        Ok(pixels
            .map(|((rgba8, linear), aov)| Pixel { linear, rgba8, aov })
            .collect())
    }
}

/// The arrays that another geometry writes anew.
fn geometry(context: &Context, picture: &Picture, kept: Arrays) -> Result<Arrays> {
    let attributes = &picture.attributes;
    Ok(Arrays {
        draws: context.upload::<DrawRecord>("draws", &picture.draws)?,
        corners: context.upload("triangles", &picture.corners)?,
        projected: context.storage("projected vertices", projected_bytes(picture))?,
        positions: context.upload("positions", &picture.positions)?,
        attribute_triangles: context.upload("attribute triangles", &attributes.triangles)?,
        attribute_vertices: context.upload("attribute vertices", &attributes.vertices)?,
        t3: context.upload("t3", &picture.t3)?,
        ..kept
    })
}

fn projected_bytes(picture: &Picture) -> u64 {
    u64::from(picture.vertex_count()) * size_of::<Projected>() as u64
}

/// Workgroups of `size` invocations for `count` of them, in two dimensions because one holds 65535 groups.
fn groups(count: u32, size: u32) -> [u32; 3] {
    let groups = count.div_ceil(size);
    let across = groups.min(32768);
    [across, groups.div_ceil(across.max(1)), 1]
}

pub(super) fn upload(context: &Context, picture: &Picture) -> Result<Arrays> {
    let attributes = &picture.attributes;
    let texels = |k: usize| context.upload(&format!("texels {k}"), attributes.textures.shard(k));
    let joined = |words: fn(&Tables) -> &[u32]| -> Vec<u32> {
        picture
            .tables
            .iter()
            .flat_map(|t| words(t).iter().copied())
            .collect()
    };
    Ok(Arrays {
        draws: context.upload::<DrawRecord>("draws", &picture.draws)?,
        corners: context.upload("triangles", &picture.corners)?,
        projected: context.storage("projected vertices", projected_bytes(picture))?,
        positions: context.upload("positions", &picture.positions)?,
        constants: context.upload("constants", &picture.constants)?,
        attribute_triangles: context.upload("attribute triangles", &attributes.triangles)?,
        attribute_vertices: context.upload("attribute vertices", &attributes.vertices)?,
        materials: context.upload("materials", &attributes.materials)?,
        textures: context.upload("textures", &attributes.textures.records)?,
        texels: [texels(0)?, texels(1)?, texels(2)?, texels(3)?],
        t3: context.upload("t3", &picture.t3)?,
        igt_hash: context.upload("igt hash", &joined(|t| &t.hash))?,
        igt_list: context.upload("igt lists", &joined(|t| &t.list))?,
        igt_triangles: context.upload("igt triangles", &joined(|t| &t.triangle))?,
    })
}
