//! Records with planted differences.

use std::sync::OnceLock;

use measurement::record::{RowRecord, RunRecord, Sample};
use statistics::random::Random;

use super::{in_folder, run_in};
use crate::common::{Folder, PLANTED};

/// The row that faults are planted in.
pub const ROW: &str = "uniform-grid";
/// The reference row of ratios.
pub const REFERENCE: &str = "obvhs-cwbvh";

/// A record of both rows on a small scene, without samples.
pub fn record() -> RunRecord {
    static RECORD: OnceLock<RunRecord> = OnceLock::new();
    let made = RECORD.get_or_init(|| {
        let folder = Folder::new();
        let arguments = format!(
            "run tetra:2 --quick --size 16 --rounds 1 -s {ROW},{REFERENCE} -o {}",
            folder.path()
        );
        let ended = run_in(&PLANTED, in_folder(&folder.path()), &arguments);
        assert_eq!(ended.code, 0, "{}", ended.err);
        folder.record()
    });
    let mut record = made.clone();
    record.scenes[0].rows.iter_mut().for_each(|row| row.samples.clear());
    record
}

/// The row in the record's only scene.
pub fn row<'a>(record: &'a mut RunRecord, label: &str) -> &'a mut RowRecord {
    record.scenes[0].rows.iter_mut().find(|r| r.label() == label).unwrap()
}

/// The record with so many rounds: the reference takes 10 ms, [`ROW`] `times` of that, builds
/// likewise, each moved by chance by as much as `noise`.
pub fn timed(rounds: u32, times: f64, noise: f64, seed: u64) -> RunRecord {
    let mut record = record();
    let mut random = Random::new(seed, "noise");
    let mut around = |seconds: f64| {
        let unit = random.next_u64() as f64 / u64::MAX as f64;
        seconds * (1.0 + noise * (2.0 * unit - 1.0))
    };
    for round in 0..rounds {
        let reference = around(0.01);
        for (label, seconds) in [(REFERENCE, reference), (ROW, around(0.01 * times))] {
            let sample = Sample {
                round,
                position: 0,
                build_s: seconds,
                trace_s: [("primary".to_owned(), seconds)].into(),
                reference_trace_s: Some(reference),
                reference_build_s: None,
                reference_by_kind: Default::default(),
                process: 0,
            };
            row(&mut record, label).samples.push(sample);
        }
    }
    record
}
