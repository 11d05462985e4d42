//! Pictures of shapes through inverse geometric textures.

use super::textured;
use glam::DMat4;
use invertex::attribute::AttributeSet;
use invertex::igt::{self, Asking, BuildOptions, Layout, Needs, Reference, Tables, askers};
use invertex::lod::{self, Lod, LodInput};
use invertex::mesh::Mesh;
use invertex::param::layer::{self, Parts};
use invertex::param::{Primary, PrimaryRequest, choose};
use invertex::render::Picture;
use std::sync::Arc;

/// A shape with its tables and one LoD.
pub(crate) struct Inverse {
    pub(crate) mesh: Mesh,
    pub(crate) parts: Parts,
    pub(crate) lod: Lod,
    pub(crate) tables: Arc<Tables>,
}

/// Builds `mesh` for drawing at `fraction` of its triangles.
pub(crate) fn build(mesh: Mesh, request: &str, layout: Layout, fraction: f32) -> Inverse {
    let request: PrimaryRequest = request.parse().unwrap();
    let (primary, _) = choose(&mesh, &request).unwrap();
    let parts = layer::parts(&mesh, &primary);
    let world = glam::Mat4::IDENTITY.to_cols_array_2d();
    let input = LodInput {
        mesh: &mesh,
        primary: &primary,
        parts: &parts,
        world,
    };
    let lod = lod::chains(&[input], &[fraction])
        .unwrap()
        .remove(0)
        .remove(0);
    let tables = tables(
        &mesh,
        &primary,
        &parts,
        layout,
        std::slice::from_ref(&lod),
        64,
    );
    Inverse {
        mesh,
        parts,
        lod,
        tables,
    }
}

/// The tables of a mesh that serve `lods`.
pub(crate) fn tables(
    mesh: &Mesh,
    primary: &Primary,
    parts: &Parts,
    layout: Layout,
    lods: &[Lod],
    hash: u32,
) -> Arc<Tables> {
    let reference = Reference::new(mesh, primary, &parts.triangle_layer, layout).unwrap();
    let options = BuildOptions { hash, layout };
    let asking: Vec<Asking> = lods.iter().map(asking).collect();
    let needs = Needs::of(&reference, &asking, options.bits().unwrap());
    Arc::new(igt::build_cpu(&reference, &needs, options).unwrap())
}

/// What a LoD asks of the tables.
pub(crate) fn asking(lod: &Lod) -> Asking<'_> {
    Asking {
        t3: &lod.t3,
        triangles: &lod.triangles,
        layer: &lod.triangle_layer,
    }
}

/// LoDs side by side, each through its own tables.
pub(crate) fn picture(all: &[&Inverse]) -> Picture {
    let (textures, materials) = textured();
    let mut attributes = AttributeSet::new(textures, &materials, 1);
    let bases: Vec<u32> = all
        .iter()
        .map(|i| attributes.push_mesh(&i.mesh).unwrap())
        .collect();
    let mut picture = Picture::new(attributes);
    for (k, (i, base)) in all.iter().zip(bases).enumerate() {
        let (lod, line) = (&i.lod, i.tables.primary.line());
        let geometry = picture
            .add_geometry(
                &lod.positions,
                &lod.triangles,
                &lod.t3,
                &askers(line, lod),
                lod.error,
            )
            .unwrap();
        let tables = picture.add_tables(Arc::clone(&i.tables), None).unwrap();
        let world = DMat4::from_translation(glam::DVec3::new(1.7 * k as f64, 0.0, 0.0));
        picture.draw(geometry, base, Some(tables), world).unwrap();
    }
    picture
}
