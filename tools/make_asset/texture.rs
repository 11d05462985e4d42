//! Texels: what the paint of `bands` looks like as base colour, roughness, metal, occlusion and height.
//!
//! In: surface and atlas. Out: three JPEG files: colour (sRGB, 2048), occlusion/roughness/metallic and tangent-space
//! normal (1024). Every texel of a chart's rectangle, gutter included, is evaluated where it lies on the vase.

use crate::atlas::{Atlas, Chart};
use crate::bands::{self, Ink};
use crate::noise;
use crate::relief;
use crate::surface::Surface;
use glam::{DVec2, Vec3, vec3};
use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder};
use rayon::prelude::*;

pub(crate) const COLOUR_TEXELS: usize = 2048;
/// Side of the normal map, and of the occlusion/roughness/metal map.
const NORMAL_TEXELS: usize = COLOUR_TEXELS / 2;
const SURFACE_TEXELS: usize = COLOUR_TEXELS / 4;

pub(crate) struct Images {
    pub(crate) colour: Vec<u8>,
    pub(crate) surface: Vec<u8>,
    pub(crate) normal: Vec<u8>,
}

#[derive(Clone, Copy)]
struct Texel {
    /// Base colour as sRGB numbers, 0 to 1.
    colour: Vec3,
    /// Occlusion, roughness, metallic.
    surface: Vec3,
    /// Height of the fine relief, object units.
    height: f32,
}

const CLAY: Vec3 = vec3(0.825, 0.495, 0.290);
const SLIP: Vec3 = vec3(0.098, 0.082, 0.076);
const SLIP_THIN: Vec3 = vec3(0.300, 0.150, 0.090);
const WHITE: Vec3 = vec3(0.905, 0.850, 0.735);
const RED: Vec3 = vec3(0.470, 0.125, 0.105);
const GOLD: Vec3 = vec3(0.930, 0.730, 0.380);
const BARE: Texel = Texel {
    colour: CLAY,
    surface: vec3(1.0, 0.8, 0.0),
    height: 0.0,
};

