//! Cells of an overlay along parallel lines and those of a sphere, where edges' images are straight.
//!
//! In: a simplified triangle, and triangles of the reference round it. Out: which of them its image meets, and the largest
//! distances at the corners of what they share, with what may be more between them.
//!
//! Vertices are placed first: what lies inside is measured once, not by each of its triangles. Triangles that lie inside
//! whole are cells themselves; the others are cut.

use super::near::Near;
use super::overlay::{Asked, Largest, Overlay, Squares};
use super::refine::{Corner, Known, Piece, Refine};
use crate::param::projection::Line;
use glam::DVec3;

/// Homogeneous barycentric coordinates in a triangle's image as linear functions of T3: `h_i(p) = n_i . p + c_i`. Their sum is
/// the weight of p: 1 for parallel lines, for the sphere the factor by which the line's point on the triangle's plane is nearer
/// to the centre than p.
pub(super) struct Shares {
    n: [DVec3; 3],
    c: DVec3,
}

/// On which sides of the triangle's edges a point lies: bit i for coordinate i, where it is negative, and where it is not positive.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sides {
    pub(super) beyond: u8,
    pub(super) beside: u8,
}

/// The corners of a cell, in order: a triangle cut by three lines has six at most.
#[derive(Clone, Copy, Debug, Default)]
struct Cell {
    corners: [Corner; 9],
    count: usize,
}

/// A corner as it is measured: the simplified triangle's point there, its weight, how far it deviates.
#[derive(Clone, Copy, Debug, Default)]
struct Met {
    point: DVec3,
    weight: f64,
    squares: Squares,
}

/// Room for what is found on the way.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    /// Of each vertex that is near: its coordinates, where that is, and what is there if it lies inside.
    h: Vec<DVec3>,
    sides: Vec<Sides>,
    inside: Vec<Met>,
    room: Room,
}

/// Room for cells that are cut.
#[derive(Debug, Default)]
struct Room {
    cells: [Cell; 2],
    met: [Met; 9],
}

/// The simplified triangle.
struct View {
    shares: Shares,
    corners: [DVec3; 3],
    normal: DVec3,
    line: Line,
}

impl Shares {
    /// None for lines for which they are not linear.
    pub(super) fn new(line: Line, asked: &Asked) -> Option<Self> {
        let [a, b, c] = asked.t3;
        let edges = [(b, c), (c, a), (a, b)];
        match line {
            Line::Cylinder => None,
            Line::Parallel => {
                let per_area = 1.0 / (b - a).cross(c - a).z;
                let n = edges.map(|(p, q)| DVec3::new(p.y - q.y, q.x - p.x, 0.0) * per_area);
                Some(Shares {
                    n,
                    c: DVec3::from(edges.map(|(p, q)| (p.x * q.y - p.y * q.x) * per_area)),
                })
            }
            Line::Sphere => {
                let per_volume = 1.0 / a.cross(b).dot(c);
                Some(Shares {
                    n: edges.map(|(p, q)| p.cross(q) * per_volume),
                    c: DVec3::ZERO,
                })
            }
        }
    }

    pub(super) fn of(&self, p: DVec3) -> DVec3 {
        let [a, b, c] = self.n;
        DVec3::new(a.dot(p), b.dot(p), c.dot(p)) + self.c
    }
}

impl Sides {
    pub(super) fn of(h: DVec3) -> Self {
        Sides {
            beyond: h.cmplt(DVec3::ZERO).bitmask() as u8,
            beside: h.cmple(DVec3::ZERO).bitmask() as u8,
        }
    }
}

impl View {
    fn met(&self, h: DVec3, reference: DVec3) -> Met {
        let [a, b, c] = self.corners;
        let weight = h.x + h.y + h.z;
        let point = (a * h.x + b * h.y + c * h.z) * (1.0 / weight);
        Met {
            point,
            weight,
            squares: Squares::of(reference - point, self.normal),
        }
    }

