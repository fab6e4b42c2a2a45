//! Proximity clouds: every empty voxel knows how far the nearest occupied one is, and a ray jumps
//! that far.
//!
//! Paper: D. Cohen, Z. Sheffer, "Proximity Clouds - an Acceleration Technique for 3D Grid
//! Traversal", The Visual Computer 11, 1994.
//!
//! Deviations. Distances are computed exactly, axis after axis, by one routine for all metrics in
//! place of the paper's approximate passes (capped at 255: smaller values are always safe; the
//! Euclidean one is rounded down). A jump goes as far as the metric's ball reaches from the current
//! voxel, and is checked in whole voxels: one that rounding made too long becomes a single step.
//! The direction-aware variant keeps eight distances a voxel, each to the nearest occupied voxel in
//! one octant of directions; it is ours, after the paper's remark on directional clouds.

use crate::config;
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};
use crate::grid::cell_lists::CellLists;
use crate::grid::cell_traversal::{CellPosition, CellTraversal};
use crate::grid::distance_field::{Metric, distances};
use crate::grid::regular_grid::{GridConfig, grid_params, stored};
use crate::grid::voxel_traversal::{GridFrame, VoxelTraversal};
use crate::parallel::collect;
use crate::params::ParamSpec;
use crate::params::config::Settings;
use crate::params::specs;
use crate::primitives::Primitives;
use crate::query::cells::{Cell, CellVisitor, NoCells};
use crate::query::sink::Sink;
use crate::structure::{BuildError, Structure, StructureInfo, StructureStats};

config! {
    /// The distances.
    pub struct CloudsConfig {
        /// how distances between voxels are measured
        metric: Metric = ParamSpec::choice(
            "metric", "chessboard", &["city-block", "chessboard", "euclidean"]
        ) => |metric| match metric {
            "city-block" => Metric::CityBlock,
            "euclidean" => Metric::Euclidean,
            _ => Metric::Chessboard,
        },
        /// one distance a voxel, or one for each octant of directions
        clouds: usize = ParamSpec::choice("directions", "all", &["all", "octants"])
            => |directions| if directions == "octants" { 8 } else { 1 },
    }
}

pub static INFO: StructureInfo = StructureInfo {
    paper: "Cohen, Sheffer 1994",
    deviations: "exact distances up to 255; eight octants instead of general directions",
    params: grid_params!(
        specs::MAX_CELLS,
        specs::MAX_REFERENCES,
        [CloudsConfig::PARAMS[0], CloudsConfig::PARAMS[1]],
        []
    ),
    variants: &["density=20"],
    also_tested: &[
        "kernel=scalar",
        "",
        "metric=city-block density=20",
        "metric=euclidean density=20",
        "directions=octants density=20",
        "mailbox=array",
    ],
    ..StructureInfo::new(
        "proximity-clouds",
        "equal voxels; empty ones hold the distance to the nearest occupied one",
    )
};

/// A grid with distances.
pub struct ProximityClouds<S: Scalar> {
    frame: GridFrame<S>,
    lists: CellLists,
    /// `clouds` distances a voxel; 0 in occupied ones.
    distances: Vec<u8>,
    /// 1, or 8 for octants.
    clouds: usize,
    metric: Metric,
    from_origin: bool,
}

impl<S: Scalar> Structure<S> for ProximityClouds<S> {
    const HAS_LISTS: bool = true;

