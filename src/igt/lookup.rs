//! The lookup: from a T3 point to the reference point it stands for. Twin of `glsl/common/igt.glsl`.
//!
//! In: [`Tables`], a query-grid point, the [`Asker`]: layer and side of the LoD triangle that asks. Out: [`Found`].
//!
//! Among several hits (the surface overlaps itself in T3) the policy is: the same layer first (*same part*), in it the
//! same side of the surface (*same side*: the outer wall of a cap never shows its inner one), then the hit closest to the
//! query (*closest*, the paper's), then the lowest triangle id. Without a hit of the layer the nearest point of its listed
//! triangles (the gutter), then a hit of another layer, then the nearest point of any. LoD triangles that projection
//! lines run along (the sill of a window, under a cylinder) get the nearest point at once.
//! Source: Inverse Geometric Textures, sections 2.2 and 5.

use super::layout::{self, EMPTY, LAST, LONG};
use super::{Layout, Tables};
use crate::param::projection::{self, GridTriangle, Line};

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

/// What a lookup prefers among several answers. `None::<u8>` or a layer alone convert to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asker {
    /// The layer of the LoD triangle's part; none for any.
    pub layer: Option<u8>,
    /// The sense in which projection lines meet the LoD triangle ([`projection::orientation`]); 0 for any.
    pub side: i32,
    /// Projection lines run along the LoD triangle ([`projection::is_grazed`]): a small deviation moves the hit far away,
    /// or to the wall behind. The nearest point is then the better answer, where it may be given.
    pub grazed: bool,
}

impl Asker {
    /// The asker as `igt_lookup` of `igt.glsl` takes it.
    pub fn word(self) -> u32 {
        let side = match self.side.signum() {
            0 => 0,
            1 => SIDE_FRONT,
            _ => SIDE_BACK,
        };
        let grazed = if self.grazed { GRAZED } else { 0 };
        self.layer.map_or(ANY_LAYER, u32::from) | side | grazed
    }

    /// The asker of a word; [`word`](Self::word) undone.
    pub fn from_word(word: u32) -> Self {
        Asker {
            layer: (word & ANY_LAYER == 0).then_some(word as u8),
            side: match word & (SIDE_FRONT | SIDE_BACK) {
                SIDE_FRONT => 1,
                SIDE_BACK => -1,
                _ => 0,
            },
            grazed: word & GRAZED != 0,
        }
    }

    /// Who asks for the fragments of a LoD triangle, T3 on the vertex grid.
    pub fn of(line: Line, corners: &GridTriangle, layer: Option<u8>) -> Self {
        Asker {
            layer,
            side: projection::orientation(line, corners),
            grazed: projection::is_grazed(line, corners),
        }
    }
}

impl From<Option<u8>> for Asker {
    fn from(layer: Option<u8>) -> Self {
        Asker {
            layer,
            ..Asker::default()
        }
    }
}

/// Bits of [`Asker::word`], as in `igt.glsl`.
const ANY_LAYER: u32 = 1 << 31;
const SIDE_FRONT: u32 = 1 << 8;
const SIDE_BACK: u32 = 1 << 9;
const GRAZED: u32 = 1 << 10;

