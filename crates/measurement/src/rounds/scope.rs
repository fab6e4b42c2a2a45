//! Context of the measurement of one scene.

use accel_core::registry::Buildable;
use glam::DVec3;

use crate::answers::edges::EdgeJudge;
use crate::answers::reference::Stage;
use crate::plan::Plan;
use crate::rays::batches::BatchSet;
use crate::system::clock::Clock;
use crate::system::pools::Pools;
use crate::system::progress::Progress;

/// Everything that the measurement of one scene works with.
pub struct Scope<'a, 'r, S: Buildable> {
    pub plan: &'a Plan<'r>,
    pub stage: &'a Stage<'a, S>,
    /// Where the lights of the scene are.
    pub lights: &'a [DVec3],
    /// All rays with the answers expected.
    pub all: &'a BatchSet<'a, S>,
    /// The oracle confirmed those answers.
    pub is_confirmed: bool,
    /// Judges answers that differ at edges.
    pub edges: &'a (dyn EdgeJudge<S> + 'a),
    pub pools: &'a Pools,
    pub clock: &'a dyn Clock,
    pub progress: &'a Progress,
}
