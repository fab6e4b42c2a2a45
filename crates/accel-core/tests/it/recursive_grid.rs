use glam::{DVec3, dvec3};

use crate::agreement::{agreed, closest_hits as hits};
use crate::common::{Random, build};
use accel_core::Vector;
use accel_core::geometry::aabb::Aabb;
use accel_core::geometry::ray::{Hit, Ray};
use accel_core::geometry::scalar::Vec3;
use accel_core::memory::MemoryLimit;
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{
    Cone, MixedSet, MixedSetBuilder, Primitives as _, TriangleSet, Watertight,
};
use accel_core::registry::Buildable;
use accel_core::structure::BuildError;
use accel_core::structures::find;

/// Primitives of all kinds in the unit cube, most of them crowded in a corner.
fn mixed<S: Buildable>(n: usize, seed: u64) -> MixedSet<S> {
    let mut random = Random::new(seed);
    let mut builder = MixedSetBuilder::default();
    for i in 0..n {
        let crowded = i % 8 != 0;
        let scale = if crowded { 0.05 } else { 1.0 };
        let at = random.point() * scale;
        let mut near = || at + (random.point() - 0.5) * scale * 0.2;
        let (a, b, c) = (near(), near(), near());
        match i % 4 {
            0 => builder.triangle([a, b, c]),
            1 => builder.polygon(&[a, b, c, a + (c - b)]),
            2 => builder.sphere(a, scale * 0.05),
            _ => builder.cone(Cone::new(a, scale * 0.03, b, scale * 0.01)),
        }
        .unwrap();
    }
    builder.finish()
}

/// Rays of all sorts: through the scene, axis-parallel, in planes of the cells, from within.
fn rays<S: Buildable>(n: usize, seed: u64) -> Vec<Ray<S>> {
    let mut random = Random::new(seed);
    (0..n)
        .map(|i| {
            let target = random.point() * if i % 3 == 0 { 1.0 } else { 0.06 };
            let (origin, direction) = match i % 5 {
                0 | 1 => {
                    let origin = random.point() * 4.0 - 1.5;
                    (origin, target - origin)
                }
                2 => (random.point() * 0.06, random.point() - 0.5),
                3 => {
                    let mut direction = DVec3::ZERO;
                    direction[i / 5 % 3] = if i % 2 == 0 { 1.0 } else { -1.0 };
                    (target - direction * 2.0, direction)
                }
                _ => {
                    let mut direction = random.point() - 0.5;
                    direction[i / 5 % 3] = if i % 2 == 0 { 0.0 } else { -0.0 };
                    ((target * 16.0).round() / 16.0 - direction * 3.0, direction)
                }
            };
            Ray::from_dvec3(origin, direction)
        })
        .filter(Ray::is_traceable)
        .collect()
}

/// Deep grids in every setting that must give right answers.
const SETTINGS: [&str; 9] = [
    "",
    "max-depth=1",
    "max-depth=2",
    "max-depth=8 threshold=1",
    "max-depth=8 threshold=1 top-density=0.01 density=8",
    "resolution=cube-root threshold=2",
    "resolution=heterogeneous density=4",
    "build=lazy",
    "build=lazy lazy-levels=2 max-depth=8 threshold=1",
];

fn same_as_oracle<S: Buildable>(prims: PrimsRef<S>, rays: &[Ray<S>]) {
    agreed("", prims, rays, 20, &SETTINGS.map(|settings| ("recursive-grid", settings)));
}

#[test]
fn same_answers_as_brute_force_in_mixed_scenes() {
    for seed in 0..3 {
        let set = mixed::<f64>(600, seed);
        same_as_oracle(PrimsRef::Mixed(&set), &rays(4000, seed + 100));
        let set = mixed::<f32>(600, seed);
        same_as_oracle(PrimsRef::Mixed(&set), &rays(4000, seed + 100));
    }
}

#[test]
fn same_answers_in_flat_scenes_and_on_ties() {
    // a chequered floor on a lattice: edges shared, every ray in the plane of many cells
    let mut triangles = Vec::new();
    for (x, z) in (0..24u8).flat_map(|x| (0..24u8).map(move |z| (x, z))) {
        let at = |dx: u8, dz: u8| [f32::from(x + dx) / 32.0, 0.0, f32::from(z + dz) / 32.0];
        triangles.push([at(0, 0), at(1, 0), at(0, 1)]);
        triangles.push([at(1, 1), at(0, 1), at(1, 0)]);
        // a copy: the lowest id must win
        triangles.push([at(0, 0), at(1, 0), at(0, 1)]);
    }
    let set = TriangleSet::<f32, Watertight>::new(triangles, |_| false).unwrap();
    let mut down = Vec::new();
    for (x, z) in (0..100u8).flat_map(|x| (0..50u8).map(move |z| (x, z))) {
        let origin = dvec3(f64::from(x) / 128.0, 1.0, f64::from(z) / 64.0);
        let direction = dvec3(0.0, -1.0, if x % 3 == 0 { 0.25 } else { -0.0 });
        down.push(Ray::new(origin.as_vec3(), direction.as_vec3()));
    }
    same_as_oracle(PrimsRef::Watertight(&set), &down);
    same_as_oracle(PrimsRef::Watertight(&set), &rays(2000, 7));
}

