//! Ambient occlusion at the vertices of a model: how much of the sky each one sees.
//!
//! In: a scene at rest, all instances as they stand. Out: for each mesh one number for each vertex, 1 in the open, 0 where
//! everything near hides the sky: the share of cosine-weighted rays that leave the vertex and meet nothing within reach.
//!
//! The same numbers on every machine: rays come from a fixed sequence, turned by the vertex's position alone, and all
//! arithmetic is `+ - * /` and square roots. Vertices in one place with one normal get one number, so seams do not show.

use super::arithmetic::{V3, add3, scale3};
use super::hemisphere::{directions, seed, tangents, turned};
use crate::mesh::bvh::{Asking, Bvh, Ray, Sides};
use crate::scene::{Deformation, Scene};
use crate::{Error, Result};
use rayon::prelude::*;

/// How rays are cast.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OcclusionOptions {
    /// Rays of each vertex, 1 to 4096.
    pub samples: u32,
    /// How far they reach, in diagonals of the model's bounding box.
    pub reach: f32,
}

impl Default for OcclusionOptions {
    fn default() -> Self {
        OcclusionOptions {
            samples: 128,
            reach: 0.5,
        }
    }
}

/// How far from its vertex a ray begins, in diagonals.
const LIFT: f32 = 1e-4;
/// Vertices between two words about progress.
const BATCH: usize = 8192;

/// One number for each vertex of each mesh. A mesh that stands in several places is taken where it stands first; one that
/// stands nowhere is in the open.
///
/// # Errors
/// [`Error::Option`] for options out of range; [`Error::Input`] where a transform leaves the range of floats.
pub(super) fn cast(
    scene: &Scene,
    options: &OcclusionOptions,
    progress: &dyn Fn(usize, usize),
) -> Result<Vec<Vec<f32>>> {
    if !(1..=4096).contains(&options.samples) {
        let reason = format!("{} is outside 1 to 4096", options.samples);
        return Err(Error::Option {
            option: "--occlusion-samples",
            reason,
        });
    }
    if !(options.reach > 0.0 && options.reach.is_finite()) {
        let reason = format!("{} is not a positive number of diagonals", options.reach);
        return Err(Error::Option {
            option: "--occlusion-reach",
            reason,
        });
    }
    let standing = standing(scene)?;
    let triangles: Vec<[V3; 3]> = standing
        .iter()
        .flat_map(|s| s.triangles.iter().copied())
        .collect();
    let rays = Bvh::new(&triangles);
    let diagonal = rays.diagonal();
    let mut out: Vec<Vec<f32>> = scene
        .meshes
        .iter()
        .map(|m| vec![1.0; m.positions.len()])
        .collect();
    let mut taken = vec![false; scene.meshes.len()];
    let of: usize = scene.meshes.iter().map(|m| m.positions.len()).sum();
    let mut done = 0;
    for s in &standing {
        if std::mem::replace(&mut taken[s.mesh], true) {
            continue;
        }
        for (numbers, vertices) in out[s.mesh].chunks_mut(BATCH).zip(s.vertices.chunks(BATCH)) {
            progress(done, of);
            let asking = || rays.asking();
            let seen = |rays: &mut Asking, (number, vertex): (&mut f32, &(V3, V3))| {
                *number = open(rays, *vertex, diagonal, options)
            };
            numbers
                .par_iter_mut()
                .zip(vertices)
                .for_each_init(asking, seen);
            done += numbers.len();
        }
    }
    progress(of, of);
    Ok(out)
}

/// A mesh as it stands in the world.
struct Standing {
    mesh: usize,
    triangles: Vec<[V3; 3]>,
    /// Position and unit normal.
    vertices: Vec<(V3, V3)>,
}

fn standing(scene: &Scene) -> Result<Vec<Standing>> {
    let pose = scene.rest();
    let mut out = Vec::new();
    for instance in scene.instances_in(&pose) {
        let mesh = &scene.meshes[instance.mesh];
        let deformation = Deformation::of(scene, &instance, &pose);
        let posed = deformation.as_ref().map(|d| d.mesh(mesh)).transpose()?;
        let world = deformation
            .as_ref()
            .map_or(instance.world, Deformation::world);
        let mesh = posed.as_ref().unwrap_or(mesh);
        let upright = glam::DMat3::from_mat4(world).inverse().transpose();
        let position =
            |p: &[f32; 3]| world.transform_point3(glam::DVec3::from_array(p.map(f64::from)));
        let normal = |n: &[f32; 3]| {
            let turned = upright * glam::DVec3::from_array(n.map(f64::from));
            turned.normalize_or(glam::DVec3::Y).as_vec3().to_array()
        };
        let positions: Vec<V3> = mesh
            .positions
            .iter()
            .map(|p| position(p).as_vec3().to_array())
            .collect();
        if positions.iter().flatten().any(|c| !c.is_finite()) {
            let element = format!("mesh \"{}\"", mesh.name);
            return Err(Error::input(
                &scene.name,
                element,
                "does not stand in the range of floats",
            ));
        }
        out.push(Standing {
            mesh: instance.mesh,
            triangles: mesh
                .triangles
                .iter()
                .map(|t| t.map(|v| positions[v as usize]))
                .collect(),
            vertices: positions
                .iter()
                .copied()
                .zip(mesh.normals.iter().map(normal))
                .collect(),
        });
    }
    Ok(out)
}

/// The share of rays from a vertex that meet nothing.
fn open(
    rays: &mut Asking,
    (position, normal): (V3, V3),
    diagonal: f32,
    options: &OcclusionOptions,
) -> f32 {
    let begin = add3(position, scale3(normal, LIFT * diagonal));
    let frame = tangents(normal);
    let mut free = 0u32;
    for direction in directions(seed(position), options.samples) {
        let ray = Ray {
            begin,
            way: turned(direction, frame, normal),
            reach: options.reach * diagonal,
            sides: Sides::Both,
        };
        free += u32::from(!rays.meets(ray));
    }
    free as f32 / options.samples as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_under_a_square_sees_what_is_left_of_the_sky() {
        // A square of half side s at height h hides s^2 / (s^2 + h^2) * .. of the sky: its form factor from a point below.
        let (s, h) = (1.0f32, 1.0f32);
        let corner = |x: f32, y: f32| [x * s, y * s, h];
        let [a, b, c, d] = [
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ];
        let tree = Bvh::new(&[[a, b, c], [a, c, d]]);
        let rays = &mut tree.asking();
        let options = OcclusionOptions {
            samples: 4096,
            reach: 10.0,
        };
        let open = open(
            rays,
            ([0.0; 3], [0.0, 0.0, 1.0]),
            1e-3,
            &OcclusionOptions {
                reach: 1e5,
                ..options
            },
        );
        // Four quarter squares: (2 / pi) * (s / sqrt(s^2 + h^2)) * atan(s / sqrt(s^2 + h^2)), twice for x and y.
        let ratio = f64::from(s / (s * s + h * h).sqrt());
        let hidden = 4.0 / std::f64::consts::PI * ratio * ratio.atan();
        assert!(
            (f64::from(1.0 - open) - hidden).abs() < 0.01,
            "{open} {hidden}"
        );
        let near = OcclusionOptions {
            samples: 64,
            reach: 0.5,
        };
        assert_eq!(
            super::open(rays, ([0.0; 3], [0.0, 0.0, 1.0]), 1.0, &near),
            1.0,
            "out of reach"
        );
    }
}
