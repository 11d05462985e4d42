//! Who asks: what a lookup prefers among several answers, and as which word shaders get it.

use crate::lod::Lod;
use crate::param::projection::{self, GridTriangle, Line};

/// What a lookup prefers among several answers. `None::<u8>` or a layer alone convert to it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Asker {
    /// The layer of the LoD triangle's part; none for any.
    pub layer: Option<u8>,
    /// The sense in which projection lines meet the LoD triangle ([`projection::orientation`]); 0 for any.
    pub side: i32,
    /// Projection lines run along the LoD triangle ([`projection::is_grazed`]): a small deviation moves the hit far away,
    /// or to the wall behind. The nearest point is then the better answer, where it may be given, and nothing is known of
    /// where the line would have led ([`Lod::bounded`]).
    pub grazed: bool,
}

impl Asker {
    /// The asker as `igt_lookup` of `igt.glsl` takes it.
    pub fn word(self) -> u32 {
        let side = match self.side.signum() {
            0 => 0,
            1 => SIDE_FRONT,
            _ => SIDE_BACK,
        };
        let grazed = if self.grazed { GRAZED } else { 0 };
        self.layer.map_or(ANY_LAYER, u32::from) | side | grazed
    }

    /// The asker of a word; [`word`](Self::word) undone.
    pub fn from_word(word: u32) -> Self {
        Asker {
            layer: (word & ANY_LAYER == 0).then_some(word as u8),
            side: match word & (SIDE_FRONT | SIDE_BACK) {
                SIDE_FRONT => 1,
                SIDE_BACK => -1,
                _ => 0,
            },
            grazed: word & GRAZED != 0,
        }
    }

    /// Who asks for the fragments of a LoD triangle, T3 on the vertex grid.
    pub fn of(line: Line, corners: &GridTriangle, layer: Option<u8>) -> Self {
        Asker {
            layer,
            side: projection::orientation(line, corners),
            grazed: projection::is_grazed(line, corners),
        }
    }

    /// Who asks for the fragments of triangle `t` of `lod`.
    pub fn of_lod(line: Line, lod: &Lod, t: usize) -> Self {
        let corners = lod.triangles[t].map(|v| lod.t3[v as usize]);
        let asker = Asker::of(line, &corners, lod.triangle_layer.get(t).copied());
        Asker {
            grazed: asker.grazed && !lod.bounded,
            ..asker
        }
    }
}

impl From<Option<u8>> for Asker {
    fn from(layer: Option<u8>) -> Self {
        Asker {
            layer,
            ..Asker::default()
        }
    }
}

/// Bits of [`Asker::word`], as in `igt.glsl`.
const ANY_LAYER: u32 = 1 << 31;
const SIDE_FRONT: u32 = 1 << 8;
const SIDE_BACK: u32 = 1 << 9;
const GRAZED: u32 = 1 << 10;

/// For each triangle of a LoD the [`Asker::word`] its fragments ask with.
pub fn askers(line: Line, lod: &Lod) -> Vec<u32> {
    let asker = |t| Asker::of_lod(line, lod, t).word();
    (0..lod.triangles.len()).map(asker).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn askers_survive_their_words() {
        for layer in [None, Some(0), Some(254)] {
            for side in [-1, 0, 1] {
                for grazed in [false, true] {
                    let asker = Asker {
                        layer,
                        side,
                        grazed,
                    };
                    assert_eq!(Asker::from_word(asker.word()), asker);
                }
            }
        }
        assert_eq!(
            Asker::from_word(u32::MAX).layer,
            None,
            "no layer whatever else is said"
        );
    }

    #[test]
    fn who_knows_a_bound_along_lines_looks_along_them() {
        // A wall that stands upright over the plane.
        let lod = |bounded: bool| Lod {
            t3: vec![[0, 0, 0], [1000, 0, 5], [0, 1, 9000]],
            triangles: vec![[0, 1, 2]],
            triangle_layer: vec![3],
            bounded,
            ..Lod::default()
        };
        let of = |bounded| Asker::of_lod(Line::Parallel, &lod(bounded), 0);
        assert!(of(false).grazed && !of(true).grazed);
        assert_eq!((of(true).layer, of(true).side), (Some(3), of(false).side));
    }
}