    type Config = GridConfig<CloudsConfig>;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
    ) -> Result<Self, BuildError> {
        let CloudsConfig { metric, clouds } = settings.own;
        let (contents, lists) = stored::<S, CellLists, _>(prims, settings.limits(), settings, &())?;
        let frame = contents.frame;
        let cells = frame.cells() as u128;
        // a start, the distances, and while they are found: whether it is occupied, a measure
        settings.fits(cells * (4 + clouds as u128 + 3) + 4 * lists.references() as u128)?;
        let occupied = collect(frame.cells(), |i| !lists.list(i).is_empty());
        let mut all = vec![0; occupied.len() * clouds];
        for octant in 0..clouds {
            let signs = (clouds == 8).then_some(octant);
            let field = distances(&occupied, frame.resolution(), metric, signs);
            for (i, d) in field.into_iter().enumerate() {
                all[i * clouds + octant] = d;
            }
        }
        let from_origin = settings.historical;
        Ok(Self { frame, lists, distances: all, clouds, metric, from_origin })
    }

    #[inline(always)]
    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        let t_start = if self.from_origin { S::ZERO } else { ray.t_min };
        let Some(mut traversal) = self.frame.traversal_from(ray, t_start) else { return };
        let jumps = Jumps::new(&self.frame, ray, self.metric);
        let cloud = if self.clouds == 8 { octant_of(ray) } else { 0 };
        loop {
            let cell = traversal.index();
            let free = self.distances.get(cell * self.clouds + cloud).copied().unwrap_or(0);
            sink.elementary_step(free > 0);
            if free == 0 && sink.test(self.lists.list(cell)).is_break() {
                return;
            }
            if sink.t_max() < traversal.t_exit() {
                return;
            }
            let goes_on = if free > 1 {
                jumps.jump(&mut traversal, i32::from(free))
            } else {
                traversal.advance()
            };
            if !goes_on {
                return;
            }
        }
    }

    fn lists<'a>(&'a self, each: &mut dyn FnMut(&'a [u32])) {
        self.lists.lists().for_each(each);
    }

    fn stats(&self) -> StructureStats {
        let (lists, resolution) = (self.lists.stats(), Some(self.frame.resolution()));
        StructureStats { resolution, bytes: lists.bytes + self.distances.len() as u64, ..lists }
    }

    fn cells(&self, each: &mut CellVisitor<'_>) -> Result<(), NoCells> {
        for cell in 0..self.frame.cells() {
            each(Cell::elementary(self.frame.cell_bounds(cell), 0, self.lists.list(cell)));
        }
        Ok(())
    }
}

/// Bit k is set for a direction that falls along axis k.
#[inline(always)]
fn octant_of<S: Scalar>(ray: &Ray<S>) -> usize {
    let d = ray.direction.to_array();
    (0..3).map(|k| usize::from(d[k] < S::ZERO) << k).sum()
}

/// How a ray jumps.
#[derive(Debug, Clone, Copy)]
pub struct Jumps<S: Scalar> {
    /// Voxels crossed on each axis while the parameter grows by 1.
    rate: [S; 3],
    metric: Metric,
}

impl<S: Scalar> Jumps<S> {
    /// For a ray through a grid whose distances are measured so.
    #[inline(always)]
    pub fn new(frame: &GridFrame<S>, ray: &Ray<S>, metric: Metric) -> Self {
        let (d, cell) = (ray.direction.to_array(), frame.cell_size());
        Self { rate: std::array::from_fn(|k| d[k].abs() / cell[k]), metric }
    }

    /// Moves on to the first voxel that may be occupied when everything nearer than `free` is
    /// empty; false when the ray leaves the grid. No voxel at distance `free` or beyond is passed.
    #[inline(always)]
    pub fn jump(&self, traversal: &mut VoxelTraversal<S>, free: i32) -> bool {
        let steps = match self.metric {
            Metric::Chessboard => Some(self.across_a_cube(traversal, free)),
            Metric::CityBlock => self.within_a_diamond(traversal, free),
            Metric::Euclidean => self.within_a_sphere(traversal, free),
        };
        match steps {
            Some(steps) => traversal.jump(steps),
            None => traversal.advance(),
        }
    }

    /// Planes crossed on axis `k` up to parameter `t`, which may be a little off.
    #[inline(always)]
    fn crossed(&self, traversal: &VoxelTraversal<S>, k: usize, t: S) -> i32 {
        let beyond = t - traversal.t_next[k];
        // not so for an axis without direction: t - infinity
        if beyond >= S::ZERO { (beyond * self.rate[k]).to_i32().saturating_add(1) } else { 0 }
    }

    /// The cube of empty voxels is left through its nearest face; on the other axes the ray is
    /// still within the cube there.
    #[inline(always)]
    fn across_a_cube(&self, traversal: &VoxelTraversal<S>, free: i32) -> [i32; 3] {
        let t: [S; 3] = std::array::from_fn(|k| traversal.plane_ahead(k, free - 1));
        let (k, first) = if t[1] < t[0] { (1, t[1]) } else { (0, t[0]) };
        let (k, first) = if t[2] < first { (2, t[2]) } else { (k, first) };
        let mut steps = std::array::from_fn(|j| self.crossed(traversal, j, first).min(free - 1));
        steps[k] = free;
        steps
    }

