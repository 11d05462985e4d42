//! From glTF meshes to [`Mesh`]: primitives concatenated in file order.
//!
//! In: primitives and the accessor reader. Out: one mesh per glTF mesh (empty where nothing in it is a triangle), all
//! triangles of the file in the file's order, degenerate ones included. Points and lines are skipped with a warning; strips
//! and fans become triangles. Primitives that name the same accessors share their vertices.

use super::accessor::Reader;
use super::json::{MeshJson, Primitive, Root, at};
use super::material::Material;
use super::morph;
use super::vertex::{Vertices, read_vertices};
use crate::mesh::{CustomAttribute, Embedding, Mesh, smooth_normals};
use crate::{Error, Result};
use std::collections::{BTreeMap, HashMap};

/// What all meshes of a document share while they are read.
pub(super) struct Meshes<'a> {
    pub(super) reader: &'a Reader<'a>,
    pub(super) root: &'a Root,
    pub(super) materials: &'a [Material],
    pub(super) warnings: &'a mut Vec<String>,
    /// Some primitive has no material: the default one, after all others, is needed.
    pub(super) default_material_used: bool,
}

/// Of the vertices of a primitive, and of each morph target.
type Accessors<'a> = (&'a BTreeMap<String, usize>, &'a [BTreeMap<String, usize>]);

/// Vertices of a mesh being put together, and where triangles point.
#[derive(Default)]
struct Parts<'a> {
    blocks: Vec<Vertices>,
    /// First vertex of the block of primitives with these accessors.
    known: HashMap<Accessors<'a>, (u32, usize)>,
    vertices: usize,
    triangles: Vec<[u32; 3]>,
    materials: Vec<u32>,
}

impl<'a> Meshes<'a> {
    /// Reads all meshes.
    pub(super) fn all(&mut self) -> Result<Vec<Mesh>> {
        let root = self.root;
        root.meshes
            .iter()
            .enumerate()
            .map(|(m, json)| self.mesh(m, json))
            .collect()
    }

    /// Reads mesh `m`.
    fn mesh(&mut self, m: usize, json: &'a MeshJson) -> Result<Mesh> {
        let mut parts = Parts::default();
        for (p, primitive) in json.primitives.iter().enumerate() {
            self.primitive(
                &mut parts,
                &format!("meshes[{m}].primitives[{p}]"),
                primitive,
            )?;
        }
        let name = json.name.clone().unwrap_or_else(|| format!("mesh_{m}"));
        let element = format!("meshes[{m}]");
        let mut mesh = self.assemble(name, parts, &element)?;
        mesh.target_weights = morph::rest_weights(
            self.reader.file,
            &element,
            json,
            mesh.targets.len(),
            self.warnings,
        )?;
        Ok(mesh)
    }

    fn primitive(
        &mut self,
        parts: &mut Parts<'a>,
        element: &str,
        primitive: &'a Primitive,
    ) -> Result<()> {
        let material = match primitive.material {
            Some(i) => {
                at(self.reader.file, self.materials, "materials", i, || {
                    format!("{element}.material")
                })?;
                i
            }
            None => self.materials.len(),
        };
        if primitive.mode > 6 {
            return Err(self.fault(element, format!("mode {} does not exist", primitive.mode)));
        }
        if !primitive.attributes.contains_key("POSITION") {
            self.warnings
                .push(format!("{element} has no POSITION: skipped"));
            return Ok(());
        }
        if primitive.mode < 4 {
            self.warnings
                .push(format!("{element} is made of points or lines: skipped"));
            return Ok(());
        }
        let (first, count) = self.vertices(parts, element, primitive)?;
        let indices = self.indices(element, primitive, count)?;
        let triangles = self.triangles(element, primitive.mode, &indices)?;
        parts
            .materials
            .resize(parts.materials.len() + triangles.len(), material as u32);
        parts
            .triangles
            .extend(triangles.iter().map(|t| t.map(|v| v + first)));
        self.default_material_used |= primitive.material.is_none();
        Ok(())
    }

