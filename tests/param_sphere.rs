//! Spheres that are computed: one-to-one for shapes that no point sees whole, seamless LoDs without a floor, and the choice.

mod glb;
mod maps;

use invertex::asset::{self, BuildSettings, LodReport, Processor};
use invertex::mesh::{Mesh, shapes};
use invertex::param::{Map, PrimaryKind, PrimaryRequest, fit, parameterize};
use maps::{bare, computed, corkscrew, dented, moebius, scene};
use std::f64::consts::PI;

/// Corners of a triangle in T3; all triangles that do not lie in one point.
fn corners(open: &Mesh) -> impl Iterator<Item = [[f64; 3]; 3]> {
    let places = open
        .triangles
        .iter()
        .map(|t| t.map(|v| open.embedding.t3[v as usize].map(f64::from)));
    places.filter(|[a, b, c]| a != b && b != c && c != a)
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn determinant([a, b, c]: [[f64; 3]; 3]) -> f64 {
    let cross = [
        b[1] * c[2] - b[2] * c[1],
        b[2] * c[0] - b[0] * c[2],
        b[0] * c[1] - b[1] * c[0],
    ];
    dot(a, cross)
}

/// Triangles that are not seen counter-clockwise from outside.
fn turned(open: &Mesh) -> usize {
    corners(open)
        .filter(|corners| determinant(*corners) <= 0.0)
        .count()
}

/// Solid angle of all triangles (van Oosterom and Strackee, 1983): with none turned, 4 pi means that each direction meets one.
fn solid_angle(open: &Mesh) -> f64 {
    let of = |[a, b, c]: [[f64; 3]; 3]| {
        let [la, lb, lc] = [a, b, c].map(|p| dot(p, p).sqrt());
        let below = la * lb * lc + dot(a, b) * lc + dot(b, c) * la + dot(c, a) * lb;
        2.0 * determinant([a, b, c]).atan2(below)
    };
    corners(open).map(of).sum()
}

#[test]
fn a_sphere_is_computed_where_none_can_be_projected() {
    for mesh in [
        shapes::icosphere(3),
        dented(),
        corkscrew(),
        shapes::grid(8),
        shapes::tube(12, 4),
        shapes::uv_sphere(12, 6),
    ] {
        let (computed, mut open) = computed(&mesh, Map::Sphere);
        assert_eq!(open.positions.len(), mesh.positions.len(), "no cut");
        assert_eq!(
            computed.quality.turned_triangles, [0u32; 0],
            "{}",
            mesh.name
        );
        assert_eq!(turned(&open), 0, "{}", mesh.name);
        // Every direction once: lids close what is open, so that only closed meshes fill the sphere.
        let closed = !["grid", "tube"].contains(&mesh.name.as_str());
        let share = solid_angle(&open) / (4.0 * PI);
        assert!(
            if closed {
                (share - 1.0).abs() < 1e-6
            } else {
                share < 0.99
            },
            "{} {share}",
            mesh.name
        );
        // Negative control: a vertex on the far side turns its triangles over.
        let corner = open.triangles[3][0] as usize;
        open.embedding.t3[corner] = open.embedding.t3[corner].map(|c| -c);
        assert!(turned(&open) > 0, "{}", mesh.name);
    }
    // The sphere's own map is close to itself: its conformal factor is 1 all over.
    let ball = Map::Sphere
        .compute(&shapes::icosphere(4))
        .unwrap()
        .quality
        .stretch;
    assert!(ball.l2 < 1.02 && ball.linf < 1.5, "{ball:?}");
    // Negative control: projected from a point, the corkscrew is turned.
    let fit = fit(&corkscrew(), PrimaryKind::Sphere, None).unwrap();
    assert!(fit.turned_fraction > 0.1, "{}", fit.turned_fraction);
}

#[test]
fn what_is_no_sphere_is_refused_with_the_reason() {
    let torus = {
        let mut mesh = shapes::grid(12);
        for p in &mut mesh.positions {
            let [s, t] = [p[0], p[1]].map(|x| (x.fract()) * std::f32::consts::TAU);
            let radius = 1.0 + 0.3 * t.cos();
            *p = [radius * s.cos(), radius * s.sin(), 0.3 * t.sin()];
        }
        mesh
    };
    let cases = [
        (torus, "1 handles"),
        (moebius(), "the winding turns over"),
        (
            bare(
                "fan",
                vec![
                    [0.0; 3],
                    [0.0, 0.0, 1.0],
                    [1.0, 0.0, 0.0],
                    [-1.0, 0.5, 0.0],
                    [0.0, -1.0, 0.0],
                ],
                vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]],
            ),
            "more than two triangles",
        ),
        (
            bare(
                "bow tie",
                vec![
                    [0.0; 3],
                    [1.0, 0.0, 0.0],
                    [0.0, 1.0, 0.0],
                    [-1.0, 0.0, 0.0],
                    [0.0, -1.0, 0.0],
                ],
                vec![[0, 1, 2], [0, 3, 4]],
            ),
            "two surfaces touch",
        ),
        (Mesh::default(), "none of its triangles"),
    ];
    for (mesh, reason) in cases {
        let error = Map::Sphere.compute(&mesh).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        assert!(error.to_string().contains(reason), "{}: {error}", mesh.name);
    }
}

