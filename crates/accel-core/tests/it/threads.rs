//! A build on several threads gives what one thread gives: the same cells and references, the same
//! work for every query, the same answers.

use accel_core::Ray;
use accel_core::primitives::PrimsRef;
use accel_core::query::counters::WorkCounters;
use accel_core::structure::StructureStats;
use accel_core::structures::{Entry, REGISTRY, find};

use crate::agreement::Answers;
use crate::common::{Random, build, many_triangles, rays_for};
use crate::test_scenes::on_threads as on;

/// Observable behaviour of a structure. The tests of an occlusion query end at the first that
/// blocks, so they depend on the order within each list.
type Seen = (StructureStats, (Answers<f32>, [WorkCounters; 2]));

fn seen(entry: &Entry, setting: &str, prims: PrimsRef<f32>, rays: &[Ray<f32>]) -> Seen {
    let tracer = build(prims, entry.info.name, setting).unwrap();
    let free = Answers { hits: Vec::new(), blocked: vec![false; rays.len()] };
    (tracer.stats(), Answers::counted(&*tracer, rays, &free))
}

#[test]
fn any_number_of_threads_builds_the_same() {
    // enough for three parts
    let set = many_triangles(13_000);
    let prims = PrimsRef::Watertight(&set);
    let bounds = (glam::DVec3::ZERO, glam::DVec3::ONE);
    let rays: Vec<Ray<f32>> =
        rays_for(bounds, &mut Random::new(11)).into_iter().step_by(13).collect();
    for entry in REGISTRY {
        let settings = match entry.info.name {
            "uniform-grid" => &["", "density=20", "boxes=historical order=reverse"][..],
            "two-level-grid" => &["", "density=2 leaf-density=0.5"],
            "recursive-grid" => &["", "threshold=2 boxes=historical", "build=lazy lazy-levels=2"],
            "hug" => &["", "size-classes=8 gap=0.002", "size-classes=2 boxes=historical"],
            "adaptive-grid" => &["", "m=0.01 split=2 orphan-grid=on", "boxes=historical"],
            "kay-kajiya" => &["", "leaf-size=3 branching=4", "leaf-size=5 branching=8"],
            "bounding-volumes" => &["group=5", "volume=slabs group=64", "volume=sphere group=40"],
            _ if entry.info.sampled => continue,
            _ => &[""],
        };
        for setting in settings {
            let one = on(1, || seen(entry, setting, prims, &rays));
            for threads in [2, 5] {
                let other = on(threads, || seen(entry, setting, prims, &rays));
                assert!(one == other, "{} {setting}: {threads} threads differ", entry.info.name);
            }
        }
    }
}

/// Refusals, their messages, and omissions for a limit depend on what was built before.
#[test]
fn limits_are_the_same_for_any_number_of_threads() {
    let set = many_triangles(13_000);
    let prims = PrimsRef::Watertight(&set);
    for name in ["recursive-grid", "hug", "adaptive-grid", "kay-kajiya"] {
        let entry = find(name).unwrap();
        let built = |threads, limit: &str, most: u64| {
            let most = most.to_string();
            let params = entry.params([(limit, most.as_str())]).unwrap();
            on(threads, || match entry.build(prims, &params) {
                Ok(tracer) => format!("{:?}", tracer.stats()),
                Err(refused) => refused.to_string(),
            })
        };
        let whole = entry.build(prims, &entry.defaults()).unwrap().stats();
        let limits =
            [("max-cells", whole.cells + whole.inner_cells), ("max-references", whole.references)];
        let mut kinds = [0; 2];
        for (limit, needed) in limits {
            if !entry.info.params.iter().any(|param| param.name == limit) {
                continue;
            }
            for percent in [10, 40, 60, 90, 100, 103, 150, 250] {
                let most = needed * percent / 100;
                let one = built(1, limit, most);
                kinds[usize::from(one.contains("limit"))] += 1;
                for threads in [2, 5] {
                    assert_eq!(built(threads, limit, most), one, "{name} {limit}={most}");
                }
            }
        }
        assert!(kinds[0] > 0 && kinds[1] > 0, "{name}: {kinds:?}");
    }
}

#[test]
fn lists_in_another_order_or_grid_are_caught() {
    // planted faults: what parts that are put together wrongly would look like
    let set = many_triangles(3_000);
    let prims = PrimsRef::Watertight(&set);
    let bounds = (glam::DVec3::ZERO, glam::DVec3::ONE);
    let rays = rays_for(bounds, &mut Random::new(11));
    let entry = find("uniform-grid").unwrap();
    let right = seen(entry, "", prims, &rays);
    for fault in ["order=reverse", "density=3"] {
        let wrong = seen(entry, fault, prims, &rays);
        assert!(right != wrong, "{fault} is not seen");
        assert_eq!(right.1.0.hits, wrong.1.0.hits);
    }
}
