//! Scenes of copies, and structures that divide each object once.

use accel_core::Ray;
use accel_core::primitives::{
    Instance, Instances, MixedSetBuilder, Primitives, TriangleSet, Watertight,
};
use accel_core::registry::Buildable;
use accel_core::structures::{REGISTRY, find};
use glam::{DAffine3, DVec3, dvec3};

use crate::agreement::mismatches;
use crate::common::{Named, Random, Set, rays_for, triangle_set};

/// Places of all kinds: turned, mirrored, stretched, small and large, one in the place of another.
fn places(r: &mut Random, count: usize, room: f64, is_similar: bool) -> Vec<DAffine3> {
    let mut all: Vec<DAffine3> = Vec::new();
    for i in 0..count {
        let mut scale = DVec3::splat(r.one_of(&[1.0, 1.0, 0.4, 2.5]));
        if !is_similar && i % 3 == 1 {
            scale *= dvec3(1.0, 0.3 + r.unit(), -1.0 - r.unit());
        }
        if i % 7 == 5 {
            scale = -scale;
        }
        let place =
            DAffine3::from_scale_rotation_translation(scale, r.rotation(), r.point() * room);
        all.push(if i % 11 == 10 { all[i - 1] } else { place });
    }
    all
}

/// Copies of a bush of triangles, with other triangles between them.
fn bushes<S: Buildable>(
    count: usize,
    room: f64,
    offset: DVec3,
) -> (TriangleSet<S, Watertight>, Vec<Instance>) {
    let mut r = Random::new(count as u64);
    let bush: Vec<[DVec3; 3]> = (0..40)
        .map(|_| {
            let p = r.signed();
            [p, p + r.signed() * 0.4, p + r.signed() * 0.4]
        })
        .collect();
    let (mut all, mut claims) = (Vec::new(), Vec::new());
    for placement in places(&mut r, count, room, false) {
        let placement = DAffine3::from_translation(offset) * placement;
        let first = all.len() as u32;
        claims.push(Instance { object: 7, first, count: 40, placement });
        all.extend(bush.iter().map(|t| t.map(|p| placement.transform_point3(p))));
        let p = offset + r.point() * room;
        all.push([p, p + r.signed(), p + r.signed()]);
    }
    let set = triangle_set(all, |id| id % 9 == 0);
    (set.with_instances(&claims), claims)
}

/// Copies of something of every kind of primitive.
fn mixed<S: Buildable>() -> Set<S> {
    let mut r = Random::new(11);
    let mut set = MixedSetBuilder::<S>::default();
    let mut claims = Vec::new();
    for (i, placement) in places(&mut r, 16, 6.0, true).into_iter().enumerate() {
        let at = |x: f64, y: f64, z: f64| placement.transform_point3(dvec3(x, y, z));
        let scale = placement.matrix3.determinant().abs().cbrt();
        set.sphere(at(0.5, 0.5, 0.0), 0.3 * scale).unwrap();
        set.triangle([at(0.0, 0.0, 0.0), at(1.0, 0.0, 0.2), at(0.0, 1.0, 0.1)]).unwrap();
        set.sphere(at(-0.5, 0.2, 0.4), 0.2 * scale).unwrap();
        claims.push(Instance { object: 0, first: 3 * i as u32, count: 3, placement });
    }
    Set::Mixed(set.finish().with_instances(&claims))
}

/// A name, the set and its bounds.
pub fn scenes<S: Buildable>() -> Vec<Named<S>> {
    let room = |from: DVec3, size: f64| (from, from + DVec3::splat(size));
    let far = dvec3(300.0, -200.0, 100.0);
    vec![
        ("copies", Set::Triangles(bushes(24, 10.0, DVec3::ZERO).0), room(DVec3::ZERO, 10.0)),
        ("copies far away", Set::Triangles(bushes(12, 4.0, far).0), room(far, 4.0)),
        ("copies of spheres", mixed(), room(DVec3::ZERO, 6.0)),
    ]
}

fn instances<S: Buildable>(set: &Set<S>) -> &Instances {
    set.prims().primitives().instances().unwrap()
}

/// Asserts that most claims hold, so that the tests over [`scenes`] test something.
fn hold<S: Buildable>() {
    for ((name, set, _), copies) in scenes::<S>().iter().zip([24, 12, 16]) {
        let found = instances(set);
        assert_eq!((found.objects(), found.copies()), (1, copies), "{name} {}", S::NAME);
    }
}

#[test]
fn copies_are_known_as_such() {
    hold::<f32>();
    hold::<f64>();
}

#[test]
fn an_object_is_divided_once() {
    let (set, claims) = bushes::<f32>(100, 20.0, DVec3::ZERO);
    let flat = set.clone().with_instances(&[]);
    assert_eq!(claims.len(), 100);
    let prims = |set| accel_core::primitives::PrimsRef::<f32>::Watertight(set);
    for (instanced, plain) in [("instanced-grid", "uniform-grid"), ("instanced-bvh", "wide-bvh")] {
        let stats = |name: &str, set| {
            let entry = find(name).unwrap();
            entry.build(prims(set), &entry.defaults()).unwrap().stats()
        };
        let (two_levels, one, flat) =
            (stats(instanced, &set), stats(plain, &set), stats(instanced, &flat));
        assert!(two_levels.bytes * 3 < one.bytes, "{two_levels:?} {one:?}");
        // 100 triangles are in no bush, the 40 of a bush are listed once
        assert!(two_levels.references * 5 < one.references, "{two_levels:?} {one:?}");
        // without copies it is one object
        assert!(flat.cells > 2 * two_levels.cells, "{two_levels:?} {flat:?}");
    }
}

#[test]
fn a_planted_false_copy_is_caught() {
    let (set, mut claims) = bushes::<f32>(24, 10.0, DVec3::ZERO);
    let whole = set.instances().unwrap().copies();
    // a transform that is not inverted: where the second stands, a ray would look for another place
    claims[1].placement = claims[1].placement.inverse();
    let found = set.clone().with_instances(&claims);
    assert_eq!(found.instances().unwrap().copies(), whole - 1);
    let mut r = Random::new(5);
    let rays: Vec<Ray<f32>> = rays_for((DVec3::ZERO, DVec3::splat(10.0)), &mut r);
    let is_instanced = |e: &&accel_core::structures::Entry| e.info.name.starts_with("instanced");
    let entries: Vec<_> = REGISTRY.iter().filter(is_instanced).copied().collect();
    let prims = accel_core::primitives::PrimsRef::Watertight(&found);
    assert_eq!((entries.len(), mismatches(&entries, "planted", prims, &rays)), (2, Vec::new()));
}
