//! A conventional texture atlas for a level of detail: what a bake needs besides the detail.
//!
//! In: a LoD and its primary. Out: [`Atlas`]: texture coordinates for each corner of each triangle in the unit square.
//! Over a uv set the LoD's T3 already is an artist's atlas. Otherwise the surface is cut into charts, connected
//! triangles of one layer that face one of the six axes most, each laid flat along that axis at one scale, and the
//! charts are packed on shelves: what modelling tools call a box or smart projection. Two triangles that cover each
//! other inside one chart (a fold steeper than 45 degrees that stays connected) share texels; the first one wins.

use crate::lod::Lod;
use crate::mesh::{Adjacency, NONE, double_area_vector};
use crate::param::grid::VERTEX_BITS;
use crate::param::{Axis, Primary};
use crate::{Error, Result};

/// Texels left free round every chart: bilinear filtering and two mip levels stay inside.
pub(super) const PADDING: u32 = 2;

/// Texture coordinates of a LoD's corners.
pub(super) struct Atlas {
    /// For each triangle those of its three corners.
    pub(super) uv: Vec<[[f32; 2]; 3]>,
    /// For each triangle its chart: corners that share a vertex and a chart share their coordinates.
    pub(super) chart: Vec<u32>,
}

/// The atlas of `lod` for textures of `size` x `size` texels.
///
/// # Errors
/// [`Error::Capacity`] where there are more charts than the texture has room for.
pub(super) fn of(lod: &Lod, primary: &Primary, size: u32) -> Result<Atlas> {
    if !primary.is_seamless() {
        return Ok(artists(lod));
    }
    boxes(lod, size)
}

/// Charts of triangles that face one way, packed.
///
/// # Errors
/// As [`of`].
pub(super) fn boxes(lod: &Lod, size: u32) -> Result<Atlas> {
    let charts = charts(lod);
    let placed = pack(&charts.boxes, size)?;
    let uv = (0..lod.triangles.len())
        .map(|t| {
            let (chart, flat) = (charts.of[t] as usize, charts.flat[t]);
            let ([x, y], low) = (placed.corners[chart], charts.boxes[chart].low);
            flat.map(|[u, v]| {
                let texel = |c: f64, low: f64, at: u32| {
                    ((c - low) * placed.scale + f64::from(at)) / f64::from(size)
                };
                [texel(u, low[0], x) as f32, texel(v, low[1], y) as f32]
            })
        })
        .collect();
    Ok(Atlas {
        uv,
        chart: charts.of,
    })
}

/// Each triangle a chart, half a square of its own: the trivial layout. Whatever its shape, a triangle gets a right angle.
///
/// # Errors
/// As [`of`].
pub(super) fn triangles(lod: &Lod, size: u32) -> Result<Atlas> {
    let count = lod.triangles.len();
    let squares = count.div_ceil(2);
    let row = (squares as f64).sqrt().ceil().max(1.0) as usize;
    let side = f64::from(size) / row as f64;
    let edge = f64::from(PADDING);
    // What is left of a square's side after its borders and the strip between the halves.
    let leg = side - 3.5 * edge;
    if leg < 1.0 {
        let squares = row as u64 * row as u64;
        return Err(Error::Capacity {
            what: format!("texels of a texture for {count} triangles by themselves"),
            need: squares * u64::from(4 * PADDING + 1).pow(2),
            have: u64::from(size) * u64::from(size),
        });
    }
    let uv = (0..count).map(|t| {
        let square = [(t / 2 % row) as f64 * side, (t / 2 / row) as f64 * side];
        let (begin, way) = if t % 2 == 0 {
            (edge, leg)
        } else {
            (side - edge, -leg)
        };
        [[0.0, 0.0], [way, 0.0], [0.0, way]].map(|[x, y]| {
            let texel = [square[0] + begin + x, square[1] + begin + y];
            texel.map(|c| (c / f64::from(size)) as f32)
        })
    });
    Ok(Atlas {
        uv: uv.collect(),
        chart: (0..count as u32).collect(),
    })
}

