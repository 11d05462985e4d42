//! Tangents where a file has none, as MikkTSpace defines them (Morten Mikkelsen, "Simulation of Wrinkled Surfaces
//! Revisited", 2008, and the reference `mikktspace.c`).
//!
//! In: positions, normals, one uv set per triangle. Out: unit tangents and handedness per vertex; a vertex whose corners
//! need different tangents (a mirrored chart that shares its vertices) is split, new vertices at the end.
//!
//! Why not the `mikktspace` crate: it is the C code in Rust's unsafe, it recurses round a vertex (a fan of many triangles
//! overflows the stack) and takes time quadratic in the fan. This one joins corners with disjoint sets. A test holds the
//! two against each other.

use super::Mesh;
use super::topology::{NONE, Union, Weld};
use glam::{DVec2, DVec3};
use std::collections::HashMap;

/// Tangents of the three corners of one triangle, each xyz and handedness.
pub type CornerTangents = [[f32; 4]; 3];

/// What one triangle contributes: the direction of growing u in its plane.
#[derive(Clone, Copy)]
struct Face {
    along_u: DVec3,
    /// The uv triangle is counter-clockwise.
    upright: bool,
    /// It has area in space and in uv.
    usable: bool,
}

impl Mesh {
    /// Gives tangents to all triangles with `set_of[t] = Some(uv set)`, leaving those of the others as they are.
    ///
    /// Handedness follows glTF, where v grows downwards and bitangent = cross(normal, tangent) * w points up in a normal
    /// map: the negative of MikkTSpace's. `tangents` must have one element per vertex; vertices may be added.
    pub fn generate_tangents(&mut self, set_of: &[Option<usize>]) {
        let corners = tangents(self, set_of);
        let mut given: Vec<Option<[u32; 4]>> = vec![None; self.positions.len()];
        let mut split: HashMap<(u32, [u32; 4]), u32> = HashMap::new();
        for (t, found) in corners.iter().enumerate() {
            for k in 0..3 {
                let v = self.triangles[t][k];
                let value = if set_of[t].is_some() {
                    found[k]
                } else {
                    self.tangents[v as usize]
                };
                let bits = value.map(f32::to_bits);
                match given[v as usize] {
                    None => {
                        given[v as usize] = Some(bits);
                        self.tangents[v as usize] = value;
                    }
                    Some(same) if same == bits => {}
                    Some(_) => {
                        let copy = *split
                            .entry((v, bits))
                            .or_insert_with(|| self.copy_vertex(v, value));
                        self.triangles[t][k] = copy;
                    }
                }
            }
        }
    }

    /// Appends a copy of vertex `v` that has this tangent; returns its number.
    fn copy_vertex(&mut self, v: u32, tangent: [f32; 4]) -> u32 {
        fn again<T: Copy>(array: &mut Vec<T>, v: usize) {
            if let Some(&value) = array.get(v) {
                array.push(value);
            }
        }
        let at = v as usize;
        again(&mut self.positions, at);
        again(&mut self.normals, at);
        self.uv_sets.iter_mut().for_each(|set| again(set, at));
        again(&mut self.colors, at);
        again(&mut self.joints, at);
        again(&mut self.weights, at);
        for target in &mut self.targets {
            again(&mut target.positions, at);
            again(&mut target.normals, at);
            again(&mut target.tangents, at);
        }
        self.tangents.push(tangent);
        self.positions.len() as u32 - 1
    }
}

