//! Where to put a centre or an axis: the point from which the least surface is turned away.
//!
//! In: one half-space per triangle ([`HalfSpace`]): the points from which the triangle's front is seen from inside.
//! Out: a point in as many (by area) of the half-spaces as can be found.
//!
//! A mesh is star-shaped about `c` iff `c` lies in every half-space, so the first try is the point with the largest
//! margin (a linear program, solved here by minimising a squared hinge at growing margins). Where there is no such
//! point, convex hinge losses give starts and a pattern search walks down the true turned area, which is neither convex
//! nor continuous. Everything is sequential and ordered, so the same mesh gives the same bits.

/// The half-space `offset - normal . c > 0` of one triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct HalfSpace {
    /// Outward unit normal (for an axis: without its component along the axis, hence shorter than 1).
    pub(crate) normal: [f64; 3],
    /// `normal . p` for a point `p` of the triangle.
    pub(crate) offset: f64,
    /// Area, as a share of all.
    pub(crate) weight: f64,
}

impl HalfSpace {
    /// Signed distance of `c` behind the triangle, in object units (positive: not turned).
    fn distance(&self, c: [f64; 3]) -> f64 {
        self.offset - dot(self.normal, c)
    }
}

/// How many triangles the search itself looks at; a larger mesh is thinned evenly, the candidates are compared on all.
const SEARCH_TRIANGLES: usize = 10_000;
/// Shares of area closer than this are the same: the point with the larger margin is then taken.
const SAME_SHARE: f64 = 1e-4;

/// The best point found, starting from `starts` (area centroid, middle of the box, ...); `radius` is half the mesh's
/// diagonal. Returns the first start where there is nothing to optimise.
pub(crate) fn search(spaces: &[HalfSpace], starts: &[[f64; 3]], radius: f64) -> [f64; 3] {
    let first = starts[0];
    if spaces.is_empty() || radius <= 0.0 {
        return first;
    }
    let stride = spaces.len().div_ceil(SEARCH_TRIANGLES);
    let sample: Vec<HalfSpace> = spaces.iter().step_by(stride).copied().collect();
    let mut candidates = starts.to_vec();
    let inner = widest(spaces, &sample, first, radius);
    candidates.push(inner);
    if turned(spaces, inner) > 0.0 {
        // Walks from the convex loss's minimum and from the best of the others: the rest end in the same valleys.
        let shares = candidates.iter().map(|&c| (turned(&sample, c), c));
        let other = shares
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map_or(first, |best| best.1);
        let convex = least_hinge(&sample, first, radius);
        candidates.push(convex);
        candidates.extend([convex, other].map(|start| walk(&sample, start, radius)));
    }
    best(spaces, &candidates)
}

/// Of points that turn the same share of area, the one with the widest margin.
fn best(spaces: &[HalfSpace], candidates: &[[f64; 3]]) -> [f64; 3] {
    let shares: Vec<f64> = candidates.iter().map(|&c| turned(spaces, c)).collect();
    let least = shares.iter().copied().fold(f64::INFINITY, f64::min);
    // Exactly nothing turned is another thing than almost nothing.
    let limit = if least == 0.0 {
        0.0
    } else {
        least + SAME_SHARE
    };
    let mut chosen = (f64::NEG_INFINITY, candidates[0]);
    for (&c, _) in candidates
        .iter()
        .zip(&shares)
        .filter(|&(_, &share)| share <= limit)
    {
        let margin = if least == 0.0 {
            margin(spaces, c)
        } else {
            depth(spaces, c)
        };
        if margin > chosen.0 {
            chosen = (margin, c);
        }
    }
    chosen.1
}

/// The share of area turned away from `c`.
pub(crate) fn turned(spaces: &[HalfSpace], c: [f64; 3]) -> f64 {
    spaces
        .iter()
        .filter(|s| s.distance(c) <= 0.0)
        .map(|s| s.weight)
        .sum()
}

/// The smallest distance to any half-space's border; negative outside.
pub(crate) fn margin(spaces: &[HalfSpace], c: [f64; 3]) -> f64 {
    spaces
        .iter()
        .map(|s| s.distance(c))
        .fold(f64::INFINITY, f64::min)
}

/// Mean of the distances that are negative: how badly the turned triangles are turned (0 is best).
fn depth(spaces: &[HalfSpace], c: [f64; 3]) -> f64 {
    spaces
        .iter()
        .map(|s| s.weight * s.distance(c).min(0.0))
        .sum()
}

