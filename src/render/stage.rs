//! From a scene to a [`Picture`].
//!
//! In: a [`Scene`] and a [`Pose`] of it; for each of its meshes what it is drawn with ([`Subject`]); which correspondence.
//! Out: a picture with every instance of the default scene as the pose has it. A reference is posed whole. Of a LoD only its
//! own vertices are: T3 does not move, so a point of the LoD asks for the same point of the reference in every pose.

use super::deform::{Frames, frames};
use super::picture::{Geometry, Picture};
use super::plain;
use crate::Result;
use crate::attribute::{AttributeSet, Prefiltered, attributes_of};
use crate::igt::{Tables, askers, layout};
use crate::lod::Lod;
use crate::mesh::Mesh;
use crate::scene::{Deformation, Instance, Pose, Rest, Scene};
use std::borrow::Cow;
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
    /// What was filtered beforehand over its primary parameterization; none: every pixel is looked up.
    pub prefiltered: Option<&'a Prefiltered>,
}

/// The picture of `scene` at rest, and what was replaced on the way. `subjects` has one element per mesh, or none for the
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
    stage_posed(scene, subjects, correspond, lit, &scene.rest())
}

/// [`stage`] of `scene` as it stands in `pose`, one of its own. For the next pose of the same picture see
/// [`Renderer::repose`](super::Renderer::repose), which keeps textures and pipelines.
///
/// # Errors
/// As [`stage`]; [`Error::Input`](crate::Error::Input) also where the pose moves a vertex out of the range of floats.
pub fn stage_posed(
    scene: &Scene,
    subjects: &[Subject],
    correspond: Correspond,
    lit: bool,
    pose: &Pose,
) -> Result<(Picture, Vec<String>)> {
    let (attributes, warnings) = attributes_of(scene, lit)?;
    let picture = stage_with(attributes, scene, subjects, correspond, pose)?;
    Ok((picture, warnings))
}

/// As [`stage_posed`], with the scene's materials and textures read already ([`attributes_of`]) and no mesh among them yet.
///
/// # Errors
/// As [`stage_posed`].
pub fn stage_with(
    attributes: AttributeSet,
    scene: &Scene,
    subjects: &[Subject],
    correspond: Correspond,
    pose: &Pose,
) -> Result<Picture> {
    let mut staging = Staging {
        picture: Picture::new(attributes),
        ready: vec![None; scene.meshes.len()],
        fetched: vec![None; scene.meshes.len()],
    };
    for instance in scene.instances_in(pose) {
        let subject = subjects.get(instance.mesh).cloned().unwrap_or_default();
        let subject = (instance.mesh, &scene.meshes[instance.mesh], &subject);
        match Deformation::of(scene, &instance, pose) {
            Some(deformation) => staging.add_deformed(subject, correspond, &deformation)?,
            None => staging.add(subject, correspond, &instance)?,
        }
    }
    Ok(staging.picture)
}

/// How a deformed geometry turns directions.
struct Turning {
    /// -1 where its skin turns it inside out.
    handed: f32,
    /// Of its vertices, where the attributes it shows are those at rest.
    frames: Option<Frames>,
}

impl Turning {
    /// `at_rest`: whether the attributes it shows are.
    fn of(deformation: Option<&Deformation>, rest: Rest, at_rest: bool) -> Self {
        Turning {
            handed: deformation.map_or(1.0, |d| d.handed(rest)),
            frames: deformation.filter(|_| at_rest).map(|d| frames(d, rest)),
        }
    }
}

struct Staging {
    picture: Picture,
    /// For each mesh that is in the picture already and that nothing deforms: geometry, first attribute triangle, tables.
    ready: Vec<Option<Ready>>,
    /// For each mesh whose attributes at rest and tables are there: first attribute triangle, number of the tables. All
    /// instances share them, however each is deformed.
    fetched: Vec<Option<(u32, u32)>>,
}

type Ready = (Geometry, u32, Option<u32>);

/// A mesh, its number, and what it is drawn with.
type Numbered<'a> = (usize, &'a Mesh, &'a Subject<'a>);

impl Staging {
    fn add(
        &mut self,
        subject: Numbered,
        correspond: Correspond,
        instance: &Instance,
    ) -> Result<()> {
        let (geometry, base, tables) = match self.ready[instance.mesh] {
            Some(ready) => ready,
            None => self.prepare(subject, correspond, None)?,
        };
        self.ready[instance.mesh] = Some((geometry, base, tables));
        self.picture.draw(geometry, base, tables, instance.world)
    }

