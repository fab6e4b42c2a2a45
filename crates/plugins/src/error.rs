//! Why a plugin cannot be used.

use std::io;
use std::path::PathBuf;

/// Why a plugin cannot be used at all; what goes wrong with a row of it is that row's.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PluginError {
    /// It cannot be loaded, says something of itself that is not valid, or its process ends before
    /// it says anything.
    #[error("{}: {what}", file.display())]
    Invalid { file: PathBuf, what: String },
    /// There are no processes of plugins on this system.
    #[error(
        "{}: plugins run in separate processes on Unix only; add --in-process", file.display()
    )]
    NoProcesses { file: PathBuf },
    /// Error reported by its process, starting with the file's name.
    #[error("{0}")]
    Child(String),
    /// There is another row of that name.
    #[error("{}: another structure is named '{name}'; rename the plugin", file.display())]
    NameTaken { file: PathBuf, name: String },
    /// The file cannot be read.
    #[error("{}: {source}", file.display())]
    Read { file: PathBuf, source: io::Error },
}
