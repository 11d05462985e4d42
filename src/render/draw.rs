//! What is drawn: the record of one draw and the projected vertex, as the shaders see them (`glsl/render/draw.glsl`).
//!
//! All triangles of a picture are numbered in one run, draw after draw, and so are the projected vertices; a draw is
//! found by bisection of that run. One indirect-free draw call then covers a whole scene.

use super::camera::Camera;

/// One instance of a mesh: its transforms and where its arrays begin. 192 bytes, std430.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct DrawRecord {
    /// Rows of object to world space.
    pub world: [[f32; 4]; 3],
    /// Rows of the transform of normals (inverse transpose); the fourth of the first row is the handedness of `world`,
    /// of the second one the slack: how far the drawn surface may lie from the reference, in world units.
    pub normal: [[f32; 4]; 3],
    /// Number of this draw's first triangle in the picture.
    pub first_triangle: u32,
    /// Triangles of this draw.
    pub triangle_count: u32,
    /// Where the mesh's triangles begin in `corners`.
    pub corner_base: u32,
    /// Number of this draw's first projected vertex.
    pub projected_base: u32,
    /// The mesh's first vertex in `positions` and `t3`.
    pub vertex_base: u32,
    /// Vertices of the mesh.
    pub vertex_count: u32,
    /// Where the attribute triangles of its reference begin.
    pub attribute_base: u32,
    /// 0: a triangle is its own reference; 1: the inverse geometric texture says which.
    pub correspondence: u32,
    /// The tables of the inverse geometric texture (`igt_tables`).
    pub igt: [u32; 15],
    /// Where in the words of the vertices' attributes the frames of a deformed geometry begin, and one more: 9 words for
    /// each vertex (see [`super::deform`]). 0: nothing deforms it.
    pub frames: u32,
}

/// A projected vertex. 32 bytes.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
pub(crate) struct Projected {
    /// Pixel position in sixteenths, where `ordinary`.
    pub x: i32,
    /// Likewise.
    pub y: i32,
    /// Clip-space depth, times w.
    pub z: f32,
    /// Clip-space w.
    pub w: f32,
    /// Pixel position times w.
    pub hx: f32,
    /// Likewise.
    pub hy: f32,
    /// 1 / w, where `ordinary`.
    pub inverse_w: f32,
    /// 1 for a vertex before the eye whose pixel position is of bounded size; 0 for any other.
    pub ordinary: u32,
}

/// What the passes need to know of a camera and the light: the push constants.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct ViewConstants {
    /// World to homogeneous pixels.
    pub rows: [[f32; 4]; 4],
    /// The eye, or (fourth 0) the direction towards it.
    pub eye: [f32; 4],
    /// Unit direction towards the light times its intensity, and the ambient light.
    pub light: [f32; 4],
    /// Pixels across.
    pub width: u32,
    /// Pixels down.
    pub height: u32,
    /// What is written: see [`super::shade`].
    pub flags: u32,
    /// What a step of one world unit away from the eye adds to clip-space depth and w.
    pub away: [f32; 2],
    /// Seconds, for what varies with time.
    pub time: f32,
}

/// The light of lit shading.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Light {
    /// Direction towards the light in world space; none: from over the camera's left shoulder.
    pub direction: Option<[f32; 3]>,
    /// A white diffuse surface facing the light gets this much, linear.
    pub intensity: f32,
    /// Constant light from all around.
    pub ambient: f32,
}

impl Default for Light {
    fn default() -> Self {
        Light {
            direction: None,
            intensity: 1.0,
            ambient: 0.3,
        }
    }
}

impl ViewConstants {
    /// The view of `height` rows of `camera`'s picture from row `top` on.
    pub(crate) fn band(self, camera: &Camera, top: u32, height: u32) -> Self {
        ViewConstants {
            rows: camera.pixel_rows_from(top),
            height,
            ..self
        }
    }

    /// How a pixel gathers the reference.
    pub(crate) fn filter(&self) -> super::filter::Filter {
        super::filter::Filter::from_code(self.flags >> super::shade::FILTER_SHIFT & 3)
    }

    /// The bound of the shader LoD in steps of 8 bits; 0: it is off.
    pub(crate) fn shader_lod(&self) -> f32 {
        (self.flags >> super::shade::SHADER_LOD_SHIFT) as i32 as f32 * 0.25
    }

    pub(crate) fn new(camera: &Camera, light: &Light, flags: u32, time: f32) -> Self {
        let over_shoulder = || camera.world_direction([-0.4, 0.55, 0.75]);
        let toward = light.direction.map_or_else(over_shoulder, |d| {
            glam::DVec3::from_array(d.map(f64::from))
                .normalize_or(glam::DVec3::Y)
                .as_vec3()
                .to_array()
        });
        let [x, y, z] = toward.map(|c| c * light.intensity);
        let rows = camera.pixel_rows();
        ViewConstants {
            away: away(&rows),
            rows,
            eye: camera.eye(),
            light: [x, y, z, light.ambient],
            width: camera.width,
            height: camera.height,
            flags,
            time,
        }
    }
}

/// Depth's and w's growth along the direction of sight: that of w in perspective, of depth where w is constant.
fn away([_, _, z, w]: &[[f32; 4]; 4]) -> [f32; 2] {
    let [z, w] = [z, w].map(|row| glam::DVec3::new(row[0].into(), row[1].into(), row[2].into()));
    let sight = if w.length() > 0.0 { w } else { z }.normalize_or_zero();
    [z.dot(sight) as f32, w.dot(sight) as f32]
}

impl DrawRecord {
    /// How far the triangle that is seen with `sense` steps back in world units before depths are compared: by the
    /// slack where its back is seen (counter-clockwise is the front, pixels have y down, mirroring turns it again).
    ///
    /// A thin wall of a level of detail may have both its faces in one place, or even crossed. The reference shows its
    /// outside there, and so must the level: within the slack a front always wins over a back.
    pub(crate) fn step_back(&self, sense: i32) -> f32 {
        if sense as f32 * self.normal[0][3] > 0.0 {
            self.normal[1][3]
        } else {
            0.0
        }
    }
}

/// The draw that triangle `triangle` of the picture belongs to.
pub(crate) fn draw_of_triangle(draws: &[DrawRecord], triangle: u32) -> usize {
    draws.partition_point(|d| d.first_triangle <= triangle) - 1
}
