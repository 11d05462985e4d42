//! How far a level of detail lies from its reference, in object units.
//!
//! In: the triangles of both. Out: [`Deviation`]. Sampled both ways: every vertex of the reference to the nearest point
//! of the LoD, and every vertex, edge midpoint and centroid of the LoD to the nearest point of the reference. It is a
//! measurement, so the true distance can be a little larger between samples, but unlike the simplifier's own figure
//! it is a distance.

use super::tree::Tree;
use glam::Vec3;
use rayon::prelude::*;

/// Distances between two surfaces, in the unit of their positions.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Largest distance found.
    pub max: f32,
    /// Root mean square over all samples of both directions.
    pub rms: f32,
}

/// A surface as positions and triangles.
pub type Surface<'a> = (&'a [[f32; 3]], &'a [[u32; 3]]);

/// The distance between `reference` and `lod`; zero where either has no triangles.
pub fn deviation(reference: Surface<'_>, lod: Surface<'_>) -> Deviation {
    let (Some(to_reference), Some(to_lod)) = (tree(reference), tree(lod)) else {
        return Deviation::default();
    };
    let squared = |tree: &Tree<()>, points: Vec<Vec3>| -> (f32, f64, usize) {
        let count = points.len();
        let (max, sum) = points
            .into_par_iter()
            .map(|point| {
                let near = tree.nearest(point, f32::INFINITY, |()| true);
                near.map_or(0.0, |(near, ())| near.distance_squared(point))
            })
            .fold(
                || (0.0f32, 0.0f64),
                |(max, sum), d| (max.max(d), sum + f64::from(d)),
            )
            .reduce(|| (0.0, 0.0), |a, b| (a.0.max(b.0), a.1 + b.1));
        (max, sum, count)
    };
    let there = squared(&to_lod, reference_samples(reference));
    let back = squared(&to_reference, lod_samples(lod));
    let mean = (there.1 + back.1) / (there.2 + back.2).max(1) as f64;
    Deviation {
        max: there.0.max(back.0).sqrt(),
        rms: mean.sqrt() as f32,
    }
}

fn tree((positions, triangles): Surface<'_>) -> Option<Tree<()>> {
    Tree::new(positions, triangles, |_| ())
}

/// Vertices that a triangle uses; others are not part of the surface.
fn reference_samples((positions, triangles): Surface<'_>) -> Vec<Vec3> {
    let mut used = vec![false; positions.len()];
    triangles
        .iter()
        .flatten()
        .for_each(|&v| used[v as usize] = true);
    positions
        .iter()
        .zip(used)
        .filter(|(_, used)| *used)
        .map(|(&p, _)| Vec3::from(p))
        .collect()
}

fn lod_samples((positions, triangles): Surface<'_>) -> Vec<Vec3> {
    let corners = triangles
        .iter()
        .map(|t| t.map(|v| Vec3::from(positions[v as usize])));
    corners
        .flat_map(|[a, b, c]| {
            [
                a,
                b,
                c,
                (a + b) / 2.0,
                (b + c) / 2.0,
                (c + a) / 2.0,
                (a + b + c) / 3.0,
            ]
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [[f32; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ];
    const HALVES: [[u32; 3]; 2] = [[0, 1, 2], [0, 2, 3]];

    /// A bumpy grid of `n` by `n` squares over the unit square.
    fn sheet(n: u32, height: impl Fn(f32, f32) -> f32) -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
        let at = |i: u32| i as f32 / n as f32;
        let grid = |i: u32| (at(i % (n + 1)), at(i / (n + 1)));
        let positions = (0..(n + 1) * (n + 1))
            .map(grid)
            .map(|(x, y)| [x, y, height(x, y)])
            .collect();
        let corner = |i: u32| i / n * (n + 1) + i % n;
        let squares = (0..n * n).map(corner);
        (
            positions,
            squares
                .flat_map(|i| [[i, i + 1, i + n + 2], [i, i + n + 2, i + n + 1]])
                .collect(),
        )
    }

    #[test]
    fn a_surface_is_at_no_distance_from_itself_and_a_shift_is_its_length() {
        assert!(deviation((&SQUARE, &HALVES), (&SQUARE, &HALVES)).max < 1e-6);
        let lifted = SQUARE.map(|[x, y, _]| [x, y, 0.25]);
        let d = deviation((&SQUARE, &HALVES), (&lifted, &HALVES));
        assert!(
            (d.max - 0.25).abs() < 1e-6 && (d.rms - 0.25).abs() < 1e-6,
            "{d:?}"
        );
    }

    #[test]
    fn what_only_one_of_the_two_has_is_seen_from_either_side() {
        let (bumpy, triangles) = sheet(16, |x, y| if x == 0.5 && y == 0.5 { 0.3 } else { 0.0 });
        let (there, back) = (
            deviation((&bumpy, &triangles), (&SQUARE, &HALVES)),
            deviation((&SQUARE, &HALVES), (&bumpy, &triangles)),
        );
        assert!(
            (there.max - 0.3).abs() < 1e-6 && (back.max - 0.3).abs() < 1e-6,
            "{there:?} {back:?}"
        );
    }

    #[test]
    fn triangles_without_area_and_empty_surfaces_are_no_trouble() {
        let line = [[0, 1, 1], [2, 2, 2]];
        assert!(
            deviation((&SQUARE, &line), (&SQUARE, &HALVES))
                .max
                .is_finite()
        );
        assert_eq!(
            deviation((&SQUARE, &[]), (&SQUARE, &HALVES)),
            Deviation::default()
        );
    }
}
