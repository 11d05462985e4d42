//! What simplification does to colours: for every triangle there ever was, how far a colour shown is from the true one, at most.
//!
//! In: a reference, the history of its simplification, what its triangles show ([`Colours`]). Out: [`ColourDeviations`], by
//! level.
//!
//! A simplified triangle shows at its point Q the colour of the reference's point P. Seen along the triangle's normal, P's colour
//! belongs where P's foot on the triangle's plane is. What is shown there is some other point's: the plane is extended, the way
//! there walked over the reference, and where that ends before, the nearest place of the last triangle counts (`beyond.rs` says
//! which). The distance of the two colours is the *tangential* deviation at P; no point of the triangle has a larger one than is
//! said. Of what the normal part does, only the
//! *product* of its length with the steepest colour near is known before there is a view.
//!
//! ```text
//! colours --palette--> mips as fields, with pyramids       history --covers--> triangles, and what they stand for
//!                                  \--landing--> pieces, where both places vary linearly <--/
//!                                               --bound--> largest distance of colours
//! ```
//!
//! A colour is a texel's in the [`Distance`]'s space, texel by texel (places rounded to 1/256 or 1/128 of its unit), and
//! bilinear between texels there. Both ends of a deviation are taken from the mip in use at P.
//!
//! Along parallel lines and those of a sphere a bound is met within 5 % on more than nine triangles of ten, on closed surfaces and
//! charts on all but two in a hundred ([`ColourDeviations::met`]). Along a cylinder's lines (`round.rs`) bounds hold and are wide.
//!
//! Source: Schilling and Klein, Texture-dependent refinement of multiresolution meshes, section 4.

mod beyond;
mod bound;
mod covers;
mod field;
mod ground;
mod landing;
mod palette;
mod passed;
mod piece;
mod polygon;
mod round;
mod space;
mod steep;
mod triangle;

pub use space::Distance;

use super::Progressive;
use crate::error::{Error, Result};
use crate::lod::LodInput;
use crate::param::weld::by_place;
use ground::Ground;
use palette::Palette;
use std::borrow::Cow;
use triangle::Against;

/// What lies outside [0, 1] along one axis of a picture.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The picture again.
    #[default]
    Repeat,
    /// The picture again, every other time mirrored.
    Mirror,
    /// The last texel.
    Clamp,
}

/// A texture with its mips.
#[derive(Clone, Debug)]
pub struct Picture<'a> {
    /// Texels across and down.
    pub size: [u32; 2],
    /// Texels of every mip, row by row; mip m has `max(size >> m, 1)`. One where the texture has no mips.
    pub mips: Vec<Cow<'a, [[u8; 4]]>>,
    /// Along u and along v.
    pub wrap: [Wrap; 2],
    /// Whether texels are sRGB; if not they are linear.
    pub srgb: bool,
    /// The nearest texel instead of a bilinear blend.
    pub nearest: bool,
    /// Linear, multiplied with each texel.
    pub factor: [f32; 4],
    /// Whether the fourth channel counts: not for opaque materials.
    pub opacity_matters: bool,
}

/// What a triangle of the reference shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shade {
    /// A picture.
    Picture {
        /// Its number.
        picture: u32,
        /// Where its corners lie, in widths and heights of the picture, any transform applied.
        uv: [[f32; 2]; 3],
    },
    /// Linear RGBA at the corners, whose places in colour space are blended.
    Corners([[f32; 4]; 3]),
}

/// What a reference shows.
#[derive(Clone, Debug, Default)]
pub struct Colours<'a> {
    /// Its pictures.
    pub pictures: Vec<Picture<'a>>,
    /// For each triangle of the mesh.
    pub shades: Vec<Shade>,
    /// Whether the opacity of [`Shade::Corners`] counts.
    pub opacity_matters: bool,
}

/// Deviations of a triangle's colours at a level, in the [`Distance`]'s unit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ColourDeviation {
    /// What the tangential part of the deviation changes anywhere on the triangle, at most.
    pub tangential: f32,
    /// The length of the normal part times the largest change of colour an object unit near the triangle. What the normal
    /// part changes in a view is this times the cotangent of the angle between view and triangle, at most.
    pub product: f32,
}

/// A bound is met where this share of it is attained.
const MET: f32 = 0.95;

