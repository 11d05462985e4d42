//! The part of the hash texture that is stored.

use serde::{Deserialize, Serialize};

/// The texels that are stored: charts seldom fill the unit square. Beyond them there is no list.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Window {
    /// First column and row.
    pub at: [u32; 2],
    /// Columns and rows.
    pub size: [u32; 2],
}

impl Window {
    /// All texels of a hash texture of `hash` columns and rows.
    pub fn whole(hash: u32) -> Self {
        Window {
            at: [0; 2],
            size: [hash; 2],
        }
    }

    /// The smallest window around the given texels; of one texel where there are none.
    pub fn around(texels: impl Iterator<Item = [u32; 2]>) -> Self {
        let (mut low, mut high) = ([u32::MAX; 2], [0; 2]);
        for texel in texels {
            for k in 0..2 {
                low[k] = low[k].min(texel[k]);
                high[k] = high[k].max(texel[k]);
            }
        }
        if low[0] > high[0] {
            (low, high) = ([0; 2], [0; 2]);
        }
        Window {
            at: low,
            size: [high[0] - low[0] + 1, high[1] - low[1] + 1],
        }
    }

    /// The number of texels.
    pub fn texels(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize
    }

    /// Where a texel is stored, row by row; none outside.
    pub fn index(&self, [x, y]: [u32; 2]) -> Option<usize> {
        let (x, y) = (x.wrapping_sub(self.at[0]), y.wrapping_sub(self.at[1]));
        let inside = x < self.size[0] && y < self.size[1];
        inside.then(|| y as usize * self.size[0] as usize + x as usize)
    }

    /// Whether it lies in a hash texture of `hash` columns and rows, and is not empty.
    pub(in crate::igt) fn fits(&self, hash: u32) -> bool {
        (0..2).all(|k| self.size[k] > 0 && self.at[k] < hash && self.size[k] <= hash - self.at[k])
    }

    /// As shaders have it: first column and row, columns and rows, 16 bits each.
    pub fn words(&self) -> [u32; 2] {
        [self.at, self.size].map(|[x, y]| x | y << 16)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_window_holds_what_it_was_drawn_around() {
        let texels = [[5, 9], [7, 2], [6, 6]];
        let window = Window::around(texels.into_iter());
        assert_eq!((window.at, window.size), ([5, 2], [3, 8]));
        assert!(window.fits(10) && !window.fits(9));
        let all: Vec<usize> = (2..10)
            .flat_map(|y| (5..8).map(move |x| [x, y]))
            .filter_map(|t| window.index(t))
            .collect();
        assert_eq!(all, (0..window.texels()).collect::<Vec<_>>());
        for outside in [[4, 5], [8, 5], [6, 1], [6, 10], [0, 0]] {
            assert_eq!(window.index(outside), None);
        }
        assert_eq!(Window::around(std::iter::empty()).texels(), 1);
    }
}
