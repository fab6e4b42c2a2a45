//! The row that the ratios of a scene are taken to: the one planned, or another where that gave
//! nothing to compare with.

use crate::answers::check::Checked;
use crate::plan::{Plan, default_rank};

/// Index of the row, given what is known of each before it is timed. Where the planned one was not
/// built or is wrong without being known to be: the default references, the best first, else the
/// first row, of those that are right and answer all rays; others with known defects, and those
/// that are measured on a sample only, come last. The planned one if there is none, and where the
/// plan keeps it.
pub fn baseline(plan: &Plan<'_>, checked: &[Option<Checked>]) -> usize {
    let serves = |row: usize| {
        let checked = checked.get(row).and_then(Option::as_ref);
        checked.is_some_and(|checked| checked.verdict.is_timed())
    };
    if plan.keeps_baseline || serves(plan.baseline) {
        return plan.baseline;
    }
    let others = plan.rows.iter().enumerate().filter(|(i, row)| serves(*i) && !row.is_occluder());
    let next = others.min_by_key(|(i, row)| {
        let rank = default_rank(row.structure(), &row.settings());
        let is_last = rank.is_none() && row.known_defect().is_some();
        (is_last, row.is_sampled(), rank.unwrap_or(usize::MAX), *i)
    });
    next.map_or(plan.baseline, |(i, _)| i)
}
