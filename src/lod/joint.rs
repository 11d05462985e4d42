//! All meshes of a model as one, welded as their primaries allow.
//!
//! In: the meshes. Out: [`Joint`]: vertices in world space, each of one mesh and one part, with the uv of its chart scaled
//! to the weight it has beside position, and where poses move it.

use super::LodInput;
use super::motion::{Motion, Shape};
use crate::param::PrimaryKind;
use crate::param::fit_surface::weld;
use crate::param::weld::by_place;
use glam::{DMat4, DVec3, Mat4};

/// What a difference of 1 in T3 weighs beside a distance of the model's extent. Small: it keeps uv from shearing, the
/// chart borders are kept by topology. (The best of the weights measured for plain textured LoDs.)
const CHART_WEIGHT: f32 = 0.1;
/// The same where a map without seams is computed. No border holds its places together, and creases of the surface lie close
/// to each other in T3: LoD triangles that cut across would show torn texture there. (Of 0.1, 0.3, 1 and 3 the least that was
/// seen to tear next to nothing, on spot; the root of the mean squared distance grows by a tenth.)
const MAP_WEIGHT: f32 = 1.0;

/// Numbers of T3 per vertex: of charts, and where a map without seams is computed.
const FLAT: usize = 2;
const SPATIAL: usize = 3;

/// One vertex of the joint mesh.
#[derive(Clone, Copy, Debug)]
pub(super) struct Origin {
    /// The mesh it belongs to.
    pub(super) mesh: u32,
    /// The mesh's vertex it stands for (the first of those welded).
    pub(super) vertex: u32,
    /// The part it belongs to.
    pub(super) part: u32,
    /// That part's layer.
    pub(super) layer: u8,
}

/// The joint mesh.
pub(super) struct Joint {
    /// World positions.
    pub(super) positions: Vec<[f32; 3]>,
    /// `stride` numbers per vertex: places in T3 times weight where they are no function of position, else zero; then those
    /// of its motion.
    pub(super) attributes: Vec<f32>,
    /// Numbers per vertex in `attributes`.
    pub(super) stride: usize,
    /// How many of them are of T3: the first two or three coordinates.
    pub(super) t3: usize,
    /// Where each vertex comes from.
    pub(super) origins: Vec<Origin>,
    /// Three per triangle; none degenerate.
    pub(super) indices: Vec<u32>,
    /// Triangles of all references, degenerate ones included: what fractions are fractions of.
    pub(super) reference_triangles: usize,
    /// Per mesh, object to world.
    pub(super) worlds: Vec<DMat4>,
    /// Per mesh, what its places in T3 weigh.
    weights: Vec<f32>,
    /// Whether any vertex has attributes that count.
    pub(super) has_attributes: bool,
}

impl Joint {
    /// Joins and welds `meshes`.
    pub(super) fn new(meshes: &[LodInput<'_>], shapes: &[Vec<Shape>]) -> Self {
        let worlds: Vec<DMat4> = meshes.iter().map(world).collect();
        let motion = Motion::new(meshes, shapes, &worlds);
        let carried = meshes.iter().any(|input| carried(input.primary.kind));
        let spatial = |input: &LodInput| matches!(input.primary.kind, PrimaryKind::Computed(map) if !map.has_charts());
        let weight = |input| match spatial(input) {
            true => MAP_WEIGHT,
            false => CHART_WEIGHT,
        };
        let t3 = if meshes.iter().any(spatial) {
            SPATIAL
        } else {
            FLAT
        };
        let mut joint = Joint {
            positions: vec![],
            attributes: vec![],
            stride: t3 + motion.numbers(),
            t3,
            origins: vec![],
            indices: vec![],
            reference_triangles: meshes.iter().map(|input| input.mesh.triangles.len()).sum(),
            worlds,
            weights: meshes.iter().map(weight).collect(),
            has_attributes: carried || motion.numbers() > 0,
        };
        for (m, input) in meshes.iter().enumerate() {
            joint.append(m, input, &motion);
        }
        joint
    }

    fn append(&mut self, m: usize, input: &LodInput<'_>, motion: &Motion) {
        let mesh = input.mesh;
        let weld = weld(mesh, input.primary.kind);
        // Both sides of a seam must lie at one place to the bit, or the simplifier would take it for two borders.
        let place = by_place(&mesh.positions, &mesh.triangles);
        let mut joined = vec![u32::MAX; mesh.positions.len()];
        for (t, triangle) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = triangle.map(|v| weld.of[v as usize]);
            if a == b || b == c || c == a {
                continue;
            }
            for v in [a, b, c] {
                if joined[v as usize] == u32::MAX {
                    joined[v as usize] = self.positions.len() as u32;
                    let (part, layer) =
                        (input.parts.triangle_part[t], input.parts.triangle_layer[t]);
                    let origin = Origin {
                        mesh: m as u32,
                        vertex: v,
                        part,
                        layer,
                    };
                    self.push(input, origin, place.of[v as usize]);
                    self.attributes.extend(motion.of(m, v as usize));
                }
                self.indices.push(joined[v as usize]);
            }
        }
    }

    /// Appends a vertex that lies where the mesh's vertex `place` does.
    fn push(&mut self, input: &LodInput<'_>, origin: Origin, place: u32) {
        let p = input.mesh.positions[place as usize];
        let world = self.worlds[origin.mesh as usize];
        self.positions.push(
            world
                .transform_point3(DVec3::from(p.map(f64::from)))
                .as_vec3()
                .to_array(),
        );
        let t3 = match carried(input.primary.kind) {
            true => input.primary.t3_of(input.mesh, origin.vertex as usize),
            false => [0.0; 3],
        };
        let weight = self.weights[origin.mesh as usize];
        self.attributes
            .extend(t3.iter().take(self.t3).map(|&x| x as f32 * weight));
        self.origins.push(origin);
    }
}

/// Whether T3 is an attribute of vertices, not a function of their positions.
pub(super) fn carried(kind: PrimaryKind) -> bool {
    kind.has_charts() || matches!(kind, PrimaryKind::Computed(_))
}

/// A vertex's place in T3 from `attributes`, which are those of `joint` or what the simplifier made of them.
pub(super) fn t3_of(joint: &Joint, attributes: &[f32], vertex: usize) -> [f64; 3] {
    let first = vertex * joint.stride;
    let weight = f64::from(joint.weights[joint.origins[vertex].mesh as usize]);
    let number = |k: usize| match k < joint.t3 {
        true => f64::from(attributes[first + k]) / weight,
        false => 0.0,
    };
    [0, 1, 2].map(number)
}

/// Object to world in f64; identity where it cannot be undone or throws points out of the range of f32.
pub(super) fn world(input: &LodInput<'_>) -> DMat4 {
    let world = Mat4::from_cols_array_2d(&input.world).as_dmat4();
    let determinant = world.determinant();
    let affine = world.row(3) == glam::DVec4::W;
    let usable =
        affine && world.is_finite() && determinant.is_normal() && world.inverse().is_finite();
    let in_range = |p: &[f32; 3]| {
        world
            .transform_point3(DVec3::from(p.map(f64::from)))
            .as_vec3()
            .is_finite()
    };
    if usable && input.mesh.positions.iter().all(in_range) {
        world
    } else {
        DMat4::IDENTITY
    }
}
