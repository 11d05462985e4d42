//! Lookups in tables that are longer than a storage buffer. Shader: `glsl/igt/query_paged.comp`; see [`pages`].

use super::super::{Asker, Cost, Found, Tables};
use super::pages;
use super::query::{BLOCK, answer};
use crate::error::Result;
use crate::gpu::{Context, shaders::igt_query_paged as pass};

/// [`query`](super::query) with the tables in pages of `2^page_bits` bytes, 256 at least: what a device with storage buffers
/// that short would do.
///
/// # Errors
/// [`Error::Capacity`](crate::Error::Capacity) where four pages do not hold a table; those of the device.
pub fn query_in_pages(
    context: &Context,
    tables: &Tables,
    points: &[[i32; 3]],
    asker: impl Into<Asker>,
    nearest: bool,
    page_bits: u32,
) -> Result<Vec<(Option<Found>, Cost)>> {
    if points.is_empty() {
        return Ok(Vec::new());
    }
    let page_bits = page_bits.max(pages::LEAST_BITS);
    let [hash, list, triangle] = pages::upload(context, tables, page_bits)?;
    let [known_line, known_layout, known_record] = Tables::known([tables].into_iter()).words();
    let pipeline = context.compute_with::<pass::Shader>(&[
        (pass::KNOWN_LINE, known_line),
        (pass::KNOWN_LAYOUT, known_layout),
        (pass::KNOWN_RECORD, known_record),
        (pass::IGT_PAGE_BITS, page_bits),
    ])?;
    let [line, how, bits, entries, at, size] = tables.shader_words();
    let asker = asker.into().word();
    let mut answers = Vec::with_capacity(points.len());
    for block in points.chunks(BLOCK) {
        let four: Vec<[i32; 4]> = block.iter().map(|p| [p[0], p[1], p[2], 0]).collect();
        let points = context.upload("query points", &four)?;
        let found = context.storage("answers", block.len() as u64 * 32)?;
        let bound = pipeline.bind(&pass::Bindings {
            igt_hash_0: &hash[0],
            igt_hash_1: &hash[1],
            igt_hash_2: &hash[2],
            igt_hash_3: &hash[3],
            igt_list_0: &list[0],
            igt_list_1: &list[1],
            igt_list_2: &list[2],
            igt_list_3: &list[3],
            igt_triangle_0: &triangle[0],
            igt_triangle_1: &triangle[1],
            igt_triangle_2: &triangle[2],
            igt_triangle_3: &triangle[3],
            points: &points,
            found: &found,
        })?;
        let push = pass::Push {
            tables: [line, how, bits, entries],
            window: [at, size],
            count: block.len() as u32,
            asker,
            nearest: nearest.into(),
        };
        let mut recorder = context.recorder("query in pages")?;
        recorder.dispatch(&bound, &push, super::groups(block.len() as u64, 64));
        context.run(recorder)?;
        let words: Vec<[u32; 8]> = context.download(&found)?;
        answers.extend(words[..block.len()].iter().map(answer));
    }
    Ok(answers)
}
