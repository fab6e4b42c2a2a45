//! How good a structure is, apart from how long it takes: what it loses while it is updated and not
//! built.
//!
//! * Expected cost: J. D. MacDonald, K. S. Booth, "Heuristics for Ray Tracing Using Space
//!   Subdivision", The Visual Computer 6(3), 1990. The cells that a random line meets which meets
//!   the scene, and the primitives in the elementary ones, all of equal cost.
//! * End-point overlap: T. Aila, T. Karras, S. Laine, "On Quality Metrics of Bounding Volume
//!   Hierarchies", HPG 2013. The part of the scene's surface that lies in cells which do not hold
//!   it, each with the cell's cost: a ray that ends there visits them in vain. Deviation: of 512
//!   random points, uniform over the area of triangles, not of clipped polygons.

use accel_core::primitives::PrimsRef;
use accel_core::query::cells::CellKind;
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::{Aabb, Vector};
use glam::DVec3;
use statistics::random::Random;

const POINTS: usize = 512;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quality {
    pub expected_cost: f64,
    /// Overlap of surfaces; `None` without triangles.
    pub overlap: Option<f64>,
}

/// A point on the surface and the primitive that it is of.
#[derive(Debug, Clone, Copy)]
pub struct SurfacePoint {
    at: DVec3,
    id: u32,
}

/// Points that are uniform over the area of the scene's triangles; none without any.
pub fn surface_points<S: Buildable>(prims: PrimsRef<'_, S>, seed: u64) -> Vec<SurfacePoint> {
    let prims = prims.primitives();
    let corners = |id: u32| prims.corners(id).map(|corners| corners.map(|p| p.to_dvec3()));
    let mut sum = 0.0;
    let area = |id: u32| {
        let area = corners(id).map_or(0.0, |[a, b, c]| (b - a).cross(c - a).length() * 0.5);
        sum += area;
        sum
    };
    let sums: Vec<f64> = (0..prims.len() as u32).map(area).collect();
    let mut random = Random::new(seed, "end-point overlap");
    let mut unit = || random.below(1 << 30) as f64 / f64::from(1u32 << 30);
    let total = sums.last().copied().unwrap_or(0.0);
    if !(total > 0.0 && total.is_finite()) {
        return Vec::new();
    }
    let points = (0..POINTS).filter_map(|_| {
        let at = unit() * total;
        let id = sums.partition_point(|&sum| sum <= at) as u32;
        let [a, b, c] = corners(id)?;
        // uniform in the triangle
        let (u, v) = (unit().sqrt(), unit());
        Some(SurfacePoint { at: a * (1.0 - u) + b * (u * (1.0 - v)) + c * (u * v), id })
    });
    points.collect()
}

/// A cell, its primitives apart.
struct CellOutline {
    bounds: Aabb<f64>,
    cost: f64,
    ids: std::ops::Range<usize>,
    /// The next cell that does not lie within it.
    behind: usize,
}

/// The quality of a structure; none where its cells cannot be shown.
pub fn quality<S: Buildable>(tracer: &dyn Tracer<S>, points: &[SurfacePoint]) -> Option<Quality> {
    let (mut cells, mut all_ids, mut open) = (Vec::<CellOutline>::new(), Vec::new(), Vec::new());
    tracer
        .cells(&mut |cell| {
            while open.len() > cell.depth as usize {
                let (Some(within), end) = (open.pop(), cells.len()) else { return };
                if let Some(cell) = cells.get_mut::<usize>(within) {
                    cell.behind = end;
                }
            }
            open.push(cells.len());
            let begin = all_ids.len();
            all_ids.extend_from_slice(cell.ids);
            let tests = cell.ids.len() as f64;
            let cost = if cell.kind == CellKind::Inner { 1.0 } else { 1.0 + tests };
            let (bounds, ids) = (cell.bounds, begin..all_ids.len());
            cells.push(CellOutline { bounds, cost, ids, behind: usize::MAX });
        })
        .ok()?;
    let area = |b: &Aabb<f64>| {
        let s = b.max - b.min;
        s.x * s.y + s.y * s.z + s.z * s.x
    };
    let finite = || cells.iter().filter(|cell| cell.bounds.is_finite());
    let scene = finite().fold(Aabb::empty(), |all, cell| all.union(cell.bounds));
    let whole = area(&scene);
    if whole.is_nan() || whole <= 0.0 {
        return None;
    }
    let expected_cost = finite().map(|cell| area(&cell.bounds) * cell.cost).sum::<f64>() / whole;
    let overlap = points.iter().map(|point| overlap_at(point, &cells, &all_ids)).sum::<f64>();
    let overlap = (!points.is_empty()).then(|| overlap / points.len() as f64);
    Some(Quality { expected_cost, overlap })
}

