//! Scenes that move.

mod aff;
mod files;
mod generated;
mod gltf;

use glam::{DAffine3, DVec3};
use scene_loading::{Instance, Scene};

/// The corners of an instance, brought elsewhere.
fn corners(scene: &Scene, instance: &Instance, by: DAffine3) -> Vec<DVec3> {
    let ids = instance.first as usize..(instance.first + instance.count) as usize;
    let all = scene.primitives[ids].iter().flat_map(|p| scene.outline(p.shape));
    all.map(|v| by.transform_point3(v)).collect()
}

/// How far apart two lists of corners are at most.
fn apart(a: &[DVec3], b: &[DVec3]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max)
}

/// The greatest distance between where a corner is in the second frame and where the claims of both
/// say that it is, and between copies of an object.
fn claim_error(first: &Scene, other: &Scene) -> f64 {
    assert_eq!(first.instances.len(), other.instances.len());
    let mut worst: f64 = 0.0;
    for (a, b) in first.instances.iter().zip(&other.instances) {
        assert_eq!((a.object, a.first, a.count), (b.object, b.first, b.count));
        let moved = corners(first, a, b.placement * a.placement.inverse());
        worst = worst.max(apart(&moved, &corners(other, b, DAffine3::IDENTITY)));
        let model = other.instances.iter().find(|i| i.object == b.object).unwrap();
        assert_eq!(model.count, b.count);
        let of_model = corners(other, model, b.placement * model.placement.inverse());
        worst = worst.max(apart(&of_model, &corners(other, b, DAffine3::IDENTITY)));
    }
    worst
}

/// How many primitives are part of an instance; none is part of two.
fn claimed(scene: &Scene) -> usize {
    let mut ids: Vec<u32> =
        scene.instances.iter().flat_map(|i| i.first..i.first + i.count).collect();
    let count = ids.len();
    ids.sort_unstable();
    ids.dedup();
    assert_eq!(ids.len(), count);
    count
}
