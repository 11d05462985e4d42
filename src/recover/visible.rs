//! From where each place of a simple surface is seen: means of the probes' directions, section 3.3.
//!
//! In: surfaces, what is asked for. Out: [`Field`]: at each point of a surface the mean of the directions that see it, no
//! longer than 1; the shorter, the more they vary.

use super::beyond::{Beyond, There, beyond};
use super::choose::{CHOICES, choose};
use super::continuity::Links;
use super::high::High;
use super::laid::Laid;
use super::mapping::{Mapping, Probes, Recovery};
use super::probe::{Draw, Probing, Seen, spread};
use super::texel::place;
use crate::Result;
use crate::attribute::arithmetic::{V3, add3, cross3, dot3, scale3, sub3};
use crate::mesh::NONE;
use rayon::prelude::*;
use std::sync::Arc;

/// Rounds of the filter that texels' sums are smoothed by, a texel a round.
const ROUNDS: usize = 8;
/// Rounds in which vertices that nothing sees take their neighbours' mean.
const SPREAD: usize = 64;

/// Mean directions over a surface.
pub(crate) enum Field {
    /// Of each vertex.
    Vertices(Vec<V3>),
    /// Of each texel of a square texture; 0 where nothing is.
    Texels { size: u32, mean: Vec<V3> },
    /// For each texel of a square texture which of [`CHOICES`] serves it best, and what those need.
    Choice {
        vertices: Arc<Field>,
        texels: Arc<Field>,
        size: u32,
        choice: Vec<u8>,
    },
}

impl Field {
    /// The mean direction that `mapping` asks for at a point, unit or shorter.
    pub(super) fn at(&self, mapping: Mapping, low: &Laid, t: usize, b: [f32; 3]) -> V3 {
        match self {
            Field::Vertices(of) => low.weighted(of, t, b),
            Field::Texels { size, mean } => mean[place(*size, low.uv(t, b))],
            Field::Choice {
                vertices, texels, ..
            } => match mapping {
                Mapping::VisibilityTexel | Mapping::HybridTexel => texels.at(mapping, low, t, b),
                _ => vertices.at(mapping, low, t, b),
            },
        }
    }

    /// The mapping that serves a point best, where that is chosen by place.
    pub(super) fn choice(&self, low: &Laid, t: usize, b: [f32; 3]) -> Option<Mapping> {
        match self {
            Field::Choice { size, choice, .. } => {
                let best = choice[place(*size, low.uv(t, b))];
                Some(CHOICES[usize::from(best)])
            }
            _ => None,
        }
    }
}

/// Fields of some surfaces, each kind made once, whichever mappings ask for it.
pub(crate) struct Fields<'a> {
    high: &'a High,
    lows: &'a [&'a Laid],
    recovery: &'a Recovery,
    /// How far the rays of each surface go.
    reaches: &'a [f32],
    /// Texels along a side, for texels' directions.
    size: u32,
    draw: Draw<'a>,
    vertices: Option<Made>,
    texels: Option<Made>,
}

/// A field for each surface.
type Made = Vec<Arc<Field>>;