/// Tangents of every corner of the triangles with a uv set in `set_of` (zeros elsewhere).
pub fn tangents(mesh: &Mesh, set_of: &[Option<usize>]) -> Vec<CornerTangents> {
    let faces: Vec<Face> = (0..mesh.triangles.len())
        .map(|t| face(mesh, t, set_of[t]))
        .collect();
    let weld = Weld::by_key(
        (0..mesh.triangles.len() * 3)
            .map(|c| corner_key(mesh, mesh.triangles[c / 3][c % 3], set_of[c / 3])),
    );
    let mut groups = group(&faces, &weld);
    let mut sums = vec![DVec3::ZERO; faces.len() * 3];
    for c in 0..sums.len() {
        if faces[c / 3].usable {
            sums[groups.root(c as u32) as usize] += contribution(mesh, &faces[c / 3], c);
        }
    }
    // A triangle without area in uv takes what another corner at the same vertex has.
    let mut stand_in = vec![NONE; faces.len() * 3];
    for c in 0..sums.len() {
        let slot = &mut stand_in[weld.of[c] as usize];
        if faces[c / 3].usable && *slot == NONE {
            *slot = c as u32;
        }
    }
    let corner = |c: usize, groups: &mut Union| -> [f32; 4] {
        if set_of[c / 3].is_none() {
            return [0.0; 4];
        }
        let source = if faces[c / 3].usable {
            c as u32
        } else {
            stand_in[weld.of[c] as usize]
        };
        let normal = normal_of(mesh, c);
        if source == NONE {
            return any_perpendicular(normal).extend(1.0).as_vec4().to_array();
        }
        let sum = sums[groups.root(source) as usize];
        let tangent = sum
            .try_normalize()
            .unwrap_or_else(|| any_perpendicular(normal));
        let handedness = if faces[source as usize / 3].upright {
            -1.0
        } else {
            1.0
        };
        tangent.extend(handedness).as_vec4().to_array()
    };
    (0..faces.len())
        .map(|t| std::array::from_fn(|k| corner(t * 3 + k, &mut groups)))
        .collect()
}

/// Corners with equal keys are one vertex.
fn corner_key(mesh: &Mesh, v: u32, set: Option<usize>) -> [u32; 9] {
    let v = v as usize;
    let (p, n) = (mesh.positions[v], mesh.normals[v]);
    let uv = set.map_or([0.0; 2], |s| mesh.uv_sets[s][v]);
    let bits = |x: f32| (x + 0.0).to_bits();
    let set = set.map_or(NONE, |s| s as u32);
    [
        bits(p[0]),
        bits(p[1]),
        bits(p[2]),
        bits(n[0]),
        bits(n[1]),
        bits(n[2]),
        bits(uv[0]),
        bits(uv[1]),
        set,
    ]
}

fn normal_of(mesh: &Mesh, c: usize) -> DVec3 {
    DVec3::from_array(mesh.normals[mesh.triangles[c / 3][c % 3] as usize].map(f64::from))
}

fn face(mesh: &Mesh, t: usize, set: Option<usize>) -> Face {
    let unusable = Face {
        along_u: DVec3::ZERO,
        upright: false,
        usable: false,
    };
    let Some(set) = set else { return unusable };
    let [a, b, c] = mesh.corners(t).map(|p| DVec3::from_array(p.map(f64::from)));
    if a == b || b == c || c == a {
        return unusable;
    }
    let uv =
        mesh.triangles[t].map(|v| DVec2::from_array(mesh.uv_sets[set][v as usize].map(f64::from)));
    let (ab, ac) = (uv[1] - uv[0], uv[2] - uv[0]);
    let area = ab.perp_dot(ac);
    let along_u = (b - a) * ac.y - (c - a) * ab.y;
    let along_v = (c - a) * ab.x - (b - a) * ac.x;
    let usable = area != 0.0 && along_u != DVec3::ZERO && along_v != DVec3::ZERO;
    let upright = area > 0.0;
    Face {
        along_u: along_u.normalize_or_zero() * if upright { 1.0 } else { -1.0 },
        upright,
        usable,
    }
}

