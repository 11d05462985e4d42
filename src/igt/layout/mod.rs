//! How tables are laid out in 32-bit words. Twin of `glsl/common/igt_layout.glsl`.
//!
//! [`packed`]: ours. [`classic`]: the paper's. [`record`]: the triangles' T3 coordinates in both. What a reader must know
//! besides the words is the [`Format`].

pub mod classic;
pub mod packed;
pub mod record;
mod window;

pub use record::Record;
pub use window::Window;

use super::Layout;
use crate::error::{Error, Result};
use crate::param::Primary;
use serde::{Deserialize, Serialize};

/// How the words of tables are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, rename_all = "camelCase")]
pub struct Format {
    /// The triangles' records.
    pub record: Record,
    /// Bits of a triangle's number in a list.
    pub id_bits: u32,
    /// Bits of its layer, in lists that have layers.
    pub layer_bits: u32,
}

impl Format {
    /// The format of tables over `triangles` triangles in layers up to `top_layer`.
    ///
    /// # Errors
    /// [`Error::Capacity`] where numbers do not fit.
    pub fn new(layout: Layout, record: Record, triangles: usize, top_layer: u8) -> Result<Self> {
        let (layer_bits, most) = match layout {
            Layout::Packed => {
                let layer_bits = u8::BITS - top_layer.leading_zeros();
                (
                    layer_bits,
                    ((1u64 << packed::MAX_ENTRY_BITS) - 1) >> layer_bits,
                )
            }
            Layout::Classic => (8, (1 << 24) - 1),
        };
        if triangles as u64 > most {
            return Err(Error::Capacity {
                what: format!("triangle ids of the {layout:?} layout").to_lowercase(),
                need: triangles as u64,
                have: most,
            });
        }
        let id_bits = match layout {
            // One value more than there are triangles: the end of a list.
            Layout::Packed => u64::BITS - (triangles as u64).leading_zeros(),
            Layout::Classic => 24,
        };
        Ok(Format {
            record,
            id_bits,
            layer_bits,
        })
    }

    /// Whether a lookup may read tables of `triangles` triangles in this format, or what is wrong with it.
    pub(super) fn fault(&self, layout: Layout, flat: bool, triangles: usize) -> Option<String> {
        let record_fits = match (layout, self.record) {
            (Layout::Classic, Record::Rgb9e5) => true,
            (Layout::Packed, Record::Chart) => flat,
            (Layout::Packed, Record::Wide) => !flat,
            (Layout::Packed, Record::Compact(precision)) => {
                !flat && record::PRECISIONS.contains(&precision)
            }
            _ => false,
        };
        if !record_fits {
            return Some(format!(
                "{:?} records do not belong to these tables",
                self.record
            ));
        }
        let (bits, layer) = (self.id_bits, self.layer_bits);
        let entries_fit = match layout {
            Layout::Packed => {
                layer <= 8
                    && bits > 0
                    && bits + layer <= packed::MAX_ENTRY_BITS
                    && (triangles as u64) < 1 << bits
            }
            Layout::Classic => bits == 24 && layer == 8,
        };
        (!entries_fit).then(|| {
            format!("{triangles} triangles do not fit {bits} bits and {layer} of the layer")
        })
    }

    /// Bits of an entry, layer included or not.
    pub fn entry_bits(&self, mixed: bool) -> u32 {
        self.id_bits + if mixed { self.layer_bits } else { 0 }
    }

    /// The entry of a triangle in a packed list.
    pub fn entry(&self, mixed: bool, triangle: u32, layer: u8) -> u32 {
        if mixed {
            triangle << self.layer_bits | u32::from(layer)
        } else {
            triangle
        }
    }

    /// The triangle of a packed entry and, in a mixed list, its layer.
    pub fn split(&self, mixed: bool, entry: u32) -> (u32, Option<u8>) {
        if mixed {
            let layer = entry & ((1 << self.layer_bits) - 1);
            (entry >> self.layer_bits, Some(layer as u8))
        } else {
            (entry, None)
        }
    }
}

/// Words of a hash texel.
pub fn hash_words(layout: Layout) -> usize {
    match layout {
        Layout::Packed => 2,
        Layout::Classic => 1,
    }
}

/// Whether T3 has two coordinates (the third is always zero).
pub fn is_flat(primary: &Primary) -> bool {
    primary.kind.has_charts()
}
