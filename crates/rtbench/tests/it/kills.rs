//! The cases K2 to K4 of the project's catalogue of hard cases: signals, kills, memory that runs out
//! in the middle of a run. What was finished is kept.

#![cfg(unix)]

use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use crate::hard_cases::{SMALL, ended, program};
use crate::resuming::{begun, journal, outputs, record, show, unsealed};
use measurement::journal::lines::Line;

/// Sends a signal twice, as `timeout` does: to the process and to its group.
fn signal(child: &Child, name: &str) {
    for _ in 0..2 {
        let pid = child.id().to_string();
        assert!(Command::new("kill").args([name, &pid]).status().unwrap().success());
    }
}

/// A run that would go on for minutes, in its second scene, so that there is something to keep.
fn long_run(folder: &Path) -> Child {
    let arguments = "run tetra:1 balls:5 --size 64 --rounds 300 -s uniform-grid,obvhs-cwbvh -q \
                     --rays primary";
    let mut child = begun(arguments, folder).spawn().unwrap();
    for _ in 0..3000 {
        let text = std::fs::read_to_string(folder.join("run.jsonl")).unwrap_or_default();
        if text.contains("{\"scene\":1}}\n") {
            return child;
        }
        std::thread::sleep(Duration::from_millis(20));
    }
    let _ = child.kill().and_then(|()| child.wait());
    panic!("the second scene never begins");
}

#[test]
fn k2_signals_mark_the_run_and_end_it() {
    for (name, number) in [("-INT", 2), ("-TERM", 15), ("-HUP", 1)] {
        let folder = tempfile::tempdir().unwrap();
        // 300 rounds of a tiny scene are quick, of the second they take long
        let child = long_run(folder.path());
        signal(&child, name);
        let (code, out, err) = ended(child);
        assert_eq!(code, Some(128 + number), "{err}");
        assert!(err.contains("1 of 2 scenes are finished, kept"), "{err}");
        assert!(err.contains("rtbench run --resume"), "{err}");
        assert!(out.contains("tetra:1: "), "{out}");
        let lines = std::fs::read_to_string(folder.path().join("run.jsonl")).unwrap();
        let last: Line = serde_json::from_str(unsealed(lines.lines().last().unwrap())).unwrap();
        assert_eq!(last, Line::Interrupted(number));
        let record = record(folder.path());
        assert!(!record.complete && record.scenes.len() == 1);
        assert_eq!(record.planned, ["tetra:1", "balls:5"]);
        let markdown = std::fs::read_to_string(folder.path().join("results.md")).unwrap();
        assert!(markdown.contains("Incomplete: 1 of 2 scenes"), "{markdown}");
    }
}

/// Rounds of a scene are kept as far as every row has them.
#[test]
fn k2_a_signal_keeps_the_rounds_of_the_scene_that_it_interrupts() {
    for seconds in [2, 10, 40] {
        let folder = tempfile::tempdir().unwrap();
        let arguments = "run tetra:4 --size 64 --time-budget 120s -s uniform-grid,obvhs-cwbvh -o";
        let child = program(&format!("{arguments} {}", show(folder.path()))).spawn().unwrap();
        std::thread::sleep(std::time::Duration::from_secs(seconds));
        signal(&child, "-INT");
        let (code, _, err) = ended(child);
        assert_eq!(code, Some(130), "{err}");
        if err.contains("0 of 1 scenes") {
            // no round was over on this machine
            continue;
        }
        assert!(err.contains("1 of 1 scenes are finished, kept"), "{err}");
        let scene = &record(folder.path()).scenes[0];
        let rounds: Vec<usize> = scene.rows.iter().map(|row| row.samples.len()).collect();
        assert!(rounds[0] > 0 && rounds.iter().all(|n| *n == rounds[0]), "{rounds:?}");
        assert!(scene.rows.iter().all(|row| row.ratio.is_some()));
        assert_eq!(journal(folder.path()).finished.len(), 1, "{err}");
        return;
    }
    panic!("no round in 40 s");
}

/// The folder is gone, and Ctrl-C comes before the next scene would make it again.
#[test]
fn k2_a_signal_makes_a_folder_again_that_was_removed() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let child = long_run(&out);
    std::fs::remove_dir_all(&out).unwrap();
    signal(&child, "-INT");
    let (code, _, err) = ended(child);
    assert_eq!(code, Some(130), "{err}");
    assert!(err.contains("1 of 2 scenes are finished, kept"), "{err}");
    let found = journal(&out);
    assert_eq!((found.finished.len(), found.died_in), (1, None), "{err}");
}

