//! The command line beyond its syntax: usage errors, help and version; how results show it; the files
//! that it names; and scenes with the view that it gives them.

use std::path::{Path, PathBuf};

use clap::CommandFactory;
use clap::error::{ContextKind, ContextValue};

use crate::args::{
    BaselineAction, BaselineArgs, CheckArgs, Cli, Command, ExportArgs, GeneratedText, RaysAction,
    RenderArgs, RunArgs, ShowArgs, TraceArgs,
};
use crate::commands::{check, cost, generate, run_outputs};
use crate::context::Context;
use crate::error::{Error, FAILURE, SUCCESS, USAGE};
use measurement::record::file;
use measurement::scenes::{KnownScene, LoadError, SceneCatalogue, SceneSource, ViewOptions};
use measurement::settings::choice;
use presentation::outside::line;

/// Help and version on standard output, usage errors on standard error.
pub fn usage(context: &mut Context<'_>, mut error: clap::Error) -> u8 {
    suggest_command(&mut error);
    show_hidden(&mut error);
    let text = error.render();
    let written = if error.use_stderr() {
        write!(context.err, "{text}")
    } else {
        write!(context.out, "{text}").and_then(|()| context.out.flush())
    };
    match written.map_err(Error::from) {
        _ if error.use_stderr() => USAGE,
        Err(e) if !e.is_closed_pipe() => FAILURE,
        _ => SUCCESS,
    }
}

/// Shows the arguments of the error, escaped.
fn show_hidden(error: &mut clap::Error) {
    let shown = |text: &String| line(text).into_owned();
    let typed: Vec<(ContextKind, ContextValue)> = error
        .context()
        .filter_map(|(kind, value)| match value {
            ContextValue::String(text) => Some((kind, ContextValue::String(shown(text)))),
            ContextValue::Strings(all) => {
                Some((kind, ContextValue::Strings(all.iter().map(shown).collect())))
            }
            _ => None,
        })
        .collect();
    for (kind, value) in typed {
        error.insert(kind, value);
    }
}

/// Clap does not see that `rnu` is `run`.
fn suggest_command(error: &mut clap::Error) {
    let (typed, known) = (ContextKind::InvalidSubcommand, ContextKind::SuggestedSubcommand);
    if let (Some(ContextValue::String(typed)), None) = (error.get(typed), error.get(known)) {
        let cli = Cli::command();
        let meant = choice::nearest(typed, cli.get_subcommands().map(clap::Command::get_name));
        if let Some(meant) = meant.map(str::to_owned) {
            error.insert(known, ContextValue::Strings(vec![meant]));
        }
    }
}

/// The command line as a record shows it, to be typed again without the folders of one machine: the
/// program is `rtbench`, whatever it was started as. An absolute
/// path within `folder` becomes relative to it; of any other absolute path the last name stays.
pub fn recorded(command_line: &[String], folder: Option<&Path>) -> Vec<String> {
    let arguments = command_line.iter().skip(1).map(|argument| without_folders(argument, folder));
    std::iter::once("rtbench".to_owned()).chain(arguments).collect()
}

/// One argument: a path alone, behind `--name=`, or behind a letter as in `-oPATH`.
fn without_folders(argument: &str, folder: Option<&Path>) -> String {
    let value = match argument.strip_prefix("--") {
        Some(long) => long.split_once('=').map_or("", |(_, value)| value),
        None if argument.starts_with('-') => argument.get(2..).unwrap_or_default(),
        None => argument,
    };
    let (name, path) = (argument.strip_suffix(value).unwrap_or_default(), Path::new(value));
    if !path.is_absolute() {
        return argument.to_owned();
    }
    let inside = folder.and_then(|folder| path.strip_prefix(folder).ok());
    let shown = match inside {
        Some(inside) if inside.as_os_str().is_empty() => ".".into(),
        Some(inside) => inside.to_string_lossy(),
        None => path.file_name().unwrap_or_default().to_string_lossy(),
    };
    format!("{name}{shown}")
}

/// The files of a run, of merged parts or of a baseline that is measured.
fn exports_of(command: &Command) -> Option<&ExportArgs> {
    match command {
        Command::Run(args) => Some(&args.exports),
        Command::Merge(args) => Some(&args.exports),
        Command::Baseline(BaselineArgs { action: BaselineAction::Save(args), .. }) => {
            Some(&args.run.exports)
        }
        _ => None,
    }
}

