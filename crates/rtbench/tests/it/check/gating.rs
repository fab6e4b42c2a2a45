//! The whole command: exit codes, exports, annotations, another binary.

use std::path::{Path, PathBuf};

use accel_core::structure::StructureInfo;
use accel_core::structures::find;
use measurement::record::RunRecord;
use measurement::system::clock::SystemClock;
use rtbench::context::Environment;

use super::{in_folder, run_in, run_timed, saved, with_program};
use crate::common::{DECLARED, Ended, Folder, PLANTED, planted};

/// A structure that no other program has.
static NEWER: StructureInfo = planted("newer", "brute force under another name");

fn check(folder: &Folder, options: &str) -> Ended {
    run_in(&PLANTED, in_folder(&folder.path()), &format!("check --baseline main {options}"))
}

/// Plants a fault in the baseline `main`: what it says is then not what is found.
fn plant(folder: &Folder, fault: impl Fn(&mut RunRecord)) {
    let mut record: RunRecord = serde_json::from_str(&folder.text("main.json")).unwrap();
    fault(&mut record);
    let text = serde_json::to_string(&record).unwrap();
    std::fs::write(Path::new(&folder.path()).join("main.json"), text).unwrap();
}

#[test]
fn an_unchanged_program_passes_and_what_changed_ends_with_3() {
    let folder = Folder::new();
    saved(&folder.path(), "main");
    let passed = check(&folder, "--strict");
    assert_eq!(passed.code, 0, "{}{}", passed.out, passed.err);
    assert!(passed.out.contains("20 of 20 unchanged."), "{}", passed.out);
    assert!(passed.out.contains("check against baseline main: "), "{}", passed.out);
    assert_eq!(passed.err, "");
    plant(&folder, |r| {
        let rows = r.scenes[0].rows.iter_mut().filter_map(|row| row.work.as_mut());
        rows.for_each(|work| work.traversal_steps -= 1);
    });
    let out = Folder::new();
    let failed = check(&folder, &format!("-o {}", out.path()));
    assert_eq!(failed.code, 3, "{}{}", failed.out, failed.err);
    assert!(failed.out.contains("n_ts"), "{}", failed.out);
    let csv = out.text("check.csv");
    assert!(csv.contains("counters,tetra:2,uniform-grid,n_ts,"), "{csv}");
    let json: serde_json::Value = serde_json::from_str(&out.text("check.json")).unwrap();
    assert_eq!(json["outcome"], "regression");
    assert_eq!(json["findings"].as_array().unwrap().len() + 1, csv.lines().count());
    assert!(out.text("check.md").starts_with("# rtbench check: regression"));
    // only what is asked for
    assert_eq!(check(&folder, "-s obvhs-cwbvh").code, 3);
}

#[test]
fn wrong_hits_end_with_4_whatever_else_is_found() {
    let folder = Folder::new();
    let arguments = "baseline save main tetra:2 --quick --size 16 -s dropper,obvhs-cwbvh";
    let ended = run_in(DECLARED, in_folder(&folder.path()), arguments);
    assert_eq!(ended.code, 0, "{}", ended.err);
    plant(&folder, |r| r.scenes[0].rows[1].work.as_mut().unwrap().traversal_steps -= 1);
    let wrong = check(&folder, "");
    assert_eq!(wrong.code, 4, "{}{}", wrong.out, wrong.err);
    assert!(wrong.out.contains("wrong hits"), "{}", wrong.out);
}

#[test]
fn inconclusive_comparisons_exit_with_5_if_requested() {
    let folder = Folder::new();
    saved(&folder.path(), "main");
    plant(&folder, |r| {
        for (i, sample) in r.scenes[0].rows.iter_mut().flat_map(|r| &mut r.samples).enumerate() {
            let times = [0.5, 1.0, 2.0, 1.0][i % 4];
            sample.reference_trace_s = sample.reference_trace_s.map(|s| s * times);
        }
    });
    let lenient = check(&folder, "");
    assert_eq!(lenient.code, 0, "{}{}", lenient.out, lenient.err);
    assert!(lenient.out.contains("inconclusive"), "{}", lenient.out);
    assert_eq!(check(&folder, "--strict").code, 5);
}

