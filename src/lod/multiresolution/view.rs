//! The flow diagram of the paper: whether a region may be drawn as coarsely as a collapse leaves it.
//!
//! In: a view of an object, limits in pixels and in colour, a [`Bound`]. Out: yes or no.
//!
//! ```text
//! back side of the original surface, or out of sight ............................ yes
//! deviation within the pixels .................................................... yes
//! its normal part within the pixels, and the tangential colour within the limit ... yes
//! seen at 45 degrees or more, and tangential colour + product x cot(angle) ........ yes
//! else ............................................................................ no
//! ```
//!
//! **A region that holds another is never judged better.** Every quantity is a sum of products of ends of intervals, made of
//! additions, multiplications, minima and maxima: with intervals that hold the others' these are ordered, and rounding keeps
//! the order. So cuts are closed on every processor, without a tolerance. That is why regions are boxes, not the nested
//! spheres and cones that the literature has: distances to spheres with different centres are ordered but for rounding.
//!
//! Nothing here divides or takes a root, so that processors agree to the bit. Source: Schilling and Klein, Texture-dependent
//! refinement of multiresolution meshes, section 5 and figure 4.

use super::bound::{Bound, NORMAL_STEPS};
use super::{Criterion, Limits};
use crate::error::{Error, Result};
use bytemuck::{Pod, Zeroable};
use glam::{DMat4, DVec3, DVec4};

/// Most levels of footprints that colour deviations have.
pub const MAX_LEVELS: usize = 16;

/// How an object is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Seen {
    /// From object space to the camera's: x to the right, y up, looking along -z.
    pub object_to_view: DMat4,
    /// From the camera's space to clip space.
    pub projection: DMat4,
    /// Of the picture, in pixels.
    pub size: [u32; 2],
    /// Whether back sides are seen too.
    pub double_sided: bool,
}

/// A view as a shader reads it, in units of the model's. Where a number has two values the first is the limit for what becomes
/// coarser, the second for what is that coarse already.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct View {
    /// The eye; in a parallel projection the direction that is looked along.
    pub eye: [f32; 3],
    /// 1: perspective; 2: back sides are seen; 4: angles count (no uneven scaling); 8: colours count; 16: what is outside of
    /// the picture is judged by its place alone; 32: only normal parts of deviations count.
    pub flags: u32,
    /// The depth of a point is this times its place relative to the eye.
    pub forward: [f32; 3],
    /// A deviation times this, over the distance, is at most its pixels anywhere in the picture.
    pub by_distance: f32,
    /// A deviation times this, times the distance, over the depth squared, is at most its pixels.
    pub by_depth: f32,
    /// Levels of colour deviations.
    pub levels: u32,
    /// Limits in pixels.
    pub pixels: [f32; 2],
    /// Limits in colour.
    pub colour: [f32; 2],
    pub(super) unused: [u32; 2],
    /// Squared distances from which on a level's footprint is that of a pixel.
    pub from: [f32; MAX_LEVELS],
    /// Planes that the picture lies in: normal and offset.
    pub planes: [[f32; 4]; 5],
}

const PERSPECTIVE: u32 = 1;
const DOUBLE_SIDED: u32 = 2;
const ANGLES: u32 = 4;
const COLOURS: u32 = 8;
const OUTSIDE_IS_COARSE: u32 = 16;
const SURFACE_ALONE: u32 = 32;

/// Which of two limits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Limit {
    /// For what becomes coarser.
    Coarsen = 0,
    /// For what is that coarse already.
    Stay = 1,
}

/// Colours of a region: tangential deviation and product for a level.
pub(super) type ColourAt<'a> = &'a dyn Fn(usize) -> [f32; 2];

