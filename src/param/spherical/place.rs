//! Vertices on the sphere: where they may lie, and where they lie best.
//!
//! In: a vertex's ring. Out: a place from which all of the ring is seen the right way round, and better places near it. With v
//! on the sphere and a, b on its ring, det(v, a, b) > 0 is linear in v: what all sides of the ring allow is a cone.
//! What is minimised is the stretch from the sphere to the surface, which grows without bound as a triangle on the sphere
//! vanishes. Source: Praun, Hoppe, Spherical Parametrization and Remeshing (2003), section 4; the L2 stretch is that of
//! Sander et al. (2001).

use glam::DVec3;

/// A place keeps at least this sine of an angle from every side of its ring.
const CLEAR: f64 = 1e-9;
/// Steps of the search along a direction.
const HALVINGS: usize = 14;
/// Weight of the inverse of the area's share: keeps tiny triangles of the surface from filling the sphere.
const INVERSE: f64 = 1e-3;

/// One side of a ring: places on the sphere, and what the triangle with it is on the surface.
#[derive(Clone, Copy)]
pub(super) struct Side {
    pub(super) from: DVec3,
    pub(super) to: DVec3,
    /// Squared lengths on the surface: of the side, and of the edges from its ends to the vertex.
    pub(super) squares: [f64; 3],
    /// Area on the surface.
    pub(super) area: f64,
}

/// A direction from which all sides are seen the right way round, well inside; none where there is none. `about` is near it.
pub(super) fn inside(sides: &[(DVec3, DVec3)], about: DVec3) -> Option<DVec3> {
    let (x, y) = about.normalize().any_orthonormal_pair();
    const WIDE: f64 = 50.0;
    let about = about.normalize();
    let mut cone: Vec<DVec3> = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)]
        .map(|(s, t)| about + (x * s + y * t) * WIDE)
        .to_vec();
    let mut next = vec![];
    for (a, b) in sides {
        let normal = a.cross(*b);
        next.clear();
        for (i, &p) in cone.iter().enumerate() {
            let q = cone[(i + 1) % cone.len()];
            let (s, t) = (normal.dot(p), normal.dot(q));
            if s >= 0.0 {
                next.push(p);
            }
            if (s > 0.0 && t < 0.0) || (s < 0.0 && t > 0.0) {
                next.push(p + (q - p) * (s / (s - t)));
            }
        }
        std::mem::swap(&mut cone, &mut next);
        if cone.len() < 3 {
            return None;
        }
    }
    let middle: DVec3 = cone.iter().map(|p| p.normalize_or_zero()).sum();
    let middle = middle.try_normalize()?;
    sees_all(middle, sides.iter().copied()).then_some(middle)
}

/// Whether every side is seen the right way round from `v`, with room to spare.
pub(super) fn sees_all(v: DVec3, mut sides: impl Iterator<Item = (DVec3, DVec3)>) -> bool {
    sides.all(|(a, b)| {
        let normal = a.cross(b);
        v.dot(normal) > CLEAR * normal.length()
    })
}

/// Moves `v` to where the triangles about it are stretched less; it keeps seeing all sides.
pub(super) fn better(v: DVec3, sides: &[Side]) -> DVec3 {
    let reach = sides
        .iter()
        .map(|s| s.from.distance(v))
        .fold(f64::INFINITY, f64::min);
    let now = cost(v, sides);
    let slope: DVec3 = sides.iter().map(|side| slope(v, side)).sum();
    // Along the sphere.
    let down = v * v.dot(slope) - slope;
    let Some(down) = down.try_normalize().filter(|d| d.is_finite()) else {
        return v;
    };
    let mut best = (now, v);
    let mut far = 0.5 * reach;
    for _ in 0..HALVINGS {
        let there = (v + down * far).normalize();
        let cost = cost(there, sides);
        if cost < best.0 && sees_all(there, sides.iter().map(|s| (s.from, s.to))) {
            best = (cost, there);
        } else if best.1 != v {
            break;
        }
        far *= 0.5;
    }
    best.1
}

/// Stretch of the triangles about `v`, as a sum over the surface; infinite where one is turned over.
fn cost(v: DVec3, sides: &[Side]) -> f64 {
    sides.iter().map(|side| stretch(v, side)).sum()
}

fn stretch(v: DVec3, side: &Side) -> f64 {
    let determinant = v.dot(side.from.cross(side.to));
    if determinant <= 0.0 {
        return f64::INFINITY;
    }
    let square = determinant * determinant;
    side.area * trace(v, side) / square + INVERSE * square / side.area
}

/// The derivative of [`stretch`] by `v`.
fn slope(v: DVec3, side: &Side) -> DVec3 {
    let normal = side.from.cross(side.to);
    let determinant = v.dot(normal);
    let square = determinant * determinant;
    let [opposite, from_v, to_v] = side.squares;
    let of_trace =
        (side.to - side.from) * (to_v - from_v) - (side.from + side.to - v * 2.0) * opposite;
    let of_square = normal * (2.0 * determinant);
    (of_trace * square - of_square * trace(v, side)) * (side.area / (square * square))
        + of_square * (INVERSE / side.area)
}

/// trace(J^T J) of the map from the sphere's triangle to the surface's, times the square of its double area: cotangents there,
/// squared lengths here. The determinant of the corners stands for that double area, which it is for small triangles; of a
/// large one it vanishes where the sphere's triangle does.
fn trace(v: DVec3, side: &Side) -> f64 {
    let (a, b, edge) = (side.from - v, side.to - v, side.to - side.from);
    let [opposite, from_v, to_v] = side.squares;
    a.dot(b) * opposite + b.dot(edge) * from_v - a.dot(edge) * to_v
}
