//! Levels of detail: a chain of simplified meshes per reference mesh, ready for inverse textures.
//!
//! In: all meshes of a model with their primaries, parts and places in the world; fractions of the triangle count. Out:
//! [`Lod`]s whose vertices carry T3 coordinates on the vertex grid and whose triangles carry their part's layer, never an
//! artist uv.
//!
//! ```text
//! reference meshes --joint--> one welded mesh in world space --simplify--> fewer triangles
//!                  --order--> what lay over what lies there again --split--> Lod per mesh
//! ```
//!
//! One simplification over everything, because budgets per part ruin silhouettes: what is flat pays for what is curved.
//! Where the primary comes from position, vertices are welded by position and there are no seams; where it is a uv set,
//! chart borders are kept, so that every LoD triangle lies in one chart. Vertices may move to the optimum.
//! Simplifiers ([`Simplifier`]): meshoptimizer (quadric error metric, Garland and Heckbert), through the meshopt crate; our
//! progressive meshes ([`progressive`]), which bound how far any detail of the reference is displaced:
//!
//! ```text
//! reference mesh --progressive--> collapses with deviations --nested--> one order over all meshes --> Lod per mesh
//! ```

mod carry;
pub mod deviation;
mod joint;
mod motion;
pub mod multiresolution;
mod nested;
mod order;
pub mod progressive;
mod simplify;
mod source;
mod split;
mod tree;

pub use motion::{MOST_POSES, Shape};

use crate::error::{Error, Result};
use crate::mesh::{Mesh, MorphTarget};
use crate::param::Primary;
use crate::param::layer::Parts;
use progressive::{Cost, Progressive};
use rayon::prelude::*;

/// What simplifies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Simplifier {
    /// Collapses in the order of their quadric error by meshoptimizer; vertices move to the optimum, poses are looked at.
    #[default]
    Meshopt,
    /// Our half-edge collapses in the order of their [`Cost`]; vertices stay, levels are nested, the rest pose is looked
    /// at, [`Lod::error`] is a bound.
    Progressive(Cost),
}

/// One level of detail of one mesh. Per-vertex arrays have one element per vertex; `joints` and `weights` are empty for
/// unskinned meshes, `targets` for those that do not morph.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Lod {
    /// Object-space positions.
    pub positions: Vec<[f32; 3]>,
    /// Smooth normals of the LoD's own geometry.
    pub normals: Vec<[f32; 3]>,
    /// T3 coordinates on the primary's vertex grid.
    pub t3: Vec<[i32; 3]>,
    /// Vertex indices, three per triangle.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the layer of its part of the reference.
    pub triangle_layer: Vec<u8>,
    /// Skin joints.
    pub joints: Vec<[u16; 4]>,
    /// Skin weights.
    pub weights: Vec<[f32; 4]>,
    /// The reference's morph targets (positions and normals), which its weights move.
    pub targets: Vec<MorphTarget>,
    /// The simplifier's error, in this mesh's object units: by [`Simplifier::Meshopt`] its own figure over the whole
    /// model, by [`Simplifier::Progressive`] a bound of how far any point of the LoD lies from the point of the reference
    /// with the same place in T3.
    pub error: f32,
    /// Whether `error` is such a bound. It holds for the point that a projection line meets, so that is what a triangle shows,
    /// however the line grazes it.
    pub bounded: bool,
    /// Triangles that lie the other way round in T3 than their part of the reference.
    pub turned: u32,
    /// False where the simplifier could not come down to the triangles asked of the whole model (many parts, seams).
    pub reached: bool,
}

/// One mesh of the model to simplify.
#[derive(Clone, Copy, Debug)]
pub struct LodInput<'a> {
    /// The reference mesh.
    pub mesh: &'a Mesh,
    /// Its primary parameterization.
    pub primary: &'a Primary,
    /// Its parts and layers.
    pub parts: &'a Parts,
    /// Object to world, as four columns. Where it cannot be inverted the mesh is simplified in object space.
    pub world: [[f32; 4]; 4],
}

