//! The original glTF document, made self-contained: one JSON value and one binary, as a GLB holds them.
//!
//! In: a container taken apart and a resolver. Out: [`Document`], in which every buffer and every image file or data URI has
//! become part of one binary, so that the model can be written back whole. A GLB that has all inside already keeps its
//! bytes and its JSON as they are.

use super::json::{BufferView, Root};
use super::resource::Resolver;
use crate::{Error, Result};
use serde_json::{Value, json};
use std::sync::Arc;

/// A self-contained glTF document.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Document {
    /// The JSON as read, but for buffers and images that were outside of the binary.
    pub json: Value,
    /// Contents of the only buffer (empty when there is none). Shared with the scene's images.
    pub binary: Arc<Vec<u8>>,
}

impl Document {
    /// The bytes of a GLB that holds this document.
    ///
    /// # Errors
    /// [`Error::Capacity`] past 4 GiB.
    pub fn to_glb(&self) -> Result<Vec<u8>> {
        super::container::to_glb(&self.json, &self.binary)
    }
}

/// A checked buffer view: a range of the document's binary.
#[derive(Clone, Copy, Debug)]
pub(super) struct View {
    pub(super) start: usize,
    pub(super) length: usize,
    pub(super) stride: Option<usize>,
}

/// Brings all buffers and images of a document into one binary; returns it with all its views, checked.
pub(super) fn gather(
    file: &str,
    mut json: Value,
    root: &Root,
    bin: Option<&[u8]>,
    resolver: &mut Resolver,
) -> Result<(Document, Vec<View>)> {
    tidy(&mut json);
    let buffers = resolve_buffers(file, root, bin, resolver)?;
    let mut views = check_views(file, &root.buffer_views, &buffers)?;
    let inside = root.buffers.len() == 1 && root.buffers[0].uri.is_none();
    let mut starts = Vec::with_capacity(buffers.len());
    let mut binary = Vec::new();
    for buffer in buffers {
        binary.resize(binary.len().next_multiple_of(16), 0);
        starts.push(binary.len());
        if binary.is_empty() {
            binary = buffer;
        } else {
            binary.extend(buffer);
        }
    }
    for (view, source) in views.iter_mut().zip(&root.buffer_views) {
        view.start += starts[source.buffer];
    }
    if !inside {
        point_views(&mut json, &starts);
    }
    let embedded = embed_images(&mut json, root, resolver, &mut binary, &mut views)?;
    if !root.buffers.is_empty() && !inside || embedded {
        json["buffers"] = json!([{ "byteLength": binary.len() }]);
    }
    Ok((
        Document {
            json,
            binary: Arc::new(binary),
        },
        views,
    ))
}

/// Removes `extensions` objects without anything in them, which glTF does not allow, where a build adds to them: what a
/// build added can then be told from what was there.
fn tidy(json: &mut Value) {
    let prune = |object: &mut Value| {
        if let Some(object) = object.as_object_mut()
            && object
                .get("extensions")
                .and_then(Value::as_object)
                .is_some_and(serde_json::Map::is_empty)
        {
            object.remove("extensions");
        }
    };
    prune(json);
    for key in ["meshes", "nodes"] {
        json.get_mut(key)
            .and_then(Value::as_array_mut)
            .into_iter()
            .flatten()
            .for_each(prune);
    }
}

/// Bytes of every buffer, each cut to the length it claims.
fn resolve_buffers(
    file: &str,
    root: &Root,
    bin: Option<&[u8]>,
    resolver: &mut Resolver,
) -> Result<Vec<Vec<u8>>> {
    let mut out = Vec::with_capacity(root.buffers.len());
    for (i, buffer) in root.buffers.iter().enumerate() {
        let element = || format!("buffers[{i}]");
        let mut bytes = match (&buffer.uri, bin) {
            (Some(uri), _) => resolver.resolve(uri, &format!("buffers[{i}].uri"))?,
            (None, Some(bin)) if i == 0 => bin.to_vec(),
            (None, _) => {
                return Err(Error::input(
                    file,
                    element(),
                    "has no uri and no BIN chunk to stand for it",
                ));
            }
        };
        if buffer.byte_length > bytes.len() as u64 || buffer.byte_length == 0 {
            let reason = format!(
                "claims {} bytes, {} are there",
                buffer.byte_length,
                bytes.len()
            );
            return Err(Error::input(file, element(), reason));
        }
        bytes.truncate(buffer.byte_length as usize);
        out.push(bytes);
    }
    Ok(out)
}

