//! Do structures give the answers of brute force?

use accel_core::structures::{Buildable, Entry, PrimsRef, find};
use accel_core::tracer::{ShadowCount, ShadowRule};
use accel_core::{Hit, Ray};

/// Mismatches with brute force of every variant of every structure on one scene.
pub fn mismatches<S: Buildable>(
    registry: &[Entry],
    name: &str,
    prims: PrimsRef<S>,
    rays: &[Ray<S>],
) -> Vec<String> {
    let entry = find("brute-force").unwrap();
    let oracle = entry.build(prims, &entry.params([]).unwrap()).unwrap();
    let mut expected = vec![Hit::NONE; rays.len()];
    oracle.closest_hits(rays, &mut expected);
    let mut expected_blocked = vec![false; rays.len()];
    oracle.occlusions(rays, &mut expected_blocked);
    let mut wrong = Vec::new();
    for entry in registry {
        for variant in entry.info.variants.iter().chain(entry.info.also_tested) {
            let settings = variant.split_whitespace().map(|s| s.split_once('=').unwrap());
            let params = entry.params(settings).unwrap();
            if (entry.info.known_defect)(&params).is_some() {
                continue;
            }
            let label = format!("{name} {} {} {variant}", S::NAME, entry.info.name);
            let tracer = match entry.build(prims, &params) {
                Ok(tracer) => tracer,
                Err(e) => {
                    wrong.push(format!("{label}: {e}"));
                    continue;
                }
            };
            let mut hits = vec![Hit::NONE; rays.len()];
            tracer.closest_hits(rays, &mut hits);
            let mut blocked = vec![false; rays.len()];
            tracer.occlusions(rays, &mut blocked);
            let mut counted = vec![Hit::NONE; rays.len()];
            tracer.count_closest_hits(rays, &mut counted);
            let mut shadows = vec![ShadowCount { blocked: false, glass: 0 }; rays.len()];
            tracer.count_occlusions(rays, ShadowRule::OpaqueBlocks, &mut shadows);
            for (i, ray) in rays.iter().enumerate() {
                if hits[i] != expected[i]
                    || counted[i] != expected[i]
                    || blocked[i] != expected_blocked[i]
                    || shadows[i].blocked != expected_blocked[i]
                {
                    wrong.push(format!(
                        "{label}: ray {i} {ray:?}: expected {:?} {}, got {:?} {:?} {} {}",
                        expected[i],
                        expected_blocked[i],
                        hits[i],
                        counted[i],
                        blocked[i],
                        shadows[i].blocked
                    ));
                }
            }
        }
    }
    wrong
}
