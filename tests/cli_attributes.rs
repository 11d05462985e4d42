//! `render --attribute`: what it draws, what it says, what it refuses.
#![cfg(feature = "cli")]

mod cli_support;
mod glb;
mod painted;

use cli_support::{Folder, invertex};
use painted::Painted;

fn pixels(path: &str) -> Vec<[u8; 4]> {
    let image = image::open(path).unwrap().to_rgba8();
    image.pixels().map(|p| p.0).filter(|p| p[3] != 0).collect()
}

#[test]
fn attributes_are_drawn_of_a_plain_file_and_of_a_level_alike() {
    let folder = Folder::new();
    let (model, built, out) = (
        folder.write("m.glb", &Painted::default().glb()),
        folder.at("b.glb"),
        folder.at("o.png"),
    );
    invertex(&[
        "build",
        &model,
        "-o",
        &built,
        "--primary",
        "uv0",
        "--lods",
        "0.4",
    ])
    .ok();
    for (file, mode) in [(&model, "reference"), (&built, "igt")] {
        let draw = |attribute: &str, more: &[&str]| {
            let arguments = [
                &[
                    "render",
                    file,
                    "-o",
                    &out,
                    "--device",
                    "cpu",
                    "--size",
                    "48",
                    "--json",
                    "--mode",
                    mode,
                    "--attribute",
                    attribute,
                ],
                more,
            ]
            .concat();
            let json = invertex(&arguments).ok().json();
            assert_eq!(json["attribute"], attribute);
            pixels(&out)
        };
        let parts = draw("part", &["--shading", "unlit"]);
        let colours: std::collections::HashSet<_> = parts.iter().collect();
        assert_eq!(colours.len(), 2, "{mode}");
        let grey = draw(
            "occlusion",
            &["--occlusion-samples", "16", "--occlusion-reach", "0.3"],
        );
        assert!(
            grey.iter().all(|p| p[0] == p[1] && p[1] == p[2]),
            "data is not lit"
        );
        assert!(grey.iter().any(|p| p[0] == 255) && grey.iter().any(|p| p[0] < 200));
        // 20 degrees at the equator, in 5..35: the middle.
        let heat = draw("_HEAT:5..35", &["--view", "0,0", "--ortho"]);
        assert!(heat.iter().any(|p| p[0].abs_diff(128) <= 6) && heat.iter().any(|p| p[0] > 240));
        let lit = draw("color*occlusion", &["--occlusion-samples", "16"]);
        assert!(lit.iter().any(|p| p[0] != p[1]));
    }
    let wire = [
        "render",
        &built,
        "-o",
        &out,
        "--device",
        "cpu",
        "--mode",
        "wireframe",
        "--lod",
        "1",
        "--attribute",
        "part",
    ];
    invertex(&wire).ok();
}

#[test]
fn what_cannot_be_shown_is_refused_before_anything_is_written() {
    let folder = Folder::new();
    let (model, out) = (
        folder.write("m.glb", &Painted::default().glb()),
        folder.at("o.png"),
    );
    for (attribute, more, words) in [
        (
            "colour",
            &[][..],
            &["colour", "triangle-color", "_NAME"][..],
        ),
        ("_HEAP", &[], &["_HEAT, _TAG"]),
        (
            "part",
            &["--mode", "normals"],
            &["--mode reference, igt and wireframe"],
        ),
        ("normal", &["--mode", "wireframe"], &["data"]),
        (
            "occlusion",
            &["--occlusion-samples", "0"],
            &["--occlusion-samples", "1 to 4096"],
        ),
        (
            "occlusion",
            &["--occlusion-reach=-1"],
            &["--occlusion-reach"],
        ),
        ("_HEAT:a..b", &[], &["LOW..HIGH"]),
        ("volume", &[], &["--volume FILE"]),
        ("wood", &["--solid-scale", "0"], &["--solid-scale", "0.001"]),
        ("part", &["--time", "1"], &["--time", "--animation"]),
        ("procedural", &[], &["--procedural FILE.glsl"]),
    ] {
        let arguments = [
            &[
                "render",
                &model,
                "-o",
                &out,
                "--device",
                "cpu",
                "--attribute",
                attribute,
            ],
            more,
        ]
        .concat();
        invertex(&arguments).fails(2, words);
        assert_eq!(folder.names(), ["m.glb"]);
    }
    let bare = folder.write(
        "bare.glb",
        &Painted {
            uv: false,
            ..Painted::default()
        }
        .glb(),
    );
    invertex(&[
        "render",
        &bare,
        "-o",
        &out,
        "--device",
        "cpu",
        "--attribute",
        "base-color",
    ])
    .fails(3, &["balls", "TEXCOORD_0"]);
}

