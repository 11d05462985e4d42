//! The measures along rays of views: object space, image space, normalised.

use super::AssessSettings;
use super::heat::Gathering;
use crate::asset::Progress;
use crate::mesh::bvh::{Asking, Bvh, Ray, Sides};
use crate::recover::{Finder, High, Laid, Search, spread};
use crate::{Error, Result};
use glam::{DVec3, Vec3};
use rayon::prelude::*;

/// Radians between the spirals of probes and views: no view is a probe.
pub(super) const TURN: f64 = 1.0;
/// Views between two words about progress.
const BATCH: usize = 16;
/// Steps shorter than this share of the diagonal have no direction.
const STANDING: f64 = 1e-7;

/// Sums over rays, in the unit of the world.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Sums {
    pub(super) object: f64,
    pub(super) object_squared: f64,
    /// Rays that met both surfaces.
    pub(super) both: u64,
    pub(super) image: f64,
    /// Rays that met the simple surface where it has a point of the reference.
    pub(super) rays: u64,
    pub(super) normalized: f64,
    /// Those of them whose step has a length.
    pub(super) steps: u64,
    /// Rays that met the simple surface where the mapping found nothing.
    pub(super) missed: u64,
}

impl Sums {
    fn join(&mut self, other: &Sums) {
        self.object += other.object;
        self.object_squared += other.object_squared;
        self.both += other.both;
        self.image += other.image;
        self.rays += other.rays;
        self.normalized += other.normalized;
        self.steps += other.steps;
        self.missed += other.missed;
    }
}

/// The simple model as one run of triangles.
struct Lows<'a> {
    of: &'a [&'a Laid],
    /// Number of each mesh's first triangle.
    first: Vec<u32>,
    tree: Bvh,
}

/// A ray's meeting with the simple model.
#[derive(Clone, Copy)]
struct Hit {
    mesh: usize,
    t: usize,
    b: [f32; 3],
    p: DVec3,
    /// The reference's point on the same ray, where its front is seen.
    q: Option<DVec3>,
}

/// Sums for each mapping over all views, one view after the other whatever the number of cores.
pub(super) fn measure(
    high: &High,
    lows: &[&Laid],
    finders: &[Vec<Finder>],
    settings: &AssessSettings,
    heat: &[Gathering],
    progress: &dyn Progress,
) -> Result<Vec<Sums>> {
    let lows = Lows::new(lows);
    let views = spread(settings.views, TURN);
    let mut sums = vec![Sums::default(); finders.len()];
    for (k, batch) in views.chunks(BATCH).enumerate() {
        if progress.cancelled() {
            return Err(Error::Cancelled);
        }
        progress.at("views", "", k * BATCH, views.len());
        let view = |towards: &[f64; 3]| -> Vec<Sums> {
            let hits = lows.hits(high, DVec3::from_array(*towards), settings.rays);
            let of = finders.iter().zip(heat);
            of.map(|(finders, heat)| rate(finders, heat, &hits, DVec3::from_array(*towards), high))
                .collect()
        };
        let each: Vec<Vec<Sums>> = batch.par_iter().map(view).collect();
        for one in &each {
            sums.iter_mut().zip(one).for_each(|(sum, s)| sum.join(s));
        }
    }
    Ok(sums)
}

impl<'a> Lows<'a> {
    fn new(of: &'a [&'a Laid]) -> Lows<'a> {
        let (mut corners, mut first) = (Vec::new(), Vec::new());
        for low in of {
            first.push(corners.len() as u32);
            corners.extend((0..low.world.triangles.len()).map(|t| low.world.corners(t)));
        }
        Lows {
            of,
            first,
            tree: Bvh::new(&corners),
        }
    }

    /// What the rays of one view meet.
    fn hits(&self, high: &High, towards: DVec3, side: u32) -> Vec<Hit> {
        let (low, far) = self.tree.bounds();
        let wide = |p: [f32; 3]| DVec3::from_array(p.map(f64::from));
        let centre = (wide(low) + wide(far)) * 0.5;
        let radius = (wide(far) - wide(low)).length() * 0.5;
        let (right, up) = towards.any_orthonormal_pair();
        let mut asking = (self.tree.asking(), high.tree.asking());
        let mut hits = Vec::new();
        for k in 0..side * side {
            let [x, y] = [k % side, k / side]
                .map(|c| (2.0 * (f64::from(c) + 0.5) / f64::from(side) - 1.0) * radius);
            let begin = centre + right * x + up * y + towards * (2.0 * radius);
            hits.extend(self.hit(high, &mut asking, begin, towards));
        }
        hits
    }

    fn hit(
        &self,
        high: &High,
        (low_asking, high_asking): &mut (Asking, Asking),
        begin: DVec3,
        towards: DVec3,
    ) -> Option<Hit> {
        let ray = Ray {
            begin: begin.as_vec3().to_array(),
            way: (-towards).as_vec3().to_array(),
            reach: f32::INFINITY,
            sides: Sides::Both,
        };
        let found = low_asking.first(ray)?;
        let mesh = self.first.partition_point(|&f| f <= found.triangle) - 1;
        let t = (found.triangle - self.first[mesh]) as usize;
        let low = self.of[mesh];
        // A back hides, and shows nothing.
        if !faces(low.world.corners(t), towards) {
            return None;
        }
        let seen = high_asking
            .first(ray)
            .filter(|q| faces(high.corners[q.triangle as usize], towards));
        Some(Hit {
            mesh,
            t,
            b: found.b,
            p: point(&low.world.corners(t), found.b),
            q: seen.map(|q| point(&high.corners[q.triangle as usize], q.b)),
        })
    }
}

fn faces(corners: [[f32; 3]; 3], towards: DVec3) -> bool {
    let [a, b, c] = corners.map(Vec3::from_array);
    (b - a).cross(c - a).as_dvec3().dot(towards) > 0.0
}

fn point(corners: &[[f32; 3]; 3], b: [f32; 3]) -> DVec3 {
    (0..3)
        .map(|k| DVec3::from_array(corners[k].map(f64::from)) * f64::from(b[k]))
        .sum()
}

/// One mapping over the hits of one view.
fn rate(finders: &[Finder], heat: &Gathering, hits: &[Hit], towards: DVec3, high: &High) -> Sums {
    let mut searches: Vec<Search> = finders.iter().map(Finder::search).collect();
    let standing = STANDING * f64::from(high.tree.diagonal());
    let mut sums = Sums::default();
    for hit in hits {
        let answer = searches[hit.mesh].at(hit.t, hit.b);
        let Some((triangle, b)) = answer.found else {
            sums.missed += 1;
            continue;
        };
        let f = point(&high.corners[triangle as usize], b);
        let step = f - hit.p;
        let aside = (step - towards * step.dot(towards)).length();
        sums.image += aside;
        sums.rays += 1;
        if step.length() > standing {
            sums.normalized += aside / step.length();
            sums.steps += 1;
        }
        let object = hit.q.map(|q| q.distance(f));
        if let Some(object) = object {
            sums.object += object;
            sums.object_squared += object * object;
            sums.both += 1;
        }
        heat.add(
            hit.mesh,
            finders[hit.mesh].low.uv(hit.t, hit.b),
            aside,
            object,
        );
    }
    sums
}
