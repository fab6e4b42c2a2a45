//! NFF text, and what is done with every scene that loads.
#![no_main]

use std::path::Path;

use scene_loading::info::{SceneInfo, validate};
use scene_loading::nff::parse_nff;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(scene) = parse_nff(Path::new("a.nff"), &String::from_utf8_lossy(bytes)) {
        assert!(!scene.primitives.is_empty());
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
