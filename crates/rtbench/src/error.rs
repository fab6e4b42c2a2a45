//! Errors that end a command, with exit codes.

use std::io;
use std::path::PathBuf;

use accel_core::query::cells::NoCells;
use presentation::drawing::ImageError;

use measurement::journal::JournalError;
use measurement::plan::error::PlanError;
use measurement::rays::text::RayTextError;
use measurement::record::file::RecordError;
use measurement::record::machines::MachinesError;
use measurement::record::merge::MergeError;
use measurement::rounds::error::MeasureError;
use measurement::scenes::LoadError;
use measurement::system::created::WriteError;
use measurement::system::program_copy::CopyError;
use plugins::PluginError;
use plugins::files::FileError;
use presentation::json::FormatError;
use renderer::GeometryError;
use studies::animate::AnimateError;
use studies::error::{StudyError, UnsavedImage};
use studies::explain::ExplainError;
use studies::reproduce::ReproduceError;
use studies::sweep::SweepError;
use studies::sweep::sizes::SizesError;

use crate::comparison::CompareError;
use crate::exit_code::{FAILURE, NOTHING_COMPARED, USAGE};
use crate::exports::occupied::OccupiedError;
use crate::exports::outputs::OutputError;
use crate::foreign_row::ForeignRowError;
use crate::gate::GateError;
use crate::history::HistoryError;
use crate::replan::ReplanError;
use crate::report::ReportError;
use crate::set_options::SetOptionsError;

