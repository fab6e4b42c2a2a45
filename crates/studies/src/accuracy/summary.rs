//! What to take on each axis, what that costs, and what is wrong otherwise.

use std::fmt::Write;

use crate::accuracy::cost_tables;
use crate::accuracy::record::{AccuracyRecord, AxisRecord, ErrorOf, VariantRecord};
use crate::accuracy::report::{push_facts, push_table};
use presentation::markdown::escaped;
use presentation::numbers::short;
use presentation::table::Table;
use statistics::estimate::Estimate;
use statistics::series::{Series, geometric_mean_of};

/// A variant on all scenes of an axis.
struct OverScenes<'a> {
    name: &'a str,
    /// Its rows, scene by scene.
    rows: Vec<&'a VariantRecord>,
    /// Mean error, in the unit of [`ErrorOf::value`].
    error: f64,
    /// Geometric mean of its time over that of the cheapest of each scene.
    ratio: f64,
}

impl<'a> OverScenes<'a> {
    /// Variants that every scene of the axis has.
    fn all(axis: &'a AxisRecord) -> Vec<Self> {
        let names = axis.scenes.first().into_iter().flat_map(|scene| &scene.rows);
        let of = |name: &'a str| {
            let row = |rows: &'a [VariantRecord]| rows.iter().find(|row| row.variant == name);
            let rows: Vec<_> =
                axis.scenes.iter().map(|scene| row(&scene.rows)).collect::<Option<_>>()?;
            let mean = |value: fn(&VariantRecord) -> f64| {
                rows.iter().map(|row| value(row)).sum::<f64>() / rows.len() as f64
            };
            let error = mean(|row| row.error.value());
            let ratio = mean(|row| row.ratio.median.ln()).exp();
            Some(Self { name, rows, error, ratio })
        };
        names.filter(|row| !row.is_without).filter_map(|row| of(&row.variant)).collect()
    }

    fn error_in_words(&self) -> String {
        match self.rows.first().map(|row| row.error) {
            Some(ErrorOf::Rmse { .. }) => format!("{}: error {:.1e}", self.name, self.error),
            _ => format!("{}: {} wrong in 10^6", self.name, short(self.error)),
        }
    }
}

/// A line for each axis and structure: the variant to take, which is the most accurate one, and of
/// equally accurate ones the fastest; of samples no number is the right one.
pub fn advice(run: &AccuracyRecord) -> Table {
    let axes = run.axes.iter().flat_map(AxisRecord::by_subject);
    let rows = axes.filter_map(|axis| {
        let cells = advice_of(&axis, run.seed)?;
        Some([axis.axis].into_iter().chain(cells).map(Into::into).collect())
    });
    Table {
        title: "What to take: the most accurate variant, over all scenes".into(),
        header: vec!["axis", "take", "costs", "else"],
        rows: rows.collect(),
        notes: vec![
            "costs: time over that of the cheapest variant, with its 95% interval; else: the most \
             wrong of the others, mean error over the scenes."
                .into(),
        ],
    }
}

fn advice_of(axis: &AxisRecord, seed: u64) -> Option<[String; 3]> {
    let variants = OverScenes::all(axis);
    let by_error = |a: &&OverScenes<'_>, b: &&OverScenes<'_>| {
        a.error.total_cmp(&b.error).then(a.ratio.total_cmp(&b.ratio))
    };
    let best = variants.iter().min_by(by_error)?;
    let worst = variants.iter().max_by(by_error)?;
    let cheapest = variants.iter().min_by(|a, b| a.ratio.total_cmp(&b.ratio))?;
    if worst.error == best.error {
        let slower = short(worst.ratio / best.ratio);
        let slower = format!("{} takes {slower} times as long", worst.name);
        return Some([best.name.into(), "nothing: all answers are the same".into(), slower]);
    }
    let is_sampled = best.rows.iter().all(|row| matches!(row.error, ErrorOf::Rmse { .. }));
    if is_sampled && best.error > 0.0 {
        // the error falls with a power of the time
        let power = (best.ratio / cheapest.ratio).ln() / (cheapest.error / best.error).ln();
        let half = format!("half the error takes {:.1} times as long", 2.0_f64.powf(power));
        return Some(["as few as the image allows".into(), half, worst.error_in_words()]);
    }
    let costs = if best.name == cheapest.name {
        "nothing: it is the cheapest".to_owned()
    } else {
        let pairs = axis.scenes.iter().zip(best.rows.iter().zip(&cheapest.rows));
        let ratios = pairs.map(|(scene, (best, of))| scene.ratios(&best.seconds, &of.seconds));
        let ratios: Vec<Series> = ratios.collect();
        more(&geometric_mean_of(&ratios, seed)?)
    };
    Some([best.name.into(), costs, worst.error_in_words()])
}

