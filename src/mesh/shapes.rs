//! Tiny meshes whose properties are known, for tests and examples. All have unit normals, one uv set, material 0.

use super::Mesh;
use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

/// A mesh from its arrays, with smooth normals.
fn shape(
    name: &str,
    positions: Vec<[f32; 3]>,
    uv: Vec<[f32; 2]>,
    triangles: Vec<[u32; 3]>,
) -> Mesh {
    Mesh {
        name: name.into(),
        normals: super::smooth_normals(&positions, &triangles),
        triangle_material: vec![0; triangles.len()],
        uv_sets: vec![uv],
        positions,
        triangles,
        ..Mesh::default()
    }
}

/// Longitude and latitude of a direction as uv in [0, 1].
fn longitude_latitude(p: &[f32; 3]) -> [f32; 2] {
    let length = p.iter().map(|c| c * c).sum::<f32>().sqrt();
    [
        p[1].atan2(p[0]) / std::f32::consts::TAU + 0.5,
        (p[2] / length).acos() / std::f32::consts::PI,
    ]
}

/// The regular tetrahedron with corners (+-1, +-1, +-1): closed, four triangles.
pub fn tetrahedron() -> Mesh {
    let positions = vec![
        [1.0, 1.0, 1.0],
        [-1.0, -1.0, 1.0],
        [-1.0, 1.0, -1.0],
        [1.0, -1.0, -1.0],
    ];
    let uv = positions.iter().map(longitude_latitude).collect();
    shape(
        "tetrahedron",
        positions,
        uv,
        vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    )
}

/// The octahedron with corners on the axes at distance 1: closed, eight triangles.
pub fn octahedron() -> Mesh {
    let positions: Vec<[f32; 3]> = vec![
        [1.0, 0.0, 0.0],
        [-1.0, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, -1.0, 0.0],
        [0.0, 0.0, 1.0],
        [0.0, 0.0, -1.0],
    ];
    let uv = positions.iter().map(longitude_latitude).collect();
    let triangles = vec![
        [4, 0, 2],
        [4, 2, 1],
        [4, 1, 3],
        [4, 3, 0],
        [5, 2, 0],
        [5, 1, 2],
        [5, 3, 1],
        [5, 0, 3],
    ];
    shape("octahedron", positions, uv, triangles)
}

/// A unit sphere from the octahedron, each triangle cut in four `subdivisions` times: 8 * 4^n triangles, closed. The
/// uv has its seam inside triangles (it is not a usable parameterization across longitude 0/1).
pub fn icosphere(subdivisions: u32) -> Mesh {
    let start = octahedron();
    let (mut positions, mut triangles) = (start.positions, start.triangles);
    for _ in 0..subdivisions {
        let mut middle: HashMap<(u32, u32), u32> = HashMap::new();
        let mut cut = Vec::with_capacity(triangles.len() * 4);
        for [a, b, c] in triangles {
            let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
                *middle.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let sum: glam::Vec3 = positions[p as usize].into();
                    positions.push(
                        (sum + glam::Vec3::from(positions[q as usize]))
                            .normalize()
                            .to_array(),
                    );
                    positions.len() as u32 - 1
                })
            });
            cut.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
        }
        triangles = cut;
    }
    let uv = positions.iter().map(longitude_latitude).collect();
    shape("icosphere", positions, uv, triangles)
}

/// Vertices of a grid of `columns` x `rows` quads (one more vertex each way), `place(s, t)` for s, t in [0, 1], and its
/// triangles, counter-clockwise where s x t points outside.
fn sheet(name: &str, columns: u32, rows: u32, place: impl Fn(f64, f64) -> [f64; 3]) -> Mesh {
    let (mut positions, mut uv, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for y in 0..=rows {
        for x in 0..=columns {
            let (s, t) = (
                f64::from(x) / f64::from(columns),
                f64::from(y) / f64::from(rows),
            );
            positions.push(place(s, t).map(|c| c as f32));
            uv.push([s as f32, t as f32]);
        }
    }
    let stride = columns + 1;
    for y in 0..rows {
        for x in 0..columns {
            let a = y * stride + x;
            triangles.extend([[a, a + 1, a + stride + 1], [a, a + stride + 1, a + stride]]);
        }
    }
    shape(name, positions, uv, triangles)
}

/// The unit square in z = 0, `n` x `n` quads, uv = (x, y), normal +Z.
pub fn grid(n: u32) -> Mesh {
    sheet("grid", n, n, |s, t| [s, t, 0.0])
}

/// A unit sphere by longitude and latitude, axis along z, with a uv seam (vertices doubled at exactly equal positions)
/// and a row of degenerate triangles at each pole, as modelling tools make them.
pub fn uv_sphere(segments: u32, rings: u32) -> Mesh {
    let mut mesh = sheet("uv_sphere", segments, rings, |s, t| {
        let radius = if t == 0.0 || t == 1.0 {
            0.0
        } else {
            (PI * t).sin()
        };
        // The last column is the first one again, to the bit.
        let angle = if s == 1.0 { 0.0 } else { TAU * s };
        [radius * angle.cos(), radius * angle.sin(), -(PI * t).cos()]
    });
    mesh.normals = mesh.positions.clone();
    mesh
}

/// An open cylinder of radius 1 about z, z in [-1, 1], with a uv seam as in [`uv_sphere`].
pub fn tube(segments: u32, rings: u32) -> Mesh {
    sheet("tube", segments, rings, |s, t| {
        let angle = if s == 1.0 { 0.0 } else { TAU * s };
        [angle.cos(), angle.sin(), 2.0 * t - 1.0]
    })
}

/// One of each, for tests that run over all of them.
pub fn all() -> Vec<Mesh> {
    vec![
        tetrahedron(),
        octahedron(),
        icosphere(2),
        grid(4),
        uv_sphere(12, 6),
        tube(12, 4),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Closed shapes turn their triangles outside: the signed volume is positive and right.
    #[test]
    fn winding_is_outward() {
        for (mesh, volume) in [
            (tetrahedron(), 8.0 / 3.0),
            (octahedron(), 4.0 / 3.0),
            (icosphere(4), 4.18),
            (uv_sphere(64, 32), 4.16),
        ] {
            let sum: f64 = (0..mesh.triangles.len())
                .map(|t| {
                    let [a, b, c] = mesh
                        .corners(t)
                        .map(|p| glam::DVec3::from_array(p.map(f64::from)));
                    a.dot(b.cross(c)) / 6.0
                })
                .sum();
            assert!((sum - volume).abs() < 0.02, "{}: {sum}", mesh.name);
        }
    }

    #[test]
    fn tube_normals_point_away_from_the_axis() {
        let mesh = tube(24, 2);
        for (n, p) in mesh.normals.iter().zip(&mesh.positions) {
            assert!(n[0] * p[0] + n[1] * p[1] > 0.99);
        }
    }
}
