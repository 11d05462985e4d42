//! Attributes by name: what a picture shows in place of the material's base colour.
//!
//! In: text such as `color*occlusion`. Out: an [`Attribute`], a product of one to [`MOST_FACTORS`] [`Factor`]s, not yet held
//! against any scene ([`super::Shown`] does that).
//!
//! A factor is a colour or data. Colours are linear light: they are lit and written as sRGB like any base colour. Data is
//! written as it is, one step of 8 bits for 1/255, and never lit. A product with a colour in it is a colour.

use super::solid::Solid;
use crate::{Error, Result};
use std::fmt;
use std::str::FromStr;

/// Most factors of a product.
pub const MOST_FACTORS: usize = 4;

/// What a picture shows: the product of its factors, component by component.
#[derive(Clone, Debug, PartialEq)]
pub struct Attribute {
    /// One to [`MOST_FACTORS`].
    pub(super) factors: Vec<Factor>,
}

/// One thing that can be fetched at a point of the reference.
#[derive(Clone, Debug, PartialEq)]
pub enum Factor {
    /// The material's base colour: factor, texture and vertex colour.
    BaseColor,
    /// The texel of the material's normal map.
    NormalMap,
    /// Roughness in green, metalness in blue: factors and texture.
    MetallicRoughness,
    /// Emitted light: factor and texture.
    Emissive,
    /// The material's occlusion map in grey.
    OcclusionMap,
    /// The shading normal in the world, from -1..1 to 0..1: the reference's, tilted by its normal map.
    Normal,
    /// A number or a vector of each vertex.
    Vertex {
        /// Which one.
        of: VertexAttribute,
        /// The triangle's first corner's all over it, not interpolated.
        flat: bool,
    },
    /// A colour of its own for each triangle of the reference.
    TriangleColor,
    /// A colour of its own for each material.
    Material,
    /// A colour of its own for each connected part.
    Part,
    /// A solid texture, cut by the reference at rest.
    Solid(Solid),
    /// A 3-D image of the user's ([`super::Volume`]), cut alike.
    Volume,
    /// A function of the user's ([`super::Procedural`]).
    Procedural,
}

/// What is known of each vertex.
#[derive(Clone, Debug, PartialEq)]
pub enum VertexAttribute {
    /// COLOR_0.
    Color,
    /// Ambient occlusion of the model by itself, cast when it is asked for ([`super::OcclusionOptions`]).
    Occlusion,
    /// A custom attribute of the file.
    Custom {
        /// Its name, with the underscore.
        name: String,
        /// What becomes 0 and what becomes 1; none: nothing is changed.
        range: Option<[f32; 2]>,
    },
}

/// Factors that are one word, and whether each is data.
const WORDS: [(&str, Factor, bool); 15] = [
    ("base-color", Factor::BaseColor, false),
    ("normal-map", Factor::NormalMap, true),
    ("metallic-roughness", Factor::MetallicRoughness, true),
    ("emissive", Factor::Emissive, false),
    ("occlusion-map", Factor::OcclusionMap, true),
    ("normal", Factor::Normal, true),
    ("triangle-color", Factor::TriangleColor, false),
    ("material", Factor::Material, false),
    ("part", Factor::Part, false),
    ("wood", Factor::Solid(Solid::Wood), false),
    ("marble", Factor::Solid(Solid::Marble), false),
    ("cellular", Factor::Solid(Solid::Cellular), false),
    ("checker3d", Factor::Solid(Solid::Checker), false),
    ("volume", Factor::Volume, false),
    ("procedural", Factor::Procedural, false),
];

impl Attribute {
    /// Its factors.
    pub fn factors(&self) -> &[Factor] {
        &self.factors
    }

    /// Whether it is written as it is, unlit: where all factors are data.
    pub fn is_data(&self) -> bool {
        self.factors.iter().all(Factor::is_data)
    }

    /// Whether it may look different at another time.
    pub fn varies(&self) -> bool {
        let varying = |f: &Factor| matches!(f, Factor::Solid(_) | Factor::Procedural);
        self.factors.iter().any(varying)
    }

    /// What can be asked for, in words.
    pub fn names() -> String {
        let words = WORDS.map(|(word, ..)| word).join(", ");
        format!(
            "{words}, color, occlusion, any custom attribute of the file as _NAME or _NAME:LOW..HIGH; flat: before one of the \
             last three takes each triangle's first corner; factors are joined by *"
        )
    }
}

impl Factor {
    fn is_data(&self) -> bool {
        match self {
            Factor::Vertex { of, .. } => *of != VertexAttribute::Color,
            other => WORDS.iter().any(|(_, word, data)| word == other && *data),
        }
    }
}

