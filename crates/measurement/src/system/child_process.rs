//! This program, another version of it, or a copy of its file, as a process of its own: a record
//! goes in, JSON comes out.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use serde::Serialize;
use serde::de::DeserializeOwned;
use tempfile::TempDir;

use crate::record::RunRecord;

#[derive(Debug, thiserror::Error)]
pub enum ChildError {
    #[error("cannot start {}: {source}", program.display())]
    Start { program: PathBuf, source: io::Error },
    #[error(
        "{}: this binary is older than `rtbench check`; build it from a newer commit", program.display()
    )]
    Lacks { program: PathBuf },
    #[error("{}: ended with {how}: {said}", program.display())]
    Failed { program: PathBuf, how: String, said: String },
    #[error("{}: cannot read its reply ({message}); is it another version?", program.display())]
    Answer { program: PathBuf, message: String },
}

/// The first arguments of this program as a child, which reads the scenes that its parent may read.
pub fn arguments(allow_outside: bool) -> &'static [&'static str] {
    if allow_outside { &["--quiet", "--allow-outside", "child"] } else { &["--quiet", "child"] }
}

/// Starts the command with a record, or other settings, on its standard input and reads its answer.
pub fn answer<T: DeserializeOwned>(
    command: &mut Command,
    record: &impl Serialize,
) -> Result<T, ChildError> {
    let program = PathBuf::from(command.get_program());
    let started = |source| ChildError::Start { program: program.clone(), source };
    let unreadable = |message: String| ChildError::Answer { program: program.clone(), message };
    let text = serde_json::to_vec(record).map_err(|e| unreadable(e.to_string()))?;
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().map_err(started)?;
    if let Some(mut stdin) = child.stdin.take() {
        // one that fails at once reads nothing; its exit code says more than the closed pipe
        let _ = stdin.write_all(&text);
    }
    let ended = child.wait_with_output().map_err(started)?;
    let said = String::from_utf8_lossy(&ended.stderr);
    if !ended.status.success() {
        return Err(ended_early(&program, ended.status, &said));
    }
    serde_json::from_slice(&ended.stdout).map_err(|e| unreadable(e.to_string()))
}

/// Why a child that said something on standard error gave no answer.
pub fn ended_early(program: &Path, status: ExitStatus, said: &str) -> ChildError {
    let program = program.to_owned();
    if said.contains("unrecognized subcommand") {
        return ChildError::Lacks { program };
    }
    ChildError::Failed { program, how: status.to_string(), said: last(said) }
}

fn last(text: &str) -> String {
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|l| !l.is_empty()).collect();
    lines.get(lines.len().saturating_sub(3)..).unwrap_or_default().join("; ")
}

/// The record without samples: what a child needs to know is short.
pub fn without_samples(record: &RunRecord) -> RunRecord {
    let mut record = record.clone();
    record.scenes.iter_mut().flat_map(|s| &mut s.rows).for_each(|row| row.samples.clear());
    record.summary.clear();
    record
}

#[derive(Debug, thiserror::Error)]
#[error("cannot copy {} into {}: {source}", program.display(), folder.display())]
pub struct CopyError {
    program: PathBuf,
    folder: PathBuf,
    source: io::Error,
}

/// A copy of a program's file, to be run beside it: the same code, elsewhere in memory and on disk.
/// It is removed with this.
///
/// On Linux the copy has no name any more as soon as it is made: it is run through the descriptor
/// that this process has of it, and whatever ends the process leaves no file behind.
#[derive(Debug)]
pub struct ProgramCopy {
    /// None where the copy has no name.
    _folder: Option<TempDir>,
    _open: Option<File>,
    path: PathBuf,
}

impl ProgramCopy {
    /// Copies the program, with its permissions, into a folder of its own within `temporary`.
    pub fn of(program: &Path, temporary: &Path) -> Result<Self, CopyError> {
        let made = || {
            let folder = tempfile::Builder::new().prefix("rtbench-copy-").tempdir_in(temporary)?;
            let name = program.file_name().unwrap_or("rtbench".as_ref());
            let path = folder.path().join(name);
            std::fs::copy(program, &path)?;
            let open = File::open(&path)?;
            Ok(match nameless(&open) {
                Some(path) => Self { _folder: None, _open: Some(open), path },
                None => Self { _folder: Some(folder), _open: None, path },
            })
        };
        let (program, folder) = (program.to_owned(), temporary.to_owned());
        made().map_err(|source| CopyError { program, folder, source })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// A path of an open file that stays when its name is removed; none where the system has no such
/// paths.
#[cfg(target_os = "linux")]
fn nameless(open: &File) -> Option<PathBuf> {
    use std::os::fd::AsRawFd;
    let path = PathBuf::from(format!("/proc/{}/fd/{}", std::process::id(), open.as_raw_fd()));
    path.exists().then_some(path)
}

#[cfg(not(target_os = "linux"))]
fn nameless(_: &File) -> Option<PathBuf> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_copy_is_identical_and_removed_afterwards() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program");
        std::fs::write(&program, "code").unwrap();
        let copy = ProgramCopy::of(&program, folder.path()).unwrap();
        assert_eq!(std::fs::read(copy.path()).unwrap(), b"code");
        assert_ne!(copy.path(), program);
        let names = || std::fs::read_dir(folder.path()).unwrap().count();
        // nothing is left if this is killed
        assert!(names() == 1 || cfg!(not(target_os = "linux")));
        drop(copy);
        assert_eq!(names(), 1);
        let error = ProgramCopy::of(&folder.path().join("none"), folder.path()).unwrap_err();
        assert!(error.to_string().starts_with("cannot copy "), "{error}");
    }
}
