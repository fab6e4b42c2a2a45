//! Costs of the rows of a scene: of the build, and per ray; and from how many rays on a structure that
//! takes longer to build is worth it.
//!
//! A row that is too slow for all rays is timed on every k-th. Its time per ray is then its ratio
//! to the reference on these rays, times what the reference takes per ray over all of its own: so
//! all rows stand for the same rays.
//!
//! The time for n rays is T(n) = build + n * time per ray. Two such lines cross once at most; the
//! least time over all n is their lower envelope.

use std::collections::BTreeMap;

use measurement::record::query::Query;
use measurement::record::{AnsweredRays, RowRecord, Sample, SceneRecord, Verdict};
use statistics::estimate::{Estimate, interval, median};
use statistics::random::Random;
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

/// Resamples of an interval.
const RESAMPLES: usize = if cfg!(fuzzing) { 10 } else { 1000 };

/// For how many rays one structure takes less time than another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BreakEven {
    Always,
    Never,
    /// For more than these: it takes longer to build.
    From(f64),
    /// For fewer than these: it takes longer for a ray.
    Until(f64),
    /// Both take the same time.
    Same,
}

/// Break-even ray count of `one` versus `other`.
pub fn break_even(one: Cost, other: Cost) -> BreakEven {
    let build = one.build_s - other.build_s;
    let ray = one.ray_s - other.ray_s;
    match (build > 0.0, ray > 0.0) {
        _ if build == 0.0 && ray == 0.0 => BreakEven::Same,
        (true, true) => BreakEven::Never,
        (false, false) => BreakEven::Always,
        (true, false) if ray == 0.0 => BreakEven::Never,
        (true, false) => BreakEven::From(-build / ray),
        (false, true) if build == 0.0 => BreakEven::Never,
        (false, true) => BreakEven::Until(-build / ray),
    }
}

/// Range of ray counts over which one structure takes the least time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EnvelopeSegment {
    pub index: usize,
    /// From how many rays on.
    pub from: f64,
}

/// Lower envelope of the cost lines: the fastest row by number of rays.
pub fn envelope(costs: &[Cost]) -> Vec<EnvelopeSegment> {
    let by = |a: &(usize, &Cost), b: &(usize, &Cost)| {
        a.1.build_s.total_cmp(&b.1.build_s).then(a.1.ray_s.total_cmp(&b.1.ray_s))
    };
    let Some((first, cost)) = costs.iter().enumerate().min_by(by) else { return Vec::new() };
    let mut reigns = vec![EnvelopeSegment { index: first, from: 0.0 }];
    let mut current = *cost;
    loop {
        // the next line to cross the current one from above; of several the flattest
        let next =
            costs.iter().enumerate().filter_map(|(i, cost)| match break_even(*cost, current) {
                BreakEven::From(n) => Some((i, *cost, n)),
                _ => None,
            });
        let next = next.min_by(|a, b| a.2.total_cmp(&b.2).then(a.1.ray_s.total_cmp(&b.1.ray_s)));
        let Some((index, cost, from)) = next else { return reigns };
        reigns.push(EnvelopeSegment { index, from });
        current = cost;
    }
}

/// The 95% interval of the count from which on `slower_to_build` is worth it against `other`, of
/// rounds in pairs: of one process from resampled rounds; of several from the counts that each
/// process has by itself, as [`Series::estimate`] does. 0 where a resample or a process has it
/// always, infinite where never. None without common rounds.
pub fn count_interval(slower_to_build: &Profile, other: &Profile, seed: u64) -> Option<[f64; 2]> {
    let mut processes: BTreeMap<u32, Vec<[Cost; 2]>> = BTreeMap::new();
    for (process, both) in slower_to_build.paired(other) {
        processes.entry(process).or_default().push(both);
    }
    let pairs = processes.first_entry()?.get().clone();
    if processes.len() == 1 {
        let mut random = Random::new(seed, "break-even");
        let drawn = |_| {
            let of = pairs.iter().filter_map(|_| pairs.get(random.below(pairs.len())).copied());
            count(&of.collect::<Vec<_>>())
        };
        let counts: Option<Vec<f64>> = (0..RESAMPLES).map(drawn).collect();
        return Some(interval(&mut counts?, pairs.len()));
    }
    let counts = processes.iter().map(|(process, pairs)| Some((*process, count(pairs)?)));
    let counts: Vec<(u32, f64)> = counts.collect::<Option<_>>()?;
    let is_finite = |(_, n): &(u32, f64)| *n > 0.0 && n.is_finite();
    let of_finite: Series = counts.iter().copied().filter(is_finite).collect();
    let [low, high] = match of_finite.estimate(seed) {
        Some(finite) if of_finite.len() > 1 => [finite.low, finite.high],
        _ => [0.0, f64::INFINITY],
    };
    let has = |which: fn(f64) -> bool| counts.iter().any(|(_, n)| which(*n));
    let low = if has(|n| n == 0.0) { 0.0 } else { low };
    let high = if has(f64::is_infinite) { f64::INFINITY } else { high };
    Some([low, high])
}

