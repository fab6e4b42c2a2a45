//! Results of a check: counts, the table, and the exported record.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Display;

use serde::{Serialize, Serializer};

use super::answers::Digest;
use super::judge::{Difference, RoundVerdict};
use super::replay::{Replay, RoundSeed};
use super::subject::{CONTROL, Subject};
use measurement::answers::arbiter::EDGE_ULPS;
use measurement::settings::Precision;
use measurement::settings::choice::as_typed;
use presentation::column::{self, Column, Unit, Value};
use presentation::json;
use presentation::json::FormatError;
use presentation::table::{Cell, Style, Table};

/// Mismatches of a subject and case that are shown.
const SHOWN: usize = 3;

#[derive(Debug, Clone, Serialize)]
pub struct Example {
    #[serde(serialize_with = "as_text")]
    pub replay: Replay,
    /// The answer and the right one.
    pub what: String,
}

/// A case in a precision for one subject: counts of some rounds, or of all.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Line {
    pub group: &'static str,
    pub case: &'static str,
    #[serde(serialize_with = "as_typed::serialize")]
    pub precision: Precision,
    pub structure: String,
    /// Why its mismatches are no failure, if so.
    pub known_defect: Option<&'static str>,
    pub trials: u64,
    pub mismatches: u64,
    /// Answers that differ from those of brute force, by how they do.
    #[serde(flatten)]
    pub differences: BTreeMap<Difference, u64>,
    /// Rounds whose scene was refused with a typed error.
    pub refused: u64,
    /// Why the first of them was.
    pub reason: Option<String>,
    /// Rounds that were asked: all of them, unless the check was cut short.
    pub rounds: u64,
    /// Stands for all answers: the same on every instruction set.
    #[serde(serialize_with = "as_text")]
    pub answers: Digest,
    pub examples: Vec<Example>,
}

fn as_text<S: Serializer>(value: &impl Display, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(value)
}

impl Line {
    /// Of no round yet.
    pub fn new(
        group: &'static str,
        case: &'static str,
        precision: Precision,
        subject: &Subject<'_>,
    ) -> Self {
        Self {
            group,
            case,
            precision,
            structure: subject.label(),
            known_defect: subject.known_defect(),
            differences: Difference::ALL.map(|difference| (difference, 0)).into(),
            ..Self::default()
        }
    }

    /// Adds the verdict on so many rays of a round.
    pub fn count(&mut self, round: RoundSeed, rays: usize, verdict: RoundVerdict) {
        self.rounds += 1;
        match verdict {
            RoundVerdict::Asked(all, answers) => {
                self.trials += rays as u64;
                self.answers.add(answers.of_round(round.number));
                for mismatch in all {
                    if let Some(difference) = mismatch.difference {
                        *self.differences.entry(difference).or_default() += 1;
                    }
                    if !mismatch.is_wrong {
                        continue;
                    }
                    self.mismatches += 1;
                    if self.examples.len() < SHOWN {
                        let subject = self.structure.clone();
                        let replay = Replay { round, ray: mismatch.ray, subject };
                        self.examples.push(Example { replay, what: mismatch.what });
                    }
                }
            }
            RoundVerdict::Refused(why) => {
                self.refused += 1;
                self.reason.get_or_insert(why);
            }
            RoundVerdict::NotAsked => {}
        }
    }

    /// Adds the counts of later rounds.
    pub fn add(&mut self, later: Self) {
        self.trials += later.trials;
        self.mismatches += later.mismatches;
        for (difference, count) in later.differences {
            *self.differences.entry(difference).or_default() += count;
        }
        self.refused += later.refused;
        self.reason = self.reason.take().or(later.reason);
        self.rounds += later.rounds;
        self.answers.add(later.answers);
        self.examples.extend(later.examples);
        self.examples.truncate(SHOWN);
    }

