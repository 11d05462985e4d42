//! What moves a LoD's vertices: skin weights and morph targets of the reference, at the point each vertex stands for.
//!
//! In: a reference that something can move. Out: arrays of a [`Lod`], vertex by vertex. A vertex that stayed where the
//! reference has it takes its numbers as they are. One that the simplifier moved would be dragged along by the wrong bone
//! with the weights of the vertex it came from: it takes those of the nearest point of its own part, interpolated. The two
//! sides of a chart's border, which move as one, take the same numbers to the bit, so that no pose opens a crack.

use super::tree::Tree;
use super::{Lod, LodInput};
use crate::mesh::{Mesh, MorphTarget};
use glam::{DVec3, Vec3};
use std::collections::HashMap;
use std::collections::hash_map::Entry;

/// A reference whose vertices move each by itself.
pub(super) struct Carry<'a> {
    mesh: &'a Mesh,
    triangle_part: &'a [u32],
    tree: Tree<u32>,
    /// For each vertex the first one that lies where it does and is moved as it is.
    twin: Vec<u32>,
}

/// Vertices of a LoD by where they lie (bits) and whose twin they come from: what the two sides of a border have in common.
pub(super) type Sides = HashMap<([u32; 3], u32), usize>;

/// A point of the reference: three vertices and their shares.
type Point = ([u32; 3], [f64; 3]);

impl<'a> Carry<'a> {
    /// None for a mesh that has neither skin nor morph targets.
    pub(super) fn new(input: &LodInput<'a>) -> Option<Self> {
        let mesh = input.mesh;
        if mesh.joints.is_empty() && mesh.targets.is_empty() {
            return None;
        }
        Some(Carry {
            mesh,
            triangle_part: &input.parts.triangle_part,
            tree: Tree::new(&mesh.positions, &mesh.triangles, |t| t as u32)?,
            twin: twins(mesh),
        })
    }

    /// Appends what moves a vertex that lies at `position` and came from the reference's vertex `origin`, of `part`;
    /// `sides` holds the vertices before it.
    pub(super) fn push(
        &self,
        lod: &mut Lod,
        sides: &mut Sides,
        (origin, part): (u32, u32),
        position: [f32; 3],
    ) {
        let side = (position.map(f32::to_bits), self.twin[origin as usize]);
        match sides.entry(side) {
            Entry::Occupied(other) => repeat(lod, *other.get()),
            Entry::Vacant(vacant) => {
                let stayed = position == self.mesh.positions[origin as usize];
                let near = (!stayed).then(|| self.nearest(part, position.into()));
                let point = near.flatten().unwrap_or(([origin; 3], [1.0, 0.0, 0.0]));
                self.push_point(lod, &point);
                vacant.insert(lod.positions.len() - 1);
            }
        }
    }

    fn push_point(&self, lod: &mut Lod, point: &Point) {
        if !self.mesh.joints.is_empty() {
            let (joints, weights) = blended(self.mesh, point);
            lod.joints.push(joints);
            lod.weights.push(weights);
        }
        lod.targets
            .resize_with(self.mesh.targets.len(), MorphTarget::default);
        for (target, of) in lod.targets.iter_mut().zip(&self.mesh.targets) {
            // A target of nothing is none in a file: one that only tilts tangents moves by zero.
            if !of.positions.is_empty() || of.normals.is_empty() {
                target.positions.push(interpolated(&of.positions, point));
            }
            if !of.normals.is_empty() {
                target.normals.push(interpolated(&of.normals, point));
            }
        }
    }

    fn nearest(&self, part: u32, position: Vec3) -> Option<Point> {
        let of_part = |t: u32| self.triangle_part[t as usize] == part;
        let (near, t) = self.tree.nearest(position, f32::INFINITY, of_part)?;
        let corners = self.mesh.corners(t as usize);
        let shares = shares(corners.map(|p| Vec3::from(p).as_dvec3()), near.as_dvec3())?;
        Some((self.mesh.triangles[t as usize], shares))
    }
}

/// Appends what moves vertex `v` once more.
fn repeat(lod: &mut Lod, v: usize) {
    if let (Some(&joints), Some(&weights)) = (lod.joints.get(v), lod.weights.get(v)) {
        lod.joints.push(joints);
        lod.weights.push(weights);
    }
    for target in &mut lod.targets {
        for array in [&mut target.positions, &mut target.normals] {
            if let Some(&way) = array.get(v) {
                array.push(way);
            }
        }
    }
}

