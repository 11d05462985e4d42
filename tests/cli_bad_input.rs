//! Bad input, through the real binary: a one-line error that names the thing, the right exit code, nothing half
//! written. Each check has its twin that succeeds, so none passes because everything fails.

mod cli_support;
mod glb;

use cli_support::{Ball, Folder, built_ball, command, invertex, run};

#[test]
fn files_that_are_missing_or_are_not_models() {
    let folder = Folder::new();
    let out = folder.at("out.glb");
    let missing = folder.at("missing.glb");
    for verb in [
        vec!["inspect", &missing],
        vec!["build", &missing, "-o", &out],
        vec!["query", &missing, "--points", "-"],
    ] {
        invertex(&verb).fails(3, &["missing.glb", "No such file"]);
    }
    let good = Ball::default().glb();
    let text = folder.write("text.glb", b"hello, this is not a model");
    invertex(&["build", &text, "-o", &out]).fails(3, &["text.glb", "not glTF"]);
    let empty = folder.write("empty.glb", b"");
    invertex(&["inspect", &empty]).fails(3, &["empty.glb", "empty"]);
    let cut = folder.write("cut.glb", &good[..good.len() / 2]);
    invertex(&["build", &cut, "-o", &out]).fails(3, &["cut.glb"]);
    let here = folder.path().display().to_string();
    invertex(&["inspect", &here]).fails(3, &["not a plain file"]);
    assert_eq!(
        folder.names(),
        ["cut.glb", "empty.glb", "text.glb"],
        "nothing was written"
    );
}

#[test]
fn models_that_cannot_be_built() {
    let folder = Folder::new();
    let out = folder.at("out.glb");
    let build = |name: &str, bytes: &[u8], more: &[&str]| {
        let model = folder.write(name, bytes);
        invertex(&[&["build", &model, "-o", &out, "--device", "cpu"], more].concat())
    };
    let nan = Ball {
        poison: Some(f32::NAN),
        ..Ball::default()
    }
    .glb();
    build("nan.glb", &nan, &[]).fails(3, &["nan.glb", "accessors[0]", "not finite"]);
    let bare = Ball {
        uv: false,
        ..Ball::default()
    }
    .glb();
    build("bare.glb", &bare, &["--primary", "uv0"])
        .fails(3, &["ball", "no uv set 0", "--primary sphere"]);
    build("sphere.glb", &bare, &["--primary", "sphere"]).ok();
    let none = cli_support::container(r#"{"asset":{"version":"2.0"}}"#, &[]);
    std::fs::remove_file(&out).unwrap();
    build("none.glb", &none, &[]).fails(3, &["none.glb", "no triangles"]);
    assert!(!std::path::Path::new(&out).exists());
}

#[test]
fn options_out_of_range() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let out = folder.at("out.glb");
    let with = |more: &[&str]| {
        invertex(&[&["build", &model, "-o", &out, "--device", "cpu"], more].concat())
    };
    for hash in [
        "0",
        "-1",
        "1000",
        "16384",
        "4294967295",
        "99999999999999",
        "x",
        "",
    ] {
        with(&["--hash", hash]).fails(2, &["--hash"]);
    }
    for lods in ["0", "1", "1.5", "-0.2", "nan", "x", ""] {
        with(&["--lods", lods]).fails(2, &["--lods"]);
    }
    for primary in [
        "cube",
        "sphere:1,2",
        "cylinder:w",
        "uv",
        "ball=cube",
        "nobody=sphere",
    ] {
        with(&["--primary", primary]).fails(2, &["--primary"]);
    }
    assert_eq!(with(&["--layout", "loose"]).code, 2);
    assert_eq!(invertex(&["build", &model]).code, 2, "an output is needed");
    assert_eq!(invertex(&["dance"]).code, 2);
    assert_eq!(folder.names(), ["ball.glb"]);
}

