//! Runs in parts: joined, they are the whole; parts that do not fit are refused.

use std::path::Path;

use serde_json::Value;

use crate::common::{Folder, run_stepping};
use measurement::record::Warning;

const RUN: &str = "run tetra:1 tetra:2 balls:1 --size 12 --rounds 2 --seed 7 \
                   -s uniform-grid:density=1,uniform-grid,light-buffer,obvhs-cwbvh,obvhs-bvh2";

/// Two scenes that three parts share: 2, 3 and 3 cells of 4 and 4.
const SHARED: &str = "run tetra:1 tetra:2 --size 8 --rounds 2 --seed 7 \
                      -s uniform-grid:density=1,uniform-grid,light-buffer,obvhs-cwbvh,obvhs-bvh2";

/// Runs all parts of a run; their folders.
fn parts(run: &str, count: u32, folder: &Folder) -> Vec<String> {
    let part = |index| {
        let path = format!("{}/part-{index}", folder.path());
        let ended = run_stepping(&format!("{run} --shard {index}/{count} -o {path}"));
        assert_eq!(ended.code, 0, "{}", ended.err);
        path
    };
    (1..=count).map(part).collect()
}

#[test]
fn joined_parts_are_the_whole_run() {
    let whole = Folder::new();
    let expected = run_stepping(&format!("{RUN} -o {}", whole.path()));
    assert_eq!(expected.code, 0, "{}", expected.err);
    for count in [2, 5] {
        let folder = Folder::new();
        let mut parts = parts(RUN, count, &folder);
        parts.reverse();
        let joined = Folder::new();
        let merged = run_stepping(&format!("merge {} -o {}", parts.join(" "), joined.path()));
        assert_eq!(merged.code, 0, "{}", merged.err);
        assert_eq!(merged.out, expected.out, "{count} parts");
        assert_eq!(joined.text("results.csv"), whole.text("results.csv"), "{count} parts");
        let (found, of) = (joined.record(), whole.record());
        assert_eq!((&found.summary, &found.planned), (&of.summary, &of.planned));
        assert!(found.complete && found.shard.is_none());
        assert_eq!(found.parts.len(), count as usize);
        for (found, of) in found.scenes.iter().zip(&of.scenes) {
            for (found, of) in found.rows.iter().zip(&of.rows) {
                assert_eq!((&found.work, &found.stats), (&of.work, &of.stats));
                assert_eq!(found.answers_sha256, of.answers_sha256);
                assert_eq!(found.is_reference, of.is_reference);
            }
        }
    }
}

#[test]
fn interrupted_shards_are_finished_by_resume() {
    let folder = Folder::new();
    let parts = parts(RUN, 2, &folder);
    let whole = std::fs::read_to_string(format!("{}/results.csv", parts[0])).unwrap();
    let journal = format!("{}/run.jsonl", parts[0]);
    let text = std::fs::read_to_string(&journal).unwrap();
    // the manifest and the first scene
    let torn: String = text.split_inclusive('\n').take(3).collect();
    std::fs::write(&journal, torn).unwrap();
    let mut record = read(&parts[0]);
    record["complete"] = false.into();
    record["scenes"].as_array_mut().unwrap().truncate(1);
    write(&parts[0], &record);
    let early = run_stepping(&format!("merge {}", parts.join(" ")));
    assert_eq!(early.code, 1);
    assert!(early.err.contains("shard 1/2 has 1 of 2 scenes; finish it with"), "{}", early.err);
    let ended = run_stepping(&format!("run --resume {}", parts[0]));
    assert_eq!(ended.code, 0, "{}", ended.err);
    assert_eq!(std::fs::read_to_string(format!("{}/results.csv", parts[0])).unwrap(), whole);
    assert_eq!(run_stepping(&format!("merge {}", parts.join(" "))).code, 0);
}

