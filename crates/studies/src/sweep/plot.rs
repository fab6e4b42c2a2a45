//! A sweep as a plot: tracing time over the values, rules of thumb beside them.

use crate::sweep::judgement::{Judgement, ValueStanding, costs, judge};
use crate::sweep::{Abscissa, Line, Sweep};
use measurement::record::{RunRecord, SceneRecord, Verdict, reference};
use presentation::svg_plot::{Axis, Level, Mark, Plot, Point, Ring, Scale, Series, figure};
use statistics::estimate::Estimate;

/// From this ratio of the slowest to the fastest on, the time axis is logarithmic.
const WIDE: f64 = 8.0;

pub fn to_svg(sweep: &Sweep<'_>, run: &RunRecord) -> String {
    let panels: Vec<Plot> = run.scenes.iter().map(|scene| panel(sweep, run, scene)).collect();
    figure(&panels)
}

/// A row that has a time, and where it lies.
struct PlottedRow<'a> {
    line: &'a Line,
    judgement: &'a Judgement,
    point: Point,
}

fn panel(sweep: &Sweep<'_>, run: &RunRecord, scene: &SceneRecord) -> Plot {
    let judgements = judge(sweep, scene);
    let words = words(sweep);
    let rows = scene.rows.iter().zip(&sweep.lines).zip(&judgements).zip(costs(scene));
    let placed: Vec<PlottedRow<'_>> = rows
        .filter(|(((row, _), _), _)| row.verdict == Verdict::Ok)
        .filter_map(|(((_, line), judgement), cost)| {
            let x = abscissa(sweep, line, judgement, &words)?;
            Some(PlottedRow { line, judgement, point: point(x, cost?) })
        })
        .collect();
    let has_ratios = scene.rows.iter().any(|r| r.ratio.is_some());
    let settings = format!("{} {}", sweep.structure, sweep.settings);
    let rays = scene.distinct_rays();
    let reference = reference::of_scene(scene).unwrap_or_else(|| run.settings.reference.clone());
    let mut swept: Vec<Point> =
        placed.iter().filter(|p| p.line.is_swept).map(|p| p.point).collect();
    swept.sort_by(|a, b| a.x.total_cmp(&b.x));
    let reference_level = has_ratios.then(|| Level { y: 1.0, label: format!("{reference} = 1") });
    Plot {
        title: format!("{}: {} of {}", scene.name, sweep.parameter.name, settings.trim_end()),
        subtitle: subtitle(scene, rays, sweep, &judgements),
        x: horizontal(sweep, words),
        y: Axis {
            label: if has_ratios {
                format!("trace time / trace time of {reference}")
            } else {
                "trace time per ray (seconds)".to_owned()
            },
            scale: vertical(&placed),
        },
        series: vec![Series {
            name: format!("values of {}", sweep.parameter.name),
            points: swept,
            is_joined: sweep.abscissa != Abscissa::Words,
        }],
        marks: placed.iter().filter_map(mark).collect(),
        marks_name: match sweep.abscissa {
            Abscissa::CellsPerPrimitive => "for comparison: default and rules of thumb".to_owned(),
            Abscissa::Number { .. } | Abscissa::Words => "for comparison: default".to_owned(),
        },
        levels: reference_level.into_iter().chain(default_level(sweep, &placed)).collect(),
    }
}

/// The default as a level where its value has no place: 0 on a logarithmic axis.
fn default_level(sweep: &Sweep<'_>, placed: &[PlottedRow<'_>]) -> Option<Level> {
    let is_log = sweep.abscissa == Abscissa::Number { is_log: true };
    let default = placed.iter().find(|p| is_log && p.line.is_default && p.point.x <= 0.0)?;
    let value = default.line.value.as_deref().unwrap_or_default();
    Some(Level { y: default.point.y, label: format!("default: {value}") })
}

