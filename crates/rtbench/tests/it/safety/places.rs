//! Non-files are refused at once: reading a pipe without a writer would block forever.
#![cfg(unix)]

use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::Command;
use std::sync::mpsc;
use std::time::Duration;

use crate::common::run;
use crate::resuming::show;

/// Non-files that may lie where a file is expected.
const PLACES: [(&str, &str); 4] =
    [("pipe", "a pipe"), ("socket", "a socket"), ("device", "a device"), ("folder", "a folder")];

fn make(kind: &str, path: &Path) {
    match kind {
        "pipe" => assert!(Command::new("mkfifo").arg(path).status().unwrap().success()),
        "socket" => drop(UnixListener::bind(path).unwrap()),
        "device" => std::os::unix::fs::symlink("/dev/zero", path).unwrap(),
        _ => std::fs::create_dir(path).unwrap(),
    }
}

/// Runs; a minute is no measurement, but the end of waiting.
fn ends(arguments: String) -> (u8, String) {
    let (sender, receiver) = mpsc::channel();
    let said = arguments.clone();
    std::thread::spawn(move || {
        let ended = run(&arguments);
        let _ = sender.send((ended.code, ended.err));
    });
    receiver.recv_timeout(Duration::from_secs(60)).unwrap_or_else(|_| panic!("waits: {said}"))
}

#[test]
fn results_that_are_no_files_are_refused_at_once() {
    let folder = tempfile::tempdir().unwrap();
    for (kind, said) in PLACES {
        let here = folder.path().join(kind);
        std::fs::create_dir(&here).unwrap();
        make(kind, &here.join("results.json"));
        let here = show(&here);
        for command in [
            format!("compare {here} {here}"),
            format!("compare {here}/results.json {here}"),
            format!("report {here}"),
            format!("merge {here} {here}"),
            format!("check --baseline {here}/results.json"),
            format!("baseline save x --from {here} --baselines {here}/baselines"),
            format!("run tetra:1 -s obvhs-cwbvh --size 4 -o {here}"),
            format!("run tetra:1 -s obvhs-cwbvh --size 4 -o {here} --overwrite"),
        ] {
            if kind == "folder" && command.starts_with("compare") && command.contains("json") {
                // a folder named so is the output folder of a run
                continue;
            }
            let (code, err) = ends(command.clone());
            assert_eq!(code, 1, "{command}: {err}");
            let named = err.contains("results.json") && err.contains(said);
            assert!(named || kind == "folder" && err.contains("results.json"), "{command}: {err}");
        }
    }
}

#[test]
fn other_outputs_must_be_regular_files_too() {
    let folder = tempfile::tempdir().unwrap();
    for name in ["run.jsonl", "results.csv", "results.md"] {
        let here = folder.path().join(name);
        std::fs::create_dir(&here).unwrap();
        make("pipe", &here.join(name));
        let command = format!("run tetra:1 -s obvhs-cwbvh --size 4 -o {} --overwrite", show(&here));
        let (code, err) = ends(command);
        assert!(code == 1 && err.contains(name) && err.contains("a pipe"), "{err}");
    }
    let journal = folder.path().join("run.jsonl");
    let (code, err) = ends(format!("run --resume {}", show(&journal)));
    assert!(code == 1 && err.contains("not a regular file"), "{err}");
}
