//! From a point of the simple surface to its point of the reference.
//!
//! In: both surfaces, a [`Mapping`]. Out: [`Finder`], which any number of cores ask through [`Search`]. Each search keeps where
//! it found its last point: neighbours begin there. Rays along normals of one triangle lie in the prism between its corners'
//! normals; a search over texels keeps where such rays begin in the tree.

use super::high::High;
use super::laid::Laid;
use super::mapping::{Mapping, Misses, Recovery};
use super::visible::Field;
use crate::attribute::arithmetic::{V3, add3, dot3, scale3, sub3, unit3, weighted};
use crate::mesh::bvh::{Asking, Bundle, Found, NO_HINT, Ray, Sides};
use std::collections::HashMap;
use std::rc::Rc;

/// How much farther a ray goes than its corners' normals, weighted: normals within 60 degrees of each other have a mean of
/// length sqrt(2/3) at least.
const LONGER: f32 = 1.25;

/// Finds points of the reference.
pub(crate) struct Finder<'a> {
    pub(crate) high: &'a High,
    pub(crate) low: &'a Laid,
    mapping: Mapping,
    facing: bool,
    misses: Misses,
    /// How far rays go, in the world's unit.
    reach: f32,
    /// Directions of visibility, for the mappings that need them.
    field: Option<&'a Field>,
}

/// A search, point after point.
pub(crate) struct Search<'a> {
    finder: &'a Finder<'a>,
    asking: Asking<'a>,
    hint: u32,
    /// Where rays begin, for triangles asked about before; none inside: at the root. None at all: nobody asks for neighbours.
    bundles: Option<HashMap<usize, Option<Rc<Bundle>>>>,
    last: Last,
}

/// The triangle that was asked about last: neighbours mostly lie in one.
struct Last {
    t: usize,
    corners: [V3; 3],
    /// Directions of normal rays at its corners.
    outward: [V3; 3],
    bundle: Option<Rc<Bundle>>,
}

/// What was found for a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Answer {
    /// Triangle of the reference and barycentrics there; none where nothing is, or was asked for.
    pub(crate) found: Option<(u32, [f32; 3])>,
    /// The mapping itself had no answer; what stands here is what stands in for it.
    pub(crate) missed: bool,
}

impl<'a> Finder<'a> {
    pub(crate) fn new(
        (high, low): (&'a High, &'a Laid),
        mapping: Mapping,
        recovery: &Recovery,
        reach: f32,
        field: Option<&'a Field>,
    ) -> Self {
        Finder {
            high,
            low,
            mapping,
            facing: recovery.facing,
            misses: recovery.misses,
            reach,
            field,
        }
    }

