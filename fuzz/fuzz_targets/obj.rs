//! OBJ text, and what is done with every scene that loads.
#![no_main]

use std::path::Path;

use scene_loading::info::{SceneInfo, validate};
use scene_loading::obj::{ObjOptions, parse_obj};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let triangulate = bytes.first().is_some_and(|b| b % 2 == 0);
    // No folder of that name: material files are missing.
    let path = Path::new("no-such-folder/a.obj");
    if let Ok(scene) = parse_obj(path, bytes.to_vec(), ObjOptions { triangulate }) {
        assert!(!scene.primitives.is_empty());
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
