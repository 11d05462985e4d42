//! Triangle records: the T3 coordinates of a triangle's vertices.
//!
//! | record | bits | holds |
//! |---|---|---|
//! | chart | 128 | six 21-bit coordinates |
//! | compact | 128 | the first vertex with p bits a coordinate, the others as differences from it of (127 - 3 p) / 6 bits |
//! | wide | 256 | nine 24-bit coordinates |
//! | RGB9E5 | 96 | the paper's: three texels with 9-bit mantissas and a shared exponent (EXT_texture_shared_exponent) |
//!
//! Compact records suit small triangles: p is chosen for the mesh ([`Record::for_mesh`]) as large as nearly all its triangles
//! allow. One whose differences do not fit has bit 127 set and the number of a pair of 128-bit words behind all records,
//! which hold a wide record. Every vertex is rounded to p bits once, so neighbours keep common edges.

use crate::param::grid::VERTEX_BITS;
use crate::param::projection::GridTriangle;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::ops::RangeInclusive;

/// How records hold coordinates.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Record {
    /// Two coordinates of 21 bits.
    Chart,
    /// Three coordinates of the given number of bits, differences for the second and third vertex.
    Compact(u32),
    /// Three coordinates of 24 bits.
    Wide,
    /// The paper's shared exponent.
    Rgb9e5,
}

/// Precisions of compact records, in bits.
pub const PRECISIONS: RangeInclusive<u32> = 16..=VERTEX_BITS;
/// Bits of a chart's coordinate.
const CHART_BITS: u32 = 21;
/// Half of the vertex grid: added to make coordinates unsigned.
const HALF: i32 = 1 << (VERTEX_BITS - 1);
/// Bit 127: the triangle's record is a wide one.
const IS_WIDE: u32 = 1 << 31;
/// The most area, as a share of the mesh's, of triangles that take two loads more.
const WIDE_AREA: f64 = 0.01;
/// Beyond this share of the area at the lowest precision every record is a wide one.
const ALL_WIDE_AREA: f64 = 0.5;

/// Bits of a difference in a compact record.
pub fn difference_bits(precision: u32) -> u32 {
    (127 - 3 * precision) / 6
}

impl Record {
    /// The record for a mesh in T3, `corners(t)` its `count` triangles on the vertex grid.
    pub fn for_mesh(count: usize, corners: impl Fn(usize) -> GridTriangle) -> Self {
        let mut area_at = [0.0; 32];
        let mut area = 0.0;
        for triangle in (0..count).map(corners) {
            // Rounding moves a difference by up to a step, hence a step in reserve.
            let reach = largest_difference(&triangle);
            let fits =
                |p: &u32| reach < ((1 << (difference_bits(*p) - 1)) - 2) << (VERTEX_BITS - p);
            let precision = PRECISIONS.rev().find(fits).unwrap_or(0);
            let size = double_area(&triangle);
            area_at[precision as usize] += size;
            area += size;
        }
        let beyond = |p: u32| area_at[..p as usize].iter().sum::<f64>();
        match PRECISIONS.rev().find(|p| beyond(*p) <= WIDE_AREA * area) {
            Some(precision) => Record::Compact(precision),
            None if beyond(*PRECISIONS.start()) <= ALL_WIDE_AREA * area => {
                Record::Compact(*PRECISIONS.start())
            }
            None => Record::Wide,
        }
    }

    /// The record as shaders have it: 0 chart, 1 wide, 2 RGB9E5, else the precision of compact ones.
    pub fn code(self) -> u32 {
        match self {
            Record::Chart => 0,
            Record::Wide => 1,
            Record::Rgb9e5 => 2,
            Record::Compact(precision) => precision,
        }
    }

    /// Words of a record, not counting the wide ones behind compact ones.
    pub fn words(self) -> usize {
        match self {
            Record::Chart | Record::Compact(_) => 4,
            Record::Wide => 8,
            Record::Rgb9e5 => 3,
        }
    }

