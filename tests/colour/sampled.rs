//! Colour deviations at points of a triangle.

use super::{Model, spread};
use glam::{DVec2, DVec3, DVec4};
use invertex::lod::progressive::Made;
use invertex::lod::progressive::colour::{
    ColourDeviations, Colours, Distance, Picture, Shade, Wrap,
};

/// What was seen on one triangle: for each level the largest deviation at it or a coarser one.
pub(crate) struct Seen {
    pub(crate) points: usize,
    pub(crate) largest: Vec<f64>,
    /// For each level the largest change of colour an object unit on the reference below the triangle.
    pub(crate) steepest: Vec<f64>,
}

/// Samples a triangle, closer where deviations are large.
pub(crate) fn largest(
    model: &Model,
    colours: &Colours<'_>,
    deviations: &ColourDeviations,
    distance: Distance,
    made: &Made,
    points: u64,
) -> Seen {
    let sampling = Sampling::new(model, (colours, distance), deviations, made);
    let mut seen = Seen {
        points: 0,
        largest: vec![0.0; deviations.levels],
        steepest: vec![0.0; deviations.levels],
    };
    let mut best = vec![[1.0 / 3.0; 3]; deviations.levels];
    for i in 0..points {
        let (u, v) = (spread(i * 2 + 1), spread(i * 2 + 2).sqrt());
        let anywhere = [1.0 - v, v * (1.0 - u), v * u];
        // The later ones near the best so far, ever closer.
        let level = (i % deviations.levels as u64) as usize;
        let near = 0.3 * 0.02f64.powf(i as f64 / points as f64 * 2.0 - 1.0).min(1.0);
        let b = match i * 2 < points {
            true => anywhere,
            false => [0, 1, 2].map(|k| best[level][k] * (1.0 - near) + anywhere[k] * near),
        };
        let Some(shown) = model.shown(made, b) else {
            continue;
        };
        sampling.steepen(shown, i, &mut seen.steepest);
        let Some(found) = sampling.at(b, shown) else {
            continue;
        };
        seen.points += 1;
        for (k, found) in found.into_iter().enumerate() {
            if found > seen.largest[k] {
                (seen.largest[k], best[k]) = (found, b);
            }
        }
    }
    for k in (0..deviations.levels - 1).rev() {
        seen.largest[k] = seen.largest[k].max(seen.largest[k + 1]);
    }
    seen
}

/// At one point of a triangle, for each level: how much the colour of what is shown there differs from the one shown where,
/// seen along the triangle's normal, it belongs. None where the reference has no such point, or the way there leads over
/// triangles behind which others lie.
pub(crate) fn differences(
    model: &Model,
    colours: &Colours<'_>,
    deviations: &ColourDeviations,
    distance: Distance,
    (made, at): (&Made, [f64; 3]),
) -> Option<Vec<f64>> {
    let sampling = Sampling::new(model, (colours, distance), deviations, made);
    let shown = model.shown(made, at)?;
    let foot = sampling.foot(shown);
    let ambiguous = (0..=STEPS).any(|k| {
        let s = f64::from(k) / f64::from(STEPS);
        let b = [0, 1, 2].map(|k| at[k] + (foot[k] - at[k]) * s);
        model.is_ambiguous(made, b)
    });
    if ambiguous {
        None
    } else {
        sampling.at(at, shown)
    }
}

/// Points of a way that are looked at.
const STEPS: u32 = 8;

/// What the rounding of texels' places may change in a difference of colours.
const ROUNDING: f64 = 0.02;

struct Sampling<'a> {
    model: &'a Model,
    colours: &'a Colours<'a>,
    deviations: &'a ColourDeviations,
    distance: Distance,
    made: &'a Made,
    corners: [DVec3; 3],
}

impl<'a> Sampling<'a> {
    fn new(
        model: &'a Model,
        (colours, distance): (&'a Colours<'a>, Distance),
        deviations: &'a ColourDeviations,
        made: &'a Made,
    ) -> Self {
        Sampling {
            model,
            colours,
            deviations,
            distance,
            made,
            corners: made.corners.map(|v| model.position(v)),
        }
    }