    fn add_deformed(
        &mut self,
        subject: Numbered,
        correspond: Correspond,
        deformation: &Deformation,
    ) -> Result<()> {
        let (geometry, base, tables) = self.prepare(subject, correspond, Some(deformation))?;
        self.picture
            .draw(geometry, base, tables, deformation.world())
    }

    fn prepare(
        &mut self,
        (number, mesh, subject): Numbered,
        correspond: Correspond,
        deformation: Option<&Deformation>,
    ) -> Result<Ready> {
        let inverse = subject
            .tables
            .as_ref()
            .filter(|_| correspond != Correspond::Reference);
        let Some(tables) = inverse else {
            let turning = Turning::of(deformation, mesh.into(), false);
            let posed = deformation.map(|d| d.mesh(mesh)).transpose()?;
            let mesh = posed.as_ref().unwrap_or(mesh);
            return self.own((mesh, Some(number)), &mesh.positions, &turning, 0.0);
        };
        let lod = match subject.lod {
            Some(lod) => Cow::Borrowed(lod),
            None => Cow::Owned(level_zero(mesh, tables, subject.layers)),
        };
        let rest = Rest::from(lod.as_ref());
        let positions = match deformation {
            Some(deformation) => Cow::Owned(deformation.positions(&mesh.name, rest)?),
            None => Cow::Borrowed(&lod.positions),
        };
        let mut turning = Turning::of(deformation, rest, true);
        if correspond == Correspond::Plain {
            let plain = plain::mesh(mesh, &lod, tables);
            let corners = lod.triangles.as_flattened().iter().map(|&v| v as usize);
            let positions: Vec<[f32; 3]> = corners.clone().map(|v| positions[v]).collect();
            turning.frames = turning.frames.map(|frames| frames.of(corners));
            return self.own((&plain, None), &positions, &turning, lod.error);
        }
        let (base, number) = match self.fetched[number] {
            Some(there) => there,
            None => {
                let base = self.picture.attributes.push_mesh_of_scene(mesh, number)?;
                let tables = self
                    .picture
                    .add_tables(Arc::clone(tables), subject.prefiltered)?;
                *self.fetched[number].insert((base, tables))
            }
        };
        let line = tables.primary.line();
        let geometry = self.picture.add_geometry(
            &positions,
            &lod.triangles,
            &lod.t3,
            &askers(line, &lod),
            lod.error,
        )?;
        let geometry = self.turned(geometry, &turning)?;
        Ok((geometry, base, Some(number)))
    }

    /// A mesh that is its own reference, with its number, or (`slack`) a level of detail with attributes of its own; it is
    /// drawn at `positions`.
    fn own(
        &mut self,
        (mesh, number): (&Mesh, Option<usize>),
        positions: &[[f32; 3]],
        turning: &Turning,
        slack: f32,
    ) -> Result<Ready> {
        let attributes = &mut self.picture.attributes;
        let base = match number {
            Some(number) => attributes.push_mesh_of_scene(mesh, number)?,
            None => attributes.push_mesh(mesh)?,
        };
        let geometry = self
            .picture
            .add_geometry(positions, &mesh.triangles, &[], &[], slack)?;
        Ok((self.turned(geometry, turning)?, base, None))
    }

    fn turned(&mut self, geometry: Geometry, turning: &Turning) -> Result<Geometry> {
        let geometry = geometry.with_handed(turning.handed);
        match &turning.frames {
            Some(frames) => self.picture.with_frames(geometry, frames),
            None => Ok(geometry),
        }
    }
}

/// The reference's own geometry as a LoD: its T3 is what the tables hold, bit for bit.
pub(crate) fn level_zero(mesh: &Mesh, tables: &Tables, layers: &[u8]) -> Lod {
    let primary = &tables.primary;
    let t3 = |v: usize| {
        let grid = primary.to_grid(primary.t3_of(mesh, v));
        tables.format.record.round(grid, layout::is_flat(primary))
    };
    Lod {
        positions: mesh.positions.clone(),
        normals: mesh.normals.clone(),
        t3: (0..mesh.positions.len()).map(t3).collect(),
        triangles: mesh.triangles.clone(),
        triangle_layer: layers.to_vec(),
        joints: mesh.joints.clone(),
        weights: mesh.weights.clone(),
        targets: mesh.targets.clone(),
        ..Lod::default()
    }
}
