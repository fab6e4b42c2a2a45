//! Proximity clouds against a search, and their jumps against single steps (HARD_CASES Gr9).

use std::collections::VecDeque;

use accel_core::grid::cell_traversal::{CellPosition, CellTraversal};
use accel_core::grid::distance_field::{Metric, distances};
use accel_core::grid::voxel_traversal::GridFrame;
use accel_core::structures::proximity_clouds::Jumps;
use accel_core::{Aabb, Ray, Scalar, Vec3, Vector};
use glam::DVec3;

use super::{Findings, Part};
use crate::verify::draw::{point, unit};
use statistics::random::Random;

/// Rays through a cloud, before the next is drawn.
const RAYS_A_CLOUD: usize = 100;

/// How a field of distances is made: occupied cells, cells per axis, metric, octant.
pub type Field = fn(&[bool], [u32; 3], Metric, Option<usize>) -> Vec<u8>;

/// A cloud of that metric.
macro_rules! cloud {
    ($name:literal, $metric:expr) => {
        Part {
            name: $name,
            single: |random, rays| examine::<f32>(random, rays, $metric, distances),
            double: |random, rays| examine::<f64>(random, rays, $metric, distances),
        }
    };
}

/// The clouds, by metric.
pub const CLOUDS: &[Part] = &[
    cloud!("city-block cloud", Metric::CityBlock),
    cloud!("chessboard cloud", Metric::Chessboard),
    cloud!("euclidean cloud", Metric::Euclidean),
];

/// Which cells of a grid are occupied, and in which directions distances are measured.
struct Cells {
    n: [u32; 3],
    occupied: Vec<bool>,
    /// Bit k set: only downwards on axis k. `None`: in all directions.
    octant: Option<usize>,
}

/// Fields that `field` makes, and rays that jump by them.
pub fn examine<S: Scalar>(
    random: &mut Random,
    rays: usize,
    metric: Metric,
    field: Field,
) -> Findings {
    let mut findings = Findings::default();
    for first in (0..rays).step_by(RAYS_A_CLOUD) {
        let cells = Cells::draw(random);
        let cloud = field(&cells.occupied, cells.n, metric, cells.octant);
        findings.record(cells.compare(&cloud, metric));
        for _ in first + 1..rays.min(first + RAYS_A_CLOUD) {
            findings.record(cells.jumped::<S>(random, &cloud, metric));
        }
    }
    findings
}

impl Cells {
    fn draw(random: &mut Random) -> Self {
        let n = [0; 3].map(|_| 3 + random.below(26) as u32);
        let rate = unit(random) * 0.04;
        let occupied = (0..n.iter().product()).map(|_| unit(random) < rate).collect();
        let octant = random.below(9);
        Self { n, occupied, octant: (octant < 8).then_some(octant) }
    }

    fn index(&self, c: [i32; 3]) -> Option<usize> {
        let n = self.n.map(|n| n as i32);
        let is_inside = (0..3).all(|k| (0..n[k]).contains(&c[k]));
        is_inside.then(|| ((c[2] * n[1] + c[1]) * n[0] + c[0]) as usize)
    }

    fn coords(&self, index: usize) -> [i32; 3] {
        let [x, y, _] = self.n.map(|n| n as usize);
        [index % x, index / x % y, index / (x * y)].map(|c| c as i32)
    }

    /// Whether one looks from a cell towards another that lies `delta` away.
    fn is_ahead(&self, delta: [i32; 3]) -> bool {
        self.octant.is_none_or(|o| {
            (0..3).all(|k| if o >> k & 1 == 0 { delta[k] >= 0 } else { delta[k] <= 0 })
        })
    }

    /// Every distance is at most that of the search.
    fn compare(&self, cloud: &[u8], metric: Metric) -> Result<u64, String> {
        let searched = match metric {
            Metric::Euclidean => self.nearest(),
            Metric::CityBlock | Metric::Chessboard => self.breadth_first(metric),
        };
        let pairs = cloud.iter().zip(&searched).enumerate();
        match pairs.into_iter().find(|(_, (value, right))| u32::from(**value) > **right) {
            Some((i, (value, right))) => {
                Err(format!("{:?} is {right} from the next, not {value}", self.coords(i)))
            }
            None if cloud.len() != searched.len() => Err("a value for each cell".to_owned()),
            None => Ok(0),
        }
    }

