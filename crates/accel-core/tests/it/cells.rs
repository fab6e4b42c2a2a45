//! Every structure shows its cells: as many as its counts say, all space that primitives fill, and
//! the way of a ray through them that the counted pass counts.

use crate::common::{Random, Set, all_scenes, build, rays_for};
use accel_core::primitives::{Ball, PrimSet, TriangleSet, Watertight};
use accel_core::query::cells::{CellKind, NoCells};
use accel_core::query::entered::{cells_entered, crossed};
use accel_core::query::trace::{TestResult, TraversalTrace};
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::StructureStats;
use accel_core::structures::{Entry, REGISTRY, find};
use accel_core::{Aabb, Hit, Ray, Scalar, Vector};
use glam::DVec3;

/// A cell, kept.
#[derive(Debug, Clone)]
struct Kept {
    bounds: Aabb<f64>,
    depth: u32,
    kind: CellKind,
    ids: Vec<u32>,
}

fn kept<S: Scalar>(tracer: &dyn Tracer<S>) -> Result<Vec<Kept>, NoCells> {
    let mut all = Vec::new();
    tracer.cells(&mut |cell| {
        let ids = cell.ids.to_vec();
        all.push(Kept { bounds: cell.bounds, depth: cell.depth, kind: cell.kind, ids });
    })?;
    Ok(all)
}

/// The box of a primitive, and points of it.
struct Solid {
    bounds: Aabb<f64>,
    points: Vec<DVec3>,
}

fn solids<S: Buildable>(set: &Set<S>) -> Vec<Solid> {
    fn of<S: Scalar, P: PrimSet<S>>(prims: &P) -> Vec<Solid> {
        let solid = |id| {
            let mut balls: Vec<Ball> = Vec::new();
            prims.hull(id, &mut balls);
            let mut points: Vec<DVec3> = balls.iter().map(|ball| ball.center).collect();
            points.push(points.iter().sum::<DVec3>() / points.len() as f64);
            Solid { bounds: prims.bounds(id).in_double(), points }
        };
        (0..prims.len() as u32).map(solid).collect()
    }
    match set {
        Set::Triangles(set) => of(set),
        Set::Mixed(set) => of(set),
    }
}

/// Points of a box, along each axis.
const POINTS: u32 = 4;

/// Returns whether boxes hold a lattice of points of another one, its corners among them.
fn cover(wanted: &Aabb<f64>, boxes: &[Aabb<f64>]) -> bool {
    let near: Vec<_> = boxes.iter().filter(|b| meet(wanted, b)).collect();
    let place = |n: u32| f64::from(n) / f64::from(POINTS - 1);
    (0..POINTS.pow(3)).all(|n| {
        let at =
            DVec3::new(place(n % POINTS), place(n / POINTS % POINTS), place(n / POINTS / POINTS));
        let point = wanted.min + (wanted.max - wanted.min) * at;
        near.iter().any(|b| inside(b, point))
    })
}

fn meet(a: &Aabb<f64>, b: &Aabb<f64>) -> bool {
    a.min.cmple(b.max).all() && b.min.cmple(a.max).all()
}

fn inside(b: &Aabb<f64>, p: DVec3) -> bool {
    p.cmpge(b.min).all() && p.cmple(b.max).all()
}

