//! What is baked of a point's surroundings: known answers on balls, planes and slabs, under a plate, and where it goes wrong.

mod pair;

use invertex::mesh::{Mesh, shapes};
use invertex::recover::{AroundOptions, BakeAttribute, Baked, Mapping, Pair, PairSettings};
use invertex::render::Renderer;
use pair::{Quiet, placed, plane, scene};

/// Everything that is found round a point, and where that is.
const ALL: [BakeAttribute; 7] = [
    BakeAttribute::Position,
    BakeAttribute::ObjectBentNormal,
    BakeAttribute::Curvature,
    BakeAttribute::Thickness,
    BakeAttribute::Shadow,
    BakeAttribute::Shading,
    BakeAttribute::BentNormal,
];

fn bake(high: &Mesh, low: &Mesh, around: AroundOptions) -> Baked {
    let settings = PairSettings {
        mapping: Mapping::Proximity,
        attributes: ALL.to_vec(),
        size: 64,
        padding: 1,
        around,
        ..PairSettings::default()
    };
    let draw = |picture| Ok(Renderer::cpu(picture));
    let (high, low) = (scene("high", high), scene("low", low));
    let mut pair = Pair::new(&high, &low, &settings, &draw, &Quiet).unwrap();
    pair.bake(0, &Quiet).unwrap()
}

/// Of each texel with its point: all values in the order of [`ALL`].
fn texels(baked: &Baked) -> Vec<[[f32; 3]; 7]> {
    let on = (0..baked.mask.len()).filter(|&k| baked.mask[k] == 255);
    let of = |k: usize| {
        std::array::from_fn(|a| {
            let [x, y, z, _] = baked.textures[a].values[k];
            [x, y, z]
        })
    };
    on.map(of).collect()
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    v.map(|c| c / dot(v, v).sqrt())
}

/// A ball of radius 2: bent normals are its normals, its curvature is 1/2, the mean chord 4/3 of the radius, the light comes
/// to the half that looks at it.
#[test]
fn a_ball_has_the_answers_of_a_ball() {
    let mut ball = shapes::icosphere(5);
    ball.normals.clone_from(&ball.positions);
    ball.positions.iter_mut().flatten().for_each(|c| *c *= 2.0);
    let around = AroundOptions {
        rays: 128,
        reach: 3.0,
        light: [1.0, 2.0, 2.0],
        ..AroundOptions::default()
    };
    let mut low = shapes::icosphere(2);
    low.positions.iter_mut().flatten().for_each(|c| *c *= 2.0);
    low.uv_sets.clear();
    let baked = bake(&ball, &low, around);
    let all = texels(&baked);
    assert!(all.len() > 1000);
    let mean = all.iter().map(|t| t[3][0]).sum::<f32>() / all.len() as f32;
    assert!((mean - 8.0 / 3.0).abs() < 0.02, "{mean}");
    for [place, bent, curvature, thickness, shadow, shading, _] in all {
        let out = unit(place);
        assert!(dot(out, bent) > 0.995, "{bent:?} {out:?}");
        assert!((curvature[0] - 0.5).abs() < 1e-3, "{curvature:?}");
        assert!((thickness[0] - 8.0 / 3.0).abs() < 0.2, "{thickness:?}");
        let cosine = dot(out, [1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0]);
        assert!((shading[0] - cosine.max(0.0)).abs() < 2e-3);
        if cosine.abs() > 0.05 {
            assert_eq!(shadow[0], f32::from(u8::from(cosine > 0.0)), "{cosine}");
        }
    }
    // Codes: a ball of radius 2 against one of 2 % of the diagonal.
    let radius = 0.02 * 4.0 * 3f32.sqrt();
    let code = baked.textures[2].rgba16()[0];
    let want = (0.5 + 0.5 * radius / 2.0) * 65535.0;
    assert!((f32::from(code) - want).abs() < 20.0, "{code} {want}");
    // The negative control: turned inside out its curvature is the other way, nothing is open, the light comes nowhere.
    ball.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    ball.normals.iter_mut().flatten().for_each(|c| *c = -*c);
    low.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    low.normals.iter_mut().flatten().for_each(|c| *c = -*c);
    for [_, _, curvature, thickness, shadow, ..] in texels(&bake(&ball, &low, around)) {
        assert!((curvature[0] + 0.5).abs() < 1e-3);
        assert_eq!(shadow[0], 0.0);
        // Outside of a hollow there is no far side: as far as rays reach.
        assert!((thickness[0] - 3.0 * 4.0 * 3f32.sqrt()).abs() < 1e-3);
    }
}

