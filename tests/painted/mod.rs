//! A small model with every kind of attribute: two balls of one mesh, each with its material, in one uv chart each.
#![allow(dead_code, reason = "each test binary uses its part")]

pub(crate) mod pictures;

use crate::glb::container;
use serde_json::{Value, json};

/// What a model may lack.
#[derive(Clone, Copy)]
pub(crate) struct Painted {
    /// Rings of each ball; twice as many segments.
    pub(crate) rings: u32,
    pub(crate) uv: bool,
    pub(crate) colors: bool,
    pub(crate) custom: bool,
    /// Normal and occlusion map of the first material.
    pub(crate) maps: bool,
}

impl Default for Painted {
    fn default() -> Self {
        Painted {
            rings: 12,
            uv: true,
            colors: true,
            custom: true,
            maps: true,
        }
    }
}

/// Accessors, views and bytes of a document on its way.
#[derive(Default)]
struct Binary {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl Binary {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views
            .push(json!({"buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len()}));
        self.bytes.extend_from_slice(bytes);
        self.views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        let view = self.view(bytes);
        self.accessors.push(
            json!({"bufferView": view, "componentType": component, "count": count, "type": kind}),
        );
        self.accessors.len() - 1
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .iter()
            .flatten()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.accessor(&bytes, 5126, values.len(), kind)
    }
}

/// The heat of a vertex at height `y`.
pub(crate) fn heat(y: f32) -> f32 {
    20.0 + 15.0 * y
}

impl Painted {
    /// The model as GLB.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut binary = Binary::default();
        let primitives: Vec<Value> = [0, 1].map(|k| self.ball(&mut binary, k)).into();
        let images: Vec<Value> = [paint(), bumps(), shade()]
            .map(|png| json!({"bufferView": binary.view(&png), "mimeType": "image/png"}))
            .into();
        let mut first = json!({
            "name": "painted",
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.25, "roughnessFactor": 0.5},
        });
        if self.maps {
            first["normalTexture"] = json!({"index": 1});
            first["occlusionTexture"] = json!({"index": 2});
        }
        let second = json!({
            "name": "plain", "emissiveFactor": [0.1, 0.0, 0.3],
            "pbrMetallicRoughness": {"baseColorFactor": [0.2, 0.7, 0.3, 1.0], "metallicFactor": 0.0},
        });
        let document = json!({
            "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"name": "balls", "primitives": primitives}],
            "materials": [first, second], "images": images,
            "textures": [{"source": 0}, {"source": 1}, {"source": 2}],
            "accessors": binary.accessors, "bufferViews": binary.views,
            "buffers": [{"byteLength": binary.bytes.len()}],
        });
        container(&document.to_string(), &binary.bytes)
    }

