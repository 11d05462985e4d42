//! `bake`: what it writes, whether the textures look like the reference, what it refuses.
#![cfg(feature = "cli")]

mod cli_support;
mod glb;
mod painted;

use cli_support::{Folder, Run, invertex};
use painted::Painted;

fn built(folder: &Folder, glb: &[u8], primary: &str) -> String {
    let (model, built) = (folder.write("m.glb", glb), folder.at("b.glb"));
    let arguments = [
        "build",
        &model,
        "-o",
        &built,
        "--device",
        "cpu",
        "--primary",
        primary,
        "--lods",
        "0.5",
    ];
    invertex(&arguments).ok();
    built
}

fn bake(built: &str, out: &str, more: &[&str]) -> Run {
    invertex(&[&["bake", built, "-o", out, "--json"], more].concat())
}

fn texels(path: &str) -> Vec<[u8; 4]> {
    let image = image::open(path).unwrap().to_rgba8();
    image.pixels().map(|p| p.0).collect()
}

#[test]
fn a_baked_lod_looks_like_the_same_lod_with_its_inverse_texture() {
    let folder = Folder::new();
    let built = built(
        &folder,
        &Painted {
            rings: 24,
            ..Painted::default()
        }
        .glb(),
        "uv0",
    );
    let out = folder.at("out");
    let json = bake(
        &built,
        &out,
        &[
            "--attributes",
            "color,normal,metallic-roughness,occlusion-map",
            "--size",
            "512",
        ],
    )
    .ok()
    .json();
    assert_eq!(
        (&json["mapping"], &json["over"], &json["size"]),
        (&"uv-match".into(), &"lod".into(), &512.into())
    );
    // Both charts, 0.46 x 0.96 of the square each.
    let filled = json["filled_fraction"].as_f64().unwrap();
    assert!((filled - 2.0 * 0.46 * 0.96).abs() < 0.03, "{filled}");
    assert!(json["missed_fraction"].as_f64().unwrap() < 1e-3);
    for stage in ["prepare", "resample", "write"] {
        assert!(json["ms"][stage].as_f64().unwrap() >= 0.0);
    }
    let baked = format!("{out}/baked.glb");
    for (attribute, bound) in [("base-color", 0.03), ("normal", 0.04)] {
        let draw = |file: &str, mode: &str, name: &str| {
            let path = folder.at(name);
            invertex(&[
                "render",
                file,
                "-o",
                &path,
                "--device",
                "cpu",
                "--mode",
                mode,
                "--size",
                "200",
                "--shading",
                "unlit",
                "--attribute",
                attribute,
            ])
            .ok();
            path
        };
        let (a, b) = (
            draw(&built, "igt", "a.png"),
            draw(&baked, "reference", "b.png"),
        );
        let compared = invertex(&["compare", &a, &b, "--json"]).ok().json();
        let flip = compared["flip_mean"].as_f64().unwrap();
        assert!(flip < bound, "{attribute}: FLIP {flip}");
    }
    // What differs are edge-on triangles at the silhouettes, where a texture is read from small mip levels.
    // Negative control: another attribute is told apart.
    let part = folder.at("part.png");
    invertex(&[
        "render",
        &built,
        "-o",
        &part,
        "--device",
        "cpu",
        "--mode",
        "igt",
        "--size",
        "200",
        "--shading",
        "unlit",
        "--attribute",
        "part",
    ])
    .ok();
    let compared = invertex(&["compare", &folder.at("a.png"), &part, "--json"])
        .ok()
        .json();
    assert!(compared["flip_mean"].as_f64().unwrap() > 0.1);
}

