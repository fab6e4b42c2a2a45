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

/// Ranks the rows that every scene has by geometric means over the scenes; `None` without such
/// rows. The first of rows with the same label counts.
pub fn lead(scenes: &[Vec<TimedRow>], seed: u64) -> Option<Ranking> {
    let by_label: Vec<BTreeMap<&str, &TimedRow>> = scenes
        .iter()
        .map(|scene| scene.iter().rev().map(|row| (row.label.as_str(), row)).collect())
        .collect();
    let everywhere = scenes.first()?.iter().filter_map(|row| {
        let label = row.label.as_str();
        let rows = by_label.iter().map(|rows| rows.get(label).copied());
        let rows = rows.collect::<Option<Vec<&TimedRow>>>()?;
        let is_counted = rows.first().is_some_and(|counted| std::ptr::eq(*counted, row));
        is_counted.then_some((label, rows))
    });
    let mut candidates: Vec<_> = everywhere.collect();
    let took = |rows: &[&TimedRow]| rows.iter().map(|t| t.middle.ln()).sum::<f64>();
    let all = candidates.iter().map(|(_, rows)| took(rows)).enumerate();
    let (place, _) = all.min_by(|a, b| a.1.total_cmp(&b.1))?;
    let (label, first) = candidates.remove(place);
    // of each its median quotient, its label, and the first one's times over its own, by scene
    let of_first = |(label, rows): (&str, Vec<&TimedRow>)| {
        let pairs = first.iter().zip(rows);
        let quotients: Vec<Series> = pairs.map(|(first, row)| first.quotients(row)).collect();
        Some((middle(&quotients)?, label.to_owned(), quotients))
    };
    let mut others: Vec<_> = candidates.into_iter().filter_map(of_first).collect();
    others.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (mut ties, mut next) = (Vec::new(), None);
    for (_, other, quotients) in others {
        // intervals take long: of what is slower in every round only that of the nearest is shown
        if next.is_some() && quotients.iter().flat_map(Series::values).all(|q| *q < 1.0) {
            continue;
        }
        match geometric_mean_of(&quotients, seed) {
            Some(quotient) if quotient.high >= 1.0 => ties.push(other),
            Some(quotient) if next.is_none() => next = Some((other, quotient.inverse())),
            _ => {}
        }
    }
    let own: Vec<Series> = first.iter().map(|t| series(&t.rounds)).collect();
    let took = geometric_mean_of(&own, seed)?;
    Some(Ranking { first: label.to_owned(), took, ties, next })
}

/// The geometric mean over series (scenes), without its interval.
fn middle(groups: &[Series]) -> Option<f64> {
    let medians = groups.iter().map(Series::middle).collect::<Option<Vec<_>>>()?;
    match medians[..] {
        [one] => Some(one),
        _ => geometric_mean(&medians),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn timed(number: usize, times: &[f64]) -> TimedRow {
        let rounds = times.iter().zip(0..).map(|(took, i)| ((0, i), *took)).collect();
        TimedRow::new(format!("row {number}"), Query::default(), rounds).unwrap()
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
