//! tray_racing's scene files, whose model is missing, and what is done with every scene that loads.
#![no_main]

use std::path::Path;

use scene_loading::info::{SceneInfo, validate};
use scene_loading::source::formats::ReadOptions;
use scene_loading::tray_racing::parse_tray_racing;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("no-such-folder/a.ron");
    if let Ok(scene) = parse_tray_racing(path, bytes.to_vec(), ReadOptions::default()) {
        assert!(!scene.primitives.is_empty());
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
