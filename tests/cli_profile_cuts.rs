//! `profile --sweep cuts` through the real binary: what is measured of each cut, triangles at equal FLIP, what is refused.
#![cfg(feature = "cli")]

mod cli_support;
mod glb;
#[path = "long/mod.rs"]
mod long;
mod painted;

use cli_support::{Folder, Run, invertex};
use invertex::asset::{Built, Model};
use invertex::lod::multiresolution::{Criterion, Limits};
use invertex::render::{Camera, Cutter, Projection, reference_sphere};
use serde_json::Value;

/// Two balls, one with cells and one plain, built as `mrm` says.
fn built(mrm: &[&str]) -> (Folder, String) {
    let folder = Folder::new();
    let from = folder.write("painted.glb", &painted::Painted::default().glb());
    let to = folder.at("built.glb");
    let arguments = ["build", &from, "-o", &to, "--device", "cpu"];
    invertex(&[&arguments, mrm].concat()).ok();
    (folder, to)
}

fn profile(file: &str, more: &[&str]) -> Run {
    profile_sized(file, "96", more)
}

fn profile_sized(file: &str, size: &str, more: &[&str]) -> Run {
    let quick = ["profile", file, "--device", "cpu", "--size", size];
    let few = ["--frames", "2", "--warm-up", "0", "--bake-size", "64"];
    invertex(&[&quick[..], &few, more].concat())
}

const SWEEP: [&str; 6] = [
    "--sweep",
    "cuts",
    "--distances",
    "1,3",
    "--pixels",
    "0.125,0.5,2",
];

fn number(row: &Value, key: &str) -> f64 {
    row[key]
        .as_f64()
        .unwrap_or_else(|| panic!("{key} of {row}"))
}

#[test]
fn cuts_are_measured_by_what_decides_them() {
    let (folder, built) = built(&["--mrm"]);
    let out = folder.at("report");
    let more = [&SWEEP[..], &["--colours", "3", "-o", &out, "--json"]].concat();
    let json = profile(&built, &more).ok().json();
    let cuts = json["cuts"].as_array().unwrap();
    assert_eq!(cuts.len(), 2 * 3 * 3);
    for cut in cuts {
        let (pixels, bound) = (number(cut, "pixels"), number(cut, "bound_pixels"));
        let most = cut["displaced"]["max"].as_f64().unwrap();
        // Corners are drawn on a grid of a sixteenth of a pixel.
        assert!(most <= bound + 0.045, "{cut}");
        assert!(
            cut["criterion"] != "pixels" || bound <= pixels * 1.00001,
            "{cut}"
        );
        assert_eq!(
            cut["criterion"] == "pixels+colour",
            !cut["colour"].is_null()
        );
        assert!(number(cut, "triangles") <= number(cut, "reference_triangles"));
        assert!(number(cut, "asked") > 0.0 && number(cut, "selection_ns_median") > 0.0);
        assert!(number(cut, "flip_mean") < 0.5 && number(cut, "compared_pixels") > 100.0);
        assert!(cut["device_selection_ns_median"].is_null(), "the processor");
    }
    let of = |criterion: &str, distance: f64| -> Vec<f64> {
        let cuts = cuts.iter().filter(|c| c["criterion"] == criterion);
        let cuts = cuts.filter(|c| c["distance"] == distance);
        cuts.map(|c| number(c, "triangles")).collect()
    };
    for distance in [1.0, 3.0] {
        let [surface, pixels, colour] =
            ["surface", "pixels", "pixels+colour"].map(|c| of(c, distance));
        assert!(pixels.is_sorted_by(|a, b| a >= b), "{pixels:?}");
        assert!(
            surface.iter().zip(&pixels).all(|(s, p)| s <= p),
            "{surface:?} {pixels:?}"
        );
        assert!(
            colour.iter().zip(&pixels).all(|(c, p)| c <= p),
            "{colour:?} {pixels:?}"
        );
        assert!(
            colour[0] < pixels[0],
            "one ball is plain: {colour:?} {pixels:?}"
        );
    }
    let equal = json["equal_flip"].as_array().unwrap();
    assert_eq!(equal.len(), 2 * 3);
    for row in equal {
        assert_eq!(row["colours"][0]["colour"], 3.0);
        assert!(number(row, "flip") < 0.5 && number(row, "triangles") > 0.0);
    }
    let page = std::fs::read_to_string(format!("{out}/profile.html")).unwrap();
    for words in [
        "FLIP over triangles, distance 3",
        "Triangles at equal FLIP",
        "pixels+colour 3",
    ] {
        assert!(page.contains(words), "{words}");
    }
    let text = profile(&built, &[&SWEEP[..], &["--colours", "3"]].concat())
        .ok()
        .stdout;
    assert!(
        text.contains("Triangles at equal FLIP") && text.contains("surface"),
        "{text}"
    );
}

