//! Commits as trees of files outside the repository's own, and what is built there.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::bisect::error::BisectError;
use crate::git::{Commit, Git, short};
use measurement::system::program_copy::ProgramCopy;

/// How a commit becomes a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Recipe {
    /// What builds it, for the system's shell, in the tree's folder.
    pub build: String,
    /// The program, from the tree's folder on.
    pub binary: PathBuf,
}

/// A tree of files that is given one commit after another: what was built for one is there for the next. It is
/// removed with this.
#[derive(Debug)]
pub struct Trees<'a> {
    git: &'a Git,
    recipe: &'a Recipe,
    temporary: TempDir,
    tree: PathBuf,
}

impl<'a> Trees<'a> {
    /// A tree among the temporary files.
    ///
    /// # Errors
    /// [`BisectError`].
    pub fn new(
        git: &'a Git,
        recipe: &'a Recipe,
        at: &Commit,
        temporary: &Path,
    ) -> Result<Self, BisectError> {
        let made = tempfile::Builder::new().prefix("rtbench-bisect-").tempdir_in(temporary);
        let temporary =
            made.map_err(|source| BisectError::Folder { folder: temporary.to_owned(), source })?;
        let tree = temporary.path().join("tree");
        // trees whose folders are gone are forgotten: those of a bisection that was killed
        git.ask(["worktree", "prune"])?;
        let add = ["worktree", "add", "--quiet", "--detach"].map(OsStr::new);
        git.ask(add.into_iter().chain([tree.as_os_str(), OsStr::new(&at.id)]))?;
        Ok(Self { git, recipe, temporary, tree })
    }

    /// The program of a commit; in words why there is none.
    ///
    /// # Errors
    /// [`BisectError`] where git refuses.
    pub fn program(&self, commit: &Commit) -> Result<Result<ProgramCopy, String>, BisectError> {
        self.git.ask_in(&self.tree, ["checkout", "--quiet", "--force", "--detach", &commit.id])?;
        if let Err(why) = self.build() {
            return Ok(Err(why));
        }
        let binary = self.tree.join(&self.recipe.binary);
        if !binary.is_file() {
            return Ok(Err(format!("the build left no {}", self.recipe.binary.display())));
        }
        Ok(ProgramCopy::of(&binary, self.temporary.path()).map_err(|error| error.to_string()))
    }

    /// The folder that it lies in.
    pub fn temporary(&self) -> &Path {
        self.temporary.path()
    }

    fn build(&self) -> Result<(), String> {
        let (shell, flag) = if cfg!(windows) { ("cmd", "/C") } else { ("sh", "-c") };
        let ended = Command::new(shell)
            .args([flag, &self.recipe.build])
            .current_dir(&self.tree)
            .stdin(Stdio::null())
            .output()
            .map_err(|error| format!("cannot start {shell}: {error}"))?;
        if ended.status.success() {
            return Ok(());
        }
        let said = String::from_utf8_lossy(&ended.stderr);
        let last = said.lines().rev().map(str::trim).find(|line| !line.is_empty());
        let last = last.map_or(String::new(), |line| format!(": {line}"));
        Err(format!("the build ended with {}{last}", ended.status))
    }
}

impl Drop for Trees<'_> {
    fn drop(&mut self) {
        let remove = ["worktree", "remove", "--force"].map(OsStr::new);
        // nothing to be done where that fails: the next bisection forgets the tree
        let _ = self.git.ask(remove.into_iter().chain([self.tree.as_os_str()]));
    }
}

/// The commits behind the good one, to the bad one, the oldest first; merges count as one commit.
///
/// # Errors
/// [`BisectError::NothingBetween`], and what git says.
pub fn between(git: &Git, good: &Commit, bad: &Commit) -> Result<Vec<Commit>, BisectError> {
    let nothing = || BisectError::NothingBetween { good: short(&good.id), bad: short(&bad.id) };
    // rev-list would go on to the beginning where one is no ancestor of the other
    if git.ask(["merge-base", "--is-ancestor", &good.id, &bad.id]).is_err() {
        return Err(nothing());
    }
    let range = format!("{}..{}", good.id, bad.id);
    let listed = git.ask(["rev-list", "--reverse", "--first-parent", &range])?;
    let commits = listed.lines().map(|id| git.commit(id)).collect::<Result<Vec<_>, _>>()?;
    if commits.is_empty() { Err(nothing()) } else { Ok(commits) }
}
