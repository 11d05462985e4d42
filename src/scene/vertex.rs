//! Vertex attributes of one primitive.
//!
//! In: the attribute names and accessors. Out: [`Vertices`], all arrays of one length, values in range: unit normals and
//! tangents, weights that are not negative and sum to one. What had to be repaired is told in a warning.

use super::accessor::Reader;
use crate::mesh::{CustomAttribute, MorphTarget};
use crate::{Error, Result};
use std::collections::BTreeMap;

/// Uv sets beyond this are left out with a warning.
const MAX_UV_SETS: usize = 8;

/// Attributes of the vertices of one primitive; `None` where the file has none.
#[derive(Default)]
pub(super) struct Vertices {
    pub(super) positions: Vec<[f32; 3]>,
    pub(super) normals: Option<Vec<[f32; 3]>>,
    pub(super) tangents: Option<Vec<[f32; 4]>>,
    pub(super) uv_sets: Vec<Vec<[f32; 2]>>,
    pub(super) colors: Option<Vec<[f32; 4]>>,
    pub(super) joints: Option<Vec<[u16; 4]>>,
    pub(super) weights: Option<Vec<[f32; 4]>>,
    pub(super) targets: Vec<MorphTarget>,
    pub(super) custom: Vec<CustomAttribute>,
}

/// What the attributes of one primitive are read with.
struct Source<'a> {
    reader: &'a Reader<'a>,
    element: &'a str,
    attributes: &'a BTreeMap<String, usize>,
    vertices: usize,
}

/// Reads the attributes of the primitive at `element`, which has a POSITION.
pub(super) fn read_vertices(
    reader: &Reader,
    element: &str,
    attributes: &BTreeMap<String, usize>,
    warnings: &mut Vec<String>,
) -> Result<Vertices> {
    let mut source = Source {
        reader,
        element,
        attributes,
        vertices: 0,
    };
    let positions: Vec<[f32; 3]> = source.floats("POSITION")?.unwrap_or_default();
    source.vertices = positions.len();
    source.check_counts()?;
    let mut out = Vertices {
        uv_sets: source.uv_sets(warnings)?,
        ..Vertices::default()
    };
    out.normals = source.floats("NORMAL")?;
    if let Some(normals) = &mut out.normals {
        let repaired = normals.iter_mut().filter_map(unit).count();
        if repaired > 0 {
            warnings.push(format!(
                "{element}: {repaired} normals were not of unit length"
            ));
        }
    }
    // A tangent means nothing without the normal and the uv it goes with.
    if out.normals.is_some() && !out.uv_sets.is_empty() {
        out.tangents = source.floats("TANGENT")?;
    }
    if let Some(tangents) = &mut out.tangents {
        let repaired = tangents.iter_mut().filter_map(unit_tangent).count();
        if repaired > 0 {
            warnings.push(format!(
                "{element}: {repaired} tangents were not of unit length with a sign"
            ));
        }
    }
    out.colors = source.colors()?;
    if attributes.contains_key("JOINTS_1") {
        warnings.push(format!(
            "{element}: only the first four joints of each vertex are used"
        ));
    }
    (out.joints, out.weights) = source.skin(warnings)?;
    out.custom = source.custom(warnings)?;
    out.positions = positions;
    Ok(out)
}

