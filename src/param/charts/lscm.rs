//! Least squares conformal maps.
//!
//! In: a [`Chart`]. Out: for each local vertex a point of the plane, with the chart's own area. With U = u + i v, a triangle
//! whose corners are z_0, z_1, z_2 in its own plane is mapped conformally where `sum_j W_j U_j = 0`, W_j the edge opposite
//! of corner j. The sum of squares over all triangles, divided by twice their areas, is least where a Hermitian system
//! holds: half as large as the same in u and v. Two vertices of the rim far apart are pinned.
//! Source: Lévy, Petitjean, Ray, Maillot, Least Squares Conformal Maps for Automatic Texture Atlas Generation (2002),
//! section 2. Sparse Cholesky factorization: faer.

use super::chart::Chart;
use super::stretch::to_own_area;
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side, c64};
use glam::{DVec2, DVec3};

/// The conformal map of a chart; `None` where the system cannot be solved.
pub(crate) fn lscm(chart: &Chart) -> Option<Vec<DVec2>> {
    let shapes: Vec<[DVec2; 3]> = (0..chart.corners.len())
        .map(|i| laid_flat(chart.triangle(i)))
        .collect();
    conformal(chart, &shapes)
}

/// The map under which triangles come closest to being similar to `shapes`, which are wound as the chart's.
pub(crate) fn conformal(chart: &Chart, shapes: &[[DVec2; 3]]) -> Option<Vec<DVec2>> {
    let vertices = chart.places.len();
    let pins = pins(chart);
    let apart = chart.places[pins[0]].distance(chart.places[pins[1]]);
    // Unknowns are numbered without the pinned ones.
    let unknown = |v: usize| v - usize::from(v > pins[0]) - usize::from(v > pins[1]);
    let pinned = |v: usize| match v {
        v if v == pins[0] => Some(c64::new(0.0, 0.0)),
        v if v == pins[1] => Some(c64::new(apart, 0.0)),
        _ => None,
    };
    let count = vertices.checked_sub(2).filter(|&n| n > 0)?;
    let mut entries: Vec<Triplet<usize, usize, c64>> = Vec::with_capacity(chart.corners.len() * 6);
    let mut right: Mat<c64> = Mat::zeros(count, 1);
    for (corners, shape) in chart.corners.iter().zip(shapes) {
        let double_area = (shape[1] - shape[0]).perp_dot(shape[2] - shape[0]);
        let opposite = |j: usize| shape[(j + 2) % 3] - shape[(j + 1) % 3];
        for a in 0..3 {
            let row = corners[a] as usize;
            if pinned(row).is_some() {
                continue;
            }
            for b in 0..3 {
                let column = corners[b] as usize;
                let (x, y) = (opposite(a), opposite(b));
                let value = c64::new(x.dot(y), x.perp_dot(y)) / double_area;
                match pinned(column) {
                    Some(at) => right[(unknown(row), 0)] -= value * at,
                    None if unknown(row) >= unknown(column) => {
                        entries.push(Triplet::new(unknown(row), unknown(column), value));
                    }
                    None => {}
                }
            }
        }
    }
    let matrix = SparseColMat::try_new_from_triplets(count, count, &entries).ok()?;
    matrix
        .sp_cholesky(Side::Lower)
        .ok()?
        .solve_in_place(&mut right);
    let flat = (0..vertices).map(|v| pinned(v).unwrap_or_else(|| right[(unknown(v), 0)]));
    let mut flat: Vec<DVec2> = flat.map(|z| DVec2::new(z.re, z.im)).collect();
    to_own_area(chart, &mut flat).then_some(flat)
}

/// A triangle in its own plane, first corner at the origin, wound counter-clockwise.
pub(crate) fn laid_flat([a, b, c]: [DVec3; 3]) -> [DVec2; 3] {
    let (to_b, to_c) = (b - a, c - a);
    let length = to_b.length();
    let along = to_b.dot(to_c) / length;
    let height = to_b.cross(to_c).length() / length;
    [
        DVec2::ZERO,
        DVec2::new(length, 0.0),
        DVec2::new(along, height),
    ]
}

/// Two vertices of the rim far apart, the lower number first.
fn pins(chart: &Chart) -> [usize; 2] {
    let farthest = |from: u32| {
        let distance =
            |v: u32| chart.places[v as usize].distance_squared(chart.places[from as usize]);
        let far = |best: u32, &v: &u32| {
            if distance(v) > distance(best) {
                v
            } else {
                best
            }
        };
        chart.rim.iter().fold(from, far)
    };
    let one = farthest(chart.rim[0]);
    let mut other = farthest(one);
    if other == one {
        // All of the rim lies in one place.
        other = chart.rim.iter().copied().find(|&v| v != one).unwrap_or(one);
    }
    [one.min(other) as usize, one.max(other) as usize]
}
