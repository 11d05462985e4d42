//! Triangles that share a place of T3 with another of their layer: there neither part nor layer tells the answers apart.
//!
//! In: a reference. Out: their numbers. Exact: pairs are looked at on the grid, texel by texel, as the tables do when they say
//! that a list is single; a shared edge or corner is no place. What a lookup shows there is the hit on the asker's side that
//! lies nearest (the paper's rule), which may or may not be the one that was meant.

use super::super::Reference;
use super::super::build::{Lists, cover_all, lists_of};
use super::arrange::{MAX_BITS, Texel};
use super::flat::Flat;
use super::ranked::piece;
use super::sides::{self, Piece};
use super::weigh;
use crate::error::Result;
use crate::param::projection::Line;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Longer lists are cut into quarters of their texel, as long as that helps.
const CROWDED: usize = 48;
/// Where more triangles meet in one place than this they are not compared pair by pair: all of them count.
const MOST: usize = 4096;
/// How often triangles about an axis are cut into quarters to tell them apart.
const QUARTERED: u32 = 4;
/// Texels that one worker looks at.
const BAND: usize = 1 << 11;

/// The triangles of `reference` that share a place with another of their layer, ascending.
///
/// # Errors
/// [`Error::Capacity`](crate::Error::Capacity) beyond two thousand million pairs of texel and triangle.
pub(in super::super) fn ambiguous(reference: &Reference) -> Result<Vec<u32>> {
    // About two triangles a texel: pairs are what costs.
    let bits = (reference.triangles.len().max(64).ilog2() / 2).min(12);
    let lists = lists_of(&cover_all(reference, bits), bits)?;
    let found: Vec<AtomicBool> = reference
        .triangles
        .iter()
        .map(|_| AtomicBool::new(false))
        .collect();
    let texels = lists.start.len() - 1;
    (0..texels.div_ceil(BAND)).into_par_iter().for_each(|band| {
        let mut finder = Finder::new(reference, &found);
        for texel in band * BAND..((band + 1) * BAND).min(texels) {
            finder.texel(Texel::new(bits, texel), Lists::of(&lists, texel));
        }
    });
    let numbers = (0..found.len() as u32).filter(|t| found[*t as usize].load(Relaxed));
    Ok(numbers.collect())
}

/// Looks through texels; has its workspace.
struct Finder<'a> {
    reference: &'a Reference,
    found: &'a [AtomicBool],
    line: Line,
    flat: Vec<Option<Flat>>,
    pieces: Vec<Piece>,
}

impl<'a> Finder<'a> {
    fn new(reference: &'a Reference, found: &'a [AtomicBool]) -> Self {
        Finder {
            reference,
            found,
            line: reference.primary.line(),
            flat: Vec::new(),
            pieces: Vec::new(),
        }
    }

    fn texel(&mut self, texel: Texel, list: &[u32]) {
        if list.len() < 2 || list.len() > CROWDED && self.quarters(texel, list) {
            return;
        }
        if list.len() > MOST {
            return list.iter().for_each(|t| self.mark(*t));
        }
        let frame = texel.frame(self.line);
        let reference = self.reference;
        self.pieces.clear();
        self.flat.clear();
        self.flat.extend(list.iter().map(|t| {
            let ids = reference.triangles[*t as usize];
            Flat::new(&frame, ids, &reference.corners(*t as usize))
        }));
        for i in 1..list.len() {
            for j in 0..i {
                if self.is_news(list[i], list[j]) && !self.apart(list, i, j) {
                    self.mark(list[i]);
                    self.mark(list[j]);
                }
            }
        }
    }

    /// The texel in quarters; false where that does not help: they all meet in one place.
    fn quarters(&mut self, texel: Texel, list: &[u32]) -> bool {
        if texel.bits() >= MAX_BITS {
            return false;
        }
        let quarters = [0, 1, 2, 3].map(|i| texel.child(1, i));
        let corners = quarters.map(|quarter| quarter.corners(self.line));
        let mut lists = [const { Vec::new() }; 4];
        for t in list {
            let piece = piece(self.reference, *t);
            for (list, corners) in lists.iter_mut().zip(&corners) {
                if weigh::touches(self.line, &piece.at_corners(corners)) {
                    list.push(*t);
                }
            }
        }
        if lists.iter().any(|part| part.len() == list.len()) {
            return false;
        }
        for (quarter, list) in quarters.into_iter().zip(&lists) {
            self.texel(quarter, list);
        }
        true
    }

