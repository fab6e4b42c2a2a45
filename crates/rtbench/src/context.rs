//! Context of a command: the parts of the outside world that tests replace.

use std::cell::RefCell;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::rc::Rc;

use accel_core::occluders;
use accel_core::structures::Entry;

use crate::args::Color;
use crate::gate::against::{AgainstError, Program};
use crate::outputs::{OutputError, OutputFile, Outputs, PlannedOutput};
use crate::plugin_rows::Plugins;
use measurement::journal::lines::Manifest;
use measurement::scenes::{KnownScene, LoadError, LoadedScene, SceneSource};
use measurement::system::child_process::{CopyError, ProgramCopy};
use measurement::system::clock::Clock;
use measurement::system::files::CreatedFiles;
use measurement::system::progress::Progress;
use measurement::system::world::World;
use measurement::system::{machine, world};
use presentation::outside::{self, Annotation};
use presentation::text::{Screen, wrapped};
use scene_loading::Scene;

/// The outside world as a command sees it.
pub struct Context<'a> {
    pub registry: &'a [Entry],
    pub occluders: &'a [occluders::Entry],
    pub scenes: &'a dyn SceneSource,
    pub clock: &'a dyn Clock,
    /// Source of machine and compiler facts in results.
    pub world: &'a World,
    /// Standard output: results and nothing else.
    pub out: &'a mut dyn Write,
    pub err: &'a mut dyn Write,
    /// The command line, program first; commands get it as results record it.
    pub command_line: Vec<String>,
    /// Which outputs are terminals, their width, and colours by the environment.
    pub terminal: Terminal,
    /// When standard output gets colours.
    pub color: Color,
    pub verbosity: Verbosity,
    /// Files and results that are there may be replaced.
    pub overwrite: bool,
    pub environment: Environment,
    /// Annotations for a CI job, printed when the command has ended.
    pub annotations: Rc<RefCell<Vec<Annotation>>>,
    /// Structures that come from plugins.
    pub plugins: Plugins,
}

/// Environment of the process, apart from the terminal.
#[derive(Debug, Clone, Default)]
pub struct Environment {
    /// This program's file, to start it again; none where it is not known.
    pub program: Option<PathBuf>,
    /// GITHUB_ACTIONS is `true`: annotations are read.
    pub github_actions: bool,
    /// GITHUB_STEP_SUMMARY: the file that Markdown is appended to.
    pub github_step_summary: Option<PathBuf>,
    /// The file in which Linux says how long threads waited for a processor.
    pub cpu_pressure: Option<PathBuf>,
    /// RTBENCH_BASELINES: the folder of baselines.
    pub baselines: Option<PathBuf>,
    /// The folder for temporary files.
    pub temporary: Option<PathBuf>,
}

impl Environment {
    /// A copy of a program's file among the temporary files.
    pub fn copy_of(&self, program: &Path) -> Result<ProgramCopy, CopyError> {
        let temporary = self.temporary.clone().unwrap_or_else(std::env::temp_dir);
        ProgramCopy::of(program, &temporary)
    }

    pub fn detect() -> Self {
        let path = |name| std::env::var_os(name).filter(|v| !v.is_empty()).map(PathBuf::from);
        Self {
            program: std::env::current_exe().ok(),
            github_actions: std::env::var_os("GITHUB_ACTIONS").is_some_and(|v| v == "true"),
            github_step_summary: path("GITHUB_STEP_SUMMARY"),
            cpu_pressure: Some(machine::CPU_PRESSURE.into()),
            baselines: path("RTBENCH_BASELINES"),
            temporary: Some(std::env::temp_dir()),
        }
    }
}

#[derive(Debug, Clone, Copy, Default)]
pub struct Terminal {
    /// Standard output is one.
    pub stdout: bool,
    /// Standard error is one.
    pub stderr: bool,
    /// NO_COLOR is set and not empty, or TERM is `dumb`.
    pub no_color: bool,
    /// Width of help text; `None`: determined when it is printed.
    pub columns: Option<usize>,
    /// Width of standard output, if it is a terminal or COLUMNS is set.
    pub found_width: Option<usize>,
}

