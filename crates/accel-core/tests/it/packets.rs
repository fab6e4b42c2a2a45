//! `wide-bvh query=packets`: rays that run alike share steps, and these count once; a large batch
//! of rays in no order is put into one.

use accel_core::primitives::{PrimsRef, TriangleSet, Watertight};
use accel_core::query::counters::WorkCounters;
use accel_core::query::tracer::{ShadowCount, ShadowRule};
use accel_core::structures::find;
use accel_core::{Hit, Ray, Vec3, Vector};
use glam::{DVec3, dvec3};

use crate::common::{Random, triangle_set};

/// Small triangles in the unit cube.
fn triangles(random: &mut Random) -> TriangleSet<f32, Watertight> {
    let mut triangle = || {
        let at = random.point();
        [at, at + random.signed() * 0.05, at + random.signed() * 0.05]
    };
    triangle_set((0..3000).map(|_| triangle()), |_| false)
}

/// From in front of the cube: to points in a row, or to eight in turn that lie far from each other.
fn rays(are_alike: bool) -> Vec<Ray<f32>> {
    let ray = |i: usize| {
        let at = if are_alike { i as f64 / 4096.0 } else { (i * 1031 % 4096) as f64 / 4096.0 };
        let to = dvec3(at, (i / 8 % 64) as f64 / 64.0, 1.0);
        let from = dvec3(-0.5, -0.75, -3.0);
        let mut ray = Ray::<f32>::from_dvec3(from, to - from);
        if !are_alike && i % 2 == 1 {
            ray.direction = Vec3::<f32>::from_dvec3((to - from) * DVec3::new(0.01, 1.0, 1.0));
        }
        ray
    };
    (0..4096).map(ray).collect()
}

type Counted = (Vec<Hit<f32>>, Vec<bool>, [WorkCounters; 2]);

fn counted(set: &TriangleSet<f32, Watertight>, query: &str, rays: &[Ray<f32>]) -> Counted {
    let entry = find("wide-bvh").unwrap();
    let params = entry.params([("query", query)]).unwrap();
    let tracer = entry.build(PrimsRef::Watertight(set), &params).unwrap();
    let mut hits = vec![Hit::NONE; rays.len()];
    let closest = tracer.count_closest_hits(rays, &mut hits);
    let mut timed = vec![Hit { t: f32::NAN, id: 0 }; rays.len()];
    tracer.closest_hits(rays, &mut timed);
    assert_eq!(hits, timed);
    // what is not written is wrong
    let mut shadows: Vec<ShadowCount> =
        hits.iter().map(|hit| ShadowCount { blocked: !hit.is_hit(), glass: 0 }).collect();
    let any = tracer.count_occlusions(rays, ShadowRule::OpaqueBlocks, &mut shadows);
    let blocked: Vec<bool> = shadows.iter().map(|shadow| shadow.blocked).collect();
    let mut timed: Vec<bool> = hits.iter().map(|hit| !hit.is_hit()).collect();
    tracer.occlusions(rays, &mut timed);
    assert_eq!(blocked, timed);
    (hits, blocked, [closest, any])
}

#[test]
fn steps_that_rays_share_count_once() {
    let set = triangles(&mut Random::new(4));
    let alike = rays(true);
    let (one, packets) = (counted(&set, "one", &alike), counted(&set, "packets", &alike));
    assert_eq!((&one.0, &one.1), (&packets.0, &packets.1));
    assert!(one.0.iter().filter(|hit| hit.is_hit()).count() > 1000);
    for (one, packets) in one.2.into_iter().zip(packets.2) {
        let inner = |work: WorkCounters| work.traversal_steps - work.elementary_steps;
        assert!(inner(packets) * 3 < inner(one), "{packets:?} {one:?}");
        // each ray visits the lists that it meets, in an order that it has in common with others
        let [few, many] = [packets, one].map(|work| work.elementary_steps as f64);
        assert!((0.9..1.4).contains(&(few / many)), "{packets:?} {one:?}");
    }
}

#[test]
fn rays_that_run_apart_take_the_steps_of_one() {
    let set = triangles(&mut Random::new(4));
    // too few to be put into an order
    let apart = &rays(false)[..4000];
    assert_eq!(counted(&set, "one", apart), counted(&set, "packets", apart));
}

/// The alike rays in an order that has nothing to do with where they start and run.
#[test]
fn rays_in_no_order_share_steps_as_well() {
    let set = triangles(&mut Random::new(4));
    let alike = rays(true);
    let mixed: Vec<Ray<f32>> = (0..4096).map(|i| alike[i * 1031 % 4096]).collect();
    let (one, packets) = (counted(&set, "one", &mixed), counted(&set, "packets", &mixed));
    assert_eq!((&one.0, &one.1), (&packets.0, &packets.1));
    let inner = |work: WorkCounters| work.traversal_steps - work.elementary_steps;
    for (one, packets) in one.2.into_iter().zip(packets.2) {
        assert!(inner(packets) * 3 < inner(one), "{packets:?} {one:?}");
    }
}

/// Rays from points in a row into all directions: their order is kept.
#[test]
fn rays_that_start_alike_keep_their_order() {
    let random = &mut Random::new(4);
    let set = triangles(random);
    let ray = |i: usize| {
        let from = dvec3(i as f64 / 4096.0, 0.5, 0.5);
        let to = random.point() - 0.5;
        Ray::<f32>::from_dvec3(from, to)
    };
    let rays: Vec<Ray<f32>> = (0..4096).map(ray).collect();
    assert_eq!(counted(&set, "one", &rays), counted(&set, "packets", &rays));
}
