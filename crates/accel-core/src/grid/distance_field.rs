//! Distances of the voxels of a grid to the nearest occupied one, exact, in three metrics.
//!
//! All three are separable: the distance along x first, then the best over y of what x gave and the
//! way along y, then z (T. Saito, J. Toriwaki, "New Algorithms for Euclidean Distance
//! Transformation of an n-Dimensional Digitized Picture", Pattern Recognition 27, 1994). Along an
//! axis each voxel is a candidate for those before it; of two, the nearer is the better one from
//! some voxel on, and stays it, in every metric. So a queue of candidates, each with the voxel from
//! which it is better than the one before it, gives all of a line in linear time (A. Meijster, J.
//! Roerdink, W. Hesselink, "A General Algorithm for Computing Distance Transforms in Linear Time",
//! Mathematical Morphology and its Applications to Image and Signal Processing, 2000). Deviation:
//! each side is looked at by itself, as octants need it.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicU16, Ordering::Relaxed};

use crate::parallel::{collect, forks, map, ranges};

/// How distances between voxels are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Metric {
    /// |dx| + |dy| + |dz|.
    CityBlock,
    Chessboard,
    /// sqrt(dx^2 + dy^2 + dz^2), rounded down.
    Euclidean,
}

/// The largest distance kept.
const CAP: u16 = 255;

impl Metric {
    /// The measure between voxels so far apart; the square for the Euclidean metric.
    pub fn of(self, delta: [i32; 3]) -> u32 {
        let d = delta.map(i32::unsigned_abs);
        match self {
            Self::CityBlock => d[0] + d[1] + d[2],
            Self::Chessboard => d[0].max(d[1]).max(d[2]),
            Self::Euclidean => d[0] * d[0] + d[1] * d[1] + d[2] * d[2],
        }
    }

    /// Measure of a way of `d` along one axis.
    #[inline(always)]
    fn along(self, d: u16) -> u16 {
        if self == Self::Euclidean { d.saturating_mul(d) } else { d }
    }

    /// Measure of a way that measures `a` on some axes and `b` on the others.
    #[inline(always)]
    fn combined(self, a: u16, b: u16) -> u16 {
        if self == Self::Chessboard { a.max(b) } else { a.saturating_add(b) }
    }

    /// The last place, downwards, from which on the nearer of two values, each with its place, is
    /// no worse.
    #[inline(always)]
    fn better_from(self, near: (i64, i64), far: (i64, i64)) -> i64 {
        let (between, more) = (far.0 - near.0, near.1 - far.1);
        match self {
            Self::CityBlock if more <= between => near.0,
            Self::CityBlock => i64::MIN,
            Self::Chessboard if more <= 0 => near.0,
            Self::Chessboard => near.0.min(far.0 - near.1),
            Self::Euclidean => ((near.0 + far.0) * between - more).div_euclid(2 * between),
        }
    }

    /// The distance kept for a measure.
    fn kept(self, measure: u16) -> u8 {
        let distance = if self == Self::Euclidean { measure.isqrt() } else { measure };
        distance.min(CAP) as u8
    }
}

/// For every voxel (x fastest) its distance to the nearest occupied one, at most 255; 0 in
/// occupied ones. With an octant only voxels ahead count: bit k of it set means that ahead is
/// downwards on axis k. Lines are gone through on all threads.
pub fn distances(occupied: &[bool], n: [u32; 3], metric: Metric, octant: Option<usize>) -> Vec<u8> {
    // each is read and written by the one thread that goes through its line
    let measure = |&o: &bool| AtomicU16::new(if o { 0 } else { metric.along(CAP) });
    let field: Vec<AtomicU16> = occupied.iter().map(measure).collect();
    let n = n.map(|n| n as usize);
    let mut stride = 1;
    for (k, &length) in n.iter().enumerate() {
        let sides = match octant {
            None => [true, true],
            Some(octant) => [octant >> k & 1 == 0, octant >> k & 1 == 1],
        };
        let lines = field.len() / length.max(1);
        // some for each thread, as they take their time
        let parts = ranges(lines, if forks() == 0 { 1 } else { 1 << forks() });
        map(&parts, &|part| {
            let (mut values, mut queue) = (vec![0; length], VecDeque::with_capacity(length));
            for line in part.clone() {
                let first = line / stride * stride * length + line % stride;
                let voxels = Line { field: &field[first..], length, stride };
                voxels.measure(metric, sides, &mut values, &mut queue);
            }
        });
        stride *= length;
    }
    collect(field.len(), |i| metric.kept(field[i].load(Relaxed)))
}

/// Voxels along an axis.
struct Line<'a> {
    /// Begins with the first.
    field: &'a [AtomicU16],
    length: usize,
    stride: usize,
}

