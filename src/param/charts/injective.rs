//! Whether a map of a disk is one-to-one.
//!
//! In: a [`Chart`] and its map. Out: yes, or why not. A map of a disk is one-to-one where no triangle is turned over and the
//! image of its rim does not meet itself: it then winds once round every point inside. Segments are compared within the
//! cells of a grid, so time grows with the rim.

use super::chart::Chart;
use glam::DVec2;

/// What is wrong with a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fault {
    /// Triangles without area, or turned over: how many.
    Turned(usize),
    /// The rim meets itself.
    Overlap,
}

/// A triangle whose image is thinner than this share of its longest edge counts as turned over: the grid could not tell.
const THIN: f64 = 1e-7;

/// What is wrong with the map `flat` of `chart`, if anything is.
pub(crate) fn fault(chart: &Chart, flat: &[DVec2]) -> Option<Fault> {
    let turned = |corners: &&[u32; 3]| {
        let [a, b, c] = corners.map(|v| flat[v as usize]);
        let longest = (b - a)
            .length_squared()
            .max((c - b).length_squared())
            .max((a - c).length_squared());
        let double_area = (b - a).perp_dot(c - a);
        double_area.is_nan() || double_area <= THIN * longest
    };
    let turned = chart.corners.iter().filter(turned).count();
    if turned > 0 {
        return Some(Fault::Turned(turned));
    }
    let rim: Vec<DVec2> = chart.rim.iter().map(|&v| flat[v as usize]).collect();
    meets_itself(&rim).then_some(Fault::Overlap)
}

/// Whether a closed polygon meets itself anywhere but where consecutive sides join.
pub(crate) fn meets_itself(polygon: &[DVec2]) -> bool {
    let sides = polygon.len();
    if sides < 4 {
        return false;
    }
    let (low, high) = polygon
        .iter()
        .fold((polygon[0], polygon[0]), |(l, h), p| (l.min(*p), h.max(*p)));
    let extent = (high - low).max_element();
    if !(extent > 0.0 && extent.is_finite()) {
        return true;
    }
    // About one side a cell along the rim; a cell is no smaller than the mean side.
    let cells = (sides / 4).clamp(1, 1024);
    let cell = |p: DVec2| {
        ((p - low) / extent * cells as f64)
            .as_ivec2()
            .clamp(glam::IVec2::ZERO, glam::IVec2::splat(cells as i32 - 1))
    };
    let side = |i: usize| [polygon[i], polygon[(i + 1) % sides]];
    let mut filled: Vec<(u32, u32)> = Vec::with_capacity(2 * sides);
    for i in 0..sides {
        let [a, b] = side(i).map(cell);
        let (from, to) = (a.min(b), a.max(b));
        for y in from.y..=to.y {
            for x in from.x..=to.x {
                filled.push(((y * cells as i32 + x) as u32, i as u32));
            }
        }
    }
    filled.sort_unstable();
    filled.chunk_by(|a, b| a.0 == b.0).any(|group| {
        group.iter().enumerate().any(|(k, &(_, i))| {
            group[k + 1..].iter().any(|&(_, j)| {
                let apart = (j - i) as usize;
                let joined = apart == 1 || apart == sides - 1;
                apart != 0 && !joined && meet(side(i as usize), side(j as usize))
            })
        })
    })
}

/// Whether two segments have a point in common.
fn meet([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    let boxes = a.min(b).cmple(c.max(d)).all() && c.min(d).cmple(a.max(b)).all();
    boxes && side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn polygon(points: &[[f64; 2]]) -> Vec<DVec2> {
        points.iter().map(|&p| p.into()).collect()
    }

    #[test]
    fn a_star_is_simple_and_a_bow_tie_is_not() {
        let star: Vec<DVec2> = (0..200)
            .map(|i| {
                let radius = if i % 2 == 0 { 1.0 } else { 0.2 };
                DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 200.0) * radius
            })
            .collect();
        assert!(!meets_itself(&star));
        assert!(meets_itself(&polygon(&[
            [0.0, 0.0],
            [1.0, 1.0],
            [1.0, 0.0],
            [0.0, 1.0]
        ])));
        let mut crossed = star.clone();
        crossed[7] = DVec2::new(-0.9, 0.1);
        assert!(meets_itself(&crossed));
    }

    #[test]
    fn a_polygon_that_touches_itself_meets_itself() {
        let touching = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.0], [0.0, 2.0]];
        assert!(meets_itself(&polygon(&touching)));
        let apart = [[0.0, 0.0], [2.0, 0.0], [2.0, 2.0], [1.0, 0.1], [0.0, 2.0]];
        assert!(!meets_itself(&polygon(&apart)));
    }
}