/// The uv that T3 is, brought to the unit square.
fn artists(lod: &Lod) -> Atlas {
    let unit = |c: i32| (f64::from(c) / f64::from(1u32 << VERTEX_BITS) + 0.5) as f32;
    let corner = |v: u32| {
        let [u, v, _] = lod.t3[v as usize];
        [unit(u), unit(v)]
    };
    Atlas {
        uv: lod.triangles.iter().map(|t| t.map(corner)).collect(),
        chart: vec![0; lod.triangles.len()],
    }
}

/// An axis-parallel box of a chart that is laid flat, object units.
#[derive(Clone, Copy)]
struct FlatBox {
    low: [f64; 2],
    high: [f64; 2],
}

impl FlatBox {
    const EMPTY: FlatBox = FlatBox {
        low: [f64::INFINITY; 2],
        high: [f64::NEG_INFINITY; 2],
    };

    fn extent(&self, k: usize) -> f64 {
        self.high[k] - self.low[k]
    }
}

struct Charts {
    /// For each triangle its chart.
    of: Vec<u32>,
    /// For each triangle its corners, laid flat.
    flat: Vec<[[f64; 2]; 3]>,
    boxes: Vec<FlatBox>,
}

fn charts(lod: &Lod) -> Charts {
    let corners = |t: usize| lod.triangles[t].map(|v| lod.positions[v as usize]);
    let facing: Vec<u8> = (0..lod.triangles.len())
        .map(|t| facing(double_area_vector(corners(t))))
        .collect();
    let of = flood(lod, &facing);
    let lay = |t: usize| {
        let axis = Axis::ALL[usize::from(facing[t] / 2)];
        corners(t).map(|p| {
            let [a, b, _] = axis.to_third(p);
            [f64::from(a), f64::from(b)]
        })
    };
    let flat: Vec<[[f64; 2]; 3]> = (0..lod.triangles.len()).map(lay).collect();
    let count = of.iter().max().map_or(0, |&last| last as usize + 1);
    let mut boxes = vec![FlatBox::EMPTY; count];
    for (chart, corners) in of.iter().zip(&flat) {
        let b = &mut boxes[*chart as usize];
        for p in corners {
            for k in 0..2 {
                (b.low[k], b.high[k]) = (b.low[k].min(p[k]), b.high[k].max(p[k]));
            }
        }
    }
    Charts { of, flat, boxes }
}