#[test]
fn what_cannot_be_cut_is_said() {
    let (_folder, plain) = built(&[]);
    profile(&plain, &SWEEP).fails(3, &["built.glb", "--mrm"]);
    let (_folder, geometry) = built(&["--mrm=geometry"]);
    let json = profile(&geometry, &[&SWEEP[..], &["--json"]].concat())
        .ok()
        .json();
    // Without colours there is nothing to limit, unless it is asked for.
    assert_eq!(json["cuts"].as_array().unwrap().len(), 2 * 2 * 3);
    profile(&geometry, &[&SWEEP[..], &["--colours", "2"]].concat())
        .fails(2, &["--colours", "what colours are off by"]);
    for bad in ["-1", "nan", "inf"] {
        profile(&geometry, &["--sweep", "cuts", "--pixels", bad])
            .fails(2, &["--pixels", "no limit"]);
        profile(&geometry, &["--sweep", "cuts", "--colours", bad])
            .fails(2, &["--colours", "no limit"]);
    }
    assert_eq!(
        profile(&geometry, &["--sweep", "cuts", "--pixels", "x"]).code,
        2
    );
}

/// Triangles of the cut on either side of x = 0: on the plain half, and on the other.
fn halves(built: &Built, camera: &Camera, colour: Option<f64>) -> [usize; 2] {
    let limits = Limits {
        criterion: colour.map_or(Criterion::Displacement, Criterion::Colour),
        ..Limits::default()
    };
    let cuts = Cutter::new(built).unwrap().cut(camera, &limits).unwrap();
    let lod = cuts.lods[0].as_ref().unwrap();
    let is_plain = |t: &&[u32; 3]| t.iter().all(|&v| lod.positions[v as usize][0] <= 0.0);
    let plain = lod.triangles.iter().filter(is_plain).count();
    [plain, lod.triangles.len() - plain]
}

/// The colour criterion saves where nothing is to be seen, and there alone; the pictures are as good.
#[test]
fn the_plain_half_takes_half_of_the_triangles_or_less() {
    let folder = Folder::new();
    let cells = long::count("INVERTEX_CELLS", 64, 128) as u32;
    let from = folder.write("halves.glb", &painted::halves(cells));
    let to = folder.at("built.glb");
    let primary = ["--primary", "uv0", "--mrm=lab", "--device", "cpu"];
    invertex(&[&["build", &from, "-o", &to][..], &primary].concat()).ok();
    let size = "1024";
    let front = ["--view", "0,0", "--distances", "1,2,4", "--json"];
    let pixels = match long::long() {
        true => ".0625,.125,.25,.5,1,2,4",
        false => ".5",
    };
    let more = ["--sweep", "cuts", "--colours", "2", "--pixels", pixels];
    let json = profile_sized(&to, size, &[&front[..], &more].concat());
    let json = json.ok().json();
    let Model::Built(built) = Model::load(to.as_ref()).unwrap() else {
        panic!("it was built");
    };
    let (centre, radius) = reference_sphere(&built.scene).unwrap();
    for distance in [1.0, 2.0, 4.0] {
        let projection = Projection::Perspective;
        let size = [1024; 2];
        let camera =
            Camera::framed_from(distance, centre, radius, [0.0; 2], projection, size).unwrap();
        let [plain, rest] = halves(&built, &camera, None);
        let [saved, kept] = halves(&built, &camera, Some(2.0));
        let at = |criterion: &str| {
            let of = |c: &&Value| {
                c["criterion"] == criterion && c["pixels"] == 0.5 && c["distance"] == distance
            };
            json["cuts"].as_array().unwrap().iter().find(of).unwrap()
        };
        let flip = ["pixels", "pixels+colour"].map(|criterion| number(at(criterion), "flip_mean"));
        let numbers = format!(
            "distance {distance}: plain half {plain} -> {saved}, the other {rest} -> {kept}; FLIP {:.4} -> {:.4}",
            flip[0], flip[1]
        );
        long::proved("half plain", "triangles, .5 px, 2 Delta E", &numbers);
        for row in json["equal_flip"].as_array().unwrap() {
            if row["distance"] == distance {
                long::proved("half plain", "at equal FLIP", &row.to_string());
            }
        }
        // Farther away few are needed anyhow: most of them where the plain half meets the other, since a collapse is as colourful as
        // all that it depends on.
        let factor = if distance == 1.0 { 2.0 } else { 1.0 };
        assert!(saved as f64 * factor < plain as f64, "{numbers}");
        assert!(kept * 10 > rest * 9, "{numbers}");
        assert!(flip[1] <= flip[0] + 1e-3, "{numbers}");
    }
}
