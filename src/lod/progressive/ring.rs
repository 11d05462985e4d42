//! What lies round a place, and what its collapse would do there.
//!
//! In: the surface as it is. Out: the [`Ring`] of a place, its faces in order, where they are one fan; the [`Star`] of a collapse onto
//! a neighbour, where the surface stays one: both have no common neighbours but those across the edge (the link condition),
//! no triangle is doubled.

use super::live::Live;
use smallvec::SmallVec;

/// A face, seen from a corner.
#[derive(Clone, Copy, Debug)]
pub(super) struct Spoke {
    pub(super) face: u32,
    /// The vertex that is its corner there.
    pub(super) own: u32,
    /// The next corner: its place and vertex.
    pub(super) next: [u32; 2],
    /// The corner before.
    pub(super) before: [u32; 2],
}

/// The faces round a place, each the neighbour of the one before.
#[derive(Clone, Debug)]
pub(super) struct Ring {
    pub(super) spokes: SmallVec<[Spoke; 10]>,
    /// Whether the last is the neighbour of the first; else the place lies on a rim.
    pub(super) closed: bool,
}

/// What a collapse does to the faces round the place that goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Star {
    /// Faces that lose their area.
    pub(super) lost: SmallVec<[u32; 2]>,
    /// Faces that get another corner, and their new corners.
    pub(super) turned: SmallVec<[(u32, [u32; 3]); 6]>,
}

impl Ring {
    /// The places that the collapse of this one may lead to, as far as the ring says.
    pub(super) fn onto(&self) -> SmallVec<[u32; 10]> {
        let next = self.spokes.iter().map(|s| s.next[0]);
        match (self.closed, self.spokes.last()) {
            (false, Some(last)) => next.take(1).chain([last.before[0]]).collect(),
            _ => next.collect(),
        }
    }

    /// Whether there is neither rim nor seam at this place.
    pub(super) fn is_whole(&self) -> bool {
        let before = self.spokes.iter().cycle().skip(self.spokes.len() - 1);
        let mut pairs = before.zip(&self.spokes);
        self.closed && pairs.all(|(a, b)| a.own == b.own && a.before == b.next)
    }

    /// Puts the faces in order; none where they are not one fan.
    fn of(mut spokes: SmallVec<[Spoke; 10]>) -> Option<Self> {
        let twice = |k: usize| {
            let earlier = &spokes[..k];
            let same =
                |s: &Spoke| s.next[0] == spokes[k].next[0] || s.before[0] == spokes[k].before[0];
            earlier.iter().any(same)
        };
        if (0..spokes.len()).any(twice) {
            return None;
        }
        // On a rim the first is the one that no other leads to, else that of the first place: the order says nothing of how
        // the surface came to be.
        let led_to = |s: &Spoke| spokes.iter().any(|other| other.before[0] == s.next[0]);
        let of_first = |&k: &usize| (led_to(&spokes[k]), spokes[k].next[0]);
        let first = (0..spokes.len()).min_by_key(of_first)?;
        spokes.swap(0, first);
        for k in 1..spokes.len() {
            let at = spokes[k - 1].before[0];
            let next = spokes[k..].iter().position(|s| s.next[0] == at)?;
            spokes.swap(k, k + next);
        }
        Some(Ring {
            closed: spokes.last()?.before[0] == spokes[0].next[0],
            spokes,
        })
    }
}

impl Live {
    /// The ring of place `u`; none where its faces are not one fan.
    pub(super) fn ring(&self, u: u32) -> Option<Ring> {
        let spoke = |&face: &u32| {
            let f = &self.faces[face as usize];
            let corner = |k: usize| [f.places[k % 3], f.corners[k % 3]];
            let k = f.places.iter().position(|&p| p == u).unwrap_or(0);
            Spoke {
                face,
                own: f.corners[k],
                next: corner(k + 1),
                before: corner(k + 2),
            }
        };
        Ring::of(self.round.get(u).iter().map(spoke).collect())
    }

    /// What the collapse of a place onto its neighbour `v` does, if the surface stays one.
    pub(super) fn star(&self, ring: &Ring, v: u32) -> Option<Star> {
        let mut lost = SmallVec::new();
        let mut kept: SmallVec<[&Spoke; 10]> = SmallVec::new();
        // The places across the edge, and for each vertex of the place that goes that of `v` on the same side.
        let (mut across, mut becomes) = ([None; 2], [None; 2]);
        for spoke in &ring.spokes {
            let (at, other) = match v {
                _ if v == spoke.next[0] => (spoke.next, spoke.before),
                _ if v == spoke.before[0] => (spoke.before, spoke.next),
                _ => {
                    kept.push(spoke);
                    continue;
                }
            };
            let side = lost.len().min(1);
            (across[side], becomes[side]) = (Some(other[0]), Some((spoke.own, at[1])));
            lost.push(spoke.face);
        }
        let [a, b] = becomes;
        let torn = a.zip(b).is_some_and(|(a, b)| a.0 == b.0 && a.1 != b.1);
        let folded = across[0].is_some() && across[0] == across[1];
        if kept.is_empty() || torn || folded || !self.stays_one(v, &across, &lost, &kept) {
            return None;
        }
        let turned = kept.iter().map(|spoke| {
            let mut sides = becomes.iter().flatten();
            let to = sides.find(|side| side.0 == spoke.own)?.1;
            let corners = self.faces[spoke.face as usize].corners;
            Some((
                spoke.face,
                corners.map(|w| if w == spoke.own { to } else { w }),
            ))
        });
        Some(Star {
            turned: turned.collect::<Option<_>>()?,
            lost,
        })
    }

    /// The link condition.
    fn stays_one(&self, v: u32, across: &[Option<u32>; 2], lost: &[u32], kept: &[&Spoke]) -> bool {
        let is_near = |s: &&&Spoke, p: u32| s.next[0] == p || s.before[0] == p;
        let stay = self.round.get(v).iter().filter(|f| !lost.contains(f));
        stay.map(|&f| self.faces[f as usize].places).all(|places| {
            let mut others = places.into_iter().filter(|&p| p != v);
            let (Some(p), Some(q)) = (others.next(), others.next()) else {
                return true;
            };
            let shared = |p: u32| kept.iter().any(|s| is_near(&s, p));
            let allowed = |p: u32| across.contains(&Some(p)) || !shared(p);
            // Both others are neighbours of the place that goes: is there a face of the three?
            let both = |s: &&&Spoke| is_near(s, p) && is_near(s, q);
            allowed(p) && allowed(q) && !kept.iter().any(|s| both(&s))
        })
    }
}