/// Deviations of all triangles at all levels.
///
/// Level k is what is seen where a pixel's footprint on the surface is at least `footprint * 2^k` and less than twice that. Of
/// a texture whose texels have one size on the surface, level k is mip k. At level 0 everything shows its finest mip.
/// Deviations never rise from a level to the next.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourDeviations {
    /// Object units a pixel at level 0: all but a thousandth of the surface has no smaller texels. 1 where there is no
    /// picture.
    pub footprint: f32,
    /// Levels: 1 to 16.
    pub levels: usize,
    /// Of the first of [`Progressive::triangles`], the reference's own, whose deviations are zero, this many are left out.
    pub first: usize,
    /// For each triangle that a collapse made, in order, its levels from the finest on.
    pub of: Vec<ColourDeviation>,
    /// The distance of the farthest two colours.
    pub widest: f32,
    /// Tangential deviations, of triangles and levels, that are large enough to matter (0.1 by [`Distance::Lab`], 0.25 by
    /// [`Distance::Rgb`]).
    pub known: usize,
    /// How many of those some point is known to attain, but for five in a hundred.
    pub met: usize,
}

impl ColourDeviations {
    /// Of one of [`Progressive::triangles`], at a level; levels beyond the last are the last.
    pub fn at(&self, triangle: usize, level: usize) -> ColourDeviation {
        match triangle.checked_sub(self.first) {
            Some(made) => self.of[made * self.levels + level.min(self.levels - 1)],
            None => ColourDeviation::default(),
        }
    }

    /// The level at which a pixel's footprint on the surface is `footprint` object units.
    pub fn level_of(&self, footprint: f32) -> usize {
        let level = (footprint / self.footprint).log2().floor();
        // What is no number is as near as can be.
        (level.max(0.0) as usize).min(self.levels - 1)
    }
}

/// The colour deviations of `history`, which is that of `input`'s mesh.
///
/// # Errors
/// [`Error::Input`] where `colours` are not those of the mesh: other triangles, pictures or texels than there are, numbers that are
/// not finite.
pub fn colour_deviations(
    input: &LodInput<'_>,
    history: &Progressive,
    colours: &Colours<'_>,
    distance: Distance,
) -> Result<ColourDeviations> {
    check(input, colours)?;
    let ground = Ground::new(input);
    let palette = Palette::new(colours, |t| ground.positions(t as u32), distance);
    let place = by_place(&input.mesh.positions, &input.mesh.triangles).of;
    let against = Against {
        steepness: steep::steepness(&ground, &palette),
        ground,
        palette,
        place: &place,
    };
    let (levels, first) = (against.palette.levels, history.reference.len());
    let made = history.triangles.len() - first;
    let mut of = vec![ColourDeviation::default(); made * levels];
    let (mut known, mut met) = (0, 0);
    // Up to the floor nothing is looked at closely, and every bound allows for rounding.
    let matters = distance.floor() + 2.0 * bound::ROUNDING;
    covers::replay(history, &against, |t, measured| {
        let own = &mut of[(t - first) * levels..][..levels];
        for (k, own) in own.iter_mut().enumerate() {
            *own = ColourDeviation {
                tangential: measured.tangential[k],
                product: measured.product[k],
            };
            let attained = measured.attained[k] >= MET * own.tangential;
            known += usize::from(own.tangential > matters);
            met += usize::from(own.tangential > matters && attained);
        }
    });
    Ok(ColourDeviations {
        footprint: against.palette.footprint as f32,
        levels,
        first,
        of,
        widest: against.palette.widest,
        known,
        met,
    })
}

/// Refuses what does not fit the mesh or itself.
fn check(input: &LodInput<'_>, colours: &Colours<'_>) -> Result<()> {
    let fault = |what: String, reason: String| Err(Error::input(&input.mesh.name, what, reason));
    let (shades, triangles) = (colours.shades.len(), input.mesh.triangles.len());
    if shades != triangles {
        return fault(
            "colours".into(),
            format!("{shades} shades for {triangles} triangles"),
        );
    }
    for (p, picture) in colours.pictures.iter().enumerate() {
        let texels = |m: usize| picture.size.map(|n| (n >> m).max(1) as usize);
        let fits =
            |(m, mip): (usize, &Cow<'_, [[u8; 4]]>)| mip.len() == texels(m)[0] * texels(m)[1];
        let whole = picture.size.iter().all(|&n| (1..=1 << 15).contains(&n));
        let mips = (1..=16).contains(&picture.mips.len());
        let finite = picture.factor.iter().all(|f| f.is_finite());
        if !(whole && mips && finite && picture.mips.iter().enumerate().all(fits)) {
            return fault(
                format!("colours.pictures[{p}]"),
                format!(
                    "{:?} texels do not fit its mips, or its factor is no number",
                    picture.size
                ),
            );
        }
    }
    let bad = colours.shades.iter().position(|shade| match shade {
        Shade::Picture { picture, uv } => {
            *picture as usize >= colours.pictures.len()
                || !uv.iter().flatten().all(|c| c.is_finite())
        }
        Shade::Corners(corners) => !corners.iter().flatten().all(|c| c.is_finite()),
    });
    match bad {
        Some(t) => fault(
            format!("colours.shades[{t}]"),
            "names a picture that is not there, or has numbers that are not finite".into(),
        ),
        None => Ok(()),
    }
}