fn subtitle(scene: &SceneRecord, rays: u64, sweep: &Sweep<'_>, judgements: &[Judgement]) -> String {
    let mut text =
        format!("{} primitives, {rays} rays; medians with 95% intervals", scene.primitives);
    let hidden: Vec<&str> = scene
        .rows
        .iter()
        .zip(&sweep.lines)
        .filter(|(row, _)| row.verdict != Verdict::Ok)
        .filter_map(|(_, line)| line.value.as_deref().or(line.rules.first().copied()))
        .collect();
    if !hidden.is_empty() {
        text.push_str(&format!("; wrong or not built: {}", hidden.join(", ")));
    }
    let has_equals = judgements.iter().any(|j| j.standing == Some(ValueStanding::NotToldApart));
    if has_equals {
        text.push_str("; dashed rings: not significantly different from the best");
    }
    text
}

fn point(x: f64, cost: Estimate) -> Point {
    Point { x, y: cost.median, low: cost.low, high: cost.high }
}

/// The words of the horizontal axis: the values, the default among them.
fn words(sweep: &Sweep<'_>) -> Vec<String> {
    match sweep.abscissa {
        Abscissa::Words => sweep.lines.iter().filter_map(|l| l.value.clone()).collect(),
        Abscissa::CellsPerPrimitive | Abscissa::Number { .. } => Vec::new(),
    }
}

/// Position of a row on the horizontal axis; `None` for the reference.
fn abscissa(sweep: &Sweep<'_>, line: &Line, judged: &Judgement, words: &[String]) -> Option<f64> {
    let value = line.value.as_ref();
    match sweep.abscissa {
        Abscissa::CellsPerPrimitive => {
            let is_own = value.is_some() || !line.rules.is_empty();
            judged.cells_per_primitive.filter(|_| is_own)
        }
        Abscissa::Number { .. } => value?.parse().ok(),
        Abscissa::Words => Some(words.iter().position(|w| Some(w) == value)? as f64),
    }
}

fn horizontal(sweep: &Sweep<'_>, words: Vec<String>) -> Axis {
    let name = sweep.parameter.name;
    let (label, scale) = match sweep.abscissa {
        Abscissa::CellsPerPrimitive => (format!("cells per primitive, by {name}"), Scale::Log),
        Abscissa::Number { is_log: true } => (name.to_owned(), Scale::Log),
        Abscissa::Number { is_log: false } => (name.to_owned(), Scale::Linear),
        Abscissa::Words => (name.to_owned(), Scale::Words(words)),
    };
    Axis { label, scale }
}

fn vertical(placed: &[PlottedRow<'_>]) -> Scale {
    let times = || placed.iter().map(|p| p.point.y);
    let fastest = times().fold(f64::INFINITY, f64::min);
    let slowest = times().fold(0.0, f64::max);
    if fastest > 0.0 && slowest / fastest >= WIDE { Scale::Log } else { Scale::FromZero }
}

/// Mark for the best value and those as good, the default, the rules of thumb.
fn mark(placed: &PlottedRow<'_>) -> Option<Mark> {
    let ring = match placed.judgement.standing {
        Some(ValueStanding::Best) => Ring::Best,
        Some(ValueStanding::NotToldApart) => Ring::AsGood,
        Some(ValueStanding::Slower) | None => Ring::None,
    };
    let marks = placed.judgement.marks.iter().map(String::as_str);
    // The dashed ring says the one, the other is a row of its own kind.
    let marks: Vec<&str> = marks.filter(|m| !["~best", "reference"].contains(m)).collect();
    let mut label = marks.join(", ");
    if let (true, true, Some(value)) = (placed.line.is_swept, !label.is_empty(), &placed.line.value)
    {
        label = format!("{label}: {value}");
    }
    let is_in_series = placed.line.is_swept;
    let is_marked = !label.is_empty() || ring != Ring::None;
    let (point, hover) = (placed.point, String::new());
    is_marked.then_some(Mark { point, label, hover, ring, is_in_series })
}
