//! What lies round a point of the reference: how open the sky over it is, how thick the body under it, whether light comes.
//!
//! In: the reference's triangles and the tree over them. Out: [`Around`], asked by any number of cores through [`Looking`].
//! Directions are those of the ambient occlusion at vertices ([`hemisphere`](crate::attribute)), but round each texel's own
//! point and normal; what lies below the triangle's plane counts neither as open nor as hidden, so that facets of a smooth
//! surface do not show.

use super::wanted::BakeAttribute;
use crate::attribute::arithmetic::{V3, add3, cross3, dot3, scale3, sub3, unit3, weighted};
use crate::attribute::hemisphere::{directions, seed, tangents, turned};
use crate::mesh::bvh::{Asking, Bvh, Ray, Sides};
use crate::mesh::{Mesh, mean_curvature};
use crate::{Error, Result};

/// How far from the surface rays begin, in diagonals.
const LIFT: f32 = 1e-4;

/// How attributes are found that depend on what lies round a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AroundOptions {
    /// Rays of each sample for bent normals and thickness, 1 to 4096.
    pub rays: u32,
    /// How far they reach, in diagonals of the reference's box.
    pub reach: f32,
    /// The radius of the ball whose curvature is 1 in codes, in diagonals of the reference's box.
    pub curvature_radius: f32,
    /// The direction towards the light of shading and shadows.
    pub light: [f32; 3],
}

impl Default for AroundOptions {
    /// The light comes from over the left shoulder of one who looks along -z, as in pictures.
    fn default() -> Self {
        AroundOptions {
            rays: 64,
            reach: 0.5,
            curvature_radius: 0.02,
            light: [-0.4, 0.55, 0.75],
        }
    }
}

impl AroundOptions {
    /// Refuses what is out of range.
    pub(super) fn check(&self) -> Result<()> {
        let wrong = |option, reason: String| Err(Error::Option { option, reason });
        if !(1..=4096).contains(&self.rays) {
            return wrong("--rays", format!("{} is outside 1 to 4096", self.rays));
        }
        for (option, length) in [
            ("--ray-reach", self.reach),
            ("--curvature-radius", self.curvature_radius),
        ] {
            if !(length > 0.0 && length.is_finite()) {
                let reason = format!("{length} is not a positive number of diagonals");
                return wrong(option, reason);
            }
        }
        let [x, y, z] = self.light.map(f64::from);
        let squared = x * x + y * y + z * z;
        if !(squared > 1e-20 && squared < 1e20) {
            return wrong("--light", "needs a direction such as 0,1,0.5".into());
        }
        Ok(())
    }

    /// The unit direction towards the light.
    pub(super) fn towards_light(&self) -> V3 {
        unit3(self.light, [0.0, 1.0, 0.0])
    }
}

/// The surroundings of a reference.
pub(super) struct Around<'a> {
    tree: &'a Bvh,
    /// Normals at the corners of each triangle, where rays are wanted.
    normals: Vec<[V3; 3]>,
    /// Mean curvature there, where it is wanted.
    curvature: Vec<[f32; 3]>,
    options: AroundOptions,
}

/// One core's way of asking.
pub(super) struct Looking<'a> {
    of: &'a Around<'a>,
    asking: Asking<'a>,
}

impl<'a> Around<'a> {
    /// Of the triangles of `meshes` in one run, those of `tree`; only what `wanted` asks for is made.
    pub(super) fn new<'m>(
        tree: &'a Bvh,
        meshes: impl Iterator<Item = &'m Mesh> + Clone,
        wanted: &[BakeAttribute],
        options: &AroundOptions,
    ) -> Around<'a> {
        let (mut normals, mut curvature) = (Vec::new(), Vec::new());
        if wanted.iter().any(BakeAttribute::casts) {
            for mesh in meshes.clone() {
                let at = |t: &[u32; 3]| t.map(|v| mesh.normals[v as usize]);
                normals.extend(mesh.triangles.iter().map(at));
            }
        }
        if wanted.contains(&BakeAttribute::Curvature) {
            for mesh in meshes {
                let bent = mean_curvature(&mesh.positions, &mesh.triangles);
                let at = |t: &[u32; 3]| t.map(|v| bent[v as usize]);
                curvature.extend(mesh.triangles.iter().map(at));
            }
        }
        Around {
            tree,
            normals,
            curvature,
            options: *options,
        }
    }

    pub(super) fn looking(&'a self) -> Looking<'a> {
        Looking {
            of: self,
            asking: self.tree.asking(),
        }
    }

    /// How far rays reach.
    pub(super) fn reach(&self) -> f32 {
        self.options.reach * self.tree.diagonal()
    }

    /// The curvature that is 1 in codes.
    pub(super) fn bent(&self) -> f32 {
        1.0 / (self.options.curvature_radius * self.tree.diagonal()).max(f32::MIN_POSITIVE)
    }
}

