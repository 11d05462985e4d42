//! The original document inside a built one: what was appended, and how to take it away again.
//!
//! In: a document. Out: its [`Counts`]; and from a built document and its counts the original, as it was.

use super::extension::{Counts, EXTENSION, MSFT_LOD};
use serde_json::Value;

/// Lengths of a document's arrays.
pub(super) fn count(json: &Value, bytes: usize) -> Counts {
    let length = |key: &str| json.get(key).and_then(Value::as_array).map(Vec::len);
    Counts {
        accessors: length("accessors"),
        buffer_views: length("bufferViews"),
        meshes: length("meshes"),
        nodes: length("nodes"),
        extensions_used: length("extensionsUsed"),
        byte_length: json.get("buffers").is_some().then_some(bytes),
    }
}

/// Takes away all that was appended to a document. What the counts do not fit is the name of the array.
pub(super) fn strip(json: &mut Value, counts: &Counts) -> Result<(), &'static str> {
    let first_lod_node = counts.nodes.unwrap_or(0);
    for (key, count) in [
        ("accessors", counts.accessors),
        ("bufferViews", counts.buffer_views),
        ("meshes", counts.meshes),
        ("nodes", counts.nodes),
        ("extensionsUsed", counts.extensions_used),
    ] {
        cut(json, key, count)?;
    }
    for animation in elements(json, "animations") {
        let channels = animation.get_mut("channels").and_then(Value::as_array_mut);
        if let Some(channels) = channels {
            channels.retain(|c| !appended(&c["target"]["node"], first_lod_node));
        }
    }
    remove_extension(json, EXTENSION);
    for mesh in elements(json, "meshes") {
        remove_extension(mesh, EXTENSION);
    }
    for node in elements(json, "nodes") {
        if names_only(&node["extensions"][MSFT_LOD]["ids"], first_lod_node) {
            remove_extension(node, MSFT_LOD);
        }
    }
    match counts.byte_length {
        None => drop(
            json.as_object_mut()
                .and_then(|object| object.remove("buffers")),
        ),
        Some(bytes) => match elements(json, "buffers")
            .next()
            .and_then(Value::as_object_mut)
        {
            Some(buffer) => drop(buffer.insert("byteLength".into(), bytes.into())),
            None => return Err("byteLength"),
        },
    }
    Ok(())
}

/// Whether `ids` are nodes of LoDs: an original's own MSFT_lod names others and stays.
fn names_only(ids: &Value, first: usize) -> bool {
    ids.as_array()
        .is_some_and(|ids| !ids.is_empty() && ids.iter().all(|id| appended(id, first)))
}

/// Whether `id` is that of a node of a LoD.
fn appended(id: &Value, first: usize) -> bool {
    id.as_u64().is_some_and(|id| id >= first as u64)
}

fn cut(json: &mut Value, key: &'static str, count: Option<usize>) -> Result<(), &'static str> {
    let Some(object) = json.as_object_mut() else {
        return Err(key);
    };
    match (count, object.get_mut(key).and_then(Value::as_array_mut)) {
        (None, _) => drop(object.remove(key)),
        (Some(count), Some(array)) if count <= array.len() => array.truncate(count),
        _ => return Err(key),
    }
    Ok(())
}

fn elements<'a>(json: &'a mut Value, key: &str) -> impl Iterator<Item = &'a mut Value> {
    json.get_mut(key)
        .and_then(Value::as_array_mut)
        .into_iter()
        .flatten()
}

/// Removes an extension, and the `extensions` object with the last one in it.
fn remove_extension(object: &mut Value, name: &str) {
    let Some(object) = object.as_object_mut() else {
        return;
    };
    let Some(extensions) = object.get_mut("extensions").and_then(Value::as_object_mut) else {
        return;
    };
    if extensions.remove(name).is_some() && extensions.is_empty() {
        object.remove("extensions");
    }
}
