//! Exclusive prefix sums of a buffer of words, in place. Shaders: `glsl/igt/scan_*.comp`.

use crate::error::Result;
use crate::gpu::{Buffer, Context, Recorder, shaders};

/// Words of a block: one workgroup's share.
const BLOCK: u64 = 4096;

/// Records the scan of the first `count` words of `values`.
pub(super) fn record(
    context: &Context,
    recorder: &mut Recorder,
    values: &Buffer,
    count: u64,
) -> Result<()> {
    let blocks = count.div_ceil(BLOCK);
    let groups = super::groups(blocks, 1);
    // Workgroups beyond the last block (the grid is two-dimensional) may write a sum of zero.
    let sums = context.storage(
        "block sums",
        u64::from(groups[0]) * u64::from(groups[1]) * 4,
    )?;
    let count = count as u32;
    use shaders::{igt_scan_add as add, igt_scan_block as block, igt_scan_spine as spine};
    let bound = context.compute::<block::Shader>()?.bind(&block::Bindings {
        values,
        sums: &sums,
    })?;
    recorder.dispatch(&bound, &block::Push { count }, groups);
    let bound = context
        .compute::<spine::Shader>()?
        .bind(&spine::Bindings { sums: &sums })?;
    recorder.dispatch(
        &bound,
        &spine::Push {
            count: blocks as u32,
        },
        [1, 1, 1],
    );
    let bound = context.compute::<add::Shader>()?.bind(&add::Bindings {
        values,
        sums: &sums,
    })?;
    recorder.dispatch(&bound, &add::Push { count }, groups);
    Ok(())
}
