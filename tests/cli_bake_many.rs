//! `bake` of many pairs at once, in cages and tiles, through the real binary.
#![cfg(feature = "cli")]

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, Run, invertex};
use std::path::Path;

fn ball(rings: u32) -> Vec<u8> {
    let ball = Ball {
        rings,
        ..Ball::default()
    };
    ball.glb()
}

fn bake(from: &str, out: &str, more: &[&str]) -> Run {
    let arguments = [
        "bake",
        from,
        "-o",
        out,
        "--json",
        "--device",
        "cpu",
        "--size",
        "32",
        "--attributes",
        "normal",
    ];
    invertex(&[&arguments, more].concat())
}

#[test]
fn a_folder_is_baked_pair_by_pair() {
    let folder = Folder::new();
    let models = folder.at("models");
    std::fs::create_dir(&models).unwrap();
    let write =
        |name: &str, bytes: &[u8]| std::fs::write(format!("{models}/{name}"), bytes).unwrap();
    write("egg_high.glb", &ball(16));
    write("egg_low.glb", &ball(6));
    write("Nut_HP.glb", &ball(12));
    write("Nut_lp.glb", &ball(6));
    write("alone_low.glb", &ball(6));
    write("notes.txt", b"nothing");
    let out = folder.at("out");
    let json = bake(&models, &out, &[]).ok().json();
    let jobs = json["jobs"].as_array().unwrap();
    let names: Vec<&str> = jobs.iter().map(|j| j["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["egg", "nut"]);
    for name in names {
        assert!(Path::new(&format!("{out}/{name}/ball_normal.png")).exists());
        assert!(Path::new(&format!("{out}/{name}/baked.glb")).exists());
    }
    assert!(
        jobs.iter()
            .all(|j| j["filled_fraction"].as_f64().unwrap() > 0.5)
    );
    // With a cage, a job looks from it.
    write("nut_cage.glb", &ball(6));
    let json = bake(&models, &out, &[]).ok().json();
    assert_eq!(
        (&json["jobs"][0]["mapping"], &json["jobs"][1]["mapping"]),
        (&"normal".into(), &"cage".into())
    );
    let empty = folder.at("empty");
    std::fs::create_dir(&empty).unwrap();
    bake(&empty, &out, &[]).fails(3, &["NAME_high.glb"]);
    bake(
        &models,
        &out,
        &["--cage", &format!("{models}/nut_cage.glb")],
    )
    .fails(2, &["LOW"]);
}

#[test]
fn a_manifest_says_what_differs_and_a_fault_keeps_nothing_else_from_being_done() {
    let folder = Folder::new();
    folder.write("high.glb", &ball(16));
    folder.write("low.glb", &ball(6));
    let manifest = |text: &str| folder.write("jobs.json", text.as_bytes());
    let out = folder.at("out");
    let all = manifest(
        r#"{"jobs": [
            {"high": "high.glb", "low": "low.glb", "output": "a", "map": "proximity", "attributes": ["color", "height"], "size": 16},
            {"high": "none.glb", "low": "low.glb", "output": "b"},
            {"high": "high.glb", "low": "low.glb"}
        ]}"#,
    );
    let run = bake(&all, &out, &[]).fails(3, &["none.glb"]);
    let json = run.json();
    assert_eq!(json["jobs"][0]["mapping"], "proximity");
    assert_eq!(json["jobs"][0]["size"], 16);
    assert_eq!(json["jobs"][0]["textures"].as_array().unwrap().len(), 2);
    assert!(
        json["jobs"][1]["error"]
            .as_str()
            .unwrap()
            .contains("none.glb")
    );
    assert_eq!(json["jobs"][2]["name"], "low");
    assert!(Path::new(&format!("{out}/low/ball_normal.png")).exists());
    assert!(!Path::new(&format!("{out}/b")).exists());
    for (text, words) in [
        (r#"{"jobs": []}"#, &["none"][..]),
        (r#"{"jobs": [{"low": "low.glb"}]}"#, &["high"]),
        (r#"{"jobs": [{"high": "high.glb", "sise": 3}]}"#, &["sise"]),
        (r#"{"jobs": 7"#, &["jobs.json"]),
        (
            r#"{"jobs": [{"high": "high.glb", "low": "low.glb", "output": "../x"}]}"#,
            &["../x"],
        ),
        (
            r#"{"jobs": [{"high": "high.glb", "low": "low.glb", "output": "/x"}]}"#,
            &["/x"],
        ),
        (
            r#"{"jobs": [{"high": "high.glb", "low": "low.glb"}, {"high": "low.glb", "low": "low.glb"}]}"#,
            &["job 1", "as job 0"],
        ),
    ] {
        bake(&manifest(text), &folder.at("none"), &[]).fails(3, words);
        assert!(!Path::new(&folder.at("none")).exists());
    }
}

/// What was finished before a fault is there and whole.
#[test]
fn what_is_finished_before_a_fault_stays() {
    let folder = Folder::new();
    let (high, low) = (
        folder.write("high.glb", &ball(16)),
        folder.write("low.glb", &ball(6)),
    );
    let out = folder.at("out");
    std::fs::create_dir(&out).unwrap();
    // Where the second texture should go there is a folder.
    std::fs::create_dir(format!("{out}/ball_height.png")).unwrap();
    let more = ["--attributes", "normal,height,position", "--size", "64"];
    let arguments = ["bake", &high, &low, "-o", &out, "--device", "cpu"];
    invertex(&[&arguments[..], &more].concat()).fails(3, &["ball_height.png"]);
    let image = image::open(format!("{out}/ball_normal.png")).unwrap();
    assert_eq!(image.width(), 64);
    assert!(!Path::new(&format!("{out}/baked.glb")).exists());
    let left = std::fs::read_dir(&out).unwrap().count();
    assert_eq!(left, 2, "nothing half written");
}

/// A disk that is full after the first texture: that one is whole, nothing half written lies about, the message names the file.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_loses_nothing_that_was_finished() {
    let folder = Folder::new();
    let (high, low) = (
        folder.write("high.glb", &ball(16)),
        folder.write("low.glb", &ball(6)),
    );
    let out = folder.at("out");
    // No file may be larger than 16 KiB; the shell leaves it to the program to notice.
    let limited = "trap '' XFSZ; ulimit -f 32; exec \"$@\"";
    let mut command = std::process::Command::new("sh");
    command.args([
        "-c",
        limited,
        "sh",
        env!("CARGO_BIN_EXE_invertex"),
        "bake",
        &high,
        &low,
        "-o",
        &out,
    ]);
    command.args(["--device", "cpu", "--size", "256", "--memory", "0"]);
    command.args(["--attributes", "shadow,normal,height"]);
    let run = cli_support::run(command).fails(3, &["ball_normal.png"]);
    assert!(run.stdout.is_empty());
    let shadow = image::open(format!("{out}/ball_shadow.png")).unwrap();
    assert_eq!(shadow.width(), 256);
    let left = std::fs::read_dir(&out).unwrap().count();
    assert_eq!(left, 1, "the one that was finished, and nothing else");
    // The negative control: without the limit all of it fits.
    let arguments = [
        "bake", &high, &low, "-o", &out, "--device", "cpu", "--size", "256",
    ];
    invertex(&[&arguments[..], &["--attributes", "shadow,normal,height"]].concat()).ok();
    let normal = std::fs::metadata(format!("{out}/ball_normal.png")).unwrap();
    assert!(normal.len() > 32 * 512);
}
