//! A surface with its baked textures as one GLB that any viewer shows.
//!
//! In: meshes with texture coordinates, the textures of each as PNG. Out: the file's bytes: positions, normals, tangents,
//! TEXCOORD_0 and a metallic-roughness material.

use crate::Result;
use crate::mesh::Mesh;
use crate::scene::to_glb;
use serde_json::{Value, json};

/// A mesh and what its material is made of.
#[derive(Clone, Debug)]
pub struct TexturedMesh<'a> {
    /// With one uv set, and, where there are any, tangents along it.
    pub mesh: &'a Mesh,
    /// Textures as PNG, each with its place in the material.
    pub textures: Vec<(TexturePlace, &'a [u8])>,
    /// Object to world, as four columns; one for each place the mesh stands in.
    pub places: Vec<[[f32; 4]; 4]>,
}

/// Where a material has a texture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TexturePlace {
    /// Colour.
    BaseColor,
    /// Roughness in green, metalness in blue.
    MetallicRoughness,
    /// Tangent-space normals.
    Normal,
    /// Ambient occlusion in red.
    Occlusion,
    /// Emitted light.
    Emissive,
}

const FLOAT: u32 = 5126;
const UNSIGNED_INT: u32 = 5125;

/// A document on its way.
#[derive(Default)]
struct Parts {
    binary: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
    images: Vec<Value>,
    textures: Vec<Value>,
}

/// The meshes as GLB.
///
/// # Errors
/// [`Error::Capacity`](crate::Error::Capacity) past the 4 GiB that GLB's lengths can say.
pub fn encode_glb(meshes: &[TexturedMesh]) -> Result<Vec<u8>> {
    let mut parts = Parts::default();
    let (mut meshes_json, mut materials, mut nodes) = (Vec::new(), Vec::new(), Vec::new());
    for (k, textured) in meshes.iter().enumerate() {
        meshes_json.push(parts.mesh(textured.mesh, k));
        materials.push(parts.material(textured));
        let node = |place: &[[f32; 4]; 4]| json!({"mesh": k, "matrix": place.as_flattened()});
        nodes.extend(textured.places.iter().map(node));
    }
    let mut document = json!({
        "asset": {"version": "2.0", "generator": "invertex"},
        "scene": 0, "scenes": [{"nodes": (0..nodes.len()).collect::<Vec<_>>()}], "nodes": nodes,
        "meshes": meshes_json, "materials": materials,
        "accessors": parts.accessors, "bufferViews": parts.views,
        "buffers": [{"byteLength": parts.binary.len()}],
    });
    if !parts.images.is_empty() {
        document["images"] = parts.images.into();
        document["textures"] = parts.textures.into();
        document["samplers"] =
            json!([{"wrapS": 33071, "wrapT": 33071, "magFilter": 9729, "minFilter": 9987}]);
    }
    to_glb(&document, &parts.binary)
}

impl Parts {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.binary.resize(self.binary.len().next_multiple_of(4), 0);
        let (offset, length) = (self.binary.len(), bytes.len());
        self.views
            .push(json!({"buffer": 0, "byteOffset": offset, "byteLength": length}));
        self.binary.extend_from_slice(bytes);
        self.views.len() - 1
    }

    fn floats<const N: usize>(&mut self, values: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = values
            .as_flattened()
            .iter()
            .flat_map(|x| x.to_le_bytes())
            .collect();
        let view = self.view(&bytes);
        let kind = ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N];
        self.accessors.push(
            json!({"bufferView": view, "componentType": FLOAT, "count": values.len(), "type": kind}),
        );
        self.accessors.len() - 1
    }

    fn mesh(&mut self, mesh: &Mesh, material: usize) -> Value {
        let position = self.floats(&mesh.positions);
        let (low, high) = mesh.bounds().unwrap_or_default();
        self.accessors[position]["min"] = json!(low);
        self.accessors[position]["max"] = json!(high);
        let mut attributes = json!({"POSITION": position, "NORMAL": self.floats(&mesh.normals)});
        if let Some(uv) = mesh.uv_sets.first() {
            attributes["TEXCOORD_0"] = self.floats(uv).into();
            if !mesh.tangents.is_empty() {
                attributes["TANGENT"] = self.floats(&mesh.tangents).into();
            }
        }
        let indices = mesh.triangles.as_flattened();
        let bytes: Vec<u8> = indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let view = self.view(&bytes);
        self.accessors.push(json!({
            "bufferView": view, "componentType": UNSIGNED_INT, "count": indices.len(), "type": "SCALAR",
        }));
        let indices = self.accessors.len() - 1;
        json!({
            "name": mesh.name,
            "primitives": [{"attributes": attributes, "indices": indices, "material": material}],
        })
    }

    fn material(&mut self, textured: &TexturedMesh) -> Value {
        let mut rough = json!({"metallicFactor": 0.0, "roughnessFactor": 0.8});
        let mut material = json!({"name": textured.mesh.name});
        for &(place, png) in &textured.textures {
            let index = json!({"index": self.texture(png)});
            match place {
                TexturePlace::BaseColor => rough["baseColorTexture"] = index,
                TexturePlace::MetallicRoughness => {
                    rough = json!({
                        "baseColorTexture": rough["baseColorTexture"], "metallicRoughnessTexture": index,
                    });
                }
                TexturePlace::Normal => material["normalTexture"] = index,
                TexturePlace::Occlusion => material["occlusionTexture"] = index,
                TexturePlace::Emissive => {
                    material["emissiveTexture"] = index;
                    material["emissiveFactor"] = json!([1.0, 1.0, 1.0]);
                }
            }
        }
        if let Some(object) = rough.as_object_mut() {
            object.retain(|_, value| !value.is_null());
        }
        material["pbrMetallicRoughness"] = rough;
        material
    }

    fn texture(&mut self, png: &[u8]) -> usize {
        let view = self.view(png);
        self.images
            .push(json!({"bufferView": view, "mimeType": "image/png"}));
        self.textures
            .push(json!({"source": self.images.len() - 1, "sampler": 0}));
        self.textures.len() - 1
    }
}
