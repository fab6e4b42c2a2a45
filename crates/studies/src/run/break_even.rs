//! From how many rays on a structure that takes longer to build is worth it.
//!
//! The time for n rays is T(n) = build + n * time per ray. Two such lines cross once at most; the
//! least time over all n is their lower envelope.

use crate::run::costs::{Cost, Profile};
use statistics::estimate::{interval, median};
use statistics::random::Random;

/// Resamples of an interval.
const RESAMPLES: usize = if cfg!(fuzzing) { 10 } else { 1000 };

/// For how many rays one structure takes less time than another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BreakEven {
    /// For any number.
    Always,
    /// For no number.
    Never,
    /// For more than these: it takes longer to build.
    From(f64),
    /// For fewer than these: it takes longer for a ray.
    Until(f64),
    /// Both take the same time.
    Same,
}

/// Of one against another.
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

/// A stretch of numbers of rays over which one structure takes the least time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Reign {
    /// Which.
    pub index: usize,
    /// From how many rays on.
    pub from: f64,
}

/// Who takes the least time for how many rays, from none on.
pub fn envelope(costs: &[Cost]) -> Vec<Reign> {
    let by = |a: &(usize, &Cost), b: &(usize, &Cost)| {
        a.1.build_s.total_cmp(&b.1.build_s).then(a.1.ray_s.total_cmp(&b.1.ray_s))
    };
    let Some((first, cost)) = costs.iter().enumerate().min_by(by) else { return Vec::new() };
    let mut reigns = vec![Reign { index: first, from: 0.0 }];
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
        reigns.push(Reign { index, from });
        current = cost;
    }
}

/// The 95% interval of the count from which on `slower_to_build` is worth it against `other`, from
/// resampled rounds, paired; 0 where a resample has it always, infinite where never. None without
/// common rounds.
pub fn count_interval(slower_to_build: &Profile, other: &Profile, seed: u64) -> Option<[f64; 2]> {
    let pairs: Vec<[Cost; 2]> = slower_to_build.paired(other).map(|(_, both)| both).collect();
    if pairs.is_empty() {
        return None;
    }
    let mut random = Random::new(seed, "break-even");
    let mut counts = Vec::with_capacity(RESAMPLES);
    for _ in 0..RESAMPLES {
        let drawn: Vec<&[Cost; 2]> =
            pairs.iter().filter_map(|_| pairs.get(random.below(pairs.len()))).collect();
        let of = |f: fn(&[Cost; 2]) -> f64| {
            median(&drawn.iter().map(|pair| f(pair)).collect::<Vec<_>>())
        };
        let one = Cost { build_s: of(|[a, _]| a.build_s)?, ray_s: of(|[a, _]| a.ray_s)? };
        let other = Cost { build_s: of(|[_, b]| b.build_s)?, ray_s: of(|[_, b]| b.ray_s)? };
        counts.push(match break_even(one, other) {
            BreakEven::From(n) => n,
            BreakEven::Always | BreakEven::Same => 0.0,
            BreakEven::Never | BreakEven::Until(_) => f64::INFINITY,
        });
    }
    Some(interval(&mut counts, pairs.len()))
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

    #[test]
    fn the_interval_holds_the_truth_about_as_often_as_it_says() {
        let mut random = Random::new(4, "noise");
        let mut noisy = |x: f64| x * (0.9 + 0.2 * random.below(1000) as f64 / 999.0);
        let mut held = 0;
        for trial in 0..200 {
            let mut profile = |number, build_s, ray_s| {
                let rounds =
                    (0..15).map(|i| ((0, i), cost(noisy(build_s), noisy(ray_s)))).collect();
                Profile::new(number, String::new(), rounds).unwrap()
            };
            let (bvh, grid) = (profile(1, 4.0, 0.2), profile(2, 1.0, 0.5));
            let [low, high] = count_interval(&bvh, &grid, trial).unwrap();
            held += u32::from(low <= 10.0 && 10.0 <= high);
        }
        assert!((180..=199).contains(&held), "{held} of 200");
    }
}
