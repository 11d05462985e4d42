//! `spirv/MANIFEST`: which source each committed binary was made from. In: the sources. Out: their binaries, or an
//! error that names the stale one and the command that renews it.

use crate::source::{Source, hex};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::fs;

pub(crate) const PATH: &str = "spirv/MANIFEST";
const RENEW: &str =
    "run `INVERTEX_BLESS_SPIRV=1 cargo build --features compile-shaders` and commit spirv/";
#[cfg(feature = "compile-shaders")]
const HEADER: &str = "\
# Written by build.rs (INVERTEX_BLESS_SPIRV=1 and the feature compile-shaders); never by hand.
# One line per binary: sha256 of the source with its includes, sha256 of the binary, file name.
";

/// The binary of every source, in their order, after checking that each was made from the source as it is now and that
/// none is left over.
pub(crate) fn read(sources: &[Source]) -> Result<Vec<Vec<u8>>, String> {
    let text = fs::read_to_string(PATH).map_err(|error| format!("{PATH}: {error}; {RENEW}"))?;
    let mut lines = parse(&text);
    let mut binaries = Vec::with_capacity(sources.len());
    for source in sources {
        let path = source.binary_path();
        let binary = fs::read(&path).map_err(|error| format!("{path}: {error}; {RENEW}"))?;
        let Some((source_hash, binary_hash)) = lines.remove(path.as_str()) else {
            return Err(format!("{PATH} does not name {path}; {RENEW}"));
        };
        if source_hash != source.sha256 {
            return Err(format!(
                "{path} is stale: {} or an include of it has changed since; {RENEW}",
                source.path
            ));
        }
        if binary_hash != hex(&Sha256::digest(&binary)) {
            return Err(format!("{path} is not the file that {PATH} names; {RENEW}"));
        }
        binaries.push(binary);
    }
    match lines.keys().next() {
        Some(path) => Err(format!("{PATH} names {path}, which has no source; {RENEW}")),
        None => Ok(binaries),
    }
}

/// path -> (sha256 of the source, sha256 of the binary).
fn parse(text: &str) -> BTreeMap<&str, (&str, &str)> {
    let fields = text
        .lines()
        .filter(|line| !line.starts_with('#'))
        .map(|line| line.split_whitespace());
    fields
        .filter_map(|mut f| Some((f.next()?, f.next()?, f.next()?)))
        .map(|(s, b, p)| (p, (s, b)))
        .collect()
}

/// The line of a MANIFEST that says which compiler wrote it.
#[cfg(feature = "compile-shaders")]
pub(crate) fn compiler(text: &str) -> Option<&str> {
    text.lines()
        .find_map(|line| line.strip_prefix("# compiler: "))
}

/// The MANIFEST of these sources and binaries.
#[cfg(feature = "compile-shaders")]
pub(crate) fn text(sources: &[Source], binaries: &[Vec<u8>], compiler: &str) -> String {
    let mut text = format!("{HEADER}# compiler: {compiler}\n");
    for (source, binary) in sources.iter().zip(binaries) {
        text += &format!(
            "{} {} {}\n",
            source.sha256,
            hex(&Sha256::digest(binary)),
            source.binary_path()
        );
    }
    text
}
