//! What motion asks of a simplification: a limb that is straight at rest still needs vertices where it bends.
//!
//! In: for each mesh its vertices' positions in a few poses. Out: three numbers for each vertex and pose, which the
//! simplifier takes for attributes: a collapse costs what it moves in all poses, not at rest alone (DeCoro, Rusinkiewicz:
//! Pose-independent Simplification of Articulated Meshes, I3D 2005; their sum of quadrics, with meshoptimizer's attribute
//! quadrics for those of the poses).

use super::LodInput;
use glam::{DMat4, DVec3};

/// What a deviation in all poses weighs beside the same one at rest. Of 1/4 to 16 measured on a tube and a fox: above 4 the
/// shape at rest pays more than motion gains, below it bends flatten; with 0 a straight limb keeps no vertex there.
const WEIGHT: f64 = 4.0;

/// Most poses: the simplifier takes 32 numbers, of which two are uv.
pub const MOST_POSES: usize = 8;

/// Positions of a mesh's vertices in one pose.
pub type Shape = Vec<[f32; 3]>;

/// Poses of all meshes, brought to shares of the model's extent.
pub(super) struct Motion<'a> {
    shapes: &'a [Vec<Shape>],
    /// For each mesh and pose the centre, and the factor to shares of the model's extent.
    places: Vec<Vec<(DVec3, f64)>>,
    poses: usize,
}

impl<'a> Motion<'a> {
    /// `shapes` has an element for each mesh, or none at all; a mesh that nothing deforms has no shapes. Shapes that do not
    /// fit their mesh are left out, as are those beyond [`MOST_POSES`].
    pub(super) fn new(meshes: &[LodInput<'_>], shapes: &'a [Vec<Shape>], worlds: &[DMat4]) -> Self {
        let usable = |m: usize| {
            let vertices = meshes[m].mesh.positions.len();
            let shapes = shapes.get(m).map_or(&[][..], Vec::as_slice);
            let fits = vertices > 0 && shapes.iter().all(|shape| shape.len() == vertices);
            if fits {
                shapes.len().min(MOST_POSES)
            } else {
                0
            }
        };
        let counts: Vec<usize> = (0..meshes.len()).map(usable).collect();
        let poses = counts.iter().copied().max().unwrap_or(0);
        let mut motion = Motion {
            shapes,
            places: vec![Vec::new(); meshes.len()],
            poses,
        };
        if poses == 0 {
            return motion;
        }
        let at_rest = |m: usize| {
            let positions = meshes[m].mesh.positions.iter();
            bounds(
                positions.map(move |p| worlds[m].transform_point3(DVec3::from(p.map(f64::from)))),
            )
        };
        let rest: Vec<(DVec3, DVec3)> = (0..meshes.len()).map(at_rest).collect();
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let model = rest
            .iter()
            .fold(start, |(low, high), r| (low.min(r.0), high.max(r.1)));
        for (m, &count) in counts.iter().enumerate() {
            let posed: Vec<(DVec3, DVec3)> = shapes
                .iter()
                .skip(m)
                .take(1)
                .flatten()
                .take(count)
                .map(|shape| bounds(shape.iter().map(|p| DVec3::from(p.map(f64::from)))))
                .collect();
            let largest = posed.iter().map(extent).fold(0.0, f64::max);
            // In a pose a mesh may be in another unit than at rest; it is brought to the size it has at rest.
            let factor =
                extent(&rest[m]) / largest / extent(&model) * WEIGHT / (poses as f64).sqrt();
            let factor = if factor.is_finite() { factor } else { 0.0 };
            motion.places[m] = posed
                .iter()
                .map(|(low, high)| ((*low + *high) / 2.0, factor))
                .collect();
        }
        motion
    }

    /// Numbers for each vertex.
    pub(super) fn numbers(&self) -> usize {
        3 * self.poses
    }

    /// The numbers of a vertex.
    pub(super) fn of(&self, mesh: usize, vertex: usize) -> impl Iterator<Item = f32> {
        let number = move |k: usize| {
            let (centre, factor) = self.places[mesh].get(k / 3)?;
            let place = f64::from(self.shapes[mesh][k / 3][vertex][k % 3]);
            Some(((place - centre[k % 3]) * factor) as f32)
        };
        (0..self.numbers()).map(move |k| number(k).unwrap_or(0.0))
    }
}

fn bounds(points: impl Iterator<Item = DVec3>) -> (DVec3, DVec3) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    points.fold(start, |(low, high), p| (low.min(p), high.max(p)))
}

fn extent((low, high): &(DVec3, DVec3)) -> f64 {
    (*high - *low).max_element().max(0.0)
}