/// Every view, inside its buffer (starts are relative to the buffer still).
fn check_views(file: &str, views: &[BufferView], buffers: &[Vec<u8>]) -> Result<Vec<View>> {
    let mut out = Vec::with_capacity(views.len());
    for (i, view) in views.iter().enumerate() {
        let element = || format!("bufferViews[{i}]");
        let buffer = super::json::at(file, buffers, "buffers", view.buffer, element)?;
        let end = view.byte_offset.checked_add(view.byte_length);
        if end.is_none_or(|end| end > buffer.len() as u64) || view.byte_length == 0 {
            let reason = format!(
                "{} bytes from {} are not inside buffers[{}], which has {}",
                view.byte_length,
                view.byte_offset,
                view.buffer,
                buffer.len()
            );
            return Err(Error::input(file, element(), reason));
        }
        if let Some(stride) = view.byte_stride
            && (!(4..=252).contains(&stride) || stride % 4 != 0)
        {
            let reason = format!("byteStride {stride} is not a multiple of 4 from 4 to 252");
            return Err(Error::input(file, element(), reason));
        }
        out.push(View {
            start: view.byte_offset as usize,
            length: view.byte_length as usize,
            stride: view.byte_stride.map(|s| s as usize),
        });
    }
    Ok(out)
}

/// Moves every reference to a buffer (of views and of extensions in them) to its place in the one binary.
fn point_views(json: &mut Value, starts: &[usize]) {
    let Some(views) = json.get_mut("bufferViews").and_then(Value::as_array_mut) else {
        return;
    };
    for view in views {
        point(view, starts);
        if let Some(extensions) = view.get_mut("extensions").and_then(Value::as_object_mut) {
            extensions
                .values_mut()
                .for_each(|extension| point(extension, starts));
        }
    }
}

fn point(object: &mut Value, starts: &[usize]) {
    let Some(buffer) = object.get("buffer").and_then(Value::as_u64) else {
        return;
    };
    let Some(start) = starts.get(buffer as usize) else {
        return;
    };
    let offset = object
        .get("byteOffset")
        .and_then(Value::as_u64)
        .unwrap_or(0);
    object["buffer"] = json!(0);
    object["byteOffset"] = json!(offset.saturating_add(*start as u64));
}

/// Images named by a URI become views of the binary. Returns whether there were any. One that cannot be read keeps its
/// URI: the scene gives it a stand-in and says so.
fn embed_images(
    json: &mut Value,
    root: &Root,
    resolver: &mut Resolver,
    binary: &mut Vec<u8>,
    views: &mut Vec<View>,
) -> Result<bool> {
    let mut embedded = false;
    for (i, image) in root.images.iter().enumerate() {
        let (Some(uri), None) = (&image.uri, image.buffer_view) else {
            continue;
        };
        let Ok(bytes) = resolver.resolve(uri, &format!("images[{i}].uri")) else {
            continue;
        };
        let Some(mime) = super::image::mime(&bytes) else {
            continue;
        };
        binary.resize(binary.len().next_multiple_of(16), 0);
        let view = json!({ "buffer": 0, "byteOffset": binary.len(), "byteLength": bytes.len() });
        views.push(View {
            start: binary.len(),
            length: bytes.len(),
            stride: None,
        });
        binary.extend(bytes);
        array(json, "bufferViews").push(view);
        if let Some(image) = array(json, "images")
            .get_mut(i)
            .and_then(Value::as_object_mut)
        {
            image.remove("uri");
            image.insert("mimeType".into(), json!(mime));
            image.insert("bufferView".into(), json!(views.len() - 1));
        }
        embedded = true;
    }
    Ok(embedded)
}

/// The array `key` of a JSON object, made if it is not there.
pub(crate) fn array<'a>(json: &'a mut Value, key: &str) -> &'a mut Vec<Value> {
    if !json[key].is_array() {
        json[key] = Value::Array(Vec::new());
    }
    json[key].as_array_mut().expect("was made an array above")
}
