//! Compares the answers to a round: with its oracle, with brute force, among the ways to ask, and
//! with the pairs.

use std::panic::{AssertUnwindSafe, catch_unwind};

use accel_core::occluders::OccluderRegistry;
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::{Hit, MISS, Ray, Scalar};
use renderer::Geometry;

use super::answers::{Answers, Digest, Repeated, closest};
use super::mismatch::OwnTestJudge;
pub use super::mismatch::{Difference, Mismatch};
use super::round::{Invariant, MetamorphicPair, OracleAnswer, Round, corners_of, model_of};
use super::subject::{Subject, with_brute_force};
use measurement::plan::rows::Row;
use measurement::rays::exactness::Exactness;

#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RoundVerdict {
    /// All rays were asked: what differs, and what stands for all answers.
    Asked(Vec<Mismatch>, Digest),
    /// The scene was refused with a typed error.
    Refused(String),
    /// The question does not concern this subject.
    NotAsked,
}

/// A round with the answers of brute force.
pub struct Judge<'a, S: Buildable> {
    round: &'a Round<S>,
    reference: Answers<S>,
    pairs: Vec<Vec<Hit<S>>>,
}

impl<'a, S: Buildable> Judge<'a, S> {
    pub fn new(round: &'a Round<S>) -> Result<Self, BuildError> {
        let reference = if round.near.is_empty() {
            with_brute_force(round.model.prims(), |t| Answers::of(t, &round.rays))?
        } else {
            Answers::near(&round.model, &round.rays, &round.near)
        };
        let of_pair = |pair: &MetamorphicPair<S>| {
            with_brute_force(pair.model.prims(), |t| closest(t, &pair.rays))
        };
        let pairs = round.pairs.iter().map(of_pair).collect::<Result<_, _>>()?;
        Ok(Self { round, reference, pairs })
    }

    /// The answers of brute force in f64: hits, and which of them are blocked.
    pub(super) fn right(self) -> (Vec<Hit<f64>>, Vec<bool>) {
        let Answers { closest, blocked, .. } = self.reference;
        (closest.iter().map(|hit| Hit { t: hit.t.to_f64(), id: hit.id }).collect(), blocked)
    }

    /// Asks a subject. A panic, or the end of a plugin's process, is a mismatch of the first ray.
    pub fn judge(&self, subject: &Subject<'_>) -> RoundVerdict {
        let ask = || match subject {
            Subject::Structure(_) => self.of_structure(subject),
            Subject::Control => self.of_control(subject),
            Subject::Occluder(row) => self.of_occluder(row),
        };
        let ended =
            |how| RoundVerdict::Asked(vec![Mismatch::wrong(0, None, how)], Digest::default());
        match catch_unwind(AssertUnwindSafe(ask)).unwrap_or_else(|_| Ok(ended("panicked".into()))) {
            Ok(judged) => judged,
            Err(BuildError::Died(how)) => ended(how),
            Err(error) => RoundVerdict::Refused(error.to_string()),
        }
    }

    fn of_structure(&self, subject: &Subject<'_>) -> Result<RoundVerdict, BuildError> {
        if subject.is_reference() {
            return Ok(self.judged(&self.reference, &self.pairs));
        }
        let mut judged = RoundVerdict::NotAsked;
        for threads in self.round.threads {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(*threads).build();
            judged = match pool {
                Ok(pool) => pool.install(|| self.of_built(subject))?,
                Err(_) => self.of_built(subject)?,
            };
            if !matches!(&judged, RoundVerdict::Asked(wrong, _) if wrong.is_empty()) {
                return Ok(judged);
            }
        }
        if self.round.threads.is_empty() { self.of_built(subject) } else { Ok(judged) }
    }

    /// Verdict on a structure that is built, or updated from the previous frame.
    fn of_built(&self, subject: &Subject<'_>) -> Result<RoundVerdict, BuildError> {
        let ask = |tracer: &dyn Tracer<S>| {
            let exactness = Exactness::of(tracer.foreign(), tracer.batches());
            let answers = Answers::of(tracer, &self.round.rays);
            (exactness, answers, tracer.foreign().and_then(|foreign| foreign.failure()))
        };
        let model = &self.round.model;
        let asked = match &self.round.before {
            Some(before) => subject.taken_over(before, model, ask)?,
            None => subject.over(model, ask)?,
        };
        let Some((exactness, answers, failure)) = asked else { return Ok(RoundVerdict::NotAsked) };
        if let Some(how) = failure {
            return Err(BuildError::Died(how));
        }
        let mut pairs = Vec::new();
        for pair in &self.round.pairs {
            pairs.extend(subject.over(&pair.model, |t| closest(t, &pair.rays))?);
        }
        if exactness.has_own_test()
            && let Some(judged) = self.by_oracle(&answers, &pairs)
        {
            return Ok(judged);
        }
        Ok(self.judged(&answers, &pairs))
    }

