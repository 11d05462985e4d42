//! How far a triangle of a simplified surface lies from the reference, point by point of T3: a bound, not a sample.
//!
//! In: a triangle, and the triangles of the reference that its image may meet. Out: [`Deviation`], and which of them it meets.
//!
//! Both triangulations are overlaid along the projection lines. In a cell of the overlay, the part of T3 that one triangle of
//! either shares, each surface is one formula:
//!
//! | lines | reference P, simplified Q over the cell | largest distance |
//! |---|---|---|
//! | parallel | both affine | at a corner of the cell |
//! | sphere | P affine, Q projective: the corners' weights w are rescaled | at a corner, but for what the weights move |
//! | cylinder | P affine, Q by the ratio of radii: see `radial` | at a corner, but for how the ratio varies |
//!
//! Corners of cells are vertices of either triangulation inside the other and crossings of edges. What is added to the largest
//! distance there makes it a bound: for the sphere, weights that differ by a factor k move a mean of points no farther than
//! their radius times (k - 1) / 2. Cells are small, and it is of a higher order.
//!
//! Source: Schilling and Klein, Texture-dependent refinement of multiresolution meshes, section 3.2 (and 4.2 for the parts).

use super::near::Near;
use super::projective::{Shares, Sweep};
use super::radial;
use super::refine::{Corner, Piece, Refine};
use crate::mesh::Mesh;
use crate::param::Primary;
use crate::param::projection::{Line, orientation};
use glam::DVec3;

/// Largest distances between points of a simplified triangle and the points of the reference that they stand for, in
/// object units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Of the whole deviation vector.
    pub total: f32,
    /// Of its part in the plane of the simplified triangle.
    pub tangential: f32,
    /// Of its part along that triangle's normal.
    pub normal: f32,
}

/// The reference as overlays see it.
pub(super) struct Overlay<'a> {
    pub(super) line: Line,
    /// Grid coordinates of its vertices, exact in f64.
    pub(super) t3: Vec<DVec3>,
    pub(super) positions: Vec<DVec3>,
    pub(super) triangles: &'a [[u32; 3]],
    /// The sense in which lines meet each triangle.
    pub(super) sense: Vec<i8>,
}

/// A triangle whose deviation is asked: its corners in T3 (grid) and in space, and its sense.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    pub(super) t3: [DVec3; 3],
    pub(super) corners: [DVec3; 3],
    pub(super) sense: i32,
    /// Bit i where the edge opposite corner i may be one of a rim or a seam: it keeps the triangles of the reference that lie
    /// beyond it. They were left out by a chord, and another chord may take them in again.
    pub(super) rims: u8,
}

/// See [`Asked::rims`]: `on_rim` tells of a vertex whether it lies on a rim or seam.
pub(super) fn rims_of(corners: [u32; 3], on_rim: &[bool]) -> u8 {
    let is_end = |k: usize| on_rim[corners[k % 3] as usize];
    let is_rim = |i: &usize| is_end(i + 1) && is_end(i + 2);
    (0..3).filter(is_rim).fold(0, |rims, i| rims | 1 << i)
}

/// The largest of what is added up over the cells.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Largest {
    total: f64,
    tangential: f64,
    normal: f64,
}

impl<'a> Overlay<'a> {
    pub(super) fn new(mesh: &'a Mesh, primary: &Primary) -> Self {
        let grid: Vec<[i32; 3]> = (0..mesh.positions.len())
            .map(|v| primary.to_grid(primary.t3_of(mesh, v)))
            .collect();
        let line = primary.line();
        let sense = |t: &[u32; 3]| orientation(line, &t.map(|v| grid[v as usize])) as i8;
        Overlay {
            line,
            sense: mesh.triangles.iter().map(sense).collect(),
            t3: grid.iter().map(|p| DVec3::from(p.map(f64::from))).collect(),
            positions: mesh
                .positions
                .iter()
                .map(|p| DVec3::from(p.map(f64::from)))
                .collect(),
            triangles: &mesh.triangles,
        }
    }

