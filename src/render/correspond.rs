//! From a drawn triangle to the point of the reference it stands for. Twin of `glsl/render/correspond.glsl`.

use super::draw::DrawRecord;
use super::picture::Picture;
use super::shade::Drawn;
use crate::attribute::arithmetic::sub3;
use crate::attribute::surface::SurfacePoint;

/// What a correspondence answers.
pub(crate) struct Correspondence {
    pub point: SurfacePoint,
    /// Fetches it took.
    pub fetches: u32,
}

/// The point of the reference under a pixel.
pub(crate) fn find(_picture: &Picture, draw: &DrawRecord, drawn: &Drawn) -> Correspondence {
    identity(draw, drawn)
}

/// The drawn triangle is the reference's own.
fn identity(draw: &DrawRecord, drawn: &Drawn) -> Correspondence {
    let point = SurfacePoint {
        triangle: draw.attribute_base + drawn.local,
        b: drawn.b,
        dx: drawn.bx.map(|b| sub3(b, drawn.b)),
        dy: drawn.by.map(|b| sub3(b, drawn.b)),
    };
    Correspondence { point, fetches: 0 }
}
