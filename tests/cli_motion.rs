//! Moving pictures, through the real binary: animations, turntables and sequences, and what cannot be had.

mod cli_support;
mod glb;
mod moving;

use cli_support::{Ball, Folder, invertex};
use serde_json::Value;

/// The made model as it is, and built.
fn models() -> (Folder, String, String) {
    let folder = Folder::new();
    let (document, binary) = moving::document();
    let model = folder.write("bend.glb", &moving::glb(&document, &binary));
    let built = folder.at("built.glb");
    let build = [
        "build",
        &model,
        "-o",
        &built,
        "--lods",
        "0.3",
        "--primary",
        "cylinder:z",
    ];
    invertex(&[&build[..], &["--device", "cpu"]].concat()).ok();
    (folder, model, built)
}

fn render(file: &str, out: &str, more: &[&str]) -> cli_support::Run {
    let common = [
        "render", file, "-o", out, "--device", "cpu", "--size", "64", "--json",
    ];
    invertex(&[&common[..], more].concat())
}

fn images(run: cli_support::Run) -> Vec<Value> {
    run.ok().json()["images"].as_array().unwrap().clone()
}

fn hashes(images: &[Value]) -> Vec<&str> {
    images
        .iter()
        .map(|i| i["sha256"].as_str().unwrap())
        .collect()
}

#[test]
fn one_moment_by_name_and_by_index() {
    let (folder, model, built) = models();
    let out = folder.at("a.png");
    let at = |file: &str, more: &[&str]| {
        let run = render(file, &out, more).ok().json();
        (run["animation"].clone(), run["images"][0].clone())
    };
    let (name, bent) = at(&model, &["--animation", "bend", "--time", "0.75"]);
    assert_eq!((&name, &bent["time"]), (&"bend".into(), &0.75.into()));
    let (_, by_index) = at(&model, &["--animation", "1", "--time", "0.75"]);
    assert_eq!(bent["sha256"], by_index["sha256"]);
    // After its two seconds it begins again.
    let (_, again) = at(&model, &["--animation", "bend", "--time", "4.75"]);
    assert_eq!(
        (&again["time"], &again["sha256"]),
        (&0.75.into(), &bent["sha256"])
    );
    let (_, later) = at(&model, &["--animation", "bend", "--time", "1.25"]);
    assert_ne!(later["sha256"], bent["sha256"]);
    let (_, still) = at(&model, &["--animation", "still"]);
    let (none, rest) = at(&model, &[]);
    assert!(none.is_null() && rest["time"].is_null());
    assert_eq!(still["time"], 0.0);
    for mode in [
        "igt",
        "plain",
        "normals",
        "wireframe",
        "fetches",
        "reference",
    ] {
        let pictures = ["0.3", "0.75"].map(|time| {
            let (_, image) = at(
                &built,
                &["--mode", mode, "--animation", "bend", "--time", time],
            );
            assert!(image["covered_pixels"].as_u64() > Some(300), "{image:#}");
            image["sha256"].clone()
        });
        assert_ne!(pictures[0], pictures[1], "{mode} moves");
    }
}

#[test]
fn sequences_fill_a_folder_and_repeat() {
    let (folder, _, built) = models();
    let out = folder.at("frames");
    let range = [
        "--mode",
        "igt",
        "--animation",
        "bend",
        "--time",
        "0..1",
        "--fps",
        "4",
    ];
    let first = images(render(&built, &out, &range));
    let times: Vec<f64> = first.iter().map(|i| i["time"].as_f64().unwrap()).collect();
    assert_eq!(times, [0.0, 0.25, 0.5, 0.75, 1.0]);
    let names: Vec<String> = (0..5).map(|k| format!("frame_000{k}.png")).collect();
    let written = std::fs::read_dir(&out)
        .unwrap()
        .map(|e| e.unwrap().file_name());
    let mut written: Vec<String> = written.map(|n| n.to_string_lossy().into_owned()).collect();
    written.sort();
    assert_eq!(written, names);
    let mut distinct = hashes(&first);
    distinct.dedup();
    assert_eq!(distinct.len(), 5);
    // A frame of a sequence is the picture of its moment.
    let alone = ["--mode", "igt", "--animation", "bend", "--time", "0.75"];
    let alone = images(render(&built, &folder.at("alone.png"), &alone));
    assert_eq!(alone[0]["sha256"], first[3]["sha256"]);
    let counted = [
        "--mode",
        "igt",
        "--animation",
        "bend",
        "--frames",
        "3",
        "--fps",
        "4",
    ];
    let counted = images(render(&built, &folder.at("counted"), &counted));
    assert_eq!(hashes(&counted), hashes(&first)[..3]);
    // A level of detail of its own for each frame, AOVs in an EXR.
    let fine = [
        "--mode",
        "igt",
        "--lod",
        "pixels:0.5",
        "--animation",
        "bend",
        "--frames",
        "2",
        "--aov",
    ];
    let fine = images(render(&built, &folder.at("exr"), &fine));
    assert!(
        fine[1]["path"]
            .as_str()
            .unwrap()
            .ends_with("frame_0001.exr")
    );
}

