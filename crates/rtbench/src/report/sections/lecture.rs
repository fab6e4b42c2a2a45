//! The lecture's two tables (Zachmann 2007, after Havran and Sixta 1999) beside ours: all times over
//! those of uniform D=1 on the same machine.

use serde::Deserialize;

use crate::report::material::Material;
use crate::report::tables::{self, Look};
use crate::report::{Page, Shown};
use measurement::record::Verdict;
use presentation::numbers::{ratio, short};
use presentation::table::{Cell, Style, Table};
use statistics::estimate::Estimate;

/// A row as `rtbench reproduce zachmann2007 --export-csv` writes it.
#[derive(Debug, Clone, Deserialize)]
pub struct LectureRow {
    scene: String,
    lecture: String,
    ours: String,
    verdict: String,
    build_then: Option<f64>,
    build_now: Option<f64>,
    build_low: Option<f64>,
    build_high: Option<f64>,
    run_then: Option<f64>,
    run_now: Option<f64>,
    run_low: Option<f64>,
    run_high: Option<f64>,
}

impl LectureRow {
    fn build(&self) -> Option<Estimate> {
        let (median, low, high) = (self.build_now?, self.build_low?, self.build_high?);
        Some(Estimate { median, low, high })
    }

    fn run(&self) -> Option<Estimate> {
        let (median, low, high) = (self.run_now?, self.run_low?, self.run_high?);
        Some(Estimate { median, low, high })
    }
}

/// One table.
pub fn write(material: &Material, page: &mut Page) -> Shown {
    let Some(rows) = material.lecture.as_deref().filter(|rows| !rows.is_empty()) else {
        return Shown::Missing;
    };
    let now = |row: &LectureRow, estimate: Option<Estimate>| match estimate {
        _ if row.verdict != Verdict::Ok.name() => {
            Cell { text: row.verdict.clone(), style: Style::Bad }
        }
        Some(estimate) => ratio(&estimate).into(),
        None => "-".to_owned().into(),
    };
    let then = |value: Option<f64>| Cell::from(value.map_or("-".to_owned(), short));
    let lines = rows.iter().map(|row| {
        let name = if row.lecture.is_empty() { &row.ours } else { &row.lecture };
        vec![
            row.scene.clone().into(),
            name.clone().into(),
            then(row.build_then),
            now(row, row.build()),
            then(row.run_then),
            now(row, row.run()),
        ]
    });
    let table = Table {
        title: "Times over those of uniform D=1, in the lecture and now".to_owned(),
        header: vec![
            "scene",
            "structure",
            "build, lecture",
            "build now [95%]",
            "run, lecture",
            "run now [95%]",
        ],
        rows: lines.collect(),
        notes: Vec::new(),
    };
    tables::write(&mut page.html, &table, Look::default());
    Shown::Yes
}
