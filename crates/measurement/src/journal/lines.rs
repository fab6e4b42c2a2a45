//! The lines of a journal, and what can be recovered from them.
//!
//! A journal is text of one JSON value a line. Lines are only ever appended, each with one write
//! and a synchronisation, so whatever ends the program, a journal is whole lines and at most one
//! torn line behind them, which is cut off. Lines that only say how far a scene is are not
//! synchronised: they outlive the program, not the machine. The unit that can be finished is a
//! scene: its rows are measured in interleaved rounds, so that all of them end together. Each line
//! has a checksum ([`seal`](crate::journal::seal)), and what it says must fit the manifest.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::journal::seal::Seal;
use crate::record::{Compiler, Machine, RowRecord, SCHEMA_VERSION, SceneRecord, Settings, Tool};
use crate::settings::RunSettings;
use presentation::json::FormatError;

/// Identity of a run: runs whose manifests agree may be parts of one.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    pub schema_version: u32,
    pub tool: Tool,
    /// Hash of the program's file, where it can be read.
    pub program_sha256: Option<String>,
    pub compiler: Compiler,
    pub machine: Machine,
    pub settings: Settings,
    pub rounds: String,
    pub scenes: Vec<String>,
    pub rows: Vec<String>,
    /// The request of the user, by which the run is resumed. Earlier versions kept the arguments.
    #[serde(default)]
    pub asked: Option<RunSettings>,
    #[serde(default)]
    pub plugins: Vec<String>,
    /// The files that it was begun with, beside those in its folder.
    #[serde(default)]
    pub exports: Vec<String>,
    /// The command line, program first, as shown.
    pub command_line: Vec<String>,
    /// When it began, seconds since 1970.
    pub started_unix_s: u64,
}

/// A line; a scene is given by its place among those of the manifest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Line {
    Begun(Box<Manifest>),
    Scene(usize),
    /// The row with that label is begun in the scene: it is built and checked, timed for the first
    /// time, or renders its image.
    Row(String),
    /// The rows begun so far ended well.
    Passed,
    /// All rows of a scene.
    Finished {
        scene: usize,
        record: Box<SceneRecord>,
    },
    Failed {
        scene: usize,
        error: String,
    },
    /// A signal ended the program: its number.
    Interrupted(i32),
    /// Every scene had its turn.
    Complete,
}

impl Line {
    /// Its text, before it is sealed.
    pub fn text(&self) -> Result<String, FormatError> {
        Ok(serde_json::to_string(self)?)
    }
}

/// Why a journal cannot be read. Lines are counted from 1.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LineError {
    #[error("no complete line: the run had not started")]
    Empty,
    #[error("line {line}: {message}")]
    Damaged { line: usize, message: String },
    #[error("written with schema {found}, expected {SCHEMA_VERSION}")]
    Schema { found: u32 },
}

#[derive(Debug, Clone, PartialEq)]
pub struct FinishedScene {
    /// Its line in the journal, counted from 1.
    pub line: usize,
    pub record: SceneRecord,
}

/// How often the program died while a row was begun: by a scene's place in the manifest and the
/// row's label; without a label, before the scene's first row.
pub type DeathCounts = BTreeMap<(usize, Option<String>), usize>;

#[derive(Debug, Clone, PartialEq)]
pub struct RecoveredRun {
    pub manifest: Manifest,
    pub seal: Seal,
    /// The finished scenes, by their places among the scenes of the manifest.
    pub finished: BTreeMap<usize, FinishedScene>,
    /// Every scene had its turn.
    pub is_complete: bool,
    /// The scene in which the program died: killed, or out of memory.
    pub died_in: Option<usize>,
    pub deaths: DeathCounts,
    /// Bytes of whole lines; what comes behind is torn.
    pub whole: usize,
}

