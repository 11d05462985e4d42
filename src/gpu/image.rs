//! Images and samplers. In: size, format and use. Out: [`Image`], always in the layout GENERAL, with one view of all of
//! it; [`Sampler`].
//!
//! GENERAL for everything costs some drivers compression of render targets; it saves every layout transition after the
//! first, and with it the state that would have to be tracked.

use super::context::Context;
use super::failure;
use crate::{Error, Result};
use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;
use std::sync::Arc;

/// A 2D image or 2D array. Clones share it; the last one frees it (see [`Buffer`](super::Buffer) for when).
#[derive(Clone)]
pub struct Image(Arc<ImageInner>);

struct ImageInner {
    context: Context,
    raw: vk::Image,
    view: vk::ImageView,
    allocation: Option<Allocation>,
    options: ImageOptions,
    name: String,
}

/// What an image is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageOptions {
    /// Texels across and down.
    pub size: [u32; 2],
    /// Layers of an array (`sampler2DArray` in GLSL, also for one layer); `None` for a plain 2D image.
    pub layers: Option<u32>,
    /// Mip levels, at least 1.
    pub levels: u32,
    /// Format of a texel.
    pub format: vk::Format,
    /// What it is used for; transfers are always added.
    pub usage: vk::ImageUsageFlags,
}

/// How a shader reads an image. Clones share it.
#[derive(Clone)]
pub struct Sampler(Arc<SamplerInner>);

struct SamplerInner {
    context: Context,
    raw: vk::Sampler,
}

/// How a [`Sampler`] filters and wraps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SamplerOptions {
    /// Filter under magnification.
    pub magnify: vk::Filter,
    /// Filter under minification.
    pub minify: vk::Filter,
    /// Filter between mip levels.
    pub mipmap: vk::SamplerMipmapMode,
    /// Whether levels beyond the first are used.
    pub mipmapped: bool,
    /// Wrapping of u and of v.
    pub wrap: [vk::SamplerAddressMode; 2],
}

impl Default for SamplerOptions {
    /// Trilinear, repeating.
    fn default() -> Self {
        SamplerOptions {
            magnify: vk::Filter::LINEAR,
            minify: vk::Filter::LINEAR,
            mipmap: vk::SamplerMipmapMode::LINEAR,
            mipmapped: true,
            wrap: [vk::SamplerAddressMode::REPEAT; 2],
        }
    }
}

impl Context {
    /// An image to draw to or to store into: one level, one layer, unspecified contents.
    ///
    /// Errors as [`Context::image`].
    pub fn target(
        &self,
        name: &str,
        width: u32,
        height: u32,
        format: vk::Format,
        usage: vk::ImageUsageFlags,
    ) -> Result<Image> {
        self.image(
            name,
            &ImageOptions {
                size: [width, height],
                layers: None,
                levels: 1,
                format,
                usage,
            },
        )
    }