    /// First vertex and number of vertices of a primitive, read unless another has read the same.
    fn vertices(
        &mut self,
        parts: &mut Parts<'a>,
        element: &str,
        primitive: &'a Primitive,
    ) -> Result<(u32, usize)> {
        let accessors = (&primitive.attributes, primitive.targets.as_slice());
        if let Some(&known) = parts.known.get(&accessors) {
            return Ok(known);
        }
        let mut block = read_vertices(self.reader, element, accessors.0, self.warnings)?;
        let count = block.positions.len();
        block.targets = morph::read_targets(self.reader, element, accessors.1, count)?;
        let found = (parts.vertices as u32, count);
        parts.vertices += count;
        if u32::try_from(parts.vertices).is_err() {
            return Err(self.fault(element, "more than 2^32 vertices in one mesh"));
        }
        parts.blocks.push(block);
        parts.known.insert(accessors, found);
        Ok(found)
    }

    /// Vertex indices of a primitive, each below `vertices`.
    fn indices(&self, element: &str, primitive: &Primitive, vertices: usize) -> Result<Vec<u32>> {
        let Some(accessor) = primitive.indices else {
            self.reader.charge(vertices, 4, || element.into())?;
            return Ok((0..vertices as u32).collect());
        };
        let indices = self
            .reader
            .unsigned::<1>(accessor, || format!("{element}.indices"))?
            .into_flattened();
        match indices.iter().position(|&v| v as usize >= vertices) {
            Some(i) => {
                let reason = format!("index {i} is {}, there are {vertices} vertices", indices[i]);
                Err(self.fault(element, reason))
            }
            None => Ok(indices),
        }
    }

    /// Triangles of a list (mode 4), strip (5) or fan (6), in glTF's order and winding (3.7.2.1).
    fn triangles(&mut self, element: &str, mode: u32, v: &[u32]) -> Result<Vec<[u32; 3]>> {
        if v.len() < 3 {
            self.warnings.push(format!(
                "{element} has {} indices, which make no triangle",
                v.len()
            ));
            return Ok(Vec::new());
        }
        let count = if mode == 4 { v.len() / 3 } else { v.len() - 2 };
        self.reader.charge(count, 16, || element.into())?;
        if mode == 4 && !v.len().is_multiple_of(3) {
            self.warnings.push(format!(
                "{element} has {} indices, not a multiple of 3: the rest is left out",
                v.len()
            ));
        }
        Ok(match mode {
            4 => v.as_chunks::<3>().0.to_vec(),
            5 => (0..count)
                .map(|i| [v[i], v[i + 1 + i % 2], v[i + 2 - i % 2]])
                .collect(),
            _ => (0..count).map(|i| [v[i + 1], v[i + 2], v[0]]).collect(),
        })
    }

    fn fault(&self, element: &str, reason: impl Into<String>) -> Error {
        Error::input(self.reader.file, element, reason)
    }

    /// Puts the blocks together: arrays that some blocks have get a neutral value in the others.
    fn assemble(&mut self, name: String, parts: Parts, element: &str) -> Result<Mesh> {
        let blocks = &parts.blocks;
        let sets = blocks.iter().map(|b| b.uv_sets.len()).max().unwrap_or(0);
        let padding = 80 + 8 * sets;
        self.reader
            .charge(parts.vertices, padding, || element.into())?;
        if parts.triangles.len() > u32::MAX as usize / 3 {
            return Err(self.fault(element, "more than 2^32 / 3 triangles in one mesh"));
        }
        let mut mesh = Mesh {
            name,
            positions: blocks
                .iter()
                .flat_map(|b| b.positions.iter().copied())
                .collect(),
            uv_sets: (0..sets)
                .map(|s| fill(blocks, true, [0.0; 2], |b| b.uv_sets.get(s)))
                .collect(),
            colors: fill(blocks, any(blocks, |b| b.colors.is_some()), [1.0; 4], |b| {
                b.colors.as_ref()
            }),
            joints: fill(blocks, any(blocks, |b| b.joints.is_some()), [0; 4], |b| {
                b.joints.as_ref()
            }),
            weights: fill(
                blocks,
                any(blocks, |b| b.joints.is_some()),
                [1.0, 0.0, 0.0, 0.0],
                |b| b.weights.as_ref(),
            ),
            tangents: fill(blocks, sets > 0, [0.0; 4], |b| b.tangents.as_ref()),
            normals: fill(blocks, true, [0.0; 3], |b| b.normals.as_ref()),
            triangles: parts.triangles,
            triangle_material: parts.materials,
            targets: morph::join(
                self.reader,
                element,
                &blocks
                    .iter()
                    .map(|b| (b.targets.as_slice(), b.positions.len()))
                    .collect::<Vec<_>>(),
                self.warnings,
            )?,
            target_weights: vec![],
            custom: self.custom(blocks, element)?,
            embedding: Embedding::default(),
        };
        let lacks = |get: fn(&Vertices) -> bool| -> Vec<bool> {
            blocks
                .iter()
                .flat_map(|b| std::iter::repeat_n(get(b), b.positions.len()))
                .collect()
        };
        let made = lacks(|b| b.normals.is_none());
        add_normals(&mut mesh, &made);
        morph::add_normals(self.reader, element, &mut mesh, &made)?;
        if sets > 0 {
            let without = lacks(|b| b.tangents.is_none());
            self.reader
                .charge(mesh.triangles.len(), 240, || element.into())?;
            self.add_tangents(&mut mesh, &without);
        }
        Ok(mesh)
    }

