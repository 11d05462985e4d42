//! Cells of an overlay along parallel lines and those of a sphere, where edges' images are straight.
//!
//! In: a simplified triangle, and triangles of the reference round it. Out: which of them its image meets, and the largest
//! distances at the corners of what they share, with what may be more between them.
//!
//! Vertices are placed first: what lies inside is measured once, not by each of its triangles. Triangles that lie inside
//! whole are cells themselves; of the others the corners are found one by one, in no order: none is needed.

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

/// A point of the reference as the simplified triangle sees it. All of it is linear on the reference.
#[derive(Clone, Copy, Debug, Default)]
struct Placed {
    /// Its coordinates in the triangle's image, and their sum.
    h: DVec3,
    weight: f64,
    /// The triangle's point on the same line, times the weight.
    image: DVec3,
    /// Where the reference's point lies.
    p: DVec3,
}

/// What the corners of a cell say, taken one after the other.
#[derive(Clone, Copy, Debug)]
struct Cell {
    squares: Squares,
    /// Of the weights.
    least: f64,
    most: f64,
}

/// Room for what is found on the way: of each vertex that is near where it is, and how far it deviates if it lies inside.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    placed: Vec<Placed>,
    sides: Vec<Sides>,
    inside: Vec<Squares>,
}

/// The simplified triangle.
struct View {
    shares: Shares,
    corners: [DVec3; 3],
    normal: DVec3,
    line: Line,
    /// How far its corners lie from its middle.
    radius: f64,
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

impl Placed {
    /// The point between this one and another of the same triangle.
    #[inline]
    fn lerp(&self, other: &Placed, s: f64) -> Placed {
        Placed {
            h: self.h.lerp(other.h, s),
            weight: self.weight + (other.weight - self.weight) * s,
            image: self.image.lerp(other.image, s),
            p: self.p.lerp(other.p, s),
        }
    }
}

impl Cell {
    const NONE: Cell = Cell {
        squares: Squares::ZERO,
        least: f64::INFINITY,
        most: 0.0,
    };

    /// Takes a corner.
    #[inline]
    fn take(&mut self, weight: f64, squares: &Squares) {
        self.least = self.least.min(weight);
        self.most = self.most.max(weight);
        self.squares.raise(squares);
    }
}

impl View {
    fn new(line: Line, asked: &Asked, normal: DVec3) -> Option<Self> {
        let [a, b, c] = asked.corners;
        let middle = (a + b + c) / 3.0;
        let far = asked.corners.map(|p| p.distance_squared(middle));
        Some(View {
            shares: Shares::new(line, asked)?,
            corners: asked.corners,
            normal,
            line,
            radius: far.into_iter().fold(0.0, f64::max).sqrt(),
        })
    }

    #[inline]
    fn placed(&self, h: DVec3, p: DVec3) -> Placed {
        let [a, b, c] = self.corners;
        Placed {
            h,
            weight: h.x + h.y + h.z,
            image: a * h.x + b * h.y + c * h.z,
            p,
        }
    }

    /// How far a point deviates.
    #[inline]
    fn squares(&self, at: &Placed) -> Squares {
        Squares::of(at.p - at.image * (1.0 / at.weight), self.normal)
    }

    /// Takes the corner where the edge between two corners of a triangle crosses edge `I`.
    #[inline]
    fn cross<const I: usize>(&self, cell: &mut Cell, from: &Placed, to: &Placed) {
        let at = from.lerp(to, from.h[I] / (from.h[I] - to.h[I]));
        cell.take(at.weight, &self.squares(&at));
    }

    /// The cell of a triangle that lies in part beyond edge `I`, and beyond no other: most are. Its corners that lie inside
    /// deviate by `inside`.
    fn cut_once<const I: usize>(&self, corners: [&Placed; 3], inside: [&Squares; 3]) -> Cell {
        let beyond = corners.map(|corner| corner.h[I] < 0.0);
        let both = usize::from(beyond[0]) + usize::from(beyond[1]) + usize::from(beyond[2]) == 1;
        // The corner that is alone on its side of the edge.
        let k = (0..3).find(|&k| beyond[k] == both).unwrap_or(0);
        let mut cell = Cell::NONE;
        for other in [(k + 1) % 3, (k + 2) % 3] {
            self.cross::<I>(&mut cell, corners[k], corners[other]);
            if both {
                cell.take(corners[other].weight, inside[other]);
            }
        }
        if !both {
            cell.take(corners[k].weight, inside[k]);
        }
        cell
    }

    /// The cell of a triangle that lies beyond several edges in part, if it has one: its corners are those of the triangle
    /// inside, crossings of both triangles' edges, and corners of this one.
    fn cut(&self, corners: [&Placed; 3], sides: [Sides; 3]) -> Option<Cell> {
        let (mut cell, mut is_met) = (Cell::NONE, false);
        for k in 0..3 {
            let (from, to) = (k, (k + 1) % 3);
            if sides[k].beyond == 0 {
                is_met = true;
                cell.take(corners[k].weight, &self.squares(corners[k]));
            }
            if sides[from].beyond & sides[to].beyond != 0 {
                continue;
            }
            let crossed = sides[from].beyond ^ sides[to].beyond;
            for edge in (0..3).filter(|edge| crossed >> edge & 1 != 0) {
                let (from, to) = (corners[from], corners[to]);
                let at = from.lerp(to, from.h[edge] / (from.h[edge] - to.h[edge]));
                let within = at.h[(edge + 1) % 3].min(at.h[(edge + 2) % 3]);
                is_met |= within >= 0.0;
                if within >= -ROUNDING * at.weight {
                    cell.take(at.weight, &self.squares(&at));
                }
            }
        }
        let beyond = sides[0].beyond | sides[1].beyond | sides[2].beyond;
        for own in (0..3).filter(|&own| beyond | 1 << own == 0b111) {
            if let Some(at) = own_corner(own, corners) {
                is_met = true;
                cell.take(at.weight, &self.squares(&at));
            }
        }
        is_met.then_some(cell)
    }

