//! A build on several threads gives what one thread gives: the same cells and references, the same
//! work for every query, the same answers.

use accel_core::primitives::PrimsRef;
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::ShadowRule;
use accel_core::structure::StructureStats;
use accel_core::structures::{Entry, REGISTRY, find};
use accel_core::{Hit, Ray};

use crate::common::{Random, many_triangles, rays_for};

/// What can be seen of a structure. The tests of an occlusion query end at the first that blocks,
/// so they depend on the order within each list.
type Seen = (StructureStats, [WorkCounters; 2], Vec<Hit<f32>>);

fn seen(entry: &Entry, setting: &str, prims: PrimsRef<f32>, rays: &[Ray<f32>]) -> Seen {
    let words = setting.split_whitespace().filter_map(|word| word.split_once('='));
    let tracer = entry.build(prims, &entry.params(words).unwrap()).unwrap();
    let mut hits = vec![Hit::NONE; rays.len()];
    let closest = tracer.count_closest_hits(rays, &mut hits);
    let mut blocked = vec![Default::default(); rays.len()];
    let shadows = tracer.count_occlusions(rays, ShadowRule::OpaqueBlocks, &mut blocked);
    (tracer.stats(), [closest, shadows], hits)
}

fn on<T: Send>(threads: usize, f: impl FnOnce() -> T + Send) -> T {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(f)
}

#[test]
fn any_number_of_threads_builds_the_same() {
    // enough for three parts
    let set = many_triangles(13_000);
    let prims = PrimsRef::Watertight(&set);
    let bounds = (glam::DVec3::ZERO, glam::DVec3::ONE);
    let rays: Vec<Ray<f32>> =
        rays_for(bounds, &mut Random::new(11)).into_iter().step_by(13).collect();
    for entry in REGISTRY.iter().filter(|entry| !entry.info.sampled) {
        let settings = match entry.info.name {
            "uniform-grid" => &["", "density=20", "boxes=historical order=reverse"][..],
            "two-level-grid" => &["", "density=2 leaf-density=0.5"],
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

#[test]
fn lists_in_another_order_or_grid_are_seen() {
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
        assert_eq!(right.2, wrong.2);
    }
}
