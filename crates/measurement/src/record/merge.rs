//! Joining the parts of a run that `--shard` made, as if one machine had made all of it.
//!
//! A part is checked before anything of it is used: all of them must be there, once, finished, of
//! the same program, machine, settings and scenes; whatever is wrong with any of them is listed.
//! Rows keep the ratios and rounds of the part that measured them. The reference row, which every
//! part measured, is taken from the first part that has the scene; its counters must agree in all.

use std::path::PathBuf;

use serde_json::{Value, json};

use crate::journal::lines::compare;
use crate::record::file::RecordError;
use crate::record::summary::summarize;
use crate::record::{Machine, PartRecord, RowRecord, RunRecord, SceneRecord};
use crate::settings::shard::ShardRecord;

/// The parts cannot be joined.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("the shards do not belong to one run:{}",
        problems.iter().map(|problem| format!("\n  {problem}")).collect::<String>())]
pub struct MergeError {
    pub problems: Vec<String>,
}

/// A part and where it was read from.
#[derive(Debug, Clone)]
pub struct PartialRun {
    pub path: PathBuf,
    pub record: RunRecord,
}

/// Joins parts, read or not, in any order. `mixed` allows parts of different machines. The result
/// has everything but a command line of its own.
pub fn merge(
    parts: Vec<Result<PartialRun, RecordError>>,
    mixed: bool,
) -> Result<RunRecord, MergeError> {
    let mut problems = Vec::new();
    let mut sharded: Vec<(ShardRecord, PartialRun)> = Vec::new();
    for part in parts {
        let part = part.map(|mut part| (part.record.shard.take(), part));
        match part {
            Ok((Some(shard), part)) => sharded.push((shard, part)),
            Ok((None, part)) => problems.push(format!(
                "{}: not a shard; expected results of `rtbench run --shard I/N`",
                part.path.display()
            )),
            Err(error) => problems.push(error.to_string()),
        }
    }
    sharded.sort_by_key(|(shard, _)| shard.index);
    complete(&sharded, &mut problems);
    agree(&sharded, mixed, &mut problems);
    for (shard, part) in &sharded {
        has_its_rows(shard, part, &mut problems);
    }
    scenes_agree(&sharded, &mut problems);
    match joined(sharded) {
        Some(run) if problems.is_empty() => Ok(run),
        _ => Err(MergeError { problems }),
    }
}

/// Every part is there once.
fn complete(parts: &[(ShardRecord, PartialRun)], problems: &mut Vec<String>) {
    let Some((first, _)) = parts.first() else { return };
    for index in 1..=first.count {
        let mut same = parts.iter().filter(|(shard, _)| shard.index == index);
        let Some((shard, one)) = same.next() else {
            problems.push(format!("shard {index}/{} is missing", first.count));
            continue;
        };
        problems.extend(same.map(|(_, other)| {
            let [one, other] = [one, other].map(|part| part.path.display());
            format!("shard {} is given twice: {one} and {other}", shard.shard())
        }));
    }
}

/// All parts are of the same program, machine, settings and table.
fn agree(parts: &[(ShardRecord, PartialRun)], mixed: bool, problems: &mut Vec<String>) {
    let common = |(shard, part): &(ShardRecord, PartialRun)| {
        let RunRecord { tool, compiler, machine, settings, .. } = &part.record;
        json!({
            "tool": tool,
            "compiler": compiler,
            "machine": (!mixed).then_some(machine),
            "settings": settings,
            "count": shard.count,
            "scenes": shard.scenes,
            "rows": shard.rows,
            "rounds": shard.rounds,
        })
    };
    let Some(first) = parts.first() else { return };
    let expected = common(first);
    for part in parts.iter().skip(1) {
        differing(&expected, &common(part), "", (&first.1, &part.1), problems);
    }
}

/// A problem for each field in which two values differ.
fn differing(
    expected: &Value,
    found: &Value,
    name: &str,
    (first, part): (&PartialRun, &PartialRun),
    problems: &mut Vec<String>,
) {
    let mut differences = Vec::new();
    compare(name, expected, found, &mut differences);
    let [part, first] = [part, first].map(|part| part.path.display());
    problems.extend(differences.iter().map(|found| format!("{part}: {found}, in {first}")));
}

/// A part is finished and has the rows that are its own, in order.
fn has_its_rows(shard: &ShardRecord, part: &PartialRun, problems: &mut Vec<String>) {
    let path = part.path.display();
    if !part.record.complete {
        problems.push(format!(
            "{path}: shard {} has {} of {} scenes; finish it with `rtbench run --resume`",
            shard.shard(),
            part.record.scenes.len(),
            part.record.planned.len()
        ));
        return;
    }
    for (i, name) in shard.scenes.iter().enumerate() {
        let expected = shard.rows_of(i).into_iter();
        let expected = expected.filter_map(|row| shard.rows.get(row).map(String::as_str));
        let expected: Vec<&str> = expected.collect();
        let scene = scene_at(shard, part, i);
        let found: Vec<String> =
            scene.map(|s| s.rows.iter().map(RowRecord::label).collect()).unwrap_or_default();
        if found != expected {
            let or_none = |rows: String| if rows.is_empty() { "none".to_owned() } else { rows };
            let expected = or_none(expected.join(", "));
            let found = match scene {
                None if part.record.planned.contains(name) => "none: it failed".to_owned(),
                _ => or_none(found.join(", ")),
            };
            problems.push(format!(
                "{path}: scene {name}: expected the rows {expected}; it has {found}"
            ));
        }
    }
}

