//! This program, or another version of it, as a process of its own: a record goes in, JSON comes
//! out.

use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::record::RunRecord;

/// Why a child gave no answer.
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

/// The last lines, joined.
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
