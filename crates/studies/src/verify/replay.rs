//! One trial that can be repeated: a ray of a round that a case draws, asked of a subject; and the
//! line that names it: `G1 f32 seed=1 round=17 rays=500 ray=233 uniform-grid density=4`.

use std::fmt;

use accel_core::Ray;
use accel_core::primitives::PrimitiveError;
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use measurement::plan::error::PlanError;
use measurement::settings::Precision;
use measurement::settings::choice::Choice;
use statistics::random::Random;

use super::catalogue::{Case, Draw, find};
use super::judge::{Judge, RoundVerdict};
use super::round::{MOST_RAYS, Round};
use super::subject::Subject;

/// What a round is drawn from: the same round for the same numbers.
#[derive(Debug, Clone, Copy)]
pub struct RoundSeed {
    pub case: &'static Case,
    pub precision: Precision,
    pub seed: u64,
    pub number: u64,
    /// Rays that are asked for.
    pub rays: usize,
}

impl RoundSeed {
    pub(super) fn drawn<S: Buildable>(&self, draw: Draw<S>) -> Result<Round<S>, PrimitiveError> {
        let purpose = format!("verify {} {}", self.case.id, self.number);
        draw(&mut Random::new(self.seed, &purpose), self.rays)
    }
}

#[derive(Debug, Clone)]
pub struct Replay {
    pub round: RoundSeed,
    /// Index of the ray.
    pub ray: usize,
    pub subject: String,
}

impl fmt::Display for Replay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { round: RoundSeed { case, precision, seed, number, rays }, ray, subject } = self;
        let (case, precision) = (case.id, precision.name());
        write!(f, "{case} {precision} seed={seed} round={number} rays={rays} ray={ray} {subject}")
    }
}

#[derive(Debug)]
pub struct ReplayOutcome {
    /// The ray and what was expected of it.
    pub question: String,
    /// Why the answer is wrong, or `None`.
    pub wrong: Option<String>,
    /// Why the scene was refused, if so.
    pub refused: Option<String>,
}

impl Replay {
    pub fn parse(line: &str) -> Result<Self, PlanError> {
        let malformed = || PlanError::Malformed {
            text: line.to_owned(),
            expected: "CASE f32|f64 seed=N round=N rays=N ray=N STRUCTURE [PARAM=VALUE ...]",
        };
        let mut words = line.split_whitespace();
        let (_, case) = find(words.next().ok_or_else(malformed)?)?;
        Self::read(case, words).ok_or_else(malformed)
    }

    fn read<'l>(case: &'static Case, mut words: impl Iterator<Item = &'l str>) -> Option<Self> {
        let precision = Precision::typed(words.next()?)?;
        let mut number = |name: &str| -> Option<u64> {
            words.next()?.strip_prefix(name)?.strip_prefix('=')?.parse().ok()
        };
        let (seed, round) = (number("seed")?, number("round")?);
        let rays = usize::try_from(number("rays")?).ok().filter(|n| *n <= MOST_RAYS)?;
        let ray = usize::try_from(number("ray")?).ok()?;
        let subject = words.collect::<Vec<_>>().join(" ");
        let round = RoundSeed { case, precision, seed, number: round, rays };
        (!subject.is_empty()).then_some(Self { round, ray, subject })
    }

    /// Asks the subject once more; `None` when the round has no such ray.
    pub fn repeat(&self, subject: &Subject<'_>) -> Result<Option<ReplayOutcome>, BuildError> {
        match self.round.precision {
            Precision::F32 => self.repeat_in(self.round.case.single, subject),
            Precision::F64 => self.repeat_in(self.round.case.double, subject),
        }
    }

    fn repeat_in<S: Buildable>(
        &self,
        draw: Draw<S>,
        subject: &Subject<'_>,
    ) -> Result<Option<ReplayOutcome>, BuildError> {
        let Ok(round) = self.round.drawn(draw) else { return Ok(None) };
        let (Some(ray), Some(expected)) = (round.rays.get(self.ray), round.expected.get(self.ray))
        else {
            return Ok(None);
        };
        let (wrong, refused) = match Judge::new(&round)?.judge(subject) {
            RoundVerdict::Asked(all, _) => {
                let of_ray = all.into_iter().find(|m| m.ray == self.ray && m.is_wrong);
                (of_ray.map(|m| m.what), None)
            }
            RoundVerdict::Refused(why) => (None, Some(why)),
            RoundVerdict::NotAsked => (None, Some("has no such primitives".to_owned())),
        };
        let Ray { origin, direction, t_min, t_max, .. } = ray;
        let question = format!(
            "ray from {origin:?} along {direction:?} in [{t_min:?}, {t_max:?}]\n\
             expected: {expected:?}"
        );
        Ok(Some(ReplayOutcome { question, wrong, refused }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_come_back_and_others_are_refused() {
        let line = "G1 f32 seed=1 round=17 rays=500 ray=233 uniform-grid density=4";
        assert_eq!(Replay::parse(line).unwrap().to_string(), line);
        for bad in [
            "",
            "G1 f16 seed=1 round=1 rays=1 ray=1 x",
            "G1 f32 seed=-1 round=1 rays=1 ray=1 x",
            "G1 f32 seed=1 round=1 rays=1 ray=1",
            "G1 f32 seed=1 round=1 ray=1 x",
        ] {
            assert!(matches!(Replay::parse(bad), Err(PlanError::Malformed { .. })), "{bad}");
        }
    }
}
