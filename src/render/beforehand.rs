//! The shader LoD: what was filtered beforehand in place of the lookup, where it is as good. Twin of
//! `glsl/render/beforehand.glsl`.
//!
//! In: a drawn triangle at a pixel. Out: [`Beforehand`]: the surface of one texel's neighbourhood over the primary
//! parameterization, and how much of the pixel it makes up.
//!
//! The texel says itself how far it lies from the full lookup (see [`Prefiltered`](crate::attribute::Prefiltered)). Up to the
//! caller's bound it stands alone; from there to twice the bound it gives way to the lookup, so that no line shows; a
//! footprint smaller than two of the finest texels is always looked up.

use super::correspond::{query_point, unit};
use super::draw::{DrawRecord, ViewConstants};
use super::frame;
use super::picture::Picture;
use super::shade::{Drawn, OUTPUT_MASK, OUTPUT_UNLIT};
use crate::attribute::arithmetic::{V3, dot3, unit3};
use crate::attribute::prefiltered::{CODES_A_STEP, Role, Scope};
use crate::attribute::sample::UvGradient;
use crate::attribute::surface::Surface;
use crate::attribute::texture::TEXTURE_WORDS;
use crate::igt::Asker;
use crate::param::projection::Line;

/// Where in [`DrawRecord::igt`] the first of the four textures stands, and one more (0: there are none).
pub(crate) const TEXTURES_AT: usize = 10;
/// Where in it stands what they hold for: a [`scope_word`].
pub(crate) const SCOPE_AT: usize = 11;
const UNLIT: u32 = 1 << 31;
/// Of a word of an asker what has to agree: nothing but a layer, or also the side.
const LAYER: u32 = 0xff;
const LAYER_AND_SIDE: u32 = 0x3ff;

/// A scope as shaders get it: the word of an asker that sees the same, and the highest bit for what light does not change.
pub(super) fn scope_word(scope: Scope) -> u32 {
    let asker = Asker {
        layer: Some(scope.layer),
        side: scope.side.into(),
        grazed: false,
    };
    asker.word() | if scope.unlit { UNLIT } else { 0 }
}

/// Whether who asks sees what `scope` holds for. Whoever looks along the surface asks for the nearest point, and is told.
fn sees(asker: u32, scope: u32) -> bool {
    let wanted = scope & LAYER_AND_SIDE;
    let kept = if wanted > LAYER {
        LAYER_AND_SIDE
    } else {
        LAYER
    };
    asker & !(LAYER_AND_SIDE & !kept) == wanted
}

/// What was filtered beforehand for a pixel.
pub(crate) struct Beforehand {
    /// How much of the pixel it makes up.
    pub share: f32,
    /// What it shows.
    pub surface: Surface,
}

/// Of a pixel whose footprint is large enough.
pub(crate) fn at(
    picture: &Picture,
    draw: &DrawRecord,
    view: &ViewConstants,
    drawn: &Drawn,
    (frame, turned): (&frame::Rows, bool),
) -> Option<Beforehand> {
    let first = draw.igt[TEXTURES_AT].checked_sub(1)?;
    let scope = draw.igt[SCOPE_AT];
    if !sees(drawn.asker, scope) {
        return None;
    }
    let line = picture.tables[draw.igt[0] as usize].primary.line();
    let t3 = drawn.vertex.map(|v| picture.t3[v as usize]);
    let [here, x, y] = [drawn.b, drawn.bx?, drawn.by?].map(|b| address(line, query_point(&t3, b)));
    let footprint = footprint(line, here, x, y);
    let textures = &picture.attributes.textures;
    let size = textures.records[first as usize * TEXTURE_WORDS + 1] as i32 as f32;
    let finer = finer(&footprint, size);
    if finer <= 0.0 {
        return None;
    }
    let decode = &picture.constants[..256];
    let images = Role::ALL.map(|role| textures.sample(decode, first + role as u32, &footprint));
    let unlit = view.flags & OUTPUT_MASK == OUTPUT_UNLIT;
    let apart = images[if unlit { Role::Base } else { Role::Normal } as usize][3];
    Some(Beforehand {
        share: share(apart, view.shader_lod()) * finer,
        surface: surface(&images, scope & UNLIT != 0, frame, turned),
    })
}

/// What the images say, with the normal in the world, on the side that is seen.
pub(crate) fn surface(
    images: &[[f32; 4]; 4],
    unlit: bool,
    frame: &frame::Rows,
    turned: bool,
) -> Surface {
    let [base, normal, matter, emissive] = images;
    let object: V3 = [0, 1, 2].map(|i| normal[i] * 2.0 - 1.0);
    let n = unit3(
        frame.1.map(|row| dot3([row[0], row[1], row[2]], object)),
        [0.0, 0.0, 1.0],
    );
    Surface {
        base: [base[0], base[1], base[2], 1.0],
        normal: if turned { n.map(|c| -c) } else { n },
        emissive: [emissive[0], emissive[1], emissive[2]],
        occlusion: matter[0],
        roughness: matter[1],
        metallic: matter[2],
        bump: [0.5, 0.5, 1.0],
        masked: false,
        unlit,
    }
}

/// How much a texel makes up that lies `apart` (of the fourth channel) from the lookup, for a bound in steps of 8 bits.
fn share(apart: f32, bound: f32) -> f32 {
    if bound <= 0.0 {
        return 0.0;
    }
    let steps = apart * (255.0 / CODES_A_STEP);
    ((2.0 * bound - steps) / bound).clamp(0.0, 1.0)
}

