//! A surface opened to a disk and laid on a square.
//!
//! In: a connected part of a [`Surface`]. Out: one chart whose rim is the border of a square. The part is cut to a disk; the cut
//! is made longer, from its border to where the surface is stretched most, as long as that helps. Inside, every vertex is a
//! mean of its neighbours with positive weights, so that no triangle is turned over whatever the shape; weights begin as
//! mean value coordinates, under which what is flat stays as it is, and then follow the stretch.
//! Source: Gu, Gortler, Hoppe, Geometry Images (2002), sections 3.1 and 3.2; Floater, Mean value coordinates (2003);
//! Yoshizawa, Belyaev, Seidel, A fast and simple stretch-minimizing mesh parameterization (2004).

use super::chart::Chart;
use super::injective::fault;
use super::lscm::laid_flat;
use super::merge::Flat;
use super::stretch::{singular_values, sums, to_own_area};
use super::surface::Surface;
use super::ways::{Edge, Ways, ways};
use faer::Mat;
use faer::prelude::Solve;
use faer::sparse::{SparseColMat, Triplet};
use glam::DVec2;

/// Times that the cut is made longer.
const CUTS: usize = 6;
/// Times that weights follow the stretch.
const FOLLOWED: usize = 4;
/// How far the sides of the square are bent outwards where an edge would lie in a side, as a share of their length.
const BENT: f64 = 0.02;

/// Weights of each vertex's neighbours; empty on the rim.
type Weights = Vec<Vec<(u32, f64)>>;

/// The part on a square; none where it cannot be cut to a disk or the system cannot be solved.
pub(super) fn square(surface: &Surface, triangles: &[u32]) -> Option<Flat> {
    let mut slits: Vec<u32> = vec![];
    let mut best: Option<Flat> = None;
    for _ in 0..=CUTS {
        let chart = Chart::opened(surface, triangles.to_vec(), &slits)?;
        let Some(flat) = laid(&chart) else {
            // Too much of the surface hangs on too short a rim: the cut goes to what is farthest from it.
            if best.is_some() {
                break;
            }
            slits.extend(way_from_rim(surface, &chart, None));
            continue;
        };
        let longer = way_from_rim(surface, &chart, Some(worst(&flat)));
        let better = best
            .as_ref()
            .is_none_or(|b| flat.stretch.l2 < 0.98 * b.stretch.l2);
        if better {
            best = Some(flat);
        }
        if !better || longer.is_empty() || best.as_ref().is_some_and(|b| b.stretch.l2 < 1.02) {
            break;
        }
        slits.extend(longer);
    }
    best
}

/// The chart on a square with the least stretch that weights found.
fn laid(chart: &Chart) -> Option<Flat> {
    if chart.rim.len() < 4 && chart.corners.len() > 1 {
        return None;
    }
    let border = border(chart);
    let mut weights = mean_values(chart);
    let mut best: Option<Flat> = None;
    for _ in 0..=FOLLOWED {
        let Some(mut places) = solved(chart, &border, &weights) else {
            break;
        };
        if !to_own_area(chart, &mut places) || fault(chart, &places).is_some() {
            break;
        }
        let stretch = sums(chart, &places).stretch();
        follow(chart, &places, &mut weights);
        let better = best.as_ref().is_none_or(|b| stretch.l2 < b.stretch.l2);
        if !better {
            break;
        }
        best = Some(Flat {
            chart: chart.clone(),
            places,
            stretch,
        });
    }
    best
}

