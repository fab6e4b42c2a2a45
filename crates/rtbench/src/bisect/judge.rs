//! Whether a commit is slower than the good one: both programs and a copy in turns, judged as `check` judges.

use std::path::Path;

use crate::bisect::error::BisectError;
use crate::bisect::rows::Chosen;
use crate::gate::command::{CommandError, Commands};
use crate::gate::contest::{Pace, ROUNDS};
use crate::gate::thresholds::Thresholds;
use crate::gate::{Finding, GateError, Outcome, wall_clock};
use measurement::system::clock::Clock;
use measurement::system::progress::Progress;
use presentation::numbers::ratio;

/// How often uncertain times are measured again, each time with twice the rounds.
const TRIES: u32 = 3;

/// What a commit is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Verdict {
    /// Certainly not slower by more than the threshold.
    Good,
    /// Certainly slower by more than that, twice.
    Bad,
    /// Nothing is certain, or nothing could be measured.
    Skip,
}

impl Verdict {
    /// As printed.
    pub fn name(self) -> &'static str {
        match self {
            Self::Good => "good",
            Self::Bad => "bad",
            Self::Skip => "skipped",
        }
    }
}

/// What a commit is, and by what.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Judged {
    /// What it is.
    pub verdict: Verdict,
    /// The time that decides, with its ratio to the good commit's; or why there is none.
    pub why: String,
}

/// What all commits are judged by.
pub struct Judge<'a> {
    /// The program of the good commit.
    pub good: &'a Path,
    /// What is measured.
    pub chosen: &'a Chosen,
    /// What counts as slower.
    pub thresholds: Thresholds,
    /// Turns of the first try.
    pub rounds: Option<u32>,
    /// Seed of orders and intervals.
    pub seed: u64,
    /// What turns are timed by.
    pub clock: &'a dyn Clock,
}

impl Judge<'_> {
    /// Judges a program, which has a copy.
    ///
    /// # Errors
    /// [`BisectError`] where the good program fails; a program that is judged and fails is skipped.
    pub fn judge(
        &self,
        program: &Path,
        copy: &Path,
        progress: &Progress,
    ) -> Result<Judged, BisectError> {
        let mut judged = Judged { verdict: Verdict::Skip, why: String::new() };
        for attempt in 0..TRIES {
            let findings = match self.findings(program, copy, attempt, progress) {
                Ok(findings) => findings,
                // what is wrong with the good program is wrong with all
                Err(error) if error.program() == self.good => {
                    return Err(GateError::from(error).into());
                }
                Err(error) => return Ok(Judged { why: error.to_string(), ..judged }),
            };
            let Some(worst) = worst(&findings) else {
                return Ok(Judged { why: "it printed none of these times".into(), ..judged });
            };
            judged.why = in_words(worst);
            judged.verdict = match worst.outcome {
                Outcome::Regression => Verdict::Bad,
                Outcome::Improved | Outcome::Unchanged => Verdict::Good,
                // more of it would be judged no more
                Outcome::NotJudged | Outcome::WrongHits => return Ok(judged),
                Outcome::Inconclusive => continue,
            };
            return Ok(judged);
        }
        Ok(judged)
    }

    /// What is said of the times that decide; regressions are measured a second time.
    fn findings(
        &self,
        new: &Path,
        copy: &Path,
        attempt: u32,
        progress: &Progress,
    ) -> Result<Vec<Finding>, CommandError> {
        let arguments = self.chosen.arguments();
        let rounds = self.rounds.unwrap_or(ROUNDS) << attempt;
        let measured = |again: u64| {
            let seed = self.seed.wrapping_add(2 * u64::from(attempt) + again);
            let pace = Pace { rounds: Some(rounds), time_budget: None, seed };
            let commands = Commands { old: self.good, new, copy, arguments: &arguments, pace };
            let mut pairs = commands.times(self.clock, progress)?;
            pairs.retain(|pair| self.chosen.decides(&pair.key));
            Ok::<_, CommandError>(wall_clock::judge_times(&pairs, &self.thresholds, seed))
        };
        let mut findings = measured(0)?;
        if findings.iter().any(wall_clock::is_suspect) {
            wall_clock::confirm(&mut findings, &measured(1)?);
        }
        Ok(findings)
    }
}

/// The finding that decides: the worst outcome, and of those the largest ratio.
fn worst(findings: &[Finding]) -> Option<&Finding> {
    // what is too short to be judged says nothing beside what was judged
    let weight = |f: &Finding| match f.outcome {
        Outcome::NotJudged => 0,
        other => 1 + other as usize,
    };
    let change = |f: &Finding| f.change.map_or(0.0, |change| change.median);
    findings.iter().max_by(|a, b| {
        let by_outcome = weight(a).cmp(&weight(b));
        by_outcome.then(change(a).total_cmp(&change(b)))
    })
}

fn in_words(finding: &Finding) -> String {
    let Finding { scene, row, quantity, change, note, .. } = finding;
    let place = if scene.is_empty() { String::new() } else { format!("{scene}: ") };
    let what = if *quantity == "time" { row.clone() } else { format!("{row}, {quantity}") };
    match change {
        Some(change) => format!("{place}{what} {}", ratio(change).trim_end()),
        None => format!("{place}{what}: {note}"),
    }
}
