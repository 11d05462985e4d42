//! The size of an image and the direction it is looked at from, as options.

use std::str::FromStr;

/// Pixels across and down.
#[derive(Clone, Copy)]
pub(super) struct Size(pub(super) u32, pub(super) u32);

impl FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let side = |side: &str| side.parse::<u32>().ok().filter(|&n| n > 0);
        let (width, height) = text.split_once(['x', 'X']).unwrap_or((text, text));
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(Size(width, height)),
            _ => Err(format!("\"{text}\" is not a size such as 640x480 or 512")),
        }
    }
}

/// Azimuth and elevation, degrees.
#[derive(Clone, Copy)]
pub(super) struct Angles(pub(super) f64, pub(super) f64);

impl FromStr for Angles {
    type Err = String;

    fn from_str(text: &str) -> std::result::Result<Self, String> {
        let angle = |text: &str| text.trim().parse::<f64>().ok().filter(|a| a.is_finite());
        let both = text
            .split_once(',')
            .and_then(|(a, e)| Some(Angles(angle(a)?, angle(e)?)));
        both.ok_or_else(|| format!("\"{text}\" is not two angles such as 30,20"))
    }
}