impl<'a> Fields<'a> {
    pub(crate) fn new(
        (high, lows): (&'a High, &'a [&'a Laid]),
        recovery: &'a Recovery,
        reaches: &'a [f32],
        size: u32,
        draw: Draw<'a>,
    ) -> Fields<'a> {
        Fields {
            high,
            lows,
            recovery,
            reaches,
            size,
            draw,
            vertices: None,
            texels: None,
        }
    }

    /// The fields of all surfaces for `mapping`; none for one that needs no visibility.
    pub(crate) fn of(&mut self, mapping: Mapping) -> Result<Vec<Option<Arc<Field>>>> {
        let made = match mapping {
            Mapping::VisibilityFace => {
                let faces = faces(self.lows, &self.recovery.probes, self.draw)?;
                faces.into_iter().map(Arc::new).collect()
            }
            Mapping::VisibilityVertex | Mapping::HybridVertex => self.vertices()?,
            Mapping::VisibilityTexel | Mapping::HybridTexel => self.texels()?,
            Mapping::Auto => self.choices()?,
            _ => return Ok(vec![None; self.lows.len()]),
        };
        Ok(made.into_iter().map(Some).collect())
    }

    fn vertices(&mut self) -> Result<Made> {
        if let Some(made) = &self.vertices {
            return Ok(made.clone());
        }
        let fields = vertices(self.lows, &self.recovery.probes, self.draw)?;
        let made: Made = fields.into_iter().map(Arc::new).collect();
        self.vertices = Some(made.clone());
        Ok(made)
    }

    fn texels(&mut self) -> Result<Made> {
        if let Some(made) = &self.texels {
            return Ok(made.clone());
        }
        let fields = texels(self.lows, &self.recovery.probes, self.size, self.draw)?;
        let made: Made = fields.into_iter().map(Arc::new).collect();
        self.texels = Some(made.clone());
        Ok(made)
    }

    fn choices(&mut self) -> Result<Made> {
        let (vertices, texels) = (self.vertices()?, self.texels()?);
        let both = (self.high, self.lows);
        let choice = |(k, seen): (usize, (Arc<Field>, Arc<Field>))| {
            Arc::new(choose(
                both,
                k,
                self.recovery,
                self.reaches[k],
                seen,
                self.size,
            ))
        };
        let all = vertices.into_iter().zip(texels).enumerate();
        Ok(all.map(choice).collect())
    }
}

/// Sums of directions, and how many.
#[derive(Clone, Copy, Default)]
struct Sum {
    v: V3,
    k: f32,
}

impl Sum {
    fn add(&mut self, direction: V3, weight: f32) {
        self.v = add3(self.v, scale3(direction, weight));
        self.k += weight;
    }

    fn join(&mut self, other: &Sum) {
        self.v = add3(self.v, other.v);
        self.k += other.k;
    }

