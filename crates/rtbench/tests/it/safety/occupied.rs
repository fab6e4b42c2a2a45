//! Results are not written over unless that is asked for.

use crate::common::{Folder, run};
use crate::resuming::{resealed, run as run_here};

const SMALL: &str = "--size 8 --rounds 1 -s uniform-grid,obvhs-cwbvh";

/// `run small -o X`, then `run tetra:3 -o X`: nine scenes were gone without a word.
#[test]
fn results_of_another_plan_are_not_replaced() {
    let folder = Folder::new();
    let of = |scene: &str, more: &str| {
        run_here(&format!("run {scene} {SMALL} -o {} {more}", folder.path()))
    };
    assert_eq!(of("tetra:1 tetra:2", "").0, 0);
    let (before, journal) = (folder.text("results.json"), folder.text("run.jsonl"));
    for (scene, more, differs) in
        [("tetra:3", "", "scenes"), ("tetra:1 tetra:2", "--seed 5", "settings.seed")]
    {
        let (code, out, err) = of(scene, more);
        assert_eq!((code, out.as_str()), (1, ""), "{err}");
        for part in ["holds results of `rtbench", "this would be `rtbench", differs, "--overwrite"]
        {
            assert!(err.contains(part), "{part}: {err}");
        }
    }
    // the same plan: on with it, or anew
    let (code, _, err) = of("tetra:1 tetra:2", "");
    assert!(code == 1 && err.contains("2 of 2 scenes finished"), "{err}");
    assert!(err.contains("rtbench run --resume") && err.contains("--overwrite"), "{err}");
    assert_eq!((folder.text("results.json"), folder.text("run.jsonl")), (before, journal));
    let (code, _, err) = of("tetra:3", "--overwrite");
    assert_eq!(code, 0, "{err}");
    assert_eq!(folder.record().planned, ["tetra:3"]);
}

#[test]
fn unreadable_results_are_not_replaced() {
    let command = |folder: &Folder, more: &str| {
        run_here(&format!("run tetra:1 {SMALL} -o {} {more}", folder.path()))
    };
    for (name, text, said) in [
        ("results.json", "{\"mine\": 1}", "does not name its run"),
        ("results.csv", "a,b\n", "does not name its run"),
        ("run.jsonl", "not a journal\n", "line 1: no checksum"),
    ] {
        let folder = Folder::new();
        let path = format!("{}/{name}", folder.path());
        std::fs::write(&path, text).unwrap();
        let (code, _, err) = command(&folder, "");
        assert!(code == 1 && err.contains(said) && err.contains(&path), "{name}: {err}");
        assert_eq!(folder.text(name), text);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "nothing was created");
        let (code, _, err) = command(&folder, "--overwrite");
        assert_eq!(code, 0, "{name}: {err}");
    }
    // nothing is lost with what finished nothing, killed before the first file was written, or
    // between two
    let empty = |folder: &Folder| {
        let mut record: serde_json::Value =
            serde_json::from_str(&folder.text("results.json")).unwrap();
        record["scenes"] = serde_json::json!([]);
        record.to_string()
    };
    for written in [0, 1, 2, 3] {
        let folder = Folder::new();
        assert_eq!(command(&folder, "").0, 0);
        let journal = folder.text("run.jsonl");
        let first: String = journal.split_inclusive('\n').take(2).collect();
        let of_nothing = [
            ("results.json", empty(&folder)),
            ("results.csv", "a\n".into()),
            ("results.md", "a\n".into()),
        ];
        let there = |name: &str| format!("{}/{name}", folder.path());
        std::fs::write(there("run.jsonl"), resealed(&first)).unwrap();
        for (i, (name, text)) in of_nothing.into_iter().enumerate() {
            std::fs::write(there(name), if i < written { text } else { String::new() }).unwrap();
        }
        assert_eq!(command(&folder, "").0, 0, "{written} files written");
    }
}

