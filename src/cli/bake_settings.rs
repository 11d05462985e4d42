//! What the options of `bake` ask for, as far as it can be told without the models.

use super::bad_option;
use super::bake::{Bake, Layout, Missed};
use super::view::Size;
use invertex::Result;
use invertex::recover::{BakeAttribute, BakeSettings, Mapping, Misses, Over, PairSettings};

impl Bake {
    /// The mapping that was asked for.
    pub(super) fn mapping(&self, usual: Mapping) -> Result<Mapping> {
        self.map.as_ref().map_or(Ok(usual), |text| text.parse())
    }

    /// What every bake has to know.
    pub(super) fn common_settings(&self) -> Result<(u32, Vec<BakeAttribute>)> {
        let Size(width, height) = self.size;
        if width != height {
            let reason = "baked textures are square: give one number";
            return Err(bad_option("--size", reason));
        }
        let attributes = self.attributes.iter().map(|text| text.parse());
        Ok((width, attributes.collect::<Result<_>>()?))
    }

    /// What is asked for of a built file, as far as it can be told without the model.
    pub(super) fn settings(&self) -> Result<BakeSettings> {
        if self.over == Some(Layout::Primary) && self.lod.is_some() {
            let reason = "says nothing about --over primary, whose texture serves all levels";
            return Err(bad_option("--lod", reason));
        }
        let of_pair = self.misses.is_some() || self.by_name || self.preview || self.cage.is_some();
        if self.recovering.is_given() || of_pair {
            let reason = "a second model to bake for is missing: options of detail recovery say nothing about a built file";
            return Err(bad_option("LOW", reason));
        }
        let (size, attributes) = self.common_settings()?;
        Ok(BakeSettings {
            mapping: self.mapping(Mapping::UvMatch)?,
            over: match self.over {
                None | Some(Layout::Lod) => Over::Lod(self.lod.unwrap_or(1)),
                Some(Layout::Primary) => Over::Primary,
            },
            attributes,
            size,
            samples: self.samples.unwrap_or(2),
            padding: self.padding,
            memory: self.memory.saturating_mul(1 << 20),
            shown: self.computed.options()?,
            around: self.surroundings.options()?,
        })
    }

    /// What is asked for of two models.
    pub(super) fn pair_settings(&self) -> Result<PairSettings> {
        if self.over.is_some() || self.lod.is_some() {
            let option = if self.lod.is_some() {
                "--lod"
            } else {
                "--over"
            };
            return Err(bad_option(
                option,
                "says nothing about a second model: it is of built files",
            ));
        }
        let (size, attributes) = self.common_settings()?;
        let misses = match self.misses {
            None | Some(Missed::Proximity) => Misses::Proximity,
            Some(Missed::Blank) => Misses::Blank,
            Some(Missed::Fill) => Misses::Fill,
        };
        Ok(PairSettings {
            mapping: self.mapping(match self.cage {
                Some(_) => Mapping::Cage,
                None => Mapping::Normal,
            })?,
            recovery: self.recovering.settings(misses)?,
            layout: self.recovering.layout(),
            by_name: self.by_name,
            attributes,
            size,
            samples: self.samples.unwrap_or(1),
            padding: self.padding,
            memory: self.memory.saturating_mul(1 << 20),
            shown: self.computed.options()?,
            around: self.surroundings.options()?,
        })
    }
}
