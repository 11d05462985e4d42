//! `assess` and `bake` between two models, through the real binary: what they say, write and refuse.
#![cfg(feature = "cli")]

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, Run, invertex, models};
use std::path::Path;

/// A detailed ball and a simple one.
fn pair(folder: &Folder) -> (String, String) {
    let ball = |rings: u32| Ball {
        rings,
        ..Ball::default()
    };
    (
        folder.write("high.glb", &ball(40).glb()),
        folder.write("low.glb", &ball(10).glb()),
    )
}

fn bake(high: &str, low: &str, out: &str, more: &[&str]) -> Run {
    let arguments = [
        "bake", high, low, "-o", out, "--json", "--device", "cpu", "--size", "64",
    ];
    invertex(&[&arguments, more].concat())
}

fn assess(high: &str, low: &str, more: &[&str]) -> Run {
    let arguments = [
        "assess", high, low, "--json", "--device", "cpu", "--views", "12", "--rays", "32",
        "--size", "64",
    ];
    // Pictures take the longest: where they are not asked for there are none.
    let dark: &[&str] = if more.contains(&"--lights") {
        &[]
    } else {
        &["--lights", "0"]
    };
    invertex(&[&arguments, dark, more].concat())
}

#[test]
fn two_models_are_baked_with_every_mapping() {
    let folder = Folder::new();
    let (high, low) = pair(&folder);
    for map in [
        "proximity",
        "normal",
        "visibility-face",
        "visibility-vertex",
        "visibility-texel",
        "hybrid-vertex",
        "hybrid-texel",
        "cage",
        "auto",
    ] {
        let out = folder.at(map);
        let more = [
            "--map",
            map,
            "--attributes",
            "normal,object-normal",
            "--probe-size",
            "128",
        ];
        let json = bake(&high, &low, &out, &more).ok().json();
        assert_eq!(
            (&json["mapping"], &json["over"]),
            (&map.into(), &"low".into())
        );
        assert_eq!(json["low"], low.as_str());
        let filled = json["filled_fraction"].as_f64().unwrap();
        assert!(filled > 0.8, "{map}: {filled}");
        let missed = json["missed_fraction"].as_f64().unwrap();
        assert!(missed < 0.02, "{map}: {missed}");
        for file in [
            "ball_normal.png",
            "ball_object-normal.png",
            "ball_mask.png",
            "baked.glb",
        ] {
            assert!(Path::new(&out).join(file).exists(), "{map}: {file}");
        }
    }
    let out = folder.at("seen");
    let more = ["--attributes", "normal", "--preview"];
    bake(&high, &low, &out, &more).ok();
    let seen = image::open(format!("{out}/preview.png")).unwrap();
    assert_eq!((seen.width(), seen.height()), (2048, 512));
    // What it wrote is a model that can be drawn, its normals those of the detailed one.
    let draw = |model: &str, name: &str| {
        let path = folder.at(name);
        let more = [
            "--mode", "normals", "--size", "160", "--device", "cpu", "--view", "30,20",
        ];
        invertex(&[&["render", model, "-o", &path], &more[..]].concat()).ok();
        path
    };
    let baked = draw(&format!("{}/baked.glb", folder.at("normal")), "baked.png");
    let (rich, plain) = (draw(&high, "rich.png"), draw(&low, "plain.png"));
    let differ = |a: &str, b: &str| {
        let json = invertex(&["compare", a, b, "--json"]).ok().json();
        json["flip_mean"].as_f64().unwrap()
    };
    assert!(differ(&rich, &baked) < 0.5 * differ(&rich, &plain));
}

