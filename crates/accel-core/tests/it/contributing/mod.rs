//! The worked example of CONTRIBUTING.md: it compiles, it gives the right answers, and the text
//! shows this very file.

mod two_boxes;

use crate::agreement::mismatches;
use crate::common::{Random, all_scenes, rays_for};
use accel_core::entry;
use accel_core::registry::Buildable;
use accel_core::structures::Entry;

static REGISTRY: &[Entry] = &[entry!(two_boxes::TwoBoxes, two_boxes::INFO)];

fn check<S: Buildable>() {
    for (name, set, bounds) in all_scenes::<S>() {
        let rays = rays_for::<S>(bounds, &mut Random::new(7));
        let wrong = mismatches(REGISTRY, name, set.prims(), &rays);
        assert!(wrong.is_empty(), "{} mismatches, the first: {}", wrong.len(), wrong[0]);
    }
}

#[test]
fn the_example_agrees_with_brute_force() {
    check::<f32>();
    check::<f64>();
}

#[test]
fn the_text_shows_the_example_as_it_is() {
    let text = include_str!("../../../../../CONTRIBUTING.md");
    let code = include_str!("two_boxes.rs");
    assert!(text.contains(&format!("```rust\n{code}```")), "CONTRIBUTING.md shows older code");
}