    fn mean(&self) -> Option<V3> {
        (self.k > 0.0).then(|| scale3(self.v, 1.0 / self.k))
    }
}

/// Directions and how much each counts.
pub(super) fn weighted(probes: &Probes) -> Vec<([f64; 3], f32)> {
    let count = |d: [f64; 3]| {
        let Some(up) = probes.upright else { return 1.0 };
        let up = glam::DVec3::from_array(up.map(f64::from)).normalize_or(glam::DVec3::Y);
        let sine = up.dot(glam::DVec3::from_array(d));
        (1.0 - sine * sine) as f32
    };
    let all = spread(probes.directions, 0.0).into_iter();
    all.map(|d| (d, count(d))).collect()
}

/// Counts for each surface's elements, in whole pixels or shares of them, one probe after the other: sums of few large
/// numbers, in one order.
fn gathered(
    lows: &[&Laid],
    probes: &Probes,
    draw: Draw,
    elements: &dyn Fn(usize) -> usize,
    count: &mut dyn FnMut(usize, &Seen, &mut [f32]),
) -> Result<Vec<Vec<Sum>>> {
    let probing = Probing::new(lows, probes, draw)?;
    let empty = |k: usize| vec![Sum::default(); elements(k)];
    let mut sums: Vec<Vec<Sum>> = (0..lows.len()).map(empty).collect();
    for (direction, weight) in weighted(probes) {
        let mut counts: Vec<Vec<f32>> = sums.iter().map(|s| vec![0.0; s.len()]).collect();
        probing.see(direction, &mut |low, seen| {
            count(low, &seen, &mut counts[low]);
        })?;
        let d = direction.map(|c| c as f32);
        for (sums, counts) in sums.iter_mut().zip(&counts) {
            for (sum, count) in sums.iter_mut().zip(counts).filter(|(_, c)| **c > 0.0) {
                sum.add(d, count * weight);
            }
        }
    }
    Ok(sums)
}

/// Per face, by pixels; then at vertices, by angles.
fn faces(lows: &[&Laid], probes: &Probes, draw: Draw) -> Result<Vec<Field>> {
    let sums = gathered(
        lows,
        probes,
        draw,
        &|k| lows[k].world.triangles.len(),
        &mut |_, seen, counts| counts[seen.triangle] += 1.0,
    )?;
    let field = |(low, sums): (&&Laid, Vec<Sum>)| {
        let mut at = vec![Sum::default(); low.world.positions.len()];
        for (t, sum) in sums.iter().enumerate() {
            let Some(mean) = sum.mean() else { continue };
            let corners = low.world.corners(t);
            for k in 0..3 {
                let v = low.world.triangles[t][k] as usize;
                at[low.weld.of[v] as usize].add(mean, angle(&corners, k));
            }
        }
        Field::Vertices(complete(low, at))
    };
    Ok(lows.iter().zip(sums).map(field).collect())
}

/// The angle of a triangle at corner `k`, radians.
fn angle(corners: &[V3; 3], k: usize) -> f32 {
    let (a, b) = (
        sub3(corners[(k + 1) % 3], corners[k]),
        sub3(corners[(k + 2) % 3], corners[k]),
    );
    let across = cross3(a, b);
    dot3(across, across).sqrt().atan2(dot3(a, b))
}

/// Per vertex, by barycentrics of pixels.
fn vertices(lows: &[&Laid], probes: &Probes, draw: Draw) -> Result<Vec<Field>> {
    let sums = gathered(
        lows,
        probes,
        draw,
        &|k| lows[k].world.positions.len(),
        &mut |k, seen, counts| {
            let low = lows[k];
            for (v, b) in low.world.triangles[seen.triangle].iter().zip(seen.b) {
                counts[low.weld.of[*v as usize] as usize] += b.max(0.0);
            }
        },
    )?;
    let field = |(low, sums): (&&Laid, Vec<Sum>)| Field::Vertices(complete(low, sums));
    Ok(lows.iter().zip(sums).map(field).collect())
}

/// Means of all vertices; where nothing is seen those of neighbours, and 0 where they have none either.
fn complete(low: &Laid, mut at: Vec<Sum>) -> Vec<V3> {
    let triangles = low.weld.triangles(&low.world.triangles);
    for _ in 0..SPREAD {
        let mut more: Vec<(usize, Sum)> = Vec::new();
        for t in &triangles {
            let mut sum = Sum::default();
            for mean in t.iter().filter_map(|&v| at[v as usize].mean()) {
                sum.add(mean, 1.0);
            }
            let empty = t.iter().filter(|&&v| at[v as usize].k == 0.0);
            more.extend(empty.filter(|_| sum.k > 0.0).map(|&v| (v as usize, sum)));
        }
        if more.is_empty() {
            break;
        }
        more.iter().for_each(|(v, sum)| at[*v].join(sum));
    }
    let mean = |v: &u32| at[*v as usize].mean().unwrap_or([0.0; 3]);
    low.weld.of.iter().map(mean).collect()
}

/// Per texel: sums smoothed over neighbours, across seams too, and only then divided.
fn texels(lows: &[&Laid], probes: &Probes, size: u32, draw: Draw) -> Result<Vec<Field>> {
    let links: Vec<Links> = lows.iter().map(|low| Links::new(low, size)).collect();
    let sums = gathered(
        lows,
        probes,
        draw,
        &|k| links[k].texels.len(),
        &mut |k, seen, counts| {
            let number = links[k].at_uv(lows[k].uv(seen.triangle, seen.b));
            if number != NONE {
                counts[number as usize] += 1.0;
            }
        },
    )?;
    let beyond = beyond(lows, &links, size);
    let sums = smooth(&links, &beyond, sums);
    let field = |(links, sums): (&Links, Vec<Sum>)| {
        let mut mean = vec![[0.0; 3]; size as usize * size as usize];
        for (texel, sum) in links.texels.iter().zip(sums) {
            mean[*texel as usize] = sum.mean().unwrap_or([0.0; 3]);
        }
        Field::Texels { size, mean }
    };
    Ok(links.iter().zip(sums).map(field).collect())
}

/// Each texel's sum becomes the sum of its own and its neighbours', in other tiles too, round after round.
fn smooth(links: &[Links], beyond: &[Beyond], mut sums: Vec<Vec<Sum>>) -> Vec<Vec<Sum>> {
    for _ in 0..ROUNDS {
        let surface = |low: usize| -> Vec<Sum> {
            let own = sums[low].par_iter().zip(&links[low].next).enumerate();
            let joined = own.map(|(k, (own, next))| {
                let mut sum = *own;
                for (way, &n) in next.iter().enumerate() {
                    let there = match n {
                        NONE => beyond[low].get(&(k as u32, way)).copied(),
                        texel => Some(There { low, texel }),
                    };
                    if let Some(There { low, texel }) = there {
                        sum.join(&sums[low][texel as usize]);
                    }
                }
                // Kept small: 5^8 would still be exact, more rounds would not.
                Sum {
                    v: scale3(sum.v, 0.25),
                    k: sum.k * 0.25,
                }
            });
            joined.collect()
        };
        sums = (0..links.len()).map(surface).collect();
    }
    sums
}
