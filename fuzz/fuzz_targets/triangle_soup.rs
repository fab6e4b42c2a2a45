//! tinybvh's triangles. The number of them is set right, or hardly any input would come past it, and what is done with every scene that loads.
#![no_main]

use std::path::Path;

use scene_loading::info::{SceneInfo, validate};
use scene_loading::triangle_soup::parse_triangle_soup;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let path = Path::new("no-such-folder/a.bin");
    let mut bytes = bytes.to_vec();
    if bytes.len() >= 4 {
        bytes.truncate(bytes.len() - (bytes.len() - 4) % 48);
        let count = ((bytes.len() - 4) / 48) as u32;
        bytes[..4].copy_from_slice(&count.to_le_bytes());
    }
    if let Ok(scene) = parse_triangle_soup(path, &bytes) {
        assert!(!scene.primitives.is_empty());
        let _ = validate(&scene);
        let _ = SceneInfo::of(&scene).to_string();
    }
});