    /// Ball `k`: the second is half as large and stands beside the first, so near that each shades the other.
    fn ball(&self, binary: &mut Binary, k: usize) -> Value {
        let (n, m) = (self.rings, self.rings * 2);
        let (mut positions, mut uv, mut normals) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..=n {
            for j in 0..=m {
                let (v, u) = (i as f32 / n as f32, j as f32 / m as f32);
                let (polar, turn) = (v * std::f32::consts::PI, (u % 1.0) * std::f32::consts::TAU);
                let normal = [
                    polar.sin() * turn.cos(),
                    polar.cos(),
                    polar.sin() * turn.sin(),
                ];
                let (radius, aside) = [(1.0, 0.0), (0.5, 1.55)][k];
                positions.push([
                    aside + radius * normal[0],
                    radius * normal[1],
                    radius * normal[2],
                ]);
                normals.push(normal);
                uv.push([0.02 + 0.46 * u + 0.5 * k as f32, 0.02 + 0.96 * v]);
            }
        }
        let mut indices: Vec<u32> = Vec::new();
        for i in 0..n {
            for j in 0..m {
                let a = i * (m + 1) + j;
                let (b, c, d) = (a + 1, a + m + 1, a + m + 2);
                if i > 0 {
                    indices.extend([a, b, d]);
                }
                if i + 1 < n {
                    indices.extend([a, d, c]);
                }
            }
        }
        let index: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let mut attributes = json!({"NORMAL": binary.floats(&normals)});
        let position = binary.floats(&positions);
        binary.accessors[position]["min"] = json!([-2.0, -1.0, -1.0]);
        binary.accessors[position]["max"] = json!([2.1, 1.0, 1.0]);
        attributes["POSITION"] = position.into();
        if self.uv {
            attributes["TEXCOORD_0"] = binary.floats(&uv).into();
        }
        if self.colors {
            let color = |p: &[f32; 3]| p.map(|c| 0.5 + 0.25 * c.clamp(-2.0, 2.0));
            let colors: Vec<[f32; 3]> = positions.iter().map(color).collect();
            attributes["COLOR_0"] = binary.floats(&colors).into();
        }
        if self.custom {
            let heats: Vec<[f32; 1]> = positions.iter().map(|p| [heat(p[1])]).collect();
            attributes["_HEAT"] = binary.floats(&heats).into();
            // Two bytes of each vertex, normalized, in steps of four.
            let tags = (0..positions.len()).flat_map(|v| [v as u8, 255 - v as u8, 0, 0]);
            let tags: Vec<u8> = tags.collect();
            let tag = binary.accessor(&tags, 5121, positions.len(), "VEC2");
            binary.accessors[tag]["normalized"] = true.into();
            let view = binary.views.len() - 1;
            binary.views[view]["byteStride"] = 4.into();
            attributes["_TAG"] = tag.into();
        }
        json!({
            "attributes": attributes, "material": k,
            "indices": binary.accessor(&index, 5125, indices.len(), "SCALAR"),
        })
    }
}

/// A flat square of `n` x `n` cells in the plane z = 0, side 2, laid out by its own uv.
pub(crate) fn sheet(n: u32) -> Vec<u8> {
    hilly(n, |_| 0.0, None)
}

/// A square of `n` x `n` cells, side 2, full of small hills, laid out by its own uv. Its texture is one colour where x is below
/// zero, and beyond full of cells that have nothing to do with each other.
pub(crate) fn halves(n: u32) -> Vec<u8> {
    let texels = 256;
    let texture = oblong(texels, texels, |x, y| {
        let cell = x / 4 + y / 4 * 977;
        let byte = |k: u32| (cell.wrapping_add(k).wrapping_mul(2_654_435_761) >> 24) as u8;
        match x * 2 < texels {
            true => [120, 130, 90],
            false => [byte(1), byte(2), byte(3)],
        }
    });
    let height = |p: [f32; 2]| (p[0] * 40.0).sin() * (p[1] * 31.0).cos() * 0.01;
    hilly(n, height, Some(&texture))
}

fn hilly(n: u32, height: impl Fn([f32; 2]) -> f32, texture: Option<&[u8]>) -> Vec<u8> {
    let mut binary = Binary::default();
    let at = |i: u32| i as f32 / n as f32;
    let all = (0..=n).flat_map(|y| (0..=n).map(move |x| [at(x), at(y)]));
    let uv: Vec<[f32; 2]> = all.collect();
    let place = |p: &[f32; 2]| {
        let [x, y] = p.map(|c| c * 2.0 - 1.0);
        [x, y, height([x, y])]
    };
    let positions: Vec<[f32; 3]> = uv.iter().map(place).collect();
    let cell = |i: u32| {
        let a = i / n * (n + 1) + i % n;
        [a, a + 1, a + n + 2, a, a + n + 2, a + n + 1]
    };
    let indices: Vec<u32> = (0..n * n).flat_map(cell).collect();
    let index: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
    let position = binary.floats(&positions);
    let ends = |end: fn(f32, f32) -> f32| {
        let z = positions.iter().map(|p| p[2]).reduce(end);
        [end(-1.0, 1.0), end(-1.0, 1.0), z.unwrap()]
    };
    binary.accessors[position]["min"] = json!(ends(f32::min));
    binary.accessors[position]["max"] = json!(ends(f32::max));
    let uv = binary.floats(&uv);
    let index = binary.accessor(&index, 5125, indices.len(), "SCALAR");
    let mut primitive =
        json!({"attributes": {"POSITION": position, "TEXCOORD_0": uv}, "indices": index});
    let image = texture.map(|png| binary.view(png));
    if image.is_some() {
        primitive["material"] = json!(0);
    }
    let mut document = json!({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"name": "sheet", "primitives": [primitive]}],
        "accessors": binary.accessors, "bufferViews": binary.views,
        "buffers": [{"byteLength": binary.bytes.len()}],
    });
    if let Some(view) = image {
        document["images"] = json!([{"bufferView": view, "mimeType": "image/png"}]);
        document["textures"] = json!([{"source": 0}]);
        document["materials"] = json!([{
            "pbrMetallicRoughness": {"baseColorTexture": {"index": 0}, "metallicFactor": 0.0},
        }]);
    }
    container(&document.to_string(), &binary.bytes)
}

/// A volume of 8 x 8 x 8 texels as a picture of its slices.
pub(crate) fn strip() -> Vec<u8> {
    oblong(8, 64, |x, y| {
        [(x * 36) as u8, (y % 8 * 36) as u8, (y / 8 * 36) as u8]
    })
}

fn png(n: u32, texel: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    oblong(n, n, texel)
}

/// A PNG of these texels.
pub(crate) fn oblong(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 3]) -> Vec<u8> {
    let image = image::RgbImage::from_fn(width, height, |x, y| image::Rgb(texel(x, y)));
    let mut bytes = std::io::Cursor::new(Vec::new());
    image.write_to(&mut bytes, image::ImageFormat::Png).unwrap();
    bytes.into_inner()
}

fn paint() -> Vec<u8> {
    png(32, |x, y| {
        [
            (x * 8) as u8,
            (y * 8) as u8,
            if (x + y) % 2 == 0 { 200 } else { 60 },
        ]
    })
}

fn bumps() -> Vec<u8> {
    png(16, |x, y| {
        [(104 + x % 4 * 16) as u8, (104 + y % 4 * 16) as u8, 240]
    })
}

fn shade() -> Vec<u8> {
    png(8, |x, y| [(128 + (x * y) * 2) as u8, 0, 0])
}
