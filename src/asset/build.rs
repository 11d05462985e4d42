//! The whole pipeline: from a scene to a built model.
//!
//! In: a [`Scene`] and [`BuildSettings`]. Out: a [`Built`] model with a [`MeshReport`] for each mesh, and the time of each
//! stage. A caller hears of progress and may stop it through [`Progress`].
//!
//! ```text
//! Scene -> primary -> parts -> LoDs of all meshes at once -> tables of each mesh -> deviations -> Built
//! ```
//!
//! The same scene and settings give the same model, whichever processor builds the tables.

use super::hierarchy::Asked;
use super::report::{self, MeshReport};
use super::settings::{BuildSettings, Processor, Progress, check, hash_for};
use super::work::Work;
use super::{Built, BuiltMesh};
#[cfg(feature = "gpu")]
use crate::Error;
use crate::Result;
use crate::igt::{self, Ambiguous, Asking, BuildOptions, Needs, Reference, Tables};
use crate::lod::Lod;
use crate::lod::deviation::{Deviation, deviation};
use crate::lod::multiresolution::Hierarchy;
use crate::mesh::Mesh;
use crate::param::{self, Chosen, Parts, Primary, Quality, Weighed};
use crate::scene::Scene;
use rayon::prelude::*;

/// A built model and what was found on the way.
#[derive(Clone, Debug)]
pub struct BuildOutcome {
    /// The model, ready for [`super::write`].
    pub built: Built,
    /// One for each built mesh.
    pub reports: Vec<MeshReport>,
    /// The triangles of each of them that share a place with another of their layer.
    pub ambiguous: Vec<Ambiguous>,
    /// Milliseconds of each stage, in order.
    pub milliseconds: Vec<(&'static str, f64)>,
    /// What was left out or replaced on the way, in words.
    pub notes: Vec<String>,
}

/// Builds LoDs and inverse geometric textures for every mesh of `scene` that has triangles.
///
/// # Errors
/// [`Error::Input`] where no mesh has triangles; [`Error::Option`] for settings out of range or naming a mesh that does
/// not exist; [`Error::Parameterization`] where a mesh cannot have the primary; [`Error::Cancelled`]; those of the device.
pub fn build(
    mut scene: Scene,
    settings: &BuildSettings,
    processor: Processor<'_>,
    progress: &dyn Progress,
) -> Result<BuildOutcome> {
    check(&scene, settings)?;
    let meshes: Vec<usize> = (0..scene.meshes.len())
        .filter(|&m| !scene.meshes[m].triangles.is_empty())
        .collect();
    let mut work = Work::new(&scene, meshes.len(), settings, progress);
    let chosen = work.each("primary", &meshes, |m| choose(&scene.meshes[m], settings))?;
    for (&m, chosen) in meshes.iter().zip(&chosen) {
        if let Some(computed) = &chosen.computed {
            scene.meshes[m] = computed.embedding.cut_open(&scene.meshes[m]);
        }
    }
    let parts = work.each("parts", &meshes, |m| {
        let at = meshes.iter().position(|&other| other == m).unwrap_or(0);
        Ok(param::parts(&scene.meshes[m], &chosen[at].primary))
    })?;
    let (chains, hierarchies) = work.chains(&scene, &meshes, &chosen, &parts)?;
    let mut prepared: Vec<Prepared> = Vec::with_capacity(meshes.len());
    let of_lods = chains.into_iter().zip(hierarchies);
    let all = meshes.iter().copied().zip(chosen).zip(parts).zip(of_lods);
    for (((mesh, chosen), parts), (lods, hierarchy)) in all {
        prepared.push(Prepared {
            mesh,
            primary: chosen.primary,
            why: chosen.why,
            weighed: chosen.weighed,
            quality: chosen.computed.map(|computed| computed.quality),
            parts,
            lods,
            hierarchy,
        });
    }
    let tables = work.with_prepared("tables", &prepared, |p| {
        tables(&scene.meshes[p.mesh], p, settings, processor)
    })?;
    let ambiguous = work.with_prepared("ambiguous", &prepared, |p| {
        Ambiguous::of(&scene.meshes[p.mesh], &p.primary, &p.parts.triangle_layer)
    })?;
    let far = work.with_prepared("deviations", &prepared, |p| {
        Ok(deviations(&scene.meshes[p.mesh], &p.lods))
    })?;
    let (milliseconds, notes) = (work.milliseconds, work.notes);
    let mut reports = Vec::with_capacity(prepared.len());
    let mut built = Vec::with_capacity(prepared.len());
    let of_all = prepared.into_iter().zip(tables).zip(far).zip(&ambiguous);
    for (((p, tables), far), ambiguous) in of_all {
        let report = report::of(
            &scene.meshes[p.mesh],
            &p,
            &tables,
            ambiguous,
            (&far, settings.simplifier),
        );
        built.push(BuiltMesh {
            mesh: p.mesh,
            triangle_layer: p.parts.triangle_layer,
            tables,
            lods: p.lods,
            prefiltered: None,
            hierarchy: p.hierarchy,
            report: report.to_json(),
        });
        reports.push(report);
    }
    Ok(BuildOutcome {
        built: Built {
            scene,
            meshes: built,
        },
        reports,
        ambiguous,
        milliseconds,
        notes,
    })
}

/// A mesh on its way: everything but its tables.
pub(super) struct Prepared {
    pub(super) mesh: usize,
    pub(super) primary: Primary,
    pub(super) why: String,
    pub(super) weighed: Vec<Weighed>,
    pub(super) quality: Option<Quality>,
    pub(super) parts: Parts,
    pub(super) lods: Vec<Lod>,
    pub(super) hierarchy: Option<Hierarchy>,
}

fn choose(mesh: &Mesh, settings: &BuildSettings) -> Result<Chosen> {
    let named = settings
        .primary_of
        .iter()
        .find(|(name, _)| *name == mesh.name);
    param::parameterize(
        mesh,
        named.map_or(&settings.primary, |(_, request)| request),
    )
}

fn tables(
    mesh: &Mesh,
    p: &Prepared,
    settings: &BuildSettings,
    processor: Processor<'_>,
) -> Result<Tables> {
    let hash = settings
        .hash
        .unwrap_or_else(|| hash_for(mesh.triangles.len()));
    let options = BuildOptions {
        hash,
        layout: settings.layout,
    };
    let layer = &p.parts.triangle_layer;
    let cuts = p
        .hierarchy
        .as_ref()
        .map(|h| Asked::of(mesh, &p.primary, &h.history));
    tables_of(mesh, &p.primary, layer, &p.lods, cuts, options, processor)
}

/// The tables of a mesh for the LoDs and cuts that will be drawn with them.
pub(super) fn tables_of(
    mesh: &Mesh,
    primary: &Primary,
    layer: &[u8],
    lods: &[Lod],
    cuts: Option<Asked>,
    options: BuildOptions,
    processor: Processor<'_>,
) -> Result<Tables> {
    let reference = Reference::new(mesh, primary, layer, options.layout)?;
    let asking: Vec<Asking> = lods
        .iter()
        .map(|lod| Asking {
            t3: &lod.t3,
            triangles: &lod.triangles,
            layer: &lod.triangle_layer,
        })
        .chain(cuts.as_ref().map(Asked::asking))
        .collect();
    let needs = Needs::of(&reference, &asking, options.bits()?);
    match processor {
        Processor::Cpu => igt::build_cpu(&reference, &needs, options),
        #[cfg(feature = "gpu")]
        Processor::Device(context) => on_device(context, &reference, &needs, options),
        #[cfg(feature = "gpu")]
        Processor::Preferably(context) => match on_device(context, &reference, &needs, options) {
            Err(full @ (Error::Capacity { .. } | Error::OutOfMemory { .. })) => {
                tracing::warn!("{}: {full}; built on the processor instead", mesh.name);
                igt::build_cpu(&reference, &needs, options)
            }
            built => built,
        },
        #[cfg(not(feature = "gpu"))]
        Processor::Absent(never) => match *never {},
    }
}

#[cfg(feature = "gpu")]
fn on_device(
    context: &crate::gpu::Context,
    reference: &Reference,
    needs: &Needs,
    options: BuildOptions,
) -> Result<Tables> {
    Ok(igt::gpu::build(context, reference, needs, options)?.tables)
}

fn deviations(mesh: &Mesh, lods: &[Lod]) -> Vec<Deviation> {
    let reference = (mesh.positions.as_slice(), mesh.triangles.as_slice());
    lods.par_iter()
        .map(|lod| deviation(reference, (&lod.positions, &lod.triangles)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Error;
    use crate::param::PrimaryRequest;

    struct Stop;
    impl Progress for Stop {
        fn cancelled(&self) -> bool {
            true
        }
    }

    #[test]
    fn a_build_stops_when_asked_and_refuses_nonsense() {
        let mesh = crate::mesh::shapes::octahedron();
        let scene = || Scene {
            name: "s".into(),
            meshes: vec![mesh.clone()],
            ..Scene::default()
        };
        let settings = BuildSettings::default();
        assert!(matches!(
            build(scene(), &settings, Processor::Cpu, &Stop),
            Err(Error::Cancelled)
        ));
        let refused = |settings: BuildSettings| {
            build(scene(), &settings, Processor::Cpu, &())
                .unwrap_err()
                .exit_code()
        };
        let with = |hash, lods: &[f32], primary_of| BuildSettings {
            hash,
            lods: lods.to_vec(),
            primary_of,
            ..settings.clone()
        };
        let stranger = vec![("nobody".to_owned(), PrimaryRequest::Sphere(None))];
        for bad in [
            with(Some(0), &[0.5], vec![]),
            with(Some(1000), &[0.5], vec![]),
            with(None, &[], vec![]),
            with(None, &[1.5], vec![]),
            with(None, &[0.5], stranger),
        ] {
            assert_eq!(refused(bad), 2);
        }
        let empty = Scene {
            name: "s".into(),
            meshes: vec![Mesh::default()],
            ..Scene::default()
        };
        assert_eq!(
            build(empty, &settings, Processor::Cpu, &())
                .unwrap_err()
                .exit_code(),
            3
        );
    }
}
