//! All cases against all subjects.

use accel_core::Ray;
use accel_core::structures::{BuildError, Buildable};
use rayon::prelude::*;

use super::judge::{Judge, Judged, Mismatch};
use super::registry::{Draw, Listed};
use super::replay::Replay;
use super::report::{Line, Tally};
use super::round::{Expected, RAYS_A_ROUND, Round};
use super::subject::Subject;
use crate::args::Precision;
use crate::random::Random;

/// Both precisions.
pub const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];

/// What to check.
#[derive(Debug)]
pub struct Plan<'r> {
    /// The cases.
    pub cases: Vec<Listed>,
    /// Who is asked.
    pub subjects: Vec<Subject<'r>>,
    /// Rays a case and precision.
    pub rays: usize,
    /// Seed.
    pub seed: u64,
}

impl Plan<'_> {
    /// Rounds a case and precision.
    fn rounds(&self) -> u64 {
        self.rays.div_ceil(RAYS_A_ROUND) as u64
    }

    /// Checks a case in a precision: a line for each subject. Runs in the current rayon pool; the
    /// outcome does not depend on the number of threads.
    pub fn check(&self, (group, case): Listed, precision: Precision) -> Vec<Line> {
        let tallies = (0..self.rounds())
            .into_par_iter()
            .map(|number| match precision {
                Precision::F32 => self.round(case.id, case.single, number),
                Precision::F64 => self.round(case.id, case.double, number),
            })
            .reduce(|| vec![Tally::default(); self.subjects.len()], added);
        let told = |(tally, subject): (Tally, &Subject<'_>)| {
            let replay = |round, ray| Replay {
                case: case.id.to_owned(),
                precision,
                seed: self.seed,
                round,
                ray,
                subject: subject.label(),
            };
            Line::new(group.name, case.id, precision, subject, &tally, replay)
        };
        tallies.into_iter().zip(&self.subjects).map(told).collect()
    }

    /// One round against all subjects.
    fn round<S: Buildable>(&self, id: &str, draw: Draw<S>, number: u64) -> Vec<Tally> {
        let failed = |what: String| {
            self.subjects.iter().map(|_| Tally::refused(number, what.clone())).collect()
        };
        let mut round = match drawn(id, draw, self.seed, number) {
            Ok(round) => round,
            Err(error) => return failed(error),
        };
        let left = self.rays.saturating_sub(number as usize * RAYS_A_ROUND);
        round.truncate(left);
        match Judge::new(&round) {
            Ok(judge) => {
                let judged = |s| Tally::of(number, round.rays.len(), judge.judge(s));
                self.subjects.iter().map(judged).collect()
            }
            Err(error) => failed(error.to_string()),
        }
    }
}

/// The tallies of two sets of rounds.
fn added(mut all: Vec<Tally>, more: Vec<Tally>) -> Vec<Tally> {
    for (tally, more) in all.iter_mut().zip(more) {
        tally.add(more);
    }
    all
}

/// The round of that number.
fn drawn<S: Buildable>(
    id: &str,
    draw: Draw<S>,
    seed: u64,
    number: u64,
) -> Result<Round<S>, String> {
    draw(&mut Random::new(seed, &format!("verify {id} {number}"))).map_err(|e| e.to_string())
}

/// What came of one trial.
#[derive(Debug)]
pub struct Replayed {
    /// The ray.
    pub ray: String,
    /// What was expected of it.
    pub expected: Expected,
    /// Why the answer is wrong, or `None`.
    pub wrong: Option<String>,
    /// Why the scene was refused, if so.
    pub refused: Option<String>,
}

/// Repeats one trial; `None` when its round has no such ray.
///
/// # Errors
/// [`BuildError`] when brute force refuses the scene.
pub fn replay<S: Buildable>(
    replay: &Replay,
    draw: Draw<S>,
    subject: &Subject<'_>,
) -> Result<Option<Replayed>, BuildError> {
    let id = super::registry::find(&replay.case).map_or(replay.case.as_str(), |(_, c)| c.id);
    let Ok(round) = drawn(id, draw, replay.seed, replay.round) else { return Ok(None) };
    let (Some(ray), Some(expected)) = (round.rays.get(replay.ray), round.expected.get(replay.ray))
    else {
        return Ok(None);
    };
    let (wrong, refused) = match Judge::new(&round)?.judge(subject) {
        Judged::Asked(all) => (of_ray(all, replay.ray), None),
        Judged::Refused(why) => (None, Some(why)),
        Judged::NotAsked => (None, Some("has no such primitives".to_owned())),
    };
    Ok(Some(Replayed { ray: told(ray), expected: expected.clone(), wrong, refused }))
}

fn of_ray(all: Vec<Mismatch>, ray: usize) -> Option<String> {
    all.into_iter().find(|m| m.ray == ray).map(|m| m.what)
}

fn told<S: Buildable>(ray: &Ray<S>) -> String {
    let Ray { origin, direction, t_min, t_max, .. } = ray;
    format!("from {origin:?} along {direction:?} in [{t_min:?}, {t_max:?}]")
}
