//! Resolves the `uri` of a buffer or image, deny by default.
//!
//! In: a URI from an untrusted file and the folder it may read from. Out: bytes. Allowed are `data:` URIs and files below
//! the folder, named relatively. Everything else (schemes, absolute paths, `..`, links that lead out, things that are not
//! plain files, more bytes than the budget) is an error.

use crate::{Error, Result};
use base64::Engine;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

/// Most bytes that all resources of one document may bring in.
const MAX_BYTES: u64 = 1 << 30;

/// Where resources come from and how much more may come.
pub(super) struct Resolver<'a> {
    file: &'a str,
    root: Option<&'a Path>,
    left: u64,
}

impl<'a> Resolver<'a> {
    /// Reads below `root`; with `None` only `data:` URIs resolve.
    pub(super) fn new(file: &'a str, root: Option<&'a Path>) -> Resolver<'a> {
        Resolver {
            file,
            root,
            left: MAX_BYTES,
        }
    }

    /// Bytes behind a URI; `element` is the place it stands (`buffers[0].uri`).
    pub(super) fn resolve(&mut self, uri: &str, element: &str) -> Result<Vec<u8>> {
        let bytes = match uri.strip_prefix("data:") {
            Some(data) => {
                decode_data(data).map_err(|reason| Error::input(self.file, element, reason))?
            }
            None => self.read_file(uri, element)?,
        };
        let length = bytes.len() as u64;
        self.left = self
            .left
            .checked_sub(length)
            .ok_or_else(|| self.too_much(element))?;
        Ok(bytes)
    }

    fn too_much(&self, element: &str) -> Error {
        Error::input(
            self.file,
            element,
            format!("more than {MAX_BYTES} bytes of resources"),
        )
    }

    fn read_file(&self, uri: &str, element: &str) -> Result<Vec<u8>> {
        let bad = |reason: String| Error::input(self.file, element, reason);
        let relative =
            relative_path(uri).map_err(|why| bad(format!("\"{}\" {why}", shown(uri))))?;
        let root = self
            .root
            .ok_or_else(|| bad("names a file, and there is no folder to read from".into()))?;
        let cannot = |e: std::io::Error| bad(format!("cannot read \"{}\": {e}", shown(uri)));
        // An empty parent ("model.gltf" in the working folder) is the working folder.
        let root = if root.as_os_str().is_empty() {
            Path::new(".")
        } else {
            root
        };
        let root = root.canonicalize().map_err(cannot)?;
        let path = root.join(relative).canonicalize().map_err(cannot)?;
        if !path.starts_with(&root) {
            return Err(bad(format!(
                "\"{}\" leads out of the file's folder",
                shown(uri)
            )));
        }
        // Looked at before it is opened: opening a pipe would wait for its other end.
        if !path.metadata().map_err(cannot)?.is_file() {
            return Err(bad(format!("\"{}\" is not a plain file", shown(uri))));
        }
        let mut bytes = Vec::new();
        let reader = std::fs::File::open(&path).map_err(cannot)?;
        reader
            .take(self.left + 1)
            .read_to_end(&mut bytes)
            .map_err(cannot)?;
        if bytes.len() as u64 > self.left {
            return Err(self.too_much(element));
        }
        Ok(bytes)
    }
}

/// A URI as an error shows it: short, and without control characters.
fn shown(uri: &str) -> String {
    uri.chars().take(80).flat_map(char::escape_debug).collect()
}

/// The relative path a URI names, or why it may not be read.
fn relative_path(uri: &str) -> Result<PathBuf, &'static str> {
    let text = percent_decode(uri).ok_or("is not a valid URI")?;
    if text.is_empty() {
        return Err("is empty");
    }
    if text.contains(['\0', '\\', ':']) {
        return Err("is not a plain relative path (schemes, drives and backslashes are not read)");
    }
    let path = PathBuf::from(text);
    if path
        .components()
        .any(|part| !matches!(part, Component::Normal(_) | Component::CurDir))
    {
        return Err("leads out of the file's folder (absolute paths and .. are not read)");
    }
    Ok(path)
}

