//! Lookups on a device, one thread a point. Shader: `glsl/igt/query.comp`; twin of [`Tables::lookup`].

use super::super::{Asker, Found, Tables};
use crate::error::Result;
use crate::gpu::{Context, shaders::igt_query as pass};

/// [`Tables::lookup`] for many points on a device; the answers are the same, bit for bit.
pub fn query(
    context: &Context,
    tables: &Tables,
    points: &[[i32; 3]],
    asker: impl Into<Asker>,
    nearest: bool,
) -> Result<Vec<Option<Found>>> {
    if points.is_empty() {
        return Ok(Vec::new());
    }
    let asker = asker.into().word();
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
            tables: super::shader_tables(tables),
            count: block.len() as u32,
            asker,
            nearest: nearest.into(),
        };
        recorder.dispatch(&bound, &push, super::groups(block.len() as u64, 64));
        context.run(recorder)?;
        let words: Vec<[u32; 8]> = context.download(&found)?;
        answers.extend(words[..block.len()].iter().map(|w| {
            (w[0] != u32::MAX).then(|| Found {
                triangle: w[0],
                barycentric: [
                    f32::from_bits(w[1]),
                    f32::from_bits(w[2]),
                    f32::from_bits(w[3]),
                ],
                fetches: w[4],
                hit: w[5] != 0,
            })
        }));
    }
    Ok(answers)
}
