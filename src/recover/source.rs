//! What is fetched for a texel.
//!
//! In: a scene, an attribute by name. Out: [`Source`]: its value at any point of the reference, and how the value is coded
//! into 8 bits.

use super::low::{ROWS, UPRIGHT, into_frame};
use super::standing::Standing;
use crate::asset::Progress;
use crate::attribute::arithmetic::{V3, dot3, sub3, unit3, weighted};
use crate::attribute::surface::{Frame, SurfacePoint};
use crate::attribute::{Attribute, AttributeSet, Factor, Shown, ShownOptions, attributes_showing};
use crate::mesh::Mesh;
use crate::scene::Scene;
use crate::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// What is resampled into a texture.
#[derive(Clone, Debug, PartialEq)]
pub enum BakeAttribute {
    /// The reference's normal, tilted by its normal map, in the tangent frame of the surface that is baked for.
    Normal,
    /// The same in object space.
    ObjectNormal,
    /// The position, object space; in 8 bits from the model's low corner, its longest side being 1.
    Position,
    /// How far the point lies over the surface that is baked for, along its normal; in 8 bits half is the surface itself.
    Height,
    /// The correspondence itself: the number of the reference's triangle and the barycentrics of its corners 1 and 2, -1 where
    /// there is none. In 8 bits a colour for each triangle.
    Mapping,
    /// Anything that pictures show in place of base colour.
    Shown(Attribute),
}

impl FromStr for BakeAttribute {
    type Err = Error;

    /// `normal`, `object-normal`, `position`, `height`, `mapping`, `color` (the base colour, vertex colours included), or an [`Attribute`].
    fn from_str(text: &str) -> Result<Self> {
        Ok(match text.trim() {
            "normal" => BakeAttribute::Normal,
            "object-normal" => BakeAttribute::ObjectNormal,
            "position" => BakeAttribute::Position,
            "height" => BakeAttribute::Height,
            "mapping" => BakeAttribute::Mapping,
            "color" => BakeAttribute::Shown("base-color".parse()?),
            "vertex-color" => BakeAttribute::Shown("color".parse()?),
            other => {
                let attribute: Attribute = other.parse().map_err(|error| match error {
                    Error::Option { reason, .. } => Error::Option {
                        option: "--attributes",
                        reason,
                    },
                    error => error,
                })?;
                if attribute.factors().contains(&Factor::Procedural) {
                    return Err(Error::Option {
                        option: "--attributes",
                        reason: "procedural runs on a device only and is not baked".into(),
                    });
                }
                BakeAttribute::Shown(attribute)
            }
        })
    }
}

impl fmt::Display for BakeAttribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            BakeAttribute::Normal => f.write_str("normal"),
            BakeAttribute::ObjectNormal => f.write_str("object-normal"),
            BakeAttribute::Position => f.write_str("position"),
            BakeAttribute::Height => f.write_str("height"),
            BakeAttribute::Mapping => f.write_str("mapping"),
            BakeAttribute::Shown(attribute) if attribute.to_string() == "base-color" => {
                f.write_str("color")
            }
            BakeAttribute::Shown(attribute) if attribute.to_string() == "color" => {
                f.write_str("vertex-color")
            }
            BakeAttribute::Shown(attribute) => attribute.fmt(f),
        }
    }
}

/// The height that 8 bits reach where nothing else is said, in longest sides of the model.
const STEEP: f32 = 0.05;

/// An attribute made ready to be fetched.
pub(super) struct Source {
    pub(super) attribute: BakeAttribute,
    set: AttributeSet,
    /// First triangle of the mesh at hand.
    base: u32,
    /// The model's low corner and longest side.
    bounds: (V3, f32),
    /// The height that 8 bits reach, up and down.
    steep: f32,
}

/// Where a sample lies on the surface that is baked for.
pub(super) struct Low<'a> {
    pub(super) mesh: &'a Mesh,
    pub(super) corners: [u32; 3],
    pub(super) b: V3,
}

impl Low<'_> {
    /// How far `there` lies over the surface, along its normal.
    fn height(&self, there: V3) -> f32 {
        let at = |of: &[V3]| weighted(&self.corners.map(|v| of[v as usize]), self.b);
        let normal = unit3(at(&self.mesh.normals), [0.0, 0.0, 1.0]);
        dot3(sub3(there, at(&self.mesh.positions)), normal)
    }
}

