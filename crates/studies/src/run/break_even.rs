//! From how many rays on a structure that takes longer to build is worth it.
//!
//! The time for n rays is T(n) = build + n * time per ray. Two such lines cross once at most; the
//! least time over all n is their lower envelope.

use std::collections::BTreeMap;

use crate::run::costs::{Cost, Profile};
use statistics::estimate::{interval, median};
use statistics::random::Random;
use statistics::series::Series;

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