/// Characters of a line where nobody says how wide it is.
const DEFAULT_WIDTH: usize = 120;
/// Narrower terminals break lines themselves.
const LEAST_WIDTH: usize = 40;

impl Terminal {
    pub fn detect() -> Self {
        use std::io::IsTerminal;
        let no_color = std::env::var_os("NO_COLOR").is_some_and(|v| !v.is_empty())
            || std::env::var_os("TERM").is_some_and(|v| v == "dumb");
        let (stdout, stderr) = (io::stdout().is_terminal(), io::stderr().is_terminal());
        let columns = || std::env::var("COLUMNS").ok()?.parse().ok();
        let terminal = stdout.then(terminal_size::terminal_size).flatten();
        let found_width = terminal.map(|(width, _)| usize::from(width.0)).or_else(columns);
        Self { stdout, stderr, no_color, columns: None, found_width }
    }

    /// Characters of a line of tables.
    pub fn width(self) -> usize {
        self.found_width.unwrap_or(DEFAULT_WIDTH).max(LEAST_WIDTH)
    }

    pub fn colors(self, choice: Color) -> bool {
        match choice {
            Color::Always => true,
            Color::Never => false,
            Color::Auto => self.stdout && !self.no_color,
        }
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verbosity {
    Quiet,
    Normal,
    /// Also prints progress in detail.
    Verbose,
}

impl<'a> Context<'a> {
    /// Over these, writing to `out` and `err`; nothing is known of a terminal or an environment.
    pub fn new(
        registry: &'a [Entry],
        scenes: &'a dyn SceneSource,
        clock: &'a dyn Clock,
        world: &'a World,
        out: &'a mut dyn Write,
        err: &'a mut dyn Write,
    ) -> Self {
        Self {
            registry,
            occluders: occluders::REGISTRY,
            scenes,
            clock,
            world,
            out,
            err,
            command_line: vec!["rtbench".into()],
            terminal: Terminal::default(),
            color: Color::Auto,
            verbosity: Verbosity::Normal,
            overwrite: false,
            environment: Environment::default(),
            annotations: Rc::default(),
            plugins: Plugins::default(),
        }
    }
}

impl Context<'_> {
    /// The same context for a while.
    pub fn reborrowed(&mut self) -> Context<'_> {
        Context {
            registry: self.registry,
            occluders: self.occluders,
            scenes: self.scenes,
            clock: self.clock,
            world: self.world,
            out: &mut *self.out,
            err: &mut *self.err,
            command_line: self.command_line.clone(),
            terminal: self.terminal,
            color: self.color,
            verbosity: self.verbosity,
            overwrite: self.overwrite,
            environment: self.environment.clone(),
            annotations: Rc::clone(&self.annotations),
            plugins: self.plugins.clone(),
        }
    }

    /// Standard output, as tables are printed on it.
    pub fn screen(&self) -> Screen {
        let colors = self.terminal.colors(self.color);
        Screen { width: self.terminal.width(), colors, is_wide: false }
    }

    /// The same without colours.
    pub fn plain_screen(&self) -> Screen {
        Screen { colors: false, ..self.screen() }
    }

    /// Refuses a folder that holds other results in files of these names, the record's first, unless
    /// output may be replaced.
    pub fn refuse_occupied(
        &self,
        folder: &Path,
        names: &[&str],
        manifest: Option<&Manifest>,
    ) -> Result<(), OutputError> {
        let (command_line, overwrite) = (&*self.command_line, self.overwrite);
        PlannedOutput { names, command_line, manifest, overwrite }.check(folder)
    }

    /// Creates the folder of `-o`, if one is named, and in it files of these names, the record's
    /// first, unless it is refused. What is still empty in the end is taken back.
    pub fn created_folder(
        &self,
        folder: Option<&PathBuf>,
        names: &[&str],
    ) -> Result<CreatedFiles, OutputError> {
        let mut created = CreatedFiles::default();
        if let Some(folder) = folder {
            self.refuse_occupied(folder, names, None)?;
            created.folder(folder)?;
            for name in names {
                created.file(&folder.join(name))?;
            }
        }
        Ok(created)
    }

