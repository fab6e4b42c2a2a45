//! Any two programs as contenders: what they print says what they timed.
//!
//! A program prints the record of a run of rtbench as JSON, or lines that end in a time: a number with a
//! unit of `s`, `ms`, `us` or `ns`, seconds without one, behind a name and a colon or blank, or alone. Lines of one name are
//! samples of one time, and their median is what a process says of it. Other lines are passed over.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::io;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::gate::against::times_of;
use crate::gate::contest::{Contender, Key, Pace, PairedTimes, Timed};
use measurement::record::RunRecord;
use measurement::system::clock::Clock;
use measurement::system::progress::Progress;
use statistics::estimate::median;

/// A program gave no times.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// It could not be started.
    #[error("cannot start {}: {source}", program.display())]
    Start {
        /// The program.
        program: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// It failed.
    #[error("{}: ended with {how}{said}", program.display())]
    Failed {
        /// The program.
        program: PathBuf,
        /// Exit code or signal.
        how: String,
        /// The last line of what it said on standard error, behind a colon; or empty.
        said: String,
    },
    /// It printed no time.
    #[error(
        "{}: it printed neither a record of rtbench nor a line that ends in a time, like \
         `name: 12.5 ms` ({lines} lines{first})",
        program.display()
    )]
    NoTimes {
        /// The program.
        program: PathBuf,
        /// Lines that it printed.
        lines: usize,
        /// The first of them; or empty.
        first: String,
    },
}

impl CommandError {
    /// The program that gave none.
    pub fn program(&self) -> &Path {
        match self {
            Self::Start { program, .. }
            | Self::Failed { program, .. }
            | Self::NoTimes { program, .. } => program,
        }
    }
}

/// The programs, and what each is called with.
#[derive(Debug)]
pub struct Commands<'a> {
    /// The older.
    pub old: &'a Path,
    /// The newer.
    pub new: &'a Path,
    /// A copy of the newer.
    pub copy: &'a Path,
    /// Arguments of all three.
    pub arguments: &'a [OsString],
    /// How many turns.
    pub pace: Pace,
}

impl Commands<'_> {
    /// All times that all three print.
    ///
    /// # Errors
    /// [`CommandError`].
    pub fn times(
        &self,
        clock: &dyn Clock,
        progress: &Progress,
    ) -> Result<Vec<PairedTimes>, CommandError> {
        self.pace.take_turns(clock, progress, |contender| {
            let program = match contender {
                Contender::Old => self.old,
                Contender::New => self.new,
                Contender::Copy => self.copy,
            };
            let printed = printed(program, self.arguments)?;
            let times = times_in(&printed);
            let mut lines = printed.lines().map(str::trim).filter(|line| !line.is_empty());
            match times.is_empty() {
                false => Ok(times),
                true => Err(CommandError::NoTimes {
                    program: program.into(),
                    first: lines
                        .next()
                        .map(|line| {
                            format!(", the first: {}", line.chars().take(80).collect::<String>())
                        })
                        .unwrap_or_default(),
                    lines: printed.lines().count(),
                }),
            }
        })
    }
}

/// What a program prints.
fn printed(program: &Path, arguments: &[OsString]) -> Result<String, CommandError> {
    let ended = Command::new(program)
        .args(arguments)
        .stdin(Stdio::null())
        .output()
        .map_err(|source| CommandError::Start { program: program.into(), source })?;
    if !ended.status.success() {
        let said = String::from_utf8_lossy(&ended.stderr);
        let last = said.lines().rev().map(str::trim).find(|line| !line.is_empty());
        return Err(CommandError::Failed {
            program: program.into(),
            how: ended.status.to_string(),
            said: last.map(|line| format!(": {line}")).unwrap_or_default(),
        });
    }
    Ok(String::from_utf8_lossy(&ended.stdout).into_owned())
}

/// The times of a program's output.
fn times_in(printed: &str) -> Vec<Timed> {
    if let Ok(record) = serde_json::from_str::<RunRecord>(printed) {
        return times_of(&record);
    }
    let mut named: BTreeMap<&str, Vec<f64>> = BTreeMap::new();
    for (name, seconds) in printed.lines().filter_map(time_in) {
        named.entry(name).or_default().push(seconds);
    }
    let timed = |(name, seconds): (&str, Vec<f64>)| {
        let row = if name.is_empty() { "time" } else { name };
        let key = Key { scene: String::new(), row: row.into(), quantity: "time" };
        Some(Timed { key, seconds: median(&seconds)? })
    };
    named.into_iter().filter_map(timed).collect()
}

/// The name and the seconds of a line that ends in a time.
fn time_in(line: &str) -> Option<(&str, f64)> {
    const UNITS: [(&str, f64); 5] =
        [("ns", 1e-9), ("us", 1e-6), ("\u{b5}s", 1e-6), ("ms", 1e-3), ("s", 1.0)];
    let line = line.trim();
    let unit = UNITS.iter().find(|(unit, _)| line.ends_with(unit));
    let (rest, factor) = match unit {
        Some((unit, factor)) => (line.strip_suffix(unit)?.trim_end(), *factor),
        None => (line, 1.0),
    };
    let start = rest.rfind(|c: char| c.is_whitespace() || [':', '=', ','].contains(&c));
    let (name, number) = match start {
        Some(at) => {
            let width = rest.get(at..)?.chars().next()?.len_utf8();
            (rest.get(..at)?, rest.get(at + width..)?)
        }
        None => ("", rest),
    };
    let seconds = number.parse::<f64>().ok()? * factor;
    let is_blank = |c: char| c.is_whitespace() || [':', '=', ','].contains(&c);
    (seconds.is_finite() && seconds > 0.0).then_some((name.trim_end_matches(is_blank), seconds))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_of_lines_are_read() {
        let near = |line: &str, name: &str, seconds: f64| {
            let (found, s) = time_in(line).unwrap_or_else(|| panic!("{line}"));
            assert!(found == name && (s / seconds - 1.0).abs() < 1e-12, "{line}: {found} {s}");
        };
        near("sort: 12.5 ms", "sort", 0.0125);
        near("  parse a file\t3us", "parse a file", 3e-6);
        near("0.25", "", 0.25);
        near("x=1e-3s", "x", 1e-3);
        near("build, 7 ns", "build", 7e-9);
        near("a 2 \u{b5}s", "a", 2e-6);
        for none in ["", "done", "42 frames", "-1 ms", "nan s", "inf", "ms", "0 ms", "it took ms"] {
            assert_eq!(time_in(none), None, "{none}");
        }
    }

    #[test]
    fn a_process_says_the_median_of_its_samples() {
        let times = times_in("hello\na: 1 s\na: 9 s\na: 2 s\nb: 5 ms\n");
        let of = |i: usize| (times[i].key.row.as_str(), times[i].seconds);
        assert_eq!((of(0), of(1), times.len()), (("a", 2.0), ("b", 0.005), 2));
    }

    #[test]
    fn records_of_rtbench_are_read() {
        let run = measurement::record::made_up::run(&[("tetra", &[("a", &[1.0, 3.0, 2.0])])]);
        let times = times_in(&serde_json::to_string(&run).unwrap());
        let trace = times.iter().find(|t| t.key.quantity == "trace").unwrap();
        assert_eq!((trace.key.scene.as_str(), trace.seconds), ("tetra", 2.0));
    }
}
