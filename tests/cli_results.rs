//! Results, through the real binary: the fields that others rely on, the figures that must hold, pictures and tables
//! that repeat.

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, command, invertex, run};
use serde_json::Value;

fn has(object: &Value, keys: &[&str]) {
    for key in keys {
        assert!(!object[key].is_null(), "{key} is missing in {object:#}");
    }
}

#[test]
fn inspect_says_what_fits() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let json = invertex(&["inspect", &model, "--json"]).ok().json();
    let mesh = &json["meshes"][0];
    has(
        mesh,
        &[
            "name",
            "triangles",
            "vertices",
            "uv_sets",
            "primary",
            "automatic",
        ],
    );
    has(
        &mesh["uv_sets"][0],
        &["charts", "overlap_fraction", "inside_unit_square"],
    );
    assert_eq!(mesh["uv_sets"][0]["set"], 0);
    for primary in mesh["primary"].as_array().unwrap() {
        has(primary, &["kind", "bijective", "turned_fraction"]);
    }
    let sphere = mesh["primary"]
        .as_array()
        .unwrap()
        .iter()
        .find(|p| p["kind"] == "sphere")
        .unwrap();
    assert_eq!(
        (&sphere["bijective"], sphere["turned_fraction"].as_f64()),
        (&Value::Bool(true), Some(0.0))
    );
    assert_eq!(
        mesh["automatic"]["kind"], "sphere",
        "a bumpy ball is star-shaped"
    );
    let table = invertex(&["inspect", &model]).ok().stdout;
    assert!(table.contains("sphere") && !table.contains('{'));
}

#[test]
fn progressive_levels_say_how_far_detail_is_displaced() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let built = folder.at("built.glb");
    let arguments = ["build", &model, "-o", &built, "--device", "cpu", "--json"];
    let progressive = ["--simplifier", "progressive", "--lods", "0.5,0.2"];
    let json = invertex(&[&arguments[..], &progressive[..]].concat())
        .ok()
        .json();
    let number = |v: &Value| v.as_f64().unwrap();
    let lods = json["meshes"][0]["lods"].as_array().unwrap();
    for lod in lods {
        let [bound, far] = ["deviation_bound", "deviation_max"].map(|key| number(&lod[key]));
        assert!(
            far > 0.0 && far <= bound && bound < 0.5,
            "{far} and {bound}"
        );
        assert_eq!(
            (number(&lod["turned"]), &lod["reached"]),
            (0.0, &Value::Bool(true))
        );
    }
    assert!(number(&lods[0]["deviation_bound"]) < number(&lods[1]["deviation_bound"]));
    // By the surface alone: a bound all the same.
    let quadric = ["--simplifier", "progressive:quadric", "--lods", "0.2"];
    let json = invertex(&[&arguments[..], &quadric[..]].concat())
        .ok()
        .json();
    let lod = &json["meshes"][0]["lods"][0];
    assert!(number(&lod["deviation_max"]) <= number(&lod["deviation_bound"]));
    let wrong = ["--simplifier", "magic"];
    assert_eq!(invertex(&[&arguments[..], &wrong[..]].concat()).code, 2);
}

#[test]
fn build_reports_and_repeats() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let build = |name: &str| {
        let arguments = [
            "build",
            &model,
            "-o",
            &folder.at(name),
            "--device",
            "cpu",
            "--lods",
            "0.5,0.2",
            "--json",
        ];
        invertex(&arguments).ok().json()
    };
    let json = build("a.glb");
    let mesh = &json["meshes"][0];
    has(
        mesh,
        &[
            "name",
            "triangles",
            "primary",
            "hash",
            "layout",
            "entries",
            "mean_list",
            "max_list",
            "tables_sha256",
        ],
    );
    has(mesh, &["ambiguous_fraction", "bytes", "lods"]);
    has(
        &mesh["bytes"],
        &["hash", "list", "triangle", "attribute", "total"],
    );
    has(
        &json["build_ms"],
        &["load", "primary", "lods", "tables", "write", "total"],
    );
    let lods = mesh["lods"].as_array().unwrap();
    assert_eq!(lods.len(), 2);
    let number = |v: &Value| v.as_f64().unwrap();
    assert!(number(&lods[0]["triangles"]) > number(&lods[1]["triangles"]));
    assert!(number(&lods[0]["deviation_max"]) < number(&lods[1]["deviation_max"]));
    assert!(
        number(&lods[1]["deviation_max"]) < 0.5,
        "a ball of radius 1 stays one"
    );
    assert!(lods[0]["deviation_bound"].is_null());
    let again = build("b.glb");
    assert_eq!(mesh["tables_sha256"], again["meshes"][0]["tables_sha256"]);
    assert_eq!(
        std::fs::read(folder.at("a.glb")).unwrap(),
        std::fs::read(folder.at("b.glb")).unwrap()
    );
}

