//! Whether an answer differs only where rounding decides: asked of the structure that the oracle
//! confirmed.

use std::sync::OnceLock;

use accel_core::Ray;
use accel_core::registry::Buildable;
use renderer::Geometry;

use crate::answers::oracle::{Opinion, Oracle};
use crate::plan::rows::Row;
use crate::rays::batches::Answers;

/// How far a ray is moved to find out whether it passes an edge: ulps, of the precision that is
/// tested, of the scene's largest coordinate and of the direction's length. 64 are 4e-6 of the scene
/// in f32, 7e-15 in f64: a few times what the usual tests (Moeller and Trumbore) are off by at
/// triangles that are no slivers.
pub const EDGE_ULPS: f64 = 64.0;

/// Judges answers that differ.
pub trait EdgeJudge<S: Buildable>: Sync {
    /// Opinion on answer `i`, to `ray`; `None` if it has none.
    fn opinion(&self, ray: &Ray<S>, answers: &Answers<S>, i: usize) -> Option<Opinion>;
}

/// Judges answers that differ, by the structure that the oracle confirmed, in f64. Built when it is
/// asked for the first time.
pub struct Edges<'a> {
    exact: &'a Geometry<f64>,
    row: Option<Row<'a>>,
    oracle: OnceLock<Option<Oracle<'a>>>,
}

impl<'a> Edges<'a> {
    /// Judge for a scene whose answers come from `row`.
    pub fn new(exact: &'a Geometry<f64>, row: Option<Row<'a>>) -> Self {
        Self { exact, row, oracle: OnceLock::new() }
    }

    fn oracle(&self) -> Option<&Oracle<'a>> {
        let build = || {
            let row = self.row.as_ref()?;
            Oracle::of_structure(self.exact, row, EDGE_ULPS).ok()
        };
        self.oracle.get_or_init(build).as_ref()
    }
}

impl<S: Buildable> EdgeJudge<S> for Edges<'_> {
    fn opinion(&self, ray: &Ray<S>, answers: &Answers<S>, i: usize) -> Option<Opinion> {
        self.oracle()?.strict_opinion(ray, answers, i)
    }
}