/// `%41` to `A`; `None` where a percent sign is not followed by two digits or the result is not UTF-8.
fn percent_decode(uri: &str) -> Option<String> {
    let mut bytes = Vec::with_capacity(uri.len());
    let mut rest = uri.as_bytes();
    while let Some((&byte, tail)) = rest.split_first() {
        rest = tail;
        if byte == b'%' {
            let (digits, tail) = rest.split_first_chunk::<2>()?;
            let digit = |b: u8| char::from(b).to_digit(16);
            bytes.push((digit(digits[0])? * 16 + digit(digits[1])?) as u8);
            rest = tail;
        } else {
            bytes.push(byte);
        }
    }
    String::from_utf8(bytes).ok()
}

/// Bytes of `[mediatype];base64,...` (the part after `data:`).
fn decode_data(data: &str) -> Result<Vec<u8>, String> {
    let (head, body) = data
        .split_once(',')
        .ok_or("is a data URI without a comma")?;
    let Some(media_type) = head.strip_suffix(";base64") else {
        return Err("is a data URI that is not base64".into());
    };
    if media_type
        .split(';')
        .skip(1)
        .any(|parameter| !parameter.contains('='))
    {
        return Err("is a data URI with a malformed media type".into());
    }
    base64::engine::general_purpose::STANDARD
        .decode(body)
        .map_err(|e| format!("is not valid base64: {e}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_lead_out_are_refused() {
        for uri in [
            "/etc/passwd",
            "../x",
            "a/../../x",
            "%2e%2e/x",
            "file:///x",
            "http://x",
            "C:x",
            "..\\x",
            "",
            "%zz",
            "%",
        ] {
            assert!(relative_path(uri).is_err(), "{uri}");
        }
        assert_eq!(
            relative_path("a/b%20c.bin").unwrap(),
            PathBuf::from("a/b c.bin")
        );
        assert!(relative_path("./x.png").is_ok());
    }

    #[test]
    fn data_uris() {
        assert_eq!(
            decode_data("application/octet-stream;base64,AQID").unwrap(),
            [1, 2, 3]
        );
        for bad in [
            "base64,AQID",
            "x;base64",
            "x;base64,A",
            "x;base64,A*==",
            "x;;base64,AQID",
            "",
        ] {
            assert!(decode_data(bad).is_err(), "{bad}");
        }
    }

    /// A file inside is read; a link to outside, a folder and a missing file are not.
    #[test]
    fn only_plain_files_below_the_root() {
        let outside = tempfile::tempdir().unwrap();
        std::fs::write(outside.path().join("secret"), b"secret").unwrap();
        let root = tempfile::tempdir().unwrap();
        std::fs::write(root.path().join("inside.bin"), b"inside").unwrap();
        std::fs::create_dir(root.path().join("folder")).unwrap();
        let mut resolver = Resolver::new("x", Some(root.path()));
        assert_eq!(resolver.resolve("inside.bin", "e").unwrap(), b"inside");
        assert!(resolver.resolve("folder", "e").is_err());
        assert!(resolver.resolve("missing", "e").is_err());
        #[cfg(unix)]
        {
            std::os::unix::fs::symlink(outside.path().join("secret"), root.path().join("link"))
                .unwrap();
            assert!(
                resolver
                    .resolve("link", "e")
                    .unwrap_err()
                    .to_string()
                    .contains("leads out")
            );
        }
        assert!(Resolver::new("x", None).resolve("inside.bin", "e").is_err());
    }

    #[test]
    fn the_budget_counts_every_resource() {
        let root = tempfile::tempdir().unwrap();
        std::fs::write(root.path().join("a"), [0; 60]).unwrap();
        let mut resolver = Resolver {
            file: "x",
            root: Some(root.path()),
            left: 100,
        };
        assert!(resolver.resolve("a", "e").is_ok());
        assert!(resolver.resolve("a", "e").is_err());
    }
}