    /// Shadow rays alone: asked together, each alone, and counted.
    fn of_occluder(&self, row: &Row<'_, OccluderRegistry>) -> Result<RoundVerdict, BuildError> {
        let Round { model, rays, lights, light_of, .. } = self.round;
        let occluder = row.entry.build(model.prims(), lights, &row.params)?;
        // what is not written is wrong
        let unwritten: Vec<bool> = self.reference.blocked.iter().map(|blocked| !blocked).collect();
        let (mut together, mut counted) = (unwritten.clone(), unwritten.clone());
        let mut alone = unwritten;
        occluder.occlusions(rays, light_of, &mut together);
        occluder.count_occlusions(rays, light_of, &mut counted);
        let each = rays.chunks(1).zip(light_of.chunks(1)).zip(alone.chunks_mut(1));
        each.for_each(|((ray, light), blocked)| occluder.occlusions(ray, light, blocked));
        let mut digest = Digest::default();
        together.iter().for_each(|blocked| digest.blocked(*blocked));
        let complaint = |ray: usize| {
            let right = *self.round.blocked.get(ray)?;
            let all = [("", &together), (" alone", &alone), (" when counting", &counted)];
            let (how, _) = all.into_iter().find(|(_, said)| said.get(ray) != Some(&right))?;
            let what = format!("blocked{how}: said {}, the oracle {right}", !right);
            Some(Mismatch::wrong(ray, None, what))
        };
        Ok(RoundVerdict::Asked((0..rays.len()).filter_map(complaint).collect(), digest))
    }

    /// Judges answers by another primitive test than ours; none where there are no exact triangles.
    fn by_oracle(&self, answers: &Answers<S>, pairs: &[Vec<Hit<S>>]) -> Option<RoundVerdict> {
        let exact = |model: &Geometry<S>| model_of::<f64>(&corners_of(model)?).ok();
        let model = exact(&self.round.model)?;
        let judge = OwnTestJudge::new(&model);
        let of_pairs: Option<Vec<Geometry<f64>>> =
            self.round.pairs.iter().map(|pair| exact(&pair.model)).collect();
        let of_pairs = of_pairs?;
        let pair_judges: Vec<_> = of_pairs.iter().map(OwnTestJudge::new).collect();
        let different = |(i, ray): (usize, &Ray<S>)| {
            let (right, blocked) =
                (self.reference.closest.get(i)?, *self.reference.blocked.get(i)?);
            let hits = answers.hits_of(i).filter_map(|said| {
                let found = judge.hit(ray, &said, right)?;
                Some((found, format!("said {}, brute force {}", told(&said), told(right))))
            });
            let occlusions = answers.occlusions_of(i).filter_map(|said| {
                let found = judge.occlusion(ray, said, blocked)?;
                Some((found, format!("blocked: said {said}, brute force {blocked}")))
            });
            let paired =
                pair_judges.iter().zip(&self.round.pairs).zip(pairs.iter().zip(&self.pairs));
            let paired = paired.filter_map(|((judge, pair), (said, right))| {
                let (ray, said, right) = (pair.rays.get(i)?, said.get(i)?, right.get(i)?);
                let (found, name) = (judge.hit(ray, said, right)?, &pair.name);
                Some((found, format!("{name}: said {}, brute force {}", told(said), told(right))))
            });
            let all = hits.chain(occlusions).chain(paired);
            let ((difference, is_wrong), words) = all.max_by_key(|((_, is_wrong), _)| *is_wrong)?;
            let what = if is_wrong { words } else { String::new() };
            Some(Mismatch { ray: i, difference: Some(difference), is_wrong, what })
        };
        let different = self.round.rays.iter().enumerate().filter_map(different).collect();
        Some(RoundVerdict::Asked(different, self.digest(answers, pairs)))
    }

    /// Stands for all answers.
    fn digest(&self, answers: &Answers<S>, pairs: &[Vec<Hit<S>>]) -> Digest {
        let mut digest = answers.digest();
        pairs.iter().flatten().for_each(|hit| digest.hit(hit));
        digest
    }

    fn judged(&self, answers: &Answers<S>, pairs: &[Vec<Hit<S>>]) -> RoundVerdict {
        let complaint = |ray| {
            let what = self.complaint(ray, answers);
            let what = what.or_else(|| self.of_pairs(ray, answers, pairs))?;
            Some(Mismatch::wrong(ray, self.difference(ray, answers), what))
        };
        let wrong = (0..self.round.rays.len()).filter_map(complaint).collect();
        RoundVerdict::Asked(wrong, self.digest(answers, pairs))
    }

    /// How the answers to a ray differ from those of brute force; none where only the oracle or a
    /// pair finds fault with them.
    fn difference(&self, ray: usize, answers: &Answers<S>) -> Option<Difference> {
        let right = self.reference.closest.get(ray)?;
        let blocked = *self.reference.blocked.get(ray)?;
        let hit = answers.hits_of(ray).find(|hit| !is_same(hit, right));
        let of_hit = hit.map(|hit| Difference::of_hits(&self.round.rays[ray], &hit, right));
        let said = answers.occlusions_of(ray).find(|said| *said != blocked);
        of_hit.or_else(|| said.map(Difference::of_occlusion))
    }

