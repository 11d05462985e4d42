//! The build on a device: bounds -> cover -> scan -> scatter -> order -> gutter. Shaders: `glsl/igt/`.
//!
//! Atomics hand out slots in any order; the order pass makes the result independent of them.

use super::super::build::{Lists, check_layout};
use super::super::gutter::{Needs, fill as host_gutter};
use super::super::{BuildOptions, Reference, Tables, finish};
use super::cover::{Covered, cover};
use super::{groups, gutter, portions, scan};
use crate::error::{Error, Result};
use crate::gpu::{Buffer, ComputeShader, Context, Pipeline, Recorder, Timings, shaders};

/// Tables and how long each pass took.
#[derive(Debug)]
pub struct Timed {
    /// The tables.
    pub tables: Tables,
    /// The passes' times on the device.
    pub timings: Vec<Timings>,
}

/// Builds the tables on a device. The bytes equal those of [`build_cpu`](super::super::build_cpu). What has no room on the
/// device at once goes in portions.
///
/// # Errors
/// Those of the CPU build, and [`Error::Capacity`] where the hash texture does not fit a storage buffer of the device.
pub fn build(
    context: &Context,
    reference: &Reference,
    needs: &Needs,
    options: BuildOptions,
) -> Result<Timed> {
    let portion = portions::portion(context, reference);
    let whole = || build_in_portions(context, reference, needs, options, portion);
    if portion < reference.triangles.len() {
        return whole();
    }
    match build_at_once(context, reference, needs, options) {
        // Longer lists than triangles usually have.
        Err(Error::Capacity { .. }) => whole(),
        built => built,
    }
}

fn build_at_once(
    context: &Context,
    reference: &Reference,
    needs: &Needs,
    options: BuildOptions,
) -> Result<Timed> {
    let bits = options.bits()?;
    check_layout(reference, options)?;
    let mut work = Work {
        context,
        reference,
        bits,
        timings: Vec::new(),
    };
    let covered = cover(&mut work)?;
    let raw = order(&mut work, &covered)?;
    let lists = download(context, &raw, bits)?;
    let gutter = gutter::fill(&mut work, &raw, needs)?;
    let tables = finish::tables(reference, options, &lists, &gutter)?;
    Ok(Timed {
        tables,
        timings: work.timings,
    })
}

/// [`build`], at most `portion` triangles at a time. The gutter is searched on the host, which has all lists.
pub fn build_in_portions(
    context: &Context,
    reference: &Reference,
    needs: &Needs,
    options: BuildOptions,
    portion: usize,
) -> Result<Timed> {
    let bits = options.bits()?;
    check_layout(reference, options)?;
    let (need, have) = (
        ((1 << (2 * bits)) + 1) * 4,
        context.info().limits.storage_buffer_bytes,
    );
    if need > have {
        let what = format!("bytes of a hash texture of {0} x {0} texels", options.hash);
        return Err(Error::Capacity { what, need, have });
    }
    let mut timings = Vec::new();
    let lists = portions::lists(reference, portion, |part| {
        let mut work = Work {
            context,
            reference: part,
            bits,
            timings: Vec::new(),
        };
        let covered = cover(&mut work)?;
        let raw = order(&mut work, &covered)?;
        timings.append(&mut work.timings);
        download(context, &raw, bits)
    })?;
    let gutter = host_gutter(reference, bits, &lists, needs);
    let tables = finish::tables(reference, options, &lists, &gutter)?;
    Ok(Timed { tables, timings })
}

/// What every pass works on, and the times so far.
pub(super) struct Work<'a> {
    pub(super) context: &'a Context,
    pub(super) reference: &'a Reference,
    pub(super) bits: u32,
    timings: Vec<Timings>,
}

impl Work<'_> {
    pub(super) fn texels(&self) -> u64 {
        1 << (2 * self.bits)
    }

    pub(super) fn run(&mut self, recorder: Recorder) -> Result<()> {
        self.timings.push(self.context.run(recorder)?);
        Ok(())
    }

    /// A pipeline for the reference's family of lines alone, which the shader's `constant` names.
    pub(super) fn compute_for_line<S: ComputeShader>(&self, constant: u32) -> Result<Pipeline<S>> {
        let line = self.reference.primary.line() as u32;
        self.context.compute_with(&[(constant, line)])
    }

    /// Turns the first `count` words of `values` into the sums of those before, and the word behind them into the sum of
    /// all, which comes back.
    pub(super) fn scan(&mut self, name: &str, values: &Buffer, count: u64) -> Result<u32> {
        let total = self.context.storage("total", 4)?;
        let mut recorder = self.context.recorder(name)?;
        scan::record(self.context, &mut recorder, values, count + 1)?;
        recorder.copy_range(values, count * 4, &total, 0, 4);
        self.run(recorder)?;
        Ok(self.context.download::<u32>(&total)?[0])
    }
}

