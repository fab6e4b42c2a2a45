//! Outlines of any kind, cut up: corners on a grid of 256 by 256, so that many repeat, cross or lie in
//! line. Mostly of 64 at most, sometimes of 512: long ones take most of the time and find few other paths.
#![no_main]

use glam::DVec3;
use scene_loading::tessellate::triangulate;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let most = if bytes.len() % 64 < 2 { 512 } else { 64 };
    let corners = bytes.as_chunks().0.iter().take(most).map(|&[x, y]| [f64::from(x), f64::from(y)]);
    let outline: Vec<DVec3> = corners.map(|[x, y]| DVec3::new(x, y, 0.1 * x)).collect();
    let triangles = triangulate(&outline).expect("the budget suffices");
    assert!(triangles.len() <= outline.len().saturating_sub(2));
    for [a, b, c] in triangles {
        assert!([a, b, c].iter().all(|&i| (i as usize) < outline.len()));
        assert!(a != b && b != c && c != a);
    }
});
