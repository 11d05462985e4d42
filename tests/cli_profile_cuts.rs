//! `profile --sweep cuts` through the real binary: what is measured of each cut, triangles at equal FLIP, what is refused.
#![cfg(feature = "cli")]

mod cli_support;
mod glb;
mod painted;

use cli_support::{Folder, Run, invertex};
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
    let quick = [
        "profile",
        file,
        "--device",
        "cpu",
        "--size",
        "96",
        "--frames",
        "2",
        "--warm-up",
        "0",
        "--bake-size",
        "64",
    ];
    invertex(&[&quick, more].concat())
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
