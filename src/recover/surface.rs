//! The surfaces that a built model's textures are baked for, and the reference's point under each sample of them.
//!
//! In: a built mesh, what textures are laid out over. Out: for a sample of a texel its point of the reference, which has no
//! triangle where the tables know none.

use super::low::{Corners, unwrapped};
use super::resample::{BAND, Band, Fineness, Sample, Surface};
use super::source::Low;
use super::texel::{self, Flat};
use super::{address, atlas};
use crate::Result;
use crate::asset::BuiltMesh;
use crate::attribute::surface::SurfacePoint;
use crate::igt::Asker;
use crate::lod::Lod;
use crate::mesh::Mesh;
use crate::render::{Drawn, inverse_at, level_zero};
use std::ops::Range;

/// A LoD, cut along its atlas.
pub(super) struct OverLod<'a> {
    built: &'a BuiltMesh,
    reference: &'a Mesh,
    pub(super) low: Mesh,
    lod: Lod,
    tiles: Tiles,
}

/// Triangles that reach into each band of a texture, and how fine it is.
pub(super) struct Tiles {
    bands: Vec<Vec<u32>>,
    fineness: Fineness,
}

/// Which triangle owns each sample of some rows of texels.
pub(super) struct Owners {
    /// Samples along a side.
    pub(super) size: u32,
    first_row: u32,
    owner: Vec<u32>,
}

impl Tiles {
    pub(super) fn new(low: &Mesh, fineness: Fineness) -> Tiles {
        let fine = fineness.size * fineness.samples;
        Tiles {
            bands: texel::bands(low, fine, BAND * fineness.samples),
            fineness,
        }
    }

    pub(super) fn owners(&self, low: &Mesh, rows: &Range<u32>) -> Owners {
        let Fineness { size, samples, .. } = self.fineness;
        let band = &self.bands[(rows.start / BAND) as usize];
        let fine = rows.start * samples..rows.end * samples;
        Owners {
            size: size * samples,
            first_row: fine.start,
            owner: texel::owners(low, band.iter().copied(), size * samples, fine),
        }
    }
}

impl Owners {
    /// The triangle that owns a sample.
    pub(super) fn of(&self, [x, y]: [u32; 2]) -> Option<usize> {
        let t = self.owner[((y - self.first_row) * self.size + x) as usize];
        (t != u32::MAX).then_some(t as usize)
    }
}

impl<'a> OverLod<'a> {
    pub(super) fn new(
        built: &'a BuiltMesh,
        reference: &'a Mesh,
        level: usize,
        fineness: Fineness,
    ) -> Result<Self> {
        let lod = match level {
            0 => level_zero(reference, &built.tables, &built.triangle_layer),
            k => built.lods[k - 1].clone(),
        };
        let atlas = atlas::of(&lod, &built.tables.primary, fineness.size)?;
        let low = unwrapped(reference, &lod, &atlas);
        Ok(OverLod {
            tiles: Tiles::new(&low, fineness),
            built,
            reference,
            low,
            lod,
        })
    }

    /// The point of a sample on triangle `t` of the LoD, and where in that triangle it lies.
    fn at(&self, t: usize, at: [u32; 2], size: u32) -> (Option<SurfacePoint>, [f32; 3]) {
        let flat = Flat::new(&texel::corners(&self.low, t, size));
        let centre = at.map(|c| f64::from(c) + 0.5);
        let b = |dx: f64, dy: f64| flat.barycentric([centre[0] + dx, centre[1] + dy]);
        let t3 = self.lod.triangles[t].map(|v| self.lod.t3[v as usize]);
        let line = self.built.tables.primary.line();
        let here = b(0.0, 0.0).unwrap_or([1.0, 0.0, 0.0]);
        let drawn = Drawn {
            b: here,
            bx: b(1.0, 0.0),
            by: b(0.0, 1.0),
            local: 0,
            vertex: [0; 3],
            asker: Asker::of_lod(line, &self.lod, t).word(),
        };
        let point = inverse_at(&self.built.tables, 0, &t3.map(four), &drawn).point;
        (point, here)
    }
}

impl Surface for OverLod<'_> {
    fn name(&self) -> &str {
        &self.reference.name
    }

    fn band(&self, rows: Range<u32>) -> Box<dyn Band + '_> {
        let owners = self.tiles.owners(&self.low, &rows);
        Box::new(LodBand {
            of: self,
            owners,
            corners: Corners::default(),
        })
    }

    fn corners(&self, triangle: u32) -> [[f32; 3]; 3] {
        self.reference.corners(triangle as usize)
    }
}

struct LodBand<'a> {
    of: &'a OverLod<'a>,
    owners: Owners,
    /// Those of the triangle at hand.
    corners: Corners,
}

impl Band for LodBand<'_> {
    fn sample(&mut self, fine: [u32; 2]) -> Option<Sample<'_>> {
        let t = self.owners.of(fine)?;
        let (point, b) = self.of.at(t, fine, self.owners.size);
        self.corners = Corners::of(&self.of.low, t);
        Some(Sample {
            missed: point.is_none(),
            point,
            low: Some(Low {
                corners: &self.corners,
                b,
            }),
        })
    }
}

/// The primary parameterization's unit square of addresses.
pub(super) struct OverPrimary<'a> {
    built: &'a BuiltMesh,
    reference: &'a Mesh,
    /// Samples along a side.
    size: u32,
}

impl<'a> OverPrimary<'a> {
    pub(super) fn new(built: &'a BuiltMesh, reference: &'a Mesh, fineness: Fineness) -> Self {
        OverPrimary {
            built,
            reference,
            size: fineness.size * fineness.samples,
        }
    }
}

impl Surface for OverPrimary<'_> {
    fn name(&self) -> &str {
        &self.reference.name
    }

    fn band(&self, _: Range<u32>) -> Box<dyn Band + '_> {
        Box::new(PrimaryBand(self))
    }

    fn corners(&self, triangle: u32) -> [[f32; 3]; 3] {
        self.reference.corners(triangle as usize)
    }
}

struct PrimaryBand<'a>(&'a OverPrimary<'a>);

impl Band for PrimaryBand<'_> {
    fn sample(&mut self, fine: [u32; 2]) -> Option<Sample<'_>> {
        Some(Sample {
            point: Some(self.0.at_address(fine)?),
            missed: false,
            low: None,
        })
    }
}

impl OverPrimary<'_> {
    /// The point with the address of a sample.
    fn at_address(&self, at: [u32; 2]) -> Option<SurfacePoint> {
        let side = f64::from(self.size);
        let middle = at.map(|c| (f64::from(c) + 0.5) / side);
        address::asked(&self.built.tables, middle, 1.0 / side, Asker::default())
    }
}

fn four([x, y, z]: [i32; 3]) -> [i32; 4] {
    [x, y, z, 0]
}