impl View {
    /// `unit` is what a unit of the model is in object space, `footprint` that of level 0 in object units, with `levels`.
    ///
    /// # Errors
    /// [`Limits::check`]'s; [`Error::Option`] naming `--camera` for matrices that cannot be undone.
    pub(super) fn new(
        seen: &Seen,
        limits: &Limits,
        unit: f64,
        (footprint, levels): (f64, usize),
    ) -> Result<Self> {
        limits.check()?;
        let to_view = seen.object_to_view * DMat4::from_scale(DVec3::splat(unit));
        let stretch = Stretch::of(&to_view).ok_or_else(|| Error::Option {
            option: "--camera",
            reason: "the object is seen through a matrix that cannot be undone".into(),
        })?;
        let p = seen.projection;
        let perspective = p.z_axis.w != 0.0;
        let scale = |axis: f64, size: u32| (axis * f64::from(size) * 0.5).abs();
        let pixels = scale(p.x_axis.x, seen.size[0]).max(scale(p.y_axis.y, seen.size[1]));
        // In a corner of the picture a point's distance is this times its depth.
        let oblique = if perspective { corner(&p) } else { 1.0 };
        let undo = to_view.inverse();
        let (eye, forward) = match perspective {
            true => (
                undo.transform_point3(DVec3::ZERO),
                -to_view.row(2).truncate(),
            ),
            false => (
                undo.transform_vector3(DVec3::NEG_Z).normalize(),
                DVec3::ZERO,
            ),
        };
        let up = |x: f64| (x as f32).next_up();
        let by_distance = pixels * oblique * oblique * stretch.most
            / if perspective { stretch.least } else { 1.0 };
        // At a distance d a pixel's footprint is d / (pixels x oblique) at least; in a parallel projection 1 / pixels.
        let per_distance =
            pixels * oblique / if perspective { stretch.least } else { 1.0 } * stretch.most;
        let from =
            |level: usize| up((footprint / unit * (level as f64).exp2() * per_distance).powi(2));
        let flag = |set: bool, bit: u32| if set { bit } else { 0 };
        let colour = limits.criterion.colour();
        let both = |limit: f64| [(limit * limits.hysteresis) as f32, limit as f32];
        Ok(View {
            eye: eye.as_vec3().to_array(),
            flags: flag(perspective, PERSPECTIVE)
                | flag(seen.double_sided, DOUBLE_SIDED)
                | flag(stretch.is_even(), ANGLES)
                | flag(colour.is_some() && levels > 0, COLOURS)
                | flag(!limits.outside, OUTSIDE_IS_COARSE)
                | flag(limits.criterion == Criterion::Surface, SURFACE_ALONE),
            forward: forward.as_vec3().to_array(),
            by_distance: up(by_distance),
            by_depth: up(pixels * stretch.most * stretch.most),
            levels: levels as u32,
            pixels: both(limits.pixels),
            colour: both(colour.unwrap_or(0.0)),
            unused: [0; 2],
            from: std::array::from_fn(from),
            planes: planes(&(p * to_view)),
        })
    }

    /// The flow diagram. `colour` gives what the region's colours are off by at a level.
    pub(super) fn accepts(&self, bound: &Bound, colour: ColourAt<'_>, limit: Limit) -> bool {
        let place = Place::of(self, bound);
        let [original, simplified] = bound.facings();
        if self.is_outside(bound) || self.is_back(&place, original) {
            return true;
        }
        let pixels = self.pixels[limit as usize];
        let displaced = match self.flags & SURFACE_ALONE {
            0 => bound.total,
            _ => bound.normal,
        };
        if self.within(&place, displaced, pixels) {
            return true;
        }
        if self.flags & COLOURS == 0 {
            return false;
        }
        let most = self.colour[limit as usize];
        let [tangential, product] = colour(self.level(&place));
        if self.within(&place, bound.normal, pixels) {
            return tangential <= most;
        }
        self.flags & ANGLES != 0 && is_steep(&place, simplified, product, most - tangential)
    }

    /// Whether a displacement of a point in the box moves no pixel farther than `pixels`.
    fn within(&self, place: &Place, displacement: f32, pixels: f32) -> bool {
        let spans = displacement * self.by_distance;
        if spans * spans <= pixels * pixels * place.near {
            return true;
        }
        let spans = displacement * self.by_depth;
        let depth = place.depth * place.depth;
        place.depth > 0.0 && spans * spans * place.far <= (pixels * depth) * (pixels * depth)
    }

    /// Pixels that a point in the region of `bound` is displaced by, at most, whatever the limits; none where no pixel is said to
    /// show it rightly: it turns its back to the eye, or it is outside of the picture and may be coarse.
    pub(super) fn displacement(&self, bound: &Bound) -> Option<f64> {
        let place = Place::of(self, bound);
        if self.is_outside(bound) || self.is_back(&place, bound.facings()[0]) {
            return None;
        }
        if bound.total == 0.0 {
            return Some(0.0);
        }
        // The two sides of `within`.
        let [near, far, depth] = [place.near, place.far, place.depth].map(f64::from);
        let by_distance = f64::from(self.by_distance) / near.sqrt();
        let by_depth = match depth > 0.0 {
            true => f64::from(self.by_depth) * far.sqrt() / (depth * depth),
            false => f64::INFINITY,
        };
        Some(f64::from(bound.total) * by_distance.min(by_depth))
    }

    /// Whether all of the region turns its back to the eye: the original surface does.
    fn is_back(&self, place: &Place, facing: [i8; 6]) -> bool {
        self.flags & DOUBLE_SIDED == 0 && along(place, facing).0 >= 0.0
    }

    fn is_outside(&self, bound: &Bound) -> bool {
        self.flags & OUTSIDE_IS_COARSE != 0
            && self.planes.iter().any(|plane| {
                let most = |k: usize| (plane[k] * bound.low[k]).max(plane[k] * bound.high[k]);
                most(0) + most(1) + most(2) + plane[3] < 0.0
            })
    }