    /// The point nearest to `v` that records can hold.
    pub fn round(self, v: [i32; 3], flat: bool) -> [i32; 3] {
        match self {
            Record::Chart => v.map(|x| round_to(x, CHART_BITS)),
            Record::Compact(precision) => v.map(|x| round_to(x, precision)),
            Record::Wide => v,
            Record::Rgb9e5 => decode_rgb9e5(encode_rgb9e5(v, flat), flat),
        }
    }

    /// The table of `count` triangles.
    pub fn table(
        self,
        count: usize,
        corners: impl Fn(usize) -> GridTriangle + Sync,
        flat: bool,
    ) -> Vec<u32> {
        let words = self.words();
        let mut table = vec![0; count * words];
        let each = |(t, out): (usize, &mut [u32])| {
            let triangle = corners(t);
            match self {
                Record::Chart => out.copy_from_slice(&chart(&triangle)),
                Record::Wide => out.copy_from_slice(&wide_record(&triangle)),
                Record::Rgb9e5 => out.copy_from_slice(&triangle.map(|v| encode_rgb9e5(v, flat))),
                Record::Compact(precision) => {
                    let record = compact(&triangle, precision).unwrap_or([0, 0, 0, IS_WIDE]);
                    out.copy_from_slice(&record);
                }
            }
        };
        table.par_chunks_exact_mut(words).enumerate().for_each(each);
        if let Record::Compact(_) = self {
            for t in 0..count {
                if table[words * t + 3] == IS_WIDE {
                    table[words * t] = (table.len() / words) as u32;
                    table.extend(wide_record(&corners(t)));
                }
            }
        }
        // Shaders read 128-bit words.
        table.resize(table.len().next_multiple_of(4), 0);
        table
    }

    /// A triangle's vertices, and the loads of at most 128 bits they took.
    pub fn read(self, table: &[u32], triangle: u32, flat: bool) -> (GridTriangle, u32) {
        let words = self.words();
        let record = &table[triangle as usize * words..][..words];
        match self {
            Record::Chart => (read_chart(record), 1),
            Record::Wide => (read_wide(record), 2),
            Record::Rgb9e5 => ([0, 1, 2].map(|i| decode_rgb9e5(record[i], flat)), 3),
            Record::Compact(_) if record[3] & IS_WIDE != 0 => {
                (read_wide(&table[4 * record[0] as usize..][..8]), 3)
            }
            Record::Compact(precision) => (read_compact(record, precision), 1),
        }
    }

    /// What is wrong with a table of `count` triangles, if anything: the element and the reason.
    pub(in crate::igt) fn fault(self, table: &[u32], count: usize) -> Option<(String, String)> {
        let (have, want) = (table.len(), (count * self.words()).next_multiple_of(4));
        let pairs = matches!(self, Record::Compact(_)) && have > want && (have - want) % 8 == 0;
        if have != want && !pairs {
            let reason = format!("{have} words where {want} belong");
            return Some(("triangle".into(), reason));
        }
        if !matches!(self, Record::Compact(_)) {
            return None;
        }
        let lost = |r: &[u32]| r[3] & IS_WIDE != 0 && 4 * (r[0] as usize) + 8 > have;
        const PIECE: usize = 1 << 14;
        let in_piece = |(piece, records): (usize, &[u32])| {
            let t = records.chunks_exact(4).position(lost)?;
            Some(piece * PIECE + t)
        };
        let pieces = table[..want].par_chunks(4 * PIECE).enumerate();
        let t = pieces.find_map_first(in_piece)?;
        Some((
            format!("triangle[{t}]"),
            "its wide record does not exist".into(),
        ))
    }
}

fn largest_difference(t: &GridTriangle) -> i32 {
    let away = |i: usize| (0..3).map(move |k| (t[i][k] - t[0][k]).abs()).max();
    away(1).max(away(2)).unwrap_or(0)
}

fn double_area(t: &GridTriangle) -> f64 {
    let [a, b, c] = t.map(|v| glam::DVec3::from(v.map(f64::from)));
    (b - a).cross(c - a).length()
}