/// What lies round points, in 16 bits and in whole numbers.
#[test]
fn surroundings_are_baked_in_sixteen_bits() {
    let folder = Folder::new();
    let (high, low) = pair(&folder);
    let out = folder.at("deep");
    let attributes = "curvature,thickness,shadow,shading,bent-normal,mapping";
    let more = ["--attributes", attributes, "--bits", "16", "--rays", "8"];
    let more = [
        &more[..],
        &["--format", "exr16", "--light", "0,0,1", "--padding", "0"],
    ]
    .concat();
    let json = bake(&high, &low, &out, &more).ok().json();
    assert_eq!(json["textures"].as_array().unwrap().len(), 12);
    let open = |name: &str| image::open(format!("{out}/ball_{name}.png")).unwrap();
    let mask = open("mask").into_rgba8();
    let found = || (0..64 * 64).filter(|k| mask.get_pixel(k % 64, k / 64)[0] == 255);
    // A ball bulges nearly everywhere, waves and all, and one half of it is lit.
    let curvature = open("curvature");
    assert_eq!(curvature.color(), image::ColorType::Rgba16);
    let curvature = curvature.into_rgba16();
    let shadow = open("shadow").into_rgba16();
    let at = |of: &image::ImageBuffer<image::Rgba<u16>, Vec<u16>>, k: u32| {
        of.get_pixel(k % 64, k / 64)[0]
    };
    let bulges = found().filter(|&k| at(&curvature, k) > 32_768).count();
    assert!(bulges as f32 > 0.8 * found().count() as f32, "{bulges}");
    let lit = found().filter(|&k| at(&shadow, k) == 65535).count();
    let dark = found().filter(|&k| at(&shadow, k) == 0).count();
    assert_eq!(lit + dark, found().count());
    assert!(lit > 500 && dark > 500, "{lit} {dark}");
    // Of 8 bits nothing is left between the steps; of 16 there is.
    let fine = found().any(|k| at(&curvature, k) % 257 != 0);
    bake(&high, &low, &out, &["--attributes", "curvature"]).ok();
    assert!(fine && open("curvature").color() == image::ColorType::Rgba8);
    // Numbers of triangles are whole numbers.
    let path = format!("{out}/ball_mapping.exr");
    let image = exr::prelude::read_all_flat_layers_from_file(path).unwrap();
    let channels = &image.layer_data[0].channel_data.list;
    let numbers = channels.iter().find(|c| c.name == *"triangle.id").unwrap();
    let exr::prelude::FlatSamples::U32(numbers) = &numbers.sample_data else {
        panic!("no whole numbers")
    };
    let most = 40 * 80 * 2;
    assert!(found().all(|k| numbers[k as usize] < most));
    assert!(numbers.contains(&u32::MAX));
}

#[test]
fn measures_come_for_every_mapping_and_repeat() {
    let folder = Folder::new();
    let (high, low) = pair(&folder);
    let out = folder.at("maps");
    let json = assess(
        &high,
        &low,
        &["--probe-size", "64", "-o", &out, "--heat-size", "32"],
    )
    .ok()
    .json();
    let mappings = json["mappings"].as_array().unwrap();
    assert_eq!(mappings.len(), 9);
    for m in mappings {
        let of = |name: &str| m[name].as_f64().unwrap();
        assert!(of("object_space") > 0.0 && of("object_space") < 10.0, "{m}");
        assert!(of("object_space_rms") >= of("object_space"), "{m}");
        assert!(of("image_space") > 0.0, "{m}");
        assert!((0.0..=1.0).contains(&of("image_space_normalized")), "{m}");
        assert!(of("sampling_uniformity") > 0.0, "{m}");
    }
    assert_eq!(json["images"].as_array().unwrap().len(), 18);
    for image in json["images"].as_array().unwrap() {
        assert!(image::open(image.as_str().unwrap()).is_ok());
    }
    let again = assess(&high, &low, &["--probe-size", "64"]).ok().json();
    assert_eq!(again["mappings"], json["mappings"]);
    let text = invertex(&[
        "assess",
        &high,
        &low,
        "--maps",
        "proximity,normal",
        "--views",
        "4",
        "--rays",
        "16",
        "--size",
        "32",
        "--lights",
        "1",
    ]);
    let text = text.ok().stdout;
    assert!(text.contains("uniformity %") && text.contains("(LOW as it is)"));
}