/// The point with (nearly) the widest margin, by bisection on the margin. Constraints of the thinned set that turn out
/// not to be enough are joined by the violated ones of the whole set.
fn widest(spaces: &[HalfSpace], sample: &[HalfSpace], start: [f64; 3], radius: f64) -> [f64; 3] {
    let mut active = sample.to_vec();
    let mut point = start;
    for _ in 0..4 {
        point = widest_of(&active, start, radius);
        if sample.len() == spaces.len() {
            break;
        }
        let reach = margin(&active, point).max(0.0);
        let violated: Vec<HalfSpace> = spaces
            .iter()
            .filter(|s| s.distance(point) < 0.5 * reach)
            .copied()
            .collect();
        if violated.is_empty() || violated.len() > SEARCH_TRIANGLES {
            break;
        }
        active.extend(violated);
    }
    point
}

fn widest_of(spaces: &[HalfSpace], start: [f64; 3], radius: f64) -> [f64; 3] {
    let (mut low, mut high) = (0.0, radius);
    let mut best = (margin(spaces, start), start);
    for _ in 0..14 {
        let wanted = 0.5 * (low + high);
        let point = newton(
            spaces,
            best.1,
            radius,
            |distance| squared_hinge(wanted - distance),
            |_| 1.0,
        );
        let reached = margin(spaces, point);
        if reached > best.0 {
            best = (reached, point);
        }
        if best.0 >= 0.98 * wanted {
            low = best.0.max(wanted);
        } else {
            high = wanted;
        }
    }
    best.1
}

/// The point of least area-weighted depth, by Newton steps on a hinge smoothed over shrinking widths.
fn least_hinge(spaces: &[HalfSpace], start: [f64; 3], radius: f64) -> [f64; 3] {
    let mut point = start;
    for width in [0.3, 0.1, 0.03, 0.01, 0.003].map(|w| w * radius) {
        point = newton(
            spaces,
            point,
            radius,
            |distance| smooth_hinge(-distance, width),
            |s| s.weight,
        );
    }
    point
}

/// Value, slope and curvature of a loss at one violation.
struct Loss {
    value: f64,
    slope: f64,
    curvature: f64,
}

fn squared_hinge(x: f64) -> Loss {
    if x > 0.0 {
        Loss {
            value: x * x,
            slope: 2.0 * x,
            curvature: 2.0,
        }
    } else {
        Loss {
            value: 0.0,
            slope: 0.0,
            curvature: 0.0,
        }
    }
}

fn smooth_hinge(x: f64, width: f64) -> Loss {
    if x <= 0.0 {
        Loss {
            value: 0.0,
            slope: 0.0,
            curvature: 0.0,
        }
    } else if x < width {
        Loss {
            value: 0.5 * x * x / width,
            slope: x / width,
            curvature: 1.0 / width,
        }
    } else {
        Loss {
            value: x - 0.5 * width,
            slope: 1.0,
            curvature: 0.0,
        }
    }
}

/// Damped Newton iterations on `sum weight * loss(distance)`; the loss must be convex and grow with the violation
/// `-distance`. No step is longer than `reach`.
fn newton(
    spaces: &[HalfSpace],
    start: [f64; 3],
    reach: f64,
    loss: impl Fn(f64) -> Loss,
    weight: impl Fn(&HalfSpace) -> f64,
) -> [f64; 3] {
    let value = |c: [f64; 3]| {
        spaces
            .iter()
            .map(|s| weight(s) * loss(s.distance(c)).value)
            .sum::<f64>()
    };
    let mut point = start;
    let mut at = value(point);
    for _ in 0..24 {
        if at == 0.0 {
            break;
        }
        let (mut gradient, mut hessian) = ([0.0; 3], [[0.0; 3]; 3]);
        for s in spaces {
            let l = loss(s.distance(point));
            let (g, h) = (weight(s) * l.slope, weight(s) * l.curvature);
            for (i, row) in hessian.iter_mut().enumerate() {
                gradient[i] += g * s.normal[i];
                row.iter_mut()
                    .zip(s.normal)
                    .for_each(|(cell, n)| *cell += h * s.normal[i] * n);
            }
        }
        let trace = hessian[0][0] + hessian[1][1] + hessian[2][2];
        (0..3).for_each(|i| hessian[i][i] += 1e-6 * trace + 1e-12);
        let step = solve(hessian, gradient);
        // Where the loss is straight there is no curvature, and a step would end anywhere.
        let mut scale = (reach / dot(step, step).sqrt()).min(1.0);
        let mut moved = false;
        for _ in 0..12 {
            let next: [f64; 3] = std::array::from_fn(|i| point[i] - scale * step[i]);
            let there = value(next);
            if there < at {
                moved = there < at * (1.0 - 1e-9);
                (point, at) = (next, there);
                break;
            }
            scale *= 0.5;
        }
        if !moved {
            break;
        }
    }
    point
}

