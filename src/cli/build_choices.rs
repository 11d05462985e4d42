//! What `build` may be told by a word: layouts, simplifiers, what a multiresolution model knows.

use invertex::asset::Multiresolution;
use invertex::igt::Layout;
use invertex::lod;
use invertex::lod::progressive::Cost;
use invertex::lod::progressive::colour::Distance;

/// What a multiresolution model knows besides how far details are displaced.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub(super) enum Mrm {
    /// What colours are off by, in CIELAB (Delta E 1976: 1 is just noticeable), at every mip.
    Lab,
    /// The same in sRGB codes, 0 to 255.
    Rgb,
    /// Nothing: for video and textures that change.
    Geometry,
}

/// `--layout`.
#[derive(Clone, Copy, clap::ValueEnum)]
pub(super) enum LayoutName {
    /// Ours.
    Packed,
    /// The paper's.
    Classic,
}

/// `--simplifier`.
#[derive(Clone, Copy, PartialEq, clap::ValueEnum)]
pub(super) enum Simplifier {
    /// Quadric edge collapse by meshoptimizer, one error budget over all meshes.
    Meshopt,
    /// Progressive meshes, ours: bounds how far any detail of the texture is displaced, and displaces as little as can be; levels
    /// are nested.
    Progressive,
    /// The same in the order of the quadric error: the surface moves as little as can be, its details are displaced farther.
    #[value(name = "progressive:quadric")]
    Quadric,
}

impl From<LayoutName> for Layout {
    fn from(name: LayoutName) -> Self {
        match name {
            LayoutName::Packed => Layout::Packed,
            LayoutName::Classic => Layout::Classic,
        }
    }
}

impl From<Simplifier> for lod::Simplifier {
    fn from(name: Simplifier) -> Self {
        match name {
            Simplifier::Meshopt => lod::Simplifier::Meshopt,
            Simplifier::Progressive => lod::Simplifier::Progressive(Cost::Displacement),
            Simplifier::Quadric => lod::Simplifier::Progressive(Cost::Quadric),
        }
    }
}

impl Mrm {
    /// What `--mrm` says, if it is given.
    pub(super) fn of(given: Option<Self>) -> Multiresolution {
        match given {
            None => Multiresolution::None,
            Some(Mrm::Geometry) => Multiresolution::Geometry,
            Some(Mrm::Lab) => Multiresolution::Colours(Distance::Lab),
            Some(Mrm::Rgb) => Multiresolution::Colours(Distance::Rgb),
        }
    }
}
