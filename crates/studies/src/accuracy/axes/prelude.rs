//! What an axis is written with.

pub(super) use crate::accuracy::axis::{Axis, Measure};
pub(super) use crate::accuracy::record::{ErrorOf, SceneOutcome, TrialCounts};
pub(super) use crate::accuracy::stage::{Batches, Replay, Stage, TRACER, Work, count};
pub(super) use crate::accuracy::timing::{AxisReport, Variant, timed};
pub(super) use crate::error::StudyError;