/// Results of a part for the scene at a place of the whole run.
fn scene_at<'a>(
    shard: &ShardRecord,
    part: &'a PartialRun,
    place: usize,
) -> Option<&'a SceneRecord> {
    let name = shard.scenes.get(place)?;
    part.record.scenes.iter().find(|scene| scene.name == *name)
}

/// Parts that share a scene have the same one, and the same answers of the reference.
fn scenes_agree(parts: &[(ShardRecord, PartialRun)], problems: &mut Vec<String>) {
    let Some((whole, _)) = parts.first() else { return };
    for place in 0..whole.scenes.len() {
        let mut first: Option<(&PartialRun, Value)> = None;
        for (shard, part) in parts {
            let Some(scene) = scene_at(shard, part, place) else { continue };
            let found = common_scene(scene);
            match &first {
                None => first = Some((part, found)),
                Some((one, expected)) => {
                    let name = format!("scene {}", scene.name);
                    differing(expected, &found, &name, (one, part), problems);
                }
            }
        }
    }
}

/// What does not depend on a clock.
fn common_scene(scene: &SceneRecord) -> Value {
    // a reference too slow for all rays is counted on as many as its time allows
    let is_whole = |row: &&RowRecord| row.is_reference && row.checked_rays == scene.distinct_rays();
    let counted = |row: &RowRecord| {
        let RowRecord { verdict, stats, work, answers_sha256, .. } = row;
        json!({
            "verdict": verdict, "stats": stats, "work": work, "answers_sha256": answers_sha256,
        })
    };
    json!({
        "sha256": scene.sha256,
        "primitives": scene.primitives,
        "rays": scene.rays,
        "oracle": scene.oracle,
        "reference": scene.rows.iter().find(is_whole).map(counted),
    })
}

/// The whole run of parts that fit, in their order; none of no parts.
fn joined(parts: Vec<(ShardRecord, PartialRun)>) -> Option<RunRecord> {
    let origin = |(shard, part): &(ShardRecord, PartialRun)| PartRecord {
        index: shard.index,
        command_line: part.record.command_line.clone(),
        machine: part.record.machine.clone(),
        started_unix_s: part.record.started_unix_s,
    };
    let origins: Vec<PartRecord> = parts.iter().map(origin).collect();
    let mut parts = parts.into_iter();
    let (whole, PartialRun { record: mut run, .. }) = parts.next()?;
    for (_, PartialRun { record, .. }) in parts {
        run.started_unix_s = run.started_unix_s.min(record.started_unix_s);
        run.peak_rss_bytes = run.peak_rss_bytes.max(record.peak_rss_bytes);
        run.machine = joined_machine(&run.machine, &record.machine);
        let new = record.warnings.into_iter().filter(|warning| !run.warnings.contains(warning));
        let new: Vec<_> = new.collect();
        run.warnings.extend(new);
        for scene in record.scenes {
            match run.scenes.iter_mut().find(|s| s.name == scene.name) {
                None => run.scenes.push(scene),
                Some(known) => {
                    known.peak_rss_bytes = known.peak_rss_bytes.max(scene.peak_rss_bytes);
                    known.rows.extend(scene.rows.into_iter().filter(|row| !row.is_reference));
                }
            }
        }
    }
    let place = |names: &[String], name: &str| names.iter().position(|n| n == name);
    for scene in &mut run.scenes {
        scene.rows.sort_by_cached_key(|row| place(&whole.rows, &row.label()));
    }
    run.scenes.sort_by_key(|scene| place(&whole.scenes, &scene.name));
    run.summary = summarize(&run.scenes, &run.settings);
    run.planned = whole.scenes.clone();
    run.parts = origins;
    Some(run)
}

/// A machine of which no more is said than is true of both.
fn joined_machine(a: &Machine, b: &Machine) -> Machine {
    let both = |a: &str, b: &str| {
        if a.split("; ").any(|known| known == b) { a.to_owned() } else { format!("{a}; {b}") }
    };
    let mut machine = a.clone();
    machine.cpu = match (&a.cpu, &b.cpu) {
        (Some(a), Some(b)) => Some(both(a, b)),
        (a, b) => a.clone().or_else(|| b.clone()),
    };
    machine.threads = a.threads.min(b.threads);
    machine.memory_bytes = a.memory_bytes.min(b.memory_bytes);
    machine.os = both(&a.os, &b.os);
    machine.governor = a.governor.clone().filter(|_| a.governor == b.governor);
    machine.boost = a.boost.filter(|_| a.boost == b.boost);
    let avx512 = a.batches_by_avx512.filter(|_| a.batches_by_avx512 == b.batches_by_avx512);
    machine.batches_by_avx512 = avx512;
    machine.huge_pages = a.huge_pages.clone().filter(|_| a.huge_pages == b.huge_pages);
    machine
}
