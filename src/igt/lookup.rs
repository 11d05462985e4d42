//! The lookup: from a T3 point to the reference point it stands for. Twin of `glsl/common/igt.glsl`.
//!
//! In: [`Tables`], a query-grid point, the [`Asker`]: layer and side of the LoD triangle that asks. Out: [`Found`].
//!
//! Among several hits (the surface overlaps itself in T3) the policy is: the same layer first (*same part*), in it the
//! same side of the surface (*same side*: the outer wall of a cap never shows its inner one), then the hit closest to the
//! query (*closest*, the paper's), then the lowest triangle id. Without a hit of the layer the nearest point of its listed
//! triangles (the gutter), then a hit of another layer, then the nearest point of any. LoD triangles that projection
//! lines run along (the sill of a window, under a cylinder) get the nearest point at once.
//!
//! The walk reads the records of the asker's layer only, and ends at the first hit where the list says that no other can
//! follow; other layers are asked where the own one is not listed at all.
//! Source: Inverse Geometric Textures, sections 2.2 and 5.

use super::layout;
use super::layout::classic::LONG;
use super::layout::packed::{self, Head, Kind, Rest, Run};
use super::{Asker, Layout, Tables};
use crate::param::projection::{self, GridTriangle, Sides};
use std::ops::ControlFlow::{self, Break, Continue};

/// Offsets are scaled by this before float arithmetic, so that no product leaves f32's range.
const OFFSET_SCALE: f32 = 1.0 / (1 << 20) as f32;

/// The answer of a lookup.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Found {
    /// The reference triangle.
    pub triangle: u32,
    /// Barycentric coordinates in it.
    pub barycentric: [f32; 3],
    /// Load instructions (up to 128 bits each) that the answer took.
    pub fetches: u32,
    /// Whether the projection line meets the triangle (`false`: the nearest point, outside every chart).
    pub hit: bool,
}

/// What a lookup took, whether it found anything or not.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Cost {
    /// Load instructions of up to 128 bits each.
    pub fetches: u32,
    /// Triangles tested.
    pub tests: u32,
}

/// Added to a candidate's rank: the hit shows the other side; there is no hit; the layer is another one.
const TURNED: u32 = 1;
const NO_HIT: u32 = 2;
const OTHER_LAYER: u32 = 4;
/// Over all ranks.
const NOTHING: u32 = 8;

#[derive(Clone, Copy)]
struct Candidate {
    rank: u32,
    distance: f32,
    triangle: u32,
    barycentric: [f32; 3],
}

impl Candidate {
    const NONE: Candidate = Candidate {
        rank: NOTHING,
        distance: 0.0,
        triangle: u32::MAX,
        barycentric: [0.0; 3],
    };

    fn better_than(&self, other: &Candidate) -> bool {
        (self.rank, self.distance, self.triangle) < (other.rank, other.distance, other.triangle)
    }
}

/// The list of a texel.
struct List {
    run: Run,
    rest: Rest,
    kind: Kind,
    /// The quadrant of its texel in which the query lies.
    quadrant: u32,
}

/// Which masked entries are read.
#[derive(Clone, Copy)]
enum Wanted {
    All,
    With(u32),
    Without(u32),
}

/// One lookup on its way.
struct Search<'a> {
    tables: &'a Tables,
    query: [i32; 3],
    asker: Asker,
    nearest: bool,
    best: Candidate,
    /// The region around the triangle tested last through which the line passes, see [`Sides::region`].
    region: u32,
    cost: Cost,
}

impl Tables {
    /// The reference point that `query` (query grid of [`Tables::primary`]) stands for. `asker`: the layer of the LoD
    /// triangle that asks and its side, or only the layer, `None` for any. `nearest`: whether points outside every
    /// chart get the nearest listed one.
    pub fn lookup(&self, query: [i32; 3], asker: impl Into<Asker>, nearest: bool) -> Option<Found> {
        self.lookup_with_cost(query, asker, nearest).0
    }

