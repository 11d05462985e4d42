//! A history made again from its steps.
//!
//! In: a mesh, which place became which, how far the triangles that came of it lie from the reference. Out: the [`Progressive`]
//! that the steps came from, or what is wrong with them: steps may come from anywhere. A step is made only where it keeps the
//! surface one, so that a history that was made is as sound as one that was found.

use super::live::{Live, Turned};
use super::{Collapse, Deviation, Progressive};
use crate::lod::LodInput;

/// What a history is made again from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Steps {
    /// For each collapse the place that goes and the place it becomes.
    pub places: Vec<[u32; 2]>,
    /// For each triangle that a collapse makes, in order, its deviation.
    pub deviations: Vec<Deviation>,
}

impl Progressive {
    /// What [`Progressive::replay`] makes it again from; prices are left out.
    pub fn steps(&self) -> Steps {
        let made = self.triangles.iter().filter(|t| t.made.is_some());
        Steps {
            places: self.collapses.iter().map(|c| [c.from, c.to]).collect(),
            deviations: made.map(|t| t.deviation).collect(),
        }
    }

    /// The history of `input`'s mesh with these steps; the price of a collapse is the largest deviation so far.
    ///
    /// # Errors
    /// What is wrong, in words: a step that the surface does not allow (of another mesh, say), deviations that are too few or
    /// none.
    pub fn replay(input: &LodInput<'_>, steps: &Steps) -> std::result::Result<Self, String> {
        let is_none = |d: &Deviation| !(d.total >= 0.0 && d.tangential >= 0.0 && d.normal >= 0.0);
        if let Some(k) = steps.deviations.iter().position(is_none) {
            return Err(format!("deviation {k} is not a distance"));
        }
        let mut replay = Replay {
            // In which sense lines meet its triangles nobody asks.
            live: Live::new(input, |_| 0),
            deviations: steps.deviations.iter(),
            collapses: Vec::with_capacity(steps.places.len()),
        };
        for &[from, to] in &steps.places {
            let number = replay.collapses.len();
            replay
                .step(from, to)
                .map_err(|reason| format!("collapse {number} of {from} onto {to} {reason}"))?;
        }
        match replay.deviations.len() {
            0 => {
                let mut history = replay.live.into_history(replay.collapses);
                history.price_by_deviation();
                Ok(history)
            }
            n => Err(format!("{n} deviations of no triangle")),
        }
    }
}

struct Replay<'a> {
    live: Live,
    deviations: std::slice::Iter<'a, Deviation>,
    collapses: Vec<Collapse>,
}

impl Replay<'_> {
    fn step(&mut self, from: u32, to: u32) -> std::result::Result<(), &'static str> {
        let live = &mut self.live;
        if from as usize >= live.round.count() {
            return Err("has no such place");
        }
        let ring = live.ring(from).filter(|ring| ring.onto().contains(&to));
        let ring =
            ring.ok_or("is between places that are no neighbours, or of one that may not go")?;
        let star = live
            .star(&ring, to)
            .ok_or("would tear or double the surface")?;
        let count = star.turned.len();
        let (deviations, left) = self
            .deviations
            .as_slice()
            .split_at_checked(count)
            .ok_or("makes triangles without a deviation")?;
        self.deviations = left.iter();
        let turned = deviations.iter().map(|&deviation| Turned {
            sense: 0,
            deviation,
            covers: &[],
        });
        live.collapse([from, to], &star, turned, self.collapses.len() as u32);
        let price = 0.0;
        self.collapses.push(Collapse { from, to, price });
        Ok(())
    }
}

impl Progressive {
    /// Makes the price of each collapse the largest deviation so far of the triangles that were made.
    pub(crate) fn price_by_deviation(&mut self) {
        self.collapses.iter_mut().for_each(|c| c.price = 0.0);
        for t in &self.triangles {
            if let Some(c) = t.made {
                let price = &mut self.collapses[c as usize].price;
                *price = price.max(f64::from(t.deviation.total));
            }
        }
        let mut dearest = 0.0f64;
        for c in &mut self.collapses {
            dearest = dearest.max(c.price);
            c.price = dearest;
        }
    }
}
