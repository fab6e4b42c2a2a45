//! The files that a command line names to be written.

use std::path::{Path, PathBuf};

use crate::args::{BaselineAction, Command, GeneratedText, RaysAction};
use crate::commands::{check, cost, generate, run_outputs};
use measurement::record::file;

/// The files that a command is asked for by name; what folders are filled with is asked for by the
/// commands that fill them. A run that is resumed writes files of its own.
pub fn named_files(command: &Command) -> Vec<PathBuf> {
    let within = |folder: &Option<PathBuf>, names: &[String]| match folder {
        Some(folder) => names.iter().map(|name| folder.join(name)).collect(),
        None => Vec::new(),
    };
    let one = |file: &Option<PathBuf>| file.iter().cloned().collect();
    match command {
        Command::Run(args) if args.resume.is_none() => run_outputs::named(&args.exports),
        Command::Merge(args) => run_outputs::named(&args.exports),
        Command::Baseline(args) => match &args.action {
            BaselineAction::Save(args) => run_outputs::named(&args.run.exports),
            _ => Vec::new(),
        },
        Command::Rays(args) => match &args.action {
            RaysAction::Export(args) => {
                args.output.iter().chain(&args.triangles).cloned().collect()
            }
            RaysAction::Trace(args) => one(&args.output),
            RaysAction::Check(_) => Vec::new(),
        },
        Command::Render(args) => one(&args.output),
        Command::Show(args) => one(&args.output),
        Command::Cost(args) => within(&args.heat_maps, &cost::MAPS.map(str::to_owned)),
        Command::Generate(args) => match &args.text {
            GeneratedText::Man(args) => within(&args.output, &generate::page_names()),
            GeneratedText::Schema(_) | GeneratedText::Completions(_) => Vec::new(),
        },
        _ => Vec::new(),
    }
}

/// Files that a command writes and that [`named_files`] leaves out: those in the folder of `-o`,
/// the exports of a run that is resumed, and the page of a report.
pub fn files_of_folder(command: &Command) -> Vec<PathBuf> {
    let folder = match command {
        Command::Run(args) => args.resume.as_ref().or(args.exports.output.as_ref()),
        Command::Merge(args) => args.exports.output.as_ref(),
        Command::Check(args) if args.results.is_none() => args.output.as_ref(),
        Command::Baseline(args) => match &args.action {
            BaselineAction::Save(args) => args.run.exports.output.as_ref(),
            _ => None,
        },
        _ => None,
    };
    let mut files = folder.map(|folder| run_outputs::files_in(folder)).unwrap_or_default();
    if let Command::Run(args) = command
        && args.resume.is_some()
    {
        files.extend(run_outputs::named(&args.exports));
    }
    if let Command::Check(args) = command {
        let folder = args.output.iter();
        files.extend(folder.flat_map(|folder| check::NAMES.map(|name| folder.join(name))));
    }
    if let Command::Report(args) = command {
        files.extend(args.output.clone());
    }
    files
}

/// Results, rays and programs that a command reads.
pub fn files_read(command: &Command) -> Vec<PathBuf> {
    let read: Vec<&Path> = match command {
        Command::Merge(args) => args.parts.iter().map(PathBuf::as_path).collect(),
        Command::Compare(args) => args.results.iter().map(PathBuf::as_path).collect(),
        Command::Report(args) => args.folders.iter().map(PathBuf::as_path).collect(),
        Command::Check(args) => {
            let baseline = args.baseline.as_deref().map(Path::new);
            let others = args.results.iter().chain(&args.against).chain(&args.against_plugin);
            others.map(PathBuf::as_path).chain(baseline).collect()
        }
        Command::Rays(args) => match &args.action {
            RaysAction::Trace(args) => vec![&args.rays],
            RaysAction::Export(_) | RaysAction::Check(_) => Vec::new(),
        },
        _ => Vec::new(),
    };
    read.into_iter().map(file::path_of).collect()
}