    /// The same for files that are written anew after each scene.
    pub fn outputs_in<'o, const N: usize>(
        &self,
        folder: Option<&PathBuf>,
        files: [OutputFile<'o>; N],
    ) -> Result<Outputs<'o>, OutputError> {
        let names = files.each_ref().map(|(name, _)| *name);
        let mut outputs = Outputs::new(folder.cloned(), self.created_folder(folder, &names)?);
        for (name, format) in files {
            outputs.add_in_folder(name, format)?;
        }
        Ok(outputs)
    }

    /// This program, as it is started with the plugins and the rights of this process.
    pub fn own_program(&self) -> Result<Program, AgainstError> {
        let path = self.environment.program.clone().ok_or(AgainstError::NoProgram)?;
        let plugins = self.plugins.arguments.clone();
        Ok(Program { path, plugins, allow_outside: self.scenes.allows_outside() })
    }

    /// Warns of what a scene loses in single precision.
    pub fn warn_in_f32(&mut self, scene: &Scene) {
        for warning in scene.warnings_in_f32() {
            self.warn(format_args!("{}: {warning}", scene.name));
        }
    }

    /// Loads a scene and shows how far that is.
    pub fn load(&self, scene: &dyn KnownScene) -> Result<LoadedScene, LoadError> {
        let progress = Progress::of_loading(self.shows_progress(), scene.name());
        let loaded = scene.load();
        progress.finish();
        loaded
    }

    /// Returns whether a bar is shown: somebody may look at it, and nobody asked for quiet.
    pub fn shows_progress(&self) -> bool {
        self.terminal.stderr && self.verbosity > Verbosity::Quiet
    }

    pub fn warn(&mut self, message: impl std::fmt::Display) {
        if self.verbosity > Verbosity::Quiet {
            self.write_err(&format!("warning: {}", outside::message(&message.to_string())));
        }
    }

    /// Warns where the program was compiled for less than the processor has.
    pub fn warn_of_instructions(&mut self) {
        let unused = world::unused(self.world);
        if !unused.is_empty() {
            let unused = unused.join(", ");
            let advice = world::ADVICE;
            self.warn(format_args!(
                "compiled without {unused}, which this processor has: the program is slower than \
                 possible; {advice}"
            ));
        }
    }

    /// Prints to standard error, within the width of the terminal if that is known. A closed
    /// standard error is nobody's loss.
    pub fn write_err(&mut self, text: &str) {
        let width = self.terminal.found_width.map_or(usize::MAX, |_| self.terminal.width());
        for part in text.lines().flat_map(|line| wrapped(line, width, 2)) {
            let _ = writeln!(self.err, "{part}");
        }
    }

    pub fn error(&mut self, message: impl std::fmt::Display) {
        self.write_err(&format!("error: {}", outside::message(&message.to_string())));
    }

    /// Prints which file was written, and of what it is.
    pub fn wrote(&mut self, path: &Path, what: impl std::fmt::Display) {
        if self.verbosity > Verbosity::Quiet {
            self.write_err(&outside::message(&format!("wrote {}: {what}", path.display())));
        }
    }

    /// Prints what is being done, when asked to.
    pub fn say(&mut self, message: impl std::fmt::Display) {
        if self.verbosity >= Verbosity::Verbose {
            self.write_err(&outside::message(&message.to_string()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colors_follow_choice_terminal_and_environment() {
        let tty = Terminal { stdout: true, stderr: true, ..Terminal::default() };
        let plain = Terminal { no_color: true, ..tty };
        assert!(tty.colors(Color::Auto) && !plain.colors(Color::Auto));
        assert!(plain.colors(Color::Always) && !tty.colors(Color::Never));
        assert!(!Terminal::default().colors(Color::Auto));
        let of = |found_width| Terminal { found_width, ..Terminal::default() }.width();
        assert_eq!([of(None), of(Some(80)), of(Some(1))], [DEFAULT_WIDTH, 80, LEAST_WIDTH]);
    }
}
