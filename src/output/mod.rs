//! What leaves the program as files: PNG and EXR pictures and the HTML report.
//!
//! In: finished pixels and numbers. Out: bytes on disk, complete or not at all ([`write_bytes`] writes beside the
//! target and renames). Encoders are pure functions to bytes, so the same picture gives the same file everywhere.

mod exr;
mod file;
mod glb;
mod heat_map;
mod map_picture;
mod png;
pub mod report;

pub use exr::{Aov, encode_exr, encode_exr_half, encode_exr_mapping};
pub use file::{check_target, make_folder, write_bytes};
pub use glb::{TexturePlace, TexturedMesh, encode_glb};
pub use heat_map::heat_map;
pub use map_picture::{MapPictures, map_pictures};
pub use png::{encode_grey, encode_png, encode_texture, encode_texture16};
