//! Everything a picture is made of, as flat arrays: what the passes of both processors read.
//!
//! In: an [`AttributeSet`] that holds the reference meshes, geometries (a reference's own or a LoD's), draws of them
//! with their transforms. Out: [`Picture`]. Nothing in it depends on the camera.

use super::beforehand::{SCOPE_AT, TEXTURES_AT, scope_word};
use super::constants::constants;
use super::correspond::{IDENTITY, INVERSE};
use super::deform::Frames;
use super::draw::DrawRecord;
use crate::attribute::{AttributeSet, Prefiltered};
use crate::igt::{Asker, Layout, Tables};
use crate::param::projection::Line;
use crate::{Error, Result};
use glam::{DMat3, DMat4};
use std::sync::Arc;

/// A geometry of a picture: where its arrays lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    vertex_base: u32,
    vertex_count: u32,
    corner_base: u32,
    triangle_count: u32,
    slack: f32,
    handed: f32,
    frames: u32,
}

impl Geometry {
    /// The same, turned inside out by its skin if `handed` is -1.
    pub(crate) fn with_handed(self, handed: f32) -> Self {
        Geometry { handed, ..self }
    }
}

/// Flat arrays of all geometries, draws and attributes.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Object-space positions of all geometries.
    pub(crate) positions: Vec<[f32; 3]>,
    /// T3 of each position on the vertex grid (0 where a geometry has none); the fourth is unused.
    pub(crate) t3: Vec<[i32; 4]>,
    /// Vertices of each triangle, in `positions`; and its [`Asker::word`].
    pub(crate) corners: Vec<[u32; 4]>,
    /// The draws, in order.
    pub(crate) draws: Vec<DrawRecord>,
    /// What can be fetched of the references.
    pub(crate) attributes: AttributeSet,
    /// Inverse geometric textures of the references that have one.
    pub(crate) tables: Vec<Arc<Tables>>,
    /// For each of them what a draw record says of what was filtered beforehand.
    prefiltered: Vec<[u32; 2]>,
    /// See [`super::constants`].
    pub(crate) constants: Vec<f32>,
    triangles: u32,
    vertices: u32,
}

impl Picture {
    /// A picture of nothing yet.
    pub fn new(attributes: AttributeSet) -> Self {
        Picture {
            positions: Vec::new(),
            t3: Vec::new(),
            corners: Vec::new(),
            draws: Vec::new(),
            attributes,
            tables: Vec::new(),
            prefiltered: Vec::new(),
            constants: constants(),
            triangles: 0,
            vertices: 0,
        }
    }

    /// Adds positions and triangles. `t3` and `askers` ([`Asker::word`]) are empty for a geometry that is its own reference; `slack` is how
    /// far a level of detail may lie from its reference, in the unit of positions.
    pub fn add_geometry(
        &mut self,
        positions: &[[f32; 3]],
        triangles: &[[u32; 3]],
        t3: &[[i32; 3]],
        askers: &[u32],
        slack: f32,
    ) -> Result<Geometry> {
        let geometry = Geometry {
            slack,
            handed: 1.0,
            frames: 0,
            vertex_base: within(
                "vertices of a picture",
                self.positions.len() + positions.len(),
                positions.len(),
            )?,
            vertex_count: positions.len() as u32,
            corner_base: within(
                "triangles of a picture",
                self.corners.len() + triangles.len(),
                triangles.len(),
            )?,
            triangle_count: triangles.len() as u32,
        };
        self.positions.extend_from_slice(positions);
        let point = |v: usize| t3.get(v).map_or([0; 4], |p| [p[0], p[1], p[2], 0]);
        self.t3.extend((0..positions.len()).map(point));
        let base = geometry.vertex_base;
        let anyone = Asker::default().word();
        let asker = |t: usize| askers.get(t).copied().unwrap_or(anyone);
        self.corners.extend(
            triangles
                .iter()
                .enumerate()
                .map(|(t, v)| [v[0] + base, v[1] + base, v[2] + base, asker(t)]),
        );
        Ok(geometry)
    }

    /// The same geometry with `frames` that turn the directions of the reference at each of its vertices.
    pub(super) fn with_frames(&mut self, geometry: Geometry, frames: &Frames) -> Result<Geometry> {
        let words = &mut self.attributes.vertices;
        let added = frames.rows.len() * 9;
        let what = "words of vertex attributes and frames";
        let begin = within(what, words.len() + added, added)?;
        words.extend(frames.rows.iter().flatten().map(|x| x.to_bits()));
        Ok(Geometry {
            slack: geometry.slack * frames.stretch,
            frames: begin + 1,
            ..geometry
        })
    }

