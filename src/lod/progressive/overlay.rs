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
//! | cylinder | on each line, radii r_P and r_Q at one height | at a corner, but for how the radii vary |
//!
//! Corners of cells are vertices of either triangulation inside the other and crossings of edges. What is added to the largest
//! distance there makes it a bound: for the sphere, weights that differ by a factor k move a mean of points no farther than
//! their radius times (k - 1) / 2. Cells are small, and it is of a higher order.
//!
//! Source: Schilling and Klein, Texture-dependent refinement of multiresolution meshes, section 3.2 (and 4.2 for the parts).

use super::radial;
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
    triangles: &'a [[u32; 3]],
    /// The sense in which lines meet each triangle.
    sense: Vec<i8>,
    /// Object units per step of the grid; what is from position only.
    unit: f64,
}

/// A triangle whose deviation is asked: its corners in T3 (grid) and in space, and its sense.
#[derive(Clone, Copy, Debug)]
pub(super) struct Asked {
    pub(super) t3: [DVec3; 3],
    pub(super) corners: [DVec3; 3],
    pub(super) sense: i32,
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
            unit: 1.0 / primary.frame.scale,
        }
    }

    /// The deviation of `asked` from the triangles `near`, which must hold all that its image meets; those that it does
    /// meet are appended to `covers`.
    pub(super) fn deviation(
        &self,
        asked: &Asked,
        near: &[u32],
        covers: &mut Vec<u32>,
    ) -> Deviation {
        let normal = normal_of(asked.corners);
        let mut largest = Largest::default();
        let shares = Shares::new(self.line, asked);
        for &t in near {
            // What lies the other way round there is never looked up from here, nor from what comes of it.
            if i32::from(self.sense[t as usize]) != asked.sense {
                continue;
            }
            let corners = self.triangles[t as usize];
            let t3 = corners.map(|v| self.t3[v as usize]);
            let positions = || corners.map(|v| self.positions[v as usize]);
            let met = match &shares {
                Some(shares) => shares
                    .cell(t3, positions)
                    .map(|cell| largest.add_projective(&cell, asked, normal)),
                None => radial::cell(asked, t3, positions())
                    .map(|cell| largest.add_radial(&cell, self.unit, normal)),
            };
            if met.is_some() {
                covers.push(t);
            }
        }
        largest.rounded_up()
    }
}

