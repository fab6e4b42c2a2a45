//! Sections from what studies left in the folder: sweeps, accuracy, tracers, costs, published
//! times.

use crate::report::material::{LectureRow, Material};
use crate::report::page::{Page, image, look};
use measurement::record::Verdict;
use presentation::numbers::{milliseconds, ratio, short};
use presentation::page::write_table;
use presentation::table::{Cell, Style, Table, words};
use statistics::estimate::Estimate;
use studies::accuracy::{report, summary};
use studies::tracer_comparison::record::{Outcome, TracersRecord};
use studies::tracer_comparison::report::error_over_time;

pub fn sweeps(material: &Material, page: &mut Page) {
    let html = &mut page.html;
    for sweep in &material.sweeps {
        html.element("h3", &[], &sweep.name);
        let text = format!("plot of times over the values of a parameter, {}", sweep.name);
        html.open("figure", &[]);
        html.open_scroll(&text);
        image(html, "svg+xml", &sweep.svg, &text, &[("class", "plot")]);
        html.close();
        html.close();
    }
}

/// What to take, then each axis as a plot and as tables.
pub fn accuracy(material: &Material, page: &mut Page) {
    let Some(run) = &material.accuracy else { return };
    page.html.list(report::facts(run));
    write_table(&mut page.html, &summary::advice(run), look());
    for axis in &run.axes {
        page.html.element("h3", &[], &axis.axis);
        for scene in &axis.scenes {
            let name = format!("accuracy-{}-{}", axis.axis, scene.scene);
            page.plot(&name, report::panel(axis, scene));
        }
        page.html.open("details", &[]);
        page.html.element("summary", &[], &format!("{}: scene by scene", axis.axis));
        for scene in &axis.scenes {
            write_table(&mut page.html, &report::table(axis, scene), look());
        }
        page.html.close();
    }
    page.html.list(report::GLOSSARY.iter().map(|line| (*line).to_owned()));
}

static CAPTIONS: &[(&str, &str)] = &[
    ("tests", "intersection tests of each pixel"),
    ("steps", "traversal steps of each pixel"),
    ("time", "microseconds of each pixel"),
];

pub fn heat_maps(material: &Material, page: &mut Page) {
    let html = &mut page.html;
    for (i, map) in material.heat_maps.iter().enumerate() {
        let is_first =
            i == 0 || material.heat_maps.get(i - 1).is_some_and(|before| before.scene != map.scene);
        if is_first {
            html.element("h3", &[], &map.scene);
        }
        let known = CAPTIONS.iter().find(|(name, _)| *name == map.name);
        let caption = known.map_or(map.name.as_str(), |(_, caption)| caption);
        let text = format!("{}: {caption}", map.scene);
        html.open("figure", &[("class", "picture")]);
        image(html, map.image.kind, &map.image.bytes, &text, &[]);
        html.element("figcaption", &[], &text);
        html.close();
    }
}

pub fn lecture(material: &Material, page: &mut Page) {
    let Some(rows) = material.lecture.as_deref().filter(|rows| !rows.is_empty()) else {
        return;
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
    write_table(&mut page.html, &table, look());
}

pub fn tracers(material: &Material, page: &mut Page) {
    for record in &material.tracers {
        page.html.element("h3", &[], &record.scene);
        page.plot(&format!("tracers-{}", record.scene), error_over_time(record));
        write_table(&mut page.html, &tracer_table(record), look());
    }
}

fn tracer_table(record: &TracersRecord) -> Table {
    let rows = record.images.iter().map(|image| {
        let mut cells = vec![image.row.label()];
        match &image.outcome {
            Outcome::Refused { refused, .. } => {
                cells.extend(["-", "-", "-"].map(str::to_owned));
                cells.push(format!("refused: {refused}"));
            }
            Outcome::Made(measured) => {
                let below = if measured.is_below_reference { "< " } else { "" };
                let time = record.time(&measured.seconds);
                cells.push(time.map_or("-".to_owned(), |t| milliseconds(t.median)));
                cells.push(time.map_or("-".to_owned(), |t| {
                    format!("[{}, {}]", milliseconds(t.low), milliseconds(t.high))
                }));
                cells.push(format!("{below}{}", short(measured.error)));
                cells.push(measured.standing.name().to_owned());
            }
        }
        cells
    });
    let header = vec!["tracer", "image, milliseconds", "95%", "RMSE", "stands"];
    let mut table = words(format!("{}: images", record.scene), header, rows);
    table.notes.push(format!(
        "Reference: the mean of two images of {} samples per pixel; its own error is {}; errors \
         below ten times that are marked <.",
        record.reference.samples,
        short(record.reference.own_error)
    ));
    table
}