#[test]
fn far_from_the_origin_of_coordinates() {
    let mut random = Random::new(5);
    let shift = dvec3(1000.0, -2000.0, 500.0);
    let mut builder = MixedSetBuilder::<f32>::default();
    for _ in 0..500 {
        let at = shift + random.point();
        let mut near = || at + (random.point() - 0.5) * 0.1;
        builder.triangle([near(), near(), near()]).unwrap();
    }
    let set = builder.finish();
    let rays: Vec<_> = (0..3000)
        .map(|_| {
            let (from, to) = (random.point() * 3.0 - 1.0, random.point());
            Ray::new((from + shift).as_vec3(), (to - from).as_vec3())
        })
        .collect();
    same_as_oracle(PrimsRef::Mixed(&set), &rays);
}

#[test]
fn ten_thousand_copies_of_one_triangle() {
    let one = [[0.1f32, 0.2, 0.3], [1.0, 0.1, 0.2], [0.3, 0.9, 0.4]];
    let set = TriangleSet::<f32, Watertight>::new(vec![one; 10_000], |_| false).unwrap();
    let prims = PrimsRef::Watertight(&set);
    for settings in ["", "max-depth=8", "build=lazy", "build=lazy max-references=12000000"] {
        let grid = build(prims, "recursive-grid", settings).unwrap();
        assert!(grid.stats().bytes < 64 << 20, "{settings}: {:?}", grid.stats());
        let at = Vec3::<f32>::from_array([0.4, 0.4, 0.3]);
        for hit in
            hits(grid.as_ref(), &[Ray::new(at - Vec3::<f32>::splat(3.0), Vec3::<f32>::splat(1.0))])
        {
            assert_eq!(hit.id, 0, "{settings}");
        }
    }
    for settings in [
        "max-growth=1e9 max-depth=8 max-references=12000000",
        "max-references=9999",
        "max-cells=1 max-references=9999 build=lazy",
    ] {
        let refused = build(prims, "recursive-grid", settings).err();
        let is_limit =
            matches!(refused, Some(BuildError::TooLarge { needed, limit, .. }) if needed > limit);
        assert!(is_limit, "{settings}: {refused:?}");
    }
}

#[test]
fn a_lazy_grid_whose_limit_is_reached_stays_right() {
    let set = mixed::<f64>(2000, 11);
    let prims = PrimsRef::Mixed(&set);
    let rays = rays(3000, 12);
    let right = hits(build(prims, "uniform-grid", "").unwrap().as_ref(), &rays);
    let root = build(prims, "recursive-grid", "max-depth=1").unwrap().stats();
    let limits = format!(
        "build=lazy max-depth=8 threshold=1 max-cells={} max-references={}",
        root.cells + 300,
        root.references + 500,
    );
    let grid = build(prims, "recursive-grid", &limits).unwrap();
    assert_eq!(hits(grid.as_ref(), &rays), right);
    assert!(grid.stats().references <= root.references + 500, "{:?}", grid.stats());
    assert!(grid.stats().cells <= root.cells + 300);
}

/// Triangles in the unit cube, most of them crowded in a corner.
fn triangles(n: usize, seed: u64) -> TriangleSet<f32, Watertight> {
    let mut random = Random::new(seed);
    let triangle = |i: usize| {
        let scale = if i.is_multiple_of(8) { 1.0 } else { 0.05 };
        let at = random.point() * scale;
        let mut near = || (at + (random.point() - 0.5) * scale * 0.2).to_array().map(|x| x as f32);
        [near(), near(), near()]
    };
    TriangleSet::new((0..n).map(triangle).collect(), |_| false).unwrap()
}

#[test]
fn blocks_stand_for_the_lists_of_all_grids_made_with_the_structure() {
    let set = triangles(3000, 51);
    let prims = PrimsRef::Watertight(&set);
    let rays = rays(2000, 52);
    let right = hits(build(prims, "brute-force", "").unwrap().as_ref(), &rays);
    for settings in ["threshold=2", "build=lazy", "build=lazy lazy-levels=2 max-depth=6"] {
        let scalar = build(prims, "recursive-grid", settings).unwrap();
        let block = format!("{settings} kernel=block");
        let block = build(prims, "recursive-grid", &block).unwrap();
        let [a, b] = [&scalar, &block].map(|tracer| tracer.stats());
        let lists = a.cells - a.empty_cells - a.pending_cells.unwrap_or(0);
        assert!(b.bytes >= a.bytes + lists * 320, "{settings}: {a:?} {b:?}");
        assert_eq!((a.inner_cells, a.references), (b.inner_cells, b.references));
        assert_eq!(hits(block.as_ref(), &rays), right, "{settings}");
        assert_eq!(hits(scalar.as_ref(), &rays), right, "{settings}");
    }
}

