//! `profile` through the real binary: the fields that others rely on, which meshes are drawn, and what is refused.

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, built_ball, invertex};
use serde_json::Value;

const RUN_KEYS: [&str; 13] = [
    "mesh",
    "variant",
    "layout",
    "hash",
    "triangles",
    "mean_list",
    "mean_fetches",
    "mean_fetches_with_uv",
    "p99_fetches",
    "max_fetches",
    "tables_bytes",
    "frame_ns_median",
    "frame_ns_p95",
];

#[test]
fn the_command_line_gives_what_it_promises() {
    let (folder, _, built) = built_ball();
    let out = folder.at("report");
    let trace = folder.at("trace.json");
    let json = invertex(&[
        "profile",
        &built,
        "--device",
        "cpu",
        "--size",
        "128x96",
        "--frames",
        "2",
        "--warm-up",
        "0",
        "--sweep",
        "hash,layout",
        "--hashes",
        "32,64",
        "--bake-size",
        "64",
        "-o",
        &out,
        "--trace",
        &trace,
        "--json",
    ])
    .ok()
    .json();
    let runs = json["runs"].as_array().unwrap();
    assert_eq!(runs.len(), 4 + 2 + 2);
    for run in runs {
        for key in RUN_KEYS {
            let may_be_null = ["layout", "hash", "mean_list"].contains(&key);
            assert!(run.get(key).is_some(), "{key} is missing in {run:#}");
            assert!(
                may_be_null || !run[key].is_null(),
                "{key} is null in {run:#}"
            );
        }
        let pixels = |histogram: &str| {
            let counts = run[histogram].as_array().unwrap().iter();
            counts.filter_map(Value::as_u64).sum::<u64>()
        };
        let covered = run["covered_pixels"].as_u64().unwrap();
        assert_eq!(pixels("histogram"), covered);
        // Whatever is looked up is tested: at least one triangle, each with a load of its own besides the hash's.
        if run["variant"] == "lod+igt" {
            let unmapped = run["unmapped_pixels"].as_u64().unwrap();
            assert_eq!(pixels("tests_histogram"), covered - unmapped);
            let tests = run["mean_tests"].as_f64().unwrap();
            let fetches = run["mean_fetches"].as_f64().unwrap();
            assert!(tests >= 1.0 && tests + 0.9 <= fetches, "{tests} {fetches}");
        } else {
            assert!(run["mean_tests"].is_null());
        }
    }
    assert_eq!(runs[1]["variant"], "lod+igt");
    assert_eq!(runs[1]["layout"], "packed");
    assert_eq!(json["clock"], "wall clock");
    let page = std::fs::read_to_string(format!("{out}/profile.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("data:image/png;base64,"));
    let heat = std::fs::read(format!("{out}/fetches-built-ball-lod_igt-lod2.png"));
    assert!(
        heat.unwrap().starts_with(b"\x89PNG"),
        "the level nearest to a tenth is the second"
    );
    let trace: Value = serde_json::from_slice(&std::fs::read(&trace).unwrap()).unwrap();
    assert!(!trace["traceEvents"].as_array().unwrap().is_empty());
    assert_eq!(json["outputs"].as_array().unwrap().len(), 3);
}

#[test]
fn several_meshes_are_drawn_one_by_one_and_together() {
    let folder = Folder::new();
    let two = Ball {
        names: vec!["left".into(), "right".into()],
        ..Ball::default()
    };
    let model = folder.write("two.glb", &two.glb());
    let built = folder.at("built.glb");
    invertex(&[
        "build", &model, "-o", &built, "--device", "cpu", "--lods", "0.2",
    ])
    .ok();
    let quick = [
        "--device",
        "cpu",
        "--size",
        "64",
        "--frames",
        "1",
        "--bake-size",
        "64",
        "--json",
    ];
    let of = |more: &[&str]| {
        let arguments = [&["profile", &built], &quick[..], more].concat();
        let json = invertex(&arguments).ok().json();
        let runs = json["runs"].as_array().unwrap().clone();
        runs.iter()
            .map(|r| r["mesh"].as_str().unwrap().to_owned())
            .collect::<Vec<_>>()
    };
    let four = |name: &str| vec![name.to_owned(); 4];
    assert_eq!(of(&[]), [four("left"), four("right"), four("*")].concat());
    assert_eq!(of(&["--mesh", "right"]), four("right"));
    assert_eq!(of(&["--mesh", "*"]), four("*"));
}

#[test]
fn memory_alone_needs_no_drawing_and_takes_many_files() {
    let (folder, _, built) = built_ball();
    let again = folder.at("again.glb");
    std::fs::copy(&built, &again).unwrap();
    let json = invertex(&["profile", &built, &again, "--table1", "--json"])
        .ok()
        .json();
    let rows = json["memory"].as_array().unwrap();
    assert_eq!(rows.len(), 2);
    for row in rows {
        let bytes = &row["bytes"];
        let of = |key: &str| bytes[key].as_u64().unwrap();
        assert_eq!(
            of("total"),
            of("hash") + of("list") + of("triangle") + of("attribute")
        );
    }
    assert_eq!(json["runs"].as_array().unwrap().len(), 0);
    let text = invertex(&["profile", &built, "--table1"]).ok().stdout;
    assert!(text.contains("bytes a triangle") && text.contains("ball"));
}

#[test]
fn what_cannot_be_profiled_is_said() {
    let (folder, _, built) = built_ball();
    let plain = folder.write("plain.glb", &Ball::default().glb());
    let missing = folder.at("missing.glb");
    let with = |more: &[&str]| {
        let quick = [
            "profile", &built, "--device", "cpu", "--size", "32", "--frames", "1",
        ];
        invertex(&[&quick, more].concat())
    };
    with(&["--bake-size", "64"]).ok();
    invertex(&["profile", &plain])
        .fails(3, &["plain.glb", "no inverse textures", "invertex build"]);
    invertex(&["profile", &missing]).fails(3, &["missing.glb"]);
    with(&["--mesh", "nobody"]).fails(3, &["nobody", "there are: ball"]);
    with(&["--lod", "9"]).fails(2, &["--lod", "levels 0"]);
    with(&["--hashes", "100"]).fails(2, &["--hashes", "power of two"]);
    with(&["--distances", "0"]).fails(2, &["--distances"]);
    with(&["--distances", "nan"]).fails(2, &["--distances"]);
    with(&["--bake-size", "4"]).fails(2, &["--bake-size"]);
    with(&["--path", "forward"]).fails(4, &["--path"]);
    with(&["-o", &folder.at("gone/report")]).fails(3, &["gone", "does not exist"]);
    with(&["--trace", &folder.at("gone/t.json")]).fails(3, &["gone", "does not exist"]);
    for bad in [
        ["--size", "0x5"],
        ["--size", "9000"],
        ["--frames", "0"],
        ["--sweep", "colour"],
    ] {
        assert_eq!(with(&bad).code, 2, "{bad:?}");
    }
    assert_eq!(with(&["--table1", "--sweep", "hash"]).code, 2);
}

#[test]
fn tables_of_another_mesh_are_refused() {
    let (folder, _, built) = built_ball();
    let bytes = std::fs::read(&built).unwrap();
    let json_length = u32::from_le_bytes(bytes[12..16].try_into().unwrap()) as usize;
    // The reference's positions stand at the beginning of the binary chunk; the tables behind them stay as they are.
    let first = 20 + json_length + 8;
    let mut other = bytes.clone();
    other[first..first + 4].copy_from_slice(&0.25f32.to_le_bytes());
    let path = folder.write("other.glb", &other);
    invertex(&["profile", &path, "--table1"]).fails(3, &["other.glb", "another mesh"]);
    invertex(&["profile", &built, "--table1"]).ok();
}
