//! Keeps what lies over what: a plate over its recess, a cap over the neck, a strap over the leather.
//!
//! In: the joint mesh, and its simplified form. Out: the same with vertices moved.
//!
//! A simplifier measures each surface against itself. Where one component lies over another at less than the error, the
//! two may cross, and what was hidden shows. So the reference is asked which vertices lie over or under a surface
//! of another component that faces the same way, and by how much; after simplification each of them is moved along
//! that surface's normal until the gap is back. The move is of the size of the error or the gap, seldom needed, and
//! leaves uv coordinates alone.

use super::joint::Joint;
use super::simplify::Simplified;
use super::tree::Tree;
use crate::mesh::{Weld, components, double_area_vector};
use crate::param::weld::by_place;
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// How near another surface must be to count, as a share of the model's largest extent.
const REACH: f32 = 0.05;
/// The least cosine between normals that face the same way.
const SAME_WAY: f32 = 0.3;
/// The share of the reference's gap that is restored: all of it would push neighbours apart for nothing.
const KEPT: f32 = 0.5;
/// Rounds of moving those above, then those below.
const ROUNDS: usize = 2;

/// What a triangle of the tree is known by: its component and unit normal.
type Mark = (u32, Vec3);

/// A vertex's neighbour: the other component, and the height over its surface (negative: under it), world units.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Neighbour {
    component: u32,
    height: f32,
}

/// What the reference says about the order of its components.
pub(super) struct Order {
    positions: Vec<Vec3>,
    /// None where there is one component only: nothing to keep in order.
    reference: Option<Tree<Mark>>,
    /// For each joint vertex its component.
    component: Vec<u32>,
    /// For each joint vertex -1 where its mesh is mirrored by its place in the world, else 1.
    handed: Vec<f32>,
    reach: f32,
}

impl Order {
    /// The order in the reference.
    pub(super) fn new(joint: &Joint) -> Self {
        let triangles = joint.indices.as_chunks::<3>().0;
        let handed = joint.origins.iter().map(|origin| {
            let mirrored = joint.worlds[origin.mesh as usize].determinant() < 0.0;
            if mirrored { -1.0 } else { 1.0 }
        });
        Order::of(&joint.positions, triangles, handed.collect())
    }

    fn of(positions: &[[f32; 3]], triangles: &[[u32; 3]], handed: Vec<f32>) -> Self {
        let welded = by_place(positions, triangles).triangles(triangles);
        let parts = components(&welded, positions.len());
        let mut component = vec![0; positions.len()];
        for (triangle, part) in triangles.iter().zip(&parts.of) {
            triangle.iter().for_each(|&v| component[v as usize] = *part);
        }
        let mut order = Order {
            positions: positions.iter().map(|p| Vec3::from(*p)).collect(),
            reference: None,
            component,
            handed,
            reach: REACH * largest_extent(positions),
        };
        if parts.count > 1 && order.reach > 0.0 && order.reach.is_finite() {
            order.reference = order.tree(positions, triangles);
        }
        order
    }

