//! A triangle mesh as flat arrays: what every later stage reads.
//!
//! In: nothing but numbers. Out: [`Mesh`], whose invariants ([`Mesh::validate`]) every stage may rely on: indices in
//! range, arrays of equal length or empty, floats finite.

/// One reference mesh: all primitives of a glTF mesh, concatenated in file order.
///
/// Triangle `t` of the mesh is the `t`-th triangle of the file (degenerate ones included), so ids mean the same
/// outside. Per-vertex arrays have one element per vertex or are empty.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// The mesh's name in the file, or `mesh_N`.
    pub name: String,
    /// Object-space positions, in the file's unit.
    pub positions: Vec<[f32; 3]>,
    /// Unit normals; always present (computed by area weights where the file has none).
    pub normals: Vec<[f32; 3]>,
    /// Unit tangent and handedness (+1 or -1); empty where there is no uv set.
    pub tangents: Vec<[f32; 4]>,
    /// Artist uv sets TEXCOORD_0.., each with one element per vertex (a primitive that lacks a set gets zeros).
    pub uv_sets: Vec<Vec<[f32; 2]>>,
    /// Linear RGBA COLOR_0; empty where no primitive has one (white where only some have).
    pub colors: Vec<[f32; 4]>,
    /// Skin joints (indices into the skin's joint list); empty for unskinned meshes.
    pub joints: Vec<[u16; 4]>,
    /// Skin weights; empty for unskinned meshes.
    pub weights: Vec<[f32; 4]>,
    /// Vertex indices, three per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle its material (index into the scene's materials).
    pub triangle_material: Vec<u32>,
}
