//! Computed primaries through the real binary: what `inspect --primary` says and draws, and what it refuses.

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, invertex};

#[test]
fn computed_maps_are_listed_and_drawn() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let maps = folder.at("maps");
    let arguments = [
        "inspect",
        &model,
        "--primary",
        "all",
        "--pictures",
        &maps,
        "--json",
    ];
    let json = invertex(&arguments).ok().json();
    let asked = json["meshes"][0]["asked"].as_array().unwrap();
    let kinds: Vec<&str> = asked
        .iter()
        .map(|one| one["kind"].as_str().unwrap())
        .collect();
    assert_eq!(
        kinds,
        [
            "lscm",
            "abf",
            "isochart",
            "geometry-image",
            "sphere:map",
            "cylinder:map"
        ]
    );
    for one in asked {
        assert_eq!(one["possible"], true, "{one:#}");
        for key in ["charts", "stretch", "seam_length", "filled_fraction"] {
            assert!(!one["map"][key].is_null(), "{key} is missing in {one:#}");
        }
        assert_eq!(one["map"]["turned_triangles"].as_array().unwrap().len(), 0);
        let pictures: Vec<&str> = one["pictures"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| p.as_str().unwrap())
            .collect();
        assert_eq!(pictures.len(), 3);
        for picture in pictures {
            let image = image::open(picture).unwrap().into_rgba8();
            let white = image.pixels().filter(|p| p.0 == [255; 4]).count();
            let share = white as f64 / f64::from(image.width() * image.height());
            assert!(
                (0.02..0.9).contains(&share),
                "{picture}: {share} is background"
            );
        }
    }
    let table = invertex(&["inspect", &model, "--primary", "lscm:1.05,sphere:0,0,0"])
        .ok()
        .stdout;
    assert!(
        table.contains("lscm:1.05") && table.contains("sphere, as asked"),
        "{table}"
    );
}

#[test]
fn nonsense_is_refused() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let built = folder.at("built.glb");
    invertex(&["inspect", &model, "--primary", "lscm:0.5"])
        .fails(2, &["--primary", "0.5", "from 1 to 10"]);
    invertex(&["inspect", &model, "--primary", "lscm,mercator"])
        .fails(2, &["--primary", "mercator", "geometry-image"]);
    invertex(&["build", &model, "-o", &built, "--primary", "sphere:map:2"])
        .fails(2, &["--primary"]);
    assert!(!std::path::Path::new(&built).exists());
    // What cannot be had is said in a line, and is no error of inspect's; build has nothing to build with.
    let strip = folder.write("strip.gltf", moebius().as_bytes());
    let text = invertex(&["inspect", &strip, "--primary", "sphere:map"])
        .ok()
        .stdout;
    assert!(
        text.contains("winding turns over") && text.contains("--primary lscm"),
        "{text}"
    );
    invertex(&["build", &strip, "-o", &built, "--primary", "sphere:map"])
        .fails(3, &["winding turns over"]);
}

/// A strip with half a turn, all in its JSON.
fn moebius() -> String {
    use base64::Engine;
    let rounds = 12u32;
    let positions: Vec<f32> = (0..rounds)
        .flat_map(|i| {
            let angle = i as f32 / rounds as f32 * std::f32::consts::TAU;
            [-0.3f32, 0.3].map(|s| {
                let radius = 1.0 + s * (angle / 2.0).cos();
                [
                    radius * angle.cos(),
                    radius * angle.sin(),
                    s * (angle / 2.0).sin(),
                ]
            })
        })
        .flatten()
        .collect();
    let indices: Vec<u32> = (0..rounds)
        .flat_map(|i| {
            let [a, b] = [2 * i, 2 * i + 1];
            let [c, d] = if i == rounds - 1 {
                [1, 0]
            } else {
                [2 * i + 2, 2 * i + 3]
            };
            [a, c, b, b, c, d]
        })
        .collect();
    let (first, second): (&[u8], &[u8]) = (
        bytemuck::cast_slice(&positions),
        bytemuck::cast_slice(&indices),
    );
    let text = base64::engine::general_purpose::STANDARD.encode([first, second].concat());
    serde_json::json!({
        "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }], "scenes": [{ "nodes": [0] }], "scene": 0,
        "meshes": [{ "name": "strip", "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 2 * rounds, "type": "VEC3", "min": [-2, -2, -2], "max": [2, 2, 2] },
            { "bufferView": 1, "componentType": 5125, "count": indices.len(), "type": "SCALAR" }
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": first.len() },
            { "buffer": 0, "byteOffset": first.len(), "byteLength": second.len() }
        ],
        "buffers": [{ "byteLength": first.len() + second.len(), "uri": format!("data:application/octet-stream;base64,{text}") }]
    })
    .to_string()
}
