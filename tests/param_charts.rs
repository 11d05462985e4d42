//! Charts that are computed: known answers, one-to-one on the grid that tables use, bad meshes, the same on every run, and
//! the way through a file and back.

mod glb;
mod maps;

use glb::container;
use invertex::asset::{self, BuildSettings, Processor};
use invertex::mesh::{Mesh, shapes};
use invertex::param::{Map, PrimaryRequest};
use invertex::scene::Scene;
use maps::{bare, computed, dented, moebius, scene, shared};

#[test]
fn a_developable_cylinder_unrolls_without_stretch() {
    for map in Map::ALL.into_iter().filter(|map| map.takes_stretch()) {
        let (computed, open) = computed(&shapes::tube(24, 5), map);
        let quality = &computed.quality;
        assert_eq!(quality.charts, 1, "{map}");
        assert!(
            (quality.stretch.l2 - 1.0).abs() < 1e-6,
            "{map}: {:?}",
            quality.stretch
        );
        assert!(
            (quality.stretch.linf - 1.0).abs() < 1e-5 && quality.stretch.angle < 1e-9,
            "{map}"
        );
        assert_eq!(shared(&computed, &open), [0u32; 0], "{map}");
        // Cut along one side, whose length is the height: 2, over the root of the area.
        let wanted = 2.0 / (2.0 * 24.0 * 2.0 * (std::f64::consts::PI / 24.0).sin()).sqrt();
        assert!(
            (quality.seam_length - wanted).abs() < 1e-5,
            "{} {wanted}",
            quality.seam_length
        );
    }
    // Negative control: a ball cannot.
    let (ball, _) = computed(&shapes::icosphere(3), Map::Lscm);
    assert!(ball.quality.stretch.l2 > 1.001);
}

#[test]
fn every_map_is_one_to_one_on_the_grid() {
    for map in Map::ALL.into_iter().filter(|map| map.has_charts()) {
        for mesh in shapes::all().into_iter().chain([dented()]) {
            let (computed, mut open) = computed(&mesh, map);
            assert_eq!(
                computed.quality.turned_triangles, [0u32; 0],
                "{map} {}",
                mesh.name
            );
            assert_eq!(shared(&computed, &open), [0u32; 0], "{map} {}", mesh.name);
            // Negative control: a vertex moved over its neighbours is found.
            let corner = open.triangles[0][0] as usize;
            let [u, v, _] = open.embedding.t3[corner];
            open.embedding.t3[corner] = [1.0 - u, 1.0 - v, 0.0];
            assert!(!shared(&computed, &open).is_empty(), "{map} {}", mesh.name);
        }
    }
}

#[test]
fn the_same_mesh_gives_the_same_charts() {
    for map in Map::ALL {
        let mesh = dented();
        let first = map.compute(&mesh).unwrap();
        assert!(map.compute(&mesh).unwrap() == first, "{map}");
    }
}

