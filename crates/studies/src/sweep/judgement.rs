//! Best value, values as good as it, and the rank of the rules of thumb.

use crate::sweep::sizes::quantities::trace_s_per_ray;
use crate::sweep::{Line, Sweep};
use measurement::record::{RowRecord, SceneRecord, StatsRecord, Verdict};
use statistics::estimate::Estimate;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ValueStanding {
    /// The lowest tracing time.
    Best,
    /// Its interval overlaps that of the best: no difference was measured.
    NotToldApart,
    Slower,
}

#[derive(Debug, Clone, PartialEq)]
pub struct Judgement {
    /// Among the swept values; none for other rows and for rows without a time.
    pub standing: Option<ValueStanding>,
    /// Tracing time over that of the best value.
    pub to_best: Option<f64>,
    pub cells_per_primitive: Option<f64>,
    /// `best`, `rule: woo`...
    pub marks: Vec<String>,
}

/// Judges the rows of a scene: one judgement for each line.
pub fn judge(sweep: &Sweep<'_>, scene: &SceneRecord) -> Vec<Judgement> {
    let costs = costs(scene);
    let rows = || scene.rows.iter().zip(&sweep.lines).zip(&costs);
    let competing: Vec<Option<Estimate>> = rows()
        .map(|((row, line), cost)| cost.filter(|_| line.is_swept && row.verdict == Verdict::Ok))
        .collect();
    let standings = standings(&competing);
    let best = competing.iter().flatten().map(|e| e.median).min_by(f64::total_cmp);
    let cells_per_primitive =
        |stats: &StatsRecord| stats.n_v as f64 / scene.primitives.max(1) as f64;
    rows()
        .zip(standings)
        .map(|(((row, line), cost), standing)| Judgement {
            standing,
            to_best: cost.zip(best).filter(|(_, b)| *b > 0.0).map(|(c, b)| c.median / b),
            cells_per_primitive: row.stats.as_ref().map(cells_per_primitive),
            marks: marks(line, standing, row.is_reference),
        })
        .collect()
}

/// The tracing time of each row as it can be compared: its ratio to the reference on the same
/// rays, or seconds per ray where the reference has no time.
pub fn costs(scene: &SceneRecord) -> Vec<Option<Estimate>> {
    let has_ratios = scene.rows.iter().any(|r| r.ratio.is_some());
    let cost = |row: &RowRecord| {
        if has_ratios {
            return row.ratio;
        }
        trace_s_per_ray(row)
    };
    scene.rows.iter().map(cost).collect()
}

/// How each cost stands among all that there are; of equal ones, the first is the best.
pub fn standings(costs: &[Option<Estimate>]) -> Vec<Option<ValueStanding>> {
    let known = costs.iter().enumerate().filter_map(|(i, cost)| Some((i, (*cost)?)));
    let best = known.min_by(|a, b| a.1.median.total_cmp(&b.1.median));
    let of = |(i, cost): (usize, &Option<Estimate>)| {
        let (cost, (first, best)) = ((*cost)?, best?);
        Some(if i == first {
            ValueStanding::Best
        } else if cost.low <= best.high && best.low <= cost.high {
            ValueStanding::NotToldApart
        } else {
            ValueStanding::Slower
        })
    };
    costs.iter().enumerate().map(of).collect()
}

fn marks(line: &Line, standing: Option<ValueStanding>, is_reference: bool) -> Vec<String> {
    let of_standing = match standing {
        Some(ValueStanding::Best) => Some("best"),
        Some(ValueStanding::NotToldApart) => Some("~best"),
        Some(ValueStanding::Slower) | None => None,
    };
    let words = of_standing.into_iter().chain(line.is_default.then_some("default"));
    let rules = line.rules.iter().map(|rule| format!("rule: {rule}"));
    let reference = is_reference.then(|| "reference".to_owned());
    words.map(str::to_owned).chain(rules).chain(reference).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn estimate(low: f64, median: f64, high: f64) -> Option<Estimate> {
        Some(Estimate { median, low, high })
    }

    #[test]
    fn overlapping_intervals_are_not_distinguished() {
        let costs = [
            estimate(4.0, 5.0, 6.0),
            estimate(2.0, 3.0, 3.5),
            None,
            estimate(1.9, 2.0, 2.2),
            estimate(2.2, 2.3, 2.4),
            estimate(2.25, 2.3, 2.4),
        ];
        use ValueStanding::{Best, NotToldApart, Slower};
        assert_eq!(
            standings(&costs),
            [Some(Slower), Some(NotToldApart), None, Some(Best), Some(NotToldApart), Some(Slower)]
        );
    }

    #[test]
    fn the_first_of_equal_costs_is_the_best() {
        let equal = [estimate(1.0, 1.0, 1.0), estimate(1.0, 1.0, 1.0)];
        assert_eq!(
            standings(&equal),
            [Some(ValueStanding::Best), Some(ValueStanding::NotToldApart)]
        );
        assert_eq!(standings(&[None, None]), [None, None]);
    }

    #[test]
    fn marks_name_every_role_of_a_row() {
        let line = Line { is_default: true, rules: vec!["woo"], ..Line::default() };
        let marks = marks(&line, Some(ValueStanding::Best), true);
        assert_eq!(marks, ["best", "default", "rule: woo", "reference"]);
        assert!(super::marks(&Line::default(), Some(ValueStanding::Slower), false).is_empty());
    }
}