    /// An image with unspecified contents, in layout GENERAL (which takes a submission of its own).
    ///
    /// [`Error::Capacity`] when the device has no images of this size, [`Error::Requirement`] when it has none of this
    /// format and usage, [`Error::OutOfMemory`].
    pub fn image(&self, name: &str, options: &ImageOptions) -> Result<Image> {
        let options = ImageOptions {
            usage: options.usage | transfers(),
            ..*options
        };
        self.check_image(name, &options)?;
        let device = &self.0.device;
        let info = create_info(&options);
        // SAFETY: size, format and usage were checked against the device.
        let raw = unsafe { device.create_image(&info, None) }.map_err(failure::allocating(
            "vkCreateImage",
            name,
            0,
        ))?;
        // From here on the image frees itself when something fails.
        let mut image = ImageInner {
            context: self.clone(),
            raw,
            view: vk::ImageView::null(),
            allocation: None,
            options,
            name: name.to_owned(),
        };
        // SAFETY: the image was just made.
        let requirements = unsafe { device.get_image_memory_requirements(raw) };
        let allocation =
            self.0
                .memory
                .allocate(name, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: the memory is only bound, and freed through the allocation.
        let (memory, offset) = (unsafe { allocation.memory() }, allocation.offset());
        image.allocation = Some(allocation);
        // SAFETY: the allocation meets the image's requirements and is bound to nothing else.
        unsafe { device.bind_image_memory(raw, memory, offset) }.map_err(failure::allocating(
            "vkBindImageMemory",
            name,
            requirements.size,
        ))?;
        let view = view_info(raw, &options);
        // SAFETY: the image is bound to memory, and the view covers all of it.
        image.view = unsafe { device.create_image_view(&view, None) }
            .map_err(failure::of("vkCreateImageView"))?;
        self.0.labels.name(raw, name);
        let image = Image(Arc::new(image));
        let mut recorder = self.recorder("make image")?;
        recorder.initialise(&image);
        self.run(recorder)?;
        Ok(image)
    }

    fn check_image(&self, name: &str, options: &ImageOptions) -> Result<()> {
        let layers = options.layers.unwrap_or(1);
        // SAFETY: a plain query.
        let found = unsafe {
            self.instance().get_physical_device_image_format_properties(
                self.physical_device(),
                options.format,
                vk::ImageType::TYPE_2D,
                vk::ImageTiling::OPTIMAL,
                options.usage,
                vk::ImageCreateFlags::empty(),
            )
        };
        let most = found.map_err(|code| match code {
            vk::Result::ERROR_FORMAT_NOT_SUPPORTED => Error::Requirement {
                device: self.info().name.clone(),
                missing: format!("images of {:?} for {:?}", options.format, options.usage),
            },
            other => failure::of("vkGetPhysicalDeviceImageFormatProperties")(other),
        })?;
        let parts = [
            ("texels of width", options.size[0], most.max_extent.width),
            ("texels of height", options.size[1], most.max_extent.height),
            ("layers", layers, most.max_array_layers),
            ("mip levels", options.levels, most.max_mip_levels),
        ];
        for (unit, need, have) in parts {
            if need > have || need == 0 {
                let what = format!("{unit} of image \"{name}\" (at least 1)");
                return Err(Error::Capacity {
                    what,
                    need: need.into(),
                    have: have.into(),
                });
            }
        }
        Ok(())
    }

    /// A sampler.
    pub fn sampler(&self, options: &SamplerOptions) -> Result<Sampler> {
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(options.magnify)
            .min_filter(options.minify)
            .mipmap_mode(options.mipmap)
            .max_lod(if options.mipmapped {
                vk::LOD_CLAMP_NONE
            } else {
                0.0
            })
            .address_mode_u(options.wrap[0])
            .address_mode_v(options.wrap[1])
            .address_mode_w(vk::SamplerAddressMode::CLAMP_TO_EDGE);
        // SAFETY: no feature is used that the device must have enabled.
        let raw = unsafe { self.0.device.create_sampler(&info, None) }
            .map_err(failure::of("vkCreateSampler"))?;
        Ok(Sampler(Arc::new(SamplerInner {
            context: self.clone(),
            raw,
        })))
    }
}

impl Image {
    /// Texels across and down.
    pub fn size(&self) -> [u32; 2] {
        self.0.options.size
    }

    /// All about it.
    pub fn options(&self) -> &ImageOptions {
        &self.0.options
    }

    /// The name it was made with.
    pub fn name(&self) -> &str {
        &self.0.name
    }

    /// The Vulkan handle.
    pub fn handle(&self) -> vk::Image {
        self.0.raw
    }

    /// A view of all levels and layers.
    pub fn view(&self) -> vk::ImageView {
        self.0.view
    }

    pub(super) fn context(&self) -> &Context {
        &self.0.context
    }

    /// Colour or depth.
    pub(super) fn aspect(&self) -> vk::ImageAspectFlags {
        aspect(self.0.options.format)
    }
}

impl Sampler {
    pub(super) fn handle(&self) -> vk::Sampler {
        self.0.raw
    }

