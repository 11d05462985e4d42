//! From bytes to JSON and binary chunk: `.gltf` and `.glb`.
//!
//! In: bytes of any origin. Out: the JSON value and the BIN chunk, or an error. Nothing is allocated by a claim of the file:
//! chunk lengths are compared with the bytes there are, and the JSON's nesting and size are counted before serde sees it.
//!
//! Source: glTF 2.0 specification, section 4.4 (GLB).

use crate::{Error, Result};
use serde_json::Value;

/// Deepest nesting of arrays and objects that is read. glTF itself needs about ten; serde_json stops at 128.
const MAX_DEPTH: usize = 100;
/// Most objects and most values in one document: what bounds the memory of the parsed tree (about 1 KiB and 32 bytes each).
const MAX_OBJECTS: usize = 1 << 20;
const MAX_VALUES: usize = 1 << 24;

const CHUNK_JSON: u32 = 0x4e4f_534a;
const CHUNK_BIN: u32 = 0x004e_4942;

/// A file taken apart.
pub(super) struct Container<'a> {
    pub(super) json: Value,
    /// Contents of the BIN chunk, with its padding.
    pub(super) bin: Option<&'a [u8]>,
}

/// Takes a `.glb` or `.gltf` apart, told apart by the first bytes.
pub(super) fn open<'a>(file: &str, bytes: &'a [u8]) -> Result<Container<'a>> {
    if bytes.starts_with(b"glTF") {
        let (json, bin) = split_glb(file, bytes)?;
        return Ok(Container {
            json: parse_json(file, json)?,
            bin,
        });
    }
    match bytes.iter().find(|b| !b.is_ascii_whitespace()) {
        Some(b'{') => Ok(Container {
            json: parse_json(file, bytes)?,
            bin: None,
        }),
        None => Err(Error::input(file, "file", "is empty")),
        _ => Err(Error::input(
            file,
            "file",
            "is not glTF (it starts neither with \"glTF\" nor with a JSON object)",
        )),
    }
}

/// JSON chunk and BIN chunk of a GLB.
fn split_glb<'a>(file: &str, bytes: &'a [u8]) -> Result<(&'a [u8], Option<&'a [u8]>)> {
    let bad = |element: &str, reason: String| Err(Error::input(file, element, reason));
    let Some(header) = bytes.first_chunk::<12>() else {
        return bad(
            "GLB header",
            format!("needs 12 bytes, the file has {}", bytes.len()),
        );
    };
    let word = |at: usize| {
        u32::from_le_bytes([header[at], header[at + 1], header[at + 2], header[at + 3]])
    };
    if word(4) != 2 {
        return bad(
            "GLB header",
            format!("version {} is not supported (2 is)", word(4)),
        );
    }
    if word(8) as usize != bytes.len() {
        return bad(
            "GLB header",
            format!("claims {} bytes, the file has {}", word(8), bytes.len()),
        );
    }
    let mut rest = &bytes[12..];
    let mut chunks = Vec::new();
    while !rest.is_empty() {
        let element = format!("GLB chunk {}", chunks.len());
        let Some((head, tail)) = rest.split_first_chunk::<8>() else {
            return bad(
                &element,
                format!("header needs 8 bytes, {} are left", rest.len()),
            );
        };
        let length = u32::from_le_bytes([head[0], head[1], head[2], head[3]]) as usize;
        let kind = u32::from_le_bytes([head[4], head[5], head[6], head[7]]);
        if length > tail.len() {
            return bad(
                &element,
                format!("claims {length} bytes, {} are left", tail.len()),
            );
        }
        if !length.is_multiple_of(4) {
            return bad(&element, format!("length {length} is not a multiple of 4"));
        }
        match (chunks.len(), kind) {
            (0, CHUNK_JSON) | (1, CHUNK_BIN) => {}
            (0, _) => return bad(&element, "is not the JSON chunk".into()),
            (_, CHUNK_JSON | CHUNK_BIN) => {
                return bad(&element, "is a JSON or BIN chunk out of its place".into());
            }
            // Unknown chunks after the JSON are to be ignored.
            _ => {}
        }
        chunks.push((kind, &tail[..length]));
        rest = &tail[length..];
        if chunks.len() > 64 {
            return bad(&element, "too many chunks".into());
        }
    }
    let json = match chunks.first() {
        Some((_, json)) => *json,
        None => return bad("GLB", "has no JSON chunk".into()),
    };
    Ok((
        json,
        chunks.get(1).filter(|c| c.0 == CHUNK_BIN).map(|c| c.1),
    ))
}

