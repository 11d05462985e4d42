//! The shape of the house, checked: which room may name which, which outside crate belongs to which room, how long a
//! file may be, what lies on the top level, and that no file names a path of somebody's machine.
//!
//! In: the source tree as text. Every check is a function from text to complaints, so that each has a negative
//! control: a text that must be complained about.

use std::fs;
use std::path::{Path, PathBuf};

/// Rooms in reading order: a room may name itself and those above it.
const ROOMS: &str =
    "error gpu mesh scene param lod igt attribute asset render recover measure output cli";

/// Rooms that see less than the order alone would let them: `gpu` knows no mesh, and nothing but errors.
const ONLY: [(&str, &[&str]); 2] = [("gpu", &["error"]), ("mesh", &["error"])];

/// What the crate root re-exports, and where it comes from.
const RE_EXPORTS: [(&str, &str); 2] = [("Error", "error"), ("Result", "error")];

/// Outside crates that only the rooms named may name.
const FENCED: [(&str, &[&str]); 12] = [
    ("gltf", &["scene", "asset"]),
    ("gltf_json", &["scene", "asset"]),
    ("ash", &["gpu"]),
    ("gpu_allocator", &["gpu"]),
    ("meshopt", &["lod"]),
    ("faer", &["param"]),
    ("nv_flip", &["measure"]),
    ("shaderc", &["gpu"]),
    ("exr", &["output", "measure"]),
    ("font8x8", &["output"]),
    ("clap", &["cli", "main"]),
    ("indicatif", &["cli", "main"]),
];

/// Longest source file.
const LINES: usize = 400;

const TOP_LEVEL: &str = "\
    .cargo .ci .git .gitattributes .github .gitignore ARCHITECTURE.md CHANGELOG.md CONTRIBUTING.md Cargo.lock \
    Cargo.toml LICENSE-APACHE LICENSE-MIT README.md SECURITY.md assets benches build build.rs clippy.toml deny.toml \
    fuzz glsl rustfmt.toml schema shared spirv src target tests tools";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn files_under(folder: &Path, into: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let path = entry.path();
        // What is built, and what belongs to version control, is not ours to judge.
        let skip = ["target", ".git", ".cache", "node_modules"]
            .iter()
            .any(|s| path.ends_with(s));
        if path.is_dir() && !path.is_symlink() && !skip {
            files_under(&path, into);
        } else if path.is_file() {
            into.push(path);
        }
    }
}

fn sources(folder: &str) -> Vec<(String, String)> {
    let mut paths = Vec::new();
    files_under(&root().join(folder), &mut paths);
    paths.sort();
    let name = |p: &Path| {
        p.strip_prefix(root())
            .unwrap_or(p)
            .to_string_lossy()
            .replace('\\', "/")
    };
    paths
        .iter()
        .filter_map(|p| Some((name(p), fs::read_to_string(p).ok()?)))
        .collect()
}

/// The room a file of `src/` lies in: `src/mesh/normal.rs` and `src/mesh.rs` lie in `mesh`.
fn room_of(file: &str) -> &str {
    let inside = file.strip_prefix("src/").unwrap_or(file);
    inside
        .split('/')
        .next()
        .unwrap_or(inside)
        .trim_end_matches(".rs")
}

/// Code without line comments, so that prose may name anything.
fn code(text: &str) -> String {
    text.lines()
        .map(|line| line.split("//").next().unwrap_or(""))
        .collect::<Vec<_>>()
        .join("\n")
}

fn is_word(c: char) -> bool {
    c.is_alphanumeric() || c == '_'
}

fn word(text: &str) -> &str {
    &text[..text.find(|c| !is_word(c)).unwrap_or(text.len())]
}

