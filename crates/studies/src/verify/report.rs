//! Results of a check: counts, the table, and the exported record.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::answers::Digest;
use super::judge::{Difference, Mismatch, RoundVerdict};
use super::subject::{CONTROL, Replay, Subject};
use measurement::answers::arbiter::EDGE_ULPS;
use measurement::settings::Precision;
use presentation::column::{self, Column, Unit, Value};
use presentation::json;
use presentation::json::FormatError;
use presentation::table::{Cell, Style, Table};

/// Mismatches of a subject and case that are shown.
const SHOWN: usize = 3;

/// Counts of some rounds for one subject.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct SubjectCounts {
    trials: u64,
    mismatches: u64,
    differences: [u64; Difference::ALL.len()],
    refused: u64,
    pub rounds: u64,
    answers: Digest,
    /// Why the first of the refused rounds was.
    reason: Option<(u64, String)>,
    /// The first mismatches: round, ray and words.
    first: Vec<(u64, usize, String)>,
}

impl SubjectCounts {
    pub fn of(round: u64, rays: usize, judged: RoundVerdict) -> Self {
        match judged {
            RoundVerdict::Asked(wrong, answers) => Self {
                trials: rays as u64,
                mismatches: wrong.iter().filter(|m| m.is_wrong).count() as u64,
                differences: Difference::ALL.map(|(difference, _)| {
                    wrong.iter().filter(|m| m.difference == Some(difference)).count() as u64
                }),
                rounds: 1,
                answers: answers.of_round(round),
                first: wrong
                    .into_iter()
                    .filter(|m| m.is_wrong)
                    .take(SHOWN)
                    .map(|Mismatch { ray, what, .. }| (round, ray, what))
                    .collect(),
                ..Self::default()
            },
            RoundVerdict::Refused(why) => Self::refused(round, why),
            RoundVerdict::NotAsked => Self { rounds: 1, ..Self::default() },
        }
    }

    pub fn refused(round: u64, why: String) -> Self {
        Self { refused: 1, rounds: 1, reason: Some((round, why)), ..Self::default() }
    }

    /// Adds another; the order does not matter.
    pub fn add(&mut self, other: Self) {
        self.trials += other.trials;
        self.mismatches += other.mismatches;
        self.differences.iter_mut().zip(other.differences).for_each(|(sum, n)| *sum += n);
        self.refused += other.refused;
        self.rounds += other.rounds;
        self.answers.add(other.answers);
        self.reason = self.reason.take().into_iter().chain(other.reason).min();
        self.first.extend(other.first);
        self.first.sort();
        self.first.truncate(SHOWN);
    }
}

#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Example {
    pub replay: String,
    /// The answer and the right one.
    pub what: String,
}

/// A case in a precision for one subject.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Line {
    pub group: &'static str,
    pub case: &'static str,
    pub precision: &'static str,
    pub structure: String,
    /// Why its mismatches are no failure, if so.
    pub known_defect: Option<&'static str>,
    pub trials: u64,
    pub mismatches: u64,
    /// Answers that differ from those of brute force, by how they do.
    #[serde(flatten)]
    pub differences: BTreeMap<&'static str, u64>,
    /// Rounds whose scene was refused with a typed error.
    pub refused: u64,
    /// Why the first of them was.
    pub reason: Option<String>,
    /// Rounds that were asked: all of them, unless the check was cut short.
    pub rounds: u64,
    /// Stands for all answers: the same on every instruction set.
    pub answers: String,
    pub examples: Vec<Example>,
}

impl Line {
    /// From a tally; `replay` names a trial by round and ray.
    pub fn new(
        group: &'static str,
        case: &'static str,
        precision: Precision,
        subject: &Subject<'_>,
        tally: &SubjectCounts,
        replay: impl Fn(u64, usize) -> Replay,
    ) -> Self {
        let example = |(round, ray, what): &(u64, usize, String)| Example {
            replay: replay(*round, *ray).to_string(),
            what: what.clone(),
        };
        let names = Difference::ALL.into_iter().map(|(_, name)| name);
        Self {
            group,
            case,
            precision: precision.name(),
            structure: subject.label(),
            known_defect: subject.known_defect(),
            trials: tally.trials,
            mismatches: tally.mismatches,
            differences: names.zip(tally.differences).collect(),
            refused: tally.refused,
            reason: tally.reason.as_ref().map(|(_, why)| why.clone()),
            rounds: tally.rounds,
            answers: format!("{:016x}", tally.answers.0),
            examples: tally.first.iter().map(example).collect(),
        }
    }

    fn count(&self, difference: &str) -> Value {
        Value::Count(self.differences.get(difference).copied().unwrap_or_default())
    }

