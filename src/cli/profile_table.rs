//! A profile's rows as columns of text: for stdout and for the report.

use invertex::measure::{MemoryRow, Run};
use invertex::output::report;

use super::print::{self, thousands};

/// Headings and rows.
pub(super) struct Rows {
    pub(super) headings: Vec<&'static str>,
    pub(super) rows: Vec<Vec<String>>,
}

impl Rows {
    /// For stdout.
    pub(super) fn text(self) -> String {
        let mut table = print::Table::new(&self.headings);
        self.rows.into_iter().for_each(|row| table.row(row));
        table.text()
    }

    /// For the report: columns that say the same in every row, or nothing, are left out where a heading says it.
    pub(super) fn table(self, title: &str, heading_says: &[&str]) -> report::Table {
        let alike = |c: usize| self.rows.iter().all(|row| row[c] == self.rows[0][c]);
        let blank = |c: usize| self.rows.iter().all(|row| row[c] == DASH);
        let says = |c: usize| heading_says.contains(&self.headings[c]);
        let keep: Vec<usize> = (0..self.headings.len())
            .filter(|&c| !(blank(c) || says(c) && alike(c)))
            .collect();
        report::Table {
            title: title.to_owned(),
            columns: keep.iter().map(|&c| self.headings[c].to_owned()).collect(),
            rows: self
                .rows
                .iter()
                .map(|row| keep.iter().map(|&c| row[c].clone()).collect())
                .collect(),
        }
    }
}

/// What stands where there is nothing to say.
pub(super) const DASH: &str = "–";

/// What was drawn, counted and timed.
pub(super) fn runs<'a>(runs: impl Iterator<Item = &'a Run>) -> Rows {
    let dash = || DASH.to_owned();
    let row = |run: &Run| {
        let milliseconds = |ns: u64| format!("{:.3}", ns as f64 / 1e6);
        vec![
            run.mesh.clone(),
            run.variant.name().to_owned(),
            run.lod.to_string(),
            run.distance.to_string(),
            thousands(run.triangles.into()),
            run.layout.map_or_else(dash, lower),
            run.hash.map_or_else(dash, |h| h.to_string()),
            run.mean_list.map_or_else(dash, |m| format!("{m:.2}")),
            format!("{:.2}", run.mean_fetches),
            format!("{:.2}", run.mean_fetches_with_uv),
            run.p99_fetches.to_string(),
            run.max_fetches.to_string(),
            run.lookup_ns_median.map_or_else(dash, milliseconds),
            milliseconds(run.frame_ns_median),
            milliseconds(run.frame_ns_p95),
            thousands(run.tables_bytes.div_ceil(1024)),
            thousands(run.texture_bytes.div_ceil(1024)),
            run.frames.to_string(),
        ]
    };
    Rows {
        headings: vec![
            "mesh",
            "variant",
            "LoD",
            "distance",
            "triangles",
            "layout",
            "hash",
            "mean list",
            "fetches",
            "with uv",
            "p99",
            "max",
            "lookup ms",
            "frame ms",
            "p95 ms",
            "tables KiB",
            "textures KiB",
            "frames",
        ],
        rows: runs.map(row).collect(),
    }
}

/// What tables take (the paper's Table 1).
pub(super) fn memory(rows: &[MemoryRow]) -> Rows {
    let row = |row: &MemoryRow| {
        let kibibytes = |bytes: u64| thousands(bytes.div_ceil(1024));
        vec![
            row.mesh.clone(),
            row.file.clone(),
            thousands(row.triangles as u64),
            row.primary.clone(),
            lower(row.layout),
            row.hash.to_string(),
            format!("{:.2}", row.mean_list),
            kibibytes(row.bytes.hash),
            kibibytes(row.bytes.list),
            kibibytes(row.bytes.triangle),
            kibibytes(row.bytes.attribute),
            format!("{:.2}", row.bytes.total as f64 / 1e6),
            format!("{:.1}", row.bytes_per_triangle),
        ]
    };
    Rows {
        headings: vec![
            "mesh",
            "file",
            "triangles",
            "primary",
            "layout",
            "hash",
            "mean list",
            "hash KiB",
            "lists KiB",
            "triangles KiB",
            "attributes KiB",
            "total MB",
            "bytes a triangle",
        ],
        rows: rows.iter().map(row).collect(),
    }
}

fn lower(layout: invertex::igt::Layout) -> String {
    format!("{layout:?}").to_lowercase()
}