/// For each vertex the first one with the same position, joints, weights and ways, bit by bit.
fn twins(mesh: &Mesh) -> Vec<u32> {
    let mut first: HashMap<Vec<u32>, u32> = HashMap::new();
    let twin = |v: usize| {
        let mut key: Vec<u32> = mesh.positions[v].map(f32::to_bits).into();
        key.extend(
            mesh.joints
                .get(v)
                .into_iter()
                .flatten()
                .map(|&j| u32::from(j)),
        );
        key.extend(
            mesh.weights
                .get(v)
                .into_iter()
                .flatten()
                .map(|w| w.to_bits()),
        );
        for target in &mesh.targets {
            let ways = [target.positions.get(v), target.normals.get(v)];
            key.extend(ways.into_iter().flatten().flatten().map(|c| c.to_bits()));
        }
        *first.entry(key).or_insert(v as u32)
    };
    (0..mesh.positions.len()).map(twin).collect()
}

/// Barycentric coordinates of a point of a triangle; none where the triangle has no area.
fn shares([a, b, c]: [DVec3; 3], p: DVec3) -> Option<[f64; 3]> {
    let normal = (b - a).cross(c - a);
    let area = normal.length_squared();
    let of = |from: DVec3, to: DVec3| normal.dot((to - from).cross(p - from)) / area;
    // Rounding may leave the triangle by a hair; no share is negative.
    let [x, y, z] = [of(b, c), of(c, a), of(a, b)].map(|share| share.max(0.0));
    let sum = x + y + z;
    (area > 0.0 && sum.is_finite() && sum > 0.0).then(|| [x / sum, y / sum, z / sum])
}

/// Of the joints of three vertices the four with the most weight, heaviest first; weights sum to 1.
fn blended(mesh: &Mesh, (vertices, shares): &Point) -> ([u16; 4], [f32; 4]) {
    if shares[0] == 1.0 {
        let v = vertices[0] as usize;
        return (mesh.joints[v], mesh.weights[v]);
    }
    let mut all: Vec<(u16, f64)> = Vec::with_capacity(12);
    for (v, share) in vertices.iter().map(|&v| v as usize).zip(shares) {
        for (&joint, &weight) in mesh.joints[v].iter().zip(&mesh.weights[v]) {
            let weight = f64::from(weight) * share;
            match all.iter_mut().find(|(j, _)| *j == joint) {
                Some((_, sum)) => *sum += weight,
                None if weight > 0.0 => all.push((joint, weight)),
                None => {}
            }
        }
    }
    all.sort_by(|a, b| b.1.total_cmp(&a.1).then(a.0.cmp(&b.0)));
    all.truncate(4);
    let total: f64 = all.iter().map(|(_, weight)| weight).sum();
    let joint = |k: usize| all.get(k).map_or(0, |(joint, _)| *joint);
    let weight = |k: usize| all.get(k).map_or(0.0, |(_, w)| (w / total) as f32);
    (std::array::from_fn(joint), std::array::from_fn(weight))
}

fn interpolated(values: &[[f32; 3]], (vertices, shares): &Point) -> [f32; 3] {
    let of = |v: u32| values.get(v as usize).copied().unwrap_or_default();
    let term = |k: usize, axis: usize| f64::from(of(vertices[k])[axis]) * shares[k];
    std::array::from_fn(|axis| (term(0, axis) + term(1, axis) + term(2, axis)) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    #[test]
    fn the_heaviest_four_of_twelve_are_kept_and_sum_to_one() {
        let mut mesh = shapes::tetrahedron();
        mesh.joints = vec![[0, 1, 2, 3], [4, 1, 5, 6], [7, 1, 0, 8], [0; 4]];
        mesh.weights = vec![
            [0.4, 0.3, 0.2, 0.1],
            [0.7, 0.1, 0.1, 0.1],
            [0.25; 4],
            [1.0, 0.0, 0.0, 0.0],
        ];
        // 0: 0.2 + 0.05, 1: 0.15 + 0.03 + 0.05, 2: 0.1, 4: 0.21.
        let (joints, weights) = blended(&mesh, &([0, 1, 2], [0.5, 0.3, 0.2]));
        assert_eq!(joints, [0, 1, 4, 2]);
        let total = 0.25 + 0.23 + 0.21 + 0.1;
        for (got, want) in weights.iter().zip([0.25, 0.23, 0.21, 0.1]) {
            assert!((f64::from(*got) - want / total).abs() < 1e-6, "{weights:?}");
        }
        let alone = blended(&mesh, &([2, 0, 0], [1.0, 0.0, 0.0]));
        assert_eq!(alone, (mesh.joints[2], mesh.weights[2]));
    }

    #[test]
    fn shares_give_the_point_back() {
        let corners = [
            DVec3::new(1.0, 2.0, 3.0),
            DVec3::new(-1.0, 0.5, 2.0),
            DVec3::new(0.0, 4.0, -1.0),
        ];
        let wanted = [0.2, 0.7, 0.1];
        let p = corners[0] * 0.2 + corners[1] * 0.7 + corners[2] * 0.1;
        let got = shares(corners, p).unwrap();
        assert!(got.iter().zip(wanted).all(|(g, w)| (g - w).abs() < 1e-12));
        assert!(shares([corners[0]; 3], p).is_none());
    }
}
