//! Results on stdout: a readable table, or one JSON document with a stable order of keys.
//!
//! A reader that closes the pipe early (`| head`) ends the program quietly.

use std::io::{self, ErrorKind, Write};

use invertex::{Error, Result};
use serde::Serialize;

/// Writes `text` to stdout.
///
/// # Errors
/// [`Error::Io`] when stdout cannot take it (a full disk behind `>`); a closed pipe is no error.
pub(super) fn text(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
        other => other.map_err(|source| Error::io("standard output", source)),
    }
}

/// Writes `value` as JSON, keys in the order of the type's fields.
pub(super) fn json(value: &impl Serialize) -> Result<()> {
    let mut document = serde_json::to_string_pretty(value)
        .map_err(|error| Error::input("standard output", "JSON", error.to_string()))?;
    document.push('\n');
    text(&document)
}

/// Lines of cells in columns: the first left-aligned, numbers to the right.
#[derive(Default)]
pub(super) struct Table {
    rows: Vec<Vec<String>>,
}

impl Table {
    /// A table with these headings.
    pub(super) fn new(headings: &[&str]) -> Self {
        Self {
            rows: vec![headings.iter().map(|&h| h.to_owned()).collect()],
        }
    }

    /// Adds a row.
    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = impl ToString>) {
        self.rows
            .push(cells.into_iter().map(|cell| cell.to_string()).collect());
    }

    /// The table as text, each line ended.
    pub(super) fn text(&self) -> String {
        let columns = self.rows.iter().map(Vec::len).max().unwrap_or(0);
        let width = |c: usize| {
            self.rows
                .iter()
                .filter_map(|r| r.get(c))
                .map(|s| s.chars().count())
                .max()
        };
        let widths: Vec<usize> = (0..columns).map(|c| width(c).unwrap_or(0)).collect();
        let right = |c: usize| {
            let cells = self
                .rows
                .iter()
                .skip(1)
                .filter_map(|r| r.get(c))
                .filter(|s| !s.is_empty());
            c > 0 && cells.clone().next().is_some() && cells.clone().all(|s| is_figure(s))
        };
        let right: Vec<bool> = (0..columns).map(right).collect();
        let line = |row: &Vec<String>| {
            let cells = row.iter().enumerate().map(|(c, cell)| match right[c] {
                true => format!("{cell:>0$}", widths[c]),
                false => format!("{cell:<0$}", widths[c]),
            });
            format!("{}\n", cells.collect::<Vec<_>>().join("  ").trim_end())
        };
        self.rows.iter().map(line).collect()
    }
}

/// A number, perhaps with a unit after it.
fn is_figure(cell: &str) -> bool {
    cell.starts_with(|c: char| c.is_ascii_digit() || "-–<".contains(c))
}

/// `1234567` as `1,234,567`.
pub(super) fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push(',');
        }
        out.push(digit);
    }
    out
}

/// A share (0..1) in percent.
pub(super) fn percent(share: f64) -> String {
    if share > 0.0 && share < 0.0001 {
        "< 0.01 %".to_owned()
    } else {
        format!("{:.2} %", share * 100.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_align() {
        let mut table = Table::new(&["name", "n"]);
        table.row(["a", "1"]);
        table.row(["longer", "10"]);
        assert_eq!(table.text(), "name     n\na        1\nlonger  10\n");
    }

    #[test]
    fn figures_are_grouped() {
        assert_eq!(
            [0, 999, 1000, 1234567].map(thousands),
            ["0", "999", "1,000", "1,234,567"]
        );
    }
}
