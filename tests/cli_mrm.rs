//! Multiresolution models through the real binary: `build --mrm`, `render --lod pixels:X,colour:Y`, what is refused.
#![cfg(feature = "cli")]

mod cli_support;
mod glb;
mod painted;

use cli_support::{Ball, Folder, Run, invertex};

fn ball() -> Vec<u8> {
    Ball {
        rings: 24,
        ..Ball::default()
    }
    .glb()
}

/// A folder with a ball, built with these options besides.
fn built(more: &[&str]) -> (Folder, String) {
    let folder = Folder::new();
    let (from, to) = (folder.write("ball.glb", &ball()), folder.at("built.glb"));
    let arguments = ["build", &from, "-o", &to, "--device", "cpu"];
    invertex(&[&arguments, more].concat()).ok();
    (folder, to)
}

fn render(file: &str, out: &str, lod: &str, more: &[&str]) -> Run {
    let arguments = [
        "render", file, "-o", out, "--mode", "igt", "--lod", lod, "--device", "cpu", "--json",
        "--size", "96x96",
    ];
    invertex(&[&arguments, more].concat())
}

#[test]
fn fewer_pixels_off_take_more_triangles() {
    let (folder, built) = built(&["--mrm=geometry"]);
    let triangles = |lod: &str| {
        let json = render(&built, &folder.at("a.png"), lod, &[]).ok().json();
        let image = &json["images"][0];
        assert!(image["cut"]["asked"].as_u64().unwrap() > 0, "{json}");
        assert_eq!(image["cut"]["colour"], serde_json::Value::Null);
        image["triangles"].as_u64().unwrap()
    };
    let counts = ["pixels:0", "pixels:0.5", "pixels:4"].map(triangles);
    assert!(counts.is_sorted_by(|a, b| a > b), "{counts:?}");
    // Where only the surface must stay fewer will do; what it shows may then be anywhere, and is said to be.
    assert!(triangles("surface:0.5") < counts[1]);
    let bound = |lod: &str| {
        let json = render(&built, &folder.at("a.png"), lod, &[]).ok().json();
        let cut = json["images"][0]["cut"].clone();
        assert_eq!(cut["surface"], lod.starts_with("surface"));
        cut["bound_pixels"].as_f64().unwrap()
    };
    let bounds = ["pixels:0", "pixels:0.5", "surface:0.5"].map(bound);
    assert!(
        bounds[0] == 0.0 && bounds[1] > 0.1 && bounds[1] < 0.50001 && bounds[2] > 0.5,
        "{bounds:?}"
    );
}

#[test]
fn cuts_follow_the_camera_through_a_sequence() {
    let (folder, built) = built(&["--mrm=geometry"]);
    let out = folder.at("away");
    let json = render(
        &built,
        &out,
        "pixels:0.5",
        &["--distance", "1..30", "--frames", "6"],
    )
    .ok()
    .json();
    let images = json["images"].as_array().unwrap();
    let triangles: Vec<u64> = images
        .iter()
        .map(|i| i["triangles"].as_u64().unwrap())
        .collect();
    assert_eq!(triangles.len(), 6);
    assert!(
        triangles.is_sorted_by(|a, b| a >= b) && triangles[0] > 4 * triangles[5],
        "{triangles:?}"
    );
}

