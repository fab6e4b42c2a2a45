//! Files that are written whole, or not at all.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::system::created::Created;
use crate::system::interrupt::undisturbed;

/// A file or folder cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    /// The system's reason.
    pub source: io::Error,
}

/// Writes a finished file in one step, or a pipe or a device.
///
/// # Errors
/// [`WriteError`] naming the file.
pub fn write_text(path: &Path, text: &str) -> Result<(), WriteError> {
    let mut created = Created::default();
    let stream = open(path, &mut created)?;
    let written = undisturbed(|| match stream {
        None => replace(path, text.as_bytes()),
        Some(mut stream) => stream.write_all(text.as_bytes()),
    });
    written.map_err(|source| WriteError { path: path.to_owned(), source })?;
    created.keep();
    Ok(())
}

/// Creates the file; what is no file, but a pipe or a device, stays open.
///
/// # Errors
/// [`WriteError`] naming the file.
pub fn open(path: &Path, created: &mut Created) -> Result<Option<File>, WriteError> {
    let file = created.file(path)?;
    let error = |source| WriteError { path: path.to_owned(), source };
    let is_file = file.metadata().map_err(error)?.is_file();
    Ok((!is_file).then_some(file))
}

/// Replaces a file's content in one step, so that a killed run, or a full disk, never leaves half a
/// file; in place only where the folder does not take new files.
///
/// # Errors
/// The system's.
pub fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    // Links are followed: what they point to is replaced, not the link.
    put(&fs::canonicalize(path)?, content)
}

/// Writes a file's whole content in one step, whether it was there or not.
///
/// # Errors
/// The system's.
pub fn put(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let mut file = match File::create(&temporary) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::PermissionDenied => return fs::write(path, content),
        Err(e) => return Err(e),
    };
    let replaced = file.write_all(content).and_then(|()| fs::rename(&temporary, path));
    if replaced.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    replaced
}
