//! Texels of a surface with texture coordinates.
//!
//! In: a mesh with one uv set, the size of a texture. Out: which triangle owns each texel's centre, and where in it that is.

use crate::mesh::Mesh;
use std::ops::Range;

/// A triangle's corners in texels.
pub(super) fn corners(low: &Mesh, t: usize, size: u32) -> [[f64; 2]; 3] {
    let uv = &low.uv_sets[0];
    low.triangles[t].map(|v| uv[v as usize].map(|c| f64::from(c) * f64::from(size)))
}

/// A triangle of a texture, with what is the same for all its texels.
pub(super) struct Flat {
    corner: [f64; 2],
    /// Its other corners seen from there.
    first: [f64; 2],
    second: [f64; 2],
    /// Twice its area, negative where corners run clockwise.
    area: f64,
}

impl Flat {
    pub(super) fn new([a, b, c]: &[[f64; 2]; 3]) -> Flat {
        let (first, second) = (less(*b, *a), less(*c, *a));
        Flat {
            corner: *a,
            first,
            second,
            area: cross(first, second),
        }
    }

    /// Barycentrics of `at`; none in a triangle without area.
    #[inline]
    pub(super) fn barycentric(&self, at: [f64; 2]) -> Option<[f32; 3]> {
        if self.area == 0.0 {
            return None;
        }
        let at = less(at, self.corner);
        let b1 = cross(at, self.second) / self.area;
        let b2 = cross(self.first, at) / self.area;
        Some([1.0 - b1 - b2, b1, b2].map(|x| x as f32))
    }
}

/// `p - q`.
pub(super) fn less(p: [f64; 2], q: [f64; 2]) -> [f64; 2] {
    [p[0] - q[0], p[1] - q[1]]
}

/// Twice the area of the triangle of 0, `p` and `q`; positive where they are counter-clockwise.
pub(super) fn cross(p: [f64; 2], q: [f64; 2]) -> f64 {
    p[0] * q[1] - p[1] * q[0]
}

/// The place of texture coordinates in a texture of `size` x `size` texels, row after row.
pub(crate) fn place(size: u32, uv: [f32; 2]) -> usize {
    let most = (size - 1) as f32;
    let [x, y] = uv.map(|c| (c * size as f32).clamp(0.0, most) as usize);
    y * size as usize + x
}

/// For each texel of some rows of a texture of `size` x `size` the first of `triangles` that covers its centre; `u32::MAX`
/// where there is none.
pub(super) fn owners(
    low: &Mesh,
    triangles: impl Iterator<Item = u32>,
    size: u32,
    rows: Range<u32>,
) -> Vec<u32> {
    let mut owner = vec![u32::MAX; size as usize * rows.len()];
    for t in triangles {
        let corners = corners(low, t as usize, size);
        let Some(inside) = Inside::new(&corners) else {
            continue;
        };
        let (xs, ys) = (span(&corners, 0, size), span(&corners, 1, size));
        for y in ys.start.max(rows.start)..ys.end.min(rows.end) {
            let row = (y - rows.start) as usize * size as usize;
            for x in xs.clone() {
                let slot = &mut owner[row + x as usize];
                if *slot == u32::MAX && inside.holds([x, y].map(|c| f64::from(c) + 0.5)) {
                    *slot = t;
                }
            }
        }
    }
    owner
}

/// The inside of a triangle of a texture, its rim included.
struct Inside(Flat);

impl Inside {
    /// None for a triangle without area.
    fn new([a, b, c]: &[[f64; 2]; 3]) -> Option<Inside> {
        let flat = Flat::new(&[*a, *b, *c]);
        match flat.area {
            area if area > 0.0 => Some(Inside(flat)),
            // The other way round.
            area if area < 0.0 => Some(Inside(Flat::new(&[*a, *c, *b]))),
            _ => None,
        }
    }

    fn holds(&self, at: [f64; 2]) -> bool {
        let Flat {
            corner,
            first,
            second,
            area,
        } = self.0;
        let at = less(at, corner);
        let (along, across) = (cross(at, second), cross(first, at));
        along >= 0.0 && across >= 0.0 && along + across <= area
    }
}

/// For each of the bands of `height` rows the triangles that reach into it, in growing order.
pub(super) fn bands(low: &Mesh, size: u32, height: u32) -> Vec<Vec<u32>> {
    let mut bands = vec![Vec::new(); size.div_ceil(height) as usize];
    for t in 0..low.triangles.len() {
        let ys = span(&corners(low, t, size), 1, size);
        if !ys.is_empty() {
            let reached = ys.start / height..=(ys.end - 1) / height;
            reached.for_each(|band| bands[band as usize].push(t as u32));
        }
    }
    bands
}

/// Columns (k = 0) or rows (1) that a triangle may cover.
fn span(corners: &[[f64; 2]; 3], k: usize, size: u32) -> Range<u32> {
    let within = |x: f64| x.clamp(0.0, f64::from(size)) as u32;
    let c = corners.map(|p| p[k]);
    let low = c.iter().copied().fold(f64::INFINITY, f64::min);
    let high = c.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    within(low.floor())..within(high.ceil())
}
