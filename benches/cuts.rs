//! What a cut of a multiresolution model costs: selection from near to far, on all cores and on a device.
//!
//! ```text
//! cargo bench --bench cuts -- MODEL.glb [MODEL.glb ...]
//! cargo bench --bench cuts -- MODEL.glb --primary uv0 --pixels 1 --size 1024
//! ```
//!
//! In: models, each of which is cut mesh by mesh. Out: bytes of the model for each triangle of the reference; for a camera that
//! goes away by factors of two the triangles of the cut, the collapses and blocks asked, and the time of a selection without
//! memory of the one before: on one core, and on a device as its time stamps have it. Medians of the runs.

mod shared;

use clap::Parser;
use glam::{DMat4, DVec3, DVec4};
use invertex::gpu::Context;
use invertex::lod::LodInput;
use invertex::lod::multiresolution::gpu::Selector;
use invertex::lod::multiresolution::{Face, Limits, Memory, Multiresolution, Seen, View};
use invertex::lod::progressive::{Cost, Progressive};
use invertex::mesh::Mesh;
use invertex::param::{PrimaryRequest, parameterize, parts};
use invertex::scene::Scene;
use shared::{Failure, median};
use std::path::PathBuf;
use std::time::Instant;

#[derive(Parser)]
#[command(about = "Times cuts of multiresolution models")]
struct Arguments {
    /// The models.
    models: Vec<PathBuf>,
    /// The primary parameterization.
    #[arg(long, default_value = "auto")]
    primary: String,
    /// The limit on the screen.
    #[arg(long, default_value_t = 0.5)]
    pixels: f64,
    /// Pixels along each side of the picture.
    #[arg(long, default_value_t = 1024)]
    size: u32,
    /// Timed runs.
    #[arg(long, default_value_t = 21)]
    runs: usize,
    /// The device: an index, part of its name, or `all`.
    #[arg(long, default_value = "llvmpipe")]
    device: String,
    /// What `cargo bench` adds.
    #[arg(long, hide = true)]
    bench: bool,
}

/// The sphere round a mesh.
fn sphere(mesh: &Mesh) -> (DVec3, f64) {
    let all = || mesh.positions.iter().map(|p| DVec3::from(p.map(f64::from)));
    let low = all().fold(DVec3::INFINITY, DVec3::min);
    let high = all().fold(DVec3::NEG_INFINITY, DVec3::max);
    ((low + high) * 0.5, (high - low).length() * 0.5)
}

/// A camera that looks along -z from so many radii away; at 3 it sees the sphere whole.
fn seen((centre, radius): (DVec3, f64), radii: f64, size: u32) -> Seen {
    let eye = centre + DVec3::Z * radius * radii;
    let projection = DMat4::from_cols(
        DVec4::X * 2.7,
        DVec4::Y * 2.7,
        DVec4::NEG_W,
        DVec4::Z * radius * 1e-3,
    );
    Seen {
        object_to_view: DMat4::from_translation(-eye),
        projection,
        size: [size; 2],
        double_sided: false,
    }
}

fn history(mesh: &Mesh, primary: &str) -> Result<(Mesh, Progressive), Failure> {
    let chosen = parameterize(mesh, &primary.parse::<PrimaryRequest>()?)?;
    let computed = chosen.computed.as_ref();
    let open = computed.map_or_else(|| mesh.clone(), |c| c.embedding.cut_open(mesh));
    let input = LodInput {
        mesh: &open,
        primary: &chosen.primary,
        parts: &parts(&open, &chosen.primary),
        world: glam::Mat4::IDENTITY.to_cols_array_2d(),
    };
    let history = Progressive::new(&input, Cost::Displacement, 4);
    Ok((open, history))
}

fn bytes(model: &Multiresolution) -> usize {
    let nodes: usize = model.levels.iter().map(Vec::len).sum();
    nodes * size_of::<invertex::lod::multiresolution::Bound>()
        + model.faces.len() * (size_of::<Face>() + size_of::<u32>())
        + model.node.len() * size_of::<u32>()
}

/// Median milliseconds on one core and on the device, and the cut.
fn timed(
    model: &Multiresolution,
    view: View,
    selector: &mut Selector,
    runs: usize,
) -> Result<(f64, f64, usize, usize), Failure> {
    let (mut here, mut there) = (Vec::new(), Vec::new());
    let mut cut = model.select(&[view], &mut Memory::default());
    for _ in 0..runs.max(1) {
        let start = Instant::now();
        cut = model.select(&[view], &mut Memory::default());
        here.push(start.elapsed().as_secs_f64() * 1e3);
        let (other, timings) = selector.select(&[view])?;
        there.push(timings.total as f64 / 1e6);
        if other.faces != cut.faces {
            return Err("the device cuts otherwise than the processor".into());
        }
    }
    Ok((median(&here), median(&there), cut.faces.len(), cut.asked))
}

fn report(mesh: &Mesh, arguments: &Arguments, context: &Context) -> Result<(), Failure> {
    let (open, history) = history(mesh, &arguments.primary)?;
    let model = Multiresolution::new(&history, &open.positions, None);
    let triangles = history.reference.len();
    let mut selector = Selector::new(context, &model, triangles)?;
    println!(
        "{}, {triangles} triangles, {} collapses: {:.0} bytes a triangle, on {}",
        mesh.name,
        model.collapses(),
        bytes(&model) as f64 / triangles as f64,
        context.info().name,
    );
    for radii in [1.5, 3.0, 6.0, 12.0, 24.0, 48.0, 96.0, 192.0] {
        let limits = Limits {
            pixels: arguments.pixels,
            ..Limits::default()
        };
        let view = model.view(&seen(sphere(&open), radii, arguments.size), &limits)?;
        let (here, there, faces, asked) = timed(&model, view, &mut selector, arguments.runs)?;
        println!(
            "  {radii:>5} radii: {faces:>7} triangles, {asked:>7} asked, {here:8.3} ms on one core, {there:8.3} ms on the device"
        );
    }
    Ok(())
}

fn main() -> Result<(), Failure> {
    let arguments = Arguments::parse();
    for context in shared::contexts(&arguments.device)? {
        for model in &arguments.models {
            for mesh in &Scene::load(model)?.meshes {
                report(mesh, &arguments, &context)?;
            }
        }
    }
    Ok(())
}
