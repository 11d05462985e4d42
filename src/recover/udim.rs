//! Tiles of texture coordinates: the unit squares that a mesh's charts lie in, each with a texture of its own.
//!
//! In: a mesh with texture coordinates. Out: its triangles by tile. Tile (u, v) has the number 1001 + u + 10 v that UDIM gives
//! it, ten tiles a row.

use crate::mesh::{Mesh, MorphTarget};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Texture coordinates may lie this far beyond a tile's border: rounding.
const ROUNDING: f32 = 1e-4;

/// The tile of a UDIM number's first row and column.
const FIRST: i64 = 1001;
/// Tiles of a row.
const ROW: i64 = 10;

/// A tile and the triangles in it.
pub(super) struct Tile {
    /// Its column and row.
    pub(super) at: [i64; 2],
    pub(super) triangles: Vec<u32>,
}

impl Tile {
    /// Its number.
    pub(super) fn number(&self) -> u32 {
        (FIRST + self.at[0] + ROW * self.at[1]) as u32
    }
}

/// The tiles of `mesh`, in the order of their numbers. `file` is what messages call its model.
///
/// # Errors
/// [`Error::Input`] for a triangle that reaches from one tile into another, and, where there are several tiles, for one that
/// has no number.
pub(super) fn tiles(file: &str, mesh: &Mesh) -> Result<Vec<Tile>> {
    let fault = |reason: String| {
        let element = format!("mesh \"{}\"", mesh.name);
        Err(Error::input(file, element, reason))
    };
    let mut all: BTreeMap<[i64; 2], Vec<u32>> = BTreeMap::new();
    let (broad, narrow): (Vec<u32>, Vec<u32>) =
        (0..mesh.triangles.len() as u32).partition(|&t| !Reach::of(mesh, t).is_narrow());
    for t in broad.into_iter().chain(narrow) {
        let reach = Reach::of(mesh, t);
        // What is no wider than rounding may lie on a border: it follows the others.
        let there = all
            .keys()
            .copied()
            .find(|&at| reach.is_narrow() && reach.lies_in(at));
        let at = there.unwrap_or_else(|| reach.middle());
        if let Some(k) = (0..2).find(|&k| !reach.lies_along(at, k)) {
            let (axis, low, high) = (["u", "v"][k], reach.low[k], reach.high[k]);
            return fault(format!(
                "TEXCOORD_0 of triangle {t} reaches from {low} to {high} along {axis}: out of its tile; let `--uv charts` lay it out"
            ));
        }
        all.entry(at).or_default().push(t);
    }
    all.values_mut()
        .for_each(|triangles| triangles.sort_unstable());
    let numbered = |[v, u]: &[i64; 2]| (0..ROW).contains(u) && (0..900).contains(v);
    if let Some([v, u]) = all.keys().find(|at| all.len() > 1 && !numbered(at)) {
        return fault(format!(
            "TEXCOORD_0 lies in several tiles, and tile {u}, {v} has no UDIM number: there are ten columns from 0 on and rows from 0 on"
        ));
    }
    let tile = |([v, u], triangles): ([i64; 2], Vec<u32>)| Tile {
        at: [u, v],
        triangles,
    };
    Ok(all.into_iter().map(tile).collect())
}

/// The box of a triangle's texture coordinates.
struct Reach {
    low: [f32; 2],
    high: [f32; 2],
}

impl Reach {
    fn of(mesh: &Mesh, t: u32) -> Reach {
        let [a, b, c] = mesh.triangles[t as usize].map(|v| mesh.uv_sets[0][v as usize]);
        Reach {
            low: [0, 1].map(|k| a[k].min(b[k]).min(c[k])),
            high: [0, 1].map(|k| a[k].max(b[k]).max(c[k])),
        }
    }

    fn is_narrow(&self) -> bool {
        (0..2).any(|k| self.high[k] - self.low[k] <= 2.0 * ROUNDING)
    }

    /// The row and column of its middle's tile.
    fn middle(&self) -> [i64; 2] {
        [1, 0].map(|k| (0.5 * (self.low[k] + self.high[k])).floor() as i64)
    }

    /// Whether it lies between the borders of that tile along u (0) or v (1).
    fn lies_along(&self, at: [i64; 2], k: usize) -> bool {
        let begin = at[1 - k] as f32;
        self.low[k] >= begin - ROUNDING && self.high[k] <= begin + 1.0 + ROUNDING
    }

    fn lies_in(&self, at: [i64; 2]) -> bool {
        (0..2).all(|k| self.lies_along(at, k))
    }
}

/// The triangles of `tile` as a mesh, its texture coordinates in the unit square; and for each of its vertices the one of
/// `mesh` that it is.
pub(super) fn cut_out(mesh: &Mesh, tile: &Tile) -> (Mesh, Vec<u32>) {
    let (mut number, mut of) = (vec![u32::MAX; mesh.positions.len()], Vec::new());
    let triangles = tile.triangles.iter().map(|&t| {
        mesh.triangles[t as usize].map(|v| {
            let n = &mut number[v as usize];
            if *n == u32::MAX {
                *n = of.len() as u32;
                of.push(v);
            }
            *n
        })
    });
    let triangles: Vec<[u32; 3]> = triangles.collect();
    let targets = mesh.targets.iter().map(|target| MorphTarget {
        positions: picked(&target.positions, &of),
        normals: picked(&target.normals, &of),
        ..target.clone()
    });
    let moved = |[u, v]: [f32; 2]| [u - tile.at[0] as f32, v - tile.at[1] as f32];
    let uv = picked(&mesh.uv_sets[0], &of).into_iter().map(moved);
    let out = Mesh {
        name: mesh.name.clone(),
        positions: picked(&mesh.positions, &of),
        normals: picked(&mesh.normals, &of),
        tangents: picked(&mesh.tangents, &of),
        uv_sets: vec![uv.collect()],
        joints: picked(&mesh.joints, &of),
        weights: picked(&mesh.weights, &of),
        triangle_material: vec![0; triangles.len()],
        triangles,
        targets: targets.collect(),
        target_weights: mesh.target_weights.clone(),
        ..Mesh::default()
    };
    (out, of)
}

/// Those elements, or none of an empty array.
pub(super) fn picked<T: Clone>(from: &[T], of: &[u32]) -> Vec<T> {
    let all = of.iter().filter_map(|&k| from.get(k as usize));
    all.cloned().collect()
}