fn ramp(a: f32, b: f32, x: f32) -> f32 {
    let t = ((x - a) / (b - a)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Age: what three thousand years did. Coverage of worn spots, and of the crackle's lines.
struct Age {
    worn: f32,
    crackle: f32,
    mottle: f32,
    grain: f32,
    streak: f32,
}

fn age(p: Vec3, normal: Vec3, height: f64) -> Age {
    let warp = Vec3::splat(noise::value(p * 9.0, 40)) * 0.35;
    let (coarse, own) = noise::crack(p * 13.0 + warp, normal, 3);
    let (fine, _) = noise::crack(p * 31.0 + warp, normal, 17);
    // A third of the coarse cells' borders never cracked.
    let coarse = if own < 0.34 { 1.0 } else { coarse };
    let crackle = (1.0 - ramp(0.008, 0.030, coarse)).max(0.50 * (1.0 - ramp(0.012, 0.050, fine)));
    let edges: f32 = [0.060, 0.268, 1.868, 1.50]
        .iter()
        .map(|e| 1.0 - ramp(0.0, 0.03, (height as f32 - e).abs()))
        .sum();
    let chips = noise::fractal(p * 22.0, 60);
    let worn = ramp(0.735 - 0.135 * edges, 0.775 - 0.135 * edges, chips);
    let low = (p.y * 900.0).max(-1e6);
    let swirl = vec3(p.x * 3.0, low * 0.12, p.z * 3.0);
    Age {
        worn,
        crackle: crackle * ramp(0.30, 0.62, noise::value(p * 3.1, 90)),
        mottle: noise::fractal(p * 4.0, 5) - 0.5,
        grain: noise::value(p * 210.0, 8) - 0.5,
        streak: noise::value(swirl, 12) - 0.5,
    }
}

/// Normal of the silhouette turned to where p is: the relief is left out.
fn upright(surface: &Surface, s: f64, p: Vec3) -> Vec3 {
    let (low, high) = (surface.profile.at(s - 2e-3), surface.profile.at(s + 2e-3));
    let outward = vec3(p.x, 0.0, p.z).normalize_or_zero();
    (outward * (high.height - low.height) as f32 - Vec3::Y * (high.radius - low.radius) as f32)
        .normalize_or(Vec3::Y)
}

fn mix(a: Vec3, b: Vec3, t: f32) -> Vec3 {
    a + (b - a) * t
}

/// Light that the grooves of the geometric relief keep out.
fn groove(height: f64, turn: f64) -> f32 {
    let shade = |lobe: f64, depth: f32| 1.0 - depth * (1.0 - ramp(0.0, 0.75, lobe as f32));
    match height {
        h if (0.31..0.57).contains(&h) => shade(relief::lobe(turn, relief::LOBES), 0.55),
        h if (1.36..1.475).contains(&h) => shade(relief::lobe(turn, relief::TONGUES), 0.40),
        h if (1.485..1.52).contains(&h) => shade(relief::lobe(turn, relief::BEADS), 0.50),
        h if (1.93..2.05).contains(&h) => shade(relief::lobe(turn, relief::LID_LOBES), 0.45),
        _ => 1.0,
    }
}

fn look(ink: &Ink, age: &Age, occlusion: f32) -> Texel {
    let keep = 1.0 - age.worn;
    let (slip, white) = (ink.slip * keep, ink.white * keep);
    let (red, gold) = (ink.red * keep, ink.gold * (1.0 - 0.5 * age.worn));
    let clay = CLAY * (1.0 + 0.26 * age.mottle + 0.02 * age.grain + 0.06 * age.streak);
    let clay = mix(
        clay,
        clay * vec3(0.86, 0.80, 0.74),
        ramp(0.1, 0.4, age.mottle),
    );
    let thin = ramp(0.16, 0.42, age.mottle + 0.45 * age.streak);
    let mut colour = clay * (1.0 - slip - white - red - gold).max(0.0);
    colour += mix(SLIP, SLIP_THIN, 0.75 * thin) * slip;
    colour += WHITE * (1.0 + 0.16 * age.mottle + 0.06 * age.streak) * white;
    colour += RED * (1.0 + 0.35 * age.mottle) * red;
    colour += GOLD * (1.0 + 0.15 * age.mottle) * gold;
    colour = mix(colour, clay * 1.10, 0.92 * ink.cut);
    // Dirt sits in the cracks of what is light; clay shows through those of what is dark.
    let dark = slip + 0.6 * red;
    colour = mix(
        colour,
        mix(clay * 0.38, clay * 0.80, dark),
        0.55 * age.crackle * (1.0 - gold),
    );
    colour *= 0.80 + 0.20 * occlusion;
    let mut rough = 0.80 * (1.0 - slip - white - red - gold).max(0.0) + (0.30 + 0.22 * thin) * slip;
    rough += 0.62 * white + 0.50 * red + 0.32 * gold;
    rough += 0.10 * age.streak + 0.25 * age.crackle + 0.3 * ink.cut;
    let paint = 0.00035 * slip + 0.00060 * white + 0.00050 * red;
    let height = paint - 0.00085 * ink.cut - 0.00080 * age.crackle - 0.00030 * age.worn
        + 0.00016 * age.grain
        + 0.00050 * age.streak * (0.4 + 0.6 * slip);
    Texel {
        colour: colour.clamp(Vec3::ZERO, Vec3::ONE),
        surface: vec3(occlusion, rough.clamp(0.12, 1.0), gold),
        height,
    }
}

fn texel(surface: &Surface, atlas: &Atlas, chart: &Chart, at: DVec2) -> Texel {
    let profile = surface.profile;
    let (s, turn) = atlas.surface(profile, chart, at);
    let s = s.clamp(0.0, profile.total());
    let p = surface.position(s, turn).as_vec3();
    let height = profile.at(s).height;
    // A painter's hand is not a ruler.
    let hand = f64::from(noise::value(p * 7.0, 70) - 0.5) * 0.0034;
    let radius = profile.at(s).radius.max(0.02);
    let sideways =
        f64::from(noise::value(p * 7.0, 71) - 0.5) * 0.0040 / (radius * std::f64::consts::TAU);
    let ink = bands::ink(
        profile,
        (s + hand).clamp(0.0, profile.total()),
        turn + sideways,
        atlas.texel_width(chart),
    );
    look(
        &ink,
        &age(p, upright(surface, s, p), height),
        groove(height, turn - turn.floor()),
    )
}

fn paint_texels(surface: &Surface, atlas: &Atlas) -> Vec<Texel> {
    let mut texels = vec![BARE; COLOUR_TEXELS * COLOUR_TEXELS];
    let rectangles: Vec<_> = atlas
        .charts
        .iter()
        .map(|c| (c, atlas.rectangle(c)))
        .collect();
    texels
        .par_chunks_mut(COLOUR_TEXELS)
        .enumerate()
        .for_each(|(y, row)| {
            for &(chart, (x0, y0, width, height)) in &rectangles {
                if !(y0..y0 + height).contains(&y) {
                    continue;
                }
                for (x, slot) in row.iter_mut().enumerate().skip(x0).take(width) {
                    *slot = texel(
                        surface,
                        atlas,
                        chart,
                        DVec2::new(x as f64 + 0.5, y as f64 + 0.5),
                    );
                }
            }
        });
    texels
}

/// Density of the chart a texel belongs to, for turning height differences into slopes.
fn densities(atlas: &Atlas) -> Vec<f32> {
    let mut map = vec![0.0; COLOUR_TEXELS * COLOUR_TEXELS];
    for chart in &atlas.charts {
        let (x0, y0, width, height) = atlas.rectangle(chart);
        for y in y0..y0 + height {
            map[y * COLOUR_TEXELS + x0..y * COLOUR_TEXELS + x0 + width]
                .fill(1.0 / atlas.texel_width(chart) as f32);
        }
    }
    map
}

fn byte(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

fn encode(rgb: &[u8], size: usize, quality: u8) -> Vec<u8> {
    let mut jpeg = Vec::new();
    JpegEncoder::new_with_quality(&mut jpeg, quality)
        .write_image(rgb, size as u32, size as u32, ExtendedColorType::Rgb8)
        .expect("an image of the right length goes into memory");
    jpeg
}

/// Averages a value over the texels under each texel of a smaller image.
fn shrink(size: usize, value: impl Fn(usize, usize) -> Vec3 + Sync) -> Vec<Vec3> {
    let step = COLOUR_TEXELS / size;
    let average = |i: usize| {
        let (x0, y0) = (step * (i % size), step * (i / size));
        let sum: Vec3 = (0..step * step)
            .map(|k| value(x0 + k % step, y0 + k / step))
            .sum();
        sum / (step * step) as f32
    };
    (0..size * size).into_par_iter().map(average).collect()
}

fn bytes(pixels: &[Vec3], tone: impl Fn(Vec3) -> Vec3) -> Vec<u8> {
    pixels
        .iter()
        .flat_map(|&p| tone(p).to_array().map(byte))
        .collect()
}

/// Paints and encodes all three images.
pub(crate) fn paint(surface: &Surface, atlas: &Atlas) -> Images {
    let texels = paint_texels(surface, atlas);
    let density = densities(atlas);
    let at = |x: usize, y: usize| {
        &texels[y.min(COLOUR_TEXELS - 1) * COLOUR_TEXELS + x.min(COLOUR_TEXELS - 1)]
    };
    // Normals: slopes along u and along "up" (falling v), whichever way the chart lies.
    let slope = |x: usize, y: usize| {
        let k = density[y * COLOUR_TEXELS + x] * 0.5;
        let du = at(x + 1, y).height - at(x.saturating_sub(1), y).height;
        let dup = at(x, y.saturating_sub(1)).height - at(x, y + 1).height;
        vec3(-du * k, -dup * k, 1.0).clamp(Vec3::splat(-1.2), Vec3::ONE)
    };
    let normal = shrink(NORMAL_TEXELS, slope);
    let surfaces = shrink(SURFACE_TEXELS, |x, y| at(x, y).surface);
    let colour: Vec<Vec3> = texels.iter().map(|t| t.colour).collect();
    Images {
        colour: encode(&bytes(&colour, |c| c), COLOUR_TEXELS, 66),
        surface: encode(&bytes(&surfaces, |c| c), SURFACE_TEXELS, 80),
        normal: encode(
            &bytes(&normal, |n| n.normalize() * 0.5 + 0.5),
            NORMAL_TEXELS,
            82,
        ),
    }
}
