//! Seeds, and how they are mutated.
//!
//! In: a number. Out: bytes. A seed is JSON and binary apart, so that most mutants are well-formed containers with a fault
//! inside: those get deepest.

use image::{ImageFormat, RgbaImage};
use invertex::asset::{self, Built, BuiltMesh};
use invertex::igt::{Asking, BuildOptions, Layout, Needs, Reference, build_cpu};
use invertex::lod::{LodInput, chains};
use invertex::param::{Primary, PrimaryKind, parts};
use invertex::scene::Scene;
use serde_json::json;
use std::io::Cursor;

/// What mutants are made from.
pub(crate) struct Seeds {
    /// Whole models: JSON text and BIN chunk.
    pub(crate) models: Vec<(String, Vec<u8>)>,
    /// Built models.
    pub(crate) built: Vec<Built>,
    /// The same as JSON text and BIN chunk.
    pub(crate) built_files: Vec<(String, Vec<u8>)>,
    /// Encoded images.
    pub(crate) images: Vec<Vec<u8>>,
}

/// Random numbers: SplitMix64 (Steele, Lea, Flood 2014).
pub(crate) struct Random(u64);

impl Random {
    pub(crate) fn new(seed: u64) -> Random {
        Random(seed.wrapping_mul(0x2545_f491_4f6c_dd1d) ^ 0x1234_5678)
    }

    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below `limit`, or 0.
    pub(crate) fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }

    pub(crate) fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }
}

pub(crate) fn seeds() -> Seeds {
    let images: Vec<Vec<u8>> = [ImageFormat::Png, ImageFormat::Jpeg, ImageFormat::WebP]
        .map(picture)
        .to_vec();
    let models = vec![model(&images[0], true), model(&images[1], false)];
    let built: Vec<Built> = [
        (PrimaryKind::Sphere, Layout::Packed),
        (PrimaryKind::UvSet(0), Layout::Packed),
        (PrimaryKind::UvSet(0), Layout::Classic),
        (PrimaryKind::Sphere, Layout::Classic),
    ]
    .map(|(kind, layout)| build(&models[0], kind, layout))
    .into();
    let built_files = built
        .iter()
        .map(|built| split(&asset::to_bytes(built).unwrap()))
        .collect();
    Seeds {
        models,
        built,
        built_files,
        images,
    }
}

fn picture(format: ImageFormat) -> Vec<u8> {
    let picture = RgbaImage::from_fn(16, 12, |x, y| {
        image::Rgba([x as u8 * 16, y as u8 * 20, 99, 255])
    });
    let mut out = Cursor::new(Vec::new());
    image::DynamicImage::from(picture)
        .into_rgb8()
        .write_to(&mut out, format)
        .unwrap();
    out.into_inner()
}

