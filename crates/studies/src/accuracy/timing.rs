//! Timing the variants of an axis: interleaved rounds in seeded order, as rows of a run are.

use crate::accuracy::audit;
use crate::accuracy::pareto::{self, FrontPoint};
use crate::accuracy::record::{ErrorOf, PartTime, SceneOutcome, VariantRecord, VariantStanding};
use crate::accuracy::stage::{Limits, Stage, StagedStructure, Work};
use crate::image_error::TIMES_REFERENCE;
use measurement::rounds::interleaved::{Visit, interleaved};
use measurement::system::clock::{self, Clock};
use statistics::estimate::Estimate;

/// A variant, judged and ready to be timed.
pub struct Variant<'a> {
    pub name: String,
    /// How to have it without this command.
    pub setting: String,
    /// Known defect, by design.
    pub known_defect: Option<&'static str>,
    /// True if all others are compared with it.
    pub is_reference: bool,
    /// How wrong it is.
    pub error: ErrorOf,
    /// More of it, by name.
    pub also: Vec<(&'static str, f64)>,
    pub work: Box<dyn Work + 'a>,
    pub is_without: bool,
}

impl<'a> Variant<'a> {
    /// A variant that is set otherwise than by a structure's parameters.
    pub fn new(
        name: impl Into<String>,
        setting: impl Into<String>,
        error: ErrorOf,
        work: impl Work + 'a,
    ) -> Self {
        Self {
            name: name.into(),
            setting: setting.into(),
            known_defect: None,
            is_reference: false,
            error,
            also: Vec::new(),
            work: Box::new(work),
            is_without: false,
        }
    }

    /// A structure with settings of its own.
    pub fn built(
        name: impl Into<String>,
        built: &StagedStructure<'_>,
        error: ErrorOf,
        work: impl Work + 'a,
    ) -> Self {
        let known_defect = built.known_defect;
        Self { known_defect, ..Self::new(name, built.setting(), error, work) }
    }
}

/// Seconds of a timed pass, about: shorter work is repeated within it.
const PASS: f64 = 0.004;

fn repeats(seconds: f64) -> u32 {
    (PASS / seconds.max(1e-7)).ceil().clamp(1.0, 1000.0) as u32
}

/// Times the variants and says where each stands. `outcome` has what the axis found beside them.
pub fn timed<'v>(
    stage: &Stage<'_>,
    mut outcome: SceneOutcome,
    variants: impl IntoIterator<Item = Variant<'v>>,
) -> SceneOutcome {
    let mut variants: Vec<Variant<'v>> = variants.into_iter().collect();
    let faults = &mut outcome.faults;
    let mut seconds: Vec<Vec<f64>> = vec![Vec::new(); variants.len()];
    let mut parts: Vec<Parts> = variants.iter().map(|v| Parts::of(&*v.work)).collect();
    // the first run of each, which warms up, gives the answers that all others must repeat
    let mut first = Vec::with_capacity(variants.len());
    for variant in &mut variants {
        variant.work.prepare();
        variant.work.run();
        let answers = variant.work.fingerprint();
        let ((), seconds) = clock::timed(stage.clock, || variant.work.run());
        first.push((answers, repeats(seconds)));
    }
    let purpose = format!("{}/{}", stage.axis, stage.name);
    let Limits { rounds, seed, .. } = stage.limits;
    let is_left = |round| round < rounds;
    interleaved(0, variants.len(), seed, &purpose, is_left, |Visit { row, .. }| {
        let (Some(variant), Some(of)) = (variants.get_mut(row), seconds.get_mut(row)) else {
            return;
        };
        let (expected, repeats) = first.get(row).copied().unwrap_or((0, 1));
        variant.work.prepare();
        let Some(parts) = parts.get_mut(row) else { return };
        of.push(parts.timed(stage.clock, repeats, &mut *variant.work));
        let timed = variant.work.fingerprint();
        let fault = audit::inconsistency(&variant.name, expected, timed);
        faults.extend(fault.filter(|f| !faults.contains(f)));
    });
    let timed = variants.into_iter().zip(seconds).zip(parts);
    let rows = timed.map(|((variant, s), parts)| row(variant, s, parts, outcome.reference_error));
    outcome.rows = rows.collect();
    stage.name.clone_into(&mut outcome.scene);
    figure(&mut outcome, stage.limits.seed);
    let found = audit::faults(&outcome);
    outcome.faults.extend(found);
    outcome
}

/// The parts of a variant's work, and seconds of each by round.
struct Parts {
    names: Vec<&'static str>,
    seconds: Vec<Vec<f64>>,
}