/// Normals that were baked are nearer to the detailed model than none, whichever way the light comes from.
#[test]
fn pictures_are_compared_under_a_light_that_moves() {
    let folder = Folder::new();
    let (high, low) = pair(&folder);
    let lit = [
        "--maps",
        "proximity,normal",
        "--lights",
        "3",
        "--light-views",
        "2",
    ];
    let json = assess(&high, &low, &lit).ok().json();
    let light = &json["light"];
    assert_eq!(
        light["turn_degrees"],
        serde_json::json!([0.0, 120.0, 240.0])
    );
    let lights = |flips: &serde_json::Value| -> Vec<f64> {
        let all = flips["lights"].as_array().unwrap().iter();
        all.map(|flip| flip.as_f64().unwrap()).collect()
    };
    for m in json["mappings"].as_array().unwrap() {
        let (baked, plain) = (lights(&m["light_flip"]), lights(&light["low"]));
        assert_eq!((baked.len(), plain.len()), (3, 3));
        assert!(baked.iter().zip(&plain).all(|(b, p)| b < p), "{m} {light}");
        let mean = m["light_flip"]["mean"].as_f64().unwrap();
        assert!((mean - baked.iter().sum::<f64>() / 3.0).abs() < 1e-9);
    }
}

/// Rays from a cage that is the surface itself find nothing above it.
#[test]
fn a_cage_says_where_rays_begin() {
    let folder = Folder::new();
    let (high, low) = pair(&folder);
    let rated = |more: &[&str]| {
        let fixed = ["--maps", "cage", "--lights", "0"];
        let json = assess(&high, &low, &[&fixed[..], more].concat())
            .ok()
            .json();
        assert!(json.get("light").is_none());
        json["mappings"][0].clone()
    };
    let (free, tight) = (rated(&[]), rated(&["--cage", &low]));
    let missed = |m: &serde_json::Value| m["missed_fraction"].as_f64().unwrap();
    assert!(missed(&tight) > missed(&free) + 0.2, "{tight} {free}");
    let lit = ["--maps", "normal,cage", "--cage", &low, "--lights", "1"];
    let json = assess(&high, &low, &lit).ok().json();
    let flip = |k: usize| json["mappings"][k]["light_flip"]["mean"].as_f64().unwrap();
    assert!(flip(0) > 0.0 && flip(0) != flip(1));
    assess(&high, &low, &["--maps", "normal", "--cage", &low]).fails(2, &["--cage", "normal"]);
    assess(&high, &low, &["--maps", "cage", "--cage", &high]).fails(3, &["triangles"]);
    assess(&high, &low, &["--lights", "361"]).fails(2, &["--lights", "0 to 360"]);
}

