//! The build on a device: bounds -> scan -> cover -> scan -> scatter -> order -> gutter. Shaders: `glsl/igt/`.
//!
//! Work items are texels of boxes, not triangles, so one huge triangle among a million small ones is spread over as many
//! threads as it covers texels. Atomics hand out slots; the order pass makes the result independent of them.

use super::super::build::{Lists, check_layout, finish};
use super::super::gutter::{self, Gutter, Needs};
use super::super::{BuildOptions, Reference, Tables};
use super::{groups, scan};
use crate::error::{Error, Result};
use crate::gpu::{Buffer, Context, Timings, shaders};
use crate::param::projection::Line;

/// Tables and how long each pass took.
#[derive(Debug)]
pub struct Timed {
    /// The tables.
    pub tables: Tables,
    /// The passes' times on the device.
    pub timings: Vec<Timings>,
}

/// Builds the tables on a device. The bytes equal those of [`build_cpu`](super::super::build_cpu).
///
/// # Errors
/// Those of the CPU build, and [`Error::Capacity`] where the work does not fit a storage buffer of the device.
pub fn build(
    context: &Context,
    reference: &Reference,
    needs: &Needs,
    options: BuildOptions,
) -> Result<Timed> {
    let bits = options.bits()?;
    check_layout(reference, options)?;
    let mut timings = Vec::new();
    let mesh = Upload::new(context, reference)?;
    let covered = cover(context, reference, &mesh, bits, &mut timings)?;
    let raw = order(context, reference, &covered, bits, &mut timings)?;
    let lists = download(context, &raw, bits)?;
    let gutter = fill_gutter(context, reference, &raw, needs, bits, &mut timings)?;
    let tables = finish(reference, options, &lists, &gutter)?;
    Ok(Timed { tables, timings })
}

/// The reference on the device.
struct Upload {
    vertices: Buffer,
    triangles: Buffer,
}

impl Upload {
    fn new(context: &Context, reference: &Reference) -> Result<Self> {
        Ok(Upload {
            vertices: context.upload("reference vertices", &reference.t3)?,
            triangles: context.upload("reference triangles", &reference.triangles)?,
        })
    }
}

/// (texel, triangle) pairs, some of them void, and how many each texel has.
struct Covered {
    pairs: Buffer,
    items: u32,
    counts: Buffer,
}

fn cover(
    context: &Context,
    reference: &Reference,
    mesh: &Upload,
    bits: u32,
    timings: &mut Vec<Timings>,
) -> Result<Covered> {
    let line = reference.primary.line();
    let count = reference.triangles.len() as u32;
    let box_count = count as u64 + extra_boxes(reference, line);
    let boxes = context.storage("boxes", box_count * 16)?;
    let starts = context.storage("box starts", (box_count + 1) * 4)?;
    let extra = context.upload("extra boxes", &[0u32])?;

    use shaders::{igt_bounds as bounds, igt_cover as cover};
    let mut recorder = context.recorder("igt bounds")?;
    recorder.fill(&starts, 0);
    let bindings = bounds::Bindings {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        boxes: &boxes,
        areas: &starts,
        extra: &extra,
    };
    let bound = context.compute::<bounds::Shader>()?.bind(&bindings)?;
    let push = bounds::Push {
        line: line as u32,
        bits,
        count,
        boxes: box_count as u32,
    };
    recorder.dispatch(&bound, &push, groups(count.into(), 64));
    scan::record(context, &mut recorder, &starts, box_count + 1)?;
    let total = context.storage("items", 4)?;
    recorder.copy_range(&starts, box_count * 4, &total, 0, 4);
    timings.push(context.run(recorder)?);
    let items = context.download::<u32>(&total)?[0];
    if items > i32::MAX as u32 {
        let (need, have) = (items.into(), i32::MAX as u64);
        return Err(Error::Capacity {
            what: "texels to test".into(),
            need,
            have,
        });
    }

    let texels = 1u64 << (2 * bits);
    let pairs = context.storage("pairs", (items as u64).max(1) * 8)?;
    let counts = context.storage("list starts", (texels + 1) * 4)?;
    let bindings = cover::Bindings {
        vertices: &mesh.vertices,
        triangles: &mesh.triangles,
        boxes: &boxes,
        starts: &starts,
        pairs: &pairs,
        counts: &counts,
    };
    let bound = context.compute::<cover::Shader>()?.bind(&bindings)?;
    let mut recorder = context.recorder("igt cover")?;
    recorder.fill(&counts, 0);
    let push = cover::Push {
        line: line as u32,
        bits,
        boxes: box_count as u32,
        items,
    };
    recorder.dispatch(&bound, &push, groups(items as u64, 64 * 8));
    timings.push(context.run(recorder)?);
    Ok(Covered {
        pairs,
        items,
        counts,
    })
}

/// Room for the boxes of triangles that reach into several octants, beyond one for each.
fn extra_boxes(reference: &Reference, line: Line) -> u64 {
    if line != Line::Sphere {
        return 0;
    }
    let spread = |t: usize| {
        let c = reference.corners(t);
        (0..3).any(|k| c.iter().any(|v| v[k] < 0) && c.iter().any(|v| v[k] > 0))
    };
    7 * (0..reference.triangles.len())
        .filter(|t| spread(*t))
        .count() as u64
}

/// Lists longer than this are sorted by the host, see `glsl/igt/order.comp`.
const LONGEST: u32 = 2048;

/// Lists with gaps: texel t's are `lists[starts[t]..starts[t] + lengths[t]]`.
struct Raw {
    starts: Buffer,
    lengths: Buffer,
    lists: Buffer,
    layers: Buffer,
    masks: Buffer,
}