/// Joins the corners round a vertex whose triangles hang together over edges and turn the same way in uv.
fn group(faces: &[Face], weld: &Weld) -> Union {
    let mut edges: Vec<(u32, u32, bool, u32)> = Vec::with_capacity(faces.len() * 3);
    for c in (0..faces.len() * 3).filter(|c| faces[c / 3].usable) {
        let (a, b) = (weld.of[c], weld.of[next(c)]);
        edges.push((a.min(b), a.max(b), a > b, c as u32));
    }
    edges.sort_unstable();
    let mut groups = Union::new(faces.len() * 3);
    for same in edges.chunk_by(|x, y| (x.0, x.1) == (y.0, y.1)) {
        // Triangles that pass the edge one way, then those that pass it the other way: paired in order.
        let (one, other) = same.split_at(same.partition_point(|edge| !edge.2));
        for (x, y) in one.iter().zip(other) {
            let (x, y) = (x.3 as usize, y.3 as usize);
            if faces[x / 3].upright == faces[y / 3].upright {
                groups.join(x as u32, next(y) as u32);
                groups.join(next(x) as u32, y as u32);
            }
        }
    }
    groups
}

/// The next corner of the same triangle.
fn next(c: usize) -> usize {
    c / 3 * 3 + (c + 1) % 3
}

/// A triangle's direction in the plane of the corner's normal, weighted by the angle there.
fn contribution(mesh: &Mesh, face: &Face, c: usize) -> DVec3 {
    let normal = normal_of(mesh, c);
    let flat = |v: DVec3| (v - normal * normal.dot(v)).normalize_or_zero();
    let at = |c: usize| {
        DVec3::from_array(mesh.positions[mesh.triangles[c / 3][c % 3] as usize].map(f64::from))
    };
    let here = at(c);
    let (to_next, to_last) = (flat(at(next(c)) - here), flat(at(next(next(c))) - here));
    flat(face.along_u) * to_next.dot(to_last).clamp(-1.0, 1.0).acos()
}

