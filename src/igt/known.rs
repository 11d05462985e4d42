//! What several tables have in common, so that a shader may be made for them alone.

use super::Tables;

/// Stands for "several" (`IGT_ANY` in `glsl/common/igt_layout.glsl`).
const ANY: u32 = 255;

/// Line, layout and record of tables where they are all the same: the arguments of `igt_known` in
/// `glsl/common/igt_layout.glsl`, meant for specialization constants.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KnownTables([u32; 3]);

impl KnownTables {
    /// Line, layout and record; 255 where they differ.
    pub fn words(&self) -> [u32; 3] {
        self.0
    }
}

impl Tables {
    /// What `tables` have in common.
    pub fn known<'a>(tables: impl Iterator<Item = &'a Tables>) -> KnownTables {
        let words = |t: &Tables| {
            let [line, how, ..] = t.shader_words();
            [line, how & 255, how >> 8 & 255]
        };
        let common =
            |a: [u32; 3], b: [u32; 3]| [0, 1, 2].map(|i| if a[i] == b[i] { a[i] } else { ANY });
        KnownTables(tables.map(words).reduce(common).unwrap_or([ANY; 3]))
    }
}