    /// [`lookup`](Self::lookup), and what it took also where it finds nothing.
    pub fn lookup_with_cost(
        &self,
        query: [i32; 3],
        asker: impl Into<Asker>,
        nearest: bool,
    ) -> (Option<Found>, Cost) {
        let mut search = Search {
            tables: self,
            query,
            asker: asker.into(),
            nearest,
            best: Candidate::NONE,
            region: 0,
            cost: Cost::default(),
        };
        search.walk(false);
        if search.best.rank == NOTHING && search.asker.layer.is_some() {
            search.walk(true);
        }
        let (best, cost) = (search.best, search.cost);
        let found = (best.rank < NOTHING).then_some(Found {
            triangle: best.triangle,
            barycentric: best.barycentric,
            fetches: cost.fetches,
            hit: best.rank & NO_HIT == 0,
        });
        (found, cost)
    }

    /// The corners of a triangle as the tables hold them, on the vertex grid.
    pub fn corners(&self, triangle: u32) -> GridTriangle {
        let flat = layout::is_flat(&self.primary);
        self.format.record.read(&self.triangle, triangle, flat).0
    }
}

impl Search<'_> {
    /// One walk over the texel's list: entries of the asker's layer, or those of all `others`.
    fn walk(&mut self, others: bool) {
        match self.tables.layout {
            Layout::Packed => self.walk_packed(others),
            Layout::Classic => self.walk_classic(others),
        }
    }

    fn walk_packed(&mut self, others: bool) {
        let format = self.tables.format;
        let Some(mut list) = self.list() else {
            return;
        };
        let kind = list.kind;
        if others && !kind.mixed {
            // All its entries counted as the asker's.
            return;
        }
        let bits = format.entry_bits(kind.mixed);
        while let Some(one) = list.run.next(bits, false) {
            let (triangle, layer) = format.split(kind.mixed, one.entry);
            if self.visit(triangle, layer, others, kind.single).is_break() {
                return;
            }
        }
        if list.rest == Rest::None {
            return;
        }
        let wanted = match (kind.sorted, self.region) {
            (true, 0) => Wanted::All,
            (true, region) => Wanted::With(1 << (region - 1)),
            (false, _) => Wanted::With(1 << list.quadrant),
        };
        if self.walk_blocks(list.rest, kind, others, wanted).is_break() {
            return;
        }
        if let (true, Wanted::With(region)) = (kind.sorted, wanted)
            && self.nearest
            && self.best.rank >= NO_HIT
        {
            // No hit: what the first triangle's test ruled out may be nearest.
            let _ = self.walk_blocks(list.rest, kind, others, Wanted::Without(region));
        }
    }

    /// The wanted entries in blocks; breaks where nothing better can follow.
    fn walk_blocks(
        &mut self,
        mut rest: Rest,
        kind: Kind,
        others: bool,
        wanted: Wanted,
    ) -> ControlFlow<()> {
        let (tables, format) = (self.tables, self.tables.format);
        let bits = format.entry_bits(kind.mixed);
        loop {
            let mut run;
            (run, rest) = match rest {
                Rest::None => return Continue(()),
                Rest::Half(unit) => (packed::half_run(&tables.list, unit, bits), Rest::None),
                Rest::Full(unit) => {
                    let (run, last) = packed::full_run(&tables.list, unit, bits);
                    (
                        run,
                        if last {
                            Rest::None
                        } else {
                            Rest::Full(unit + 2)
                        },
                    )
                }
            };
            self.cost.fetches += 1;
            while let Some(one) = run.next(bits, true) {
                let listed = match wanted {
                    Wanted::All => true,
                    Wanted::With(bit) => one.mask & bit != 0,
                    Wanted::Without(bit) => one.mask & bit == 0,
                };
                if listed {
                    let (triangle, layer) = format.split(kind.mixed, one.entry);
                    self.visit(triangle, layer, others, kind.single)?;
                }
            }
        }
    }

    /// The list of the query's texel, down through divided texels.
    fn list(&mut self) -> Option<List> {
        let (tables, line) = (self.tables, self.tables.primary.line());
        let mut bits = tables.bits();
        let mut at = tables.window.index(line.texel(bits, self.query))?;
        loop {
            self.cost.fetches += 1;
            let words = [tables.hash[2 * at], tables.hash[2 * at + 1]];
            match packed::head(words) {
                Head::Empty => return None,
                Head::List { run, rest, kind } => {
                    let [x, y] = line.texel(bits + 1, self.query);
                    return Some(List {
                        run,
                        rest,
                        kind,
                        quadrant: (y & 1) << 1 | x & 1,
                    });
                }
                Head::Divided { first, by } => {
                    bits += by;
                    let [x, y] = line.texel(bits, self.query);
                    let within = (1 << by) - 1;
                    at = first + ((y & within) << by | x & within) as usize;
                }
            }
        }
    }

    fn walk_classic(&mut self, others: bool) {
        let (tables, bits) = (self.tables, self.tables.bits());
        let [x, y] = tables.primary.line().texel(bits, self.query);
        let word = tables.hash[(y << bits | x) as usize];
        self.cost.fetches += 1;
        let (mut start, mut length) = ((word & 0xff_ffff) as usize, word >> 24);
        if length == LONG {
            length = tables.list[start];
            start += 1;
            self.cost.fetches += 1;
        }
        for entry in &tables.list[start..start + length as usize] {
            self.cost.fetches += 1;
            // The paper's lists do not say that a hit is the only one.
            let layer = Some((entry >> 24) as u8);
            let _ = self.visit(entry & 0xff_ffff, layer, others, false);
        }
    }

    /// An entry; breaks where nothing better can follow. An entry without a layer counts as the asker's: all its list is
    /// of one layer.
    fn visit(
        &mut self,
        triangle: u32,
        layer: Option<u8>,
        others: bool,
        single: bool,
    ) -> ControlFlow<()> {
        let other = layer.is_some_and(|l| self.asker.layer.is_some_and(|own| own != l));
        if other != others {
            return Continue(());
        }
        let tables = self.tables;
        let flat = layout::is_flat(&tables.primary);
        let (corners, loads) = tables.format.record.read(&tables.triangle, triangle, flat);
        self.cost.fetches += loads;
        self.cost.tests += 1;
        let Some(candidate) = self.candidate(triangle, &corners, u32::from(other) * OTHER_LAYER)
        else {
            return Continue(());
        };
        if candidate.better_than(&self.best) {
            self.best = candidate;
        }
        // Layers may overlap one another: an asker without a layer looks on where there are several.
        let only = single && (self.asker.layer.is_some() || layer.is_none());
        if only && !others && candidate.rank <= TURNED {
            Break(())
        } else {
            Continue(())
        }
    }

    fn candidate(&mut self, triangle: u32, corners: &GridTriangle, rank: u32) -> Option<Candidate> {
        let (line, query) = (self.tables.primary.line(), self.query);
        let grazed = self.nearest && self.asker.grazed;
        let mut hit = None;
        self.region = 0;
        if !grazed {
            let sides = Sides::of(line, query, corners);
            hit = sides.hit(line, query, corners);
            self.region = sides.region();
        }
        let w = corners.map(|v| projection::offset(v, query).map(|x| x as f32 * OFFSET_SCALE));
        if let Some(hit) = hit {
            let barycentric = hit.barycentric();
            let turned = u32::from(self.asker.side * hit.sense < 0) * TURNED;
            return Some(Candidate {
                rank: rank + turned,
                distance: projection::squared_length(projection::combine(barycentric, w)),
                triangle,
                barycentric,
            });
        }
        self.nearest.then(|| {
            let (barycentric, distance) = projection::nearest(w);
            Candidate {
                rank: rank + NO_HIT,
                distance,
                triangle,
                barycentric,
            }
        })
    }
}

#[cfg(test)]
mod tests;