impl Source<'_> {
    fn fault(&self, what: &str, reason: impl Into<String>) -> Error {
        Error::input(self.reader.file, format!("{}.{what}", self.element), reason)
    }

    fn floats<const N: usize>(&self, name: &str) -> Result<Option<Vec<[f32; N]>>> {
        let Some(&accessor) = self.attributes.get(name) else {
            return Ok(None);
        };
        self.reader
            .floats::<N>(accessor, || format!("{}.{name}", self.element))
            .map(Some)
    }

    /// Every attribute, known or not, has as many elements as there are positions.
    fn check_counts(&self) -> Result<()> {
        for (name, &accessor) in self.attributes {
            let count = self
                .reader
                .check(accessor, || format!("{}.{name}", self.element))?
                .count;
            if count != self.vertices {
                let reason = format!("has {count} elements, POSITION has {}", self.vertices);
                return Err(self.fault(name, reason));
            }
        }
        Ok(())
    }

    /// TEXCOORD_0, 1, ... without gaps.
    fn uv_sets(&self, warnings: &mut Vec<String>) -> Result<Vec<Vec<[f32; 2]>>> {
        let named = self
            .attributes
            .keys()
            .filter(|name| name.starts_with("TEXCOORD_"))
            .count();
        let mut sets = Vec::new();
        for set in 0..named {
            let name = format!("TEXCOORD_{set}");
            if set == MAX_UV_SETS {
                warnings.push(format!(
                    "{}: {named} uv sets, the first {MAX_UV_SETS} are used",
                    self.element
                ));
                break;
            }
            match self.floats(&name)? {
                Some(uv) => sets.push(uv),
                None => {
                    return Err(self.fault(
                        &name,
                        format!("is missing, although there are {named} uv sets"),
                    ));
                }
            }
        }
        Ok(sets)
    }

    /// COLOR_0 as RGBA.
    fn colors(&self) -> Result<Option<Vec<[f32; 4]>>> {
        let Some(&accessor) = self.attributes.get("COLOR_0") else {
            return Ok(None);
        };
        if self.reader.check(accessor, String::new)?.components == 4 {
            return self.floats("COLOR_0");
        }
        let rgb = self.floats::<3>("COLOR_0")?.unwrap_or_default();
        self.reader.charge(rgb.len(), 16, || self.element.into())?;
        Ok(Some(
            rgb.into_iter().map(|[r, g, b]| [r, g, b, 1.0]).collect(),
        ))
    }

    /// Attributes whose names begin with an underscore; matrices are left out.
    fn custom(&self, warnings: &mut Vec<String>) -> Result<Vec<CustomAttribute>> {
        let mut out = Vec::new();
        for (name, &accessor) in self.attributes.iter().filter(|(n, _)| n.starts_with('_')) {
            let width = self.reader.check(accessor, String::new)?.components;
            let values = match width {
                1 => self.floats::<1>(name)?.map(Vec::into_flattened),
                2 => self.floats::<2>(name)?.map(Vec::into_flattened),
                3 => self.floats::<3>(name)?.map(Vec::into_flattened),
                4 => self.floats::<4>(name)?.map(Vec::into_flattened),
                _ => None,
            };
            match values {
                Some(values) => out.push(CustomAttribute {
                    name: name.clone(),
                    width,
                    values,
                }),
                None => warnings.push(format!(
                    "{}.{name}: a matrix is not read: left out",
                    self.element
                )),
            }
        }
        Ok(out)
    }

    /// JOINTS_0 and WEIGHTS_0.
    #[allow(clippy::type_complexity)]
    fn skin(
        &self,
        warnings: &mut Vec<String>,
    ) -> Result<(Option<Vec<[u16; 4]>>, Option<Vec<[f32; 4]>>)> {
        let (Some(&joints), Some(mut weights)) = (
            self.attributes.get("JOINTS_0"),
            self.floats::<4>("WEIGHTS_0")?,
        ) else {
            if self.attributes.contains_key("JOINTS_0") || self.attributes.contains_key("WEIGHTS_0")
            {
                warnings.push(format!(
                    "{}: joints and weights come together; left out",
                    self.element
                ));
            }
            return Ok((None, None));
        };
        let joints = self
            .reader
            .unsigned::<4>(joints, || format!("{}.JOINTS_0", self.element))?;
        self.reader
            .charge(joints.len(), 8, || self.element.into())?;
        let mut narrow = Vec::with_capacity(joints.len());
        for (v, joint) in joints.iter().enumerate() {
            if let Some(j) = joint.iter().find(|&&j| j > u16::MAX.into()) {
                return Err(self.fault("JOINTS_0", format!("element {v} names joint {j}")));
            }
            narrow.push(joint.map(|j| j as u16));
        }
        let mut repaired = 0;
        for (v, weight) in weights.iter_mut().enumerate() {
            if weight.iter().any(|w| *w < 0.0) {
                return Err(self.fault("WEIGHTS_0", format!("element {v} is negative: {weight:?}")));
            }
            let sum: f64 = weight.iter().map(|w| f64::from(*w)).sum();
            if (sum - 1.0).abs() > 1e-2 {
                repaired += 1;
                *weight = match sum > 0.0 {
                    true => weight.map(|w| (f64::from(w) / sum) as f32),
                    false => [1.0, 0.0, 0.0, 0.0],
                };
            }
        }
        if repaired > 0 {
            warnings.push(format!(
                "{}: weights of {repaired} vertices did not sum to 1",
                self.element
            ));
        }
        Ok((Some(narrow), Some(weights)))
    }
}

/// Brings a normal to unit length unless it has it; tells whether it had to. Zero becomes +Z.
fn unit(normal: &mut [f32; 3]) -> Option<()> {
    let vector = glam::DVec3::from_array(normal.map(f64::from));
    if (vector.length_squared() - 1.0).abs() < 1e-3 {
        return None;
    }
    *normal = vector.normalize_or(glam::DVec3::Z).as_vec3().to_array();
    Some(())
}

/// The same for a tangent, whose w is a sign.
fn unit_tangent(tangent: &mut [f32; 4]) -> Option<()> {
    let sign = if tangent[3] < 0.0 { -1.0 } else { 1.0 };
    let mut direction = [tangent[0], tangent[1], tangent[2]];
    let turned = unit(&mut direction);
    let signed = (tangent[3] != sign).then_some(());
    *tangent = [direction[0], direction[1], direction[2], sign];
    turned.or(signed)
}
