//! The reference's colours as the search for deviations reads them: every mip of every picture as a [`Field`], and which of
//! them a triangle shows at which level.
//!
//! In: [`Colours`] and the reference. Out: [`Palette`]. A *level* is a pixel's footprint on the surface; the mip in use there is
//! that whose texels are no larger: `floor(log2(footprint * density))`, where the density is how many texels of mip 0 an
//! object unit has in the direction where it has most.

use super::field::{Field, Patch, Patches, Summary};
use super::space::{Distance, from_srgb, vector};
use super::{Colours, Picture, Shade};
use glam::{DMat2, DVec2, DVec3, Vec4};
use rayon::prelude::*;

/// Most levels.
pub(super) const MOST_LEVELS: usize = 16;
/// The share of the surface whose texels may be finer than a pixel of level 0: the poles of a globe, slivers.
const FINER: f64 = 1e-3;
/// By how much rounding may make a mip's exponent too small.
const ROUNDING: f64 = 1e-3;
/// Coordinates beyond this are as good as infinite.
const FAR: f64 = 1e12;

/// What a triangle shows.
#[derive(Debug)]
pub(super) enum Look {
    /// A picture, and where in it the corners lie.
    Picture { picture: u32, uv: [DVec2; 3] },
    /// A linear function of the last two barycentric coordinates.
    Corners(Patch),
}

/// All of them.
pub(super) struct Palette {
    pub(super) distance: Distance,
    pub(super) looks: Vec<Look>,
    fields: Vec<Vec<Field>>,
    repeats: Vec<[bool; 2]>,
    /// For each triangle and level.
    mips: Vec<u8>,
    pub(super) levels: usize,
    pub(super) footprint: f64,
    /// No two colours are farther from each other.
    pub(super) widest: f32,
}

/// One end of a deviation: the function that a triangle shows at a level.
#[derive(Clone, Copy)]
pub(super) enum Side<'a> {
    Texels(&'a Field),
    Corners(&'a Patch),
}

impl Palette {
    pub(super) fn new(
        colours: &Colours<'_>,
        corners: impl Fn(usize) -> [DVec3; 3] + Sync,
        distance: Distance,
    ) -> Palette {
        let fields: Vec<Vec<Field>> = colours
            .pictures
            .iter()
            .map(|picture| fields(picture, distance))
            .collect();
        let looks: Vec<Look> = colours
            .shades
            .par_iter()
            .map(|shade| look(shade, colours, distance))
            .collect();
        let densities: Vec<(f64, f64)> = looks
            .par_iter()
            .enumerate()
            .map(|(t, look)| density(look, &fields, corners(t)))
            .collect();
        let footprint = footprint(&densities);
        let repeat = |picture: &Picture<'_>| picture.wrap.map(|w| w == super::Wrap::Repeat);
        let mut palette = Palette {
            distance,
            repeats: colours.pictures.iter().map(repeat).collect(),
            widest: widest(&looks, &fields),
            looks,
            fields,
            mips: Vec::new(),
            levels: 1,
            footprint,
        };
        palette.choose_mips(&densities);
        palette
    }

    /// The mip of each triangle at each level, until all are at their last.
    fn choose_mips(&mut self, densities: &[(f64, f64)]) {
        let last = |t: usize| match &self.looks[t] {
            Look::Picture { picture, .. } => self.fields[*picture as usize].len() - 1,
            Look::Corners(_) => 0,
        };
        let mip = |t: usize, k: usize| {
            let texels = self.footprint * f64::from(1u32 << k) * densities[t].0;
            let mip = (texels.log2() + ROUNDING).floor();
            // At level 0 all show their finest mip.
            if k == 0 {
                0
            } else {
                (mip.max(0.0) as usize).min(last(t))
            }
        };
        let count = self.looks.len();
        let at_last = |k: usize| (0..count).all(|t| mip(t, k) == last(t) || densities[t].0 <= 0.0);
        self.levels = (0..MOST_LEVELS - 1)
            .find(|&k| at_last(k))
            .unwrap_or(MOST_LEVELS - 1)
            + 1;
        let levels = self.levels;
        self.mips = (0..count)
            .into_par_iter()
            .flat_map_iter(|t| (0..levels).map(move |k| mip(t, k) as u8))
            .collect();
    }

    pub(super) fn mip(&self, t: u32, level: usize) -> u8 {
        self.mips[t as usize * self.levels + level]
    }

    fn picture(&self, t: u32) -> Option<u32> {
        match &self.looks[t as usize] {
            Look::Picture { picture, .. } => Some(*picture),
            Look::Corners(_) => None,
        }
    }

    /// Whether both show one picture; along which axes it repeats.
    pub(super) fn shared(&self, a: u32, b: u32) -> Option<[bool; 2]> {
        let picture = self.picture(a)?;
        (self.picture(b) == Some(picture)).then(|| self.repeats[picture as usize])
    }

    /// What triangle `t` shows at a level beside triangle `beside`: where they share a picture, both show one mip.
    pub(super) fn side(&self, t: u32, beside: u32, level: usize) -> Side<'_> {
        match &self.looks[t as usize] {
            Look::Corners(patch) => Side::Corners(patch),
            Look::Picture { picture, .. } => {
                let shared = self.picture(beside) == Some(*picture);
                let mip = self.mip(if shared { beside } else { t }, level);
                Side::Texels(&self.fields[*picture as usize][usize::from(mip)])
            }
        }
    }

    /// How different the colours at two places are, each in what a triangle shows; the first decides the mip.
    pub(super) fn difference(
        &self,
        (t, here): (u32, DVec2),
        (other, there): (u32, DVec2),
        k: usize,
    ) -> f32 {
        let own = self.side(t, t, k).colour(here);
        (own - self.side(other, t, k).colour(there)).length()
    }

    /// Whether triangle `t` beside `beside` shows at a level what it shows at the next.
    pub(super) fn is_as_next(&self, t: u32, beside: u32, level: usize) -> bool {
        let same = |t: u32| self.mip(t, level) == self.mip(t, level + 1);
        level + 1 < self.levels && same(beside) && same(t)
    }

    /// The coordinates, of a picture or of the triangle, of its corners.
    pub(super) fn coordinates(&self, t: u32) -> [DVec2; 3] {
        match &self.looks[t as usize] {
            Look::Picture { uv, .. } => *uv,
            Look::Corners(_) => [DVec2::ZERO, DVec2::X, DVec2::Y],
        }
    }
}

