//! A line that names one trial: `G1 f32 seed=1 round=17 rays=500 ray=233 uniform-grid density=4`.

use std::fmt;

use super::round::MOST_RAYS;
use measurement::plan::error::PlanError;
use measurement::settings::Precision;
use measurement::settings::choice::Choice;

#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replay {
    pub case: String,
    pub precision: Precision,
    pub seed: u64,
    pub round: u64,
    /// Rays that the round was drawn with.
    pub rays: usize,
    /// Index of the ray, or of the trial of a part.
    pub ray: usize,
    pub subject: String,
}

impl fmt::Display for Replay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { case, seed, round, rays, ray, subject, .. } = self;
        let precision = self.precision.name();
        write!(f, "{case} {precision} seed={seed} round={round} rays={rays} ray={ray} {subject}")
    }
}

impl Replay {
    pub fn parse(line: &str) -> Result<Self, PlanError> {
        Self::read(line).ok_or_else(|| PlanError::Malformed {
            text: line.to_owned(),
            expected: "CASE f32|f64 seed=N round=N rays=N ray=N STRUCTURE [PARAM=VALUE ...]",
        })
    }

    fn read(line: &str) -> Option<Self> {
        let mut words = line.split_whitespace();
        let case = words.next()?.to_owned();
        let precision = Precision::typed(words.next()?)?;
        let mut number = |name: &str| -> Option<u64> {
            words.next()?.strip_prefix(name)?.strip_prefix('=')?.parse().ok()
        };
        let (seed, round) = (number("seed")?, number("round")?);
        let rays = usize::try_from(number("rays")?).ok().filter(|n| *n <= MOST_RAYS)?;
        let ray = usize::try_from(number("ray")?).ok()?;
        let subject = words.collect::<Vec<_>>().join(" ");
        (!subject.is_empty()).then_some(Self { case, precision, seed, round, rays, ray, subject })
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