    fn differing(&self, how: Difference) -> u64 {
        self.differences.get(&how).copied().unwrap_or_default()
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
        let mut listed = BTreeSet::new();
        let groups = self.lines.iter().map(|line| line.group);
        let groups: Vec<&'static str> = groups.filter(|group| listed.insert(*group)).collect();
        let row = |structure: &str| {
            let own = || self.lines.iter().filter(|line| line.structure == structure);
            let defect = own().find_map(|line| line.known_defect);
            let sum = |group: &&str| {
                let own = || own().filter(|line| line.group == *group);
                let (trials, wrong) =
                    (own().map(|line| line.trials).sum(), own().map(|line| line.mismatches).sum());
                sum_cell(trials, wrong, defect.is_some())
            };
            let mut cells: Vec<Cell> = vec![structure.to_owned().into()];
            cells.extend(groups.iter().map(sum));
            cells.push(defect.unwrap_or_default().to_owned().into());
            cells
        };
        let mut listed = BTreeSet::new();
        let structures = self.lines.iter().map(|line| line.structure.as_str());
        let structures = structures.filter(|structure| listed.insert(*structure));
        let title = match self.cut {
            None => "mismatches/trials".to_owned(),
            Some(cut) => format!("INCOMPLETE ({}): mismatches/trials", self.stop_text(cut)),
        };
        Table {
            title,
            header: ["structure"].into_iter().chain(groups.iter().copied()).chain([""]).collect(),
            rows: structures.map(row).collect(),
            notes: self.notes(),
        }
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
        let asked = self.lines.iter().filter(|line| line.known_defect.is_none());
        asked.for_each(|line| all.word(line.answers.0));
        all.to_string()
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
        use Difference::{Edge, Invented, LastBits, Lost, WrongId};
        let key = |line: &Line| (line.structure.clone(), line.precision.name());
        let is_tolerant = |line: &&Line| line.differences.values().sum::<u64>() > line.mismatches;
        let rows: BTreeSet<_> = self.lines.iter().filter(is_tolerant).map(key).collect();
        rows.into_iter().map(move |row| {
            let sum = |how| -> u64 {
                let own = self.lines.iter().filter(|line| key(line) == row);
                own.map(|line| line.differing(how)).sum()
            };
            format!(
                "{} has a primitive test of its own: in {} {} last bits of t, {} at edges (within \
                 {EDGE_ULPS} ulps of the scene's largest coordinate), which are not wrong; \
                 {} lost, {} invented, {} wrong ids",
                row.0,
                row.1,
                sum(LastBits),
                sum(Edge),
                sum(Lost),
                sum(Invented),
                sum(WrongId)
            )
        })
    }

    /// One note for all that were refused for the same reason: brute force refuses for all, a
    /// plugin of f32 all cases in f64.
    fn refusals(&self) -> impl Iterator<Item = String> {
        let mut who: BTreeMap<(&str, &str, u64, &str), Vec<&str>> = BTreeMap::new();
        for line in &self.lines {
            if let Some(why) = &line.reason {
                let said = (line.case, line.precision.name(), line.refused, why.as_str());
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
                let precision = precision.name();
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
        c(&["precision"], "", None, |line| Text(line.precision.name().to_owned())),
        c(&["structure"], "", None, |line| Text(line.structure.clone())),
        c(&["known_defect"], "", None, |line| Value::of(line.known_defect.map(str::to_owned), Text)),
        c(&["trials"], "", None, |line| Count(line.trials)),
        c(&["mismatches"], "", None, |line| Count(line.mismatches)),
        c(&["bound_95"], "", None, |line| {
            Value::of(bound(line.trials, line.mismatches).map(|b| format!("{b:.3e}")), Text)
        }),
        c(&["refused_rounds"], "", None, |line| Count(line.refused)),
        c(&["rounds"], "", None, |line| Count(line.rounds)),
        c(&["answers"], "", None, |line| Text(line.answers.to_string())),
        c(&["replay"], "", None, |line| Value::of(line.examples.first().map(|e| e.replay.to_string()), Text)),
        c(&["last_bits"], "", None, |line| Count(line.differing(Difference::LastBits))),
        c(&["at_edges"], "", None, |line| Count(line.differing(Difference::Edge))),
        c(&["lost"], "", None, |line| Count(line.differing(Difference::Lost))),
        c(&["invented"], "", None, |line| Count(line.differing(Difference::Invented))),
        c(&["wrong_id"], "", None, |line| Count(line.differing(Difference::WrongId))),
    ]
}

/// The 95% upper bound of the rate where nothing was found.
fn bound(trials: u64, mismatches: u64) -> Option<f64> {
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
