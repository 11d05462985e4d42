//! One mip of a picture as a function of the plane: its texels' places in a colour space, bilinear between their middles.
//!
//! In: texels. Out: [`Field`], which knows of every rectangle how far its colours reach and how fast they change, without
//! looking at all texels: a pyramid of blocks, each [`SIDE`] times as large as those below it.
//!
//! Coordinates are texels: between the middles of texels i and i + 1 lies *patch* i, one bilinear function.

use super::Wrap;
use glam::Vec4;
use rayon::prelude::*;

/// Patches along a block's side, and blocks along the side of one above them.
const SIDE: i64 = 4;

/// A bilinear function: `c + x X + y Y + x y XY`.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Patch {
    pub(super) c: Vec4,
    pub(super) x: Vec4,
    pub(super) y: Vec4,
    pub(super) xy: Vec4,
}

/// What a patch's function is made of at the middle between two points: symmetric, linear in each, and at one point twice
/// the function itself. So its values at pairs of a polygon's corners bound the function over the polygon.
impl Patch {
    pub(super) fn between(&self, p: [f32; 2], q: [f32; 2]) -> Vec4 {
        self.c
            + self.x * (0.5 * (p[0] + q[0]))
            + self.y * (0.5 * (p[1] + q[1]))
            + self.xy * (0.5 * (p[0] * q[1] + p[1] * q[0]))
    }
}

/// What is known of a rectangle of patches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Summary {
    /// Least and largest coordinates of its colours.
    pub(super) low: Vec4,
    pub(super) high: Vec4,
    /// The largest change a texel, along x and along y.
    pub(super) slope: [f32; 2],
}

impl Summary {
    pub(super) const NOTHING: Summary = Summary {
        low: Vec4::INFINITY,
        high: Vec4::NEG_INFINITY,
        slope: [0.0; 2],
    };

    pub(super) fn with(self, other: &Summary) -> Summary {
        Summary {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            slope: [0, 1].map(|k| self.slope[k].max(other.slope[k])),
        }
    }

    pub(super) fn with_colour(self, colour: Vec4) -> Summary {
        Summary {
            low: self.low.min(colour),
            high: self.high.max(colour),
            ..self
        }
    }

    /// No colour of one is farther from one of the other.
    pub(super) fn farthest(&self, other: &Summary) -> f32 {
        (self.high - other.low)
            .max(other.high - self.low)
            .max(Vec4::ZERO)
            .length()
    }
}

/// A rectangle of patches: the first and the last along each axis.
pub(super) type Patches = [[i64; 2]; 2];

/// A mip.
#[derive(Debug)]
pub(super) struct Field {
    pub(super) size: [i64; 2],
    wrap: [Wrap; 2],
    pub(super) nearest: bool,
    texels: Vec<[i16; 4]>,
    /// What a step of the stored places is.
    unit: f32,
    /// From small ones to one that holds everything.
    blocks: Vec<Blocks>,
    pub(super) whole: Summary,
}

#[derive(Debug)]
struct Blocks {
    /// Patches along a block's side.
    side: i64,
    size: [i64; 2],
    of: Vec<Summary>,
}

impl Field {
    /// A mip of `size` texels, row by row, at places in steps of `unit`.
    pub(super) fn new(
        size: [u32; 2],
        wrap: [Wrap; 2],
        nearest: bool,
        texels: Vec<[i16; 4]>,
        unit: f32,
    ) -> Field {
        let mut field = Field {
            size: size.map(i64::from),
            wrap,
            nearest,
            texels,
            unit,
            blocks: Vec::new(),
            whole: Summary::NOTHING,
        };
        while field.blocks.last().is_none_or(|b| b.size != [1, 1]) {
            let next = field.next_blocks();
            field.blocks.push(next);
        }
        let top = field.blocks.last().and_then(|b| b.of.first());
        field.whole = top.copied().unwrap_or(Summary::NOTHING);
        field
    }