#[test]
fn incomparable_baselines_are_refused_with_all_reasons() {
    let folder = Folder::new();
    saved(&folder.path(), "main");
    plant(&folder, |r| {
        r.scenes[0].sha256 = "0".repeat(64);
        r.compiler.target = Some("other".into());
    });
    let refused = check(&folder, "");
    assert_eq!((refused.code, refused.out.as_str()), (1, ""));
    for said in ["scene tetra:2: sha256", "target: other, then"] {
        assert!(refused.err.contains(said), "{}", refused.err);
    }
}

#[test]
fn rows_of_one_side_are_named_and_nothing_in_common_is_an_error() {
    let folder = Folder::new();
    saved(&folder.path(), "main");
    let rename = |to: &str| {
        let to = to.to_owned();
        plant(&folder, move |r| {
            for row in r.scenes[0].rows.iter_mut().filter(|r| r.structure != "obvhs-cwbvh") {
                row.structure.clone_from(&to);
            }
        });
    };
    // planted: a row that this program lacks
    rename("gone-grid");
    let lenient = check(&folder, "");
    assert_eq!(lenient.code, 0, "{}{}", lenient.out, lenient.err);
    assert!(lenient.out.contains("missing now: gone-grid (tetra:2)"), "{}", lenient.out);
    assert!(lenient.out.contains("; 1 rows missing now"), "{}", lenient.out);
    assert_eq!(check(&folder, "--strict").code, 5);
    assert_eq!(check(&folder, "--strict --allow-missing gone-grid").code, 0);
    // what was meant
    let matched = check(&folder, "--strict --match gone-grid=uniform-grid");
    assert!(matched.code == 0 && !matched.out.contains("missing"), "{}", matched.out);
    let unknown = check(&folder, "--match gone-grid=unifrom-grid");
    assert!(unknown.code == 2 && unknown.err.contains("--match"), "{}", unknown.err);
    // nothing in common
    plant(&folder, |r| r.scenes[0].rows.retain(|row| row.structure == "gone-grid"));
    let nothing = check(&folder, "");
    assert_eq!((nothing.code, nothing.out.as_str()), (6, ""), "{}", nothing.err);
    assert!(nothing.err.contains("nothing was compared"), "{}", nothing.err);
    assert!(nothing.err.contains("gone-grid"), "{}", nothing.err);
}

#[test]
fn too_few_rounds_for_significance_are_reported_before_measuring() {
    let folder = Folder::new();
    saved(&folder.path(), "main");
    let few = check(&folder, "--rounds 2");
    assert!(few.err.contains("2 rounds against 15 of the baseline can never"), "{}", few.err);
    assert!(!check(&folder, "").err.contains("never"));
}

#[test]
fn two_stored_results_are_checked_and_what_was_measured_is_kept() {
    let (folder, kept) = (Folder::new(), Folder::new());
    saved(&folder.path(), "main");
    let out = format!("{}/out", kept.path());
    let measured = check(&folder, &format!("-o {out}"));
    assert_eq!(measured.code, 0, "{}{}", measured.out, measured.err);
    let stored = check(&folder, &format!("--results {out} --strict"));
    assert_eq!(stored.code, 0, "{}{}", stored.out, stored.err);
    let last = |ended: &Ended| ended.out.lines().last().unwrap().to_owned();
    assert_eq!(last(&stored), last(&measured));
    // planted in what is stored
    let path = Path::new(&out).join("results.json");
    let mut record: RunRecord =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    record.scenes[0].rows[0].work.as_mut().unwrap().traversal_steps += 1;
    std::fs::write(&path, serde_json::to_string(&record).unwrap()).unwrap();
    assert_eq!(check(&folder, &format!("--results {out}")).code, 3);
    assert_eq!(check(&folder, &format!("--results {out} --rounds 3")).code, 2);
}

#[test]
fn an_older_program_that_lacks_a_row_passes_with_the_row_named() {
    let folder = Folder::new();
    let program = env!("CARGO_BIN_EXE_rtbench");
    let arguments = format!(
        "check tetra:2 --against {program} --rounds 2 --quick --size 16 -t 900% -s newer,obvhs-cwbvh"
    );
    let mut newer = *find("brute-force").unwrap();
    newer.info = &NEWER;
    let registry = [&PLANTED[..], &[newer]].concat();
    let clock = SystemClock::default();
    let environment = with_program(&folder.path());
    let ended = run_timed(&registry, environment.clone(), &clock, &arguments);
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    let said = "new, nothing to compare with: newer (tetra:2)";
    assert!(ended.out.contains(said), "{}", ended.out);
    let strict = run_timed(&registry, environment, &clock, &format!("{arguments} --strict"));
    assert_eq!(strict.code, 5, "{}{}", strict.out, strict.err);
}

