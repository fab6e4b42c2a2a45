//! Queries to git: commits and their dates.

use std::ffi::OsStr;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Git did not answer.
#[derive(Debug, thiserror::Error)]
pub enum GitError {
    #[error("cannot start git: {0}")]
    Start(io::Error),
    #[error("{}: no commit `{commit}` in this repository", folder.display())]
    UnknownCommit { commit: String, folder: PathBuf },
    #[error("{}: git {asked}: {said}", folder.display())]
    Failed { folder: PathBuf, asked: String, said: String },
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Commit {
    pub id: String,
    /// When it was committed, seconds since 1970.
    pub unix_s: u64,
    /// The first line of its message.
    pub subject: String,
}

/// As many letters of a commit's name as are shown.
const SHOWN: usize = 10;

/// A commit's name as it is shown.
pub fn short(id: &str) -> String {
    id.chars().take(SHOWN).collect()
}

#[derive(Debug, Clone)]
pub struct Git {
    program: PathBuf,
    folder: PathBuf,
}

impl Git {
    pub fn at(folder: &Path) -> Result<Self, GitError> {
        Self::with(Path::new("git"), folder)
    }

    /// The same by a program of the caller's choice.
    pub fn with(program: &Path, folder: &Path) -> Result<Self, GitError> {
        let git = Self { program: program.into(), folder: folder.into() };
        git.ask(["rev-parse", "--git-dir"])?;
        Ok(git)
    }

    /// Output of git without the final line break.
    fn ask<A: AsRef<OsStr>>(
        &self,
        arguments: impl IntoIterator<Item = A>,
    ) -> Result<String, GitError> {
        let mut command = Command::new(&self.program);
        command.arg("-C").arg(&self.folder).args(arguments).stdin(Stdio::null());
        // a hook that calls us names its own repository
        for name in ["GIT_DIR", "GIT_WORK_TREE", "GIT_INDEX_FILE", "GIT_PREFIX"] {
            command.env_remove(name);
        }
        let ended = command.output().map_err(GitError::Start)?;
        if ended.status.success() {
            return Ok(String::from_utf8_lossy(&ended.stdout).trim_end().to_owned());
        }
        let said = String::from_utf8_lossy(&ended.stderr);
        let said = said.lines().rev().map(str::trim).find(|line| !line.is_empty());
        let asked = command.get_args().skip(2).map(OsStr::to_string_lossy);
        Err(GitError::Failed {
            folder: self.folder.clone(),
            asked: asked.collect::<Vec<_>>().join(" "),
            said: said.map_or_else(|| ended.status.to_string(), str::to_owned),
        })
    }

    pub fn commit(&self, name: &str) -> Result<Commit, GitError> {
        let unknown =
            || GitError::UnknownCommit { commit: name.into(), folder: self.folder.clone() };
        let exact = format!("{name}^{{commit}}");
        let verified = self.ask(["rev-parse", "--verify", "--quiet", "--end-of-options", &exact]);
        let id = match verified {
            Ok(id) => id,
            Err(GitError::Failed { .. }) => return Err(unknown()),
            Err(other) => return Err(other),
        };
        let shown = self.ask(["show", "--no-patch", "--format=%ct %s", &id])?;
        let (unix_s, subject) = shown.split_once(' ').unwrap_or((&shown, ""));
        let unix_s = unix_s.parse().map_err(|_| unknown())?;
        Ok(Commit { id, unix_s, subject: subject.to_owned() })
    }
}
