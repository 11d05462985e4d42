//! Sampling uniformity, section 4.3: how the distances between neighbouring texels change on the way to the reference.

use crate::recover::{Finder, Laid, Links, centres};
use glam::DVec3;
use rayon::prelude::*;

/// Texels that one core works on at a time.
const CHUNK: usize = 4096;
/// Which neighbours: right and down, so that each pair counts once.
const PAIRS: [usize; 2] = [1, 3];

/// The mean of |d' / d - 1| over pairs of neighbouring texels of one chart, d their distance on the simple surface and d' that
/// of their points of the reference.
pub(super) fn measure(lows: &[&Laid], finders: &[Finder], size: u32) -> f64 {
    let (mut sum, mut pairs) = (0.0, 0u64);
    for (low, finder) in lows.iter().zip(finders) {
        let links = Links::new(low, size);
        let all = centres(low, &links, size);
        let points: Vec<(DVec3, Option<DVec3>)> = all
            .par_chunks(CHUNK)
            .flat_map_iter(|texels| {
                let mut search = finder.search();
                let point = move |&(t, b): &(usize, [f32; 3])| {
                    let found = search.at(t, b).found;
                    let there = found.map(|(triangle, b)| finder.high.point(triangle, b));
                    (wide(low.point(t, b)), there.map(wide))
                };
                texels.iter().map(point).collect::<Vec<_>>()
            })
            .collect();
        let parts: Vec<(f64, u64)> = (0..points.len())
            .into_par_iter()
            .chunks(CHUNK)
            .map(|texels| {
                let each = texels.iter().flat_map(|&k| changes(&links, &points, k));
                each.fold((0.0, 0), |(sum, n), change| (sum + change, n + 1))
            })
            .collect();
        for (part, n) in parts {
            sum += part;
            pairs += n;
        }
    }
    sum / pairs.max(1) as f64
}

fn wide(p: [f32; 3]) -> DVec3 {
    DVec3::from_array(p.map(f64::from))
}

/// The changes between texel `k` and its neighbours to the right and below.
fn changes(links: &Links, points: &[(DVec3, Option<DVec3>)], k: usize) -> Vec<f64> {
    let next = PAIRS.iter().filter_map(|&way| links.in_chart(k, way));
    let (p, f) = points[k];
    next.filter_map(|n| {
        let (q, g) = points[n];
        let (d, there) = (p.distance(q), f?.distance(g?));
        (d > 0.0).then(|| (there / d - 1.0).abs())
    })
    .collect()
}
