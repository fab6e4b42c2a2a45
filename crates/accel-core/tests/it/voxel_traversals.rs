//! Traversals through regular grids against exact integers (HARD_CASES T1, T3, T4).
//!
//! Three demands, all for the whole way through the grid, up to a tolerance of a few epsilon of the
//! largest coordinate (boxes are inserted padded by 64 of them):
//! * each exactly pierced cell is visited, unless it is crossed for less than the tolerance;
//! * between the exits of two successive cells the ray stays within the second one, grown by the
//!   tolerance: what the ray meets is listed there, and the traversal does not end before;
//! * a step changes one coordinate by one, and there are at most 3 N cells.

use accel_core::grid::cell_traversal::{CellPosition, CellTraversal};
use accel_core::grid::voxel_traversal::GridFrame;
use accel_core::{Aabb, Ray, Scalar, Vec3, Vector};
use glam::{DVec3, dvec3};

use crate::common::Random;
use crate::integer_ray::{IntegerRay, PiercedCell};

fn below(random: &mut Random, n: usize) -> usize {
    (random.unit() * n as f64) as usize
}

/// Draws grids and rays.
type RayGenerator = fn(&mut Random, usize) -> Vec<GridRay>;

/// A ray through a grid of `n` cells per axis, in f64; its numbers are those of single precision.
#[derive(Debug, Clone, Copy)]
struct GridRay {
    /// Cells an axis.
    n: u32,
    /// Side of a cell.
    side: f64,
    /// Lower corner of the grid on every axis.
    low: f64,
    /// Origin of the ray.
    origin: DVec3,
    /// Its direction.
    direction: DVec3,
}

/// Faults of the traversals that `start` makes, over this many questions.
fn wrong<S: Scalar, W: CellTraversal<S>>(
    rays_of: RayGenerator,
    rays: usize,
    start: impl Fn(&GridFrame<S>, &Ray<S>) -> Option<W>,
) -> Vec<String> {
    let judged = |question: GridRay| {
        let (frame, ray) = question.posed::<S>();
        let outcome = question.judge(&frame, start(&frame, &ray));
        outcome.err().map(|what| format!("{question:?}: {what}"))
    };
    rays_of(&mut Random::new(1), rays).into_iter().filter_map(judged).collect()
}

impl GridRay {
    fn posed<S: Scalar>(&self) -> (GridFrame<S>, Ray<S>) {
        let high = self.low + self.side * f64::from(self.n);
        let [low, high] = [self.low, high].map(|x| Vec3::<S>::splat(S::from_f64(x)));
        let frame = GridFrame::new(Aabb { min: low, max: high }, [self.n; 3]);
        (frame, Ray::from_dvec3(self.origin, self.direction))
    }

    /// Tolerance in cells. The numbers of the question are exact, so that only the parameters of
    /// planes are rounded: by one epsilon of the distance each, and comparisons involve two.
    fn tolerance<S: Scalar>(&self) -> f64 {
        let way = f64::from(self.n) + self.in_cells().0.abs().max_element();
        4.0 * S::EPSILON.to_f64() * way
    }

    /// Origin and direction in cells of the grid.
    fn in_cells(&self) -> (DVec3, DVec3) {
        ((self.origin - self.low) / self.side, self.direction / self.side)
    }

    /// Number of exact cells missed within the tolerance; or the fault.
    fn judge<S: Scalar>(
        &self,
        frame: &GridFrame<S>,
        traversal: Option<impl CellTraversal<S>>,
    ) -> Result<u64, String> {
        let (origin, direction) = self.in_cells();
        let exact = IntegerRay::new(origin, direction).map(|r| r.pierced(self.n as i32));
        let exact = exact.unwrap_or_default();
        let visited = match traversal {
            Some(traversal) => self.followed(frame, traversal)?,
            None => Vec::new(),
        };
        self.missed::<S>(&visited, &exact)
    }

