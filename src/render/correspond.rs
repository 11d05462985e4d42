//! From a drawn triangle to the point of the reference it stands for. Twin of `glsl/render/correspond.glsl`.
//!
//! In: the drawn triangle's barycentrics at a pixel and at its two neighbours. Out: a [`SurfacePoint`] with gradients.
//!
//! *Identity*: the drawn triangle is the reference's own. *Inverse geometric texture*: T3 is interpolated over the drawn
//! triangle, brought to the query grid and looked up. Gradients then come from the reference triangle found: the query
//! points of the neighbouring pixels are projected along their own lines into its plane (the paper's "derivatives in
//! T3", section 2.5), never looked up, so that they do not jump where the neighbour lies in another triangle.

use super::draw::DrawRecord;
use super::picture::Picture;
use super::shade::Drawn;
use crate::attribute::arithmetic::{V3, add3, cross3, dot3, scale3, sub3};
use crate::attribute::surface::SurfacePoint;
use crate::igt::{Asker, Tables};
use crate::param::grid::{QUERY_MAX, QUERY_SHIFT};
use crate::param::projection::{GridTriangle, Line, hit};

/// [`DrawRecord::correspondence`] of a draw whose triangles are the reference's own.
pub(crate) const IDENTITY: u32 = 0;
/// Of a draw whose reference points come from tables.
pub(crate) const INVERSE: u32 = 1;
/// Query-grid steps to floats of about one, so that no product of six of them leaves the range of `f32`.
const UNIT: f32 = 1.0 / 536_870_912.0;

/// How far from its first corner a query on a triangle may be, in steps of the query grid.
const REACH: f32 = 1.5e9;

/// What a correspondence answers.
pub(crate) struct Correspondence {
    /// None where the tables know no triangle near the point.
    pub point: Option<SurfacePoint>,
    /// Fetches it took.
    pub fetches: u32,
}

/// The point of the reference under a pixel.
pub(crate) fn find(picture: &Picture, draw: &DrawRecord, drawn: &Drawn) -> Correspondence {
    if draw.correspondence == IDENTITY {
        identity(draw, drawn)
    } else {
        inverse(picture, draw, drawn)
    }
}

fn identity(draw: &DrawRecord, drawn: &Drawn) -> Correspondence {
    let point = SurfacePoint {
        triangle: draw.attribute_base + drawn.local,
        b: drawn.b,
        dx: drawn.bx.map(|b| sub3(b, drawn.b)),
        dy: drawn.by.map(|b| sub3(b, drawn.b)),
        taps: 1,
    };
    Correspondence {
        point: Some(point),
        fetches: 0,
    }
}

fn inverse(picture: &Picture, draw: &DrawRecord, drawn: &Drawn) -> Correspondence {
    let tables = &picture.tables[draw.igt[0] as usize];
    let t3 = drawn.vertex.map(|v| picture.t3[v as usize]);
    inverse_at(tables, draw.attribute_base, &t3, drawn)
}

/// Through the inverse geometric texture, for a triangle whose corners are `t3` on the vertex grid: the reference point,
/// its triangle counted from `attribute_base`.
pub(crate) fn inverse_at(
    tables: &Tables,
    attribute_base: u32,
    t3: &[[i32; 4]; 3],
    drawn: &Drawn,
) -> Correspondence {
    let query = query_point(t3, drawn.b).map(|q| q.clamp(-QUERY_MAX, QUERY_MAX));
    let asker = Asker::from_word(drawn.asker);
    let (found, cost) = tables.lookup_with_cost(query, asker, true);
    let Some(found) = found else {
        return Correspondence {
            point: None,
            fetches: cost.fetches,
        };
    };
    let corners = tables.corners(found.triangle);
    let line = tables.primary.line();
    let here = projected(line, query, &corners);
    let moved =
        |b: Option<[f32; 3]>| Some(sub3(projected(line, query_point(t3, b?), &corners)?, here?));
    let point = SurfacePoint {
        triangle: attribute_base + found.triangle,
        b: found.barycentric,
        dx: moved(drawn.bx),
        dy: moved(drawn.by),
        taps: 1,
    };
    Correspondence {
        point: Some(point),
        fetches: found.fetches,
    }
}

/// Where in `triangle` of the reference the drawn point lies, if it does: its line meets it.
pub(super) fn within(
    picture: &Picture,
    draw: &DrawRecord,
    drawn: &Drawn,
    triangle: u32,
) -> Option<[f32; 3]> {
    let tables = &picture.tables[draw.igt[0] as usize];
    let t3 = drawn.vertex.map(|v| picture.t3[v as usize]);
    let query = query_point(&t3, drawn.b).map(|q| q.clamp(-QUERY_MAX, QUERY_MAX));
    let met = hit(tables.primary.line(), query, &tables.corners(triangle));
    met.map(|met| met.barycentric())
}

