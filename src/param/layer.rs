//! Parts of a reference mesh and the layers that tell overlapping parts apart.
//!
//! In: a mesh and its primary. Out: [`Parts`]: for each triangle its connected part and a small layer number, such that two
//! parts with the same layer never answer for the same place. A LoD triangle carries its part's layer, and a lookup prefers
//! hits of that layer: a body under a cap never shows the cap.
//!
//! Greedy colouring without a graph: every cell of a coarse raster of the hash domain remembers, as a 256-bit set, the layers
//! already used there; a part takes the lowest layer that is free under its whole (dilated) footprint. Cost is linear in
//! the cells touched.

use super::Primary;
use super::fit_domain::{Domain, Piece};
use super::fit_surface::{parts_of, t3_points};
use crate::mesh::Mesh;

/// Cells along a side of a flat raster.
pub const RASTER_CELLS: usize = 512;
/// Cells along a side of one of a cylinder's or sphere's sheets.
const SHEET_CELLS: usize = 256;
/// Footprints keep this many cells between each other, twice: room for a LoD that reaches over its part's border.
pub const DILATION: usize = 2;
/// Layers that are nobody else's; the last one is shared by all parts that find none.
pub const LAYERS: usize = 255;

/// Cells that may be looked at in all: parts that come after them share the last layer, so that a heap of huge
/// overlapping triangles takes seconds, not hours.
const MOST_VISITS: usize = 1 << 30;

/// Connected parts of a mesh and their layers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Parts {
    /// For each triangle its part, `0..part_count`.
    pub triangle_part: Vec<u32>,
    /// For each triangle its layer, `0..255`.
    pub triangle_layer: Vec<u8>,
    /// Number of parts.
    pub part_count: usize,
    /// Parts that found no free layer and share the last one: there the layer does not tell parts apart.
    pub crowded_parts: usize,
}

/// The set of layers used in a cell.
#[derive(Clone, Copy, Default)]
struct Layers([u64; 4]);

impl Layers {
    fn insert(&mut self, layer: usize) {
        self.0[layer / 64] |= 1 << (layer % 64);
    }

    fn join(&mut self, other: &Layers) {
        (0..4).for_each(|i| self.0[i] |= other.0[i]);
    }

    /// The lowest layer that is not in the set.
    fn lowest_free(&self) -> usize {
        self.0
            .iter()
            .enumerate()
            .find(|&(_, &w)| w != u64::MAX)
            .map_or(256, |(i, w)| i * 64 + w.trailing_ones() as usize)
    }
}

/// The parts of `mesh` under `primary`, with layers. Deterministic; parts are numbered by their first triangle.
pub fn parts(mesh: &Mesh, primary: &Primary) -> Parts {
    let found = parts_of(mesh, primary.kind);
    let mut parts = Parts {
        triangle_layer: vec![0; found.of.len()],
        triangle_part: found.of,
        part_count: found.count,
        crowded_parts: 0,
    };
    if parts.part_count > 1 {
        colour(mesh, primary, &mut parts);
    }
    parts
}

fn colour(mesh: &Mesh, primary: &Primary, parts: &mut Parts) {
    let origin = primary.frame.origin;
    let points: Vec<[f64; 3]> = t3_points(mesh, primary.kind)
        .iter()
        .map(|p| [0, 1, 2].map(|k| p[k] - origin[k]))
        .collect();
    let mut raster = Raster::new(primary, &points);
    let corners = |t: u32| mesh.triangles[t as usize].map(|v| points[v as usize]);
    for (number, group) in by_part(parts).into_iter().enumerate() {
        let footprint = raster.footprint(number as u32 + 1, group.iter().map(|&t| corners(t)));
        let Some(footprint) = footprint else {
            group
                .iter()
                .for_each(|&t| parts.triangle_layer[t as usize] = LAYERS as u8 - 1);
            parts.crowded_parts += 1;
            continue;
        };
        let mut used = Layers::default();
        footprint
            .iter()
            .for_each(|&cell| used.join(&raster.cells[cell as usize]));
        let mut layer = used.lowest_free();
        if layer >= LAYERS {
            layer = LAYERS - 1;
            parts.crowded_parts += 1;
        }
        footprint
            .iter()
            .for_each(|&cell| raster.cells[cell as usize].insert(layer));
        group
            .iter()
            .for_each(|&t| parts.triangle_layer[t as usize] = layer as u8);
    }
}

