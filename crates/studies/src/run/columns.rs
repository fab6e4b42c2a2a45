//! The columns of a run's results: one line each, from which tables and CSV come.

use measurement::record::{
    AnsweredRays, Outliers, RowRecord, SceneRecord, StatsRecord, Verdict, WorkRecord, reference,
};
use presentation::column::{self, Column, Unit, Value};
use presentation::numbers;
use presentation::table::{Cell, Style, Table, dash};

/// The head of the ratios to the reference.
pub const RATIO: &str = "ratio [95%]";

#[derive(Debug, Clone, Copy)]
pub struct RowOf<'a> {
    pub scene: &'a SceneRecord,
    pub row: &'a RowRecord,
    /// Rays of the scene; a verdict that rests on fewer says so.
    pub all_rays: u64,
}

impl RowOf<'_> {
    fn stats(&self, read: fn(&StatsRecord) -> Option<u64>) -> Value {
        Value::of(self.row.stats.as_ref().and_then(read), Value::Count)
    }

    /// N_IT, N_TS, N_ETS or N_EETS, by its place.
    fn work(&self, counter: usize) -> Value {
        let per_ray = self.row.work.as_ref().map(WorkRecord::per_ray);
        Value::of(per_ray.and_then(|work| work.get(counter).copied()), Value::Real)
    }

    /// Rays a second of a kind, by its place among [`rates`].
    fn rate(&self, kind: usize) -> Value {
        Value::of(rates(self.row).get(kind).copied().flatten(), Value::Real)
    }

    fn outliers(&self, read: fn(&Outliers) -> [u64; 2]) -> Value {
        let count = (!self.row.samples.is_empty()).then(|| read(&self.row.outliers).iter().sum());
        Value::of(count, Value::Count)
    }
}

/// A row that has no times shows its verdict in their place.
fn untimed(of: &RowOf<'_>) -> Option<Cell> {
    let verdict = of.row.verdict;
    (!verdict.is_timed()).then(|| Cell { text: verdict.name().into(), style: Style::Bad })
}

