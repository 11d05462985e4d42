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

/// Builds all meshes of a model.
pub(crate) fn build(
    scene: Scene,
    request: &PrimaryRequest,
    hash: u32,
    layout: Layout,
    fractions: &[f32],
) -> Built {
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
        .enumerate()
        .map(|(m, chosen)| {
            let (primary, parts) = chosen?;
            let chain = chains.next().unwrap();
            let tables = inverse::tables(&scene.meshes[m], &primary, &parts, layout, &chain, hash);
            Some(BuiltMesh {
                primary,
                parts,
                chain,
                tables,
            })
        })
        .collect();
    Built { scene, meshes }
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
                })
            })
            .collect()
    }
}
