//! Counters that Havran and Sixta published in 1999, and Havran's octrees, beside ours.
//!
//! The figures and the verdicts are those of `rtbench reproduce havran1999`.

use crate::report::material::{Material, ReproducedFigure};
use crate::report::page::{Page, look};
use presentation::numbers::short;
use presentation::page::write_table;
use presentation::svg_plot::{Axis, Plot, Point, Scale, Series};
use presentation::table::{Table, words};

/// The counters that are drawn, with their colours' order.
const DRAWN: [&str; 3] = ["N_IT", "N_TS", "N_OIV"];
/// Name of the table of best settings.
const BEST: &str = "best";

/// Number of figures that agree, a plot of then and now, and the table of the best settings.
pub fn write(material: &Material, page: &mut Page) {
    let Some(rows) = material.counters.as_deref().filter(|rows| !rows.is_empty()) else {
        return;
    };
    page.html.paragraph(
        "Every published counter, on the scenes and rays of the paper. Figures on the diagonal are \
         the same then and now.",
    );
    page.plot("counters-1999", plot(rows));
    write_table(&mut page.html, &verdicts(rows), look());
    for counter in DRAWN {
        let table = best(rows, counter);
        if !table.rows.is_empty() {
            write_table(&mut page.html, &table, look());
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
fn verdicts(rows: &[ReproducedFigure]) -> Table {
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
fn plot(rows: &[ReproducedFigure]) -> Plot {
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