/// All columns, in the order of CSV files; behind them come those of each kind of ray, see
/// [`crate::run::kind_tables`].
#[rustfmt::skip]
pub fn columns<'a>() -> [Column<RowOf<'a>>; 34] {
    use Unit::{Bytes, None, PerRay, Ratio, Seconds};
    use Value::{Count, Measured, Real, Text};
    let c = Column::new;
    [
        c(&["scene"], "", None, |of: &RowOf<'a>| Text(of.scene.name.clone())),
        c(&["primitives"], "", None, |of| Count(of.scene.primitives)),
        c(&["structure"], "", None, |of| Text(of.row.structure.clone())),
        c(&["settings"], "", None, |of| Text(of.row.settings.clone())),
        c(&["resolution"], "", None, |of| {
            let voxels = of.row.stats.as_ref().and_then(|stats| stats.resolution);
            Value::of(voxels.map(numbers::resolution), Text)
        }),
        c(&["n_in"], "N_IN", None, |of| of.stats(|stats| Some(stats.n_in))),
        c(&["n_v"], "N_V", None, |of| of.stats(|stats| Some(stats.n_v))),
        c(&["n_ev"], "N_EV", None, |of| of.stats(|stats| Some(stats.n_ev))),
        c(&["n_oiv"], "N_OIV", None, |of| of.stats(|stats| Some(stats.n_oiv))),
        c(&["n_it"], "N_IT", PerRay, |of| of.work(0)),
        c(&["n_ts"], "N_TS", PerRay, |of| of.work(1)),
        c(&["n_ets"], "N_ETS", PerRay, |of| of.work(2)),
        c(&["n_eets"], "N_EETS", PerRay, |of| of.work(3)),
        c(&["saved_part"], "", None, |of| {
            Value::of(of.row.work.as_ref().and_then(WorkRecord::saved_part), Real)
        }),
        c(&["answers"], "", None, |of| Text(of.row.answers.name().to_owned())),
        c(&["rays"], "rays", None, |of| Count(of.row.rays)).or(|of| untimed(of).map(|_| dash())),
        c(&["memory_bytes"], "MiB", Bytes, |of| of.stats(|stats| Some(stats.memory_bytes))),
        c(&["pending_cells"], "", None, |of| of.stats(|stats| stats.pending_cells)),
        c(&["build_s", "build_s_low", "build_s_high"], "build ms", Seconds, |of| Value::of(of.row.build_s, Measured)).or(untimed),
        c(&["trace_s", "trace_s_low", "trace_s_high"], "trace ms", Seconds, |of| Value::of(of.row.trace_s, Measured)).or(untimed),
        c(&["render_s"], "image ms", Seconds, |of| Value::of(of.row.render_s, Real)).or(untimed),
        c(&["first_image_s"], "", Seconds, |of| Value::of(of.row.first_image_s(), Real)),
        c(&["ratio_to_reference", "ratio_low", "ratio_high"], RATIO, Ratio, |of| Value::of(of.row.ratio, Measured)).or(untimed),
        c(&["reference"], "", None, |of| {
            let reference = reference::of_scene(of.scene).filter(|_| of.row.ratio.is_some());
            Value::of(reference, Text)
        }),
        c(&["primary_mrays"], "primary", None, |of| of.rate(0)),
        c(&["shadow_mrays"], "shadow", None, |of| of.rate(1)),
        c(&["secondary_mrays"], "second.", None, |of| of.rate(2)),
        c(&["diffuse_mrays"], "diffuse", None, |of| of.rate(3)),
        c(&["mismatches"], "", None, |of| {
            Value::of(of.row.verdict.is_judged().then_some(of.row.mismatches), Count)
        }),
        c(&["verdict"], "verdict", None, |of| Text(of.row.verdict.name().to_owned()))
            .or(|of| Some(verdict_cell(of.row, of.all_rays))),
        c(&["build_outliers"], "", None, |of| of.outliers(|outliers| outliers.build)),
        c(&["trace_outliers"], "", None, |of| of.outliers(|outliers| outliers.trace)),
        c(&["edge_mismatches"], "", None, |of| Value::of(of.row.edge_mismatches(), Count)),
        c(&["origin"], "", None, |of| {
            Text(match of.row {
                RowRecord { foreign: Some(_), .. } => "foreign".to_owned(),
                RowRecord { plugin: Some(_), .. } => "plugin".to_owned(),
                _ => String::new(),
            })
        }),
    ]
}

/// Millions of rays per second: primary, shadow, secondary, diffuse.
fn rates(row: &RowRecord) -> [Option<f64>; 4] {
    let of = |kind: &str| row.mrays.get(kind).copied();
    // Rays over seconds, from the rates of both kinds.
    let seconds = |kind: &str| {
        let rays = *row.rays_by_kind.get(kind)? as f64;
        Some((rays, rays / of(kind)?))
    };
    let secondary = match (seconds("reflected"), seconds("refracted")) {
        (Some((r1, s1)), Some((r2, s2))) => Some((r1 + r2) / (s1 + s2)),
        (one, other) => one.or(other).map(|(r, s)| r / s),
    };
    [of("primary"), of("shadow"), secondary, of("diffuse")]
}

/// A number of rays as a part of all that were checked.
fn rate(rays: u64, checked: u64) -> String {
    format!("{:.1e}", rays as f64 / checked.max(1) as f64)
}

/// The verdict, and how many of the rays it rests on where that is not all of them.
fn verdict_cell(row: &RowRecord, all_rays: u64) -> Cell {
    let style = if row.verdict == Verdict::Ok { Style::Plain } else { Style::Bad };
    let text = match row.verdict {
        v if !v.is_judged() => v.name().to_owned(),
        Verdict::Ok if row.answers == AnsweredRays::ShadowRays => {
            format!("ok on {} shadow rays", row.checked_rays)
        }
        Verdict::Ok if row.checked_rays < all_rays => format!("ok on {} rays", row.checked_rays),
        Verdict::Ok => "ok".to_owned(),
        _ => {
            format!("{}: {} of {}", row.verdict.name(), row.mismatches, row.checked_rays)
        }
    };
    let at_edges = row.edge_mismatches().unwrap_or(0);
    let text = match at_edges {
        0 => text,
        n => format!("{text}; edges {}", rate(n, row.checked_rays)),
    };
    Cell { text, style }
}

/// The names of [`columns`].
pub fn keys() -> impl Iterator<Item = &'static str> {
    column::keys(&columns()).collect::<Vec<_>>().into_iter()
}

/// The fields of a row, one for each of [`keys`].
pub fn fields(scene: &SceneRecord, row: &RowRecord) -> Vec<String> {
    column::fields(&columns(), &RowOf { scene, row, all_rays: 0 }).collect()
}

const FOREIGN: &str = "foreign: another program. It reported its times itself, on its own hardware; \
                    its answers were checked from a file (`rtbench rays check`). It is in no \
                    ratio, mean or comparison.";

/// The rows of a scene that programs outside told, in a table of their own, so that nobody takes
/// their times for measured ones; none where there are none.
pub fn foreign_table(scene: &SceneRecord) -> Option<Table> {
    let columns = columns();
    let shown: Vec<_> = ["rays", "build ms", "trace ms", "verdict"]
        .into_iter()
        .filter_map(|head| column::headed(&columns, head))
        .collect();
    let mut header = vec!["program (foreign)"];
    header.extend(shown.iter().map(|column| column.head));
    header.push("Mrays/s");
    let all_rays = scene.distinct_rays();
    let mut notes = vec![FOREIGN.to_owned()];
    let rows: Vec<_> = scene
        .foreign
        .iter()
        .map(|row| {
            let of = RowOf { scene, row, all_rays };
            let example = row.example.as_ref().filter(|_| row.mismatches > 0);
            notes.extend(example.map(|example| format!("{}: {example}", row.label())));
            let mut cells = vec![row.label().into()];
            cells.extend(shown.iter().map(|column| column.cell(&of)));
            let rate = row.trace_s.map(|s| numbers::short(row.rays as f64 / s.median / 1e6));
            cells.push(rate.unwrap_or_else(|| "-".into()).into());
            cells
        })
        .collect();
    let title = format!("{}: foreign rows", scene.name);
    (!rows.is_empty()).then_some(Table { title, header, rows, notes })
}
