//! Compares the answers to a round: with its oracle, with brute force, among the ways to ask, and
//! with the twins.

use std::panic::{AssertUnwindSafe, catch_unwind};

use accel_core::structures::{BuildError, Buildable};
use accel_core::tracer::{ShadowCount, ShadowRule, Tracer};
use accel_core::{Hit, Ray, Scalar};

use super::round::Round;
use super::subject::{Subject, with_brute_force};

/// A wrong answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Mismatch {
    /// Index of the ray in the round.
    pub ray: usize,
    /// What was said and what is right.
    pub what: String,
}

/// What came of a round.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Judged {
    /// All rays were asked.
    Asked(Vec<Mismatch>),
    /// The scene was refused with a typed error.
    Refused(String),
    /// The question does not concern this subject.
    NotAsked,
}

/// The answers to all rays, asked in all ways.
#[derive(Debug, Clone)]
struct Answers<S: Scalar> {
    closest: Vec<Hit<S>>,
    counted: Vec<Hit<S>>,
    blocked: Vec<bool>,
    counted_blocked: Vec<bool>,
}

impl<S: Scalar> Answers<S> {
    fn of(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> Self {
        let nothing = vec![Hit::NONE; rays.len()];
        let (mut closest, mut counted) = (nothing.clone(), nothing);
        tracer.closest_hits(rays, &mut closest);
        tracer.count_closest_hits(rays, &mut counted);
        let mut blocked = vec![false; rays.len()];
        tracer.occlusions(rays, &mut blocked);
        let mut shadows = vec![ShadowCount::default(); rays.len()];
        tracer.count_occlusions(rays, ShadowRule::OpaqueBlocks, &mut shadows);
        let counted_blocked = shadows.iter().map(|s| s.blocked).collect();
        Self { closest, counted, blocked, counted_blocked }
    }
}

/// A round with the answers of brute force.
#[derive(Debug)]
pub struct Judge<'a, S: Scalar> {
    round: &'a Round<S>,
    reference: Answers<S>,
    twins: Vec<Vec<Hit<S>>>,
}

impl<'a, S: Buildable> Judge<'a, S> {
    /// Asks brute force.
    ///
    /// # Errors
    /// [`BuildError`] for a scene without primitives.
    pub fn new(round: &'a Round<S>) -> Result<Self, BuildError> {
        let reference = with_brute_force(round.model.prims(), |t| Answers::of(t, &round.rays))?;
        let twins = round.twins.iter().map(|twin| {
            let ask = |t: &dyn Tracer<S>| Answers::of(t, &twin.rays).closest;
            with_brute_force(twin.model.prims(), ask)
        });
        Ok(Self { round, reference, twins: twins.collect::<Result<_, _>>()? })
    }

    /// Asks a subject. A panic is a mismatch of the first ray.
    pub fn judge(&self, subject: &Subject<'_>) -> Judged {
        let ask = || match subject {
            Subject::Structure(_) => self.of_structure(subject),
            Subject::Control => self.of_control(subject),
        };
        let panicked = |_| Judged::Asked(vec![Mismatch { ray: 0, what: "panicked".into() }]);
        match catch_unwind(AssertUnwindSafe(ask)).unwrap_or_else(|e| Ok(panicked(e))) {
            Ok(judged) => judged,
            Err(error) => Judged::Refused(error.to_string()),
        }
    }

    fn of_structure(&self, subject: &Subject<'_>) -> Result<Judged, BuildError> {
        let ask = |tracer: &dyn Tracer<S>| Answers::of(tracer, &self.round.rays);
        let Some(answers) = subject.over(&self.round.model, ask)? else {
            return Ok(Judged::NotAsked);
        };
        let mut twins = Vec::new();
        for twin in &self.round.twins {
            let ask = |tracer: &dyn Tracer<S>| Answers::of(tracer, &twin.rays).closest;
            twins.extend(subject.over(&twin.model, ask)?);
        }
        let wrong = (0..self.round.rays.len()).filter_map(|ray| {
            let what =
                self.complaint(ray, &answers).or_else(|| self.of_twins(ray, &answers, &twins));
            what.map(|what| Mismatch { ray, what })
        });
        Ok(Judged::Asked(wrong.collect()))
    }

    /// Only the oracle judges the control: its answers are its own.
    fn of_control(&self, subject: &Subject<'_>) -> Result<Judged, BuildError> {
        let ask = |tracer: &dyn Tracer<S>| Answers::of(tracer, &self.round.rays).closest;
        let Some(hits) = subject.over(&self.round.model, ask)? else {
            return Ok(Judged::NotAsked);
        };
        let answers = self.round.expected.iter().zip(&hits).enumerate();
        let wrong = answers
            .filter(|(_, (expected, hit))| !expected.admits(hit))
            .map(|(ray, (expected, hit))| Mismatch { ray, what: unexpected(hit, expected) });
        Ok(Judged::Asked(wrong.collect()))
    }

    /// What is wrong with the answers to one ray.
    fn complaint(&self, ray: usize, answers: &Answers<S>) -> Option<String> {
        let (hit, right) = (answers.closest.get(ray)?, self.reference.closest.get(ray)?);
        let expected = self.round.expected.get(ray)?;
        if !expected.admits(hit) {
            return Some(unexpected(hit, expected));
        }
        if !is_same(hit, right) {
            return Some(format!("said {}, brute force {}", told(hit), told(right)));
        }
        let counted = answers.counted.get(ray)?;
        if !is_same(hit, counted) {
            return Some(format!("said {}, when counting {}", told(hit), told(counted)));
        }
        let blocked = *self.reference.blocked.get(ray)?;
        let said = [*answers.blocked.get(ray)?, *answers.counted_blocked.get(ray)?];
        (said != [blocked; 2]).then(|| format!("blocked: said {said:?}, brute force {blocked}"))
    }

    /// What is wrong with the answers of the twins to one ray. Where renumbering changed which of
    /// two equal hits has the lowest id, brute force says which id is right.
    fn of_twins(&self, ray: usize, answers: &Answers<S>, twins: &[Vec<Hit<S>>]) -> Option<String> {
        let hit = answers.closest.get(ray)?;
        let both = twins.iter().zip(&self.twins).zip(&self.round.twins);
        both.into_iter().find_map(|((said, right), twin)| {
            let (said, right) = (said.get(ray)?, right.get(ray)?);
            let back = twin.told_back(*said);
            let is_right = is_same_parameter(&back, hit) && said.id == right.id;
            (!is_right).then(|| {
                format!(
                    "said {}, {} {}, brute force {}",
                    told(hit),
                    twin.name,
                    told(&back),
                    told(&twin.told_back(*right))
                )
            })
        })
    }
}

/// Same primitive, same bits of t (but for the sign of zero).
fn is_same<S: Scalar>(a: &Hit<S>, b: &Hit<S>) -> bool {
    a.id == b.id && is_same_parameter(a, b)
}

fn is_same_parameter<S: Scalar>(a: &Hit<S>, b: &Hit<S>) -> bool {
    a.is_hit() == b.is_hit() && (!a.is_hit() || a.t == b.t)
}

fn unexpected<S: Scalar>(hit: &Hit<S>, expected: &super::round::Expected) -> String {
    format!("said {}, the oracle {expected:?}", told(hit))
}

fn told<S: Scalar>(hit: &Hit<S>) -> String {
    if hit.is_hit() { format!("{} at {:?}", hit.id, hit.t.to_f64()) } else { "miss".into() }
}
