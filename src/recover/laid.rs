//! The simple surface of a recovery: a mesh with texture coordinates in the unit square, in the world.
//!
//! In: a mesh as it stands. Out: [`Laid`], cut along a layout of its own where the mesh brings none; one for each tile where its
//! texture coordinates lie in several.

use super::atlas::{self, Atlas};
use super::low::unwrapped;
use super::standing::{Standing, placed};
use super::udim::{self, Tile};
use crate::attribute::arithmetic::{V3, add3, unit3, weighted};
use crate::lod::Lod;
use crate::mesh::{Mesh, Weld, components};
use crate::{Error, Result};

/// Where texture coordinates come from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum UvLayout {
    /// The mesh's first uv set; charts of our own where it has none.
    #[default]
    Auto,
    /// The mesh's first uv set.
    Uv0,
    /// Charts of triangles that face one way, packed.
    Charts,
    /// Each triangle by itself, two in a square: the paper's trivial layout.
    Triangles,
}

/// A surface that textures are made for.
pub(crate) struct Laid {
    /// As its file has it, texture coordinates (set 0, in the unit square) and tangents added.
    pub(crate) object: Mesh,
    /// The same in the world.
    pub(crate) world: Mesh,
    pub(crate) place: glam::DMat4,
    /// For each vertex the one that stands for all in its place.
    pub(crate) weld: Weld,
    /// For each vertex the direction of normal rays: the mean of the normals in its place, so that rays do not part where
    /// normals or charts do.
    pub(crate) outward: Vec<V3>,
    /// For each triangle its chart.
    pub(crate) chart: Vec<u32>,
    /// For each triangle its corners on the cage; empty without one.
    pub(crate) cage: Vec<[V3; 3]>,
    /// The number of the mesh in its scene.
    pub(crate) number: usize,
    /// The UDIM number of its tile, where there are several.
    pub(crate) tile: Option<u32>,
    /// What was made up on the way.
    pub(crate) warnings: Vec<String>,
}

/// How a simple model is laid out.
pub(crate) struct Laying<'a> {
    /// What messages call it.
    pub(crate) file: &'a str,
    pub(crate) layout: UvLayout,
    /// Texels along a side.
    pub(crate) size: u32,
}

impl Laid {
    /// The surfaces that mesh `rest` is, `cage` the corners of its triangles on the cage.
    ///
    /// # Errors
    /// [`Error::Input`] for texture coordinates that cannot be used; [`Error::Capacity`] where a layout of our own does not
    /// fit `size` x `size` texels.
    pub(crate) fn all(
        laying: &Laying,
        rest: &Mesh,
        stood: &Standing,
        cage: &[[V3; 3]],
    ) -> Result<Vec<Laid>> {
        let &Laying { file, layout, size } = laying;
        let mut warnings = Vec::new();
        let has_uv = !rest.uv_sets.is_empty();
        let object = match layout {
            UvLayout::Uv0 if !has_uv => {
                let reason = "has no TEXCOORD_0; leave the layout to `--uv auto`";
                return Err(fault(file, rest, reason));
            }
            UvLayout::Triangles => cut(rest, atlas::triangles, size)?,
            UvLayout::Auto | UvLayout::Uv0 if has_uv => artists(rest),
            _ => {
                if layout == UvLayout::Auto {
                    let name = &rest.name;
                    warnings.push(format!(
                        "mesh \"{name}\" has no texture coordinates: charts were laid out for it"
                    ));
                }
                cut(rest, atlas::boxes, size)?
            }
        };
        let world = placed(&object, stood.world);
        // What tiles share is found before they part.
        let directions = outward(&world, &Weld::by_position(&world.positions));
        let tiles = udim::tiles(file, &object)?;
        let several = tiles.len() > 1;
        let laid = |tile: &Tile| {
            let (part, of) = udim::cut_out(&object, tile);
            let mut warnings = std::mem::take(&mut warnings);
            if !several && tile.at != [0, 0] {
                let ([u, v], name) = (tile.at, &part.name);
                warnings.push(format!(
                    "mesh \"{name}\": texture coordinates are moved from tile {u}, {v} to 0, 0"
                ));
            }
            let world = placed(&part, stood.world);
            let charts = Weld::by_position_and_uv(&world, 0).triangles(&world.triangles);
            Laid {
                chart: components(&charts, world.positions.len()).of,
                weld: Weld::by_position(&world.positions),
                outward: udim::picked(&directions, &of),
                cage: turned(udim::picked(cage, &tile.triangles), stood.world),
                object: part,
                world,
                place: stood.world,
                number: stood.number,
                tile: several.then(|| tile.number()),
                warnings,
            }
        };
        Ok(tiles.iter().map(laid).collect())
    }

    /// Numbers of the vertices, weighted.
    pub(crate) fn weighted(&self, of: &[V3], t: usize, b: [f32; 3]) -> V3 {
        let [i, j, k] = self.world.triangles[t];
        weighted(&[of[i as usize], of[j as usize], of[k as usize]], b)
    }

    /// A point of the surface.
    pub(crate) fn point(&self, t: usize, b: [f32; 3]) -> V3 {
        self.weighted(&self.world.positions, t, b)
    }

    /// Its texture coordinates.
    pub(crate) fn uv(&self, t: usize, b: [f32; 3]) -> [f32; 2] {
        let [i, j, k] = self.world.triangles[t].map(|v| self.world.uv_sets[0][v as usize]);
        [0, 1].map(|x| b[0] * i[x] + b[1] * j[x] + b[2] * k[x])
    }
}

fn fault(file: &str, mesh: &Mesh, reason: impl Into<String>) -> Error {
    Error::input(file, format!("mesh \"{}\"", mesh.name), reason)
}

/// `mesh` with a layout of our own.
fn cut(mesh: &Mesh, layout: fn(&Lod, u32) -> Result<Atlas>, size: u32) -> Result<Mesh> {
    let lod = Lod {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        triangles: mesh.triangles.clone(),
        joints: mesh.joints.clone(),
        weights: mesh.weights.clone(),
        targets: mesh.targets.clone(),
        ..Lod::default()
    };
    let atlas = layout(&lod, size)?;
    Ok(unwrapped(mesh, &lod, &atlas))
}

/// `mesh` with its own texture coordinates and tangents along them.
fn artists(mesh: &Mesh) -> Mesh {
    let mut out = mesh.clone();
    out.uv_sets.truncate(1);
    if out.tangents.len() != out.positions.len() {
        out.tangents = vec![[0.0; 4]; out.positions.len()];
        out.generate_tangents(&vec![Some(0); out.triangles.len()]);
    }
    out
}

/// Corners of a cage in the order of triangles that a placing may have turned round.
fn turned(mut cage: Vec<[V3; 3]>, world: glam::DMat4) -> Vec<[V3; 3]> {
    if world.determinant() < 0.0 {
        cage.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    cage
}

fn outward(mesh: &Mesh, weld: &Weld) -> Vec<V3> {
    let mut sums = vec![[0.0; 3]; mesh.positions.len()];
    for (v, normal) in mesh.normals.iter().enumerate() {
        let sum = &mut sums[weld.of[v] as usize];
        *sum = add3(*sum, *normal);
    }
    let mean = |v: usize| unit3(sums[weld.of[v] as usize], mesh.normals[v]);
    (0..mesh.positions.len()).map(mean).collect()
}
