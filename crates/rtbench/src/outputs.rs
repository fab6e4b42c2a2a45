//! The output files: created before anything is measured, written anew after each scene, so that an
//! unwritable path is found at once and a killed run keeps what it finished. A run that is refused
//! leaves none that was not there. Two outputs to one file, and one onto an input, are refused.
//!
//! What a folder of `-o` holds already is not written over unless that is asked for: results of
//! another plan would be lost, those of the same plan can be resumed.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::IgnoredAny;

use measurement::journal;
use measurement::journal::lines::{LineError, Manifest, read};
use measurement::record::RunRecord;
use measurement::record::file::{self, RecordError};
use measurement::system::files::{self, CreatedFiles, WriteError, open, put, replace};
use measurement::system::interrupt::undisturbed;
use presentation::json::{self, FormatError};

#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error(transparent)]
    Format(#[from] FormatError),
    #[error("{}: two outputs would be written to this file; choose another file for one of them", .0.display())]
    SameFile(PathBuf),
    #[error("{}: the command also reads this file; write to another one", .0.display())]
    IsRead(PathBuf),
    #[error("'-' is standard output for `report` alone; name a file")]
    StandardOutput,
    #[error(
        "--export-select '{0}' matches no series; their names are SCENE: STRUCTURE SETTINGS / NAME, \
         like '{1}'"
    )]
    NothingSelected(String, String),
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

/// Makes a file's text of what is finished so far.
type Formatter<'a> = Box<dyn Fn(&RunRecord) -> Result<String, FormatError> + 'a>;

/// The name of a file in the folder of `-o`, and what makes its text.
pub type OutputFile<'a> = (&'static str, Formatter<'a>);

struct Output<'a> {
    path: PathBuf,
    format: Formatter<'a>,
    /// A pipe or a device: written once, when the run is over.
    stream: Option<File>,
}

/// All outputs of a run, but for the tables.
#[derive(Default)]
pub struct Outputs<'a> {
    /// That of `-o`.
    folder: Option<PathBuf>,
    outputs: Vec<Output<'a>>,
    created: CreatedFiles,
}

impl<'a> Outputs<'a> {
    /// No outputs yet; those of the folder of `-o` are `created`.
    pub fn new(folder: Option<PathBuf>, created: CreatedFiles) -> Self {
        Self { folder, outputs: Vec::new(), created }
    }

    /// Adds a file in the folder of `-o`, if that is named.
    pub fn add_in_folder(
        &mut self,
        name: &str,
        format: impl Fn(&RunRecord) -> Result<String, FormatError> + 'a,
    ) -> Result<(), OutputError> {
        self.add(self.folder.as_ref().map(|folder| folder.join(name)), format)
    }

    /// Creates one more file, if one is named.
    pub fn add(
        &mut self,
        path: Option<PathBuf>,
        format: impl Fn(&RunRecord) -> Result<String, FormatError> + 'a,
    ) -> Result<(), OutputError> {
        if let Some(path) = path {
            let stream = open(&path, &mut self.created)?;
            self.outputs.push(Output { path, format: Box::new(format), stream });
        }
        Ok(())
    }

    /// Makes the files, and their folders, that were removed since. Whether there were any.
    pub fn restore(&mut self) -> Result<bool, OutputError> {
        let is_gone = |output: &&Output<'_>| output.stream.is_none() && !output.path.exists();
        let gone: Vec<&Output<'_>> = self.outputs.iter().filter(is_gone).collect();
        for output in &gone {
            if let Some(folder) = output.path.parent() {
                self.created.folder(folder)?;
            }
            open(&output.path, &mut self.created)?;
        }
        Ok(!gone.is_empty())
    }

    /// Returns whether anything is written to files.
    pub fn are_files(&self) -> bool {
        !self.outputs.is_empty()
    }

    /// Writes what is finished so far; streams only when the run is `over`.
    pub fn write(&mut self, run: &RunRecord, over: bool) -> Result<(), OutputError> {
        for output in &mut self.outputs {
            let text = (output.format)(run)?;
            let written = undisturbed(|| match &mut output.stream {
                None => replace(&output.path, text.as_bytes()),
                Some(stream) if over => stream.write_all(text.as_bytes()),
                Some(_) => Ok(()),
            });
            match written {
                Err(e) if output.stream.is_some() && e.kind() == io::ErrorKind::BrokenPipe => {}
                other => {
                    other.map_err(|source| WriteError { path: output.path.clone(), source })?
                }
            }
        }
        Ok(())
    }
}

/// Writes the record to a new folder in `within`, and says where.
pub fn keep_elsewhere(within: Option<&Path>, record: &RunRecord) -> io::Result<PathBuf> {
    let text = json::written(record).map_err(io::Error::other)?;
    let folder = files::create(within.ok_or(io::ErrorKind::NotFound)?)?;
    let path = folder.join(file::NAME);
    undisturbed(|| put(&path, text.as_bytes())).inspect_err(|_| {
        let _ = fs::remove_dir(&folder);
    })?;
    Ok(path)
}

