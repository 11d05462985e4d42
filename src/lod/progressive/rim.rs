//! Rims of holes and of charts: what the chords that replace them leave out.
//!
//! In: collapses along rims. Out: for each edge of a rim the places of the reference's rim between its ends. A chord cuts off
//! a piece of the reference that no triangle answers for, or adds one that the reference does not have; neither has points
//! in common with the other surface, so the overlay does not see them.

use super::live::Live;
use super::ring::Star;
use std::collections::HashMap;

/// Edges of rims (two vertices, the lower first) that replace more than one of the reference's.
#[derive(Debug, Default)]
pub(super) struct Rims(HashMap<[u32; 2], Vec<u32>>);

/// An edge of a rim that a collapse makes.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NewRim {
    /// The face whose edge it becomes.
    pub(super) face: u32,
    /// Its ends: vertices.
    pub(super) edge: [u32; 2],
    /// Places that lay on the reference's rim between them.
    pub(super) without: Vec<u32>,
}

fn key([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

impl Rims {
    /// The edges of rims that the collapse of place `u` onto `v` makes.
    pub(super) fn renewed(&self, live: &Live, u: u32, v: u32, star: &Star) -> Vec<NewRim> {
        let mut renewed = Vec::new();
        for &lost in &star.lost {
            let ends = live.vertex(lost, u).zip(live.vertex(lost, v));
            let Some((from, to)) = ends.filter(|&(a, b)| live.is_rim(lost, [a, b])) else {
                continue;
            };
            for &(face, _) in &star.turned {
                let corners = live.faces[face as usize].corners;
                if live.vertex(face, u) != Some(from) {
                    continue;
                }
                for other in corners.into_iter().filter(|&w| w != from) {
                    if live.is_rim(face, [from, other]) {
                        let mut without = self.between([from, to]).to_vec();
                        without.push(u);
                        without.extend(self.between([from, other]));
                        renewed.push(NewRim {
                            face,
                            edge: [to, other],
                            without,
                        });
                    }
                }
            }
        }
        renewed
    }

    fn between(&self, edge: [u32; 2]) -> &[u32] {
        self.0.get(&key(edge)).map_or(&[], |places| places)
    }

    /// Takes the edges over.
    pub(super) fn renew(&mut self, renewed: Vec<NewRim>) {
        for rim in renewed {
            self.0.insert(key(rim.edge), rim.without);
        }
    }
}
