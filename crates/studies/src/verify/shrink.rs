//! Reduces a failure to few triangles and, if possible, one ray with short coordinates.
//!
//! A. Zeller and R. Hildebrandt, "Simplifying and Isolating Failure-Inducing Input", 2002: parts of
//! the input are left out while the rest still fails in the same way. Then each number is replaced
//! by a shorter one likewise. The work is bounded by a count, not by time, so that results repeat.

use std::cell::Cell;

use accel_core::registry::Buildable;
use accel_core::{Hit, Ray};
use glam::DVec3;

use super::judge::{Difference, Judge, Mismatch, RoundVerdict};
use super::replay::Replay;
use super::round::{Corners, OracleAnswer, Round, corners_of, model_of};
use super::subject::Subject;
use measurement::settings::Precision;

/// Trials, each of a build and a few rays, and triangles and rays of all trials together.
const MOST_TRIALS: u32 = 3000;
const MOST_WORK: usize = 5_000_000;

/// Trials that may end the process of a plugin.
const MOST_DEATHS: usize = 300;

/// Numbers of a triangle and of a ray.
const PER_TRIANGLE: usize = 9;
const PER_RAY: usize = 8;

#[derive(Debug)]
pub struct ReducedFailure {
    pub replay: Replay,
    /// Triangles and rays of the round.
    pub from: [usize; 2],
    pub triangles: Vec<Corners>,
    /// The rays: more than one only if no single ray fails alone.
    pub rays: Vec<Ray<f64>>,
    pub what: String,
    /// The answers of brute force to the rays: hits, and which of them are blocked.
    pub right: (Vec<Hit<f64>>, Vec<bool>),
}

/// Reduces the failure of one trial; none where it has no triangles, where only the case's oracle
/// sees it, or where it does not repeat.
pub fn shrink(replay: &Replay, subject: &Subject<'_>) -> Option<ReducedFailure> {
    let round = replay.round;
    match round.precision {
        Precision::F32 => reduced(&round.drawn(round.case.single).ok()?, replay, subject),
        Precision::F64 => reduced(&round.drawn(round.case.double).ok()?, replay, subject),
    }
}

fn reduced<S: Buildable>(
    round: &Round<S>,
    replay: &Replay,
    subject: &Subject<'_>,
) -> Option<ReducedFailure> {
    let search = Search {
        test: &|triangles, rays| wrong::<S>(triangles, rays, subject),
        trials: Cell::new(MOST_TRIALS),
        work: Cell::new(MOST_WORK),
    };
    let widened = |rays: &[Ray<S>]| rays.iter().map(Ray::widened).collect::<Vec<_>>();
    let pairs = round.pairs.iter().map(|pair| (&pair.model, widened(&pair.rays)));
    let scenes: Vec<_> = [(&round.model, widened(&round.rays))].into_iter().chain(pairs).collect();
    let alone =
        scenes.iter().filter_map(|(model, rays)| Some((model, vec![*rays.get(replay.ray)?])));
    let all = scenes.iter().map(|(model, rays)| (model, rays.clone()));
    let (mut triangles, mut rays, first) = alone.chain(all).find_map(|(model, rays)| {
        let triangles = corners_of(model)?;
        let first = search.failure(&triangles, &rays)?;
        Some((triangles, rays, first))
    })?;
    let from = [triangles.len(), round.rays.len()];
    let kind = first.difference;
    rays = minimal(rays, |some| search.fails(&triangles, some, kind));
    triangles = minimal(triangles, |some| search.fails(some, &rays, kind));
    search.simplify(&mut triangles, &mut rays, kind);
    triangles = minimal(triangles, |some| search.fails(some, &rays, kind));
    let what = wrong::<S>(&triangles, &rays, subject)?.what;
    let right = Judge::new(&round_of::<S>(&triangles, &rays)?).ok()?.right();
    Some(ReducedFailure { replay: replay.clone(), from, triangles, rays, what, right })
}

/// Test of a scene that returns the first wrong answer, if any.
type FailureTest<'a> = &'a dyn Fn(&[Corners], &[Ray<f64>]) -> Option<Mismatch>;