/// The surface of a pixel that is both.
pub(crate) fn blend(full: &Surface, before: &Beforehand) -> Surface {
    let (f, b) = (1.0 - before.share, before.share);
    let s = &before.surface;
    let three = |x: V3, y: V3| [0, 1, 2].map(|i| x[i] * f + y[i] * b);
    Surface {
        base: [0, 1, 2, 3].map(|i| full.base[i] * f + s.base[i] * b),
        normal: unit3(three(full.normal, s.normal), s.normal),
        emissive: three(full.emissive, s.emissive),
        metallic: full.metallic * f + s.metallic * b,
        roughness: full.roughness * f + s.roughness * b,
        occlusion: full.occlusion * f + s.occlusion * b,
        ..*full
    }
}

/// 0 where a footprint is narrower than two texels of the finest level, 1 from sqrt(2) times as much on.
fn finer(footprint: &UvGradient, size: f32) -> f32 {
    let squared = |d: [f32; 2]| {
        let t = d.map(|c| c * size);
        t[0] * t[0] + t[1] * t[1]
    };
    (squared(footprint.dx).max(squared(footprint.dy)) - 1.0).clamp(0.0, 1.0)
}

/// Where to sample for a pixel at address `here` whose neighbours are `x` and `y`: levels half as coarse as the pixel.
pub(crate) fn footprint(line: Line, here: [f32; 2], x: [f32; 2], y: [f32; 2]) -> UvGradient {
    let half = |there: [f32; 2]| {
        let mut d = [there[0] - here[0], there[1] - here[1]];
        if line == Line::Cylinder {
            // Once round is nowhere.
            d[0] -= (d[0] + 0.5).floor();
        }
        d.map(|c| c * 0.5)
    };
    UvGradient {
        uv: here,
        dx: half(x),
        dy: half(y),
    }
}

/// The hash address of a query in the unit square: [`Line::texel`] with no texels.
pub(crate) fn address(line: Line, query: [i32; 3]) -> [f32; 2] {
    let p = unit(query);
    let middle = |c: f32| c * 0.5 + 0.5;
    match line {
        Line::Parallel => [middle(p[0]), middle(p[1])],
        Line::Cylinder => [round([p[0], p[1]]), middle(p[2])],
        Line::Sphere => {
            let length = (p[0].abs() + p[1].abs() + p[2].abs()).max(1e-30);
            let (a, b) = (p[0] / length, p[1] / length);
            if p[2] >= 0.0 {
                return [middle(a), middle(b)];
            }
            let fold = |side: f32, other: f32| {
                let folded = 1.0 - other.abs();
                middle(if side < 0.0 { -folded } else { folded })
            };
            [fold(a, b), fold(b, a)]
        }
    }
}

/// How far round the axis a direction lies, 0 to 1, quadrants cut evenly in the diamond |x| + |y| = 1.
fn round([x, y]: [f32; 2]) -> f32 {
    let quadrant = if x > 0.0 && y >= 0.0 {
        0.0
    } else if x <= 0.0 && y > 0.0 {
        1.0
    } else if x < 0.0 && y <= 0.0 {
        2.0
    } else {
        3.0
    };
    let (ax, ay) = (x.abs(), y.abs());
    let across = quadrant == 1.0 || quadrant == 3.0;
    let along = if across { ax } else { ay };
    (quadrant + along / (ax + ay).max(1e-30)) * 0.25
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn addresses_are_those_of_the_hash_texels() {
        let bits = 10;
        let mut seed = 7u32;
        let mut random = || {
            seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (seed >> 2) as i32 - (1 << 29)
        };
        for line in [Line::Parallel, Line::Cylinder, Line::Sphere] {
            for _ in 0..2000 {
                let query = [random(), random(), random()];
                let texel = line.texel(bits, query);
                let near = address(line, query);
                for k in 0..2 {
                    let at = near[k] * 1024.0;
                    let texel = texel[k] as f32;
                    assert!(at > texel - 0.01 && at < texel + 1.01, "{line:?} {query:?}");
                }
            }
        }
    }

    #[test]
    fn who_asks_decides() {
        let asker = |layer, side, grazed| Asker {
            layer,
            side,
            grazed,
        };
        let scope = |side| {
            scope_word(Scope {
                unlit: true,
                layer: 3,
                side,
            })
        };
        for (one, either, front) in [
            (asker(Some(3), 1, false), true, true),
            (asker(Some(3), -1, false), true, false),
            (asker(Some(3), 0, false), true, false),
            (asker(Some(2), 1, false), false, false),
            (asker(None, 1, false), false, false),
            (asker(Some(3), 1, true), false, false),
        ] {
            assert_eq!(sees(one.word(), scope(0)), either, "{one:?}");
            assert_eq!(sees(one.word(), scope(1)), front, "{one:?}");
        }
    }

    #[test]
    fn shares_fall_from_the_bound_to_twice_it() {
        let steps = |s: f32| s * CODES_A_STEP / 255.0;
        assert_eq!(share(steps(0.0), 1.0), 1.0);
        assert_eq!(share(steps(1.0), 1.0), 1.0);
        assert!((share(steps(1.5), 1.0) - 0.5).abs() < 1e-5);
        assert_eq!(share(steps(2.0), 1.0), 0.0);
        assert_eq!(share(0.0, 0.0), 0.0, "switched off");
    }
}