    /// The cells of a traversal, each of which holds its part of the ray.
    fn followed<S: Scalar>(
        &self,
        frame: &GridFrame<S>,
        mut traversal: impl CellTraversal<S>,
    ) -> Result<Vec<[i32; 3]>, String> {
        let n = self.n as i32;
        let slack = self.tolerance::<S>();
        let (origin, direction) = self.in_cells();
        let grid = Aabb::<f64> { min: DVec3::ZERO, max: DVec3::splat(f64::from(n)) };
        let within = grid.clip(origin, direction, 0.0, f64::INFINITY);
        let (mut from, end) = within.unwrap_or((f64::NAN, f64::NAN));
        let mut visited: Vec<[i32; 3]> = Vec::new();
        loop {
            let cell = traversal.coords();
            if cell.iter().any(|c| !(0..n).contains(c)) || frame.index(cell) != traversal.index() {
                return Err(format!("{cell:?} is no cell, or not number {}", traversal.index()));
            }
            if let Some(last) = visited.last()
                && (0..3).map(|k| (cell[k] - last[k]).abs()).sum::<i32>() != 1
            {
                return Err(format!("a step from {last:?} to {cell:?}"));
            }
            visited.push(cell);
            if visited.len() > 3 * n as usize {
                return Err(format!("more than {} cells", 3 * n));
            }
            let to = traversal.t_exit().to_f64();
            let low = DVec3::from_array(cell.map(f64::from)) - slack;
            let high = low + (1.0 + 2.0 * slack);
            for t in [from, to].into_iter().filter(|t| t.is_finite()) {
                let p = origin + direction * t;
                if p.cmplt(low).any() || p.cmpgt(high).any() {
                    return Err(format!("at {t:?} the ray is not within {cell:?} but at {p:?}"));
                }
            }
            if !traversal.advance() {
                let left = (end - to) * direction.abs().max_element();
                return if left > slack { Err(format!("ends at {cell:?}")) } else { Ok(visited) };
            }
            from = to;
        }
    }

    /// Counts the exact cells that were passed by; an error where one is crossed for long.
    fn missed<S: Scalar>(
        &self,
        visited: &[[i32; 3]],
        exact: &[PiercedCell],
    ) -> Result<u64, String> {
        let slack = self.tolerance::<S>();
        let first = visited.first().copied().unwrap_or_default();
        let signs = self.direction.signum().to_array().map(|s| s as i32);
        let mut missed = 0;
        for PiercedCell { cell, length } in exact {
            // one coordinate a step: the number of steps says where a cell must stand
            let steps: i32 = (0..3).map(|k| signs[k] * (cell[k] - first[k])).sum();
            let is_visited = usize::try_from(steps).is_ok_and(|i| visited.get(i) == Some(cell));
            if !is_visited && *length > slack {
                return Err(format!("missed {cell:?}, crossed for {length:e} cells"));
            }
            missed += u64::from(!is_visited);
        }
        Ok(missed)
    }
}

/// Origins in 1024ths of a cell, directions of whole numbers up to 2^20, each ray in a grid of
/// 16, 32, ... 1024 cells per axis: so many rays for each.
fn lattice_rays(random: &mut Random, rays: usize) -> Vec<GridRay> {
    let sizes = (4..=10).map(|power| 1_u32 << power);
    sizes.flat_map(|n| (0..rays).map(|_| lattice_ray(random, n)).collect::<Vec<_>>()).collect()
}

fn lattice_ray(random: &mut Random, n: u32) -> GridRay {
    let parts = 1024 * n as usize;
    let mut point = |origin: f64, size: usize| {
        let mut at = || origin + below(random, size + 1) as f64;
        dvec3(at(), at(), at())
    };
    let (inside, around) = (point(0.0, parts), point(-(parts as f64), 3 * parts));
    let target = point(0.0, parts);
    let bits = below(random, 21);
    let mut whole = || below(random, (2 << bits) + 1) as f64 - f64::from(1_u32 << bits);
    let any = dvec3(whole(), whole(), whole());
    let (origin, direction) = match below(random, 4) {
        0 => (inside, any),
        // on cell planes: ties and rays within them
        1 => ((inside / 1024.0).floor() * 1024.0, any),
        2 => (inside, target - inside),
        _ => (around, ((target - around) / 4.0).trunc()),
    };
    let direction = if direction == DVec3::ZERO { DVec3::Z } else { direction };
    GridRay { n, side: 1.0, low: 0.0, origin: origin / 1024.0, direction }
}