    /// Where the edge between two corners crosses edge `I`.
    #[inline]
    fn crossing<const I: usize>(&self, from: &Corner, to: &Corner) -> Met {
        let s = from.h[I] / (from.h[I] - to.h[I]);
        self.met(from.h.lerp(to.h, s), from.p.lerp(to.p, s))
    }

    /// What is known of the cell of a triangle that lies in part beyond edge `I`, and beyond no other: most are. Its corners that lie
    /// inside are `known`.
    fn cut_once<const I: usize>(&self, corners: &Piece, known: [&Met; 3]) -> Known {
        let beyond = corners.each_ref().map(|corner| corner.h[I] < 0.0);
        let both = usize::from(beyond[0]) + usize::from(beyond[1]) + usize::from(beyond[2]) == 1;
        // The corner that is alone on its side of the edge.
        let k = (0..3).find(|&k| beyond[k] == both).unwrap_or(0);
        let (next, before) = ((k + 1) % 3, (k + 2) % 3);
        let ahead = self.crossing::<I>(&corners[k], &corners[next]);
        let behind = self.crossing::<I>(&corners[k], &corners[before]);
        match both {
            true => {
                let corners = [&ahead, known[next], known[before], &behind];
                self.known(corners.into_iter())
            }
            false => self.known([known[k], &ahead, &behind].into_iter()),
        }
    }

    /// What is known of a cell.
    #[inline]
    fn known<'m>(&self, corners: impl Iterator<Item = &'m Met> + Clone) -> Known {
        let mut squares = Squares::default();
        for corner in corners.clone() {
            squares.raise(&corner.squares);
        }
        let more = match self.line {
            Line::Sphere => more_between(corners),
            _ => 0.0,
        };
        (squares, more)
    }
}

impl Sweep {
    /// The largest distances of `asked` from what is near, whose numbers are appended to `covers` where it is met. The search
    /// ends where it comes to more than `limit`. None for lines along which edges are curved.
    pub(super) fn largest(
        &mut self,
        (overlay, near): (&Overlay<'_>, &Near),
        (asked, normal): (&Asked, DVec3),
        limit: f64,
        refine: &mut Refine,
        covers: &mut Vec<u32>,
    ) -> Option<Largest> {
        let view = View {
            shares: Shares::new(overlay.line, asked)?,
            corners: asked.corners,
            normal,
            line: overlay.line,
        };
        self.place(&view, overlay, near);
        for (&t, &corners) in near.triangles.iter().zip(&near.corners) {
            let [a, b, c] = corners.map(|v| self.sides[v as usize]);
            // Beside one of the edges with all corners: nothing is shared.
            let beside = a.beside & b.beside & c.beside;
            if !overlay.faces(t, asked) {
                continue;
            }
            if beside != 0 {
                if a.beyond & b.beyond & c.beyond & asked.rims != 0 {
                    covers.push(t);
                }
                continue;
            }
            let (h, inside) = (&self.h, &self.inside);
            let corner = |v: u32| Corner {
                h: h[v as usize],
                p: overlay.positions[near.vertices[v as usize] as usize],
            };
            let piece = || [corner(corners[0]), corner(corners[1]), corner(corners[2])];
            let met = corners.map(|v| &inside[v as usize]);
            let known = match a.beyond | b.beyond | c.beyond {
                0 => Some(view.known(met.into_iter())),
                1 => Some(view.cut_once::<0>(&piece(), met)),
                2 => Some(view.cut_once::<1>(&piece(), met)),
                4 => Some(view.cut_once::<2>(&piece(), met)),
                beyond => self.room.cut(&view, &piece(), beyond),
            };
            if let Some(known) = known {
                refine.take(known, piece);
                covers.push(t);
                if refine.farthest() > limit {
                    return Some(refine.attained());
                }
            }
        }
        Some(refine.finish(|piece| self.room.part(&view, piece)))
    }

    fn place(&mut self, view: &View, overlay: &Overlay<'_>, near: &Near) {
        self.h.clear();
        self.sides.clear();
        self.inside.resize(near.vertices.len(), Met::default());
        for (&v, inside) in near.vertices.iter().zip(&mut self.inside) {
            let h = view.shares.of(overlay.t3[v as usize]);
            let sides = Sides::of(h);
            if sides.beyond == 0 {
                *inside = view.met(h, overlay.positions[v as usize]);
            }
            self.h.push(h);
            self.sides.push(sides);
        }
    }
}

impl Room {
    /// What is known of the cell of a part of a triangle, if it has one.
    fn part(&mut self, view: &View, piece: &Piece) -> Option<Known> {
        let [a, b, c] = piece.each_ref().map(|corner| Sides::of(corner.h));
        match a.beside & b.beside & c.beside {
            0 => self.cut(view, piece, a.beyond | b.beyond | c.beyond),
            _ => None,
        }
    }

