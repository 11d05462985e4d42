//! Many questions at once: closest points and first hits of a surface, on all cores or on a device.
//!
//! In: triangles, then questions. Out: an answer for each, the same bits on every processor, and those of asking every
//! triangle: of equally near ones the lowest.

#[cfg(feature = "gpu")]
mod gpu;

use crate::mesh::bvh::{Bvh, Found, NO_HINT, Ray, Sides};
use rayon::prelude::*;

/// Questions that one core answers in a run, each search beginning where the last one ended.
const CHUNK: usize = 2048;

/// Triangles, ready to be asked about.
///
/// ```
/// use invertex::mesh::shapes;
/// use invertex::recover::{Question, Triangles};
///
/// let ball = shapes::icosphere(3);
/// let corners: Vec<_> = (0..ball.triangles.len()).map(|t| ball.corners(t)).collect();
/// let triangles = Triangles::new(&corners);
/// let closest = triangles.ask(&[Question::closest([0.0, 0.0, 2.0])]);
/// assert!((closest[0].unwrap().distance.sqrt() - 1.0).abs() < 0.02);
/// ```
pub struct Triangles {
    tree: Bvh,
    /// Kept for the few questions that are too deep for a device.
    #[cfg(feature = "gpu")]
    words: std::sync::OnceLock<gpu::Words>,
}

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// The point that is asked about, or where a ray begins.
    pub place: [f32; 3],
    /// How far away an answer may lie: the square of the distance, or, for a ray, in lengths of `way`.
    pub within: f32,
    /// The direction of a ray; or, for a closest point, the direction that triangles must not face away from.
    pub way: [f32; 3],
    /// What is wanted.
    pub ask: Ask,
}

/// Kinds of questions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// The closest point.
    Closest,
    /// The closest point of triangles that do not face away from `way`.
    ClosestFacing,
    /// The first hit of a ray.
    Ray,
    /// The first hit of a front.
    RayFront,
    /// The first hit of a back.
    RayBack,
}

/// A point of a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Number of the triangle.
    pub triangle: u32,
    /// Barycentrics there.
    pub barycentric: [f32; 3],
    /// The square of the distance; for a ray how many lengths of its direction away.
    pub distance: f32,
}

impl Question {
    /// The closest point to `place`, however far.
    pub fn closest(place: [f32; 3]) -> Question {
        Question {
            place,
            within: f32::INFINITY,
            way: [0.0, 0.0, 1.0],
            ask: Ask::Closest,
        }
    }

    /// The first hit of a ray, whatever its side.
    pub fn ray(place: [f32; 3], way: [f32; 3], within: f32) -> Question {
        Question {
            place,
            within,
            way,
            ask: Ask::Ray,
        }
    }
}

impl Question {
    /// The ray that is asked about, if it is one.
    fn as_ray(&self) -> Option<Ray> {
        let sides = match self.ask {
            Ask::Closest | Ask::ClosestFacing => return None,
            Ask::Ray => Sides::Both,
            Ask::RayFront => Sides::Front,
            Ask::RayBack => Sides::Back,
        };
        Some(Ray {
            begin: self.place,
            way: self.way,
            reach: self.within,
            sides,
        })
    }

    /// What triangles must not face away from.
    fn facing(&self) -> Option<[f32; 3]> {
        (self.ask == Ask::ClosestFacing).then_some(self.way)
    }
}

impl Triangles {
    /// Builds the tree over triangles, which keep their numbers.
    pub fn new(corners: &[[[f32; 3]; 3]]) -> Triangles {
        Triangles {
            tree: Bvh::new(corners),
            #[cfg(feature = "gpu")]
            words: std::sync::OnceLock::new(),
        }
    }

    /// An answer for each question, on all cores; none where nothing is within reach.
    pub fn ask(&self, questions: &[Question]) -> Vec<Option<Answer>> {
        let chunks = questions.par_chunks(CHUNK);
        chunks.flat_map_iter(|some| self.run(some)).collect()
    }

    /// The same answers by asking every triangle, one question after the other: slow, and the definition that the others are
    /// held against.
    pub fn ask_every(&self, questions: &[Question]) -> Vec<Option<Answer>> {
        let asking = self.tree.asking();
        let answer = |q: &Question| {
            let found = match q.as_ray() {
                Some(ray) => asking.first_of_every(ray),
                None => asking.closest_of_every(q.place, q.within, q.facing()),
            };
            found.map(Answer::from)
        };
        let chunks = questions.par_chunks(CHUNK);
        chunks
            .flat_map_iter(|some| some.iter().map(answer))
            .collect()
    }

    fn run(&self, questions: &[Question]) -> Vec<Option<Answer>> {
        let mut asking = self.tree.asking();
        let mut hint = NO_HINT;
        let answer = |q: &Question| {
            let found = match q.as_ray() {
                Some(ray) => asking.first(ray),
                None => asking.closest(q.place, q.within, q.facing(), hint),
            };
            hint = found.map_or(hint, |f| f.hint);
            found.map(Answer::from)
        };
        questions.iter().map(answer).collect()
    }
}

impl From<Found> for Answer {
    fn from(found: Found) -> Answer {
        Answer {
            triangle: found.triangle,
            barycentric: found.b,
            distance: found.distance,
        }
    }
}
