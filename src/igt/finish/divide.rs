//! Crowded texels cut into parts.
//!
//! In: a texel and its many triangles. Out: the head of a divided texel; the parts are arranged as texels of their own, and
//! may be divided again. Where a triangle touches parts is asked only within its extent; the parts of a texel that holds
//! thousands are arranged side by side, each into words of its own, which are then put one after the other.

use super::arrange::{Arranger, CROWDED, Listed, MAX_BITS, Texel};
use super::flat::Flat;
use super::packed::Band;
use super::ranked::piece;
use super::weigh::{self, Corners};
use rayon::prelude::*;

/// A division helps if the parts' lists together are at most this many times as long.
const MOST_COPIES: usize = 3;
/// Parts of texels with more triangles are arranged side by side.
const MANY: usize = 2048;

impl Arranger<'_> {
    /// The texel cut into parts, where that is worth while.
    pub(super) fn divided(
        &mut self,
        crowd: usize,
        listed: Listed<'_>,
        left: u32,
        out: &mut Band,
    ) -> Option<u64> {
        let by = match crowd {
            0..24 => 1,
            24..96 => 2,
            _ => 3,
        };
        let tries: &[u32] = if by == 1 { &[1] } else { &[by, 1] };
        if left == 0 {
            return None;
        }
        tries
            .iter()
            .find_map(|by| self.divided_by(*by, listed, left, out))
    }

    fn divided_by(
        &mut self,
        by: u32,
        listed: Listed<'_>,
        left: u32,
        out: &mut Band,
    ) -> Option<u64> {
        let Listed { texel, own, .. } = listed;
        if texel.bits() + by > MAX_BITS {
            return None;
        }
        let parts: Vec<Texel> = (0..1 << (2 * by)).map(|i| texel.child(by, i)).collect();
        let corners: Vec<Corners> = parts.iter().map(|part| part.corners(self.line)).collect();
        let lists = self.lists_of_parts(by, listed, &corners)?;
        if lists.iter().any(|list| list.len() == own.len()) && own.len() < 3 * CROWDED[0] {
            // They all meet in one place.
            return None;
        }
        let all: Vec<u32> = listed.all().collect();
        let first = out.divide(parts.len());
        let arrange = |arranger: &mut Arranger<'_>, i: usize, out: &mut Band| {
            let more = arranger.nearest_of_layers(&corners[i], &all, &lists[i]);
            let part = Listed {
                texel: parts[i],
                own: &lists[i],
                more: &more,
            };
            arranger.arrange(part, left - 1, out)
        };
        if own.len() > MANY {
            let alone = |i: usize| {
                let mut words = Band::default();
                let head = arrange(&mut Arranger::new(self.reference), i, &mut words);
                (head, words)
            };
            let done: Vec<(u64, Band)> = (0..parts.len()).into_par_iter().map(alone).collect();
            for (i, (head, words)) in done.into_iter().enumerate() {
                let head = out.append(head, words);
                out.set_child(first + i, head);
            }
        } else {
            for i in 0..parts.len() {
                let head = arrange(self, i, out);
                out.set_child(first + i, head);
            }
        }
        Some(out.divided(first, by))
    }

    /// The triangles that touch each part; none if the parts have too many together.
    fn lists_of_parts(
        &self,
        by: u32,
        listed: Listed<'_>,
        corners: &[Corners],
    ) -> Option<Vec<Vec<u32>>> {
        let (texel, width) = (listed.texel, 1 << by);
        let frame = texel.frame(self.line);
        let mut lists = vec![Vec::new(); corners.len()];
        let mut room = listed.own.len() * MOST_COPIES;
        for t in listed.own {
            let ids = self.reference.triangles[*t as usize];
            let at = self.reference.corners(*t as usize);
            let extent = Flat::new(&frame, ids, &at).map(|flat| flat.parts(width));
            let [columns, rows] = extent.unwrap_or([[0, width - 1]; 2]);
            let piece = piece(self.reference, *t);
            for y in rows[0]..=rows[1] {
                for x in columns[0]..=columns[1] {
                    let i = (y * width + x) as usize;
                    if weigh::touches(self.line, &piece.at_corners(&corners[i])) {
                        room = room.checked_sub(1)?;
                        lists[i].push(*t);
                    }
                }
            }
        }
        Some(lists)
    }
}
