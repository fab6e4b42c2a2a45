//! tray_racing's scene files, with an empty model.
#![no_main]

use std::path::Path;

use scene_loading::Scene;
use scene_loading::info::{SceneInfo, validate};
use scene_loading::tray_racing::parse_tray_racing;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("no-such-folder/a.ron");
    if let Ok(scene) = parse_tray_racing(path, bytes.to_vec(), true, |_| Ok(Scene::default())) {
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
