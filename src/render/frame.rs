//! The frame that directions of the reference are turned by at a drawn point. Twin of `glsl/render/frame.glsl`.
//!
//! In: a draw, the drawn triangle's vertices and a point of it. Out: the rows of a map from directions at rest to the
//! world, and those of its cofactors, which turn normals. A draw without frames (nothing deforms it) has one map for all
//! of its points, its record's. With frames (see `deform.rs`) the vertices' maps are interpolated.

use super::draw::DrawRecord;
use super::picture::Picture;
use crate::attribute::arithmetic::{V3, cross3, dot3, scale3};

/// Rows of the transform of directions, and of normals; the fourth of the normals' first row is the handedness.
pub(crate) type Rows = ([[f32; 4]; 3], [[f32; 4]; 3]);

/// The frame at barycentrics `b` of the triangle of `vertex`.
pub(crate) fn at(picture: &Picture, draw: &DrawRecord, vertex: [u32; 3], b: [f32; 3]) -> Rows {
    if draw.frames == 0 {
        return (draw.world, draw.normal);
    }
    let [i, j, k] = vertex.map(|v| draw.frames - 1 + (v - draw.vertex_base) * 9);
    let row = |word: u32| picture.attributes.weighted3([i, j, k, 0], word, b);
    of_rows([row(0), row(3), row(6)])
}

/// Cofactors are the inverse transpose times the determinant; its sign keeps normals outside where the map mirrors.
fn of_rows([x, y, z]: [V3; 3]) -> Rows {
    let cofactors = [cross3(y, z), cross3(z, x), cross3(x, y)];
    let handed = if dot3(x, cofactors[0]) < 0.0 {
        -1.0
    } else {
        1.0
    };
    let four = |[x, y, z]: V3| [x, y, z, 0.0];
    let mut normal = cofactors.map(|row| four(scale3(row, handed)));
    normal[0][3] = handed;
    ([four(x), four(y), four(z)], normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_stay_perpendicular_and_outside() {
        let n = [0.6, -0.8, 0.0f32];
        let t = [0.8, 0.6, 3.0f32];
        for side in [1.0f32, -1.0] {
            let map = [
                [side * 0.5, 0.25, 0.0],
                [0.0, 1.0, -0.5],
                [side * 0.125, 0.0, 0.75],
            ];
            let (world, normal) = of_rows(map);
            let turned = |rows: &[[f32; 4]; 3], v| rows.map(|r| dot3([r[0], r[1], r[2]], v));
            assert_eq!(normal[0][3], side);
            assert!(dot3(turned(&normal, n), turned(&world, t)).abs() < 1e-6);
            assert!(dot3(turned(&normal, n), turned(&world, n)) > 0.0);
        }
    }
}
