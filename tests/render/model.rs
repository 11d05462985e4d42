//! The shared models, built for drawing.

use super::inverse;
use invertex::igt::{Layout, Tables};
use invertex::lod::{self, Lod, LodInput};
use invertex::param::layer::{self, Parts};
use invertex::param::{Primary, PrimaryRequest, choose};
use invertex::render::Subject;
use invertex::scene::Scene;
use std::path::PathBuf;
use std::sync::Arc;

/// The file of a shared model, if it is here; says loudly if not.
pub(crate) fn path(name: &str) -> Option<PathBuf> {
    let beside = || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/models");
    let path = std::env::var_os("INVERTEX_MODELS")
        .map_or_else(beside, PathBuf::from)
        .join(name);
    if !path.exists() {
        eprintln!("SKIPPED: no {}", path.display());
        return None;
    }
    Some(path)
}

/// A scene with everything a LoD needs; for each mesh what could be had.
pub(crate) struct Built {
    pub(crate) scene: Scene,
    pub(crate) meshes: Vec<Option<BuiltMesh>>,
}

/// A mesh of it.
pub(crate) struct BuiltMesh {
    pub(crate) primary: Primary,
    pub(crate) parts: Parts,
    pub(crate) chain: Vec<Lod>,
    pub(crate) tables: Arc<Tables>,
}

/// A scene with the primary, the parts and the LoDs of each mesh that can have them.
pub(crate) struct Prepared {
    pub(crate) scene: Scene,
    pub(crate) meshes: Vec<Option<PreparedMesh>>,
}

/// Primary, parts and LoDs of a mesh.
pub(crate) type PreparedMesh = (Primary, Parts, Vec<Lod>);

/// Everything but the tables.
pub(crate) fn prepare(scene: Scene, request: &PrimaryRequest, fractions: &[f32]) -> Prepared {
    let chosen: Vec<Option<(Primary, Parts)>> = scene
        .meshes
        .iter()
        .map(|mesh| {
            choose(mesh, request)
                .ok()
                .map(|(primary, _)| (primary, layer::parts(mesh, &primary)))
        })
        .collect();
    let instances = scene.instances();
    let world = |m: usize| {
        let found = instances.iter().find(|i| i.mesh == m);
        found.map_or(glam::Mat4::IDENTITY.to_cols_array_2d(), |i| {
            i.world_columns()
        })
    };
    let built = chosen
        .iter()
        .enumerate()
        .filter_map(|(m, c)| c.as_ref().map(|c| (m, c)));
    let inputs: Vec<LodInput> = built
        .map(|(m, (primary, parts))| LodInput {
            mesh: &scene.meshes[m],
            primary,
            parts,
            world: world(m),
        })
        .collect();
    let mut chains = lod::chains(&inputs, fractions).unwrap().into_iter();
    let meshes = chosen
        .into_iter()
        .map(|chosen| chosen.map(|(primary, parts)| (primary, parts, chains.next().unwrap())))
        .collect();
    Prepared { scene, meshes }
}

impl Prepared {
    /// With tables whose size `hash` gives for a number of triangles.
    pub(crate) fn built(self, layout: Layout, hash: impl Fn(usize) -> u32) -> Built {
        let scene = self.scene;
        let with_tables = |(m, prepared): (usize, Option<PreparedMesh>)| {
            let (primary, parts, chain) = prepared?;
            let mesh = &scene.meshes[m];
            let hash = hash(mesh.triangles.len());
            let tables = inverse::tables(mesh, &primary, &parts, layout, &chain, hash);
            Some(BuiltMesh {
                primary,
                parts,
                chain,
                tables,
            })
        };
        let meshes = self.meshes.into_iter().enumerate();
        let meshes = meshes.map(with_tables).collect();
        Built { scene, meshes }
    }
}

/// Builds all meshes of a model.
pub(crate) fn build(
    scene: Scene,
    request: &PrimaryRequest,
    hash: u32,
    layout: Layout,
    fractions: &[f32],
) -> Built {
    prepare(scene, request, fractions).built(layout, |_| hash)
}

impl Built {
    /// What each mesh is drawn with at level `level` (0: the reference's own geometry).
    pub(crate) fn subjects(&self, level: usize) -> Vec<Subject<'_>> {
        self.meshes
            .iter()
            .map(|mesh| {
                mesh.as_ref().map_or_else(Subject::default, |m| Subject {
                    tables: Some(Arc::clone(&m.tables)),
                    lod: level.checked_sub(1).and_then(|k| m.chain.get(k)),
                    layers: &m.parts.triangle_layer,
                    prefiltered: None,
                })
            })
            .collect()
    }
}
