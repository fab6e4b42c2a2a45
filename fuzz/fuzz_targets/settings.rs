//! Settings of structures and occluders as typed behind `-s` and `--set`, and a tiny scene built with them in
//! little memory: whatever is built answers a ray.
#![no_main]

use std::sync::OnceLock;

use accel_core::Ray;
use accel_core::memory::MemoryLimit;
use accel_core::occluders;
use accel_core::structures::REGISTRY;
use glam::DVec3;
use measurement::plan::measured_row::{BuiltRow, MeasuredRow, select};
use renderer::Geometry;
use scene_loading::nff::parse_nff;

/// What a structure may take: enough for a hundred thousand cells, and for many builds a second.
const MEMORY: u64 = 1 << 20;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let text = String::from_utf8_lossy(bytes);
    let (rows, overrides) = text.split_once('\n').unwrap_or((&text, ""));
    let overrides: Vec<String> = overrides.lines().map(str::to_owned).collect();
    if rows.split([':', ' ']).next() == Some("all") {
        return;
    }
    let Ok((structures, occluding)) =
        select(REGISTRY, occluders::REGISTRY, &[rows.to_owned()], &overrides)
    else {
        return;
    };
    let memory = MemoryLimit::new(MEMORY);
    let limited = structures.into_iter().map(|mut row| {
        row.params = row.params.within(memory);
        MeasuredRow::Structure(row)
    });
    let limited = limited.chain(occluding.into_iter().map(|mut row| {
        row.params = row.params.within(memory);
        MeasuredRow::Occluder(row)
    }));
    for row in limited {
        asked(&row);
    }
});

/// Builds a row and asks it.
fn asked(row: &MeasuredRow<'_>) {
    let geometry = geometry();
    let Ok(built) = row.prepare()(geometry.prims(), &[DVec3::new(0.0, 3.0, 5.0)]) else { return };
    if let BuiltRow::Structure(tracer) = &built {
        let rays = [Ray::new([0.3, 0.2, 9.0].into(), [0.0, 0.0, -1.0].into())];
        let mut hits = [accel_core::Hit::NONE];
        tracer.closest_hits(&rays, &mut hits);
        assert!(hits[0].is_hit() || row.known_defect().is_some(), "{}", row.label());
    }
    let _ = built.stats();
}

/// Triangles that cover the ray's way, a sphere, a cone.
fn geometry() -> &'static Geometry<f32> {
    static GEOMETRY: OnceLock<Geometry<f32>> = OnceLock::new();
    GEOMETRY.get_or_init(|| {
        let text = "p 3\n-2 -2 0\n2 -2 0\n0 3 0\np 3\n-2 -2 -1\n2 -2 -1.5\n0 3 -1\n\
                    s 0.3 0.2 2 0.5\nc\n1 0 -3 0.5\n1 2 -3 0.2\n";
        let scene = parse_nff("a.nff".as_ref(), text).expect("it is valid");
        Geometry::of(&scene).expect("it is valid")
    })
}
