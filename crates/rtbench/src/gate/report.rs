//! Report of a check: its verdict, and tables of findings; as text, Markdown, CSV, and annotations of
//! GitHub Actions.

use std::fmt::Write as _;
use std::io::{self, Write};

use serde::Serialize;

use crate::comparison::differences::remarks;
use crate::comparison::pairing::{MissingRow, grouped, in_words};
use crate::error::{FAILURE, INCONCLUSIVE, NOTHING_COMPARED, REGRESSION, SUCCESS, WRONG_HITS};
use crate::gate::contest::{self, PairedTimes};
use crate::gate::evidence::{Evidence, Finding, GateOutcome, Stage, Times};
use crate::gate::thresholds::Thresholds;
use crate::gate::{STAGES, wall_clock};
use measurement::record::{FloorRecord, Machine, RowRecord, Tool, reference};
use presentation::column::{self, Column, Unit, Value};
use presentation::json::FormatError;
use presentation::markdown::{escaped, push_table};
use presentation::numbers;
use presentation::outside::{Annotation, line};
use presentation::table::{Cell, Style, Table};
use presentation::text::Screen;

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    pub tool: Tool,
    pub command_line: Vec<String>,
    pub against: String,
    /// The program that the baseline is of; none where it is no rtbench.
    pub baseline_tool: Option<Tool>,
    pub baseline_machine: Machine,
    pub machine: Machine,
    pub thresholds: Thresholds,
    /// The worst of all that was judged.
    pub outcome: GateOutcome,
    pub findings: Vec<Finding>,
    /// Rows that one side lacks and that are not allowed to be missing.
    pub missing: Vec<MissingRow>,
    pub remarks: Vec<String>,
    /// Description of the figures of times.
    pub times: String,
    /// Scenes that could not be measured.
    pub failures: usize,
    /// Difference of a copy of the program from it.
    pub floor: Option<FloorRecord>,
    /// Times of the turns, with `--against`.
    pub pairs: Vec<PairedTimes>,
}

/// Improvements that are named beside the tables.
const MOST_IMPROVEMENTS: usize = 10;

/// Columns of most weight: these stay where not all fit.
const FIRST: [&str; 5] = ["what", "change", "outcome", "now", "baseline"];

pub const GLOSSARY: &[&str] = &[
    "change: now over the baseline, with its 95% interval where it was measured; p: the \
     probability of such times without a difference, corrected for the number of tests (Holm \
     1979).",
    "regression: significantly worse by more than the threshold. unchanged: significantly within \
     it. inconclusive: none of these, and not significantly better.",
];

impl Report {
    /// Report of all that was judged, without what only the command knows. Where none of the rows
    /// that are `asked` about was built, nothing was judged: other rows do not answer for them.
    pub fn of(
        evidence: &Evidence<'_>,
        findings: Vec<Finding>,
        is_asked: impl Fn(&RowRecord) -> bool,
    ) -> Self {
        let Evidence { thresholds, base, now, .. } = evidence;
        let mut outcome = Self::worst(&findings);
        if evidence.is_unbuilt(is_asked) {
            outcome = outcome.max(GateOutcome::NotJudged);
        }
        let mut remarks = remarks(base, now);
        remarks.extend(thresholds.rows.iter().map(|own| format!("threshold of {own}")));
        let (times, floor, pairs) = match evidence.times {
            Times::Paired { pairs, .. } => ("seconds".into(), contest::floor(pairs), pairs.into()),
            Times::InRun { .. } => {
                let reference = reference::in_words(now);
                let times = format!("ratios to {reference} in the same rounds");
                (times, now.floor.clone(), Vec::new())
            }
        };
        Self {
            tool: now.tool.clone(),
            command_line: Vec::new(),
            against: String::new(),
            baseline_tool: Some(base.tool.clone()),
            baseline_machine: base.machine.clone(),
            machine: now.machine.clone(),
            thresholds: (*thresholds).clone(),
            outcome,
            findings,
            missing: Vec::new(),
            remarks,
            times,
            failures: 0,
            floor,
            pairs,
        }
    }