    /// Fractions of a voxel by which the ray is ahead on each axis when it leaves its voxel: it
    /// then has crossed at most `ahead + tau * rate` planes after another `tau`.
    #[inline(always)]
    fn ahead(&self, traversal: &VoxelTraversal<S>) -> [S; 3] {
        let t = traversal.t_exit();
        std::array::from_fn(|k| {
            if self.rate[k] > S::ZERO && traversal.t_next[k].is_finite() {
                (t - traversal.t_next[k]) * self.rate[k] + S::ONE
            } else {
                S::ZERO
            }
        })
    }

    /// The voxel at `tau` beyond the exit of the current one, if that is a forward step.
    #[inline(always)]
    fn steps_after(&self, traversal: &VoxelTraversal<S>, tau: S) -> Option<[i32; 3]> {
        let t = traversal.t_exit() + tau;
        // also refuses NaN
        (tau >= S::ZERO && t.is_finite())
            .then(|| std::array::from_fn(|k| self.crossed(traversal, k, t)))
    }

    #[inline(always)]
    fn within_a_diamond(&self, traversal: &VoxelTraversal<S>, free: i32) -> Option<[i32; 3]> {
        let (a, r) = (self.ahead(traversal), self.rate);
        let tau = (S::from_i32(free) - (a[0] + a[1] + a[2])) / (r[0] + r[1] + r[2]);
        let sum = |n: &[i32; 3]| n.iter().map(|&n| i64::from(n)).sum::<i64>();
        self.steps_after(traversal, tau).filter(|n| (1..=i64::from(free)).contains(&sum(n)))
    }

    #[inline(always)]
    fn within_a_sphere(&self, traversal: &VoxelTraversal<S>, free: i32) -> Option<[i32; 3]> {
        // |a + tau r| = free
        let dot = |a: [S; 3], b: [S; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (a, r) = (self.ahead(traversal), self.rate);
        let (rr, ar) = (dot(r, r), dot(a, r));
        let c = dot(a, a) - S::from_i32(free * free);
        let tau = ((ar * ar - rr * c).sqrt() - ar) / rr;
        let square = |n: &[i32; 3]| n.iter().map(|&n| i64::from(n) * i64::from(n)).sum::<i64>();
        let limit = i64::from(free) * i64::from(free);
        self.steps_after(traversal, tau).filter(|n| (1..=limit).contains(&square(n)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    #[test]
    fn jumps_stay_within_the_ball() {
        // HARD_CASES Gr9: what is passed is nearer than `free`, in whole voxels
        let n = 64;
        let bounds = crate::Aabb { min: glam::DVec3::ZERO, max: glam::DVec3::splat(64.0) };
        let frame = GridFrame::<f64>::new(bounds, [n; 3]);
        let mut random = Random(3);
        for metric in [Metric::CityBlock, Metric::Chessboard, Metric::Euclidean] {
            let mut jumped = 0;
            for _ in 0..5000 {
                let o = random.point([64.0; 3]);
                let ray = Ray::<f64>::new(o, random.point([64.0; 3]) - o);
                let Some(start) = frame.traversal(&ray) else { continue };
                let jumps = Jumps::new(&frame, &ray, metric);
                let free = 2 + (random.unit() * 20.0) as i32;
                let mut end = start;
                if !jumps.jump(&mut end, free) {
                    continue;
                }
                let mut step = start;
                let mut passed = 0;
                while step.index() != end.index() {
                    let delta: [i32; 3] =
                        std::array::from_fn(|k| step.coords()[k] - start.coords()[k]);
                    assert!(metric.of(delta) < (free * free) as u32 && passed < 200);
                    let measured = match metric {
                        Metric::Euclidean => f64::from(metric.of(delta)).sqrt(),
                        _ => f64::from(metric.of(delta)),
                    };
                    assert!(measured < f64::from(free), "{metric:?} {free} {delta:?}");
                    assert!(step.advance(), "the jump's end is not on the way");
                    passed += 1;
                }
                jumped += passed;
            }
            assert!(jumped > 15_000, "{metric:?} {jumped}");
        }
    }
}
