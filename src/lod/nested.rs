//! LoDs of progressive meshes: one budget over all of them, levels nested.
//!
//! In: meshes and fractions. Out: chains, each level a prefix of its mesh's collapses. The next collapse of the whole model is
//! the cheapest of all meshes', in world units; so a level is cut at one price everywhere.

use super::joint::world;
use super::progressive::{Cost, Progressive};
use super::source::Source;
use super::split::per_object_unit;
use super::{Lod, LodInput};
use rayon::prelude::*;
use std::borrow::Cow;

/// A mesh simplifies on by this factor below its own share of the coarsest level: others may need the triangles more.
const BEYOND: f64 = 8.0;

/// The chains of a model by progressive meshes: `result[m][k]` is mesh `m` at `fractions[k]` of the whole model's triangles. Histories
/// that are not `known` are made, by `cost`.
pub(super) fn chains(
    meshes: &[LodInput<'_>],
    known: &[Option<Progressive>],
    cost: Cost,
    fractions: &[f32],
) -> Vec<Vec<Lod>> {
    let coarsest = fractions.iter().copied().fold(1.0, f32::min);
    let history = |(m, input): (usize, &LodInput<'_>)| match known.get(m) {
        Some(Some(history)) => Cow::Borrowed(history),
        _ => {
            let share = input.mesh.triangles.len() as f64 * f64::from(coarsest);
            Cow::Owned(Progressive::new(input, cost, (share / BEYOND) as usize))
        }
    };
    let histories: Vec<Cow<'_, Progressive>> = meshes.par_iter().enumerate().map(history).collect();
    let order = Order::new(meshes, &histories);
    let levels: Vec<Level> = fractions.iter().map(|&f| order.level(f)).collect();
    let pairs = meshes.par_iter().zip(&histories).enumerate();
    let chains = pairs.map(|(m, (input, history))| {
        let source = Source::new(input, history);
        let lod = |level: &Level| Lod {
            reached: level.reached,
            ..source.lod(history.after(level.collapses[m]))
        };
        levels.iter().map(lod).collect()
    });
    chains.collect()
}

/// All collapses of a model in one order.
struct Order {
    /// Mesh and triangles lost, cheapest first.
    steps: Vec<(usize, usize)>,
    meshes: usize,
    /// Triangles before the first of them.
    triangles: usize,
    /// Triangles that fractions are fractions of.
    reference: usize,
}

/// How many collapses each mesh has come to.
struct Level {
    collapses: Vec<usize>,
    /// Whether the triangles asked for were reached.
    reached: bool,
}

impl Order {
    fn new(meshes: &[LodInput<'_>], histories: &[Cow<'_, Progressive>]) -> Self {
        let mut priced: Vec<(f64, usize, usize)> = Vec::new();
        for (m, (input, history)) in meshes.iter().zip(histories).enumerate() {
            let unit = per_object_unit(&world(input));
            let lost = history.lost();
            priced.extend(
                history
                    .collapses
                    .iter()
                    .zip(lost)
                    .map(|(c, lost)| (c.price * unit, m, lost)),
            );
        }
        // Stable: the steps of a mesh, whose prices never fall, stay in order.
        priced.sort_by(|a, b| a.0.total_cmp(&b.0));
        Order {
            steps: priced.into_iter().map(|(_, m, lost)| (m, lost)).collect(),
            meshes: meshes.len(),
            triangles: histories.iter().map(|h| h.after(0).count()).sum(),
            reference: meshes.iter().map(|input| input.mesh.triangles.len()).sum(),
        }
    }

    fn level(&self, fraction: f32) -> Level {
        let target = ((self.reference as f64 * f64::from(fraction)).round() as usize).max(1);
        let mut collapses = vec![0; self.meshes];
        let mut triangles = self.triangles;
        for &(m, lost) in &self.steps {
            if triangles <= target {
                break;
            }
            collapses[m] += 1;
            triangles -= lost;
        }
        Level {
            collapses,
            reached: triangles <= target,
        }
    }
}
