//! Invalid requests on the command line, or in a file with the same contents.

use accel_core::params::ParamError;

use crate::scenes::LoadError;
use crate::settings::shard::Shard;

/// Invalid requests on the command line.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PlanError {
    #[error("unknown structure '{name}'{hint}; valid: {valid}")]
    UnknownStructure {
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    /// No such parameter, or a value out of range.
    #[error("{error}{hint}")]
    Param {
        error: ParamError,
        /// ` (did you mean ...?)` or empty.
        hint: String,
    },
    /// Not of the right form.
    #[error("cannot read '{text}': expected {expected}")]
    Malformed { text: String, expected: &'static str },
    /// `--set` for a structure that is not measured.
    #[error("--set names {structure}, which this run does not measure; add it to -s")]
    OverrideWithoutRow { structure: &'static str },
    /// No such kind of ray.
    #[error("unknown kind of ray '{name}'{hint}; valid: {valid}")]
    UnknownRays {
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    /// No such thing among those of a kind.
    #[error("unknown {what} '{name}'{hint}; valid: {valid}")]
    UnknownName {
        what: &'static str,
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    /// No such hard case or group of them.
    #[error("unknown case '{name}'{hint}; valid: {valid}")]
    UnknownCase {
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    /// No such rule for rays that leave surfaces.
    #[error("unknown offset '{name}'{hint}; valid: {valid}")]
    UnknownOffset {
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    /// No such axis of accuracy.
    #[error("unknown axis '{name}'{hint}; valid: {valid}")]
    UnknownAxis {
        name: String,
        /// ` (did you mean ...?)` or empty.
        hint: String,
        valid: String,
    },
    /// A number that a run cannot have.
    #[error("{what}: {value}, expected a number from 1 to {most}")]
    OutOfRange { what: &'static str, value: u64, most: u64 },
    /// An occluder, and none of the rays that it answers.
    #[error("{structure} answers shadow rays only; add shadow to --rays")]
    NoRaysFor { structure: &'static str },
    /// The cases asked for concern none of the structures asked for.
    #[error("none of these cases applies to these structures; leave out -s, or name other cases")]
    NothingAsked,
    /// There are no structures at all.
    #[error("there are no structures to measure")]
    NoRows,
    /// A part of a run that is too small to be cut so often.
    #[error(
        "--shard {shard}: this run has {cells} cells (scenes times rows, without the reference); \
             use at most {cells} shards"
    )]
    TooManyShards {
        shard: Shard,
        /// Number of cells to divide.
        cells: usize,
    },
    /// Parts could not be joined again.
    #[error("--shard: two scenes are named {name}; shards are merged by names")]
    SameName { name: String },
    /// Two outputs would be mixed up.
    #[error("only one output can go to standard output (-); name files for the others")]
    OneStdout,
    /// No such scene or set.
    #[error(transparent)]
    Scene(#[from] LoadError),
}
