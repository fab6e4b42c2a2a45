//! Files packed by gzip or zstd: what unpacks is read as OBJ text.
#![no_main]

use std::path::Path;

use scene_loading::source::formats::{ReadOptions, parse_scene};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let ending = if bytes.starts_with(&[0x1f]) { "gz" } else { "zst" };
    let path = Path::new("no-such-folder/a.obj").with_extension(format!("obj.{ending}"));
    if let Ok(scene) = parse_scene(&path, bytes.to_vec(), ReadOptions::default()) {
        assert!(!scene.primitives.is_empty());
    }
});
