//! Why a plugin cannot be used.

use std::io;
use std::path::PathBuf;

/// Why a plugin cannot be used at all; what goes wrong with a row of it is that row's.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PluginError {
    /// The file is no shared library, or lacks something that it needs.
    #[error("{}: cannot be loaded: {message}", file.display())]
    Load {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        message: String,
    },
    /// It lacks the symbol of a plugin.
    #[error(
        "{}: has no function rtbench_plugin_describe; export it with extern \"C\" (see rtbench.h)",
        file.display()
    )]
    NoSymbol {
        /// The file.
        file: PathBuf,
    },
    /// It was compiled for another interface.
    #[error(
        "{}: speaks version {found} of rtbench.h, this program version {own}: compile it with the \
         header of this program", file.display()
    )]
    Version {
        /// The file.
        file: PathBuf,
        /// Its version.
        found: u32,
        /// Ours.
        own: u32,
    },
    /// It says something of itself that is not valid.
    #[error("{}: {what}", file.display())]
    Description {
        /// The file.
        file: PathBuf,
        /// What is wrong.
        what: String,
    },
    /// Its process ended or hung while it was asked what it is.
    #[error("{}: {how} while it was asked what it is", file.display())]
    Died {
        /// The file.
        file: PathBuf,
        /// How it ended.
        how: String,
    },
    /// There are no processes of plugins on this system.
    #[error(
        "{}: plugins have processes of their own on Unix only: add --in-process", file.display()
    )]
    NoProcesses {
        /// The file.
        file: PathBuf,
    },
    /// What its process says of it, the file's name first.
    #[error("{0}")]
    Child(String),
    /// There is another row of that name.
    #[error("{}: there is another structure '{name}': give the plugin a name of its own", file.display())]
    NameTaken {
        /// The file.
        file: PathBuf,
        /// The name.
        name: String,
    },
    /// The file cannot be read.
    #[error("{}: {source}", file.display())]
    Read {
        /// The file.
        file: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
}