    pub fn is_failure(&self) -> bool {
        self.mismatches > 0 && self.known_defect.is_none()
    }
}

/// Why a check ended before all was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    Interrupted(usize),
    OutOfTime,
}

#[derive(Debug, Clone, Default, Serialize)]
pub struct Report {
    pub command_line: Vec<String>,
    pub seed: u64,
    /// Rays a case and precision.
    pub rays: usize,
    pub seconds: f64,
    /// Why it ended before all was asked, if so.
    pub cut: Option<StopReason>,
    /// Rounds of a complete check: one per case and precision.
    pub rounds: u64,
    pub rounds_asked: u64,
    /// One line per case, precision and subject.
    pub lines: Vec<Line>,
}

impl Report {
    /// True when a line fails, or when the control was asked and missed nothing.
    pub fn is_failure(&self) -> bool {
        self.lines.iter().any(Line::is_failure) || self.is_powerless()
    }

    /// True when the control was asked about a closed mesh and missed nothing: then nothing is
    /// proved about watertightness.
    pub fn is_powerless(&self) -> bool {
        let mut asked = self.lines.iter().filter(|l| l.structure == CONTROL && l.case == "G1");
        asked.clone().any(|l| l.trials >= 1000) && asked.all(|l| l.mismatches == 0)
    }

    /// Structures down, groups across: mismatches of trials, and what none of them bounds.
    pub fn table(&self) -> Table {
        let mut groups: Vec<&'static str> = Vec::new();
        let mut structures: Vec<&str> = Vec::new();
        let mut sums: BTreeMap<(&str, &str), (u64, u64)> = BTreeMap::new();
        for line in &self.lines {
            if !groups.contains(&line.group) {
                groups.push(line.group);
            }
            if !structures.contains(&line.structure.as_str()) {
                structures.push(&line.structure);
            }
            let sum = sums.entry((&line.structure, line.group)).or_default();
            *sum = (sum.0 + line.trials, sum.1 + line.mismatches);
        }
        let rows = structures.iter().map(|&name| {
            let defect =
                self.lines.iter().find(|l| l.structure == name).and_then(|l| l.known_defect);
            let mut cells: Vec<Cell> = vec![name.to_owned().into()];
            cells.extend(groups.iter().map(|&group| {
                let (trials, wrong) = sums.get(&(name, group)).copied().unwrap_or_default();
                sum_cell(trials, wrong, defect.is_some())
            }));
            cells.push(defect.unwrap_or_default().to_owned().into());
            cells
        });
        let rows = rows.collect();
        let header = ["structure"].into_iter().chain(groups.iter().copied()).chain([""]).collect();
        let title = match self.cut {
            None => "mismatches/trials".to_owned(),
            Some(cut) => format!("INCOMPLETE ({}): mismatches/trials", self.stop_text(cut)),
        };
        Table { title, header, rows, notes: self.notes() }
    }

    /// How it ended, and how far it came.
    fn stop_text(&self, cut: StopReason) -> String {
        let why = match cut {
            StopReason::Interrupted(signal) => format!("interrupted by signal {signal}"),
            StopReason::OutOfTime => "out of time".to_owned(),
        };
        format!("{why} after {} of {} rounds", self.rounds_asked, self.rounds)
    }

    /// Stands for all answers but those of rows with a known defect, which may differ by machine.
    pub fn answers(&self) -> String {
        let mut all = Digest::default();
        let asked = self.lines.iter().filter(|l| l.known_defect.is_none());
        let digests = asked.map(|l| u64::from_str_radix(&l.answers, 16).unwrap_or_default());
        digests.for_each(|digest| all.word(digest));
        format!("{:016x}", all.0)
    }

    fn notes(&self) -> Vec<String> {
        let mut notes = vec![
            "<x: no mismatch; its rate is below x with 95% confidence (3/trials)".to_owned(),
            format!("answers {}: the same for every instruction set", self.answers()),
        ];
        if self.is_powerless() {
            notes.push("the negative control missed nothing: this run proves nothing".into());
        }
        notes.extend(self.by_own_tests());
        notes.extend(self.refusals());
        notes
    }

    /// How the answers of each row with a primitive test of its own differ from ours, by precision.
    fn by_own_tests(&self) -> impl Iterator<Item = String> {
        let mut rows: BTreeMap<_, [u64; Difference::ALL.len()]> = BTreeMap::new();
        let key = |line: &Line| (line.structure.clone(), line.precision);
        let is_tolerant = |line: &&Line| line.differences.values().sum::<u64>() > line.mismatches;
        let names: BTreeSet<_> = self.lines.iter().filter(is_tolerant).map(key).collect();
        for line in self.lines.iter().filter(|line| names.contains(&key(line))) {
            let sums = rows.entry(key(line)).or_default();
            for (sum, (_, name)) in sums.iter_mut().zip(Difference::ALL) {
                *sum += line.differences.get(name).copied().unwrap_or_default();
            }
        }
        rows.into_iter().map(|((row, precision), [bits, edges, lost, invented, ids])| {
            format!(
                "{row} has a primitive test of its own: in {precision} {bits} last bits of t, \
                 {edges} at edges (within {EDGE_ULPS} ulps of the scene's largest coordinate), \
                 which are not wrong; {lost} lost, {invented} invented, {ids} wrong ids"
            )
        })
    }

