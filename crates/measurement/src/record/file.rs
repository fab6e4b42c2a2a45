//! Reading records of runs back: what `compare`, `check`, `merge` and `report` work on.
//!
//! In records of schema 1 a row of obvhs by its plain name had `adapter=robust`, and obvhs as its
//! authors use it, which has the plain name now, was `adapter=direct`.

use std::fs::{File, FileType};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::record::{RunRecord, SCHEMA_VERSION, label};

/// The record's name in the output folder of a run.
pub const NAME: &str = "results.json";

const WRITTEN_BY: &str = "rtbench run -o DIR";

/// The most bytes that are read: a full run writes about 3 MB.
const MAX_BYTES: u64 = 1 << 30;

/// Why a record cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum RecordError {
    #[error("cannot read {}: {source}", path.display())]
    Io { path: PathBuf, source: io::Error },
    #[error("cannot read {}: {what}, expected a file", path.display())]
    NotAFile { path: PathBuf, what: &'static str },
    #[error("{}: more than {MAX_BYTES} bytes, too large for a record", path.display())]
    TooLarge { path: PathBuf },
    #[error("{}: line {line}, column {column}: {message}; expected what `{written_by}` writes",
            path.display())]
    Syntax { path: PathBuf, line: usize, column: usize, message: String, written_by: &'static str },
    #[error("{}: written with schema {found}, expected {SCHEMA_VERSION}", path.display())]
    Schema { path: PathBuf, found: u32 },
}

/// The first thing looked at: the rest may have changed with it.
#[derive(Deserialize)]
struct Version {
    schema_version: u32,
}

/// Reads the record in a file, or in the output folder of a run.
pub fn read(path: &Path) -> Result<RunRecord, RecordError> {
    let path = path_of(path);
    record(&path, &bytes(&path)?)
}

/// The record that a file has.
pub fn record(path: &Path, text: &[u8]) -> Result<RunRecord, RecordError> {
    let Version { schema_version: found } = parsed(path, text, WRITTEN_BY)?;
    match found {
        SCHEMA_VERSION => parsed(path, text, WRITTEN_BY),
        1 => {
            let old = parsed(path, text, WRITTEN_BY)?;
            raised(&old).map_err(|error| syntax(path, &error, WRITTEN_BY))
        }
        _ => Err(RecordError::Schema { path: path.to_owned(), found }),
    }
}

/// The record's file: of the output folder of a run, the one within.
pub fn path_of(path: &Path) -> PathBuf {
    if path.is_dir() { path.join(NAME) } else { path.to_owned() }
}

/// A file of results, unless it is too large to be one.
pub fn bytes(path: &Path) -> Result<Vec<u8>, RecordError> {
    let io = |source| RecordError::Io { path: path.to_owned(), source };
    length(path)?;
    let mut text = Vec::new();
    let file = File::open(path).map_err(io)?;
    let length = file.take(MAX_BYTES + 1).read_to_end(&mut text).map_err(io)?;
    if length as u64 > MAX_BYTES {
        return Err(RecordError::TooLarge { path: path.to_owned() });
    }
    Ok(text)
}

/// The length of a file, in bytes. A pipe that nobody writes to would never be read to its end, so
/// whatever is no file is refused before it is opened.
pub fn length(path: &Path) -> Result<u64, RecordError> {
    let found = std::fs::metadata(path)
        .map_err(|source| RecordError::Io { path: path.to_owned(), source })?;
    match kind_of(found.file_type()) {
        Some(what) => Err(RecordError::NotAFile { path: path.to_owned(), what }),
        None => Ok(found.len()),
    }
}

/// Names the kind of a directory entry that is not a file.
fn kind_of(kind: FileType) -> Option<&'static str> {
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt;
        if kind.is_fifo() {
            return Some("it is a pipe");
        } else if kind.is_socket() {
            return Some("it is a socket");
        } else if kind.is_char_device() || kind.is_block_device() {
            return Some("it is a device");
        }
    }
    if kind.is_dir() {
        Some("it is a folder")
    } else if kind.is_file() {
        None
    } else {
        Some("it is no regular file")
    }
}

pub fn parsed<T: DeserializeOwned>(
    path: &Path,
    text: &[u8],
    written_by: &'static str,
) -> Result<T, RecordError> {
    serde_json::from_slice(text).map_err(|error| syntax(path, &error, written_by))
}

fn syntax(path: &Path, error: &serde_json::Error, written_by: &'static str) -> RecordError {
    let message = error.to_string();
    // the library says the place once more at the end
    let message = message.rsplit_once(" at line ").map_or(&*message, |(m, _)| m).to_owned();
    let (line, column) = (error.line(), error.column());
    RecordError::Syntax { path: path.to_owned(), line, column, message, written_by }
}

/// The structures whose plain names have another meaning now.
const RENAMED: [&str; 2] = ["obvhs-cwbvh", "obvhs-bvh2"];

/// The same record with the names of today.
fn raised(record: &RunRecord) -> serde_json::Result<RunRecord> {
    let mut value = serde_json::to_value(record)?;
    rename(&mut value);
    let record: RunRecord = serde_json::from_value(value)?;
    Ok(RunRecord { schema_version: SCHEMA_VERSION, ..record })
}

