//! The record of a run, `results.json`, and everything that reads one: `compare`, `report`, `merge`, `check`,
//! the exports. The length of a record that is read says which: the report's intervals take a hundred times as
//! long as reading.
#![no_main]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use measurement::record::merge::{PartialRun, merge};
use measurement::record::metrics::METRICS;
use measurement::record::{RunRecord, file};
use measurement::settings::shard::ShardRecord;
use measurement::system::progress::Progress;
use rtbench::commands::run_outputs;
use rtbench::comparison::{ComparisonSettings, NamedRun, compare, tables};
use rtbench::gate::thresholds::Thresholds;
use rtbench::gate::{Evidence, Instructions, Times, judge};
use rtbench::replan::restrict;
use rtbench::report::material::{DataFile, Material};
use rtbench::report::page;
use studies::run::costs::profiles;
use studies::run::view::View;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let Ok(record) = file::record(Path::new("results.json"), bytes) else { return };
    match bytes.len() % 32 {
        0 => reported(record),
        1..8 => compared(&record),
        8..16 => exported(&record),
        16..24 => checked(&record),
        _ => merged(&record),
    }
});

/// With itself, whatever it takes.
fn compared(record: &RunRecord) {
    let choice = ComparisonSettings {
        metrics: METRICS.iter().collect(),
        shows_equal: true,
        filter: None,
        margin: 0.05,
        threshold: None,
        is_forced: true,
    };
    let named = |letter| NamedRun { letter, path: "results.json", run: record };
    if let Ok(comparison) = compare(named("A"), named("B"), &choice) {
        let all = [comparison];
        let _ = tables::to_csv(&all);
        let _ = tables::to_markdown(&all);
    }
}

fn exported(record: &RunRecord) {
    let _ = studies::run::output::to_csv(record);
    let _ = studies::run::output::to_markdown(record);
    let _ = run_outputs::github(run_outputs::measures(record));
    let _ = run_outputs::bencher(run_outputs::measures(record));
    let view = View::fastest_first();
    for scene in &record.scenes {
        let _ = studies::run::output::write_scene(&mut std::io::sink(), record, scene, &view);
    }
    let _ = studies::run::output::write_end(&mut std::io::sink(), record, &view);
}

fn checked(record: &RunRecord) {
    let Ok(base) = restrict(record, &[], &[]) else { return };
    let _ = judge(&Evidence {
        thresholds: &Thresholds::default(),
        base: &base,
        now: record,
        instructions: Instructions::Missing("fuzzed"),
        times: Times::InRun { cpu_pressure: None, across_processors: false },
    });
}

/// As both parts of two, of which one at least is not what it says.
fn merged(record: &RunRecord) {
    let part = |index: u32| {
        let mut record = record.clone();
        if let Some(ShardRecord { index: own, .. }) = &mut record.shard {
            *own = own.wrapping_add(index);
        }
        PartialRun { record, path: PathBuf::from(format!("{index}.json")) }
    };
    let _ = merge(vec![Ok(part(0))], true);
    let _ = merge(vec![Ok(part(0)), Ok(part(1))], false);
}

fn reported(run: RunRecord) {
    let material = Material {
        folder: PathBuf::from("no-such-folder"),
        data: DataFile { name: file::NAME.into(), bytes: 0, sha256: String::new() },
        profiles: run.scenes.iter().map(profiles).collect(),
        pictures: BTreeMap::new(),
        accuracy: None,
        tracers: Vec::new(),
        heat_maps: Vec::new(),
        sweeps: Vec::new(),
        counters: None,
        lecture: None,
        run,
    };
    let _ = page(&[material], true, Progress::new(false, 1, None));
}
