//! The surface that textures are baked for, and the reference's point under each sample of it.
//!
//! In: a built mesh, what textures are laid out over. Out: for a sample of a texel its point of the reference, which has no
//! triangle where the tables know none.

use super::bake::{BakeSettings, Over};
use super::low::unwrapped;
use super::source::Low;
use super::{address, atlas, texel};
use crate::Result;
use crate::asset::BuiltMesh;
use crate::attribute::surface::SurfacePoint;
use crate::igt::{Asker, layout};
use crate::lod::Lod;
use crate::mesh::Mesh;
use crate::render::{Drawn, inverse_at, level_zero};
use std::ops::Range;

/// Rows of texels in a band.
pub(super) const BAND: u32 = 16;

/// The surface that is baked for.
pub(super) struct Surface<'a> {
    built: &'a BuiltMesh,
    pub(super) reference: &'a Mesh,
    /// None over the primary. The LoD cut along its atlas, and the LoD.
    pub(super) low: Option<(Mesh, Lod)>,
    /// Triangles of the LoD that reach into each band.
    bands: Vec<Vec<u32>>,
}

/// A sample that lies on the surface.
pub(super) struct Sample<'a> {
    pub(super) point: Option<SurfacePoint>,
    pub(super) low: Option<Low<'a>>,
}

impl<'a> Surface<'a> {
    pub(super) fn new(
        built: &'a BuiltMesh,
        reference: &'a Mesh,
        settings: &BakeSettings,
    ) -> Result<Self> {
        let mut surface = Surface {
            built,
            reference,
            low: None,
            bands: Vec::new(),
        };
        if let Over::Lod(level) = settings.over {
            let lod = match level {
                0 => level_zero(reference, &built.tables, &built.triangle_layer),
                k => built.lods[k - 1].clone(),
            };
            let atlas = atlas::of(&lod, &built.tables.primary, settings.size)?;
            let low = unwrapped(reference, &lod, &atlas);
            let fine = settings.size * settings.samples;
            surface.bands = texel::bands(&low, fine, BAND * settings.samples);
            surface.low = Some((low, lod));
        }
        Ok(surface)
    }

    /// Which triangle of the LoD owns each sample of some rows of texels.
    pub(super) fn owners(&self, rows: &Range<u32>, size: u32, samples: u32) -> Vec<u32> {
        let Some((low, _)) = &self.low else {
            return Vec::new();
        };
        let band = &self.bands[(rows.start / BAND) as usize];
        let rows = rows.start * samples..rows.end * samples;
        texel::owners(low, band.iter().copied(), size * samples, rows)
    }

    pub(super) fn sample(
        &self,
        fine: [u32; 2],
        size: u32,
        rows: &Range<u32>,
        samples: u32,
        owners: &[u32],
    ) -> Option<Sample<'_>> {
        let Some((low, lod)) = &self.low else {
            return Some(Sample {
                point: Some(self.at_address(fine, size)?),
                low: None,
            });
        };
        let row = fine[1] - rows.start * samples;
        let t = owners[(row * size + fine[0]) as usize];
        (t != u32::MAX).then(|| self.on_lod(low, lod, t as usize, fine, size))
    }

    /// The point of a sample on triangle `t` of the LoD.
    fn on_lod<'b>(
        &self,
        low: &'b Mesh,
        lod: &Lod,
        t: usize,
        at: [u32; 2],
        size: u32,
    ) -> Sample<'b> {
        let corners = texel::corners(low, t, size);
        let centre = at.map(|c| f64::from(c) + 0.5);
        let b = |dx: f64, dy: f64| texel::barycentric(&corners, [centre[0] + dx, centre[1] + dy]);
        let t3 = lod.triangles[t].map(|v| lod.t3[v as usize]);
        let line = self.built.tables.primary.line();
        let here = b(0.0, 0.0).unwrap_or([1.0, 0.0, 0.0]);
        let drawn = Drawn {
            b: here,
            bx: b(1.0, 0.0),
            by: b(0.0, 1.0),
            local: 0,
            vertex: [0; 3],
            asker: Asker::of(line, &t3, lod.triangle_layer.get(t).copied()).word(),
        };
        Sample {
            point: inverse_at(&self.built.tables, 0, &t3.map(four), &drawn).point,
            low: Some(Low {
                mesh: low,
                corners: low.triangles[t],
                b: here,
            }),
        }
    }

    /// The point with the address of a sample.
    fn at_address(&self, at: [u32; 2], size: u32) -> Option<SurfacePoint> {
        let primary = &self.built.tables.primary;
        let (line, flat) = (primary.line(), layout::is_flat(primary));
        let middle = |c: u32, by: f64| (f64::from(c) + 0.5 + by) / f64::from(size);
        let point = |dx: f64, dy: f64| {
            four(address::point(
                line,
                flat,
                [middle(at[0], dx), middle(at[1], dy)],
            ))
        };
        let drawn = Drawn {
            b: [1.0, 0.0, 0.0],
            bx: Some([0.0, 1.0, 0.0]),
            by: Some([0.0, 0.0, 1.0]),
            local: 0,
            vertex: [0; 3],
            asker: Asker::default().word(),
        };
        let t3 = [point(0.0, 0.0), point(1.0, 0.0), point(0.0, 1.0)];
        inverse_at(&self.built.tables, 0, &t3, &drawn).point
    }
}

fn four([x, y, z]: [i32; 3]) -> [i32; 4] {
    [x, y, z, 0]
}
