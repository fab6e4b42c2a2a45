//! Primitives that no cell and no plane can separate: all in one place, or all about one centre.
//! What a structure makes of them stays near-linear in their number.

use accel_core::Ray;
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{MixedSet, MixedSetBuilder};
use glam::{DVec3, dvec3};

use crate::agreement::closest_hits;
use crate::common::{Random, build, right_variants};

const N: usize = 100_000;

fn built(n: usize, mut add: impl FnMut(&mut MixedSetBuilder<f32>)) -> MixedSet<f32> {
    let mut set = MixedSetBuilder::default();
    (0..n).for_each(|_| add(&mut set));
    set.finish()
}

fn scenes(n: usize) -> [(&'static str, MixedSet<f32>); 4] {
    let (mut random, mut other) = (Random::new(7), Random::new(8));
    let one = [dvec3(0.1, 0.2, 0.3), dvec3(1.0, 0.1, 0.2), dvec3(0.3, 0.9, 0.4)];
    [
        ("one triangle", built(n, |set| set.triangle(one).unwrap())),
        (
            "triangles about a point",
            built(n, |set| {
                let (a, b) = (random.signed(), random.signed());
                set.triangle([a, b, -a - b]).unwrap();
            }),
        ),
        ("one sphere", built(n, |set| set.sphere(DVec3::ZERO, 1.0).unwrap())),
        (
            "spheres about a point",
            built(n, |set| set.sphere(DVec3::ZERO, 0.1 + other.unit()).unwrap()),
        ),
    ]
}

/// Most references that n primitives may have in a structure: near-linear.
fn most_references(n: usize) -> u64 {
    (16.0 * n as f64 * (n as f64).log2()) as u64
}

/// Number of references of a structure; its answers must be those of brute force.
fn references(set: &MixedSet<f32>, name: &str, text: &str) -> u64 {
    let tracer = build(PrimsRef::Mixed(set), name, text).unwrap();
    let rays = [[0.45, 0.4, -9.0], [0.1, 0.1, -9.0], [3.0, 3.0, -9.0]]
        .map(|o| Ray::<f32>::new(o.into(), [0.0, 0.0, 1.0].into()));
    let right = closest_hits(&*build(PrimsRef::Mixed(set), "brute-force", "").unwrap(), &rays);
    assert_eq!(closest_hits(&*tracer, &rays), right, "{name} {text}");
    tracer.stats().references
}

#[test]
fn building_over_inseparable_primitives_is_near_linear() {
    for (scene, set) in scenes(N) {
        // obvhs as its authors use it is quadratic
        for (name, variant) in right_variants().chain([("obvhs-cwbvh", "adapter=robust")]) {
            let start = std::time::Instant::now();
            let found = references(&set, name, variant);
            // shown with --nocapture: which structure takes long
            let seconds = start.elapsed().as_secs_f64();
            println!("{scene}: {name} {variant}: {found} references, {seconds:.2} s");
            assert!(found <= most_references(N), "{scene}: {name} {variant}: {found} references");
        }
    }
}

#[test]
fn unlimited_growth_is_caught() {
    let n = 4000;
    let [_, (_, triangles), ..] = scenes(n);
    let found = |settings| references(&triangles, "irregular-grid", settings);
    assert!(found("") <= most_references(n));
    let unlimited = found("max-growth=1e9 step-cost=0 longest-list=1");
    assert!(unlimited > most_references(n), "{unlimited}");
}
