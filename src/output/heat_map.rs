//! Heat maps: a number for each pixel in false colour, over a scale bar with labels.
//!
//! In: numbers by pixel, the one at the top of the scale (larger ones share its colour, and the bar says so). Out: RGBA of 8 bits, opaque, the picture above and the bar
//! below. The colours are those of the renderer's mode `fetches` ([`legend`]).

use font8x8::UnicodeFonts;

use crate::render::legend;
use crate::{Error, Result};

/// The colour behind everything, and that of text.
const GROUND: [u8; 4] = [24, 25, 28, 255];
const INK: [u8; 4] = [232, 230, 224, 255];
/// Narrower pictures get room at their sides, so that the bar can be read.
const NARROWEST: u32 = 320;
/// Pixels of a character of the font, before scaling.
const CELL: u32 = 8;

/// Pixels of a picture, rows from the top.
#[derive(Debug)]
struct Canvas {
    width: u32,
    height: u32,
    rgba: Vec<u8>,
}

/// The heat map of `values` (row by row from the top; none where nothing is), 0 to `top`, with `title` over the bar:
/// its width, height and RGBA.
///
/// # Errors
/// [`Error::Capacity`] where there are not `width * height` values.
pub fn heat_map(
    [width, height]: [u32; 2],
    values: &[Option<u32>],
    top: u32,
    title: &str,
) -> Result<(u32, u32, Vec<u8>)> {
    let need = u64::from(width) * u64::from(height);
    if need != values.len() as u64 || need == 0 {
        return Err(Error::Capacity {
            what: format!("values of a {width} x {height} heat map"),
            need,
            have: values.len() as u64,
        });
    }
    let top = top.max(1);
    let scale = if width >= 512 { 2 } else { 1 };
    let line = CELL * scale + 6;
    let strip = 3 * line + 14;
    let mut canvas = Canvas::new(width.max(NARROWEST), height + strip);
    let side = (canvas.width - width) / 2;
    let colours = legend(top as usize + 1);
    for (at, value) in values.iter().enumerate() {
        if let Some(value) = value {
            let [r, g, b] = colours[(*value).min(top) as usize].1;
            let (x, y) = (at as u32 % width, at as u32 / width);
            canvas.put(side + x, y, [r, g, b, 255]);
        }
    }
    let y = height + 10;
    let fits = CELL * scale * title.chars().count() as u32 <= canvas.width;
    canvas.centred(canvas.width / 2, y, if fits { scale } else { 1 }, title);
    let beyond = values.iter().flatten().any(|&value| value > top);
    canvas.bar(y + line, line - 4, top, scale, beyond);
    Ok((canvas.width, canvas.height, canvas.rgba))
}

impl Canvas {
    fn new(width: u32, height: u32) -> Self {
        let pixels = width as usize * height as usize;
        Canvas {
            width,
            height,
            rgba: GROUND.repeat(pixels),
        }
    }

    fn put(&mut self, x: u32, y: u32, colour: [u8; 4]) {
        if x < self.width && y < self.height {
            let at = (y as usize * self.width as usize + x as usize) * 4;
            self.rgba[at..at + 4].copy_from_slice(&colour);
        }
    }

    /// The scale: its colours from 0 to `top`, and labels under it; `beyond`: its end stands for more, too.
    fn bar(&mut self, y: u32, height: u32, top: u32, scale: u32, beyond: bool) {
        let margin = 5 * CELL * scale / 2;
        let length = self.width - 2 * margin;
        let colours = legend(length as usize);
        for (x, (_, [r, g, b])) in colours.into_iter().enumerate() {
            for row in 0..height {
                self.put(margin + x as u32, y + row, [r, g, b, 255]);
            }
        }
        let step = label_step(top, length / (6 * CELL * scale));
        let mut labels: Vec<u32> = (0..=top).step_by(step as usize).collect();
        if beyond {
            // The end is named, in place of a label that would touch it.
            labels.retain(|&value| top - value > step / 2);
            labels.push(top);
        }
        for value in labels {
            let share = f64::from(value) / f64::from(top);
            let x = margin + (share * f64::from(length - 1)).round() as u32;
            for row in 0..4 {
                self.put(x, y + height + row, INK);
            }
            let more = if beyond && value == top { "+" } else { "" };
            self.centred(x, y + height + 6, scale, &format!("{value}{more}"));
        }
    }

    /// Text whose middle is at `x`, its upper edge at `y`.
    fn centred(&mut self, x: u32, y: u32, scale: u32, text: &str) {
        let half = text.chars().count() as u32 * CELL * scale / 2;
        let mut left = x.saturating_sub(half);
        for character in text.chars() {
            let glyph = font8x8::BASIC_FONTS
                .get(character)
                .or_else(|| font8x8::LATIN_FONTS.get(character));
            // A character that the font lacks is left blank.
            for (row, bits) in glyph.unwrap_or_default().into_iter().enumerate() {
                for column in (0..CELL).filter(|c| bits >> c & 1 == 1) {
                    for dot in 0..scale * scale {
                        let (dx, dy) = (dot % scale, dot / scale);
                        let (px, py) = (left + column * scale + dx, y + row as u32 * scale + dy);
                        self.put(px, py, INK);
                    }
                }
            }
            left += CELL * scale;
        }
    }
}

/// The distance between labels, 1, 2 or 5 times a power of ten, so that at most `most` fit beside zero.
fn label_step(top: u32, most: u32) -> u32 {
    let enough = |step: &u32| top / step <= most.max(1);
    let steps = (0..10).flat_map(|e| [1u32, 2, 5].map(|m| 10u32.pow(e).saturating_mul(m)));
    steps.into_iter().find(enough).unwrap_or(top.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pixel(map: &(u32, u32, Vec<u8>), x: u32, y: u32) -> [u8; 4] {
        let at = (y as usize * map.0 as usize + x as usize) * 4;
        map.2[at..at + 4].try_into().unwrap()
    }

    #[test]
    fn pixels_have_the_colours_of_the_bar() {
        let mut values = vec![Some(0); 512 * 4];
        (values[1], values[2], values[3]) = (Some(10), None, Some(99));
        let map = heat_map([512, 4], &values, 10, "fetches").unwrap();
        let ends = [legend(2)[0].1, legend(2)[1].1].map(|[r, g, b]| [r, g, b, 255]);
        let row = [0, 1, 2, 3].map(|x| pixel(&map, x, 0));
        assert_eq!(row, [ends[0], ends[1], GROUND, ends[1]]);
        // The bar's own ends, and some ink of the labels below.
        let y = 4 + 10 + CELL * 2 + 6;
        let margin = 5 * CELL;
        assert_eq!(pixel(&map, margin, y), ends[0]);
        assert_eq!(pixel(&map, 511 - margin, y), ends[1]);
        let below = map.2[(y + 18) as usize * 512 * 4..].chunks_exact(4);
        assert!(below.filter(|p| **p == INK).count() > 50);
    }

    #[test]
    fn labels_are_round_and_not_too_many() {
        assert_eq!(
            [label_step(7, 8), label_step(16, 8), label_step(44, 8)],
            [1, 2, 5]
        );
        assert_eq!(label_step(4_000_000_000, 8), 500_000_000);
    }

    #[test]
    fn values_that_do_not_fill_the_picture_are_refused() {
        assert!(heat_map([2, 2], &[None; 3], 4, "").is_err());
        assert!(heat_map([0, 2], &[], 4, "").is_err());
        assert!(heat_map([2, 2], &[None; 4], 0, "é →").is_ok());
    }
}
