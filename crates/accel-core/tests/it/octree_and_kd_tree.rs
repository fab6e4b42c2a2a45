//! The octree in all its settings and the k-d tree against brute force: the same hits to the bit.

use crate::agreement::{agreed, closest_hits};
use crate::common::{Random, build};
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{Cone, MixedSet, MixedSetBuilder};
use accel_core::registry::Buildable;
use accel_core::structure::StructureStats;
use accel_core::{Ray, Scalar};
use glam::{DVec3, Vec3Swizzles as _};

/// A point whose coordinates are often those of cutting planes.
fn lattice_point(random: &mut Random) -> DVec3 {
    (random.signed() * 8.0).round() / 8.0
}

fn mixed<S: Scalar>(n: usize, size: f64, random: &mut Random) -> MixedSet<S> {
    let mut set = MixedSetBuilder::<S>::default();
    for i in 0..n {
        let p = if i % 3 == 0 { lattice_point(random) } else { random.signed() };
        let mut near = || p + random.signed() * size;
        match i % 5 {
            0 => set.sphere(p, size * 0.4).unwrap(),
            1 => {
                let q = near();
                set.cone(Cone::new(p, size * 0.3, q, size * 0.1)).unwrap();
            }
            2 => {
                let (u, v) = (near() - p, near() - p);
                set.polygon(&[p, p + u, p + u + v, p + v]).unwrap();
            }
            // flat on the lattice: lies within cutting planes
            3 => set.triangle([p, p + DVec3::X * size, p + DVec3::Y * size]).unwrap(),
            _ => set.triangle([p, near(), near()]).unwrap(),
        }
        if i % 7 == 0 {
            set.last_is_transmissive();
        }
    }
    set.finish()
}

fn rays<S: Scalar>(n: usize, random: &mut Random) -> Vec<Ray<S>> {
    (0..n)
        .map(|i| {
            let reach = random.one_of(&[0.5, 1.5, 4.0, 1000.0]);
            let (mut origin, mut direction) = (random.signed() * reach, random.signed());
            match i % 6 {
                0 => direction = lattice_point(random) - origin,
                1 => {
                    // parallel to an axis, within planes
                    origin = lattice_point(random) * 2.0;
                    let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
                    direction = random.one_of(&DVec3::AXES) * sign;
                    if i % 12 == 1 {
                        direction = -direction;
                    }
                }
                2 => {
                    // parallel to a plane, and in it
                    origin = lattice_point(random);
                    direction = lattice_point(random);
                    direction[random.one_of(&[0, 1, 2])] = -0.0;
                }
                3 => direction = random.signed() - origin,
                4 => {
                    // diagonals of cells
                    origin = lattice_point(random) * 2.0;
                    direction = random.signed().signum();
                }
                _ => {}
            }
            let mut ray = Ray::<S>::from_dvec3(origin, direction);
            if i % 4 == 0 {
                ray.t_min = S::from_f64(random.unit());
                ray.t_max = S::from_f64(random.unit() * 3.0);
            }
            ray
        })
        .collect()
}

const SETTINGS: &[(&str, &str)] = &[
    ("octree", ""),
    ("octree", "max-leaf=1 useless-splits=3 max-depth=8"),
    ("octree", "max-depth=0"),
    ("octree", "traversal=neighbour"),
    ("octree", "traversal=neighbour max-leaf=1 useless-splits=3 max-depth=8"),
    ("octree", "traversal=point-location max-leaf=1 useless-splits=3 max-depth=8 order=reverse"),
    ("octree", "traversal=point-location subdivision=adaptive"),
    ("octree", "traversal=neighbour subdivision=adaptive max-leaf=2 useless-splits=2"),
    ("octree", "subdivision=adaptive max-leaf=1 useless-splits=2"),
    ("kd-tree", ""),
    ("kd-tree", "exact-below=0"),
    ("kd-tree", "exact-below=100000 empty-bonus=0 traversal-cost=0.2"),
    ("kd-tree", "max-depth=1"),
];

fn compare<S: Buildable>(set: &MixedSet<S>, rays: &[Ray<S>], scene: &str) {
    agreed(scene, PrimsRef::Mixed(set), rays, 50, SETTINGS);
}

fn compare_scenes<S: Buildable>() {
    let mut random = Random::new(7);
    for (n, size) in [(1, 1.0), (40, 0.8), (500, 0.25), (3000, 0.08)] {
        let set = mixed::<S>(n, size, &mut random);
        compare(&set, &rays::<S>(3000, &mut random), &format!("{n} primitives"));
    }
    // all in one plane that the centre's cut contains
    let mut flat = MixedSetBuilder::<S>::default();
    for _ in 0..400 {
        let p = lattice_point(&mut random).with_z(0.0);
        let q = random.signed().with_z(0.0) * 0.3;
        flat.triangle([p, p + q, p + q.yxz()]).unwrap();
    }

    compare(&flat.finish(), &rays::<S>(3000, &mut random), "flat");
}

#[test]
fn the_same_hits_as_brute_force_in_f32() {
    compare_scenes::<f32>();
}

#[test]
fn the_same_hits_as_brute_force_in_f64() {
    compare_scenes::<f64>();
}

fn duplicates(n: usize) -> MixedSet<f32> {
    let mut set = MixedSetBuilder::<f32>::default();
    for _ in 0..n {
        set.triangle([DVec3::ZERO, DVec3::X, DVec3::new(0.3, 1.0, 0.2)]).unwrap();
    }
    set.finish()
}

#[test]
fn ten_thousand_duplicates_stay_few_cells() {
    let set = duplicates(10_000);
    let ray = [Ray::<f32>::new(glam::Vec3::new(0.4, 0.3, 5.0), -glam::Vec3::Z)];
    for (name, settings) in SETTINGS.iter().filter(|(_, s)| !s.contains("useless")) {
        let tracer = build(PrimsRef::Mixed(&set), name, settings).unwrap();
        let StructureStats { references, bytes, .. } = tracer.stats();
        assert!(references < 1_000_000 && bytes < 1 << 24, "{name} {settings} {references}");
        assert_eq!(closest_hits(&*tracer, &ray)[0].id, 0, "{name} {settings}");
    }
}

#[test]
fn limits_are_errors_with_numbers() {
    let set = duplicates(1000);
    let refused =
        |name, settings| build(PrimsRef::Mixed(&set), name, settings).err().unwrap().to_string();
    let e = refused("octree", "max-leaf=0 useless-splits=20 max-growth=1e9 max-references=100000");
    assert!(e.contains("references in cells") && e.contains("100000"), "{e}");
    let e = refused("octree", "max-leaf=0 useless-splits=20 max-growth=1e9 max-cells=100");
    assert_eq!(e, "octree: number of cells would be 105, more than the limit of 100");
    let e = refused("kd-tree", "max-references=999");
    assert!(e.starts_with("kd-tree: references in cells would be"), "{e}");
}

#[test]
fn centre_subdivision_makes_eight_cells_of_one() {
    let mut random = Random::new(3);
    let set = mixed::<f64>(300, 0.2, &mut random);
    for subdivision in ["centre", "adaptive"] {
        let settings =
            format!("subdivision={subdivision} max-leaf=1 useless-splits=20 max-depth=5");
        let stats = build(PrimsRef::Mixed(&set), "octree", &settings).unwrap().stats();
        assert_eq!(stats.cells, 7 * stats.inner_cells + 1);
        assert!(stats.empty_cells < stats.cells && stats.references > 300);
    }
}