/// Parses a document after counting what it would cost.
fn parse_json(file: &str, bytes: &[u8]) -> Result<Value> {
    measure(bytes).map_err(|reason| Error::input(file, "JSON", reason))?;
    let json: Value =
        serde_json::from_slice(bytes).map_err(|e| Error::input(file, "JSON", e.to_string()))?;
    if !json.is_object() {
        return Err(Error::input(file, "JSON", "is not an object"));
    }
    Ok(json)
}

/// Counts nesting, objects and values, so that neither the parser nor the drop of its result runs out of stack or memory.
fn measure(bytes: &[u8]) -> Result<(), String> {
    let (mut depth, mut objects, mut values) = (0usize, 0usize, 0usize);
    let (mut in_string, mut escaped) = (false, false);
    for &byte in bytes {
        if in_string {
            in_string = escaped || byte != b'"';
            escaped = byte == b'\\' && !escaped;
            continue;
        }
        match byte {
            b'"' => in_string = true,
            b'{' | b'[' => {
                depth += 1;
                objects += usize::from(byte == b'{');
                values += 1;
            }
            b'}' | b']' => depth = depth.saturating_sub(1),
            b',' => values += 1,
            _ => {}
        }
        if depth > MAX_DEPTH {
            return Err(format!("is nested deeper than {MAX_DEPTH} levels"));
        }
    }
    if objects > MAX_OBJECTS || values > MAX_VALUES {
        return Err(format!(
            "has {objects} objects and {values} values; {MAX_OBJECTS} and {MAX_VALUES} are read"
        ));
    }
    Ok(())
}

/// Puts a document together as GLB: chunks padded to 4 bytes, JSON with spaces, binary with zeros.
///
/// # Errors
/// [`Error::Capacity`] past the 4 GiB that GLB's lengths can say.
pub(crate) fn to_glb(json: &Value, bin: &[u8]) -> Result<Vec<u8>> {
    let mut text = serde_json::to_vec(json)
        .map_err(|e| Error::input("glTF document", "JSON", format!("cannot be written: {e}")))?;
    text.resize(text.len().next_multiple_of(4), b' ');
    let padded = bin.len().next_multiple_of(4);
    let total = 12 + 8 + text.len() + if bin.is_empty() { 0 } else { 8 + padded };
    if u32::try_from(total).is_err() {
        return Err(Error::Capacity {
            what: "bytes of a GLB".into(),
            need: total as u64,
            have: u32::MAX.into(),
        });
    }
    let mut out = Vec::with_capacity(total);
    let word = |out: &mut Vec<u8>, value: u32| out.extend(value.to_le_bytes());
    out.extend(b"glTF");
    word(&mut out, 2);
    word(&mut out, total as u32);
    word(&mut out, text.len() as u32);
    word(&mut out, CHUNK_JSON);
    out.extend(&text);
    if !bin.is_empty() {
        word(&mut out, padded as u32);
        word(&mut out, CHUNK_BIN);
        out.extend(bin);
        out.resize(total, 0);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn glb_written_is_read_again() {
        let json = serde_json::json!({"asset": {"version": "2.0"}, "x": [1, "\"]}{[", {"y": 0.1}]});
        for bin in [&[][..], &[1, 2, 3], &[1, 2, 3, 4]] {
            let glb = to_glb(&json, bin).unwrap();
            assert_eq!(glb.len() % 4, 0);
            let back = open("x", &glb).unwrap();
            assert_eq!(back.json, json);
            assert_eq!(
                back.bin.map_or(0, <[u8]>::len),
                bin.len().next_multiple_of(4)
            );
        }
    }

    #[test]
    fn nesting_is_counted_outside_strings_only() {
        let deep = |n: usize| format!("{{\"a\":{}1{}}}", "[".repeat(n), "]".repeat(n));
        assert!(open("x", deep(MAX_DEPTH - 1).as_bytes()).is_ok());
        assert!(open("x", deep(MAX_DEPTH).as_bytes()).is_err());
        assert!(open("x", deep(5_000_000).as_bytes()).is_err());
        let text = format!("{{\"a\":\"{}\\\"{}\"}}", "[".repeat(1000), "{".repeat(1000));
        assert!(open("x", text.as_bytes()).is_ok());
    }

    #[test]
    fn a_document_of_too_many_objects_is_refused_before_it_is_parsed() {
        let text = format!("{{\"nodes\":[{}{{}}]}}", "{},".repeat(MAX_OBJECTS));
        let Err(error) = open("x", text.as_bytes()) else {
            panic!("was read")
        };
        assert!(error.to_string().contains("objects"), "{error}");
    }
}
