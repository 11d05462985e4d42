//! Files that are whole or absent.
//!
//! In: a path and all the bytes. Out: the file, or an [`Error::Io`] that names the path and says what to do; never
//! half a file. The bytes go to a temporary file in the same folder, which then takes the name in one step.

use std::fs;
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};

use crate::{Error, Result};

/// Writes `bytes` to `path`, replacing what is there only when everything has been written.
///
/// A symbolic link is followed, so the link stays a link. A pipe or device (`/dev/stdout`) has no folder to write
/// beside: it receives the bytes directly, and is never replaced by a file.
///
/// # Errors
/// [`Error::Io`] for a missing or read-only folder, a folder where the file should be, a full disk.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    check_target(path)?;
    let target = fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf());
    match fs::metadata(&target) {
        Ok(meta) if !meta.is_file() => write_through(&target, bytes),
        existing => write_beside(&target, bytes, existing.ok().map(|meta| meta.permissions())),
    }
    .map_err(|source| Error::io(path, explain(source)))
}

/// Says early, before minutes of work, that `path` could not be written: its folder is missing or it is a folder.
///
/// # Errors
/// [`Error::Io`] naming the folder or the path.
pub fn check_target(path: &Path) -> Result<()> {
    if path.as_os_str().is_empty() || path.is_dir() {
        return Err(Error::io(
            path,
            io::Error::new(ErrorKind::IsADirectory, "is a folder; give a file name"),
        ));
    }
    check_folder(path)
}

/// Makes the folder `path` unless it is there; the folder it lies in must exist, so that a mistyped path is noticed.
///
/// # Errors
/// [`Error::Io`] when the parent is missing, a file has that name, or the folder cannot be made.
pub fn make_folder(path: &Path) -> Result<()> {
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => Ok(()),
        Ok(_) => Err(Error::io(
            path,
            io::Error::new(
                ErrorKind::NotADirectory,
                "is a file; a folder is needed here",
            ),
        )),
        Err(_) => {
            check_folder(path)?;
            fs::create_dir(path).map_err(|source| Error::io(path, explain(source)))
        }
    }
}

fn check_folder(path: &Path) -> Result<()> {
    let folder = folder_of(path);
    match fs::metadata(&folder) {
        Ok(meta) if meta.is_dir() => Ok(()),
        Ok(_) => Err(Error::io(
            folder,
            io::Error::new(ErrorKind::NotADirectory, "is not a folder"),
        )),
        Err(source) if source.kind() == ErrorKind::NotFound => Err(Error::io(
            &folder,
            io::Error::new(
                ErrorKind::NotFound,
                "the output folder does not exist; create it first",
            ),
        )),
        Err(source) => Err(Error::io(folder, explain(source))),
    }
}

fn folder_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

fn write_through(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut file = fs::OpenOptions::new().write(true).open(path)?;
    file.write_all(bytes)?;
    file.flush()
}

fn write_beside(path: &Path, bytes: &[u8], permissions: Option<fs::Permissions>) -> io::Result<()> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(".invertex-");
    // A temporary file is private by default; a result is as readable as any other file (umask still applies).
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut file = builder.tempfile_in(folder_of(path))?;
    file.write_all(bytes)?;
    file.flush()?;
    if let Some(permissions) = permissions {
        file.as_file().set_permissions(permissions)?;
    }
    file.persist(path).map(drop).map_err(|failed| failed.error)
}

/// The operating system's error without the temporary file's name, which means nothing to the reader.
fn explain(source: io::Error) -> io::Error {
    let kind = source.kind();
    let text = match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "no space left to write it; nothing was written"
        }
        ErrorKind::PermissionDenied => "no permission to write here",
        ErrorKind::ReadOnlyFilesystem => "the file system is read-only",
        _ => return source,
    };
    io::Error::new(kind, text)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_replaced_whole_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        write_bytes(&path, b"first, longer").unwrap();
        write_bytes(&path, b"second").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no/where");
        let error = write_bytes(&missing.join("a.bin"), b"x")
            .unwrap_err()
            .to_string();
        assert!(
            error.contains(&missing.display().to_string()) && error.contains("does not exist"),
            "{error}"
        );
    }

    #[test]
    fn a_folder_is_not_a_file_and_a_file_is_not_a_folder() {
        let folder = tempfile::tempdir().unwrap();
        assert!(write_bytes(folder.path(), b"x").is_err());
        let file = folder.path().join("file");
        write_bytes(&file, b"x").unwrap();
        assert!(make_folder(&file).is_err());
        assert!(write_bytes(&file.join("below"), b"x").is_err());
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_full_device_is_an_error_and_stays_a_device() {
        use std::os::unix::fs::FileTypeExt;
        let full = Path::new("/dev/full");
        if !full.exists() {
            return println!("SKIPPED: no /dev/full here");
        }
        let error = write_bytes(full, &[0; 1 << 16]).unwrap_err().to_string();
        assert!(error.contains("no space"), "{error}");
        assert!(fs::metadata(full).unwrap().file_type().is_char_device());
    }

    #[cfg(unix)]
    #[test]
    fn a_link_stays_a_link_and_permissions_stay() {
        use std::os::unix::fs::PermissionsExt;
        let folder = tempfile::tempdir().unwrap();
        let (file, link) = (folder.path().join("file"), folder.path().join("link"));
        fs::write(&file, b"old").unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&file, &link).unwrap();
        write_bytes(&link, b"new").unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert_eq!(fs::read(&file).unwrap(), b"new");
        assert_eq!(
            fs::metadata(&file).unwrap().permissions().mode() & 0o777,
            0o640
        );
    }
}