impl FromStr for Attribute {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        let factors = text
            .split('*')
            .map(|word| word.trim().parse())
            .collect::<Result<Vec<Factor>>>()?;
        if factors.len() > MOST_FACTORS {
            let reason = format!("{} factors; {MOST_FACTORS} at most", factors.len());
            return Err(wrong(reason));
        }
        Ok(Attribute { factors })
    }
}

impl FromStr for Factor {
    type Err = Error;

    fn from_str(text: &str) -> Result<Self> {
        if let Some((_, factor, _)) = WORDS.iter().find(|(word, ..)| *word == text) {
            return Ok(factor.clone());
        }
        let (flat, name) = match text.strip_prefix("flat:") {
            Some(name) => (true, name),
            None => (false, text),
        };
        let of = match name {
            "color" => VertexAttribute::Color,
            "occlusion" => VertexAttribute::Occlusion,
            custom if custom.starts_with('_') => custom_attribute(custom)?,
            _ => {
                let names = Attribute::names();
                return Err(wrong(format!(
                    "there is no attribute \"{text}\"; there are: {names}"
                )));
            }
        };
        Ok(Factor::Vertex { of, flat })
    }
}

/// `_NAME` or `_NAME:LOW..HIGH`.
fn custom_attribute(text: &str) -> Result<VertexAttribute> {
    let (name, range) = match text.split_once(':') {
        None => (text, None),
        Some((name, range)) => {
            let number = |text: &str| text.trim().parse::<f32>().ok().filter(|x| x.is_finite());
            let ends = range
                .split_once("..")
                .and_then(|(low, high)| Some([number(low)?, number(high)?]));
            let ends = ends.filter(|[low, high]| low != high && (high - low).is_finite());
            let Some(ends) = ends else {
                let reason =
                    format!("\"{range}\" is not a range LOW..HIGH of two different numbers");
                return Err(wrong(reason));
            };
            (name, Some(ends))
        }
    };
    Ok(VertexAttribute::Custom {
        name: name.to_owned(),
        range,
    })
}

impl fmt::Display for Attribute {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (k, factor) in self.factors.iter().enumerate() {
            f.write_str(if k == 0 { "" } else { "*" })?;
            factor.fmt(f)?;
        }
        Ok(())
    }
}

impl fmt::Display for Factor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Factor::Vertex { of, flat } = self else {
            let word = WORDS.iter().find(|(_, factor, _)| factor == self);
            return f.write_str(word.map_or("", |(word, ..)| word));
        };
        f.write_str(if *flat { "flat:" } else { "" })?;
        match of {
            VertexAttribute::Color => f.write_str("color"),
            VertexAttribute::Occlusion => f.write_str("occlusion"),
            VertexAttribute::Custom { name, range: None } => f.write_str(name),
            VertexAttribute::Custom {
                name,
                range: Some([low, high]),
            } => write!(f, "{name}:{low}..{high}"),
        }
    }
}

/// What is wrong with the attribute that was asked for.
pub(super) fn wrong(reason: impl Into<String>) -> Error {
    Error::Option {
        option: "--attribute",
        reason: reason.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_and_written_back() {
        for text in [
            "base-color",
            "color*occlusion",
            "flat:_HEAT:-2..40.5",
            "normal",
            "part*_A*flat:color*metallic-roughness",
        ] {
            assert_eq!(text.parse::<Attribute>().unwrap().to_string(), text);
        }
        assert_eq!(
            " color * occlusion"
                .parse::<Attribute>()
                .unwrap()
                .to_string(),
            "color*occlusion"
        );
    }

    #[test]
    fn what_is_no_attribute_is_named_with_all_there_are() {
        for (text, word) in [
            ("colour", "triangle-color"),
            ("", "occlusion"),
            ("color**occlusion", "there is no attribute \"\""),
            ("flat:normal", "there is no attribute"),
            ("_HEAT:1", "LOW..HIGH"),
            ("_HEAT:3..3", "two different"),
            ("_HEAT:nan..1", "LOW..HIGH"),
            ("color*color*color*color*color", "4 at most"),
        ] {
            let message = text.parse::<Attribute>().unwrap_err().to_string();
            assert!(
                message.starts_with("--attribute: ") && message.contains(word),
                "{message}"
            );
        }
    }

    #[test]
    fn a_product_is_data_where_all_its_factors_are() {
        for (text, data) in [
            ("occlusion", true),
            ("color", false),
            ("color*occlusion", false),
            ("_HEAT*occlusion-map", true),
            ("triangle-color", false),
            ("normal", true),
        ] {
            assert_eq!(text.parse::<Attribute>().unwrap().is_data(), data, "{text}");
        }
    }
}
