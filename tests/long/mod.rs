//! The long forms of tests: every shared model, many more points and inputs. `INVERTEX_LONG=1` switches them on;
//! `tools/test --long` sets it, builds optimised, and gathers the rows that [`proved`] prints.
#![allow(dead_code, unused_macros, reason = "each test file uses a part")]

use invertex::param::PrimaryRequest;
use std::path::PathBuf;

/// Whether the long forms run.
pub(crate) fn long() -> bool {
    std::env::var_os("INVERTEX_LONG").is_some_and(|value| !value.is_empty() && value != "0")
}

/// A count that the variable `name` sets, and otherwise the suite's form.
pub(crate) fn count(name: &str, short: u64, at_length: u64) -> u64 {
    let set = std::env::var(name)
        .ok()
        .and_then(|value| value.parse().ok());
    set.unwrap_or(if long() { at_length } else { short })
}

/// The shared models by short names. All are built with the primary that `auto` picks, but for one that is not
/// one-to-one by it (flat ends of a cylinder): that one by its charts as well.
const MODELS: [(&str, &str); 13] = [
    ("flight_helmet", "flight_helmet/flight_helmet.glb"),
    ("water_bottle", "water_bottle/water_bottle.glb"),
    ("water_bottle_uv", "water_bottle/water_bottle.glb"),
    ("food_apple", "food_apple/food_apple.glb"),
    ("spot", "spot/spot.glb"),
    ("fox", "fox/fox.glb"),
    ("boat", "boat/boat.glb"),
    ("globe_earth", "globe_earth/globe_earth.glb"),
    ("earth_relief", "globe_earth/earth_relief_vertex_colour.glb"),
    ("bunny", "stanford_bunny/bunny.glb"),
    ("bunny_low", "stanford_bunny/bunny_low_uv.glb"),
    ("dragon", "stanford_dragon/dragon.glb"),
    ("dragon_low", "stanford_dragon/dragon_low_uv.glb"),
];

/// The file of a shared model when its long test runs; says why where it does not.
pub(crate) fn model(name: &str) -> Option<PathBuf> {
    if !long() {
        eprintln!("SHORT: {name} is measured with INVERTEX_LONG=1");
        return None;
    }
    found(name)
}

/// The file of a shared model, if it is here; says loudly if not.
pub(crate) fn found(name: &str) -> Option<PathBuf> {
    let (_, file) = MODELS.iter().find(|(short, _)| *short == name).unwrap();
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let folder = std::env::var_os("INVERTEX_MODELS").map_or_else(beside, PathBuf::from);
    let path = folder.join(file);
    if !path.exists() {
        eprintln!("SKIPPED: no {}", path.display());
        return None;
    }
    Some(path)
}

/// The primary that a model is built with.
pub(crate) fn primary(name: &str) -> PrimaryRequest {
    if name.ends_with("_uv") {
        return PrimaryRequest::UvSet(0);
    }
    PrimaryRequest::Auto
}

/// A row of the table that a long run prints.
pub(crate) fn proved(subject: &str, measure: &str, numbers: &str) {
    println!("\nproved | {subject} | {measure} | {numbers}");
}

/// A test for each shared model that calls `check` with its name.
macro_rules! on_every_model {
    ($check:path) => {
        $crate::long::on_every_model! { $check: flight_helmet water_bottle water_bottle_uv food_apple spot fox boat globe_earth earth_relief
            bunny bunny_low dragon dragon_low }
    };
    ($check:path: $($name:ident)*) => {
        $(#[test]
        fn $name() {
            $check(stringify!($name));
        })*
    };
}
#[allow(unused_imports, reason = "each test file uses a part")]
pub(crate) use on_every_model;
