//! Stepped masks against the definition, and tiles against their box.

use super::super::boxes::boxes;
use super::*;

struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6364136223846793005)
            .wrapping_add(1442695040888963407);
        (self.0 >> 33) % n
    }

    /// A triangle about `size` wide; one in eight has two equal vertices, or three on a line.
    fn triangle(&mut self, size: u64) -> GridTriangle {
        let most = (1 << (VERTEX_BITS - 1)) - 1;
        let middle = [0; 3].map(|_: i32| self.below(2 * most as u64) as i32 - most);
        let mut corner =
            || middle.map(|c| (c + self.below(size) as i32 - size as i32 / 2).clamp(-most, most));
        let mut t = [corner(), corner(), corner()];
        match self.below(16) {
            0 => t[1] = t[0],
            1 => t[2] = [0, 1, 2].map(|k| (t[0][k] + t[1][k]) / 2),
            2 => t[0] = t[0].map(|x| x >> 12 << 12),
            _ => {}
        }
        t
    }
}

/// The definition: the sides of all corners, one by one.
fn square_is_touched(bits: u32, t: &GridTriangle, texel: [u32; 2]) -> bool {
    let width = 1i64 << (VERTEX_BITS - bits);
    let low = texel.map(|x| x as i64 * width - (1 << (VERTEX_BITS - 1)));
    one_side(
        |i, c| {
            let p = [
                low[0] + (c & 1) as i64 * width,
                low[1] + (c >> 1) as i64 * width,
            ];
            let [a, b] =
                [t[(i + 1) % 3], t[(i + 2) % 3]].map(|v| [v[0] as i64 - p[0], v[1] as i64 - p[1]]);
            a[0] * b[1] - a[1] * b[0]
        },
        4,
    )
}

/// How many of the tiles of random triangles have another mask than `defined` gives `other` of the triangle.
fn wrong_tiles(line: Line, other: impl Fn(&GridTriangle) -> GridTriangle) -> usize {
    let mut random = Random(line as u64 + 5);
    let (mut tiles, mut wrong) = (0, 0);
    for bits in [2, 3, 6, 10, 13] {
        let texel = 1u64 << (VERTEX_BITS - bits);
        for size in [3, texel, 4 * texel, 40 * texel, 1 << 23].map(|s| s.min(1 << 24)) {
            for _ in 0..60 {
                let t = random.triangle(size);
                let changed = other(&t);
                let (toucher, definition) = (
                    Toucher::new(line, bits, &t),
                    Toucher::new(line, bits, &changed),
                );
                let (boxes, count) = boxes(line, bits, &t);
                for one in &boxes[..count] {
                    let step = (one.tiles() / 20).max(1) as usize;
                    for tile in (0..one.tiles()).step_by(step).map(|i| one.tile(i)) {
                        let defined = (0..tile.area()).fold(0, |mask, i| {
                            let index = tile.texel(bits, i);
                            let at = [index & ((1 << bits) - 1), index >> bits];
                            let touched = match line {
                                Line::Parallel => square_is_touched(bits, &changed, at),
                                Line::Cylinder => definition.touches_wedge(at),
                                Line::Sphere => definition.touches_cone(at, tile.octant),
                            };
                            mask | u32::from(touched) << i
                        });
                        tiles += 1;
                        wrong += usize::from(toucher.touched(&tile) != defined);
                    }
                }
            }
        }
    }
    assert!(tiles > 5000, "{tiles} tiles");
    wrong
}

#[test]
fn stepping_gives_what_the_corners_give() {
    for line in [Line::Parallel, Line::Cylinder, Line::Sphere] {
        assert_eq!(wrong_tiles(line, |t| *t), 0, "{line:?}");
        // Negative control: a vertex moved by a texel of the finest table is seen.
        let moved = wrong_tiles(line, |t| {
            [[t[0][0] ^ 1 << 11, t[0][1], t[0][2]], t[1], t[2]]
        });
        assert!(moved > 0, "{line:?}");
    }
}

#[test]
fn tiles_are_a_partition_of_their_box() {
    for (width, height) in [
        (1, 1),
        (32, 1),
        (33, 1),
        (64, 64),
        (5, 40),
        (7, 9),
        (100, 2),
        (8, 5),
        (1, 77),
    ] {
        let whole = TexelBox {
            column: 3,
            row: 2,
            width,
            height,
            octant: 0,
        };
        let mut seen = vec![0; 1 << 14];
        for tile in (0..whole.tiles()).map(|i| whole.tile(i)) {
            assert!(tile.area() <= super::super::TILE);
            (0..tile.area()).for_each(|i| seen[tile.texel(7, i) as usize] += 1);
        }
        let inside =
            |i: u32| (3..3 + width).contains(&(i & 127)) && (2..2 + height).contains(&(i >> 7));
        assert!(
            (0..1 << 14).all(|i| seen[i as usize] == u32::from(inside(i))),
            "{width} x {height}"
        );
    }
}
