//! Made-up records for tests.

use crate::accuracy::record::{
    AccuracyRecord, AxisRecord, ErrorOf, SceneOutcome, VariantRecord, VariantStanding,
};
use statistics::estimate::Estimate;

/// A variant that takes so many seconds and is wrong so often in a million.
pub fn row(variant: &str, seconds: f64, wrong: u64) -> VariantRecord {
    VariantRecord {
        variant: variant.into(),
        setting: String::new(),
        known_defect: None,
        is_reference: wrong == 0,
        error: ErrorOf::Counted { wrong, trials: 1_000_000 },
        is_below_reference: false,
        seconds: vec![seconds; 3],
        time_s: Estimate::exactly(seconds),
        ratio: Estimate::exactly(seconds / 2.0),
        standing: VariantStanding::OnFront,
        also: Default::default(),
        parts: Vec::new(),
        is_without: false,
    }
}

pub fn record(axes: Vec<AxisRecord>) -> AccuracyRecord {
    let run = measurement::record::made_up::run(&[]);
    AccuracyRecord {
        command_line: run.command_line,
        tool: run.tool,
        machine: run.machine,
        compiler: run.compiler,
        seed: 1,
        quick: false,
        rounds: 3,
        processes: 1,
        took_s: 1.0,
        axes,
    }
}

/// An axis of these variants on one scene.
pub fn axis(rows: Vec<VariantRecord>) -> AxisRecord {
    let scene = SceneOutcome { scene: "kitchen".into(), rows, ..SceneOutcome::new("", "") };
    let [axis, metric, reference] = ["triangle-test", "misses", "exact"].map(str::to_owned);
    AxisRecord { axis, metric, reference, scenes: vec![scene] }
}