#[test]
fn cells_and_references_share_the_memory() {
    let set = triangles(2000, 61);
    let prims = PrimsRef::Watertight(&set);
    let entry = find("recursive-grid").unwrap();
    let within = |settings: &[(&str, &str)], bytes: u64| {
        let params = entry.params(settings.iter().copied()).unwrap();
        entry.build(prims, &params.within(MemoryLimit::new(bytes)))
    };
    let stats = within(&[], u64::MAX).unwrap().stats();
    // without the entries that stand for grids; cells and references alone would fit
    let needed = 8 * stats.cells + 4 * stats.references;
    assert!(8 * stats.cells < needed - 4000 && 4 * stats.references < needed - 4000);
    let refused = within(&[], needed - 4000).err().expect("too little");
    assert!(matches!(refused, BuildError::OutOfMemory(_)), "{refused}");
    assert!(within(&[], 2 * needed).is_ok());
    // on demand: no more than there is room for, and right
    let lazy = within(&[("build", "lazy"), ("max-depth", "8")], needed / 2).unwrap();
    let rays = rays(2000, 62);
    let right = hits(build(prims, "brute-force", "").unwrap().as_ref(), &rays);
    assert_eq!(hits(lazy.as_ref(), &rays), right);
    let stats = lazy.stats();
    assert!(8 * stats.cells + 4 * stats.references <= needed / 2, "{stats:?}");
}

#[test]
fn lazy_builds_what_rays_ask_for_and_counts_the_same() {
    let set = mixed::<f64>(3000, 21);
    let prims = PrimsRef::Mixed(&set);
    let eager = build(prims, "recursive-grid", "max-depth=4").unwrap();
    let lazy = build(prims, "recursive-grid", "max-depth=4 build=lazy").unwrap();
    let before = lazy.stats();
    assert_eq!(eager.stats().pending_cells, None);
    assert!(before.pending_cells > Some(0) && before.inner_cells == 1);
    assert!(before.cells < eager.stats().cells);
    let few = rays(20, 22);
    let mut answers = (vec![Hit::NONE; few.len()], vec![Hit::NONE; few.len()]);
    let counters = lazy.count_closest_hits(&few, &mut answers.0);
    assert_eq!(counters, eager.count_closest_hits(&few, &mut answers.1));
    assert_eq!(answers.0, answers.1);
    let after = lazy.stats();
    assert!(after.inner_cells > 1 && after.inner_cells < eager.stats().inner_cells);
    // rays along all axes through every corner of the crowd build nearly all of it
    let mut random = Random::new(23);
    for _ in 0..40 {
        let rays: Vec<_> = (0..100)
            .map(|i| {
                let mut origin = random.point() * if i % 2 == 0 { 1.2 } else { 0.1 } - 0.05;
                origin[i % 3] = -1.0;
                Ray::new(origin, DVec3::AXES[i % 3])
            })
            .collect();
        lazy.count_closest_hits(&rays, &mut vec![Hit::NONE; rays.len()]);
    }
    assert!(lazy.stats().cells <= eager.stats().cells);
    assert!(lazy.stats().inner_cells > after.inner_cells);
    assert!(lazy.stats().inner_cells <= eager.stats().inner_cells);
}

#[test]
fn lazy_gives_the_same_hits_a_hundred_times_with_two_threads() {
    let set = mixed::<f32>(1500, 31);
    let prims = PrimsRef::Mixed(&set);
    let rays = rays(1000, 32);
    let right = hits(build(prims, "recursive-grid", "").unwrap().as_ref(), &rays);
    for round in 0..100 {
        let grid = build(prims, "recursive-grid", "build=lazy").unwrap();
        let start = std::sync::Barrier::new(2);
        let (a, b) = std::thread::scope(|scope| {
            let run = || {
                start.wait();
                hits(grid.as_ref(), &rays)
            };
            let other = scope.spawn(run);
            (run(), other.join().unwrap())
        });
        assert_eq!(a, right, "round {round}");
        assert_eq!(b, right, "round {round}");
    }
}

#[test]
fn the_oracle_catches_a_grid_that_loses_primitives() {
    // planted fault: a grid built over fewer primitives than the set has
    let set = mixed::<f64>(600, 41);
    let rays = rays(4000, 42);
    let oracle = hits(build(PrimsRef::Mixed(&set), "brute-force", "").unwrap().as_ref(), &rays);
    let fewer = mixed::<f64>(590, 41);
    assert!(fewer.bounds(0) == set.bounds(0) && Aabb::is_finite(&fewer.bounds(589)));
    let ours = hits(build(PrimsRef::Mixed(&fewer), "recursive-grid", "").unwrap().as_ref(), &rays);
    assert_ne!(ours, oracle);
}
