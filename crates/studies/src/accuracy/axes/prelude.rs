//! What an axis is written with.

pub(super) use crate::accuracy::axis::{Axis, Measure};
pub(super) use crate::accuracy::record::{ErrorOf, SceneOutcome, TrialCounts, in_a_million};
pub(super) use crate::accuracy::stage::{
    Batches, Replay, Stage, TRACER, Work, build_columns, count, counted, diagonal, mebibytes,
    replays, widened,
};
pub(super) use crate::accuracy::timing::{Variant, timed};
pub(super) use crate::error::StudyError;
