//! Costs of the rows of a scene: of the build, and per ray.
//!
//! A row that is too slow for all rays is timed on every k-th. Its time per ray is then its ratio
//! to the reference on these rays, times what the reference takes per ray over all of its own: so
//! all rows stand for the same rays.

use std::collections::BTreeMap;

use measurement::record::query::Query;
use measurement::record::{AnsweredRays, RowRecord, Sample, SceneRecord, Verdict};
use statistics::estimate::{Estimate, median};
use statistics::series::Series;

use crate::run::leads::{Ranking, TimedRow, Visit, lead};

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Cost {
    pub build_s: f64,
    pub ray_s: f64,
}

impl Cost {
    /// Building and tracing so many rays.
    pub fn total_s(&self, rays: f64) -> f64 {
        self.build_s + rays * self.ray_s
    }
}

/// A row that answers all kinds of rays, all of them rightly.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// Its number in the scene's table, from 1.
    pub number: usize,
    pub label: String,
    /// It may be called the best of anything.
    pub may_lead: bool,
    /// By process and round.
    pub rounds: BTreeMap<Visit, Cost>,
    /// Medians over the rounds.
    pub cost: Cost,
}

impl Profile {
    /// Profile of a row that may lead; `None` without rounds.
    pub fn new(number: usize, label: String, rounds: BTreeMap<Visit, Cost>) -> Option<Self> {
        let of = |f: fn(&Cost) -> f64| median(&rounds.values().map(f).collect::<Vec<_>>());
        let cost = Cost { build_s: of(|c| c.build_s)?, ray_s: of(|c| c.ray_s)? };
        Some(Self { number, label, may_lead: true, rounds, cost })
    }

    /// Both costs of the rounds that both have, with their process.
    pub fn paired<'a>(&'a self, other: &'a Self) -> impl Iterator<Item = (u32, [Cost; 2])> + 'a {
        let both =
            |(visit, cost): (&Visit, &Cost)| Some((visit.0, [*cost, *other.rounds.get(visit)?]));
        self.rounds.iter().filter_map(both)
    }

    /// Seconds for a ray, with their interval.
    pub fn ray_s(&self, seed: u64) -> Option<Estimate> {
        let rounds = self.rounds.iter().map(|((process, _), c)| (*process, c.ray_s));
        rounds.collect::<Series>().estimate(seed)
    }

    /// Time per ray over that of another row, paired by round.
    pub fn ray_quotients(&self, other: &Self) -> Series {
        let quotient =
            |(process, [own, other]): (u32, [Cost; 2])| (process, own.ray_s / other.ray_s);
        self.paired(other).map(quotient).filter(|(_, q)| q.is_finite()).collect()
    }

    /// Cost in each round; `None` if it has none.
    pub fn timed(&self, of: impl Fn(&Cost) -> f64) -> Option<TimedRow> {
        let rounds = self.rounds.iter().map(|(visit, cost)| (*visit, of(cost))).collect();
        TimedRow::new(self.label.clone(), Query::default(), rounds)
    }
}

/// The row that the ratios of a scene are taken to, where it was timed.
pub fn reference(scene: &SceneRecord) -> Option<&RowRecord> {
    scene.rows.iter().find(|row| row.is_reference && row.verdict.is_timed())
}

/// The rows of a scene that may be compared, in its order.
pub fn profiles(scene: &SceneRecord) -> Vec<Profile> {
    let reference = reference(scene);
    let of = |(i, row): (usize, &RowRecord)| {
        if row.verdict != Verdict::Ok || row.answers != AnsweredRays::AllRays || row.rays == 0 {
            return None;
        }
        let rounds =
            row.samples.iter().map(|s| ((s.process, s.round), cost(s, row, reference))).collect();
        let profile = Profile::new(i + 1, row.label_with_query(), rounds)?;
        Some(Profile { may_lead: scene.may_lead(row), ..profile })
    };
    scene.rows.iter().enumerate().filter_map(of).collect()
}

fn cost(sample: &Sample, row: &RowRecord, reference: Option<&RowRecord>) -> Cost {
    let all_rays = |reference: &RowRecord| {
        let own = reference.samples.iter().find(|s| s.round == sample.round)?;
        let on_same_rays = sample.reference_trace_s.filter(|s| *s > 0.0)?;
        Some(own.total_trace_s() / reference.rays.max(1) as f64 / on_same_rays)
    };
    let a_second = reference.and_then(all_rays).unwrap_or(1.0 / row.rays.max(1) as f64);
    Cost { build_s: sample.build_s, ray_s: sample.total_trace_s() * a_second }
}

/// Seconds for all rays of a kind that the scene has, of a row that may have been timed on fewer.
pub fn all_rays_s(
    scene: &SceneRecord,
    row: &RowRecord,
    reference: Option<&RowRecord>,
    sample: &Sample,
    kind: &str,
) -> Option<f64> {
    let own = *sample.trace_s.get(kind)?;
    let all = *scene.rays.get(kind)? as f64;
    let timed_on = |row: &RowRecord| row.rays_by_kind.get(kind).map(|n| (*n).max(1) as f64);
    let through_reference = || {
        let reference = reference.filter(|reference| reference.stride < row.stride)?;
        let same_round = reference.samples.iter().find(|s| s.round == sample.round)?;
        let on_same_rays = sample.reference_by_kind.get(kind).filter(|s| **s > 0.0)?;
        Some(own / on_same_rays * same_round.trace_s.get(kind)? * (all / timed_on(reference)?))
    };
    through_reference().or_else(|| Some(own * (all / timed_on(row)?)))
}

/// Fastest row for this many rays, build included, of those that may lead; `None` without such
/// rows.
pub fn lead_for(profiles: &[Profile], rays: f64, seed: u64) -> Option<Ranking> {
    let may_lead = profiles.iter().filter(|p| p.may_lead);
    let timed: Vec<TimedRow> = may_lead.filter_map(|p| p.timed(|c| c.total_s(rays))).collect();
    lead(&[timed], seed)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn profile(number: usize, cost: (f64, f64)) -> Profile {
        let (build_s, ray_s) = cost;
        let rounds = (0..6).map(|i| ((0, i), Cost { build_s, ray_s })).collect();
        Profile::new(number, format!("row {number}"), rounds).unwrap()
    }

    #[test]
    fn builds_count_where_rays_are_few() {
        let mut rows = [profile(1, (9.0, 1.0)), profile(2, (1.0, 2.0)), profile(3, (0.5, 0.5))];
        rows[2].may_lead = false;
        assert_eq!(lead_for(&rows, 1.0, 1).unwrap().first, "row 2");
        assert_eq!(lead_for(&rows, 100.0, 1).unwrap().first, "row 1");
        assert_eq!(lead_for(&rows, 8.0, 1).unwrap().ties.len(), 1);
    }
}