/// Faults of the cells of a structure, which may cut primitives.
fn faults(stats: &StructureStats, cells: &[Kept], solids: &[Solid], cuts: bool) -> Vec<String> {
    let mut wrong = Vec::new();
    let of_kind = |kind| cells.iter().filter(|cell| cell.kind == kind).count() as u64;
    let empty = of_kind(CellKind::Empty);
    for (what, shown, counted) in [
        ("inner cells", of_kind(CellKind::Inner), stats.inner_cells),
        ("cells", of_kind(CellKind::Leaf) + empty, stats.cells),
        ("empty cells", empty, stats.empty_cells),
        ("references", cells.iter().map(|cell| cell.ids.len() as u64).sum(), stats.references),
    ] {
        if shown != counted {
            wrong.push(format!("{shown} {what} shown, {counted} counted"));
        }
    }
    if cells.iter().any(|cell| {
        (cell.kind == CellKind::Empty) != cell.ids.is_empty() && cell.kind != CellKind::Inner
    }) {
        wrong.push("an empty cell that lists primitives, or a leaf that lists none".into());
    }
    let mut deepest = None;
    for cell in cells {
        if cell.depth > deepest.map_or(0, |depth| depth + 1) && stats.inner_cells > 0 {
            wrong.push(format!("a cell of depth {} within one of {deepest:?}", cell.depth));
        }
        deepest = Some(cell.depth);
    }
    let scene = solids.iter().fold(Aabb::empty(), |all, solid| all.union(solid.bounds));
    // of the rounding of planes in f32
    let slack = 16.0 * f64::from(f32::EPSILON) * scene.magnitude();
    let mut lists = vec![Vec::new(); solids.len()];
    for cell in cells {
        cell.ids.iter().for_each(|&id| lists[id as usize].push(cell.bounds.expanded(slack)));
    }
    let elementary = cells.iter().filter(|cell| cell.kind != CellKind::Inner);
    let boxes: Vec<_> = elementary.map(|cell| cell.bounds.expanded(slack)).collect();
    for (id, solid) in solids.iter().enumerate() {
        if !cuts && !cover(&solid.bounds, &lists[id]) && !cover(&solid.bounds, &boxes) {
            wrong.push(format!("cells do not cover the box of primitive {id}"));
        }
        if solid.points.iter().any(|&p| !lists[id].iter().any(|b| inside(b, p))) {
            wrong.push(format!("no cell around a point of primitive {id} lists it"));
        }
    }
    wrong
}

/// Returns whether a structure has no cells to show: those that would stand for several copies.
fn shows_none(entry: &Entry, scene: &str) -> bool {
    scene.starts_with("copies") && entry.info.name.starts_with("instanced-")
}

/// Every setting that tests go through.
fn settings(entry: &Entry) -> impl Iterator<Item = &'static str> {
    entry.info.variants.iter().chain(entry.info.also_tested).copied()
}

fn built<'a, S: Buildable>(entry: &Entry, set: &'a Set<S>, text: &str) -> Box<dyn Tracer<S> + 'a> {
    build(set.prims(), entry.info.name, text).unwrap()
}

fn all_cells<S: Buildable>() {
    for (scene, set, _) in all_scenes::<S>() {
        let solids = solids(&set);
        for entry in REGISTRY {
            for setting in settings(entry) {
                let tracer = built(entry, &set, setting);
                let name = format!("{} {setting}, {scene}", entry.info.name);
                match kept(&*tracer) {
                    Ok(cells) => {
                        // triangles that are cut have boxes of their parts alone
                        let cuts = setting == "split=always"
                            || entry.info.name.starts_with("obvhs")
                                && ["preset=slow", "preset=very-slow"].contains(&setting);
                        let wrong = faults(&tracer.stats(), &cells, &solids, cuts);
                        assert!(wrong.is_empty(), "{name}: {:#?}", &wrong[..wrong.len().min(5)]);
                    }
                    Err(error) => assert!(shows_none(entry, scene), "{name}: {error}"),
                }
            }
        }
    }
}

#[test]
fn all_structures_show_what_they_count_in_f32() {
    all_cells::<f32>();
}

#[test]
fn all_structures_show_what_they_count_in_f64() {
    all_cells::<f64>();
}

#[test]
fn a_dropped_cell_and_a_reference_counted_twice_are_caught() {
    let scenes = all_scenes::<f32>();
    let (_, set, _) = scenes.iter().find(|(name, ..)| *name == "soup").unwrap();
    let solids = solids(set);
    for entry in REGISTRY {
        let name = entry.info.name;
        let tracer = built(entry, set, settings(entry).next().unwrap());
        let (stats, cells) = (tracer.stats(), kept(&*tracer).unwrap());
        for kind in [CellKind::Inner, CellKind::Leaf, CellKind::Empty] {
            // planted fault: the visitor drops a cell
            let Some(dropped) = cells.iter().rposition(|cell| cell.kind == kind) else { continue };
            let mut fewer = cells.clone();
            let dropped = fewer.remove(dropped);
            let wrong = faults(&stats, &fewer, &solids, false);
            assert!(!wrong.is_empty(), "{name}: {kind:?}");
            if kind == CellKind::Leaf {
                // planted fault: as the one before, but the counts are said to be right
                let lies = StructureStats {
                    cells: stats.cells - 1,
                    references: stats.references - dropped.ids.len() as u64,
                    ..stats
                };
                let wrong = faults(&lies, &fewer, &solids, false);
                assert!(wrong.iter().any(|w| w.contains("primitive")), "{name}: {wrong:?}");
            }
        }
        // planted fault: a reference counted twice
        let mut more = cells.clone();
        let leaf = more.iter_mut().find(|cell| cell.kind == CellKind::Leaf).unwrap();
        leaf.ids.push(leaf.ids[0]);
        assert!(!faults(&stats, &more, &solids, false).is_empty(), "{name}");
    }
}