/// A model with something of everything: texture, sampler, transform, skin, animation, morph targets,
/// sparse accessors, strips.
fn model(picture: &[u8], strip: bool) -> (String, Vec<u8>) {
    let mesh = invertex::mesh::shapes::uv_sphere(8, 5);
    let mut bin = Vec::new();
    let mut views = Vec::new();
    let mut view = |bytes: &[u8]| {
        bin.resize(bin.len().next_multiple_of(4), 0);
        views.push(json!({ "buffer": 0, "byteOffset": bin.len(), "byteLength": bytes.len() }));
        bin.extend(bytes);
        views.len() - 1
    };
    let n = mesh.positions.len();
    let indices: Vec<u16> = mesh.triangles.iter().flatten().map(|&v| v as u16).collect();
    let joints = vec![[0u8, 1, 0, 0]; n];
    let weights = vec![[0.75f32, 0.25, 0.0, 0.0]; n];
    let colors: Vec<[u16; 4]> = (0..n as u16)
        .map(|v| [v * 100, 0, 65_535, 65_535])
        .collect();
    let identity: Vec<f32> = (0..32)
        .map(|i| f32::from(u8::from(i % 16 % 5 == 0)))
        .collect();
    let position = view(bytemuck::cast_slice(&mesh.positions));
    let normal = view(bytemuck::cast_slice(&mesh.normals));
    let uv = view(bytemuck::cast_slice(&mesh.uv_sets[0]));
    let index = view(bytemuck::cast_slice(&indices));
    let joint = view(bytemuck::cast_slice(&joints));
    let weight = view(bytemuck::cast_slice(&weights));
    let color = view(bytemuck::cast_slice(&colors));
    let bind = view(bytemuck::cast_slice(&identity));
    let times = view(bytemuck::cast_slice(&[0f32, 0.5, 1.0]));
    let moves = view(bytemuck::cast_slice(&[
        [0f32, 0.0, 0.0],
        [0.0, 1.0, 0.0],
        [0.0, 0.0, 0.0],
    ]));
    let sparse_at = view(bytemuck::cast_slice(&[1u16, 7]));
    let sparse_to = view(bytemuck::cast_slice(&[[0.5f32, 0.5], [0.25, 0.75]]));
    let shape = view(bytemuck::cast_slice(&mesh.normals));
    let shares = view(bytemuck::cast_slice(&[0f32, 0.5, 1.0, 0.25, 0.5, 0.0]));
    let bumped_at = view(bytemuck::cast_slice(&[2u16, 9]));
    let bumped_to = view(bytemuck::cast_slice(&[
        [0.0f32, 0.25, 0.0],
        [0.5, 0.0, 0.0],
    ]));
    let image = view(picture);
    let accessor = |view: usize, component: u32, count: usize, kind: &str| json!({ "bufferView": view, "componentType": component, "count": count, "type": kind });
    let mut sparse_uv = accessor(uv, 5126, n, "VEC2");
    sparse_uv["sparse"] = json!({ "count": 2,
        "indices": { "bufferView": sparse_at, "componentType": 5123 }, "values": { "bufferView": sparse_to } });
    let mut bump = json!({ "componentType": 5126, "count": n, "type": "VEC3" });
    bump["sparse"] = json!({ "count": 2,
        "indices": { "bufferView": bumped_at, "componentType": 5123 }, "values": { "bufferView": bumped_to } });
    let mut normalized = accessor(color, 5123, n, "VEC4");
    normalized["normalized"] = true.into();
    let json = json!({
        "asset": { "version": "2.0" },
        "extensionsUsed": ["KHR_texture_transform"],
        "scene": 0, "scenes": [{ "nodes": [0, 1] }],
        "nodes": [
            { "mesh": 0, "skin": 0 },
            { "children": [2], "translation": [1.0, 2.0, 3.0], "rotation": [0.0, 0.6, 0.0, 0.8] },
            { "scale": [2.0, 2.0, 2.0], "mesh": 1 },
        ],
        "meshes": [
            { "name": "skinned", "primitives": [{ "material": 0, "indices": 3, "attributes": { "POSITION": 0, "NORMAL": 1,
                "TEXCOORD_0": 2, "JOINTS_0": 4, "WEIGHTS_0": 5, "COLOR_0": 6 },
                "targets": [{ "POSITION": 10, "NORMAL": 1 }, { "POSITION": 11 }] }], "weights": [0.5, 0.25] },
            { "primitives": [{ "mode": if strip { 5 } else { 6 }, "attributes": { "POSITION": 0 }, "indices": 3 },
                { "mode": 1, "attributes": { "POSITION": 0 } }] },
        ],
        "materials": [{ "pbrMetallicRoughness": { "baseColorFactor": [1.0, 0.5, 0.25, 1.0], "baseColorTexture": { "index": 0,
            "extensions": { "KHR_texture_transform": { "offset": [0.5, 0.0], "rotation": 0.1, "scale": [2.0, 2.0] } } } },
            "normalTexture": { "index": 0, "scale": 0.5 }, "alphaMode": "MASK", "alphaCutoff": 0.25 }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "magFilter": 9729, "minFilter": 9987, "wrapS": 33071 }],
        "images": [{ "bufferView": image, "mimeType": "image/png" }],
        "skins": [{ "joints": [1, 2], "inverseBindMatrices": 7 }],
        "animations": [{ "channels": [{ "sampler": 0, "target": { "node": 1, "path": "translation" } },
                { "sampler": 1, "target": { "node": 0, "path": "weights" } }],
            "samplers": [{ "input": 8, "output": 9, "interpolation": "LINEAR" },
                { "input": 8, "output": 12, "interpolation": "STEP" }] }],
        "accessors": [accessor(position, 5126, n, "VEC3"), accessor(normal, 5126, n, "VEC3"), sparse_uv,
            accessor(index, 5123, indices.len(), "SCALAR"), accessor(joint, 5121, n, "VEC4"),
            accessor(weight, 5126, n, "VEC4"), normalized, accessor(bind, 5126, 2, "MAT4"),
            accessor(times, 5126, 3, "SCALAR"), accessor(moves, 5126, 3, "VEC3"), accessor(shape, 5126, n, "VEC3"), bump,
            accessor(shares, 5126, 6, "SCALAR")],
        "bufferViews": views,
        "buffers": [{ "byteLength": bin.len() }],
    });
    (json.to_string(), bin)
}

