//! Finds the wrong answers of a batch, and those that differ only where rounding decides.
//!
//! What a structure answers with our primitive tests must be right to the last bit. One that comes
//! with a triangle test of its own (a plugin) may answer otherwise where a ray passes an edge,
//! where two surfaces meet, or where the interval of the ray ends. Each of its answers that differs
//! is therefore put before an [`EdgeJudge`](crate::answers::edges::EdgeJudge): it is *at an edge*
//! if moving the ray by [`EDGE_ULPS`](crate::answers::edges::EDGE_ULPS) ulps changes the
//! right answer, too, and if what it claims to hit is there. Anything else is wrong; and so are
//! answers at edges where they are more than rounding explains ([`MOST_AT_EDGES`]).

use accel_core::registry::Buildable;

use crate::answers::fault;
use crate::answers::oracle::Opinion;
use crate::answers::reference::{oracle_rays, oracle_sample};
use crate::rays::batches::{Answers, Batch, BatchSet};
use crate::rays::exactness::Exactness;
use crate::rounds::scope::Scope;

/// Largest part of answers whose hit is lost, invented or elsewhere at an edge that rounding
/// explains. A ray from a surface is moved through it, so that a structure that ignores `t_min` in
/// shadow rays is at edges everywhere.
pub const MOST_AT_EDGES: f64 = 0.02;
/// So many may always be there.
const FEW: usize = 16;

/// Answers that are put before the judge after the first wrong one; more are only counted.
const ENOUGH_WRONG: usize = 64;

/// How the answers to a batch compare.
#[derive(Debug, Default)]
pub struct BatchVerdict {
    pub compared: usize,
    /// Number of these answered wrongly.
    pub wrong: usize,
    /// Number of these that differ from the expected answer at an edge.
    pub edges: usize,
    /// The first wrong answer, in words.
    pub example: Option<String>,
}

/// Compares the answers to a batch of `set`: with those of the reference, or with the oracle where
/// it confirmed no reference.
pub fn judge<S: Buildable>(
    scope: &Scope<'_, '_, S>,
    set: &BatchSet<'_, S>,
    batch: &Batch<'_, S>,
    answers: &Answers<S>,
    exactness: Exactness,
) -> BatchVerdict {
    if !scope.is_confirmed {
        let (stage, plan) = (scope.stage, scope.plan);
        let count = oracle_rays(stage.geometry.len(), set.batches.len(), &plan.limits);
        let rays = batch.rays.len();
        let sample = oracle_sample(plan.seed, &stage.scene.name, batch.kind, rays, count);
        let tally = stage.oracle.check(batch.kind, &batch.rays, answers, &sample);
        let wrong = tally.wrong.len();
        return BatchVerdict { compared: tally.checked, wrong, edges: 0, example: tally.example };
    }
    let mut judged = BatchVerdict { compared: batch.rays.len(), ..BatchVerdict::default() };
    let (mut first, mut apart, mut first_apart) = (None, 0, None);
    for ray in batch.wrong(answers, exactness) {
        let opinion = match exactness {
            Exactness::OwnTest if judged.wrong < ENOUGH_WRONG => {
                opinion(scope, batch, answers, ray)
            }
            _ => None,
        };
        match opinion {
            Some(Opinion::Borderline) => {
                judged.edges += 1;
                if batch.is_apart(answers, ray) {
                    apart += 1;
                    first_apart.get_or_insert(ray);
                }
            }
            Some(Opinion::Right) => {}
            Some(Opinion::Wrong(_)) | None => {
                judged.wrong += 1;
                first.get_or_insert(ray);
            }
        }
    }
    if apart > FEW && apart as f64 > MOST_AT_EDGES * judged.compared as f64 {
        judged.edges -= apart;
        judged.wrong += apart;
        first = first.or(first_apart);
    }
    judged.example = first.map(|first| {
        let (kind, ray) = (batch.name(), first * set.stride);
        let (said, expected) = (answers.describe(first), batch.expected.describe(first));
        let example = format!("{kind} ray {ray}: {said}, expected {expected}");
        match (exactness, batch.rays.get(first)) {
            (Exactness::OwnTest | Exactness::OurTest, Some(ray)) => {
                let primitives = scope.stage.geometry.len();
                let fault = fault::name(ray, first, answers, &batch.expected, primitives);
                format!("{fault}: {example}")
            }
            _ => example,
        }
    });
    judged
}

/// Judgement of an answer by the f64 structure; `None` without one.
fn opinion<S: Buildable>(
    scope: &Scope<'_, '_, S>,
    batch: &Batch<'_, S>,
    answers: &Answers<S>,
    ray: usize,
) -> Option<Opinion> {
    scope.edges.opinion(batch.rays.get(ray)?, answers, ray)
}
