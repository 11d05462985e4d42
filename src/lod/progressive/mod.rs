//! Progressive meshes: a reference mesh and every step of its simplification.
//!
//! In: a mesh, its primary and parts. Out: [`Progressive`]: half-edge collapses in order, and every triangle there ever was, with
//! a bound of its [`Deviation`] from the reference. Any prefix of the collapses gives a mesh: manifold where the reference
//! is, one-to-one in T3 where that is, nothing turned by more than 75 degrees in a step. Vertices stay where the reference has
//! them, so levels are nested and share its vertices' attributes.
//!
//! ```text
//! live (surface, topology) --quadric--> candidates --overlay--> plans --collapse--> history
//! ```
//!
//! Sources: Hoppe 1996, Progressive meshes; Schilling and Klein, Texture-dependent refinement of multiresolution meshes,
//! sections 2.1 and 3.

mod collapse;
pub mod colour;
mod grounds;
mod lists;
mod live;
mod near;
mod overlay;
mod plan;
mod projective;
mod quadric;
mod radial;
mod refine;
mod replay;
mod rim;
mod ring;

pub use overlay::Deviation;
pub use replay::Steps;

use super::LodInput;
use crate::param::projection::orientation;
use glam::DVec3;
use overlay::{Asked, Overlay, Scratch};

/// What a collapse costs: the cheapest come first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Cost {
    /// What it displaces, surface or texture: the root of the quadric error or the deviation of the triangles that come to be,
    /// whichever is larger. Fewest triangles for a bound of the deviation.
    #[default]
    Displacement,
    /// The root of the quadric error: how far the surface moves, on average. Fewest triangles for a surface; what its texture does
    /// is bounded all the same.
    Quadric,
}

/// A mesh with the history of its simplification.
#[derive(Clone, Debug, PartialEq)]
pub struct Progressive {
    /// All triangles there ever were: first those of the reference (without its degenerate ones), then those that
    /// collapses made, in their order.
    pub triangles: Vec<Made>,
    /// For each vertex of the mesh its place: the vertex whose position it has on the surface.
    pub place: Vec<u32>,
    /// For each of the reference's, the first of `triangles`: its number in the mesh.
    pub reference: Vec<u32>,
    /// Collapses, in order.
    pub collapses: Vec<Collapse>,
}

/// A triangle, and when it is there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Made {
    /// Vertices of the mesh.
    pub corners: [u32; 3],
    /// The layer of its part.
    pub layer: u8,
    /// How far it lies from the reference, at most: zero for one of the reference's.
    pub deviation: Deviation,
    /// The collapse that made it; none for the reference's.
    pub made: Option<u32>,
    /// The collapse that it goes by; none for those that stay.
    pub gone: Option<u32>,
}

/// One step: a place becomes its neighbour.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Collapse {
    /// The place that goes.
    pub from: u32,
    /// The place it becomes.
    pub to: u32,
    /// The dearest step so far by its [`Cost`]; object units.
    pub price: f64,
}

impl Progressive {
    /// Simplifies a mesh until at most `least` triangles are left, or no further collapse keeps the surface whole.
    pub fn new(input: &LodInput<'_>, cost: Cost, least: usize) -> Self {
        collapse::simplify(input, cost, least)
    }

    /// Triangles that each collapse takes away, less those that it makes.
    pub fn lost(&self) -> Vec<usize> {
        let mut lost = vec![0i64; self.collapses.len()];
        for t in &self.triangles {
            t.gone.into_iter().for_each(|c| lost[c as usize] += 1);
            t.made.into_iter().for_each(|c| lost[c as usize] -= 1);
        }
        lost.into_iter().map(|n| n.max(0) as usize).collect()
    }

    /// The triangles after the first `collapses` steps.
    pub fn after(&self, collapses: usize) -> impl Iterator<Item = &Made> {
        let before = move |step: Option<u32>| step.is_some_and(|step| (step as usize) < collapses);
        self.triangles
            .iter()
            .filter(move |t| (t.made.is_none() || before(t.made)) && !before(t.gone))
    }
}

/// How far a triangle of any simplified surface lies from the reference, at most: `t3` are its corners on the primary's vertex
/// grid, `corners` in object space. Every triangle of the reference is looked at.
pub fn deviation_of(input: &LodInput<'_>, t3: [[i32; 3]; 3], corners: [[f32; 3]; 3]) -> Deviation {
    let overlay = Overlay::new(input.mesh, input.primary);
    let asked = Asked {
        t3: t3.map(|p| DVec3::from(p.map(f64::from))),
        corners: corners.map(|p| DVec3::from(p.map(f64::from))),
        sense: orientation(overlay.line, &t3),
        rims: 0,
    };
    let all: Vec<u32> = (0..input.mesh.triangles.len() as u32).collect();
    let mut scratch = Scratch::default();
    overlay.gather(&mut scratch, std::iter::once(&all[..]));
    overlay.deviation(&asked, f64::INFINITY, &mut scratch, &mut Vec::new())
}
