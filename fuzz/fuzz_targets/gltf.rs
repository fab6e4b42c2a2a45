//! glTF, binary or JSON. A panic of the crate `gltf` is a finding although the loader would catch it.
#![no_main]

use std::path::Path;

use scene_loading::gltf::parse_gltf;
use scene_loading::info::{SceneInfo, validate};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("no-such-folder/a.gltf");
    // The length in a GLB header is set right, or hardly any input would come past it.
    let mut bytes = bytes.to_vec();
    if bytes.starts_with(b"glTF") && bytes.len() >= 12 {
        let length = (bytes.len() as u32).to_le_bytes();
        bytes[8..12].copy_from_slice(&length);
    }
    if let Ok(scene) = parse_gltf(path, &bytes) {
        assert!(!scene.primitives.is_empty());
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
