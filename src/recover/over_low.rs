//! A surface whose texels are looked for in another: what each sample of a texel stands for.

use super::find::{Finder, Search};
use super::low::Corners;
use super::resample::{Band, Sample, Surface};
use super::source::Low;
use super::surface::{Owners, Tiles};
use super::texel::{self, Flat};
use crate::attribute::arithmetic::{V3, dot3, sub3};
use crate::attribute::surface::SurfacePoint;
use crate::{Error, Result};
use std::ops::Range;

/// A surface whose texels are looked for in another.
pub(super) struct OverLow<'a> {
    pub(super) finder: Finder<'a>,
    pub(super) tiles: Tiles,
    /// Whether textures are sampled, so that the size of a texel counts.
    pub(super) gradients: bool,
    /// What messages call the reference.
    pub(super) reference: &'a str,
}

impl Surface for OverLow<'_> {
    fn name(&self) -> &str {
        &self.finder.low.object.name
    }

    fn band(&self, rows: Range<u32>) -> Box<dyn Band + '_> {
        Box::new(LowBand {
            of: self,
            owners: self.tiles.owners(&self.finder.low.world, &rows),
            search: self.finder.search_neighbours(),
            last: None,
        })
    }

    fn corners(&self, triangle: u32) -> [V3; 3] {
        self.finder.high.corners[triangle as usize]
    }

    fn check(&self, filled: u64, empty: u64) -> Result<()> {
        let reason = match (filled, empty) {
            (0, 0) => {
                "its texture coordinates cover no texel: ask for larger textures or another layout"
            }
            (0, _) => {
                "no texel has a point of the reference: are rays long enough, do surfaces face the same way?"
            }
            _ => return Ok(()),
        };
        let element = format!("mesh \"{}\"", self.name());
        Err(Error::input(self.reference, element, reason))
    }
}

struct LowBand<'a> {
    of: &'a OverLow<'a>,
    owners: Owners,
    search: Search<'a>,
    /// The triangle of the last sample: neighbours mostly lie in one.
    last: Option<Last>,
}

struct Last {
    t: usize,
    /// In texels.
    flat: Flat,
    corners: Corners,
}

impl Band for LowBand<'_> {
    fn sample(&mut self, fine: [u32; 2]) -> Option<Sample<'_>> {
        let t = self.owners.of(fine)?;
        let low = self.of.finder.low;
        let size = self.owners.size;
        let here = match self.last.take() {
            Some(last) if last.t == t => last,
            _ => Last {
                t,
                flat: Flat::new(&texel::corners(&low.world, t, size)),
                corners: Corners::of(&low.world, t),
            },
        };
        let Last { flat, corners, .. } = self.last.insert(here);
        let centre = fine.map(|c| f64::from(c) + 0.5);
        let b = flat.barycentric(centre)?;
        let answer = self.search.at(t, b);
        let point = answer.found.map(|(triangle, at)| {
            let step = |dx: f64, dy: f64| {
                let next = flat.barycentric([centre[0] + dx, centre[1] + dy])?;
                let way = sub3(low.point(t, next), low.point(t, b));
                along(&self.of.corners(triangle), way)
            };
            let [dx, dy] = match self.of.gradients {
                true => [step(1.0, 0.0), step(0.0, 1.0)],
                false => [None; 2],
            };
            SurfacePoint {
                triangle,
                b: at,
                dx,
                dy,
                taps: 0,
            }
        });
        Some(Sample {
            point,
            missed: answer.missed,
            low: Some(Low { corners, b }),
        })
    }
}

/// How barycentrics of a triangle change along `way`, as far as it runs in the triangle's plane.
fn along(corners: &[V3; 3], way: V3) -> Option<[f32; 3]> {
    let (e, f) = (sub3(corners[1], corners[0]), sub3(corners[2], corners[0]));
    let (ee, ef, ff) = (dot3(e, e), dot3(e, f), dot3(f, f));
    let (we, wf) = (dot3(way, e), dot3(way, f));
    let area = ee * ff - ef * ef;
    (area > 0.0).then(|| {
        let (v, w) = ((we * ff - wf * ef) / area, (wf * ee - we * ef) / area);
        [-v - w, v, w]
    })
}
