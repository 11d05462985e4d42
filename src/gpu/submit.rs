//! Submission. In: a recorder whose passes are recorded. Out: the work done, and the time each pass took. The only place
//! where this crate submits or waits; only our own command buffers come here.

use super::context::Context;
use super::failure;
use super::recorder::Recorder;
use super::timing::{Stamps, Timings};
use crate::{Error, Result};
use ash::vk;

/// A command buffer of our own, with the pool it came from and its time stamps.
pub(super) struct OwnCommands {
    context: Context,
    pool: vk::CommandPool,
    pub(super) stamps: Stamps,
}

impl Context {
    /// A recorder with a command buffer of its own, for [`Context::run`].
    pub fn recorder(&self, name: &str) -> Result<Recorder> {
        let device = &self.0.device;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(self.0.queue_family)
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the family is the device's.
        let pool = unsafe { device.create_command_pool(&info, None) }
            .map_err(failure::of("vkCreateCommandPool"))?;
        // From here on the pool destroys itself when something fails.
        let own = OwnCommands {
            context: self.clone(),
            pool,
            stamps: Stamps::new(self),
        };
        let info = vk::CommandBufferAllocateInfo::default()
            .command_pool(pool)
            .command_buffer_count(1);
        let begin = vk::CommandBufferBeginInfo::default()
            .flags(vk::CommandBufferUsageFlags::ONE_TIME_SUBMIT);
        // SAFETY: the pool was just made and is used by this recorder alone.
        let commands = unsafe { device.allocate_command_buffers(&info) }
            .map_err(failure::of("vkAllocateCommandBuffers"))?[0];
        // SAFETY: the command buffer was just made.
        unsafe { device.begin_command_buffer(commands, &begin) }
            .map_err(failure::of("vkBeginCommandBuffer"))?;
        let mut recorder = Recorder::over(self, commands, name, Some(own));
        recorder.stamp();
        Ok(recorder)
    }

    /// Submits what was recorded, waits for it, and says how long each pass took.
    ///
    /// [`Error::DeviceLost`] names the recorder; an error of a recording call comes out here.
    pub fn run(&self, mut recorder: Recorder) -> Result<Timings> {
        assert!(
            recorder.context.same(self),
            "{}: recorded for another context",
            recorder.name
        );
        if let Some(failure) = recorder.failure.take() {
            return Err(failure);
        }
        let Some(own) = &recorder.own else {
            panic!(
                "{}: a foreign command buffer is submitted by its owner",
                recorder.name
            );
        };
        let device = &self.0.device;
        recorder.barrier_to_host();
        // SAFETY: recording is over; every pass closed what it opened.
        unsafe { device.end_command_buffer(recorder.commands) }
            .map_err(failure::of("vkEndCommandBuffer"))?;
        // SAFETY: a plain fence.
        let fence = unsafe { device.create_fence(&vk::FenceCreateInfo::default(), None) }
            .map_err(failure::of("vkCreateFence"))?;
        let done = self.submit_and_wait(recorder.commands, fence);
        // SAFETY: the wait is over, by success or by the loss of the device.
        unsafe { device.destroy_fence(fence, None) };
        done.map_err(|error| match error {
            Error::DeviceLost { .. } => Error::DeviceLost {
                during: recorder.name.clone(),
            },
            other => other,
        })?;
        own.stamps.read(&recorder.passes)
    }

    fn submit_and_wait(&self, commands: vk::CommandBuffer, fence: vk::Fence) -> Result<()> {
        let device = &self.0.device;
        let buffers = [vk::CommandBufferSubmitInfo::default().command_buffer(commands)];
        let submits = [vk::SubmitInfo2::default().command_buffer_infos(&buffers)];
        {
            let queue = self.queue();
            // SAFETY: the lock keeps our other threads from the queue; the command buffer is complete.
            unsafe { device.queue_submit2(*queue, &submits, fence) }
                .map_err(failure::of("vkQueueSubmit2"))?;
        }
        // SAFETY: the fence was submitted.
        unsafe { device.wait_for_fences(&[fence], true, u64::MAX) }
            .map_err(failure::of("vkWaitForFences"))
    }
}

impl Drop for OwnCommands {
    fn drop(&mut self) {
        // SAFETY: what was submitted has been waited for; the pool frees its command buffer.
        unsafe { self.context.0.device.destroy_command_pool(self.pool, None) };
    }
}