    fn position(&self, t: u32, b: [f64; 3]) -> DVec3 {
        let [x, y, z] = self.model.mesh.triangles[t as usize].map(|v| self.model.position(v));
        x * b[0] + y * b[1] + z * b[2]
    }

    /// How colours change from a point of the reference towards a corner of its triangle, over a long way or a short one.
    fn steepen(&self, (t, own): (u32, [f64; 3]), i: u64, steepest: &mut [f64]) {
        let share = 0.1f64.powi((i / 3 % 4) as i32);
        let mut other = own.map(|b| b * (1.0 - share));
        other[(i % 3) as usize] += share;
        let far = self.position(t, own).distance(self.position(t, other));
        for (k, steepest) in steepest.iter_mut().enumerate() {
            let mip = self.mip(t, k);
            let change = (self.colour(t, own, mip) - self.colour(t, other, mip)).length();
            if change > ROUNDING {
                *steepest = steepest.max((change - ROUNDING) / far);
            }
        }
    }

    /// The deviations at a point of the triangle, for which a point of the reference is shown; none where nothing is at its foot.
    fn at(&self, at: [f64; 3], (t, own): (u32, [f64; 3])) -> Option<Vec<f64>> {
        let (other, shares) = self.walked(t, at, self.foot((t, own)))?;
        let at = |k: usize| {
            let mip = self.mip(t, k);
            let mine = self.colour(t, own, mip);
            (mine - self.colour(other, shares, mip)).length()
        };
        Some((0..self.deviations.levels).map(at).collect())
    }

    /// Where on the plane of the triangle the foot of the reference's point is.
    fn foot(&self, (t, own): (u32, [f64; 3])) -> [f64; 3] {
        let p = self.position(t, own);
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let share = |from: DVec3, to: DVec3| {
            normal.dot((to - from).cross(p - from)) / normal.length_squared()
        };
        [share(b, c), share(c, a), share(a, b)]
    }

    /// What is shown at the end of the straight way between two points of the plane, or what counts where the way leaves the
    /// surface.
    fn walked(&self, t: u32, from: [f64; 3], to: [f64; 3]) -> Option<(u32, [f64; 3])> {
        let at = |s: f64| {
            let b = [0, 1, 2].map(|k| from[k] + (to[k] - from[k]) * s);
            let found = self.model.shown(self.made, b)?;
            let piece = |t: u32| self.model.piece[t as usize];
            (piece(found.0) == piece(t)).then_some(found)
        };
        let steps = (1..=STEPS).map(|k| f64::from(k) / f64::from(STEPS));
        let Some(outside) = steps.clone().find(|&s| at(s).is_none()) else {
            return at(1.0);
        };
        let mut ends = [outside - 1.0 / f64::from(STEPS), outside];
        for _ in 0..24 {
            let middle = 0.5 * (ends[0] + ends[1]);
            ends[usize::from(at(middle).is_none())] = middle;
        }
        let (last, _) = at(ends[0])?;
        Some((last, self.model.clamped(self.made, to, last)?))
    }

