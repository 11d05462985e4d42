//! Makes `assets/amphora.glb`, the model that `invertex demo` runs on: a lidded Greek vase, painted by signed
//! distance functions.
//!
//! In: nothing but the code in this folder. Out: one GLB (under 3 MB) and, with `--check`, a comparison of its
//! sha256 with the committed file.
//!
//! ```text
//! cargo run --example make-asset             writes assets/amphora.glb
//! cargo run --example make-asset -- FILE     writes FILE
//! cargo run --example make-asset -- --check  makes it in memory; fails when the committed file differs
//! ```
//!
//! The body is radius = f(height, angle), so the cylinder about y is one-to-one over all of it, relief included.
//! The artist's uv are something else altogether: some twenty unrolled panels, some lying on their side.
//! Every transcendental function comes from `libm`, never from the platform, so the bytes are the same everywhere.

mod animals;
mod atlas;
mod bands;
mod figures;
mod glb;
mod mesh;
mod noise;
mod ornament;
mod profile;
mod relief;
mod sdf;
mod surface;
mod texture;

use sha2::{Digest, Sha256};
use std::path::Path;
use std::process::ExitCode;

const COMMITTED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/amphora.glb");

fn make() -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let profile = profile::Profile::vase();
    let surface = surface::Surface { profile: &profile };
    let atlas = atlas::Atlas::pack(atlas::charts(&profile), texture::COLOUR_TEXELS as f32);
    let mesh = mesh::tessellate(&surface, &atlas);
    let images = texture::paint(&surface, &atlas);
    eprintln!(
        "amphora: {} triangles, {} vertices, {} charts, {:.0} texels per unit",
        mesh.indices.len() / 3,
        mesh.positions.len(),
        atlas.charts.len(),
        atlas.texels_per_unit
    );
    glb::write(&mesh, &images)
}

fn hex(bytes: &[u8]) -> String {
    Sha256::digest(bytes)
        .iter()
        .map(|b| format!("{b:02x}"))
        .collect()
}

fn main() -> ExitCode {
    let argument = std::env::args().nth(1);
    let run = || -> Result<ExitCode, Box<dyn std::error::Error>> {
        let bytes = make()?;
        if argument.as_deref() == Some("--check") {
            let committed = std::fs::read(COMMITTED)?;
            let (made, kept) = (hex(&bytes), hex(&committed));
            if made != kept {
                eprintln!(
                    "assets/amphora.glb is not what tools/make_asset makes: {kept} committed, {made} made."
                );
                eprintln!(
                    "Run `cargo run --example make-asset` and look at the result before committing it."
                );
                return Ok(ExitCode::FAILURE);
            }
            println!(
                "assets/amphora.glb: {} bytes, sha256 {made}, as made by tools/make_asset",
                bytes.len()
            );
            return Ok(ExitCode::SUCCESS);
        }
        let path = argument.as_deref().unwrap_or(COMMITTED);
        std::fs::write(Path::new(path), &bytes)?;
        println!("{path}: {} bytes, sha256 {}", bytes.len(), hex(&bytes));
        Ok(ExitCode::SUCCESS)
    };
    run().unwrap_or_else(|error| {
        eprintln!("make-asset: {error}");
        ExitCode::FAILURE
    })
}