/// Which of the six axis directions a normal is nearest to: twice the axis, plus one where it points down it.
fn facing(normal: [f64; 3]) -> u8 {
    let size = normal.map(f64::abs);
    let axis = (1..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
    2 * axis as u8 + u8::from(normal[axis] < 0.0)
}

/// Numbers the connected sets of triangles that face one way and are of one layer.
fn flood(lod: &Lod, facing: &[u8]) -> Vec<u32> {
    let adjacency = Adjacency::new(&lod.triangles);
    let kind = |t: usize| (facing[t], lod.triangle_layer.get(t));
    let mut of = vec![NONE; lod.triangles.len()];
    let (mut count, mut stack) = (0, Vec::new());
    for first in 0..of.len() {
        if of[first] != NONE {
            continue;
        }
        of[first] = count;
        stack.push(first);
        while let Some(t) = stack.pop() {
            for &next in &adjacency.across[t] {
                let n = next as usize;
                if next != NONE && of[n] == NONE && kind(n) == kind(t) {
                    of[n] = count;
                    stack.push(n);
                }
            }
        }
        count += 1;
    }
    of
}

struct Placed {
    /// Texels for an object unit.
    scale: f64,
    /// The texel where each chart's box begins.
    corners: Vec<[u32; 2]>,
}

/// Places all boxes at the largest scale (found by halving) at which they fit.
fn pack(boxes: &[FlatBox], size: u32) -> Result<Placed> {
    let extent = boxes
        .iter()
        .map(|b| b.extent(0).max(b.extent(1)))
        .fold(0.0, f64::max);
    let most = f64::from(size) / extent.max(f64::MIN_POSITIVE);
    let Some(mut best) = shelves(boxes, 0.0, size) else {
        let texels = |side: u32| u64::from(side) * u64::from(side);
        return Err(Error::Capacity {
            what: format!("texels of a baked texture for {} charts", boxes.len()),
            need: boxes.len() as u64 * texels(2 * PADDING + 1),
            have: texels(size),
        });
    };
    let (mut low, mut high) = (0.0, most);
    for _ in 0..24 {
        let middle = (low + high) / 2.0;
        match shelves(boxes, middle, size) {
            Some(placed) => (best, low) = (placed, middle),
            None => high = middle,
        }
    }
    Ok(best)
}

/// Places boxes row by row, tallest first; `None` where they do not fit.
fn shelves(boxes: &[FlatBox], scale: f64, size: u32) -> Option<Placed> {
    let texels = |b: &FlatBox, k: usize| (b.extent(k) * scale).ceil() as u32 + 1 + 2 * PADDING;
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(texels(&boxes[i], 1)), i));
    let mut corners = vec![[0; 2]; boxes.len()];
    let ([mut x, mut y], mut row) = ([0u32; 2], 0u32);
    for i in order {
        let (width, height) = (texels(&boxes[i], 0), texels(&boxes[i], 1));
        if x + width > size {
            (x, y, row) = (0, y + row, 0);
        }
        if width > size || y + height > size {
            return None;
        }
        corners[i] = [x + PADDING, y + PADDING];
        x += width;
        row = row.max(height);
    }
    Some(Placed { scale, corners })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::shapes;
    use crate::param::PrimaryKind;

    fn ball() -> (Lod, Primary) {
        let mesh = shapes::icosphere(3);
        let primary = Primary::centred(PrimaryKind::Sphere, &mesh).unwrap();
        let lod = Lod {
            triangle_layer: vec![0; mesh.triangles.len()],
            positions: mesh.positions,
            triangles: mesh.triangles,
            ..Lod::default()
        };
        (lod, primary)
    }

    /// The triangles whose interior holds a texel's centre.
    fn owners(atlas: &Atlas, size: u32) -> Vec<u32> {
        let mut count = vec![0u32; (size * size) as usize];
        for corners in &atlas.uv {
            let [a, b, c] = corners.map(|p| p.map(|x| f64::from(x) * f64::from(size)));
            let edge = |p: [f64; 2], q: [f64; 2], at: [f64; 2]| {
                (q[0] - p[0]) * (at[1] - p[1]) - (q[1] - p[1]) * (at[0] - p[0])
            };
            for (i, count) in count.iter_mut().enumerate() {
                let at = [i as u32 % size, i as u32 / size].map(|c| f64::from(c) + 0.5);
                let e = [edge(a, b, at), edge(b, c, at), edge(c, a, at)];
                let inside = e.iter().all(|&x| x > 1e-6) || e.iter().all(|&x| x < -1e-6);
                *count += u32::from(inside);
            }
        }
        count
    }

    #[test]
    fn no_texel_of_a_ball_has_two_owners_and_a_quarter_of_them_have_one() {
        let (lod, primary) = ball();
        let atlas = of(&lod, &primary, 64).unwrap();
        assert_eq!(atlas.chart.iter().max(), Some(&5), "six sides");
        let owners = owners(&atlas, 64);
        assert_eq!(owners.iter().max(), Some(&1));
        assert!(owners.iter().filter(|&&o| o == 1).count() > 64 * 64 / 4);
        // The negative control: charts on top of each other are seen.
        let mut stacked = atlas;
        stacked.uv[1] = stacked.uv[0];
        assert_eq!(super::tests::owners(&stacked, 64).iter().max(), Some(&2));
    }

    #[test]
    fn triangles_by_themselves_share_no_texel() {
        let (lod, _) = ball();
        let atlas = triangles(&lod, 256).unwrap();
        let owners = owners(&atlas, 256);
        assert_eq!(owners.iter().max(), Some(&1));
        assert!(owners.iter().filter(|&&o| o == 1).count() > 256 * 256 / 8);
        assert!(triangles(&lod, 64).is_err());
    }

    #[test]
    fn charts_that_do_not_fit_are_refused() {
        let (lod, primary) = ball();
        assert!(of(&lod, &primary, 16).is_ok());
        let refused = of(&lod, &primary, 8).err().unwrap().to_string();
        assert!(refused.contains("6 charts"), "{refused}");
    }
}
