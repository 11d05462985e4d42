//! How well primaries fit: exact shares on meshes made for it, and the choice that follows.

use invertex::mesh::{Mesh, shapes};
use invertex::param::{Axis, Fit, PrimaryKind, PrimaryRequest, choose, fit, fits};

/// Both meshes as one, the second moved by `offset` and, where asked, wound the other way round.
fn join(a: &Mesh, b: &Mesh, offset: [f32; 3], reverse: bool) -> Mesh {
    let mut out = a.clone();
    let first = a.positions.len() as u32;
    out.positions.extend(
        b.positions
            .iter()
            .map(|p| [0, 1, 2].map(|k| p[k] + offset[k])),
    );
    out.normals.extend(&b.normals);
    out.uv_sets[0].extend(&b.uv_sets[0]);
    let wind = |t: &[u32; 3]| if reverse { [t[0], t[2], t[1]] } else { *t }.map(|v| v + first);
    out.triangles.extend(b.triangles.iter().map(wind));
    out.triangle_material.extend(&b.triangle_material);
    out
}

fn scaled(mesh: &Mesh, factor: f32) -> Mesh {
    let mut out = mesh.clone();
    out.positions
        .iter_mut()
        .flatten()
        .for_each(|x| *x *= factor);
    out.uv_sets[0]
        .iter_mut()
        .flatten()
        .for_each(|x| *x *= factor);
    out
}

fn of(mesh: &Mesh, kind: PrimaryKind) -> Fit {
    fit(mesh, kind, None).unwrap_or_else(|| panic!("{kind} cannot be had"))
}

/// A sphere with a long horn: star-shaped about `at`, but not about its centroid.
fn horned(at: [f32; 3]) -> Mesh {
    let mut mesh = shapes::icosphere(4);
    for p in &mut mesh.positions {
        let horn = (p[0] - 0.6).max(0.0) * 60.0;
        *p = [0, 1, 2].map(|k| at[k] + p[k] * (1.0 + horn));
    }
    mesh
}

#[test]
fn the_centre_of_a_star_shape_is_found() {
    let at = [10.0f32, -3.0, 2.0];
    let mesh = horned(at);
    let found = of(&mesh, PrimaryKind::Sphere);
    assert!(
        found.bijective,
        "turned {} about {:?}",
        found.turned_fraction, found.centre
    );
    let mean = |k: usize| {
        mesh.positions.iter().map(|p| f64::from(p[k])).sum::<f64>() / mesh.positions.len() as f64
    };
    let tip = [at[0] as f64 + 15.0, mean(1), mean(2)];
    let from_tip = fit(&mesh, PrimaryKind::Sphere, Some(tip)).unwrap();
    assert!(
        from_tip.turned_fraction > 0.0,
        "from a bad centre something must be turned"
    );
    assert!(!from_tip.worst_triangles.is_empty());
    let (primary, why) = choose(&mesh, &PrimaryRequest::Sphere(None)).unwrap();
    assert!(why.contains("one-to-one"), "{why}");
    assert_eq!(primary.frame.origin, found.centre);
}

#[test]
fn turned_and_covered_shares_are_exact() {
    // A unit square, and under it one of a quarter of its area, upside down: 0.25 of 1.25 is turned.
    let mesh = join(
        &shapes::grid(4),
        &scaled(&shapes::grid(4), 0.5),
        [0.0, 0.0, -1.0],
        true,
    );
    let plane = of(&mesh, PrimaryKind::Plane(Axis::Z));
    assert!(
        (plane.turned_fraction - 0.2).abs() < 1e-12,
        "{}",
        plane.turned_fraction
    );
    assert!(
        (plane.overlap_fraction - 0.25).abs() < 5e-3,
        "{}",
        plane.overlap_fraction
    );
    assert_eq!(
        (plane.overlap_within_parts, plane.charts, plane.bijective),
        (0.0, 2, false)
    );
    assert!((plane.facing - 0.8).abs() < 1e-12);
    let uv = of(&mesh, PrimaryKind::UvSet(0));
    assert!(
        (uv.mirrored_fraction - 0.2).abs() < 1e-9,
        "{}",
        uv.mirrored_fraction
    );
    assert!((uv.overlap_fraction - 0.25).abs() < 5e-3);
    assert_eq!(
        (uv.turned_fraction, uv.charts),
        (0.0, 2),
        "a mirrored chart is not turned against itself"
    );
}

#[test]
fn shapes_get_the_primary_they_were_made_from() {
    let expected = [
        (shapes::grid(6), PrimaryKind::Plane(Axis::Z)),
        (shapes::tube(48, 6), PrimaryKind::Cylinder(Axis::Z)),
        (shapes::icosphere(3), PrimaryKind::Sphere),
        (shapes::uv_sphere(24, 12), PrimaryKind::Sphere),
    ];
    for (mesh, kind) in expected {
        let (primary, why) = choose(&mesh, &PrimaryRequest::Auto).unwrap();
        assert_eq!(primary.kind, kind, "{}: {why}", mesh.name);
        assert!(why.contains("one-to-one"), "{why}");
        let found = of(&mesh, kind);
        assert!(
            found.bijective && found.worst_triangles.is_empty(),
            "{found:?}"
        );
        assert!(found.facing > 0.95, "{}: {}", mesh.name, found.facing);
    }
}

