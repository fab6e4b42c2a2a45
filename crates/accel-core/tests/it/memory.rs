//! A structure that may take little memory says so, and is never another one for it.

use accel_core::memory::{MemoryLimit, OutOfMemory};
use accel_core::primitives::PrimsRef;
use accel_core::primitives::{TriangleSet, Watertight};
use accel_core::structure::{BuildError, StructureStats};
use accel_core::structures::{Entry, REGISTRY, find};

use crate::common;

type Set = TriangleSet<f32, Watertight>;

fn relief(side: usize) -> Set {
    Set::new(common::relief(side, 0.1, [0.0; 3], 1.0), |_| false).unwrap()
}

fn built(
    entry: &Entry,
    set: &Set,
    settings: &[(&str, &str)],
    limit: MemoryLimit,
) -> Result<StructureStats, BuildError> {
    let params = entry.params(settings.iter().copied()).unwrap().within(limit);
    Ok(entry.build(PrimsRef::Watertight(set), &params)?.stats())
}

/// The variants of a structure, as settings.
fn variants(entry: &'static Entry) -> impl Iterator<Item = Vec<(&'static str, &'static str)>> {
    let settings = entry.info.variants.iter().chain(entry.info.also_tested);
    settings.map(|variant| common::settings(variant).collect())
}

/// Faults of a structure with little memory.
fn complaint(
    of: impl Fn(MemoryLimit) -> Result<StructureStats, BuildError>,
    smallest: u64,
) -> Option<String> {
    let whole = of(MemoryLimit::NONE).unwrap();
    // more than it takes in the end: no builder needs eight times that
    if let Err(error) = of(MemoryLimit::new(8 * whole.bytes + (1 << 16))) {
        return Some(format!("takes {} bytes, and {error}", whole.bytes));
    }
    for part in [2, 4, 8, smallest] {
        match of(MemoryLimit::new(whole.bytes / part)) {
            Err(BuildError::OutOfMemory(OutOfMemory { needed, limit, .. })) => {
                if limit.is_none_or(|limit| needed <= u128::from(limit)) {
                    return Some(format!("needs {needed}, of {limit:?}"));
                }
            }
            Err(error) => return Some(format!("a 1/{part}: {error}")),
            Ok(stats) if stats != whole => return Some(format!("a 1/{part}: {stats:?}")),
            Ok(_) if part == smallest => return Some(format!("built in a 1/{part}")),
            Ok(_) => {}
        }
    }
    None
}

#[test]
fn too_little_memory_is_an_error_and_changes_no_structure() {
    let set = relief(64);
    for entry in REGISTRY {
        for settings in variants(entry) {
            let wrong = complaint(|limit| built(entry, &set, &settings, limit), 64);
            assert_eq!(wrong, None, "{} {settings:?}", entry.info.name);
        }
    }
}

/// Each part within the limit, all of them not.
#[test]
fn memory_limits_hold_for_all_parts_together() {
    let set = relief(64);
    let names = ["kd-tree", "octree", "hug", "adaptive-grid", "two-level-grid", "wide-bvh"];
    for entry in REGISTRY.iter().filter(|entry| names.contains(&entry.info.name)) {
        let has_kernel = entry.info.params.iter().any(|spec| spec.name == "kernel");
        let settings = [("kernel", "scalar")];
        let of = |limit| built(entry, &set, &settings[..usize::from(has_kernel)], limit);
        let bytes = of(MemoryLimit::NONE).unwrap().bytes;
        let refused = of(MemoryLimit::new(bytes / 3 * 2));
        let is_refused = matches!(refused, Err(BuildError::OutOfMemory(_)));
        assert!(is_refused, "{}: {bytes} bytes, {refused:?}", entry.info.name);
    }
}

/// Planted: a structure that does not ask, and one that makes itself smaller.
#[test]
fn structures_that_skip_the_filter_are_caught() {
    let whole = StructureStats { bytes: 1 << 20, ..StructureStats::default() };
    assert_eq!(complaint(|_| Ok(whole), 64).as_deref(), Some("built in a 1/64"));
    let smaller =
        |limit: MemoryLimit| Ok(StructureStats { cells: limit.count(1 << 20).min(1), ..whole });
    assert!(complaint(smaller, 64).unwrap().starts_with("a 1/2: StructureStats"));
}

/// Grids of any number of voxels are refused before a byte of them is taken.
#[test]
fn huge_grids_are_refused_at_once() {
    let set = relief(4);
    let limit = MemoryLimit::new(64 << 20);
    for name in ["uniform-grid", "bricked-grid", "proximity-clouds", "two-level-grid"] {
        let settings = [("resolution", "1024x1024x1024"), ("max-cells", "2147483648")];
        let error = built(find(name).unwrap(), &set, &settings, limit).unwrap_err();
        assert!(matches!(error, BuildError::OutOfMemory(_)), "{name}: {error}");
    }
    let settings = [("resolution", "2048x1024x512"), ("max-cells", "1073741824")];
    let error = built(find("compact-grid").unwrap(), &set, &settings, limit).unwrap_err();
    assert!(matches!(error, BuildError::OutOfMemory(_)), "{error}");
}