    /// Prints tables, remarks and, in the last line, the verdict.
    pub fn write(&self, out: &mut dyn Write, screen: Screen, all: bool) -> io::Result<()> {
        for table in self.tables(all) {
            if table.rows.is_empty() {
                screen.write_line(out, &table.title)?;
                screen.write_line(out, &table.notes.join(" "))?;
                writeln!(out)?;
            } else {
                screen.write_fitted(out, &table, &FIRST)?;
            }
        }
        for remark in in_words(&self.missing).iter().chain(&self.remarks) {
            screen.write_line(out, remark)?;
        }
        screen.write_notes(out, GLOSSARY)?;
        for improvement in self.improvements() {
            screen.write_line(out, &improvement)?;
        }
        // a script reads the last line
        writeln!(out, "{}", line(&self.verdict()))
    }

    /// The exit code: 4 for wrong hits, 1 where scenes failed, 3 for regressions, 6 where nothing
    /// could be judged, and if `strict` 5 where something is inconclusive or missing.
    pub fn exit_code(&self, strict: bool) -> u8 {
        match self.outcome {
            GateOutcome::WrongHits => WRONG_HITS,
            _ if self.failures > 0 => FAILURE,
            GateOutcome::Regression => REGRESSION,
            GateOutcome::NotJudged => NOTHING_COMPARED,
            GateOutcome::Inconclusive if strict => INCONCLUSIVE,
            _ if strict && !self.missing.is_empty() => INCONCLUSIVE,
            _ => SUCCESS,
        }
    }

    /// The worst of findings that were judged; without any, nothing was.
    pub fn worst(findings: &[Finding]) -> GateOutcome {
        let judged = findings.iter().map(|f| f.outcome).filter(|o| *o != GateOutcome::NotJudged);
        judged.max().unwrap_or(GateOutcome::NotJudged)
    }

    /// One line: what came of it.
    pub fn verdict(&self) -> String {
        let count = |outcome| self.findings.iter().filter(|f| f.outcome == outcome).count();
        use GateOutcome::{Improved, Inconclusive, NotJudged, Regression, Unchanged, WrongHits};
        let outcomes = [WrongHits, Regression, Inconclusive, Improved, Unchanged, NotJudged];
        let counts = outcomes.into_iter().filter(|outcome| count(*outcome) > 0);
        let counts = counts.map(|outcome| format!("{} {}", count(outcome), outcome.name()));
        let counts: Vec<String> = counts.collect();
        let missing = |is_new| self.missing.iter().filter(|row| row.is_new == is_new).count();
        let more = [
            (self.failures, "scenes failed"),
            (missing(false), "rows missing now"),
            (missing(true), "rows new"),
        ];
        let more = more.into_iter().filter(|(n, _)| *n > 0);
        let more: String = more.map(|(n, what)| format!("; {n} {what}")).collect();
        format!("check against {}: {}{more}", self.against, counts.join(", "))
    }

    /// Improvements beyond the threshold, largest first.
    pub fn improvements(&self) -> Vec<String> {
        let mut better: Vec<&Finding> =
            self.findings.iter().filter(|f| f.outcome == GateOutcome::Improved).collect();
        let change = |f: &Finding| f.change.map_or(1.0, |c| c.median);
        better.sort_by(|a, b| change(a).total_cmp(&change(b)));
        let line = |f: &&Finding| {
            let word = if f.stage == wall_clock::STAGE.name { "faster" } else { "less" };
            let change = change_in_words(f).unwrap_or_else(|| "-".to_owned());
            format!("{word}: {}, {}: {change}", f.place(), f.quantity)
        };
        let mut lines: Vec<String> = better.iter().take(MOST_IMPROVEMENTS).map(line).collect();
        if better.len() > lines.len() {
            lines.push(format!("and {} more in the tables", better.len() - lines.len()));
        }
        lines
    }

    /// One table per stage: what changed or could not be told, and with `all` the rest.
    pub fn tables(&self, all: bool) -> Vec<Table> {
        STAGES.iter().filter_map(|stage| self.table(stage, all)).collect()
    }

