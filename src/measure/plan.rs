//! What a profile draws: variants, sweeps, and the list of drawings that they come to.
//!
//! In: a built model, a level, which sweeps. Out: [`Drawing`]s in order, plain data: each is one picture made ready once
//! and drawn from one or more distances.

use crate::asset::Built;
use crate::igt::Layout;
use crate::render::{self, Filter};
use serde::Serialize;

/// Where the appearance of what is drawn comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Variant {
    /// The reference itself.
    #[serde(rename = "reference")]
    Reference,
    /// A LoD with its inverse texture.
    #[serde(rename = "lod+igt")]
    Inverse,
    /// The same LoD with conventionally baked textures over an atlas of its own.
    #[serde(rename = "lod+baked")]
    Baked,
    /// The same LoD with the artist's uv at its corners.
    #[serde(rename = "lod+plain")]
    Plain,
}

impl Variant {
    /// All of them, in the order of a profile's rows.
    pub const ALL: [Variant; 4] = [
        Variant::Reference,
        Variant::Inverse,
        Variant::Baked,
        Variant::Plain,
    ];

    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Variant::Reference => "reference",
            Variant::Inverse => "lod+igt",
            Variant::Baked => "lod+baked",
            Variant::Plain => "lod+plain",
        }
    }
}

/// What is varied beyond the rows that every profile has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Sweep {
    /// The hash resolution (the paper's Table 2).
    Hash,
    /// The layouts of the tables, side by side.
    Layout,
    /// The levels of detail.
    Lod,
    /// The distance, for the reference and every level (the paper's Figure 11).
    Distance,
    /// How a pixel gathers the reference: one point, five, the footprint.
    Filter,
}

/// What sweeps go through.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranges {
    /// Hash resolutions.
    pub hashes: Vec<u32>,
    /// Distances, in units of the one at which the model fills the view.
    pub distances: Vec<f64>,
}

impl Default for Ranges {
    /// The paper's.
    fn default() -> Self {
        Ranges {
            hashes: vec![128, 256, 512, 1024],
            distances: vec![1.0, 2.0, 4.0, 8.0, 16.0],
        }
    }
}

/// One picture and where it is drawn from.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// What is drawn.
    pub variant: Variant,
    /// The level of detail; 0 for the reference.
    pub level: usize,
    /// Other tables than the file's: their hash resolution (`None`: the file's) and layout.
    pub tables: Option<(Option<u32>, Layout)>,
    /// Distances it is drawn from.
    pub distances: Vec<f64>,
    /// The sweep it belongs to; none for the rows of every profile.
    pub sweep: Option<Sweep>,
    /// How a pixel gathers the reference.
    pub filter: Filter,
}

/// The drawings of a profile of `built` at `level`.
pub fn plan(built: &Built, level: usize, sweeps: &[Sweep], ranges: &Ranges) -> Vec<Drawing> {
    let mut out: Vec<Drawing> = Variant::ALL
        .into_iter()
        .map(|variant| Drawing::new(variant, level, None))
        .collect();
    for &sweep in sweeps {
        match sweep {
            Sweep::Hash => out.extend(ranges.hashes.iter().map(|&hash| Drawing {
                tables: Some((Some(hash), layout_of(built))),
                ..Drawing::new(Variant::Inverse, level, Some(sweep))
            })),
            Sweep::Layout => out.extend([Layout::Packed, Layout::Classic].map(|layout| Drawing {
                tables: Some((None, layout)),
                ..Drawing::new(Variant::Inverse, level, Some(sweep))
            })),
            Sweep::Filter => out.extend(Filter::ALL.map(|filter| Drawing {
                filter,
                ..Drawing::new(Variant::Inverse, level, Some(sweep))
            })),
            Sweep::Lod => out.extend(over_levels(built, sweep)),
            Sweep::Distance => out.extend(over_levels(built, sweep).map(|drawing| Drawing {
                distances: ranges.distances.clone(),
                ..drawing
            })),
        }
    }
    out
}

/// The reference, and every level in every other variant.
fn over_levels(built: &Built, sweep: Sweep) -> impl Iterator<Item = Drawing> {
    let reference = Drawing::new(Variant::Reference, 0, Some(sweep));
    let levels = (1..render::levels(built)).flat_map(move |level| {
        let others = &Variant::ALL[1..];
        others
            .iter()
            .map(move |&variant| Drawing::new(variant, level, Some(sweep)))
    });
    std::iter::once(reference).chain(levels)
}

fn layout_of(built: &Built) -> Layout {
    built
        .meshes
        .first()
        .map_or_else(Layout::default, |mesh| mesh.tables.layout)
}

impl Drawing {
    fn new(variant: Variant, level: usize, sweep: Option<Sweep>) -> Self {
        Drawing {
            variant,
            level: if variant == Variant::Reference {
                0
            } else {
                level
            },
            tables: None,
            distances: vec![1.0],
            sweep,
            filter: Filter::Nearest,
        }
    }
}
