//! Baselines: records of runs kept under names, one JSON file each, to check against.
//!
//! A file is the record as `rtbench run -o` writes it, with the instruction counts of
//! the same program beside it where they were asked for.

use std::path::{Path, PathBuf};
use std::{fs, io};

use serde::{Deserialize, Serialize};

use crate::context::Environment;
use measurement::callgrind::Counts;
use measurement::record::RunRecord;
use measurement::record::file::{self, RecordError};
use measurement::settings::choice;
use measurement::system::files::put;
use measurement::system::interrupt::undisturbed;

const FOLDER: &str = ".rtbench/baselines";
const EXTENSION: &str = "json";
const LONGEST: usize = 64;

#[derive(Debug, thiserror::Error)]
pub enum BaselineError {
    #[error(
        "'{0}' is not a valid baseline name: expected 1 to {LONGEST} letters, digits, '.', '-' \
             and '_', beginning with a letter or digit"
    )]
    Name(String),
    #[error("no baseline '{name}' in {}{hint}; {valid}", folder.display())]
    Unknown {
        name: String,
        folder: PathBuf,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    #[error("baseline '{0}' exists; replace it with --overwrite")]
    Exists(String),
    #[error(
        "a baseline cannot be resumed: finish the run with `rtbench run --resume DIR`, then save \
             it with `rtbench baseline save NAME --from DIR`"
    )]
    Resume,
    #[error("{}: the run is not finished; finish it with `rtbench run --resume DIR`", .0.display())]
    Incomplete(PathBuf),
    #[error("baseline {}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error(transparent)]
    Record(#[from] RecordError),
    #[error("{}: {message}", path.display())]
    Counts { path: PathBuf, message: String },
}

impl BaselineError {
    /// Returns whether the error is one of usage (exit code 2).
    pub fn is_usage(&self) -> bool {
        matches!(self, Self::Name(_) | Self::Unknown { .. } | Self::Exists(_) | Self::Resume)
    }
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Baseline {
    /// Read by itself: records of earlier schemas are read, too.
    #[serde(flatten, skip_deserializing)]
    pub record: RunRecord,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instructions: Option<Counts>,
    /// The share of the time in which some thread waited for a processor, where that is known.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cpu_pressure: Option<f64>,
}

#[derive(Debug, Clone)]
pub struct Store(PathBuf);

impl Store {
    /// The folder that the command line names, else the environment, else the usual one.
    pub fn new(folder: Option<&PathBuf>, environment: &Environment) -> Self {
        let named = folder.or(environment.baselines.as_ref()).cloned();
        Self(named.unwrap_or_else(|| PathBuf::from(FOLDER)))
    }

    /// All names, sorted; none where there is no folder.
    pub fn names(&self) -> Result<Vec<String>, BaselineError> {
        let files = match fs::read_dir(&self.0) {
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
            other => other.map_err(|e| self.io(&self.0, e))?,
        };
        let mut names = Vec::new();
        for file in files {
            let path = file.map_err(|e| self.io(&self.0, e))?.path();
            let is_json = path.extension().is_some_and(|e| e == EXTENSION);
            let stem = path.file_stem().and_then(|s| s.to_str()).filter(|_| is_json);
            names.extend(stem.filter(|s| is_name(s)).map(str::to_owned));
        }
        names.sort();
        Ok(names)
    }

    /// Path of the baseline of this name, whether or not it exists.
    pub fn path(&self, name: &str) -> Result<PathBuf, BaselineError> {
        let path = is_name(name).then(|| self.0.join(format!("{name}.{EXTENSION}")));
        path.ok_or_else(|| BaselineError::Name(name.to_owned()))
    }

    pub fn existing(&self, name: &str) -> Result<PathBuf, BaselineError> {
        let path = self.path(name)?;
        if path.is_file() {
            return Ok(path);
        }
        let names = self.names()?;
        Err(BaselineError::Unknown {
            name: name.to_owned(),
            folder: self.0.clone(),
            hint: choice::hint(name, names.iter().map(String::as_str)),
            valid: if names.is_empty() {
                "create one with `rtbench baseline save NAME`".into()
            } else {
                format!("there are: {}", names.join(", "))
            },
        })
    }

    /// The baseline of that name, or the record in that file or folder.
    pub fn open(&self, name_or_path: &str) -> Result<Baseline, BaselineError> {
        let path = Path::new(name_or_path);
        let is_path = !is_name(name_or_path) || path.extension().is_some_and(|e| e == EXTENSION);
        if is_path || (path.exists() && !self.path(name_or_path)?.is_file()) {
            return read(path);
        }
        read(&self.existing(name_or_path)?)
    }

    /// Keeps a baseline under a name, whole or not at all.
    pub fn save(
        &self,
        name: &str,
        baseline: &Baseline,
        replace: bool,
    ) -> Result<PathBuf, BaselineError> {
        let path = self.free(name, replace)?;
        let text = serde_json::to_string_pretty(baseline)
            .map_err(|e| BaselineError::Counts { path: path.clone(), message: e.to_string() })?;
        fs::create_dir_all(&self.0).map_err(|e| self.io(&self.0, e))?;
        undisturbed(|| put(&path, text.as_bytes())).map_err(|e| self.io(&path, e))?;
        Ok(path)
    }

    /// The path of a baseline that is not there yet, or may be replaced.
    pub fn free(&self, name: &str, replace: bool) -> Result<PathBuf, BaselineError> {
        let path = self.path(name)?;
        let is_taken = path.exists() && !replace;
        if is_taken { Err(BaselineError::Exists(name.to_owned())) } else { Ok(path) }
    }

    pub fn remove(&self, name: &str) -> Result<(), BaselineError> {
        let path = self.existing(name)?;
        fs::remove_file(&path).map_err(|e| self.io(&path, e))
    }

    fn io(&self, path: &Path, source: io::Error) -> BaselineError {
        BaselineError::Io { path: path.to_owned(), source }
    }
}

/// Reads the record in a file or folder, and the counts beside it.
pub fn read(path: &Path) -> Result<Baseline, BaselineError> {
    let path = file::path_of(path);
    let text = file::bytes(&path)?;
    let record = file::record(&path, &text)?;
    let baseline: Baseline = serde_json::from_slice(&text)
        .map_err(|e| BaselineError::Counts { path, message: e.to_string() })?;
    Ok(Baseline { record, ..baseline })
}

fn is_name(text: &str) -> bool {
    let is_valid = |c: char| c.is_ascii_alphanumeric() || ".-_".contains(c);
    let begins_well = text.starts_with(|c: char| c.is_ascii_alphanumeric());
    begins_well && text.len() <= LONGEST && text.chars().all(is_valid)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_stay_in_their_folder() {
        for good in ["main", "v1.2", "a-b_c", "7"] {
            assert!(is_name(good), "{good}");
        }
        let long = "x".repeat(65);
        for bad in ["", ".hidden", "-x", "a/b", "../x", "a b", "a\\b", "ä", &long] {
            assert!(!is_name(bad), "{bad}");
        }
    }
}