    /// Custom attributes of all blocks, 0 where a block lacks one. Where blocks disagree in the width, the widest counts.
    fn custom(&self, blocks: &[Vertices], element: &str) -> Result<Vec<CustomAttribute>> {
        let mut width: BTreeMap<&str, usize> = BTreeMap::new();
        for custom in blocks.iter().flat_map(|b| &b.custom) {
            let known = width.entry(&custom.name).or_default();
            *known = custom.width.max(*known);
        }
        let vertices = blocks.iter().map(|b| b.positions.len()).sum::<usize>();
        let mut out = Vec::new();
        for (name, width) in width {
            self.reader.charge(vertices, 4 * width, || element.into())?;
            let mut values = Vec::with_capacity(vertices * width);
            for block in blocks {
                let own = block.custom.iter().find(|c| c.name == name);
                for v in 0..block.positions.len() {
                    let number = |k: usize| match own {
                        Some(own) if k < own.width => own.values[v * own.width + k],
                        _ => 0.0,
                    };
                    values.extend((0..width).map(number));
                }
            }
            out.push(CustomAttribute {
                name: name.to_owned(),
                width,
                values,
            });
        }
        Ok(out)
    }

    /// Tangents for the triangles whose vertices have none, in the uv set of their normal map (the first without one).
    fn add_tangents(&self, mesh: &mut Mesh, without: &[bool]) {
        let set_of = |(triangle, &material): (&[u32; 3], &u32)| {
            let normal_map = self
                .materials
                .get(material as usize)
                .and_then(|m| m.normal_texture);
            let set = normal_map.map_or(0, |t| t.uv_set);
            without[triangle[0] as usize].then_some(if set < mesh.uv_sets.len() { set } else { 0 })
        };
        let sets: Vec<Option<usize>> = mesh
            .triangles
            .iter()
            .zip(&mesh.triangle_material)
            .map(set_of)
            .collect();
        if sets.iter().any(Option::is_some) {
            mesh.generate_tangents(&sets);
        }
        // Vertices that no triangle uses.
        for (tangent, normal) in mesh.tangents.iter_mut().zip(&mesh.normals) {
            if *tangent == [0.0; 4] {
                let across = glam::Vec3::from_array(*normal).any_orthogonal_vector();
                *tangent = across.normalize_or(glam::Vec3::X).extend(1.0).to_array();
            }
        }
    }
}

fn any(blocks: &[Vertices], has: fn(&Vertices) -> bool) -> bool {
    blocks.iter().any(has)
}

/// One array of all blocks, `neutral` where a block has none; empty unless `wanted`.
fn fill<'a, T: Copy + 'a>(
    blocks: &'a [Vertices],
    wanted: bool,
    neutral: T,
    get: impl Fn(&'a Vertices) -> Option<&'a Vec<T>>,
) -> Vec<T> {
    let mut out = Vec::new();
    for block in blocks.iter().filter(|_| wanted) {
        match get(block) {
            Some(values) => out.extend(values),
            None => out.resize(out.len() + block.positions.len(), neutral),
        }
    }
    out
}

/// Smooth normals for the vertices that have none, from the triangles between them.
fn add_normals(mesh: &mut Mesh, without: &[bool]) {
    if !without.contains(&true) {
        return;
    }
    let triangles: Vec<[u32; 3]> = mesh
        .triangles
        .iter()
        .copied()
        .filter(|t| without[t[0] as usize])
        .collect();
    let found = smooth_normals(&mesh.positions, &triangles);
    for (v, normal) in found.into_iter().enumerate().filter(|(v, _)| without[*v]) {
        mesh.normals[v] = normal;
    }
}
