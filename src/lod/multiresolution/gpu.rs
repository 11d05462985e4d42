//! Selection on a device: the twin of [`Multiresolution::select`]. Shaders: `glsl/lod/select.comp` and `emit.comp`.
//!
//! In: a [`Multiresolution`], uploaded once; views, written before each picture. Out: an index buffer, the number of each
//! triangle, an indirect draw; the host never reads back. For each level of the tree one indirect dispatch asks the nodes of
//! the blocks that the level above did not accept as a whole; a last one writes triangles. Their order is that of the
//! device's atomics; sorted they are the processor's, byte for byte.

use super::tree::BLOCK;
use super::{Bound, Cut, Multiresolution, NEVER, View};
use crate::error::{Error, Result};
use crate::gpu::shaders::{lod_emit as emit, lod_select as select};
use crate::gpu::{self, Buffer, Context, Recorder};

/// Levels of a tree that a shader walks: 64 to their number of collapses.
const MOST_LEVELS: usize = 6;

/// Most instances of a mesh that one cut is made for.
pub const MOST_VIEWS: usize = 256;

/// A model on a device, and what its cuts are written to.
pub struct Selector {
    context: Context,
    buffers: Buffers,
    select: gpu::Bound<select::Shader>,
    emit: gpu::Bound<emit::Shader>,
    /// For each level of the tree: nodes before it, its nodes, words of bits before it.
    levels: Vec<[u32; 3]>,
    collapses: u32,
    code_words: u32,
    /// Words of one picture's bits.
    bit_words: u32,
    /// Pictures so far: which half of the bits is whose.
    pictures: u32,
}

struct Buffers {
    views: Buffer,
    counts: Buffer,
    /// Blocks that are looked into: two halves.
    lists: Buffer,
    /// What the counts are at first.
    reset: Buffer,
    command: Buffer,
    reset_command: Buffer,
    indices: Buffer,
    numbers: Buffer,
}

impl Selector {
    /// Uploads `model`, whose cuts never have more than `triangles` triangles: those of the reference.
    ///
    /// # Errors
    /// [`Error::Capacity`] where the device has no room for it; those of the device.
    pub fn new(context: &Context, model: &Multiresolution, triangles: usize) -> Result<Self> {
        let blocks = model.levels[0].len().div_ceil(BLOCK);
        let most = context.info().limits.workgroups[0] as usize;
        if model.levels.len() > MOST_LEVELS || blocks > most {
            return Err(Error::Capacity {
                what: "blocks of 64 collapses".into(),
                need: blocks as u64,
                have: most as u64,
            });
        }
        let levels = layout(model);
        let bit_words = levels.iter().map(|l| bit_words(l[1])).sum::<u32>();
        let code_words = model.colours.as_ref().map_or(0, |c| c.levels.div_ceil(2));
        let lists = blocks * 2 + BLOCK * 2;
        let bits = context.storage("cut bits", u64::from(bit_words) * 8)?;
        let nodes = context.upload("cut nodes", &nodes(model))?;
        let faces = context.upload("cut faces", &model.faces)?;
        let codes = context.upload("cut colours", &codes(model, code_words))?;
        let buffers = Buffers {
            views: context.storage("cut views", (MOST_VIEWS * size_of::<View>()) as u64)?,
            counts: context.storage("cut counts", (levels.len() * 16) as u64)?,
            lists: context.storage("cut blocks", lists as u64 * 4)?,
            reset: context.upload("cut counts at first", &counts(levels.len()))?,
            command: context.storage("cut draw", 20)?,
            reset_command: context.upload("cut draw at first", &[0u32, 1, 0, 0, 0])?,
            indices: context.storage("cut indices", triangles.max(1) as u64 * 12)?,
            numbers: context.storage("cut triangles", triangles.max(1) as u64 * 4)?,
        };
        let selecting = context
            .compute::<select::Shader>()?
            .bind(&select::Bindings {
                bits: &bits,
                nodes: &nodes,
                codes: &codes,
                views: &buffers.views,
                counts: &buffers.counts,
                lists: &buffers.lists,
            })?;
        let emitting = context.compute::<emit::Shader>()?.bind(&emit::Bindings {
            bits: &bits,
            nodes: &nodes,
            faces: &faces,
            lists: &buffers.lists,
            command: &buffers.command,
            indices: &buffers.indices,
            numbers: &buffers.numbers,
        })?;
        Ok(Selector {
            context: context.clone(),
            buffers,
            select: selecting,
            emit: emitting,
            levels,
            collapses: model.collapses() as u32,
            code_words: code_words as u32,
            bit_words,
            pictures: 0,
        })
    }

    /// Says what the next picture is seen from: an element for each instance of the mesh.
    ///
    /// # Errors
    /// [`Error::Capacity`] beyond [`MOST_VIEWS`]; those of the device.
    pub fn write_views(&self, views: &[View]) -> Result<()> {
        if views.len() > MOST_VIEWS {
            return Err(Error::Capacity {
                what: "instances of a mesh that one cut is made for".into(),
                need: views.len() as u64,
                have: MOST_VIEWS as u64,
            });
        }
        let buffer = &self.buffers.views;
        self.context.write(buffer, 0, bytemuck::cast_slice(views))
    }

