//! Levels of a built model: what each mesh is drawn with, how many triangles that is, one mesh alone.
//!
//! In: a [`Built`] model and a level: 0 is the reference's own geometry, 1, 2, .. the chain, finest first. Out: subjects
//! for [`stage`]. A mesh whose chain is shorter shows its coarsest.

use super::stage::{Correspond, Subject, stage};
use crate::asset::Built;
use crate::scene::{Material, Scene};
use crate::{Error, Result};
use std::sync::Arc;

/// Levels of the model, the reference included.
pub fn levels(built: &Built) -> usize {
    1 + built
        .meshes
        .iter()
        .map(|mesh| mesh.lods.len())
        .max()
        .unwrap_or(0)
}

/// The place in a mesh's chain of `chain` LoDs that stands for `level`; `None` for the reference.
pub fn in_chain(chain: usize, level: usize) -> Option<usize> {
    level.min(chain).checked_sub(1)
}

/// Triangles of all meshes of the model at `level`, each counted once.
pub fn triangles(built: &Built, level: usize) -> usize {
    let of_mesh = |mesh: usize| {
        let reference = built.scene.meshes[mesh].triangles.len();
        built
            .of_mesh(mesh)
            .map_or(reference, |b| match in_chain(b.lods.len(), level) {
                Some(k) => b.lods[k].triangles.len(),
                None => reference,
            })
    };
    (0..built.scene.meshes.len()).map(of_mesh).sum()
}

/// The level whose share of the reference's triangles is nearest to `share`, in ratio; 0 only where there is no LoD.
pub fn level_near(built: &Built, share: f64) -> usize {
    let whole = triangles(built, 0).max(1) as f64;
    let far = |level: usize| {
        let ratio = triangles(built, level).max(1) as f64 / whole / share;
        ratio.ln().abs()
    };
    (1..levels(built))
        .min_by(|&a, &b| far(a).total_cmp(&far(b)))
        .unwrap_or(0)
}

/// What each mesh is drawn with at `level`.
pub fn subjects(built: &Built, level: usize) -> Vec<Subject<'_>> {
    let subject = |mesh: usize| match built.of_mesh(mesh) {
        None => Subject::default(),
        Some(b) => Subject {
            tables: Some(Arc::new(b.tables.clone())),
            lod: in_chain(b.lods.len(), level).map(|k| &b.lods[k]),
            layers: &b.triangle_layer,
            prefiltered: None,
        },
    };
    (0..built.scene.meshes.len()).map(subject).collect()
}

/// [`subjects`] with what was filtered beforehand, for the shader LoD.
pub fn subjects_prefiltered(built: &Built, level: usize) -> Vec<Subject<'_>> {
    let mut subjects = subjects(built, level);
    for b in &built.meshes {
        subjects[b.mesh].prefiltered = b.prefiltered.as_ref();
    }
    subjects
}

/// Centre and radius of a sphere round the reference as it stands in the world, so that every level is framed alike.
///
/// # Errors
/// As [`stage`].
pub fn reference_sphere(scene: &Scene) -> Result<([f64; 3], f64)> {
    // Textures have no extent; without them nothing needs to be decoded.
    let mut bare = scene.clone();
    bare.materials = vec![Material::default(); bare.materials.len()];
    Ok(stage(&bare, &[], Correspond::Reference, false)?
        .0
        .bounding_sphere())
}

/// Leaves every mesh but `mesh` without triangles, and the materials that only they use without textures.
///
/// # Errors
/// [`Error::Input`] where the mesh stands nowhere in the default scene, or has no triangles.
pub fn keep_only(scene: &mut Scene, mesh: usize) -> Result<()> {
    let stands = scene.instances().iter().any(|i| i.mesh == mesh);
    if !stands {
        let name = scene.meshes.get(mesh).map_or("", |m| m.name.as_str());
        let reason = "stands nowhere in the file's default scene, or has no triangles";
        return Err(Error::input(
            &scene.name,
            format!("mesh \"{name}\""),
            reason,
        ));
    }
    for (k, other) in scene.meshes.iter_mut().enumerate() {
        if k != mesh {
            other.triangles.clear();
            other.triangle_material.clear();
        }
    }
    let used = &scene.meshes[mesh].triangle_material;
    for (k, material) in scene.materials.iter_mut().enumerate() {
        if !used.contains(&(k as u32)) {
            *material = Material::default();
        }
    }
    Ok(())
}

impl Built {
    /// The model with mesh `mesh` (of the scene) alone.
    ///
    /// # Errors
    /// As [`keep_only`].
    pub fn only(&self, mesh: usize) -> Result<Built> {
        let mut scene = self.scene.clone();
        keep_only(&mut scene, mesh)?;
        let meshes = self.meshes.iter().filter(|built| built.mesh == mesh);
        Ok(Built {
            scene,
            meshes: meshes.cloned().collect(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chains_end_with_their_coarsest() {
        assert_eq!(
            [0, 1, 2, 9].map(|level| in_chain(2, level)),
            [None, Some(0), Some(1), Some(1)]
        );
        assert_eq!(in_chain(0, 3), None);
    }
}