#[test]
fn solids_move_and_volumes_are_read_from_a_strip_or_a_folder() {
    let folder = Folder::new();
    let model = folder.write("m.glb", &Painted::default().glb());
    let out = folder.at("f");
    let base = [
        "render", &model, "--device", "cpu", "--size", "32", "--json", "-o",
    ];
    let moving = ["--attribute", "cellular", "--time", "0..4", "--frames", "3"];
    let json = invertex(&[&base[..], &[&out], &moving].concat())
        .ok()
        .json();
    let images = json["images"].as_array().unwrap();
    let of = |k: usize, key: &str| images[k][key].clone();
    assert_eq!((images.len(), of(1, "time")), (3, 2.0.into()));
    assert_ne!(of(0, "sha256"), of(1, "sha256"));
    assert_eq!(of(0, "sha256"), of(2, "sha256"), "four seconds are a round");
    invertex(
        &[
            &base[..],
            &[
                &folder.at("a.png"),
                "--attribute",
                "wood",
                "--animation",
                "walk",
            ],
        ]
        .concat(),
    )
    .fails(3, &["no animations"]);
    let strip = painted::strip();
    let file = folder.write("v.png", &strip);
    let slices = folder.path().join("slices");
    std::fs::create_dir(&slices).unwrap();
    let whole = image::load_from_memory(&strip).unwrap();
    for k in 0..8 {
        whole
            .crop_imm(0, 8 * k, 8, 8)
            .save(slices.join(format!("{k}.png")))
            .unwrap();
    }
    let slices = slices.display().to_string();
    let one = folder.at("one.png");
    let draw = |volume: &str| {
        let shown = [
            "--attribute",
            "volume",
            "--volume",
            volume,
            "--solid-scale",
            "2",
        ];
        invertex(&[&base[..], &[&one], &shown].concat())
    };
    let sha = |volume: &str| draw(volume).ok().json()["images"][0]["sha256"].clone();
    assert_eq!(sha(&file), sha(&slices));
    std::fs::remove_file(&one).unwrap();
    let narrow = folder.write("narrow.png", &painted::oblong(8, 12, |_, _| [0; 3]));
    draw(&narrow).fails(3, &["narrow.png", "8x12"]);
    draw(&model).fails(3, &["m.glb"]);
    draw(&folder.at("absent.png")).fails(3, &["absent.png"]);
    assert!(!std::path::Path::new(&one).exists());
}

#[test]
fn a_users_function_that_cannot_be_had_is_an_error() {
    let folder = Folder::new();
    let model = folder.write("m.glb", &Painted::default().glb());
    let out = folder.at("o.png");
    let broken = folder.write(
        "mine.glsl",
        b"vec3 igt_procedural(vec3 p, vec3 n, float t) {\n  return q;\n}\n",
    );
    let with = |file: &str, device: &str| {
        invertex(&[
            "render",
            &model,
            "-o",
            &out,
            "--attribute",
            "procedural",
            "--procedural",
            file,
            "--device",
            device,
        ])
    };
    if cfg!(feature = "compile-shaders") {
        with(&broken, "cpu").fails(2, &["--procedural", "Vulkan device"]);
        with(&broken, "0").fails(3, &["mine.glsl:2: error: 'q' : undeclared identifier"]);
        with(&folder.at("absent.glsl"), "0").fails(3, &["absent.glsl"]);
    } else {
        with(&broken, "cpu").fails(2, &["--attribute", "--features compile-shaders"]);
    }
    assert_eq!(folder.names(), ["m.glb", "mine.glsl"]);
}
