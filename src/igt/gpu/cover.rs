//! Bounds and cover on a device: which texels each triangle touches. Shaders: `glsl/igt/bounds.comp`, `split.comp`,
//! `cover.comp`; twin of [`cover`](super::super::cover).
//!
//! Most triangles have a box of one tile and are done in the bounds pass. The others' tiles are spread over threads, so one
//! huge triangle among a million small ones takes as many threads as it has tiles.

use super::super::Reference;
use super::build::Work;
use super::groups;
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Recorder, shaders};
use crate::param::projection::Line;
use rayon::prelude::*;

/// The reference on the device.
struct Upload {
    vertices: Buffer,
    triangles: Buffer,
}

/// Tiles with a mask of the texels that their triangle touches, and how many triangles touch each texel.
pub(super) struct Covered {
    /// A tile for each triangle, then as many as `owners` has.
    pub(super) tiles: Buffer,
    pub(super) count: u32,
    pub(super) owners: Buffer,
    pub(super) counts: Buffer,
}

/// Boxes of more than one tile, or at an octant's border.
struct Boxes {
    records: Buffer,
    /// The number of tiles of each.
    starts: Buffer,
    /// The number of boxes, and of all their tiles in thousands.
    counters: Buffer,
    count: u32,
}

pub(super) fn cover(work: &mut Work<'_>) -> Result<Covered> {
    let (context, reference) = (work.context, work.reference);
    let mesh = Upload {
        vertices: context.upload("reference vertices", &reference.t3)?,
        triangles: context.upload("reference triangles", &reference.triangles)?,
    };
    let triangles = reference.triangles.len() as u64;
    let covered = Covered {
        tiles: context.storage("tiles", triangles * 8)?,
        count: triangles as u32,
        owners: context.storage("tile owners", 0)?,
        counts: context.storage("list starts", (work.texels() + 1) * 4)?,
    };
    let boxes = bounds(work, &mesh, &covered)?;
    if boxes.count == 0 {
        return Ok(covered);
    }
    let tiles = first_tiles(work, &boxes)?;
    large(work, &mesh, covered, &boxes, tiles)
}

fn bounds(work: &mut Work<'_>, mesh: &Upload, covered: &Covered) -> Result<Boxes> {
    use shaders::igt_bounds as pass;
    let (context, bits) = (work.context, work.bits);
    let several = in_several_octants(work.reference);
    let triangles = u64::from(covered.count);
    let most = triangles + 8 * several.len() as u64;
    let mut boxes = Boxes {
        records: context.storage("boxes", most * 16)?,
        starts: context.storage("box starts", (most + 1) * 4)?,
        counters: context.storage("box counters", 8)?,
        count: 0,
    };
    let mut recorder = context.recorder("igt bounds")?;
    recorder.fill(&boxes.counters, 0);
    recorder.fill(&covered.counts, 0);
    let pipeline = work.compute_for_line::<pass::Shader>(pass::LINE)?;
    let bound = pipeline.bind(&pass::Bindings {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        boxes: &boxes.records,
        starts: &boxes.starts,
        counters: &boxes.counters,
        tiles: &covered.tiles,
        counts: &covered.counts,
    })?;
    let count = covered.count;
    recorder.dispatch(&bound, &pass::Push { bits, count }, groups(triangles, 64));
    split(work, &mut recorder, mesh, &boxes, &several)?;
    work.run(recorder)?;
    let counters: Vec<u32> = context.download(&boxes.counters)?;
    // The number of tiles may not fit a word; this is it without the last ten bits of each box's.
    if counters[1] >= 1 << 21 {
        return Err(too_many(u64::from(counters[1]) << 10));
    }
    boxes.count = counters[0];
    Ok(boxes)
}

/// Records the boxes of triangles in several octants.
fn split(
    work: &Work<'_>,
    recorder: &mut Recorder,
    mesh: &Upload,
    boxes: &Boxes,
    several: &[u32],
) -> Result<()> {
    use shaders::igt_split as pass;
    if several.is_empty() {
        return Ok(());
    }
    let list = work
        .context
        .upload("triangles in several octants", several)?;
    let bound = work
        .context
        .compute::<pass::Shader>()?
        .bind(&pass::Bindings {
            vertices: &mesh.vertices,
            triangles: &mesh.triangles,
            boxes: &boxes.records,
            starts: &boxes.starts,
            counters: &boxes.counters,
            several: &list,
        })?;
    let push = pass::Push {
        bits: work.bits,
        count: several.len() as u32,
    };
    recorder.dispatch(&bound, &push, groups(8 * several.len() as u64, 64));
    Ok(())
}

fn too_many(tiles: u64) -> Error {
    Error::Capacity {
        what: "tiles of texels to test".into(),
        need: tiles,
        have: i32::MAX as u64,
    }
}

/// Triangles of the sphere that reach into several octants.
fn in_several_octants(reference: &Reference) -> Vec<u32> {
    if reference.primary.line() != Line::Sphere {
        return Vec::new();
    }
    let spread = |t: &u32| {
        let c = reference.corners(*t as usize);
        let across = |k: usize| c.iter().any(|v| v[k] < 0) && c.iter().any(|v| v[k] > 0);
        (0..3).any(across) && !c.contains(&[0; 3])
    };
    let all = 0..reference.triangles.len() as u32;
    all.into_par_iter().filter(spread).collect()
}

/// Turns the boxes' numbers of tiles into where their tiles begin; how many there are in all.
fn first_tiles(work: &mut Work<'_>, boxes: &Boxes) -> Result<u32> {
    let tiles = work.scan("igt tiles", &boxes.starts, boxes.count.into())?;
    if tiles > i32::MAX as u32 {
        return Err(too_many(tiles.into()));
    }
    Ok(tiles)
}

/// The tiles of the boxes that the bounds pass left.
fn large(
    work: &mut Work<'_>,
    mesh: &Upload,
    small: Covered,
    boxes: &Boxes,
    tiles: u32,
) -> Result<Covered> {
    use shaders::igt_cover as pass;
    let context = work.context;
    let first = small.count;
    let all = u64::from(first) + u64::from(tiles);
    let covered = Covered {
        tiles: context.storage("all tiles", all * 8)?,
        count: all as u32,
        owners: context.storage("tile owners", u64::from(tiles) * 4)?,
        counts: small.counts,
    };
    let pipeline = work.compute_for_line::<pass::Shader>(pass::LINE)?;
    let bound = pipeline.bind(&pass::Bindings {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        boxes: &boxes.records,
        starts: &boxes.starts,
        tiles: &covered.tiles,
        owners: &covered.owners,
        counts: &covered.counts,
    })?;
    let mut recorder = context.recorder("igt cover")?;
    recorder.copy(&small.tiles, &covered.tiles);
    let push = pass::Push {
        bits: work.bits,
        boxes: boxes.count,
        tiles,
        first,
    };
    recorder.dispatch(&bound, &push, groups(tiles.into(), 64));
    work.run(recorder)?;
    Ok(covered)
}
