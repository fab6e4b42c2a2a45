//! JSON scene files, with their inline shapes, and scene sets.
#![no_main]

use std::path::Path;

use scene_loading::info::{SceneInfo, validate};
use scene_loading::scene_file::{SceneFile, Source};
use scene_loading::scene_set::SceneSet;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("a.json");
    let text = String::from_utf8_lossy(bytes);
    let _ = SceneSet::parse(path, &text);
    let Ok(file) = SceneFile::parse(path, &text) else { return };
    let Source::Shapes(shapes) = &file.source else { return };
    let Ok(mut scene) = file.inline(path, shapes) else { return };
    if file.apply(path, &mut scene).is_ok() {
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