/// The LoD chains of a model: `result[m][k]` is mesh `m` at `fractions[k]` of the whole model's triangles. A mesh never
/// vanishes: where its share of the budget is nothing, it keeps its coarsest level that is not empty.
///
/// # Errors
/// [`Error::Option`] naming `--lods` where a fraction is not between 0 and 1 (both excluded).
pub fn chains(meshes: &[LodInput<'_>], fractions: &[f32]) -> Result<Vec<Vec<Lod>>> {
    chains_in_motion(meshes, &[], fractions)
}

/// The same by progressive meshes: levels are nested, and their error is a bound. Histories that are `known`, one for each mesh
/// (or nothing), are not made again; those of others are, by `cost`.
///
/// # Errors
/// As [`chains`].
pub fn nested_chains(
    meshes: &[LodInput<'_>],
    known: &[Option<Progressive>],
    cost: Cost,
    fractions: &[f32],
) -> Result<Vec<Vec<Lod>>> {
    check(fractions)?;
    Ok(nested::chains(meshes, known, cost, fractions))
}

/// The same of a model that moves: `shapes` has, for each mesh, its vertices' positions in up to [`MOST_POSES`] poses, none
/// for a mesh that nothing deforms. LoDs keep vertices where it bends.
///
/// # Errors
/// As [`chains`].
pub fn chains_in_motion(
    meshes: &[LodInput<'_>],
    shapes: &[Vec<Shape>],
    fractions: &[f32],
) -> Result<Vec<Vec<Lod>>> {
    check(fractions)?;
    let joint = joint::Joint::new(meshes, shapes);
    let order = order::Order::new(&joint);
    let carries: Vec<Option<carry::Carry>> = meshes.par_iter().map(carry::Carry::new).collect();
    let levels: Vec<Vec<Lod>> = fractions
        .par_iter()
        .map(|&fraction| {
            let mut simplified = simplify::simplify(&joint, fraction);
            order.restore(&mut simplified);
            (0..meshes.len())
                .into_par_iter()
                .map(|m| split::split(meshes, &joint, &simplified, m, carries[m].as_ref()))
                .collect()
        })
        .collect();
    let mut chains: Vec<Vec<Lod>> = vec![Vec::with_capacity(fractions.len()); meshes.len()];
    for level in levels {
        chains
            .iter_mut()
            .zip(level)
            .for_each(|(chain, lod)| chain.push(lod));
    }
    for (m, chain) in chains.iter_mut().enumerate() {
        keep_present(meshes, &joint, m, chain, (fractions, carries[m].as_ref()));
    }
    Ok(chains)
}

/// Refuses fractions that are none.
fn check(fractions: &[f32]) -> Result<()> {
    if let Some(bad) = fractions.iter().find(|f| !(**f > 0.0 && **f < 1.0)) {
        return Err(Error::Option {
            option: "--lods",
            reason: format!(
                "{bad} is not a fraction of the triangles: between 0 and 1, both excluded, such as 0.5,0.2,0.05"
            ),
        });
    }
    Ok(())
}

/// Fills empty levels with the next finer one that is not, at last with the reference's own geometry.
fn keep_present(
    meshes: &[LodInput<'_>],
    joint: &joint::Joint,
    m: usize,
    chain: &mut [Lod],
    (fractions, carry): (&[f32], Option<&carry::Carry>),
) {
    let mut finest_first: Vec<usize> = (0..chain.len()).collect();
    finest_first.sort_by(|&a, &b| fractions[b].total_cmp(&fractions[a]));
    let mut finer: Option<Lod> = None;
    for k in finest_first {
        if chain[k].triangles.is_empty() {
            let kept = finer.clone().unwrap_or_else(|| {
                split::split(meshes, joint, &simplify::untouched(joint), m, carry)
            });
            chain[k] = Lod {
                reached: false,
                ..kept
            };
        }
        finer = Some(chain[k].clone());
    }
}
