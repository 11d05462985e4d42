//! GLB out: one mesh, one material, three JPEG textures, positions to the bit.
//!
//! In: vertex arrays and encoded images. Out: the bytes of a valid GLB (checked with the Khronos validator).

use crate::mesh::Mesh;
use crate::texture::Images;
use serde_json::{Value, json};

/// Appends data at a multiple of four and remembers its view.
#[derive(Default)]
struct Bin {
    bytes: Vec<u8>,
    views: Vec<Value>,
}

impl Bin {
    fn push(&mut self, data: &[u8], target: Option<u32>) -> usize {
        let offset = self.bytes.len();
        self.bytes.extend_from_slice(data);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        let mut view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": data.len() });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        self.views.push(view);
        self.views.len() - 1
    }
}

const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
const FLOAT: u32 = 5126;

fn bounds(positions: &[[f32; 3]]) -> ([f32; 3], [f32; 3]) {
    let mut bounds = ([f32::MAX; 3], [f32::MIN; 3]);
    for p in positions {
        for (axis, &value) in p.iter().enumerate() {
            bounds.0[axis] = bounds.0[axis].min(value);
            bounds.1[axis] = bounds.1[axis].max(value);
        }
    }
    bounds
}

/// Assembles the file.
pub(crate) fn write(mesh: &Mesh, images: &Images) -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut bin = Bin::default();
    let count = mesh.positions.len();
    let (low, high) = bounds(&mesh.positions);
    let mut accessors = Vec::new();
    let mut accessor = |view: usize, kind: &str, component: u32, count: usize| {
        accessors.push(
            json!({ "bufferView": view, "type": kind, "componentType": component, "count": count }),
        );
        accessors.len() - 1
    };
    let short: Option<Vec<u16>> = mesh
        .indices
        .iter()
        .map(|&i| u16::try_from(i).ok())
        .collect();
    let (index_bytes, index_type): (&[u8], u32) = match &short {
        Some(short) => (bytemuck::cast_slice(short), 5123),
        None => (bytemuck::cast_slice(&mesh.indices), 5125),
    };
    let indices = accessor(
        bin.push(index_bytes, Some(INDICES)),
        "SCALAR",
        index_type,
        mesh.indices.len(),
    );
    let mut floats =
        |bytes: &[u8], kind: &str| accessor(bin.push(bytes, Some(VERTICES)), kind, FLOAT, count);
    let position = floats(bytemuck::cast_slice(&mesh.positions), "VEC3");
    let normal = floats(bytemuck::cast_slice(&mesh.normals), "VEC3");
    let tangent = floats(bytemuck::cast_slice(&mesh.tangents), "VEC4");
    let uv = floats(bytemuck::cast_slice(&mesh.uvs), "VEC2");
    accessors[position]["min"] = json!(low);
    accessors[position]["max"] = json!(high);
    let pictures: Vec<Value> = [("colour", &images.colour), ("surface", &images.surface), ("normal", &images.normal)]
        .into_iter()
        .map(|(name, jpeg)| json!({ "name": name, "mimeType": "image/jpeg", "bufferView": bin.push(jpeg, None) }))
        .collect();
    let texture = |source: usize| json!({ "source": source, "sampler": 0 });
    let document = json!({
        "asset": { "version": "2.0", "generator": "invertex tools/make_asset", "copyright": "MIT OR Apache-2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "amphora" }],
        "meshes": [{ "name": "amphora", "primitives": [{
            "attributes": { "POSITION": position, "NORMAL": normal, "TANGENT": tangent, "TEXCOORD_0": uv },
            "indices": indices, "material": 0, "mode": 4 }] }],
        "materials": [{ "name": "painted clay",
            "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 }, "metallicRoughnessTexture": { "index": 1 } },
            "occlusionTexture": { "index": 1 }, "normalTexture": { "index": 2 } }],
        "textures": [texture(0), texture(1), texture(2)],
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071, "wrapT": 33071 }],
        "images": pictures,
        "accessors": accessors,
        "bufferViews": bin.views,
        "buffers": [{ "byteLength": bin.bytes.len() }],
    });
    Ok(container(serde_json::to_vec(&document)?, bin.bytes))
}

/// The binary container: a header and two chunks, each padded to a multiple of four (JSON with spaces).
fn container(mut json: Vec<u8>, bin: Vec<u8>) -> Vec<u8> {
    json.resize(json.len().next_multiple_of(4), b' ');
    let total = 12 + 8 + json.len() + 8 + bin.len();
    let mut file = Vec::with_capacity(total);
    let word = |file: &mut Vec<u8>, value: usize| file.extend((value as u32).to_le_bytes());
    file.extend(b"glTF");
    word(&mut file, 2);
    word(&mut file, total);
    for (kind, chunk) in [(b"JSON", json), (b"BIN\0", bin)] {
        word(&mut file, chunk.len());
        file.extend(kind);
        file.extend(chunk);
    }
    file
}
