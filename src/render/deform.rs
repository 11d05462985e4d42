//! LoDs as a pose has them: the frames of their vertices.
//!
//! In: a deformation, a LoD at rest. Out: [`Frames`], the linear maps from directions at rest to directions in the world,
//! one for each vertex, which turn the reference's normals wherever the LoD shows them (`frame.rs`).
//!
//! A frame is the blend matrix's linear part times the least rotation from the normal at rest to the morphed one. It is
//! the very matrix that glTF turns the reference's own normals by at a vertex, so LoD and reference agree where their
//! weights do; it costs as much as the LoD has vertices, whatever the reference has; and it varies smoothly, where the map
//! from each rest triangle to its deformed one would show every edge of the LoD.

use crate::lod::Lod;
use crate::scene::{Deformation, Rest};
use glam::{DMat3, DQuat, DVec3};

/// Entries of a frame smaller than this are zero, beside a largest of 1: no product in a shader is subnormal.
const LEAST: f64 = 1e-9;

/// Frames of the vertices of a deformed geometry.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Frames {
    /// Rows of each vertex's map from directions at rest to the world, the largest entry of all being 1.
    pub(crate) rows: Vec<[f32; 9]>,
    /// The most that any frame stretches an axis, before the division by the largest entry.
    pub(crate) stretch: f32,
}

impl Frames {
    /// The frames of other vertices, each of which stands where one of these does.
    pub(crate) fn of(&self, vertices: impl Iterator<Item = usize>) -> Frames {
        Frames {
            rows: vertices.map(|v| self.rows[v]).collect(),
            ..*self
        }
    }
}

impl<'a> From<&'a Lod> for Rest<'a> {
    fn from(lod: &'a Lod) -> Self {
        Rest {
            positions: &lod.positions,
            normals: &lod.normals,
            joints: &lod.joints,
            weights: &lod.weights,
            targets: &lod.targets,
        }
    }
}

/// The frames of all vertices.
pub(crate) fn frames(moving: &Deformation, rest: Rest) -> Frames {
    let world = DMat3::from_mat4(moving.world());
    let frame = |v: usize| {
        let skin = DMat3::from_mat4(moving.skin(rest, v));
        world * skin * turn(moving, rest, v)
    };
    let frames: Vec<DMat3> = (0..rest.positions.len()).map(frame).collect();
    let columns = |m: &DMat3| [m.x_axis, m.y_axis, m.z_axis];
    let largest = |f: fn(DVec3) -> f64| {
        let all = frames.iter().flat_map(columns).map(f);
        all.fold(0.0, f64::max)
    };
    let entry = largest(|column| column.abs().max_element());
    let scale = if entry > 0.0 { 1.0 / entry } else { 0.0 };
    let small = |x: f64| {
        let x = x * scale;
        if x.abs() < LEAST { 0.0 } else { x as f32 }
    };
    let rows = |m: &DMat3| m.transpose().to_cols_array().map(small);
    Frames {
        rows: frames.iter().map(rows).collect(),
        stretch: largest(DVec3::length) as f32,
    }
}

/// The least rotation from the normal of vertex `v` at rest to the morphed one.
fn turn(moving: &Deformation, rest: Rest, v: usize) -> DMat3 {
    if moving.way(rest, v, |t| &t.normals) == DVec3::ZERO {
        return DMat3::IDENTITY;
    }
    let at_rest = DVec3::from(rest.normals[v].map(f64::from)).normalize_or(DVec3::Z);
    let morphed = moving.normal(rest, v).normalize_or(at_rest);
    DMat3::from_quat(DQuat::from_rotation_arc(at_rest, morphed))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MorphTarget;
    use crate::scene::deform_samples::{rest, skinned};
    use glam::DMat4;

    #[test]
    fn frames_are_the_linear_parts_up_to_one_scale_and_know_what_is_mirrored() {
        let turned = DMat4::from_rotation_z(0.5) * DMat4::from_scale(DVec3::new(4.0, 2.0, -8.0));
        let moving = skinned(vec![turned, DMat4::from_scale(DVec3::splat(0.5))]);
        let at = [[0.0; 3]; 3];
        let (joints, weights) = ([[0, 1, 0, 0]; 3], [[1.0, 0.0, 0.0, 0.0]; 3]);
        let mirrored = frames(&moving, rest(&at, &joints, &weights));
        assert_eq!(mirrored.stretch, 8.0);
        assert_eq!(moving.handed(rest(&at, &joints, &weights)), -1.0);
        for row in 0..3 {
            for column in 0..3 {
                let want = (turned.col(column)[row] / 8.0) as f32;
                assert!((mirrored.rows[1][row * 3 + column] - want).abs() < 1e-7);
            }
        }
        let upright = frames(&moving, rest(&at, &[[1, 0, 0, 0]; 3], &weights));
        assert_eq!(upright.stretch, 0.5);
        assert_eq!(moving.handed(rest(&at, &[[1, 0, 0, 0]; 3], &weights)), 1.0);
        assert_eq!(
            upright.rows[0],
            [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]
        );
    }

    #[test]
    fn a_morphed_normal_turns_its_frame_and_what_lies_beside_it() {
        let target = MorphTarget {
            positions: vec![[0.0, 2.0, 0.0]; 3],
            normals: vec![[2.0, 0.0, -2.0]; 3],
            ..MorphTarget::default()
        };
        let targets = [target];
        let rest = Rest {
            targets: &targets,
            ..rest(&[[1.0, 0.0, 0.0]; 3], &[], &[])
        };
        let moving = |weights: &'static [f64]| Deformation {
            palette: None,
            weights,
            world: DMat4::IDENTITY,
        };
        // Half of the way the normal is halfway from +z to +x; the x axis sinks with it.
        let half = frames(&moving(&[0.5]), rest).rows[2];
        let want = [0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0];
        assert!(
            half.iter()
                .zip(want)
                .all(|(a, b): (&f32, f32)| (a - b).abs() < 1e-6)
        );
        let position = moving(&[0.25]).positions("m", rest).unwrap()[0];
        assert_eq!(position, [1.0, 0.5, 0.0]);
        let none = frames(&moving(&[0.0]), rest).rows[0];
        assert_eq!(none, [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    }
}
