//! Detail recovery between two models: known answers for planes, balls and mirrored charts.

mod pair;

use invertex::Result;
use invertex::mesh::{Mesh, shapes};
use invertex::recover::{
    BakeAttribute, Baked, Mapping, Misses, Pair, PairSettings, Recovery, UvLayout,
};
use invertex::render::Renderer;
use invertex::scene::Scene;
use pair::{Quiet, placed, plane, scene};

fn bake(high: &Scene, low: &Scene, settings: &PairSettings) -> Result<Baked> {
    let draw = |picture| Ok(Renderer::cpu(picture));
    Pair::new(high, low, settings, &draw, &Quiet)?.bake(0, &Quiet)
}

fn settings(mapping: Mapping, attribute: BakeAttribute) -> PairSettings {
    let mut settings = PairSettings {
        mapping,
        attributes: vec![attribute],
        size: 64,
        padding: 2,
        ..PairSettings::default()
    };
    settings.recovery.probes.size = 128;
    settings
}

/// Texels whose mask has this shade, and their values.
fn texels(baked: &Baked, shade: u8) -> Vec<(usize, [f32; 4])> {
    let all = baked.mask.iter().zip(&baked.textures[0].values).enumerate();
    all.filter(|(_, (m, _))| **m == shade)
        .map(|(k, (_, v))| (k, *v))
        .collect()
}

#[test]
fn every_mapping_of_a_plane_over_a_plane_is_the_foot_point() {
    let (high, low) = (plane(7, 0.05, 0.0), plane(2, 0.0, 0.0));
    let (high, low) = (scene("high", &high), scene("low", &low));
    for mapping in Mapping::OF_TWO_SURFACES {
        let baked = bake(&high, &low, &settings(mapping, BakeAttribute::Position)).unwrap();
        // What leans to a side by the probes' spread leaves the plane at its rim: those texels stand in.
        let found = texels(&baked, 255);
        assert!(found.len() > 64 * 60, "{mapping}: {}", found.len());
        assert_eq!(baked.filled, 64 * 64);
        let leaning = if matches!(
            mapping,
            Mapping::Proximity | Mapping::Normal | Mapping::Cage
        ) {
            1e-5
        } else {
            0.006
        };
        for (k, [x, y, z, _]) in found {
            let [u, v] = [k % 64, k / 64].map(|c| (c as f32 + 0.5) / 64.0);
            assert!(
                (x - u).abs() < leaning && (y - v).abs() < leaning,
                "{mapping}: {x} {u}"
            );
            assert!((z - 0.05).abs() < 1e-6);
        }
    }
}

#[test]
fn balls_within_balls_are_met_along_their_radii() {
    let mut outer = shapes::icosphere(4);
    outer.positions.iter_mut().flatten().for_each(|c| *c *= 1.1);
    let (high, low) = (scene("high", &outer), scene("low", &shapes::icosphere(2)));
    for mapping in Mapping::OF_TWO_SURFACES {
        for layout in [UvLayout::Charts, UvLayout::Triangles] {
            let mut settings = settings(mapping, BakeAttribute::Position);
            (settings.layout, settings.size) = (layout, 192);
            let baked = bake(&high, &low, &settings).unwrap();
            assert_eq!(baked.missed, 0, "{mapping}");
            for (_, [x, y, z, _]) in texels(&baked, 255) {
                let radius = (x * x + y * y + z * z).sqrt();
                assert!((1.09..1.1001).contains(&radius), "{mapping}: {radius}");
            }
        }
    }
}

