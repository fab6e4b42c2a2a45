//! The octree in all its settings and the k-d tree against brute force: the same hits to the bit.

use crate::agreement::Answers;
use accel_core::params::Params;
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{Cone, MixedSet, MixedSetBuilder};
use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::structure::{BuildError, StructureStats};
use accel_core::structures::find;
use accel_core::{Hit, Ray, Scalar};
use glam::{DVec3, Vec3Swizzles as _};

/// A small generator; the same numbers on every machine.
struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as f64 / (1u64 << 31) as f64
    }
    fn signed(&mut self) -> f64 {
        self.unit() * 2.0 - 1.0
    }
    fn point(&mut self) -> DVec3 {
        DVec3::new(self.signed(), self.signed(), self.signed())
    }
    /// A point whose coordinates are often those of cutting planes.
    fn lattice_point(&mut self) -> DVec3 {
        (self.point() * 8.0).round() / 8.0
    }
    fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }
}

fn mixed<S: Scalar>(n: usize, size: f64, random: &mut Random) -> MixedSet<S> {
    let mut set = MixedSetBuilder::<S>::default();
    for i in 0..n {
        let p = if i % 3 == 0 { random.lattice_point() } else { random.point() };
        let mut near = || p + random.point() * size;
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
            let reach = [0.5, 1.5, 4.0, 1000.0][random.below(4)];
            let (mut origin, mut direction) = (random.point() * reach, random.point());
            match i % 6 {
                0 => direction = random.lattice_point() - origin,
                1 => {
                    // parallel to an axis, within planes
                    origin = random.lattice_point() * 2.0;
                    let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
                    direction = [DVec3::X, DVec3::Y, DVec3::Z][random.below(3)] * sign;
                    if i % 12 == 1 {
                        direction = -direction;
                    }
                }
                2 => {
                    // parallel to a plane, and in it
                    origin = random.lattice_point();
                    direction = random.lattice_point();
                    direction[random.below(3)] = -0.0;
                }
                3 => direction = random.point() - origin,
                4 => {
                    // diagonals of cells
                    origin = random.lattice_point() * 2.0;
                    direction = random.point().signum();
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

fn params(name: &str, settings: &str) -> Params {
    let pairs = settings.split_whitespace().filter_map(|s| s.split_once('='));
    find(name).unwrap().params(pairs).unwrap()
}

fn build<'a, S: Buildable>(
    set: &'a MixedSet<S>,
    name: &str,
    settings: &str,
) -> Result<Box<dyn Tracer<S> + 'a>, BuildError> {
    find(name).unwrap().build(PrimsRef::Mixed(set), &params(name, settings))
}

fn answers<S: Buildable>(tracer: &dyn Tracer<S>, rays: &[Ray<S>]) -> (Vec<Hit<S>>, Vec<bool>) {
    let Answers { hits, blocked } = Answers::written(tracer, rays);
    (hits, blocked)
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

fn compare<S: Buildable>(set: &MixedSet<S>, rays: &[Ray<S>], what: &str) {
    let right = answers(build(set, "brute-force", "").unwrap().as_ref(), rays);
    assert!(right.0.iter().filter(|h| h.is_hit()).count() > rays.len() / 50, "{what}");
    for (name, settings) in SETTINGS {
        let ours = answers(build(set, name, settings).unwrap().as_ref(), rays);
        for (i, ray) in rays.iter().enumerate() {
            let (is, ought) = (ours.0[i], right.0[i]);
            assert_eq!(is, ought, "{what} {} {name} {settings} {ray:?}", S::NAME);
            assert_eq!(ours.1[i], right.1[i], "{what} {} {name} {settings} {ray:?}", S::NAME);
        }
    }
}

fn compare_scenes<S: Buildable>() {
    let mut random = Random(7);
    for (n, size) in [(1, 1.0), (40, 0.8), (500, 0.25), (3000, 0.08)] {
        let set = mixed::<S>(n, size, &mut random);
        compare(&set, &rays::<S>(3000, &mut random), &format!("{n} primitives"));
    }
    // all in one plane that the centre's cut contains
    let mut flat = MixedSetBuilder::<S>::default();
    for _ in 0..400 {
        let p = random.lattice_point().with_z(0.0);
        let q = random.point().with_z(0.0) * 0.3;
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
        let tracer = build(&set, name, settings).unwrap();
        let StructureStats { references, bytes, .. } = tracer.stats();
        assert!(references < 1_000_000 && bytes < 1 << 24, "{name} {settings} {references}");
        assert_eq!(answers(tracer.as_ref(), &ray).0[0].id, 0, "{name} {settings}");
    }
}

#[test]
fn limits_are_errors_with_numbers() {
    let set = duplicates(1000);
    let refused = |name, settings| build(&set, name, settings).err().unwrap().to_string();
    let e = refused("octree", "max-leaf=0 useless-splits=20 max-growth=1e9 max-references=100000");
    assert!(e.contains("references in cells") && e.contains("100000"), "{e}");
    let e = refused("octree", "max-leaf=0 useless-splits=20 max-growth=1e9 max-cells=100");
    assert_eq!(e, "octree: number of cells would be 105, more than the limit of 100");
    let e = refused("kd-tree", "max-references=999");
    assert!(e.starts_with("kd-tree: references in cells would be"), "{e}");
}

#[test]
fn centre_subdivision_makes_eight_cells_of_one() {
    let mut random = Random(3);
    let set = mixed::<f64>(300, 0.2, &mut random);
    for subdivision in ["centre", "adaptive"] {
        let settings =
            format!("subdivision={subdivision} max-leaf=1 useless-splits=20 max-depth=5");
        let stats = build(&set, "octree", &settings).unwrap().stats();
        assert_eq!(stats.cells, 7 * stats.inner_cells + 1);
        assert!(stats.empty_cells < stats.cells && stats.references > 300);
    }
}
