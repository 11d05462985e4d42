//! Which mapping serves each texel best: the one whose point lies nearest to what the reference shows there.
//!
//! In: both surfaces, directions of visibility. Out: for each texel of a coarse texture one of [`CHOICES`]. A texel's middle p is
//! looked at from each probe's direction that nothing of the simple surface hides; along that line the reference shows a
//! point q. The mapping with the smallest mean distance from F(p) to q is taken, each direction counted by the area it sees:
//! the object-space measure (section 4.1) of that texel, predicted from the probes, which are none of the views that
//! measure. Then texels whose neighbours nearly all agree on another choice follow them: a choice that changes from texel to
//! texel would tear what it shows.

use super::continuity::{Links, centres};
use super::find::{Finder, Search};
use super::high::High;
use super::laid::Laid;
use super::mapping::{Mapping, Recovery};
use super::visible::{Field, weighted};
use crate::attribute::arithmetic::{V3, add3, dot3, scale3, sub3};
use crate::mesh::NONE;
use crate::mesh::bvh::{Asking, Bvh, Ray, Sides};
use rayon::prelude::*;
use std::sync::Arc;

/// What is chosen from; of equally good ones the first.
pub(super) const CHOICES: [Mapping; 7] = [
    Mapping::Normal,
    Mapping::HybridVertex,
    Mapping::VisibilityVertex,
    Mapping::HybridTexel,
    Mapping::VisibilityTexel,
    Mapping::Cage,
    Mapping::Proximity,
];
/// Texels along a side of the texture that holds choices, at most.
const SIDE: u32 = 512;
/// How far from the surface sight begins, in diagonals.
const LIFT: f32 = 1e-4;
/// Rounds in which lone texels follow their neighbours.
const ROUNDS: usize = 2;
/// Texels that one core works on at a time.
const CHUNK: usize = 1024;

/// The field of [`Mapping::Auto`] for one of `lows`, whose directions at vertices and texels are known.
pub(super) fn choose(
    (high, lows): (&High, &[&Laid]),
    number: usize,
    recovery: &Recovery,
    reach: f32,
    (vertices, texels): (Arc<Field>, Arc<Field>),
    size: u32,
) -> Field {
    let low = lows[number];
    let size = size.min(SIDE);
    let links = Links::new(low, size);
    let blank = Recovery {
        misses: super::mapping::Misses::Blank,
        ..*recovery
    };
    let finders = CHOICES.map(|mapping| {
        let field = match mapping {
            Mapping::HybridTexel | Mapping::VisibilityTexel => &texels,
            _ => &vertices,
        };
        Finder::new((high, low), mapping, &blank, reach, Some(field))
    });
    let corners = lows.iter().flat_map(|low| {
        let of = |t: usize| low.world.corners(t);
        (0..low.world.triangles.len()).map(of)
    });
    let sight = Sight {
        high,
        hides: Bvh::new(&corners.collect::<Vec<_>>()),
        directions: weighted(&recovery.probes),
        far: 2.0 * high.tree.diagonal(),
    };
    let all = centres(low, &links, size);
    let best: Vec<u8> = all
        .par_chunks(CHUNK)
        .flat_map_iter(|texels| {
            let mut asking = (sight.hides.asking(), high.tree.asking());
            let mut searches: Vec<Search> = finders.iter().map(Finder::search).collect();
            let choice = |&(t, b): &(usize, [f32; 3])| {
                let points = searches.iter_mut().map(|s| s.at(t, b).found);
                let points = points.map(|found| found.map(|(f, b)| high.point(f, b)));
                let points: Vec<Option<V3>> = points.collect();
                sight.best(low, (t, b), &points, &mut asking)
            };
            texels.iter().map(choice).collect::<Vec<_>>()
        })
        .collect();
    let mut choice = vec![0; size as usize * size as usize];
    for (&at, best) in links.texels.iter().zip(calmed(&links, best)) {
        choice[at as usize] = best;
    }
    Field::Choice {
        vertices,
        texels,
        size,
        choice,
    }
}

struct Sight<'a> {
    high: &'a High,
    /// All simple surfaces.
    hides: Bvh,
    directions: Vec<([f64; 3], f32)>,
    far: f32,
}

impl Sight<'_> {
    /// The choice whose point is nearest in the mean to what is seen.
    fn best(
        &self,
        low: &Laid,
        (t, b): (usize, [f32; 3]),
        points: &[Option<V3>],
        asking: &mut (Asking, Asking),
    ) -> u8 {
        let p = low.point(t, b);
        let normal = low.world.face_normal(t).map(|c| c as f32);
        let begin = add3(p, scale3(normal, LIFT * self.far));
        let mut sums = [0.0f32; CHOICES.len()];
        for (direction, weight) in &self.directions {
            let towards = direction.map(|c| c as f32);
            let area = dot3(normal, towards) * weight;
            let ray = |begin: V3, way: V3| Ray {
                begin,
                way,
                reach: 2.0 * self.far,
                sides: Sides::Both,
            };
            if area <= 0.0 || asking.0.meets(ray(begin, towards)) {
                continue;
            }
            let outside = add3(p, scale3(towards, self.far));
            let Some(q) = asking.1.first(ray(outside, scale3(towards, -1.0))) else {
                continue;
            };
            let q = self.high.point(q.triangle, q.b);
            for (sum, point) in sums.iter_mut().zip(points) {
                let apart = point.map_or([0.0; 3], |f| sub3(f, q));
                *sum += area * dot3(apart, apart).sqrt();
            }
        }
        // Proximity always has a point, but for surfaces that all look away.
        let known = (0..CHOICES.len()).filter(|&k| points[k].is_some());
        let best = known.reduce(|best, k| if sums[k] < sums[best] { k } else { best });
        best.unwrap_or(CHOICES.len() - 1) as u8
    }
}

/// Texels follow three or four of their neighbours that agree.
fn calmed(links: &Links, mut choice: Vec<u8>) -> Vec<u8> {
    for _ in 0..ROUNDS {
        let calm = |k: usize| {
            let near = links.next[k].iter().filter(|&&n| n != NONE);
            let mut votes = [0u8; CHOICES.len()];
            near.for_each(|&n| votes[choice[n as usize] as usize] += 1);
            let most = (0..votes.len()).fold(0, |a, k| if votes[k] > votes[a] { k } else { a });
            if votes[most] >= 3 {
                most as u8
            } else {
                choice[k]
            }
        };
        choice = (0..choice.len()).into_par_iter().map(calm).collect();
    }
    choice
}
