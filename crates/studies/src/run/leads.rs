//! Ranks rows by time, with significance: paired by round, over one scene or several.

use std::collections::BTreeMap;

use measurement::record::query::Query;
use statistics::estimate::{Estimate, geometric_mean};
use statistics::series::{Series, geometric_mean_of};

pub type Visit = (u32, u32);

/// A row and what it took in each round: seconds of something, or bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct TimedRow {
    pub label: String,
    /// How it was asked.
    pub query: Query,
    /// By process and round, each above 0.
    pub rounds: BTreeMap<Visit, f64>,
    pub middle: f64,
}

impl TimedRow {
    /// Row with these rounds; `None` if no round took time.
    pub fn new(label: String, query: Query, mut rounds: BTreeMap<Visit, f64>) -> Option<Self> {
        rounds.retain(|_, took| took.is_finite() && *took > 0.0);
        let middle = series(&rounds).middle()?;
        Some(Self { label, query, rounds, middle })
    }

    /// Ratio of its times to those of another row, paired by round.
    pub fn quotients(&self, other: &Self) -> Series {
        let quotient = |(visit, own): (&Visit, &f64)| {
            Some((visit.0, own / other.rounds.get(visit)?)).filter(|(_, q)| q.is_finite())
        };
        self.rounds.iter().filter_map(quotient).collect()
    }
}

fn series(rounds: &BTreeMap<Visit, f64>) -> Series {
    rounds.iter().map(|((process, _), took)| (*process, *took)).collect()
}

/// How the fastest of several stands against the others.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranking {
    /// The fastest, by its median.
    pub first: String,
    /// Its time; over several scenes the geometric mean.
    pub took: Estimate,
    pub ties: Vec<String>,
    /// The nearest that is significantly slower, and how many times as much it takes.
    pub next: Option<(String, Estimate)>,
}

/// The intervals of fewer samples reach to all of them.
const FEW: usize = 6;

/// Another row than the fastest, and the quotients of the fastest one's times and its own.
struct Competitor {
    label: String,
    /// By scene, at the end of which they are resampled.
    groups: Vec<Series>,
}

impl Competitor {
    fn quotient(&self, seed: u64) -> Option<Estimate> {
        geometric_mean_of(&self.groups, seed)
    }

    /// The quotient without its interval.
    fn middle(&self) -> Option<f64> {
        let medians = self.groups.iter().map(Series::middle).collect::<Option<Vec<_>>>()?;
        match &medians[..] {
            [one] => Some(*one),
            _ => geometric_mean(&medians),
        }
    }

    /// Returns whether so few rounds of one scene say that it may be the faster one: their interval
    /// reaches to the largest quotient, as [`Estimate`] says, and need not be resampled.
    fn is_tied_by_few(&self) -> bool {
        match &self.groups[..] {
            [group] => {
                let is_one_process = group.by_process().len() < 2;
                is_one_process && group.len() < FEW && group.values().iter().any(|q| *q >= 1.0)
            }
            _ => false,
        }
    }

    /// Returns whether it is slower in every round: resampling them does not change that.
    fn is_always_slower(&self) -> bool {
        self.groups.iter().flat_map(Series::values).all(|quotient| *quotient < 1.0)
    }
}

impl Ranking {
    /// From the others, in any order.
    fn new(first: String, took: Estimate, others: Vec<Competitor>, seed: u64) -> Self {
        let mut others: Vec<(f64, Competitor)> =
            others.into_iter().filter_map(|other| Some((other.middle()?, other))).collect();
        others.sort_by(|a, b| b.0.total_cmp(&a.0));
        let (mut ties, mut next) = (Vec::new(), None);
        for (_, other) in others {
            // intervals take long: of what is slower in any case only that of the nearest is shown
            if next.is_some() && other.is_always_slower() {
                continue;
            }
            if other.is_tied_by_few() {
                ties.push(other.label);
                continue;
            }
            match other.quotient(seed) {
                Some(quotient) if quotient.high >= 1.0 => ties.push(other.label),
                Some(quotient) if next.is_none() => next = Some((other.label, quotient.inverse())),
                _ => {}
            }
        }
        Self { first, took, ties, next }
    }
}