    /// Adds the tables of a reference, and what was filtered beforehand over its primary; returns their number.
    ///
    /// # Errors
    /// [`Error::Capacity`] where its textures are too much.
    pub fn add_tables(
        &mut self,
        tables: Arc<Tables>,
        prefiltered: Option<&Prefiltered>,
    ) -> Result<u32> {
        let number = self.tables.len();
        let words = match prefiltered {
            None => [0; 2],
            Some(prefiltered) => {
                let goes_round = tables.primary.line() == Line::Cylinder;
                // Images of a scene are counted from 0.
                let key = usize::MAX - 4 * (number + 1);
                let textures = &mut self.attributes.textures;
                let first = textures.add_prefiltered(key, prefiltered, goes_round)?;
                [first + 1, scope_word(prefiltered.scope())]
            }
        };
        self.tables.push(tables);
        self.prefiltered.push(words);
        Ok(number as u32)
    }

    /// What a draw record says of tables `number`: the number, where its hash (in pairs of words), lists and triangles (in
    /// quadruples) begin when all tables lie after each other, and how to read them.
    fn igt_words(&self, number: u32) -> [u32; 15] {
        let before = &self.tables[..number as usize];
        let base = |words: fn(&Tables) -> &[u32], size: usize| {
            before.iter().map(|t| (words(t).len() / size) as u32).sum()
        };
        let tables = &self.tables[number as usize];
        let mut out = [0; 15];
        out[..4].copy_from_slice(&[
            number,
            base(|t| &t.hash, 2),
            base(|t| &t.list, 4),
            base(|t| &t.triangle, 4),
        ]);
        out[4..10].copy_from_slice(&tables.shader_words());
        [out[TEXTURES_AT], out[SCOPE_AT]] = self.prefiltered[number as usize];
        out
    }

    /// Draws a geometry. `attribute_base` is the number of its reference's first triangle in the attributes; `tables`
    /// the number of its inverse geometric texture, none for a geometry whose triangles are the reference's own.
    pub fn draw(
        &mut self,
        geometry: Geometry,
        attribute_base: u32,
        tables: Option<u32>,
        world: DMat4,
    ) -> Result<()> {
        if geometry.triangle_count == 0 {
            return Ok(());
        }
        let mut record = DrawRecord {
            first_triangle: self.triangles,
            triangle_count: geometry.triangle_count,
            corner_base: geometry.corner_base,
            projected_base: self.vertices,
            vertex_base: geometry.vertex_base,
            vertex_count: geometry.vertex_count,
            attribute_base,
            correspondence: if tables.is_some() { INVERSE } else { IDENTITY },
            ..DrawRecord::default()
        };
        (record.world, record.normal) = transforms(world)?;
        record.normal[0][3] *= geometry.handed;
        let stretch = if geometry.frames == 0 {
            largest_stretch(world)
        } else {
            1.0
        };
        record.normal[1][3] = (f64::from(geometry.slack) * stretch) as f32;
        record.frames = geometry.frames;
        record.igt = tables.map_or([0; 15], |number| self.igt_words(number));
        let triangles = self.triangles as usize + geometry.triangle_count as usize;
        self.triangles = within("drawn triangles", triangles, 0)?;
        self.vertices = within(
            "drawn vertices",
            self.vertices as usize + geometry.vertex_count as usize,
            0,
        )?;
        self.draws.push(record);
        Ok(())
    }

    /// Triangles drawn, all instances counted.
    pub fn triangle_count(&self) -> u32 {
        self.triangles
    }

    /// The layout of the tables that draw `draw` looks up in; none for one whose triangles are the reference's own.
    pub fn layout_of(&self, draw: u32) -> Option<Layout> {
        let record = self.draws.get(draw as usize)?;
        let tables = self.tables.get(record.igt[0] as usize)?;
        (record.correspondence == INVERSE).then_some(tables.layout)
    }

    /// How many textures shading reads at triangle `triangle` of the reference of draw `draw`, as
    /// [`Rendered`](super::Rendered) names them.
    pub fn textures_at(&self, draw: u32, triangle: u32) -> u32 {
        let base = self.draws[draw as usize].attribute_base;
        self.attributes.textures_of((base + triangle) as usize)
    }

    /// Loads that the artist's uv takes at triangle `triangle` of the reference of draw `draw`.
    pub fn uv_fetches_at(&self, draw: u32, triangle: u32) -> u32 {
        let base = self.draws[draw as usize].attribute_base;
        self.attributes.uv_fetches(base + triangle)
    }

    /// Bytes of all textures with their mip levels.
    pub fn texture_bytes(&self) -> u64 {
        self.attributes.textures.texels.len() as u64 * 4
    }

