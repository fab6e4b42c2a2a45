//! `wide-bvh query=packets`: rays that run alike share steps, and these count once; a large batch
//! of rays in no order is put into one.

use accel_core::primitives::{PrimsRef, TriangleSet, Watertight};
use accel_core::query::counters::WorkCounters;
use accel_core::{Ray, Vec3, Vector};
use glam::{DVec3, dvec3};

use crate::agreement::{Answers, work};
use crate::common::{Random, build, triangle_set};

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

fn counted(
    set: &TriangleSet<f32, Watertight>,
    query: &str,
    rays: &[Ray<f32>],
) -> (Answers<f32>, [WorkCounters; 2]) {
    let settings = format!("query={query}");
    work(&*build(PrimsRef::Watertight(set), "wide-bvh", &settings).unwrap(), rays)
}

#[test]
fn steps_that_rays_share_count_once() {
    let set = triangles(&mut Random::new(4));
    let alike = rays(true);
    let (one, packets) = (counted(&set, "one", &alike), counted(&set, "packets", &alike));
    assert_eq!(one.0, packets.0);
    assert!(one.0.hits.iter().filter(|hit| hit.is_hit()).count() > 1000);
    for (one, packets) in one.1.into_iter().zip(packets.1) {
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

/// The alike rays, each two or three times, in an order that has nothing to do with where they start
/// and run; more of them than are copied at a time.
#[test]
fn rays_in_no_order_share_steps_as_well() {
    let set = triangles(&mut Random::new(4));
    let alike = rays(true);
    let mixed: Vec<Ray<f32>> = (0..10_000).map(|i| alike[i * 1031 % 4096]).collect();
    let (one, packets) = (counted(&set, "one", &mixed), counted(&set, "packets", &mixed));
    assert_eq!(one.0, packets.0);
    let inner = |work: WorkCounters| work.traversal_steps - work.elementary_steps;
    for (one, packets) in one.1.into_iter().zip(packets.1) {
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
