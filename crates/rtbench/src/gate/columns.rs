//! The columns of what was judged: one line each, from which tables and CSV come.

use crate::gate::evidence::{Finding, GateOutcome};
use presentation::column::{Column, Unit, Value};
use presentation::numbers;
use presentation::table::{Cell, Style};

/// All columns, in the order of the CSV file and of tables.
#[rustfmt::skip]
pub fn columns() -> [Column<Finding>; 10] {
    use Unit::{None, Ratio};
    use Value::{Measured, Real, Text};
    let c = Column::new;
    [
        c(&["stage"], "", None, |f: &Finding| Text(f.stage.to_owned())),
        c(&["scene"], "", None, |f| Text(f.scene.clone())),
        c(&["row"], "row", None, |f| Text(f.row.clone())).or(|f| Some(f.place().into())),
        c(&["what"], "what", None, |f| Text(f.quantity.to_owned())),
        c(&["baseline"], "baseline", None, |f| Value::of(f.baseline, Real)).or(|f| f.baseline.map(number)),
        c(&["now"], "now", None, |f| Value::of(f.now, Real)).or(|f| f.now.map(number)),
        c(&["change", "change_low", "change_high"], "change", Ratio, |f| Value::of(f.change, Measured))
            .or(|f| change_in_words(f).map(Cell::from)),
        // probabilities may be far smaller than nine digits show
        c(&["p"], "p", None, |f| Value::of(f.p.map(|p| format!("{p:e}")), Text))
            .or(|f| f.p.map(|p| format!("{p:.1e}").into())),
        c(&["outcome"], "outcome", None, |f| Text(f.outcome.name().to_owned())).or(|f| Some(outcome(f))),
        c(&["note"], "", None, |f| Text(f.note.clone())),
    ]
}

/// A change, where there is one: exact ones as a percentage, measured ones with their interval.
pub fn change_in_words(finding: &Finding) -> Option<String> {
    finding.change.map(|e| {
        if e.low == e.high {
            format!("{:+.3}%", (e.median - 1.0) * 100.0)
        } else {
            numbers::ratio(&e).trim_end().to_owned()
        }
    })
}

fn number(x: f64) -> Cell {
    if x.fract() == 0.0 && x.abs() < 1e15 {
        format!("{x:.0}").into()
    } else {
        numbers::short(x).into()
    }
}

fn outcome(finding: &Finding) -> Cell {
    let style = match finding.outcome {
        GateOutcome::WrongHits | GateOutcome::Regression => Style::Bad,
        GateOutcome::Improved => Style::Best,
        GateOutcome::NotJudged => Style::Dim,
        GateOutcome::Inconclusive | GateOutcome::Unchanged => Style::Plain,
    };
    let text = if finding.note.is_empty() {
        finding.outcome.name().to_owned()
    } else {
        format!("{}: {}", finding.outcome.name(), finding.note)
    };
    Cell { text, style }
}
