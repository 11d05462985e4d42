//! From a scene to a [`Picture`].
//!
//! In: a [`Scene`]; for each of its meshes what it is drawn with ([`Subject`]); which correspondence. Out: a picture with
//! every instance of the default scene, skinned ones at rest.

use super::picture::{Geometry, Picture};
use super::{plain, skin};
use crate::Result;
use crate::attribute::{AttributeSet, attributes_of};
use crate::igt::{Tables, askers, layout};
use crate::lod::Lod;
use crate::mesh::Mesh;
use crate::scene::{Instance, Scene};
use glam::DMat4;
use std::sync::Arc;

/// Where a drawn point's appearance comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Correspond {
    /// The reference's own geometry.
    #[default]
    Reference,
    /// A LoD, through the inverse geometric texture.
    Inverse,
    /// A LoD with artist attributes at its corners (`plain.rs`).
    Plain,
}

/// What one mesh of a scene is drawn with. A mesh without tables is drawn as the reference.
#[derive(Clone, Debug, Default)]
pub struct Subject<'a> {
    /// Its inverse geometric texture.
    pub tables: Option<Arc<Tables>>,
    /// The LoD that is drawn; none: the reference's own geometry as level 0.
    pub lod: Option<&'a Lod>,
    /// Layers of the reference's triangles (empty: any), for level 0.
    pub layers: &'a [u8],
}

/// The picture of `scene`, and what was replaced on the way. `subjects` has one element per mesh, or none for the
/// reference alone. `lit`: whether more than base colour will be drawn.
///
/// # Errors
/// [`Error::Capacity`](crate::Error::Capacity) where textures or meshes are too large;
/// [`Error::Input`](crate::Error::Input) where a transform is not finite.
pub fn stage(
    scene: &Scene,
    subjects: &[Subject],
    correspond: Correspond,
    lit: bool,
) -> Result<(Picture, Vec<String>)> {
    let (attributes, warnings) = attributes_of(scene, lit)?;
    let mut staging = Staging {
        picture: Picture::new(attributes),
        ready: vec![None; scene.meshes.len()],
    };
    for instance in scene.instances() {
        let subject = subjects.get(instance.mesh).cloned().unwrap_or_default();
        staging.add(scene, &instance, &subject, correspond)?;
    }
    Ok((staging.picture, warnings))
}

struct Staging {
    picture: Picture,
    /// For each mesh that is in the picture already, unskinned: geometry, first attribute triangle, tables.
    ready: Vec<Option<Ready>>,
}

type Ready = (Geometry, u32, Option<u32>);

impl Staging {
    fn add(
        &mut self,
        scene: &Scene,
        instance: &Instance,
        subject: &Subject,
        correspond: Correspond,
    ) -> Result<()> {
        let mesh = &scene.meshes[instance.mesh];
        if let Some(skin) = instance.skin.filter(|_| !mesh.joints.is_empty()) {
            let palette = skin::palette(scene, &scene.skins[skin]);
            let (geometry, base, tables) =
                self.prepare(mesh, subject, correspond, Some(&palette))?;
            return self.picture.draw(geometry, base, tables, DMat4::IDENTITY);
        }
        let (geometry, base, tables) = match self.ready[instance.mesh] {
            Some(ready) => ready,
            None => self.prepare(mesh, subject, correspond, None)?,
        };
        self.ready[instance.mesh] = Some((geometry, base, tables));
        self.picture.draw(geometry, base, tables, instance.world)
    }

    fn prepare(
        &mut self,
        mesh: &Mesh,
        subject: &Subject,
        correspond: Correspond,
        palette: Option<&[DMat4]>,
    ) -> Result<Ready> {
        let placed = palette.map(|p| skin::mesh(p, mesh));
        let reference = placed.as_ref().unwrap_or(mesh);
        let inverse = subject
            .tables
            .as_ref()
            .filter(|_| correspond != Correspond::Reference);
        let Some(tables) = inverse else {
            return self.own(reference, 0.0);
        };
        let lod = match subject.lod {
            Some(lod) => placed_lod(lod, palette),
            None => level_zero(mesh, reference, tables, subject.layers),
        };
        if correspond == Correspond::Plain {
            return self.own(&plain::mesh(reference, &lod, tables), lod.error);
        }
        let base = self.attributes().push_mesh(reference)?;
        let line = tables.primary.line();
        let geometry = self.picture.add_geometry(
            &lod.positions,
            &lod.triangles,
            &lod.t3,
            &askers(line, &lod.t3, &lod.triangles, &lod.triangle_layer),
            lod.error,
        )?;
        let tables = self.picture.add_tables(Arc::clone(tables));
        Ok((geometry, base, Some(tables)))
    }

    /// A mesh that is its own reference, or (`slack`) a level of detail with attributes of its own.
    fn own(&mut self, mesh: &Mesh, slack: f32) -> Result<Ready> {
        let base = self.attributes().push_mesh(mesh)?;
        let geometry =
            self.picture
                .add_geometry(&mesh.positions, &mesh.triangles, &[], &[], slack)?;
        Ok((geometry, base, None))
    }

    fn attributes(&mut self) -> &mut AttributeSet {
        &mut self.picture.attributes
    }
}

fn placed_lod(lod: &Lod, palette: Option<&[DMat4]>) -> Lod {
    let mut out = lod.clone();
    if let Some(palette) = palette {
        out.positions = skin::positions(palette, &lod.positions, &lod.joints, &lod.weights);
    }
    out
}

/// The reference's own geometry as a LoD: its T3 is what the tables hold, bit for bit.
fn level_zero(mesh: &Mesh, placed: &Mesh, tables: &Tables, layers: &[u8]) -> Lod {
    let primary = &tables.primary;
    let t3 = |v: usize| {
        let grid = primary.to_grid(primary.t3_of(mesh, v));
        tables.format.record.round(grid, layout::is_flat(primary))
    };
    Lod {
        positions: placed.positions.clone(),
        normals: placed.normals.clone(),
        t3: (0..mesh.positions.len()).map(t3).collect(),
        triangles: mesh.triangles.clone(),
        triangle_layer: layers.to_vec(),
        ..Lod::default()
    }
}
