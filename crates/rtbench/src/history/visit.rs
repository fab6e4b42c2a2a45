//! The runs of a history: records in folders, in the order of their commits, which git is asked for.

use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use measurement::record::RunRecord;
use measurement::record::file::{self, RecordError};

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
        id.map_or_else(|| "unknown".to_owned(), |id| id.chars().take(SHOWN).collect())
    }

    /// The first line of the commit's message, where it is known.
    pub fn subject(&self) -> &str {
        self.commit.as_ref().map_or("", |commit| &commit.subject)
    }
}

/// The runs of all folders, each of which has a record or folders with records, in the order of
/// their commits where a repository says when these were made, else of their own beginnings.
pub fn visits(folders: &[PathBuf], repository: Option<&Path>) -> Result<Vec<Visit>, HistoryError> {
    if let Some(folder) = repository {
        ask_git(folder, &["rev-parse", "--git-dir"])?;
    }
    let mut visits = Vec::new();
    for record in records(folders)? {
        let run = file::read(&record)?;
        let commit = match (repository, &run.tool.git_revision) {
            (Some(folder), Some(id)) => {
                let unknown = || HistoryError::UnknownCommit {
                    record: record.clone(),
                    folder: folder.to_owned(),
                    commit: id.clone(),
                };
                Some(commit(folder, id)?.ok_or_else(unknown)?)
            }
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
    #[error("cannot start git: {0}")]
    NoGit(io::Error),
    #[error("{}: git {asked}: {said}", folder.display())]
    Git { folder: PathBuf, asked: String, said: String },
    #[error(
        "{}: {}: no commit `{commit}` in this repository",
        record.display(), folder.display()
    )]
    UnknownCommit { record: PathBuf, folder: PathBuf, commit: String },
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Commit {
    /// When it was committed, seconds since 1970.
    pub unix_s: u64,
    /// The first line of its message.
    pub subject: String,
}

/// As many letters of a commit's name as are shown.
const SHOWN: usize = 10;

/// Output of git about a repository, without the final line break.
fn ask_git(folder: &Path, arguments: &[&str]) -> Result<String, HistoryError> {
    let mut command = Command::new("git");
    command.arg("-C").arg(folder).args(arguments).stdin(Stdio::null());
    // a hook that calls us names its own repository
    for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX"] {
        command.env_remove(name);
    }
    let ended = command.output().map_err(HistoryError::NoGit)?;
    if ended.status.success() {
        return Ok(String::from_utf8_lossy(&ended.stdout).trim_end().to_owned());
    }
    let said = String::from_utf8_lossy(&ended.stderr);
    let said = said.lines().rev().map(str::trim).find(|line| !line.is_empty());
    Err(HistoryError::Git {
        folder: folder.to_owned(),
        asked: arguments.join(" "),
        said: said.map_or_else(|| ended.status.to_string(), str::to_owned),
    })
}

/// The commit of that name, if the repository has one.
fn commit(folder: &Path, name: &str) -> Result<Option<Commit>, HistoryError> {
    let exact = format!("{name}^{{commit}}");
    let verify = ["rev-parse", "--verify", "--quiet", "--end-of-options", &exact];
    let id = match ask_git(folder, &verify) {
        Err(HistoryError::Git { .. }) => return Ok(None),
        other => other?,
    };
    let shown = ask_git(folder, &["show", "--no-patch", "--format=%ct %s", &id])?;
    let (unix_s, subject) = shown.split_once(' ').unwrap_or((&shown, ""));
    let commit = |unix_s| Commit { unix_s, subject: subject.to_owned() };
    Ok(unix_s.parse().ok().map(commit))
}
