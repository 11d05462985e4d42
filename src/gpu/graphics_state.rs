//! The fixed-function half of a graphics pipeline. In: [`GraphicsOptions`] and the stages. Out: the Vulkan pipeline:
//! no vertex buffers, no blending, one sample, dynamic viewport and scissor, dynamic rendering.

use super::context::Inner;
use super::failure;
use super::pipeline::GraphicsOptions;
use crate::Result;
use ash::vk;

impl Inner {
    pub(super) fn create_graphics(
        &self,
        cache: vk::PipelineCache,
        layout: vk::PipelineLayout,
        stages: &[vk::PipelineShaderStageCreateInfo<'_>],
        options: &GraphicsOptions<'_>,
    ) -> Result<vk::Pipeline> {
        let vertices = vk::PipelineVertexInputStateCreateInfo::default();
        let assembly =
            vk::PipelineInputAssemblyStateCreateInfo::default().topology(options.topology);
        let viewport = vk::PipelineViewportStateCreateInfo::default()
            .viewport_count(1)
            .scissor_count(1);
        let raster = vk::PipelineRasterizationStateCreateInfo::default()
            .polygon_mode(vk::PolygonMode::FILL)
            .cull_mode(options.cull)
            .front_face(vk::FrontFace::COUNTER_CLOCKWISE)
            .line_width(1.0);
        let samples = vk::PipelineMultisampleStateCreateInfo::default()
            .rasterization_samples(vk::SampleCountFlags::TYPE_1);
        let depth = vk::PipelineDepthStencilStateCreateInfo::default()
            .depth_test_enable(options.depth_test)
            .depth_write_enable(options.depth_test)
            .depth_compare_op(vk::CompareOp::LESS_OR_EQUAL);
        let opaque = vk::PipelineColorBlendAttachmentState::default()
            .color_write_mask(vk::ColorComponentFlags::RGBA);
        let opaque = vec![opaque; options.color_formats.len()];
        let blend = vk::PipelineColorBlendStateCreateInfo::default().attachments(&opaque);
        let dynamic_states = [vk::DynamicState::VIEWPORT, vk::DynamicState::SCISSOR];
        let dynamic = vk::PipelineDynamicStateCreateInfo::default().dynamic_states(&dynamic_states);
        let mut rendering = vk::PipelineRenderingCreateInfo::default()
            .color_attachment_formats(options.color_formats)
            .depth_attachment_format(options.depth.unwrap_or_default());
        let info = vk::GraphicsPipelineCreateInfo::default()
            .stages(stages)
            .vertex_input_state(&vertices)
            .input_assembly_state(&assembly)
            .viewport_state(&viewport)
            .rasterization_state(&raster)
            .multisample_state(&samples)
            .depth_stencil_state(&depth)
            .color_blend_state(&blend)
            .dynamic_state(&dynamic)
            .layout(layout)
            .push_next(&mut rendering);
        // SAFETY: stages and layout are alive and were made for each other by reflection; all state outlives the call.
        let made = unsafe { self.device.create_graphics_pipelines(cache, &[info], None) };
        made.map(|pipelines| pipelines[0])
            .map_err(|(_, code)| failure::of("vkCreateGraphicsPipelines")(code))
    }
}
