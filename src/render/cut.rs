//! Cuts of a built model: each mesh with a multiresolution model gets, for a camera, the triangles that it needs.
//!
//! In: a [`Built`] model, cameras one after the other, limits. Out: [`Cuts`]: levels of detail to draw in place of the chain's.
//! A mesh that stands in several places gets one cut that will do for all of them.

use super::camera::Camera;
use super::levels::in_chain;
use super::stage::Subject;
use crate::asset::{Built, BuiltMesh};
use crate::lod::multiresolution::{Cut, Hierarchy, Limits, Memory, Seen, View};
use crate::lod::{Lod, LodInput};
use crate::mesh::{Adjacency, Mesh, Weld};
use crate::param::{Parts, parts};
use crate::scene::{Instance, Scene};
use crate::{Error, Result};
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// What cuts the meshes of a model; it remembers the last cut, for hysteresis.
pub struct Cutter<'a> {
    built: &'a Built,
    /// One for each mesh of the scene that has a multiresolution model.
    meshes: Vec<Option<Cutting<'a>>>,
    instances: Vec<Instance>,
}

struct Cutting<'a> {
    mesh: &'a Mesh,
    built: &'a BuiltMesh,
    hierarchy: &'a Hierarchy,
    parts: Parts,
    /// Whether its back sides are seen: it has a rim, or a material has two sides.
    double_sided: bool,
    memory: Memory,
    /// The triangles of the last cut.
    last: Vec<u32>,
}

/// The cuts of all meshes for a camera.
#[derive(Clone, Debug, Default)]
pub struct Cuts {
    /// For each mesh of the scene its level; none for a mesh without a multiresolution model.
    pub lods: Vec<Option<Lod>>,
    /// Triangles of all cuts, each mesh counted once.
    pub triangles: usize,
    /// Collapses and blocks of them that were asked.
    pub asked: usize,
    /// Triangles that the cuts before did not have.
    pub changed: usize,
    /// Pixels that nothing that faces the eye is displaced by more than, as the model knows it: at most the limit where pixels
    /// alone decide. Infinite where the eye stands in a region that is judged as one.
    pub displacement: f64,
    /// Milliseconds that the selection took, on all cores; without the making of levels.
    pub milliseconds: f64,
}

impl<'a> Cutter<'a> {
    /// None where no mesh has a multiresolution model.
    pub fn new(built: &'a Built) -> Option<Self> {
        if built.meshes.iter().all(|mesh| mesh.hierarchy.is_none()) {
            return None;
        }
        let cutting = |mesh: usize| {
            let of_mesh = built.of_mesh(mesh)?;
            let hierarchy = of_mesh.hierarchy.as_ref()?;
            let mesh = &built.scene.meshes[mesh];
            Some(Cutting {
                mesh,
                built: of_mesh,
                hierarchy,
                parts: parts(mesh, &of_mesh.tables.primary),
                double_sided: is_seen_from_behind(mesh, &built.scene),
                memory: Memory::default(),
                last: Vec::new(),
            })
        };
        Some(Cutter {
            built,
            meshes: (0..built.scene.meshes.len()).map(cutting).collect(),
            instances: built.scene.instances(),
        })
    }

    /// Whether some mesh knows what its colours are off by; others are cut by pixels alone.
    pub fn knows_colours(&self) -> bool {
        let mut meshes = self.meshes.iter().flatten();
        meshes.any(|cutting| cutting.hierarchy.colours.is_some())
    }