/// Faults of the trace of a ray, and its steps without a cell.
fn faults_of_way<S: Buildable>(
    tracer: &dyn Tracer<S>,
    ray: &Ray<S>,
    trace: &TraversalTrace<S>,
) -> Vec<String> {
    let mut wrong = Vec::new();
    let mut hits = [Hit::NONE];
    let counters = tracer.count_closest_hits(&[*ray], &mut hits);
    if trace.counted() != counters || trace.counters != counters {
        wrong.push(format!("{:?} recorded, {counters:?} counted", trace.counted()));
    }
    if trace.hit != hits[0] {
        wrong.push(format!("{:?} recorded, {:?} answered", trace.hit, hits[0]));
    }
    let last_hit =
        trace.steps.iter().flat_map(|step| &step.tests).rfind(|t| t.1 == TestResult::Hit);
    if last_hit.map(|test| test.0) != trace.hit.is_hit().then_some(trace.hit.id) {
        wrong.push(format!("the last hit is {last_hit:?}, the answer {:?}", trace.hit));
    }
    let crossed = crossed(tracer, ray).unwrap();
    let entered = cells_entered(tracer, ray, trace, &crossed);
    for (number, (step, cells)) in trace.steps.iter().zip(&entered).enumerate() {
        let ids: Vec<u32> = step.tests.iter().map(|test| test.0).collect();
        let [first, ..] = cells.as_slice() else {
            if step.kind != CellKind::Inner {
                wrong.push(format!("no cell for step {number}"));
            }
            continue;
        };
        let listed = || cells.iter().flat_map(|&cell| &crossed[cell].ids);
        let is_whole = crossed[*first].ids == ids;
        // a block of triangles may be of several leaves of a node, not all of which the ray meets
        let is_listed = |id: &u32| listed().any(|listed| listed == id);
        let is_of_blocks = tracer.code().contains("ObvhsCwBvh") && ids.iter().any(is_listed);
        if !is_whole && !is_of_blocks && !ids.iter().all(is_listed) {
            wrong.push(format!("step {number} tests other primitives than its cell lists"));
        }
        if is_whole && step.kind != CellKind::Inner && crossed[*first].kind != step.kind {
            wrong.push(format!("step {number} is one into another kind of cell"));
        }
    }
    wrong
}

fn all_ways<S: Buildable>() {
    for (scene, set, bounds) in all_scenes::<S>() {
        let rays: Vec<Ray<S>> = rays_for::<S>(bounds, &mut Random::new(11));
        let mut rays: Vec<_> = rays.into_iter().step_by(389).filter(Ray::is_traceable).collect();
        // a moved ray has other parameters, and cells are those at all times
        let reach = 4.0 * (bounds.1 - bounds.0).length();
        rays.retain(|ray| {
            (ray.origin.to_dvec3() - bounds.0).length() < reach && ray.t_min >= S::ZERO
        });
        for entry in REGISTRY.iter().filter(|entry| !shows_none(entry, scene)) {
            for setting in settings(entry) {
                let tracer = built(entry, &set, setting);
                for ray in &rays {
                    let trace = tracer.trace(ray).unwrap();
                    let wrong = faults_of_way(&*tracer, ray, &trace);
                    let name = format!("{} {setting}, {scene}, {ray:?}", entry.info.name);
                    assert!(wrong.is_empty(), "{name}: {wrong:#?}\n{trace:#?}");
                }
            }
        }
    }
}

