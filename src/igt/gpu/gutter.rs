//! The gutter on a device. Shaders: `glsl/igt/missing.comp`, `gutter.comp`; twin of [`gutter`](super::super::gutter).

use super::super::gutter::{Found, Gutter, Needs, REACH};
use super::build::{Raw, Work};
use super::groups;
use crate::error::Result;
use crate::gpu::{Buffer, shaders};

/// Pairs asked at a time, so that no buffer outgrows a device's storage range.
const BLOCK: usize = 1 << 20;

/// Searches for every needed pair.
pub(super) fn fill(work: &mut Work<'_>, raw: &Raw, needs: &Needs) -> Result<Gutter> {
    let mut found = Vec::new();
    for block in needs.pairs.chunks(BLOCK) {
        let pairs: Vec<[u32; 2]> = block
            .iter()
            .map(|p| [(p >> 8) as u32, (p & 255) as u32])
            .collect();
        let pairs = work.context.upload("needs", &pairs)?;
        let (missing, count) = missing(work, raw, &pairs, block.len())?;
        if count > 0 {
            let mut some = search(work, raw, &pairs, &missing, count)?;
            some.sort_unstable_by_key(|(n, _)| *n);
            found.extend(some.into_iter().map(|(n, one)| (block[n as usize], one)));
        }
    }
    Ok(Gutter::from_found(found.into_iter()))
}

/// The pairs whose texel has no triangle of the layer, behind their number.
fn missing(work: &mut Work<'_>, raw: &Raw, needs: &Buffer, count: usize) -> Result<(Buffer, u32)> {
    use shaders::igt_missing as pass;
    let context = work.context;
    let missing = context.storage("missing", (count as u64 + 1) * 4)?;
    let number = context.storage("number of missing", 4)?;
    let bound = context.compute::<pass::Shader>()?.bind(&pass::Bindings {
        starts: &raw.starts,
        lengths: &raw.lengths,
        lists: &raw.lists,
        layers: &raw.layers,
        masks: &raw.masks,
        needs,
        missing: &missing,
    })?;
    let mut recorder = context.recorder("igt missing")?;
    recorder.fill(&missing, 0);
    let push = pass::Push {
        count: count as u32,
    };
    recorder.dispatch(&bound, &push, groups(count as u64, 64));
    recorder.copy(&missing, &number);
    work.run(recorder)?;
    Ok((missing, context.download::<u32>(&number)?[0]))
}

/// What is found for the missing pairs, with their places among the pairs.
fn search(
    work: &mut Work<'_>,
    raw: &Raw,
    needs: &Buffer,
    missing: &Buffer,
    count: u32,
) -> Result<Vec<(u32, Found)>> {
    use shaders::igt_gutter as pass;
    let context = work.context;
    let answers = context.storage("gutter answers", u64::from(count) * 44)?;
    let pipeline = work.compute_for_line::<pass::Shader>(pass::LINE)?;
    let bound = pipeline.bind(&pass::Bindings {
        starts: &raw.starts,
        lengths: &raw.lengths,
        lists: &raw.lists,
        layers: &raw.layers,
        masks: &raw.masks,
        needs,
        missing,
        answers: &answers,
    })?;
    let mut recorder = context.recorder("igt gutter")?;
    let push = pass::Push {
        bits: work.bits,
        count,
        reach: REACH.min(1 << work.bits),
    };
    recorder.dispatch(&bound, &push, groups(count.into(), 64));
    work.run(recorder)?;
    let words: Vec<[u32; 11]> = context.download(&answers)?;
    let found = |w: &[u32; 11]| Found {
        ring: w[1],
        count: w[2],
        triangles: std::array::from_fn(|i| w[3 + i]),
    };
    Ok(words.iter().map(|w| (w[0], found(w))).collect())
}
