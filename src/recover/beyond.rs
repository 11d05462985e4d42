//! Which texels are neighbours across the borders of tiles (UDIM): [`super::continuity`] from one texture into another.
//!
//! In: surfaces, some of them tiles of one mesh, and the neighbours within each. Out: [`Beyond`]: for steps that leave a tile by
//! an edge that another tile of its mesh has too, the texel there.

use super::continuity::{Crossing, Links, Walk};
use super::laid::Laid;
use crate::mesh::NONE;
use rayon::prelude::*;
use std::collections::{BTreeMap, HashMap};

/// A texel of another surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct There {
    /// The surface's number.
    pub(super) low: usize,
    /// The texel's, there.
    pub(super) texel: u32,
}

/// For the number of a texel and a way (left, right, up, down) the neighbour in another tile.
pub(super) type Beyond = HashMap<(u32, usize), There>;

/// The ends of an edge, to the bit: tiles have copies of what they share.
type Ends = [[u32; 3]; 2];

/// An edge of a tile with nothing beyond: triangle and corner where it begins.
struct Rim {
    tile: usize,
    t: usize,
    k: usize,
}

/// Neighbours in other tiles of each of `lows`, whose own neighbours are `links`.
pub(super) fn beyond(lows: &[&Laid], links: &[Links], size: u32) -> Vec<Beyond> {
    let mut meshes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (k, low) in lows.iter().enumerate() {
        meshes.entry(low.number).or_default().push(k);
    }
    let mut out = vec![Beyond::new(); lows.len()];
    for tiles in meshes.values().filter(|tiles| tiles.len() > 1) {
        let walks: Vec<Walk> = tiles.iter().map(|&k| Walk::new(lows[k], size)).collect();
        let rims = rims(&walks);
        for (own, &low) in tiles.iter().enumerate() {
            let open = links[low].open();
            let found = open.into_par_iter().filter_map(|(texel, way)| {
                let left = walks[own].border(links[low].texels[texel as usize], way)?;
                let (tile, place) = across(&walks, &rims, own, &left)?;
                let low = tiles[tile];
                let there = links[low].at_place(place);
                (there != NONE).then_some(((texel, way), There { low, texel: there }))
            });
            out[low] = found.collect();
        }
    }
    out
}

/// All edges of tiles with nothing beyond.
fn rims(walks: &[Walk]) -> HashMap<Ends, Vec<Rim>> {
    let mut all: HashMap<Ends, Vec<Rim>> = HashMap::new();
    for (tile, walk) in walks.iter().enumerate() {
        for (t, across) in walk.across.iter().enumerate() {
            for k in (0..3).filter(|&k| across[k] == NONE) {
                let ends = sorted(ends(walk, t, k));
                all.entry(ends).or_default().push(Rim { tile, t, k });
            }
        }
    }
    all
}

fn ends(walk: &Walk, t: usize, k: usize) -> Ends {
    [k, (k + 1) % 3].map(|k| walk.low.world.corners(t)[k].map(f32::to_bits))
}

fn sorted([a, b]: Ends) -> Ends {
    [a.min(b), a.max(b)]
}

/// The tile and the place in it of the texel beyond where tile `own` is left.
fn across(
    walks: &[Walk],
    rims: &HashMap<Ends, Vec<Rim>>,
    own: usize,
    left: &Crossing,
) -> Option<(usize, u32)> {
    let here = ends(&walks[own], left.t, left.k);
    let rim = rims.get(&sorted(here))?.iter().find(|r| r.tile != own)?;
    let walk = &walks[rim.tile];
    let next = (rim.k + 1) % 3;
    // Neighbours run along their edge in opposite directions, unless one of them is turned round.
    let both = match ends(walk, rim.t, rim.k) == here {
        true => [rim.k, next],
        false => [next, rim.k],
    };
    let uv = walk.landed(rim.t, both, left.share)?;
    Some((rim.tile, walk.place_of(rim.t, uv)?))
}