/// First names after `prefix::`, groups `prefix::{a, b::c}` included.
fn named(text: &str, prefix: &str) -> Vec<String> {
    let path = format!("{prefix}::");
    let mut names = Vec::new();
    for (at, _) in text.match_indices(&path) {
        if text[..at]
            .chars()
            .next_back()
            .is_some_and(|c| is_word(c) || c == ':')
        {
            continue;
        }
        let rest = &text[at + path.len()..];
        match rest.strip_prefix('{') {
            Some(group) => names.extend(first_level(group)),
            None => names.push(word(rest).to_owned()),
        }
    }
    names.retain(|n| !n.is_empty());
    names
}

/// The first word of every member of a group, nested groups left out.
fn first_level(group: &str) -> Vec<String> {
    let (mut depth, mut fresh, mut names) = (0, true, Vec::new());
    for (at, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth == 0 => break,
            '}' => depth -= 1,
            ',' if depth == 0 => fresh = true,
            c if depth == 0 && fresh && is_word(c) => {
                names.push(word(&group[at..]).to_owned());
                fresh = false;
            }
            _ => {}
        }
    }
    names
}

fn may_name(room: &str, other: &str) -> bool {
    if room == other {
        return true;
    }
    if let Some((_, only)) = ONLY.iter().find(|(r, _)| *r == room) {
        return only.contains(&other);
    }
    let place = |r: &str| ROOMS.split(' ').position(|known| known == r);
    match (place(room), place(other)) {
        (Some(here), Some(there)) => there < here,
        _ => false,
    }
}

/// Complaints about one file's `crate::` paths.
fn wrong_edges(file: &str, text: &str) -> Vec<String> {
    let room = room_of(file);
    if matches!(room, "lib" | "main") {
        return Vec::new();
    }
    let text = code(text);
    let mut wrong = Vec::new();
    for name in named(&text, "crate")
        .into_iter()
        .chain(named(&text, "invertex"))
    {
        let other = RE_EXPORTS
            .iter()
            .find(|(n, _)| *n == name)
            .map_or(name.as_str(), |(_, from)| from);
        if !may_name(room, other) {
            wrong.push(format!("{file}: {room} names {other}"));
        }
    }
    wrong
}

/// Complaints about one file's use of outside crates.
fn wrong_crates(file: &str, text: &str) -> Vec<String> {
    let text = code(text);
    let room = room_of(file);
    FENCED
        .iter()
        .filter(|(name, rooms)| !rooms.contains(&room) && !named(&text, name).is_empty())
        .map(|(name, rooms)| format!("{file}: only {rooms:?} may name the crate {name}"))
        .collect()
}

fn too_long(file: &str, text: &str) -> Option<String> {
    let lines = text.lines().count();
    (lines > LINES).then(|| format!("{file}: {lines} lines"))
}

/// Complaints about absolute paths of one machine: somebody's home.
fn machine_paths(file: &str, text: &str) -> Vec<String> {
    // Spelled in two halves, or this file would name them.
    let homes = [
        concat!("/ro", "ot/"),
        concat!("/ho", "me/"),
        concat!("/Us", "ers/"),
        concat!("/wo", "rk/"),
        concat!("C:\\", "Users"),
    ];
    homes
        .iter()
        .filter(|home| text.contains(*home))
        .map(|home| format!("{file}: names {home}"))
        .collect()
}

