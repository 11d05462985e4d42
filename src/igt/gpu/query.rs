//! Lookups on a device, one thread a point. Shader: `glsl/igt/query.comp`; twin of [`Tables::lookup_with_cost`].

use super::super::{Asker, Cost, Found, Tables};
use super::pages;
use super::query_paged::query_in_pages;
use crate::error::Result;
use crate::gpu::{Bound, Buffer, Context, Pipeline, Timings, shaders::igt_query as pass};

/// Points of one dispatch: no buffer outgrows a device's storage range.
pub(super) const BLOCK: usize = 1 << 20;

/// [`Tables::lookup_with_cost`] for many points on a device; the answers are the same, bit for bit. Tables beyond
/// the device's storage buffers are asked in pages.
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
    if let Some(page_bits) = pages::bits(context, tables) {
        return query_in_pages(context, tables, points, asker, nearest, page_bits);
    }
    let loaded = Loaded::new(context, tables, points.len())?;
    let asker = asker.into();
    let mut answers = Vec::with_capacity(points.len());
    for block in points.chunks(BLOCK) {
        let (bound, push) = loaded.block(block, asker, nearest)?;
        let mut recorder = context.recorder("query")?;
        recorder.dispatch(&bound, &push, super::groups(block.len() as u64, 64));
        context.run(recorder)?;
        let words: Vec<[u32; 8]> = context.download(&loaded.found)?;
        answers.extend(words[..block.len()].iter().map(answer));
    }
    Ok(answers)
}

/// Looks `points` up again and again, nothing but the lookups in a frame; each frame's times go to `more`, until it says
/// no. The answers stay on the device.
pub fn repeat(
    context: &Context,
    tables: &Tables,
    points: &[[i32; 3]],
    asker: impl Into<Asker>,
    mut more: impl FnMut(Timings) -> bool,
) -> Result<()> {
    let loaded = Loaded::new(context, tables, points.len())?;
    let asker = asker.into();
    let blocks = points.chunks(BLOCK);
    let blocks = blocks.map(|block| loaded.block(block, asker, true));
    let blocks = blocks.collect::<Result<Vec<_>>>()?;
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

/// Tables on a device, and the pipeline made for them.
struct Loaded<'a> {
    context: &'a Context,
    words: [u32; 6],
    hash: Buffer,
    list: Buffer,
    triangle: Buffer,
    /// The answers of one block.
    found: Buffer,
    pipeline: Pipeline<pass::Shader>,
}

impl<'a> Loaded<'a> {
    fn new(context: &'a Context, tables: &Tables, points: usize) -> Result<Self> {
        let [line, table_layout, record] = Tables::known([tables].into_iter()).words();
        let constants = [
            (pass::KNOWN_LINE, line),
            (pass::KNOWN_LAYOUT, table_layout),
            (pass::KNOWN_RECORD, record),
        ];
        Ok(Loaded {
            context,
            words: tables.shader_words(),
            hash: context.upload("igt hash", &tables.hash)?,
            list: context.upload("igt lists", &tables.list)?,
            triangle: context.upload("igt triangles", &tables.triangle)?,
            found: context.storage("answers", points.clamp(1, BLOCK) as u64 * 32)?,
            pipeline: context.compute_with::<pass::Shader>(&constants)?,
        })
    }

    /// A dispatch for at most [`BLOCK`] points.
    fn block(
        &self,
        points: &[[i32; 3]],
        asker: Asker,
        nearest: bool,
    ) -> Result<(Bound<pass::Shader>, pass::Push)> {
        let [line, how, bits, entries, at, size] = self.words;
        let four: Vec<[i32; 4]> = points.iter().map(|p| [p[0], p[1], p[2], 0]).collect();
        let bound = self.pipeline.bind(&pass::Bindings {
            hash: &self.hash,
            list: &self.list,
            triangle: &self.triangle,
            points: &self.context.upload("query points", &four)?,
            found: &self.found,
        })?;
        let push = pass::Push {
            tables: [line, how, bits, entries],
            window: [at, size],
            count: points.len() as u32,
            asker: asker.word(),
            nearest: nearest.into(),
        };
        Ok((bound, push))
    }
}

/// An answer of the shader.
pub(super) fn answer(words: &[u32; 8]) -> (Option<Found>, Cost) {
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
