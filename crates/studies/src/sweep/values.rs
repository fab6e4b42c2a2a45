//! The values of a sweep, and the rules of thumb for the number of voxels, as rows beside it.

use accel_core::grid::resolution::ResolutionRule;
use accel_core::params::{ParamKind, ParamSpec};
use accel_core::structures::Entry;
use measurement::plan::rows::Assignments;

/// Fewest significant digits that computed values are rounded to.
const FEWEST_DIGITS: usize = 3;
/// Digits that tell all f64 apart.
const MOST_DIGITS: usize = 17;
/// From this ratio of the largest to the smallest value on, a logarithmic axis shows them better.
const WIDE: f64 = 8.0;

/// Numbers from one to another, both included, at equal ratios.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Range {
    pub from: f64,
    pub to: f64,
    pub steps: usize,
}

impl Range {
    /// The values, rounded to as few digits as keep them apart: what is shown is what is measured.
    pub fn real_numbers(&self) -> Vec<String> {
        let exact = self.points();
        let texts = |digits| -> Vec<String> {
            let last = exact.len().saturating_sub(1);
            let rounded = exact.iter().enumerate().map(|(i, &x)| {
                let is_end = i == 0 || i == last;
                if is_end { x } else { rounded(x, digits) }
            });
            rounded.map(|x| x.to_string()).collect()
        };
        (FEWEST_DIGITS..=MOST_DIGITS)
            .map(texts)
            .find(|texts| ascends(&numbers(texts)))
            .unwrap_or_else(|| texts(MOST_DIGITS))
    }

    /// The values as distinct whole numbers, so possibly fewer of them.
    pub fn whole_numbers(&self) -> Vec<String> {
        let mut texts: Vec<String> = self.points().iter().map(|x| x.round().to_string()).collect();
        texts.dedup();
        texts
    }

    fn points(&self) -> Vec<f64> {
        let last = self.steps.saturating_sub(1).max(1);
        let between = |i: usize| {
            let t = i as f64 / last as f64;
            (self.from.ln() + t * (self.to.ln() - self.from.ln())).exp()
        };
        let inner = (1..last).map(between);
        std::iter::once(self.from).chain(inner).chain([self.to]).collect()
    }
}

/// The nearest number of that many significant digits.
fn rounded(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x)
}

fn ascends(numbers: &[f64]) -> bool {
    numbers.windows(2).all(|w| matches!(w, [a, b] if a < b))
}

fn numbers(texts: &[String]) -> Vec<f64> {
    texts.iter().filter_map(|t| t.parse().ok()).collect()
}

/// Values as typed: numbers in their shortest form and in ascending order, words as they are.
pub fn in_order(kind: ParamKind, typed: &[String]) -> Vec<String> {
    match kind {
        ParamKind::Integer { .. } | ParamKind::Real { .. } => {
            let mut numbers = numbers(typed);
            numbers.sort_by(f64::total_cmp);
            numbers.dedup();
            numbers.iter().map(f64::to_string).collect()
        }
        ParamKind::Choice(_) | ParamKind::Resolution => typed.to_vec(),
    }
}

/// Returns whether the numbers span so much that their ratios matter more than their differences.
pub fn spread_by_ratios(values: &[String]) -> bool {
    let numbers = numbers(values);
    let smallest = numbers.iter().copied().fold(f64::INFINITY, f64::min);
    let largest = numbers.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    smallest > 0.0 && largest / smallest >= WIDE
}

/// The rules that are formulas for N voxels: they are measured at one voxel per primitive. The
/// others know their density, or have the structure's default.
const ONE_PER_PRIMITIVE: [&str; 3] = ["regular", "woo", "heterogeneous"];

/// Returns whether the parameter decides the number of voxels of a grid, so that rules compete with
/// it.
pub fn rules_apply_to(entry: &Entry, parameter: &ParamSpec) -> bool {
    let names_rules = |p: &ParamSpec| matches!(p.kind, ParamKind::Resolution);
    names_rules(parameter)
        || parameter.name == "density" && entry.info.params.iter().any(names_rules)
}

