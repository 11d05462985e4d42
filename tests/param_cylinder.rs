//! Cylinders that are computed: a tube is its own map, bent tubes are one-to-one where no axis sees them whole, closed ones have
//! poles, LoDs have no floor; what is no tube is refused.

mod glb;
mod maps;

use invertex::asset::{self, BuildSettings, Processor};
use invertex::mesh::{Mesh, shapes};
use invertex::param::{Axis, Map, PrimaryKind, PrimaryRequest, fit, parameterize};
use maps::{bare, computed, corkscrew, dented, moebius, scene, shared};
use std::f32::consts::TAU;

/// A tube of the given width along a spiral of two and a half turns: no axis sees it whole.
fn hose(around: usize, along: usize, width: f32) -> Mesh {
    let place = |i: usize, j: usize| {
        let t = j as f32 / along as f32;
        let turn = 2.5 * TAU * t;
        let centre = [2.0 * turn.cos(), 2.0 * turn.sin(), 4.0 * t];
        let (out, up) = ([turn.cos(), turn.sin(), 0.0], [0.0, 0.0, 1.0]);
        // Bulges, so that nothing about it is regular.
        let radius = width * (1.0 + 0.3 * (9.0 * t).sin());
        let angle = TAU * (i % around) as f32 / around as f32;
        std::array::from_fn(|k| centre[k] + radius * (angle.cos() * out[k] + angle.sin() * up[k]))
    };
    let positions = (0..=along)
        .flat_map(|j| (0..around).map(move |i| place(i, j)))
        .collect();
    let at = |i: usize, j: usize| (j * around + i % around) as u32;
    let triangles = (0..along)
        .flat_map(|j| (0..around).map(move |i| (i, j)))
        .flat_map(|(i, j)| {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            [[a, c, b], [a, d, c]]
        })
        .collect();
    bare("hose", positions, triangles)
}

#[test]
fn a_tube_is_its_own_map() {
    let mesh = shapes::tube(48, 12);
    let (map, open) = computed(&mesh, Map::Cylinder);
    let stretch = map.quality.stretch;
    // Chords of 48 sides, and a rim that is free: a few parts in a thousand.
    assert!(stretch.l2 < 1.005 && stretch.linf < 1.06, "{stretch:?}");
    assert_eq!((map.quality.seam_length, map.quality.charts), (0.0, 1));
    // As long for its width as the tube: radius 1, height 2.
    let radius = |p: &[f32; 3]| p[0].hypot(p[1]);
    let widest = open.embedding.t3.iter().map(radius).fold(0.0, f32::max);
    let heights = open.embedding.t3.iter().map(|p| p[2]);
    let height = heights.clone().fold(f32::MIN, f32::max) - heights.fold(f32::MAX, f32::min);
    assert!((height / widest - 2.0).abs() < 0.05, "{height} {widest}");
    // The angle of a place is that of the vertex, but for where it begins and which end is the first.
    let angle = |p: &[f32; 3]| p[1].atan2(p[0]);
    let apart = |a: f32, b: f32| (a - b).rem_euclid(TAU).min((b - a).rem_euclid(TAU));
    let spread = |sense: f32| {
        let places = mesh.positions.iter().zip(&open.embedding.t3);
        let shifts: Vec<f32> = places.map(|(p, q)| angle(q) - sense * angle(p)).collect();
        shifts
            .iter()
            .map(|s| apart(*s, shifts[0]))
            .fold(0.0, f32::max)
    };
    // The diagonals of its squares twist the free rims a little; a side is 0.13 wide.
    let (same, turned) = (spread(1.0), spread(-1.0));
    assert!(
        same.min(turned) < 0.04 && same.max(turned) > 1.0,
        "{same} {turned}"
    );
}