#[test]
fn github_gets_annotations_and_a_summary() {
    let folder = Folder::new();
    saved(&folder.path(), "main");
    plant(&folder, |r| {
        for row in &mut r.scenes[0].rows {
            let stats = row.stats.as_mut().unwrap();
            stats.memory_bytes -= 1;
            stats.n_oiv -= 1;
            let work = row.work.as_mut().unwrap();
            work.intersection_tests -= 1;
            work.traversal_steps -= 1;
            work.elementary_steps -= 1;
            row.answers_sha256 = Some("0".repeat(64));
        }
    });
    let summary = PathBuf::from(folder.path()).join("summary.txt");
    std::fs::write(&summary, "before\n").unwrap();
    let environment = Environment {
        github_actions: true,
        github_step_summary: Some(summary.clone()),
        ..in_folder(&folder.path())
    };
    let ended = run_in(&PLANTED, environment, "check --baseline main");
    assert_eq!(ended.code, 3);
    let lines: Vec<&str> = ended.err.lines().collect();
    assert_eq!(lines.len(), 10, "{}", ended.err);
    assert!(lines[0].starts_with("::error title=rtbench check%3A regression::tetra:2: "));
    assert_eq!(lines[9], "::error title=rtbench check::3 more; see the summary");
    let text = std::fs::read_to_string(summary).unwrap();
    assert!(text.starts_with("before\n# rtbench check: regression\n"), "{text}");
}

#[test]
fn two_binaries_are_measured_in_turns() {
    let folder = Folder::new();
    let program = env!("CARGO_BIN_EXE_rtbench");
    let arguments = format!(
        "check tetra:2 --against {program} --rounds 2 --quick --size 16 --all -t 900% \
         -s uniform-grid,obvhs-cwbvh -o {}",
        folder.path()
    );
    let clock = SystemClock::default();
    let ended = run_timed(&PLANTED, with_program(&folder.path()), &clock, &arguments);
    assert_eq!(ended.code, 0, "{}{}", ended.out, ended.err);
    assert!(ended.out.contains("check against binary "), "{}", ended.out);
    let json: serde_json::Value = serde_json::from_str(&folder.text("check.json")).unwrap();
    let pairs = json["pairs"].as_array().unwrap();
    // build and trace of two rows
    assert_eq!(pairs.len(), 4);
    for pair in pairs {
        let (times, processes) = (&pair["times"], pair["processes"].as_array().unwrap());
        let times = times.as_array().unwrap();
        assert!(times.len() == processes.len() && times.len() >= 10, "{pair}");
        assert!(times.iter().all(|t| t.as_array().unwrap().len() == 3));
        assert_eq!((processes[0].as_u64(), processes.last().unwrap().as_u64()), (Some(0), Some(1)));
    }
    assert_eq!(json["floor"]["figures"], 4);
    assert!(ended.out.contains("A/A floor"), "{}", ended.out);
}

#[cfg(unix)]
#[test]
fn a_binary_that_cannot_answer_is_a_clear_error() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    for (script, said) in [
        (
            "echo \"error: unrecognized subcommand 'child'\" >&2; exit 2",
            "older than `rtbench check`",
        ),
        ("echo nonsense", "another version?"),
        ("echo 'error: the scene is gone' >&2; exit 1", "exit status: 1: error: the scene is gone"),
    ] {
        let old = PathBuf::from(folder.path()).join("old");
        std::fs::write(&old, format!("#!/bin/sh\ncat >/dev/null\n{script}\n")).unwrap();
        std::fs::set_permissions(&old, std::fs::Permissions::from_mode(0o755)).unwrap();
        let arguments = format!(
            "check tetra:1 --against {} --rounds 1 --quick --size 8 -s obvhs-cwbvh",
            old.display()
        );
        let ended = run_in(&PLANTED, with_program(&folder.path()), &arguments);
        assert_eq!((ended.code, ended.out.as_str()), (1, ""), "{}", ended.err);
        assert!(ended.err.contains(said), "{}", ended.err);
    }
    let arguments = "check tetra:1 --against /nowhere/rtbench --quick --size 8 -s obvhs-cwbvh";
    let missing = run_in(&PLANTED, with_program(&folder.path()), arguments);
    assert!(missing.code == 1 && missing.err.contains("/nowhere/rtbench"), "{}", missing.err);
}