/// A sheet from (0, 0) to (side, side) at this height, looking up or down.
fn sheet(side: f32, z: f32, up: bool) -> Mesh {
    let mut mesh = plane(12, z, 0.0);
    for p in &mut mesh.positions {
        (p[0], p[1]) = (p[0] * side, p[1] * side);
    }
    if !up {
        mesh.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        mesh.normals.fill([0.0, 0.0, -1.0]);
    }
    mesh
}

fn joined(mut a: Mesh, b: &Mesh) -> Mesh {
    let first = a.positions.len() as u32;
    a.positions.extend(&b.positions);
    a.normals.extend(&b.normals);
    a.uv_sets[0].extend(&b.uv_sets[0]);
    a.tangents.clear();
    let more = b.triangles.iter().map(|t| t.map(|v| v + first));
    a.triangles.extend(more);
    a.triangle_material = vec![0; a.triangles.len()];
    a
}

/// Two sheets: through a slab of thickness d the mean way is 2 d, less d^2 / R for what rays of reach R do not see the end of.
#[test]
fn a_slab_is_as_thick_as_it_is_and_flat() {
    let d = 0.1;
    let slab = joined(sheet(8.0, 0.0, true), &sheet(8.0, -d, false));
    let reach = 0.2;
    let around = AroundOptions {
        rays: 256,
        reach,
        light: [0.0, 0.6, 0.8],
        ..AroundOptions::default()
    };
    let baked = bake(&slab, &sheet(8.0, 0.0, true), around);
    let far = reach * (2.0 * 64.0 + d * d).sqrt();
    let want = 2.0 * d - d * d / far;
    let (mut middle, mut sum) = (0, 0.0);
    for [place, bent, curvature, thickness, shadow, shading, tangent] in texels(&baked) {
        assert!(dot(bent, [0.0, 0.0, 1.0]) > 0.999 && tangent[2] > 0.999);
        assert!(curvature[0].abs() < 1e-6);
        assert_eq!(shadow[0], 1.0);
        assert!((shading[0] - 0.8).abs() < 1e-6);
        if place[..2].iter().all(|c| (far..8.0 - far).contains(c)) {
            // Few rays that nearly graze the slab make much of the mean.
            assert!((thickness[0] - want).abs() < 0.2 * want, "{thickness:?}");
            (middle, sum) = (middle + 1, sum + thickness[0]);
        }
    }
    let mean = sum / middle as f32;
    assert!(
        middle > 300 && (mean - want).abs() < 0.02 * want,
        "{mean} {want}"
    );
    // Half of it is half as thick: the measure follows the body.
    let thin = joined(sheet(8.0, 0.0, true), &sheet(8.0, -d / 2.0, false));
    let thin = texels(&bake(&thin, &sheet(8.0, 0.0, true), around));
    let centre = |all: &[[[f32; 3]; 7]]| {
        let near = |t: &&[[f32; 3]; 7]| t[0][..2].iter().all(|c| (3.5..4.5).contains(c));
        let some: Vec<f32> = all.iter().filter(near).map(|t| t[3][0]).collect();
        some.iter().sum::<f32>() / some.len() as f32
    };
    let ratio = centre(&texels(&baked)) / centre(&thin);
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
}

