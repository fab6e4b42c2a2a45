//! `rtbench.toml`: its sets and defaults in whole runs.

use std::fs;
use std::process::Command;

use crate::common::{Folder, run_stepping};

#[test]
fn sets_and_defaults_are_those_of_the_file() {
    let folder = Folder::new();
    let path = format!("{}/rtbench.toml", folder.path());
    let obj = format!("{}/tri.obj", folder.path());
    fs::write(obj, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(
        &path,
        "[sets]\nsmall = [\"tetra:1\", \"tri.obj\"]\nboth = [\"small\", \"tetra:2\"]\n\
         [run]\nscenes = [\"both\"]\nsize = 8\nrounds = 2\nstructures = \"obvhs-cwbvh\"\n",
    )
    .unwrap();
    let ended = run_stepping(&format!("run --config {path} -o {}/all", folder.path()));
    assert_eq!(ended.code, 0, "{}", ended.err);
    let text = fs::read_to_string(format!("{}/all/results.json", folder.path())).unwrap();
    let record: measurement::record::RunRecord = serde_json::from_str(&text).unwrap();
    assert_eq!(record.planned, ["tetra:1", "tri", "tetra:2"]);
    assert_eq!(record.settings.resolution, [8, 8]);
    assert_eq!(record.scenes[0].rows[0].samples.len(), 2);
    let line = record.command_line.join(" ");
    assert!(line.ends_with("--rounds=2 both --size=8 --structures=obvhs-cwbvh"), "{line}");
    // the journal needs the file no more, but for its sets
    let typed = run_stepping(&format!("run tetra:2 --rounds 3 --config {path} --export-json -"));
    let record: measurement::record::RunRecord = serde_json::from_str(&typed.out).unwrap();
    assert_eq!(record.planned, ["tetra:2"]);
    assert_eq!(record.scenes[0].rows[0].samples.len(), 3);

    let sets = run_stepping(&format!("list sets --config {path}"));
    assert!(sets.out.contains("both") && sets.out.contains("small, tetra:2"), "{}", sets.out);
    let info = run_stepping(&format!("scenes validate small --config {path}"));
    assert!(info.out.contains("tri: can be used"), "{}{}", info.out, info.err);
}

#[test]
fn the_program_finds_the_file_of_its_folder() {
    let folder = Folder::new();
    let below = format!("{}/below", folder.path());
    fs::create_dir(&below).unwrap();
    let path = format!("{}/rtbench.toml", folder.path());
    let list = || {
        let mut program = Command::new(env!("CARGO_BIN_EXE_rtbench"));
        program.args(["list", "sets"]).current_dir(&below).output().unwrap()
    };
    fs::write(&path, "[sets]\nmine = [\"tetra\"]\n").unwrap();
    let listed = list();
    let text = String::from_utf8_lossy(&listed.stdout);
    assert!(text.lines().any(|line| line.starts_with("mine ")), "{listed:?}");
    fs::write(&path, "[stes]\n").unwrap();
    let refused = list();
    let text = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(2), "{text}");
    assert!(text.contains("line 1: unknown field `stes`"), "{text}");
    assert!(text.contains("(did you mean 'sets'?)"), "{text}");
}

#[test]
fn what_is_wrong_in_it_is_a_usage_error() {
    let folder = Folder::new();
    let path = format!("{}/rtbench.toml", folder.path());
    fs::write(&path, "[run]\nrunds = 3\n").unwrap();
    let ended = run_stepping(&format!("run tetra:1 --config {path}"));
    assert_eq!(ended.code, 2);
    assert!(ended.err.contains("line 2") && ended.err.contains("'rounds'"), "{}", ended.err);
    fs::write(&path, "[sets]\na = [\"tetrra\"]\n").unwrap();
    let ended = run_stepping(&format!("run a --config {path}"));
    assert!(ended.code == 2 && ended.err.contains("did you mean `tetra`?"), "{}", ended.err);
}