impl Line<'_> {
    fn at(&self, i: usize) -> &AtomicU16 {
        &self.field[i * self.stride]
    }

    /// Makes each voxel's value the least measure of a way to one ahead: upwards, downwards, or on
    /// both sides.
    #[inline(always)]
    fn measure(
        &self,
        metric: Metric,
        [up, down]: [bool; 2],
        values: &mut [u16],
        queue: &mut VecDeque<Candidate>,
    ) {
        for (i, value) in values.iter_mut().enumerate() {
            *value = self.at(i).load(Relaxed);
        }
        let (length, values) = (self.length, &*values);
        if up {
            let say = |i: usize, m| self.at(i).store(m, Relaxed);
            least_ahead(length, metric, |i| values[i], queue, say);
        }
        if down {
            let last = length - 1;
            least_ahead(
                length,
                metric,
                |i| values[last - i],
                queue,
                |i, m| {
                    let least = self.at(last - i);
                    least.store(least.load(Relaxed).min(m), Relaxed);
                },
            );
        }
    }
}

/// A voxel of a line whose value may be the least for voxels before it.
struct Candidate {
    at: i64,
    value: i64,
    /// From here on, downwards, it is no worse than the candidate before it.
    from: i64,
}

/// Tells `say` for every place of a line the least measure of a value there or behind it together
/// with the way to it, at most that of [`CAP`].
#[inline(always)]
fn least_ahead(
    length: usize,
    metric: Metric,
    value: impl Fn(usize) -> u16,
    queue: &mut VecDeque<Candidate>,
    mut say: impl FnMut(usize, u16),
) {
    queue.clear();
    let most = metric.along(CAP);
    for i in (0..length).rev() {
        let (at, own) = (i as i64, i64::from(value(i)));
        let mut from = i64::MAX;
        // one that is as good before the last candidate is the best takes its place
        while let Some(last) = queue.back() {
            from = metric.better_from((at, own), (last.at, last.value));
            if from < last.from.min(at) {
                break;
            }
            queue.pop_back();
            from = i64::MAX;
        }
        queue.push_back(Candidate { at, value: own, from });
        while queue.get(1).is_some_and(|next| next.from >= at) {
            queue.pop_front();
        }
        let Some(best) = queue.front() else { continue };
        // longer ways all measure more than the most
        let way = (best.at - at).min(i64::from(CAP) + 1) as u16;
        say(i, metric.combined(best.value as u16, metric.along(way)).min(most));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    const METRICS: [Metric; 3] = [Metric::CityBlock, Metric::Chessboard, Metric::Euclidean];

    #[test]
    fn distances_equal_those_found_by_search() {
        let n = [9u32, 7, 12];
        let cells = (n[0] * n[1] * n[2]) as usize;
        let at = |i: usize| [i % 9, i / 9 % 7, i / 63].map(|c| c as i32);
        for filled in [vec![0], vec![cells - 1, 100], vec![5, 300, 301, 520], vec![]] {
            let mut occupied = vec![false; cells];
            filled.iter().for_each(|&i: &usize| occupied[i] = true);
            for metric in METRICS {
                for octant in (0..8).map(Some).chain([None]) {
                    let field = distances(&occupied, n, metric, octant);
                    for (i, &found) in field.iter().enumerate() {
                        let delta = |&j: &usize| [0, 1, 2].map(|k| at(j)[k] - at(i)[k]);
                        let side = |o: usize, k: usize| if o >> k & 1 == 0 { 1 } else { -1 };
                        let is_ahead = |d: &[i32; 3]| {
                            octant.is_none_or(|o| (0..3).all(|k| d[k] * side(o, k) >= 0))
                        };
                        let ahead = filled.iter().map(delta).filter(is_ahead);
                        let nearest = ahead.map(|d| metric.of(d)).min();
                        let root = |m: u32| if metric == Metric::Euclidean { m.isqrt() } else { m };
                        let expected = nearest.map_or(255, root);
                        assert_eq!(u32::from(found), expected, "{metric:?} {octant:?} {i}");
                    }
                }
            }
        }
    }

    /// Random lines, longer than any distance kept, against search.
    #[test]
    fn lines_equal_those_found_by_search() {
        let mut random = Random(7);
        for length in [1, 2, 3, 40, 600] {
            for metric in METRICS {
                for most in [2.0, 40.0, 300.0, 65026.0] {
                    let cap = metric.along(CAP);
                    let mut value = |_| ((random.unit() * most) as u16).min(cap);
                    let line: Vec<u16> = (0..length).map(&mut value).collect();
                    let check = |i, found| {
                        let way = |j| metric.combined(line[j], metric.along((j - i) as u16));
                        let ways = (i..length.min(i + 256)).map(way);
                        assert_eq!(Some(found), ways.min(), "{metric:?} {i} of {length}");
                    };
                    least_ahead(length, metric, |i| line[i], &mut VecDeque::new(), check);
                }
            }
        }
    }

    #[test]
    fn long_grids_are_capped() {
        let mut occupied = vec![false; 1000];
        occupied[0] = true;
        for metric in METRICS {
            let field = distances(&occupied, [1000, 1, 1], metric, None);
            assert_eq!((field[200], field[254], field[999]), (200, 254, 255));
        }
    }
}