/// Rounds a coordinate to `bits` bits, within what they can hold.
fn round_to(x: i32, bits: u32) -> i32 {
    let shift = VERTEX_BITS - bits;
    let most = (HALF >> shift) - 1;
    ((x + ((1 << shift) >> 1)) >> shift).clamp(-most, most) << shift
}

fn chart(t: &GridTriangle) -> [u32; 4] {
    let c = |i: usize| ((t[i / 2][i % 2] + HALF) >> (VERTEX_BITS - CHART_BITS)) as u128;
    let bits = (0..6).fold(0, |w, i| w | c(i) << (i as u32 * CHART_BITS));
    [0, 1, 2, 3].map(|i| (bits >> (32 * i)) as u32)
}

fn window(record: &[u32]) -> u128 {
    (0..4).fold(0, |w, i| w | u128::from(record[i]) << (32 * i))
}

fn read_chart(record: &[u32]) -> GridTriangle {
    let w = window(record);
    let c = |i: u32| {
        let field = (w >> (i * CHART_BITS)) as u32 & ((1 << CHART_BITS) - 1);
        ((field << (VERTEX_BITS - CHART_BITS)) as i32) - HALF
    };
    [[c(0), c(1), 0], [c(2), c(3), 0], [c(4), c(5), 0]]
}

/// The compact record of a triangle on the grid of `precision` bits; none where a difference does not fit.
fn compact(t: &GridTriangle, precision: u32) -> Option<[u32; 4]> {
    let (shift, bits) = (VERTEX_BITS - precision, difference_bits(precision));
    let most = (1 << (bits - 1)) - 1;
    let mut w = 0u128;
    for k in 0..3 {
        w |= (((t[0][k] + HALF) >> shift) as u128) << (k as u32 * precision);
    }
    for i in 0..6 {
        let difference = (t[1 + i / 3][i % 3] - t[0][i % 3]) >> shift;
        if difference.abs() > most {
            return None;
        }
        let field = (difference as u32 & ((1 << bits) - 1)) as u128;
        w |= field << (3 * precision + i as u32 * bits);
    }
    Some([0, 1, 2, 3].map(|i| (w >> (32 * i)) as u32))
}

fn read_compact(record: &[u32], precision: u32) -> GridTriangle {
    let (shift, bits) = (VERTEX_BITS - precision, difference_bits(precision));
    let w = window(record);
    let first: [i32; 3] = std::array::from_fn(|k| {
        let field = (w >> (k as u32 * precision)) as u32 & ((1u32 << precision) - 1);
        ((field << shift) as i32) - HALF
    });
    // Sign-extended by a shift to the top and back; the differences stay far inside 32 bits.
    let difference = |i: usize| {
        let field = (w >> (3 * precision + i as u32 * bits)) as u32;
        ((field << (32 - bits)) as i32 >> (32 - bits)) << shift
    };
    // A corrupt record may lead outside the domain; a vertex never does.
    let vertex = |i: usize| {
        std::array::from_fn(|k| (first[k] + difference(3 * i + k)).clamp(-HALF, HALF - 1))
    };
    [first, vertex(0), vertex(1)]
}

fn wide_record(t: &GridTriangle) -> [u32; 8] {
    let c = |i: usize| (t[i / 3][i % 3] + HALF) as u32;
    std::array::from_fn(|i| {
        let top = if i < 3 { c(8) >> (8 * i) & 255 } else { 0 };
        c(i) | top << 24
    })
}

fn read_wide(w: &[u32]) -> GridTriangle {
    let c = |x: u32| ((x & 0xff_ffff) as i32) - HALF;
    let last = w[0] >> 24 | w[1] >> 24 << 8 | w[2] >> 24 << 16;
    [
        [c(w[0]), c(w[1]), c(w[2])],
        [c(w[3]), c(w[4]), c(w[5])],
        [c(w[6]), c(w[7]), c(last)],
    ]
}