/// Ranks the rows that every scene has by geometric means over the scenes; `None` without such
/// rows. The first of rows with the same label counts.
pub fn lead<R: AsRef<[TimedRow]>>(scenes: &[R], seed: u64) -> Option<Ranking> {
    let by_label = |scene: &R| -> BTreeMap<String, usize> {
        scene.as_ref().iter().enumerate().rev().map(|(i, t)| (t.label.clone(), i)).collect()
    };
    let places: Vec<BTreeMap<String, usize>> = scenes.iter().map(by_label).collect();
    let everywhere = |label: &str| -> Option<Vec<&TimedRow>> {
        let found = scenes.iter().zip(&places);
        found.map(|(scene, places)| scene.as_ref().get(*places.get(label)?)).collect()
    };
    let labels = places.first()?;
    let mut candidates: Vec<(usize, Vec<&TimedRow>)> =
        labels.iter().filter_map(|(label, place)| Some((*place, everywhere(label)?))).collect();
    candidates.sort_by_key(|(place, _)| *place);
    let took = |rows: &[&TimedRow]| rows.iter().map(|t| t.middle.ln()).sum::<f64>();
    let (place, first) = candidates.iter().min_by(|a, b| took(&a.1).total_cmp(&took(&b.1)))?;
    let label = |rows: &[&TimedRow]| rows.first().map_or(String::new(), |t| t.label.clone());
    let others =
        candidates.iter().filter(|(other, _)| other != place).map(|(_, rows)| Competitor {
            label: label(rows),
            groups: first.iter().zip(rows).map(|(a, b)| a.quotients(b)).collect(),
        });
    let own: Vec<Series> = first.iter().map(|t| series(&t.rounds)).collect();
    Some(Ranking::new(label(first), geometric_mean_of(&own, seed)?, others.collect(), seed))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timed(number: usize, times: &[f64]) -> TimedRow {
        let rounds = times.iter().zip(0..).map(|(took, i)| ((0, i), *took)).collect();
        TimedRow::new(format!("row {number}"), Query::default(), rounds).unwrap()
    }

    #[test]
    fn intervals_of_few_samples_reach_to_the_largest() {
        for n in 1..FEW {
            for largest in [0.9, 1.0, 1.1] {
                let mut group: Vec<f64> = (1..n).map(|i| 0.5 + 0.05 * i as f64).collect();
                group.push(largest);
                let other = Competitor { label: String::new(), groups: vec![group.into()] };
                let interval = other.quotient(1).unwrap();
                assert_eq!(interval.high, largest, "{n}");
                assert_eq!(other.is_tied_by_few(), interval.high >= 1.0, "{n} {largest}");
            }
        }
        let many = Competitor { label: String::new(), groups: vec![vec![1.1; FEW].into()] };
        assert!(!many.is_tied_by_few());
    }

    #[test]
    fn leads_are_paired_by_round() {
        // rounds of very different speed: unpaired, nothing could be told
        let rows = vec![
            timed(1, &[1.0, 5.0, 9.0, 2.0, 3.0, 4.0]),
            timed(2, &[1.2, 6.0, 10.8, 2.4, 3.6, 4.8]),
            timed(3, &[1.1, 4.9, 9.9, 2.1, 2.9, 4.8]),
        ];
        let alone = lead(std::slice::from_ref(&rows), 1).unwrap();
        assert_eq!((alone.first.as_str(), alone.ties), ("row 1", vec!["row 3".to_owned()]));
        let (label, times) = alone.next.unwrap();
        assert_eq!(label, "row 2");
        assert!((times.median - 1.2).abs() < 1e-9 && times.low <= times.high, "{times:?}");
        assert!(alone.took.holds(3.5), "{:?}", alone.took);
        let all = lead(&[rows.clone(), rows[..2].to_vec()], 1).unwrap();
        assert_eq!((all.first.as_str(), all.ties.len()), ("row 1", 0), "row 3 is not everywhere");
        assert_eq!(lead(&[Vec::new()], 1), None);
    }

    #[test]
    fn rounds_that_took_nothing_are_left_out() {
        let rounds = [((0, 0), 0.0), ((0, 1), f64::NAN), ((0, 2), 2.0)].into();
        assert_eq!(TimedRow::new("a".into(), Query::default(), rounds).unwrap().middle, 2.0);
        assert_eq!(TimedRow::new("a".into(), Query::default(), BTreeMap::new()), None);
    }
}
