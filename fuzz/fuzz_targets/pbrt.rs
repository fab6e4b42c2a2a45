//! PBRT text, and what is done with every scene that loads.
#![no_main]

use std::path::Path;

use scene_loading::info::{SceneInfo, validate};
use scene_loading::pbrt::parse_pbrt;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("no-such-folder/a.pbrt");
    if let Ok(scene) = parse_pbrt(path, bytes.to_vec(), bytes.len() % 2 == 0) {
        assert!(!scene.primitives.is_empty());
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
