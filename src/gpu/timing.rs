//! How long passes took on the device. In: a time stamp before the first pass and after each. Out: [`Timings`].
//!
//! Stamps stand between passes: inside a render pass they mean nothing on some drivers.

use super::context::Context;
use super::failure;
use crate::Result;
use ash::vk;

/// The device time of every pass of a recorder, in the order recorded.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Timings {
    /// One entry per pass.
    pub passes: Vec<PassTime>,
    /// From before the first pass to after the last, in nanoseconds.
    pub total: u64,
}

/// The device time of a pass.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PassTime {
    /// Name of the pass.
    pub name: String,
    /// Its duration with the barrier before it; 0 on a queue without time stamps.
    pub nanoseconds: u64,
}

/// Stamps in one query pool.
const STAMPS_PER_POOL: u32 = 128;

/// The time stamps of one recorder: pools are added as passes come.
pub(super) struct Stamps {
    context: Context,
    pools: Vec<vk::QueryPool>,
    written: u32,
}

impl Stamps {
    pub(super) fn new(context: &Context) -> Self {
        Stamps {
            context: context.clone(),
            pools: Vec::new(),
            written: 0,
        }
    }

    /// Records a stamp after everything recorded so far.
    ///
    /// # Safety
    /// `commands` is being recorded outside a render pass, on this context.
    pub(super) unsafe fn write(&mut self, commands: vk::CommandBuffer) -> Result<()> {
        if self.context.info().limits.timestamp_bits == 0 {
            return Ok(());
        }
        let device = &self.context.0.device;
        let at = self.written % STAMPS_PER_POOL;
        if at == 0 {
            let info = vk::QueryPoolCreateInfo::default()
                .query_type(vk::QueryType::TIMESTAMP)
                .query_count(STAMPS_PER_POOL);
            // SAFETY: the queue has time stamps.
            let pool = unsafe { device.create_query_pool(&info, None) }
                .map_err(failure::of("vkCreateQueryPool"))?;
            self.pools.push(pool);
            // SAFETY: the caller's promise; the pool was just made.
            unsafe { device.cmd_reset_query_pool(commands, pool, 0, STAMPS_PER_POOL) };
        }
        if let Some(pool) = self.pools.last() {
            // SAFETY: the caller's promise; query `at` was reset above or with its pool.
            unsafe {
                device.cmd_write_timestamp2(
                    commands,
                    vk::PipelineStageFlags2::ALL_COMMANDS,
                    *pool,
                    at,
                )
            };
            self.written += 1;
        }
        Ok(())
    }

    /// The durations between stamps, after the work has finished.
    pub(super) fn read(&self, names: &[String]) -> Result<Timings> {
        let mut ticks = Vec::with_capacity(self.written as usize);
        for pool in &self.pools {
            let left = self.written - ticks.len() as u32;
            let mut part = vec![0_u64; left.min(STAMPS_PER_POOL) as usize];
            let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
            // SAFETY: these queries were written by work that has finished.
            unsafe {
                self.context
                    .0
                    .device
                    .get_query_pool_results(*pool, 0, &mut part, flags)
            }
            .map_err(failure::of("vkGetQueryPoolResults"))?;
            ticks.extend(part);
        }
        let limits = &self.context.info().limits;
        let elapsed = |from: usize, to: usize| match (ticks.get(from), ticks.get(to)) {
            (Some(from), Some(to)) => nanoseconds(
                *from,
                *to,
                limits.timestamp_bits,
                limits.timestamp_nanoseconds,
            ),
            _ => 0,
        };
        let total = elapsed(0, names.len());
        let timed = names.iter().enumerate();
        let passes = timed
            .map(|(at, name)| PassTime {
                name: name.clone(),
                nanoseconds: elapsed(at, at + 1),
            })
            .collect();
        Ok(Timings { passes, total })
    }
}

impl Drop for Stamps {
    fn drop(&mut self) {
        for pool in self.pools.drain(..) {
            // SAFETY: the work that wrote to the pool has finished or was never submitted.
            unsafe { self.context.0.device.destroy_query_pool(pool, None) };
        }
    }
}

/// Counters of `bits` bits wrap around.
fn nanoseconds(from: u64, to: u64, bits: u32, period: f32) -> u64 {
    let mask = if bits >= 64 {
        u64::MAX
    } else {
        (1 << bits) - 1
    };
    let ticks = to.wrapping_sub(from) & mask;
    (ticks as f64 * f64::from(period)).round() as u64
}

#[cfg(test)]
mod tests {
    use super::nanoseconds;

    #[test]
    fn counters_wrap_at_their_width() {
        assert_eq!(nanoseconds(10, 30, 64, 1.0), 20);
        assert_eq!(nanoseconds(u64::MAX, 1, 64, 1.0), 2);
        assert_eq!(
            nanoseconds((1 << 36) - 1, 4, 36, 0.5),
            3,
            "5 ticks of half a nanosecond, rounded"
        );
        assert_ne!(
            nanoseconds((1 << 36) - 1, 4, 40, 0.5),
            3,
            "another width is another distance"
        );
    }
}
