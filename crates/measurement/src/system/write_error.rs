//! Why a file or folder is not written.

use std::io;
use std::path::PathBuf;

/// A file or folder cannot be written.
#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    /// The file or folder.
    pub path: PathBuf,
    pub source: io::Error,
}
