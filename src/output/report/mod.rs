//! The HTML report: one self-contained file that opens anywhere, offline, years later.
//!
//! In: pictures as PNG bytes and numbers as text; for a demo ([`Report`]) or for anything else ([`Page`]). Out: HTML with pictures as data URIs and inline CSS, JavaScript and
//! SVG. Everything is readable without JavaScript; with it each level gains a before/after slider. Light and dark.

mod chart;
mod page;
mod plot;

pub use chart::{BarChart, Series};
pub use page::{render, render_page};
pub use plot::{Axis, Line, Marks, Plot};

/// A chart of either kind.
#[derive(Clone, Debug)]
pub enum Chart {
    /// Horizontal bars.
    Bars(BarChart),
    /// Points over an axis.
    Plot(Plot),
}

/// One section of a [`Page`].
#[derive(Clone, Debug, Default)]
pub struct Section {
    /// Its heading.
    pub heading: String,
    /// A sentence or two under it.
    pub text: String,
    /// Pictures.
    pub shots: Vec<Shot>,
    /// Charts.
    pub charts: Vec<Chart>,
    /// Tables.
    pub tables: Vec<Table>,
}

/// A page of sections: what a profile found.
#[derive(Clone, Debug)]
pub struct Page {
    /// Title of the page.
    pub title: String,
    /// One or two sentences under it.
    pub lead: String,
    /// Facts in a row: label and value.
    pub facts: Vec<(String, String)>,
    /// The sections, top to bottom.
    pub sections: Vec<Section>,
    /// Last line: program, version, device.
    pub footer: String,
}

/// A picture with its caption.
#[derive(Clone, Debug)]
pub struct Shot {
    /// A few words under the picture; also its text alternative.
    pub caption: String,
    /// The PNG file's bytes.
    pub png: Vec<u8>,
}

/// One level of detail.
#[derive(Clone, Debug)]
pub struct Level {
    /// Heading (`LoD 2: 10 %`).
    pub name: String,
    /// The LoD with the inverse texture.
    pub inverse: Shot,
    /// The same LoD textured plainly.
    pub plain: Shot,
    /// Other views of it: wireframe, fetch heat map, difference.
    pub others: Vec<Shot>,
    /// Numbers beside the pictures: label and value.
    pub numbers: Vec<(String, String)>,
}

/// A table of numbers.
#[derive(Clone, Debug)]
pub struct Table {
    /// What it shows.
    pub title: String,
    /// Column headings; the first column is the row's name.
    pub columns: Vec<String>,
    /// Rows, each as long as `columns`.
    pub rows: Vec<Vec<String>>,
}

/// Everything a report says.
#[derive(Clone, Debug)]
pub struct Report {
    /// Title of the page.
    pub title: String,
    /// One or two sentences under it.
    pub lead: String,
    /// Facts in a row: label and value.
    pub facts: Vec<(String, String)>,
    /// The reference.
    pub reference: Shot,
    /// Which of `levels` stands beside the reference at the top.
    pub showcase: usize,
    /// The levels, fine to coarse.
    pub levels: Vec<Level>,
    /// Bar charts.
    pub charts: Vec<BarChart>,
    /// Tables.
    pub tables: Vec<Table>,
    /// Last line: program, version, device.
    pub footer: String,
}
