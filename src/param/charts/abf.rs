//! Angle based flattening.
//!
//! In: a [`Chart`]. Out: for each local vertex a point of the plane. Unknown are the angles of all triangles; what is minimised
//! is the sum of (angle - wanted)^2 / wanted^2 where every triangle has 180 degrees, every inner vertex 360, and all edges
//! about an inner vertex fit when one walks round it (products of sines). Each step solves the constraints made linear; the
//! triangles' own are taken out by hand, so that a system of two unknowns for each inner vertex is left. Triangles of those
//! angles are then put together by the conformal map, which has next to nothing left to distort.
//! Source: Sheffer, Lévy, Mogilnitsky, Bogomyakov, ABF++: Fast and Robust Angle Based Flattening (2005), sections 3 and 4; the
//! condition about a vertex as a sum of logarithms, as in Zayer, Lévy, Seidel, Linear Angle Based Parameterization (2007).

use super::chart::Chart;
use super::lscm::{conformal, laid_flat, lscm};
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use faer::{Mat, Side};
use glam::DVec2;
use std::f64::consts::{PI, TAU};

/// Most steps; three to five are usual.
const STEPS: usize = 12;
/// Constraints are met when none is off by more.
const MET: f64 = 1e-8;
/// An angle stays above this share of what it was before a step.
const KEPT: f64 = 0.1;

/// The angle based map of a chart; the conformal one where angles cannot be found.
pub(crate) fn abf(chart: &Chart) -> Option<Vec<DVec2>> {
    let angles = angles(chart);
    match flattened(chart, &angles).and_then(|angles| conformal(chart, &shapes(chart, &angles))) {
        Some(flat) => Some(flat),
        None => lscm(chart),
    }
}

/// Angles of each triangle on the surface.
pub(crate) fn angles(chart: &Chart) -> Vec<[f64; 3]> {
    (0..chart.corners.len())
        .map(|i| angles_of(laid_flat(chart.triangle(i))))
        .collect()
}

/// Angles of a triangle in the plane.
pub(crate) fn angles_of(corners: [DVec2; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| {
        let (a, b) = (
            corners[(k + 1) % 3] - corners[k],
            corners[(k + 2) % 3] - corners[k],
        );
        a.perp_dot(b).atan2(a.dot(b))
    })
}

/// A triangle of these angles, with the area that the chart's has.
fn shapes(chart: &Chart, angles: &[[f64; 3]]) -> Vec<[DVec2; 3]> {
    let shape = |i: usize| {
        let [a, b, c] = laid_flat(chart.triangle(i));
        let double_area = (b - a).perp_dot(c - a);
        let [alpha, beta, gamma] = angles[i];
        // Sines are sides: c = sin gamma along x, b = sin beta at angle alpha.
        let (sin, cos) = alpha.sin_cos();
        let [base, side] = [gamma.sin(), beta.sin()];
        let scale = (double_area / (base * side * sin)).sqrt();
        [
            DVec2::ZERO,
            DVec2::new(base, 0.0) * scale,
            DVec2::new(cos, sin) * (side * scale),
        ]
    };
    (0..angles.len()).map(shape).collect()
}

/// For each local vertex its number among those inside, or none on the rim.
fn inner(chart: &Chart) -> (Vec<Option<usize>>, usize) {
    let mut on_rim = vec![false; chart.places.len()];
    chart.rim.iter().for_each(|&v| on_rim[v as usize] = true);
    let mut count = 0;
    let number = |rim: bool| {
        (!rim).then(|| {
            count += 1;
            count - 1
        })
    };
    (on_rim.into_iter().map(number).collect(), count)
}