    /// Gathers what `covers` name, for [`Overlay::deviation`].
    pub(super) fn gather<'c>(
        &self,
        scratch: &mut Scratch,
        covers: impl Iterator<Item = &'c [u32]> + Clone,
    ) {
        scratch.near.gather(self.triangles, covers);
    }

    /// The deviation of `asked` from what was gathered, which must hold all triangles that its image meets; those that it does
    /// meet are appended to `covers`. Where it is more than `limit`, what is returned is so too, and no more is known.
    pub(super) fn deviation(
        &self,
        asked: &Asked,
        limit: f64,
        Scratch {
            near,
            sweep,
            refine,
        }: &mut Scratch,
        covers: &mut Vec<u32>,
    ) -> Deviation {
        let asked = (asked, normal_of(asked.corners));
        refine.clear();
        sweep
            .largest((self, near), asked, limit, refine, covers)
            .unwrap_or_else(|| self.round_the_axis(asked, limit, (near, refine), covers))
            .rounded_up()
    }

    /// How far a triangle lies from a vertex of the reference, if its image holds that vertex.
    pub(super) fn displaced(&self, v: u32, asked: &Asked) -> Option<f64> {
        let shares = Shares::new(self.line, asked)?;
        let h = shares.of(self.t3[v as usize]);
        let [a, b, c] = asked.corners;
        let there = (a * h.x + b * h.y + c * h.z) / h.element_sum();
        let distance = there.distance(self.positions[v as usize]);
        (h.min_element() >= 0.0).then_some(distance)
    }

    /// Where a vertex lies on the grid.
    pub(super) fn grid(&self, v: u32) -> [i32; 3] {
        self.t3[v as usize].as_ivec3().to_array()
    }

    /// Triangles of the reference that lie the other way round are never looked up from here, nor from what comes of it.
    pub(super) fn faces(&self, t: u32, asked: &Asked) -> bool {
        i32::from(self.sense[t as usize]) == asked.sense
    }

    /// For the lines of a cylinder.
    fn round_the_axis(
        &self,
        (asked, normal): (&Asked, DVec3),
        limit: f64,
        (near, refine): (&Near, &mut Refine),
        covers: &mut Vec<u32>,
    ) -> Largest {
        let view = radial::View::new(asked, normal);
        let known = |piece: &Piece| view.known(piece.map(|c| c.h), piece.map(|c| c.p));
        for &t in near.triangles.iter().filter(|&&t| self.faces(t, asked)) {
            let piece = self.triangles[t as usize].map(|v| Corner {
                h: self.t3[v as usize],
                p: self.positions[v as usize],
            });
            let Some(known) = known(&piece) else {
                if radial::is_beyond(asked.t3, asked.rims, piece.map(|c| c.h)) {
                    covers.push(t);
                }
                continue;
            };
            refine.take(known, || piece);
            covers.push(t);
            if refine.farthest() > limit {
                return refine.attained();
            }
        }
        refine.finish(|piece, _| known(piece))
    }
}

/// Room for what is found on the way: one for each thread.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    near: Near,
    sweep: Sweep,
    refine: Refine,
}

/// The unit normal of a triangle in space; zero for one without area.
fn normal_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

impl Deviation {
    /// Takes one more deviation vector into account, of a triangle with these corners.
    pub(super) fn include(&mut self, vector: DVec3, corners: [DVec3; 3]) {
        let mut one = Largest::default();
        one.join(&Squares::of(vector, normal_of(corners)), 0.0);
        let one = one.rounded_up();
        self.total = self.total.max(one.total);
        self.tangential = self.tangential.max(one.tangential);
        self.normal = self.normal.max(one.normal);
    }
}

impl Largest {
    /// A cell's: what was found at its corners, and how much more may lie between them.
    pub(super) fn join(&mut self, corners: &Squares, more: f64) {
        // Few cells have more than others had: roots are taken of those alone.
        let join = |largest: &mut f64, square: f64| {
            let left = *largest - more;
            if left < 0.0 || square > left * left {
                *largest = largest.max(square.sqrt() + more);
            }
        };
        join(&mut self.total, corners.total);
        join(&mut self.tangential, corners.tangential);
        join(&mut self.normal, corners.normal);
    }

    /// The next floats that are not smaller.
    fn rounded_up(&self) -> Deviation {
        let up = |x: f64| {
            let near = x as f32;
            if f64::from(near) < x {
                near.next_up()
            } else {
                near
            }
        };
        Deviation {
            total: up(self.total),
            tangential: up(self.tangential),
            normal: up(self.normal),
        }
    }
}

/// The largest squares of deviation vectors and of their parts.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Squares {
    total: f64,
    tangential: f64,
    normal: f64,
}

impl Squares {
    pub(super) const ZERO: Squares = Squares {
        total: 0.0,
        tangential: 0.0,
        normal: 0.0,
    };

    /// Of one deviation vector, split by the simplified triangle's normal.
    pub(super) fn of(vector: DVec3, normal: DVec3) -> Self {
        let upright = vector.dot(normal);
        Squares {
            total: vector.length_squared(),
            tangential: (vector - normal * upright).length_squared(),
            normal: upright * upright,
        }
    }

    /// Takes over what is larger; whether the first was.
    #[inline]
    pub(super) fn raise(&mut self, other: &Squares) -> bool {
        let raised = other.total > self.total;
        self.total = self.total.max(other.total);
        self.tangential = self.tangential.max(other.tangential);
        self.normal = self.normal.max(other.normal);
        raised
    }

    pub(super) fn total(&self) -> f64 {
        self.total
    }

    /// How much larger a root of others is than its own, at most.
    pub(super) fn short_of(&self, others: &Squares) -> f64 {
        let more = |own: f64, other: f64| other.sqrt() - own.sqrt();
        more(self.total, others.total)
            .max(more(self.tangential, others.tangential))
            .max(more(self.normal, others.normal))
    }

    /// Whether the roots are no larger than those of others and `slack`, which may be negative.
    pub(super) fn are_below(&self, others: &Squares, slack: f64) -> bool {
        let is_below = |a: f64, b: f64| a.sqrt() <= b.sqrt() + slack;
        is_below(self.total, others.total)
            && is_below(self.tangential, others.tangential)
            && is_below(self.normal, others.normal)
    }
}