impl<'a> Side<'a> {
    /// From coordinates to texels: factors, and what comes off.
    pub(super) fn scale(&self) -> ([f64; 2], f64) {
        match self {
            Side::Texels(field) => field.scale(),
            Side::Corners(_) => ([1.0; 2], 0.0),
        }
    }

    /// The patches of a rectangle. What touches one by rounding only is left out.
    pub(super) fn patches(&self, low: [f64; 2], high: [f64; 2]) -> Patches {
        const HAIR: f64 = 1e-7;
        match self {
            Side::Corners(_) => [[0, 0]; 2],
            Side::Texels(_) => [0, 1].map(|k| {
                let first = (low[k].clamp(-FAR, FAR) + HAIR).floor() as i64;
                let last = (high[k].clamp(-FAR, FAR) - HAIR).ceil() as i64 - 1;
                [first, last.max(first)]
            }),
        }
    }

    pub(super) fn patch(&self, x: i64, y: i64) -> Patch {
        match self {
            Side::Texels(field) => field.patch(x, y),
            Side::Corners(patch) => **patch,
        }
    }

    /// What is known of a rectangle, which lies in `patches`.
    pub(super) fn summary(&self, patches: Patches, low: [f64; 2], high: [f64; 2]) -> Summary {
        match self {
            Side::Texels(field) => field.summary(patches),
            Side::Corners(patch) => {
                let corner = |x: f64, y: f64| patch.c + patch.x * x as f32 + patch.y * y as f32;
                let mut all = Summary::NOTHING;
                for x in [low[0], high[0]] {
                    for y in [low[1], high[1]] {
                        all = all.with_colour(corner(x, y));
                    }
                }
                all.slope = [patch.x.length(), patch.y.length()];
                all
            }
        }
    }

    /// The same of a rectangle in coordinates.
    pub(super) fn summary_of(&self, low: DVec2, high: DVec2) -> Summary {
        let (size, shift) = self.scale();
        let texels = |c: DVec2| [c.x * size[0] - shift, c.y * size[1] - shift];
        let (low, high) = (texels(low), texels(high));
        self.summary(self.patches(low, high), low, high)
    }

    /// No way so long, in coordinates, changes the colour by more.
    pub(super) fn along(&self, way: DVec2) -> f32 {
        let (slope, size) = match self {
            Side::Texels(field) if field.nearest => return f32::INFINITY,
            Side::Texels(field) => (field.whole.slope, field.size.map(|n| n as f64)),
            Side::Corners(patch) => ([patch.x.length(), patch.y.length()], [1.0; 2]),
        };
        let along = |k: usize| way[k] * size[k] * f64::from(slope[k]);
        (along(0) + along(1)) as f32
    }

    /// The colour at a point, in coordinates.
    pub(super) fn colour(&self, at: DVec2) -> Vec4 {
        let (size, shift) = self.scale();
        let at = [at.x * size[0] - shift, at.y * size[1] - shift];
        let [[x, _], [y, _]] = self.patches(at, at);
        let within = match self {
            Side::Texels(_) => [(at[0] - x as f64) as f32, (at[1] - y as f64) as f32],
            Side::Corners(_) => at.map(|c| c as f32),
        };
        self.patch(x, y).between(within, within)
    }

