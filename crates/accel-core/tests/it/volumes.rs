//! Bounding volumes and their hierarchy, in more settings than are measured, against brute force:
//! the same hits to the bit.

use crate::agreement::agreed;
use crate::common::{Random, Set, all_scenes, build, rays_for};
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{MixedSetBuilder, TriangleSet, Watertight};
use accel_core::registry::Buildable;
use accel_core::structure::StructureStats;
use accel_core::{Hit, Ray, Vec3, Vector};
use glam::{DVec3, dvec3};

const SETTINGS: &[(&str, &str)] = &[
    ("bounding-volumes", ""),
    ("bounding-volumes", "group=5"),
    ("bounding-volumes", "volume=sphere"),
    ("bounding-volumes", "volume=sphere group=8"),
    ("bounding-volumes", "volume=slabs directions=3"),
    ("bounding-volumes", "volume=slabs directions=4 group=3"),
    ("bounding-volumes", "volume=slabs"),
    ("bounding-volumes", "volume=slabs group=1000000"),
    ("kay-kajiya", ""),
    ("kay-kajiya", "directions=3 leaf-size=3"),
    ("kay-kajiya", "directions=4 branching=8"),
    ("kay-kajiya", "branching=4 leaf-size=7"),
    ("kay-kajiya", "branching=8 leaf-size=1000000"),
];

fn compare<S: Buildable>(prims: PrimsRef<S>, rays: &[Ray<S>], scene: &str) {
    agreed(scene, prims, rays, 100, SETTINGS);
}

fn random_scenes<S: Buildable>() {
    for (name, set, bounds) in all_scenes::<S>() {
        compare(set.prims(), &rays_for::<S>(bounds, &mut Random::new(21)), name);
    }
}

#[test]
fn the_same_hits_as_brute_force_in_f32() {
    random_scenes::<f32>();
}

#[test]
fn the_same_hits_as_brute_force_in_f64() {
    random_scenes::<f64>();
}

/// Octahedra around lattice points, their corners an eighth of a unit apart: every face lies in a
/// plane of a slab, and every number is exact in f32.
fn octahedra<S: Buildable>(size: f64) -> Set<S> {
    let mut list = Vec::new();
    for i in 0..27 {
        let centre = dvec3((i % 3) as f64, (i / 3 % 3) as f64, (i / 9) as f64) * 0.5;
        for octant in 0..8 {
            let sign = |k: usize| if octant >> k & 1 == 0 { 0.125 } else { -0.125 };
            let corners = [DVec3::X * sign(0), DVec3::Y * sign(1), DVec3::Z * sign(2)];
            let corner = |k: usize| Vec3::<S>::from_dvec3((centre + corners[k]) * size).to_array();
            list.push([corner(0), corner(1), corner(2)]);
        }
    }
    Set::Triangles(TriangleSet::<S, Watertight>::new(list, |id| id % 5 == 0).unwrap())
}

/// Rays from lattice points along axes and diagonals: within, along and onto planes of slabs, with
/// zeros of both signs.
fn lattice_rays<S: Buildable>(size: f64) -> Vec<Ray<S>> {
    let mut random = Random::new(3);
    let mut rays = Vec::new();
    for i in 0..4000 {
        let lattice = |random: &mut Random| (random.point() * 16.0).floor() / 8.0 - 0.5;
        let origin = lattice(&mut random);
        let mut direction = (random.signed() * 2.5).trunc();
        if i % 3 == 0 {
            direction = lattice(&mut random) - origin;
        }
        if i % 2 == 0 {
            direction = -direction;
        }
        rays.push(Ray::from_dvec3(origin * size, direction * size));
    }
    rays
}

#[test]
fn rays_along_and_onto_planes_of_slabs() {
    // powers of two, so that the planes stay exact; the products of the triangle test must fit f32
    for exponent in [-30, -10, 0, 10, 30] {
        let size = 2f64.powi(exponent);
        compare(octahedra::<f32>(size).prims(), &lattice_rays(size), "octahedra");
        compare(octahedra::<f64>(size).prims(), &lattice_rays(size), "octahedra");
    }
}

#[test]
fn rays_from_eight_magnitudes_and_beyond() {
    fn check<S: Buildable>() {
        let mut random = Random::new(5);
        let set = octahedra::<S>(1.0);
        let rays: Vec<Ray<S>> = (0..3000)
            .map(|i| {
                let distance = [7.9, 8.5, 1e3, 1e6][i % 4];
                let direction = random.signed().normalize_or(DVec3::X);
                let target = (random.point() * 9.0).floor() / 8.0;
                Ray::from_dvec3(target - direction * distance, direction * random.unit().max(0.01))
            })
            .collect();
        compare(set.prims(), &rays, "from afar");
    }
    check::<f32>();
    check::<f64>();
}

fn duplicates(n: usize) -> Set<f32> {
    let triangle = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.3, 1.0, 0.2]];
    Set::Triangles(TriangleSet::new(vec![triangle; n], |_| false).unwrap())
}

#[test]
fn ten_thousand_duplicates() {
    let set = duplicates(10_000);
    let rays: Vec<Ray<f32>> = (0..20)
        .map(|i| Ray::from_dvec3(dvec3(0.4, 0.3 + f64::from(i) * 0.05, 5.0), -DVec3::Z))
        .collect();
    compare(set.prims(), &rays, "duplicates");
    for (name, settings) in SETTINGS {
        let stats: StructureStats = build(set.prims(), name, settings).unwrap().stats();
        assert_eq!((stats.references, stats.empty_cells), (10_000, 0), "{name} {settings}");
        assert!(stats.inner_cells < stats.cells && stats.cells <= 10_000, "{name} {settings}");
    }
}

#[test]
fn limits_are_errors_with_numbers() {
    let set = duplicates(1000);
    let refused = |name, settings| build(set.prims(), name, settings).err().unwrap().to_string();
    let limit = "more than the limit of";
    let e = refused("bounding-volumes", "group=10 max-cells=99");
    assert_eq!(e, format!("bounding-volumes: number of volumes would be 100, {limit} 99"));
    let e = refused("kay-kajiya", "max-cells=1998");
    assert_eq!(e, format!("kay-kajiya: number of volumes would be 1999, {limit} 1998"));
    assert!(build(set.prims(), "kay-kajiya", "max-cells=1999").is_ok());
}

#[test]
fn counters_say_what_was_tested() {
    let mut set = MixedSetBuilder::<f64>::default();
    for i in 0..10 {
        set.sphere(DVec3::X * f64::from(i) * 3.0, 1.0).unwrap();
    }
    let set = set.finish();
    let work = |ray, name, settings| {
        let tracer = build(PrimsRef::Mixed(&set), name, settings).unwrap();
        tracer.count_closest_hits(&[ray], &mut [Hit::NONE])
    };
    // past the first five spheres, down onto the sixth
    let ray = Ray::from_dvec3(dvec3(15.0, 0.0, 9.0), -DVec3::Z);
    for settings in ["", "volume=sphere", "volume=slabs"] {
        let work = work(ray, "bounding-volumes", settings);
        let steps = (work.traversal_steps, work.elementary_steps, work.empty_elementary_steps);
        assert_eq!((steps, work.intersection_tests), ((10, 1, 0), 1), "{settings}");
    }
    // from the end: the nearest sphere is reached and no other
    let ray = Ray::from_dvec3(dvec3(-9.0, 0.0, 0.0), DVec3::X);
    let work = work(ray, "kay-kajiya", "");
    assert_eq!((work.elementary_steps, work.intersection_tests), (1, 1));
}