    fn table(&self, stage: &Stage, all: bool) -> Option<Table> {
        let own: Vec<&Finding> = self.findings.iter().filter(|f| f.stage == stage.name).collect();
        if own.is_empty() {
            return None;
        }
        let quiet = [GateOutcome::Unchanged, GateOutcome::NotJudged];
        let shown = |f: &&&Finding| all || !quiet.contains(&f.outcome);
        let rows = own.iter().filter(shown).copied();
        let count = |outcome| own.iter().filter(|f| f.outcome == outcome).count();
        let (unchanged, all_of_them) = (count(GateOutcome::Unchanged), own.len());
        let mut notes = vec![format!("{unchanged} of {all_of_them} unchanged.")];
        notes.extend(self.reasons(&own).filter(|_| !all));
        if stage.name == wall_clock::STAGE.name {
            notes.push(format!("baseline, now: {}.", self.times));
            notes.extend(self.floor.as_ref().map(FloorRecord::in_words));
        }
        let columns = columns();
        Some(Table {
            title: format!("{}: {}", stage.name, stage.summary),
            notes,
            ..column::table(&columns, &column::heads(&columns), rows)
        })
    }

    /// Why things were not judged, each reason once with its number.
    fn reasons(&self, own: &[&Finding]) -> impl Iterator<Item = String> {
        let not_judged = own.iter().filter(|f| f.outcome == GateOutcome::NotJudged);
        // `too short to time: 8.4 us` differs from row to row
        let reasons = not_judged.map(|f| (f.note.split(':').next().unwrap_or_default(), f));
        let line = |(reason, all): (&str, Vec<_>)| format!("{} not judged: {reason}.", all.len());
        grouped(reasons).into_iter().map(line)
    }
}

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

pub fn markdown(report: &Report, all: bool) -> String {
    let mut text =
        format!("# rtbench check: {}\n\n{}\n\n", report.outcome.name(), escaped(&report.verdict()));
    let improvements = report.improvements();
    for improvement in &improvements {
        let _ = writeln!(text, "- {}", escaped(improvement));
    }
    text += if improvements.is_empty() { "" } else { "\n" };
    for table in report.tables(all) {
        if table.rows.is_empty() {
            let (title, notes) = (escaped(&table.title), table.notes.join(" "));
            let _ = writeln!(text, "## {title}\n\n{}\n", escaped(&notes));
        } else {
            push_table(&mut text, &table);
        }
    }
    let missing = in_words(&report.missing);
    let remarks = missing.iter().chain(&report.remarks).map(|remark| escaped(remark));
    for line in remarks.chain(GLOSSARY.iter().map(|&line| line.to_owned())) {
        let _ = writeln!(text, "{line}\n");
    }
    text
}

/// One row for each thing judged.
pub fn csv(report: &Report) -> Result<String, FormatError> {
    column::csv(&columns(), &report.findings)
}

/// GitHub shows no more than that of a level in a step.
const MOST_ANNOTATIONS: usize = 10;

/// The annotations of a check: errors for regressions and wrong hits, warnings for what is
/// inconclusive.
pub fn annotations(report: &Report) -> Vec<Annotation> {
    let of = |level: &[GateOutcome]| -> Vec<&Finding> {
        let mut found: Vec<_> =
            report.findings.iter().filter(|f| level.contains(&f.outcome)).collect();
        found.sort_by_key(|f| std::cmp::Reverse(f.outcome));
        found
    };
    let mut annotations = Vec::new();
    for (level, found) in [
        ("error", of(&[GateOutcome::WrongHits, GateOutcome::Regression])),
        ("warning", of(&[GateOutcome::Inconclusive])),
    ] {
        let shown = if found.len() > MOST_ANNOTATIONS { MOST_ANNOTATIONS - 1 } else { found.len() };
        annotations.extend(found.iter().take(shown).map(|finding| Annotation {
            level,
            title: format!("rtbench check: {}", finding.outcome.name()),
            text: annotation_text(finding),
        }));
        if shown < found.len() {
            let text = format!("{} more; see the summary", found.len() - shown);
            annotations.push(Annotation { level, title: "rtbench check".into(), text });
        }
    }
    annotations.extend(in_words(&report.missing).into_iter().take(MOST_ANNOTATIONS).map(|text| {
        Annotation { level: "warning", title: "rtbench check: not compared".into(), text }
    }));
    annotations
}

fn annotation_text(finding: &Finding) -> String {
    let Finding { quantity, note, .. } = finding;
    let mut text = format!("{}: {quantity}", finding.place());
    if let Some(change) = finding.change {
        text += &format!(" {:+.2}%", (change.median - 1.0) * 100.0);
    }
    if !note.is_empty() {
        text += &format!(" ({note})");
    }
    text
}
