//! The shared models, built for drawing.

use invertex::igt::{self, Asking, BuildOptions, Layout, Needs, Reference, Tables};
use invertex::lod::{self, Lod, LodInput};
use invertex::param::layer::{self, Parts};
use invertex::param::{Primary, PrimaryRequest, choose};
use invertex::render::Subject;
use invertex::scene::Scene;
use std::path::PathBuf;
use std::sync::Arc;

/// The file of a shared model, if it is here; says loudly if not.
pub fn path(name: &str) -> Option<PathBuf> {
    let folder = std::env::var_os("INVERTEX_MODELS").map_or_else(
        || PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../shared/models"),
        PathBuf::from,
    );
    let path = folder.join(name);
    if !path.exists() {
        eprintln!("SKIPPED: no {}", path.display());
        return None;
    }
    Some(path)
}

/// A scene with everything a LoD needs.
pub struct Built {
    pub scene: Scene,
    pub tables: Vec<Option<Arc<Tables>>>,
    pub parts: Vec<Parts>,
    /// For each mesh its LoDs.
    pub chains: Vec<Vec<Lod>>,
}

/// Builds all meshes of a model.
pub fn build(
    scene: Scene,
    request: &PrimaryRequest,
    hash: u32,
    layout: Layout,
    fractions: &[f32],
) -> Built {
    let primaries: Vec<Option<Primary>> = scene
        .meshes
        .iter()
        .map(|m| choose(m, request).ok().map(|(p, _)| p))
        .collect();
    let drawn: Vec<usize> = (0..scene.meshes.len())
        .filter(|&m| primaries[m].is_some())
        .collect();
    let parts: Vec<Parts> = scene
        .meshes
        .iter()
        .zip(&primaries)
        .map(|(mesh, primary)| {
            primary
                .as_ref()
                .map(|p| layer::parts(mesh, p))
                .unwrap_or_else(no_parts)
        })
        .collect();
    let world = |m: usize| {
        let found = scene.instances().into_iter().find(|i| i.mesh == m);
        found.map_or(glam::Mat4::IDENTITY.to_cols_array_2d(), |i| {
            i.world_columns()
        })
    };
    let inputs: Vec<LodInput> = drawn
        .iter()
        .map(|&m| LodInput {
            mesh: &scene.meshes[m],
            primary: primaries[m].as_ref().unwrap(),
            parts: &parts[m],
            world: world(m),
        })
        .collect();
    let mut chains = vec![Vec::new(); scene.meshes.len()];
    for (chain, &m) in lod::chains(&inputs, fractions)
        .unwrap()
        .into_iter()
        .zip(&drawn)
    {
        chains[m] = chain;
    }
    let tables = (0..scene.meshes.len())
        .map(|m| {
            let primary = primaries[m].as_ref()?;
            let reference =
                Reference::new(&scene.meshes[m], primary, &parts[m].triangle_layer, layout)
                    .unwrap();
            let lods: Vec<Asking> = chains[m].iter().map(asking).collect();
            let options = BuildOptions { hash, layout };
            let needs = Needs::of(&reference, &lods, options.bits().unwrap());
            Some(Arc::new(
                igt::build_cpu(&reference, &needs, options).unwrap(),
            ))
        })
        .collect();
    Built {
        scene,
        tables,
        parts,
        chains,
    }
}

fn asking(lod: &Lod) -> Asking<'_> {
    Asking {
        t3: &lod.t3,
        triangles: &lod.triangles,
        layer: &lod.triangle_layer,
    }
}

fn no_parts() -> Parts {
    let nothing = invertex::mesh::Mesh::default();
    let primary = Primary::centred(
        invertex::param::PrimaryKind::Sphere,
        &invertex::mesh::shapes::octahedron(),
    );
    layer::parts(&nothing, &primary.unwrap())
}

impl Built {
    /// What each mesh is drawn with at level `level` (0: the reference's own geometry).
    pub fn subjects(&self, level: usize) -> Vec<Subject<'_>> {
        (0..self.scene.meshes.len())
            .map(|m| Subject {
                tables: self.tables[m].clone(),
                lod: level.checked_sub(1).and_then(|k| self.chains[m].get(k)),
                layers: &self.parts[m].triangle_layer,
            })
            .collect()
    }
}
