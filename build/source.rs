//! Finds the shaders and hashes them. In: the folder `glsl/`. Out: one [`Source`] per `<stage>/<pass>.<extension>`,
//! sorted by path, with the sha256 of its text and of everything it includes.

use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;

/// One shader to compile.
pub(crate) struct Source {
    /// Path from the crate's root, with `/`: `glsl/igt/bounds.comp`.
    pub path: String,
    /// `<stage>_<pass>`: the name of its Rust module.
    pub name: String,
    /// `comp`, `vert` or `frag`.
    pub extension: String,
    /// The text of the file.
    #[cfg_attr(not(feature = "compile-shaders"), allow(dead_code))]
    pub text: String,
    /// sha256 over the names and texts of the file and of its includes, sorted by name.
    pub sha256: String,
}

impl Source {
    /// Where the compiled shader is kept.
    pub(crate) fn binary_path(&self) -> String {
        format!("spirv/{}.{}.spv", self.name, self.extension)
    }
}

/// Every shader under `root`, sorted by path. A folder deeper than one level holds no passes.
pub(crate) fn find(root: &str) -> Result<Vec<Source>, String> {
    let mut sources = Vec::new();
    for stage in entries(root)? {
        let folder = format!("{root}/{stage}");
        if !fs::metadata(&folder).is_ok_and(|metadata| metadata.is_dir()) {
            continue;
        }
        for file in entries(&folder)? {
            if let Some((pass, extension @ ("comp" | "vert" | "frag"))) = file.rsplit_once('.') {
                sources.push(source(root, &stage, pass, extension)?);
            }
        }
    }
    sources.sort_by(|a, b| a.path.cmp(&b.path));
    Ok(sources)
}

fn source(root: &str, stage: &str, pass: &str, extension: &str) -> Result<Source, String> {
    let path = format!("{root}/{stage}/{pass}.{extension}");
    let mut texts = BTreeMap::new();
    gather(root, &path, &mut texts)?;
    let mut hash = Sha256::new();
    for (name, text) in &texts {
        hash.update(format!("{name}\n{}\n", text.len()));
        hash.update(text);
    }
    let text = texts.remove(&path).unwrap_or_default();
    Ok(Source {
        name: format!("{stage}_{pass}"),
        extension: extension.to_owned(),
        text,
        sha256: hex(&hash.finalize()),
        path,
    })
}

/// The text of `path` and of all it includes, directly or not. Conditional includes count: a hash that changes too
/// often is harmless, one that changes too rarely is not.
fn gather(root: &str, path: &str, texts: &mut BTreeMap<String, String>) -> Result<(), String> {
    if texts.contains_key(path) {
        return Ok(());
    }
    let text = read(path)?;
    let included: Vec<String> = text
        .lines()
        .filter_map(include_of)
        .map(|name| format!("{root}/{name}"))
        .collect();
    texts.insert(path.to_owned(), text);
    for inner in included {
        gather(root, &inner, texts).map_err(|error| format!("{error} (included by {path})"))?;
    }
    Ok(())
}

/// The text of a shader file, with `\n` line ends whatever the checkout made of them.
pub(crate) fn read(path: &str) -> Result<String, String> {
    fs::read_to_string(path)
        .map(|text| text.replace("\r\n", "\n"))
        .map_err(|error| format!("{path}: {error}"))
}

/// `a/b.glsl` of a line `#include "a/b.glsl"`; paths are rooted in `glsl/`.
fn include_of(line: &str) -> Option<&str> {
    let rest = line
        .trim_start()
        .strip_prefix('#')?
        .trim_start()
        .strip_prefix("include")?;
    rest.split('"').nth(1)
}

/// Names of what is in a folder.
pub(crate) fn entries(folder: &str) -> Result<Vec<String>, String> {
    let listing = fs::read_dir(folder).map_err(|error| format!("{folder}: {error}"))?;
    listing
        .map(|entry| entry.map(|entry| entry.file_name().to_string_lossy().into_owned()))
        .collect::<Result<_, _>>()
        .map_err(|error| format!("{folder}: {error}"))
}

/// Lower-case hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