#[test]
fn a_cylinder_is_computed_where_none_can_be_projected() {
    for (mesh, most) in [
        (hose(16, 120, 0.4), 1.1),
        (hose(7, 60, 0.2), 1.25),
        (shapes::tube(12, 4), 1.05),
        (shapes::uv_sphere(24, 12), 1.3),
        (dented(), 2.0),
        (corkscrew(), 2.5),
    ] {
        let (map, open) = computed(&mesh, Map::Cylinder);
        assert_eq!(map.quality.turned_triangles, [0u32; 0], "{}", mesh.name);
        assert_eq!(open.positions.len(), mesh.positions.len(), "no cut");
        let l2 = map.quality.stretch.l2;
        assert!(l2 < most, "{} {:?}", mesh.name, map.quality.stretch);
        // Exactly, on the tables' grid: no place is shared.
        assert_eq!(shared(&map, &open), [0u32; 0], "{}", mesh.name);
        println!("{} {:?}", mesh.name, map.quality.stretch);
        let seen = fit(&open, PrimaryKind::Computed(Map::Cylinder), Some([0.0; 3])).unwrap();
        assert!(seen.bijective && seen.turned_fraction == 0.0, "{seen:?}");
        // Negative control: half a turn about the axis folds a vertex over.
        let mut folded = open.clone();
        let v = folded.triangles[folded.triangles.len() / 2][0] as usize;
        let [x, y, z] = folded.embedding.t3[v];
        folded.embedding.t3[v] = [-x, -y, z];
        assert!(!shared(&map, &folded).is_empty(), "{}", mesh.name);
    }
    // Negative control: no axis sees the hose whole.
    for axis in Axis::ALL {
        let fit = fit(&hose(16, 120, 0.4), PrimaryKind::Cylinder(axis), None).unwrap();
        assert!(
            fit.turned_fraction > 0.1,
            "{axis:?} {}",
            fit.turned_fraction
        );
    }
}

#[test]
fn parts_have_a_cylinder_each() {
    let mut two = hose(9, 40, 0.3);
    let other = shapes::tube(12, 4);
    let first = two.positions.len() as u32;
    two.positions.extend(&other.positions);
    two.normals.extend(&other.normals);
    two.triangles
        .extend(other.triangles.iter().map(|t| t.map(|v| v + first)));
    two.triangle_material = vec![0; two.triangles.len()];
    let (map, open) = computed(&two, Map::Cylinder);
    assert_eq!(
        (map.quality.charts, map.quality.turned_triangles.len()),
        (2, 0)
    );
    let parts = invertex::param::parts(&open, &map.primary());
    let layers: std::collections::BTreeSet<u8> = parts.triangle_layer.iter().copied().collect();
    assert_eq!(layers.len(), 2, "they lie over each other");
}

#[test]
fn lods_of_a_computed_cylinder_have_no_floor() {
    let settings = BuildSettings {
        primary: PrimaryRequest::Computed(Map::Cylinder, None),
        lods: vec![0.5, 0.1, 0.03],
        ..BuildSettings::default()
    };
    let mesh = hose(16, 120, 0.4);
    let outcome = asset::build(scene(&mesh), &settings, Processor::Cpu, &()).unwrap();
    let lods = &outcome.reports[0].lods;
    assert!(lods.iter().all(|lod| lod.reached), "{lods:?}");
    assert!(
        lods[..2]
            .iter()
            .all(|lod| lod.turned as usize * 20 <= lod.triangles),
        "{lods:?}"
    );
    assert_eq!(outcome.reports[0].ambiguous_triangles, 0);
}

/// A sphere squeezes the hose, a cylinder does not: `auto` weighs both.
#[test]
fn auto_takes_a_cylinder_for_a_hose() {
    let chosen = parameterize(&hose(16, 200, 0.2), &PrimaryRequest::Auto).unwrap();
    assert_eq!(
        chosen.primary.kind,
        PrimaryKind::Computed(Map::Cylinder),
        "{}",
        chosen.why
    );
    let cost = |kind: &str| chosen.weighed.iter().find(|w| w.kind == kind).unwrap().cost;
    let sphere = cost("sphere:map");
    assert!(
        sphere.is_none_or(|sphere| sphere > cost("cylinder:map").unwrap()),
        "{}",
        chosen.why
    );
}

#[test]
fn what_is_no_tube_is_refused_with_the_reason() {
    let torus = {
        let mut mesh = shapes::grid(12);
        for p in &mut mesh.positions {
            let [s, t] = [p[0], p[1]].map(|x| x.fract() * TAU);
            let radius = 1.0 + 0.3 * t.cos();
            *p = [radius * s.cos(), radius * s.sin(), 0.3 * t.sin()];
        }
        mesh
    };
    for (mesh, reason) in [
        (torus, "1 handles"),
        (moebius(), "the winding turns over"),
        (shapes::tetrahedron(), "too few triangles"),
        (Mesh::default(), "none of its triangles"),
    ] {
        let error = Map::Cylinder.compute(&mesh).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        let said = error.to_string();
        assert!(
            said.contains(reason) && said.contains("cylinder:map"),
            "{}: {said}",
            mesh.name
        );
    }
}
