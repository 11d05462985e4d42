//! Golden images, by hash: the deferred path's bytes may not change unnoticed.
//!
//! `tests/goldens/render.txt` holds a line `sha256  name` for each picture. A missing line fails; with
//! INVERTEX_BLESS_GOLDENS=1 the file is written anew.

mod render;

use glam::{DMat4, DVec3};
use invertex::igt::Layout;
use invertex::mesh::shapes;
use invertex::render::{Options, Output, Picture, Renderer};
use render::{camera, inverse, picture, tangents};
use sha2::{Digest, Sha256};
use std::fmt::Write;

const GOLDENS: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/goldens/render.txt");

fn pictures() -> Vec<(&'static str, Picture)> {
    let ball = tangents(shapes::icosphere(3));
    let beside = DMat4::from_translation(DVec3::new(1.1, 0.3, -0.4));
    let sphere = inverse::build(ball.clone(), "sphere", Layout::Packed, 0.2);
    let tube = inverse::build(
        tangents(shapes::tube(24, 9)),
        "cylinder:z",
        Layout::Classic,
        0.3,
    );
    let flat = inverse::build(tangents(shapes::grid(12)), "uv0", Layout::Packed, 0.2);
    vec![
        (
            "reference",
            picture(&[(&ball, DMat4::IDENTITY), (&ball, beside)]),
        ),
        ("inverse", inverse::picture(&[&sphere, &tube, &flat])),
    ]
}

fn hashes() -> String {
    let outputs = [
        ("lit", Options::default()),
        (
            "unlit",
            Options {
                output: Output::Unlit,
                ..Options::default()
            },
        ),
        (
            "normals",
            Options {
                output: Output::Normals,
                ..Options::default()
            },
        ),
        (
            "fetches",
            Options {
                output: Output::Fetches,
                ..Options::default()
            },
        ),
        (
            "wireframe",
            Options {
                wireframe: true,
                ..Options::default()
            },
        ),
        (
            "samples",
            Options {
                samples: 4,
                ..Options::default()
            },
        ),
    ];
    let mut out = String::new();
    for (name, picture) in pictures() {
        let view = camera(&picture, 25.0, 30.0, 120, 90);
        let renderer = Renderer::cpu(picture);
        for (output, options) in &outputs {
            let image = renderer.draw(&view, options).unwrap();
            let digest = Sha256::digest(&image.rgba8);
            let hex: String = digest.iter().map(|b| format!("{b:02x}")).collect();
            writeln!(out, "{hex}  {name} {output}").unwrap();
        }
    }
    out
}

#[test]
fn pictures_have_their_golden_bytes() {
    let hashes = hashes();
    if std::env::var_os("INVERTEX_BLESS_GOLDENS").is_some() {
        std::fs::write(GOLDENS, &hashes).unwrap();
        return;
    }
    let golden = std::fs::read_to_string(GOLDENS)
        .expect("tests/goldens/render.txt is missing; see the file's head");
    let wrong: Vec<&str> = hashes
        .lines()
        .filter(|line| !golden.lines().any(|g| g == *line))
        .collect();
    assert!(
        wrong.is_empty(),
        "not as in tests/goldens/render.txt (INVERTEX_BLESS_GOLDENS=1 renews it): {wrong:#?}"
    );
    assert_eq!(
        golden.lines().count(),
        hashes.lines().count(),
        "the file names pictures that no longer exist"
    );
    // All differ: a golden that any picture would meet proves nothing.
    let distinct: std::collections::HashSet<&str> = hashes.lines().map(|l| &l[..64]).collect();
    assert_eq!(distinct.len(), hashes.lines().count());
}