/// A plane's geometry image is the plane.
#[test]
fn a_geometry_image_of_a_plane_is_the_identity() {
    let (computed, open) = computed(&shapes::grid(9), Map::GeometryImage);
    assert!(
        (computed.quality.stretch.linf - 1.0).abs() < 1e-4,
        "{:?}",
        computed.quality.stretch
    );
    assert_eq!(
        (computed.quality.charts, shared(&computed, &open)),
        (1, vec![])
    );
    let places: Vec<[f32; 3]> = open.embedding.t3.clone();
    let far = |a: [f32; 3], b: [f32; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f32>().sqrt();
    let scale = far(places[0], places[9]) / far(open.positions[0], open.positions[9]);
    for v in 0..open.positions.len() {
        let wanted = scale * far(open.positions[0], open.positions[v]);
        assert!(
            (far(places[0], places[v]) - wanted).abs() < 1e-5,
            "vertex {v}"
        );
    }
}

#[test]
fn a_bound_of_the_stretch_is_kept_and_costs_charts() {
    let of = |stretch: f64| {
        Map::Lscm
            .compute_within(&dented(), Some(stretch))
            .unwrap()
            .quality
    };
    let (tight, loose) = (of(1.01), of(1.2));
    assert!(
        tight.stretch.l2 <= 1.01 && loose.stretch.l2 <= 1.2,
        "{tight:?} {loose:?}"
    );
    assert!(
        tight.charts > loose.charts,
        "{} {}",
        tight.charts,
        loose.charts
    );
    let request = |text: &str| text.parse::<PrimaryRequest>();
    assert_eq!(
        request("abf:1.05").unwrap(),
        PrimaryRequest::Computed(Map::Abf, Some(1.05))
    );
    for bad in [
        "lscm:0.5",
        "lscm:many",
        "geometry-image:1.1",
        "isochart:NaN",
    ] {
        assert_eq!(request(bad).unwrap_err().exit_code(), 2, "{bad}");
    }
}

#[test]
fn charts_are_few_and_within_the_bound() {
    let (computed, _) = computed(&dented(), Map::Lscm);
    assert!(computed.quality.charts <= 16, "{}", computed.quality.charts);
    assert!(computed.quality.stretch.l2 < 1.1);
    assert!(computed.quality.filled_fraction > 0.3);
}

#[test]
fn bad_meshes_have_charts_or_a_reason() {
    // Three sheets at one edge, one of them wound the other way round.
    let fan = bare(
        "three at an edge",
        vec![
            [0.0; 3],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
            [-1.0, 0.5, 0.0],
            [0.0, -1.0, 0.0],
        ],
        vec![[0, 1, 2], [1, 0, 3], [0, 1, 4]],
    );
    let (of_fan, open) = computed(&fan, Map::Lscm);
    assert_eq!(shared(&of_fan, &open), [0u32; 0]);
    // A strip with half a turn: no way round is its outside.
    let strip = moebius();
    let (of_strip, open) = computed(&strip, Map::Lscm);
    assert_eq!(shared(&of_strip, &open), [0u32; 0]);
    // Triangles without area beside one that has some: they lie in one point.
    let mixed = bare(
        "slivers",
        vec![[0.0; 3], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [0.0, 1.0, 0.0]],
        vec![[0, 1, 2], [0, 1, 3], [1, 1, 1], [2, 0, 1]],
    );
    let (of_mixed, open) = computed(&mixed, Map::Lscm);
    assert_eq!(of_mixed.quality.charts, 1);
    for t in [0, 2, 3] {
        let [a, b, c] = open.triangles[t].map(|v| open.embedding.t3[v as usize]);
        assert!(a == b && b == c, "triangle {t}");
    }
    // Nothing with area, nothing at all.
    for mesh in [
        bare("points", vec![[1.0; 3]; 3], vec![[0, 1, 2]]),
        Mesh::default(),
    ] {
        let error = Map::Lscm.compute(&mesh).unwrap_err();
        assert_eq!(error.exit_code(), 3);
        assert!(
            error.to_string().contains("none of its triangles has area"),
            "{error}"
        );
    }
}

/// Time grows hardly faster than the mesh: nothing is quadratic.
#[test]
fn four_times_the_triangles_take_not_much_more_than_four_times_as_long() {
    let time = |subdivisions: u32| {
        let mesh = shapes::icosphere(subdivisions);
        let start = std::time::Instant::now();
        Map::Lscm.compute(&mesh).unwrap();
        start.elapsed().as_secs_f64()
    };
    let (small, large) = (time(4).min(time(4)), time(5));
    assert!(large < 16.0 * small, "{small} s, then {large} s");
}

#[test]
fn a_computed_map_goes_through_a_file_and_back() {
    let original = scene(&dented());
    for map in Map::ALL {
        let settings = BuildSettings {
            primary: PrimaryRequest::Computed(map, None),
            lods: vec![0.3, 0.05],
            ..BuildSettings::default()
        };
        let outcome = asset::build(original.clone(), &settings, Processor::Cpu, &()).unwrap();
        let report = &outcome.reports[0];
        assert_eq!(report.primary, map.name());
        assert!(
            report.ambiguous_triangles == 0 || !map.has_charts(),
            "{map}"
        );
        assert!(
            report.lods.iter().all(|lod| lod.reached),
            "{map}: {:?}",
            report.lods
        );
        let bytes = asset::to_bytes(&outcome.built).unwrap();
        let back = asset::read("ball", &bytes).unwrap();
        assert!(back == outcome.built, "{map}");
        assert!(asset::to_bytes(&back).unwrap() == bytes, "{map}");
        assert_eq!(
            back.scene.document, original.document,
            "the original is untouched"
        );
        // Other viewers see the mesh as it was, not cut open.
        let plain = Scene::from_bytes("plain", &bytes, None).unwrap();
        assert_eq!(plain.meshes[0], original.meshes[0]);
    }
}

#[test]
fn places_that_do_not_fit_are_refused() {
    let settings = BuildSettings {
        primary: PrimaryRequest::Computed(Map::Lscm, None),
        ..BuildSettings::default()
    };
    let built = asset::build(scene(&shapes::icosphere(2)), &settings, Processor::Cpu, &())
        .unwrap()
        .built;
    let bytes = asset::to_bytes(&built).unwrap();
    let length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    let read = |spoil: &dyn Fn(&mut serde_json::Value)| {
        let mut document: serde_json::Value =
            serde_json::from_slice(&bytes[20..20 + length]).unwrap();
        spoil(&mut document["meshes"][0]["extensions"][asset::EXTENSION]);
        let binary = &bytes[28 + length..];
        asset::read("ball", &container(&document.to_string(), binary)).map_err(|e| e.to_string())
    };
    assert!(read(&|_| ()) == Ok(built), "negative control");
    let cases: [(&dyn Fn(&mut serde_json::Value), &str); 6] = [
        (
            &|x| drop(x.as_object_mut().unwrap().remove("embedding")),
            "comes with a computed primary",
        ),
        (
            &|x| x["primary"]["kind"] = "sphere".into(),
            "comes with a computed primary",
        ),
        (&|x| x["embedding"]["width"] = 3.into(), "places"),
        (&|x| x["embedding"]["width"] = 0.into(), "places"),
        (
            &|x| x["embedding"]["copies"] = x["hash"].clone(),
            "places for",
        ),
        (
            &|x| x["embedding"]["places"] = 1_000_000.into(),
            "bufferViews",
        ),
    ];
    for (spoil, word) in cases {
        let message = read(spoil).unwrap_err();
        assert!(message.contains(word), "\"{word}\" is not in: {message}");
    }
}
