//! Tables in pages: for devices whose storage buffers are shorter than a table.
//!
//! In: tables, the size of a page. Out: [`Pages`], up to [`MOST`] buffers a table for `glsl/igt/query_paged.comp`, which
//! picks one by branches (`glsl/common/igt_pages.glsl`): descriptors are never indexed. Pages are a power of two long, so a
//! place is a page's number and a place in it; tables that fit one buffer need none of this, nor pay for it.

use super::super::Tables;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Context};

/// The most pages of a table.
pub(super) const MOST: usize = 4;
/// The least page: 64 words.
pub(super) const LEAST_BITS: u32 = 8;

/// A table's pages; those that it does not need are its first.
pub(super) type Pages = [Buffer; MOST];

/// Hash, lists and triangles in pages of `2^page_bits` bytes.
pub(super) fn upload(context: &Context, tables: &Tables, page_bits: u32) -> Result<[Pages; 3]> {
    let pages = |name: &str, words: &[u32]| -> Result<Pages> {
        let size = 1usize << (page_bits - 2);
        let count = words.len().div_ceil(size);
        if count > MOST {
            return Err(Error::Capacity {
                what: format!("bytes of {name} in {MOST} storage buffers"),
                need: words.len() as u64 * 4,
                have: (MOST * size * 4) as u64,
            });
        }
        let first = context.upload(name, &words[..size.min(words.len())])?;
        let mut pages = [0; MOST].map(|_| first.clone());
        for (page, words) in pages.iter_mut().zip(words.chunks(size)).skip(1) {
            *page = context.upload(name, words)?;
        }
        Ok(pages)
    };
    Ok([
        pages("igt hash", &tables.hash)?,
        pages("igt lists", &tables.list)?,
        pages("igt triangles", &tables.triangle)?,
    ])
}

/// log2 of the largest page that the device's storage buffers hold; none where the tables need no pages.
pub(super) fn bits(context: &Context, tables: &Tables) -> Option<u32> {
    let room = context.info().limits.storage_buffer_bytes;
    let fits = tables.bytes().iter().all(|bytes| *bytes <= room);
    (!fits).then(|| room.max(1).ilog2().min(31))
}