/// Places of the rim's vertices, in its order, on a square of side 1, by length from the sharpest corner.
fn border(chart: &Chart) -> Vec<DVec2> {
    let rim = &chart.rim;
    let count = rim.len();
    let mut angle = vec![0.0; chart.places.len()];
    for (i, corners) in chart.corners.iter().enumerate() {
        let flat = laid_flat(chart.triangle(i));
        for k in 0..3 {
            angle[corners[k] as usize] += (flat[(k + 1) % 3] - flat[k])
                .angle_to(flat[(k + 2) % 3] - flat[k])
                .abs();
        }
    }
    let sharp = |best: usize, i: usize| {
        if angle[rim[i] as usize] < angle[rim[best] as usize] - 1e-9 {
            i
        } else {
            best
        }
    };
    let start = (1..count).fold(0, sharp);
    let place = |i: usize| chart.places[rim[(start + i) % count] as usize];
    let mut along = vec![0.0; count + 1];
    for i in 0..count {
        along[i + 1] = along[i] + place(i).distance(place(i + 1));
    }
    // Corners are vertices; a side has one edge at least.
    let mut corners = [0, 0, 0, 0, count];
    for side in 1..4 {
        let wanted = along[count] * side as f64 / 4.0;
        let range = corners[side - 1] + 1..count - (3 - side);
        let near = |best: usize, i: usize| {
            if (along[i] - wanted).abs() < (along[best] - wanted).abs() {
                i
            } else {
                best
            }
        };
        corners[side] = range.clone().fold(range.start, near);
    }
    let bend = if joins_a_side(chart, start, &corners) {
        BENT
    } else {
        0.0
    };
    let mut out = vec![DVec2::ZERO; count];
    for side in 0..4 {
        let (from, to) = (corners[side], corners[side + 1]);
        let turn = DVec2::from_angle(side as f64 * std::f64::consts::FRAC_PI_2);
        let origin = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y][side];
        let exact = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y][side];
        for i in from..to {
            let length = along[to] - along[from];
            let s = if length > 0.0 {
                (along[i] - along[from]) / length
            } else {
                (i - from) as f64 / (to - from) as f64
            };
            let outwards = turn.rotate(DVec2::NEG_Y) * (4.0 * bend * s * (1.0 - s));
            out[(start + i) % count] = origin + exact * s + outwards;
        }
    }
    out
}

/// Whether an edge inside joins two vertices of one side: all beyond it would be squeezed into the side.
fn joins_a_side(chart: &Chart, start: usize, corners: &[usize; 5]) -> bool {
    let count = chart.rim.len();
    let mut at = vec![usize::MAX; chart.places.len()];
    chart
        .rim
        .iter()
        .enumerate()
        .for_each(|(i, &v)| at[v as usize] = (i + count - start) % count);
    let inside = |a: usize, b: usize| {
        let apart = a.abs_diff(b);
        let next = apart == 1 || apart == count - 1;
        let on = |i: usize, side: usize| {
            (corners[side]..=corners[side + 1]).contains(&i) || (i == 0 && side == 3)
        };
        !next && (0..4).any(|side| on(a, side) && on(b, side))
    };
    chart.corners.iter().any(|t| {
        (0..3).any(|k| {
            let (a, b) = (at[t[k] as usize], at[t[(k + 1) % 3] as usize]);
            a != usize::MAX && b != usize::MAX && inside(a, b)
        })
    })
}

/// Mean value coordinates of inner vertices on the surface.
fn mean_values(chart: &Chart) -> Weights {
    let mut on_rim = vec![false; chart.places.len()];
    chart.rim.iter().for_each(|&v| on_rim[v as usize] = true);
    let mut weights: Weights = vec![vec![]; chart.places.len()];
    for (i, corners) in chart.corners.iter().enumerate() {
        let flat = laid_flat(chart.triangle(i));
        for k in 0..3 {
            let v = corners[k] as usize;
            if on_rim[v] {
                continue;
            }
            let (a, b) = (flat[(k + 1) % 3] - flat[k], flat[(k + 2) % 3] - flat[k]);
            let half = (0.5 * a.angle_to(b).abs()).tan();
            for (other, edge) in [(corners[(k + 1) % 3], a), (corners[(k + 2) % 3], b)] {
                let weight = half / edge.length();
                match weights[v].iter_mut().find(|(w, _)| *w == other) {
                    Some((_, sum)) => *sum += weight,
                    None => weights[v].push((other, weight)),
                }
            }
        }
    }
    weights
}

