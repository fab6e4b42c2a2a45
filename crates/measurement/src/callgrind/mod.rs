//! Instruction counts of the build and of the traversal of each row, by valgrind's callgrind.
//!
//! Source: the manual of callgrind (N. Nethercote, J. Seward, "Valgrind: A Framework for
//! Heavyweight Dynamic Binary Instrumentation", PLDI 2007). All rows are counted in one process, as
//! starting valgrind and loading scenes is what takes long: everything to be counted runs in one
//! function that is never inlined ([`counted::counted_phase`]), which switches the counting on and
//! off, and each return from it writes a file of its own.

pub mod counted;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{fs, io};

use serde::{Deserialize, Serialize};
use tempfile::TempDir;

use crate::record::RunRecord;
use crate::system::child_process::{ChildError, answer, arguments, without_samples};

/// The function whose calls are counted, in whichever crate older and newer binaries have it: of
/// two options with the same pattern, callgrind 3.19 follows only one.
const PHASE: &str = "*::callgrind::counted::counted_phase";

#[derive(Debug, thiserror::Error)]
pub enum CallgrindError {
    #[error(
        "instruction counts need valgrind, which could not be started ({0}); install it (`apt-get \
         install valgrind`), or leave instruction counts out with --instructions=false"
    )]
    NoValgrind(String),
    #[error(transparent)]
    Child(#[from] ChildError),
    #[error("cannot find the file of this program to start it under valgrind")]
    NoProgram,
    #[error("callgrind's output {}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("callgrind's output: {0}")]
    Output(String),
    #[error(
        "callgrind counted {found} of {expected} phases: were the symbols of {} stripped?",
        program.display()
    )]
    Phases { program: PathBuf, expected: usize, found: usize },
    #[error(
        "{}: made by rtbench at {}, this is {}: instruction counts of different builds are not comparable",
        path.display(), name(was), name(is)
    )]
    OtherProgram { path: PathBuf, was: Option<String>, is: Option<String> },
}

