//! Structures that are taken from frame to frame answer as brute force does in each.

use std::ops::Range;

use accel_core::bvh;
use accel_core::params::Params;
use accel_core::params::config::Settings;
use accel_core::primitives::{
    Instance, MixedSet, MixedSetBuilder, Primitives, PrimsRef, TriangleSet, Watertight,
};
use accel_core::query::sink::Sink;
use accel_core::query::tracer::PreviousFrame;
use accel_core::registry::Buildable;
use accel_core::structure::{BuildError, Structure, StructureStats};
use accel_core::structures::{Entry, REGISTRY, find};
use accel_core::update::{Change, moved};
use accel_core::{Ray, Scalar};
use glam::{DAffine3, DQuat, DVec3, dvec3};

use crate::agreement::Answers;
use crate::common::{Random, Set, planted_entry, rays_for, triangle_set};

const FRAMES: Range<u32> = 0..8;
/// Objects of the rigid parts; some stand several times.
const PARTS: [u32; 9] = [0, 0, 1, 2, 2, 2, 3, 4, 5];
const TRIANGLES: u32 = 20;

/// Primitives that move besides the rigid parts.
#[derive(Clone, Copy, PartialEq)]
enum Free {
    Rests,
    Moves,
}

/// Placement of a part in a frame: all at rest in frame 3, one alone moves in frame 4, far away in
/// frame 6.
fn placement(part: usize, frame: u32) -> DAffine3 {
    let step = |frame: u32| {
        let x = f64::from(frame) * 0.3 + part as f64;
        let at = dvec3((7.0 * x).sin(), (5.0 * x).cos(), (3.0 * x).sin()) * 3.0 + 4.0;
        DAffine3::from_rotation_translation(DQuat::from_rotation_y(x), at)
    };
    match frame {
        3 => step(2),
        4 if part != 2 => step(2),
        6 => DAffine3::from_translation(DVec3::X * 60.0) * step(6),
        frame => step(frame),
    }
}

/// A frame's triangles and what is said to be rigid.
fn triangles(frame: u32, free: Free) -> (Vec<[DVec3; 3]>, Vec<Instance>) {
    let (mut all, mut claims) = (Vec::new(), Vec::new());
    // the corners of the scene, part of nothing
    for corner in [DVec3::splat(-3.0), DVec3::splat(11.0)] {
        all.push([corner, corner + DVec3::X * 0.01, corner + DVec3::Y * 0.01]);
    }
    for (part, &object) in PARTS.iter().enumerate() {
        let mut r = Random::new(u64::from(object) + 5);
        let placement = placement(part, frame);
        claims.push(Instance { object, first: all.len() as u32, count: TRIANGLES, placement });
        for _ in 0..TRIANGLES {
            let p = r.signed();
            let own = [p, p + r.signed() * 0.4, p + r.signed() * 0.4];
            all.push(own.map(|p| placement.transform_point3(p)));
        }
    }
    let mut r = Random::new(77);
    // of so many most rest
    for i in 0..240 {
        let p = r.point() * 8.0;
        let by =
            if free == Free::Moves && i < 40 && i % 3 == 0 { f64::from(frame) * 0.1 } else { 0.0 };
        all.push([p + by, p + r.signed() * 0.5, p + r.signed() * 0.5 - by]);
    }
    (all, claims)
}

fn triangles_of<S: Buildable>(frame: u32, free: Free) -> TriangleSet<S, Watertight> {
    let (all, claims) = triangles(frame, free);
    let set = triangle_set(all, |id| id % 9 == 0);
    set.with_instances(&claims)
}

/// The same with a sphere in each triangle's place, every other time.
fn mixed_set<S: Buildable>(frame: u32, free: Free) -> MixedSet<S> {
    let (all, claims) = triangles(frame, free);
    let mut set = MixedSetBuilder::<S>::default();
    for (i, t) in all.iter().enumerate() {
        match i % 2 {
            0 => set.triangle(*t).unwrap(),
            _ => set.sphere(t[0], 0.1).unwrap(),
        }
    }
    set.finish().with_instances(&claims)
}

