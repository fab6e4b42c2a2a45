//! MTL text.
#![no_main]

use std::path::Path;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(materials) = scene_loading::obj::parse_materials(Path::new("a.mtl"), bytes.to_vec()) {
        for m in materials {
            assert!((0.0..=1.0).contains(&m.transmittance) && (0.0..=1.0).contains(&m.specular));
        }
    }
});