    /// The cuts for `camera`.
    ///
    /// # Errors
    /// [`Error::Option`] for limits that are none, or a mesh that stands where no camera sees it right (a matrix that cannot
    /// be undone).
    pub fn cut(&mut self, camera: &Camera, limits: &Limits) -> Result<Cuts> {
        let views = self.views(camera, limits)?;
        let start = Instant::now();
        let cuts: Vec<_> = self
            .meshes
            .par_iter_mut()
            .zip(&views)
            .map(|(cutting, views)| {
                let cutting = cutting.as_mut()?;
                let model = &cutting.hierarchy.model;
                Some(model.select(views, &mut cutting.memory))
            })
            .collect();
        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
        let cut = cuts.iter().flatten();
        let (triangles, asked) =
            cut.fold((0, 0), |(t, a), cut| (t + cut.faces.len(), a + cut.asked));
        let displacement = self.displacement(&views, &cuts);
        let lods = self.meshes.par_iter().zip(&cuts).map(|(cutting, cut)| {
            let (cutting, cut) = cutting.as_ref().zip(cut.as_ref())?;
            Some(cutting.hierarchy.lod(&cutting.input(), cut))
        });
        let lods = lods.collect();
        let kept = self.meshes.iter_mut().zip(cuts).map(|(cutting, cut)| {
            let (cutting, cut) = cutting.as_mut().zip(cut)?;
            let new = cut
                .faces
                .iter()
                .filter(|f| cutting.last.binary_search(f).is_err())
                .count();
            cutting.last = cut.faces;
            Some(new)
        });
        let changed = kept.flatten().sum();
        Ok(Cuts {
            lods,
            triangles,
            asked,
            changed,
            displacement,
            milliseconds,
        })
    }

    /// For each mesh of the scene how its instances are seen; none of a mesh without a multiresolution model.
    ///
    /// # Errors
    /// As [`Cutter::cut`].
    pub fn views(&self, camera: &Camera, limits: &Limits) -> Result<Vec<Vec<View>>> {
        limits.check()?;
        let mut views: Vec<Vec<View>> = vec![Vec::new(); self.meshes.len()];
        for instance in &self.instances {
            if let Some(cutting) = &self.meshes[instance.mesh] {
                views[instance.mesh].push(cutting.view(camera, instance, limits)?);
            }
        }
        Ok(views)
    }

    fn displacement(&self, views: &[Vec<View>], cuts: &[Option<Cut>]) -> f64 {
        let meshes = self.meshes.par_iter().zip(views).zip(cuts);
        let of_mesh = meshes.map(|((cutting, views), cut)| match (cutting, cut) {
            (Some(cutting), Some(cut)) => cutting.hierarchy.model.displacement(views, cut),
            _ => 0.0,
        });
        of_mesh.reduce(|| 0.0, f64::max)
    }

    /// What each mesh is drawn with: its cut, or the chain's level where it has none.
    pub fn subjects<'b>(&'b self, cuts: &'b Cuts, level: usize) -> Vec<Subject<'b>> {
        let subject = |mesh: usize| match self.built.of_mesh(mesh) {
            None => Subject::default(),
            Some(b) => Subject {
                tables: Some(Arc::new(b.tables.clone())),
                lod: match &cuts.lods[mesh] {
                    Some(lod) => Some(lod),
                    None => in_chain(b.lods.len(), level).map(|k| &b.lods[k]),
                },
                layers: &b.triangle_layer,
                prefiltered: b.prefiltered.as_ref(),
            },
        };
        (0..self.meshes.len()).map(subject).collect()
    }
}

impl Cutting<'_> {
    fn input(&self) -> LodInput<'_> {
        LodInput {
            mesh: self.mesh,
            primary: &self.built.tables.primary,
            parts: &self.parts,
            world: glam::Mat4::IDENTITY.to_cols_array_2d(),
        }
    }

    fn view(&self, camera: &Camera, instance: &Instance, limits: &Limits) -> Result<View> {
        let seen = Seen {
            object_to_view: camera.view * instance.world,
            projection: camera.projection,
            size: [camera.width, camera.height],
            double_sided: self.double_sided,
        };
        let view = self.hierarchy.model.view(&seen, limits);
        view.map_err(|e| match e {
            Error::Option { reason, .. } => Error::input(&self.mesh.name, "world", reason),
            other => other,
        })
    }
}

/// Whether there is a way to see the back of a surface: through a hole, or because a material says so.
fn is_seen_from_behind(mesh: &Mesh, scene: &Scene) -> bool {
    let welded = Weld::by_position(&mesh.positions).triangles(&mesh.triangles);
    let two_sided = |&m: &u32| {
        scene
            .materials
            .get(m as usize)
            .is_some_and(|m| m.double_sided)
    };
    Adjacency::new(&welded).border_edges > 0 || mesh.triangle_material.iter().any(two_sided)
}
