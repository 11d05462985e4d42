//! A file's bytes where they lie: mapped, not read.
//!
//! In: a path. Out: [`Mapped`], whose bytes the system fetches when they are looked at, and shares with whoever else maps
//! the file. Opening costs the same for any size.
//!
//! **The only `unsafe` outside of `gpu/`**, and why it is here: nothing else than a mapping gives tables of a hundred
//! megabytes in a millisecond, and no safe interface to one exists. What it asks for is that nobody changes the file while
//! it is mapped. This crate never does: it writes beside and renames, so a mapping keeps the old file. Somebody else who
//! writes into a mapped file changes what was validated, and who cuts it short ends the process (SIGBUS); where that may
//! happen, read the file instead ([`read_file`](super::read_file)). `tests/edges.rs` holds this file to one block.

use crate::error::{Error, Result};
use std::path::Path;
use std::sync::Arc;

/// The bytes of a file that nobody changes.
#[derive(Clone, Debug)]
pub struct Mapped {
    name: String,
    map: Arc<memmap2::Mmap>,
}

impl Mapped {
    /// Maps a plain file. It must not be changed in place while it is mapped; it may be replaced or removed.
    ///
    /// # Errors
    /// [`Error::Io`] where it cannot be opened, is not a plain file, or is empty.
    pub fn open(path: &Path) -> Result<Self> {
        let io = |e| Error::io(path, e);
        let refuse = |why| io(std::io::Error::new(std::io::ErrorKind::InvalidInput, why));
        // Looked at first: opening a pipe would wait for its other end.
        let about = std::fs::metadata(path).map_err(io)?;
        if !about.is_file() {
            return Err(refuse("is not a plain file"));
        }
        if about.len() == 0 {
            return Err(refuse("is empty"));
        }
        let file = std::fs::File::open(path).map_err(io)?;
        // SAFETY: the bytes are only read, through a shared slice that lives no longer than the map. That no one changes
        // them meanwhile is what `open` asks of its caller, see above.
        #[allow(unsafe_code, reason = "see the file's head")]
        let map = unsafe { memmap2::Mmap::map(&file) }.map_err(io)?;
        Ok(Mapped {
            name: path.display().to_string(),
            map: Arc::new(map),
        })
    }

    /// The path it was opened by, as errors name it.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Says that some bytes will be looked at soon, so that the system fetches them at once instead of page by page. Only
    /// faster: where the system does not know this, nothing happens.
    pub fn expect(&self, range: std::ops::Range<usize>) {
        #[cfg(target_os = "linux")]
        if range.end <= self.map.len() && range.start < range.end {
            let advice = memmap2::Advice::PopulateRead;
            let _ = self.map.advise_range(advice, range.start, range.len());
        }
        #[cfg(not(target_os = "linux"))]
        drop(range);
    }

    /// All bytes.
    #[inline]
    pub fn bytes(&self) -> &[u8] {
        &self.map
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_map_has_the_files_bytes_also_when_it_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("some.bin");
        std::fs::write(&path, [1, 2, 3]).unwrap();
        let mapped = Mapped::open(&path).unwrap();
        let other = folder.path().join("other.bin");
        std::fs::write(&other, [9]).unwrap();
        std::fs::rename(&other, &path).unwrap();
        assert_eq!(mapped.bytes(), [1, 2, 3]);
        assert_eq!(Mapped::open(&path).unwrap().bytes(), [9]);
    }

    #[test]
    fn what_is_no_file_or_empty_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let empty = folder.path().join("empty");
        std::fs::write(&empty, []).unwrap();
        for path in [folder.path(), &empty, &folder.path().join("missing")] {
            assert_eq!(Mapped::open(path).unwrap_err().exit_code(), 3);
        }
    }
}
