//! What is painted where: the bands of the vase, bottom to top.
//!
//! In: a point of the surface (height of the silhouette, arc length, turn) and the width of a texel there. Out: `Ink`,
//! how much of each paint covers the clay, and how deep a line is cut.

use crate::animals;
use crate::figures::{self, Brush};
use crate::ornament;
use crate::profile::Profile;
use crate::relief;
use crate::sdf;
use glam::{Vec2, vec2};

/// The paints over bare clay.
#[derive(Clone, Copy)]
pub(crate) enum Paint {
    /// Black gloss.
    Slip,
    White,
    Red,
    Gold,
    /// Nothing: the clay shows again.
    Clay,
}

/// Coverage by each paint (their sum is at most one), and cut lines.
#[derive(Clone, Copy, Default)]
pub(crate) struct Ink {
    pub(crate) slip: f32,
    pub(crate) white: f32,
    pub(crate) red: f32,
    pub(crate) gold: f32,
    pub(crate) cut: f32,
}

impl Ink {
    /// Lays paint over what is there, `cover` of the texel.
    pub(crate) fn paint(&mut self, paint: Paint, cover: f32) {
        for weight in [
            &mut self.slip,
            &mut self.white,
            &mut self.red,
            &mut self.gold,
            &mut self.cut,
        ] {
            *weight *= 1.0 - cover;
        }
        match paint {
            Paint::Slip => self.slip += cover,
            Paint::White => self.white += cover,
            Paint::Red => self.red += cover,
            Paint::Gold => self.gold += cover,
            Paint::Clay => {}
        }
    }
    /// Cuts a line through the paint.
    pub(crate) fn cut(&mut self, cover: f32) {
        self.cut = self.cut.max(cover);
    }
}

/// A sample inside one band.
struct Spot {
    turn: f64,
    /// Above the band's lower edge, object units.
    z: f32,
    /// The band's height.
    height: f32,
    /// Once round, at the band's middle.
    around: f32,
    texel: f32,
}

impl Spot {
    /// Number of the repeat, and the offset from its middle in object units.
    fn cell(&self, repeats: u32) -> (i64, Vec2) {
        let t = self.turn * f64::from(repeats);
        let x = (t - t.floor() - 0.5) as f32 * self.around / repeats as f32;
        (t.floor() as i64, vec2(x, self.z))
    }
    fn cover(&self, distance: f32) -> f32 {
        (0.5 - distance / self.texel).clamp(0.0, 1.0)
    }
    fn fill(&self, ink: &mut Ink, paint: Paint, distance: f32) {
        ink.paint(paint, self.cover(distance));
    }
    /// For figures whose unit is the band's height.
    fn brush<'a>(&self, ink: &'a mut Ink) -> Brush<'a> {
        Brush {
            ink,
            texel: self.texel / self.height,
        }
    }
    /// A line round the vase at `z`.
    fn line(&self, ink: &mut Ink, paint: Paint, z: f32, half: f32) {
        self.fill(ink, paint, (self.z - z).abs() - half);
    }
}

type Motif = fn(&Spot, &mut Ink);

/// (from height, motif): each band ends where the next begins.
const BANDS: [(f64, Motif); 17] = [
    (0.000, underside),
    (0.052, foot),
    (0.284, rays),
    (0.586, lines),
    (0.602, key),
    (0.684, lines),
    (0.700, ships),
    (1.098, lines),
    (1.114, braid),
    (1.148, lines),
    (1.164, animals),
    (1.330, tongues),
    (1.478, collar),
    (1.545, palmettes),
    (1.785, lip),
    (1.904, lid),
    (2.072, bud),
];

/// Paint at a point of the surface.
pub(crate) fn ink(profile: &Profile, s: f64, turn: f64, texel: f64) -> Ink {
    let height = profile.at(s).height;
    let band = BANDS.iter().rposition(|b| b.0 <= height).unwrap_or(0);
    let from = profile.s_of_height(BANDS[band].0);
    let to = BANDS
        .get(band + 1)
        .map_or(profile.total(), |next| profile.s_of_height(next.0));
    let around = std::f64::consts::TAU * profile.at(0.5 * (from + to)).radius;
    let spot = Spot {
        turn,
        z: (s - from) as f32,
        height: (to - from) as f32,
        around: around as f32,
        texel: texel as f32,
    };
    let mut ink = Ink::default();
    BANDS[band].1(&spot, &mut ink);
    ink
}

fn underside(spot: &Spot, ink: &mut Ink) {
    for z in [0.06, 0.075, 0.20, 0.24] {
        spot.line(ink, Paint::Slip, z, 0.004);
    }
}