/// All commands that fill a folder.
#[test]
fn every_command_that_fills_a_folder_asks() {
    let parts = Folder::new();
    for shard in [1, 2] {
        let part = format!("run tetra:1 {SMALL} --shard {shard}/2 -o {}/{shard}", parts.path());
        assert_eq!(run(&part.replace("-s uniform-grid", "-s brute-force,uniform-grid")).code, 0);
    }
    for command in [
        format!("run tetra:1 {SMALL} -o DIR"),
        format!("merge {0}/1 {0}/2 -o DIR", parts.path()),
        format!("baseline save x tetra:1 {SMALL} --baselines DIR/of -o DIR"),
        "accuracy mailbox --quick --scene tetra:1 --trials 100 --rounds 3 -o DIR".to_owned(),
        "compare-tracers tetra:1 --quick --size 4 --samples 1 --reference-samples 2 -o DIR"
            .to_owned(),
    ] {
        let folder = Folder::new();
        let command = command.replace("DIR", &folder.path());
        let first = run(&command);
        assert_eq!(first.code, 0, "{command}: {}", first.err);
        let second = run(&command);
        let expected = if command.starts_with("baseline") { 2 } else { 1 };
        assert_eq!(second.code, expected, "{command}: {}", second.err);
        assert!(second.err.contains("--overwrite"), "{command}: {}", second.err);
        let third = run(&format!("{command} --overwrite"));
        assert_eq!(third.code, 0, "{command}: {}", third.err);
    }
}

/// All commands that write a file by the name they are given, or files of known names.
#[test]
fn every_command_that_writes_a_file_asks() {
    let results = Folder::new();
    assert_eq!(run(&format!("run tetra:1 {SMALL} -o {}", results.path())).code, 0);
    let record = results.path();
    for shard in [1, 2] {
        let part = format!("run tetra:1 {SMALL} --shard {shard}/2 -o {record}/{shard}");
        assert_eq!(run(&part.replace("-s uniform-grid", "-s brute-force,uniform-grid")).code, 0);
    }
    let run_exports = ["--export-github-smaller", "--export-github-bigger", "--export-bencher"];
    let mut commands: Vec<(String, &str)> = Vec::new();
    for option in run_exports {
        commands.push((format!("run tetra:1 {SMALL} {option} DIR/file"), "file"));
        commands.push((format!("merge {record}/1 {record}/2 {option} DIR/file"), "file"));
    }
    let sweep = "sweep tetra:1 -s uniform-grid -p density --values 1,2 --rounds 1 --size 4";
    let written = [
        (sweep.to_owned(), &["results.json", "sweep.csv", "sweep.md", "sweep.svg"][..]),
        (format!("sweep tetra --sizes 4,16 {SMALL}"), &["sweep.svg", "slopes.csv"]),
        (format!("check -b {record} --rounds 2"), &["check.json", "check.csv", "check.md"]),
        ("verify --cases G1 -s brute-force --rays 10".to_owned(), &["verify.json", "verify.csv"]),
    ];
    for (command, names) in written {
        commands.extend(names.iter().map(|name| (format!("{command} -o DIR"), *name)));
    }
    commands.extend([
        ("render tetra:1 --size 4 -o DIR/file.png".to_owned(), "file.png"),
        ("render tetra:1 --size 4 -o DIR/file.exr".to_owned(), "file.exr"),
        ("cost tetra:1 --size 4 --heat-maps DIR".to_owned(), "steps.svg"),
        ("generate man -o DIR".to_owned(), "rtbench-check.1"),
        (format!("report {record} -o DIR/file"), "file"),
        (format!("report {record} -o DIR/page --plots DIR"), "bars-tetra_1.svg"),
    ]);
    for (command, name) in commands {
        let folder = Folder::new();
        let command = command.replace("DIR", &folder.path());
        let path = format!("{}/{name}", folder.path());
        std::fs::write(&path, "mine").unwrap();
        let ended = run(&command);
        let said = format!("{path}: exists");
        assert!(ended.code == 1 && ended.err.contains(&said), "{command}: {}", ended.err);
        assert_eq!(folder.text(name), "mine", "{command}");
        // an empty one has nothing to lose
        std::fs::write(&path, "").unwrap();
        for more in ["", " --overwrite"] {
            let ended = run(&format!("{command}{more}"));
            assert!(ended.code == 0, "{command}{more}: {}", ended.err);
            assert!(std::fs::metadata(&path).unwrap().len() > 4, "{command}{more}");
        }
    }
}

/// Output of `report` may be overwritten; a pipe is written to.
#[test]
fn pages_are_replaced_by_pages() {
    let folder = Folder::new();
    let run_words = format!("run tetra:1 {SMALL} -o {}", folder.path());
    assert_eq!(run(&run_words).code, 0);
    let report = format!("report {}", folder.path());
    assert_eq!(run(&report).code, 0);
    assert_eq!(run(&report).code, 0);
    std::fs::write(format!("{}/report.html", folder.path()), "<!DOCTYPE html>\nmine").unwrap();
    let refused = run(&report);
    assert!(refused.code == 1 && refused.err.contains("report.html: exists"));
    assert_eq!(run(&format!("run tetra:1 {SMALL} --export-bencher /dev/null")).code, 0);
}