    /// Records the selection for the `views` that were written. Then [`Selector::command`], [`Selector::indices`] and
    /// [`Selector::numbers`] hold the cut.
    pub fn record(&mut self, recorder: &mut Recorder, views: usize) {
        let b = &self.buffers;
        // The top is looked into as block 0 of one more level.
        recorder.fill(&b.lists, 0);
        recorder.copy(&b.reset, &b.counts);
        recorder.copy(&b.reset_command, &b.command);
        let top = self.levels.len() - 1;
        for level in (0..=top).rev() {
            let push = self.push(level, views);
            recorder.dispatch_indirect(&self.select, &push, &b.counts, level as u64 * 16);
        }
        let push: emit::Push = bytemuck::cast(self.push(0, views));
        recorder.dispatch_indirect(&self.emit, &push, &b.counts, 0);
        self.pictures += 1;
    }

    /// What a level's dispatch is told. Lists of blocks lie in two halves, one read and one written.
    fn push(&self, level: usize, views: usize) -> select::Push {
        let half = |level: usize| (level % 2) as u32 * self.list_half();
        let bits: [u32; MOST_LEVELS] =
            std::array::from_fn(|l| self.levels.get(l).map_or(0, |level| level[2]));
        let mine = self.pictures % 2 * self.bit_words;
        let [first_node, node_count, _] = self.levels[level];
        select::Push {
            level_bits: [bits[0], bits[1], bits[2], bits[3]],
            level_bits_above: [bits[4], bits[5]],
            depth: self.levels.len() as u32,
            now: mine,
            before: match self.pictures {
                0 => NEVER,
                _ => self.bit_words - mine,
            },
            level: level as u32,
            first_node,
            node_count,
            collapses: self.collapses,
            views: views as u32,
            code_words: self.code_words,
            list: half(level),
            next_list: half(level + 1),
        }
    }

    fn list_half(&self) -> u32 {
        self.levels[0][1].div_ceil(BLOCK as u32) + BLOCK as u32
    }

    /// A `VkDrawIndexedIndirectCommand`.
    pub fn command(&self) -> &Buffer {
        &self.buffers.command
    }

    /// Vertices of the reference, three for each triangle.
    pub fn indices(&self) -> &Buffer {
        &self.buffers.indices
    }

    /// For each triangle its number in [`Multiresolution::faces`].
    pub fn numbers(&self) -> &Buffer {
        &self.buffers.numbers
    }

    /// Selects, waits, and brings the cut back, in the processor's order; for tests and tools. What is asked is not counted.
    ///
    /// # Errors
    /// As [`Selector::write_views`]; those of the device.
    pub fn select(&mut self, views: &[View]) -> Result<(Cut, gpu::Timings)> {
        self.write_views(views)?;
        let context = self.context.clone();
        let mut recorder = context.recorder("cut")?;
        self.record(&mut recorder, views.len());
        let timings = context.run(recorder)?;
        let command: Vec<u32> = context.download(self.command())?;
        let mut faces: Vec<u32> = context.download(self.numbers())?;
        faces.truncate(command[0] as usize / 3);
        faces.sort_unstable();
        Ok((Cut { faces, asked: 0 }, timings))
    }
}

/// Words of bits for so many nodes: two a block.
fn bit_words(nodes: u32) -> u32 {
    nodes.div_ceil(BLOCK as u32) * 2
}

fn layout(model: &Multiresolution) -> Vec<[u32; 3]> {
    let (mut nodes, mut bits) = (0, 0);
    let mut levels = Vec::with_capacity(model.levels.len());
    for level in &model.levels {
        let count = level.len() as u32;
        levels.push([nodes, count, bits]);
        // The lowest level has one more, where its last node's triangles end.
        nodes += count + u32::from(nodes == 0);
        bits += bit_words(count);
    }
    levels
}

/// Bounds of all levels; after the lowest one's the end of the triangles.
fn nodes(model: &Multiresolution) -> Vec<Bound> {
    let mut all = model.levels[0].clone();
    all.push(Bound {
        first: model.faces.len() as u32,
        ..Bound::nothing()
    });
    model.levels[1..].iter().for_each(|level| all.extend(level));
    all
}

/// Codes of all levels, two footprints a word, in the order of [`nodes`].
fn codes(model: &Multiresolution, words: usize) -> Vec<u32> {
    let Some(colours) = &model.colours else {
        return vec![0];
    };
    let mut all = Vec::new();
    for (level, codes) in colours.codes.iter().enumerate() {
        for row in codes.chunks(colours.levels) {
            all.extend(row.chunks(2).map(|pair| {
                let code = |k: usize| pair.get(k).copied().unwrap_or_default();
                let [a, b] = [code(0), code(1)];
                u32::from_le_bytes([a[0], a[1], b[0], b[1]])
            }));
        }
        if level == 0 {
            all.extend(std::iter::repeat_n(0, words));
        }
    }
    all
}

/// Workgroups at first: one for the top, none below.
fn counts(levels: usize) -> Vec<[u32; 4]> {
    let of = |level: usize| [u32::from(level + 1 == levels), 1, 1, 0];
    (0..levels).map(of).collect()
}