/// T3 at barycentrics `b` of a drawn triangle, on the query grid. Relative to the first vertex, so that the error is
/// 2^-24 of the triangle, not of the whole domain. A triangle may span the domain, 2^30 steps; a neighbour of a pixel that
/// sees its triangle edge on may lie outside by as much as an i32 holds, and its gradient must not be cut short.
pub(super) fn query_point(t3: &[[i32; 4]; 3], b: [f32; 3]) -> [i32; 3] {
    std::array::from_fn(|k| {
        let along = |v: usize| ((t3[v][k] - t3[0][k]) << QUERY_SHIFT) as f32;
        let offset = b[1] * along(1) + b[2] * along(2);
        let offset = (offset + 0.5).floor().clamp(-REACH, REACH) as i32;
        (t3[0][k] << QUERY_SHIFT) + offset
    })
}

/// A point of the query grid, -1..1.
pub(super) fn unit(v: [i32; 3]) -> V3 {
    v.map(|x| x as f32 * UNIT)
}

/// Barycentrics, in the plane of `corners`, of the point where the line of `query` meets it; none for a line along it.
///
/// With d the line's direction, n the plane's normal and w the query relative to the first corner, the point is
/// w - d (n.w) / (n.d): differences of nearby points throughout, so neighbours can be subtracted. Where the line grazes the
/// plane (sine under 1/5, as [`is_grazed`](crate::param::projection::is_grazed) has it) a neighbour would land far away and
/// its texture be blurred to one colour; the plane's normal takes the line's place.
fn projected(line: Line, query: [i32; 3], corners: &GridTriangle) -> Option<[f32; 3]> {
    let edge = |v: usize| {
        unit(std::array::from_fn(|k| {
            (corners[v][k] - corners[0][k]) << QUERY_SHIFT
        }))
    };
    let (e1, e2) = (edge(1), edge(2));
    let w = unit(std::array::from_fn(|k| {
        query[k] - (corners[0][k] << QUERY_SHIFT)
    }));
    let q = unit(query);
    let d: V3 = match line {
        Line::Parallel => [0.0, 0.0, 1.0],
        Line::Cylinder => [q[0], q[1], 0.0],
        Line::Sphere => q,
    };
    let n = cross3(e1, e2);
    let (steepness, area) = (dot3(n, d), dot3(n, n));
    if area.is_nan() || area <= 1e-32 {
        return None;
    }
    let grazed = steepness * steepness <= area * dot3(d, d) * 0.04;
    let r = if grazed {
        add3(w, scale3(n, -(dot3(n, w) / area)))
    } else {
        add3(w, scale3(d, -(dot3(n, w) / steepness)))
    };
    let b1 = dot3(cross3(r, e2), n) / area;
    let b2 = dot3(cross3(e1, r), n) / area;
    Some([1.0 - b1 - b2, b1, b2])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_on_the_triangle_projects_to_its_own_barycentrics() {
        let corners: GridTriangle = [
            [4_000_000, 100, 3_000_000],
            [3_997_000, 9_000, 3_004_000],
            [4_003_000, -7_000, 2_999_000],
        ];
        let b = [0.2f64, 0.5, 0.3];
        let p: [f64; 3] =
            std::array::from_fn(|k| (0..3).map(|i| b[i] * f64::from(corners[i][k])).sum::<f64>());
        for (line, scale) in [
            (Line::Sphere, [0.97, 0.97, 0.97]),
            (Line::Cylinder, [1.02, 1.02, 1.0]),
            (Line::Parallel, [1.0, 1.0, 0.9]),
        ] {
            // Another point of the same projection line.
            let query = std::array::from_fn(|k| (p[k] * scale[k] * 64.0).round() as i32);
            let got = projected(line, query, &corners).unwrap();
            for i in 0..3 {
                assert!((f64::from(got[i]) - b[i]).abs() < 2e-4, "{line:?} {got:?}");
            }
        }
        // Along the lines of the plane: the foot of the perpendicular, however far the line would have to run.
        let upright: GridTriangle = [[0, 0, 0], [9_000, 0, 0], [0, 0, 9_000]];
        let query = [
            3_000 << QUERY_SHIFT,
            500 << QUERY_SHIFT,
            3_000 << QUERY_SHIFT,
        ];
        let foot = projected(Line::Parallel, query, &upright).unwrap();
        assert!(
            foot.iter().all(|b| (b - 1.0 / 3.0).abs() < 1e-4),
            "{foot:?}"
        );
        let flat: GridTriangle = [[0, 0, 0], [5, 5, 0], [10, 10, 0]];
        let none = projected(Line::Parallel, [64, 64, 0], &flat);
        assert!(none.is_none(), "no area");
    }

    #[test]
    fn query_points_reproduce_corners_and_stay_on_the_grid() {
        let t3 = [
            [8_388_607, -8_388_607, 0, 0],
            [-8_388_607, 8_388_607, 5, 0],
            [1, 2, 3, 0],
        ];
        assert_eq!(
            query_point(&t3, [1.0, 0.0, 0.0]),
            [8_388_607 << 6, -(8_388_607 << 6), 0]
        );
        assert_eq!(query_point(&t3, [0.0, 0.0, 1.0]), [64, 128, 192]);
        let opposite = query_point(&t3, [0.0, 1.0, 0.0]);
        assert_eq!(opposite[0], -(8_388_607 << 6), "right across the domain");
        let far = query_point(&t3, [-1e30, 1e30, 1e30]);
        assert!(far.iter().all(|c| c.abs() <= QUERY_MAX + 1_500_000_000));
    }
}
