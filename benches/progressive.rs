//! How fast a mesh is simplified with its texture bounded, and how well, beside meshoptimizer.
//!
//! ```text
//! cargo bench --bench progressive -- MODEL.glb [MODEL.glb ...]                    the whole history
//! cargo bench --bench progressive -- MODEL.glb --primary uv0 --fraction 0.05     another primary, another count
//! cargo bench --bench progressive -- MODEL.glb --cost quadric                     the surface alone decides the order
//! ```
//!
//! In: models, each of which is simplified mesh by mesh. Out: for ours the triangles removed a second (deviations of all new
//! triangles included), for meshoptimizer (half-edge collapses, positions alone, no texture bound) the same; the distance of
//! both results from the reference, measured alike; the largest bound of ours. Medians of the runs.

mod shared;

use clap::Parser;
use invertex::lod::LodInput;
use invertex::lod::deviation::deviation;
use invertex::lod::progressive::{Cost, Progressive};
use invertex::mesh::Mesh;
use invertex::param::{PrimaryRequest, parameterize, parts};
use invertex::scene::Scene;
use shared::{Failure, median};
use std::path::PathBuf;
use std::time::Instant;

#[derive(Parser)]
#[command(about = "Times progressive meshes")]
struct Arguments {
    /// The models.
    models: Vec<PathBuf>,
    /// The primary parameterization.
    #[arg(long, default_value = "auto")]
    primary: String,
    /// Of the triangles, what is left.
    #[arg(long, default_value_t = 0.02)]
    fraction: f64,
    /// What a collapse costs.
    #[arg(long, value_enum, default_value_t = By::Displacement)]
    cost: By,
    /// Timed runs.
    #[arg(long, default_value_t = 3)]
    runs: usize,
    /// What `cargo bench` adds.
    #[arg(long, hide = true)]
    bench: bool,
}

#[derive(Clone, Copy, clap::ValueEnum)]
enum By {
    Displacement,
    Quadric,
}

impl From<By> for Cost {
    fn from(by: By) -> Self {
        match by {
            By::Displacement => Cost::Displacement,
            By::Quadric => Cost::Quadric,
        }
    }
}

/// The median milliseconds of `work`, and its last result.
fn time<T>(runs: usize, work: impl Fn() -> T) -> (f64, T) {
    let mut last = work();
    let mut all = Vec::new();
    for _ in 0..runs.max(1) {
        let start = Instant::now();
        last = work();
        all.push(start.elapsed().as_secs_f64() * 1e3);
    }
    (median(&all), last)
}

/// Half-edge collapses by meshoptimizer over welded positions.
fn peer(mesh: &Mesh, target: usize) -> Vec<[u32; 3]> {
    let weld = invertex::mesh::Weld::by_position(&mesh.positions);
    let indices: Vec<u32> = weld
        .triangles(&mesh.triangles)
        .into_iter()
        .flatten()
        .collect();
    let bytes = mesh
        .positions
        .as_flattened()
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect::<Vec<u8>>();
    let Ok(positions) = meshopt::VertexDataAdapter::new(&bytes, 12, 0) else {
        return Vec::new();
    };
    let options = meshopt::SimplifyOptions::None;
    let simplified = meshopt::simplify(&indices, &positions, target * 3, 1e9, options, None);
    simplified.as_chunks::<3>().0.to_vec()
}

fn report(mesh: &Mesh, arguments: &Arguments) -> Result<(), Failure> {
    let chosen = parameterize(mesh, &arguments.primary.parse::<PrimaryRequest>()?)?;
    let open = chosen
        .computed
        .map_or_else(|| mesh.clone(), |c| c.embedding.cut_open(mesh));
    let parts = parts(&open, &chosen.primary);
    let input = LodInput {
        mesh: &open,
        primary: &chosen.primary,
        parts: &parts,
        world: glam::Mat4::IDENTITY.to_cols_array_2d(),
    };
    let target = (mesh.triangles.len() as f64 * arguments.fraction) as usize;
    let (ms, progressive) = time(arguments.runs, || {
        Progressive::new(&input, arguments.cost.into(), target)
    });
    let last: Vec<_> = progressive.after(progressive.collapses.len()).collect();
    let bound = last.iter().map(|t| t.deviation.total).fold(0.0, f32::max);
    let ours: Vec<[u32; 3]> = last.iter().map(|t| t.corners).collect();
    let (peer_ms, theirs) = time(arguments.runs, || peer(mesh, ours.len()));
    let reference = (&mesh.positions[..], &mesh.triangles[..]);
    let far = |triangles: &[[u32; 3]]| deviation(reference, (&open.positions, triangles));
    let (a, b) = (far(&ours), deviation(reference, (&mesh.positions, &theirs)));
    let speed = |left: usize, ms: f64| (mesh.triangles.len() - left) as f64 / ms;
    println!(
        "{} ({}, {} triangles) to {}: {:.0} k triangles/s, {:.1} ms, bound {:.3e}, distance max {:.3e} rms {:.3e}, {:.0} bytes a triangle",
        mesh.name,
        chosen.primary.kind,
        mesh.triangles.len(),
        ours.len(),
        speed(ours.len(), ms),
        ms,
        bound,
        a.max,
        a.rms,
        (progressive.triangles.len() * size_of::<invertex::lod::progressive::Made>()) as f64
            / mesh.triangles.len() as f64,
    );
    println!(
        "  meshoptimizer to {}: {:.0} k triangles/s, {:.1} ms, distance max {:.3e} rms {:.3e}; ours / theirs: max {:.2} rms {:.2}",
        theirs.len(),
        speed(theirs.len(), peer_ms),
        peer_ms,
        b.max,
        b.rms,
        a.max / b.max,
        a.rms / b.rms
    );
    Ok(())
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    for model in &arguments.models {
        for mesh in &Scene::load(model)?.meshes {
            report(mesh, &arguments)?;
        }
    }
    Ok(())
}
