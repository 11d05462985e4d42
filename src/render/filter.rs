//! How many points of the reference a pixel gathers. Twin of `glsl/render/filter.glsl`.
//!
//! In: a drawn triangle at a pixel. Out: the [`Surface`] that is lit, and the fetches that all its lookups took.
//!
//! [`Filter::Five`] is the paper's (section 2.5): five points, five surfaces, their mean. The four beside the middle lie at
//! (1, 3), (3, -1), (-1, -3) and (-3, 1) times 1/sqrt(48) of a pixel: no two in a row or column, and with equal weights the
//! second moments of the pixel's square. A place in a reference triangle that one before it was found in needs no lookup:
//! testing it loads nothing. Textures are filtered over each point's share of the pixel, [`SHARE`] of the gradients; by
//! [`Filter::Footprint`] anisotropically, so that what is seen at a grazing angle stays sharp across.
//!
//! A place outside the drawn triangle is drawn in to its border: nothing is looked up where nothing is drawn.

use super::beforehand::{self, Beforehand};
use super::correspond;
use super::draw::DrawRecord;
use super::picture::Picture;
use super::shade::Drawn;
use crate::attribute::arithmetic::{add3, scale3, sub3, unit3};
use crate::attribute::surface::{Surface, SurfacePoint};
use serde::Serialize;

/// How a LoD gathers the reference's appearance over a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Filter {
    /// One point; its textures filtered isotropically, as a plain renderer does.
    #[default]
    Nearest,
    /// The mean of five points (paper, section 2.5).
    Five,
    /// The mean of five points whose textures are filtered anisotropically: up to four samples each.
    Footprint,
}

impl Filter {
    /// All of them, from the cheapest on.
    pub const ALL: [Filter; 3] = [Filter::Nearest, Filter::Footprint, Filter::Five];

    /// As the flags of a view and the shaders have it.
    pub(crate) fn code(self) -> u32 {
        self as u32
    }

    /// One of five points, with its share of the gradients.
    fn share(self, p: SurfacePoint) -> SurfacePoint {
        SurfacePoint {
            dx: p.dx.map(|d| scale3(d, SHARE)),
            dy: p.dy.map(|d| scale3(d, SHARE)),
            taps: if self == Filter::Footprint {
                FOOTPRINT_TAPS
            } else {
                1
            },
            ..p
        }
    }

    pub(crate) fn from_code(code: u32) -> Self {
        match code {
            1 => Filter::Five,
            2 => Filter::Footprint,
            _ => Filter::Nearest,
        }
    }
}

const PLACE_NEAR: f32 = 0.144_337_57;
const PLACE_FAR: f32 = 0.433_012_7;
const PLACES: [[f32; 2]; 4] = [
    [PLACE_NEAR, PLACE_FAR],
    [PLACE_FAR, -PLACE_NEAR],
    [-PLACE_NEAR, -PLACE_FAR],
    [-PLACE_FAR, PLACE_NEAR],
];
/// What part of a pixel's gradients the textures of one of five points are filtered over.
const SHARE: f32 = 0.45;
/// Texture samples along the longer axis of a footprint, at most.
const FOOTPRINT_TAPS: u32 = 4;

/// What a pixel gathered.
pub(crate) struct Gathered {
    /// The point of its middle; none where the tables know no point, or nothing was looked up.
    pub point: Option<SurfacePoint>,
    /// None where the tables know no point.
    pub surface: Option<Surface>,
    /// Fetches of all lookups, and one for what was filtered beforehand.
    pub fetches: u32,
}

/// Surfaces being added up.
#[derive(Default)]
struct Sum {
    surface: Surface,
    shown: u32,
    masked: u32,
}

impl Sum {
    fn add(&mut self, s: &Surface) {
        if s.masked {
            self.masked += 1;
            return;
        }
        self.shown += 1;
        let sum = &mut self.surface;
        sum.base = [0, 1, 2, 3].map(|i| sum.base[i] + s.base[i]);
        sum.normal = add3(sum.normal, s.normal);
        sum.emissive = add3(sum.emissive, s.emissive);
        sum.bump = add3(sum.bump, s.bump);
        sum.metallic += s.metallic;
        sum.roughness += s.roughness;
        sum.occlusion += s.occlusion;
    }

    fn mean(&self, centre: &Surface) -> Surface {
        if self.masked > self.shown {
            return Surface {
                masked: true,
                ..*centre
            };
        }
        let (sum, n) = (&self.surface, self.shown as i32 as f32);
        Surface {
            base: sum.base.map(|x| x / n),
            normal: unit3(sum.normal, centre.normal),
            emissive: sum.emissive.map(|x| x / n),
            bump: sum.bump.map(|x| x / n),
            metallic: sum.metallic / n,
            roughness: sum.roughness / n,
            occlusion: sum.occlusion / n,
            masked: false,
            unlit: centre.unlit,
        }
    }
}

