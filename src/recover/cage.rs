//! An explicit cage: a mesh shaped like the simple one, from whose points rays run to it and on.
//!
//! In: a scene with a mesh for each of the simple model's. Out: for each triangle of the simple surface its corners on the
//! cage. Triangles belong together by their numbers; vertices need not, since tools split them along seams as they like.

use super::partner::stem;
use super::standing::{Standing, standing_first};
use crate::attribute::arithmetic::V3;
use crate::mesh::Mesh;
use crate::scene::Scene;
use crate::{Error, Result};

/// The meshes of a cage as they stand.
pub(super) struct Cage<'a> {
    scene: &'a Scene,
    /// Each mesh where it stands first.
    meshes: Vec<Standing>,
}

impl<'a> Cage<'a> {
    /// # Errors
    /// [`Error::Input`] where a mesh leaves the range of floats.
    pub(super) fn new(scene: &'a Scene) -> Result<Cage<'a>> {
        Ok(Cage {
            scene,
            meshes: standing_first(scene)?,
        })
    }

    /// For each triangle of `low`, mesh `place` of `of` of the simple model, its corners on the cage, in the world. The cage's
    /// mesh is the one of that name (an ending such as `_low` or `_cage` left out), or the one in that place where both
    /// models have as many.
    ///
    /// # Errors
    /// [`Error::Input`] where there is none, or where its triangles are not those of `low`.
    pub(super) fn of(&self, low: &Mesh, (place, of): (usize, usize)) -> Result<Vec<[V3; 3]>> {
        let named = |m: &&Standing| stem(&m.mesh.name) == stem(&low.name);
        let in_place = || self.meshes.get(place).filter(|_| self.meshes.len() == of);
        let Some(cage) = self.meshes.iter().find(named).or_else(in_place) else {
            let element = format!("mesh \"{}\"", low.name);
            return Err(Error::input(
                &self.scene.name,
                element,
                "the cage has no such mesh",
            ));
        };
        let fault = |reason: String| {
            let element = format!("mesh \"{}\"", cage.mesh.name);
            Err(Error::input(&self.scene.name, element, reason))
        };
        // As the file winds them: what mirrors a placing turns triangles round.
        let triangles = &self.scene.meshes[cage.number].triangles;
        let (have, need) = (triangles.len(), low.triangles.len());
        if have != need {
            return fault(format!(
                "has {have} triangles where the mesh it is a cage of has {need}: a cage is that mesh with its vertices moved"
            ));
        }
        let corners = |t: &[u32; 3]| t.map(|v| cage.mesh.positions[v as usize]);
        let corners: Vec<[V3; 3]> = triangles.iter().map(corners).collect();
        if let Some(t) = torn(low, &corners) {
            return fault(format!(
                "at triangle {t} corners part that are one in the mesh it is a cage of: its triangles are others, or in another order"
            ));
        }
        Ok(corners)
    }
}

/// The first triangle with a corner that lies elsewhere than an earlier triangle has put the same vertex of `low`.
fn torn(low: &Mesh, corners: &[[V3; 3]]) -> Option<usize> {
    let mut at: Vec<Option<V3>> = vec![None; low.positions.len()];
    let parts = |t: &usize| {
        let pairs = low.triangles[*t].iter().zip(&corners[*t]);
        pairs
            .into_iter()
            .any(|(&v, corner)| at[v as usize].get_or_insert(*corner) != corner)
    };
    (0..corners.len()).find(parts)
}