#[test]
fn flat_data_is_baked_to_the_bit_and_borders_grow() {
    let folder = Folder::new();
    let built = built(&folder, &Painted::default().glb(), "uv0");
    let out = folder.at("out");
    let more = [
        "--lod",
        "0",
        "--attributes",
        "part,position,_HEAT:5..35",
        "--size",
        "128",
        "--samples",
        "1",
        "--padding",
        "3",
        "--format",
        "exr",
    ];
    bake(&built, &out, &more).ok();
    let (parts, mask) = (
        texels(&format!("{out}/balls_part.png")),
        texels(&format!("{out}/balls_mask.png")),
    );
    let of = |shade: u8| {
        mask.iter()
            .zip(&parts)
            .filter(move |(m, _)| m[0] == shade)
            .map(|(_, p)| *p)
    };
    let colours: std::collections::HashSet<_> = of(255).chain(of(128)).collect();
    assert_eq!(colours.len(), 2, "two parts, no blends");
    assert!(of(128).count() > 128 * 6 && of(255).count() > 128 * 128 / 2);
    // Heat is 20 + 15 y, so position's y (from -1, longest side 3.05) tells it.
    let (heat, place) = (
        texels(&format!("{out}/balls__HEAT-5..35.png")),
        texels(&format!("{out}/balls_position.png")),
    );
    for k in (0..mask.len()).filter(|&k| mask[k][0] == 255) {
        let y = f64::from(place[k][1]) / 255.0 * 3.05 - 1.0;
        let want = (15.0 + 15.0 * y) / 30.0 * 255.0;
        assert!(
            (f64::from(heat[k][0]) - want).abs() < 2.5,
            "{k}: {} {want}",
            heat[k][0]
        );
    }
    assert!(std::path::Path::new(&format!("{out}/balls_position.exr")).exists());
}

#[test]
fn over_a_primary_one_texture_serves_every_direction() {
    let folder = Folder::new();
    // One ball is left of two: a sphere's primary fits.
    for primary in ["uv0", "sphere:0,0,0", "cylinder:y", "plane:z"] {
        let built = built(&folder, &Painted::default().glb(), primary);
        let out = folder.at("out");
        let more = [
            "--over",
            "primary",
            "--attributes",
            "material,object-normal",
            "--size",
            "64",
        ];
        let json = bake(&built, &out, &more).ok().json();
        assert_eq!(json["over"], "primary");
        let filled = json["filled_fraction"].as_f64().unwrap();
        assert!(filled > 0.3, "{primary}: {filled}");
        let names = std::fs::read_dir(&out).unwrap().count();
        assert_eq!(names, 3, "two textures and a mask");
        std::fs::remove_dir_all(&out).unwrap();
    }
}

#[test]
fn what_cannot_be_baked_is_refused_before_anything_is_written() {
    let folder = Folder::new();
    let built = built(&folder, &Painted::default().glb(), "uv0");
    let out = folder.at("out");
    for (more, code, words) in [
        (
            &["--attributes", "colour"][..],
            2,
            &["--attributes", "triangle-color"][..],
        ),
        (
            &["--attributes", "normal", "--lod", "7"],
            2,
            &["--lod", "0 (the reference) to 1"],
        ),
        (
            &["--attributes", "normal", "--size", "8"],
            2,
            &["--size", "16 to 16384"],
        ),
        (
            &["--attributes", "normal", "--size", "64x32"],
            2,
            &["--size", "square"],
        ),
        (
            &["--attributes", "normal", "--samples", "9"],
            2,
            &["--samples"],
        ),
        (
            &["--attributes", "normal", "--padding", "999"],
            2,
            &["--padding"],
        ),
        (
            &["--attributes", "normal", "--over", "primary"],
            2,
            &["object-normal"],
        ),
        (
            &["--attributes", "color", "--over", "primary", "--lod", "1"],
            2,
            &["--lod"],
        ),
        (&["--attributes", "procedural"], 2, &["device only"]),
        (&["--attributes", "_HEAP"], 2, &["_HEAT, _TAG"]),
        (
            &["--attributes", "color", "--mesh", "nobody"],
            3,
            &["nobody", "balls"],
        ),
    ] {
        bake(&built, &out, more).fails(code, words);
        assert!(!std::path::Path::new(&out).exists());
    }
    bake(&folder.at("m.glb"), &out, &["--attributes", "color"]).fails(3, &["invertex build"]);
}
