//! The output files: created before anything is measured, written anew after each scene, so that
//! an unwritable path is found at once and a killed run keeps what it finished.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::args::RunArgs;
use crate::error::Error;
use crate::export::{csv, json, markdown};
use crate::record::RunRecord;

/// What a file holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Format {
    Csv,
    Markdown,
    Json,
}

/// One output file.
#[derive(Debug)]
struct Output {
    path: PathBuf,
    format: Format,
    /// A pipe or a device: written once, when the run is over.
    stream: Option<File>,
}

/// All output files of a run.
#[derive(Debug, Default)]
pub struct Outputs {
    outputs: Vec<Output>,
}

impl Outputs {
    /// Creates the files that the command line names.
    ///
    /// # Errors
    /// [`Error::Write`] naming the file or folder.
    pub fn create(args: &RunArgs) -> Result<Self, Error> {
        let mut named: Vec<(PathBuf, Format)> = Vec::new();
        if let Some(folder) = &args.output {
            fs::create_dir_all(folder)
                .map_err(|source| Error::Write { path: folder.clone(), source })?;
            named.push((folder.join("results.csv"), Format::Csv));
            named.push((folder.join("results.md"), Format::Markdown));
            named.push((folder.join("results.json"), Format::Json));
        }
        let single = [
            (&args.export_csv, Format::Csv),
            (&args.export_markdown, Format::Markdown),
            (&args.export_json, Format::Json),
        ];
        named.extend(single.into_iter().filter_map(|(p, f)| Some((p.clone()?, f))));
        let outputs = named
            .into_iter()
            .map(|(path, format)| open(path, format))
            .collect::<Result<Vec<_>, _>>()?;
        Ok(Self { outputs })
    }

    /// Writes what is finished so far; streams only when the run is `over`.
    ///
    /// # Errors
    /// [`Error::Write`] naming the file, [`Error::Format`].
    pub fn write(&mut self, run: &RunRecord, over: bool) -> Result<(), Error> {
        for output in &mut self.outputs {
            let text = match output.format {
                Format::Csv => csv::to_string(run)?,
                Format::Markdown => markdown::to_string(run),
                Format::Json => json::to_string(run)?,
            };
            let written = match &mut output.stream {
                None => replace(&output.path, text.as_bytes()),
                Some(stream) if over => stream.write_all(text.as_bytes()),
                Some(_) => Ok(()),
            };
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

fn open(path: PathBuf, format: Format) -> Result<Output, Error> {
    let error = |source| Error::Write { path: path.clone(), source };
    let file =
        OpenOptions::new().create(true).write(true).truncate(false).open(&path).map_err(error)?;
    let is_file = file.metadata().map_err(error)?.is_file();
    Ok(Output { path, format, stream: (!is_file).then_some(file) })
}

/// Replaces a file's content in one step, so that a killed run never leaves half a file; in place
/// where the folder does not take new files.
fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    // Links are followed: what they point to is replaced, not the link.
    let path = fs::canonicalize(path)?;
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary = path.with_file_name(name);
    match fs::write(&temporary, content).and_then(|()| fs::rename(&temporary, &path)) {
        Ok(()) => Ok(()),
        Err(_) => {
            let _ = fs::remove_file(&temporary);
            fs::write(&path, content)
        }
    }
}