/// The cost of the cells that hold the point and nothing of its primitive.
fn overlap_at(point: &SurfacePoint, cells: &[CellOutline], ids: &[u32]) -> f64 {
    // the cells around the cell looked at, with the cost of those that hold the point
    let (mut sum, mut at) = (0.0, 0);
    let mut around: Vec<(usize, f64)> = Vec::new();
    while let Some(cell) = cells.get(at) {
        while around.last().is_some_and(|(behind, _)| *behind <= at) {
            sum += around.pop().map_or(0.0, |(_, cost)| cost);
        }
        let (low, high) = (point.at.cmpge(cell.bounds.min), point.at.cmple(cell.bounds.max));
        if !(low.all() && high.all()) {
            // a cell within may reach out by its padding, the point's primitive with it
            at = cell.behind.min(cells.len());
            continue;
        }
        around.push((cell.behind, cell.cost));
        if ids.get(cell.ids.clone()).is_some_and(|ids| ids.contains(&point.id)) {
            // it is held by all of these
            around.iter_mut().for_each(|(_, cost)| *cost = 0.0);
        }
        at += 1;
    }
    sum + around.iter().map(|(_, cost)| cost).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use accel_core::primitives::TriangleSet;
    use accel_core::query::tracer::PreviousFrame;
    use accel_core::structures::find;

    /// Triangles in a row, each moved to the place of another one of a row that is as long, by
    /// `shift`.
    fn row(n: usize, shift: usize) -> TriangleSet<f32> {
        let triangle = |i: usize| {
            let x = ((i * shift) % n) as f32;
            [[x, 0.0, 0.0], [x + 0.5, 0.1, 0.0], [x, 0.5, 0.4]]
        };
        TriangleSet::new((0..n).map(triangle).collect(), |_| false).unwrap()
    }

    #[test]
    fn a_refitted_tree_becomes_worse_and_a_built_one_does_not() {
        let sets = [row(200, 1), row(200, 37)];
        let of = |tracer: &dyn Tracer<f32>, set: &TriangleSet<f32>| {
            quality(tracer, &surface_points(PrimsRef::Watertight(set), 1)).unwrap()
        };
        let all: Vec<u32> = (0..200).collect();
        for name in ["wide-bvh", "obvhs-bvh2"] {
            let entry = find(name).unwrap();
            let params = entry.defaults().set("update", "refit").unwrap();
            let params = params.set("rebuild-at", 1e6).unwrap();
            let first = entry.build(PrimsRef::Watertight(&sets[0]), &params).unwrap();
            let built = of(&*first, &sets[0]);
            let fresh = entry.build(PrimsRef::Watertight(&sets[1]), &params).unwrap();
            let before = PreviousFrame { kept: first.released().unwrap(), moved: &all };
            let refitted = entry.update(PrimsRef::Watertight(&sets[1]), &params, before).unwrap();
            assert!(refitted.is_updated());
            let [fresh, refitted] = [fresh, refitted].map(|tracer| of(&*tracer, &sets[1]));
            assert!(fresh.expected_cost < 1.1 * built.expected_cost, "{fresh:?} {built:?}");
            assert!(refitted.expected_cost > 3.0 * built.expected_cost, "{refitted:?}");
            assert!(
                refitted.overlap > fresh.overlap.map(|o| 5.0 * o + 5.0),
                "{refitted:?} {fresh:?}"
            );
        }
        // what lies in a voxel is listed there
        let grid = find("uniform-grid").unwrap();
        let grid = grid.build(PrimsRef::Watertight(&sets[1]), &grid.defaults()).unwrap();
        assert_eq!(of(&*grid, &sets[1]).overlap, Some(0.0));
    }
}