/// The unit normal of a triangle in space; zero for one without area.
fn normal_of([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Homogeneous barycentric coordinates in a triangle's image as linear functions of T3: `h_i(p) = n_i . p + c_i`. Their sum is
/// the weight of p: 1 for parallel lines, for the sphere the factor by which the line's point on the triangle's plane is nearer
/// to the centre than p.
struct Shares {
    n: [DVec3; 3],
    c: DVec3,
}

/// A corner of a cell: homogeneous coordinates in the simplified triangle, and the reference's point.
type Corner = (DVec3, DVec3);

/// Corners of a cell, in order: a triangle cut by three lines has six at most.
#[derive(Default)]
struct Cell {
    corners: [Corner; 9],
    count: usize,
}

impl Shares {
    /// None for lines for which they are not linear.
    fn new(line: Line, asked: &Asked) -> Option<Self> {
        let [a, b, c] = asked.t3;
        let edges = [(b, c), (c, a), (a, b)];
        match line {
            Line::Cylinder => None,
            Line::Parallel => {
                let area = (b - a).cross(c - a).z;
                let n = edges.map(|(p, q)| DVec3::new(p.y - q.y, q.x - p.x, 0.0) / area);
                Some(Shares {
                    n,
                    c: DVec3::from(edges.map(|(p, q)| (p.x * q.y - p.y * q.x) / area)),
                })
            }
            Line::Sphere => {
                let volume = a.cross(b).dot(c);
                Some(Shares {
                    n: edges.map(|(p, q)| p.cross(q) / volume),
                    c: DVec3::ZERO,
                })
            }
        }
    }

    fn of(&self, p: DVec3) -> DVec3 {
        let [a, b, c] = self.n;
        DVec3::new(a.dot(p), b.dot(p), c.dot(p)) + self.c
    }

    /// What the triangle's image shares with that of a reference triangle, if that has area.
    fn cell(&self, t3: [DVec3; 3], positions: impl FnOnce() -> [DVec3; 3]) -> Option<Cell> {
        let h = t3.map(|p| self.of(p));
        // Beside one of the edges with all corners: nothing is shared.
        let most = h[0].max(h[1]).max(h[2]);
        if most.min_element() <= 0.0 {
            return None;
        }
        let mut cell = Cell::default();
        let positions = positions();
        (0..3).for_each(|k| cell.push((h[k], positions[k])));
        let least = h[0].min(h[1]).min(h[2]);
        for i in (0..3).filter(|&i| least[i] < 0.0) {
            cell = cell.cut(i);
        }
        (cell.count > 0).then_some(cell)
    }
}

impl Cell {
    fn push(&mut self, corner: Corner) {
        // Rounding could make a cut polygon less than convex, by a hair: no corner is lost that is not beside another.
        if self.count < self.corners.len() {
            self.corners[self.count] = corner;
            self.count += 1;
        }
    }

    fn corners(&self) -> &[Corner] {
        &self.corners[..self.count]
    }

    /// What lies where coordinate `i` is not negative. Source: Sutherland and Hodgman 1974, Reentrant polygon clipping.
    fn cut(&self, i: usize) -> Cell {
        let mut kept = Cell::default();
        let corners = self.corners();
        for (k, &(h, p)) in corners.iter().enumerate() {
            let (before, from) = corners[(k + self.count - 1) % self.count];
            if (h[i] < 0.0) != (before[i] < 0.0) {
                let s = before[i] / (before[i] - h[i]);
                kept.push((before.lerp(h, s), from.lerp(p, s)));
            }
            if h[i] >= 0.0 {
                kept.push((h, p));
            }
        }
        kept
    }
}

impl Deviation {
    /// Takes one more deviation vector into account, of a triangle with these corners.
    pub(super) fn include(&mut self, vector: DVec3, corners: [DVec3; 3]) {
        let mut one = Squares::default();
        one.add(vector, normal_of(corners));
        let one = one.roots().rounded_up();
        self.total = self.total.max(one.total);
        self.tangential = self.tangential.max(one.tangential);
        self.normal = self.normal.max(one.normal);
    }
}

impl Largest {
    fn add_projective(&mut self, cell: &Cell, asked: &Asked, normal: DVec3) {
        let [a, b, c] = asked.corners;
        let mut at_corners = Squares::default();
        let (mut least, mut most) = (f64::INFINITY, 0.0f64);
        let mut points = [DVec3::ZERO; 9];
        for (point, (h, p)) in points.iter_mut().zip(cell.corners()) {
            let weight = h.x + h.y + h.z;
            (least, most) = (least.min(weight), most.max(weight));
            *point = (a * h.x + b * h.y + c * h.z) / weight;
            at_corners.add(*p - *point, normal);
        }
        if least <= 0.0 {
            // The line runs along the simplified triangle's plane: its point may be anywhere.
            self.total = f64::INFINITY;
            return;
        }
        let points = &points[..cell.count];
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        let from_middle = points.iter().map(|p| p.distance_squared(middle));
        let radius = from_middle.fold(0.0, f64::max).sqrt();
        self.join(&at_corners.roots(), radius * 0.5 * (most / least - 1.0));
    }

    fn add_radial(&mut self, cell: &radial::Cell, unit: f64, normal: DVec3) {
        let mut at_corners = Squares::default();
        cell.corners
            .iter()
            .for_each(|corner| at_corners.add(corner.reference - corner.simplified, normal));
        let at_corners = at_corners.roots();
        let bound = cell.bound() * unit;
        self.join(&at_corners, (bound - at_corners.total).max(0.0));
    }

    /// A cell's: what was found at its corners, and how much more may lie between them.
    fn join(&mut self, corners: &Largest, more: f64) {
        self.total = self.total.max(corners.total + more);
        self.tangential = self.tangential.max(corners.tangential + more);
        self.normal = self.normal.max(corners.normal + more);
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
struct Squares {
    total: f64,
    tangential: f64,
    normal: f64,
}

impl Squares {
    /// One deviation vector, split by the simplified triangle's normal.
    fn add(&mut self, vector: DVec3, normal: DVec3) {
        let upright = vector.dot(normal);
        self.total = self.total.max(vector.length_squared());
        self.normal = self.normal.max(upright * upright);
        let along = vector - normal * upright;
        self.tangential = self.tangential.max(along.length_squared());
    }

    fn roots(&self) -> Largest {
        Largest {
            total: self.total.sqrt(),
            tangential: self.tangential.sqrt(),
            normal: self.normal.sqrt(),
        }
    }
}
