//! What is fetched for a texel.
//!
//! In: a scene, an attribute. Out: [`Source`]: its value at any point of the reference, and how values are coded.

use super::around::{Around, AroundOptions, Looking};
use super::coding::{Coding, numbered};
use super::low::{Corners, ROWS, UPRIGHT};
use super::standing::Standing;
use super::wanted::BakeAttribute;
use crate::asset::Progress;
use crate::attribute::arithmetic::{V3, dot3, sub3, unit3, weighted};
use crate::attribute::surface::{Frame, SurfacePoint};
use crate::attribute::{AttributeSet, Shown, ShownOptions, attributes_showing};
use crate::mesh::Mesh;
use crate::scene::Scene;
use crate::{Error, Result};

/// The height that codes reach where nothing else is said, in longest sides of the model.
const STEEP: f32 = 0.05;

/// An attribute made ready to be fetched.
pub(super) struct Source {
    pub(super) attribute: BakeAttribute,
    set: AttributeSet,
    /// First triangle of the mesh at hand.
    base: u32,
    /// How its values are coded.
    pub(super) coding: Coding,
    /// The unit direction towards the light.
    light: V3,
}

/// Where a sample lies on the surface that is baked for.
pub(super) struct Low<'a> {
    pub(super) corners: &'a Corners,
    pub(super) b: V3,
}

impl Low<'_> {
    /// How far `there` lies over the surface, along its normal.
    fn height(&self, there: V3) -> f32 {
        let normal = weighted(&self.corners.normals, self.b);
        let normal = unit3(normal, [0.0, 0.0, 1.0]);
        dot3(
            sub3(there, weighted(&self.corners.positions, self.b)),
            normal,
        )
    }
}

impl Source {
    /// Codes reach this height from now on, and what these surroundings say.
    pub(super) fn reach(&mut self, height: Option<f32>, around: &Around) {
        match self.attribute {
            BakeAttribute::Height => {
                self.coding = height.map_or(self.coding, Coding::Signed);
            }
            BakeAttribute::Curvature => self.coding = Coding::Signed(around.bent()),
            BakeAttribute::Thickness => self.coding = Coding::Length(around.reach()),
            _ => {}
        }
    }

    /// What a texel without a value gets where `mean` is the mean of the others.
    pub(super) fn absent(&self, mean: [f32; 4]) -> [f32; 4] {
        match self.attribute {
            BakeAttribute::Mapping => [-1.0, 0.0, 0.0, 0.0],
            _ => mean,
        }
    }

    /// Makes all attributes ready; also what was replaced on the way.
    pub(super) fn all(
        scene: &Scene,
        attributes: &[BakeAttribute],
        (options, around): (&ShownOptions, &AroundOptions),
        progress: &dyn Progress,
    ) -> Result<(Vec<Source>, Vec<String>)> {
        around.check()?;
        if attributes.is_empty() {
            let reason = "none is named".into();
            return Err(Error::Option {
                option: "--attributes",
                reason,
            });
        }
        let (mut sources, mut warnings) = (Vec::new(), Vec::new());
        for attribute in attributes {
            let name = attribute.to_string();
            let heard = |done: usize, of: usize| progress.at("attribute", &name, done, of);
            let (mut source, told) = Source::new(scene, attribute, options, &heard)?;
            source.light = around.towards_light();
            sources.push(source);
            warnings.extend(told);
            if progress.cancelled() {
                return Err(Error::Cancelled);
            }
        }
        warnings.sort();
        warnings.dedup();
        Ok((sources, warnings))
    }

    /// Makes `attribute` ready; also what was replaced on the way.
    fn new(
        scene: &Scene,
        attribute: &BakeAttribute,
        options: &ShownOptions,
        progress: &dyn Fn(usize, usize),
    ) -> Result<(Source, Vec<String>)> {
        let shown = match attribute {
            BakeAttribute::Shown(shown) => shown.clone(),
            _ => "normal".parse()?,
        };
        let shown = Shown::new(scene, &shown, options, progress)?;
        let (set, warnings) = attributes_showing(scene, false, &shown)?;
        let bounds = bounds(scene);
        let source = Source {
            attribute: attribute.clone(),
            set,
            base: 0,
            coding: Coding::of(attribute, bounds, bounds.1 * STEEP),
            light: [0.0, 1.0, 0.0],
        };
        Ok((source, warnings))
    }