    /// The mip in use on a triangle.
    fn mip(&self, t: u32, level: usize) -> usize {
        let Shade::Picture { picture, uv } = &self.colours.shades[t as usize] else {
            return 0;
        };
        let picture = &self.colours.pictures[*picture as usize];
        let uv = uv.map(|c| DVec2::new(f64::from(c[0]), f64::from(c[1])));
        let size = DVec2::new(f64::from(picture.size[0]), f64::from(picture.size[1]));
        let [a, b, c] = self.model.mesh.triangles[t as usize].map(|v| self.model.position(v));
        // The gradients of both coordinates over the triangle.
        let normal = (b - a).cross(c - a);
        let gradient = |values: [f64; 3]| {
            let along = (c - b) * values[0] + (a - c) * values[1] + (b - a) * values[2];
            normal.cross(along) / normal.length_squared()
        };
        let x = gradient(uv.map(|c| c.x * size.x));
        let y = gradient(uv.map(|c| c.y * size.y));
        let (xx, xy, yy) = (x.dot(x), x.dot(y), y.dot(y));
        let density = (0.5 * (xx + yy + ((xx - yy).powi(2) + 4.0 * xy * xy).sqrt())).sqrt();
        let footprint = f64::from(self.deviations.footprint) * 2f64.powi(level as i32);
        let mip = ((footprint * density).log2() + 1e-3).floor().max(0.0) as usize;
        if level == 0 {
            0
        } else {
            mip.min(picture.mips.len() - 1)
        }
    }

    fn colour(&self, t: u32, b: [f64; 3], mip: usize) -> DVec4 {
        match &self.colours.shades[t as usize] {
            Shade::Corners(corners) => {
                let place = |k: usize| self.place(corners[k].map(f64::from)) * b[k];
                place(0) + place(1) + place(2)
            }
            Shade::Picture { picture, uv } => {
                let picture = &self.colours.pictures[*picture as usize];
                let at = [0, 1].map(|i| (0..3).map(|k| f64::from(uv[k][i]) * b[k]).sum::<f64>());
                self.bilinear(picture, mip, at)
            }
        }
    }

    fn bilinear(&self, picture: &Picture<'_>, mip: usize, uv: [f64; 2]) -> DVec4 {
        let size = picture.size.map(|n| i64::from(n >> mip).max(1));
        let at = [0, 1].map(|k| uv[k] * size[k] as f64 - 0.5);
        let first = at.map(f64::floor);
        let mut sum = DVec4::ZERO;
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let by = [dx, dy];
            let [x, y] = [0, 1].map(|k| wrapped(first[k] as i64 + by[k], size[k], picture.wrap[k]));
            let weight = |k: usize| 1.0 - (at[k] - first[k] - by[k] as f64).abs();
            let [r, g, b, a] = picture.mips[mip][(y * size[0] + x) as usize].map(f64::from);
            let linear = |c: f64| {
                let c = c / 255.0;
                if c <= 0.04045 {
                    c / 12.92
                } else {
                    ((c + 0.055) / 1.055).powf(2.4)
                }
            };
            let place = match self.distance {
                Distance::Rgb => DVec4::new(r, g, b, 0.0),
                Distance::Lab => self.place([linear(r), linear(g), linear(b), a / 255.0]),
            };
            sum += place * weight(0) * weight(1);
        }
        sum
    }

    /// Of linear RGBA.
    fn place(&self, [r, g, b, _]: [f64; 4]) -> DVec4 {
        if self.distance == Distance::Rgb {
            let code = |c: f64| {
                let encoded = if c <= 0.0031308 {
                    12.92 * c
                } else {
                    1.055 * c.powf(1.0 / 2.4) - 0.055
                };
                255.0 * encoded
            };
            return DVec4::new(code(r), code(g), code(b), 0.0);
        }
        let x = (0.4124 * r + 0.3576 * g + 0.1805 * b) / 0.9505;
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        let z = (0.0193 * r + 0.1192 * g + 0.9505 * b) / 1.089;
        let f = |t: f64| {
            if t > 0.008856 {
                t.cbrt()
            } else {
                7.787 * t + 16.0 / 116.0
            }
        };
        DVec4::new(
            116.0 * f(y) - 16.0,
            500.0 * (f(x) - f(y)),
            200.0 * (f(y) - f(z)),
            0.0,
        )
    }
}

fn wrapped(i: i64, n: i64, wrap: Wrap) -> i64 {
    match wrap {
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Mirror => {
            let j = i.rem_euclid(2 * n);
            if j < n { j } else { 2 * n - 1 - j }
        }
        Wrap::Clamp => i.clamp(0, n - 1),
    }
}
