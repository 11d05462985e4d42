//! The recorder: a pass is one call. In: bound pipelines and buffers. Out: commands, each pass with its label, a full
//! barrier before it and a time stamp after it. Nothing here submits, waits or, over a foreign command
//! buffer, allocates.
//!
//! There is one memory barrier at every pass boundary, for all stages and all accesses. It costs overlap between passes
//! that do not depend on each other; it cannot be forgotten.

use super::bind::{Bound, Held};
use super::buffer::Buffer;
use super::context::Context;
use super::image::Image;
use super::interface::{ComputeShader, ShaderInterface};
use super::submit::OwnCommands;
use crate::{Error, Result};
use ash::vk;

/// Records passes into a command buffer: its own, or an embedder's.
pub struct Recorder {
    pub(super) context: Context,
    pub(super) commands: vk::CommandBuffer,
    pub(super) name: String,
    pub(super) own: Option<OwnCommands>,
    pub(super) passes: Vec<String>,
    held: Vec<Held>,
    /// The first thing that went wrong; recording calls give nothing back, `run` and `finish` do.
    pub(super) failure: Option<Error>,
    /// Off only in the test that shows what synchronization validation says without barriers.
    barriers: bool,
}

/// Keeps the resources of recorded passes alive. An embedder drops it when the device is done with its submission.
#[must_use = "the resources must outlive the submission"]
pub struct InUse {
    _held: Vec<Held>,
}

impl Recorder {
    pub(super) fn over(
        context: &Context,
        commands: vk::CommandBuffer,
        name: &str,
        own: Option<OwnCommands>,
    ) -> Self {
        Recorder {
            context: context.clone(),
            commands,
            name: name.to_owned(),
            own,
            passes: Vec::new(),
            held: Vec::new(),
            failure: None,
            barriers: true,
        }
    }

    /// A recorder over an embedder's command buffer. It only records: nothing is submitted, waited for or timed.
    ///
    /// # Safety
    /// `commands` was made from this context's device and is being recorded, outside a render pass, on a family with the
    /// required queue flags, until [`Recorder::finish`].
    pub unsafe fn foreign(context: &Context, commands: vk::CommandBuffer) -> Self {
        Recorder::over(context, commands, "foreign", None)
    }

    /// Ends recording into a foreign command buffer; what comes back must live until the device has executed it.
    pub fn finish(mut self) -> Result<InUse> {
        match self.failure.take() {
            Some(failure) => Err(failure),
            None => Ok(InUse {
                _held: std::mem::take(&mut self.held),
            }),
        }
    }

    /// A compute pass of `groups` workgroups.
    pub fn dispatch<S: ComputeShader>(
        &mut self,
        bound: &Bound<S>,
        push: &S::Push,
        groups: [u32; 3],
    ) {
        let most = self.context.info().limits.workgroups;
        if let Some(axis) = (0..3).find(|axis| groups[*axis] > most[*axis]) {
            let what = format!("workgroups of {} along axis {axis}", S::NAME);
            return self.fail(Error::Capacity {
                what,
                need: groups[axis].into(),
                have: most[axis].into(),
            });
        }
        self.hold_set(bound);
        self.pass(S::NAME, |recorder| {
            recorder.bind(bound, push);
            // SAFETY: recording; the pipeline and its set are bound; the counts are within the limits.
            unsafe {
                recorder
                    .device()
                    .cmd_dispatch(recorder.commands, groups[0], groups[1], groups[2])
            };
        });
    }

    /// A compute pass whose three workgroup counts are read from `counts` at byte `offset` (a multiple of 4).
    pub fn dispatch_indirect<S: ComputeShader>(
        &mut self,
        bound: &Bound<S>,
        push: &S::Push,
        counts: &Buffer,
        offset: u64,
    ) {
        if !offset.is_multiple_of(4) || offset.saturating_add(12) > counts.bytes() {
            let what = format!(
                "bytes of indirect counts of {} in \"{}\"",
                S::NAME,
                counts.name()
            );
            return self.fail(Error::Capacity {
                what,
                need: offset.saturating_add(12),
                have: counts.bytes(),
            });
        }
        self.hold(Held::Buffer(counts.clone()));
        self.hold_set(bound);
        self.pass(S::NAME, |recorder| {
            recorder.bind(bound, push);
            // SAFETY: recording; the pipeline and its set are bound; the counts lie inside the buffer.
            unsafe {
                recorder
                    .device()
                    .cmd_dispatch_indirect(recorder.commands, counts.handle(), offset)
            };
        });
    }

