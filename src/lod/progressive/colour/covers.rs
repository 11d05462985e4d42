//! The history once more: which triangles of the reference every triangle's image meets.
//!
//! In: collapses. Out: for each triangle that they made what [`Against::measured`] says of it. A triangle meets only what those meet
//! that the same collapse takes away. Collapses are done in waves of those whose triangles are all there: on all cores,
//! and what a triangle meets is dropped with it.

use super::super::{Made, Progressive};
use super::triangle::{Against, Measured};
use rayon::prelude::*;

/// A triangle's image meets these; empty after the triangle is gone.
type Covers = Vec<Vec<u32>>;

/// Calls `done` for each triangle that a collapse made.
pub(super) fn replay(
    history: &Progressive,
    against: &Against<'_>,
    mut done: impl FnMut(usize, &Measured),
) {
    let steps = Steps::new(history);
    let mut covers: Covers = vec![Vec::new(); history.triangles.len()];
    for (covers, &t) in covers.iter_mut().zip(&history.reference) {
        covers.push(t);
    }
    for wave in steps.waves() {
        let made: Vec<(u32, u32)> = wave
            .iter()
            .flat_map(|&c| steps.made(c).iter().map(move |&t| (c, t)))
            .collect();
        let measured: Vec<Measured> = made
            .par_iter()
            .with_max_len(1)
            .map(|&(c, t)| {
                let near = steps.near(history, &covers, c, t);
                against.measured(&history.triangles[t as usize], &near)
            })
            .collect();
        for &c in &wave {
            for &t in steps.gone(c) {
                covers[t as usize] = Vec::new();
            }
        }
        for (&(_, t), mut measured) in made.iter().zip(measured) {
            done(t as usize, &measured);
            covers[t as usize] = std::mem::take(&mut measured.covers);
        }
    }
}

/// Triangles that each collapse makes and takes away.
struct Steps {
    made: Vec<Vec<u32>>,
    gone: Vec<Vec<u32>>,
    /// After how many others, at least.
    depth: Vec<u32>,
}

impl Steps {
    fn new(history: &Progressive) -> Steps {
        let count = history.collapses.len();
        let mut steps = Steps {
            made: vec![Vec::new(); count],
            gone: vec![Vec::new(); count],
            depth: vec![0; count],
        };
        for (t, triangle) in history.triangles.iter().enumerate() {
            if let Some(c) = triangle.made {
                steps.made[c as usize].push(t as u32);
            }
            if let Some(c) = triangle.gone {
                steps.gone[c as usize].push(t as u32);
            }
        }
        for c in 0..count {
            let maker = |&t: &u32| history.triangles[t as usize].made;
            let before = steps.gone[c].iter().filter_map(maker);
            let depth = before.map(|b| steps.depth[b as usize] + 1).max();
            steps.depth[c] = depth.unwrap_or(0);
        }
        steps
    }

    fn waves(&self) -> Vec<Vec<u32>> {
        let count = self.depth.iter().max().map_or(0, |d| *d as usize + 1);
        let mut waves = vec![Vec::new(); count];
        for (c, depth) in self.depth.iter().enumerate() {
            waves[*depth as usize].push(c as u32);
        }
        waves
    }

    fn made(&self, c: u32) -> &[u32] {
        &self.made[c as usize]
    }

    fn gone(&self, c: u32) -> &[u32] {
        &self.gone[c as usize]
    }

    /// What triangle `t` of collapse `c` may meet: what those meet that lay round the place on the same side of a seam.
    fn near(&self, history: &Progressive, covers: &Covers, c: u32, t: u32) -> Vec<u32> {
        let from = history.collapses[c as usize].from;
        let of = |t: u32| &history.triangles[t as usize];
        let vertex = |t: &Made| {
            let is_there = |v: &u32| history.place[*v as usize] == from;
            t.corners.into_iter().find(is_there)
        };
        // It has two corners of the triangle that it comes from.
        let kept = |other: &Made| {
            let stays = |v: &&u32| of(t).corners.contains(v);
            other.corners.iter().filter(stays).count() == 2 && other.layer == of(t).layer
        };
        let sides: Vec<Option<u32>> = self
            .gone(c)
            .iter()
            .filter(|&&g| kept(of(g)))
            .map(|&g| vertex(of(g)))
            .collect();
        let mut near: Vec<u32> = self
            .gone(c)
            .iter()
            .filter(|&&g| sides.contains(&vertex(of(g))))
            .flat_map(|&g| covers[g as usize].iter().copied())
            .collect();
        near.sort_unstable();
        near.dedup();
        near
    }
}
