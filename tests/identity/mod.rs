//! The reference as its own LoD: which pixels show another point than the reference's own, and whether they may.
//!
//! In: a built model. Out: a row of numbers and the faults. A pixel that finds another triangle is excused only where the
//! question has no other answer, each reason checked here in f64 without the lookup's code:
//!
//! * *shared*: the found triangle holds the sample's very T3 point too (overlapping charts, surfaces that touch);
//! * *edge-on*: moved by one step of the query grid, the sample's projection line misses its own triangle, which faces
//!   along its lines (the flat end of a cylinder) or has no image at all.

use super::long;
use super::render::model::{Built, BuiltMesh};
use super::{camera, picture, showing};
use invertex::igt::Reference;
use invertex::mesh::Mesh;
use invertex::param::grid::QUERY_SHIFT;
use invertex::param::projection::Line;
use invertex::render::{Correspond, Output, Rendered, Renderer};

/// Samples closer to an edge than this (barycentric) may go to the neighbour.
const EDGE: f32 = 1e-3;
/// A line meets a triangle when its barycentrics are above this: f64 error on the grid's numbers.
const ROUNDING: f64 = -1e-9;
/// T3 points this many query steps apart are one: a sample is brought to the grid.
const STEPS: f64 = 1.0;

/// What was counted over all pictures of a model.
#[derive(Default)]
struct Counts {
    inside: usize,
    shared: usize,
    edge_on: usize,
    colours: usize,
    lowest_db: f64,
    lowest_db_all: f64,
}

/// Draws level 0 through the tables and compares it with the reference.
pub(crate) fn faults(name: &str, built: &Built) -> Vec<String> {
    let grids: Vec<Option<Grid>> = (0..built.meshes.len()).map(|m| grid(built, m)).collect();
    let placed: Vec<usize> = built.scene.instances().iter().map(|i| i.mesh).collect();
    let renderers = [Correspond::Reference, Correspond::Inverse]
        .map(|correspond| Renderer::cpu(picture(built, 0, correspond)));
    let (mut faults, mut counts) = (
        Vec::new(),
        Counts {
            lowest_db: 999.0,
            lowest_db_all: 999.0,
            ..Counts::default()
        },
    );
    for view in [(30.0, 20.0), (200.0, -35.0)] {
        let camera = camera(built, view, 384);
        for output in [Output::Lit, Output::Unlit] {
            let [reference, zero] =
                [0, 1].map(|k: usize| renderers[k].draw(&camera, &showing(output)).unwrap());
            let grid_of = |draw: u32| grids[placed[draw as usize]].as_ref();
            compare(&reference, &zero, grid_of, &mut counts, &mut faults);
        }
    }
    let excused = counts.shared + counts.edge_on;
    let without = if excused > 0 {
        format!(" ({:.1} with the excused ones)", counts.lowest_db_all)
    } else {
        String::new()
    };
    let numbers = format!(
        "{} samples: {} wrong triangles, {} excused ({} shared T3, {} edge-on), {} colours off, PSNR >= {:.1} dB{without}",
        counts.inside,
        faults.len() - counts.colours,
        excused,
        counts.shared,
        counts.edge_on,
        counts.colours,
        counts.lowest_db
    );
    long::proved(name, "--lod 0 = reference", &numbers);
    if counts.lowest_db <= 60.0 {
        faults.push(format!("PSNR {:.2} dB", counts.lowest_db));
    }
    let total = faults.len();
    faults.truncate(8);
    if total > 8 {
        faults.push(format!("and {} more", total - 8));
    }
    faults
}

fn compare<'a>(
    reference: &Rendered,
    zero: &Rendered,
    grid_of: impl Fn(u32) -> Option<&'a Grid<'a>>,
    counts: &mut Counts,
    faults: &mut Vec<String>,
) {
    let (mut squares, mut excused_squares, mut kept) = (0.0, 0.0, 0);
    for at in 0..reference.triangle.len() {
        let square = square(reference, zero, at);
        let [b1, b2] = reference.barycentric[at];
        let (wanted, found) = (reference.triangle[at], zero.triangle[at]);
        let away = wanted != u32::MAX && b1.min(b2).min(1.0 - b1 - b2) > EDGE;
        counts.inside += usize::from(away);
        let what = || format!("pixel {at}: triangle {wanted} at {b1} {b2}, found {found}");
        let other_colour = !near(reference, zero, at);
        if away && (wanted != found || other_colour) {
            let reason =
                grid_of(reference.draw[at]).and_then(|g| g.excuse(wanted, [b1, b2], found));
            match reason {
                Some(Excuse::Shared) => counts.shared += 1,
                Some(Excuse::EdgeOn) => counts.edge_on += 1,
                None => {
                    counts.colours += usize::from(wanted == found);
                    let of = |r: &Rendered| r.rgba8[4 * at..4 * at + 4].to_vec();
                    faults.push(format!(
                        "{}: {:?} became {:?}",
                        what(),
                        of(reference),
                        of(zero)
                    ));
                }
            }
            if reason.is_some() {
                excused_squares += square;
                continue;
            }
        }
        squares += square;
        kept += 1;
    }
    let db = |squares: f64, pixels: usize| {
        10.0 * (255.0f64.powi(2) * 4.0 * pixels as f64 / squares.max(1e-9)).log10()
    };
    counts.lowest_db = counts.lowest_db.min(db(squares, kept));
    counts.lowest_db_all = counts
        .lowest_db_all
        .min(db(squares + excused_squares, reference.triangle.len()));
}