    /// Whether a pair could tell something new.
    fn is_news(&self, a: u32, b: u32) -> bool {
        let layer = |t: u32| self.reference.layer[t as usize];
        let known = |t: u32| self.found[t as usize].load(Relaxed);
        layer(a) == layer(b) && !(known(a) && known(b))
    }

    fn mark(&self, t: u32) {
        self.found[t as usize].store(true, Relaxed);
    }

    fn apart(&mut self, list: &[u32], i: usize, j: usize) -> bool {
        if let (Some(a), Some(b)) = (&self.flat[i], &self.flat[j])
            && a.surely_apart(b)
        {
            return true;
        }
        if self.pieces.is_empty() {
            let reference = self.reference;
            self.pieces
                .extend(list.iter().map(|t| piece(reference, *t)));
        }
        let (a, b) = (&self.pieces[i], &self.pieces[j]);
        sides::apart(a, b) || sides::apart_in_parts(a, b, QUARTERED)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::igt::Layout;
    use crate::mesh::{Mesh, shapes};
    use crate::param::{Axis, Primary, PrimaryKind};

    fn found(mesh: &Mesh, kind: PrimaryKind, layer: &[u8]) -> Vec<u32> {
        let primary = Primary::centred(kind, mesh).unwrap();
        ambiguous(&Reference::new(mesh, &primary, layer, Layout::Packed).unwrap()).unwrap()
    }

    #[test]
    fn what_is_one_to_one_has_none() {
        for (mesh, kind) in [
            (shapes::grid(20), PrimaryKind::UvSet(0)),
            (shapes::icosphere(4), PrimaryKind::Sphere),
            // A fan of many triangles about each pole.
            (shapes::uv_sphere(400, 9), PrimaryKind::Sphere),
            (shapes::tube(30, 6), PrimaryKind::Cylinder(Axis::Z)),
        ] {
            let layer = vec![0; mesh.triangles.len()];
            assert_eq!(found(&mesh, kind, &layer), [0u32; 0], "{}", mesh.name);
        }
    }

    /// A sheet of 800 and, over a part of it, two more: those that lie under the two, and the two.
    #[test]
    fn a_patch_over_a_sheet_is_found_unless_layers_tell_them_apart() {
        let mut mesh = shapes::grid(20);
        let before = mesh.triangles.len();
        let first = mesh.positions.len() as u32;
        for [u, v] in [[0.26, 0.26], [0.34, 0.26], [0.34, 0.34], [0.26, 0.34]] {
            mesh.positions.push([u, v, 1.0]);
            mesh.normals.push([0.0, 0.0, 1.0]);
            mesh.uv_sets[0].push([u, v]);
        }
        mesh.triangles.push([first, first + 1, first + 2]);
        mesh.triangles.push([first, first + 2, first + 3]);
        mesh.triangle_material.extend([0, 0]);
        let mut layer = vec![0; mesh.triangles.len()];
        let all = found(&mesh, PrimaryKind::UvSet(0), &layer);
        let centre = |t: u32| {
            let corners = mesh.triangles[t as usize].map(|v| mesh.uv_sets[0][v as usize]);
            [0, 1].map(|k| corners.iter().map(|c| c[k]).sum::<f32>() / 3.0)
        };
        assert!(all.ends_with(&[before as u32, before as u32 + 1]));
        // Cells 5 and 6 of 20 along both sides.
        assert_eq!(all.len(), 2 * 4 + 2);
        for t in &all {
            assert!(centre(*t).iter().all(|c| (0.25..0.35).contains(c)), "{t}");
        }
        layer[before..].fill(1);
        assert_eq!(found(&mesh, PrimaryKind::UvSet(0), &layer), [0u32; 0]);
    }
}
