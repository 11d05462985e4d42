//! The largest distance of two colours that vary over a polygon: branch and bound.
//!
//! In: two functions ([`Side`]) and a polygon over whose corners the places where they are asked vary: linearly for the first,
//! as quotients of linear functions for the second. Out: [`Search`], whose `upper` no point of any polygon it was shown exceeds,
//! and whose `lower` is reached.
//!
//! | a polygon lies in | bound |
//! |---|---|
//! | several patches of either | the farthest colours of the two rectangles; the way between both places times the slope there |
//! | one patch of each | the difference is a quadratic function: no larger than its values at pairs of corners |
//!
//! Those that might hold more than what is found already are cut along the middle line between texels, then in halves.

use super::palette::Side;
use super::polygon::Polygon;

/// A bound may exceed what is reached by this factor.
const SLACK: f32 = 1.03;
/// Polygons that a search may look at before it takes bounds as they are.
const PATIENCE: u32 = 60_000;
/// What rounding in the arithmetic of colours may take away.
pub(super) const ROUNDING: f32 = 1e-3;

/// Two places in texels: x and y of the first; x, y and weight of the second.
pub(super) type Pair = Polygon<5>;

/// What is known of a maximum.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// It is reached.
    pub(super) lower: f32,
    /// It is not exceeded.
    pub(super) upper: f32,
    floor: f32,
    left: u32,
}

/// What a polygon was found to be.
struct Found {
    upper: f32,
    lower: f32,
    /// Where to cut it: which coordinate, at which value.
    cut: (usize, f64),
}

impl Search {
    /// Below `floor` it does not matter what the maximum is.
    pub(super) fn new(floor: f32) -> Search {
        Search {
            lower: 0.0,
            upper: 0.0,
            floor,
            left: PATIENCE,
        }
    }

    /// A search of its own, for which what this one found is enough; it looks at so many polygons.
    pub(super) fn afresh(&self, left: u32) -> Search {
        Search {
            upper: 0.0,
            left,
            ..*self
        }
    }

    /// Bounds up to this are good enough.
    pub(super) fn enough(&self) -> f32 {
        (self.lower * SLACK).max(self.floor)
    }

    /// Something is no larger than this.
    pub(super) fn settle(&mut self, upper: f32) {
        if upper > 0.0 {
            self.upper = self.upper.max(upper + ROUNDING);
        }
    }

    /// Something is as large as this.
    pub(super) fn reach(&mut self, lower: f32) {
        self.lower = self.lower.max(lower);
    }

