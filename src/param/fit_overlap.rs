//! How often the hash domain is covered: the share of it where more than one triangle answers.
//!
//! In: triangles in T3 relative to the origin, the part of each. Out: [`Overlap`]. A sheet of the domain is sampled at
//! texel centres; a triangle counts where the projection line through the centre meets it strictly inside, so shared
//! edges never count twice and "not bijective" is never claimed by rounding alone.

use super::fit_domain::Domain;

/// Texels along each side of a uv layout.
pub(crate) const LAYOUT_TEXELS: usize = 2048;
/// Texels along each side of a sheet of a projection.
pub(crate) const SHEET_TEXELS: usize = 512;

/// Coverage of a domain.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Overlap {
    /// Texels covered at all.
    pub(crate) covered: u64,
    /// Texels covered more than once.
    pub(crate) overlapped: u64,
    /// Texels covered more than once by one part.
    pub(crate) overlapped_within: u64,
    /// For each triangle the texels it shares with another; empty where nothing overlaps.
    pub(crate) shared_by: Vec<u32>,
}

impl Overlap {
    /// Share of the covered texels that are covered more than once.
    pub(crate) fn fraction(&self) -> f64 {
        self.overlapped as f64 / (self.covered as f64).max(1.0)
    }

    /// Share of the covered texels that one part covers more than once: where not even the part decides.
    pub(crate) fn fraction_within(&self) -> f64 {
        self.overlapped_within as f64 / (self.covered as f64).max(1.0)
    }
}

/// What is known of one texel while triangles are drawn part by part.
#[derive(Clone, Copy)]
struct Texel {
    /// The last part that covered it, plus 1.
    part: u32,
    more_than_once: bool,
    within: bool,
}

/// Most texels that one drawing tests: many triangles that each cover everything are drawn more coarsely instead of taking
/// hours. No model that makes sense comes near.
const MOST_TESTS: f64 = (1u64 << 26) as f64;
/// The coarsest sheets.
const LEAST_SIDE: usize = 16;

/// The finest side, `side` or a half, quarter, ... of it, at which drawing stays below [`MOST_TESTS`].
fn affordable(
    domain: &Domain,
    mut side: usize,
    triangles: usize,
    corner: impl Fn(usize) -> [[f64; 3]; 3],
) -> usize {
    let mut area = 0.0;
    for t in 0..triangles {
        domain.pieces(&corner(t), |piece| {
            let extent = |i: usize| piece.high[i].min(1.0) - piece.low[i].max(0.0);
            area += extent(0).max(0.0) * extent(1).max(0.0);
        });
    }
    while side > LEAST_SIDE && area * (side * side) as f64 > MOST_TESTS {
        side /= 2;
    }
    side
}

/// Draws all triangles on sheets of `side` x `side` texels, or coarser (see [`affordable`]). `corner(t)` gives triangle `t` in T3, `part[t]` its part.
pub(crate) fn measure(
    domain: &Domain,
    side: usize,
    part: &[u32],
    corner: impl Fn(usize) -> [[f64; 3]; 3],
) -> Overlap {
    let side = affordable(domain, side, part.len(), &corner);
    let mut texels = vec![
        Texel {
            part: 0,
            more_than_once: false,
            within: false
        };
        domain.sheets() * side * side
    ];
    // Part by part, so that "covered by this part before" is one comparison.
    let mut order: Vec<u32> = (0..part.len() as u32).collect();
    order.sort_by_key(|&t| part[t as usize]);
    for &t in &order {
        let stamp = part[t as usize] + 1;
        covered(domain, side, &corner(t as usize), |texel| {
            let texel = &mut texels[texel];
            texel.more_than_once |= texel.part != 0;
            texel.within |= texel.part == stamp;
            texel.part = stamp;
        });
    }
    let count = |what: fn(&Texel) -> bool| texels.iter().filter(|t| what(t)).count() as u64;
    let mut overlap = Overlap {
        covered: count(|t| t.part != 0),
        overlapped: count(|t| t.more_than_once),
        overlapped_within: count(|t| t.within),
        shared_by: vec![],
    };
    if overlap.overlapped > 0 {
        overlap.shared_by = vec![0; part.len()];
        for (t, shared) in overlap.shared_by.iter_mut().enumerate() {
            covered(domain, side, &corner(t), |texel| {
                *shared += u32::from(texels[texel].more_than_once)
            });
        }
    }
    overlap
}