    /// What is known of the cell of a triangle: more exactly where that is more than `little`.
    #[inline]
    fn known(&self, cell: &Cell, corners: [&Placed; 3], little: f64) -> Known {
        let more = match self.line {
            Line::Sphere => self.more_between(cell, corners, little),
            _ => 0.0,
        };
        (cell.squares, more)
    }

    /// How much more a point of a sphere's cell may deviate than its corners do.
    #[inline]
    fn more_between(&self, cell: &Cell, corners: [&Placed; 3], little: f64) -> f64 {
        if cell.least <= 0.0 {
            // The line runs along the simplified triangle's plane: its point may be anywhere.
            return f64::INFINITY;
        }
        let share = 0.5 * (cell.most / cell.least - 1.0);
        match self.radius * share <= little {
            true => self.radius * share,
            false => self.radius.min(radius_of(corners)) * share,
        }
    }

    /// What is known of the cell of a part of a triangle, if it has one.
    fn part(&self, piece: &Piece, little: f64) -> Option<Known> {
        let placed = piece
            .each_ref()
            .map(|corner| self.placed(corner.h, corner.p));
        let corners = placed.each_ref();
        let sides = corners.map(|corner| Sides::of(corner.h));
        let beside = sides[0].beside & sides[1].beside & sides[2].beside;
        let cell = (beside == 0).then(|| self.cut(corners, sides))??;
        Some(self.known(&cell, corners, little))
    }
}

/// How far a crossing may seem to lie outside, by rounding: as a share of its weight.
const ROUNDING: f64 = 1e-12;

/// Where a triangle has the simplified one's corner `own`, if it does.
fn own_corner(own: usize, corners: [&Placed; 3]) -> Option<Placed> {
    let (i, j) = ((own + 1) % 3, (own + 2) % 3);
    let turn = |a: &Placed, b: &Placed| a.h[i] * b.h[j] - a.h[j] * b.h[i];
    let [a, b, c] = corners;
    let shares = [turn(b, c), turn(c, a), turn(a, b)];
    let sum = shares[0] + shares[1] + shares[2];
    let [x, y, z] = shares.map(|share| share / sum);
    let at = Placed {
        h: a.h * x + b.h * y + c.h * z,
        weight: a.weight * x + b.weight * y + c.weight * z,
        image: a.image * x + b.image * y + c.image * z,
        p: a.p * x + b.p * y + c.p * z,
    };
    // Ahead, not behind the centre.
    (x >= 0.0 && y >= 0.0 && z >= 0.0 && at.h[own] > 0.0).then_some(at)
}

/// How far from their middle the simplified triangle's points lie at the corners of another.
fn radius_of(corners: [&Placed; 3]) -> f64 {
    if corners.iter().any(|corner| corner.weight <= 0.0) {
        return f64::INFINITY;
    }
    let [a, b, c] = corners.map(|corner| corner.image / corner.weight);
    let middle = (a + b + c) / 3.0;
    let far = [a, b, c].map(|p| p.distance_squared(middle));
    far.into_iter().fold(0.0, f64::max).sqrt()
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
        let view = View::new(overlay.line, asked, normal)?;
        self.place(&view, overlay, near);
        for (&t, &corners) in near.triangles.iter().zip(&near.corners) {
            let sides = corners.map(|v| self.sides[v as usize]);
            let [a, b, c] = sides;
            // Beside one of the edges with all corners: nothing is shared.
            if a.beside & b.beside & c.beside != 0 {
                if a.beyond & b.beyond & c.beyond & asked.rims != 0 && overlay.faces(t, asked) {
                    covers.push(t);
                }
                continue;
            }
            if !overlay.faces(t, asked) {
                continue;
            }
            let inside = corners.map(|v| &self.inside[v as usize]);
            let corners = corners.map(|v| &self.placed[v as usize]);
            let cell = match a.beyond | b.beyond | c.beyond {
                0 => {
                    let mut cell = Cell::NONE;
                    (0..3).for_each(|k| cell.take(corners[k].weight, inside[k]));
                    Some(cell)
                }
                1 => Some(view.cut_once::<0>(corners, inside)),
                2 => Some(view.cut_once::<1>(corners, inside)),
                4 => Some(view.cut_once::<2>(corners, inside)),
                _ => view.cut(corners, sides),
            };
            if let Some(cell) = cell {
                let known = view.known(&cell, corners, refine.little());
                refine.take(known, || {
                    corners.map(|corner| Corner {
                        h: corner.h,
                        p: corner.p,
                    })
                });
                covers.push(t);
                if refine.farthest() > limit {
                    return Some(refine.attained());
                }
            }
        }
        Some(refine.finish(|piece, little| view.part(piece, little)))
    }

    fn place(&mut self, view: &View, overlay: &Overlay<'_>, near: &Near) {
        self.placed.clear();
        self.sides.clear();
        self.inside.clear();
        for &v in &near.vertices {
            let h = view.shares.of(overlay.t3[v as usize]);
            let placed = view.placed(h, overlay.positions[v as usize]);
            let sides = Sides::of(h);
            self.inside.push(match sides.beyond {
                0 => view.squares(&placed),
                _ => Squares::ZERO,
            });
            self.placed.push(placed);
            self.sides.push(sides);
        }
    }
}
