//! The columns that a size has beside those of a run.

use measurement::record::scale::SizeRecord;
use presentation::column::{Column, Unit, Value};

use crate::run::columns::RowOf;
use crate::sweep::sizes::quantities::trace_s_per_ray;

/// A row of a size.
#[derive(Debug, Clone, Copy)]
pub struct SizeRow<'a> {
    /// As of a run.
    pub of: RowOf<'a>,
    /// The requested size.
    pub size: Option<&'a SizeRecord>,
}

impl SizeRow<'_> {
    fn each(&self, all: Option<f64>) -> Value {
        Value::of(all.map(|x| x / self.of.scene.primitives.max(1) as f64), Value::Real)
    }
}

/// The numbers of primitives that a size stands for.
pub fn asked(size: Option<&SizeRecord>, between: &str) -> String {
    let asked = size.iter().flat_map(|size| &size.asked).map(u64::to_string);
    asked.collect::<Vec<_>>().join(between)
}

/// All of them, in the order of CSV files; behind them come those of a run.
pub fn columns<'a>() -> [Column<SizeRow<'a>>; 6] {
    let c = Column::new;
    [
        c(&["asked_primitives"], "", Unit::None, |row: &SizeRow<'a>| {
            Value::Text(asked(row.size, "; "))
        }),
        c(&["build_ns_per_primitive"], "ns/prim", Unit::None, |row| {
            row.each(row.of.row.build_s.map(|e| e.median * 1e9))
        }),
        c(&["trace_ns_per_ray"], "ns/ray", Unit::None, |row| {
            Value::of(trace_s_per_ray(row.of.row).map(|e| e.median * 1e9), Value::Real)
        }),
        c(&["bytes_per_primitive"], "B/prim", Unit::None, |row| {
            row.each(row.of.row.stats.as_ref().map(|stats| stats.memory_bytes as f64))
        }),
        c(&["peak_build_bytes"], "peak MiB", Unit::Bytes, |row| {
            Value::of(row.of.row.peak_build_bytes, Value::Count)
        }),
        // why a row was not measured
        c(&["reason"], "", Unit::None, |row| Value::of(row.of.row.error.clone(), Value::Text)),
    ]
}
