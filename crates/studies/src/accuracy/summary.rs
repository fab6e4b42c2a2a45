//! One-page summary of the cost of accuracy.

use std::fmt::Write;

use crate::accuracy::error_of::ErrorOf;
use crate::accuracy::record::{AccuracyRecord, AxisRecord, SceneOutcome, VariantRecord};
use crate::accuracy::tables::{push_facts, push_table};
use crate::accuracy::{effect_prices, parts};
use presentation::markdown::escaped;
use presentation::numbers::short;
use statistics::estimate::Estimate;
use statistics::series::{Series, geometric_mean_of};

/// Cost of the accuracy of an axis: from the cheapest variant to the most accurate one.
#[derive(Debug, Clone, PartialEq)]
pub enum Cost {
    /// All variants are equally accurate.
    NoneAtStake,
    /// The most accurate one takes less than 5% longer, by the whole interval.
    Free(Estimate),
    /// It may take less than that or more.
    NotTold(Estimate),
    /// It takes more, by the whole interval.
    More(Estimate),
}

/// Time over that of the cheapest from which on a difference counts as a cost: the margin of
/// `compare`. An interval that excludes 1 says only how many rounds were made; one on a side of
/// this says what matters (J. Kruschke, "Rejecting or Accepting Parameter Values in Bayesian
/// Estimation", AMPPS 1(2), 2018: a region of practical equivalence).
const NOTICED: f64 = 1.05;

/// The cost over all scenes of an axis; none without a scene.
pub fn cost(axis: &AxisRecord, seed: u64) -> Option<Cost> {
    let is_at_stake = |s: &SceneOutcome| {
        let mut errors = s.rows.iter().map(|r| r.error.value());
        let first = errors.next();
        errors.any(|e| Some(e) != first)
    };
    if axis.scenes.is_empty() {
        return None;
    }
    if !axis.scenes.iter().any(is_at_stake) {
        return Some(Cost::NoneAtStake);
    }
    let ratios: Vec<Series> = axis.scenes.iter().filter_map(ratios_of_accurate).collect();
    let over_all = geometric_mean_of(&ratios.iter().collect::<Vec<_>>(), seed)?;
    Some(if over_all.high < NOTICED {
        Cost::Free(over_all)
    } else if over_all.low <= NOTICED {
        Cost::NotTold(over_all)
    } else {
        Cost::More(over_all)
    })
}

/// Time of the most accurate variant over that of the cheapest, round by round.
fn ratios_of_accurate(scene: &SceneOutcome) -> Option<Series> {
    let (accurate, cheapest) = (scene.most_accurate()?, scene.cheapest()?);
    Some(scene.ratios(&accurate.seconds, &cheapest.seconds))
}

pub fn to_markdown(run: &AccuracyRecord) -> String {
    let mut text = String::from("# What accuracy costs in time\n\n");
    push_facts(&mut text, run);
    let mut lists: [Vec<(f64, String)>; 4] = Default::default();
    for axis in run.axes.iter().flat_map(AxisRecord::by_subject) {
        let Some(cost) = cost(&axis, run.seed) else { continue };
        let line = format!("**{}**: {}", escaped(&axis.axis), escaped(&words(&axis, &cost)));
        let (list, times) = match cost {
            Cost::Free(times) => (0, times.median),
            Cost::More(times) => (1, times.median),
            Cost::NotTold(times) => (2, times.median),
            Cost::NoneAtStake => (3, 1.0),
        };
        if let Some(list) = lists.get_mut(list) {
            list.push((times, line));
        }
    }
    let heads = [
        "Free: cost below 5%, upper end of the interval included",
        "Cost above 5%, lower end of the interval included",
        "Inconclusive: the interval contains 5%",
        "No accuracy is at stake: all variants give the same answers",
    ];
    for (head, lines) in heads.iter().zip(&mut lists) {
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        let _ = writeln!(text, "## {head}\n");
        if lines.is_empty() {
            text.push_str("Nothing.\n\n");
        }
        for (_, line) in lines {
            let _ = writeln!(text, "* {line}");
        }
        text.push('\n');
    }
    for axis in &run.axes {
        for table in parts::over_scenes(axis, run.seed) {
            push_table(&mut text, &table);
        }
        for table in axis.scenes.iter().filter_map(|scene| parts::steps(axis, scene, run.seed)) {
            push_table(&mut text, &table);
        }
    }
    if let Some(table) = effect_prices::table(run) {
        push_table(&mut text, &table);
    }
    let faults: Vec<String> = run
        .axes
        .iter()
        .flat_map(|a| a.scenes.iter().map(move |s| (a, s)))
        .flat_map(|(a, s)| s.faults.iter().map(move |f| format!("{} on {}: {f}", a.axis, s.scene)))
        .collect();
    if !faults.is_empty() {
        let _ = writeln!(text, "## Faults: these figures are invalid\n");
        faults.iter().for_each(|f| {
            let _ = writeln!(text, "* {}", escaped(f));
        });
        text.push('\n');
    }
    text
}

/// An axis in words: over all scenes, then scene by scene.
pub fn line(axis: &AxisRecord, cost: &Cost) -> String {
    format!("{}: {}", axis.axis, words(axis, cost))
}