#[test]
fn what_cannot_be_rated_or_baked_is_refused() {
    let folder = Folder::new();
    let (high, low) = pair(&folder);
    assess(&high, &low, &["--maps", "nearest"]).fails(2, &["--maps", "proximity"]);
    assess(&high, &low, &["--maps", "uv-match"]).fails(2, &["--maps", "built file"]);
    invertex(&["assess", &high, &low, "--rays", "2"]).fails(2, &["--rays", "8 to 2048"]);
    invertex(&["assess", &high, &low, "--views", "0"]).fails(2, &["--views"]);
    assess(&high, &low, &["--upright", "0,0,0"]).fails(2, &["--upright", "0,1,0"]);
    assess(&high, &low, &["--reach", "-1"]).fails(2, &["--reach"]);
    assess(&high, &folder.at("none.glb"), &[]).fails(3, &["none.glb"]);
    let out = folder.at("out");
    for (more, code, words) in [
        (
            &["--attributes", "normal", "--map", "nearest"][..],
            2,
            &["--map", "cage"][..],
        ),
        (
            &["--attributes", "normal", "--map", "uv-match"],
            2,
            &["--map", "built"],
        ),
        (&["--attributes", "normal", "--lod", "1"], 2, &["--lod"]),
        (
            &["--attributes", "normal", "--over", "primary"],
            2,
            &["--over"],
        ),
        (
            &["--attributes", "normal", "--mesh", "nobody"],
            3,
            &["nobody", "ball"],
        ),
        (
            &["--attributes", "normal", "--probes", "0"],
            2,
            &["--probes"],
        ),
        (
            &["--attributes", "shadow", "--light", "0,0"],
            2,
            &["--light", "0,1,0.5"],
        ),
        (
            &["--attributes", "thickness", "--ray-reach", "-1"],
            2,
            &["--ray-reach"],
        ),
        (
            &["--attributes", "bent"],
            2,
            &["--attributes", "bent-normal"],
        ),
    ] {
        bake(&high, &low, &out, more).fails(code, words);
        assert!(!Path::new(&out).exists());
    }
    // Options of two models say nothing about one.
    invertex(&[
        "bake",
        &high,
        "-o",
        &out,
        "--attributes",
        "normal",
        "--misses",
        "fill",
    ])
    .fails(2, &["second model"]);
    // A model of floats that are none is refused by the reader.
    let poisoned = Ball {
        poison: Some(f32::NAN),
        ..Ball::default()
    };
    let poisoned = folder.write("nan.glb", &poisoned.glb());
    bake(&poisoned, &low, &out, &["--attributes", "normal"]).fails(3, &["nan.glb"]);
    bake(&high, &poisoned, &out, &["--attributes", "normal"]).fails(3, &["nan.glb"]);
}

/// The paper's Table 1 on the bunny: proximity is worst in uniformity and in normalised distance, best in plain distance.
#[test]
fn the_bunny_ranks_mappings_as_the_paper_does() {
    let Some(models) = models() else {
        println!("skipped: no shared models");
        return;
    };
    let at = |name: &str| {
        models
            .join("stanford_bunny")
            .join(name)
            .display()
            .to_string()
    };
    let (high, low) = (at("bunny.glb"), at("bunny_low_uv.glb"));
    let rated = |maps: &str, more: &[&str]| {
        let usual = [
            "assess", &high, &low, "--maps", maps, "--views", "64", "--rays", "32", "--json",
        ];
        let small = [
            "--size",
            "256",
            "--probe-size",
            "256",
            "--device",
            "cpu",
            "--lights",
            "0",
        ];
        let run = invertex(&[&usual, &small[..], more].concat());
        run.ok().json()
    };
    let json = rated("proximity,normal,visibility-vertex,hybrid-vertex", &[]);
    let all = json["mappings"].as_array().unwrap();
    let (near, rays) = all.split_first().unwrap();
    let of = |m: &serde_json::Value, name: &str| m[name].as_f64().unwrap();
    for m in rays {
        assert!(
            of(near, "image_space_normalized") > of(m, "image_space_normalized"),
            "{near} {m}"
        );
        assert!(of(near, "image_space") < of(m, "image_space"), "{near} {m}");
        assert!(
            of(near, "sampling_uniformity") > of(m, "sampling_uniformity"),
            "{near} {m}"
        );
    }
    // What is best by place is nearest to what is seen: the measure that it is chosen by. All mappings rate the same rays.
    let json = rated(
        "normal,proximity,visibility-vertex,hybrid-vertex,auto",
        &["--misses", "proximity"],
    );
    let all = json["mappings"].as_array().unwrap();
    let nearest = all.iter().map(|m| of(m, "object_space"));
    let nearest = nearest.fold(f64::INFINITY, f64::min);
    assert_eq!(of(&all[4], "object_space"), nearest, "{json}");
}
