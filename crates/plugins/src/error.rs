//! Why a plugin cannot be used.

use std::io;
use std::path::PathBuf;

/// Why a plugin cannot be used at all; what goes wrong with a row of it is that row's.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PluginError {
    /// The file is no shared library, or lacks something that it needs.
    #[error("{}: cannot be loaded: {message}", file.display())]
    Load { file: PathBuf, message: String },
    /// It lacks the symbol of a plugin.
    #[error(
        "{}: has no function rtbench_plugin_describe; export it with extern \"C\" (see rtbench.h)",
        file.display()
    )]
    NoSymbol { file: PathBuf },
    /// It was compiled for another interface.
    #[error(
        "{}: built for version {found} of rtbench.h, but this program has version {own}; compile \
         it with this program's header", file.display()
    )]
    Version { file: PathBuf, found: u32, own: u32 },
    /// It says something of itself that is not valid.
    #[error("{}: {what}", file.display())]
    Description { file: PathBuf, what: String },
    /// Its process ended or hung while describing itself.
    #[error("{}: {how} while describing itself", file.display())]
    Died { file: PathBuf, how: String },
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
