//! Cells of an overlay along parallel lines and those of a sphere, where edges' images are straight.
//!
//! In: a simplified triangle, and triangles of the reference round it. Out: which of them its image meets, and the largest
//! distances at the corners of what they share, with what may be more between them.
//!
//! Vertices are placed first: what lies inside is measured once, not by each of its triangles. Triangles that lie inside
//! whole are cells themselves; the others are cut.

use super::near::Near;
use super::overlay::{Asked, Largest, Overlay, Squares};
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

/// A corner of a cell that is cut.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    /// Its homogeneous coordinates in the simplified triangle.
    h: DVec3,
    /// The reference's point.
    p: DVec3,
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

    /// What the cell of a triangle adds that lies in part beyond edge `I`, and beyond no other: most are. Its corners that lie
    /// inside are `known`.
    fn add_cut_once<const I: usize>(
        &self,
        corners: &[Corner; 3],
        known: [&Met; 3],
        largest: &mut Largest,
    ) {
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
                self.add(corners.into_iter(), largest);
            }
            false => self.add([known[k], &ahead, &behind].into_iter(), largest),
        }
    }

    /// What a cell adds.
    #[inline]
    fn add<'m>(&self, corners: impl Iterator<Item = &'m Met> + Clone, largest: &mut Largest) {
        let mut squares = Squares::default();
        corners.clone().for_each(|c| squares.raise(&c.squares));
        let more = match self.line {
            Line::Sphere => more_between(corners),
            _ => 0.0,
        };
        largest.join(&squares, more);
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
        covers: &mut Vec<u32>,
    ) -> Option<Largest> {
        let view = View {
            shares: Shares::new(overlay.line, asked)?,
            corners: asked.corners,
            normal,
            line: overlay.line,
        };
        self.place(&view, overlay, near);
        let mut largest = Largest::default();
        for (&t, &corners) in near.triangles.iter().zip(&near.corners) {
            let [a, b, c] = corners.map(|v| self.sides[v as usize]);
            // Beside one of the edges with all corners: nothing is shared.
            let beside = a.beside & b.beside & c.beside;
            if beside != 0 || !overlay.faces(t, asked) {
                continue;
            }
            let beyond = a.beyond | b.beyond | c.beyond;
            let met = match beyond {
                0 => {
                    let met = corners.map(|v| &self.inside[v as usize]);
                    view.add(met.into_iter(), &mut largest);
                    true
                }
                _ => self.add_cut((overlay, near), &view, (corners, beyond), &mut largest),
            };
            if met {
                covers.push(t);
                if largest.total > limit {
                    break;
                }
            }
        }
        Some(largest)
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

    /// Adds the cell of a triangle that lies in part beyond the edges of `beyond`; whether there is one.
    fn add_cut(
        &mut self,
        (overlay, near): (&Overlay<'_>, &Near),
        view: &View,
        (corners, beyond): ([u32; 3], u8),
        largest: &mut Largest,
    ) -> bool {
        let corner = |v: u32| Corner {
            h: self.h[v as usize],
            p: overlay.positions[near.vertices[v as usize] as usize],
        };
        let [a, b, c] = corners;
        let corners_of = [corner(a), corner(b), corner(c)];
        if beyond.is_power_of_two() {
            let known = corners.map(|v| &self.inside[v as usize]);
            match beyond {
                1 => view.add_cut_once::<0>(&corners_of, known, largest),
                2 => view.add_cut_once::<1>(&corners_of, known, largest),
                _ => view.add_cut_once::<2>(&corners_of, known, largest),
            }
            return true;
        }
        let [mut cell, mut other] = self.cells.each_mut();
        cell.count = 3;
        cell.corners[..3].copy_from_slice(&corners_of);
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
        if !met.is_empty() {
            view.add(met.iter(), largest);
        }
        !met.is_empty()
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
