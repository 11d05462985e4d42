//! Inverse geometric textures: the tables, their build passes, the lookup.
//!
//! In: a [`Reference`] (the reference mesh on the integer grid of T3) and the LoDs that will be drawn with it. Out:
//! [`Tables`] of 32-bit words that any processor can read, and [`Tables::lookup`], which answers for a T3 point: which
//! triangle of the reference, at which barycentric coordinates.
//!
//! ```text
//! Reference --cover--> (texel, triangle) pairs --list--> lists --gutter--> lists --finish--> Tables
//! ```
//!
//! Every pass works on integers only, so the tables of the CPU and of any GPU are equal byte for byte. Source: Inverse
//! Geometric Textures, sections 2.1 (building), 2.2 (use) and 2.3 (data structures).

mod ambiguous;
mod asker;
mod build;
pub mod cover;
mod finish;
#[cfg(feature = "gpu")]
pub mod gpu;
mod gutter;
mod known;
pub mod layout;
mod lookup;
mod reference;
mod validate;
mod words;

pub use ambiguous::Ambiguous;
pub use asker::{Asker, askers};
pub use build::build_cpu;
pub use gutter::{Asking, Needs};
pub use known::KnownTables;
pub use lookup::{Cost, Found};
pub use reference::Reference;
pub use words::Words;

use crate::error::{Error, Result};
use crate::param::Primary;
pub use layout::{Format, Window};
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

/// How the tables are laid out in words; see [`layout`].
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Layout {
    /// Ours: 64-bit hash texels that hold short lists, triangles of 128 bits, crowded texels divided.
    #[default]
    Packed,
    /// The paper's: RGBA8 hash and lists, RGB9E5 triangles (section 2.3).
    Classic,
}

/// What a build needs to know besides the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuildOptions {
    /// Texels along each side of the hash texture: a power of two from 4 to 8192.
    pub hash: u32,
    /// The layout of the tables.
    pub layout: Layout,
}

impl BuildOptions {
    /// log2 of the hash resolution, or what is wrong with it.
    pub fn bits(&self) -> Result<u32> {
        if self.hash.is_power_of_two() && (4..=8192).contains(&self.hash) {
            return Ok(self.hash.trailing_zeros());
        }
        Err(Error::Option {
            option: "--hash",
            reason: format!("{} is not a power of two from 4 to 8192", self.hash),
        })
    }
}

/// Figures of a build.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Stats {
    /// List entries, gutter included.
    pub entries: u64,
    /// Entries that only serve points outside the reference's charts.
    pub gutter_entries: u64,
    /// How far the gutter had to reach, in texels.
    pub gutter_width: u32,
    /// Points of LoDs farther outside than any gutter reaches: texels without an entry of their layer.
    pub unreached_texels: u64,
    /// Mean list length over texels that have a list.
    pub mean_list: f64,
    /// The longest list.
    pub max_list: u32,
    /// Triangles of the reference that the grid collapsed to a line or a point in T3: nothing maps to them.
    pub collapsed_triangles: u64,
    /// Packed: texels that are cut into smaller ones because their lists are long.
    pub divided_texels: u64,
    /// Packed: lists, divided texels' included, in which triangles of one layer overlap.
    pub overlapping_lists: u64,
    /// Classic: words lost because lists never straddle a row.
    pub row_waste: u64,
}

/// Built tables. Words are little-endian in files.
#[derive(Clone, Debug, PartialEq)]
pub struct Tables {
    /// How the words are to be read.
    pub layout: Layout,
    /// What else a reader must know.
    pub format: Format,
    /// Texels of the hash texture: width and height, equal powers of two.
    pub hash_size: [u32; 2],
    /// Those of them that are stored.
    pub window: Window,
    /// The primary parameterization the tables invert.
    pub primary: Primary,
    /// The hash texture's window: one or two words a texel, row by row; behind them divided texels' children.
    pub hash: Words,
    /// The lists of triangles.
    pub list: Words,
    /// The triangles' T3 coordinates and layers.
    pub triangle: Words,
    /// Figures of the build.
    pub stats: Stats,
}

impl Tables {
    /// log2 of the hash resolution.
    pub fn bits(&self) -> u32 {
        self.hash_size[0].trailing_zeros()
    }

    /// How shaders are to read the tables: what `igt_tables` of `glsl/common/igt.glsl` takes.
    pub fn shader_words(&self) -> [u32; 6] {
        let table_layout = match self.layout {
            Layout::Packed => 0,
            Layout::Classic => 1,
        };
        let flat = u32::from(layout::is_flat(&self.primary));
        let [at, size] = self.window.words();
        [
            self.primary.line() as u32,
            table_layout | self.format.record.code() << 8 | flat << 16,
            self.bits(),
            self.format.id_bits | self.format.layer_bits << 8,
            at,
            size,
        ]
    }

    /// SHA-256 over the three tables' bytes, as lower-case hexadecimal.
    pub fn sha256(&self) -> String {
        let mut hasher = Sha256::new();
        for words in [&self.hash, &self.list, &self.triangle] {
            hasher.update((words.len() as u64).to_le_bytes());
            for chunk in words.chunks(4096) {
                let bytes: Vec<u8> = chunk.iter().flat_map(|w| w.to_le_bytes()).collect();
                hasher.update(&bytes);
            }
        }
        hasher
            .finalize()
            .iter()
            .map(|byte| format!("{byte:02x}"))
            .collect()
    }

    /// Bytes of hash, list and triangle table.
    pub fn bytes(&self) -> [u64; 3] {
        [&self.hash, &self.list, &self.triangle].map(|words| words.len() as u64 * 4)
    }
}