    /// Fills a buffer with a word.
    pub fn fill(&mut self, buffer: &Buffer, word: u32) {
        self.hold(Held::Buffer(buffer.clone()));
        self.pass(&format!("fill {}", buffer.name()), |recorder| {
            // SAFETY: recording; offset 0 and the whole size are always allowed.
            unsafe {
                recorder.device().cmd_fill_buffer(
                    recorder.commands,
                    buffer.handle(),
                    0,
                    vk::WHOLE_SIZE,
                    word,
                )
            };
        });
    }

    /// Copies the first bytes of `from` to the start of `to`: as many as the smaller one holds.
    pub fn copy(&mut self, from: &Buffer, to: &Buffer) {
        self.copy_range(from, 0, to, 0, from.bytes().min(to.bytes()));
    }

    /// Copies `bytes` bytes.
    pub fn copy_range(
        &mut self,
        from: &Buffer,
        from_byte: u64,
        to: &Buffer,
        to_byte: u64,
        bytes: u64,
    ) {
        let ends = [
            (from, from_byte.saturating_add(bytes)),
            (to, to_byte.saturating_add(bytes)),
        ];
        if let Some((buffer, end)) = ends.into_iter().find(|(buffer, end)| *end > buffer.bytes()) {
            let what = format!("bytes of buffer \"{}\" in a copy", buffer.name());
            return self.fail(Error::Capacity {
                what,
                need: end,
                have: buffer.bytes(),
            });
        }
        if bytes == 0 {
            return;
        }
        self.hold(Held::Buffer(from.clone()));
        self.hold(Held::Buffer(to.clone()));
        self.pass(
            &format!("copy {} to {}", from.name(), to.name()),
            |recorder| {
                let regions = [vk::BufferCopy {
                    src_offset: from_byte,
                    dst_offset: to_byte,
                    size: bytes,
                }];
                // SAFETY: recording; the ranges lie inside both buffers.
                unsafe {
                    recorder.device().cmd_copy_buffer(
                        recorder.commands,
                        from.handle(),
                        to.handle(),
                        &regions,
                    )
                };
            },
        );
    }

    /// The one way a pass is recorded: label, barrier, commands, stamp.
    pub(super) fn pass(&mut self, name: &str, record: impl FnOnce(&Recorder)) {
        // SAFETY: the command buffer is being recorded; the label closes below.
        unsafe { self.context.0.labels.begin(self.commands, name) };
        if self.barriers {
            self.barrier(
                vk::PipelineStageFlags2::ALL_COMMANDS,
                vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE,
            );
        }
        record(self);
        // SAFETY: as above.
        unsafe { self.context.0.labels.end(self.commands) };
        self.passes.push(name.to_owned());
        self.stamp();
    }

    /// Binds the pipeline and its set and pushes the constants.
    pub(super) fn bind<S: ShaderInterface>(&self, bound: &Bound<S>, push: &S::Push) {
        let (device, pipeline) = (self.device(), &bound.0.pipeline);
        // SAFETY: recording; the handles are of this device and live as long as the recorder holds them.
        unsafe {
            device.cmd_bind_pipeline(self.commands, pipeline.bind_point, pipeline.pipeline);
            let sets = [bound.0.set];
            device.cmd_bind_descriptor_sets(
                self.commands,
                pipeline.bind_point,
                pipeline.layout,
                0,
                &sets,
                &[],
            );
            if !pipeline.push_stages.is_empty() {
                let bytes = bytemuck::bytes_of(push);
                device.cmd_push_constants(
                    self.commands,
                    pipeline.layout,
                    pipeline.push_stages,
                    0,
                    bytes,
                );
            }
        }
    }

    /// Everything before is done and visible to `stages` and `accesses` after.
    fn barrier(&self, stages: vk::PipelineStageFlags2, accesses: vk::AccessFlags2) {
        let barriers = [vk::MemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .src_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
            .dst_stage_mask(stages)
            .dst_access_mask(accesses)];
        let dependency = vk::DependencyInfo::default().memory_barriers(&barriers);
        // SAFETY: recording, outside a render pass.
        unsafe {
            self.device()
                .cmd_pipeline_barrier2(self.commands, &dependency)
        };
    }

