//! Finds impossible results, which reveal faults of an experiment.
//!
//! * A front with a member that another beats.
//! * A variant that answers otherwise while it is timed than when it was judged: its time and its
//!   error would be those of two different programs.
//! * A reference variant of an exact oracle that is wrong.
//! * A sampled reference that is worse than it says: the finest variant, whose own scatter is known
//!   from several seeds, lies farther from it than both errors together explain.

use crate::accuracy::pareto::{self, FrontPoint};
use crate::accuracy::record::{ErrorOf, SceneOutcome, VariantStanding};

/// Factor by which a variant's distance from the reference may exceed its scatter plus the
/// reference's own error. Both are estimates, which few pixels may decide.
const TOLERATED: f64 = 3.0;

/// The faults of an outcome, in words.
pub fn faults(outcome: &SceneOutcome) -> Vec<String> {
    let mut faults = Vec::new();
    let places: Vec<FrontPoint> =
        outcome.rows.iter().map(|row| FrontPoint::of(row, outcome.reference_error)).collect();
    let standings: Vec<VariantStanding> = outcome.rows.iter().map(|row| row.standing).collect();
    faults.extend(pareto::fault(&places, &standings));
    for row in outcome.rows.iter().filter(|row| row.is_reference) {
        if let ErrorOf::Counted { wrong, trials } = row.error
            && wrong > 0
        {
            faults
                .push(format!("{} is the reference and wrong in {wrong} of {trials}", row.variant));
        }
    }
    faults
}

/// A variant whose answers changed between judging and timing.
pub fn inconsistency(variant: &str, judged: u64, timed: u64) -> Option<String> {
    (judged != timed).then(|| format!("answers of {variant} differ between timing and judging"))
}

/// A sampled reference that is worse than stated: `error` is that of the finest variant to it,
/// `scatter` the variant's own by its seeds, `own` the reference's.
pub fn bad_reference(error: f64, scatter: f64, own: f64) -> Option<String> {
    let explained = scatter.hypot(own);
    (error > TOLERATED * explained).then(|| {
        format!(
            "the reference is less accurate than stated: the finest variant differs by \
             {error:.2e}; scatter and the stated error explain {explained:.2e}"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_variant_with_false_answers_is_caught() {
        assert_eq!(inconsistency("fast", 7, 7), None);
        assert!(inconsistency("fast", 7, 8).unwrap().contains("answers of fast differ"));
    }

    #[test]
    fn a_reference_less_accurate_than_stated_is_caught() {
        assert_eq!(bad_reference(0.011, 0.01, 0.001), None);
        assert!(bad_reference(0.04, 0.01, 0.001).is_some());
        // planted: an honest reference that states a tenth of its error
        assert!(bad_reference(0.03, 0.003, 0.003).is_some());
    }
}
