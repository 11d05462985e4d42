//! Builds that a device has no room for at once, and their sum.
//!
//! In: a reference, triangles at a time. Out: [`Lists`] over all of it. A device's storage buffers may stop at 128 MiB: a list
//! of 33 million entries. Triangles then go in portions, each with only the vertices it needs; the lists of all portions are
//! put one after the other on the host, texel by texel, which keeps them ascending.

use super::super::Reference;
use super::super::build::Lists;
use crate::error::{Error, Result};
use crate::gpu::Context;
use rayon::prelude::*;
use std::ops::Range;

/// Bytes of the largest buffer for each triangle: of a portion's boxes, or of its lists at about seven entries a triangle.
const BYTES: u64 = 28;
/// Smaller portions than this do not help.
const LEAST: usize = 256;
/// Texels that one worker sums at a time.
const BAND: usize = 1 << 14;

/// How many triangles a device takes at a time.
pub(super) fn portion(context: &Context, reference: &Reference) -> usize {
    let room = context.info().limits.storage_buffer_bytes;
    let triangles = reference.triangles.len();
    let vertices = reference.t3.len() as u64 * 12;
    if triangles as u64 * BYTES <= room && vertices <= room {
        return triangles;
    }
    (room / BYTES) as usize
}

/// The lists of all portions of `size` triangles as `lists_of` makes them. A portion that has no room is halved.
pub(super) fn lists(
    reference: &Reference,
    mut size: usize,
    mut lists_of: impl FnMut(&Reference) -> Result<Lists>,
) -> Result<Lists> {
    let count = reference.triangles.len();
    let (mut parts, mut at) = (Vec::new(), 0);
    while at < count {
        let range = at..(at + size.max(1)).min(count);
        let (first, length) = (range.start, range.len());
        match lists_of(&part(reference, range)) {
            Ok(lists) => {
                parts.push((first as u32, lists));
                at += length;
            }
            Err(Error::Capacity { .. }) if length > LEAST => size = length / 2,
            Err(error) => return Err(error),
        }
    }
    joined(parts)
}

/// Some triangles of a reference, with the vertices they need.
fn part(reference: &Reference, range: Range<usize>) -> Reference {
    const UNSEEN: u32 = u32::MAX;
    let mut number = vec![UNSEEN; reference.t3.len()];
    let mut t3 = Vec::new();
    let mut place = |v: u32| {
        let number = &mut number[v as usize];
        if *number == UNSEEN {
            *number = t3.len() as u32;
            t3.push(reference.t3[v as usize]);
        }
        *number
    };
    let triangles = reference.triangles[range.clone()]
        .iter()
        .map(|t| [place(t[0]), place(t[1]), place(t[2])])
        .collect();
    Reference {
        primary: reference.primary,
        layout: reference.layout,
        format: reference.format,
        t3,
        triangles,
        layer: reference.layer[range].to_vec(),
    }
}

/// One list for each texel out of those of portions, each with the number of its first triangle.
fn joined(parts: Vec<(u32, Lists)>) -> Result<Lists> {
    let entries: u64 = parts.iter().map(|(_, part)| part.items.len() as u64).sum();
    if entries > i32::MAX as u64 {
        return Err(Error::Capacity {
            what: "list entries".into(),
            need: entries,
            have: i32::MAX as u64,
        });
    }
    let places = parts.first().map_or(1, |(_, part)| part.start.len());
    let mut start = vec![0u32; places];
    start.par_iter_mut().enumerate().for_each(|(t, start)| {
        *start = parts.iter().map(|(_, part)| part.start[t]).sum();
    });
    let mut items = vec![0u32; entries as usize];
    let mut rest = items.as_mut_slice();
    let mut bands = Vec::new();
    for first in (0..places - 1).step_by(BAND) {
        let end = (first + BAND).min(places - 1);
        let (band, others) = rest.split_at_mut((start[end] - start[first]) as usize);
        bands.push((first..end, band));
        rest = others;
    }
    bands.into_par_iter().for_each(|(texels, band)| {
        let mut at = 0;
        for texel in texels {
            for (first, part) in &parts {
                for item in part.of(texel) {
                    band[at] = first + item;
                    at += 1;
                }
            }
        }
    });
    Ok(Lists { start, items })
}

#[cfg(test)]
mod tests {
    use super::super::super::Layout;
    use super::*;
    use crate::mesh::shapes;
    use crate::param::{Primary, PrimaryKind};

    /// Lists of one entry a texel: triangle t touches texels t and t + 1.
    fn touching(reference: &Reference) -> Lists {
        let count = reference.triangles.len() as u32;
        Lists {
            start: (0..=64u32).map(|t| t.min(count)).collect(),
            items: (0..count).collect(),
        }
    }

    #[test]
    fn portions_have_all_triangles_once_in_ascending_lists() {
        let mesh = shapes::grid(4);
        let primary = Primary::centred(PrimaryKind::UvSet(0), &mesh).unwrap();
        let layer = vec![0; 32];
        let reference = Reference::new(&mesh, &primary, &layer, Layout::Packed).unwrap();
        for size in [1, 5, 31, 32, 99] {
            let mut corners = Vec::new();
            let all = lists(&reference, size, |part| {
                corners.extend((0..part.triangles.len()).map(|t| part.corners(t)));
                Ok(touching(part))
            })
            .unwrap();
            let whole: Vec<_> = (0..32).map(|t| reference.corners(t)).collect();
            assert_eq!(corners, whole);
            let mut items = all.items.clone();
            items.sort_unstable();
            assert_eq!(items, (0..32).collect::<Vec<_>>());
            assert!((0..64).all(|t| all.of(t).is_sorted()));
        }
    }

    #[test]
    fn portions_without_room_are_halved_and_other_errors_stay() {
        let mesh = shapes::grid(40);
        let primary = Primary::centred(PrimaryKind::UvSet(0), &mesh).unwrap();
        let layer = vec![0; mesh.triangles.len()];
        let reference = Reference::new(&mesh, &primary, &layer, Layout::Packed).unwrap();
        let full = || Error::Capacity {
            what: "room".into(),
            need: 2,
            have: 1,
        };
        let mut sizes = Vec::new();
        let lists_of = |part: &Reference| {
            sizes.push(part.triangles.len());
            let lists = Lists {
                start: vec![0; 65],
                items: Vec::new(),
            };
            if sizes.len() > 2 {
                Ok(lists)
            } else {
                Err(full())
            }
        };
        lists(&reference, 3200, lists_of).unwrap();
        assert_eq!(sizes, [3200, 1600, 800, 800, 800, 800]);
        assert!(lists(&reference, 3200, |_| Err(full())).is_err());
        let lost = || Err(Error::Cancelled);
        assert!(matches!(
            lists(&reference, 3200, |_| lost()),
            Err(Error::Cancelled)
        ));
    }
}