    pub(super) fn context(&self) -> &Context {
        &self.0.context
    }
}

impl std::fmt::Debug for Image {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Image({:?}, {:?})", self.0.name, self.0.options)
    }
}

impl Drop for ImageInner {
    fn drop(&mut self) {
        let device = &self.context.0.device;
        // SAFETY: the device no longer uses the image, and view and image are destroyed once (a null view is ignored).
        unsafe {
            device.destroy_image_view(self.view, None);
            device.destroy_image(self.raw, None);
        }
        if let Some(allocation) = self.allocation.take() {
            self.context.0.memory.free(allocation);
        }
    }
}

impl Drop for SamplerInner {
    fn drop(&mut self) {
        // SAFETY: the device no longer uses the sampler, and it is destroyed once.
        unsafe { self.context.0.device.destroy_sampler(self.raw, None) };
    }
}

fn transfers() -> vk::ImageUsageFlags {
    vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST
}

fn create_info(options: &ImageOptions) -> vk::ImageCreateInfo<'static> {
    vk::ImageCreateInfo::default()
        .image_type(vk::ImageType::TYPE_2D)
        .format(options.format)
        .extent(vk::Extent3D {
            width: options.size[0],
            height: options.size[1],
            depth: 1,
        })
        .mip_levels(options.levels)
        .array_layers(options.layers.unwrap_or(1))
        .samples(vk::SampleCountFlags::TYPE_1)
        .tiling(vk::ImageTiling::OPTIMAL)
        .usage(options.usage)
}

fn view_info(raw: vk::Image, options: &ImageOptions) -> vk::ImageViewCreateInfo<'static> {
    let range = vk::ImageSubresourceRange::default()
        .aspect_mask(aspect(options.format))
        .level_count(vk::REMAINING_MIP_LEVELS)
        .layer_count(vk::REMAINING_ARRAY_LAYERS);
    let view_type = match options.layers {
        Some(_) => vk::ImageViewType::TYPE_2D_ARRAY,
        None => vk::ImageViewType::TYPE_2D,
    };
    vk::ImageViewCreateInfo::default()
        .image(raw)
        .view_type(view_type)
        .format(options.format)
        .subresource_range(range)
}

fn aspect(format: vk::Format) -> vk::ImageAspectFlags {
    match format {
        vk::Format::D32_SFLOAT | vk::Format::D16_UNORM => vk::ImageAspectFlags::DEPTH,
        _ => vk::ImageAspectFlags::COLOR,
    }
}

/// Bytes of a texel, for the formats that are moved between host and device.
pub(super) fn texel_bytes(format: vk::Format) -> Result<u64> {
    Ok(match format {
        vk::Format::R8_UNORM | vk::Format::R8_UINT => 1,
        vk::Format::R8G8_UNORM
        | vk::Format::R16_UINT
        | vk::Format::R16_SFLOAT
        | vk::Format::D16_UNORM => 2,
        vk::Format::R8G8B8A8_UNORM
        | vk::Format::R8G8B8A8_SRGB
        | vk::Format::R32_UINT
        | vk::Format::R32_SINT
        | vk::Format::R32_SFLOAT
        | vk::Format::D32_SFLOAT
        | vk::Format::R16G16_SFLOAT
        | vk::Format::E5B9G9R9_UFLOAT_PACK32 => 4,
        vk::Format::R32G32_UINT | vk::Format::R32G32_SFLOAT | vk::Format::R16G16B16A16_SFLOAT => 8,
        vk::Format::R32G32B32A32_UINT
        | vk::Format::R32G32B32A32_SINT
        | vk::Format::R32G32B32A32_SFLOAT => 16,
        other => {
            let reason = format!("{other:?} is not a format that is moved between host and device");
            return Err(Error::Option {
                option: "image format",
                reason,
            });
        }
    })
}
