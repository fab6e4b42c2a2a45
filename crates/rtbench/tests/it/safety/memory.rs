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
    // lines end where the width of the table does
    let printed = ended.out.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(printed.contains(said), "{printed}");
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

/// A structure that exceeds the limit after its build is refused and not timed.
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
fn memory_refused_by_the_system_is_a_row_out_of_memory() {
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

/// Point at which the program of [`died`] ends.
enum Death {
    /// The second scene is begun, none of its rows.
    Preparing,
    /// Its row `uniform-grid` is built and checked.
    Checking,
    /// First timing of that row.
    Timing,
    /// All its rows were timed once.
    Later,
}

/// The journal of a run that died in its second scene: the lines up to there, so many times.
fn died(folder: &std::path::Path, at: &Death, times: usize) {
    let (code, _, err) = run_here(&format!("{ARGUMENTS} -o {}", show(folder)));
    assert_eq!(code, 0, "{err}");
    let path = folder.join("run.jsonl");
    let text = std::fs::read_to_string(&path).unwrap();
    let lines: Vec<&str> = text.split_inclusive('\n').collect();
    let second = lines.iter().rposition(|line| line.contains("\"line\":{\"scene\":1}")).unwrap();
    let rest = &lines[second..];
    let places = |part: &str| {
        rest.iter().enumerate().filter(|(_, l)| l.contains(part)).map(|(i, _)| i).collect()
    };
    // checked, timed for the first time, rendered
    let (rows, passed): (Vec<usize>, Vec<usize>) =
        (places("{\"row\":\"uniform-grid\"}"), places("\"passed\""));
    assert!(rows.len() == 3 && passed.len() == 3, "{text}");
    assert!(rows.iter().zip(&passed).all(|(row, passed)| row < passed), "{text}");
    let last = match at {
        Death::Preparing => 0,
        Death::Checking => rows[0],
        Death::Timing => rows[1],
        Death::Later => passed[1],
    };
    let kept = lines[..second].concat() + &rest[..=last].concat().repeat(times);
    std::fs::write(&path, resealed(&kept)).unwrap();
}

/// Every resume died in the same row: the second finds that out and leaves it out.
#[test]
fn a_row_that_ended_the_program_twice_is_skipped() {
    for (at, times, skipped) in [
        (Death::Checking, 1, false),
        (Death::Checking, 2, true),
        (Death::Checking, 3, true),
        (Death::Timing, 1, false),
        (Death::Timing, 2, true),
    ] {
        let folder = tempfile::tempdir().unwrap();
        died(folder.path(), &at, times);
        let found = journal(folder.path());
        assert_eq!(found.deaths, [((1, Some("uniform-grid".to_owned())), times)].into());
        let (code, out, err) = run_here(&format!("run --resume {}", show(folder.path())));
        assert_eq!(code, u8::from(skipped), "{times}: {err}");
        let said = format!("skipped: {times} times the program died");
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

/// A scene that ended the program before its first row is left out once, and then tried again.
#[test]
fn a_scene_that_ended_the_program_twice_is_skipped_and_tried_again() {
    for (times, skipped) in [(1, false), (2, true)] {
        let folder = tempfile::tempdir().unwrap();
        died(folder.path(), &Death::Preparing, times);
        assert_eq!(journal(folder.path()).deaths, [((1, None), times)].into());
        let resume = || run_here(&format!("run --resume {}", show(folder.path())));
        let (code, _, err) = resume();
        assert_eq!(code, u8::from(skipped), "{err}");
        assert_eq!(err.contains("tetra:2: skipped: 2 times the program died"), skipped, "{err}");
        assert_eq!(record(folder.path()).scenes.len(), if skipped { 1 } else { 2 });
        let (code, _, err) = resume();
        assert_eq!((code, record(folder.path()).scenes.len()), (0, 2), "{err}");
    }
}

/// The end of the program after a row was timed once, as by `kill -9`, is not that row's fault.
#[test]
fn deaths_after_the_first_round_count_for_no_row() {
    let folder = tempfile::tempdir().unwrap();
    died(folder.path(), &Death::Later, 3);
    let found = journal(folder.path());
    assert_eq!((found.deaths.len(), found.died_in), (0, Some(1)));
    let (code, _, err) = run_here(&format!("run --resume {}", show(folder.path())));
    assert!(code == 0 && err.contains("died while measuring 'tetra:2'"), "{err}");
}
