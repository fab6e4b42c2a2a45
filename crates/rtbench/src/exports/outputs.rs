//! The output files: created before anything is measured, written anew after each scene, so that an
//! unwritable path is found at once and a killed run keeps what it finished. A run that is refused
//! leaves none that was not there.

use std::fs::File;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use measurement::record::RunRecord;
use measurement::system::created::CreatedFiles;
use measurement::system::created::WriteError;
use measurement::system::files::{open, replace, write_text};
use measurement::system::interrupt::undisturbed;
use presentation::json::FormatError;

/// Why results are not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// They could not be turned into text.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// Two outputs would be mixed up.
    #[error("only one output can go to standard output (-); name files for the others")]
    OneStdout,
    /// One would overwrite the other.
    #[error("{}: two outputs would be written to this file; choose another file for one of them", .0.display())]
    SameFile(PathBuf),
    /// An output would overwrite an input.
    #[error("{}: the command also reads this file; write to another one", .0.display())]
    IsRead(PathBuf),
    /// The pattern of `--export-select`, and the name of a series that there is.
    #[error(
        "--export-select '{0}' matches no series; their names are SCENE: STRUCTURE SETTINGS / NAME, \
         like '{1}'"
    )]
    NothingSelected(String, String),
    #[error("cannot write to standard output: {0}")]
    Stdout(#[from] io::Error),
}

/// Makes a file's text of what is finished so far.
type Formatter<'a> = Box<dyn Fn(&RunRecord) -> Result<String, FormatError> + 'a>;

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
    /// Format printed to standard output instead of the tables.
    printed: Option<Formatter<'a>>,
    created: CreatedFiles,
}

impl<'a> Outputs<'a> {
    /// Creates the folder of `-o`.
    ///
    /// # Errors
    /// [`OutputError::Write`] naming the folder.
    pub fn folder(&mut self, path: &Path) -> Result<(), OutputError> {
        Ok(self.created.folder(path)?)
    }

    /// Returns whether standard output is taken, so that no tables may be printed.
    pub fn are_printed(&self) -> bool {
        self.printed.is_some()
    }

    /// Writes what goes to standard output, once the run is over.
    ///
    /// # Errors
    /// Those of the format and of the writer.
    pub fn print(&self, run: &RunRecord, out: &mut dyn Write) -> Result<(), OutputError> {
        if let Some(format) = &self.printed {
            out.write_all(format(run)?.as_bytes())?;
            out.flush()?;
        }
        Ok(())
    }

    /// Creates one more file, if one is named; `-` is standard output.
    ///
    /// # Errors
    /// [`OutputError::Write`] naming the file, [`OutputError::OneStdout`].
    pub fn add(
        &mut self,
        path: Option<&PathBuf>,
        format: impl Fn(&RunRecord) -> Result<String, FormatError> + 'a,
    ) -> Result<(), OutputError> {
        if path.is_some_and(|path| path.as_os_str() == "-") {
            if self.printed.is_some() {
                return Err(OutputError::OneStdout);
            }
            self.printed = Some(Box::new(format));
        } else if let Some(path) = path {
            let stream = open(path, &mut self.created)?;
            self.outputs.push(Output { path: path.clone(), format: Box::new(format), stream });
        }
        Ok(())
    }

    /// Makes the files, and their folders, that were removed since. Whether there were any.
    ///
    /// # Errors
    /// [`OutputError::Write`] naming the file or folder.
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
    ///
    /// # Errors
    /// [`OutputError::Write`] naming the file, [`OutputError::Format`].
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

/// Writes a file, if one is named.
///
/// # Errors
/// [`OutputError::Write`] naming the file, or that of `text`.
pub fn write_file(
    path: Option<&Path>,
    text: impl FnOnce() -> Result<String, FormatError>,
) -> Result<(), OutputError> {
    let Some(path) = path else { return Ok(()) };
    Ok(write_text(path, &text()?)?)
}