#[test]
fn inside_out_is_as_good() {
    for (mut mesh, kind) in [
        (shapes::icosphere(3), PrimaryKind::Sphere),
        (shapes::tube(24, 3), PrimaryKind::Cylinder(Axis::Z)),
    ] {
        let outside = of(&mesh, kind);
        mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        let inside = of(&mesh, kind);
        assert!(inside.bijective && outside.bijective);
        assert!((inside.facing - outside.facing).abs() < 1e-9);
    }
}

#[test]
fn an_axis_off_the_origin_is_found() {
    let mut mesh = shapes::tube(48, 6);
    mesh.positions
        .iter_mut()
        .for_each(|p| *p = [p[2] + 7.0, p[0] * 0.5 - 4.0, p[1] * 2.0 + 1.0]);
    let found = of(&mesh, PrimaryKind::Cylinder(Axis::X));
    assert!(found.bijective, "{found:?}");
    // Third comes the axis: T3 is (y, z, x).
    assert!(
        (found.centre[0] + 4.0).abs() < 0.3 && (found.centre[1] - 1.0).abs() < 1.0,
        "{:?}",
        found.centre
    );
    let (primary, _) = choose(&mesh, &PrimaryRequest::Cylinder(None)).unwrap();
    assert_eq!(primary.kind, PrimaryKind::Cylinder(Axis::X));
}

#[test]
fn nested_shells_are_not_one_to_one() {
    let shells = join(
        &shapes::icosphere(2),
        &scaled(&shapes::icosphere(2), 2.0),
        [0.0; 3],
        false,
    );
    let sphere = of(&shells, PrimaryKind::Sphere);
    assert_eq!((sphere.turned_fraction, sphere.bijective), (0.0, false));
    // All but texel centres on an edge of one of the shells.
    assert!(
        sphere.overlap_fraction > 0.99,
        "{}",
        sphere.overlap_fraction
    );
    assert_eq!((sphere.overlap_within_parts, sphere.charts), (0.0, 2));
}

#[test]
fn what_cannot_be_had_is_refused_with_advice() {
    let mut mesh = shapes::icosphere(1);
    mesh.uv_sets = vec![vec![[0.5, 0.5]; mesh.positions.len()]];
    assert!(
        fits(&mesh).iter().all(Fit::is_seamless),
        "a uv set in one point is no parameterization"
    );
    for request in [PrimaryRequest::UvSet(0), PrimaryRequest::UvSet(1)] {
        let message = choose(&mesh, &request).unwrap_err().to_string();
        assert!(message.contains("--primary sphere"), "{message}");
    }
    assert!(
        choose(
            &shapes::grid(2),
            &PrimaryRequest::Sphere(Some([0.5, 0.5, 0.0]))
        )
        .is_err()
    );
    let empty = Mesh {
        name: "nothing".into(),
        ..Mesh::default()
    };
    assert!(
        choose(&empty, &PrimaryRequest::Auto)
            .unwrap_err()
            .to_string()
            .contains("no triangles")
    );
    assert!(fits(&empty).is_empty());
    let mut flat = shapes::grid(2);
    flat.positions
        .iter_mut()
        .for_each(|p| *p = [p[0], 0.0, 0.0]);
    assert!(choose(&flat, &PrimaryRequest::Auto).is_err(), "no area");
}

#[test]
fn what_was_asked_for_is_given_with_a_warning() {
    let (primary, why) =
        choose(&shapes::icosphere(3), &PrimaryRequest::Plane(Some(Axis::Y))).unwrap();
    assert_eq!(primary.kind, PrimaryKind::Plane(Axis::Y));
    assert!(why.contains("as asked") && why.contains("turned"), "{why}");
}

#[test]
fn a_folded_layout_is_ambiguous_and_a_mirrored_pair_is_not() {
    // A 1 x 2 strip whose far half lies on the near half in uv, connected along the fold.
    let mut folded = shapes::grid(8);
    for (p, uv) in folded.positions.iter_mut().zip(&mut folded.uv_sets[0]) {
        p[2] = p[0] * p[0];
        uv[0] = 0.5 - (uv[0] - 0.5).abs();
    }
    let uv = of(&folded, PrimaryKind::UvSet(0));
    assert!(
        uv.overlap_within_parts > 0.95 && (uv.turned_fraction - 0.5).abs() < 0.2,
        "{uv:?}"
    );
    let mut pair = join(&shapes::grid(4), &shapes::grid(4), [3.0, 0.0, 0.5], false);
    let n = pair.uv_sets[0].len();
    for (v, uv) in pair.uv_sets[0].iter_mut().enumerate() {
        uv[0] = if v < n / 2 {
            0.5 * uv[0]
        } else {
            1.0 - 0.5 * uv[0]
        };
    }
    let uv = of(&pair, PrimaryKind::UvSet(0));
    assert!(
        uv.bijective && (uv.mirrored_fraction - 0.5).abs() < 1e-6,
        "{uv:?}"
    );
}

#[test]
fn the_same_mesh_gets_the_same_numbers() {
    let mesh = horned([1.0, 2.0, 3.0]);
    assert_eq!(fits(&mesh), fits(&mesh));
}
