//! What is known of a picture before its pipelines are made: values of specialization constants, so that a driver leaves out
//! what the picture does not need. Twin of `glsl/render/known.glsl`.
//!
//! In: a [`Picture`]. Out: [`Known`]. Nothing here changes a pixel: on lavapipe, where both sides of every branch are
//! executed, it halves the time of a lookup.

use super::beforehand::TEXTURES_AT;
use super::correspond::IDENTITY;
use super::filter::Filter;
use super::picture::Picture;
use crate::gpu::{Variant, shaders::render_shade as shade};
use crate::igt::{KnownTables, Tables};

/// Values of the constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Known {
    /// Bit 0: some draw is its own reference; bit 1: some draw is looked up.
    correspondence: u32,
    tables: KnownTables,
    /// Whether no draw is deformed.
    rigid: bool,
    /// Shards that texels lie in.
    shards: u32,
    /// Texture slots that some material uses, a bit each.
    slots: u32,
    /// Whether the triangles' records hold the uv of all of them.
    recorded: bool,
    /// Whether an attribute is shown in place of base colour.
    shown: bool,
    /// Whether that is a solid texture, a 3-D image or a function.
    solid: bool,
    /// Whether something was filtered beforehand.
    prefiltered: bool,
}

impl Known {
    pub(crate) fn of(picture: &Picture) -> Self {
        let looked_up = |d: &super::draw::DrawRecord| 1 << u32::from(d.correspondence != IDENTITY);
        let attributes = &picture.attributes;
        Known {
            correspondence: picture.draws.iter().map(looked_up).fold(0, |a, b| a | b),
            tables: Tables::known(picture.tables.iter().map(AsRef::as_ref)),
            rigid: picture.draws.iter().all(|d| d.frames == 0),
            shards: attributes.textures.shards(),
            slots: attributes.used_slots(),
            recorded: attributes.all_recorded(),
            shown: attributes.is_shown(),
            solid: attributes.is_solid(),
            prefiltered: picture.draws.iter().any(|d| d.igt[TEXTURES_AT] != 0),
        }
    }

    /// The same for a fragment shader, which is not told that every draw is looked up. Told that, and that all lines are a
    /// cylinder's, llvmpipe (Mesa 22.3) makes code that takes every triangle for hit, at its first corner; the compute
    /// shader with the same lookup is right, and so is every other driver. Told either alone, it is right.
    pub(crate) fn in_fragments(self) -> Self {
        let some_are_not = u32::from(self.correspondence == 2);
        Known {
            correspondence: self.correspondence | some_are_not,
            ..self
        }
    }

    /// `shading` for a filter, made for what is known.
    pub(crate) fn variant(&self, filter: Filter, shading: &Variant) -> Variant {
        Variant {
            constants: self.constants(filter).to_vec(),
            code: shading.code.clone(),
        }
    }

    /// The constants for a filter with their ids, the same in all shaders that include `render/known.glsl`.
    fn constants(&self, filter: Filter) -> [(u32, u32); 12] {
        let [line, table_layout, record] = self.tables.words();
        [
            (shade::KNOWN_CORRESPONDENCE, self.correspondence),
            (shade::KNOWN_LINE, line),
            (shade::KNOWN_LAYOUT, table_layout),
            (shade::KNOWN_RECORD, record),
            (shade::KNOWN_RIGID, self.rigid.into()),
            (shade::KNOWN_SHARDS, self.shards),
            (shade::KNOWN_SLOTS, self.slots),
            (shade::KNOWN_RECORDED, self.recorded.into()),
            (shade::KNOWN_SHOWN, self.shown.into()),
            (shade::KNOWN_SOLID, self.solid.into()),
            (shade::KNOWN_PREFILTERED, self.prefiltered.into()),
            (shade::KNOWN_FILTER, filter.code()),
        ]
    }
}
