//! Answers that differ from ours, and how.
//!
//! Those of rows that decide by a primitive test of their own are judged as `run` does: put before
//! an oracle in f64 ([`Oracle::strict_opinion`]).

use std::cell::OnceCell;

use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::find;
use accel_core::{Hit, Ray, Scalar};
use renderer::Geometry;
use serde::Serialize;

use super::subject::brute_force_entry;
use measurement::answers::arbiter::EDGE_ULPS;
use measurement::answers::oracle::{Opinion, Oracle};
use measurement::rays::batches::Answers;
use measurement::rays::exactness::is_apart;

/// How an answer differs, by its name in records.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Difference {
    /// The ray passes an edge so closely that moving it changes the right answer, too.
    #[serde(rename = "at_edges")]
    Edge,
    /// There is no such hit.
    Invented,
    /// In `t`, by no more than rounding.
    LastBits,
    /// A hit is missed, or one behind it is returned.
    Lost,
    /// The hit is there, but on another primitive.
    WrongId,
}

impl Difference {
    pub const ALL: [Self; 5] =
        [Self::Edge, Self::Invented, Self::LastBits, Self::Lost, Self::WrongId];

    /// Between an answer and the right one, which are not equal.
    pub fn of_hits<S: Scalar>(ray: &Ray<S>, said: &Hit<S>, right: &Hit<S>) -> Self {
        match (said.is_hit(), right.is_hit()) {
            (false, _) => Self::Lost,
            (true, false) => Self::Invented,
            _ if !is_apart(said, right, ray) && said.id == right.id => Self::LastBits,
            _ if !is_apart(said, right, ray) => Self::WrongId,
            _ if said.t > right.t && said.id != right.id => Self::Lost,
            _ => Self::Invented,
        }
    }

    /// Between an answer about an occlusion and the right one.
    pub fn of_occlusion(said: bool) -> Self {
        if said { Self::Invented } else { Self::Lost }
    }
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// Index of the ray in the round.
    pub ray: usize,
    /// How it differs; none where the structure panicked, or only an oracle sees it.
    pub difference: Option<Difference>,
    /// True if it is wrong. Last bits and edges are so only of our own primitive tests.
    pub is_wrong: bool,
    /// The answer and the right one; empty if it is not wrong.
    pub what: String,
}

impl Mismatch {
    pub fn wrong(ray: usize, difference: Option<Difference>, what: String) -> Self {
        Self { ray, difference, is_wrong: true, what }
    }
}

/// Primitives up to which the oracle tests all of them; above, it asks a structure.
const MOST_FOR_BRUTE_FORCE: usize = 4096;

/// How an answer differs from ours; whether it is wrong.
type Judgement = (Difference, bool);

/// An oracle over a scene, built when the first answer differs by more than last bits.
pub(super) struct OwnTestJudge<'a> {
    exact: &'a Geometry<f64>,
    oracle: OnceCell<Option<Oracle<'a>>>,
}

impl<'a> OwnTestJudge<'a> {
    pub(super) fn new(exact: &'a Geometry<f64>) -> Self {
        Self { exact, oracle: OnceCell::new() }
    }

    /// How a hit differs from ours.
    pub fn hit<S: Buildable>(
        &self,
        ray: &Ray<S>,
        said: &Hit<S>,
        ours: &Hit<S>,
    ) -> Option<Judgement> {
        let difference = Difference::of_hits(ray, said, ours);
        if said.id == ours.id && !is_apart(said, ours, ray) {
            let is_equal = !said.is_hit() || said.t == ours.t;
            return (!is_equal).then_some((Difference::LastBits, false));
        }
        Some(self.judged(ray, &Answers::Hits(vec![*said]), difference))
    }

    /// The same of an occlusion.
    pub fn occlusion<S: Buildable>(
        &self,
        ray: &Ray<S>,
        said: bool,
        ours: bool,
    ) -> Option<Judgement> {
        let difference = Difference::of_occlusion(said);
        (said != ours).then(|| self.judged(ray, &Answers::Blocked(vec![said]), difference))
    }

    fn judged<S: Buildable>(&self, ray: &Ray<S>, said: &Answers<S>, how: Difference) -> Judgement {
        let oracle = self.oracle.get_or_init(|| self.build().ok()).as_ref();
        match oracle.and_then(|oracle| oracle.strict_opinion(ray, said, 0)) {
            Some(Opinion::Right) => (Difference::LastBits, false),
            Some(Opinion::Borderline) => (Difference::Edge, false),
            Some(Opinion::Wrong(_)) | None => (how, true),
        }
    }

    fn build(&self) -> Result<Oracle<'a>, BuildError> {
        let prims = self.exact.prims();
        let large = find("wide-bvh").filter(|_| self.exact.len() > MOST_FOR_BRUTE_FORCE);
        let entry = large.map_or_else(brute_force_entry, Ok)?;
        Oracle::over(prims, entry, &entry.params([])?, EDGE_ULPS)
    }
}
