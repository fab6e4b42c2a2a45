//! The reader of a run's journal: the bytes as they are, and with the checksums that they should have.
#![no_main]

use measurement::journal::lines;
use measurement::journal::seal::Seal;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    check(bytes);
    check(&resealed(bytes));
});

fn check(bytes: &[u8]) {
    if let Ok(found) = lines::read(bytes) {
        assert!(found.whole <= bytes.len());
        assert!(found.finished.keys().all(|&i| i < found.manifest.scenes.len()));
        // What was read is read again from what it is written as.
        let differences = found.manifest.differences(&found.manifest);
        assert!(differences.is_empty(), "{differences:?}");
    }
}

/// The same lines, their checksums mended: else none that was changed would be read.
fn resealed(bytes: &[u8]) -> Vec<u8> {
    let text = String::from_utf8_lossy(bytes);
    let (mut seal, mut out) = (Seal::default(), String::new());
    for (i, line) in text.split_inclusive('\n').enumerate() {
        // as text of a sealed line begins and ends
        let inner =
            line.trim_end().split_once("\",\"line\":").and_then(|(_, l)| l.strip_suffix('}'));
        let inner = inner.unwrap_or(line.trim_end());
        out.push_str(&seal.sealed(inner));
        if line.ends_with('\n') {
            out.push('\n');
        }
        if i == 0 {
            seal = Seal::behind(inner);
        }
    }
    out.into_bytes()
}
