//! The output files: created before anything is measured, written anew after each scene, so that
//! an unwritable path is found at once and a killed run keeps what it finished.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::args::RunArgs;
use crate::error::Error;
use crate::export::{csv, json, markdown};
use crate::interrupt::undisturbed;
use crate::record::RunRecord;

/// Makes a file's text of what is finished so far.
type Formatter<'a> = Box<dyn Fn(&RunRecord) -> Result<String, Error> + 'a>;

/// One output file.
struct Output<'a> {
    path: PathBuf,
    format: Formatter<'a>,
    /// A pipe or a device: written once, when the run is over.
    stream: Option<File>,
}

/// All output files of a run.
#[derive(Default)]
pub struct Outputs<'a> {
    outputs: Vec<Output<'a>>,
}

impl<'a> Outputs<'a> {
    /// Creates the files that the command line of a run names.
    ///
    /// # Errors
    /// [`Error::Write`] naming the file or folder.
    pub fn of_run(args: &RunArgs) -> Result<Self, Error> {
        let mut outputs = Self::default();
        if let Some(folder) = &args.output {
            fs::create_dir_all(folder)
                .map_err(|source| Error::Write { path: folder.clone(), source })?;
            outputs.add(Some(&folder.join("results.csv")), csv::to_string)?;
            outputs.add(Some(&folder.join("results.md")), |run| Ok(markdown::to_string(run)))?;
            outputs.add(Some(&folder.join("results.json")), json::to_string)?;
        }
        outputs.add(args.export_csv.as_ref(), csv::to_string)?;
        outputs.add(args.export_markdown.as_ref(), |run| Ok(markdown::to_string(run)))?;
        outputs.add(args.export_json.as_ref(), json::to_string)?;
        Ok(outputs)
    }

    /// Creates one more file, if one is named.
    ///
    /// # Errors
    /// [`Error::Write`] naming the file.
    pub fn add(
        &mut self,
        path: Option<&PathBuf>,
        format: impl Fn(&RunRecord) -> Result<String, Error> + 'a,
    ) -> Result<(), Error> {
        if let Some(path) = path {
            let stream = open(path)?;
            self.outputs.push(Output { path: path.clone(), format: Box::new(format), stream });
        }
        Ok(())
    }

    /// Writes what is finished so far; streams only when the run is `over`.
    ///
    /// # Errors
    /// [`Error::Write`] naming the file, [`Error::Format`].
    pub fn write(&mut self, run: &RunRecord, over: bool) -> Result<(), Error> {
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
                    other.map_err(|source| Error::Write { path: output.path.clone(), source })?
                }
            }
        }
        Ok(())
    }
}

/// Writes a finished file in one step, or a pipe or a device.
///
/// # Errors
/// [`Error::Write`] naming the file.
pub fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    let written = match open(path)? {
        None => replace(path, text.as_bytes()),
        Some(mut stream) => stream.write_all(text.as_bytes()),
    };
    written.map_err(|source| Error::Write { path: path.to_owned(), source })
}

/// Creates the file; what is no file, but a pipe or a device, stays open.
fn open(path: &Path) -> Result<Option<File>, Error> {
    let error = |source| Error::Write { path: path.to_owned(), source };
    let file =
        OpenOptions::new().create(true).write(true).truncate(false).open(path).map_err(error)?;
    let is_file = file.metadata().map_err(error)?.is_file();
    Ok((!is_file).then_some(file))
}

/// Replaces a file's content in one step, so that a killed run, or a full disk, never leaves half a
/// file; in place only where the folder does not take new files.
fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    // Links are followed: what they point to is replaced, not the link.
    let path = fs::canonicalize(path)?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let mut file = match File::create(&temporary) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::PermissionDenied => return fs::write(&path, content),
        Err(e) => return Err(e),
    };
    let replaced = file.write_all(content).and_then(|()| fs::rename(&temporary, &path));
    if replaced.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    replaced
}