impl Source {
    /// 8 bits reach this height from now on.
    pub(super) fn reach(&mut self, height: f32) {
        self.steep = height;
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
        options: &ShownOptions,
        progress: &dyn Progress,
    ) -> Result<(Vec<Source>, Vec<String>)> {
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
            let (source, told) = Source::new(scene, attribute, options, &heard)?;
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
        let source = Source {
            attribute: attribute.clone(),
            set,
            base: 0,
            bounds: bounds(scene),
            steep: bounds(scene).1 * STEEP,
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
        matches!(
            self.attribute,
            BakeAttribute::Position | BakeAttribute::Height
        )
    }

    /// Whether textures are sampled.
    pub(super) fn has_textures(&self) -> bool {
        !self.set.textures.texels.is_empty()
    }

    /// Whether values are linear light, written as sRGB.
    pub(super) fn is_color(&self) -> bool {
        match &self.attribute {
            BakeAttribute::Shown(shown) => !shown.is_data(),
            _ => false,
        }
    }

    /// Whether values are directions.
    pub(super) fn is_direction(&self) -> bool {
        matches!(
            self.attribute,
            BakeAttribute::Normal | BakeAttribute::ObjectNormal
        )
    }

    /// The value at a point whose triangle, with these corners, counts from the first one taken; directions and positions
    /// as they are.
    pub(super) fn at(
        &self,
        decode: &[f32],
        corners: &[V3; 3],
        point: &SurfacePoint,
        low: Option<&Low>,
    ) -> [f32; 4] {
        match self.attribute {
            BakeAttribute::Position => {
                let [x, y, z] = weighted(corners, point.b);
                return [x, y, z, 1.0];
            }
            BakeAttribute::Height => {
                let height = low.map_or(0.0, |low| low.height(weighted(corners, point.b)));
                return [height, height, height, 1.0];
            }
            BakeAttribute::Mapping => {
                return [point.triangle as f32, point.b[1], point.b[2], 1.0];
            }
            _ => {}
        }
        let here = SurfacePoint {
            triangle: point.triangle + self.base,
            ..*point
        };
        let frame = Frame {
            world: &ROWS,
            normal: &UPRIGHT,
        };
        let mut surface = self.set.surface(decode, &here, &frame);
        let [x, y, z] = match (&self.attribute, low) {
            (BakeAttribute::Normal, Some(low)) => {
                into_frame(low.mesh, low.corners, low.b, surface.normal)
            }
            (BakeAttribute::Normal | BakeAttribute::ObjectNormal, _) => surface.normal,
            _ => {
                self.set
                    .show(decode, &mut surface, &here, point.triangle, 0.0);
                let [r, g, b, _] = surface.base;
                [r, g, b]
            }
        };
        let alpha = if self.is_color() {
            surface.base[3]
        } else {
            1.0
        };
        [x, y, z, alpha]
    }

    /// A mean of values as a value.
    pub(super) fn mean(&self, sum: [f32; 4], count: f32) -> [f32; 4] {
        let [x, y, z, w] = sum.map(|s| s / count);
        if self.is_direction() {
            let [x, y, z] = unit3([x, y, z], [0.0, 0.0, 1.0]);
            return [x, y, z, w];
        }
        [x, y, z, w]
    }

    /// A value of data as 8 bits hold it, 0..1.
    pub(super) fn coded(&self, value: [f32; 4]) -> [f32; 4] {
        let [x, y, z, w] = value;
        let [x, y, z] = match self.attribute {
            BakeAttribute::Position => {
                let (low, longest) = self.bounds;
                [
                    (x - low[0]) / longest,
                    (y - low[1]) / longest,
                    (z - low[2]) / longest,
                ]
            }
            BakeAttribute::Height => [x, y, z].map(|h| h / self.steep * 0.5 + 0.5),
            BakeAttribute::Mapping if x < 0.0 => [0.0; 3],
            BakeAttribute::Mapping => shade(x as u32),
            _ if self.is_direction() => [x, y, z].map(|c| c * 0.5 + 0.5),
            _ => [x, y, z],
        };
        [x, y, z, w]
    }
}

/// A colour for a number, none near black.
fn shade(number: u32) -> V3 {
    let mixed = number.wrapping_add(1).wrapping_mul(0x9e37_79b9);
    let mixed = (mixed ^ mixed >> 15).wrapping_mul(0x85eb_ca6b);
    [8, 16, 24].map(|shift| 0.25 + 0.75 * (mixed >> shift & 0xff) as f32 / 255.0)
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
