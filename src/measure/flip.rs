//! FLIP: how different two pictures look when one alternates with the other.
//!
//! In: two 8-bit sRGB pictures of one size. Out: an error in 0..1 for each pixel. Andersson et al., "FLIP: A
//! Difference Evaluator for Alternating Images", HPG 2020; NVIDIA's own code through the `nv-flip` crate, at its
//! default of 67 pixels a degree.

/// FLIP's filters reach ten-odd pixels; a crop with this margin of equal pixels gives the same map.
const MARGIN: usize = 32;

/// A rectangle of pixels: `x0..x1`, `y0..y1`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Window {
    pub(super) x0: usize,
    pub(super) y0: usize,
    pub(super) x1: usize,
    pub(super) y1: usize,
}

impl Window {
    /// The smallest rectangle round the pixels of `mask`, widened by FLIP's reach; `None` when there are none.
    pub(super) fn around(mask: &[bool], width: usize, height: usize) -> Option<Self> {
        let mut found: Option<Window> = None;
        for (i, _) in mask.iter().enumerate().filter(|(_, inside)| **inside) {
            let (x, y) = (i % width, i / width);
            let w = found.get_or_insert(Window {
                x0: x,
                y0: y,
                x1: x,
                y1: y,
            });
            *w = Window {
                x0: w.x0.min(x),
                y0: w.y0.min(y),
                x1: w.x1.max(x),
                y1: w.y1.max(y),
            };
        }
        found.map(|w| Window {
            x0: w.x0.saturating_sub(MARGIN),
            y0: w.y0.saturating_sub(MARGIN),
            x1: (w.x1 + 1 + MARGIN).min(width),
            y1: (w.y1 + 1 + MARGIN).min(height),
        })
    }

    fn width(&self) -> usize {
        self.x1 - self.x0
    }

    fn height(&self) -> usize {
        self.y1 - self.y0
    }

    fn crop(&self, rgb: &[[u8; 3]], width: usize) -> nv_flip::FlipImageRgb8 {
        let rows = (self.y0..self.y1).flat_map(|y| &rgb[y * width + self.x0..y * width + self.x1]);
        let bytes: Vec<u8> = rows.flatten().copied().collect();
        nv_flip::FlipImageRgb8::with_data(self.width() as u32, self.height() as u32, &bytes)
    }
}

/// FLIP of each pixel of a `width`-wide picture; 0 outside `window`.
pub(super) fn flip_map(
    reference: &[[u8; 3]],
    test: &[[u8; 3]],
    width: usize,
    window: Window,
) -> Vec<f32> {
    let (a, b) = (window.crop(reference, width), window.crop(test, width));
    let part = nv_flip::flip(a, b, nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec();
    let mut map = vec![0.0; reference.len()];
    for (row, values) in part.chunks_exact(window.width()).enumerate() {
        let start = (window.y0 + row) * width + window.x0;
        map[start..start + values.len()].copy_from_slice(values);
    }
    map
}

/// FLIP's customary colours for a map of errors: black (none) over violet and orange to light yellow.
pub(super) fn magma(map: &[f32]) -> Vec<[u8; 4]> {
    let lut = nv_flip::magma_lut().to_vec();
    let last = lut.len() / 3 - 1;
    let colour = |e: &f32| {
        let at = ((e.clamp(0.0, 1.0) * last as f32 + 0.5) as usize).min(last) * 3;
        [lut[at], lut[at + 1], lut[at + 2], 255]
    };
    map.iter().map(colour).collect()
}
