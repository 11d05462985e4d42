//! Lookups on a device, one thread a point. Shader: `glsl/igt/query.comp`; twin of [`Tables::lookup_with_cost`].

use super::super::{Asker, Cost, Found, Tables};
use crate::error::Result;
use crate::gpu::{Context, shaders::igt_query as pass};

/// [`Tables::lookup_with_cost`] for many points on a device; the answers are the same, bit for bit.
pub fn query(
    context: &Context,
    tables: &Tables,
    points: &[[i32; 3]],
    asker: impl Into<Asker>,
    nearest: bool,
) -> Result<Vec<(Option<Found>, Cost)>> {
    if points.is_empty() {
        return Ok(Vec::new());
    }
    let asker = asker.into().word();
    let [line, how, bits, entries, at, size] = tables.shader_words();
    let hash = context.upload("igt hash", &tables.hash)?;
    let list = context.upload("igt lists", &tables.list)?;
    let triangle = context.upload("igt triangles", &tables.triangle)?;
    // Points go in blocks so that no buffer outgrows a device's storage range.
    let mut answers = Vec::with_capacity(points.len());
    for block in points.chunks(1 << 20) {
        let four: Vec<[i32; 4]> = block.iter().map(|p| [p[0], p[1], p[2], 0]).collect();
        let points = context.upload("query points", &four)?;
        let found = context.storage("answers", block.len() as u64 * 32)?;
        let bindings = pass::Bindings {
            hash: &hash,
            list: &list,
            triangle: &triangle,
            points: &points,
            found: &found,
        };
        let bound = context.compute::<pass::Shader>()?.bind(&bindings)?;
        let mut recorder = context.recorder("query")?;
        let push = pass::Push {
            tables: [line, how, bits, entries],
            window: [at, size],
            count: block.len() as u32,
            asker,
            nearest: nearest.into(),
        };
        recorder.dispatch(&bound, &push, super::groups(block.len() as u64, 64));
        context.run(recorder)?;
        let words: Vec<[u32; 8]> = context.download(&found)?;
        answers.extend(words[..block.len()].iter().map(answer));
    }
    Ok(answers)
}

/// An answer of the shader.
fn answer(words: &[u32; 8]) -> (Option<Found>, Cost) {
    let cost = Cost {
        fetches: words[4],
        tests: words[6],
    };
    let found = (words[0] != u32::MAX).then(|| Found {
        triangle: words[0],
        barycentric: [words[1], words[2], words[3]].map(f32::from_bits),
        fetches: cost.fetches,
        hit: words[5] != 0,
    });
    (found, cost)
}