/// A scene's frames, parts that are not rigid left out.
fn frames<S: Buildable>(is_mixed: bool, free: Free) -> Vec<(Set<S>, Vec<u32>)> {
    let mut sets: Vec<Set<S>> = Vec::new();
    let mut all_moved = Vec::new();
    for frame in FRAMES {
        let (mut set, first) = if is_mixed {
            (Set::Mixed(mixed_set(frame, free)), sets.first())
        } else {
            (Set::Triangles(triangles_of(frame, free)), sets.first())
        };
        match (&mut set, first) {
            (Set::Triangles(now), Some(Set::Triangles(first))) => now.keep_rigid(first),
            (Set::Mixed(now), Some(Set::Mixed(first))) => now.keep_rigid(first),
            _ => {}
        }
        let of_last =
            |last: &Set<S>| moved(last.prims().primitives(), set.prims().primitives()).unwrap();
        all_moved.push(sets.last().map(of_last).unwrap_or_default());
        sets.push(set);
    }
    sets.into_iter().zip(all_moved).collect()
}

/// Rays, and what brute force answers in each frame.
fn asked<S: Buildable>(frames: &[(Set<S>, Vec<u32>)]) -> (Vec<Ray<S>>, Vec<Answers<S>>) {
    let bounds = (DVec3::ZERO, DVec3::splat(9.0));
    let rays: Vec<_> = rays_for::<S>(bounds, &mut Random::new(3)).into_iter().step_by(3).collect();
    let expected = frames.iter().map(|(set, _)| Answers::expected(set.prims(), &rays)).collect();
    (rays, expected)
}

/// Wrong answers in all frames, and how many frames were updated and not built.
fn wrong_of<S: Buildable>(
    entry: &Entry,
    params: &Params,
    frames: &[(Set<S>, Vec<u32>)],
    (rays, expected): &(Vec<Ray<S>>, Vec<Answers<S>>),
) -> (usize, usize) {
    let (mut wrong, mut updated) = (0, 0);
    let mut kept = None;
    for ((set, moved), expected) in frames.iter().zip(expected) {
        let tracer = match kept {
            None => entry.build(set.prims(), params),
            Some(kept) => entry.update(set.prims(), params, PreviousFrame { kept, moved }),
        };
        let tracer = tracer.unwrap();
        updated += usize::from(tracer.is_updated());
        let (counted, _) = Answers::counted(&*tracer, rays, expected);
        for answers in [Answers::of(&*tracer, rays, expected), counted] {
            wrong += answers.differing(expected).len();
        }
        kept = tracer.released();
    }
    (wrong, updated)
}

/// All settings `update` but `rebuild`, and for the others the defaults.
fn settings_of(entry: &Entry) -> Vec<Params> {
    let mut all = vec![entry.defaults()];
    for how in ["refit", "incremental", "instances"] {
        if let Ok(params) = entry.defaults().set("update", how) {
            all.push(params.clone());
            all.extend(params.clone().set("rebuild-at", 1e6));
            all.extend(params.clone().set("kernel", "scalar"));
            all.extend(params.clone().set("order", "reverse"));
            all.extend(params.set("mailbox", "hash"));
        }
    }
    all
}

fn every_frame_is_right<S: Buildable>() {
    for (is_mixed, free) in
        [(false, Free::Rests), (false, Free::Moves), (true, Free::Rests), (true, Free::Moves)]
    {
        let frames = frames::<S>(is_mixed, free);
        let asked = asked(&frames);
        for entry in REGISTRY {
            for params in settings_of(entry) {
                let (wrong, updated) = wrong_of(entry, &params, &frames, &asked);
                let how = params.get("update").unwrap_or("rebuild");
                let label = format!("{} {params:?} {is_mixed}", entry.info.name);
                let is_right = (entry.info.known_defect)(&params).is_none();
                assert!(wrong == 0 || !is_right, "{label}: {wrong}");
                match (how, free) {
                    ("rebuild", _) | ("instances", Free::Moves) => {
                        assert_eq!(updated, 0, "{label}")
                    }
                    // the scene becomes larger, and as small as before
                    ("incremental", _) => assert_eq!(updated, 5, "{label}"),
                    ("instances", Free::Rests) => assert!(updated >= 6, "{label} {updated}"),
                    _ if params.get("rebuild-at") == Some("1000000") => {
                        assert_eq!(updated, 7, "{label}");
                    }
                    _ => assert!(updated >= 2, "{label} {updated}"),
                }
            }
        }
    }
}