/// Pattern search on the turned area itself: 26 directions, the step halved when none helps.
fn walk(spaces: &[HalfSpace], start: [f64; 3], radius: f64) -> [f64; 3] {
    // The depth breaks ties on the plateaus of a step function.
    let cost = |c: [f64; 3]| {
        let of = |s: &HalfSpace| match s.distance(c) {
            distance if distance > 0.0 => 0.0,
            distance => s.weight * (1.0 - 0.01 * distance / radius),
        };
        spaces.iter().map(of).sum::<f64>()
    };
    let mut point = start;
    let mut at = cost(point);
    let mut step = 0.1 * radius;
    while step > 2e-3 * radius {
        let mut next = (at, point);
        for direction in (0..27).filter(|&d| d != 13) {
            let offset = [direction % 3, direction / 3 % 3, direction / 9]
                .map(|d| (f64::from(d) - 1.0) * step);
            let c: [f64; 3] = std::array::from_fn(|i| point[i] + offset[i]);
            let there = cost(c);
            if there < next.0 {
                next = (there, c);
            }
        }
        if next.0 < at - 1e-7 {
            (at, point) = next;
        } else {
            step *= 0.5;
        }
    }
    point
}

/// Solves the symmetric 3 x 3 system `m x = v` by Cramer's rule; zero where it is singular.
fn solve(m: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    let columns = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])];
    let determinant = dot(m[0], columns[0]);
    if determinant == 0.0 || !determinant.is_finite() {
        return [0.0; 3];
    }
    std::array::from_fn(|i| {
        (columns[0][i] * v[0] + columns[1][i] * v[1] + columns[2][i] * v[2]) / determinant
    })
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The half-spaces of a box `[-1, 1]^3 + at`, each face weighted the same.
    fn cube(at: [f64; 3]) -> Vec<HalfSpace> {
        (0..6)
            .map(|face| {
                let mut normal = [0.0; 3];
                normal[face / 2] = if face % 2 == 0 { 1.0 } else { -1.0 };
                HalfSpace {
                    normal,
                    offset: 1.0 + dot(normal, at),
                    weight: 1.0 / 6.0,
                }
            })
            .collect()
    }

    #[test]
    fn widest_point_of_a_cube_is_its_middle() {
        let spaces = cube([3.0, -2.0, 5.0]);
        let point = search(&spaces, &[[0.0; 3]], 10.0);
        assert_eq!(turned(&spaces, point), 0.0);
        assert!(margin(&spaces, point) > 0.9, "{point:?}");
    }

    #[test]
    fn infeasible_constraints_turn_the_lighter_side() {
        // Nothing is left of -1 and right of +1 at once: the lighter of the two must be given up.
        let mut spaces = cube([0.0; 3]);
        spaces.push(HalfSpace {
            normal: [1.0, 0.0, 0.0],
            offset: -3.0,
            weight: 0.01,
        });
        let point = search(&spaces, &[[-4.0, 0.0, 0.0]], 5.0);
        assert!(
            (turned(&spaces, point) - 0.01).abs() < 1e-12,
            "{point:?} turns {}",
            turned(&spaces, point)
        );
    }

    #[test]
    fn no_triangles_give_the_start() {
        assert_eq!(search(&[], &[[1.0, 2.0, 3.0]], 1.0), [1.0, 2.0, 3.0]);
    }

    #[test]
    fn linear_system_is_solved() {
        let m = [[4.0, 1.0, 0.5], [1.0, 3.0, 0.2], [0.5, 0.2, 2.0]];
        let x = solve(m, [1.0, 2.0, 3.0]);
        let back: Vec<f64> = m.iter().map(|row| dot(*row, x)).collect();
        assert!(
            back.iter()
                .zip([1.0, 2.0, 3.0])
                .all(|(a, b)| (a - b).abs() < 1e-12),
            "{back:?}"
        );
    }
}