/// Angles close to `surface` that fit together in the plane.
fn flattened(chart: &Chart, surface: &[[f64; 3]]) -> Option<Vec<[f64; 3]>> {
    let (inner, count) = inner(chart);
    let system = System {
        chart,
        inner: &inner,
        count,
        wanted: surface.to_vec(),
    };
    let mut now = system.wanted.clone();
    if count == 0 {
        return Some(surface.to_vec());
    }
    for _ in 0..STEPS {
        let next = system.step(&now)?;
        let whole = now
            .iter()
            .zip(&next)
            .flat_map(|(a, b)| [0, 1, 2].map(|k| (a[k], b[k])));
        // As far towards the solution as all angles stay angles.
        let far = whole.fold(1.0f64, |far, (from, to)| {
            let room = |limit: f64, step: f64| {
                if step > limit {
                    far.min(limit / step)
                } else {
                    far
                }
            };
            if to < from {
                room((1.0 - KEPT) * from, from - to)
            } else {
                room((1.0 - KEPT) * (PI - from), to - from)
            }
        });
        for (a, b) in now.iter_mut().zip(&next) {
            (0..3).for_each(|k| a[k] += far * (b[k] - a[k]));
        }
        if far == 1.0 && system.off(&now) < MET {
            break;
        }
    }
    (system.off(&now) < 1e-3).then_some(now)
}

struct System<'a> {
    chart: &'a Chart,
    inner: &'a [Option<usize>],
    count: usize,
    /// Angles on the surface: those that the plane should have. (The paper scales those about inner vertices to 360 degrees
    /// first; left as they are, no map of the chart distorts angles less.)
    wanted: Vec<[f64; 3]>,
}

/// Constraints of inner vertices that a triangle's angles have a part in: number, and derivative by each angle.
type Rows = ([(usize, [f64; 3]); 6], usize);