fn build(model: &(String, Vec<u8>), kind: PrimaryKind, layout: Layout) -> Built {
    let scene = Scene::from_bytes("seed", &glb(model.0.as_bytes(), &model.1), None).unwrap();
    let mesh = &scene.meshes[0];
    let primary = Primary::centred(kind, mesh).unwrap();
    let parts = parts(mesh, &primary);
    let world = std::array::from_fn(|c| std::array::from_fn(|r| f32::from(u8::from(r == c))));
    let lods = chains(
        &[LodInput {
            mesh,
            primary: &primary,
            parts: &parts,
            world,
        }],
        &[0.5],
    )
    .unwrap()
    .remove(0);
    let options = BuildOptions { hash: 8, layout };
    let reference = Reference::new(mesh, &primary, &parts.triangle_layer, layout).unwrap();
    let asking: Vec<Asking> = lods
        .iter()
        .map(|l| Asking {
            t3: &l.t3,
            triangles: &l.triangles,
            layer: &l.triangle_layer,
        })
        .collect();
    let needs = Needs::of(&reference, &asking, options.bits().unwrap());
    let tables = build_cpu(&reference, &needs, options).unwrap();
    let triangle_layer = parts.triangle_layer;
    Built {
        meshes: vec![BuiltMesh {
            mesh: 0,
            triangle_layer,
            tables,
            lods,
            prefiltered: None,
            hierarchy: None,
            report: json!({ "a": 1 }),
        }],
        scene,
    }
}

/// A GLB with right lengths, whatever is in it.
pub(crate) fn glb(json: &[u8], bin: &[u8]) -> Vec<u8> {
    let pad = |n: usize| n.next_multiple_of(4);
    let mut out = b"glTF\x02\0\0\0".to_vec();
    out.extend((28 + pad(json.len()) as u32 + pad(bin.len()) as u32).to_le_bytes());
    for (kind, bytes, fill) in [(b"JSON", json, b' '), (b"BIN\0", bin, 0)] {
        out.extend((pad(bytes.len()) as u32).to_le_bytes());
        out.extend(kind);
        out.extend(bytes);
        out.resize(out.len() + pad(bytes.len()) - bytes.len(), fill);
    }
    out
}

/// JSON and binary of a GLB.
fn split(glb: &[u8]) -> (String, Vec<u8>) {
    let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
    (
        String::from_utf8(glb[20..20 + length].to_vec()).unwrap(),
        glb[28 + length..].to_vec(),
    )
}

/// One to four faults in bytes: bits flipped, cut short, pieces doubled, moved, removed, numbers replaced.
pub(crate) fn spoil_bytes(bytes: &mut Vec<u8>, random: &mut Random) {
    for _ in 0..1 + random.below(4) {
        if bytes.is_empty() {
            return;
        }
        let at = random.below(bytes.len());
        let length = 1 + random.below((bytes.len() - at).min(64));
        match random.below(8) {
            0 | 1 => bytes[at] ^= 1 << random.below(8),
            2 => bytes[at] = *random.pick(&[0, 1, 0x7f, 0x80, 0xff, b'"', b'{', b'[']),
            3 => bytes.truncate(at),
            4 => {
                let piece = bytes[at..at + length].to_vec();
                let to = random.below(bytes.len());
                bytes.splice(to..to, piece);
            }
            5 => drop(bytes.drain(at..at + length)),
            6 if bytes.len() >= 4 => {
                let at = random.below(bytes.len() - 3) & !3;
                let numbers = [
                    0,
                    1,
                    u32::MAX,
                    i32::MAX as u32,
                    0x7fc0_0000,
                    0x7f80_0000,
                    0x7f7f_ffff,
                    0x0001_0000,
                    7,
                ];
                bytes[at..at + 4].copy_from_slice(&random.pick(&numbers).to_le_bytes());
            }
            _ => {
                let to = random.below(bytes.len() - length + 1);
                bytes.copy_within(at..at + length, to);
            }
        }
    }
}