/// The trials of a search, which end when the work is done.
struct Search<'a> {
    test: FailureTest<'a>,
    trials: Cell<u32>,
    work: Cell<usize>,
}

impl Search<'_> {
    /// The fault; `None` once there were enough trials.
    fn failure(&self, triangles: &[Corners], rays: &[Ray<f64>]) -> Option<Mismatch> {
        self.trials.set(self.trials.get().checked_sub(1)?);
        self.work.set(self.work.get().checked_sub(triangles.len() + rays.len())?);
        let found = (self.test)(triangles, rays);
        if found.as_ref().is_some_and(|found| found.difference.is_none()) {
            self.work.set(self.work.get().saturating_sub(MOST_WORK / MOST_DEATHS));
        }
        found
    }

    fn fails(&self, triangles: &[Corners], rays: &[Ray<f64>], kind: Option<Difference>) -> bool {
        self.failure(triangles, rays).is_some_and(|found| found.difference == kind)
    }

    /// Makes numbers shorter where the scene fails as well.
    fn simplify(&self, triangles: &mut [Corners], rays: &mut [Ray<f64>], kind: Option<Difference>) {
        let (of_triangles, most_flat) = (PER_TRIANGLE * triangles.len(), flat(triangles));
        let mut is_changed = true;
        while is_changed {
            is_changed = false;
            for i in (0..of_triangles + PER_RAY * rays.len()).rev() {
                let is_end = i >= of_triangles && (i - of_triangles) % PER_RAY == 7;
                let before = *number(triangles, rays, i);
                for shorter in shorter(before, is_end) {
                    *number(triangles, rays, i) = shorter;
                    // another fault may begin where triangles have no area
                    let is_flat = flat(triangles) > most_flat;
                    if !is_flat && self.fails(triangles, rays, kind) {
                        is_changed = true;
                        break;
                    }
                    *number(triangles, rays, i) = before;
                }
            }
        }
    }
}

/// The items that are needed for a failure: none can be left out alone, as far as trials last.
fn minimal<T: Clone>(mut items: Vec<T>, fails: impl Fn(&[T]) -> bool) -> Vec<T> {
    let mut parts = 2;
    while items.len() > 1 {
        let size = items.len().div_ceil(parts);
        let mut rests = (0..items.len()).step_by(size).map(|at| {
            let after = items.len().min(at + size);
            [&items[..at], &items[after..]].concat()
        });
        match rests.find(|rest| fails(rest)) {
            Some(rest) => {
                items = rest;
                parts = (parts - 1).max(2);
            }
            None if size == 1 => break,
            None => parts = (2 * parts).min(items.len()),
        }
    }
    items
}

/// Number `i` of a scene: those of all triangles, then those of all rays.
fn number<'a>(triangles: &'a mut [Corners], rays: &'a mut [Ray<f64>], i: usize) -> &'a mut f64 {
    let of_triangles = PER_TRIANGLE * triangles.len();
    if i < of_triangles {
        return &mut triangles.as_flattened_mut()[i / 3][i % 3];
    }
    let (ray, i) = ((i - of_triangles) / PER_RAY, (i - of_triangles) % PER_RAY);
    match i {
        0..3 => &mut rays[ray].origin[i],
        3 => &mut rays[ray].t_min,
        4..7 => &mut rays[ray].direction[i - 4],
        _ => &mut rays[ray].t_max,
    }
}

fn flat(triangles: &[Corners]) -> usize {
    let is_flat = |[a, b, c]: &&Corners| (*b - *a).cross(*c - *a) == DVec3::ZERO;
    triangles.iter().filter(is_flat).count()
}

/// Numbers near `x` that take fewer characters, the shortest first; the end of an interval may be
/// infinite.
fn shorter(x: f64, is_end: bool) -> Vec<f64> {
    let sign = 1f64.copysign(x);
    let bits = [0, 1, 2, 3, 5, 8, 12, 16, 20].map(|bits| rounded(x, bits));
    let ends = is_end.then_some(f64::INFINITY);
    let mut all: Vec<f64> = [0.0, sign, x.round()].into_iter().chain(ends).chain(bits).collect();
    all.retain(|other| length(*other) < length(x));
    all.sort_by_key(|x| length(*x));
    all.dedup();
    all
}

