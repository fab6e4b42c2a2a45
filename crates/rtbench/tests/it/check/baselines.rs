//! Baselines: kept, listed, shown, promoted, removed.

use super::{in_folder, run_in, saved};
use crate::common::{Folder, PLANTED};

#[test]
fn a_baseline_is_kept_listed_shown_promoted_and_removed() {
    let folder = Folder::new();
    let path = folder.path();
    let run = |arguments: &str| run_in(&PLANTED, in_folder(&path), arguments);
    assert!(!run("baseline list").out.contains("tetra"));
    saved(&path, "branch");
    let listed = run("baseline list").out;
    let line = listed.lines().find(|l| l.starts_with("branch ")).unwrap();
    let cells: Vec<&str> = line.split_whitespace().collect();
    assert_eq!(cells[1..5], ["1", "2", "15", "-"], "{listed}");
    let shown = run("baseline show branch");
    assert!(shown.code == 0 && shown.out.contains("tetra:2:"), "{}", shown.out);
    assert_eq!(run("baseline promote branch main").code, 0);
    assert_eq!(folder.text("branch.json"), folder.text("main.json"));
    assert_eq!(run("baseline remove branch").code, 0);
    assert!(!std::path::Path::new(&path).join("branch.json").exists());
    // nothing is left behind
    assert_eq!(std::fs::read_dir(&path).unwrap().count(), 1);
}

#[test]
fn invalid_baseline_requests_fail_before_measuring() {
    let folder = Folder::new();
    let path = folder.path();
    saved(&path, "main");
    for (arguments, code, said) in [
        ("baseline save main tetra:2", 2, "--overwrite"),
        ("baseline save ../main tetra:2", 2, "letters"),
        ("baseline show mian", 2, "did you mean 'main'?"),
        ("baseline remove other", 2, "there are: main"),
        ("baseline promote main .x", 2, "letters"),
        ("baseline save new --from /nowhere", 1, "/nowhere"),
        ("baseline save new --resume x", 2, "--from DIR"),
        ("check --baseline mian", 2, "did you mean 'main'?"),
        ("check", 2, "--baseline"),
        ("check teapot --against old --against older", 2, "expected one binary"),
        ("check --baseline main --instructions=maybe", 2, "true, false"),
        ("check teapot --against old -- --frames", 2, "unknown scene"),
        ("check --baseline main teapot", 2, "it has: tetra:2"),
        ("check --baseline main -s unifrom-grid", 2, "did you mean 'uniform-grid'?"),
        ("check --baseline main --quick", 2, "--quick"),
        ("check --baseline main --significance 2", 2, "between 0 and 1"),
        ("check --baseline main -t much", 2, "percent"),
        ("check --baseline main -t 5", 2, "5%"),
        ("check --baseline main --instructions", 1, "has no instruction counts"),
    ] {
        let ended = run_in(&PLANTED, in_folder(&path), arguments);
        assert_eq!(ended.code, code, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
        assert_eq!(ended.out, "", "{arguments}");
    }
}

#[test]
fn an_earlier_run_can_be_kept_and_half_a_run_cannot() {
    let (runs, folder) = (Folder::new(), Folder::new());
    let run = |arguments: &str| run_in(&PLANTED, in_folder(&folder.path()), arguments);
    let arguments = format!("run tetra:2 --quick --size 16 -s obvhs-cwbvh -o {}", runs.path());
    assert_eq!(run(&arguments).code, 0);
    let save = format!("baseline save main --from {}", runs.path());
    assert_eq!(run(&save).code, 0);
    assert!(folder.text("main.json").contains("obvhs-cwbvh"));
    // a file serves as a baseline, too
    let check = format!("check --baseline {}/results.json", runs.path());
    assert_eq!(run(&check).code, 0, "{}", run(&check).err);
    let half = runs.text("results.json").replace("\"complete\": true", "\"complete\": false");
    std::fs::write(format!("{}/results.json", runs.path()), half).unwrap();
    let refused = run(&format!("{save} --overwrite"));
    assert!(refused.code == 1 && refused.err.contains("--resume"), "{}", refused.err);
    std::fs::write(format!("{}/main.json", folder.path()), "{\"schema_version\": 1").unwrap();
    let damaged = run("baseline list");
    assert!(damaged.code == 1 && damaged.err.contains("main.json: line 1"), "{}", damaged.err);
}

#[test]
fn wrong_hits_are_not_kept() {
    let folder = Folder::new();
    let arguments = "baseline save main tetra:2 --quick --size 16 -s dropper,obvhs-cwbvh";
    let ended = run_in(&PLANTED, in_folder(&folder.path()), arguments);
    assert_eq!(ended.code, 4);
    assert!(ended.err.contains("not saved"), "{}", ended.err);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

#[test]
fn a_baseline_with_a_camera_is_checked_through_it() {
    let folder = Folder::new();
    let run = |arguments: &str| run_in(&PLANTED, in_folder(&folder.path()), arguments);
    let options = "--quick --size 16 -s obvhs-cwbvh --rounds 2";
    let saved =
        run(&format!("baseline save main tetra:2 {options} --light 3,4,5 --camera 2,2,2:0,0,0"));
    assert_eq!(saved.code, 0, "{}", saved.err);
    let same = run("check --baseline main");
    assert!(!same.err.contains("sha256") && !same.err.contains("view:"), "{}", same.err);
    assert!([0, 5].contains(&same.code), "{}: {}", same.code, same.err);
    let other = run("check --baseline main --light 9,9,9");
    assert!(other.code == 1 || other.code == 2, "{}: {}", other.code, other.out);
    assert!(other.err.contains("view: --camera=2,2,2:0,0,0"), "{}", other.err);
}