/// Calls `visit` with the index of every texel whose centre's line meets the triangle strictly inside.
fn covered(domain: &Domain, side: usize, triangle: &[[f64; 3]; 3], mut visit: impl FnMut(usize)) {
    let scale = side as f64;
    domain.pieces(triangle, |piece| {
        let [columns, rows] = [0, 1].map(|i| {
            let from = (piece.low[i] * scale - 0.5).ceil().clamp(0.0, scale) as usize;
            let to = (piece.high[i] * scale - 0.5)
                .floor()
                .clamp(-1.0, scale - 1.0) as isize;
            from..(to + 1) as usize
        });
        let probe = domain.probe(triangle, piece.sheet);
        for row in rows {
            for column in columns.clone() {
                let at = [(column as f64 + 0.5) / scale, (row as f64 + 0.5) / scale];
                if probe.inside(at) {
                    visit((piece.sheet * side + row) * side + column);
                }
            }
        }
    });
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::param::PrimaryKind;

    fn square(at: f64, size: f64) -> [[[f64; 3]; 3]; 2] {
        let [a, b] = [at, at + size];
        [
            [[a, a, 0.0], [b, a, 0.0], [b, b, 0.0]],
            [[a, a, 0.0], [b, b, 0.0], [a, b, 0.0]],
        ]
    }

    #[test]
    fn a_square_is_covered_once() {
        let triangles = square(0.25, 0.5);
        let overlap = measure(&Domain::tile([0.0, 0.0]), LAYOUT_TEXELS, &[0, 0], |t| {
            triangles[t]
        });
        // The diagonal passes through 1024 centres: strictly inside neither.
        assert_eq!(overlap.covered, 1024 * 1024 - 1024);
        assert_eq!((overlap.overlapped, overlap.overlapped_within), (0, 0));
        assert!(overlap.shared_by.is_empty());
    }

    #[test]
    fn two_squares_overlap_in_a_quarter_and_parts_tell_them_apart() {
        let triangles = [square(0.0, 0.5), square(0.25, 0.5)].concat();
        let both = |part: &[u32]| {
            measure(&Domain::tile([0.0, 0.0]), LAYOUT_TEXELS, part, |t| {
                triangles[t]
            })
        };
        let (apart, one) = (both(&[0, 0, 1, 1]), both(&[0, 0, 0, 0]));
        // 1/16 of the tile is shared, 7/16 are covered.
        assert!(
            (apart.fraction() - 1.0 / 7.0).abs() < 2e-3,
            "{}",
            apart.fraction()
        );
        assert_eq!(apart.overlapped, one.overlapped);
        assert_eq!(apart.overlapped_within, 0);
        assert_eq!(one.overlapped_within, one.overlapped);
        assert!(apart.shared_by.iter().all(|&n| n > 0));
    }

    /// A hundred thousand triangles, each over all of the tile: still done at once, and still an overlap.
    #[test]
    fn triangles_that_all_cover_everything_take_no_time() {
        let everything = [[-9.0, -9.0, 0.0], [9.0, -9.0, 0.0], [0.0, 90.0, 0.0]];
        let parts: Vec<u32> = (0..100_000).collect();
        let tile = Domain::tile([0.0, 0.0]);
        let overlap = measure(&tile, LAYOUT_TEXELS, &parts, |_| everything);
        assert_eq!(overlap.fraction(), 1.0);
        assert_eq!(affordable(&tile, 2048, 2, |_| everything), 2048);
    }

    #[test]
    fn a_closed_box_about_the_centre_covers_the_sphere_once() {
        let corners: Vec<[f64; 3]> = (0..8)
            .map(|i| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }))
            .collect();
        let quads = [
            [0, 2, 3, 1],
            [4, 5, 7, 6],
            [0, 1, 5, 4],
            [2, 6, 7, 3],
            [0, 4, 6, 2],
            [1, 3, 7, 5],
        ];
        let triangles: Vec<[[f64; 3]; 3]> = quads
            .iter()
            .flat_map(|q| [[q[0], q[1], q[2]], [q[0], q[2], q[3]]])
            .map(|t: [usize; 3]| t.map(|i| corners[i]))
            .collect();
        let domain = Domain::new(PrimaryKind::Sphere, &corners, 0.0);
        let overlap = measure(&domain, SHEET_TEXELS, &[0; 12], |t| triangles[t]);
        let all = (6 * SHEET_TEXELS * SHEET_TEXELS) as u64;
        assert_eq!(overlap.overlapped, 0);
        assert!(
            all - overlap.covered <= 6 * SHEET_TEXELS as u64,
            "{} of {all}",
            overlap.covered
        );
        let twice = measure(&domain, SHEET_TEXELS, &[0; 24], |t| {
            triangles[t % 12].map(|p| p.map(|x| x * (1.0 + (t / 12) as f64)))
        });
        assert_eq!(
            twice.overlapped, twice.covered,
            "a nested copy covers everything twice"
        );
    }
}