fn any_perpendicular(normal: DVec3) -> DVec3 {
    normal
        .try_normalize()
        .map_or(DVec3::X, |n| n.any_orthonormal_vector())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    fn all_set_0(mesh: &Mesh) -> Vec<Option<usize>> {
        vec![Some(0); mesh.triangles.len()]
    }

    struct Theirs<'a>(&'a Mesh, Vec<CornerTangents>);

    impl mikktspace::Geometry for Theirs<'_> {
        fn num_faces(&self) -> usize {
            self.0.triangles.len()
        }
        fn num_vertices_of_face(&self, _: usize) -> usize {
            3
        }
        fn position(&self, t: usize, k: usize) -> [f32; 3] {
            self.0.positions[self.0.triangles[t][k] as usize]
        }
        fn normal(&self, t: usize, k: usize) -> [f32; 3] {
            self.0.normals[self.0.triangles[t][k] as usize]
        }
        fn tex_coord(&self, t: usize, k: usize) -> [f32; 2] {
            self.0.uv_sets[0][self.0.triangles[t][k] as usize]
        }
        fn set_tangent_encoded(&mut self, tangent: [f32; 4], t: usize, k: usize) {
            self.1[t][k] = tangent;
        }
    }

    /// Largest difference between our tangents and those of the reference implementation (w with the opposite sign).
    fn difference(mesh: &Mesh, ours: &[CornerTangents]) -> f32 {
        let mut theirs = Theirs(
            mesh,
            vec![[0.0; 4]; mesh.triangles.len()]
                .iter()
                .map(|_| [[0.0; 4]; 3])
                .collect(),
        );
        assert!(mikktspace::generate_tangents(&mut theirs));
        let mut worst = 0f32;
        for t in (0..mesh.triangles.len()).filter(|&t| mesh.face_area(t) > 0.0) {
            for k in 0..3 {
                let (a, b) = (ours[t][k], theirs.1[t][k]);
                let away = (0..3)
                    .map(|i| (a[i] - b[i]).abs())
                    .fold((a[3] + b[3]).abs(), f32::max);
                worst = worst.max(away);
            }
        }
        worst
    }

    #[test]
    fn agrees_with_the_reference_implementation() {
        let mirrored = {
            let mut mesh = shapes::grid(6);
            mesh.uv_sets[0]
                .iter_mut()
                .for_each(|uv| uv[0] = (uv[0] - 0.5).abs());
            mesh
        };
        let bumpy = {
            let mut mesh = shapes::grid(9);
            mesh.positions
                .iter_mut()
                .for_each(|p| p[2] = (p[0] * 9.0).sin() * (p[1] * 7.0).cos() * 0.1);
            mesh.normals = crate::mesh::smooth_normals(&mesh.positions, &mesh.triangles);
            mesh
        };
        for mesh in [shapes::grid(5), shapes::tube(16, 4), mirrored, bumpy] {
            let ours = tangents(&mesh, &all_set_0(&mesh));
            let away = difference(&mesh, &ours);
            assert!(away < 1e-4, "{}: {away}", mesh.name);
            // Negative control: a tangent turned by a degree is noticed.
            let mut turned = ours.clone();
            turned[0][0] = (glam::Quat::from_rotation_z(0.02)
                * glam::Vec3::from_slice(&turned[0][0]))
            .extend(turned[0][0][3])
            .to_array();
            assert!(difference(&mesh, &turned) > 1e-3);
        }
    }

    /// On the grid u grows along x and v along y: with v downwards in the image, the bitangent is -y.
    #[test]
    fn handedness_is_that_of_gltf() {
        let mesh = shapes::grid(2);
        for corner in tangents(&mesh, &all_set_0(&mesh)).iter().flatten() {
            assert_eq!(corner, &[1.0, 0.0, 0.0, -1.0]);
        }
    }

    #[test]
    fn a_mirrored_chart_splits_its_shared_vertices() {
        let mut mesh = shapes::grid(2);
        mesh.uv_sets[0]
            .iter_mut()
            .for_each(|uv| uv[0] = (uv[0] - 0.5).abs());
        mesh.tangents = vec![[0.0; 4]; 9];
        mesh.targets = vec![crate::mesh::MorphTarget {
            positions: mesh.positions.clone(),
            ..Default::default()
        }];
        mesh.target_weights = vec![0.0];
        let before = mesh.triangles.len();
        mesh.generate_tangents(&all_set_0(&shapes::grid(2)));
        assert_eq!(
            mesh.positions.len(),
            12,
            "the three vertices on the mirror line are doubled"
        );
        assert_eq!(mesh.triangles.len(), before);
        assert_eq!(mesh.targets[0].positions, mesh.positions);
        mesh.validate().unwrap();
    }

    #[test]
    fn no_uv_area_still_gives_a_unit_tangent_across_the_normal() {
        let mut mesh = shapes::icosphere(1);
        mesh.uv_sets[0].iter_mut().for_each(|uv| *uv = [0.5; 2]);
        for (t, corners) in tangents(&mesh, &all_set_0(&mesh)).iter().enumerate() {
            for (k, tangent) in corners.iter().enumerate() {
                let tangent = glam::Vec4::from_array(*tangent).truncate();
                let normal = glam::Vec3::from_array(mesh.normals[mesh.triangles[t][k] as usize]);
                assert!((tangent.length() - 1.0).abs() < 1e-5 && tangent.dot(normal).abs() < 1e-5);
            }
        }
    }

    /// A fan of 200,000 triangles round one vertex: no recursion, no quadratic time.
    #[test]
    fn a_huge_fan_is_no_trouble() {
        let n = 200_000u32;
        let rim = |i: u32| (f64::from(i) / f64::from(n) * std::f64::consts::TAU).sin_cos();
        let positions: Vec<[f32; 3]> = std::iter::once([0.0; 3])
            .chain((0..n).map(|i| [rim(i).1 as f32, rim(i).0 as f32, 0.0]))
            .collect();
        let mesh = Mesh {
            normals: vec![[0.0, 0.0, 1.0]; positions.len()],
            uv_sets: vec![positions.iter().map(|p| [p[0], p[1]]).collect()],
            triangles: (0..n).map(|i| [0, 1 + i, 1 + (i + 1) % n]).collect(),
            triangle_material: vec![0; n as usize],
            positions,
            ..Mesh::default()
        };
        let found = tangents(&mesh, &all_set_0(&mesh));
        assert!((found[0][0][0] - 1.0).abs() < 1e-3);
    }
}
