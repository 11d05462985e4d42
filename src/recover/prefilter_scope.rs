//! Which of several surfaces over each other is filtered beforehand.
//!
//! In: the tables, the layers there are. Out: the [`Scope`] that fills most of a coarse raster; and the texels in which
//! another surface is seen.

use super::address;
use super::prefilter::{Filtering, places};
use crate::attribute::Scope;
use crate::igt::{Asker, layout};
use crate::param::grid::QUERY_SHIFT;
use crate::param::projection::orientation;
use rayon::prelude::*;

/// Texels along each side of a coarse raster.
const RASTER: usize = 64;

impl Filtering<'_> {
    /// For each texel of the first level whether another surface is seen in it than the one that is filtered.
    pub(super) fn unusable(&self) -> Vec<bool> {
        let side = self.size as usize;
        let texel = |i: usize| {
            let mut places = places(side, [i % side, i / side], 2);
            places.any(|st| self.sees(st) == Some(false))
        };
        (0..side * side).into_par_iter().map(texel).collect()
    }

    /// Whether the surface at an address is the one that is filtered; none where there is no surface.
    fn sees(&self, st: [f64; 2]) -> Option<bool> {
        let flat = layout::is_flat(&self.tables.primary);
        let query = address::point(self.line(), flat, st).map(|c| c << QUERY_SHIFT);
        let found = |side: i32| {
            let found = self.tables.lookup(query, self.asker(side), true);
            found.map(|found| found.triangle)
        };
        let side = self.scope.side.into();
        let triangle = found(side)?;
        let seen = match side {
            0 => found(1) == found(-1),
            side => orientation(self.line(), &self.tables.corners(triangle)) == side,
        };
        Some(seen && self.layer_of[triangle as usize] == self.scope.layer)
    }

    pub(super) fn asker(&self, side: i32) -> Asker {
        Asker {
            layer: Some(self.scope.layer),
            side,
            grazed: false,
        }
    }

    /// The scope that fills most of a coarse raster.
    pub(super) fn widest(&self, layers: &[u8]) -> Scope {
        let filled = |scope: Scope| {
            let one = Filtering { scope, ..*self };
            let seen = |st: &[f64; 2]| one.sees(*st) == Some(true);
            raster().filter(seen).count()
        };
        let scope = |layer, side| Scope {
            unlit: false,
            layer,
            side,
        };
        let all = layers
            .iter()
            .flat_map(|&layer| [0, 1, -1].map(|side| scope(layer, side)));
        // Of equals the first: the lowest layer, any side.
        all.rev()
            .max_by_key(|&scope| filled(scope))
            .unwrap_or_default()
    }

    /// Whether all of the surface is unlit, on a coarse raster.
    pub(super) fn is_unlit(&self) -> bool {
        let all: Vec<bool> = raster()
            .filter_map(|st| self.place(st, RASTER))
            .map(|p| self.seen(&p, [1.0, 1.0]).unlit)
            .collect();
        !all.is_empty() && all.into_iter().all(|unlit| unlit)
    }
}

/// Addresses of the middles of a coarse raster's texels.
fn raster() -> impl Iterator<Item = [f64; 2]> {
    places(1, [0, 0], RASTER)
}