/// Squared difference of a pixel over its four channels.
fn square(a: &Rendered, b: &Rendered, at: usize) -> f64 {
    (4 * at..4 * at + 4)
        .map(|i| (f64::from(a.rgba8[i]) - f64::from(b.rgba8[i])).powi(2))
        .sum()
}

/// Whether two colours are within one step.
fn near(a: &Rendered, b: &Rendered, at: usize) -> bool {
    (4 * at..4 * at + 4).all(|i| a.rgba8[i].abs_diff(b.rgba8[i]) <= 1)
}

#[derive(Clone, Copy)]
enum Excuse {
    Shared,
    EdgeOn,
}

/// A mesh on the grid of its tables.
struct Grid<'a> {
    line: Line,
    reference: Reference,
    mesh: &'a Mesh,
}

fn grid(built: &Built, m: usize) -> Option<Grid<'_>> {
    let BuiltMesh {
        primary,
        parts,
        tables,
        ..
    } = built.meshes[m].as_ref()?;
    let mesh = &built.scene.meshes[m];
    let reference = Reference::new(mesh, primary, &parts.triangle_layer, tables.layout).unwrap();
    Some(Grid {
        line: primary.line(),
        reference,
        mesh,
    })
}

impl Grid<'_> {
    fn corners(&self, triangle: u32) -> [[f64; 3]; 3] {
        self.reference
            .corners(triangle as usize)
            .map(|v| v.map(|x| f64::from(x << QUERY_SHIFT)))
    }

    /// Why a sample on `wanted` may find another point, on `found`.
    fn excuse(&self, wanted: u32, [b1, b2]: [f32; 2], found: u32) -> Option<Excuse> {
        let corners = self.corners(wanted);
        let b = [
            1.0 - f64::from(b1) - f64::from(b2),
            f64::from(b1),
            f64::from(b2),
        ];
        let q = [0, 1, 2].map(|k| (0..3).map(|i| b[i] * corners[i][k]).sum::<f64>().round());
        let other = (found != wanted && (found as usize) < self.mesh.triangles.len())
            .then(|| meeting(self.line, q, &self.corners(found)))
            .flatten();
        let steps = |p: [f64; 3]| (0..3).map(|k| (p[k] - q[k]).abs()).fold(0.0, f64::max);
        if other.is_some_and(|p| steps(p) <= STEPS) {
            return Some(Excuse::Shared);
        }
        let around = [-1.0, 0.0, 1.0];
        let moves = around
            .iter()
            .flat_map(|x| around.iter().flat_map(move |y| around.map(|z| [*x, *y, z])));
        let misses =
            |m: [f64; 3]| meeting(self.line, [0, 1, 2].map(|k| q[k] + m[k]), &corners).is_none();
        moves.into_iter().any(misses).then_some(Excuse::EdgeOn)
    }
}

/// Where the projection line through `q` meets a triangle: its plane is cut, and the point expressed in its corners.
fn meeting(line: Line, q: [f64; 3], corners: &[[f64; 3]; 3]) -> Option<[f64; 3]> {
    let minus = |a: [f64; 3], b: [f64; 3]| [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    let cross = |a: [f64; 3], b: [f64; 3]| {
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    };
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let (start, d) = match line {
        Line::Parallel => (q, [0.0, 0.0, 1.0]),
        Line::Cylinder => ([0.0, 0.0, q[2]], [q[0], q[1], 0.0]),
        Line::Sphere => ([0.0; 3], q),
    };
    let n = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
    let steep = dot(n, d);
    if steep == 0.0 {
        return None;
    }
    let along = dot(n, minus(corners[0], start)) / steep;
    let p = [0, 1, 2].map(|k| start[k] + along * d[k]);
    let inside = (0..3).all(|i| {
        let (a, b) = (corners[(i + 1) % 3], corners[(i + 2) % 3]);
        dot(cross(minus(a, p), minus(b, p)), n) / dot(n, n) >= ROUNDING
    });
    (inside && (line == Line::Parallel || along > 0.0)).then_some(p)
}

#[test]
fn a_line_meets_what_it_points_at() {
    let ahead = [[8.0, -9.0, -9.0], [8.0, 9.0, -9.0], [8.0, 0.0, 9.0]];
    let behind = ahead.map(|p| [-p[0], p[1], p[2]]);
    for line in [Line::Sphere, Line::Cylinder] {
        assert_eq!(
            meeting(line, [3.0, 0.0, 0.0], &ahead),
            Some([8.0, 0.0, 0.0])
        );
        assert_eq!(meeting(line, [3.0, 0.0, 0.0], &behind), None);
        assert_eq!(meeting(line, [3.0, 9.0, 0.0], &ahead), None);
    }
    let flat = [[0.0, 0.0, 0.0], [9.0, 0.0, 0.0], [0.0, 9.0, 0.0]];
    assert!(meeting(Line::Parallel, [2.0, 2.0, 77.0], &flat).is_some());
    assert!(meeting(Line::Parallel, [7.0, 7.0, 77.0], &flat).is_none());
}
