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
    Folder { folder: PathBuf, source: io::Error },
    #[error(
        "{}: no results.json in it, nor in a folder in it; expected what `rtbench run -o DIR` writes",
        folder.display()
    )]
    NoRecords { folder: PathBuf },
    /// The repository does not know a commit, or there is no git.
    #[error(transparent)]
    Git(#[from] GitError),
    /// The commit of a record is not in the repository.
    #[error("{}: {source}", record.display())]
    UnknownCommit { record: PathBuf, source: GitError },
}
