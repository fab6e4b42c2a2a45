//! What ends a command, and with which exit code.

use std::io;
use std::path::PathBuf;

use crate::scene_source::LoadError;
use accel_core::structures::BuildError;

use crate::comparison::CompareError;
use crate::config::ConfigError;
use crate::gate::GateError;
use crate::journal::JournalError;
use crate::merge::MergeError;
use crate::panics::Panicked;
use crate::plan::PlanError;
use crate::record_file::RecordError;
use crate::report::ReportError;
use crate::reproduce::ReproduceError;
use renderer::{GeometryError, ImageError};

/// Fine.
pub const SUCCESS: u8 = 0;
/// Something failed.
pub const FAILURE: u8 = 1;
/// The command line makes no sense.
pub const USAGE: u8 = 2;
/// Something got worse than a baseline.
pub const REGRESSION: u8 = 3;
/// A structure gave wrong hits.
pub const WRONG_HITS: u8 = 4;
/// Something could not be told from a regression, and `--strict` was given; or `verify` ran out of
/// time before it had asked everything.
pub const INCONCLUSIVE: u8 = 5;
/// SIGINT (Ctrl-C) ended the run; other signals as shells count them, 128 and their number.
pub const INTERRUPTED: u8 = 130;

/// Why a command ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The command line names something that is not there, or that is not valid.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// A scene could not be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A scene's geometry could not be made.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A structure could not be built where nothing can be done without it.
    #[error("scene {scene}: {source}")]
    Build {
        /// Scene.
        scene: String,
        /// Why.
        source: BuildError,
    },
    /// No structure could be built that gives the answers to compare with.
    #[error("scene {scene}: no structure could be built to compare answers with: {reasons}")]
    NoAnswers {
        /// Scene.
        scene: String,
        /// What each candidate said.
        reasons: String,
    },
    /// An output file cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// The file or folder.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// An image cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Image {
        /// The file.
        path: PathBuf,
        /// Why.
        source: ImageError,
    },
    /// A scene has nothing that an axis of accuracy is about.
    #[error("{axis}: scene {scene} does not serve: {reason}")]
    UnfitScene {
        /// Axis.
        axis: &'static str,
        /// Scene.
        scene: String,
        /// What it lacks.
        reason: &'static str,
    },
    /// Nothing was measured that a model of times could be made from.
    #[error("the images of {scenes} took no time that a prediction could be made from")]
    NoModel {
        /// The scenes.
        scenes: String,
    },
    /// Threads could not be started.
    #[error("cannot start {threads} threads: {source}")]
    Threads {
        /// How many.
        threads: usize,
        /// Why.
        source: rayon::ThreadPoolBuildError,
    },
    /// Results could not be turned into text.
    #[error("cannot write the results as {format}: {message}")]
    Format {
        /// CSV or JSON.
        format: &'static str,
        /// What the library said.
        message: String,
    },
    /// The journal of a run cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Something panicked while a scene was measured: a defect of ours.
    #[error("scene {scene}: {source}; this is a defect of rtbench")]
    Panicked {
        /// Scene.
        scene: String,
        /// What it said.
        source: Panicked,
    },
    /// Signals cannot be had.
    #[error("cannot watch for signals: {0}")]
    Signals(io::Error),
    /// The record of a run cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Runs are not compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// Nothing could be held against a baseline.
    #[error(transparent)]
    Gate(#[from] GateError),
    /// The configuration cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The parts of a run cannot be joined.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// What a report is made from cannot be read.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// Published figures could not be reproduced.
    #[error(transparent)]
    Reproduce(#[from] ReproduceError),
    /// Standard output failed; a closed pipe is not an error, see [`Error::is_closed_pipe`].
    #[error("cannot write to standard output: {0}")]
    Output(#[from] io::Error),
}

impl Error {
    /// The exit code it stands for.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Plan(PlanError::Scene(e)) | Self::Load(e) => {
                use LoadError::{NoSizes, Procedural, UnknownScene};
                let is_usage =
                    matches!(e, UnknownScene { .. } | Procedural { .. } | NoSizes { .. });
                if is_usage { USAGE } else { FAILURE }
            }
            Self::Compare(CompareError::Filter { .. } | CompareError::NothingMatches { .. }) => {
                USAGE
            }
            Self::Gate(error) if error.is_usage() => USAGE,
            Self::Plan(_) | Self::Config(_) => USAGE,
            Self::Reproduce(
                ReproduceError::UnknownScene(_)
                | ReproduceError::UnknownStructure(_)
                | ReproduceError::NotInLecture(_)
                | ReproduceError::FixedReference(_),
            ) => USAGE,
            _ => FAILURE,
        }
    }

    /// The reader of our output went away, as `head` does: nothing to report, unless a run was
    /// not finished.
    pub fn is_closed_pipe(&self) -> bool {
        matches!(self, Self::Output(e) if e.kind() == io::ErrorKind::BrokenPipe)
    }
}