/// Reads a journal. A last line without its line break is torn: it counts as never written.
pub fn read(bytes: &[u8]) -> Result<RecoveredRun, LineError> {
    let whole = bytes.iter().rposition(|&b| b == b'\n').map_or(0, |last| last + 1);
    let text = bytes.get(..whole).unwrap_or_default();
    let mut lines = text.split_inclusive(|&b| b == b'\n').enumerate();
    let damaged = |i: usize, message: &dyn std::fmt::Display| LineError::Damaged {
        line: i + 1,
        message: message.to_string(),
    };
    let (_, first) = lines.next().ok_or(LineError::Empty)?;
    // The version first: other versions may have other fields.
    if let Some(found) = schema_of(first).filter(|&found| found != SCHEMA_VERSION) {
        return Err(LineError::Schema { found });
    }
    let opened = |i: usize, line: &[u8], seal: &Seal| -> Result<String, LineError> {
        let line = std::str::from_utf8(line).map_err(|e| damaged(i, &e))?;
        Ok(seal.opened(line).map_err(|e| damaged(i, &e))?.to_owned())
    };
    let first = opened(0, first, &Seal::default())?;
    let manifest = match serde_json::from_str(&first).map_err(|e| damaged(0, &e))? {
        Line::Begun(manifest) => *manifest,
        _ => return Err(damaged(0, &"expected the manifest of a run")),
    };
    let mut found = RecoveredRun {
        manifest,
        seal: Seal::behind(&first),
        finished: BTreeMap::new(),
        is_complete: false,
        died_in: None,
        deaths: BTreeMap::new(),
        whole,
    };
    let mut begun: Option<(usize, Option<String>)> = None;
    for (i, line) in lines {
        let text = opened(i, line, &found.seal)?;
        let line: Line = serde_json::from_str(&text).map_err(|e| damaged(i, &e))?;
        let scenes = found.manifest.scenes.len();
        if let Line::Scene(scene) | Line::Finished { scene, .. } | Line::Failed { scene, .. } =
            &line
            && *scene >= scenes
        {
            return Err(damaged(i, &format!("scene {scene} of {scenes}")));
        }
        // where the run goes on with a scene, what it had begun before never ended
        if let (Line::Scene(_), Some(begun)) =
            (&line, begun.take_if(|_| !matches!(line, Line::Row(_))))
        {
            *found.deaths.entry(begun).or_default() += 1;
        }
        match line {
            Line::Begun(_) => return Err(damaged(i, &"a second manifest")),
            Line::Scene(scene) => {
                found.died_in = Some(scene);
                found.is_complete = false;
                begun = Some((scene, None));
            }
            Line::Row(label) => {
                let scene = found.died_in.ok_or_else(|| damaged(i, &"a row of no scene"))?;
                if !found.manifest.rows.contains(&label) {
                    return Err(damaged(i, &format!("the run has no row {label}")));
                }
                begun = Some((scene, Some(label)));
            }
            Line::Passed => {}
            Line::Finished { scene, record } => {
                found.manifest.holds(scene, &record).map_err(|e| damaged(i, &e))?;
                let finished = FinishedScene { line: i + 1, record: *record };
                if found.finished.insert(scene, finished).is_some() {
                    return Err(damaged(i, &format!("scene {scene} is finished twice")));
                }
                found.died_in = None;
            }
            Line::Failed { scene, .. } => {
                found.died_in = None;
                // that was said: it is tried again
                found.deaths.remove(&(scene, None));
            }
            Line::Interrupted(_) => found.died_in = None,
            Line::Complete => found.is_complete = true,
        }
    }
    if let Some(begun) = begun {
        *found.deaths.entry(begun).or_default() += 1;
    }
    Ok(found)
}

/// The version in a manifest, whatever else it holds.
fn schema_of(line: &[u8]) -> Option<u32> {
    let value: Value = serde_json::from_slice(line).ok()?;
    let line = value.get("line").unwrap_or(&value);
    line.pointer("/begun/schema_version")?.as_u64()?.try_into().ok()
}

impl Manifest {
    /// Differences to another manifest, as `name: was ..., is ...`; empty if the runs may be parts
    /// of one.
    pub fn differences(&self, now: &Self) -> Vec<String> {
        // the parts of one run may differ in these
        let now = Self {
            asked: self.asked.clone(),
            exports: self.exports.clone(),
            command_line: self.command_line.clone(),
            started_unix_s: self.started_unix_s,
            ..now.clone()
        };
        let mut differences = Vec::new();
        if let (Ok(was), Ok(is)) = (serde_json::to_value(self), serde_json::to_value(&now)) {
            compare("", &was, &is, &mut differences);
        }
        differences
    }

    /// Checks that a record can be that of the scene at a place: it has its name, and rows of
    /// the run.
    fn holds(&self, scene: usize, record: &SceneRecord) -> Result<(), String> {
        if let Some(name) = self.scenes.get(scene).filter(|name| **name != record.name) {
            return Err(format!("scene {scene} is {name}, its record is of {}", record.name));
        }
        let mut left: BTreeMap<&str, usize> = BTreeMap::new();
        for label in &self.rows {
            *left.entry(label).or_default() += 1;
        }
        let name = &record.name;
        for label in record.rows.iter().map(RowRecord::label) {
            match left.get_mut(&*label) {
                Some(count) if *count > 0 => *count -= 1,
                _ => return Err(format!("scene {name}: the run has no further row {label}")),
            }
        }
        Ok(())
    }
}