/// The shared-exponent texel of a vertex: coordinate c/2^24 of the domain with 9 bits of mantissa.
fn encode_rgb9e5(v: [i32; 3], flat: bool) -> u32 {
    let c = [v[0] + HALF, v[1] + HALF, if flat { 0 } else { v[2] + HALF }].map(|x| x as u32);
    let largest = c[0].max(c[1]).max(c[2]);
    let mut exponent = (32 - largest.leading_zeros()).saturating_sub(9);
    let mantissa = |exponent: u32, x: u32| {
        if exponent == 0 {
            x
        } else {
            (x + (1 << (exponent - 1))) >> exponent
        }
    };
    if mantissa(exponent, largest) > 511 {
        exponent += 1;
    }
    // Rounding up at the domain's upper border would need a sixteenth exponent: stay below it.
    let exponent = exponent.min(15);
    let m = c.map(|x| mantissa(exponent, x).min(511));
    m[0] | m[1] << 9 | m[2] << 18 | exponent << 27
}

fn decode_rgb9e5(word: u32, flat: bool) -> [i32; 3] {
    let exponent = word >> 27;
    // Exponents above 15 are never written; clamp so that a corrupt table cannot leave the grid.
    let coordinate = |at: u32| (((word >> at & 511) << exponent.min(15)) as i32) - HALF;
    [
        coordinate(0),
        coordinate(9),
        if flat { 0 } else { coordinate(18) },
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Triangles of all sizes up to `reach`, all over the domain.
    fn triangles(reach: i32) -> Vec<GridTriangle> {
        let mut state = 12_345u64;
        let mut random = |range: i32| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            ((state >> 33) as i64 % (2 * i64::from(range) + 1)) as i32 - range
        };
        (0..500)
            .map(|_| {
                let middle = [0; 3].map(|_: i32| random(HALF - 1 - reach));
                [0, 1, 2].map(|_| middle.map(|x| x + random(reach)))
            })
            .collect()
    }

    #[test]
    fn records_give_back_what_they_hold() {
        for (reach, flat) in [
            (50, false),
            (30_000, false),
            (4_000_000, false),
            (60_000, true),
        ] {
            let given: Vec<GridTriangle> = triangles(reach)
                .into_iter()
                .map(|t| {
                    if flat {
                        t.map(|[x, y, _]| [x, y, 0])
                    } else {
                        t
                    }
                })
                .collect();
            let records = if flat {
                vec![Record::Chart, Record::Rgb9e5]
            } else {
                let compact = PRECISIONS.map(Record::Compact);
                [Record::Wide, Record::Rgb9e5]
                    .into_iter()
                    .chain(compact)
                    .collect()
            };
            for record in records {
                let rounded: Vec<GridTriangle> = given
                    .iter()
                    .map(|t| t.map(|v| record.round(v, flat)))
                    .collect();
                let table = record.table(rounded.len(), |t| rounded[t], flat);
                assert_eq!(record.fault(&table, rounded.len()), None);
                for (t, triangle) in rounded.iter().enumerate() {
                    let (read, fetches) = record.read(&table, t as u32, flat);
                    assert_eq!(read, *triangle, "{record:?} {reach}");
                    assert!((1..=3).contains(&fetches));
                }
            }
        }
    }

    #[test]
    fn small_triangles_get_fine_compact_records_and_large_ones_wide_ones() {
        let of = |reach| {
            let all = triangles(reach);
            Record::for_mesh(all.len(), |t| all[t])
        };
        assert_eq!(of(50), Record::Compact(24));
        assert!(matches!(of(60_000), Record::Compact(16..=18)));
        assert_eq!(of(4_000_000), Record::Wide);
    }

    #[test]
    fn a_lost_wide_record_is_noticed() {
        let all = triangles(4_000_000);
        let record = Record::Compact(16);
        let rounded: Vec<GridTriangle> = all
            .iter()
            .map(|t| t.map(|v| record.round(v, false)))
            .collect();
        let mut table = record.table(rounded.len(), |t| rounded[t], false);
        table.truncate(table.len() - 8);
        assert!(record.fault(&table, rounded.len()).is_some());
    }
}
