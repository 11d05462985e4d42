//! The tables of a built file without the rest of it: mapped, validated, ready to be uploaded or asked.
//!
//! In: the path of a built GLB. Out: [`TableFile`]. Nothing is built, decoded or copied; the JSON is parsed, and every index
//! that a lookup follows is looked at once, so that a million triangles take milliseconds. What is left out is what only
//! tells damage that leaves all indices in range: the checksum, for which there is [`MeshTables::verify`], and whether the
//! mesh is still the one that the tables were built for ([`read`](super::read) checks both).

use super::decode::parse;
use super::extension::{EXTENSION, MeshExtension, RootExtension, VERSION};
use crate::igt::{Tables, Words};
use crate::scene::{Mapped, json_and_binary};
use crate::{Error, Result};
use serde_json::Value;
use std::ops::Range;
use std::path::Path;

/// The tables of a built file.
#[derive(Clone, Debug)]
pub struct TableFile {
    /// Those of each mesh that has some, in growing order.
    pub meshes: Vec<MeshTables>,
}

/// The tables of a mesh.
#[derive(Clone, Debug)]
pub struct MeshTables {
    /// Index of the glTF mesh.
    pub mesh: usize,
    /// Its name.
    pub name: String,
    /// Triangles of the reference, as the file says; no answer names one beyond.
    pub triangles: usize,
    /// The tables; their words lie in the file.
    pub tables: Tables,
    sha256: String,
}

impl MeshTables {
    /// Whether the tables are those that were written, by their checksum; reads all of them.
    pub fn verify(&self) -> bool {
        self.tables.sha256() == self.sha256
    }
}

/// Opens the tables of a built file by mapping it; see [`Mapped::open`] for what that asks of whoever owns the file.
///
/// # Errors
/// [`Error::Io`] where it cannot be mapped; [`Error::Input`] where it is not a built file, or a lookup would leave its
/// tables.
pub fn open_tables(path: &Path) -> Result<TableFile> {
    let file = Mapped::open(path)?;
    let name = file.name().to_owned();
    let (json, binary) = json_and_binary(&name, file.bytes())?;
    let extension = &json["extensions"][EXTENSION];
    if extension.is_null() {
        let reason = format!("has no {EXTENSION}: not a built model; run build first");
        return Err(Error::input(name, "extensions", reason));
    }
    let root: RootExtension = parse(&name, "", extension)?;
    if root.version != VERSION {
        let reason = format!("{EXTENSION} version {} is not {VERSION}", root.version);
        return Err(Error::input(name, "extensions", reason));
    }
    let opening = Opening {
        file: &file,
        views: &json["bufferViews"],
        binary: binary.unwrap_or(0..0),
    };
    let meshes = json["meshes"].as_array().map_or(&[][..], Vec::as_slice);
    let built = meshes.iter().enumerate().filter_map(|(mesh, value)| {
        let extension = &value["extensions"][EXTENSION];
        (!extension.is_null()).then(|| opening.mesh(mesh, value, extension))
    });
    Ok(TableFile {
        meshes: built.collect::<Result<_>>()?,
    })
}

/// A file being opened.
struct Opening<'a> {
    file: &'a Mapped,
    views: &'a Value,
    binary: Range<usize>,
}

impl Opening<'_> {
    fn mesh(&self, mesh: usize, value: &Value, extension: &Value) -> Result<MeshTables> {
        let element = format!("meshes[{mesh}]");
        let extension: MeshExtension = parse(self.file.name(), &format!("{element}."), extension)?;
        let words = |what: &str, view: Option<usize>| -> Result<Words> {
            let Some(view) = view else {
                return Ok(Vec::new().into());
            };
            let element = format!("{element}.{what}");
            let range = self.view(&element, view)?;
            let bytes = range.len();
            self.file.expect(range.clone());
            Words::in_file(self.file, range)
                .ok_or_else(|| self.fault(&element, format!("{bytes} bytes are not whole words")))
        };
        let tables = Tables {
            layout: extension.layout,
            format: extension.format,
            hash_size: extension.hash_size,
            window: extension.window,
            primary: extension.primary,
            hash: words("hash", extension.hash)?,
            list: words("list", extension.list)?,
            triangle: words("triangle", extension.triangle)?,
            stats: extension.stats,
        };
        let triangles = self
            .view(&format!("{element}.layer"), extension.layer)?
            .len();
        tables
            .validate(triangles)
            .map_err(|(what, reason)| self.fault(&format!("{element}.{what}"), reason))?;
        Ok(MeshTables {
            mesh,
            name: value["name"].as_str().unwrap_or_default().to_owned(),
            triangles,
            tables,
            sha256: extension.tables_sha256,
        })
    }

    fn fault(&self, element: &str, reason: impl Into<String>) -> Error {
        Error::input(self.file.name(), element, reason)
    }

    /// The bytes of a buffer view, as a range of the file.
    fn view(&self, element: &str, index: usize) -> Result<Range<usize>> {
        let view = &self.views[index];
        let number = |key: &str| view[key].as_u64().map(|n| n as usize);
        let range = number("byteLength").and_then(|length| {
            let start = number("byteOffset").unwrap_or(0);
            let end = start.checked_add(length)?;
            let own = number("buffer") == Some(0) && end <= self.binary.len();
            own.then(|| self.binary.start + start..self.binary.start + end)
        });
        range.ok_or_else(|| {
            let reason = format!("bufferViews[{index}] is not there or leaves the file");
            self.fault(element, reason)
        })
    }
}
