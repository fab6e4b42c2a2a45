//! The output files: created before anything is measured, written anew after each scene, so that
//! an unwritable path is found at once and a killed run keeps what it finished. A run that is refused
//! leaves none that was not there.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::args::ExportArgs;
use crate::error::Error;
use crate::export::EXPORTERS;
use crate::export::created::Created;
use crate::interrupt::undisturbed;
use crate::plan::PlanError;
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

/// All outputs of a run, but for the tables.
#[derive(Default)]
pub struct Outputs<'a> {
    outputs: Vec<Output<'a>>,
    /// What goes to standard output, in place of the tables.
    printed: Option<Formatter<'a>>,
    created: Created,
}

impl<'a> Outputs<'a> {
    /// Creates the files that the command line of a run names.
    ///
    /// # Errors
    /// [`Error::Write`] naming the file or folder, [`PlanError::OneStdout`].
    pub fn of_run(args: &ExportArgs) -> Result<Self, Error> {
        let mut outputs = Self::default();
        if let Some(folder) = &args.output {
            outputs.folder(folder)?;
            for exporter in &EXPORTERS {
                let path = exporter.in_folder.map(|name| folder.join(name));
                outputs.add(path.as_ref(), exporter.to_string)?;
            }
        }
        for exporter in &EXPORTERS {
            outputs.add((exporter.path)(args), exporter.to_string)?;
        }
        Ok(outputs)
    }

    /// Creates the folder of `-o`.
    ///
    /// # Errors
    /// [`Error::Write`] naming the folder.
    pub fn folder(&mut self, path: &Path) -> Result<(), Error> {
        self.created.folder(path)
    }

    /// Whether standard output is taken, so that no tables may be printed.
    pub fn are_printed(&self) -> bool {
        self.printed.is_some()
    }

    /// Writes what goes to standard output, once the run is over.
    ///
    /// # Errors
    /// Those of the format and of the writer.
    pub fn print(&self, run: &RunRecord, out: &mut dyn Write) -> Result<(), Error> {
        if let Some(format) = &self.printed {
            out.write_all(format(run)?.as_bytes())?;
            out.flush()?;
        }
        Ok(())
    }

    /// Creates one more file, if one is named; `-` is standard output.
    ///
    /// # Errors
    /// [`Error::Write`] naming the file, [`PlanError::OneStdout`].
    pub fn add(
        &mut self,
        path: Option<&PathBuf>,
        format: impl Fn(&RunRecord) -> Result<String, Error> + 'a,
    ) -> Result<(), Error> {
        if path.is_some_and(|path| path.as_os_str() == "-") {
            if self.printed.is_some() {
                return Err(PlanError::OneStdout.into());
            }
            self.printed = Some(Box::new(format));
        } else if let Some(path) = path {
            let stream = open(path, &mut self.created)?;
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

/// Writes a file, if one is named.
///
/// # Errors
/// [`Error::Write`] naming the file, or that of `text`.
pub fn write_file(
    path: Option<&Path>,
    text: impl FnOnce() -> Result<String, Error>,
) -> Result<(), Error> {
    let Some(path) = path else { return Ok(()) };
    write_text(path, &text()?)
}

/// Creates the files that are named and written later.
///
/// # Errors
/// [`Error::Write`] naming the file.
pub fn create<'p>(paths: impl IntoIterator<Item = &'p Option<PathBuf>>) -> Result<Created, Error> {
    let mut created = Created::default();
    for path in paths.into_iter().flatten() {
        created.file(path)?;
    }
    Ok(created)
}

/// Writes a finished file in one step, or a pipe or a device.
///
/// # Errors
/// [`Error::Write`] naming the file.
pub fn write_text(path: &Path, text: &str) -> Result<(), Error> {
    let mut created = Created::default();
    let stream = open(path, &mut created)?;
    let written = undisturbed(|| match stream {
        None => replace(path, text.as_bytes()),
        Some(mut stream) => stream.write_all(text.as_bytes()),
    });
    written.map_err(|source| Error::Write { path: path.to_owned(), source })?;
    created.keep();
    Ok(())
}

/// Creates the file; what is no file, but a pipe or a device, stays open.
fn open(path: &Path, created: &mut Created) -> Result<Option<File>, Error> {
    let file = created.file(path)?;
    let error = |source| Error::Write { path: path.to_owned(), source };
    let is_file = file.metadata().map_err(error)?.is_file();
    Ok((!is_file).then_some(file))
}

/// Replaces a file's content in one step, so that a killed run, or a full disk, never leaves half a
/// file; in place only where the folder does not take new files.
fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    // Links are followed: what they point to is replaced, not the link.
    put(&fs::canonicalize(path)?, content)
}

/// Writes a file's whole content in one step, whether it was there or not.
///
/// # Errors
/// The system's.
pub fn put(path: &Path, content: &[u8]) -> io::Result<()> {
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    let mut file = match File::create(&temporary) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::PermissionDenied => return fs::write(path, content),
        Err(e) => return Err(e),
    };
    let replaced = file.write_all(content).and_then(|()| fs::rename(&temporary, path));
    if replaced.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    replaced
}