fn rename(value: &mut Value) {
    match value {
        Value::Object(fields) => {
            let of_row = match (fields.get("structure"), fields.get("settings")) {
                (Some(Value::String(structure)), Some(Value::String(settings))) => {
                    renamed(structure, settings)
                }
                _ => None,
            };
            // what was typed stays
            let mut kept = vec!["command_line"];
            if let Some(settings) = of_row {
                fields.insert("settings".into(), settings.into());
                kept.extend(["structure", "settings"]);
            }
            let others = fields.iter_mut().filter(|(name, _)| !kept.contains(&&***name));
            others.for_each(|(_, value)| rename(value));
        }
        Value::Array(values) => values.iter_mut().for_each(rename),
        Value::String(text) => {
            let (structure, settings) = text.split_once(' ').unwrap_or((&**text, ""));
            let is_row = settings.split_whitespace().all(|setting| setting.contains('='));
            if let Some(settings) = renamed(structure, settings).filter(|_| is_row) {
                *text = label(structure, &settings);
            }
        }
        _ => {}
    }
}

/// The settings of today; `None` for a structure whose name means what it meant.
fn renamed(structure: &str, settings: &str) -> Option<String> {
    if !RENAMED.contains(&structure) {
        return None;
    }
    let mut settings: Vec<&str> = settings.split_whitespace().collect();
    if settings.contains(&"adapter=direct") {
        settings.retain(|setting| *setting != "adapter=direct");
    } else if !settings.iter().any(|setting| setting.starts_with("adapter=")) {
        // in the order of the structure's parameters
        let place = usize::from(settings.first().is_some_and(|s| s.starts_with("preset=")));
        settings.insert(place, "adapter=robust");
    }
    Some(settings.join(" "))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::record::file;
    use crate::record::made_up::run;

    fn read_text(text: &str) -> Result<RunRecord, RecordError> {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(NAME), text).unwrap();
        read(folder.path())
    }

    #[test]
    fn invalid_records_are_errors_with_line_and_column() {
        let error = |text: &str| read_text(text).unwrap_err().to_string();
        assert!(error("").contains("results.json: line 1, column 0: EOF"), "{}", error(""));
        let error_of_syntax = error("{\n  \"schema_version\": nonsense");
        assert!(error_of_syntax.contains("line 2, column "), "{error_of_syntax}");
        assert!(!error_of_syntax.contains(" at line "), "{error_of_syntax}");
        assert!(error("{\"schema_version\": 99, \"x\": 1}").contains("schema 99, expected 2"));
        assert!(error("{\"schema_version\": 1}").contains("missing field"));
        let missing = read(Path::new("/nowhere/results.json")).unwrap_err().to_string();
        assert!(missing.starts_with("cannot read /nowhere/results.json"), "{missing}");
    }

    #[test]
    fn rows_of_schema_1_have_the_names_of_today() {
        let names = [
            ("obvhs-cwbvh", "obvhs-cwbvh adapter=robust"),
            (
                "obvhs-cwbvh preset=fast kernel=scalar",
                "obvhs-cwbvh preset=fast adapter=robust kernel=scalar",
            ),
            ("obvhs-cwbvh preset=fast adapter=direct", "obvhs-cwbvh preset=fast"),
            ("obvhs-bvh2 adapter=direct", "obvhs-bvh2"),
            ("obvhs-bvh2 adapter=as-shipped", "obvhs-bvh2 adapter=as-shipped"),
            ("wide-bvh preset=morton", "wide-bvh preset=morton"),
        ];
        let rows = names.map(|(old, _)| (old, &[1.0][..]));
        let mut old = run(&[("tetra", &rows)]);
        old.settings.reference = "obvhs-cwbvh adapter=direct".into();
        old.scenes[0].oracle.refused = vec!["obvhs-bvh2: no hit".into()];
        old.command_line = vec!["rtbench".into(), "run".into(), "obvhs-cwbvh".into()];
        for (schema_version, is_old) in [(1, true), (SCHEMA_VERSION, false)] {
            let written = RunRecord { schema_version, ..old.clone() };
            let text = serde_json::to_vec(&written).unwrap();
            let read = file::record(Path::new("results.json"), &text).unwrap();
            let labels = read.scenes[0].rows.iter().map(|row| row.label());
            let expected = names.map(|(old, new)| if is_old { new } else { old });
            assert_eq!(labels.collect::<Vec<_>>(), expected);
            assert_eq!(read.schema_version, SCHEMA_VERSION);
            let reference = if is_old { "obvhs-cwbvh" } else { "obvhs-cwbvh adapter=direct" };
            assert_eq!(read.settings.reference, reference);
            let summary = read.summary.iter().map(|row| label(&row.structure, &row.settings));
            assert!(summary.zip(expected).all(|(label, expected)| label == expected));
            // what is no row's name stays
            assert_eq!(read.scenes[0].oracle.refused, old.scenes[0].oracle.refused);
            assert_eq!(read.command_line, old.command_line);
        }
    }
}