#[test]
fn what_a_model_does_not_know_is_refused() {
    let (folder, plain) = built(&[]);
    let out = folder.at("a.png");
    render(&plain, &out, "pixels:1,colour:2", &[]).fails(2, &["--mrm"]);
    render(&plain, &out, "surface:1", &[]).fails(2, &["surface", "--mrm"]);
    // Levels of the chain, as without colour.
    render(&plain, &out, "pixels:1", &[]).ok();
    let (folder, geometry) = built(&["--mrm=geometry"]);
    let out = folder.at("a.png");
    render(&geometry, &out, "pixels:1,colour:2", &[]).fails(2, &["what colours are off by"]);
    for wrong in [
        "pixels:nan",
        "pixels:-1",
        "pixels:1,colour:-1",
        "pixels:1,color:1",
        "pixels:1,colour:",
        "surface:-1",
        "surface:1,colour:2",
    ] {
        let run = render(&geometry, &out, wrong, &[]);
        assert!(
            run.code == 2 && run.stderr.contains("pixels:X,colour:Y"),
            "{}",
            run.stderr
        );
    }
    let sequence = folder.at("away");
    let more = ["--distance", "1..30", "--frames", "3", "--blend", "2"];
    render(&geometry, &sequence, "pixels:1", &more).fails(2, &["--blend"]);
    let run = invertex(&["build", "x.glb", "-o", "y.glb", "--mrm=taste"]);
    assert!(
        run.code == 2 && run.stderr.contains("geometry"),
        "{}",
        run.stderr
    );
}

#[test]
fn a_flight_writes_pictures_and_a_page() {
    let (folder, built) = built(&["--mrm=geometry"]);
    let out = folder.at("flight");
    let fly = |file: &str, more: &[&str]| {
        let arguments = [
            "fly", file, "-o", &out, "--frames", "5", "--size", "64", "--device", "cpu", "--json",
        ];
        invertex(&[&arguments, more].concat())
    };
    let json = fly(&built, &[]).ok().json();
    let frames = json["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 5);
    for frame in frames {
        let path = frame["path"].as_str().unwrap();
        for file in [
            path.to_owned(),
            path.replace(".png", "_cut.png"),
            path.replace(".png", "_displaced.png"),
        ] {
            assert!(std::fs::metadata(&file).unwrap().len() > 100, "{file}");
        }
        // Within the limit, but for corners' rounding.
        assert!(
            frame["displaced"]["p99"].as_f64().unwrap() < 0.55,
            "{frame}"
        );
        assert!(frame["displaced"]["pixels"].as_u64().unwrap() > 0);
        let bound = frame["bound_pixels"].as_f64().unwrap();
        let most = frame["displaced"]["max"].as_f64().unwrap();
        assert!(bound < 0.50001 && most < bound + 0.045, "{frame}");
    }
    let count = |k: usize| frames[k]["triangles"].as_u64().unwrap();
    assert!(count(4) > count(0));
    let page = std::fs::read_to_string(json["page"].as_str().unwrap()).unwrap();
    assert!(page.contains("<svg") && page.contains("Displacement on the screen"));
    for (wrong, word) in [
        (["--lod", "3"], "--lod"),
        (["--hysteresis", "0"], "--hysteresis"),
        (["--turns", "inf"], "--turns"),
        (["--lod", "pixels:1,colour:1"], "colour"),
    ] {
        fly(&built, &wrong).fails(2, &[word]);
    }
    let plain = folder.write("plain.glb", &ball());
    fly(&plain, &[]).fails(3, &["--mrm"]);
}

#[test]
fn colours_let_triangles_move_farther() {
    // One half of the ball is plain, the other has cells.
    let folder = Folder::new();
    let file = folder.at("painted.glb");
    std::fs::write(&file, painted::Painted::default().glb()).unwrap();
    let out = folder.at("built.glb");
    let json = invertex(&[
        "build", &file, "-o", &out, "--device", "cpu", "--mrm", "--json",
    ])
    .ok()
    .json();
    assert!(
        json["build_ms"]["colours"].as_f64().unwrap() > 0.0,
        "{json}"
    );
    let triangles = |lod: &str| {
        let json = render(&out, &folder.at("a.png"), lod, &[]).ok().json();
        json["images"][0]["triangles"].as_u64().unwrap()
    };
    let counts = [
        "pixels:0.25",
        "pixels:0.25,colour:1",
        "pixels:0.25,colour:10",
        "pixels:0.25,colour:1000",
    ]
    .map(triangles);
    assert!(
        counts.is_sorted_by(|a, b| a >= b) && counts[3] < counts[0],
        "{counts:?}"
    );
}