/// Divides weights by the stretch about each neighbour: what is stretched is drawn together.
fn follow(chart: &Chart, places: &[DVec2], weights: &mut Weights) {
    let mut squares = vec![0.0; chart.places.len()];
    let mut areas = vec![0.0; chart.places.len()];
    for (i, corners) in chart.corners.iter().enumerate() {
        let shape = laid_flat(chart.triangle(i));
        let [large, small] = singular_values(shape, corners.map(|v| places[v as usize]));
        let area = (shape[1] - shape[0]).perp_dot(shape[2] - shape[0]);
        let square = 0.5 * (1.0 / (large * large) + 1.0 / (small * small));
        for &v in corners {
            squares[v as usize] += area * square;
            areas[v as usize] += area;
        }
    }
    let stretch = |v: u32| {
        (squares[v as usize] / areas[v as usize])
            .sqrt()
            .clamp(1e-3, 1e3)
    };
    for (v, weight) in weights.iter_mut().flatten() {
        *weight /= stretch(*v);
    }
}

/// Places where every inner vertex is the mean of its neighbours.
fn solved(chart: &Chart, border: &[DVec2], weights: &Weights) -> Option<Vec<DVec2>> {
    let mut places = vec![DVec2::ZERO; chart.places.len()];
    chart
        .rim
        .iter()
        .zip(border)
        .for_each(|(&v, &p)| places[v as usize] = p);
    let mut number = vec![usize::MAX; places.len()];
    let mut count = 0;
    for (v, _) in weights.iter().enumerate().filter(|(_, w)| !w.is_empty()) {
        number[v] = count;
        count += 1;
    }
    if count == 0 {
        return Some(places);
    }
    let mut entries: Vec<Triplet<usize, usize, f64>> = vec![];
    let mut right: Mat<f64> = Mat::zeros(count, 2);
    for (v, of) in weights.iter().enumerate().filter(|(_, w)| !w.is_empty()) {
        let row = number[v];
        let total: f64 = of.iter().map(|(_, w)| w).sum();
        entries.push(Triplet::new(row, row, 1.0));
        for &(other, weight) in of {
            let share = weight / total;
            match number[other as usize] {
                usize::MAX => {
                    right[(row, 0)] += share * places[other as usize].x;
                    right[(row, 1)] += share * places[other as usize].y;
                }
                column => entries.push(Triplet::new(row, column, -share)),
            }
        }
    }
    let matrix = SparseColMat::try_new_from_triplets(count, count, &entries).ok()?;
    matrix.sp_lu().ok()?.solve_in_place(&mut right);
    for (v, &row) in number
        .iter()
        .enumerate()
        .filter(|(_, row)| **row != usize::MAX)
    {
        places[v] = DVec2::new(right[(row, 0)], right[(row, 1)]);
    }
    places.iter().all(|p| p.is_finite()).then_some(places)
}

/// A vertex of the triangle that is stretched most.
fn worst(flat: &Flat) -> u32 {
    let chart = &flat.chart;
    let badness = |i: usize| {
        let shape = laid_flat(chart.triangle(i));
        let [large, small] =
            singular_values(shape, chart.corners[i].map(|v| flat.places[v as usize]));
        1.0 / small + 1.0 / large
    };
    let all = (0..chart.corners.len()).map(|i| (badness(i), i));
    let (_, worst) = all.fold((0.0, 0), |best, x| if x.0 > best.0 { x } else { best });
    chart.corners[worst][0]
}

/// Half-edges of the surface on the shortest way from the rim to vertex `to`, or to the one farthest from the rim.
fn way_from_rim(surface: &Surface, chart: &Chart, to: Option<u32>) -> Vec<u32> {
    let mut edges: Vec<Vec<Edge>> = vec![vec![]; chart.places.len()];
    for (i, corners) in chart.corners.iter().enumerate() {
        for k in 0..3 {
            let number = 3 * chart.triangles[i] + k as u32;
            let length = surface.length(number as usize);
            let ends = [corners[k], corners[(k + 1) % 3]];
            for (from, to) in [(ends[0], ends[1]), (ends[1], ends[0])] {
                edges[from as usize].push(Edge { to, length, number });
            }
        }
    }
    let Ways {
        distance, arrived, ..
    } = ways(chart.places.len(), chart.rim.iter().copied(), |v| {
        edges[v as usize].iter().copied()
    });
    let mut way = vec![];
    let farthest = (1..distance.len()).fold(
        0,
        |far, v| if distance[v] > distance[far] { v } else { far },
    );
    let mut v = to.unwrap_or(farthest as u32);
    while let Some((from, half_edge)) = arrived[v as usize] {
        way.push(half_edge);
        v = from;
    }
    way
}