    /// Whether both are one function of one plane, whose slopes say how fast it changes.
    pub(super) fn is_smooth_with(&self, other: &Side<'_>) -> bool {
        match (self, other) {
            (Side::Texels(a), Side::Texels(b)) => std::ptr::eq(*a, *b) && !a.nearest,
            _ => false,
        }
    }
}

/// All mips of a picture.
fn fields(picture: &Picture<'_>, distance: Distance) -> Vec<Field> {
    let decode: Vec<f64> = (0..=255u8)
        .map(|code| match picture.srgb {
            true => from_srgb(code),
            false => f64::from(code) / 255.0,
        })
        .collect();
    let steps = f64::from(distance.steps());
    let place = |texel: &[u8; 4]| {
        let [r, g, b] =
            [0, 1, 2].map(|k| decode[usize::from(texel[k])] * f64::from(picture.factor[k]));
        let a = f64::from(texel[3]) / 255.0 * f64::from(picture.factor[3]);
        let place = distance.place([r, g, b, a], picture.opacity_matters);
        place.map(|x| (x * steps).round() as i16)
    };
    let field = |(mip, texels): (usize, &std::borrow::Cow<'_, [[u8; 4]]>)| {
        let size = picture.size.map(|n| (n >> mip).max(1));
        let places = texels.par_iter().map(place).collect();
        let unit = 1.0 / distance.steps();
        Field::new(size, picture.wrap, picture.nearest, places, unit)
    };
    picture.mips.iter().enumerate().map(field).collect()
}

fn look(shade: &Shade, colours: &Colours<'_>, distance: Distance) -> Look {
    match shade {
        Shade::Picture { picture, uv } => Look::Picture {
            picture: *picture,
            uv: uv.map(|c| DVec2::from(c.map(f64::from))),
        },
        Shade::Corners(corners) => {
            let place =
                |c: [f32; 4]| vector(distance.place(c.map(f64::from), colours.opacity_matters));
            let [c, x, y] = corners.map(place);
            Look::Corners(Patch {
                c,
                x: x - c,
                y: y - c,
                xy: Vec4::ZERO,
            })
        }
    }
}

/// The change of a triangle's coordinates over its plane: columns for two directions of unit length that are square to each other.
/// None for a triangle without area.
pub(super) fn change(coordinates: [DVec2; 3], [a, b, c]: [DVec3; 3]) -> Option<DMat2> {
    let (ab, ac) = (b - a, c - a);
    let along = ab.try_normalize()?;
    let across = (ac - along * ac.dot(along)).try_normalize()?;
    let corners = DMat2::from_cols(
        DVec2::new(ab.length(), 0.0),
        DVec2::new(ac.dot(along), ac.dot(across)),
    );
    let ends = DMat2::from_cols(
        coordinates[1] - coordinates[0],
        coordinates[2] - coordinates[0],
    );
    let change = ends * corners.inverse();
    change.is_finite().then_some(change)
}

/// The largest stretch of a matrix.
pub(super) fn stretch(m: DMat2) -> f64 {
    let (a, b, c) = (
        m.x_axis.length_squared(),
        m.x_axis.dot(m.y_axis),
        m.y_axis.length_squared(),
    );
    (0.5 * (a + c + ((a - c) * (a - c) + 4.0 * b * b).sqrt())).sqrt()
}

/// Texels of mip 0 an object unit, and the area.
fn density(look: &Look, fields: &[Vec<Field>], corners: [DVec3; 3]) -> (f64, f64) {
    let [a, b, c] = corners;
    let area = (b - a).cross(c - a).length() / 2.0;
    let Look::Picture { picture, uv } = look else {
        return (0.0, area);
    };
    let size = fields[*picture as usize][0].size;
    let size = DVec2::new(size[0] as f64, size[1] as f64);
    let change = change(uv.map(|c| c * size), corners);
    (change.map_or(0.0, stretch), area)
}

/// The footprint of level 0: of all but a small share of the surface no texel is smaller.
fn footprint(densities: &[(f64, f64)]) -> f64 {
    let mut dense: Vec<(f64, f64)> = densities.iter().copied().filter(|d| d.0 > 0.0).collect();
    dense.sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
    let whole: f64 = dense.iter().map(|d| d.1).sum();
    let mut over = 0.0;
    for (density, area) in dense {
        over += area;
        if over > whole * FINER {
            return 1.0 / density;
        }
    }
    1.0
}

fn widest(looks: &[Look], fields: &[Vec<Field>]) -> f32 {
    let mut all = Summary::NOTHING;
    for mips in fields.iter().flatten() {
        all = all.with(&mips.whole);
    }
    for look in looks {
        if let Look::Corners(patch) = look {
            let corners = [patch.c, patch.c + patch.x, patch.c + patch.y];
            all = corners.into_iter().fold(all, Summary::with_colour);
        }
    }
    all.farthest(&all)
}