    /// From now on points are those of mesh `number`.
    pub(super) fn take(&mut self, mesh: &Mesh, number: usize) -> Result<()> {
        self.base = self.set.push_mesh_of_scene(mesh, number)?;
        Ok(())
    }

    /// From now on points are those of these meshes, in one run.
    pub(super) fn take_all(&mut self, meshes: &[Standing]) -> Result<()> {
        for (k, standing) in meshes.iter().enumerate() {
            let first = self
                .set
                .push_mesh_of_scene(&standing.mesh, standing.number)?;
            if k == 0 {
                self.base = first;
            }
        }
        Ok(())
    }

    /// Whether it matters where in space a point lies.
    pub(super) fn asks_for_places(&self) -> bool {
        let places = [BakeAttribute::Position, BakeAttribute::Height];
        places.contains(&self.attribute) || self.attribute.casts()
    }

    /// Whether textures are sampled.
    pub(super) fn has_textures(&self) -> bool {
        !self.set.textures.texels.is_empty()
    }

    /// The value at a point whose triangle, with these corners, counts from the first one taken; directions and positions
    /// as they are.
    pub(super) fn at(
        &self,
        decode: &[f32],
        corners: &[V3; 3],
        point: &SurfacePoint,
        low: Option<&Low>,
        around: &mut Looking,
    ) -> [f32; 4] {
        let grey = |c: f32| [c, c, c, 1.0];
        let (triangle, b) = (point.triangle, point.b);
        match self.attribute {
            BakeAttribute::Position => {
                let [x, y, z] = weighted(corners, b);
                return [x, y, z, 1.0];
            }
            BakeAttribute::Height => {
                return grey(low.map_or(0.0, |low| low.height(weighted(corners, b))));
            }
            BakeAttribute::Mapping => return numbered(triangle, b),
            BakeAttribute::Curvature => return grey(around.curvature(triangle, b)),
            BakeAttribute::Thickness => return grey(around.thickness(corners, triangle, b)),
            BakeAttribute::Shadow => return grey(around.lit(corners, triangle, b)),
            BakeAttribute::BentNormal | BakeAttribute::ObjectBentNormal => {
                let [x, y, z] = self.framed(around.bent_normal(corners, triangle, b), low);
                return [x, y, z, 1.0];
            }
            _ => {}
        }
        let here = SurfacePoint {
            triangle: triangle + self.base,
            ..*point
        };
        let frame = Frame {
            world: &ROWS,
            normal: &UPRIGHT,
        };
        let normal = || self.set.shading_normal(decode, &here, &frame);
        match &self.attribute {
            BakeAttribute::Normal | BakeAttribute::ObjectNormal => {
                let [x, y, z] = self.framed(normal(), low);
                [x, y, z, 1.0]
            }
            BakeAttribute::Shading => grey(dot3(normal(), self.light).max(0.0)),
            _ => {
                let mut surface = self.set.surface(decode, &here, &frame);
                self.set.show(decode, &mut surface, &here, triangle, 0.0);
                let [r, g, b, a] = surface.base;
                [r, g, b, if self.attribute.is_color() { a } else { 1.0 }]
            }
        }
    }

    /// A direction in the frame that the attribute is told in.
    fn framed(&self, direction: V3, low: Option<&Low>) -> V3 {
        match low.filter(|_| self.attribute.is_tangent()) {
            Some(low) => low.corners.in_frame(low.b, direction),
            None => direction,
        }
    }

    /// A mean of values as a value.
    pub(super) fn mean(&self, sum: [f32; 4], count: f32) -> [f32; 4] {
        let [x, y, z, w] = sum.map(|s| s / count);
        if self.attribute.is_direction() {
            let [x, y, z] = unit3([x, y, z], [0.0, 0.0, 1.0]);
            return [x, y, z, w];
        }
        [x, y, z, w]
    }
}

/// Low corner and longest side of the box round all meshes.
fn bounds(scene: &Scene) -> (V3, f32) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for (a, b) in scene.meshes.iter().filter_map(Mesh::bounds) {
        for k in 0..3 {
            (low[k], high[k]) = (low[k].min(a[k]), high[k].max(b[k]));
        }
    }
    let longest = (0..3)
        .map(|k| high[k] - low[k])
        .fold(f32::MIN_POSITIVE, f32::max);
    (low, longest)
}