/// A plate over the left half of a floor: the floor sees the sky to the right, and light from over the plate leaves a shadow
/// where geometry says.
#[test]
fn a_plate_bends_normals_away_and_throws_its_shadow() {
    let mut plate = sheet(1.0, 0.25, true);
    plate.positions.iter_mut().for_each(|p| p[0] *= 0.5);
    let high = joined(sheet(1.0, 0.0, true), &plate);
    // Light from the left: the shadow of the rim at x = 1/2 falls 1/4 to the right of it.
    let around = AroundOptions {
        rays: 256,
        light: [-1.0, 0.0, 1.0],
        ..AroundOptions::default()
    };
    let (mut shaded, mut lit) = (0, 0);
    for [place, bent, _, _, shadow, ..] in texels(&bake(&high, &sheet(1.0, -0.01, true), around)) {
        if place[2] > 0.1 {
            continue;
        }
        let x = place[0];
        if (0.3..0.7).contains(&x) && (0.2..0.8).contains(&place[1]) {
            assert!(bent[0] > 0.05 && dot(bent, bent) > 0.999, "{bent:?}");
        }
        if (0.27..0.73).contains(&x) {
            assert_eq!(shadow[0], 0.0, "{x}");
            shaded += 1;
        } else if x > 0.77 {
            assert_eq!(shadow[0], 1.0, "{x}");
            lit += 1;
        }
    }
    assert!(shaded > 500 && lit > 500, "{shaded} {lit}");
}

/// Where a place mirrors, a texel still stands for the point under it.
#[test]
fn texels_of_mirrored_models_stay_in_their_place() {
    let place = [
        [-1.0, 0.0, 0.0, 0.0],
        [0.0, 1.0, 0.0, 0.0],
        [0.0, 0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0, 1.0],
    ];
    let (high, low) = (plane(5, 0.05, 0.0), plane(2, 0.0, 0.0));
    let (high, low) = (placed("high", &high, place), placed("low", &low, place));
    let settings = PairSettings {
        attributes: vec![BakeAttribute::Position],
        size: 32,
        ..PairSettings::default()
    };
    let draw = |picture| Ok(Renderer::cpu(picture));
    let mut pair = Pair::new(&high, &low, &settings, &draw, &Quiet).unwrap();
    let baked = pair.bake(0, &Quiet).unwrap();
    for (k, [x, y, ..]) in baked.textures[0].values.iter().enumerate() {
        let [u, v] = [k % 32, k / 32].map(|c| (c as f32 + 0.5) / 32.0);
        assert!((x + u).abs() < 1e-5 && (y - v).abs() < 1e-5, "{x} {u}");
    }
}

#[test]
fn options_out_of_range_are_refused() {
    let (high, low) = (
        scene("high", &plane(1, 0.0, 0.0)),
        scene("low", &plane(1, 0.0, 0.0)),
    );
    let usual = AroundOptions::default();
    for (around, option) in [
        (AroundOptions { rays: 0, ..usual }, "--rays"),
        (
            AroundOptions {
                rays: 5000,
                ..usual
            },
            "--rays",
        ),
        (
            AroundOptions {
                reach: f32::NAN,
                ..usual
            },
            "--ray-reach",
        ),
        (
            AroundOptions {
                curvature_radius: 0.0,
                ..usual
            },
            "--curvature-radius",
        ),
        (
            AroundOptions {
                light: [0.0; 3],
                ..usual
            },
            "--light",
        ),
        (
            AroundOptions {
                light: [f32::INFINITY, 0.0, 0.0],
                ..usual
            },
            "--light",
        ),
    ] {
        let settings = PairSettings {
            around,
            ..PairSettings::default()
        };
        let draw = |picture| Ok(Renderer::cpu(picture));
        let refused = Pair::new(&high, &low, &settings, &draw, &Quiet).map(|_| ());
        let refused = refused.unwrap_err().to_string();
        assert!(refused.starts_with(option), "{refused}");
    }
}