fn read(part: &str) -> Value {
    let text = std::fs::read_to_string(Path::new(part).join("results.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

fn write(part: &str, record: &Value) {
    std::fs::write(Path::new(part).join("results.json"), record.to_string()).unwrap();
}

#[test]
fn shards_of_different_runs_are_not_merged() {
    let folder = Folder::new();
    let parts = parts(SHARED, 3, &folder);
    let [a, b, c] = [&parts[0], &parts[1], &parts[2]];
    let refused = |arguments: &str, said: &[&str]| {
        let ended = run_stepping(&format!("merge {arguments}"));
        assert_eq!((ended.code, ended.out.as_str()), (1, ""), "{arguments}: {}", ended.err);
        for said in said {
            assert!(ended.err.contains(said), "{said}: {}", ended.err);
        }
    };
    refused(&format!("{a} {c}"), &["shard 2/3 is missing"]);
    refused(a, &["shard 2/3 is missing", "shard 3/3 is missing"]);
    refused(&format!("{a} {b} {b} {c}"), &["shard 2/3 is given twice"]);
    let whole = Folder::new();
    run_stepping(&format!("run tetra:1 --quick --size 8 -s obvhs-cwbvh -o {}", whole.path()));
    refused(&whole.path(), &["not a shard"]);
    refused(&format!("{a} {b} {c} {}", whole.path()), &["not a shard"]);
    refused("/nowhere", &["cannot read /nowhere"]);

    let good = read(b);
    let all = format!("{a} {b} {c}");
    for (place, value, said) in [
        ("/settings/seed", Value::from(8), "settings.seed: was 7, is 8"),
        ("/tool/version", "9".into(), "tool.version: was"),
        ("/compiler/rustc", "x".into(), "compiler.rustc: was"),
        ("/machine/cpu", "another".into(), "machine.cpu: was"),
        ("/shard/count", 4.into(), "count: was 3, is 4"),
        ("/shard/rounds", "Fixed(9)".into(), "rounds: was"),
        ("/scenes/0/sha256", "0".into(), ".sha256: was"),
        ("/scenes/0/rows", Value::Array(Vec::new()), "expected the rows"),
        ("/scenes", Value::Array(Vec::new()), "none: it failed"),
    ] {
        let mut record = good.clone();
        *record.pointer_mut(place).unwrap() = value;
        write(b, &record);
        refused(&all, &[said]);
    }
    // several faults are listed together
    let mut record = good.clone();
    record["settings"]["seed"] = 8.into();
    record["machine"]["cpu"] = "another".into();
    write(b, &record);
    refused(&format!("{a} {b}"), &["settings.seed", "machine.cpu", "shard 3/3 is missing"]);
    // the reference must have given the same in all parts that share a scene
    let mut record = good.clone();
    for row in record["scenes"][0]["rows"].as_array_mut().unwrap() {
        if row["is_reference"] == true {
            row["work"]["traversal_steps"] = 1.into();
        }
    }
    write(b, &record);
    refused(&all, &["reference.work.traversal_steps: was"]);
    // different machines only when asked for
    let mut record = good.clone();
    record["machine"]["cpu"] = "another".into();
    write(b, &record);
    refused(&all, &["machine.cpu"]);
    let joined = Folder::new();
    let ended = run_stepping(&format!("merge {all} --mixed-machines -o {}", joined.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let mixed: Value = serde_json::from_str(&joined.text("results.json")).unwrap();
    assert!(mixed["machine"]["cpu"].as_str().unwrap().ends_with("; another"), "{mixed}");
    assert_eq!(mixed["parts"][1]["machine"]["cpu"], "another");
    // nothing was harmed by all that
    write(b, &good);
    assert_eq!(run_stepping(&format!("merge {all}")).code, 0);
}

#[test]
fn warnings_of_all_parts_are_kept() {
    let (folder, joined) = (Folder::new(), Folder::new());
    let parts = parts(SHARED, 2, &folder);
    let swap = Warning::Swap { own_bytes: 1, read_bytes: 2 };
    let rounds = Warning::TooFewRounds { rounds: 2 };
    for (part, more) in parts.iter().zip([vec![], vec![swap.clone()]]) {
        let mut record = read(part);
        record["warnings"] = serde_json::json!([vec![rounds.clone()], more].concat());
        write(part, &record);
    }
    let merged = run_stepping(&format!("merge {} -o {}", parts.join(" "), joined.path()));
    assert_eq!(merged.code, 0, "{}", merged.err);
    assert_eq!(joined.record().warnings, [rounds, swap]);
}

#[test]
fn a_folder_with_a_shard_is_not_overwritten() {
    let folder = Folder::new();
    let parts = parts(SHARED, 1, &folder);
    let ended = run_stepping(&format!("merge {0} -o {0}", parts[0]));
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(ended.err.contains("results.json: the command also reads this file"), "{}", ended.err);
    assert_eq!(read(&parts[0])["shard"]["index"], 1);
}

#[test]
fn scenes_of_the_same_name_are_not_divided() {
    let folder = Folder::new();
    let mut paths = Vec::new();
    for (name, x) in [("a", 1), ("b", 2)] {
        let path = format!("{}/{name}", folder.path());
        std::fs::create_dir(&path).unwrap();
        std::fs::write(
            format!("{path}/same.obj"),
            format!("v 0 0 0\nv {x} 0 0\nv 0 1 0\nf 1 2 3\n"),
        )
        .unwrap();
        paths.push(format!("{path}/same.obj"));
    }
    let ended = run_stepping(&format!("run {} -s obvhs-cwbvh --shard 1/2", paths.join(" ")));
    assert_eq!(ended.code, 2, "{}", ended.err);
    assert!(ended.err.contains("two scenes are named same"), "{}", ended.err);
}

#[test]
fn shards_that_make_no_sense_are_usage_errors() {
    for (arguments, said) in [
        ("run tetra:1 --shard 0/2", "1 to N"),
        ("run tetra:1 --shard 3/2", "1 to N"),
        ("run tetra:1 --shard half", "2/8"),
        ("run tetra:1 -s obvhs-cwbvh,uniform-grid --shard 1/2", "at most 1"),
        ("run --resume x --shard 1/2", "--shard"),
        ("merge", "DIR|FILE"),
    ] {
        let ended = run_stepping(arguments);
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
    }
}
