//! Sections from what studies left in the folder: sweeps, accuracy, tracers, costs, published
//! times.

use crate::report::material::{LectureRow, Material, ReproducedFigure};
use crate::report::page::{Page, image};
use measurement::record::Verdict;
use presentation::numbers::{milliseconds, ratio, short};
use presentation::svg_plot::{Axis, Plot, Point, Scale, Series};
use presentation::table::{Cell, Style, Table, words};
use statistics::estimate::Estimate;
use studies::accuracy::{report, summary};
use studies::tracer_comparison::record::{Outcome, TracersRecord};
use studies::tracer_comparison::report::error_over_time;

pub fn sweeps(material: &Material, page: &mut Page) {
    let html = &mut page.html;
    for (name, plot) in &material.sweeps {
        html.element("h3", &[], name);
        let text = format!("plot of times over the values of a parameter, {name}");
        html.open("figure", &[]);
        html.open_scroll(&text);
        image(html, plot.kind, &plot.bytes, &text, &[("class", "plot")]);
        html.close();
        html.close();
    }
}

/// What to take, then each axis as a plot and as tables.
pub fn accuracy(material: &Material, page: &mut Page) {
    let Some(run) = &material.accuracy else { return };
    page.html.list(report::facts(run));
    page.table(&summary::advice(run));
    for axis in &run.axes {
        page.html.element("h3", &[], &axis.axis);
        for scene in &axis.scenes {
            let name = format!("accuracy-{}-{}", axis.axis, scene.scene);
            page.plot(&name, &report::panel(axis, scene));
        }
        page.html.open_details(&[], &format!("{}: scene by scene", axis.axis));
        for scene in &axis.scenes {
            page.table(&report::table(axis, scene));
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
    for (scene, maps) in &material.heat_maps {
        if !maps.is_empty() {
            html.element("h3", &[], scene);
        }
        for (name, map) in maps {
            let known = CAPTIONS.iter().find(|(known, _)| known == name);
            let caption = known.map_or(name.as_str(), |(_, caption)| caption);
            let text = format!("{scene}: {caption}");
            html.open("figure", &[("class", "picture")]);
            image(html, map.kind, &map.bytes, &text, &[]);
            html.element("figcaption", &[], &text);
            html.close();
        }
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
    page.table(&table);
}

pub fn tracers(material: &Material, page: &mut Page) {
    for record in &material.tracers {
        page.html.element("h3", &[], &record.scene);
        page.plot(&format!("tracers-{}", record.scene), &error_over_time(record));
        page.table(&tracer_table(record));
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

/// The counters that are drawn, with their colours' order.
const DRAWN: [&str; 3] = ["N_IT", "N_TS", "N_OIV"];
/// Name of the table of best settings.
const BEST: &str = "best";

/// Counters that Havran and Sixta published in 1999, and Havran's octrees, beside ours: number of
/// figures that agree, a plot of then and now, and the table of the best settings. Figures and verdicts
/// are those of `rtbench reproduce havran1999`.
pub fn counters(material: &Material, page: &mut Page) {
    let Some(rows) = material.counters.as_deref().filter(|rows| !rows.is_empty()) else {
        return;
    };
    page.html.paragraph(
        "Every published counter, on the scenes and rays of the paper. Figures on the diagonal are \
         the same then and now.",
    );
    page.plot("counters-1999", &counter_plot(rows));
    page.table(&counter_verdicts(rows));
    for counter in DRAWN {
        let table = best(rows, counter);
        if !table.rows.is_empty() {
            page.table(&table);
        }
    }
}

/// A word for each kind of verdict; its reason is left out.
const KINDS: [(&str, &str); 4] = [
    ("exact", "exact"),
    ("within tolerance", "within tolerance"),
    ("differs: unexplained", "differs, unexplained"),
    ("differs", "differs for a known reason"),
];

/// Numbers of figures of each structure that agree.
fn counter_verdicts(rows: &[ReproducedFigure]) -> Table {
    let kind =
        |row: &ReproducedFigure| KINDS.iter().position(|(begin, _)| row.verdict.starts_with(begin));
    let mut structures: Vec<&str> = Vec::new();
    for row in rows {
        if !structures.contains(&row.structure.as_str()) {
            structures.push(&row.structure);
        }
    }
    let counts = |of: &dyn Fn(&ReproducedFigure) -> bool| {
        let in_kind = |i| rows.iter().filter(|r| of(r) && kind(r) == Some(i)).count().to_string();
        (0..KINDS.len()).map(in_kind).collect::<Vec<_>>()
    };
    let line = |name: &str, counts: Vec<String>| [vec![name.to_owned()], counts].concat();
    let own = structures.iter().map(|name| line(name, counts(&|r| r.structure == *name)));
    let lines = own.chain([line("all", counts(&|_| true))]);
    let header = std::iter::once("structure").chain(KINDS.map(|(_, name)| name)).collect();
    words("Published figures that we reproduce", header, lines)
}

/// Then across, now up.
fn counter_plot(rows: &[ReproducedFigure]) -> Plot {
    let series = DRAWN.map(|counter| {
        let points = rows.iter().filter(|r| r.counter == counter).filter_map(|row| {
            let then: f64 = row.published.parse().ok()?;
            Some(Point { x: then, y: row.ours, low: row.ours, high: row.ours })
        });
        Series { name: counter.to_owned(), points: points.collect(), is_joined: false }
    });
    let mut series = series.to_vec();
    let ends = series.iter().flat_map(|s| &s.points).map(|p| p.x).filter(|x| *x > 0.0);
    let (low, high) =
        ends.fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
    if low < high {
        let point = |x: f64| Point { x, y: x, low: x, high: x };
        let points = vec![point(low), point(high)];
        series.push(Series { name: "the same".to_owned(), points, is_joined: true });
    }
    let axis = |label: &str| Axis { label: label.to_owned(), scale: Scale::Log };
    Plot {
        title: "Counters: 1999 and now".to_owned(),
        subtitle: "N_IT and N_TS are per ray; all scenes, structures and settings".to_owned(),
        x: axis("published in 1999"),
        y: axis("ours"),
        series,
        ..Plot::default()
    }
}

/// One counter of the settings that the paper found best: scenes down, then and now across.
fn best(rows: &[ReproducedFigure], counter: &str) -> Table {
    let rows = rows.iter().filter(|r| r.structure == BEST && r.counter == counter);
    let lines = rows.map(|row| {
        let then: f64 = row.published.parse().unwrap_or(f64::NAN);
        vec![
            row.scene.clone(),
            row.params.clone(),
            row.published.clone(),
            if row.ours.fract() == 0.0 { row.ours.to_string() } else { format!("{:.2}", row.ours) },
            short(row.ours / then),
            row.verdict.clone(),
        ]
    });
    let header = vec!["scene", "structure", "1999", "ours", "ours / 1999", "judged"];
    words(format!("{counter} with the settings that the paper found best"), header, lines)
}