#[test]
fn each_mesh_may_have_its_own_primary() {
    let folder = Folder::new();
    let two = Ball {
        names: vec!["left".into(), "right".into()],
        ..Ball::default()
    };
    let model = folder.write("pair.glb", &two.glb());
    let out = folder.at("out.glb");
    let arguments = [
        "build",
        &model,
        "-o",
        &out,
        "--device",
        "cpu",
        "--primary",
        "uv0",
        "--primary",
        "right=cylinder:y",
    ];
    let json = invertex(&[&arguments[..], &["--json"]].concat())
        .ok()
        .json();
    assert_eq!(json["meshes"][0]["primary"], "uv0");
    assert_eq!(json["meshes"][1]["primary"], "cylinder:y");
}

#[test]
fn query_answers_in_order_and_reads_back() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let out = folder.at("out.glb");
    invertex(&[
        "build",
        &model,
        "-o",
        &out,
        "--primary",
        "uv0",
        "--device",
        "cpu",
    ])
    .ok();
    let points = folder.write("points.csv", b"u,v\n# the middle\n0.5,0.5\n\n0.001,0.001\n");
    let query = |more: &[&str]| {
        invertex(
            &[
                &["query", &out, "--points", &points, "--device", "cpu"],
                more,
            ]
            .concat(),
        )
        .ok()
    };
    let csv = query(&[]).stdout;
    let rows: Vec<Vec<f64>> = csv
        .lines()
        .map(|l| l.split(',').map(|x| x.parse().unwrap()).collect())
        .collect();
    assert_eq!(rows.len(), 2);
    assert!(
        rows[0][0] >= 0.0 && (rows[0][1] + rows[0][2] + rows[0][3] - 1.0).abs() < 1e-5,
        "{csv}"
    );
    assert_eq!(rows[1][0], -1.0, "outside the chart");
    assert!(rows.iter().all(|row| row[4] >= 1.0));
    let nearest = query(&["--nearest", "--json"]).json();
    has(
        &nearest,
        &[
            "mesh",
            "primary",
            "points",
            "mapped",
            "mean_fetches",
            "results",
        ],
    );
    assert_eq!(nearest["results"][0]["hit"], true);
    let mut piped = command(&["query", &out, "--points", "-", "--device", "cpu"]);
    piped.stdin(std::fs::File::open(&points).unwrap());
    assert_eq!(run(piped).ok().stdout, csv);
}