/// For each triangle of a LoD the [`Asker::word`] its fragments ask with; T3 on the vertex grid.
pub fn askers(line: Line, t3: &[[i32; 3]], triangles: &[[u32; 3]], layers: &[u8]) -> Vec<u32> {
    let asker = |(triangle, &layer): (&[u32; 3], &u8)| {
        let corners = triangle.map(|v| t3[v as usize]);
        Asker::of(line, &corners, Some(layer)).word()
    };
    triangles.iter().zip(layers).map(asker).collect()
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

impl Tables {
    /// The reference point that `query` (query grid of [`Tables::primary`]) stands for. `asker`: the layer of the LoD
    /// triangle that asks and its side, or only the layer, `None` for any. `nearest`: whether points outside every
    /// chart get the nearest listed one.
    pub fn lookup(&self, query: [i32; 3], asker: impl Into<Asker>, nearest: bool) -> Option<Found> {
        let (asker, mut fetches) = (asker.into(), 0);
        let mut best = Candidate::NONE;
        if !(nearest && asker.grazed) {
            best = self.scan(query, asker, false, best, &mut fetches);
        }
        if nearest && best.rank > TURNED {
            best = self.scan(query, asker, true, best, &mut fetches);
        }
        (best.rank < NOTHING).then_some(Found {
            triangle: best.triangle,
            barycentric: best.barycentric,
            fetches,
            hit: best.rank & NO_HIT == 0,
        })
    }

    /// Loads of a lookup that finds nothing: the hash texel and its list.
    pub fn fetches_of_miss(&self, query: [i32; 3]) -> u32 {
        let mut fetches = 0;
        self.scan(
            query,
            Asker::default(),
            false,
            Candidate::NONE,
            &mut fetches,
        );
        fetches
    }

    /// One walk over the texel's list: hits, or nearest points.
    fn scan(
        &self,
        query: [i32; 3],
        asker: Asker,
        nearest: bool,
        mut best: Candidate,
        fetches: &mut u32,
    ) -> Candidate {
        let line = self.primary.line();
        self.for_each_entry(query, fetches, |triangle, corners, of_layer| {
            let other = u32::from(asker.layer.is_some_and(|l| l != of_layer)) * OTHER_LAYER;
            let w = corners.map(|v| projection::offset(v, query).map(|x| x as f32 * OFFSET_SCALE));
            let candidate = if nearest {
                let (barycentric, distance) = projection::nearest(w);
                Candidate {
                    rank: other + NO_HIT,
                    distance,
                    triangle,
                    barycentric,
                }
            } else {
                let Some(hit) = projection::hit(line, query, &corners) else {
                    return;
                };
                let barycentric = hit.barycentric();
                let distance = projection::squared_length(projection::combine(barycentric, w));
                let turned = u32::from(asker.side * hit.sense < 0) * TURNED;
                Candidate {
                    rank: other + turned,
                    distance,
                    triangle,
                    barycentric,
                }
            };
            if candidate.better_than(&best) {
                best = candidate;
            }
        });
        best
    }

    fn for_each_entry(
        &self,
        query: [i32; 3],
        fetches: &mut u32,
        mut visit: impl FnMut(u32, GridTriangle, u8),
    ) {
        let flat = layout::is_flat(&self.primary);
        let bits = self.bits();
        let [x, y] = self.primary.line().texel(bits, query);
        let texel = (y << bits | x) as usize;
        let words = layout::triangle_words(self.layout, &self.primary);
        let mut read = |triangle: u32, layer: Option<u8>, fetches: &mut u32| {
            *fetches += layout::triangle_fetches(self.layout, &self.primary);
            let record = &self.triangle[triangle as usize * words..][..words];
            let (corners, stored) = layout::decode_triangle(self.layout, flat, record);
            visit(triangle, corners, layer.unwrap_or(stored));
        };
        *fetches += 1;
        match self.layout {
            Layout::Packed => {
                let (mut entry, mut next) =
                    (self.hash[2 * texel], self.hash[2 * texel + 1] as usize);
                if entry == EMPTY {
                    return;
                }
                loop {
                    read(entry & !LAST, None, fetches);
                    if entry & LAST != 0 {
                        return;
                    }
                    entry = self.list[next];
                    next += 1;
                    *fetches += 1;
                }
            }
            Layout::Classic => {
                let word = self.hash[texel];
                let (mut start, mut length) = ((word & 0xff_ffff) as usize, word >> 24);
                if length == LONG {
                    length = self.list[start];
                    start += 1;
                    *fetches += 1;
                }
                for entry in &self.list[start..start + length as usize] {
                    *fetches += 1;
                    read(entry & 0xff_ffff, Some((entry >> 24) as u8), fetches);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{BuildOptions, Needs, Reference, build_cpu};
    use super::*;
    use crate::mesh::{Mesh, shapes};
    use crate::param::grid::QUERY_SHIFT;
    use crate::param::{Axis, Primary, PrimaryKind};

    /// A tube about z with an outer wall and, nine tenths as wide and facing inwards, an inner one: one part.
    fn walls() -> Mesh {
        let mut mesh = shapes::tube(24, 4);
        let (count, outer) = (mesh.positions.len() as u32, mesh.triangles.len());
        for v in 0..count as usize {
            let [x, y, z] = mesh.positions[v];
            mesh.positions.push([0.9 * x, 0.9 * y, z]);
        }
        mesh.normals = vec![[0.0, 0.0, 1.0]; mesh.positions.len()];
        mesh.uv_sets.clear();
        for t in 0..outer {
            let [a, b, c] = mesh.triangles[t].map(|v| v + count);
            mesh.triangles.push([a, c, b]);
        }
        mesh.triangle_material = vec![0; mesh.triangles.len()];
        mesh
    }

    #[test]
    fn an_outer_wall_never_answers_with_the_inner_one() {
        let mesh = walls();
        let outer = mesh.triangles.len() as u32 / 2;
        let primary = Primary::centred(PrimaryKind::Cylinder(Axis::Z), &mesh).unwrap();
        let layers = vec![0; mesh.triangles.len()];
        let layout = Layout::Packed;
        let reference = Reference::new(&mesh, &primary, &layers, layout).unwrap();
        let options = BuildOptions { hash: 64, layout };
        let tables = build_cpu(&reference, &Needs::default(), options).unwrap();
        let side = |t: usize| projection::orientation(Line::Cylinder, &reference.corners(t));
        assert_eq!(side(0), -side(outer as usize));
        let mut changed = 0;
        for (t, triangle) in reference.triangles[..outer as usize].iter().enumerate() {
            // Just outside the inner wall, where a LoD's chord may run.
            let corners = triangle.map(|v| reference.t3[v as usize]);
            let query: [i32; 3] = std::array::from_fn(|k| {
                let mean = corners.iter().map(|c| i64::from(c[k])).sum::<i64>() / 3;
                let near = if k < 2 { mean * 92 / 100 } else { mean };
                (near << QUERY_SHIFT) as i32
            });
            let ask = |side| {
                tables
                    .lookup(
                        query,
                        Asker {
                            layer: Some(0),
                            side,
                            grazed: false,
                        },
                        false,
                    )
                    .unwrap()
            };
            assert!(ask(0).triangle >= outer, "the inner wall is closer");
            assert_eq!(ask(side(t)).triangle, t as u32);
            assert!(ask(-side(t)).triangle >= outer);
            changed += 1;
        }
        assert!(changed > 0);
    }

    #[test]
    fn the_orientation_is_the_sense_of_the_hits() {
        let mesh = shapes::icosphere(2);
        for kind in [
            PrimaryKind::Sphere,
            PrimaryKind::Cylinder(Axis::Z),
            PrimaryKind::Plane(Axis::Z),
        ] {
            let primary = Primary::centred(kind, &mesh).unwrap();
            let layers = vec![0; mesh.triangles.len()];
            let reference = Reference::new(&mesh, &primary, &layers, Layout::Packed).unwrap();
            for t in 0..reference.triangles.len() {
                let corners = reference.corners(t);
                let middle: [i32; 3] = std::array::from_fn(|k| {
                    let sum: i64 = corners.iter().map(|c| i64::from(c[k])).sum();
                    ((sum << QUERY_SHIFT) / 3) as i32
                });
                if let Some(hit) = projection::hit(primary.line(), middle, &corners) {
                    assert_eq!(hit.sense, projection::orientation(primary.line(), &corners));
                }
            }
        }
    }

    #[test]
    fn a_grazed_triangle_gets_the_nearest_point() {
        let mesh = shapes::icosphere(2);
        let primary = Primary::centred(PrimaryKind::Plane(Axis::Z), &mesh).unwrap();
        let (layout, layers) = (Layout::Packed, vec![0; mesh.triangles.len()]);
        let reference = Reference::new(&mesh, &primary, &layers, layout).unwrap();
        let options = BuildOptions { hash: 32, layout };
        let tables = build_cpu(&reference, &Needs::default(), options).unwrap();
        let mut grazed = 0;
        for t in 0..reference.triangles.len() {
            let corners = reference.corners(t);
            let asker = Asker::of(Line::Parallel, &corners, Some(0));
            let middle: [i32; 3] = std::array::from_fn(|k| {
                let sum: i64 = corners.iter().map(|c| i64::from(c[k])).sum();
                ((sum << QUERY_SHIFT) / 3) as i32
            });
            let found = tables.lookup(middle, asker, true).unwrap();
            assert_eq!((found.triangle, found.hit), (t as u32, !asker.grazed));
            assert!(!asker.grazed || tables.lookup(middle, asker, false).is_none_or(|f| f.hit));
            grazed += u32::from(asker.grazed);
        }
        assert!(
            grazed > 0,
            "the sphere's equator stands upright over the plane"
        );
    }

    #[test]
    fn askers_survive_their_words() {
        for layer in [None, Some(0), Some(254)] {
            for side in [-1, 0, 1] {
                for grazed in [false, true] {
                    let asker = Asker {
                        layer,
                        side,
                        grazed,
                    };
                    assert_eq!(Asker::from_word(asker.word()), asker);
                }
            }
        }
        assert_eq!(
            Asker::from_word(u32::MAX).layer,
            None,
            "no layer whatever else is said"
        );
    }
}
