//! STL, text or binary, and what is done with every scene that loads.
#![no_main]

use std::path::Path;

use scene_loading::info::{SceneInfo, validate};
use scene_loading::stl::parse_stl;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("no-such-folder/a.stl");
    if let Ok(scene) = parse_stl(path, bytes.to_vec()) {
        assert!(!scene.primitives.is_empty());
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
