//! Grids of one level against brute force and one another.

use accel_core::primitives::{MixedSetBuilder, PrimsRef};
use accel_core::registry::Buildable;

use crate::agreement::{agreed, work};
use crate::common::build;
use crate::test_scenes::{Random, hard_scenes, mixed_scene, rays};

/// Every setting must give brute force's hits, bit for bit.
fn agree_with_brute_force<S: Buildable>(tested: &[(&str, impl AsRef<str>)]) {
    for (scene, set) in hard_scenes::<S>() {
        let rays = rays(&set, if scene == "duplicates" { 60 } else { 1500 }, 99);
        agreed(scene, PrimsRef::Mixed(&set), &rays, 20, tested);
    }
}

#[test]
fn grids_agree_with_brute_force() {
    for name in ["uniform-grid", "hashed-grid", "bricked-grid"] {
        let settings = [
            "",
            "traversal=driving-axis",
            "density=20 traversal=driving-axis order=reverse",
            "resolution=16x8x8",
            "resolution=cubic",
            "resolution=auto",
        ];
        let tested = settings.map(|settings| (name, settings));
        agree_with_brute_force::<f32>(&tested);
        agree_with_brute_force::<f64>(&tested);
    }
}

#[test]
fn storages_have_the_same_cells_and_do_the_same_work() {
    for (scene, set) in hard_scenes::<f64>() {
        let rays = rays(&set, if scene == "duplicates" { 60 } else { 1500 }, 5);
        for settings in ["", "density=9 order=reverse", "boxes=historical traversal=driving-axis"] {
            let dense = build(PrimsRef::Mixed(&set), "uniform-grid", settings).unwrap();
            let expected = work(dense.as_ref(), &rays);
            for name in ["hashed-grid", "bricked-grid"] {
                let other = build(PrimsRef::Mixed(&set), name, settings).unwrap();
                assert!(work(other.as_ref(), &rays) == expected, "{name} {settings} {scene}");
                let (mut a, mut b) = (dense.stats(), other.stats());
                (a.bytes, b.bytes) = (0, 0);
                assert_eq!(a, b, "{name} {settings} {scene}");
            }
        }
    }
}

#[test]
fn a_virtual_grid_of_2048_cubed_works() {
    // HARD_CASES Gr3: 2^33 cells
    let mut set = MixedSetBuilder::<f32>::default();
    let mut random = Random(11);
    for _ in 0..400 {
        let at = random.point([1.0; 3]);
        set.triangle([at, at + random.point([0.01; 3]), at + random.point([0.01; 3])]).unwrap();
    }
    let set = set.finish();
    let rays = rays(&set, 600, 12);
    let right = work(build(PrimsRef::Mixed(&set), "brute-force", "").unwrap().as_ref(), &rays);
    for traversal in ["t-next", "driving-axis"] {
        let settings = format!("resolution=2048x2048x2048 traversal={traversal}");
        let grid = build(PrimsRef::Mixed(&set), "hashed-grid", &settings).unwrap();
        let got = work(grid.as_ref(), &rays);
        assert!(got.0 == right.0);
        let stats = grid.stats();
        assert_eq!(stats.cells, 1 << 33);
        assert!(stats.bytes < 1 << 27, "{stats:?}");
    }
}

const METRICS: [&str; 3] = ["city-block", "chessboard", "euclidean"];

#[test]
fn proximity_clouds_agree_with_brute_force() {
    let settings = |metric: &&str| {
        ["all", "octants"].map(|directions| {
            let settings = format!("metric={metric} directions={directions} density=15");
            ("proximity-clouds", settings)
        })
    };
    let tested: Vec<_> = METRICS.iter().flat_map(settings).collect();
    agree_with_brute_force::<f32>(&tested);
    agree_with_brute_force::<f64>(&tested);
}

#[test]
fn jumps_save_steps() {
    let set = mixed_scene::<f32>(100, 31, [1.0; 3]);
    let rays = rays(&set, 1000, 32);
    let grid = build(PrimsRef::Mixed(&set), "uniform-grid", "density=100").unwrap();
    let plain = work(grid.as_ref(), &rays).1[0];
    for metric in METRICS {
        let mut steps = plain.traversal_steps;
        for directions in ["all", "octants"] {
            let settings = format!("density=100 metric={metric} directions={directions}");
            let clouds = build(PrimsRef::Mixed(&set), "proximity-clouds", &settings).unwrap();
            let counters = work(clouds.as_ref(), &rays).1[0];
            assert!(counters.traversal_steps < steps, "{settings}");
            steps = counters.traversal_steps;
        }
    }
}