    pub(super) fn barrier_to_host(&self) {
        self.barrier(vk::PipelineStageFlags2::HOST, vk::AccessFlags2::HOST_READ);
    }

    /// Takes a new image from UNDEFINED to GENERAL, where it stays.
    pub(super) fn initialise(&mut self, image: &Image) {
        self.hold(Held::Image(image.clone()));
        let range = vk::ImageSubresourceRange::default()
            .aspect_mask(image.aspect())
            .level_count(vk::REMAINING_MIP_LEVELS)
            .layer_count(vk::REMAINING_ARRAY_LAYERS);
        let barriers = [vk::ImageMemoryBarrier2::default()
            .src_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .dst_stage_mask(vk::PipelineStageFlags2::ALL_COMMANDS)
            .dst_access_mask(vk::AccessFlags2::MEMORY_READ | vk::AccessFlags2::MEMORY_WRITE)
            .old_layout(vk::ImageLayout::UNDEFINED)
            .new_layout(vk::ImageLayout::GENERAL)
            .src_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .dst_queue_family_index(vk::QUEUE_FAMILY_IGNORED)
            .image(image.handle())
            .subresource_range(range)];
        let dependency = vk::DependencyInfo::default().image_memory_barriers(&barriers);
        // SAFETY: recording, outside a render pass; the image is new, so nothing else uses it.
        unsafe {
            self.device()
                .cmd_pipeline_barrier2(self.commands, &dependency)
        };
    }

    pub(super) fn hold(&mut self, held: Held) {
        self.held.push(held);
    }

    pub(super) fn hold_set<S: ShaderInterface>(&mut self, bound: &Bound<S>) {
        assert!(
            bound.0.context().same(&self.context),
            "{} is bound in another context",
            S::NAME
        );
        self.held.push(Held::Set(bound.0.clone()));
    }

    pub(super) fn fail(&mut self, error: Error) {
        self.failure.get_or_insert(error);
    }

    pub(super) fn device(&self) -> &ash::Device {
        &self.context.0.device
    }

    pub(super) fn stamp(&mut self) {
        let Some(own) = &mut self.own else { return };
        // SAFETY: the own command buffer is being recorded, and passes end outside render passes.
        if let Err(error) = unsafe { own.stamps.write(self.commands) } {
            self.fail(error);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::gpu::shaders::test_add::{Bindings, Push, Shader};
    use crate::gpu::{Context, ContextOptions, DeviceChoice, devices};

    /// Two passes, the second of which reads what the first wrote; what validation says of them.
    fn messages_of_dependent_passes(device: usize, barriers: bool) -> Vec<String> {
        let options = ContextOptions {
            device: DeviceChoice::Index(device),
            validation: true,
        };
        let ctx = Context::new(&options).unwrap();
        let one = ctx.upload("one", &[1_u32; 64]).unwrap();
        let (x, y) = (
            ctx.storage("x", 256).unwrap(),
            ctx.storage("y", 256).unwrap(),
        );
        let pipeline = ctx.compute::<Shader>().unwrap();
        let first = pipeline
            .bind(&Bindings {
                a: &one,
                b: &one,
                sum: &x,
            })
            .unwrap();
        let second = pipeline
            .bind(&Bindings {
                a: &x,
                b: &one,
                sum: &y,
            })
            .unwrap();
        let mut recorder = ctx.recorder("dependent passes").unwrap();
        recorder.barriers = barriers;
        recorder.dispatch(
            &first,
            &Push {
                count: 64,
                offset: 0,
            },
            [1, 1, 1],
        );
        recorder.dispatch(
            &second,
            &Push {
                count: 64,
                offset: 0,
            },
            [1, 1, 1],
        );
        ctx.run(recorder).unwrap();
        ctx.validation_messages()
    }

    #[test]
    fn synchronization_validation_sees_a_missing_barrier() {
        for device in devices().unwrap().iter().filter(|device| device.usable) {
            assert_eq!(
                messages_of_dependent_passes(device.index, true),
                Vec::<String>::new(),
                "{}",
                device.name
            );
            let messages = messages_of_dependent_passes(device.index, false);
            let hazard = messages.iter().any(|message| {
                message.contains("SYNC-HAZARD-READ-AFTER-WRITE")
                    || message.contains("SYNC-HAZARD-READ_AFTER_WRITE")
            });
            assert!(hazard, "{}: {messages:?}", device.name);
        }
    }
}