#[test]
fn outputs_that_cannot_be_written() {
    let (folder, model, built) = built_ball();
    let gone = folder.at("gone/out.glb");
    invertex(&["build", &model, "-o", &gone, "--device", "cpu"])
        .fails(3, &["gone", "does not exist"]);
    let image = folder.at("gone/out.png");
    invertex(&["render", &built, "-o", &image, "--device", "cpu"])
        .fails(3, &["gone", "does not exist"]);
    invertex(&["build", &model, "-o", &model, "--device", "cpu"]).fails(2, &["-o", "is the input"]);
    invertex(&["build", &model, "-o", &folder.at("out.obj")]).fails(2, &["-o", ".glb"]);
    invertex(&["build", &model, "-o", &folder.at("out")]).fails(2, &["-o", ".glb"]);
    invertex(&["render", &built, "-o", &folder.at("out.gif")]).fails(2, &["-o", ".png"]);
    invertex(&["render", &built, "-o", &folder.at("out.png"), "--aov"]).fails(2, &["--aov"]);
    let file = folder.write("file", b"");
    invertex(&["demo", &file]).fails(3, &["is a file"]);
    assert_eq!(folder.names(), ["ball.glb", "built.glb", "file"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk() {
    if !std::path::Path::new("/dev/full").exists() {
        return println!("SKIPPED: no /dev/full here");
    }
    let (_folder, model, built) = built_ball();
    // As a link, so that the name can end as it must.
    let link = |name: &str, folder: &Folder| {
        std::os::unix::fs::symlink("/dev/full", folder.path().join(name)).unwrap();
        folder.at(name)
    };
    let full = Folder::new();
    let out = link("full.glb", &full);
    invertex(&["build", &model, "-o", &out, "--device", "cpu"]).fails(3, &["full.glb", "no space"]);
    let image = link("full.png", &full);
    invertex(&[
        "render", &built, "-o", &image, "--device", "cpu", "--size", "32",
    ])
    .fails(3, &["full.png", "no space"]);
    assert_eq!(
        full.names(),
        ["full.glb", "full.png"],
        "nothing lies beside them"
    );
    let mut to_full = command(&["inspect", &model, "--json"]);
    to_full.stdout(
        std::fs::OpenOptions::new()
            .write(true)
            .open("/dev/full")
            .unwrap(),
    );
    run(to_full).fails(3, &["standard output"]);
}

#[test]
fn tables_that_were_tampered_with() {
    let (folder, _, built) = built_ball();
    let good = std::fs::read(&built).unwrap();
    invertex(&[
        "query",
        &built,
        "--points",
        &folder.write("p.csv", b"0.5,0.5\n0,1,0\n"),
        "--device",
        "cpu",
    ])
    .fails(3, &["line"]);
    let mut refused = 0;
    // One bit at a time through the second half of the file, where the appended tables lie.
    for k in 0..40 {
        let mut bad = good.clone();
        let at = good.len() / 2 + k * (good.len() / 2 - 8) / 40;
        bad[at] ^= 0x40;
        let path = folder.write("bad.glb", &bad);
        let out = invertex(&[
            "render",
            &path,
            "-o",
            &folder.at("x.png"),
            "--mode",
            "igt",
            "--size",
            "16",
            "--device",
            "cpu",
        ]);
        assert!(
            [0, 3].contains(&out.code),
            "byte {at}: {} {}",
            out.code,
            out.stderr
        );
        refused += usize::from(out.code == 3);
    }
    assert!(refused > 10, "only {refused} of 40 changes were noticed");
}

#[test]
fn devices_that_are_not_there() {
    let folder = Folder::new();
    let model = folder.write("ball.glb", &Ball::default().glb());
    let out = folder.at("out.glb");
    let without_vulkan = |arguments: &[&str]| {
        let mut command = command(arguments);
        command
            .env("VK_DRIVER_FILES", "/nonexistent/icd.json")
            .env("VK_ICD_FILENAMES", "/nonexistent/icd.json");
        run(command)
    };
    without_vulkan(&["build", &model, "-o", &out, "--device", "0"])
        .fails(4, &["no usable Vulkan device", "--device cpu"]);
    without_vulkan(&["build", &model, "-o", &out, "--device", "GeForce"])
        .fails(4, &["no usable Vulkan device"]);
    assert_eq!(folder.names(), ["ball.glb"]);
    let doctor = without_vulkan(&["doctor", "--json"]).fails(4, &["install"]);
    assert_eq!(doctor.json()["devices"], serde_json::json!([]));
    assert!(
        doctor.json()["advice"][0]
            .as_str()
            .unwrap()
            .contains("install")
    );
    // `auto` says so and does the work all the same.
    let auto = without_vulkan(&["build", &model, "-o", &out]).ok();
    assert!(
        auto.stderr.contains("note: no usable Vulkan device"),
        "{}",
        auto.stderr
    );
    without_vulkan(&[
        "render",
        &out,
        "-o",
        &folder.at("a.png"),
        "--size",
        "32",
        "--quiet",
    ])
    .ok();
}

#[test]
fn questions_that_make_no_sense() {
    let (folder, model, built) = built_ball();
    let points = folder.write("points.csv", b"0.5,0.5\nu,v\n");
    let uv = folder.at("uv.glb");
    invertex(&[
        "build",
        &model,
        "-o",
        &uv,
        "--primary",
        "uv0",
        "--device",
        "cpu",
    ])
    .ok();
    invertex(&["query", &uv, "--points", &points, "--device", "cpu"])
        .fails(3, &["points.csv", "line 2", "\"u\""]);
    invertex(&["query", &model, "--points", &points])
        .fails(3, &["ball.glb", "run `invertex build`"]);
    invertex(&["query", &uv, "--points", &points, "--mesh", "cube"]).fails(3, &["cube", "ball"]);
    invertex(&["render", &model, "-o", &folder.at("a.png"), "--mode", "igt"])
        .fails(3, &["ball.glb", "run `invertex build`"]);
    invertex(&[
        "render",
        &built,
        "-o",
        &folder.at("a.png"),
        "--mode",
        "igt",
        "--lod",
        "9",
    ])
    .fails(2, &["--lod", "0", "2"]);
    invertex(&["render", &built, "-o", &folder.at("a.png"), "--lod", "1"]).fails(2, &["--lod"]);
    invertex(&["build", &built, "-o", &folder.at("again.glb")]).fails(3, &["built.glb", "already"]);
    let two = Ball {
        names: vec!["left".into(), "right".into()],
        ..Ball::default()
    };
    let pair = folder.write("pair.glb", &two.glb());
    invertex(&[
        "build",
        &pair,
        "-o",
        &folder.at("p.glb"),
        "--primary",
        "uv0",
        "--device",
        "cpu",
    ])
    .ok();
    invertex(&["query", &folder.at("p.glb"), "--points", &points])
        .fails(2, &["--mesh", "left, right"]);
    let camera = folder.write(
        "camera.json",
        b"{\"width\": 4, \"height\": 4, \"views\": []}",
    );
    invertex(&[
        "render",
        &built,
        "-o",
        &folder.at("views"),
        "--camera",
        &camera,
    ])
    .fails(3, &["camera.json", "views"]);
    assert!(!folder.names().contains(&"views".to_owned()));
}
