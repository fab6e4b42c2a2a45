//! A run over sizes as tables, CSV and plots: the columns of a size, one table per size, and the
//! slopes over all of them.

use std::io::{self, Write};

use crate::run::columns::{self as run, RATIO, RowOf};
use crate::run::output;
use crate::run::tables::{scene_notes, scene_title};
use crate::sweep::sizes::quantities::{QUANTITIES, Quantity, points, rows, trace_s_per_ray};
use measurement::record::scale::{SizeRecord, SlopeRecord};
use measurement::record::{RowRecord, RunRecord, SceneRecord, Verdict};
use presentation::column::{self, Column, Unit, Value, headed};
use presentation::csv::written;
use presentation::json::FormatError;
use presentation::numbers;
use presentation::svg_plot::{Axis, Plot, Point, Scale, Series, figure};
use presentation::table::{Cell, Style, Table, dash};
use presentation::text::Screen;
use statistics::estimate::Estimate;

pub fn write_size(
    out: &mut dyn Write,
    run: &RunRecord,
    scene: &SceneRecord,
    screen: Screen,
) -> io::Result<()> {
    screen.write_fitted(out, &size_table(run, scene), &FIRST)
}

/// Prints the slopes, and what the columns of all tables mean.
pub fn write_slopes(out: &mut dyn Write, run: &RunRecord, screen: Screen) -> io::Result<()> {
    screen.write_fitted(out, &slope_table(run), &[])?;
    screen.write_notes(out, GLOSSARY)
}

/// All tables in Markdown, the slopes first.
pub fn to_markdown(run: &RunRecord) -> String {
    let sizes = run.scenes.iter().map(|scene| size_table(run, scene));
    let tables: Vec<Table> = std::iter::once(slope_table(run)).chain(sizes).collect();
    output::document("rtbench sweep", run, &tables, GLOSSARY)
}

/// The columns of a size: its own, and those of a run.
const HEADS: [&str; 8] =
    ["build ms", "ns/prim", "ns/ray", "MiB", "B/prim", "peak MiB", RATIO, "verdict"];

/// Columns kept when not all fit.
const FIRST: [&str; 6] = [RATIO, "verdict", "build ms", "ns/ray", "MiB", "peak MiB"];

fn size_table(run: &RunRecord, scene: &SceneRecord) -> Table {
    let size = run.scale.as_ref().and_then(|scale| scale.size(&scene.name));
    let all_rays = scene.rays.values().sum();
    let (own, of_run) = (columns(), run::columns());
    let rows = scene.rows.iter().map(|row| {
        let of = SizeRow { of: RowOf { scene, row, all_rays }, size };
        let cell = |head: &str| match (headed(&own, head), headed(&of_run, head)) {
            (Some(column), _) => column.cell(&of),
            (None, Some(column)) if head == "verdict" => column.cell(&of.of),
            // the verdict says why there is none
            (None, Some(column)) => column.value_cell(&of.of),
            (None, None) => dash(),
        };
        std::iter::once(row.label().into()).chain(HEADS.into_iter().map(cell)).collect()
    });
    Table {
        title: format!("{}; asked for {}", scene_title(scene), requested_sizes(size, ", ")),
        header: std::iter::once("structure").chain(HEADS).collect(),
        rows: rows.collect(),
        notes: scene_notes(run, scene),
    }
}