fn foot(spot: &Spot, ink: &mut Ink) {
    ink.paint(Paint::Slip, 1.0);
    spot.line(ink, Paint::Clay, 0.012, 0.012);
    spot.line(ink, Paint::Red, spot.height - 0.026, 0.014);
    spot.line(ink, Paint::Red, 0.080, 0.0035);
}

fn rays(spot: &Spot, ink: &mut Ink) {
    spot.line(ink, Paint::Slip, 0.006, 0.006);
    let (_, p) = spot.cell(relief::LOBES);
    // The cell's width grows upwards; a ray follows its lobe, so its foot is narrow in truth.
    let half = 0.40 * spot.around / relief::LOBES as f32;
    spot.fill(
        ink,
        Paint::Slip,
        ornament::ray(p - vec2(0.0, 0.03), half, spot.height * 0.80),
    );
    let (_, between) = Spot {
        turn: spot.turn + 0.5 / f64::from(relief::LOBES),
        ..*spot
    }
    .cell(relief::LOBES);
    let leaf = ornament::ray(
        vec2(between.x, spot.height * 0.97 - between.y),
        half * 0.42,
        spot.height * 0.36,
    );
    spot.fill(ink, Paint::Red, leaf);
    spot.fill(
        ink,
        Paint::Slip,
        sdf::circle(p, vec2(0.0, spot.height * 0.885), 0.0085),
    );
}

fn lines(spot: &Spot, ink: &mut Ink) {
    spot.line(ink, Paint::Slip, spot.height * 0.5, spot.height * 0.32);
    spot.line(ink, Paint::Red, spot.height * 0.5, spot.height * 0.13);
}

fn key(spot: &Spot, ink: &mut Ink) {
    const REPEATS: u32 = 48;
    let (_, p) = spot.cell(REPEATS);
    let unit = spot.around / REPEATS as f32 / 6.0;
    let q = vec2(p.x / unit + 3.0, (p.y - 0.5 * spot.height) / unit + 3.0);
    spot.fill(ink, Paint::Slip, ornament::meander(q) * unit);
}

/// Four ships, dolphins between them, the sea below.
fn ships(spot: &Spot, ink: &mut Ink) {
    const SHIPS: u32 = 4;
    let (_, p) = spot.cell(SHIPS);
    let p = p / spot.height;
    let width = spot.around / SHIPS as f32 / spot.height;
    figures::sea(
        vec2((spot.turn * 80.0).fract() as f32 * 0.108, p.y),
        spot.brush(ink),
    );
    if p.x.abs() < 1.0 {
        figures::ship(p, spot.brush(ink));
    }
    // Leaping over the gap between two ships, one up, one down.
    let gap = vec2(
        if p.x > 0.0 {
            p.x - width * 0.5
        } else {
            p.x + width * 0.5
        },
        p.y,
    );
    for (centre, cos, sin) in [
        (vec2(-0.02, 0.76), 0.94, 0.34),
        (vec2(-0.05, 0.48), 0.97, -0.24),
    ] {
        let local = sdf::turn(gap - centre, cos, sin);
        if local.x.abs() < 0.33 && local.y.abs() < 0.22 {
            figures::dolphin(local, spot.brush(ink));
        }
    }
    for star in [
        vec2(-0.16, 0.90),
        vec2(0.22, 0.92),
        vec2(0.24, 0.62),
        vec2(0.06, 0.30),
    ] {
        spot.fill(
            ink,
            Paint::Slip,
            ornament::rosette((gap - star) / 0.036) * 0.036 * spot.height,
        );
    }
}

fn braid(spot: &Spot, ink: &mut Ink) {
    const REPEATS: u32 = 64;
    let (_, p) = spot.cell(REPEATS);
    let unit = 0.5 * spot.around / REPEATS as f32;
    let q = vec2(
        p.x / unit,
        (p.y - 0.5 * spot.height) / (0.5 * spot.height) * 0.96,
    );
    ink.paint(Paint::Slip, 1.0);
    spot.fill(
        ink,
        Paint::Clay,
        ornament::guilloche(q) * unit.min(0.5 * spot.height),
    );
}

/// Goats and swans in turn, rosettes between them.
fn animals(spot: &Spot, ink: &mut Ink) {
    const FIGURES: u32 = 12;
    let (number, p) = spot.cell(FIGURES);
    let p = p / spot.height;
    let width = spot.around / FIGURES as f32 / spot.height;
    let gap = vec2(
        if p.x > 0.0 {
            p.x - width * 0.5
        } else {
            p.x + width * 0.5
        },
        p.y,
    );
    for (star, size) in [
        (vec2(0.02, 0.52), 0.080),
        (vec2(-0.02, 0.20), 0.055),
        (vec2(0.05, 0.86), 0.055),
    ] {
        spot.fill(
            ink,
            Paint::Slip,
            ornament::rosette((gap - star) / size) * size * spot.height,
        );
    }
    if number % 2 == 0 {
        animals::goat(p, spot.brush(ink));
    } else {
        animals::swan(p, spot.brush(ink));
    }
}