/// The files that a command is asked for by name; what folders are filled with is asked for by the
/// commands that fill them. A run that is resumed writes files of its own.
pub fn named_files(command: &Command) -> Vec<PathBuf> {
    let within = |folder: &Option<PathBuf>, names: &[String]| match folder {
        Some(folder) => names.iter().map(|name| folder.join(name)).collect(),
        None => Vec::new(),
    };
    match command {
        Command::Run(RunArgs { resume: Some(_), .. }) => Vec::new(),
        Command::Rays(RaysAction::Export(args)) => {
            args.output.iter().chain(&args.triangles).cloned().collect()
        }
        Command::Rays(RaysAction::Trace(TraceArgs { output, .. }))
        | Command::Render(RenderArgs { output, .. })
        | Command::Show(ShowArgs { output, .. }) => output.iter().cloned().collect(),
        Command::Cost(args) => within(&args.heat_maps, &cost::MAPS.map(str::to_owned)),
        Command::Generate(GeneratedText::Man(args)) => {
            within(&args.output, &generate::page_names())
        }
        _ => exports_of(command).map(run_outputs::named).unwrap_or_default(),
    }
}

/// Files that a command writes and that [`named_files`] leaves out: those in the folder of `-o`,
/// the exports of a run that is resumed, and the page of a report.
pub fn files_of_folder(command: &Command) -> Vec<PathBuf> {
    let (folder, more) = match command {
        Command::Run(RunArgs { resume: Some(folder), exports, .. }) => {
            (Some(folder), run_outputs::named(exports))
        }
        Command::Check(CheckArgs { output, results, .. }) => {
            let own = output.iter().flat_map(|folder| check::NAMES.map(|name| folder.join(name)));
            (output.as_ref().filter(|_| results.is_none()), own.collect())
        }
        Command::Report(args) => (None, args.output.iter().cloned().collect()),
        _ => (exports_of(command).and_then(|exports| exports.output.as_ref()), Vec::new()),
    };
    let files = folder.map(|folder| run_outputs::files_in(folder)).unwrap_or_default();
    [files, more].concat()
}

/// Results, rays and programs that a command reads.
pub fn files_read(command: &Command) -> Vec<PathBuf> {
    let read: Vec<&Path> = match command {
        Command::Merge(args) => args.parts.iter().map(PathBuf::as_path).collect(),
        Command::Compare(args) => args.results.iter().map(PathBuf::as_path).collect(),
        Command::Report(args) => args.folders.iter().map(PathBuf::as_path).collect(),
        Command::Check(args) => {
            let baseline = args.baseline.as_deref().map(Path::new);
            let others = args.results.iter().chain(&args.against);
            others.map(PathBuf::as_path).chain(baseline).collect()
        }
        Command::Rays(RaysAction::Trace(args)) => vec![&args.rays],
        _ => Vec::new(),
    };
    read.into_iter().map(file::path_of).collect()
}

/// A source whose scenes get the view of the command line instead of their own.
pub struct GivenView<'a> {
    pub source: &'a dyn SceneSource,
    pub allow_outside: bool,
    pub view: ViewOptions,
}

impl SceneSource for GivenView<'_> {
    fn resolve(&self, names: &[String]) -> Result<Vec<Box<dyn KnownScene>>, LoadError> {
        let mut scenes = self.source.resolve(names)?;
        if self.allow_outside {
            scenes.iter_mut().for_each(|scene| scene.known_mut().allow_outside());
        }
        if !self.view.is_empty() {
            scenes.iter_mut().for_each(|scene| scene.known_mut().view = self.view.clone());
        }
        Ok(scenes)
    }

    fn allows_outside(&self) -> bool {
        self.allow_outside
    }

    fn catalogue(&self) -> Result<SceneCatalogue, LoadError> {
        self.source.catalogue()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[cfg(unix)]
    #[test]
    fn recorded_commands_name_no_folder_of_the_machine() {
        let typed = "/home/me/rtbench/target/release/rtbench run /data/hall.obj kitchen -o /tmp/out \
                     --export-csv=/home/me/rtbench/out/a.csv -o/tmp/x/y --baselines /home/me/rtbench \
                     -s grid:a=1 --set uniform-grid.density=4 --export-json - results/one ../b";
        let typed: Vec<String> = typed.split_whitespace().map(str::to_owned).collect();
        let expected = "rtbench run hall.obj kitchen -o out --export-csv=out/a.csv -oy --baselines . \
                        -s grid:a=1 --set uniform-grid.density=4 --export-json - results/one ../b";
        let recorded = recorded(&typed, Some(Path::new("/home/me/rtbench")));
        assert_eq!(recorded, expected.split_whitespace().collect::<Vec<_>>());
        // it stays as it is when it is recorded again
        assert_eq!(super::recorded(&recorded, None), recorded);
    }

    #[test]
    fn a_process_without_arguments_is_rtbench() {
        assert_eq!(recorded(&[], None), ["rtbench"]);
        assert_eq!(recorded(&["./rtbench".into(), String::new()], None), ["rtbench", ""]);
    }
}
