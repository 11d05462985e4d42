//! Which vertices are one place of the surface, for primaries from position.
//!
//! In: positions and triangles. Out: a [`Weld`]. Vertices at the same position are one; so are *border* vertices
//! that all but coincide: files written from formulas close their seams only to the last bit of a cosine, and an open
//! seam would be kept by the simplifier as if it were a hole's rim.

use crate::mesh::{Adjacency, NONE, Weld};
use std::collections::HashMap;

/// Border vertices closer than this share of the bounding box's diagonal are one.
const CLOSE: f64 = 1e-6;

/// Welds `positions`; each class is named by its lowest vertex.
pub(crate) fn by_place(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Weld {
    let mut weld = Weld::by_position(positions);
    let reach = CLOSE * diagonal(positions);
    let border = border(&weld, triangles);
    if border.is_empty() || !(reach > 0.0 && reach.is_finite()) {
        return weld;
    }
    let close = close_pairs(positions, &border, reach);
    if !close.is_empty() {
        // Targets are border vertices that were kept themselves, so one step leads to the end.
        weld.of
            .iter_mut()
            .for_each(|v| *v = *close.get(v).unwrap_or(v));
        weld.count -= close.len();
    }
    weld
}

/// Welded vertices on edges without a neighbour, in order.
fn border(weld: &Weld, triangles: &[[u32; 3]]) -> Vec<u32> {
    let mut welded = weld.triangles(triangles);
    welded.retain(|t| t[0] != t[1] && t[1] != t[2] && t[2] != t[0]);
    let adjacency = Adjacency::new(&welded);
    let mut border: Vec<u32> = welded
        .iter()
        .zip(&adjacency.across)
        .flat_map(|(t, across)| {
            (0..3)
                .filter(|&k| across[k] == NONE)
                .flat_map(|k| [t[k], t[(k + 1) % 3]])
        })
        .collect();
    border.sort_unstable();
    border.dedup();
    border
}

/// For each vertex of `border` (ascending) that lies within `reach` of an earlier one kept for itself: that one.
fn close_pairs(positions: &[[f32; 3]], border: &[u32], reach: f64) -> HashMap<u32, u32> {
    let place = |v: u32| positions[v as usize].map(f64::from);
    let cell = |p: [f64; 3]| p.map(|x| (x / reach).floor() as i64);
    let mut kept: HashMap<[i64; 3], Vec<u32>> = HashMap::new();
    let mut close = HashMap::new();
    for &v in border {
        let (p, at) = (place(v), cell(place(v)));
        let near = |&other: &u32| {
            let q = place(other);
            (0..3).map(|k| (p[k] - q[k]).powi(2)).sum::<f64>() <= reach * reach
        };
        let neighbours =
            (0..27).map(|n| [at[0] + n % 3 - 1, at[1] + n / 3 % 3 - 1, at[2] + n / 9 - 1]);
        let found = neighbours
            .filter_map(|c| kept.get(&c)?.iter().copied().find(near))
            .min();
        match found {
            Some(other) => {
                close.insert(v, other);
            }
            None => kept.entry(at).or_default().push(v),
        }
    }
    close
}

/// Diagonal of the bounding box.
fn diagonal(positions: &[[f32; 3]]) -> f64 {
    let extent = |k: usize| {
        let low = positions
            .iter()
            .map(|p| f64::from(p[k]))
            .fold(f64::INFINITY, f64::min);
        let high = positions
            .iter()
            .map(|p| f64::from(p[k]))
            .fold(f64::NEG_INFINITY, f64::max);
        (high - low).max(0.0)
    };
    (0..3).map(|k| extent(k).powi(2)).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn a_seam_open_by_the_last_bit_is_closed() {
        let mut mesh = shapes::tube(12, 4);
        let exact = Weld::by_position(&mesh.positions);
        for p in &mut mesh.positions[..] {
            // Columns 0 and 12 coincide; nudge one of them.
            p[1] += if p[0] > 0.9 && p[1] == 0.0 { 1e-8 } else { 0.0 };
        }
        let last = mesh.positions.len() - 1;
        mesh.positions[last][1] = -1e-8;
        assert!(Weld::by_position(&mesh.positions).count > exact.count);
        let weld = by_place(&mesh.positions, &mesh.triangles);
        assert_eq!(weld.count, exact.count);
        assert_eq!(weld.of, exact.of);
    }

    #[test]
    fn real_holes_stay_open() {
        let mesh = shapes::grid(6);
        assert_eq!(
            by_place(&mesh.positions, &mesh.triangles),
            Weld::by_position(&mesh.positions)
        );
        assert_eq!(by_place(&[], &[]).count, 0);
    }
}
