//! `render --attribute`: what it draws, what it says, what it refuses.
#![cfg(feature = "cli")]

mod cli_support;
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
