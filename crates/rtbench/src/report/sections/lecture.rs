//! The two tables of Zachmann 2007 (after Havran and Sixta 1999) beside ours: all times over
//! those of uniform D=1 on the same machine.

use crate::report::glossary::look;
use crate::report::material::Material;
use crate::report::page::{Page, SectionOutcome};
use crate::report::records::LectureRow;
use measurement::record::Verdict;
use presentation::numbers::{ratio, short};
use presentation::page::tables;
use presentation::table::{Cell, Style, Table};
use statistics::estimate::Estimate;

pub fn write(material: &Material, page: &mut Page) -> SectionOutcome {
    let Some(rows) = material.lecture.as_deref().filter(|rows| !rows.is_empty()) else {
        return SectionOutcome::Missing;
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
    tables::write(&mut page.html, &table, look());
    SectionOutcome::Yes
}
