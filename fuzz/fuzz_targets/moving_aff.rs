//! AFF text, and some frames of every animation that loads.
#![no_main]

use std::path::Path;

use scene_loading::animation::parse;
use scene_loading::info::{SceneInfo, validate};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("no-such-folder/a.aff");
    let Ok(mut animation) = parse(path, bytes.to_vec()) else { return };
    let last = animation.frames() - 1;
    for index in [0, last / 2, last] {
        if let Ok(scene) = animation.frame(index) {
            assert!(!scene.primitives.is_empty() && !scene.lights.is_empty());
            let _ = validate(&scene);
            let _ = SceneInfo::of(&scene).to_string();
        }
    }
});