/// Why a command ended early.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// The command line names something that is not there, or that is not valid.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// Nothing that can be swept.
    #[error(transparent)]
    Sweep(Box<SweepError>),
    /// Nothing that can be scaled.
    #[error(transparent)]
    Sizes(Box<SizesError>),
    /// Nothing that can be animated.
    #[error(transparent)]
    Animate(Box<AnimateError>),
    /// Nothing that can be explained.
    #[error(transparent)]
    Explain(Box<ExplainError>),
    /// A scene could not be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A scene could not be measured.
    #[error(transparent)]
    Measure(Box<MeasureError>),
    /// A plugin cannot be used.
    #[error(transparent)]
    Plugin(#[from] PluginError),
    /// A file of hits cannot be used.
    #[error(transparent)]
    HitsFile(#[from] FileError),
    /// Rays cannot be read.
    #[error(transparent)]
    RayText(#[from] RayTextError),
    /// Results take no foreign row.
    #[error(transparent)]
    ForeignRow(#[from] ForeignRowError),
    /// Only triangles are written to files.
    #[error(
        "scene {scene}: has other primitives than static triangles; scenes named ...-tess are tessellated"
    )]
    NotOfTriangles { scene: String },
    /// A study ended early.
    #[error(transparent)]
    Study(Box<StudyError>),
    /// An output file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// Two outputs would be mixed up, or the files of results cannot be written.
    #[error(transparent)]
    Outputs(OutputError),
    /// The folder of `-o` holds other results.
    #[error(transparent)]
    Occupied(#[from] OccupiedError),
    /// Nothing was measured that a model of times could be made from.
    #[error("the images of {scenes} were too fast to predict from")]
    NoModel { scenes: String },
    /// Results could not be turned into text.
    #[error(transparent)]
    Format(#[from] FormatError),
    /// The journal of a run cannot be used.
    #[error(transparent)]
    Journal(#[from] JournalError),
    /// Signals cannot be had.
    #[error("cannot watch for signals: {0}")]
    Signals(io::Error),
    /// The record of a run cannot be read.
    #[error(transparent)]
    Record(#[from] RecordError),
    /// Runs are not compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// No row could be compared with the baseline.
    #[error(transparent)]
    Gate(Box<GateError>),
    /// The options of a set file cannot be used.
    #[error(transparent)]
    SetOptions(Box<SetOptionsError>),
    /// The parts of a run cannot be joined.
    #[error(transparent)]
    Merge(#[from] MergeError),
    /// Runs of several machines are not the same run.
    #[error(transparent)]
    Machines(#[from] MachinesError),
    /// The input of a report cannot be read.
    #[error(transparent)]
    Report(#[from] ReportError),
    /// The input of a history cannot be read.
    #[error(transparent)]
    History(#[from] HistoryError),
    /// The copy of this program that the floor is measured with.
    #[error(transparent)]
    Copy(#[from] CopyError),
    /// A structure's cells cannot be drawn.
    #[error("structure {row}: {source}")]
    NoCells { row: String, source: NoCells },
    /// A picture cannot be encoded.
    #[error("cannot draw {}: {source}", path.display())]
    Undrawn { path: PathBuf, source: ImageError },
    /// Published figures could not be reproduced.
    #[error(transparent)]
    Reproduce(#[from] ReproduceError),
    /// Standard output failed; a closed pipe is not an error, see [`Error::is_closed_pipe`].
    #[error("cannot write to standard output: {0}")]
    Output(#[from] io::Error),
}

/// Maps equal errors of several subsystems to one.
impl From<MeasureError> for Error {
    fn from(error: MeasureError) -> Self {
        match error {
            MeasureError::Load(error) => Self::Load(error),
            other => Self::Measure(Box::new(other)),
        }
    }
}

impl From<GeometryError> for Error {
    fn from(error: GeometryError) -> Self {
        MeasureError::from(error).into()
    }
}

impl From<StudyError> for Error {
    fn from(error: StudyError) -> Self {
        match error {
            StudyError::Plan(error) => Self::Plan(error),
            StudyError::Measure(error) => (*error).into(),
            other => Self::Study(Box::new(other)),
        }
    }
}

impl From<UnsavedImage> for Error {
    fn from(error: UnsavedImage) -> Self {
        StudyError::from(error).into()
    }
}

impl From<SweepError> for Error {
    fn from(error: SweepError) -> Self {
        match error {
            SweepError::Plan(error) => Self::Plan(error),
            SweepError::Scene(error) => Self::Load(error),
            other => Self::Sweep(Box::new(other)),
        }
    }
}

impl From<AnimateError> for Error {
    fn from(error: AnimateError) -> Self {
        match error {
            AnimateError::Plan(error) => Self::Plan(error),
            other => Self::Animate(Box::new(other)),
        }
    }
}

impl From<ExplainError> for Error {
    fn from(error: ExplainError) -> Self {
        match error {
            ExplainError::Plan(error) => Self::Plan(error),
            other => Self::Explain(Box::new(other)),
        }
    }
}

impl From<SizesError> for Error {
    fn from(error: SizesError) -> Self {
        match error {
            SizesError::Plan(error) => Self::Plan(error),
            SizesError::Scene(error) => Self::Load(error),
            other => Self::Sizes(Box::new(other)),
        }
    }
}

impl From<GateError> for Error {
    fn from(error: GateError) -> Self {
        Self::Gate(Box::new(error))
    }
}

impl From<ReplanError> for Error {
    fn from(error: ReplanError) -> Self {
        match error {
            ReplanError::Plan(error) => Self::Plan(error),
            other => GateError::from(other).into(),
        }
    }
}

impl From<SetOptionsError> for Error {
    fn from(error: SetOptionsError) -> Self {
        match error {
            SetOptionsError::Plan(error) => Self::Plan(error),
            other => Self::SetOptions(Box::new(other)),
        }
    }
}

impl From<OutputError> for Error {
    fn from(error: OutputError) -> Self {
        match error {
            OutputError::Stdout(error) => Self::Output(error),
            OutputError::Write(error) => Self::Write(error),
            other => Self::Outputs(other),
        }
    }
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
            Self::Compare(
                CompareError::Filter { .. }
                | CompareError::Match { .. }
                | CompareError::NothingMatches { .. },
            ) => USAGE,
            Self::Gate(error) if error.is_usage() => USAGE,
            Self::Gate(error) if matches!(**error, GateError::NothingCompared(_)) => {
                NOTHING_COMPARED
            }
            Self::Plan(_)
            | Self::Sweep(_)
            | Self::Sizes(_)
            | Self::Explain(_)
            | Self::Animate(_)
            | Self::SetOptions(_) => USAGE,
            Self::Plugin(PluginError::NameTaken { .. } | PluginError::NoProcesses { .. }) => USAGE,
            Self::Outputs(
                OutputError::OneStdout
                | OutputError::SameFile(_)
                | OutputError::IsRead(_)
                | OutputError::NothingSelected(..),
            ) => USAGE,
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