    /// What is known of the cell of a triangle that lies in part beyond the edges of `beyond`, if it has one.
    fn cut(&mut self, view: &View, piece: &Piece, beyond: u8) -> Option<Known> {
        let [mut cell, mut other] = self.cells.each_mut();
        cell.count = 3;
        cell.corners[..3].copy_from_slice(piece);
        if beyond & 1 != 0 {
            cell.cut::<0>(other);
            std::mem::swap(&mut cell, &mut other);
        }
        if beyond & 2 != 0 {
            cell.cut::<1>(other);
            std::mem::swap(&mut cell, &mut other);
        }
        if beyond & 4 != 0 {
            cell.cut::<2>(other);
            std::mem::swap(&mut cell, &mut other);
        }
        let met = &mut self.met[..cell.count];
        for (met, corner) in met.iter_mut().zip(&cell.corners) {
            *met = view.met(corner.h, corner.p);
        }
        (!met.is_empty()).then(|| view.known(met.iter()))
    }
}

impl Cell {
    fn push(&mut self, corner: Corner) {
        // Rounding could make a cut polygon less than convex, by a hair: no corner is lost that is not beside another.
        if let Some(free) = self.corners.get_mut(self.count) {
            *free = corner;
            self.count += 1;
        }
    }

    /// What lies where coordinate `I` is not negative. Source: Sutherland and Hodgman 1974, Reentrant polygon clipping.
    fn cut<const I: usize>(&self, kept: &mut Cell) {
        kept.count = 0;
        let corners = &self.corners[..self.count];
        let Some(mut before) = corners.last() else {
            return;
        };
        for corner in corners {
            let (from, to) = (before.h[I], corner.h[I]);
            if (from < 0.0) != (to < 0.0) {
                let s = from / (from - to);
                kept.push(Corner {
                    h: before.h.lerp(corner.h, s),
                    p: before.p.lerp(corner.p, s),
                });
            }
            if to >= 0.0 {
                kept.push(*corner);
            }
            before = corner;
        }
    }
}

/// How much more a point of a sphere's cell may deviate than its corners do.
#[inline]
fn more_between<'m>(corners: impl Iterator<Item = &'m Met> + Clone) -> f64 {
    let (mut least, mut most) = (f64::INFINITY, 0.0f64);
    let (mut middle, mut count) = (DVec3::ZERO, 0.0);
    for corner in corners.clone() {
        (least, most) = (least.min(corner.weight), most.max(corner.weight));
        middle += corner.point;
        count += 1.0;
    }
    if least <= 0.0 {
        // The line runs along the simplified triangle's plane: its point may be anywhere.
        return f64::INFINITY;
    }
    middle *= 1.0 / count;
    let from_middle = corners.map(|c| c.point.distance_squared(middle));
    let radius = from_middle.fold(0.0, f64::max).sqrt();
    radius * 0.5 * (most / least - 1.0)
}