#[test]
fn traces_have_the_counted_steps_in_f32() {
    all_ways::<f32>();
}

#[test]
fn traces_have_the_counted_steps_in_f64() {
    all_ways::<f64>();
}

#[test]
fn traces_that_lack_a_step_or_a_test_are_caught() {
    let scenes = all_scenes::<f32>();
    let (_, set, bounds) = scenes.iter().find(|(name, ..)| *name == "soup").unwrap();
    let from = bounds.0 - DVec3::new(0.3, 0.1, 0.2);
    let ray = Ray::<f32>::new(from.as_vec3(), (bounds.1 - from).as_vec3());
    for entry in REGISTRY {
        let tracer = built(entry, set, settings(entry).next().unwrap());
        let trace = tracer.trace(&ray).unwrap();
        let found =
            |planted: &TraversalTrace<f32>| !faults_of_way(&*tracer, &ray, planted).is_empty();
        assert!(!found(&trace), "{}", entry.info.name);
        let mut shorter = trace.clone();
        shorter.steps.pop();
        assert!(found(&shorter), "{}", entry.info.name);
        let mut forgetful = trace.clone();
        let tested = forgetful.steps.iter_mut().find(|step| !step.tests.is_empty()).unwrap();
        tested.tests.pop();
        assert!(found(&forgetful), "{}", entry.info.name);
    }
}

#[test]
fn entered_empty_voxels_follow_from_the_ray() {
    // two small triangles in opposite corners, all empty between: which voxels a ray enters is
    // known without any traversal
    let at = |x: f32| [[x, x, x], [x + 0.1, x, x], [x, x + 0.1, x]];
    let triangles = TriangleSet::<f32, Watertight>::new(vec![at(0.0), at(9.9)], |_| false);
    let set = Set::Triangles(triangles.unwrap());
    let ray = Ray::<f32>::new([-1.0, 5.1, 5.3].into(), [1.0, 0.0, 0.0].into());
    let entered = |name: &str| {
        let tracer = built(find(name).unwrap(), &set, "density=4000");
        let trace = tracer.trace(&ray).unwrap();
        let crossed = crossed(&*tracer, &ray).unwrap();
        let entered = cells_entered(&*tracer, &ray, &trace, &crossed);
        let start = |cell: &usize| crossed[*cell].bounds.min.x;
        let starts: Vec<f64> = entered.iter().map(|cells| start(&cells[0])).collect();
        let mut row: Vec<f64> = (0..crossed.len()).map(|cell| start(&cell)).collect();
        row.sort_by(f64::total_cmp);
        row.dedup();
        (starts, row)
    };
    let (starts, row) = entered("uniform-grid");
    assert!(row.len() > 15 && starts == row, "each voxel, one after the other: {starts:?} {row:?}");
    let (starts, row) = entered("proximity-clouds");
    assert!(starts.len() * 2 < row.len(), "voxels are passed: {starts:?} {row:?}");
    assert!(starts[0] == row[0] && starts.windows(2).all(|w| w[0] < w[1]), "{starts:?}");
}

#[test]
fn structures_without_cells_return_an_error() {
    struct Silent;
    impl Tracer<f32> for Silent {
        fn closest_hits(&self, _: &[Ray<f32>], _: &mut [Hit<f32>]) {}
        fn occlusions(&self, _: &[Ray<f32>], _: &mut [bool]) {}
        fn count_closest_hits(
            &self,
            _: &[Ray<f32>],
            _: &mut [Hit<f32>],
        ) -> accel_core::query::counters::WorkCounters {
            Default::default()
        }
        fn count_occlusions(
            &self,
            _: &[Ray<f32>],
            _: &mut [bool],
        ) -> accel_core::query::counters::WorkCounters {
            Default::default()
        }
        fn stats(&self) -> StructureStats {
            StructureStats::default()
        }
    }
    assert_eq!(kept(&Silent).unwrap_err(), NoCells::UNTOLD);
    let ray = Ray::<f32>::new([0.0; 3].into(), [1.0; 3].into());
    assert_eq!(Silent.trace(&ray).unwrap_err(), NoCells::UNTOLD);
}