fn name(revision: &Option<String>) -> &str {
    revision.as_deref().unwrap_or("an unknown commit")
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Counts {
    pub valgrind: String,
    pub rows: Vec<CountedRow>,
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct CountedRow {
    pub scene: String,
    pub structure: String,
    /// Settings that differ from the defaults.
    pub settings: String,
    pub rays: u64,
    pub build: Option<u64>,
    /// Instructions of the traversals of all those rays; none where it was not built.
    pub trace: Option<u64>,
}

pub fn version() -> Result<String, CallgrindError> {
    let output = Command::new("valgrind").arg("--version").output();
    let output = output.map_err(|e| CallgrindError::NoValgrind(e.to_string()))?;
    let said = |text: &[u8]| String::from_utf8_lossy(text).trim().to_owned();
    let version = output.status.success().then(|| said(&output.stdout));
    version.ok_or_else(|| CallgrindError::NoValgrind(said(&output.stderr)))
}

/// Counts what `program` takes for the rows of a record; sources of scene files may lie outside
/// their folders where that is allowed.
pub fn count(
    program: Option<&Path>,
    record: &RunRecord,
    allow_outside: bool,
) -> Result<Counts, CallgrindError> {
    let valgrind = version()?;
    let program = program.ok_or(CallgrindError::NoProgram)?;
    let folder = scratch()?;
    let mut command = callgrind(folder.path());
    command.arg(program).args(arguments(allow_outside)).arg("count-instructions");
    let phases: Vec<counted::CountedCalls> = answer(&mut command, &without_samples(record))?;
    let totals = totals(folder.path())?;
    let expected = phases.iter().flat_map(|p| [p.build_call, p.trace_call]).flatten().count();
    if totals.len() != expected {
        let (program, found) = (program.to_owned(), totals.len());
        return Err(CallgrindError::Phases { program, expected, found });
    }
    let total = |call: Option<usize>| call.and_then(|i| totals.get(i).copied());
    let rows = phases.into_iter().map(|phase| CountedRow {
        build: total(phase.build_call),
        trace: total(phase.trace_call),
        scene: phase.scene,
        structure: phase.structure,
        settings: phase.settings,
        rays: phase.rays,
    });
    Ok(Counts { valgrind, rows: rows.collect() })
}

/// Callgrind, counting the phase function alone, a file a call; its program is to be added.
fn callgrind(folder: &Path) -> Command {
    let mut command = Command::new("valgrind");
    // what allocating costs must not depend on what was freed before; threads keep their own
    // arenas, or it would depend on what other threads allocate, and no caches of chunks: into
    // these goes what a thread frees of another's, so that the length of the record would count
    command.env("MALLOC_MMAP_THRESHOLD_", "131072");
    command.env("GLIBC_TUNABLES", "glibc.malloc.tcache_count=0");
    command
        .args(["--tool=callgrind", "--collect-atstart=no", "--quiet"])
        .arg(format!("--toggle-collect={PHASE}"))
        .arg(format!("--dump-after={PHASE}"))
        .arg(format!("--callgrind-out-file={}", folder.join("out").display()));
    command
}

/// The instructions of all files in the folder that a return from the phase function wrote, in
/// order.
fn totals(folder: &Path) -> Result<Vec<u64>, CallgrindError> {
    let io = |path: &Path| {
        let path = path.to_owned();
        move |source| CallgrindError::Io { path, source }
    };
    let mut parts = Vec::new();
    for file in fs::read_dir(folder).map_err(io(folder))? {
        let path = file.map_err(io(folder))?.path();
        let text = fs::read_to_string(&path).map_err(io(&path))?;
        parts.extend(part(&text).map_err(CallgrindError::Output)?);
    }
    parts.sort_unstable_by_key(|(number, _)| *number);
    Ok(parts.into_iter().map(|(_, instructions)| instructions).collect())
}

/// The number of a file's part and its instructions; none for the part that the end of the program
/// wrote.
fn part(text: &str) -> Result<Option<(u64, u64)>, String> {
    let value =
        |key: &str| text.lines().find_map(|line| Some(line.strip_prefix(key)?.trim().to_owned()));
    let line = |key: &str| value(key).ok_or_else(|| format!("no line '{key}'"));
    let number = |key: &str, text: &str| {
        text.parse::<u64>().map_err(|_| format!("'{key} {text}': expected a whole number"))
    };
    let trigger = value("desc: Trigger:").unwrap_or_default();
    if !trigger.starts_with("--dump-after") {
        return Ok(None);
    }
    let events = line("events:")?;
    if events != "Ir" {
        return Err(format!("'events: {events}': expected 'Ir' alone"));
    }
    let instructions = number("totals:", &line("totals:")?)?;
    Ok(Some((number("part:", &line("part:")?)?, instructions)))
}

/// A folder for callgrind's files, removed when it is dropped.
fn scratch() -> Result<TempDir, CallgrindError> {
    let made = tempfile::Builder::new().prefix("rtbench-callgrind-").tempdir();
    made.map_err(|source| CallgrindError::Io { path: std::env::temp_dir(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    const PART: &str = "# callgrind format\nversion: 1\npid: 7\npart: 3\n\n\
        desc: Trigger: --dump-after=x\nevents: Ir\nfn=x\n0 12\n\ntotals: 1234\n";

    #[test]
    fn callgrind_parts_have_a_number_and_a_total() {
        assert_eq!(part(PART), Ok(Some((3, 1234))));
        let end = PART.replace("--dump-after=x", "Program termination");
        assert_eq!(part(&end), Ok(None));
        for damaged in [
            PART.replace("totals: 1234", ""),
            PART.replace("1234", "12 34"),
            PART.replace("1234", "x"),
            PART.replace("events: Ir", "events: Ir Dr"),
            PART.replace("part: 3", "part: three"),
        ] {
            assert!(part(&damaged).is_err(), "{damaged}");
        }
    }

    #[test]
    fn callgrind_parts_are_sorted_by_number() {
        let folder = scratch().unwrap();
        for (name, number, total) in [("out.10", "10", "5"), ("out.9", "9", "4"), ("out", "x", "9")]
        {
            let text = PART.replace("part: 3", &format!("part: {number}")).replace("1234", total);
            let text = if name == "out" { text.replace("--dump-after", "end") } else { text };
            fs::write(folder.path().join(name), text).unwrap();
        }
        assert_eq!(totals(folder.path()).unwrap(), [4, 5]);
    }
}
