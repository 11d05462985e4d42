//! The integer grids of T3, on which every later decision is exact.
//!
//! In: T3 coordinates as f64. Out: 24-bit vertices and 30-bit query points:
//!
//! ```text
//! vertex grid   v = round((p - origin) * scale)          |v| <= 2^23 - 1
//! query grid    q, six bits finer: the vertex v is 64 v   |q| <= 2^29 - 1
//! ```
//!
//! A query grid as coarse as the vertices' one would show steps under magnification. Vertices are brought to their grid
//! once, on the host, in f64: from there on both processors see integers only.

use serde::{Deserialize, Serialize};

/// Bits of a coordinate on the vertex grid, sign included.
pub const VERTEX_BITS: u32 = 24;
/// Bits by which the query grid is finer.
pub const QUERY_SHIFT: u32 = 6;
/// Bits of a coordinate on the query grid, sign included.
pub const QUERY_BITS: u32 = VERTEX_BITS + QUERY_SHIFT;
/// Largest absolute coordinate on the vertex grid.
pub const VERTEX_MAX: i32 = (1 << (VERTEX_BITS - 1)) - 1;
/// Largest absolute coordinate on the query grid.
pub const QUERY_MAX: i32 = (1 << (QUERY_BITS - 1)) - 1;

/// Where the grid lies in T3, and how fine it is: one scale for all axes, so that distances keep their meaning.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Frame {
    /// The T3 point with grid coordinates (0, 0, 0).
    pub origin: [f64; 3],
    /// Vertex-grid steps per unit of T3.
    pub scale: f64,
}

impl Frame {
    /// The frame in which points up to `reach` (largest coordinate difference) from `origin` fill 31/32 of the domain: a
    /// LoD's moved vertices may reach a little outside the reference. `None` where `reach` is zero or not finite.
    pub fn fitting(origin: [f64; 3], reach: f64) -> Option<Self> {
        let scale = (VERTEX_MAX as f64) * (31.0 / 32.0) / reach;
        let usable =
            reach > 0.0 && scale.is_finite() && scale > 0.0 && origin.iter().all(|x| x.is_finite());
        usable.then_some(Frame { origin, scale })
    }

    /// The nearest point of the vertex grid, clamped to the domain.
    pub fn to_vertex_grid(&self, p: [f64; 3]) -> [i32; 3] {
        self.to_steps(p, 1.0, VERTEX_MAX)
    }

    /// The nearest point of the query grid, clamped to the domain.
    pub fn to_query_grid(&self, p: [f64; 3]) -> [i32; 3] {
        self.to_steps(p, (1 << QUERY_SHIFT) as f64, QUERY_MAX)
    }

    /// The T3 point of a query-grid point.
    pub fn from_query_grid(&self, q: [i32; 3]) -> [f64; 3] {
        let step = 1.0 / (self.scale * (1 << QUERY_SHIFT) as f64);
        [0, 1, 2].map(|k| self.origin[k] + q[k] as f64 * step)
    }

    /// The T3 point of a vertex-grid point.
    pub fn from_vertex_grid(&self, v: [i32; 3]) -> [f64; 3] {
        [0, 1, 2].map(|k| self.origin[k] + v[k] as f64 / self.scale)
    }

    fn to_steps(self, p: [f64; 3], finer: f64, limit: i32) -> [i32; 3] {
        // `as` saturates and turns NaN into 0; the f64 product is exact enough that both ends round alike everywhere.
        [0, 1, 2].map(|k| {
            (((p[k] - self.origin[k]) * (self.scale * finer)).round() as i32).clamp(-limit, limit)
        })
    }
}

/// A vertex-grid point on the query grid.
pub fn vertex_to_query(v: [i32; 3]) -> [i32; 3] {
    v.map(|x| x << QUERY_SHIFT)
}