    /// The blocks above those that there are.
    fn next_blocks(&self) -> Blocks {
        let below = self.blocks.last();
        let (side, size) = below.map_or((1, self.size), |b| (b.side, b.size));
        let fewer = size.map(|n| (n + SIDE - 1) / SIDE);
        let block = |i: i64| {
            let at = [i % fewer[0], i / fewer[0]];
            let within = [0, 1].map(|k| [at[k] * SIDE, (at[k] * SIDE + SIDE).min(size[k]) - 1]);
            match below {
                Some(below) => below.summary(within),
                None => self.of_texels(within),
            }
        };
        Blocks {
            side: side * SIDE,
            size: fewer,
            of: (0..fewer[0] * fewer[1])
                .into_par_iter()
                .map(block)
                .collect(),
        }
    }

    /// From coordinates that run from 0 to 1 over the picture to texels.
    pub(super) fn scale(&self) -> ([f64; 2], f64) {
        let shift = if self.nearest { 0.0 } else { 0.5 };
        (self.size.map(|n| n as f64), shift)
    }

    pub(super) fn patch(&self, x: i64, y: i64) -> Patch {
        if self.nearest {
            return Patch {
                c: self.texel(x, y),
                ..Patch::default()
            };
        }
        self.smooth_patch(x, y)
    }

    /// The patch, even where texels are not blended.
    pub(super) fn smooth_patch(&self, x: i64, y: i64) -> Patch {
        let texel = |i: i64, j: i64| self.texel(x + i, y + j);
        let c = texel(0, 0);
        let (right, below, both) = (texel(1, 0), texel(0, 1), texel(1, 1));
        Patch {
            c,
            x: right - c,
            y: below - c,
            xy: both - right - below + c,
        }
    }

    fn texel(&self, x: i64, y: i64) -> Vec4 {
        let (x, y) = (
            self.wrap[0].texel(x, self.size[0]),
            self.wrap[1].texel(y, self.size[1]),
        );
        let [a, b, c, d] = self.texels[(y * self.size[0] + x) as usize];
        Vec4::new(f32::from(a), f32::from(b), f32::from(c), f32::from(d)) * self.unit
    }

    /// What is known of `patches`; all of their texels are looked at where those are few.
    pub(super) fn summary(&self, patches: Patches) -> Summary {
        let length = patches.map(|[from, to]| to - from + 1);
        if length[0] * length[1] <= 2 * SIDE * SIDE {
            return self.of_texels(patches);
        }
        let [columns, rows] = [0, 1].map(|k| self.wrap[k].within(patches[k], self.size[k]));
        let longest = length[0].max(length[1]);
        let fits = |b: &&Blocks| b.side * (SIDE - 1) >= longest;
        let Some(blocks) = self.blocks.iter().find(fits).or(self.blocks.last()) else {
            return self.whole;
        };
        let mut all = Summary::NOTHING;
        for rows in rows.iter().flatten() {
            for columns in columns.iter().flatten() {
                let block = |r: &[i64; 2]| r.map(|i| i / blocks.side);
                all = all.with(&blocks.summary([block(columns), block(rows)]));
            }
        }
        all
    }

    /// The same from the texels.
    fn of_texels(&self, [columns, rows]: Patches) -> Summary {
        let mut all = Summary::NOTHING;
        let mut squared = [0f32; 2];
        let width = (columns[1] - columns[0] + 2) as usize;
        let mut above = [Vec4::ZERO; 40];
        for y in rows[0]..=rows[1] + 1 {
            let mut left = Vec4::ZERO;
            for i in 0..width.min(above.len()) {
                let here = self.texel(columns[0] + i as i64, y);
                all = all.with_colour(here);
                if i > 0 {
                    squared[0] = squared[0].max((here - left).length_squared());
                }
                if y > rows[0] {
                    squared[1] = squared[1].max((here - above[i]).length_squared());
                }
                (left, above[i]) = (here, here);
            }
        }
        all.slope = squared.map(f32::sqrt);
        all
    }
}

impl Blocks {
    fn summary(&self, [columns, rows]: Patches) -> Summary {
        let mut all = Summary::NOTHING;
        for y in rows[0]..=rows[1] {
            for x in columns[0]..=columns[1] {
                all = all.with(&self.of[(y * self.size[0] + x) as usize]);
            }
        }
        all
    }
}

impl Wrap {
    /// The texel, of `n`, that index `i` stands for.
    fn texel(self, i: i64, n: i64) -> i64 {
        if (0..n).contains(&i) {
            return i;
        }
        match self {
            Wrap::Repeat => i.rem_euclid(n),
            Wrap::Mirror => {
                let i = i.rem_euclid(2 * n);
                i.min(2 * n - 1 - i)
            }
            Wrap::Clamp => i.clamp(0, n - 1),
        }
    }