    /// One note for all that were refused for the same reason: brute force refuses for all, a
    /// plugin of f32 all cases in f64.
    fn refusals(&self) -> impl Iterator<Item = String> {
        let mut who: BTreeMap<(&str, &str, u64, &str), Vec<&str>> = BTreeMap::new();
        for line in &self.lines {
            if let Some(why) = &line.reason {
                let said = (line.case, line.precision, line.refused, why.as_str());
                who.entry(said).or_default().push(&line.structure);
            }
        }
        let mut what: BTreeMap<(String, &str), (u64, Vec<String>)> = BTreeMap::new();
        for ((case, precision, rounds, why), structures) in who {
            let who = match structures.as_slice() {
                [one] => (*one).to_owned(),
                many => format!("{} structures", many.len()),
            };
            let (sum, cases) = what.entry((who, why)).or_default();
            *sum += rounds;
            cases.push(format!("{case} {precision}"));
        }
        what.into_iter().map(|((who, why), (rounds, cases))| {
            format!("{} {who}: {rounds} rounds refused: {why}", cases.join(", "))
        })
    }

    /// The first mismatches of each line, and how many more there are.
    pub fn examples(&self) -> Vec<String> {
        let mut told = Vec::new();
        for line in &self.lines {
            let known = if line.known_defect.is_some() { " (known)" } else { "" };
            for Example { replay, what } in &line.examples {
                told.push(format!("rtbench verify --replay '{replay}'{known}: {what}"));
            }
            let more = line.mismatches.saturating_sub(line.examples.len() as u64);
            if more > 0 {
                let Line { case, precision, structure, .. } = line;
                told.push(format!("... {case} {precision} {structure}{known}: {more} more"));
            }
        }
        told
    }

    pub fn to_csv(&self) -> Result<String, FormatError> {
        column::csv(&columns(), &self.lines)
    }

    pub fn to_json(&self) -> Result<String, FormatError> {
        json::written(self)
    }
}

#[rustfmt::skip]
fn columns() -> [Column<Line>; 17] {
    use Unit::None;
    use Value::{Count, Text};
    let c = Column::new;
    [
        c(&["group"], "", None, |line: &Line| Text(line.group.to_owned())),
        c(&["case"], "", None, |line| Text(line.case.to_owned())),
        c(&["precision"], "", None, |line| Text(line.precision.to_owned())),
        c(&["structure"], "", None, |line| Text(line.structure.clone())),
        c(&["known_defect"], "", None, |line| Value::of(line.known_defect.map(str::to_owned), Text)),
        c(&["trials"], "", None, |line| Count(line.trials)),
        c(&["mismatches"], "", None, |line| Count(line.mismatches)),
        c(&["bound_95"], "", None, |line| {
            Value::of(bound(line.trials, line.mismatches).map(|b| format!("{b:.3e}")), Text)
        }),
        c(&["refused_rounds"], "", None, |line| Count(line.refused)),
        c(&["rounds"], "", None, |line| Count(line.rounds)),
        c(&["answers"], "", None, |line| Text(line.answers.clone())),
        c(&["replay"], "", None, |line| Value::of(line.examples.first().map(|e| e.replay.clone()), Text)),
        c(&["last_bits"], "", None, |line| line.count("last_bits")),
        c(&["at_edges"], "", None, |line| line.count("at_edges")),
        c(&["lost"], "", None, |line| line.count("lost")),
        c(&["invented"], "", None, |line| line.count("invented")),
        c(&["wrong_id"], "", None, |line| line.count("wrong_id")),
    ]
}

/// The 95% upper bound of the rate where nothing was found.
pub fn bound(trials: u64, mismatches: u64) -> Option<f64> {
    (trials > 0 && mismatches == 0).then(|| 3.0 / trials as f64)
}

fn sum_cell(trials: u64, mismatches: u64, is_known: bool) -> Cell {
    if trials == 0 {
        return "-".to_owned().into();
    }
    let sum = format!("{mismatches}/{trials}");
    match bound(trials, mismatches) {
        Some(bound) => format!("{sum} <{bound:.0e}").into(),
        None => Cell { text: sum, style: if is_known { Style::Dim } else { Style::Bad } },
    }
}