/// A point of the reference and what is up there.
struct Place {
    at: V3,
    /// Of the triangle.
    face: V3,
    /// Interpolated; the triangle's where it looks to the other side.
    normal: V3,
}

impl Looking<'_> {
    fn place(&self, corners: &[V3; 3], triangle: u32, b: [f32; 3]) -> Place {
        let [p, q, r] = *corners;
        let face = unit3(cross3(sub3(q, p), sub3(r, p)), [0.0, 0.0, 1.0]);
        let normal = weighted(&self.of.normals[triangle as usize], b);
        let normal = unit3(normal, face);
        Place {
            at: weighted(corners, b),
            face,
            normal: if dot3(normal, face) > 0.0 {
                normal
            } else {
                face
            },
        }
    }

    /// The beginning of rays on this side of the surface.
    fn begin(&self, place: &Place, side: f32) -> V3 {
        let lift = side * LIFT * self.of.tree.diagonal();
        add3(place.at, scale3(place.face, lift))
    }

    /// The mean unit direction of open sky at barycentrics `b` of a triangle with these corners; the normal where none is.
    pub(super) fn bent_normal(&mut self, corners: &[V3; 3], triangle: u32, b: [f32; 3]) -> V3 {
        let place = self.place(corners, triangle, b);
        let (begin, frame) = (self.begin(&place, 1.0), tangents(place.normal));
        let mut sum = [0.0; 3];
        for direction in directions(seed(place.at), self.of.options.rays) {
            let way = turned(direction, frame, place.normal);
            let ray = Ray {
                begin,
                way,
                reach: self.of.reach(),
                sides: Sides::Both,
            };
            if dot3(way, place.face) > 0.0 && !self.asking.meets(ray) {
                sum = add3(sum, way);
            }
        }
        unit3(sum, place.normal)
    }

    /// The mean way through the body there, as far as rays reach.
    pub(super) fn thickness(&mut self, corners: &[V3; 3], triangle: u32, b: [f32; 3]) -> f32 {
        let place = self.place(corners, triangle, b);
        let inwards = scale3(place.normal, -1.0);
        let (begin, frame) = (self.begin(&place, -1.0), tangents(inwards));
        let reach = self.of.reach();
        let (mut sum, mut count) = (0.0f32, 0u32);
        for direction in directions(seed(place.at), self.of.options.rays) {
            let way = turned(direction, frame, inwards);
            if dot3(way, place.face) >= 0.0 {
                continue;
            }
            // What leaves the body meets a triangle from behind.
            let leaves = self.asking.first(Ray {
                begin,
                way,
                reach,
                sides: Sides::Back,
            });
            sum += leaves.map_or(reach, |found| found.distance);
            count += 1;
        }
        if count == 0 {
            reach
        } else {
            sum / count as f32
        }
    }

    /// 1 where the light comes, 0 where it does not.
    pub(super) fn lit(&mut self, corners: &[V3; 3], triangle: u32, b: [f32; 3]) -> f32 {
        let place = self.place(corners, triangle, b);
        let way = self.of.options.towards_light();
        if dot3(way, place.face) <= 0.0 || dot3(way, place.normal) <= 0.0 {
            return 0.0;
        }
        let ray = Ray {
            begin: self.begin(&place, 1.0),
            way,
            reach: 2.0 * self.of.tree.diagonal(),
            sides: Sides::Both,
        };
        f32::from(u8::from(!self.asking.meets(ray)))
    }

    /// The mean curvature there.
    pub(super) fn curvature(&self, triangle: u32, b: [f32; 3]) -> f32 {
        let corners = &self.of.curvature[triangle as usize];
        (0..3).map(|k| corners[k] * b[k]).sum()
    }
}