/// Lists longer than this are sorted by the host, see `glsl/igt/order.comp`.
const LONGEST: u32 = 2048;

/// Lists with gaps: texel t's are `lists[starts[t]..starts[t] + lengths[t]]`.
pub(super) struct Raw {
    pub(super) starts: Buffer,
    pub(super) lengths: Buffer,
    pub(super) lists: Buffer,
    pub(super) layers: Buffer,
    pub(super) masks: Buffer,
    /// One word: whether there are gaps, or lists left to the host.
    changed: Buffer,
}

fn order(work: &mut Work<'_>, covered: &Covered) -> Result<Raw> {
    let (context, texels) = (work.context, work.texels());
    let entries = work.scan("igt starts", &covered.counts, texels)?;
    if entries > i32::MAX as u32 {
        return Err(Error::Capacity {
            what: "list entries".into(),
            need: entries.into(),
            have: i32::MAX as u64,
        });
    }
    let mut layers = work.reference.layer.clone();
    // A single layer needs no look at the entries.
    let first = layers.first().copied().unwrap_or(0);
    let mixed = layers.iter().any(|layer| *layer != first);
    let mask = 1 << (first & 31);
    layers.resize(layers.len().next_multiple_of(4), 0);
    let raw = Raw {
        starts: covered.counts.clone(),
        lengths: context.storage("list lengths", texels * 4)?,
        lists: context.storage("raw lists", u64::from(entries) * 4)?,
        layers: context.upload("layers", &layers)?,
        masks: context.storage("list layers", texels * 4)?,
        changed: context.storage("lists changed", 4)?,
    };
    let cursors = context.storage("cursors", (texels + 1) * 4)?;

    use shaders::{igt_order as order, igt_scatter as scatter};
    let mut recorder = context.recorder("igt lists")?;
    recorder.copy(&raw.starts, &cursors);
    recorder.fill(&raw.changed, 0);
    let bindings = scatter::Bindings {
        tiles: &covered.tiles,
        owners: &covered.owners,
        cursors: &cursors,
        lists: &raw.lists,
    };
    let bound = context.compute::<scatter::Shader>()?.bind(&bindings)?;
    let push = scatter::Push {
        bits: work.bits,
        triangles: work.reference.triangles.len() as u32,
        tiles: covered.count,
    };
    recorder.dispatch(&bound, &push, groups(covered.count.into(), 64));
    let bindings = order::Bindings {
        starts: &raw.starts,
        lists: &raw.lists,
        lengths: &raw.lengths,
        layers: &raw.layers,
        masks: &raw.masks,
        changed: &raw.changed,
    };
    let pipeline = context.compute_with::<order::Shader>(&[(order::MIXED, mixed.into())])?;
    let bound = pipeline.bind(&bindings)?;
    let push = order::Push {
        texels: texels as u32,
        mask,
    };
    recorder.dispatch(&bound, &push, groups(texels, 64));
    work.run(recorder)?;
    Ok(raw)
}

/// Brings the lists home, sorts those that were too long for the device, and closes the gaps that doubles left.
fn download(context: &Context, raw: &Raw, bits: u32) -> Result<Lists> {
    let texels = 1usize << (2 * bits);
    let start: Vec<u32> = context.download(&raw.starts)?;
    let mut items: Vec<u32> = context.download(&raw.lists)?;
    if context.download::<u32>(&raw.changed)?[0] == 0 {
        return Ok(Lists { start, items });
    }
    let mut lengths: Vec<u32> = context.download(&raw.lengths)?;
    if sort_long(&start, &mut lengths, &mut items) {
        context.write(&raw.lengths, 0, bytemuck::cast_slice(&lengths))?;
        context.write(&raw.lists, 0, bytemuck::cast_slice(&items))?;
    }
    let mut lists = Lists {
        start: Vec::with_capacity(texels + 1),
        items: Vec::with_capacity(items.len()),
    };
    for t in 0..texels {
        lists.start.push(lists.items.len() as u32);
        let list = &items[start[t] as usize..(start[t] + lengths[t]) as usize];
        lists.items.extend(list);
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