/// Rounded to so many bits behind the first.
fn rounded(x: f64, bits: u32) -> f64 {
    let dropped = 52 - bits;
    let half = 1_u64 << (dropped - 1);
    f64::from_bits((x.to_bits() + half) & !((1 << dropped) - 1))
}

/// How long a number is: its bits, and those of its exponent and sign.
fn length(x: f64) -> u32 {
    if x == 0.0 || x == f64::INFINITY {
        return u32::from(x.is_sign_negative());
    }
    let exponent = (x.abs().to_bits() >> 52) as i32 - 1023;
    let fraction = x.to_bits() << 12;
    let bits = if fraction == 0 { 0 } else { 64 - fraction.trailing_zeros() };
    2 + 2 * bits + (32 - exponent.unsigned_abs().leading_zeros()) + u32::from(x < 0.0)
}

/// The first wrong answer of the subject over these triangles.
fn wrong<S: Buildable>(
    triangles: &[Corners],
    rays: &[Ray<f64>],
    subject: &Subject<'_>,
) -> Option<Mismatch> {
    let round = round_of::<S>(triangles, rays)?;
    match Judge::new(&round).ok()?.judge(subject) {
        RoundVerdict::Asked(all, _) => all.into_iter().find(|mismatch| mismatch.is_wrong),
        RoundVerdict::Refused(_) | RoundVerdict::NotAsked => None,
    }
}

fn round_of<S: Buildable>(triangles: &[Corners], rays: &[Ray<f64>]) -> Option<Round<S>> {
    let mut round = Round::new(model_of(triangles).ok()?);
    for ray in rays {
        let (t_min, t_max) = (S::from_f64(ray.t_min), S::from_f64(ray.t_max));
        let ray = Ray { t_min, t_max, ..Ray::from_dvec3(ray.origin, ray.direction) };
        round.push(ray, OracleAnswer::Anything);
    }
    Some(round)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn minimal_keeps_the_elements_needed() {
        let needed = |some: &[u32]| [3, 40, 41].iter().all(|n| some.contains(n));
        assert_eq!(minimal((0..100).collect(), needed), [3, 40, 41]);
        // at least one stays, whatever fails
        assert_eq!(minimal(vec![1, 2, 3], |_| true).len(), 1);
        assert_eq!(minimal(vec![1, 2, 3], |_| false), [1, 2, 3]);
    }

    #[test]
    fn numbers_get_shorter_only() {
        for x in [0.1, -7.3e-12, 1e30, 0.75, 3.0, -0.0, f64::from(f32::MAX)] {
            for other in shorter(x, true) {
                assert!(length(other) < length(x), "{x} {other}");
            }
        }
        assert!(shorter(0.1, false).contains(&0.0) && shorter(5.0, true).contains(&f64::INFINITY));
        assert_eq!(shorter(-0.0, false), [0.0]);
        assert!(shorter(0.0, false).is_empty());
        assert_eq!(rounded(0.7, 1), 0.75);
    }

    #[test]
    fn every_number_of_a_scene_has_its_place() {
        let (mut triangles, mut rays) = ([[DVec3::ONE; 3]; 2], [Ray::new(DVec3::ONE, DVec3::X)]);
        (0..26).for_each(|i| *number(&mut triangles, &mut rays, i) = i as f64);
        assert_eq!(triangles[1].map(|p| p.x), [9.0, 12.0, 15.0]);
        let ray = Ray::new(DVec3::new(18.0, 19.0, 20.0), DVec3::new(22.0, 23.0, 24.0));
        assert_eq!(rays, [Ray { t_min: 21.0, t_max: 25.0, ..ray }]);
        assert_eq!(flat(&[[DVec3::X, DVec3::Y, DVec3::Z]]), 0);
        assert_eq!(flat(&[[DVec3::X, DVec3::X * 2.0, DVec3::X * 5.0]]), 1);
    }
}