    /// Vertices projected, all instances counted.
    #[cfg(feature = "gpu")]
    pub(crate) fn vertex_count(&self) -> u32 {
        self.vertices
    }

    /// Centre and radius of a sphere round everything that is drawn (centre: of the bounding box), world space.
    pub fn bounding_sphere(&self) -> ([f64; 3], f64) {
        let points = || {
            self.draws.iter().flat_map(|d| {
                let first = d.vertex_base as usize;
                let vertices = &self.positions[first..first + d.vertex_count as usize];
                vertices
                    .iter()
                    .map(move |&p| d.world.map(|row| f64::from(super::project::affine(row, p))))
            })
        };
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for p in points() {
            for k in 0..3 {
                (low[k], high[k]) = (low[k].min(p[k]), high[k].max(p[k]));
            }
        }
        if low[0] > high[0] {
            return ([0.0; 3], 1.0);
        }
        let centre = [0, 1, 2].map(|k| (low[k] + high[k]) / 2.0);
        let squared = |p: [f64; 3]| (0..3).map(|k| (p[k] - centre[k]).powi(2)).sum::<f64>();
        (centre, points().map(squared).fold(0.0, f64::max).sqrt())
    }
}

/// `total` as a u32, less `added`; an error where more than 2^26 would not be addressable by 6 vertices a triangle.
fn within(what: &str, total: usize, added: usize) -> Result<u32> {
    const MOST: usize = 1 << 28;
    if total > MOST {
        return Err(Error::Capacity {
            what: what.into(),
            need: total as u64,
            have: MOST as u64,
        });
    }
    Ok((total - added) as u32)
}

/// The most that a transform stretches an axis.
fn largest_stretch(world: DMat4) -> f64 {
    let columns = DMat3::from_mat4(world);
    [columns.x_axis, columns.y_axis, columns.z_axis]
        .iter()
        .map(|c| c.length())
        .fold(0.0, f64::max)
}

/// Rows of object to world, and rows of the transform of normals with the handedness in the first one's fourth.
fn transforms(world: DMat4) -> Result<([[f32; 4]; 3], [[f32; 4]; 3])> {
    if !world.is_finite() {
        return Err(Error::input("scene", "node transform", "is not finite"));
    }
    let linear = DMat3::from_mat4(world);
    let determinant = linear.determinant();
    // The cofactors turn normals right at any determinant, zero included; the sign keeps them outside when mirrored.
    let columns = [linear.x_axis, linear.y_axis, linear.z_axis];
    let sign = if determinant < 0.0 { -1.0 } else { 1.0 };
    let cofactor = [
        columns[1].cross(columns[2]),
        columns[2].cross(columns[0]),
        columns[0].cross(columns[1]),
    ];
    let scale = cofactor
        .iter()
        .map(|c| c.abs().max_element())
        .fold(0.0, f64::max);
    let factor = if scale > 0.0 { sign / scale } else { 0.0 };
    let rows = [0, 1, 2].map(|row| world.row(row).as_vec4().to_array());
    let mut normal = [0, 1, 2].map(|row| {
        let [x, y, z] = [0, 1, 2].map(|column| (cofactor[column][row] * factor) as f32);
        [x, y, z, 0.0]
    });
    normal[0][3] = sign as f32;
    Ok((rows, normal))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{DQuat, DVec3};

    #[test]
    fn normals_stay_perpendicular_and_outside_under_any_affine_map() {
        for scale in [
            DVec3::ONE,
            DVec3::new(2.0, 0.5, 3.0),
            DVec3::new(-1.0, 1.0, 1.0),
        ] {
            let world = DMat4::from_scale_rotation_translation(
                scale,
                DQuat::from_rotation_y(0.7),
                DVec3::X,
            );
            let (rows, normal) = transforms(world).unwrap();
            assert_eq!(normal[0][3], if scale.x < 0.0 { -1.0 } else { 1.0 });
            let turn = |rows: &[[f32; 4]; 3], v: DVec3| {
                DVec3::from_array(
                    [0, 1, 2].map(|i| (0..3).map(|k| f64::from(rows[i][k]) * v[k]).sum()),
                )
            };
            let (n, t) = (DVec3::new(1.0, 2.0, -0.5), DVec3::new(2.0, -1.0, 0.0));
            assert!(turn(&normal, n).dot(turn(&rows, t)).abs() < 1e-5);
            assert!(turn(&normal, n).dot(turn(&rows, n)) > 0.0);
        }
        assert!(transforms(DMat4::from_translation(DVec3::NAN)).is_err());
    }
}
