//! A computed map to T3, in the file: places of vertices, copies, corners that name them.
//!
//! In: a mesh that is cut open. Out: words for buffer views. And back, from words of any origin: the mesh as the file's
//! original has it, cut open, or the reason why not. The third coordinate is left out where all of them are zero.

use crate::mesh::{Embedding, Mesh};
use serde::{Deserialize, Serialize};

/// Buffer views of little-endian 32-bit words.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EmbeddingExtension {
    /// Floats, `width` for each vertex, copies included.
    pub(super) places: usize,
    /// 2 (the third is zero) or 3.
    pub(super) width: u32,
    /// For each copy its vertex.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) copies: Option<usize>,
    /// Pairs: a corner and the copy it names.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) moved: Option<usize>,
}

/// The extension of `embedding`; `view` appends words and says in which view they are. None for a mesh without places.
pub(super) fn write(
    embedding: &Embedding,
    mut view: impl FnMut(&[u32]) -> Option<usize>,
) -> Option<EmbeddingExtension> {
    let flat = embedding.t3.iter().all(|p| p[2].to_bits() == 0);
    let width = if flat { 2 } else { 3 };
    let places: Vec<u32> = embedding
        .t3
        .iter()
        .flat_map(|p| p.map(f32::to_bits).into_iter().take(width))
        .collect();
    Some(EmbeddingExtension {
        places: view(&places)?,
        width: width as u32,
        copies: view(&embedding.copies),
        moved: view(embedding.moved.as_flattened()),
    })
}

/// `mesh` cut open as `extension` says; `words` reads a view.
pub(super) fn read<E>(
    extension: &EmbeddingExtension,
    mesh: &Mesh,
    words: impl Fn(Option<usize>) -> Result<Vec<u32>, E>,
) -> Result<Result<Mesh, String>, E> {
    let places = words(Some(extension.places))?;
    let (copies, moved) = (words(extension.copies)?, words(extension.moved)?);
    let width = extension.width as usize;
    if !(2..=3).contains(&width)
        || !places.len().is_multiple_of(width)
        || !moved.len().is_multiple_of(2)
    {
        return Ok(Err(format!(
            "{} numbers are no places of {width}",
            places.len()
        )));
    }
    let place = |p: &[u32]| [0, 1, 2].map(|k| p.get(k).map_or(0.0, |bits| f32::from_bits(*bits)));
    let embedding = Embedding {
        t3: places.chunks_exact(width).map(place).collect(),
        copies,
        moved: moved.as_chunks::<2>().0.to_vec(),
    };
    Ok(match embedding.fault(mesh) {
        Some(reason) => Err(reason),
        None => Ok(embedding.cut_open(mesh)),
    })
}