#[test]
fn a_turntable_turns_and_may_move() {
    let (folder, model, _) = models();
    let still = images(render(
        &model,
        &folder.at("round"),
        &["--turntable", "4", "--view", "10,20"],
    ));
    let beside = images(render(&model, &folder.at("one.png"), &["--view", "100,20"]));
    assert_eq!(still.len(), 4);
    assert_eq!(still[1]["sha256"], beside[0]["sha256"], "a quarter on");
    let moving = ["--turntable", "4", "--animation", "bend", "--fps", "4"];
    let moving = images(render(&model, &folder.at("moving"), &moving));
    let times: Vec<f64> = moving.iter().map(|i| i["time"].as_f64().unwrap()).collect();
    assert_eq!(times, [0.0, 0.25, 0.5, 0.75]);
    let text = invertex(&[
        "render",
        &model,
        "-o",
        &folder.at("t"),
        "--turntable",
        "2",
        "--device",
        "cpu",
        "--size",
        "32",
    ]);
    assert!(text.ok().stdout.contains("frame_0001.png"));
}

#[test]
fn what_cannot_be_had_is_said() {
    let (folder, model, _) = models();
    let out = folder.at("x.png");
    let with = |more: &[&str]| render(&model, &out, more);
    with(&["--animation", "walk"]).fails(3, &["bend.glb", "walk", "there are: still, bend"]);
    with(&["--animation", "2"]).fails(3, &["there are: still, bend"]);
    let ball = folder.write("ball.glb", &Ball::default().glb());
    render(&ball, &out, &["--animation", "walk"]).fails(3, &["ball.glb", "has no animations"]);
    with(&["--animation", "bend", "--mesh", "nobody"]).fails(3, &["nobody", "there are: tube"]);
    for time in ["nan", "-1", "inf", "soon", "", "2..1", "0..nan"] {
        let run = with(&["--animation", "bend", "--time", time]);
        assert!(
            run.code == 2 && run.stderr.contains("--time"),
            "{time}: {}",
            run.stderr
        );
    }
    let bend = ["--animation", "bend"];
    for (more, word) in [
        (vec!["--fps", "0"], "--fps"),
        (vec!["--fps", "24"], "--fps"),
        (vec!["--frames", "0"], "--frames"),
        (
            vec!["--frames", "5", "--time", "0..1", "--fps", "5"],
            "--fps",
        ),
        (vec!["--turntable", "3", "--frames", "3"], "--frames"),
        (vec!["--time", "0..1000000"], "--time"),
    ] {
        let run = with(&[&bend[..], &more].concat());
        assert!(
            run.code == 2 && run.stderr.contains(word),
            "{more:?}: {}",
            run.stderr
        );
    }
    for alone in [["--time", "1"], ["--frames", "3"], ["--fps", "5"]] {
        let run = with(&alone);
        assert!(
            run.code == 2 && run.stderr.contains("--animation"),
            "{}",
            run.stderr
        );
    }
    // A file in the way of the folder.
    let file = folder.write("file", b"x");
    render(&model, &file, &["--turntable", "2"]).fails(3, &["is a file; a folder is needed"]);
    assert!(!std::path::Path::new(&out).exists());
}

#[test]
fn animations_with_faults_are_named() {
    let folder = Folder::new();
    let spoilt = |spoil: fn(&mut Value)| {
        let (mut document, binary) = moving::document();
        spoil(&mut document);
        let model = folder.write("spoilt.glb", &moving::glb(&document, &binary));
        render(
            &model,
            &folder.at("x.png"),
            &["--animation", "bend", "--time", "0.5"],
        )
    };
    spoilt(|_| ()).ok();
    spoilt(|d| d["animations"][1]["channels"][0]["target"]["node"] = 99.into()).fails(
        3,
        &["animations[1].channels[0].target.node", "does not exist"],
    );
    spoilt(|d| d["animations"][1]["channels"][0]["sampler"] = 9.into())
        .fails(3, &["animations[1].channels[0]", "does not exist"]);
    // Values where times should be: they do not grow.
    spoilt(|d| {
        let outputs = d["animations"][1]["samplers"][4]["output"].clone();
        d["animations"][1]["samplers"][0]["input"] = outputs;
    })
    .fails(3, &["animations[1].samplers[0]", "do not grow"]);
    spoilt(|d| d["animations"][1]["samplers"][0]["interpolation"] = "BOUNCE".into()).fails(
        3,
        &["animations[1].samplers[0]", "LINEAR, STEP or CUBICSPLINE"],
    );
    spoilt(|d| d["animations"][1]["channels"][0]["target"]["path"] = "scale".into())
        .fails(3, &["animations[1].channels[0]", "numbers for 3 keyframes"]);
    // Six numbers for three keyframes of two targets become six of one.
    spoilt(|d| {
        let targets = d["meshes"][0]["primitives"][0]["targets"]
            .as_array_mut()
            .unwrap();
        targets.truncate(1);
    })
    .fails(
        3,
        &[
            "animations[1].channels[4]",
            "2 weights for the 1 morph targets",
        ],
    );
    spoilt(|d| d["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = 99.into())
        .fails(3, &["targets[0].POSITION", "does not exist"]);
    spoilt(|d| {
        let bind = d["skins"][0]["inverseBindMatrices"].clone();
        d["meshes"][0]["primitives"][0]["targets"][0]["NORMAL"] = bind;
    })
    .fails(3, &["16 components"]);
    spoilt(|d| d["meshes"][0]["weights"] = serde_json::json!([1e300, 0]))
        .fails(3, &["meshes[0].weights", "beyond 1e15"]);
}