    /// Distances found by a breadth-first search backwards from the occupied cells: a step goes to
    /// a neighbour across a face, for the chessboard also across edges and corners.
    fn breadth_first(&self, metric: Metric) -> Vec<u32> {
        let mut found = vec![u32::MAX; self.occupied.len()];
        let mut queue: VecDeque<usize> =
            (0..self.occupied.len()).filter(|&i| self.occupied[i]).collect();
        queue.iter().for_each(|&i| found[i] = 0);
        let steps: Vec<[i32; 3]> = (0..27)
            .map(|i| [i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1])
            .filter(|s| metric == Metric::Chessboard || metric.of(*s) == 1)
            .filter(|s| self.is_ahead(*s))
            .collect();
        while let Some(i) = queue.pop_front() {
            let at = self.coords(i);
            for step in &steps {
                // from there a step leads here
                let Some(j) = self.index(std::array::from_fn(|k| at[k] - step[k])) else {
                    continue;
                };
                if found[j] == u32::MAX {
                    found[j] = found[i] + 1;
                    queue.push_back(j);
                }
            }
        }
        found
    }

    /// Euclidean distances, rounded down, by looking at all occupied cells.
    fn nearest(&self) -> Vec<u32> {
        let occupied: Vec<[i32; 3]> = (0..self.occupied.len())
            .filter(|&i| self.occupied[i])
            .map(|i| self.coords(i))
            .collect();
        let from = |at: [i32; 3]| {
            let deltas = occupied.iter().map(|c| std::array::from_fn(|k| c[k] - at[k]));
            let ahead = deltas.filter(|d| self.is_ahead(*d));
            ahead.map(|d| Metric::Euclidean.of(d)).min().map_or(u32::MAX, u32::isqrt)
        };
        (0..self.occupied.len()).map(|i| from(self.coords(i))).collect()
    }

    /// A ray visits the same occupied cells whether it jumps or steps; but for those that it
    /// crosses for less than rounding, which are counted.
    fn jumped<S: Scalar>(
        &self,
        random: &mut Random,
        cloud: &[u8],
        metric: Metric,
    ) -> Result<u64, String> {
        let size = DVec3::from_array(self.n.map(f64::from));
        let bounds = Aabb { min: Vec3::<S>::splat(S::ZERO), max: Vec3::<S>::from_dvec3(size) };
        let frame = GridFrame::new(bounds, self.n);
        let ray = self.ray::<S>(random, size);
        let (Some(mut steps), Some(mut traversal)) = (frame.traversal(&ray), frame.traversal(&ray))
        else {
            return Ok(0);
        };
        let jumps = Jumps::new(&frame, &ray, metric);
        let mut visited = Vec::new();
        loop {
            let cell = traversal.index();
            let free = cloud.get(cell).copied().unwrap_or(0);
            if self.occupied[cell] {
                visited.push(cell);
            }
            let goes_on = match free {
                0 | 1 => traversal.advance(),
                _ => jumps.jump(&mut traversal, i32::from(free)),
            };
            if !goes_on {
                break;
            }
        }
        let slack = 64.0 * S::EPSILON.to_f64() * size.max_element();
        let fastest = ray.direction.to_dvec3().abs().max_element();
        let (mut from, mut passed) = (0.0, 0);
        loop {
            let (cell, to) = (steps.index(), steps.t_exit().to_f64());
            if self.occupied[cell] && !visited.contains(&cell) {
                if (to - from) * fastest > slack {
                    return Err(format!("{ray:?} jumps past {:?}", steps.coords()));
                }
                passed += 1;
            }
            if !steps.advance() {
                return Ok(passed);
            }
            from = to;
        }
    }

    /// A ray that looks where distances are measured; some components are 0.
    fn ray<S: Scalar>(&self, random: &mut Random, size: DVec3) -> Ray<S> {
        let mut along = point(random).to_array();
        for (k, x) in along.iter_mut().enumerate() {
            if random.below(5) == 0 {
                *x = 0.0;
            }
            *x = match self.octant {
                Some(o) if o >> k & 1 == 1 => -x.abs(),
                Some(_) => x.abs(),
                None => *x,
            };
        }
        let along = DVec3::from_array(along);
        let along = if along == DVec3::ZERO { self.diagonal() } else { along };
        let within = DVec3::from_array([0; 3].map(|_| unit(random))) * size;
        let origin = within - along * (unit(random) * size.max_element());
        Ray::new(Vec3::<S>::from_dvec3(origin), Vec3::<S>::from_dvec3(along))
    }

    /// A direction of the octant.
    fn diagonal(&self) -> DVec3 {
        let octant = self.octant.unwrap_or(0);
        DVec3::from_array([0, 1, 2].map(|k| if octant >> k & 1 == 1 { -1.0 } else { 1.0 }))
    }
}
