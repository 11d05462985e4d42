//! The triangles nearest to a texel that none of them touches.

use super::weigh::Corners;
use crate::param::projection::{self, GridTriangle, Line};

/// How many triangles serve the points of a texel that none touches.
const MOST: usize = 4;

/// The triangles nearest to the middle of a texel, at most [`MOST`], in ascending order of distance.
pub(super) fn nearest(
    line: Line,
    corners: &Corners,
    triangles: impl Iterator<Item = u32>,
    of: impl Fn(u32) -> GridTriangle,
) -> Vec<u32> {
    let middle: [f64; 3] = std::array::from_fn(|k| corners.iter().map(|c| c[k]).sum::<f64>() / 4.0);
    // There may be thousands: only the nearest are kept.
    let mut nearest: Vec<(f32, u32)> = Vec::with_capacity(MOST + 1);
    for t in triangles {
        let one = (distance(line, middle, &of(t)), t);
        let before = |other: &(f32, u32)| other.0.total_cmp(&one.0).then(other.1.cmp(&t)).is_lt();
        let at = nearest.partition_point(before);
        if at < MOST {
            nearest.insert(at, one);
            nearest.truncate(MOST);
        }
    }
    nearest.into_iter().map(|(_, t)| t).collect()
}

/// Squared distance of a triangle from the line through the middle, at the triangle's own height over the line's start.
fn distance(line: Line, middle: [f64; 3], triangle: &GridTriangle) -> f32 {
    let [x, y, z] = [0, 1, 2].map(|k| triangle.iter().map(|v| f64::from(v[k])).sum::<f64>() / 3.0);
    let [dx, dy, dz] = middle;
    let point = match line {
        Line::Parallel => [dx, dy, z],
        Line::Cylinder => {
            let out = ((x * x + y * y) / (dx * dx + dy * dy).max(1.0)).sqrt();
            [dx * out, dy * out, dz]
        }
        Line::Sphere => {
            let out = ((x * x + y * y + z * z) / (dx * dx + dy * dy + dz * dz).max(1.0)).sqrt();
            [dx * out, dy * out, dz * out]
        }
    };
    let offsets = triangle.map(|v| [0, 1, 2].map(|k| (f64::from(v[k]) - point[k]) as f32 / 1024.0));
    projection::nearest(offsets).1
}