    /// The stored patches, of `n`, whose texels a run of patches has: two runs at most.
    fn within(self, [from, to]: [i64; 2], n: i64) -> [Option<[i64; 2]>; 2] {
        let all = [Some([0, n - 1]), None];
        if to - from + 1 >= n {
            return all;
        }
        match self {
            Wrap::Repeat => {
                let (from, to) = (from.rem_euclid(n), to.rem_euclid(n));
                if from <= to {
                    [Some([from, to]), None]
                } else {
                    [Some([0, to]), Some([from, n - 1])]
                }
            }
            // The mirrored copy runs backwards: texels i and i + 1 of it are the stored ones of patch 2 n - 2 - i.
            Wrap::Mirror => {
                let (a, b) = (from.rem_euclid(2 * n), to.rem_euclid(2 * n));
                let stored = |i: i64| if i < n { i } else { (2 * n - 2 - i).max(0) };
                let (p, q) = (stored(a), stored(b));
                match (a < n, b < n) {
                    (true, true) | (false, false) if a <= b => [Some([p.min(q), p.max(q)]), None],
                    (true, false) => [Some([p.min(q), n - 1]), None],
                    (false, true) => [Some([0, p.max(q)]), None],
                    _ => all,
                }
            }
            Wrap::Clamp => [Some([from.clamp(0, n - 1), to.clamp(0, n - 1)]), None],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(i: u64) -> i16 {
        ((i.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 49) as i16) & 0x3ff
    }

    fn field(size: [u32; 2], wrap: Wrap) -> Field {
        let count = u64::from(size[0] * size[1]);
        let texels = (0..count)
            .map(|i| {
                [
                    noise(4 * i),
                    noise(4 * i + 1),
                    noise(4 * i + 2),
                    noise(4 * i + 3),
                ]
            })
            .collect();
        Field::new(size, [wrap; 2], false, texels, 1.0)
    }

    /// Everything in a rectangle, asked patch by patch, lies in what is said of it; and of all of it nothing less is said.
    #[test]
    fn summaries_hold_what_is_there() {
        for wrap in [Wrap::Repeat, Wrap::Mirror, Wrap::Clamp] {
            for size in [[1, 1], [3, 2], [17, 33], [64, 20]] {
                let field = field(size, wrap);
                for case in 0..200u64 {
                    let number = |k: u64, n: i64| i64::from(noise(case * 7 + k)).rem_euclid(n);
                    let from = [number(1, 90) - 40, number(2, 90) - 40];
                    let patches = [0, 1].map(|k| [from[k], from[k] + number(k as u64 + 3, 30)]);
                    let said = field.summary(patches);
                    let mut seen = Summary::NOTHING;
                    for y in patches[1][0]..=patches[1][1] {
                        for x in patches[0][0]..=patches[0][1] {
                            seen = seen.with(&field.of_texels([[x, x], [y, y]]));
                        }
                    }
                    assert!(said.low.cmple(seen.low).all() && said.high.cmpge(seen.high).all());
                    assert!(said.slope[0] >= seen.slope[0] && said.slope[1] >= seen.slope[1]);
                }
                let every =
                    field.summary([[0, i64::from(size[0]) - 1], [0, i64::from(size[1]) - 1]]);
                assert!(every.low == field.whole.low && every.high == field.whole.high);
            }
        }
    }

    #[test]
    fn a_patch_is_bilinear_between_its_texels() {
        let field = field([8, 8], Wrap::Repeat);
        let patch = field.patch(7, 3);
        let corner = |x: f32, y: f32| patch.between([x, y], [x, y]);
        assert_eq!(corner(1.0, 0.0), field.texel(0, 3));
        assert_eq!(corner(0.0, 1.0), field.texel(7, 4));
        assert_eq!(corner(1.0, 1.0), field.texel(8, 4));
        let middle =
            (field.texel(7, 3) + field.texel(8, 3) + field.texel(7, 4) + field.texel(8, 4)) / 4.0;
        assert!((corner(0.5, 0.5) - middle).length() < 1e-3);
    }
}