/// A tangent-space normal turned back by the frame of the surface that it was baked for is the reference's normal,
/// whichever way its charts are turned or mirrored.
#[test]
fn normals_come_back_from_mirrored_charts() {
    // A tilted plane: its normal is the same everywhere and not the low plane's.
    let mut high = plane(3, 0.0, 0.0);
    for p in &mut high.positions {
        p[2] = 0.1 * p[0] + 0.2 * p[1] - 0.15;
    }
    high.normals = vec![[0.0; 3]; high.positions.len()];
    let length = (0.1f32 * 0.1 + 0.2 * 0.2 + 1.0).sqrt();
    high.normals
        .fill([-0.1 / length, -0.2 / length, 1.0 / length]);
    let high = scene("high", &high);
    let turns: [fn([f32; 2]) -> [f32; 2]; 4] = [
        |uv| uv,
        |[u, v]| [1.0 - u, v],
        |[u, v]| [v, u],
        |[u, v]| [1.0 - v, u],
    ];
    let mut sides = Vec::new();
    for turn in turns {
        let mut low = plane(2, 0.0, 0.1);
        low.uv_sets[0].iter_mut().for_each(|uv| *uv = turn(*uv));
        let low = scene("low", &low);
        let asked = settings(Mapping::Normal, BakeAttribute::Normal);
        let baked = bake(&high, &low, &asked).unwrap();
        let mesh = baked.low.as_ref().unwrap();
        let (t, n) = (mesh.tangents[0], mesh.normals[0]);
        let cross = |a: [f32; 3], b: [f32; 3]| {
            [
                a[1] * b[2] - a[2] * b[1],
                a[2] * b[0] - a[0] * b[2],
                a[0] * b[1] - a[1] * b[0],
            ]
        };
        let along = [t[0], t[1], t[2]];
        let across = cross(n, along).map(|c| c * t[3]);
        sides.push(t[3]);
        let found = texels(&baked, 255);
        assert!(found.len() > 1000);
        for (_, [x, y, z, _]) in found {
            let back: Vec<f32> = (0..3)
                .map(|k| along[k] * x + across[k] * y + n[k] * z)
                .collect();
            for (a, b) in back
                .iter()
                .zip([-0.1 / length, -0.2 / length, 1.0 / length])
            {
                assert!((a - b).abs() < 1e-4, "{back:?}");
            }
        }
    }
    assert!(sides.contains(&1.0) && sides.contains(&-1.0), "{sides:?}");
}

#[test]
fn models_are_met_where_they_stand() {
    // Both moved and turned alike: the same texels as without. One mirrored: fronts are still found.
    let place = |sx: f32| {
        [
            [0.0, sx * 2.0, 0.0, 0.0],
            [-2.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 2.0, 0.0],
            [5.0, -3.0, 7.0, 1.0],
        ]
    };
    let (high, low) = (plane(5, 0.05, 0.0), plane(2, 0.0, 0.0));
    for sx in [1.0, -1.0] {
        let (high, low) = (
            placed("high", &high, place(sx)),
            placed("low", &low, place(sx)),
        );
        let baked = bake(
            &high,
            &low,
            &settings(Mapping::Normal, BakeAttribute::Normal),
        )
        .unwrap();
        assert_eq!((baked.missed, baked.filled), (0, 64 * 64));
        for (_, [x, y, z, _]) in texels(&baked, 255) {
            assert!(x.abs() < 1e-5 && y.abs() < 1e-5 && z > 0.999);
        }
    }
}

/// The high plane covers half of the low one: what becomes of the rest.
#[test]
fn misses_are_blank_replaced_or_filled_and_always_told() {
    let mut high = plane(4, 0.02, 0.0);
    high.positions.iter_mut().for_each(|p| p[0] *= 0.5);
    let (high, low) = (scene("high", &high), scene("low", &plane(2, 0.0, 0.0)));
    let with = |misses: Misses| {
        let mut settings = settings(Mapping::Normal, BakeAttribute::Position);
        settings.recovery = Recovery {
            misses,
            ..settings.recovery
        };
        bake(&high, &low, &settings).unwrap()
    };
    let half = 32 * 64;
    let blank = with(Misses::Blank);
    assert_eq!(
        (blank.filled, blank.missed, blank.empty),
        (half, half, half)
    );
    let clear = blank.textures[0].values.iter().filter(|v| v[3] == 0.0);
    assert_eq!(clear.count() as u64, half);
    let near = with(Misses::Proximity);
    assert_eq!((near.filled, near.missed, near.empty), (2 * half, half, 0));
    for (_, [x, ..]) in texels(&near, 192) {
        assert!((x - 0.5).abs() < 1e-6, "the rim is closest");
    }
    let fill = with(Misses::Fill);
    assert_eq!((fill.filled, fill.missed, fill.empty), (half, half, half));
    assert_eq!(texels(&fill, 128).len(), 2 * 64, "two texels of padding");
    assert!(fill.textures[0].values.iter().all(|v| v[3] == 1.0));
}

/// A wall of two faces: with regard to sides the near one is met from the outside only.
#[test]
fn triangles_that_look_away_are_passed_by() {
    let mut high = plane(1, 0.05, 0.0);
    // Its front looks down, away from the low plane's.
    high.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    high.normals.iter_mut().for_each(|n| *n = [0.0, 0.0, -1.0]);
    let (high, low) = (scene("high", &high), scene("low", &plane(1, 0.0, 0.0)));
    for mapping in [Mapping::Normal, Mapping::Proximity, Mapping::Cage] {
        let mut settings = settings(mapping, BakeAttribute::Position);
        settings.recovery.misses = Misses::Blank;
        let refused = bake(&high, &low, &settings).unwrap_err().to_string();
        assert!(refused.contains("no texel has a point"), "{refused}");
        settings.recovery.facing = false;
        assert_eq!(bake(&high, &low, &settings).unwrap().missed, 0, "{mapping}");
    }
}

