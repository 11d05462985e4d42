//! Which triangles are ambiguous, as a file: what `--ambiguous FILE` of `build` and `inspect` writes.

use std::path::Path;

use invertex::igt::Ambiguous;
use invertex::output::write_bytes;
use invertex::{Error, Result};

/// Writes the ambiguous triangles of each mesh, one a line: `mesh,triangle`, below a line of these names.
pub(super) fn write<'a>(
    path: &Path,
    meshes: impl Iterator<Item = (&'a str, &'a Ambiguous)>,
) -> Result<()> {
    let bad = |e: csv::Error| Error::io(path, std::io::Error::other(e));
    let mut file = csv::Writer::from_writer(Vec::new());
    file.write_record(["mesh", "triangle"]).map_err(bad)?;
    for (name, ambiguous) in meshes {
        for triangle in &ambiguous.triangles {
            let number = triangle.to_string();
            file.write_record([name, &number]).map_err(bad)?;
        }
    }
    let bytes = file
        .into_inner()
        .map_err(|e| Error::io(path, std::io::Error::other(e.to_string())))?;
    write_bytes(path, &bytes)
}