fn slope_table(run: &RunRecord) -> Table {
    let scale = run.scale.as_ref();
    let row = |row: &&RowRecord| {
        let label = row.label();
        let slopes: Vec<Option<&SlopeRecord>> = QUANTITIES
            .iter()
            .map(|quantity| scale.and_then(|scale| scale.slope(&label, quantity.name)))
            .collect();
        let sizes = slopes.iter().flatten().map(|slope| slope.sizes).max().unwrap_or(0);
        let mut cells = vec![label.into(), sizes.to_string().into()];
        cells.extend(slopes.into_iter().map(|slope| slope.map_or_else(dash, slope_cell)));
        cells
    };
    let scene = scale.map_or("", |scale| scale.scene.as_str());
    let mut notes = Vec::new();
    if let Some(scale) = scale {
        notes.push(format!(
            "Limits: {} s per build, {} MiB per process that loads the scene and builds one row.",
            scale.time_limit_s,
            numbers::mebibytes(scale.max_memory_bytes)
        ));
    }
    Table {
        title: format!("{scene}: slopes over the number of primitives, log-log"),
        header: vec![
            "structure",
            "sizes",
            "build [95%]",
            "trace [95%]",
            "memory [95%]",
            "peak [95%]",
        ],
        rows: rows(&run.scenes).iter().map(row).collect(),
        notes,
    }
}

fn slope_cell(slope: &SlopeRecord) -> Cell {
    let text = match slope.low.zip(slope.high) {
        Some((low, high)) => format!("{:.2} [{low:.2}, {high:.2}]", slope.slope),
        None => format!("{:.2} [?]", slope.slope),
    };
    Cell { text, style: Style::Plain }
}

const GLOSSARY: &[&str] = &[
    "build: median over the rounds, ns/prim the same for each primitive; ns/ray: trace time of a \
     ray, over the kinds in the title; MiB: bytes of the structure, B/prim the same for each \
     primitive; peak MiB: memory at the peak of the build minus memory before it, in a process \
     that does nothing else; includes the structure. ratio: trace time to the reference's, with its 95% \
     bootstrap interval.",
    "slopes: the power of the number of primitives that a quantity grows with, by least squares \
     over the logarithms of the sizes measured, with the 95% interval (Student) from the \
     residuals; [?] if there are only two sizes. \
     1 is linear; n log n is about 1.1 between a thousand and ten million.",
    "over limit: the build took more time or memory than the limits allow; the row is not measured \
     there and not tried at larger sizes.",
];

#[derive(Debug, Clone, Copy)]
pub struct SizeRow<'a> {
    /// As of a run.
    pub of: RowOf<'a>,
    pub size: Option<&'a SizeRecord>,
}

impl SizeRow<'_> {
    fn per_primitive(&self, all: Option<f64>) -> Value {
        Value::of(all.map(|x| x / self.of.scene.primitives.max(1) as f64), Value::Real)
    }
}

/// The numbers of primitives that a size stands for.
pub fn requested_sizes(size: Option<&SizeRecord>, between: &str) -> String {
    let asked = size.iter().flat_map(|size| &size.asked).map(u64::to_string);
    asked.collect::<Vec<_>>().join(between)
}

/// All of them, in the order of CSV files; behind them come those of a run.
pub fn columns<'a>() -> [Column<SizeRow<'a>>; 6] {
    let c = Column::new;
    [
        c(&["asked_primitives"], "", Unit::None, |row: &SizeRow<'a>| {
            Value::Text(requested_sizes(row.size, "; "))
        }),
        c(&["build_ns_per_primitive"], "ns/prim", Unit::None, |row| {
            row.per_primitive(row.of.row.build_s.map(|e| e.median * 1e9))
        }),
        c(&["trace_ns_per_ray"], "ns/ray", Unit::None, |row| {
            Value::of(trace_s_per_ray(row.of.row).map(|e| e.median * 1e9), Value::Real)
        }),
        c(&["bytes_per_primitive"], "B/prim", Unit::None, |row| {
            row.per_primitive(row.of.row.stats.as_ref().map(|stats| stats.memory_bytes as f64))
        }),
        c(&["peak_build_bytes"], "peak MiB", Unit::Bytes, |row| {
            Value::of(row.of.row.peak_build_bytes, Value::Count)
        }),
        // why a row was not measured
        c(&["reason"], "", Unit::None, |row| Value::of(row.of.row.error.clone(), Value::Text)),
    ]
}