#[test]
fn what_cannot_be_recovered_is_refused() {
    let (high, low) = (plane(2, 0.05, 0.0), plane(1, 0.0, 0.0));
    let refused = |high: &Mesh, low: &Mesh, settings: &PairSettings| {
        let outcome = bake(&scene("high", high), &scene("low", low), settings);
        outcome.map(|_| ()).unwrap_err().to_string()
    };
    let usual = settings(Mapping::Normal, BakeAttribute::Normal);
    let mut apart = high.clone();
    apart.positions.iter_mut().for_each(|p| p[0] += 3.0);
    assert!(refused(&apart, &low, &usual).contains("does not overlap high"));
    let mut wide = low.clone();
    wide.uv_sets[0].iter_mut().for_each(|uv| uv[1] *= 2.0);
    assert!(refused(&high, &wide, &usual).contains("along v: out of its tile"));
    let mut flat = low.clone();
    flat.uv_sets[0].iter_mut().for_each(|uv| uv[1] = 0.25);
    assert!(refused(&high, &flat, &usual).contains("cover no texel"));
    let mut no_uv = low.clone();
    no_uv.uv_sets.clear();
    let mut asked = usual.clone();
    asked.layout = UvLayout::Uv0;
    assert!(refused(&high, &no_uv, &asked).contains("no TEXCOORD_0"));
    asked.layout = UvLayout::Auto;
    let baked = bake(&scene("high", &high), &scene("low", &no_uv), &asked).unwrap();
    assert!(baked.filled > 0 && baked.missed == 0);
    asked = usual.clone();
    asked.recovery.reach = Some(f32::NAN);
    assert!(refused(&high, &low, &asked).contains("--reach"));
    asked = usual.clone();
    asked.recovery.probes.directions = 0;
    assert!(refused(&high, &low, &asked).contains("--probes"));
    asked = settings(Mapping::UvMatch, BakeAttribute::Normal);
    assert!(refused(&high, &low, &asked).contains("built file"));
    asked = usual;
    asked.by_name = true;
    let mut other = high.clone();
    other.name = "somebody".into();
    assert!(refused(&other, &low, &asked).contains("no such mesh"));
}

/// What is fetched later through the mapping image is what was fetched at once.
#[test]
fn the_mapping_image_holds_the_correspondence() {
    let mut high = plane(9, 0.0, 0.0);
    for p in &mut high.positions {
        p[2] = 0.02 + 0.01 * (11.0 * p[0]).sin() * (7.0 * p[1]).cos();
    }
    let low = scene("low", &plane(2, 0.0, 0.05));
    let asked = PairSettings {
        attributes: vec![
            BakeAttribute::Mapping,
            BakeAttribute::Position,
            BakeAttribute::Height,
        ],
        ..settings(Mapping::Normal, BakeAttribute::Normal)
    };
    let baked = bake(&scene("high", &high), &low, &asked).unwrap();
    let [mapping, position, height] = [0, 1, 2].map(|k| &baked.textures[k].values);
    let mut met = 0;
    for k in (0..64 * 64).filter(|&k| baked.mask[k] == 255) {
        let [triangle, b1, b2, _] = mapping[k];
        let corners = high.corners(triangle as usize);
        let b = [1.0 - b1 - b2, b1, b2];
        for i in 0..3 {
            let at: f32 = (0..3).map(|c| b[c] * corners[c][i]).sum();
            assert!((at - position[k][i]).abs() < 1e-6);
        }
        assert!(
            (height[k][0] - position[k][2]).abs() < 1e-6,
            "over the plane z = 0"
        );
        met += 1;
    }
    assert!(met > 3000);
    // Where nothing is there is no number, nor is there a mean of numbers.
    let off = (0..64 * 64).filter(|&k| baked.mask[k] == 0);
    assert!(off.clone().count() > 0);
    off.for_each(|k| assert_eq!(mapping[k][0], -1.0));
    let several = PairSettings {
        samples: 2,
        ..asked
    };
    let refused = bake(&scene("high", &high), &low, &several).unwrap_err();
    assert!(refused.to_string().contains("--samples 1"));
}
