//! Timing the variants of an axis: interleaved rounds in seeded order, as rows of a run are.

use crate::accuracy::audit;
use crate::accuracy::error_of::ErrorOf;
use crate::accuracy::pareto::{self, Place};
use crate::accuracy::record::{SceneOutcome, Standing, VariantRecord};
use crate::accuracy::stage::Stage;
use crate::accuracy::work::Work;
use crate::image_error::TIMES_REFERENCE;
use measurement::rounds::interleaved::{Visit, interleaved};
use statistics::estimate::{Estimate, estimate, median};

/// A variant, judged and ready to be timed.
pub struct Variant<'a> {
    /// Name in tables.
    pub name: String,
    /// How to have it without this command.
    pub setting: String,
    /// What is wrong with it by design.
    pub known_defect: Option<&'static str>,
    /// Whether all others are held against it.
    pub is_reference: bool,
    /// How wrong it is.
    pub error: ErrorOf,
    /// More of it, by name.
    pub also: Vec<(&'static str, f64)>,
    /// What is timed.
    pub work: Box<dyn Work + 'a>,
}

/// What an axis says of a scene beside its variants.
#[derive(Debug, Clone, Default)]
pub struct Said {
    /// What is timed, in words.
    pub timed: String,
    /// What was judged, in words.
    pub judged: String,
    /// The reference's own error; 0 where it is exact.
    pub reference_error: f64,
    /// What an axis found that cannot be.
    pub faults: Vec<String>,
}

/// Seconds of a timed pass, about: shorter work is repeated within it.
const PASS: f64 = 0.004;

fn repeats(seconds: f64) -> u32 {
    (PASS / seconds.max(1e-7)).ceil().clamp(1.0, 1000.0) as u32
}

/// Times the variants and says where each stands.
pub fn timed(stage: &Stage<'_>, said: Said, mut variants: Vec<Variant<'_>>) -> SceneOutcome {
    let mut faults = said.faults;
    let mut seconds: Vec<Vec<f64>> = vec![Vec::new(); variants.len()];
    // the first run of each, which warms up, gives the answers that all others must repeat
    let mut first = Vec::with_capacity(variants.len());
    for variant in &mut variants {
        variant.work.prepare();
        variant.work.run();
        let answers = variant.work.fingerprint();
        let start = stage.clock.now();
        variant.work.run();
        first.push((answers, repeats(stage.clock.seconds_since(start))));
    }
    let purpose = format!("{}/{}", stage.axis, stage.name);
    let is_left = |round| round < stage.rounds;
    interleaved(variants.len(), stage.seed, &purpose, is_left, |Visit { row, .. }| {
        let (Some(variant), Some(of)) = (variants.get_mut(row), seconds.get_mut(row)) else {
            return;
        };
        let (expected, repeats) = first.get(row).copied().unwrap_or((0, 1));
        variant.work.prepare();
        let start = stage.clock.now();
        (0..repeats).for_each(|_| variant.work.run());
        of.push(stage.clock.seconds_since(start) / f64::from(repeats));
        let timed = variant.work.fingerprint();
        let fault = audit::inconsistency(&variant.name, expected, timed);
        faults.extend(fault.filter(|f| !faults.contains(f)));
    });
    let rows = rows(variants, seconds, said.reference_error, stage.seed);
    let mut outcome = SceneOutcome {
        scene: stage.name.to_owned(),
        timed: said.timed,
        judged: said.judged,
        reference_error: said.reference_error,
        rows,
        faults,
    };
    let found = audit::faults(&outcome);
    outcome.faults.extend(found);
    outcome
}

/// One's time over another's, round by round.
pub fn ratios(seconds: &[f64], other: &[f64]) -> Vec<f64> {
    let pairs = seconds.iter().zip(other).filter(|(_, other)| **other > 0.0);
    pairs.map(|(s, other)| s / other).collect()
}

/// Which variant is the cheapest: none takes less than it in the middle of the rounds that both were
/// in. (Medians of times of their own would compare different rounds.)
fn cheapest(seconds: &[Vec<f64>]) -> usize {
    let mut least = 0;
    for i in 1..seconds.len() {
        if let (Some(own), Some(best)) = (seconds.get(i), seconds.get(least))
            && median(&ratios(own, best)).is_some_and(|ratio| ratio < 1.0)
        {
            least = i;
        }
    }
    least
}

fn rows(
    variants: Vec<Variant<'_>>,
    seconds: Vec<Vec<f64>>,
    reference_error: f64,
    seed: u64,
) -> Vec<VariantRecord> {
    const NO_TIME: Estimate = Estimate { median: f64::NAN, low: f64::NAN, high: f64::NAN };
    let times: Vec<Estimate> =
        seconds.iter().map(|s| estimate(s, seed).unwrap_or(NO_TIME)).collect();
    let cheapest = seconds.get(cheapest(&seconds)).cloned().unwrap_or_default();
    let record = |((variant, seconds), time_s): ((Variant<'_>, Vec<f64>), Estimate)| {
        let ratios = ratios(&seconds, &cheapest);
        let is_below_reference = variant.error.value() < TIMES_REFERENCE * reference_error;
        VariantRecord {
            variant: variant.name,
            setting: variant.setting,
            known_defect: variant.known_defect.map(Into::into),
            is_reference: variant.is_reference,
            error: variant.error,
            is_below_reference,
            seconds,
            time_s,
            ratio: estimate(&ratios, seed).unwrap_or(NO_TIME),
            standing: Standing::Dominated,
            also: variant.also.into_iter().map(|(name, x)| (name.to_owned(), x)).collect(),
        }
    };
    let mut rows: Vec<VariantRecord> =
        variants.into_iter().zip(seconds).zip(times).map(record).collect();
    let places: Vec<Place> = rows.iter().map(|row| Place::of(row, reference_error)).collect();
    for (row, standing) in rows.iter_mut().zip(pareto::standings(&places)) {
        row.standing = standing;
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cheapest_is_found_round_by_round() {
        // a machine that slows down: the second is faster in each round, the third never
        let seconds = [vec![2.0, 4.0, 8.0], vec![1.0, 3.9, 7.0], vec![2.5, 4.5, 6.9]];
        assert_eq!(cheapest(&seconds), 1);
        assert_eq!(ratios(&seconds[0], &seconds[1])[0], 2.0);
        assert_eq!(ratios(&[1.0], &[0.0]).len(), 0);
        assert_eq!((repeats(1.0), repeats(0.001), repeats(0.0)), (1, 4, 1000));
    }
}
