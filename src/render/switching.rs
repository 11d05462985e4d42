//! Switching between levels of detail in a sequence without a pop.
//!
//! In: for each frame the level that a bound asks for. Out: [`Step`]: what is drawn, and how two images are laid over each
//! other. A level is kept until the bound is reached; then both it and the next are drawn for a few frames, and their
//! images blended. Whatever is asked for meanwhile waits, so that never more than two levels are drawn.
//! Source: Giegl, Wimmer, *Unpopping: Solving the Image-Space Blend Problem for Smooth Discrete LOD Transitions* (2007). They
//! lay one level over the other in the frame buffer, one of the two always opaque so that no background shines through;
//! here both have an image of their own, and coverage blends as colour does.

use super::constants::{THRESHOLDS_AT, constants};
use super::renderer::Rendered;
use super::shade::NOTHING;
use crate::attribute::arithmetic::{srgb_encode, unit_encode};

/// The levels of a sequence's frames.
#[derive(Clone, Debug)]
pub struct Switching {
    frames: u32,
    level: Option<usize>,
    /// The level that is left, and frames since.
    leaving: Option<(usize, u32)>,
}

/// What a frame shows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The level.
    pub level: usize,
    /// While a switch goes on: the level that is left, and how much of the image is [`Step::level`]'s already, 0 to 1.
    pub leaving: Option<(usize, f32)>,
}

impl Switching {
    /// Blends for `frames` frames, 0 for none.
    pub fn new(frames: u32) -> Self {
        Switching {
            frames,
            level: None,
            leaving: None,
        }
    }

    /// The next frame, for which `wanted` is asked.
    pub fn next(&mut self, wanted: usize) -> Step {
        let level = self.level.unwrap_or(wanted);
        self.leaving = match self.leaving {
            Some((old, since)) if since < self.frames => Some((old, since + 1)),
            _ => None,
        };
        self.level = Some(level);
        if self.leaving.is_none() && wanted != level {
            self.leaving = (self.frames > 0).then_some((level, 1));
            self.level = Some(wanted);
        }
        let share = |since: u32| since as f32 / (self.frames + 1) as f32;
        Step {
            level: self.level.unwrap_or(wanted),
            leaving: self.leaving.map(|(old, since)| (old, share(since))),
        }
    }
}

/// `from` and `to` blended, `share` of it `to`, in linear light, weighted by coverage; what else is known of a pixel is that
/// of the image with the larger share. Both are lit or unlit images of one size.
///
/// # Panics
/// Where the sizes differ.
pub fn blended(from: &Rendered, to: &Rendered, share: f32) -> Rendered {
    assert_eq!((from.width, from.height), (to.width, to.height));
    let table = constants();
    let thresholds = &table[THRESHOLDS_AT..THRESHOLDS_AT + 256];
    let (f, t) = (1.0 - share, share);
    let mut out = if share < 0.5 { from } else { to }.clone();
    for (k, linear) in out.linear.iter_mut().enumerate() {
        let (a, b) = (from.linear[k], to.linear[k]);
        let alpha = a[3] * f + b[3] * t;
        *linear = [0.0; 4];
        if alpha > 0.0 {
            *linear = [0, 1, 2, 3].map(|i| (a[i] * a[3] * f + b[i] * b[3] * t) / alpha);
            linear[3] = alpha;
        }
        let [r, g, b, a] = *linear;
        let codes = [r, g, b].map(|c| srgb_encode(thresholds, c) as u8);
        let rgba = [codes[0], codes[1], codes[2], unit_encode(a) as u8];
        out.rgba8[4 * k..4 * k + 4].copy_from_slice(if alpha > 0.0 { &rgba } else { &[0; 4] });
    }
    let covered = |k: &usize| from.draw[*k] != NOTHING || to.draw[*k] != NOTHING;
    out.covered_pixels = (0..out.linear.len()).filter(covered).count() as u64;
    out.mean_fetches = from.mean_fetches + to.mean_fetches;
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn steps(frames: u32, wanted: &[usize]) -> Vec<Step> {
        let mut switching = Switching::new(frames);
        wanted.iter().map(|&w| switching.next(w)).collect()
    }

    fn plain(level: usize) -> Step {
        Step {
            level,
            leaving: None,
        }
    }

    #[test]
    fn a_switch_takes_its_frames_and_ends() {
        let all = steps(3, &[2, 2, 1, 1, 1, 1, 1]);
        let blend = |share| Step {
            level: 1,
            leaving: Some((2, share)),
        };
        assert_eq!(
            all,
            [
                plain(2),
                plain(2),
                blend(0.25),
                blend(0.5),
                blend(0.75),
                plain(1),
                plain(1)
            ]
        );
    }

    #[test]
    fn without_frames_it_pops() {
        assert_eq!(steps(0, &[2, 1, 0]), [plain(2), plain(1), plain(0)]);
    }

    #[test]
    fn what_is_asked_for_meanwhile_waits() {
        let all = steps(2, &[3, 2, 1, 1, 1, 1, 1]);
        let levels: Vec<_> = all
            .iter()
            .map(|s| (s.level, s.leaving.map(|l| l.0)))
            .collect();
        let expected = [
            (3, None),
            (2, Some(3)),
            (2, Some(3)),
            (1, Some(2)),
            (1, Some(2)),
            (1, None),
            (1, None),
        ];
        assert_eq!(levels, expected);
    }

    #[test]
    fn images_blend_in_linear_light_and_by_coverage() {
        let one = |linear: [f32; 4]| Rendered {
            width: 1,
            height: 1,
            rgba8: vec![0; 4],
            linear: vec![linear],
            triangle: vec![0],
            draw: vec![if linear[3] > 0.0 { 0 } else { NOTHING }],
            barycentric: vec![[0.0; 2]],
            fetches: vec![0],
            depth: vec![1.0],
            ..Rendered::default()
        };
        let (black, white) = (one([0.0, 0.0, 0.0, 1.0]), one([1.0; 4]));
        let half = blended(&black, &white, 0.5);
        assert_eq!(half.linear[0], [0.5, 0.5, 0.5, 1.0]);
        assert_eq!(half.rgba8, [188, 188, 188, 255]);
        let fading = blended(&white, &one([0.0; 4]), 0.25);
        assert_eq!(fading.linear[0], [1.0, 1.0, 1.0, 0.75]);
        assert_eq!((fading.rgba8[0], fading.covered_pixels), (255, 1));
        let nothing = blended(&one([0.0; 4]), &one([0.0; 4]), 0.5);
        assert_eq!(
            (&nothing.rgba8[..], nothing.covered_pixels),
            (&[0u8; 4][..], 0)
        );
    }
}
