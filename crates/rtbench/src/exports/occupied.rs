//! What a folder of `-o` holds already. Results are not written over unless that is asked for:
//! those of another plan would be lost, those of the same plan can be resumed.

use std::path::{Path, PathBuf};
use std::{fs, io};

use measurement::journal;
use measurement::journal::lines::{LineError, Manifest, read};
use measurement::record::file::{self, RecordError};
use serde::Deserialize;
use serde::de::IgnoredAny;

/// Why nothing is written to a folder.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OccupiedError {
    #[error(
        "{}: holds results of `{there}`; this would be `{here}`, which differs in {differences}; name \
         another folder, or replace them with --overwrite",
        folder.display()
    )]
    OtherPlan { folder: PathBuf, there: String, here: String, differences: String },
    #[error(
        "{}: holds this same run, `{there}`, with {finished} of {scenes} scenes finished; resume with \
         `rtbench run --resume {}`, or start again with --overwrite",
        folder.display(), folder.display()
    )]
    SamePlan { folder: PathBuf, there: String, finished: usize, scenes: usize },
    #[error(
        "{}: holds results of `{there}`, which `{here}` would replace; name another folder, or \
         use --overwrite",
        path.display()
    )]
    Results { path: PathBuf, there: String, here: String },
    #[error(
        "{}: exists, and does not name its run; name another folder, or replace it with \
         --overwrite",
        path.display()
    )]
    Unknown { path: PathBuf },
    #[error("{}: exists; name another file, or replace it with --overwrite", path.display())]
    File { path: PathBuf },
    #[error("{}: {source}; name another folder, or replace it with --overwrite", path.display())]
    Journal { path: PathBuf, source: LineError },
    #[error(transparent)]
    Record(#[from] RecordError),
}

/// Refuses files that are there and hold something. What is no file, a pipe or a device, is written
/// to.
pub fn refuse_files(paths: impl IntoIterator<Item = PathBuf>) -> Result<(), OccupiedError> {
    let holds_something = |path: &PathBuf| {
        path.as_os_str() != "-" && fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() > 0)
    };
    let found = paths.into_iter().find(holds_something);
    found.map_or(Ok(()), |path| Err(OccupiedError::File { path }))
}

pub struct PlannedOutput<'a> {
    /// The names of the files, the record first.
    pub names: &'a [&'a str],
    pub command_line: &'a [String],
    /// Description of the run, if it keeps a journal.
    pub manifest: Option<&'a Manifest>,
    /// Existing output may be replaced.
    pub overwrite: bool,
}

impl PlannedOutput<'_> {
    /// Refuses a folder that holds something else, or anything that is not a file where a file is
    /// expected.
    pub fn check(&self, folder: &Path) -> Result<(), OccupiedError> {
        let journal = self.manifest.map(|_| journal::NAME);
        let absent = [io::ErrorKind::NotFound, io::ErrorKind::NotADirectory];
        let mut sizes = Vec::new();
        for name in self.names.iter().copied().chain(journal) {
            let path = folder.join(name);
            sizes.push(file::length(&path).or_else(|error| match error {
                RecordError::Io { source, .. } if absent.contains(&source.kind()) => Ok(0),
                other => Err(other),
            })?);
        }
        if self.overwrite {
            return Ok(());
        }
        if let Some(manifest) = self.manifest {
            self.check_journal(folder, manifest)?;
        }
        let mut found = self.names.iter().zip(sizes).filter(|(_, size)| *size > 0);
        match found.next() {
            Some((name, _)) if Some(name) == self.names.first() => self.check_record(folder, name),
            Some((name, _)) => Err(OccupiedError::Unknown { path: folder.join(name) }),
            None => Ok(()),
        }
    }

    fn check_journal(&self, folder: &Path, here: &Manifest) -> Result<(), OccupiedError> {
        let path = folder.join(journal::NAME);
        if !path.exists() {
            return Ok(());
        }
        let found = match read(&file::bytes(&path)?) {
            Ok(found) if found.finished.is_empty() => return Ok(()),
            Ok(found) => found,
            Err(LineError::Empty) => return Ok(()),
            Err(source) => return Err(OccupiedError::Journal { path, source }),
        };
        let folder = folder.to_owned();
        let there = found.manifest.command_line.join(" ");
        let differences = found.manifest.differences(here);
        if differences.is_empty() {
            let (finished, scenes) = (found.finished.len(), found.manifest.scenes.len());
            return Err(OccupiedError::SamePlan { folder, there, finished, scenes });
        }
        let names = differences.iter().filter_map(|text| Some(text.split_once(':')?.0));
        let differences = names.collect::<Vec<_>>().join(", ");
        let here = here.command_line.join(" ");
        Err(OccupiedError::OtherPlan { folder, there, here, differences })
    }

    fn check_record(&self, folder: &Path, name: &str) -> Result<(), OccupiedError> {
        /// Records of all commands say so much.
        #[derive(Deserialize)]
        struct Record {
            command_line: Vec<String>,
            /// Scenes of a run that would be lost.
            scenes: Option<Vec<IgnoredAny>>,
        }
        let path = folder.join(name);
        let Ok(record) = serde_json::from_slice::<Record>(&file::bytes(&path)?) else {
            return Err(OccupiedError::Unknown { path });
        };
        if record.scenes.is_some_and(|scenes| scenes.is_empty()) {
            return Ok(());
        }
        let (there, here) = (record.command_line.join(" "), self.command_line.join(" "));
        Err(OccupiedError::Results { path, there, here })
    }
}