    /// Only the oracle judges the control: its answers are its own.
    fn of_control(&self, subject: &Subject<'_>) -> Result<RoundVerdict, BuildError> {
        let ask = |tracer: &dyn Tracer<S>| closest(tracer, &self.round.rays);
        let Some(hits) = subject.over(&self.round.model, ask)? else {
            return Ok(RoundVerdict::NotAsked);
        };
        let answers = self.round.expected.iter().zip(&hits).enumerate();
        let wrong = answers
            .filter(|(_, (expected, hit))| !expected.admits(hit))
            .map(|(ray, (expected, hit))| Mismatch::wrong(ray, None, unexpected(hit, expected)));
        let mut digest = Digest::default();
        hits.iter().for_each(|hit| digest.hit(hit));
        Ok(RoundVerdict::Asked(wrong.collect(), digest))
    }

    /// Fault of the answers to one ray, if any.
    fn complaint(&self, ray: usize, answers: &Answers<S>) -> Option<String> {
        let (hit, right) = (answers.closest.get(ray)?, self.reference.closest.get(ray)?);
        let expected = self.round.expected.get(ray)?;
        if !expected.admits(hit) {
            return Some(unexpected(hit, expected));
        }
        if !is_same(hit, right) {
            return Some(format!("said {}, brute force {}", told(hit), told(right)));
        }
        let blocked = *self.reference.blocked.get(ray)?;
        let said = *answers.blocked.get(ray)?;
        if said != blocked {
            return Some(format!("blocked: said {said}, brute force {blocked}"));
        }
        if let Some(right) = self.round.blocked.get(ray)
            && said != *right
        {
            return Some(format!("blocked: said {said}, the oracle {right}"));
        }
        let other_hit = |(again, i): (&Repeated<S>, usize)| {
            let other = again.closest.get(i).filter(|other| !is_same(hit, other))?;
            Some(format!("said {}, {} {}", told(hit), again.how, told(other)))
        };
        let other_occlusion = |(again, i): (&Repeated<S>, usize)| {
            let (how, said) = (again.how, again.blocked.get(i).filter(|said| **said != blocked)?);
            Some(format!("any-hit differs {how}: blocked {said}, expected {blocked}"))
        };
        let other_hit = answers.again(ray).find_map(other_hit);
        other_hit.or_else(|| answers.again(ray).find_map(other_occlusion))
    }

    /// Fault of the pairs' answers to one ray, if any.
    fn of_pairs(&self, ray: usize, answers: &Answers<S>, pairs: &[Vec<Hit<S>>]) -> Option<String> {
        let hit = answers.closest.get(ray)?;
        let both = pairs.iter().zip(&self.pairs).zip(&self.round.pairs);
        both.into_iter().find_map(|((said, right), pair)| {
            let (said, right) = (said.get(ray)?, right.get(ray)?);
            let expected = self.round.expected.get(ray)?;
            let is_right = said.id == right.id && is_kept(pair, hit, said, expected);
            (!is_right).then(|| {
                let [said, right] = [said, right].map(|hit| told(&pair.told_back(*hit)));
                format!("said {}, {} {said}, brute force {right}", told(hit), pair.name)
            })
        })
    }
}

/// Returns whether the answer to the pair is that to the round. Where renumbering changed which of
/// two equal hits has the lowest id, only brute force knows which is right.
fn is_kept<S: Buildable>(
    pair: &MetamorphicPair<S>,
    hit: &Hit<S>,
    said: &Hit<S>,
    expected: &OracleAnswer,
) -> bool {
    match (pair.same, expected) {
        (Invariant::Bits, _) => {
            is_same_parameter(&pair.told_back(*said), hit)
                && (!pair.ids.is_empty() || said.id == hit.id)
        }
        (Invariant::Ids, OracleAnswer::Hit { id: Some(id), .. }) => said.id == *id,
        (Invariant::Ids, OracleAnswer::Hit { .. }) => said.is_hit(),
        (Invariant::Ids, OracleAnswer::Miss) => !said.is_hit(),
        (Invariant::Ids, OracleAnswer::Anything | OracleAnswer::Broken(_)) => true,
    }
}

/// Same primitive, same bits of t (but for the sign of zero).
fn is_same<S: Scalar>(a: &Hit<S>, b: &Hit<S>) -> bool {
    a.id == b.id && is_same_parameter(a, b)
}

fn is_same_parameter<S: Scalar>(a: &Hit<S>, b: &Hit<S>) -> bool {
    a.is_hit() == b.is_hit() && (!a.is_hit() || a.t == b.t)
}

fn unexpected<S: Scalar>(hit: &Hit<S>, expected: &OracleAnswer) -> String {
    format!("said {}, the oracle {expected:?}", told(hit))
}

fn told<S: Scalar>(hit: &Hit<S>) -> String {
    // as in `unwritten`
    if hit.id == MISS - 1 && hit.t.to_f64().is_nan() {
        return "nothing (no answer written)".into();
    }
    if hit.is_hit() { format!("{} at {:?}", hit.id, hit.t.to_f64()) } else { "miss".into() }
}
