//! PLY, text or binary, and what is done with every scene that loads.
#![no_main]

use std::path::Path;

use scene_loading::info::{SceneInfo, validate};
use scene_loading::ply::parse_ply;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("no-such-folder/a.ply");
    if let Ok(scene) = parse_ply(path, bytes, bytes.len() % 2 == 0) {
        assert!(!scene.primitives.is_empty());
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
