//! The runs of a history: records in folders, in the order of their commits.

use crate::git::{self, Commit, Git, GitError};
use measurement::record::file::RecordError;
use measurement::record::{RunRecord, file};
use std::io;
use std::path::{Path, PathBuf};

/// A run that was kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Visit {
    pub name: String,
    pub run: RunRecord,
    /// The commit, where a repository says more of it than its name.
    pub commit: Option<Commit>,
}

impl Visit {
    /// When it was committed, else when it was measured: seconds since 1970.
    pub fn unix_s(&self) -> u64 {
        self.commit.as_ref().map_or(self.run.started_unix_s, |commit| commit.unix_s)
    }

    /// The commit's name, short.
    pub fn id(&self) -> String {
        let id = self.run.tool.git_revision.as_ref();
        id.map_or_else(|| "unknown".to_owned(), |id| git::short(id))
    }

    /// The first line of the commit's message, where it is known.
    pub fn subject(&self) -> &str {
        self.commit.as_ref().map_or("", |commit| &commit.subject)
    }
}

/// The runs of all folders, each of which has a record or folders with records, in the order of
/// their commits where a repository says when these were made, else of their own beginnings.
pub fn visits(folders: &[PathBuf], repository: Option<&Path>) -> Result<Vec<Visit>, HistoryError> {
    let git = repository.map(Git::at).transpose()?;
    let mut visits = Vec::new();
    for record in records(folders)? {
        let run = file::read(&record)?;
        let commit = match (&git, &run.tool.git_revision) {
            (Some(git), Some(id)) => Some(git.commit(id).map_err(|source| match source {
                GitError::UnknownCommit { .. } => {
                    HistoryError::UnknownCommit { record: record.clone(), source }
                }
                other => other.into(),
            })?),
            _ => None,
        };
        let name = record.parent().and_then(Path::file_name).unwrap_or_default();
        visits.push(Visit { name: name.to_string_lossy().into_owned(), run, commit });
    }
    visits.sort_by(|a, b| {
        let key = |v: &Visit| (v.unix_s(), v.run.started_unix_s);
        key(a).cmp(&key(b)).then_with(|| a.name.cmp(&b.name))
    });
    Ok(visits)
}

/// The files of records, each once.
fn records(folders: &[PathBuf]) -> Result<Vec<PathBuf>, HistoryError> {
    let mut records: Vec<PathBuf> = Vec::new();
    for folder in folders {
        let own = file::path_of(folder);
        // a file that was named must be there; a folder may be one of folders
        if own.exists() || !folder.is_dir() {
            records.push(own);
            continue;
        }
        let error = |source| HistoryError::Folder { folder: folder.clone(), source };
        let entries = std::fs::read_dir(folder).map_err(error)?;
        let entries = entries.map(|entry| entry.map(|e| e.path().join(file::NAME)));
        let mut within = entries.collect::<Result<Vec<_>, _>>().map_err(error)?;
        within.retain(|path| path.exists());
        if within.is_empty() {
            return Err(HistoryError::NoRecords { folder: folder.clone() });
        }
        records.extend(within);
    }
    records.sort();
    records.dedup();
    Ok(records)
}

/// Why no history can be made.
#[derive(Debug, thiserror::Error)]
pub enum HistoryError {
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error("cannot read {}: {source}", folder.display())]
    Folder { folder: PathBuf, source: io::Error },
    #[error(
        "{}: no results.json in it, nor in a folder in it; expected what `rtbench run -o DIR` writes",
        folder.display()
    )]
    NoRecords { folder: PathBuf },
    #[error(transparent)]
    Git(#[from] GitError),
    #[error("{}: {source}", record.display())]
    UnknownCommit { record: PathBuf, source: GitError },
}