/// Two rays that are known to have broken traversals, through cells of side 16; then the same moved
/// by whole numbers and mirrored.
fn published_rays(random: &mut Random, rays: usize) -> Vec<GridRay> {
    let published = [
        (dvec3(-668.0, -340.0, 77.0), dvec3(404.0, -64.0, -784.0)),
        (dvec3(386.71, 137.41, 7.06), dvec3(416.0, 142.0, 0.0)),
    ];
    let one = |i: usize| {
        let [first, second] = published;
        let (from, to) = if i.is_multiple_of(2) { first } else { second };
        let mut whole = || below(random, 129) as f64 - 64.0;
        let by = if i < 2 { DVec3::ZERO } else { dvec3(whole(), whole(), whole()) };
        let sign = if (i / 2).is_multiple_of(2) { 1.0 } else { -1.0 };
        // 1024ths, so that single precision holds the ends and their difference
        let exact = |p: DVec3| ((p * 1024.0).round() / 1024.0 + by) * sign;
        let (from, to) = (exact(from), exact(to));
        GridRay { n: 128, side: 16.0, low: -1024.0, origin: from, direction: to - from }
    };
    (0..rays).map(one).collect()
}

/// Origins about 10^6 grids away, aimed at points of the grid's surface: the point of entry rounds
/// to a cell beyond the last.
fn far_origins(random: &mut Random, rays: usize) -> Vec<GridRay> {
    let one = |_| {
        let n = random.one_of(&[8_u32, 100, 1024]);
        let side = f64::from(n);
        let axis = below(random, 3);
        let mut at = || (below(random, 4) as f64 / 3.0 * side).floor();
        let mut target = [at(), at(), at()];
        let mut direction = [0.0; 3];
        let sign = random.one_of(&[1.0, -1.0]);
        let slant = [0.0, 1.0, -3.0];
        for k in 0..3 {
            direction[k] = if k == axis { -1024.0 * sign } else { random.one_of(&slant) };
            if k == axis {
                target[k] = if sign > 0.0 { side } else { 0.0 };
            }
        }
        let (direction, target) = (DVec3::from_array(direction), DVec3::from_array(target));
        let far = target - direction * (side * 1e6 / 1024.0).round();
        GridRay { n, side: 1.0, low: 0.0, origin: far.as_vec3().as_dvec3(), direction }
    };
    (0..rays).map(one).collect()
}

fn agrees<S: Scalar>() {
    for (rays_of, rays) in [
        (lattice_rays as RayGenerator, 2000),
        (published_rays as RayGenerator, 2000),
        (far_origins as RayGenerator, 2000),
    ] {
        assert_eq!(wrong::<S, _>(rays_of, rays, |f, r| f.traversal(r)), [""; 0]);
        assert_eq!(
            wrong::<S, _>(rays_of, rays, |f, r| f.driving_traversal_from(r, S::ZERO)),
            [""; 0]
        );
    }
}

#[test]
fn both_traversals_visit_what_is_crossed_in_f32() {
    agrees::<f32>();
}

#[test]
fn both_traversals_visit_what_is_crossed_in_f64() {
    agrees::<f64>();
}

/// The real traversal, but for one of its cells.
struct Hasty<W>(W, u32);

impl<W: CellPosition> CellPosition for Hasty<W> {
    fn index(&self) -> usize {
        self.0.index()
    }
    fn coords(&self) -> [i32; 3] {
        self.0.coords()
    }
}

impl<W: CellTraversal<f32>> CellTraversal<f32> for Hasty<W> {
    fn t_exit(&self) -> f32 {
        self.0.t_exit()
    }
    fn advance(&mut self) -> bool {
        self.1 += 1;
        self.0.advance() && (self.1 != 9 || self.0.advance())
    }
}

#[test]
fn planted_traversals_that_drift_or_skip_are_found() {
    let accumulates = |f: &GridFrame<f32>, r: &Ray<f32>| f.accumulating_traversal_from(r, 0.0);
    let drifts = wrong::<f32, _>(lattice_rays, 150, accumulates);
    let is_lost = |what: &&String| what.contains("missed") || what.contains("not within");
    assert!(drifts.iter().any(|what| is_lost(&what)) && drifts.len() < 7 * 150);
    let skips = |f: &GridFrame<f32>, r: &Ray<f32>| f.traversal(r).map(|w| Hasty(w, 0));
    assert!(wrong::<f32, _>(lattice_rays, 50, skips).iter().any(|w| w.contains("a step from")));
}
