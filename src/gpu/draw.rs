//! A graphics pass. In: a bound graphics pipeline, images to draw to, a vertex count. Out: one dynamic-rendering pass in
//! the recorder's command buffer.

use super::bind::{Bound, Held};
use super::image::Image;
use super::interface::GraphicsShader;
use super::recorder::Recorder;
use crate::Error;
use ash::vk;

/// One draw into images of one size.
pub struct GraphicsPass<'a, S: GraphicsShader> {
    /// The pipeline with its resources.
    pub pipeline: &'a Bound<S>,
    /// Its push constants.
    pub push: S::Push,
    /// Colour images, in the order of the fragment shader's outputs, and what they start with.
    pub color: &'a [(&'a Image, Clear)],
    /// The depth image and what it starts with.
    pub depth: Option<(&'a Image, Clear)>,
    /// Vertices per instance.
    pub vertices: u32,
    /// Instances.
    pub instances: u32,
}

/// What an attachment holds when its pass begins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clear {
    /// What it held before.
    Load,
    /// A colour of a float or normalised format.
    Float([f32; 4]),
    /// A colour of an unsigned integer format.
    Uint([u32; 4]),
    /// A depth.
    Depth(f32),
}

impl Recorder {
    /// A graphics pass. Viewport and scissor are the whole of the images, which must be of one size.
    pub fn draw<S: GraphicsShader>(&mut self, pass: &GraphicsPass<'_, S>) {
        let images: Vec<&Image> = pass
            .color
            .iter()
            .chain(&pass.depth)
            .map(|(image, _)| *image)
            .collect();
        let Some(size) = images.first().map(|image| image.size()) else {
            let reason = format!("{} has no image to draw to", S::NAME);
            return self.fail(Error::Option {
                option: "attachments",
                reason,
            });
        };
        if let Some(other) = images.iter().find(|image| image.size() != size) {
            let reason = format!(
                "\"{}\" is {:?}, the first attachment {size:?}",
                other.name(),
                other.size()
            );
            return self.fail(Error::Option {
                option: "attachments",
                reason,
            });
        }
        for image in images {
            self.hold(Held::Image(image.clone()));
        }
        self.hold_set(pass.pipeline);
        self.pass(S::NAME, |recorder| recorder.render(pass, size));
    }

    fn render<S: GraphicsShader>(&self, pass: &GraphicsPass<'_, S>, [width, height]: [u32; 2]) {
        let color: Vec<_> = pass
            .color
            .iter()
            .map(|(image, clear)| attachment(image, *clear))
            .collect();
        let depth = pass.depth.map(|(image, clear)| attachment(image, clear));
        let area = vk::Rect2D {
            offset: vk::Offset2D::default(),
            extent: vk::Extent2D { width, height },
        };
        let mut info = vk::RenderingInfo::default()
            .render_area(area)
            .layer_count(1)
            .color_attachments(&color);
        if let Some(depth) = &depth {
            info = info.depth_attachment(depth);
        }
        let viewport = vk::Viewport {
            width: width as f32,
            height: height as f32,
            max_depth: 1.0,
            ..Default::default()
        };
        let (device, commands) = (self.device(), self.commands);
        // SAFETY: recording, outside a render pass; the attachments live as long as the recorder holds them.
        unsafe {
            device.cmd_begin_rendering(commands, &info);
            self.bind(pass.pipeline, &pass.push);
            device.cmd_set_viewport(commands, 0, &[viewport]);
            device.cmd_set_scissor(commands, 0, &[area]);
            device.cmd_draw(commands, pass.vertices, pass.instances, 0, 0);
            device.cmd_end_rendering(commands);
        }
    }
}

fn attachment(image: &Image, clear: Clear) -> vk::RenderingAttachmentInfo<'static> {
    let value = match clear {
        Clear::Load => vk::ClearValue::default(),
        Clear::Float(float32) => vk::ClearValue {
            color: vk::ClearColorValue { float32 },
        },
        Clear::Uint(uint32) => vk::ClearValue {
            color: vk::ClearColorValue { uint32 },
        },
        Clear::Depth(depth) => vk::ClearValue {
            depth_stencil: vk::ClearDepthStencilValue { depth, stencil: 0 },
        },
    };
    let load = if clear == Clear::Load {
        vk::AttachmentLoadOp::LOAD
    } else {
        vk::AttachmentLoadOp::CLEAR
    };
    vk::RenderingAttachmentInfo::default()
        .image_view(image.view())
        .image_layout(vk::ImageLayout::GENERAL)
        .load_op(load)
        .store_op(vk::AttachmentStoreOp::STORE)
        .clear_value(value)
}