/// Appends each field in which two values differ, as `name: was ..., is ...`.
pub(crate) fn compare(name: &str, was: &Value, is: &Value, differences: &mut Vec<String>) {
    if let (Value::Object(was), Value::Object(is)) = (was, is) {
        for (key, value) in was {
            let name = if name.is_empty() { key.clone() } else { format!("{name}.{key}") };
            // counts what the kernel leaves over: no two boots agree
            if name != "machine.memory_bytes" {
                compare(&name, value, is.get(key).unwrap_or(&Value::Null), differences);
            }
        }
    } else if was != is {
        differences.push(format!("{name}: was {was}, is {is}"));
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::record::made_up;

    pub(in crate::journal) fn manifest() -> Manifest {
        let run = made_up::run(&[]);
        Manifest {
            schema_version: SCHEMA_VERSION,
            tool: run.tool,
            program_sha256: Some("ab".into()),
            compiler: run.compiler,
            machine: run.machine,
            settings: run.settings,
            rounds: "Fixed(3)".into(),
            scenes: vec!["a".into(), "b".into()],
            rows: vec!["x".into()],
            asked: None,
            plugins: Vec::new(),
            exports: Vec::new(),
            command_line: Vec::new(),
            started_unix_s: 0,
        }
    }

    fn text(lines: &[Line]) -> Vec<u8> {
        let mut seal = Seal::default();
        let mut text = String::new();
        for (i, line) in lines.iter().enumerate() {
            let line = serde_json::to_string(line).unwrap();
            text += &(seal.sealed(&line) + "\n");
            if i == 0 {
                seal = Seal::behind(&line);
            }
        }
        text.into_bytes()
    }

    #[test]
    fn every_cut_is_its_whole_lines() {
        let begun = Line::Begun(Box::new(manifest()));
        let failed = Line::Failed { scene: 0, error: "no".into() };
        let lines = [begun, Line::Scene(0), failed, Line::Scene(1)];
        let bytes = text(&lines);
        let ends: Vec<usize> = (1..=lines.len()).map(|n| text(&lines[..n]).len()).collect();
        for cut in 0..bytes.len() {
            let whole = ends.iter().copied().filter(|&end| end <= cut).max();
            match (read(&bytes[..cut]), whole) {
                (Ok(found), Some(whole)) => assert_eq!(found.whole, whole),
                (Err(error), None) => assert_eq!(error, LineError::Empty),
                other => panic!("{cut}: {other:?}"),
            }
        }
        assert_eq!(read(&bytes).unwrap().died_in, Some(1));
    }

    #[test]
    fn damage_in_the_middle_is_an_error_that_names_the_line() {
        let begun = || Line::Begun(Box::new(manifest()));
        for (lines, line) in [
            (vec![Line::Complete], 1),
            (vec![begun(), begun()], 2),
            (vec![begun(), Line::Scene(0), Line::Scene(2)], 3),
        ] {
            let error = read(&text(&lines)).unwrap_err();
            assert!(matches!(error, LineError::Damaged { line: l, .. } if l == line), "{error}");
        }
        for edited in 0..3 {
            let whole = text(&[begun(), Line::Scene(0), Line::Complete]);
            let mut lines: Vec<_> = whole.split_inclusive(|&b| b == b'\n').map(Vec::from).collect();
            let last = lines[edited].len() - 4;
            lines[edited][last] ^= 1;
            let error = read(&lines.concat()).unwrap_err();
            assert!(error.to_string().contains(&format!("line {}: ", edited + 1)), "{error}");
        }
        let mut bytes = text(&[begun(), Line::Scene(0), Line::Complete]);
        let middle = text(&[begun()]).len() + 2;
        bytes[middle] = 0;
        assert!(matches!(read(&bytes), Err(LineError::Damaged { line: 2, .. })));
        let old = Manifest { schema_version: 0, ..manifest() };
        let error = read(&text(&[Line::Begun(Box::new(old))])).unwrap_err();
        assert_eq!(error, LineError::Schema { found: 0 });
    }

    #[test]
    fn differences_are_named() {
        let was = manifest();
        let mut now = manifest();
        now.started_unix_s = 5;
        now.machine.memory_bytes = None;
        assert!(was.differences(&now).is_empty());
        now.settings.seed = 2;
        now.program_sha256 = None;
        now.scenes.pop();
        let said = was.differences(&now).join("; ");
        for part in ["settings.seed: was 1, is 2", "program_sha256: was", "scenes: was"] {
            assert!(said.contains(part), "{said}");
        }
    }
}
