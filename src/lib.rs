//! Inverse geometric textures: one reference mesh, any level of detail, all of its appearance.
//!
#![doc = include_str!("../assets/pipeline.svg")]
//!
//! A *primary parameterization* M_T gives every point of the reference an address in a square ([`param`]). The tables
//! of [`igt`] invert it: each texel of a hash texture lists the reference triangles that reach it. A point of any
//! simplified version has an address too; its list is tested with exact integers, one triangle owns the point, and
//! every attribute of the reference can be fetched there ([`attribute`]), per pixel, without baking anything.
//!
//! ```
//! use invertex::igt::{self, BuildOptions, Layout, Needs, Reference};
//! use invertex::mesh::shapes;
//! use invertex::param::{Primary, PrimaryKind};
//!
//! # fn main() -> invertex::Result<()> {
//! // The reference: a ball of 512 triangles. Its primary parameterization: central projection.
//! let ball = shapes::icosphere(3);
//! let primary = Primary::new(PrimaryKind::Sphere, &ball, [0.0; 3])?;
//! let one_part = vec![0; ball.triangles.len()];
//! let reference = Reference::new(&ball, &primary, &one_part, Layout::Packed)?;
//! let options = BuildOptions { hash: 64, layout: Layout::Packed };
//! let tables = igt::build_cpu(&reference, &Needs::default(), options)?;
//!
//! // A point in the middle of a face of an octahedron, the ball's coarsest version: where on the ball is it?
//! let query = primary.to_query(primary.t3_of_position([1.0 / 3.0; 3]));
//! let found = tables.lookup(query, None, false).expect("the ball covers every direction");
//! let corners = ball.corners(found.triangle as usize);
//! let point: [f32; 3] = std::array::from_fn(|k| (0..3).map(|i| found.barycentric[i] * corners[i][k]).sum());
//! assert!(point.iter().all(|c| (c - 1.0 / 3.0f32.sqrt()).abs() < 0.01));
//! # Ok(())
//! # }
//! ```
//!
//! The modules are listed in the order data flows: [`scene`] reads glTF, [`mesh`] holds it, [`param`] and [`lod`] prepare
//! it, [`igt`] builds the tables, [`asset`] writes and reads the result, [`render`] draws it, [`recover`] bakes it. The feature `gpu` adds
//! Vulkan; without it the CPU reference does everything, and gives the same bytes.

pub mod asset;
pub mod attribute;
pub mod error;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod igt;
pub mod lod;
pub mod measure;
pub mod mesh;
pub mod output;
pub mod param;
pub mod recover;
pub mod render;
pub mod scene;

pub use error::{Error, Result};