impl Parts {
    fn of(work: &dyn Work) -> Self {
        let names = work.parts().to_vec();
        Self { seconds: vec![Vec::new(); names.len()], names }
    }

    /// Seconds of the work, made so many times; those of its parts are kept.
    fn timed(&mut self, clock: &dyn Clock, repeats: u32, work: &mut dyn Work) -> f64 {
        let timed = |work: &mut dyn Work, run: &dyn Fn(&mut dyn Work)| {
            let ((), seconds) = clock::timed(clock, || (0..repeats).for_each(|_| run(work)));
            seconds / f64::from(repeats)
        };
        if self.names.is_empty() {
            return timed(work, &|work| work.run());
        }
        let mut sum = 0.0;
        for (part, of) in self.seconds.iter_mut().enumerate() {
            let seconds = timed(work, &|work| work.run_part(part));
            of.push(seconds);
            sum += seconds;
        }
        sum
    }
}

/// Cheapest variant from `first` on, by the median over common rounds. (Separate medians would
/// compare different rounds.)
fn cheapest(outcome: &SceneOutcome, first: usize) -> usize {
    let mut least = first;
    for (i, row) in outcome.rows.iter().enumerate().skip(first + 1) {
        if let Some(best) = outcome.rows.get(least)
            && outcome.ratios(&row.seconds, &best.seconds).middle().is_some_and(|ratio| ratio < 1.0)
        {
            least = i;
        }
    }
    least
}

const NO_TIME: Estimate = Estimate { median: f64::NAN, low: f64::NAN, high: f64::NAN };

/// Record of a variant before [`figure`] evaluates its times.
fn row(variant: Variant<'_>, seconds: Vec<f64>, parts: Parts, own_error: f64) -> VariantRecord {
    let is_below_reference = variant.error.value() < TIMES_REFERENCE * own_error;
    let part = |(part, seconds): (&str, _)| PartTime { part: part.into(), ratio: NO_TIME, seconds };
    VariantRecord {
        variant: variant.name,
        setting: variant.setting,
        known_defect: variant.known_defect.map(Into::into),
        is_reference: variant.is_reference,
        error: variant.error,
        is_below_reference,
        seconds,
        time_s: NO_TIME,
        ratio: NO_TIME,
        standing: VariantStanding::Dominated,
        also: variant.also.into_iter().map(|(name, x)| (name.to_owned(), x)).collect(),
        parts: parts.names.into_iter().zip(parts.seconds).map(part).collect(),
        is_without: variant.is_without,
    }
}

/// Makes times, ratios and places of the variants from the seconds of their rounds.
pub fn figure(outcome: &mut SceneOutcome, seed: u64) {
    let variants_begin = outcome.rows.iter().take_while(|row| row.is_without).count();
    let seconds = |row: &VariantRecord| row.seconds.clone();
    let cheapest =
        outcome.rows.get(cheapest(outcome, variants_begin)).map(seconds).unwrap_or_default();
    let first = outcome.rows.first().map(|row| row.parts.clone()).unwrap_or_default();
    let mut rows = std::mem::take(&mut outcome.rows);
    for row in &mut rows {
        let ratio = |seconds: &[f64], other: &[f64]| {
            outcome.ratios(seconds, other).estimate(seed).unwrap_or(NO_TIME)
        };
        row.time_s = outcome.series(&row.seconds).estimate(seed).unwrap_or(NO_TIME);
        row.ratio = ratio(&row.seconds, &cheapest);
        for (part, first) in row.parts.iter_mut().zip(&first) {
            part.ratio = ratio(&part.seconds, &first.seconds);
        }
    }
    let reference_error = outcome.reference_error;
    let places: Vec<FrontPoint> =
        rows.iter().map(|row| FrontPoint::of(row, reference_error)).collect();
    for (row, standing) in rows.iter_mut().zip(pareto::standings(&places)) {
        row.standing = standing;
    }
    outcome.rows = rows;
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::test_records::{axis, row};

    #[test]
    fn the_cheapest_is_found_round_by_round() {
        // a machine that slows down: the second is faster in each round, the third never
        let seconds = [vec![2.0, 4.0, 8.0], vec![1.0, 3.9, 7.0], vec![2.5, 4.5, 6.9]];
        let mut outcome =
            axis(vec![row("a", 1.0, 0), row("b", 1.0, 0), row("c", 1.0, 0)]).scenes.remove(0);
        for (row, seconds) in outcome.rows.iter_mut().zip(seconds) {
            row.seconds = seconds;
        }
        assert_eq!(cheapest(&outcome, 0), 1);
        assert_eq!(cheapest(&outcome, 2), 2);
        assert_eq!((repeats(1.0), repeats(0.001), repeats(0.0)), (1, 4, 1000));
    }
}
