//! The reader of a run's journal. Its modules are taken by their paths: the whole program, with all
//! structures for all kinds of primitives, would take ten minutes to compile for the fuzzer.
#![no_main]
#![allow(dead_code)]

#[path = "../../crates/rtbench/src/journal/lines.rs"]
mod lines;
#[path = "../../crates/rtbench/src/random.rs"]
mod random;
#[path = "../../crates/rtbench/src/record.rs"]
mod record;
#[path = "../../crates/rtbench/src/statistics.rs"]
mod statistics;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(found) = lines::read(bytes) {
        assert!(found.whole <= bytes.len());
        assert!(found.finished.keys().all(|&i| i < found.manifest.scenes.len()));
        // What was read is read again from what it is written as.
        let differences = found.manifest.differences(&found.manifest);
        assert!(differences.is_empty(), "{differences:?}");
    }
});
