//! Matrices of cameras.
#![allow(dead_code, reason = "each test file uses a part")]

use glam::{DMat4, DVec3, DVec4};

/// From the world to a camera at `eye` that looks at a point.
pub(crate) fn looking(eye: DVec3, at: DVec3, up: DVec3) -> DMat4 {
    let back = (eye - at).normalize();
    let right = up.cross(back).normalize();
    let up = back.cross(right);
    let turned = DMat4::from_cols(
        right.extend(0.0),
        up.extend(0.0),
        back.extend(0.0),
        DVec4::W,
    );
    turned.transpose() * DMat4::from_translation(-eye)
}

/// `angle` is half the height's.
pub(crate) fn perspective(angle: f64, aspect: f64) -> DMat4 {
    let y = 1.0 / angle.tan();
    DMat4::from_cols(
        DVec4::X * (y / aspect),
        DVec4::Y * y,
        DVec4::NEG_W,
        DVec4::Z * 1e-3,
    )
}

/// A picture that is `half` units high from its middle.
pub(crate) fn parallel(half: f64, aspect: f64) -> DMat4 {
    let scale = DVec3::new(1.0 / (half * aspect), 1.0 / half, -1e-5);
    DMat4::from_scale(scale)
}
