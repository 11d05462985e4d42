//! Ambiguous triangles and mapped tables, through the real binary.

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, invertex};

/// Lines of a CSV file below its names.
fn rows(path: &str) -> Vec<String> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines().map(str::to_owned);
    assert_eq!(lines.next().as_deref(), Some("mesh,triangle"));
    lines.collect()
}

#[test]
fn ambiguous_triangles_are_counted_named_and_listed() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let build = |primary: &str, list: &str| {
        let arguments = [
            "build",
            &model,
            "-o",
            &folder.at("out.glb"),
            "--device",
            "cpu",
            "--lods",
            "0.5",
            "--primary",
            primary,
            "--ambiguous",
            &folder.at(list),
            "--json",
        ];
        invertex(&arguments).ok().json()["meshes"][0].clone()
    };
    // Its chart covers every place once, lines along an axis meet a ball twice.
    let once = build("uv0", "once.csv");
    assert_eq!(once["ambiguous_triangles"], 0);
    assert_eq!(once["ambiguous_area_fraction"], 0.0);
    assert_eq!(rows(&folder.at("once.csv")), [""; 0]);
    let twice = build("plane:z", "twice.csv");
    let listed = rows(&folder.at("twice.csv"));
    let count = twice["ambiguous_triangles"].as_u64().unwrap() as usize;
    assert_eq!(listed.len(), count);
    assert!(count as f64 > 0.9 * twice["triangles"].as_f64().unwrap());
    assert!(twice["ambiguous_area_fraction"].as_f64().unwrap() > 0.9);
    let first = twice["ambiguous_first"].as_array().unwrap();
    assert_eq!(first.len(), count.min(64));
    let name = twice["name"].as_str().unwrap();
    for (row, t) in listed.iter().zip(first) {
        assert_eq!(*row, format!("{name},{t}"));
    }
    let json = invertex(&[
        "inspect",
        &model,
        "--json",
        "--ambiguous",
        &folder.at("seen.csv"),
    ])
    .ok()
    .json();
    assert_eq!(json["meshes"][0]["automatic"]["kind"], "sphere");
    // About its middle only the lower pole may be: the sine of pi is not zero in 32 bits, and the grid rounds it.
    let seen = rows(&folder.at("seen.csv")).len() as u64;
    assert_eq!(json["meshes"][0]["automatic"]["ambiguous_triangles"], seen);
    assert!(seen <= 24, "{seen}");
}

#[test]
fn a_list_that_cannot_be_written_is_told_before_the_work() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let (out, missing) = (folder.at("out.glb"), folder.at("missing/list.csv"));
    invertex(&["build", &model, "-o", &out, "--ambiguous", &missing]).fails(3, &["missing"]);
    invertex(&["inspect", &model, "--ambiguous", &missing]).fails(3, &["missing"]);
    assert_eq!(folder.names(), ["ball.glb"]);
}

#[test]
fn mapped_tables_give_the_same_answers() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let built = folder.at("built.glb");
    invertex(&[
        "build", &model, "-o", &built, "--device", "cpu", "--lods", "0.5",
    ])
    .ok();
    let points = folder.write("points.csv", b"1,0,0\n0,0.5,0.2\n-1,-1,-1\n0,0,9\n");
    let query = |more: &[&str]| {
        let mut arguments = vec!["query", &built, "--points", &points, "--device", "cpu"];
        arguments.extend(more);
        invertex(&arguments)
    };
    let read = query(&[]).ok().stdout;
    assert_eq!(read.lines().count(), 4);
    assert_eq!(query(&["--mapped"]).ok().stdout, read);
    query(&["--mapped", "--mesh", "nobody"]).fails(3, &["nobody"]);
    let plain = ["query", &model, "--points", &points, "--mapped"];
    invertex(&plain).fails(3, &["run build first"]);
}