/// Triangles grouped by part; the groups with most triangles first (large parts get low layers), then by number.
fn by_part(parts: &Parts) -> Vec<Vec<u32>> {
    let mut groups = vec![vec![]; parts.part_count];
    for (t, &part) in parts.triangle_part.iter().enumerate() {
        groups[part as usize].push(t as u32);
    }
    groups.sort_by_key(|group: &Vec<u32>| std::cmp::Reverse(group.len()));
    groups
}

/// Cells of all sheets of the hash domain.
struct Raster {
    domain: Domain,
    side: usize,
    cells: Vec<Layers>,
    /// For each cell the last part whose footprint it was in, so that a footprint lists it once.
    stamps: Vec<u32>,
    /// Cells that may still be looked at.
    visits_left: usize,
}

impl Raster {
    fn new(primary: &Primary, points: &[[f64; 3]]) -> Self {
        // Sheets overlap by more than the dilation, so that parts on both sides of a fold meet.
        let apron = 2.0 * (2 * DILATION + 2) as f64 / SHEET_CELLS as f64;
        let domain = Domain::new(primary.kind, points, apron);
        let side = if domain.sheets() == 1 {
            RASTER_CELLS
        } else {
            SHEET_CELLS
        };
        let count = domain.sheets() * side * side;
        Raster {
            cells: vec![Layers::default(); count],
            stamps: vec![0; count],
            domain,
            side,
            visits_left: MOST_VISITS,
        }
    }

    /// The cells of the triangles' bounding rectangles, grown by [`DILATION`], each once; `None` when
    /// [`MOST_VISITS`] are used up. `stamp` is the part's own number, not 0.
    fn footprint(
        &mut self,
        stamp: u32,
        triangles: impl Iterator<Item = [[f64; 3]; 3]>,
    ) -> Option<Vec<u32>> {
        let (domain, side) = (self.domain, self.side);
        let mut footprint = vec![];
        for triangle in triangles {
            domain.pieces(&triangle, |piece| {
                let [columns, rows] = cells(&piece, side);
                let visits = columns.len() * rows.len();
                if visits > self.visits_left {
                    self.visits_left = 0;
                    return;
                }
                self.visits_left -= visits;
                for row in rows {
                    for column in columns.clone() {
                        let cell = (piece.sheet * side + row) * side + column;
                        if self.stamps[cell] != stamp {
                            self.stamps[cell] = stamp;
                            footprint.push(cell as u32);
                        }
                    }
                }
            });
            if self.visits_left == 0 {
                return None;
            }
        }
        Some(footprint)
    }
}

/// Columns and rows of the cells that a rectangle on a sheet touches, grown by [`DILATION`] and cut to the sheet.
fn cells(piece: &Piece, side: usize) -> [std::ops::Range<usize>; 2] {
    [0, 1].map(|i| {
        let cell = |x: f64| (x * side as f64).floor().clamp(0.0, side as f64 - 1.0) as usize;
        cell(piece.low[i]).saturating_sub(DILATION)..(cell(piece.high[i]) + DILATION + 1).min(side)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::param::PrimaryKind;

    #[test]
    fn a_footprint_ends_where_the_visits_do() {
        let mesh = shapes::grid(4);
        let primary = Primary::centred(PrimaryKind::UvSet(0), &mesh).unwrap();
        let points = t3_points(&mesh, primary.kind);
        let triangles: Vec<[[f64; 3]; 3]> = mesh
            .triangles
            .iter()
            .map(|t| t.map(|v| points[v as usize]))
            .collect();
        let mut raster = Raster::new(&primary, &points);
        let cells = raster.footprint(1, triangles.iter().copied()).unwrap();
        assert_eq!(
            cells.len(),
            RASTER_CELLS * RASTER_CELLS,
            "the unit square, each cell once"
        );
        raster.visits_left = 1000;
        assert_eq!(raster.footprint(2, triangles.iter().copied()), None);
        assert_eq!(raster.visits_left, 0, "and stays used up");
    }

    #[test]
    fn the_lowest_free_layer_is_found() {
        let mut layers = Layers::default();
        for expected in 0..256 {
            assert_eq!(layers.lowest_free(), expected);
            layers.insert(expected);
        }
        assert_eq!(layers.lowest_free(), 256);
    }
}