    fn tree(&self, positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Option<Tree<Mark>> {
        Tree::new(positions, triangles, |t| {
            let first = triangles[t][0] as usize;
            let normal = area_vector(positions, &triangles[t]).normalize_or_zero();
            (self.component[first], normal * self.handed[first])
        })
    }

    /// Moves vertices of `simplified` so that what lay over a surface of another component lies over it again.
    pub(super) fn restore(&self, simplified: &mut Simplified) {
        let Some(reference) = &self.reference else {
            return;
        };
        let normals = self.normals(simplified);
        let neighbours: Vec<Option<Neighbour>> = normals
            .par_iter()
            .enumerate()
            .map(|(v, normal)| self.neighbour(reference, v, (*normal)?))
            .collect();
        for _ in 0..ROUNDS {
            self.push(simplified, &normals, &neighbours, |height| height > 0.0);
            self.push(simplified, &normals, &neighbours, |height| height < 0.0);
        }
    }

    /// The normals of the simplified surface at its vertices, outwards; none where it has no vertex or no normal.
    /// Not those of the reference: a vertex of a plate's rim may have become one of its face.
    fn normals(&self, simplified: &Simplified) -> Vec<Option<Vec3>> {
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        for triangle in simplified.indices.as_chunks::<3>().0 {
            let area = area_vector(&simplified.positions, triangle);
            triangle.iter().for_each(|&v| sums[v as usize] += area);
        }
        let unit = |(sum, hand): (&Vec3, &f32)| sum.try_normalize().map(|n| n * hand);
        sums.iter().zip(&self.handed).map(unit).collect()
    }

    /// What lay over or under vertex `v` of the reference, facing like `normal`.
    fn neighbour(&self, reference: &Tree<Mark>, v: usize, normal: Vec3) -> Option<Neighbour> {
        let (own, place) = (self.component[v], self.positions[v]);
        let (near, (component, other)) = reference.nearest(place, self.reach, |(c, n)| {
            c != own && n.dot(normal) > SAME_WAY
        })?;
        let height = (place - near).dot(other);
        // Beyond the other's border nothing lies over or under it.
        let beside = height.abs() < 0.7 * place.distance(near);
        (height != 0.0 && !beside).then_some(Neighbour { component, height })
    }

    /// Moves those vertices whose height in the reference is `chosen`.
    fn push(
        &self,
        simplified: &mut Simplified,
        normals: &[Option<Vec3>],
        neighbours: &[Option<Neighbour>],
        chosen: impl Fn(f32) -> bool + Sync,
    ) {
        let triangles = simplified.indices.as_chunks::<3>().0;
        let Some(tree) = self.tree(&simplified.positions, triangles) else {
            return;
        };
        // Both sides of a seam lie at one place and must stay together.
        let weld = Weld::by_position(&simplified.positions);
        let moves: Vec<(u32, Vec3)> = (0..normals.len())
            .into_par_iter()
            .filter_map(|v| {
                let neighbour = neighbours[v].filter(|n| chosen(n.height))?;
                let place = Vec3::from(simplified.positions[v]);
                let by = self.correction(&tree, place, normals[v]?, neighbour, simplified.error)?;
                Some((weld.of[v], by))
            })
            .collect();
        let mut by_place = vec![Vec3::ZERO; normals.len()];
        for (place, by) in moves {
            if by.length_squared() > by_place[place as usize].length_squared() {
                by_place[place as usize] = by;
            }
        }
        for (position, &place) in simplified.positions.iter_mut().zip(&weld.of) {
            *position = (Vec3::from(*position) + by_place[place as usize]).to_array();
        }
    }

    /// The way back to the side where a vertex lay; none where it lies there, or the neighbour is out of reach. Of a gap
    /// larger than the `error` only the error is restored.
    fn correction(
        &self,
        tree: &Tree<Mark>,
        place: Vec3,
        normal: Vec3,
        neighbour: Neighbour,
        error: f32,
    ) -> Option<Vec3> {
        let (near, (_, other)) = tree.nearest(place, self.reach + 2.0 * error, |(c, n)| {
            c == neighbour.component && n.dot(normal) > SAME_WAY
        })?;
        let (side, height) = (neighbour.height.signum(), (place - near).dot(other));
        let missing = (KEPT * neighbour.height.abs()).min(error) - side * height;
        (missing > 0.0).then(|| other * (side * missing))
    }
}

/// Twice a triangle's area along its normal.
fn area_vector(positions: &[[f32; 3]], triangle: &[u32; 3]) -> Vec3 {
    let corners = triangle.map(|v| positions[v as usize]);
    DVec3::from(double_area_vector(corners)).as_vec3()
}

fn largest_extent(positions: &[[f32; 3]]) -> f32 {
    let points = || positions.iter().map(|p| Vec3::from(*p));
    let low = points().fold(Vec3::INFINITY, Vec3::min);
    let high = points().fold(Vec3::NEG_INFINITY, Vec3::max);
    (high - low).max_element()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;

    type Sheets = (Vec<[f32; 3]>, Vec<[u32; 3]>);

    /// A sheet over x and y, and another `gap` above it along its normal.
    fn sheets(gap: f32) -> Sheets {
        let one = shapes::grid(4);
        let up = one.face_normal(0).map(|x| x as f32 * gap);
        let count = one.positions.len() as u32;
        let lifted = |p: &[f32; 3]| [0, 1, 2].map(|k| p[k] + up[k]);
        let mut positions = one.positions.clone();
        positions.extend(one.positions.iter().map(lifted));
        let mut triangles = one.triangles.clone();
        triangles.extend(one.triangles.iter().map(|t| t.map(|v| v + count)));
        (positions, triangles)
    }

    fn order((positions, triangles): &Sheets) -> Order {
        Order::of(positions, triangles, vec![1.0; positions.len()])
    }

    fn simplified((positions, triangles): &Sheets, error: f32) -> Simplified {
        Simplified {
            positions: positions.clone(),
            attributes: vec![],
            indices: triangles.as_flattened().to_vec(),
            error,
            reached: true,
        }
    }

    /// The mean height of the second sheet over the first one.
    fn gap_of(positions: &[[f32; 3]]) -> f32 {
        let half = positions.len() / 2;
        let up = Vec3::from(shapes::grid(4).face_normal(0).map(|x| x as f32));
        let sum: Vec3 = (0..half)
            .map(|v| Vec3::from(positions[v + half]) - Vec3::from(positions[v]))
            .sum();
        sum.dot(up) / half as f32
    }

    #[test]
    fn sheets_know_who_is_above_and_by_how_much() {
        let extent = largest_extent(&shapes::grid(4).positions);
        let gap = 0.5 * REACH * extent;
        let up = Vec3::from(shapes::grid(4).face_normal(0).map(|x| x as f32));
        let height = |gap: f32, v: usize, normal: Vec3| {
            let order = order(&sheets(gap));
            let tree = order.reference.as_ref().unwrap();
            order.neighbour(tree, v, normal).map(|n| n.height / gap)
        };
        let half = shapes::grid(4).positions.len();
        for v in 0..half {
            assert!((height(gap, v, up).unwrap() + 1.0).abs() < 1e-3);
            assert!((height(gap, v + half, up).unwrap() - 1.0).abs() < 1e-3);
            assert_eq!(height(gap, v, -up), None, "faces the other way");
            assert_eq!(height(4.0 * gap, v, up), None, "out of reach");
        }
    }

    #[test]
    fn a_mirrored_model_has_its_outside_where_its_windings_say() {
        let gap = 0.5 * REACH * largest_extent(&shapes::grid(4).positions);
        let both = sheets(gap);
        let order = Order::of(&both.0, &both.1, vec![-1.0; both.0.len()]);
        let normals = order.normals(&simplified(&both, gap));
        let tree = order.reference.as_ref().unwrap();
        let lower = order.neighbour(tree, 0, normals[0].unwrap()).unwrap();
        assert!(lower.height > 0.0, "the lower sheet is the outer one");
    }

    #[test]
    fn sheets_that_crossed_are_put_in_order_and_others_stay() {
        let extent = largest_extent(&shapes::grid(4).positions);
        let gap = 0.5 * REACH * extent;
        let reference = order(&sheets(gap));
        let mut crossed = simplified(&sheets(-gap), gap);
        assert!(gap_of(&crossed.positions) < 0.0);
        reference.restore(&mut crossed);
        assert!(gap_of(&crossed.positions) >= 0.49 * KEPT * gap);
        let mut fine = simplified(&sheets(gap), gap);
        reference.restore(&mut fine);
        assert_eq!(fine.positions, sheets(gap).0);
    }

    #[test]
    fn one_component_has_no_order() {
        let mesh = shapes::icosphere(2);
        let one = (mesh.positions, mesh.triangles);
        assert!(order(&one).reference.is_none());
    }
}