/// Refuses outputs of which two are the same file, or one is an input.
pub fn refuse_shared(outputs: &[PathBuf], inputs: &[PathBuf]) -> Result<(), OutputError> {
    let read: BTreeSet<PathBuf> = inputs.iter().filter_map(|path| place(path)).collect();
    let mut written = BTreeSet::new();
    for path in outputs {
        let Some(place) = place(path) else { continue };
        if read.contains(&place) {
            return Err(OutputError::IsRead(path.clone()));
        }
        if !written.insert(place) {
            return Err(OutputError::SameFile(path.clone()));
        }
    }
    Ok(())
}

/// The identity of a file under any of its names; of one that does not exist yet, the path it will
/// have. None for standard output, pipes and devices, which hold nothing to destroy.
fn place(path: &Path) -> Option<PathBuf> {
    if path.as_os_str() == "-" || path.metadata().is_ok_and(|found| !found.is_file()) {
        return None;
    }
    if let Some(file) = identity(path) {
        return Some(file);
    }
    let absolute = std::path::absolute(path).ok()?;
    let mut behind = Vec::new();
    let mut folder = absolute.as_path();
    while let (Some(name), Some(parent)) = (folder.file_name(), folder.parent()) {
        behind.push(name);
        folder = parent;
        if let Ok(real) = folder.canonicalize() {
            return Some(behind.iter().rev().fold(real, |place, name| place.join(name)));
        }
    }
    Some(absolute)
}

/// Device and inode: equal for all links to one file.
#[cfg(unix)]
fn identity(path: &Path) -> Option<PathBuf> {
    use std::os::unix::fs::MetadataExt;
    let found = path.metadata().ok()?;
    Some(format!("{}:{}", found.dev(), found.ino()).into())
}

#[cfg(not(unix))]
fn identity(path: &Path) -> Option<PathBuf> {
    path.canonicalize().ok()
}

/// Refuses files that are there and hold something. What is no file, a pipe or a device, is written
/// to.
pub fn refuse_files(paths: impl IntoIterator<Item = PathBuf>) -> Result<(), OutputError> {
    let holds_something =
        |path: &PathBuf| fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() > 0);
    let found = paths.into_iter().find(holds_something);
    found.map_or(Ok(()), |path| Err(OutputError::File { path }))
}

pub struct PlannedOutput<'a> {
    /// The names of the files, the record first.
    pub names: &'a [&'a str],
    pub command_line: &'a [String],
    /// Description of the run, if it keeps a journal.
    pub manifest: Option<&'a Manifest>,
    pub overwrite: bool,
}

impl PlannedOutput<'_> {
    /// Refuses a folder that holds something else, or anything that is not a file where a file is
    /// expected.
    pub fn check(&self, folder: &Path) -> Result<(), OutputError> {
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
            Some((name, _)) => Err(OutputError::Unknown { path: folder.join(name) }),
            None => Ok(()),
        }
    }

    fn check_journal(&self, folder: &Path, here: &Manifest) -> Result<(), OutputError> {
        let path = folder.join(journal::NAME);
        if !path.exists() {
            return Ok(());
        }
        let found = match read(&file::bytes(&path)?) {
            Ok(found) if found.finished.is_empty() => return Ok(()),
            Ok(found) => found,
            Err(LineError::Empty) => return Ok(()),
            Err(source) => return Err(OutputError::Journal { path, source }),
        };
        let folder = folder.to_owned();
        let there = found.manifest.command_line.join(" ");
        let differences = found.manifest.differences(here);
        if differences.is_empty() {
            let (finished, scenes) = (found.finished.len(), found.manifest.scenes.len());
            return Err(OutputError::SamePlan { folder, there, finished, scenes });
        }
        let names = differences.iter().filter_map(|text| Some(text.split_once(':')?.0));
        let differences = names.collect::<Vec<_>>().join(", ");
        let here = here.command_line.join(" ");
        Err(OutputError::OtherPlan { folder, there, here, differences })
    }

    fn check_record(&self, folder: &Path, name: &str) -> Result<(), OutputError> {
        /// Records of all commands say so much.
        #[derive(Deserialize)]
        struct Record {
            command_line: Vec<String>,
            /// Scenes of a run that would be lost.
            scenes: Option<Vec<IgnoredAny>>,
        }
        let path = folder.join(name);
        let Ok(record) = serde_json::from_slice::<Record>(&file::bytes(&path)?) else {
            return Err(OutputError::Unknown { path });
        };
        if record.scenes.is_some_and(|scenes| scenes.is_empty()) {
            return Ok(());
        }
        let (there, here) = (record.command_line.join(" "), self.command_line.join(" "));
        Err(OutputError::Results { path, there, here })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::made_up;

    #[test]
    fn rescued_records_get_separate_folders() {
        let within = tempfile::tempdir().unwrap();
        let record = made_up::run(&[]);
        let paths = [0, 1].map(|_| keep_elsewhere(Some(within.path()), &record).unwrap());
        assert_ne!(paths[0], paths[1]);
        assert_eq!(file::read(&paths[1]).unwrap(), record);
        assert!(keep_elsewhere(Some(&within.path().join("none")), &record).is_err());
    }
}
