//! Over whatever adapter there is, one in software, too (`mesa-vulkan-drivers`). Without one, tests
//! but that of the refusal say so and pass.

use std::process::Command;

use peer::trial::{Trial, closed_surface, glass, rays, triangles};
use peer::{Ray, Triangle};

const LAYOUTS: [&str; 2] = ["layout=cwbvh", "layout=bvh2"];

fn trial<'a>(triangles: &'a [Triangle], glass: &'a [u8], settings: &str) -> Trial<'a> {
    Trial::build(super::rtbench_plugin_describe, triangles, glass, settings, 2).unwrap()
}

fn has_gpu() -> bool {
    super::Gpu::get().inspect_err(|why| println!("not tested: {why}")).is_ok()
}

#[test]
fn answers_are_right() {
    let (triangles, glass, rays) = (triangles(3000), glass(3000), rays(1000));
    for layout in LAYOUTS.into_iter().filter(|_| has_gpu()) {
        for more in ["", "test=moeller-trumbore", "boxes=plain"] {
            let trial = trial(&triangles, &glass, &format!("{layout} {more}"));
            let faults = trial.faults(&rays);
            assert!(faults.sum() == 0 && faults.certain > 500, "{layout} {more} {faults:?}");
            let stats = trial.stats();
            assert!(stats.references == 3000 && stats.inner_nodes > 100 && stats.leaves > 500);
            let note = String::from_utf8_lossy(&stats.note);
            assert!(note.contains(" ns a ray with the way there and back"), "{note}");
        }
        for count in 1..6 {
            // a point, and the first triangle again: the lower id counts
            let few = [&triangles[..count], &[[[0.5; 3]; 3], triangles[0]]].concat();
            let faults = trial(&few, &[], layout).faults(&rays);
            assert_eq!(faults.sum(), 0, "{layout} {count} {faults:?}");
        }
    }
}

#[test]
fn no_ray_passes_between_two_triangles() {
    for layout in LAYOUTS.into_iter().filter(|_| has_gpu()) {
        for (center, radius) in [([0.0; 3], 8.0), ([1e3, -700.0, 3.0], 0.37), ([1e-3; 3], 1e-4)] {
            let (surface, rays) = closed_surface(center, radius);
            let missed = |test: &str| missed(&surface, &rays, &format!("{layout} test={test}"));
            assert_eq!(missed("watertight"), [0, 0], "{layout} {center:?}");
            // the rays are hard: another test loses some
            assert!(missed("moeller-trumbore")[0] > 0, "{layout} {center:?}");
        }
    }
}

/// Rays without a closest hit, and rays that nothing blocks.
fn missed(surface: &[Triangle], rays: &[Ray], settings: &str) -> [usize; 2] {
    let trial = trial(surface, &[], settings);
    let misses = trial.closest(rays).iter().filter(|hit| hit.id == u32::MAX).count();
    let free = trial.occluded(rays).unwrap().iter().filter(|blocked| **blocked == 0).count();
    [misses, free]
}

/// What a process says that has another environment.
fn says(variable: &str, value: &str) -> String {
    let mut child = Command::new(std::env::current_exe().unwrap());
    child.args(["--exact", "tests::child", "--ignored", "--nocapture"]);
    let said = child.env(variable, value).output().unwrap().stdout;
    String::from_utf8_lossy(&said).into_owned()
}

#[test]
#[ignore = "the process of `says`"]
fn child() {
    let (some, (surface, rays_at_edges)) = (triangles(300), closed_surface([0.0; 3], 8.0));
    match Trial::build(super::rtbench_plugin_describe, &some, &[], "", 1) {
        Err(why) => println!("refused: {why}"),
        Ok(trial) => {
            let (lost, at_edges) =
                (trial.faults(&rays(300)).lost, missed(&surface, &rays_at_edges, ""));
            println!("lost {lost}, at edges {at_edges:?}");
        }
    }
}

#[test]
fn planted_mistakes_are_seen() {
    if has_gpu() {
        assert!(says(super::FAULT, "0").contains("lost 0, at edges [0, 0]"));
        let at_edges = says(super::FAULT, "1");
        assert!(at_edges.contains("lost 0, at edges [") && !at_edges.contains("[0, 0]"));
        let everywhere = says(super::FAULT, "2");
        assert!(everywhere.contains("lost ") && !everywhere.contains("lost 0"), "{everywhere}");
    }
}

#[test]
#[cfg(target_os = "linux")]
fn without_an_adapter_the_row_is_refused() {
    // the loader of Vulkan finds no driver there
    let said = says("VK_ICD_FILENAMES", "/nonexistent");
    assert!(said.contains("refused: there is no GPU that wgpu can use"), "{said}");
}