/// `RTBENCH_KILLS` sets how many kills.
#[test]
fn k3_kill_9_loses_no_finished_row() {
    let kills: usize =
        std::env::var("RTBENCH_KILLS").ok().and_then(|n| n.parse().ok()).unwrap_or(20);
    let whole = tempfile::tempdir().unwrap();
    let begin = std::time::Instant::now();
    let (code, _, err) = ended(begun(SMALL, whole.path()).spawn().unwrap());
    assert_eq!(code, Some(0), "{err}");
    let takes = begin.elapsed();
    let mut state = 42_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64
    };
    let (mut killed, mut torn, mut kept, mut runs, mut skipped) = (0, 0, 0, 0, 0);
    'runs: while killed < kills {
        let folder = tempfile::tempdir().unwrap();
        runs += 1;
        let mut before = Vec::new();
        // longer from kill to kill, or a machine that has become busy would never finish a run
        let mut longest = takes.mul_f64(1.1);
        loop {
            let mut child = if before.is_empty() {
                // nothing was kept: begin (again)
                begun(SMALL, folder.path()).spawn().unwrap()
            } else {
                program(&format!("run -q --resume {}", show(folder.path()))).spawn().unwrap()
            };
            std::thread::sleep(longest.mul_f64(random()));
            longest = longest.mul_f64(1.1);
            let _ = child.kill();
            let (code, out, err) = ended(child);
            let text = std::fs::read(folder.path().join("run.jsonl")).unwrap_or_default();
            let end = text.iter().rposition(|&b| b == b'\n').map_or(0, |last| last + 1);
            torn += usize::from(end < text.len());
            if end == 0 {
                assert!(before.is_empty() && !out.contains("primitives; rays"));
                killed += 1;
                continue;
            }
            let found = journal(folder.path());
            // every scene that was shown is there, and what was there is unchanged
            let shown = out.lines().filter(|l| l.contains("primitives; rays")).count();
            assert!(
                found.finished.len() >= shown,
                "{shown} were shown: {:?}",
                found.finished.keys()
            );
            assert!(text.starts_with(&before), "finished rows changed");
            before = if found.finished.is_empty() { Vec::new() } else { text[..end].to_vec() };
            if code == Some(0) {
                assert!(found.is_complete);
                break;
            }
            assert_eq!(code, None, "{err}");
            killed += 1;
            kept += found.finished.len();
            if found.deaths.values().any(|deaths| *deaths > 1) {
                // what is killed twice in the same row goes on without it: a new run
                skipped += 1;
                continue 'runs;
            }
        }
        assert_eq!(outputs(folder.path()), outputs(whole.path()));
        println!(
            "{killed} kills in {runs} runs, {kept} finished scenes kept, {torn} torn lines cut, {skipped} \
             runs killed twice in a row of theirs"
        );
    }
}

/// With memory limited, a large scene ends the process in one way or the other. What was finished
/// is kept, the death is noticed, and without the limit the run is finished.
#[test]
fn k4_memory_that_runs_out() {
    let folder = tempfile::tempdir().unwrap();
    let big = folder.path().join("big.nff");
    // half a gigabyte once loaded, and not enough memory for it
    std::fs::write(&big, "s 0 0 0 1\n".repeat(4_000_000)).unwrap();
    let arguments =
        format!("run tetra:1 {} --quick --rounds 1 --size 4 -s obvhs-cwbvh -q", show(&big));
    let out = folder.path().join("out");
    let mut command = Command::new("sh");
    let script = "ulimit -v 480000; MALLOC_ARENA_MAX=1 exec \"$0\" \"$@\"";
    command.args(["-c", script, env!("CARGO_BIN_EXE_rtbench")]);
    command.args(arguments.split_whitespace()).arg("-o").arg(&out);
    let child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let (code, shown, err) = ended(child);
    assert_ne!(code, Some(0), "{err}");
    assert!(shown.contains("tetra:1: 4 primitives"), "{shown} {err}");
    let found = journal(&out);
    assert_eq!(found.finished.len(), 1, "{err}");
    // a smaller file in its place would be another scene, but nothing of it is finished
    std::fs::write(&big, "s 0 0 0 1\n").unwrap();
    let (code, _, err) = ended(program(&format!("run --resume {}", show(&out))).spawn().unwrap());
    assert_eq!(code, Some(0), "{err}");
    if found.died_in == Some(1) {
        assert!(err.contains("died while measuring 'big'"), "{err}");
    }
    assert_eq!(record(&out).scenes.len(), 2);
}
