//! Judges rows that decide by a primitive test of their own, as `run` does: an answer that differs
//! from ours is put before an oracle in f64 ([`Oracle::strict_opinion`]).

use std::cell::OnceCell;

use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::find;
use accel_core::{Hit, Ray};

use super::mismatch::Difference;
use super::model::Model;
use super::subject::brute_force_entry;
use measurement::answers::arbiter::EDGE_ULPS;
use measurement::answers::oracle::{Opinion, Oracle};
use measurement::rays::batches::Answers;
use measurement::rays::exactness::is_apart;

/// Primitives up to which the oracle tests all of them; above, it asks a structure.
const MOST_FOR_BRUTE_FORCE: usize = 4096;

/// An oracle over a scene, built when the first answer differs by more than last bits.
pub(super) struct OwnTestJudge<'a> {
    exact: &'a Model<f64>,
    oracle: OnceCell<Option<Oracle<'a>>>,
}

impl<'a> OwnTestJudge<'a> {
    /// Over the scene in f64.
    pub(super) fn new(exact: &'a Model<f64>) -> Self {
        Self { exact, oracle: OnceCell::new() }
    }

    /// How a hit differs from ours; whether it is wrong.
    pub(super) fn hit<S: Buildable>(
        &self,
        ray: &Ray<S>,
        said: &Hit<S>,
        ours: &Hit<S>,
    ) -> Option<(Difference, bool)> {
        let difference = Difference::of_hits(ray, said, ours);
        if said.id == ours.id && !is_apart(said, ours, ray) {
            let is_equal = !said.is_hit() || said.t == ours.t;
            return (!is_equal).then_some((Difference::LastBits, false));
        }
        Some(self.judged(ray, &Answers::Hits(vec![*said]), difference))
    }

    /// The same of an occlusion.
    pub(super) fn occlusion<S: Buildable>(
        &self,
        ray: &Ray<S>,
        said: bool,
        ours: bool,
    ) -> Option<(Difference, bool)> {
        let difference = Difference::of_occlusion(said);
        (said != ours).then(|| self.judged(ray, &Answers::Blocked(vec![said]), difference))
    }

    fn judged<S: Buildable>(
        &self,
        ray: &Ray<S>,
        said: &Answers<S>,
        difference: Difference,
    ) -> (Difference, bool) {
        let oracle = self.oracle.get_or_init(|| self.build().ok()).as_ref();
        match oracle.and_then(|oracle| oracle.strict_opinion(ray, said, 0)) {
            Some(Opinion::Right) => (Difference::LastBits, false),
            Some(Opinion::Borderline) => (Difference::Edge, false),
            Some(Opinion::Wrong(_)) | None => (difference, true),
        }
    }

    fn build(&self) -> Result<Oracle<'a>, BuildError> {
        let prims = self.exact.prims();
        let large = find("wide-bvh").filter(|_| self.exact.len() > MOST_FOR_BRUTE_FORCE);
        let entry = large.map_or_else(brute_force_entry, Ok)?;
        Oracle::over(prims, entry, &entry.params([])?, EDGE_ULPS)
    }
}
