//! Why no commit was found.

use std::io;
use std::path::PathBuf;

use crate::gate::GateError;
use crate::git::GitError;
use measurement::system::program_copy::CopyError;

/// Why no commit was found.
#[derive(Debug, thiserror::Error)]
pub enum BisectError {
    /// Git refused, knows no such commit, or is not there.
    #[error(transparent)]
    Git(#[from] GitError),
    /// Nothing lies between them.
    #[error(
        "{good} is no ancestor of {bad} along first parents, or the same commit: nothing lies between them"
    )]
    NothingBetween {
        /// The good commit, as named.
        good: String,
        /// The bad one.
        bad: String,
    },
    /// One of the two that all others are between cannot be built.
    #[error("{commit}: {why}")]
    Unbuilt {
        /// The commit.
        commit: String,
        /// Why.
        why: String,
    },
    /// The bad one is not bad.
    #[error(
        "{bad} is not certainly slower than {good}: {found}; try more --rounds, or a smaller --time-threshold"
    )]
    NotSlower {
        /// The bad commit.
        bad: String,
        /// The good one.
        good: String,
        /// What was measured.
        found: String,
    },
    /// A row is no row.
    #[error(
        "'{text}': expected SCENE/STRUCTURE, like 'teapot/kd-tree' or 'teapot/hug density=9/trace'"
    )]
    Malformed {
        /// As typed.
        text: String,
    },
    /// A folder for trees of files cannot be made.
    #[error("cannot make a folder in {}: {source}", folder.display())]
    Folder {
        /// Where.
        folder: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A program cannot be kept.
    #[error(transparent)]
    Copy(#[from] CopyError),
    /// The programs could not be measured.
    #[error(transparent)]
    Gate(Box<GateError>),
}

impl BisectError {
    /// What was typed makes no sense.
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Malformed { .. } | Self::NothingBetween { .. })
    }
}

impl From<GateError> for BisectError {
    fn from(error: GateError) -> Self {
        Self::Gate(Box::new(error))
    }
}