/// Each rule with its settings, over settings of other parameters. The rule `density` is the
/// structure's default and stands there as such.
pub fn rule_settings<'t>(others: &[(&'t str, &'t str)]) -> Vec<(&'static str, Assignments<'t>)> {
    let others = others.iter().copied().filter(|(n, _)| !["resolution", "density"].contains(n));
    let of = |rule: &'static str| {
        let density = ONE_PER_PRIMITIVE.contains(&rule).then_some(("density", "1"));
        (rule, others.clone().chain([("resolution", rule)]).chain(density).collect())
    };
    ResolutionRule::NAMES.iter().copied().filter(|r| *r != "density").map(of).collect()
}

#[cfg(test)]
mod tests {
    use accel_core::structures::{REGISTRY, find};

    use super::*;

    fn range(from: f64, to: f64, steps: usize) -> Range {
        Range { from, to, steps }
    }

    #[test]
    fn equal_ratios_are_the_default_and_are_rounded() {
        assert_eq!(range(0.1, 100.0, 4).real_numbers(), ["0.1", "1", "10", "100"]);
        assert_eq!(range(1.0, 10.0, 3).real_numbers(), ["1", "3.16", "10"]);
        assert_eq!(range(0.1, 100.0, 13).real_numbers().len(), 13);
    }

    #[test]
    fn ends_are_exact_and_near_values_stay_apart() {
        let values = range(1.000_01, 1.000_05, 5).real_numbers();
        assert_eq!((values[0].as_str(), values[4].as_str()), ("1.00001", "1.00005"));
        assert!(ascends(&numbers(&values)) && values.len() == 5, "{values:?}");
        let values = range(0.123_456, 0.2, 2).real_numbers();
        assert_eq!(values, ["0.123456", "0.2"]);
    }

    #[test]
    fn whole_numbers_are_distinct() {
        assert_eq!(range(1.0, 8.0, 4).whole_numbers(), ["1", "2", "4", "8"]);
        assert_eq!(range(1.0, 4.0, 20).whole_numbers(), ["1", "2", "3", "4"]);
    }

    #[test]
    fn swept_numbers_are_sorted_and_words_are_not() {
        let typed = |v: &[&str]| v.iter().map(|s| (*s).to_owned()).collect::<Vec<_>>();
        let real = ParamKind::Real { min: 0.0, max: 100.0 };
        assert_eq!(in_order(real, &typed(&["10", "2.50", "2.5", "1e1"])), ["2.5", "10"]);
        let words = ParamKind::Choice(&["b", "a"]);
        assert_eq!(in_order(words, &typed(&["b", "a"])), ["b", "a"]);
    }

    #[test]
    fn wide_ranges_are_spread_by_ratios() {
        let typed = |v: &[f64]| v.iter().map(f64::to_string).collect::<Vec<_>>();
        assert!(spread_by_ratios(&typed(&[1.0, 100.0])));
        assert!(!spread_by_ratios(&typed(&[1.0, 2.0])));
        assert!(!spread_by_ratios(&typed(&[0.0, 100.0])));
    }

    #[test]
    fn rules_compete_where_the_number_of_voxels_is_swept() {
        for entry in REGISTRY {
            let grids = [
                "uniform-grid",
                "compact-grid",
                "two-level-grid",
                "hashed-grid",
                "bricked-grid",
                "proximity-clouds",
            ];
            let is_grid = grids.contains(&entry.info.name);
            for p in entry.info.params {
                let expected = is_grid && ["density", "resolution"].contains(&p.name);
                assert_eq!(rules_apply_to(entry, p), expected, "{}.{}", entry.info.name, p.name);
            }
        }
    }

    #[test]
    fn every_rule_can_be_built() {
        let entry = find("uniform-grid").unwrap();
        let rules = rule_settings(&[("density", "7"), ("mailbox", "hash")]);
        assert_eq!(rules.len(), ResolutionRule::NAMES.len() - 1);
        for (rule, settings) in rules {
            let params = entry.params(settings).unwrap();
            assert_eq!((params.text("resolution"), params.text("mailbox")), (rule, "hash"));
            assert_ne!(params.text("density"), "7");
        }
    }
}
