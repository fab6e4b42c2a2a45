//! Memory that does not suffice costs a row, not the run.

use std::process::Command;

use measurement::record::Verdict;

use crate::common::{Folder, row, run};
use crate::resuming::{journal, record, resealed, run as run_here, show};

const HUGE: &str = "uniform-grid:resolution=2048x1024x512:max-cells=1073741824";
const LABEL: &str = "uniform-grid resolution=2048x1024x512 max-cells=1073741824";

/// A grid of 4 GiB where 64 MiB are allowed.
#[test]
fn a_structure_over_the_limit_is_a_row_out_of_memory() {
    let folder = Folder::new();
    let ended = run(&format!(
        "run tetra:1 --size 4 --rounds 1 -s obvhs-cwbvh,{HUGE},obvhs-bvh2 --max-memory 64MiB -o {}",
        folder.path()
    ));
    assert_eq!(ended.code, 1, "{}", ended.err);
    let said = "it would take 4096 MiB of memory, more than the limit of 64 MiB";
    assert!(ended.out.contains(said), "{}", ended.out);
    assert!(ended.out.contains("out of memory in 1 scenes"), "{}", ended.out);
    let record = folder.record();
    let huge = row(&record, LABEL);
    assert_eq!((huge.verdict, huge.samples.len()), (Verdict::OutOfMemory, 0));
    for other in ["obvhs-cwbvh", "obvhs-bvh2"] {
        assert_eq!(row(&record, other).verdict, Verdict::Ok);
        assert_eq!(row(&record, other).samples.len(), 1);
    }
    let csv = folder.csv();
    let verdicts: Vec<&str> = csv.iter().map(|line| &*line["verdict"]).collect();
    assert_eq!(verdicts, ["ok", "out of memory", "ok"]);
    assert!(record.complete);
}

/// What grew over the limit unforeseen is refused once it is there: nothing of it is timed.
#[test]
fn a_limit_below_every_structure_leaves_no_row_timed() {
    let ended = run(
        "run balls:1 --size 4 --rounds 1 -s obvhs-cwbvh,uniform-grid,obvhs-bvh2 --max-memory 100B",
    );
    assert_eq!(ended.code, 1, "{}", ended.err);
    let refusals = ended.err.matches("more than the limit of 100 bytes").count();
    assert!(refusals > 0 || ended.out.matches("out of memory").count() >= 3, "{}", ended.out);
}

/// The same where not we but the system sets the limit.
#[cfg(target_os = "linux")]
#[test]
fn what_the_system_refuses_is_a_row_out_of_memory() {
    let folder = Folder::new();
    let program = env!("CARGO_BIN_EXE_rtbench");
    let line = format!(
        "ulimit -v 3000000; exec {program} run tetra:1 -q --size 4 --rounds 1 --max-memory 16GiB \
         -s obvhs-cwbvh,{HUGE},kd-tree -o {}",
        folder.path()
    );
    let ended = Command::new("sh").args(["-c", &line]).output().unwrap();
    let err = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(1), "{err}");
    let record = folder.record();
    let huge = row(&record, LABEL);
    assert_eq!(huge.verdict, Verdict::OutOfMemory);
    let why = huge.error.as_deref().unwrap();
    assert!(why.contains("4096 MiB of memory, which the system refuses"), "{why}");
    assert_eq!(row(&record, "kd-tree").verdict, Verdict::Ok);
}

const ARGUMENTS: &str =
    "run tetra:1 tetra:2 -q --size 4 --rounds 1 -s obvhs-cwbvh,uniform-grid,kd-tree";

/// The journal of a run that died while the rows of its second scene were checked: the lines up to the
/// second row of that scene, so many times.
fn died(folder: &std::path::Path, times: usize) {
    let (code, _, err) = run_here(&format!("{ARGUMENTS} -o {}", show(folder)));
    assert_eq!(code, 0, "{err}");
    let path = folder.join("run.jsonl");
    let text = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let second = lines.iter().rposition(|line| line.contains("\"line\":{\"scene\":1}")).unwrap();
    let row = lines.iter().rposition(|l| l.contains("{\"row\":\"uniform-grid\"}")).unwrap();
    assert_eq!(row, second + 2, "{text}");
    let mut kept = lines[..second].concat();
    for _ in 0..times {
        kept += &lines[second..=row].concat();
    }
    std::fs::write(&path, resealed(&kept)).unwrap();
}

/// Every resume died in the same row: the second finds that out and leaves it out.
#[test]
fn a_row_that_ended_the_program_twice_is_skipped() {
    for (times, skipped) in [(1, false), (2, true), (3, true)] {
        let folder = tempfile::tempdir().unwrap();
        died(folder.path(), times);
        let found = journal(folder.path());
        assert_eq!(found.deaths, [((1, "uniform-grid".to_owned()), times)].into());
        let (code, out, err) = run_here(&format!("run --resume {}", show(folder.path())));
        assert_eq!(code, u8::from(skipped), "{times}: {err}");
        let said = format!("skipped: {times} times the program ended without a word");
        assert_eq!(out.contains(&said), skipped, "{times}: {out}");
        let record = record(folder.path());
        let verdicts = |scene: usize| {
            record.scenes[scene].rows.iter().map(|row| row.verdict).collect::<Vec<_>>()
        };
        assert_eq!(verdicts(0), [Verdict::Ok; 3]);
        let own = if skipped { Verdict::Panicked } else { Verdict::Ok };
        assert_eq!(verdicts(1), [Verdict::Ok, own, Verdict::Ok]);
        assert!(record.complete && journal(folder.path()).is_complete);
    }
}
