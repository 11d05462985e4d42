//! Bounds against samples, over several cuts of a model.

use super::Model;
use super::sampled::largest;
use invertex::lod::progressive::Made;
use invertex::lod::progressive::colour::{Colours, Distance, colour_deviations};

/// What was sampled on one model.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Found {
    pub(crate) points: usize,
    pub(crate) above: usize,
    /// Products that the reference is too steep for, and those that it comes near to.
    pub(crate) steeper: usize,
    pub(crate) steep: usize,
    /// Above nine tenths of the bound.
    pub(crate) near: usize,
    pub(crate) triangles: usize,
    pub(crate) tight: usize,
    /// Of all triangles and levels: those that matter, and those whose bound is met.
    pub(crate) known: usize,
    pub(crate) met: usize,
}

/// Samples triangles of several cuts at several levels.
pub(crate) fn sampled(
    model: &Model,
    colours: &Colours<'_>,
    distance: Distance,
    least: usize,
    points: u64,
) -> Found {
    let history = model.progressive(least);
    let start = std::time::Instant::now();
    let deviations = colour_deviations(&model.input(), &history, colours, distance).unwrap();
    let seconds = start.elapsed().as_secs_f64();
    let floor = if distance == Distance::Lab { 0.1 } else { 0.25 };
    let mut found = Found {
        known: deviations.known,
        met: deviations.met,
        ..Found::default()
    };
    let steps = history.collapses.len();
    for collapses in [steps / 2, steps * 9 / 10, steps] {
        let made: Vec<(usize, &Made)> = history
            .triangles
            .iter()
            .enumerate()
            .filter(|(_, t)| {
                let before = |step: Option<u32>| step.is_some_and(|s| (s as usize) < collapses);
                before(t.made) && !before(t.gone)
            })
            .collect();
        for (t, made) in made.iter().step_by(made.len() / 12 + 1) {
            let seen = largest(model, colours, &deviations, distance, made, points);
            let normal = f64::from(made.deviation.normal);
            for k in 0..deviations.levels {
                let bound = deviations.at(*t, k);
                let [bound, product] = [bound.tangential, bound.product].map(f64::from);
                let steep = seen.steepest[k] * normal;
                found.steeper += usize::from(steep > product * (1.0 + 1e-4));
                found.steep += usize::from(product > floor && steep > 0.5 * product);
                found.points += seen.points;
                // Places of texels are rounded, and answers to 2^-21 of a triangle.
                let rounding = 0.02 + 2e-4 * bound;
                found.above += usize::from(seen.largest[k] > bound + rounding);
                found.near += usize::from(seen.largest[k] > 0.9 * bound + rounding);
                found.triangles += usize::from(bound > floor);
                found.tight += usize::from(bound > floor && seen.largest[k] >= 0.8 * bound);
            }
        }
    }
    println!(
        "{found:?} in {seconds:.2} s of {} triangles",
        history.triangles.len()
    );
    found
}