fn words(axis: &AxisRecord, cost: &Cost) -> String {
    let scenes: Vec<String> = axis.scenes.iter().map(|s| scene(s, cost)).collect();
    let head = match cost {
        Cost::Free(e) => {
            format!("the most accurate variant costs next to nothing: {} more time", more(e))
        }
        Cost::More(e) => {
            if e.median < 2.0 {
                format!("the most accurate variant costs {} more time over all scenes", more(e))
            } else {
                format!(
                    "the most accurate variant takes {} times as long over all scenes",
                    times(e)
                )
            }
        }
        Cost::NotTold(e) => format!(
            "the cost of the most accurate variant over all scenes is inconclusive: {} more time",
            more(e)
        ),
        Cost::NoneAtStake => "answers are the same".into(),
    };
    format!("{head}. {}.", scenes.join("; "))
}

fn scene(scene: &SceneOutcome, cost: &Cost) -> String {
    let (Some(accurate), Some(cheapest)) = (scene.most_accurate(), scene.cheapest()) else {
        return format!("{}: nothing was measured", scene.place());
    };
    if *cost == Cost::NoneAtStake {
        let slowest = scene.rows.iter().max_by(|a, b| a.ratio.median.total_cmp(&b.ratio.median));
        let slowest = slowest.unwrap_or(cheapest);
        return format!(
            "on {} {} is the fastest and {} takes {} times as long",
            scene.place(),
            cheapest.variant,
            slowest.variant,
            times(&slowest.ratio)
        );
    }
    if accurate.variant == cheapest.variant {
        return format!(
            "on {} {} is the most accurate ({}) and the cheapest",
            scene.place(),
            accurate.variant,
            error(accurate)
        );
    }
    let cost = if accurate.ratio.holds(1.0) {
        format!("takes no significantly longer ({}) than", more(&accurate.ratio))
    } else if accurate.ratio.median < 2.0 {
        format!("costs {} more time than", more(&accurate.ratio))
    } else {
        format!("takes {} times as long as", times(&accurate.ratio))
    };
    format!(
        "on {} {} {cost} {} and {}",
        scene.place(),
        accurate.variant,
        cheapest.variant,
        removes(cheapest, accurate)
    )
}

fn error(row: &VariantRecord) -> String {
    match row.error {
        ErrorOf::Counted { wrong, trials } => format!("{wrong} wrong of {trials}"),
        ErrorOf::Rmse { rmse } => format!("an error of {rmse:.1e}"),
    }
}

/// Error removed by the step from one variant to another.
fn removes(from: &VariantRecord, to: &VariantRecord) -> String {
    match (from.error, to.error) {
        (ErrorOf::Rmse { rmse: a }, ErrorOf::Rmse { rmse: b }) if b > 0.0 => {
            // error^-p of a time: what half the error takes
            let half = 2.0_f64.powf((to.ratio.median / from.ratio.median).ln() / (a / b).ln());
            format!(
                "divides the error by {} (half the error takes {half:.1} times as long)",
                short(a / b)
            )
        }
        _ => {
            let gone = from.error.value() - to.error.value();
            format!("removes {} errors in 10^6 of {}", short(gone), short(from.error.value()))
        }
    }
}

fn more(e: &Estimate) -> String {
    let percent = |x: f64| format!("{:.1}%", (x - 1.0) * 100.0);
    format!("{} ({} to {})", percent(e.median), percent(e.low), percent(e.high))
}

fn times(e: &Estimate) -> String {
    format!("{:.2} ({:.2} to {:.2})", e.median, e.low, e.high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::test_records::{axis, row};

    #[test]
    fn costs_are_measured_and_reported() {
        let of = |rows| cost(&axis(rows), 1).unwrap();
        assert!(matches!(of(vec![row("a", 2.0, 5), row("b", 2.0, 0)]), Cost::Free(_)));
        // measured, and too small to matter
        assert!(matches!(of(vec![row("a", 2.0, 5), row("b", 2.06, 0)]), Cost::Free(_)));
        let mut noisy = row("b", 2.1, 0);
        noisy.seconds = vec![1.0, 2.1, 9.0];
        assert!(matches!(of(vec![row("a", 2.0, 5), noisy]), Cost::NotTold(_)));
        assert!(matches!(of(vec![row("a", 2.0, 5), row("b", 2.2, 0)]), Cost::More(_)));
        assert_eq!(of(vec![row("a", 2.0, 0), row("b", 3.0, 0)]), Cost::NoneAtStake);
        let tests = axis(vec![row("leaky", 2.0, 71), row("watertight", 2.2, 0)]);
        let said = line(&tests, &cost(&tests, 1).unwrap());
        assert!(
            said.contains(
                "on kitchen watertight costs 10.0% (10.0% to 10.0%) more time than leaky and removes \
                 71.0 errors in 10^6 of 71.0"
            ),
            "{said}"
        );
    }

    #[test]
    fn lists_are_in_the_order_of_their_costs() {
        let of = |name: &str, seconds| {
            let mut axis = axis(vec![row("leaky", 2.0, 71), row("watertight", seconds, 0)]);
            axis.axis = name.to_owned();
            axis
        };
        let axes = vec![of("dear", 6.0), of("cheap", 2.2), of("free", 2.01)];
        let page = to_markdown(&crate::accuracy::test_records::record(axes));
        let at = |what: &str| page.find(what).unwrap_or_else(|| panic!("no {what}: {page}"));
        assert!(at("**free**") < at("## Cost above") && at("## Cost above") < at("**cheap**"));
        assert!(at("**cheap**") < at("**dear**") && at("**dear**") < at("## Inconclusive"));
    }
}
