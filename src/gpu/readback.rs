//! Between host and device. In: slices, or buffers and images. Out: buffers and images with those contents, or vectors.
//! All of it goes through staging buffers and waits; none of it belongs in a frame.

use super::bind::Held;
use super::buffer::{Buffer, BufferKind};
use super::context::Context;
use super::image::{Image, ImageOptions, texel_bytes};
use crate::{Error, Result};
use ash::vk;

/// Most bytes of a staging buffer: larger contents go in parts.
const PART_BYTES: usize = 64 << 20;

impl Context {
    /// A storage buffer that holds `data`. An empty slice makes a buffer of 0 [`bytes`](Buffer::bytes) that shaders see
    /// as 16 zero bytes.
    ///
    /// Errors as [`Context::storage`].
    pub fn upload<T: bytemuck::Pod>(&self, name: &str, data: &[T]) -> Result<Buffer> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let buffer = self.storage(name, bytes.len() as u64)?;
        if bytes.is_empty() {
            let mut recorder = self.recorder(name)?;
            recorder.fill(&buffer, 0);
            self.run(recorder)?;
        }
        self.write(&buffer, 0, bytes)?;
        Ok(buffer)
    }

    /// Overwrites bytes of a buffer, from byte `at` (a multiple of 4) on. [`Error::Capacity`] when they do not fit.
    pub fn write(&self, buffer: &Buffer, at: u64, bytes: &[u8]) -> Result<()> {
        let mut at = at;
        for part in bytes.chunks(PART_BYTES) {
            let staging = self.staging(&format!("{} (staging)", buffer.name()), part)?;
            let mut recorder = self.recorder(&format!("upload {}", buffer.name()))?;
            recorder.copy_range(&staging, 0, buffer, at, part.len() as u64);
            self.run(recorder)?;
            at += part.len() as u64;
        }
        Ok(())
    }

    /// The contents of a buffer, which must be a whole number of `T`.
    pub fn download<T: bytemuck::Pod>(&self, buffer: &Buffer) -> Result<Vec<T>> {
        let element = size_of::<T>() as u64;
        assert!(
            element > 0 && buffer.bytes().is_multiple_of(element),
            "{buffer:?} is not made of {element} byte elements"
        );
        let count = (buffer.bytes() / element) as usize;
        let mut elements = vec![T::zeroed(); count];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut elements);
        let mut at = 0;
        for part in bytes.chunks_mut(PART_BYTES) {
            let length = part.len() as u64;
            let staging = self.buffer(
                &format!("{} (readback)", buffer.name()),
                length,
                BufferKind::Readback,
            )?;
            let mut recorder = self.recorder(&format!("download {}", buffer.name()))?;
            recorder.copy_range(buffer, at, &staging, 0, length);
            self.run(recorder)?;
            part.copy_from_slice(host_bytes(&staging)?);
            at += length;
        }
        Ok(elements)
    }

    /// The texels of an image's first level and layer, row by row. `T` is a texel or a part of one.
    pub fn download_image<T: bytemuck::Pod>(&self, image: &Image) -> Result<Vec<T>> {
        let [width, height] = image.size();
        let bytes = u64::from(width) * u64::from(height) * texel_bytes(image.options().format)?;
        let staging = self.buffer(
            &format!("{} (readback)", image.name()),
            bytes,
            BufferKind::Readback,
        )?;
        let mut recorder = self.recorder(&format!("download {}", image.name()))?;
        recorder.hold(Held::Image(image.clone()));
        recorder.hold(Held::Buffer(staging.clone()));
        recorder.pass("download image", |recorder| {
            let regions = [region(image, 0, 0, 0)];
            // SAFETY: recording; the image is in GENERAL, and the buffer holds all of its first level.
            unsafe {
                recorder.device().cmd_copy_image_to_buffer(
                    recorder.commands,
                    image.handle(),
                    vk::ImageLayout::GENERAL,
                    staging.handle(),
                    &regions,
                );
            }
        });
        self.run(recorder)?;
        Ok(bytemuck::pod_collect_to_vec(host_bytes(&staging)?))
    }

    /// An image with contents: `texels[level]` holds all layers of a mip level, one after the other, row by row.
    ///
    /// [`Error::Option`] when a level has another number of bytes than its size asks for; otherwise as
    /// [`Context::image`].
    pub fn texture(&self, name: &str, options: &ImageOptions, texels: &[&[u8]]) -> Result<Image> {
        let layers = options.layers.unwrap_or(1);
        for (level, bytes) in texels.iter().enumerate() {
            let [width, height] = level_size(options.size, level as u32);
            let need = u64::from(width)
                * u64::from(height)
                * u64::from(layers)
                * texel_bytes(options.format)?;
            if bytes.len() as u64 != need || texels.len() != options.levels as usize {
                let reason = format!(
                    "image \"{name}\" level {level} of {} has {} bytes, not {need} in {} levels",
                    texels.len(),
                    bytes.len(),
                    options.levels
                );
                return Err(Error::Option {
                    option: "texels",
                    reason,
                });
            }
        }
        let image = self.image(name, options)?;
        let staging = self.staging(&format!("{name} (staging)"), &texels.concat())?;
        let mut recorder = self.recorder(&format!("upload {name}"))?;
        recorder.hold(Held::Image(image.clone()));
        recorder.hold(Held::Buffer(staging.clone()));
        recorder.pass("upload image", |recorder| {
            let mut offset = 0;
            let mut regions = Vec::new();
            for (level, bytes) in texels.iter().enumerate() {
                regions.push(region(&image, level as u32, offset, layers));
                offset += bytes.len() as u64;
            }
            // SAFETY: recording; the image is in GENERAL, and the sizes were checked above.
            unsafe {
                recorder.device().cmd_copy_buffer_to_image(
                    recorder.commands,
                    staging.handle(),
                    image.handle(),
                    vk::ImageLayout::GENERAL,
                    &regions,
                );
            }
        });
        self.run(recorder)?;
        Ok(image)
    }
}

fn level_size(size: [u32; 2], level: u32) -> [u32; 2] {
    size.map(|texels| (texels >> level).max(1))
}

/// A level of an image, tightly packed in a buffer from byte `offset` on; 0 layers mean the first one.
fn region(image: &Image, level: u32, offset: u64, layers: u32) -> vk::BufferImageCopy {
    let [width, height] = level_size(image.size(), level);
    vk::BufferImageCopy::default()
        .buffer_offset(offset)
        .image_extent(vk::Extent3D {
            width,
            height,
            depth: 1,
        })
        .image_subresource(vk::ImageSubresourceLayers {
            aspect_mask: image.aspect(),
            mip_level: level,
            base_array_layer: 0,
            layer_count: layers.max(1),
        })
}

fn host_bytes(staging: &Buffer) -> Result<&[u8]> {
    staging.mapped().ok_or(Error::Vulkan {
        call: "vkMapMemory",
        code: "host memory is not mapped".to_owned(),
    })
}
