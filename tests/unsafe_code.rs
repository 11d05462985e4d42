//! `unsafe` stands in `src/gpu/`, and in one block beside it: where files are mapped.

use std::fs;
use std::path::{Path, PathBuf};

/// Where `unsafe` may stand besides `gpu/`, and how often; each file says why.
const ELSEWHERE: [(&str, usize); 1] = [("src/scene/mapped.rs", 1)];

fn files_under(folder: &Path, into: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            files_under(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            into.push(path);
        }
    }
}

/// A complaint about `unsafe` in a file outside of the places where it belongs. Comments may name it.
fn stray(file: &str, text: &str) -> Option<String> {
    let code = text
        .lines()
        .map(|line| line.split("//").next().unwrap_or(""));
    let is_word = |c: char| c.is_alphanumeric() || c == '_';
    let count = code
        .flat_map(|line| line.split(|c| !is_word(c)))
        .filter(|word| *word == "unsafe")
        .count();
    let known = ELSEWHERE.iter().find(|(known, _)| *known == file);
    let may = known.map_or(0, |(_, blocks)| *blocks);
    let fenced = file.starts_with("src/gpu/");
    (!fenced && count != may).then(|| format!("{file}: {count} times unsafe where {may} belong"))
}

#[test]
fn unsafe_code_stays_where_it_belongs() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut files = Vec::new();
    files_under(&root.join("src"), &mut files);
    assert!(files.len() > 100, "the source tree was not found");
    let complaints: Vec<String> = files
        .iter()
        .filter_map(|path| {
            let name = path.strip_prefix(root).unwrap().to_string_lossy();
            stray(&name.replace('\\', "/"), &fs::read_to_string(path).unwrap())
        })
        .collect();
    assert!(complaints.is_empty(), "\n{}", complaints.join("\n"));
}

#[test]
fn stray_unsafe_code_is_seen() {
    let block = "let x = unsafe { *p };";
    for (file, text, wrong) in [
        ("src/mesh/mod.rs", block, true),
        ("src/mesh/mod.rs", "// unsafe in words\nunsafe_code", false),
        ("src/gpu/mod.rs", block, false),
        ("src/scene/mapped.rs", block, false),
        // A second block, or none where one is listed: the list is then out of date.
        ("src/scene/mapped.rs", "unsafe {} unsafe {}", true),
        ("src/scene/mapped.rs", "", true),
    ] {
        assert_eq!(stray(file, text).is_some(), wrong, "{file} {text}");
    }
}