    pub(crate) fn search(&'a self) -> Search<'a> {
        Search {
            finder: self,
            asking: self.high.tree.asking(),
            hint: NO_HINT,
            bundles: None,
            last: Last {
                t: usize::MAX,
                corners: [[0.0; 3]; 3],
                outward: [[0.0; 3]; 3],
                bundle: None,
            },
        }
    }

    /// A search over points that are neighbours; the same answers, sooner.
    pub(crate) fn search_neighbours(&'a self) -> Search<'a> {
        let along_normals = self.mapping == Mapping::Normal;
        Search {
            bundles: along_normals.then(HashMap::new),
            ..self.search()
        }
    }

    /// Where rays along the normals of triangle `t` begin; none where normals differ too much.
    fn bundle(&self, t: usize) -> Option<Bundle> {
        let corners = self.low.world.triangles[t].map(|v| v as usize);
        let normals = corners.map(|v| self.low.outward[v]);
        let near = |a: usize, b: usize| dot3(normals[a], normals[b]) >= 0.5;
        if !(near(0, 1) && near(1, 2) && near(2, 0)) {
            return None;
        }
        let ends = [0, 1, 2].map(|k| {
            let (p, way) = (self.low.world.positions[corners[k]], normals[k]);
            let far = self.reach * LONGER;
            [add3(p, scale3(way, far)), sub3(p, scale3(way, far))]
        });
        let all = ends.as_flattened();
        let least = |k: usize| all.iter().fold(f32::INFINITY, |m, p| m.min(p[k]));
        let most = |k: usize| all.iter().fold(f32::NEG_INFINITY, |m, p| m.max(p[k]));
        let [low, high] = [[0, 1, 2].map(least), [0, 1, 2].map(most)];
        Some(self.high.tree.bundle(low, high))
    }

    /// The mapping at a point.
    fn mapping(&self, t: usize, b: [f32; 3]) -> Mapping {
        let choice = |field: &Field| field.choice(self.low, t, b);
        self.field.and_then(choice).unwrap_or(self.mapping)
    }

    /// The unit direction in which `mapping` looks.
    fn direction(&self, mapping: Mapping, t: usize, b: [f32; 3], outward: V3) -> V3 {
        let (Some(field), true) = (self.field, mapping != Mapping::Normal) else {
            return outward;
        };
        let seen = field.at(mapping, self.low, t, b);
        let weight = match mapping {
            Mapping::HybridVertex | Mapping::HybridTexel => weight_of_normal(seen),
            _ => 0.0,
        };
        let from = scale3(unit3(seen, outward), 1.0 - weight);
        unit3(add3(from, scale3(outward, weight)), outward)
    }
}

/// How much the normal counts beside the mean direction `seen` (the rest is the mean direction's): the standard deviation
/// of the directions of sight, sqrt(1 - seen^2).
///
/// The paper gives no formula. This one has no constant to tune, is 0 where all sight comes from one direction, grows with
/// the spread as the paper asks, and is continuous. Directions over an open hemisphere, weighted by the area they see, have
/// the mean 2/3 n and the weight 0.745; there both vectors agree, so the weight matters in hollows alone.
pub(crate) fn weight_of_normal(seen: V3) -> f32 {
    (1.0 - dot3(seen, seen)).max(0.0).sqrt()
}

impl Search<'_> {
    /// What the point at barycentrics `b` of triangle `t` of the simple surface stands for.
    pub(crate) fn at(&mut self, t: usize, b: [f32; 3]) -> Answer {
        let finder = self.finder;
        if self.last.t != t {
            self.turn_to(t);
        }
        let p = weighted(&self.last.corners, b);
        let outward = self.outward(b);
        let mapping = finder.mapping(t, b);
        let facing = finder.facing.then_some(outward);
        let mut found = match mapping {
            Mapping::Proximity => self.closest(p, facing),
            Mapping::Cage => self.inwards(t, b, p, outward),
            _ => self.both_ways(p, finder.direction(mapping, t, b, outward)),
        };
        if found.is_none() && finder.mapping == Mapping::Auto {
            // What was best at the middle of a texel may miss beside it.
            found = self.closest(p, facing);
        }
        if let Some(found) = found {
            self.hint = found.hint;
        }
        let missed = found.is_none();
        let found = found.or_else(|| {
            let stands_in = finder.misses == Misses::Proximity;
            stands_in.then(|| self.closest(p, None)).flatten()
        });
        Answer {
            found: found.map(|f| (f.triangle, f.b)),
            missed,
        }
    }

    fn closest(&mut self, p: V3, facing: Option<V3>) -> Option<Found> {
        self.asking.closest(p, f32::INFINITY, facing, self.hint)
    }

    fn ray(&mut self, begin: V3, way: V3, reach: f32, sides: Sides) -> Option<Found> {
        let ray = self.counted(begin, way, reach, sides);
        self.asking.first(ray)
    }

    fn counted(&self, begin: V3, way: V3, reach: f32, sides: Sides) -> Ray {
        let sides = match self.finder.facing {
            true => sides,
            false => Sides::Both,
        };
        Ray {
            begin,
            way,
            reach,
            sides,
        }
    }

    /// Outwards first: what lies over the surface hides what lies under it.
    fn both_ways(&mut self, p: V3, way: V3) -> Option<Found> {
        let outwards = self.counted(p, way, self.finder.reach, Sides::Back);
        self.asking
            .first_of_both(outwards, self.last.bundle.as_deref())
    }

    /// Makes `t` the last triangle.
    fn turn_to(&mut self, t: usize) {
        let (finder, low) = (self.finder, self.finder.low);
        let corners = low.world.triangles[t].map(|v| v as usize);
        let bundle = self.bundles.as_mut().and_then(|bundles| {
            let made = || finder.bundle(t).map(Rc::new);
            bundles.entry(t).or_insert_with(made).clone()
        });
        self.last = Last {
            t,
            corners: corners.map(|v| low.world.positions[v]),
            outward: corners.map(|v| low.outward[v]),
            bundle,
        };
    }

    /// The unit normal of rays at a point of the last triangle; the triangle's own where normals cancel out.
    fn outward(&self, b: [f32; 3]) -> V3 {
        let mean = weighted(&self.last.outward, b);
        if dot3(mean, mean) > 1e-12 {
            return unit3(mean, mean);
        }
        self.finder
            .low
            .world
            .face_normal(self.last.t)
            .map(|c| c as f32)
    }

    /// From the cage to the point and on, as far as rays reach; without a cage from as far outside.
    fn inwards(&mut self, t: usize, b: [f32; 3], p: V3, outward: V3) -> Option<Found> {
        let (reach, inward) = (self.finder.reach, scale3(outward, -1.0));
        let Some(corners) = self.finder.low.cage.get(t) else {
            let begin = add3(p, scale3(outward, reach));
            return self.ray(begin, inward, 2.0 * reach, Sides::Front);
        };
        let begin = weighted(corners, b);
        let way = sub3(p, begin);
        let length = dot3(way, way).sqrt();
        // Where the cage touches the surface there is no way between them.
        self.ray(begin, unit3(way, inward), length + reach, Sides::Front)
    }
}