/// All finished sizes: their own columns, then those of a run.
pub fn sizes_csv(run: &RunRecord) -> Result<String, FormatError> {
    let columns = columns();
    written(|writer| {
        writer.write_record(column::keys(&columns).chain(run::keys()))?;
        for scene in &run.scenes {
            let size = run.scale.as_ref().and_then(|scale| scale.size(&scene.name));
            for row in &scene.rows {
                let of = SizeRow { of: RowOf { scene, row, all_rays: 0 }, size };
                let own = column::fields(&columns, &of);
                writer.write_record(own.chain(run::fields(scene, row)))?;
            }
        }
        Ok(())
    })
}

/// How each quantity of each row grows.
#[rustfmt::skip]
pub fn slopes_csv<'a>(run: &'a RunRecord) -> Result<String, FormatError> {
    use Value::{Count, Real, Text};
    let c = |keys, of| Column::new(keys, "", Unit::None, of);
    let columns = [
        c(&["scene"], |(scene, _): &(&'a str, &'a SlopeRecord)| Text((*scene).to_owned())),
        c(&["structure"], |(_, slope)| Text(slope.structure.clone())),
        c(&["settings"], |(_, slope)| Text(slope.settings.clone())),
        c(&["quantity"], |(_, slope)| Text(slope.quantity.clone())),
        c(&["sizes"], |(_, slope)| Count(slope.sizes)),
        c(&["slope"], |(_, slope)| Real(slope.slope)),
        c(&["low"], |(_, slope)| Value::of(slope.low, Real)),
        c(&["high"], |(_, slope)| Value::of(slope.high, Real)),
    ];
    let slopes = run.scale.iter().flat_map(|scale| scale.slopes.iter().map(move |s| (&*scale.scene, s)));
    column::csv(&columns, slopes)
}

/// Plots, both axes logarithmic: the panels of the quantities that have something to show.
pub fn to_svg(run: &RunRecord) -> String {
    let panels: Vec<Plot> = QUANTITIES.iter().filter_map(|quantity| panel(run, quantity)).collect();
    figure(&panels)
}

fn panel(run: &RunRecord, quantity: &Quantity) -> Option<Plot> {
    let scale = run.scale.as_ref()?;
    let series: Vec<Series> = rows(&run.scenes)
        .into_iter()
        .map(|row| series(run, row, quantity))
        .filter(|series| !series.points.is_empty())
        .collect();
    let axis = |label: &str| Axis { label: label.to_owned(), scale: Scale::Log };
    (!series.is_empty()).then(|| Plot {
        title: format!("{}: {}", scale.scene, quantity.label),
        subtitle: subtitle(run),
        x: axis("primitives"),
        y: axis(quantity.label),
        series,
        ..Plot::default()
    })
}

/// A row's curve; the legend has its slope.
fn series(run: &RunRecord, row: &RowRecord, quantity: &Quantity) -> Series {
    let point = |&(x, Estimate { median: y, low, high }): &_| Point { x, y, low, high };
    let label = row.label();
    let slope = run.scale.as_ref().and_then(|scale| scale.slope(&label, quantity.name));
    Series {
        name: slope.map_or_else(|| label.clone(), |s| format!("{label} ({:.2})", s.slope)),
        points: points(&run.scenes, row, quantity).iter().map(point).collect(),
        is_joined: true,
    }
}

/// Subtitle: the quantity, and rows missing at some size.
fn subtitle(run: &RunRecord) -> String {
    let mut text = "medians with 95% intervals; in parentheses the slope".to_owned();
    let hidden = rows(&run.scenes).into_iter().filter(|row| {
        let same = run.scenes.iter().flat_map(|s| &s.rows).filter(|other| other.is_same(row));
        same.map(|row| row.verdict).any(|verdict| verdict != Verdict::Ok)
    });
    let hidden: Vec<String> = hidden.map(RowRecord::label).collect();
    match hidden.len() {
        0 => {}
        1..=3 => text.push_str(&format!("; not ok at some size: {}", hidden.join(", "))),
        n => text.push_str(&format!("; {n} rows are not ok at some size")),
    }
    text
}