/// Without seams a chain comes down as far as the shape does.
#[test]
fn lods_of_a_computed_sphere_have_no_floor() {
    let settings = BuildSettings {
        primary: PrimaryRequest::Computed(Map::Sphere, None),
        lods: vec![0.5, 0.1, 0.01],
        ..BuildSettings::default()
    };
    let outcome = asset::build(scene(&corkscrew()), &settings, Processor::Cpu, &()).unwrap();
    let lods = &outcome.reports[0].lods;
    assert!(lods.iter().all(|lod| lod.reached), "{lods:?}");
    // A simplifier does not look at T3, and turns some triangles over there: fewer than one in twenty, while there are hundreds.
    let few = |lod: &LodReport| lod.turned as usize * 20 <= lod.triangles;
    assert!(lods[..2].iter().all(few), "{lods:?}");
    assert!(lods[2].triangles <= 51, "{lods:?}");
}

#[test]
fn auto_computes_where_nothing_else_fits() {
    let bent = Mesh {
        uv_sets: vec![],
        ..corkscrew()
    };
    let chosen = parameterize(&bent, &PrimaryRequest::Auto).unwrap();
    assert_eq!(
        chosen.primary.kind,
        PrimaryKind::Computed(Map::Sphere),
        "{}",
        chosen.why
    );
    assert!(
        chosen.why.contains("seamless, computed")
            && chosen.why.contains("the best of the others is"),
        "{}",
        chosen.why
    );
    // What fits is not computed.
    let ball = parameterize(&dented(), &PrimaryRequest::Auto).unwrap();
    assert!(ball.computed.is_none(), "{}", ball.why);
}

/// Triangles all seen counter-clockwise that fill the sphere once share no place: exactly, on the grid of the tables.
#[test]
fn no_triangle_of_a_closed_sphere_shares_a_place() {
    for mesh in [
        shapes::octahedron(),
        shapes::icosphere(1),
        shapes::icosphere(2),
        shapes::icosphere(3),
        shapes::uv_sphere(12, 6),
        dented(),
        corkscrew(),
    ] {
        let (computed, open) = computed(&mesh, Map::Sphere);
        let found = maps::shared(&computed, &open);
        assert_eq!(found, [0u32; 0], "{}", mesh.name);
        // Negative control: a vertex moved over its neighbours' far side folds the surface.
        let mut folded = open.clone();
        let [a, b, c] = open.triangles[0].map(|v| open.embedding.t3[v as usize]);
        let over: [f32; 3] = std::array::from_fn(|k| 0.75 * b[k] + 0.75 * c[k] - 0.5 * a[k]);
        folded.embedding.t3[open.triangles[0][0] as usize] = over;
        assert!(
            !maps::shared(&computed, &folded).is_empty(),
            "{}",
            mesh.name
        );
    }
}