/// From how many rays on the first is worth it against the second, by the medians of rounds; 0 for
/// always, infinite for never.
fn count(rounds: &[[Cost; 2]]) -> Option<f64> {
    let of = |f: fn(&[Cost; 2]) -> f64| median(&rounds.iter().map(f).collect::<Vec<_>>());
    let one = Cost { build_s: of(|[a, _]| a.build_s)?, ray_s: of(|[a, _]| a.ray_s)? };
    let other = Cost { build_s: of(|[_, b]| b.build_s)?, ray_s: of(|[_, b]| b.ray_s)? };
    Some(match break_even(one, other) {
        BreakEven::From(n) => n,
        BreakEven::Always | BreakEven::Same => 0.0,
        BreakEven::Never | BreakEven::Until(_) => f64::INFINITY,
    })
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

    fn cost(build_s: f64, ray_s: f64) -> Cost {
        Cost { build_s, ray_s }
    }

    #[test]
    fn lines_cross_where_both_take_the_same_time() {
        let (grid, bvh) = (cost(1.0, 0.5), cost(4.0, 0.2));
        assert_eq!(break_even(bvh, grid), BreakEven::From(3.0 / 0.3));
        assert_eq!(break_even(grid, bvh), BreakEven::Until(3.0 / 0.3));
        assert!((grid.total_s(10.0) - bvh.total_s(10.0)).abs() < 1e-12);
        assert_eq!(break_even(cost(1.0, 0.1), bvh), BreakEven::Always);
        assert_eq!(break_even(bvh, cost(1.0, 0.1)), BreakEven::Never);
        assert_eq!(break_even(bvh, bvh), BreakEven::Same);
        assert_eq!(break_even(cost(4.0, 0.3), bvh), BreakEven::Never);
        assert_eq!(break_even(cost(5.0, 0.2), bvh), BreakEven::Never);
        assert_eq!(break_even(cost(3.0, 0.2), bvh), BreakEven::Always);
    }

    #[test]
    fn the_envelope_is_the_least_of_all_lines() {
        let costs =
            [cost(9.0, 0.1), cost(0.0, 5.0), cost(1.0, 1.0), cost(8.0, 0.9), cost(2.0, 1.0)];
        let reigns = envelope(&costs);
        assert_eq!(reigns.iter().map(|r| r.index).collect::<Vec<_>>(), [1, 2, 0]);
        for n in [0.0, 0.1, 0.3, 1.0, 5.0, 8.0, 9.0, 50.0, 1e6] {
            let reign = reigns.iter().rev().find(|r| r.from <= n).unwrap();
            let least = costs.iter().map(|c| c.total_s(n)).fold(f64::INFINITY, f64::min);
            assert!((costs[reign.index].total_s(n) - least).abs() < 1e-9, "{n}");
        }
        assert!(envelope(&[]).is_empty());
    }

    #[test]
    fn three_lines_through_one_point_leave_the_flattest() {
        let costs = [cost(0.0, 2.0), cost(1.0, 1.0), cost(2.0, 0.0)];
        let indices: Vec<usize> = envelope(&costs).iter().map(|r| r.index).collect();
        assert_eq!(indices, [0, 2]);
    }

    /// In how many of 200 trials the interval holds the truth: each process has costs of its own,
    /// which its rounds scatter about.
    fn held(processes: u32, between: f64, of: fn(&Profile, &Profile, u64) -> [f64; 2]) -> u32 {
        let mut random = Random::new(4, "noise");
        let mut noisy =
            |x: f64, by: f64| x * (1.0 - by + 2.0 * by * random.below(1000) as f64 / 999.0);
        let mut held = 0;
        for trial in 0..200 {
            let mut profile = |number, build_s, ray_s| {
                let mut rounds = BTreeMap::new();
                for process in 0..processes {
                    let own = [noisy(build_s, between), noisy(ray_s, between)];
                    rounds.extend((0..15).map(|round| {
                        let [build_s, ray_s] = own.map(|x| noisy(x, 0.1));
                        ((process, process * 15 + round), cost(build_s, ray_s))
                    }));
                }
                Profile::new(number, String::new(), rounds).unwrap()
            };
            let (bvh, grid) = (profile(1, 4.0, 0.2), profile(2, 1.0, 0.5));
            let [low, high] = of(&bvh, &grid, trial);
            held += u32::from(low <= 10.0 && 10.0 <= high);
        }
        held
    }

    #[test]
    fn the_interval_holds_the_truth_about_as_often_as_it_says() {
        let of = |a: &Profile, b: &Profile, seed| count_interval(a, b, seed).unwrap();
        let found = [held(1, 0.0, of), held(3, 0.0, of), held(3, 0.1, of), held(5, 0.1, of)];
        assert!(found.iter().all(|n| (180..=200).contains(n)), "{found:?} of 200");
    }

    #[test]
    fn an_interval_that_ignores_processes_is_caught() {
        let planted = |a: &Profile, b: &Profile, seed| {
            let as_one = |of: &Profile| {
                let rounds = of.rounds.iter().map(|((_, round), cost)| ((0, *round), *cost));
                Profile::new(1, String::new(), rounds.collect()).unwrap()
            };
            count_interval(&as_one(a), &as_one(b), seed).unwrap()
        };
        assert!(held(3, 0.1, planted) < 170);
    }

    #[test]
    fn processes_that_always_or_never_show_an_effect_are_in_the_interval() {
        let of = |costs: &[Cost]| {
            let rounds = costs.iter().zip(0..).map(|(cost, i)| ((i, i), *cost)).collect();
            Profile::new(1, String::new(), rounds).unwrap()
        };
        let grid = of(&[cost(1.0, 0.5); 3]);
        let interval = |costs: &[Cost]| count_interval(&of(costs), &grid, 1).unwrap();
        let bvh = cost(4.0, 0.2);
        let [low, high] = interval(&[bvh; 3]);
        assert!((low - 10.0).abs() < 1e-9 && (high - 10.0).abs() < 1e-9);
        let [low, high] = interval(&[bvh, bvh, cost(0.9, 0.2)]);
        assert!(low == 0.0 && high.is_finite());
        assert_eq!(interval(&[bvh, cost(4.0, 0.6), cost(0.9, 0.2)]), [0.0, f64::INFINITY]);
        assert_eq!(interval(&[cost(4.0, 0.6); 3])[1], f64::INFINITY);
    }
}