/// Gives each chunk of a PNG the checksum of what it now holds, so that a fault inside gets past the container: sizes in
/// the header, filters and lengths in the packed data. Other bytes are left as they are.
pub(crate) fn repair_png(bytes: &mut [u8]) {
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        return;
    }
    let mut at = 8;
    while let Some(head) = bytes.get(at..at + 8) {
        let length = u32::from_be_bytes(head[..4].try_into().unwrap()) as usize;
        let Some(sum) = bytes.get(at + 4..at + 8 + length).map(crc32) else {
            return;
        };
        at += 8 + length;
        let Some(place) = bytes.get_mut(at..at + 4) else {
            return;
        };
        place.copy_from_slice(&sum.to_be_bytes());
        at += 4;
    }
}

/// CRC-32 as PNG has it (ISO 3309), bit by bit.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| (crc >> 1) ^ (0xedb8_8320 & (crc & 1).wrapping_neg());
    let byte = |crc: u32, b: &u8| (0..8).fold(crc ^ u32::from(*b), |crc, _| step(crc));
    !bytes.iter().fold(u32::MAX, byte)
}

#[test]
fn a_repaired_png_is_what_it_was() {
    let whole = picture(ImageFormat::Png);
    let mut spoiled = whole.clone();
    // The checksum of the header: signature, length, name, thirteen bytes.
    spoiled[8 + 8 + 13] ^= 1;
    assert!(image::load_from_memory(&spoiled).is_err());
    repair_png(&mut spoiled);
    assert_eq!(spoiled, whole);
}

/// One to three faults in JSON: numbers and names replaced or exchanged, elements doubled or removed.
pub(crate) fn spoil_json(text: &mut String, random: &mut Random) {
    const NUMBERS: [&str; 20] = [
        "0",
        "1",
        "2",
        "3",
        "5",
        "7",
        "-1",
        "255",
        "256",
        "5121",
        "5125",
        "5126",
        "65535",
        "4294967295",
        "4294967296",
        "18446744073709551615",
        "1e300",
        "0.5",
        "null",
        "[]",
    ];
    for _ in 0..1 + random.below(3) {
        let tokens = tokens(text);
        if tokens.is_empty() {
            return;
        }
        let (start, end) = *random.pick(&tokens);
        match random.below(4) {
            0..2 => text.replace_range(start..end, random.pick::<&str>(&NUMBERS)),
            2 => {
                let (a, b) = *random.pick(&tokens);
                let other = text[a..b].to_owned();
                text.replace_range(start..end, &other);
            }
            _ => {
                let (_, b) = *random.pick(&tokens);
                let piece = text[start..b.clamp(start, (start + 200).min(text.len()))].to_owned();
                text.insert_str(end, &piece);
            }
        }
    }
}

/// Numbers and strings of JSON: ASCII, as all seeds are.
fn tokens(text: &str) -> Vec<(usize, usize)> {
    let bytes = text.as_bytes();
    let (mut out, mut i) = (Vec::new(), 0);
    while i < bytes.len() {
        let start = i;
        if bytes[i] == b'"' {
            i += 1;
            while i < bytes.len() && bytes[i] != b'"' {
                i += 1;
            }
            i = (i + 1).min(bytes.len());
            out.push((start, i));
        } else if bytes[i].is_ascii_digit() || bytes[i] == b'-' {
            while i < bytes.len()
                && (bytes[i].is_ascii_alphanumeric() || b"-+.".contains(&bytes[i]))
            {
                i += 1;
            }
            out.push((start, i));
        } else {
            i += 1;
        }
    }
    out
}
