//! The same lookups again and again, for their time alone. Shader: `glsl/igt/query.comp`.

use super::super::{Asker, Tables};
use crate::error::Result;
use crate::gpu::{Context, Timings, shaders::igt_query as pass};

/// Points of one dispatch.
const BLOCK: usize = 1 << 20;

/// Looks `points` up again and again, nothing but the lookups in a frame; each frame's times go to `more`, until it says
/// no. The answers stay on the device.
pub fn repeat(
    context: &Context,
    tables: &Tables,
    points: &[[i32; 3]],
    asker: impl Into<Asker>,
    mut more: impl FnMut(Timings) -> bool,
) -> Result<()> {
    let asker = asker.into().word();
    let [line, how, bits, entries, at, size] = tables.shader_words();
    let hash = context.upload("igt hash", &tables.hash)?;
    let list = context.upload("igt lists", &tables.list)?;
    let triangle = context.upload("igt triangles", &tables.triangle)?;
    let found = context.storage("answers", points.len().clamp(1, BLOCK) as u64 * 32)?;
    let pipeline = context.compute::<pass::Shader>()?;
    let mut blocks = Vec::new();
    for block in points.chunks(BLOCK) {
        let four: Vec<[i32; 4]> = block.iter().map(|p| [p[0], p[1], p[2], 0]).collect();
        let bound = pipeline.bind(&pass::Bindings {
            hash: &hash,
            list: &list,
            triangle: &triangle,
            points: &context.upload("query points", &four)?,
            found: &found,
        })?;
        let push = pass::Push {
            tables: [line, how, bits, entries],
            window: [at, size],
            count: block.len() as u32,
            asker,
            nearest: true.into(),
        };
        blocks.push((bound, push));
    }
    loop {
        let mut recorder = context.recorder("lookups")?;
        for (bound, push) in &blocks {
            recorder.dispatch(bound, push, super::groups(push.count.into(), 64));
        }
        if !more(context.run(recorder)?) {
            return Ok(());
        }
    }
}
