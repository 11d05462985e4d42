//! The bounds of collapses: each holds those of the collapses it depends on.
//!
//! In: a history. Out: for each collapse its [`Bound`], in the history's order. A collapse depends on those that made the
//! triangles it takes away. Its region is theirs, and the triangles it makes with all that they may be displaced by.

use super::bound::Bound;
use crate::lod::progressive::{Made, Progressive};
use glam::DVec3;

/// What bounds are measured in: the history's vertices, scaled so that none has a coordinate beyond one.
pub(super) struct Space<'a> {
    history: &'a Progressive,
    positions: &'a [[f32; 3]],
    /// Object units in a unit: a power of two, so that nothing is rounded.
    pub(super) unit: f32,
}

impl<'a> Space<'a> {
    pub(super) fn new(history: &'a Progressive, positions: &'a [[f32; 3]]) -> Self {
        let most = positions
            .iter()
            .flatten()
            .fold(0.0f32, |most, c| most.max(c.abs()));
        // Limits keep the unit and one over it normal floats.
        let exponent = most
            .max(f32::MIN_POSITIVE)
            .log2()
            .ceil()
            .clamp(-100.0, 100.0);
        Space {
            history,
            positions,
            unit: exponent.exp2(),
        }
    }

    fn corners(&self, made: &Made) -> [[f32; 3]; 3] {
        made.corners.map(|v| {
            let place = self.history.place[v as usize];
            self.positions[place as usize].map(|c| c / self.unit)
        })
    }

    /// The bounds of all collapses.
    pub(super) fn bounds(&self) -> Vec<Bound> {
        let collapses = self.history.collapses.len();
        let mut bounds = vec![Bound::nothing(); collapses];
        // Triangles come in the order in which they were made: what one is held by is complete when it goes.
        let (gone, made) = (by(self.history, |t| t.gone), by(self.history, |t| t.made));
        for c in 0..collapses {
            let mut bound = Bound::nothing();
            for &t in gone.of(c) {
                self.predecessor(&mut bound, &self.history.triangles[t as usize], &bounds);
            }
            for &t in made.of(c) {
                self.made(&mut bound, &self.history.triangles[t as usize]);
            }
            bounds[c] = bound;
        }
        bounds
    }

    /// A triangle that goes: the reference's own, or one that an earlier collapse answers for.
    fn predecessor(&self, bound: &mut Bound, t: &Made, bounds: &[Bound]) {
        match t.made {
            Some(c) => bound.join(&bounds[c as usize]),
            None => {
                let corners = self.corners(t);
                bound.hold(corners, 0.0);
                bound.face(0, unit_normal(corners));
            }
        }
    }

    fn made(&self, bound: &mut Bound, t: &Made) {
        let corners = self.corners(t);
        let [total, normal] = [t.deviation.total, t.deviation.normal].map(|d| d / self.unit);
        // Nothing of the reference lies farther than the model is wide.
        bound.hold(corners, total.min(4.0));
        bound.displace(total, normal);
        bound.face(1, unit_normal(corners));
    }
}

fn unit_normal(corners: [[f32; 3]; 3]) -> Option<[f64; 3]> {
    let [a, b, c] = corners.map(|p| DVec3::from(p.map(f64::from)));
    let normal = (b - a).cross(c - a).try_normalize()?;
    Some(normal.to_array())
}

/// Triangles of a history by one of their collapses.
pub(super) struct By {
    first: Vec<u32>,
    triangles: Vec<u32>,
}

impl By {
    /// Those of collapse `c`, in growing order.
    pub(super) fn of(&self, c: usize) -> &[u32] {
        &self.triangles[self.first[c] as usize..self.first[c + 1] as usize]
    }
}

/// Triangles by a collapse each names; those that name none are left out.
pub(super) fn by(history: &Progressive, collapse: impl Fn(&Made) -> Option<u32>) -> By {
    let mut first = vec![0u32; history.collapses.len() + 1];
    for c in history.triangles.iter().filter_map(&collapse) {
        first[c as usize + 1] += 1;
    }
    for c in 1..first.len() {
        first[c] += first[c - 1];
    }
    let mut next = first.clone();
    let mut triangles = vec![0; first.last().map_or(0, |&n| n as usize)];
    for (t, made) in history.triangles.iter().enumerate() {
        if let Some(c) = collapse(made) {
            triangles[next[c as usize] as usize] = t as u32;
            next[c as usize] += 1;
        }
    }
    By { first, triangles }
}