/// The drawn triangle at a place of the pixel; none where its neighbours have no meaning.
fn moved(drawn: &Drawn, place: [f32; 2]) -> Option<Drawn> {
    let (x, y) = (sub3(drawn.bx?, drawn.b), sub3(drawn.by?, drawn.b));
    let way = add3(scale3(x, place[0]), scale3(y, place[1]));
    // As far as the border.
    let mut share = 1f32;
    for (b, d) in drawn.b.into_iter().zip(way) {
        if b + d < 0.0 {
            share = share.min(b.max(0.0) / -d);
        }
    }
    let b = add3(drawn.b, scale3(way, share));
    Some(Drawn {
        b,
        bx: Some(add3(b, x)),
        by: Some(add3(b, y)),
        ..*drawn
    })
}

/// The surface of a pixel; `before` is what was filtered beforehand, `see` says what is seen of a point.
pub(crate) fn gather(
    (picture, draw): (&Picture, &DrawRecord),
    drawn: &Drawn,
    filter: Filter,
    before: Option<Beforehand>,
    see: impl Fn(&SurfacePoint) -> Surface,
) -> Gathered {
    let Some(before) = before else {
        return looked_up((picture, draw), drawn, filter, see);
    };
    if before.share >= 1.0 {
        return Gathered {
            point: None,
            surface: Some(before.surface),
            fetches: 1,
        };
    }
    let full = looked_up((picture, draw), drawn, filter, see);
    let blended = |s: Surface| match before.share > 0.0 {
        true => beforehand::blend(&s, &before),
        false => s,
    };
    Gathered {
        surface: full.surface.map(blended),
        fetches: full.fetches + 1,
        ..full
    }
}

/// The surface of a pixel through the correspondence.
fn looked_up(
    (picture, draw): (&Picture, &DrawRecord),
    drawn: &Drawn,
    filter: Filter,
    see: impl Fn(&SurfacePoint) -> Surface,
) -> Gathered {
    let centre = correspond::find(picture, draw, drawn);
    let Some(point) = centre.point else {
        return Gathered {
            point: None,
            surface: None,
            fetches: centre.fetches,
        };
    };
    let alone = filter == Filter::Nearest || draw.correspondence == correspond::IDENTITY;
    let places = PLACES.map(|place| moved(drawn, place));
    let (false, [Some(a), Some(b), Some(c), Some(d)]) = (alone, places) else {
        return Gathered {
            point: centre.point,
            surface: Some(see(&point)),
            fetches: centre.fetches,
        };
    };
    let mut fetches = centre.fetches;
    let mut points = vec![point];
    for place in [a, b, c, d] {
        let again = |p: &SurfacePoint| {
            let triangle = p.triangle - draw.attribute_base;
            let b = correspond::within(picture, draw, &place, triangle)?;
            Some(SurfacePoint { b, ..*p })
        };
        let again = points.iter().find_map(again);
        points.extend(again.or_else(|| {
            let found = correspond::find(picture, draw, &place);
            fetches += found.fetches;
            found.point
        }));
    }
    let seen: Vec<Surface> = points.iter().map(|p| see(&filter.share(*p))).collect();
    let mut sum = Sum::default();
    seen.iter().for_each(|s| sum.add(s));
    Gathered {
        point: centre.point,
        surface: Some(sum.mean(&seen[0])),
        fetches,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_places_have_the_moments_of_the_square() {
        let sum = |f: &dyn Fn([f32; 2]) -> f32| PLACES.map(f).iter().sum::<f32>() / 5.0;
        assert_eq!((sum(&|p| p[0]), sum(&|p| p[1])), (0.0, 0.0));
        for k in 0..2 {
            assert!((sum(&|p| p[k] * p[k]) - 1.0 / 12.0).abs() < 1e-6);
        }
        assert!(sum(&|p| p[0] * p[1]).abs() < 1e-6);
    }

    #[test]
    fn a_place_outside_is_drawn_in_to_the_border() {
        let drawn = Drawn {
            b: [0.02, 0.5, 0.48],
            bx: Some([-0.18, 0.7, 0.48]),
            by: Some([0.02, 0.4, 0.58]),
            local: 0,
            vertex: [0; 3],
            asker: 0,
        };
        let b = moved(&drawn, [0.4, 0.0]).unwrap().b;
        assert!(b[0].abs() < 1e-6 && (b[1] - 0.52).abs() < 1e-6, "{b:?}");
        let free = moved(&drawn, [-0.4, 0.0]).unwrap().b;
        assert!((free[0] - 0.1).abs() < 1e-6);
        assert!(moved(&Drawn { by: None, ..drawn }, [0.1, 0.1]).is_none());
    }
}