impl System<'_> {
    /// Rows `2 v` (angles about v) and `2 v + 1` (walking round v) of triangle `i` with these angles.
    fn rows(&self, i: usize, angles: [f64; 3]) -> Rows {
        let mut rows = ([(0, [0.0; 3]); 6], 0);
        for k in 0..3 {
            if let Some(v) = self.inner[self.chart.corners[i][k] as usize] {
                let mut about = [0.0; 3];
                about[k] = 1.0;
                let mut round = [0.0; 3];
                round[(k + 1) % 3] = 1.0 / angles[(k + 1) % 3].tan();
                round[(k + 2) % 3] = -1.0 / angles[(k + 2) % 3].tan();
                rows.0[rows.1] = (2 * v, about);
                rows.0[rows.1 + 1] = (2 * v + 1, round);
                rows.1 += 2;
            }
        }
        rows
    }

    /// How far each inner vertex's constraints are from being met.
    fn residuals(&self, now: &[[f64; 3]]) -> Vec<f64> {
        let mut residuals = vec![0.0; 2 * self.count];
        for (corners, angles) in self.chart.corners.iter().zip(now) {
            for k in 0..3 {
                if let Some(v) = self.inner[corners[k] as usize] {
                    residuals[2 * v] += angles[k];
                    residuals[2 * v + 1] +=
                        angles[(k + 1) % 3].sin().ln() - angles[(k + 2) % 3].sin().ln();
                }
            }
        }
        residuals.iter_mut().step_by(2).for_each(|sum| *sum -= TAU);
        residuals
    }

    /// The largest distance from any constraint.
    fn off(&self, now: &[[f64; 3]]) -> f64 {
        let triangles = now.iter().map(|a| (a[0] + a[1] + a[2] - PI).abs());
        let worst = triangles.chain(self.residuals(now).into_iter().map(f64::abs));
        worst.fold(0.0, |worst, x| if x <= worst { worst } else { x })
    }

    /// The angles nearest to what is wanted that meet the constraints as they are near `now`.
    fn step(&self, now: &[[f64; 3]]) -> Option<Vec<[f64; 3]>> {
        let size = 2 * self.count;
        let mut entries: Vec<Triplet<usize, usize, f64>> = Vec::with_capacity(now.len() * 21);
        let mut right: Mat<f64> = Mat::zeros(size, 1);
        for (row, residual) in self.residuals(now).into_iter().enumerate() {
            right[(row, 0)] = residual;
        }
        for (i, angles) in now.iter().enumerate() {
            let (weights, total) = self.weights(i);
            let (rows, count) = self.rows(i, *angles);
            let excess = self.wanted[i].iter().sum::<f64>() - PI;
            let off = [0, 1, 2].map(|k| angles[k] - self.wanted[i][k]);
            for (a, (row, by)) in rows[..count].iter().enumerate() {
                let weighted = [0, 1, 2].map(|k| by[k] * weights[k]);
                let through = weighted.iter().sum::<f64>() / total;
                right[(*row, 0)] -= dot(*by, off) + through * excess;
                for (column, other) in &rows[..=a] {
                    let value = dot(weighted, *other) - through * dot(weights, *other);
                    entries.push(Triplet::new(*row.max(column), *row.min(column), value));
                }
            }
        }
        let matrix = SparseColMat::try_new_from_triplets(size, size, &entries).ok()?;
        matrix
            .sp_cholesky(Side::Lower)
            .ok()?
            .solve_in_place(&mut right);
        let moved = |i: usize| {
            let (weights, total) = self.weights(i);
            let (rows, count) = self.rows(i, now[i]);
            let mut pull = [0.0; 3];
            for (row, by) in &rows[..count] {
                (0..3).for_each(|k| pull[k] += by[k] * right[(*row, 0)]);
            }
            let excess = self.wanted[i].iter().sum::<f64>() - PI;
            let own = (excess - dot(weights, pull)) / total;
            [0, 1, 2].map(|k| self.wanted[i][k] - weights[k] * (own + pull[k]))
        };
        let next: Vec<[f64; 3]> = (0..now.len()).map(moved).collect();
        next.iter().flatten().all(|x| x.is_finite()).then_some(next)
    }

    /// The inverse of the weights of a triangle's angles, and their sum.
    fn weights(&self, i: usize) -> ([f64; 3], f64) {
        let weights = self.wanted[i].map(|angle| angle * angle);
        (weights, weights.iter().sum())
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::super::{merge, segment, surface::Surface};
    use super::*;
    use crate::mesh::shapes;

    /// Root mean square of angles' differences from the surface's, as shares of those.
    fn distortion(chart: &Chart, flat: &[DVec2]) -> f64 {
        let of_surface = angles(chart);
        let squares = chart
            .corners
            .iter()
            .zip(&of_surface)
            .flat_map(|(corners, wanted)| {
                let angles = angles_of(corners.map(|v| flat[v as usize]));
                [0, 1, 2].map(|k| ((angles[k] - wanted[k]) / wanted[k]).powi(2))
            });
        (squares.sum::<f64>() / (3 * of_surface.len()) as f64).sqrt()
    }

    #[test]
    fn angles_are_distorted_less_than_by_the_conformal_map_on_every_chart() {
        let mut mesh = shapes::icosphere(4);
        for p in &mut mesh.positions {
            let dent = 1.0 + 0.3 * (5.0 * p[0]).sin() * (4.0 * p[1] + 1.0).cos();
            *p = p.map(|x| x * dent);
        }
        let surface = Surface::new(&mesh);
        let (piece, count) = segment::pieces(&surface, 0.1);
        let mut compared = 0;
        for number in 0..count as u32 {
            let of_piece = (0..piece.len() as u32).filter(|&t| piece[t as usize] == number);
            let Some(chart) = Chart::new(&surface, of_piece.collect()) else {
                continue;
            };
            let (_, inside) = inner(&chart);
            if inside > 3 {
                let [by_angles, conformal] =
                    [abf(&chart), lscm(&chart)].map(|flat| distortion(&chart, &flat.unwrap()));
                assert!(
                    by_angles < conformal,
                    "chart {number}: {by_angles} {conformal}"
                );
                compared += 1;
            }
        }
        assert!(compared > 5, "{compared}");
    }

    /// A flat chart keeps its angles; the constraints hold, and the check of them can fail.
    #[test]
    fn what_is_flat_stays_as_it_is() {
        let surface = Surface::new(&shapes::grid(6));
        let charts = merge::divided(&surface, (0..72).collect(), abf);
        assert_eq!(charts.len(), 1);
        assert!(distortion(&charts[0].chart, &charts[0].places) < 1e-9);
        let (inner, count) = inner(&charts[0].chart);
        let system = System {
            chart: &charts[0].chart,
            inner: &inner,
            count,
            wanted: angles(&charts[0].chart),
        };
        assert!(system.off(&system.wanted) < 1e-12);
        let mut bent = system.wanted.clone();
        bent[20][1] += 0.1;
        assert!(system.off(&bent) > 0.05);
    }
}