    /// The finest level that is in use in the box.
    fn level(&self, place: &Place) -> usize {
        (1..self.levels as usize)
            .take_while(|&level| place.near >= self.from[level])
            .count()
    }
}

/// A box relative to the eye.
struct Place {
    low: [f32; 3],
    high: [f32; 3],
    /// Squared distances of its nearest and its farthest point; 1 in a parallel projection.
    near: f32,
    far: f32,
    /// The least depth in it.
    depth: f32,
}

impl Place {
    fn of(view: &View, bound: &Bound) -> Self {
        if view.flags & PERSPECTIVE == 0 {
            return Place {
                low: view.eye,
                high: view.eye,
                near: 1.0,
                far: 1.0,
                depth: 0.0,
            };
        }
        let low: [f32; 3] = std::array::from_fn(|k| bound.low[k] - view.eye[k]);
        let high: [f32; 3] = std::array::from_fn(|k| bound.high[k] - view.eye[k]);
        let near = |k: usize| low[k].max(-high[k]).max(0.0);
        let far = |k: usize| high[k].max(-low[k]);
        let depth = |k: usize| (view.forward[k] * low[k]).min(view.forward[k] * high[k]);
        let squares = |x: [f32; 3]| x[0] * x[0] + x[1] * x[1] + x[2] * x[2];
        Place {
            near: squares([near(0), near(1), near(2)]),
            far: squares([far(0), far(1), far(2)]),
            depth: depth(0) + depth(1) + depth(2),
            low,
            high,
        }
    }
}

/// The least and the most that a way from the eye into the box goes along a normal, in steps of normals.
fn along(place: &Place, facing: [i8; 6]) -> (f32, f32) {
    let (mut least, mut most) = (0.0f32, 0.0f32);
    for k in 0..3 {
        let (low, high) = (f32::from(facing[k]), f32::from(facing[k + 3]));
        let ends = [
            place.low[k] * low,
            place.low[k] * high,
            place.high[k] * low,
            place.high[k] * high,
        ];
        least += ends[0].min(ends[1]).min(ends[2].min(ends[3]));
        most += ends[0].max(ends[1]).max(ends[2].max(ends[3]));
    }
    (least, most)
}

/// Whether simplified triangles are seen at 45 degrees or more, and the product times the cotangent of the angle is within
/// `left`.
fn is_steep(place: &Place, facing: [i8; 6], product: f32, left: f32) -> bool {
    let upright = -along(place, facing).1;
    let (sine, one) = (upright * upright, place.far * (NORMAL_STEPS * NORMAL_STEPS));
    let cosine = (one - sine).max(0.0);
    upright > 0.0
        && left >= 0.0
        && sine >= 0.5 * one
        && product * product * cosine <= left * left * sine
}

/// How lengths change from a model's units to the camera's.
struct Stretch {
    least: f64,
    most: f64,
}

impl Stretch {
    /// None for a matrix that cannot be undone.
    fn of(m: &DMat4) -> Option<Self> {
        let columns = [m.x_axis, m.y_axis, m.z_axis].map(DVec4::truncate);
        let lengths = columns.map(DVec3::length);
        let (x, y, z) = (columns[0], columns[1], columns[2]);
        let volume = x.dot(y.cross(z)).abs();
        let most = lengths.into_iter().fold(0.0, f64::max);
        if !(volume.is_finite() && volume > 0.0 && m.is_finite()) {
            return None;
        }
        let is_even = volume >= most.powi(3) * (1.0 - 1e-6);
        if is_even {
            return Some(Stretch { least: most, most });
        }
        // No length grows by more than Frobenius' norm, and what two directions grow by leaves this for the third.
        let most = lengths.iter().map(|l| l * l).sum::<f64>().sqrt();
        Some(Stretch {
            least: volume / (most * most),
            most,
        })
    }

    fn is_even(&self) -> bool {
        self.least == self.most
    }
}

/// The secant of the angle between the view's axis and the farthest corner of the picture.
fn corner(p: &DMat4) -> f64 {
    let reach = |scale: f64, offset: f64| (1.0 + offset.abs()) / scale.abs();
    let (x, y) = (reach(p.x_axis.x, p.z_axis.x), reach(p.y_axis.y, p.z_axis.y));
    (1.0 + x * x + y * y).sqrt()
}

/// Left, right, bottom, top of the picture, and in front of the eye: what lies inside of it has no negative value.
fn planes(to_clip: &DMat4) -> [[f32; 4]; 5] {
    let row = |k: usize| to_clip.row(k);
    let w = row(3);
    [w + row(0), w - row(0), w + row(1), w - row(1), w].map(|plane| {
        let length = plane.truncate().length();
        let plane = if length > 0.0 {
            plane / length
        } else {
            DVec4::W
        };
        // A hair is nothing that a pixel shows, and more than rounding.
        (plane + DVec4::W * 1e-5).as_vec4().to_array()
    })
}
