//! What a collapse is judged by: where it is, how far it displaces what, which way it faces.
//!
//! In: boxes, deviations and normals of triangles. Out: [`Bound`], of which one can hold others: every number of it is then
//! at least as bad. Joining takes minima and maxima and nothing else, so that no rounding comes in between.

use bytemuck::{Pod, Zeroable};

/// Steps of a stored normal's component for one.
pub(super) const NORMAL_STEPS: f32 = 127.0;

/// A deviation that no view accepts, and a length that no model has; its square is still a float.
pub(super) const FAR: f32 = 1e15;

/// The least deviation that is any: its square is no subnormal float, which some processors take for nothing.
const NEAR: f32 = 1e-15;

/// A region of the surface, on both levels: the triangles that a collapse takes away and those that it makes. 48 bytes, as a
/// shader reads it.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Bound {
    /// The box round the region, original and simplified; units of the model's ([`super::Multiresolution::unit`]).
    pub low: [f32; 3],
    /// Its other end.
    pub high: [f32; 3],
    /// Largest deviation of a triangle that was made, in the same unit.
    pub total: f32,
    /// Largest part of one along the normal.
    pub normal: f32,
    /// Boxes round unit normals: of the original surface and of simplified triangles; six steps of 1/127 each, the low ends
    /// first, as signed bytes.
    pub facing: [u32; 3],
    /// Where its triangles begin in [`super::Multiresolution`]'s order; for a block of the tree nothing.
    pub first: u32,
}

/// A box round normals, in steps: low end, high end.
pub(super) type Facing = [i8; 6];

impl Bound {
    /// Nothing yet: joining another gives that.
    pub(super) fn nothing() -> Self {
        let none: Facing = [127, 127, 127, -127, -127, -127];
        Bound {
            low: [f32::INFINITY; 3],
            high: [f32::NEG_INFINITY; 3],
            total: 0.0,
            normal: 0.0,
            facing: packed([none; 2]),
            first: 0,
        }
    }

    /// Holds another as well.
    pub(super) fn join(&mut self, other: &Bound) {
        for k in 0..3 {
            self.low[k] = self.low[k].min(other.low[k]);
            self.high[k] = self.high[k].max(other.high[k]);
        }
        self.total = self.total.max(other.total);
        self.normal = self.normal.max(other.normal);
        let (mine, others) = (self.facings(), other.facings());
        self.facing = packed([0, 1].map(|s| joined(mine[s], others[s])));
    }

    /// Holds a triangle with these corners, and what lies within `reach` of it.
    pub(super) fn hold(&mut self, corners: [[f32; 3]; 3], reach: f32) {
        for p in corners {
            for k in 0..3 {
                self.low[k] = self.low[k].min(below(p[k] - reach));
                self.high[k] = self.high[k].max(above(p[k] + reach));
            }
        }
    }

    /// Takes deviations into account.
    pub(super) fn displace(&mut self, total: f32, normal: f32) {
        let kept = |d: f32| if d > 0.0 { d.clamp(NEAR, FAR) } else { 0.0 };
        self.total = self.total.max(kept(total));
        self.normal = self.normal.max(kept(normal));
    }

    /// Holds a normal of the original surface (0) or of a simplified triangle (1).
    pub(super) fn face(&mut self, which: usize, normal: Option<[f64; 3]>) {
        let mut facings = self.facings();
        facings[which] = joined(facings[which], normal.map_or(ANY, steps));
        self.facing = packed(facings);
    }

    /// Boxes round the normals of the original surface and of simplified triangles.
    pub(super) fn facings(&self) -> [Facing; 2] {
        let bytes: [i8; 12] = bytemuck::cast(self.facing);
        let part = |first: usize| std::array::from_fn(|k| bytes[first + k]);
        [part(0), part(6)]
    }
}

/// What has no normal may face anywhere.
const ANY: Facing = [-127, -127, -127, 127, 127, 127];

fn packed([original, simplified]: [Facing; 2]) -> [u32; 3] {
    let bytes: [i8; 12] = std::array::from_fn(|k| {
        if k < 6 {
            original[k]
        } else {
            simplified[k - 6]
        }
    });
    bytemuck::cast(bytes)
}

fn joined(a: Facing, b: Facing) -> Facing {
    std::array::from_fn(|k| {
        if k < 3 {
            a[k].min(b[k])
        } else {
            a[k].max(b[k])
        }
    })
}

/// The smallest box of steps round a unit normal.
fn steps(normal: [f64; 3]) -> Facing {
    let steps = normal.map(|c| c * f64::from(NORMAL_STEPS));
    std::array::from_fn(|k| {
        let step = if k < 3 {
            steps[k].floor()
        } else {
            steps[k - 3].ceil()
        };
        step.clamp(-127.0, 127.0) as i8
    })
}

fn below(x: f32) -> f32 {
    x.next_down()
}

fn above(x: f32) -> f32 {
    x.next_up()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_joined_is_held() {
        let mut a = Bound::nothing();
        a.hold([[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], 0.25);
        a.face(0, Some([0.0, 0.6, -0.8]));
        a.displace(0.25, f32::INFINITY);
        let mut b = Bound::nothing();
        b.join(&a);
        assert_eq!(a, b);
        assert!(a.low[0] <= -0.25 && a.high[1] >= 1.25 && a.normal < f32::INFINITY);
        assert_eq!(a.facings()[0], [0, 76, -102, 0, 77, -101]);
        // No normal of simplified triangles yet: an empty box, until one has none.
        assert_eq!(a.facings()[1], [127, 127, 127, -127, -127, -127]);
        b.face(1, None);
        assert_eq!(b.facings()[1], ANY);
        a.join(&b);
        assert_eq!(a, b);
    }
}