    /// Takes all points of a polygon into account.
    pub(super) fn look_at(&mut self, sides: [Side<'_>; 2], polygon: Pair) {
        let (mut polygon, mut waiting) = (polygon, Vec::new());
        loop {
            let next = match self.halves(sides, &polygon) {
                Some([first, second]) => {
                    waiting.push(second);
                    Some(first)
                }
                None => waiting.pop(),
            };
            match next {
                Some(next) => polygon = next,
                None => return,
            }
        }
    }

    /// Settles a polygon, or cuts it.
    fn halves(&mut self, sides: [Side<'_>; 2], polygon: &Pair) -> Option<[Pair; 2]> {
        if polygon.is_empty() {
            return None;
        }
        let found = look(sides, polygon);
        self.reach(found.lower);
        if found.upper <= self.enough() || self.left == 0 {
            self.settle(found.upper);
            return None;
        }
        self.left -= 1;
        let (k, at) = found.cut;
        Some(polygon.halves(|c| match k {
            0 | 1 => c[k] - at,
            _ => c[k] - at * c[4],
        }))
    }
}

/// The least and the largest value of each coordinate, and of the weight.
struct Box5 {
    low: [f64; 4],
    high: [f64; 4],
    weight: [f64; 2],
}

impl Box5 {
    fn new(polygon: &Pair) -> Box5 {
        let mut all = Box5 {
            low: [f64::INFINITY; 4],
            high: [f64::NEG_INFINITY; 4],
            weight: [f64::INFINITY, 0.0],
        };
        for c in polygon.corners() {
            let values = [c[0], c[1], c[2] / c[4], c[3] / c[4]];
            for k in 0..4 {
                all.low[k] = all.low[k].min(values[k]);
                all.high[k] = all.high[k].max(values[k]);
            }
            all.weight = [all.weight[0].min(c[4]), all.weight[1].max(c[4])];
        }
        all
    }

    fn of(&self, side: usize) -> ([f64; 2], [f64; 2]) {
        let k = side * 2;
        (
            [self.low[k], self.low[k + 1]],
            [self.high[k], self.high[k + 1]],
        )
    }

    /// How far weights move a mean of the second's places from where it would be without them: for weights that differ by a
    /// factor k, a mean of two values at a distance d moves by no more than d (k - 1) / 4.
    fn moved(&self) -> [f64; 2] {
        let by = 0.25 * (self.weight[1] / self.weight[0] - 1.0);
        [2, 3].map(|k| (self.high[k] - self.low[k]) * by)
    }
}

fn look(sides: [Side<'_>; 2], polygon: &Pair) -> Found {
    let reach = Box5::new(polygon);
    if reach.weight[0] <= 0.0 {
        // A corner at infinity, by rounding.
        return Found {
            upper: f32::INFINITY,
            lower: 0.0,
            cut: widest(&reach),
        };
    }
    let patches = [0, 1].map(|s| {
        let (low, high) = reach.of(s);
        sides[s].patches(low, high)
    });
    let lines = |k: usize| {
        let [first, last] = patches[k / 2][k % 2];
        (last - first, first)
    };
    let most = (0..4).max_by_key(|&k| lines(k).0).unwrap_or(0);
    let (count, first) = lines(most);
    if count == 0 {
        return within(sides, polygon, &reach, patches.map(|p| p.map(|run| run[0])));
    }
    Found {
        upper: over_many(sides, polygon, &reach, patches),
        lower: 0.0,
        cut: (most, (first + (count + 1) / 2) as f64),
    }
}

/// The coordinate that varies most, and its middle.
fn widest(reach: &Box5) -> (usize, f64) {
    let width = |k: &usize| reach.high[*k] - reach.low[*k];
    let most = (0..4)
        .max_by(|a, b| width(a).total_cmp(&width(b)))
        .unwrap_or(0);
    (most, 0.5 * (reach.low[most] + reach.high[most]))
}

/// In one patch of each: the first texels of both are given.
fn within(sides: [Side<'_>; 2], polygon: &Pair, reach: &Box5, at: [[i64; 2]; 2]) -> Found {
    let patches = [0, 1].map(|s| sides[s].patch(at[s][0], at[s][1]));
    let origin = |s: usize| match sides[s] {
        Side::Texels(_) => at[s].map(|i| i as f64),
        Side::Corners(_) => [0.0; 2],
    };
    let (a, b) = (origin(0), origin(1));
    let mut places = [([0f32; 2], [0f32; 2]); 12];
    let corners = polygon.corners();
    for (place, c) in places.iter_mut().zip(corners) {
        let first = [(c[0] - a[0]) as f32, (c[1] - a[1]) as f32];
        let second = [(c[2] / c[4] - b[0]) as f32, (c[3] / c[4] - b[1]) as f32];
        *place = (first, second);
    }
    let places = &places[..corners.len()];
    let difference = |i: usize, j: usize| {
        let (p, q) = (places[i], places[j]);
        (patches[0].between(p.0, q.0) - patches[1].between(p.1, q.1)).length_squared()
    };
    let (mut lower, mut between) = (0f32, 0f32);
    for i in 0..places.len() {
        lower = lower.max(difference(i, i));
        between = between.max(difference(i, (i + 1) % places.len()));
        // A fan of triangles from the first corner covers the polygon.
        if i > 1 && i + 1 < places.len() {
            between = between.max(difference(0, i));
        }
    }
    let moved = reach.moved();
    let steep = |along: glam::Vec4| along.length() + patches[1].xy.length();
    let more = steep(patches[1].x) * moved[0] as f32 + steep(patches[1].y) * moved[1] as f32;
    Found {
        upper: lower.max(between).sqrt() + more,
        lower: lower.sqrt(),
        cut: widest(reach),
    }
}

/// In many patches.
fn over_many(
    sides: [Side<'_>; 2],
    polygon: &Pair,
    reach: &Box5,
    patches: [super::field::Patches; 2],
) -> f32 {
    let summary = |s: usize| {
        let (low, high) = reach.of(s);
        sides[s].summary(patches[s], low, high)
    };
    if !sides[0].is_smooth_with(&sides[1]) {
        return summary(0).farthest(&summary(1));
    }
    let both = [0, 1].map(|k| {
        let [a, b] = [patches[0][k], patches[1][k]];
        [a[0].min(b[0]), a[1].max(b[1])]
    });
    let count = |p: &super::field::Patches| (p[0][1] - p[0][0] + 1) * (p[1][1] - p[1][0] + 1);
    if count(&both) > 4 * (count(&patches[0]) + count(&patches[1])) {
        return summary(0).farthest(&summary(1));
    }
    let (low, high) = reach.of(0);
    let known = sides[0].summary(both, low, high);
    let moved = reach.moved();
    let along = [0, 1].map(|k| {
        let way = |c: &[f64; 5]| (c[2 + k] / c[4] - c[k]).abs();
        polygon.corners().iter().map(way).fold(0.0, f64::max) + moved[k]
    });
    let by_way = known.slope[0] * along[0] as f32 + known.slope[1] * along[1] as f32;
    known.farthest(&known).min(by_way)
}