fn tongues(spot: &Spot, ink: &mut Ink) {
    let (number, p) = spot.cell(relief::TONGUES);
    // The shoulder narrows upwards while the cell is measured at its middle; the tongue narrows with it.
    let half = 0.5 * spot.around / relief::TONGUES as f32;
    let low = vec2(0.0, 0.052);
    let shape = sdf::taper(
        p,
        low,
        vec2(0.0, spot.height + 0.02),
        half * 0.80,
        half * 0.80,
    );
    spot.fill(ink, Paint::Slip, shape);
    if number % 2 == 0 {
        spot.fill(ink, Paint::Red, shape + half * 0.34);
    } else {
        spot.fill(ink, Paint::White, (shape + half * 0.42).abs() - 0.0016);
    }
    let (_, between) = Spot {
        turn: spot.turn + 0.5 / f64::from(relief::TONGUES),
        ..*spot
    }
    .cell(relief::TONGUES);
    spot.fill(
        ink,
        Paint::Slip,
        sdf::circle(between, vec2(0.0, 0.022), 0.0065),
    );
}

fn collar(spot: &Spot, ink: &mut Ink) {
    ink.paint(Paint::Slip, 1.0);
    let (_, p) = spot.cell(relief::BEADS);
    spot.fill(ink, Paint::Red, sdf::circle(p, vec2(0.0, 0.026), 0.0095));
    spot.line(ink, Paint::Clay, spot.height - 0.010, 0.003);
}

/// The neck is black; its palmettes are left in the colour of the clay.
fn palmettes(spot: &Spot, ink: &mut Ink) {
    const REPEATS: u32 = 7;
    ink.paint(Paint::Slip, 1.0);
    let (_, p) = spot.cell(REPEATS);
    let scale = spot.height * 0.74;
    let width = spot.around / REPEATS as f32 / scale;
    let q = vec2(p.x, p.y - spot.height * 0.13) / scale;
    spot.fill(
        ink,
        Paint::Clay,
        ornament::palmette(q).min(ornament::tendril(q, width)) * scale,
    );
    spot.fill(
        ink,
        Paint::Red,
        sdf::ellipse(q, vec2(0.0, 0.30), vec2(0.055, 0.048)) * scale,
    );
    for z in [0.040, 0.965] {
        spot.line(ink, Paint::Clay, spot.height * z, 0.0026);
    }
}

fn lip(spot: &Spot, ink: &mut Ink) {
    ink.paint(Paint::Slip, 1.0);
    let (_, p) = spot.cell(44);
    let middle = spot.height * 0.60;
    spot.fill(ink, Paint::White, sdf::circle(p, vec2(0.0, middle), 0.0075));
    for z in [-0.024, 0.024] {
        spot.line(ink, Paint::Red, middle + z, 0.0042);
    }
}

fn lid(spot: &Spot, ink: &mut Ink) {
    const SCROLLS: u32 = 24;
    let (number, lobe) = spot.cell(relief::LID_LOBES);
    let (_, p) = spot.cell(SCROLLS);
    let rim = 0.052;
    // Measured at the lid's middle; at the rim a turn is longer by this much.
    let wide = 1.45;
    let scale = rim * 0.92;
    let q = vec2(p.x * wide, p.y - 0.004) / scale;
    spot.fill(
        ink,
        Paint::Slip,
        ornament::scroll(q, spot.around * wide / SCROLLS as f32 / scale) * scale,
    );
    spot.fill(ink, Paint::Clay, 0.94 * scale - (spot.z - 0.008));
    let half = 0.40 * spot.around / relief::LID_LOBES as f32;
    let petal = sdf::taper(
        lobe,
        vec2(0.0, rim + 0.030),
        vec2(0.0, spot.height + 0.02),
        half,
        half * 0.9,
    );
    spot.line(ink, Paint::Slip, rim + 0.004, 0.003);
    spot.fill(ink, Paint::Slip, petal);
    if number % 2 == 0 {
        spot.fill(ink, Paint::Red, petal + 0.010);
    }
}

fn bud(spot: &Spot, ink: &mut Ink) {
    ink.paint(Paint::Gold, 1.0);
    spot.line(ink, Paint::Slip, 0.0, 0.014);
}