#[test]
fn a_lod_looks_like_the_reference_and_pictures_repeat() {
    let folder = Folder::new();
    let model = folder.write(
        "ball.glb",
        &Ball {
            rings: 24,
            ..Ball::default()
        }
        .glb(),
    );
    let out = folder.at("out.glb");
    invertex(&[
        "build", &model, "-o", &out, "--device", "cpu", "--lods", "0.5,0.1",
    ])
    .ok();
    let render = |name: &str, more: &[&str]| {
        let path = folder.at(name);
        let first = [
            "render", &out, "-o", &path, "--device", "cpu", "--size", "96x64", "--json",
        ];
        invertex(&[&first[..], more].concat()).ok().json()["images"][0].clone()
    };
    let reference = render("reference.png", &[]);
    has(
        &reference,
        &[
            "path",
            "triangles",
            "covered_pixels",
            "mean_fetches",
            "sha256",
        ],
    );
    assert_eq!(
        (&reference["width"], &reference["height"]),
        (&96.into(), &64.into())
    );
    assert_eq!(reference["sha256"], render("again.png", &[])["sha256"]);
    let zero = render("zero.png", &["--mode", "igt", "--lod", "0"]);
    let coarse = render("coarse.png", &["--mode", "igt", "--lod", "2"]);
    assert!(coarse["triangles"].as_u64() < zero["triangles"].as_u64());
    assert!(coarse["mean_fetches"].as_f64().unwrap() > 1.0);
    let compare = |name: &str, more: &[&str]| {
        let paths = [folder.at("reference.png"), folder.at(name)];
        invertex(&[&["compare", &paths[0], &paths[1], "--json"], more].concat())
    };
    let same = compare("zero.png", &[]).ok().json();
    assert!(
        same["psnr_db"].as_f64().unwrap_or(f64::INFINITY) > 60.0,
        "{same}"
    );
    let far = compare("coarse.png", &[]).ok().json();
    has(
        &far,
        &["flip_mean", "flip_max", "psnr_db", "differing_pixels"],
    );
    assert!(far["flip_mean"].as_f64() > same["flip_mean"].as_f64());
    assert_eq!(
        compare("again.png", &["--identical"]).ok().json()["psnr_db"],
        Value::Null
    );
    compare("coarse.png", &["--identical"]).fails(5, &["pixels differ"]);
    compare("coarse.png", &["--max-flip", "0.000001"]).fails(5, &["FLIP"]);
    let few = render("few.png", &["--mode", "igt", "--lod", "pixels:100000"]);
    assert_eq!(few["lod"], 2);
    assert_eq!(
        render("fine.png", &["--mode", "igt", "--lod", "pixels:0"])["lod"],
        0
    );
    assert_eq!(
        render(
            "half.png",
            &["--mode", "plain", "--lod", "triangles:1000000"]
        )["lod"],
        0
    );
    let opaque = render("grey.png", &["--background", "#808080"]);
    assert_eq!(opaque["covered_pixels"], reference["covered_pixels"]);
    assert!(
        image::open(folder.at("grey.png"))
            .unwrap()
            .into_rgba8()
            .pixels()
            .all(|p| p.0[3] == 255)
    );
}

#[test]
fn a_camera_file_draws_its_views_into_a_folder() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let view = "[[1,0,0,0],[0,1,0,0],[0,0,1,-3],[0,0,0,1]]";
    let projection = "[[0.8,0,0,0],[0,-0.8,0,0],[0,0,-0.2,0],[0,0,0,1]]";
    let one = |name: &str| format!("{{{name}\"view\":{view},\"projection_vulkan\":{projection}}}");
    let json = format!(
        "{{\"width\":40,\"height\":30,\"views\":[{},{}]}}",
        one("\"name\":\"front\","),
        one("")
    );
    let camera = folder.write("camera.json", json.as_bytes());
    let out = folder.at("views");
    let json = invertex(&[
        "render", &model, "-o", &out, "--camera", &camera, "--device", "cpu", "--json",
    ])
    .ok()
    .json();
    assert_eq!(json["images"].as_array().unwrap().len(), 2);
    let first = std::fs::read(folder.path().join("views/front.png")).unwrap();
    assert_eq!(
        first,
        std::fs::read(folder.path().join("views/view_01.png")).unwrap()
    );
    assert!(json["images"][0]["covered_pixels"].as_u64().unwrap() > 100);
    let same = invertex(&["compare", &out, &out, "--json"]).ok().json();
    assert_eq!(
        (&same["psnr_db"], same["images"].as_array().unwrap().len()),
        (&Value::Null, 2)
    );
}

#[test]
fn exr_holds_the_layers() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let path = folder.at("a.exr");
    invertex(&[
        "render", &model, "-o", &path, "--aov", "--device", "cpu", "--size", "48",
    ])
    .ok();
    let meta = exr::meta::MetaData::read_from_file(&path, false).unwrap();
    let names: Vec<String> = meta.headers[0]
        .channels
        .list
        .iter()
        .map(|c| c.name.to_string())
        .collect();
    for name in [
        "R",
        "A",
        "triangle.id",
        "barycentric.z",
        "fetches.count",
        "depth.Z",
    ] {
        assert!(names.contains(&name.to_owned()), "{names:?}");
    }
    let png = folder.at("a.png");
    invertex(&[
        "render", &model, "-o", &png, "--device", "cpu", "--size", "48",
    ])
    .ok();
    let apart = invertex(&["compare", &path, &png, "--json"]).ok().json();
    assert!(
        apart["max_channel_difference"].as_u64().unwrap() <= 1,
        "the same picture in both formats: {apart}"
    );
}
