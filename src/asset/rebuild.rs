//! Other tables for a model that is built already: the same reference and LoDs at another resolution, in another layout.
//!
//! In: a [`Built`] model. Out: one with new tables, in memory; what it says of itself ([`BuiltMesh::report`]) is dropped,
//! as it speaks of the old ones.

use super::build::tables_of;
use super::hierarchy::Asked;
use super::{Built, BuiltMesh, Processor};
use crate::Result;
use crate::igt::BuildOptions;

impl Built {
    /// The model with the tables of every mesh built again; `options` says how, given the mesh as it is.
    ///
    /// # Errors
    /// [`Error::Option`](crate::Error::Option) for a hash resolution out of range,
    /// [`Error::Capacity`](crate::Error::Capacity) where a layout cannot hold the lists; those of the device.
    pub fn rebuilt(
        &self,
        options: impl Fn(&BuiltMesh) -> BuildOptions,
        processor: Processor<'_>,
    ) -> Result<Built> {
        let again = |built: &BuiltMesh| {
            let mesh = &self.scene.meshes[built.mesh];
            let primary = &built.tables.primary;
            let tables = tables_of(
                mesh,
                primary,
                &built.triangle_layer,
                &built.lods,
                built
                    .hierarchy
                    .as_ref()
                    .map(|h| Asked::of(mesh, primary, &h.history)),
                options(built),
                processor,
            )?;
            Ok(BuiltMesh {
                tables,
                report: serde_json::Value::Null,
                ..built.clone()
            })
        };
        Ok(Built {
            scene: self.scene.clone(),
            meshes: self.meshes.iter().map(again).collect::<Result<_>>()?,
        })
    }
}