fn none(complaints: Vec<String>) {
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn rooms_import_only_from_above() {
    let files = sources("src");
    assert!(
        files.len() > 20,
        "the source tree was not found: {} files",
        files.len()
    );
    none(files.iter().flat_map(|(f, t)| wrong_edges(f, t)).collect());
}

#[test]
fn every_folder_of_src_is_a_room() {
    let strangers = sources("src").into_iter().filter(|(f, _)| {
        let room = room_of(f);
        !ROOMS.split(' ').any(|known| known == room) && !matches!(room, "lib" | "main")
    });
    none(
        strangers
            .map(|(f, _)| format!("{f}: in no room of the list"))
            .collect(),
    );
}

#[test]
fn a_wrong_edge_is_seen() {
    assert_eq!(
        wrong_edges("src/mesh/mod.rs", "use crate::render::Camera;").len(),
        1
    );
    assert_eq!(
        wrong_edges("src/gpu/mod.rs", "fn f() -> crate::mesh::Mesh { todo() }").len(),
        1
    );
    assert_eq!(
        wrong_edges(
            "src/param/fit.rs",
            "use crate::{mesh::Mesh, lod::{Lod, render}, Error};"
        )
        .len(),
        1
    );
    assert_eq!(
        wrong_edges(
            "src/igt/build.rs",
            "use crate::{\n    mesh::Mesh,\n    render::shade,\n};"
        )
        .len(),
        1
    );
    assert_eq!(
        wrong_edges("src/igt/build.rs", "use invertex::cli;").len(),
        1
    );
    // And the right ones are let through.
    none(wrong_edges(
        "src/igt/build.rs",
        "use crate::{Error, Result, mesh::Mesh, gpu};\nuse crate::igt::Tables;",
    ));
    none(wrong_edges(
        "src/mesh/mod.rs",
        "// the opposite of crate::render::Camera",
    ));
    none(wrong_edges("src/lib.rs", "pub use crate::render::Camera;"));
}

#[test]
fn outside_crates_stay_in_their_rooms() {
    none(
        sources("src")
            .iter()
            .flat_map(|(f, t)| wrong_crates(f, t))
            .collect(),
    );
}

#[test]
fn a_stray_crate_is_seen() {
    assert_eq!(
        wrong_crates("src/render/mod.rs", "let d: ash::Device = x;").len(),
        1
    );
    assert_eq!(wrong_crates("src/lod/mod.rs", "use gltf::Gltf;").len(), 1);
    none(wrong_crates("src/gpu/mod.rs", "use ash::vk;"));
    none(wrong_crates(
        "src/render/mod.rs",
        "let x = splash::colour();",
    ));
}

#[test]
fn files_are_short() {
    let kinds = [".rs", ".glsl", ".comp", ".vert", ".frag"];
    let of_interest = |f: &str| kinds.iter().any(|k| f.ends_with(k));
    let all = ["src", "glsl", "tests", "tools", "benches"]
        .into_iter()
        .flat_map(sources);
    none(
        all.filter(|(f, _)| of_interest(f))
            .filter_map(|(f, t)| too_long(&f, &t))
            .collect(),
    );
    assert!(too_long("src/x.rs", &"line\n".repeat(LINES + 1)).is_some());
    assert!(too_long("src/x.rs", &"line\n".repeat(LINES)).is_none());
}

#[test]
fn the_top_level_holds_what_it_should() {
    let Ok(entries) = fs::read_dir(root()) else {
        panic!("no source tree at {}", root().display())
    };
    let known = |name: &str| TOP_LEVEL.split(' ').any(|k| k == name);
    let names = entries
        .flatten()
        .map(|e| e.file_name().to_string_lossy().into_owned());
    none(
        names
            .filter(|n| !known(n) && n != ".cache")
            .map(|n| format!("{n}: what is it doing on the top level?"))
            .collect(),
    );
    for needed in [
        "README.md",
        "ARCHITECTURE.md",
        "CHANGELOG.md",
        "LICENSE-MIT",
        "LICENSE-APACHE",
        "tools",
        "spirv",
    ] {
        assert!(root().join(needed).exists(), "{needed} is missing");
    }
}

#[test]
fn no_file_names_a_path_of_one_machine() {
    let folders = [
        "src", "glsl", "tests", "tools", "benches", "schema", "build", ".ci", "spirv",
    ];
    let mut texts: Vec<_> = folders.into_iter().flat_map(sources).collect();
    for name in TOP_LEVEL.split(' ').filter(|n| n.contains('.')) {
        if let Ok(text) = fs::read_to_string(root().join(name)) {
            texts.push(((*name).to_owned(), text));
        }
    }
    none(
        texts
            .iter()
            .flat_map(|(f, t)| machine_paths(f, t))
            .collect(),
    );
    assert_eq!(
        machine_paths("x", concat!("see /ho", "me/somebody/models")).len(),
        1
    );
}
