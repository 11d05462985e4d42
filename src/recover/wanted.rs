//! What can be resampled into a texture, by name.

use crate::attribute::{Attribute, Factor};
use crate::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// What is resampled into a texture.
///
/// What depends on a place's surroundings is of the reference as it stands: of both models in the world, of a built file in
/// the mesh's own space, where the mesh is alone. Lengths are in that space's unit.
#[derive(Clone, Debug, PartialEq)]
pub enum BakeAttribute {
    /// The reference's normal, tilted by its normal map, in the tangent frame of the surface that is baked for.
    Normal,
    /// The same in object space.
    ObjectNormal,
    /// The mean of the directions in which the reference's point sees the sky, weighted by their cosine, in the tangent frame of
    /// the surface that is baked for; the normal where it sees none.
    BentNormal,
    /// The same in object space.
    ObjectBentNormal,
    /// The position, object space; in codes from the model's low corner, its longest side being 1.
    Position,
    /// How far the point lies over the surface that is baked for, along its normal; in codes half is the surface itself.
    Height,
    /// The mean curvature of the reference in 1 / unit of length, positive where it bulges, interpolated between its vertices
    /// ([`mean_curvature`](crate::mesh::mean_curvature)); in codes half is flat, 1 a ball of
    /// [`AroundOptions::curvature_radius`](super::AroundOptions::curvature_radius), 0 a hollow of it.
    Curvature,
    /// How far it is through the body to its far side: the mean over directions inwards, weighted by their cosine, none counted
    /// longer than rays reach ([`AroundOptions::reach`](super::AroundOptions::reach)), which is 1 in codes. Of a ball 4/3 of
    /// its radius.
    Thickness,
    /// 1 where the light ([`AroundOptions::light`](super::AroundOptions::light)) reaches the reference's point, 0 where it looks
    /// away from the light or something of the reference stands between.
    Shadow,
    /// What a white matt surface with the reference's normal shows under that light, whatever stands between: the cosine
    /// between both, linear.
    Shading,
    /// The correspondence itself: the number of the reference's triangle and the barycentrics of its corners 1 and 2, -1 where
    /// there is none ([`BakedTexture::triangles`](super::BakedTexture::triangles)). In codes a colour for each triangle.
    Mapping,
    /// Anything that pictures show in place of base colour.
    Shown(Attribute),
}

/// Attributes that are one word and none of [`Attribute`]'s.
const WORDS: [(&str, BakeAttribute); 11] = [
    ("normal", BakeAttribute::Normal),
    ("object-normal", BakeAttribute::ObjectNormal),
    ("bent-normal", BakeAttribute::BentNormal),
    ("object-bent-normal", BakeAttribute::ObjectBentNormal),
    ("position", BakeAttribute::Position),
    ("height", BakeAttribute::Height),
    ("curvature", BakeAttribute::Curvature),
    ("thickness", BakeAttribute::Thickness),
    ("shadow", BakeAttribute::Shadow),
    ("shading", BakeAttribute::Shading),
    ("mapping", BakeAttribute::Mapping),
];

/// Other names for some of [`Attribute`]'s.
const OTHERWISE: [(&str, &str); 2] = [("color", "base-color"), ("vertex-color", "color")];

impl BakeAttribute {
    /// Whether it is told in the tangent frame of a surface.
    pub(super) fn is_tangent(&self) -> bool {
        matches!(self, BakeAttribute::Normal | BakeAttribute::BentNormal)
    }

    /// Whether values are directions.
    pub(super) fn is_direction(&self) -> bool {
        let of_object = [BakeAttribute::ObjectNormal, BakeAttribute::ObjectBentNormal];
        self.is_tangent() || of_object.contains(self)
    }

    /// Whether values are linear light, coded as sRGB.
    pub(super) fn is_color(&self) -> bool {
        match self {
            BakeAttribute::Shown(shown) => !shown.is_data(),
            BakeAttribute::Shading => true,
            _ => false,
        }
    }

    /// Whether it depends on what lies round the reference's point.
    pub(super) fn asks_around(&self) -> bool {
        self.casts() || *self == BakeAttribute::Curvature
    }

    /// Whether it is found by rays from the reference's point.
    pub(super) fn casts(&self) -> bool {
        use BakeAttribute::*;
        matches!(self, BentNormal | ObjectBentNormal | Thickness | Shadow)
    }
}

impl FromStr for BakeAttribute {
    type Err = Error;

    /// One of the words above, `color` (the base colour, vertex colours included), `vertex-color` (COLOR_0), or an [`Attribute`].
    fn from_str(text: &str) -> Result<Self> {
        let text = text.trim();
        if let Some((_, attribute)) = WORDS.iter().find(|(word, _)| *word == text) {
            return Ok(attribute.clone());
        }
        let wrong = |reason: String| Error::Option {
            option: "--attributes",
            reason,
        };
        let other = OTHERWISE.iter().find(|(word, _)| *word == text);
        let attribute: Attribute =
            other
                .map_or(text, |(_, name)| name)
                .parse()
                .map_err(|error| match error {
                    Error::Option { reason, .. } => {
                        let words = WORDS.map(|(word, _)| word).join(", ");
                        wrong(format!("{reason}; and, to bake: {words}, vertex-color"))
                    }
                    error => error,
                })?;
        if attribute.factors().contains(&Factor::Procedural) {
            let reason = "procedural runs on a device only and is not baked";
            return Err(wrong(reason.into()));
        }
        Ok(BakeAttribute::Shown(attribute))
    }
}

impl fmt::Display for BakeAttribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((word, _)) = WORDS.iter().find(|(_, attribute)| attribute == self) {
            return f.write_str(word);
        }
        let BakeAttribute::Shown(attribute) = self else {
            return Ok(());
        };
        let name = attribute.to_string();
        let other = OTHERWISE.iter().find(|(_, usual)| *usual == name);
        f.write_str(other.map_or(name.as_str(), |(word, _)| word))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_come_back_and_others_are_refused_with_all_there_are() {
        let names = WORDS.map(|(word, _)| word).into_iter();
        for name in names.chain(["color", "vertex-color", "occlusion", "wood*occlusion"]) {
            assert_eq!(name.parse::<BakeAttribute>().unwrap().to_string(), name);
        }
        let base: BakeAttribute = "base-color".parse().unwrap();
        assert_eq!(base.to_string(), "color");
        for text in ["colour", "bent", "procedural"] {
            let refused = text.parse::<BakeAttribute>().unwrap_err().to_string();
            assert!(refused.starts_with("--attributes: "), "{refused}");
        }
        let refused = "bent".parse::<BakeAttribute>().unwrap_err().to_string();
        assert!(refused.contains("bent-normal") && refused.contains("occlusion"));
    }
}