/// A cost in percent, or as a factor where it is large.
fn more(e: &Estimate) -> String {
    if e.median < 2.0 {
        let Estimate { median, low, high } = e.map(|x| (x - 1.0) * 100.0);
        return format!("{median:+.1}% [{low:.1}, {high:.1}]");
    }
    format!("{:.2} x [{:.2}, {:.2}]", e.median, e.low, e.high)
}

pub fn to_markdown(run: &AccuracyRecord) -> String {
    let mut text = String::from("# What accuracy costs in time\n\n");
    push_facts(&mut text, run);
    push_table(&mut text, &advice(run));
    for axis in &run.axes {
        let steps =
            axis.scenes.iter().filter_map(|scene| cost_tables::steps(axis, scene, run.seed));
        for table in cost_tables::over_scenes(axis, run.seed).into_iter().chain(steps) {
            push_table(&mut text, &table);
        }
    }
    if let Some(table) = cost_tables::effects(run) {
        push_table(&mut text, &table);
    }
    let faults = run.scenes().flat_map(|(axis, scene)| {
        scene.faults.iter().map(|fault| format!("{} on {}: {fault}", axis.axis, scene.scene))
    });
    let faults: Vec<String> = faults.map(|fault| format!("* {}\n", escaped(&fault))).collect();
    if !faults.is_empty() {
        let _ = writeln!(text, "## Faults: these figures are invalid\n\n{}", faults.concat());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accuracy::record::made_up::{axis, record, row};

    fn advised(rows: Vec<VariantRecord>) -> Vec<String> {
        let table = advice(&record(vec![axis(rows)]));
        table.rows[0].iter().map(|cell| cell.text.clone()).collect()
    }

    #[test]
    fn the_most_accurate_variant_is_advised_with_its_price() {
        let cells = advised(vec![row("leaky", 2.0, 71), row("watertight", 2.2, 0)]);
        let expected =
            ["triangle-test", "watertight", "+10.0% [10.0, 10.0]", "leaky: 71.0 wrong in 10^6"];
        assert_eq!(cells, expected);
        let cells = advised(vec![row("leaky", 2.0, 71), row("a", 6.0, 0), row("b", 5.0, 0)]);
        assert_eq!(cells[1..3], ["b", "2.50 x [2.50, 2.50]"]);
        let cells = advised(vec![row("leaky", 3.0, 71), row("watertight", 2.0, 0)]);
        assert_eq!(cells[1..3], ["watertight", "nothing: it is the cheapest"]);
        let cells = advised(vec![row("none", 3.0, 0), row("hash", 2.0, 0)]);
        assert_eq!(cells[3], "none takes 1.50 times as long");
        // what is there without any variant is none to take
        let without = VariantRecord { is_without: true, ..row("left out", 1.0, 0) };
        assert_eq!(advised(vec![without, row("exact", 2.0, 5)])[1], "exact");
    }

    #[test]
    fn of_samples_no_number_is_advised() {
        let of = |name: &str, seconds, rmse| VariantRecord {
            error: ErrorOf::Rmse { rmse },
            ..row(name, seconds, 1)
        };
        let cells = advised(vec![of("1", 2.0, 0.08), of("16", 32.0, 0.02)]);
        assert_eq!(cells[2], "half the error takes 4.0 times as long");
        assert_eq!(cells[3], "1: error 8.0e-2");
    }
}
