//! Multiresolution models: a progressive mesh of which any view takes a cut.
//!
//! In: a [`Progressive`] mesh, what its colours are off by, a view and its limits. Out: [`Cut`]: triangles of every age, side
//! by side, that no point on the screen is displaced by more than the limits.
//!
//! ```text
//! history --node--> bounds that hold their predecessors' --tree--> blocks of 64 --select (view)--> triangles
//! ```
//!
//! A collapse can be made once those are made that made its triangles. So collapses make a DAG, and a set of them that leaves
//! none of their predecessors out is a cut: a triangle is there where the collapse that made it is in the set and the one that
//! it goes by is not. The bound of each collapse holds those of its predecessors, and the flow diagram (`view`) never judges a region better
//! than one that it holds: **every collapse decides alone**, and what they decide is a cut.
//!
//! Any cut is a mesh as sound as a level of the history. Edges between places that stay never vanish by half-edge collapses, so
//! a collapse that has kept the surface one among coarser surroundings keeps it one among finer ones; corners lie on the
//! reference in all of them, so there are no cracks.
//!
//! Collapses stand in blocks of 64, blocks in blocks of blocks; one whose bound is accepted has no triangle to draw and is not
//! looked into. As many collapses are not accepted as the cut has vertices beyond the coarsest level's: the cost follows the
//! cut, not the reference.
//!
//! Sources: Schilling and Klein, Texture-dependent refinement of multiresolution meshes, sections 2.2, 4 and 5; De Floriani,
//! Magillo and Puppo 1997, Building and traversing a surface at variable resolution (multi-triangulations).

mod bound;
mod colour;
#[cfg(feature = "gpu")]
pub mod gpu;
mod hierarchy;
mod limits;
mod node;
mod select;
mod tree;
mod view;

pub use bound::Bound;
pub use colour::{Colours, StepColours, decoded, encoded};
pub use hierarchy::Hierarchy;
pub use limits::{Criterion, Limits};
pub use select::{Cut, Memory};
pub use view::{MAX_LEVELS, Seen, View};

use super::progressive::Progressive;
use crate::error::Result;

/// What a triangle that every cut may have was made by: none of the collapses.
pub const NEVER: u32 = u32::MAX;

/// Triangles of all ages and the collapses between them, in an order that is quick to cut.
#[derive(Clone, Debug, PartialEq)]
pub struct Multiresolution {
    /// Object units in a unit of the bounds: a power of two.
    pub unit: f32,
    /// Bounds of collapses, then of blocks of 64 of them, then of blocks of 64 of those, up to 64 or fewer. After the last
    /// collapse that there is, nodes for triangles that stay follow, which no view accepts.
    pub levels: Vec<Vec<Bound>>,
    /// Triangles, by the node that they go by: those of node `n` from `levels[0][n].first` to the next one's.
    pub faces: Vec<Face>,
    /// For each of `faces` its number in [`Progressive::triangles`].
    pub of: Vec<u32>,
    /// For each collapse of the history its node.
    pub node: Vec<u32>,
    /// What colours are off by.
    pub colours: Option<Colours>,
}

/// A triangle of some age.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
pub struct Face {
    /// Vertices of the reference.
    pub corners: [u32; 3],
    /// The node of the collapse that made it; [`NEVER`] for the reference's own.
    pub made: u32,
}

impl Multiresolution {
    /// The model of a history whose triangles' vertices lie at `positions`. `colours` fit ([`StepColours::fits`]).
    pub fn new(
        history: &Progressive,
        positions: &[[f32; 3]],
        colours: Option<&StepColours>,
    ) -> Self {
        tree::model(history, positions, colours)
    }

    /// A view of it.
    ///
    /// # Errors
    /// [`Limits::check`]'s; [`crate::Error::Option`] for a matrix that cannot be undone.
    pub fn view(&self, seen: &Seen, limits: &Limits) -> Result<View> {
        let colours = self.colours.as_ref();
        let levels = colours.map_or((1.0, 0), |c| (f64::from(c.footprint), c.levels));
        View::new(seen, limits, f64::from(self.unit), levels)
    }

    /// Collapses of the history.
    pub fn collapses(&self) -> usize {
        self.node.len()
    }
}