fn order(
    context: &Context,
    reference: &Reference,
    covered: &Covered,
    bits: u32,
    timings: &mut Vec<Timings>,
) -> Result<Raw> {
    let texels = 1u64 << (2 * bits);
    let starts = &covered.counts;
    let cursors = context.storage("cursors", (texels + 1) * 4)?;
    let lists = context.storage("raw lists", (covered.items as u64).max(1) * 4)?;
    let lengths = context.storage("list lengths", texels * 4)?;
    let masks = context.storage("list layers", texels * 4)?;
    let mut layers = reference.layer.clone();
    layers.resize(layers.len().next_multiple_of(4), 0);
    let layers = context.upload("layers", &layers)?;

    use shaders::{igt_order as order, igt_scatter as scatter};
    let mut recorder = context.recorder("igt lists")?;
    scan::record(context, &mut recorder, starts, texels + 1)?;
    recorder.copy(starts, &cursors);
    let bindings = scatter::Bindings {
        pairs: &covered.pairs,
        cursors: &cursors,
        lists: &lists,
    };
    let bound = context.compute::<scatter::Shader>()?.bind(&bindings)?;
    recorder.dispatch(
        &bound,
        &scatter::Push {
            items: covered.items,
        },
        groups(covered.items.into(), 64),
    );
    let bindings = order::Bindings {
        starts,
        lists: &lists,
        lengths: &lengths,
        layers: &layers,
        masks: &masks,
    };
    let bound = context.compute::<order::Shader>()?.bind(&bindings)?;
    recorder.dispatch(
        &bound,
        &order::Push {
            texels: texels as u32,
        },
        groups(texels, 64),
    );
    timings.push(context.run(recorder)?);
    Ok(Raw {
        starts: covered.counts.clone(),
        lengths,
        lists,
        layers,
        masks,
    })
}

fn fill_gutter(
    context: &Context,
    reference: &Reference,
    raw: &Raw,
    needs: &Needs,
    bits: u32,
    timings: &mut Vec<Timings>,
) -> Result<Gutter> {
    if needs.pairs.is_empty() {
        return Ok(Gutter::from_found(&[], std::iter::empty()));
    }
    use shaders::igt_gutter as pass;
    let mut found = Vec::with_capacity(needs.pairs.len());
    for block in needs.pairs.chunks(1 << 20) {
        let pairs: Vec<[u32; 2]> = block
            .iter()
            .map(|p| [(p >> 8) as u32, (p & 255) as u32])
            .collect();
        let needs = context.upload("needs", &pairs)?;
        let answers = context.storage("gutter answers", block.len() as u64 * 40)?;
        let bindings = pass::Bindings {
            starts: &raw.starts,
            lengths: &raw.lengths,
            lists: &raw.lists,
            layers: &raw.layers,
            masks: &raw.masks,
            needs: &needs,
            answers: &answers,
        };
        let bound = context.compute::<pass::Shader>()?.bind(&bindings)?;
        let mut recorder = context.recorder("igt gutter")?;
        let push = pass::Push {
            line: reference.primary.line() as u32,
            bits,
            count: block.len() as u32,
            reach: gutter::REACH.min(1 << bits),
        };
        recorder.dispatch(&bound, &push, groups(block.len() as u64, 64));
        timings.push(context.run(recorder)?);
        let words: Vec<[u32; 10]> = context.download(&answers)?;
        found.extend(words[..block.len()].iter().map(|w| gutter::Found {
            ring: w[0],
            count: w[1],
            triangles: std::array::from_fn(|i| w[2 + i]),
        }));
    }
    Ok(Gutter::from_found(&needs.pairs, found.into_iter()))
}

/// Brings the lists home, sorts those that were too long for the device, and closes the gaps that doubles left.
fn download(context: &Context, raw: &Raw, bits: u32) -> Result<Lists> {
    let texels = 1usize << (2 * bits);
    let starts: Vec<u32> = context.download(&raw.starts)?;
    let mut lengths: Vec<u32> = context.download(&raw.lengths)?;
    let mut items: Vec<u32> = context.download(&raw.lists)?;
    items.truncate(starts[texels] as usize);
    if sort_long(&starts, &mut lengths, &mut items) {
        context.write(&raw.lengths, 0, bytemuck::cast_slice(&lengths))?;
        context.write(&raw.lists, 0, bytemuck::cast_slice(&items))?;
    }
    if (0..texels).all(|t| starts[t] + lengths[t] == starts[t + 1]) {
        return Ok(Lists {
            start: starts[..=texels].to_vec(),
            items,
        });
    }
    let mut lists = Lists {
        start: Vec::with_capacity(texels + 1),
        items: Vec::with_capacity(items.len()),
    };
    for t in 0..texels {
        lists.start.push(lists.items.len() as u32);
        lists
            .items
            .extend(&items[starts[t] as usize..(starts[t] + lengths[t]) as usize]);
    }
    lists.start.push(lists.items.len() as u32);
    Ok(lists)
}

/// Sorts the lists over [`LONGEST`] and drops their doubles; whether there were any.
fn sort_long(starts: &[u32], lengths: &mut [u32], items: &mut [u32]) -> bool {
    let mut any = false;
    for (t, length) in lengths
        .iter_mut()
        .enumerate()
        .filter(|(_, length)| **length > LONGEST)
    {
        any = true;
        let list = &mut items[starts[t] as usize..starts[t + 1] as usize];
        list.sort_unstable();
        let mut kept = 0;
        for i in 0..list.len() {
            if kept == 0 || list[kept - 1] != list[i] {
                list[kept] = list[i];
                kept += 1;
            }
        }
        *length = kept as u32;
    }
    any
}