#[test]
fn every_frame_is_right_in_f32() {
    every_frame_is_right::<f32>();
}

#[test]
fn every_frame_is_right_in_f64() {
    every_frame_is_right::<f64>();
}

/// A refit that forgets to fit.
struct Stale<S: Scalar>(bvh::WideBvh<S>);

impl<S: Scalar> Structure<S> for Stale<S> {
    type Config = <bvh::WideBvh<S> as Structure<S>>::Config;

    fn build(
        prims: &dyn Primitives<S>,
        settings: &Settings<Self::Config>,
    ) -> Result<Self, BuildError> {
        Structure::build(prims, settings).map(Self)
    }

    fn update(
        &mut self,
        _: &dyn Primitives<S>,
        _: &Settings<Self::Config>,
        _: &[u32],
    ) -> Result<Change, BuildError> {
        Ok(Change::Updated)
    }

    fn traverse<K: Sink<S>>(&self, ray: &Ray<S>, sink: &mut K) {
        self.0.traverse(ray, sink);
    }

    fn stats(&self) -> StructureStats {
        Structure::<S>::stats(&self.0)
    }
}

#[test]
fn planted_faults_are_found() {
    let rigid = frames::<f32>(false, Free::Rests);
    let asked = asked(&rigid);
    // boxes that are not fitted
    let stale = planted_entry!(Stale, bvh::INFO);
    assert!(wrong_of(&stale, &stale.defaults(), &rigid, &asked).0 > 100);
    // stale cells: half of what moved is not said to have
    let mut few = frames::<f32>(false, Free::Rests);
    for (_, moved) in &mut few {
        moved.retain(|id| id % 2 == 0);
    }
    for name in ["uniform-grid", "hashed-grid", "two-level-grid"] {
        let grid = find(name).unwrap();
        let params = grid.defaults().set("update", "incremental").unwrap();
        assert!(wrong_of(grid, &params, &few, &asked).0 > 100, "{name}");
    }
    // transforms the wrong way round
    let mut inverted = frames::<f32>(false, Free::Rests);
    for (frame, (set, _)) in (0..).zip(&mut inverted) {
        let Set::Triangles(set) = set else { continue };
        let (_, mut claims) = triangles(frame, Free::Rests);
        for (part, claim) in claims.iter_mut().enumerate() {
            let first = placement(part, 0);
            claim.placement = first * placement(part, frame).inverse() * first;
        }
        *set = set.clone().with_instances(&claims);
    }
    let bvh = find("instanced-bvh").unwrap();
    let params = bvh.defaults().set("update", "instances").unwrap();
    assert!(wrong_of(bvh, &params, &inverted, &asked).0 > 100);
    // the same are no parts where somebody looks
    let (first, rest) = inverted.split_at_mut(1);
    let [(Set::Triangles(first), _)] = first else { unreachable!() };
    for (set, _) in rest {
        let Set::Triangles(set) = set else { continue };
        set.keep_rigid(first);
    }
    assert_eq!(wrong_of(bvh, &params, &inverted, &asked).0, 0);
}

#[test]
fn moved_primitives_are_found() {
    let sets = [0, 1, 2, 3, 4].map(|frame| mixed_set::<f64>(frame, Free::Rests));
    let count = |a: usize, b: usize| moved(&sets[a], &sets[b]).unwrap().len();
    assert_eq!([count(2, 3), count(3, 4)], [0, 20]);
    assert_eq!(count(0, 1), PARTS.len() * 20);
    assert_eq!(moved(&sets[0], &MixedSetBuilder::<f64>::default().finish()), None);
    // another set of as many is no frame of it: wrong, but nothing panics
    let grid = find("uniform-grid").unwrap();
    let params = grid.defaults().set("update", "incremental").unwrap();
    let tracer = grid.build(PrimsRef::Mixed(&sets[0]), &params).unwrap();
    let before = PreviousFrame { kept: tracer.released().unwrap(), moved: &[] };
    let other = triangles_of::<f64>(0, Free::Rests);
    assert!(grid.update(PrimsRef::Watertight(&other), &params, before).is_ok());
}
