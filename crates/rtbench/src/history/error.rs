//! Why no history can be made.

use std::io;
use std::path::PathBuf;

use crate::git::GitError;
use measurement::record::file::RecordError;

/// Why no history can be made.
#[derive(Debug, thiserror::Error)]
pub enum HistoryError {
    /// A record cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// A folder cannot be looked into.
    #[error("cannot read {}: {source}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Nothing is there.
    #[error(
        "{}: no results.json in it, nor in a folder in it; expected what `rtbench run -o DIR` writes",
        folder.display()
    )]
    NoRecords {
        /// The folder.
        folder: PathBuf,
    },
    /// The repository does not know a commit, or there is no git.
    #[error(transparent)]
    Git(#[from] GitError),
    /// The commit of a record is not in the repository.
    #[error("{}: {source}", record.display())]
    UnknownCommit {
        /// The record.
        record: PathBuf,
        /// Which, and where.
        source: GitError,
    },
}
