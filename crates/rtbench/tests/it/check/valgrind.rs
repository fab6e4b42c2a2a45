//! Instruction counts, where valgrind is installed.

use measurement::callgrind;

use super::{run_in, with_program};
use crate::common::{Folder, PLANTED};

#[test]
fn instruction_counts_repeat_and_a_planted_3_percent_is_found() {
    let folder = Folder::new();
    let run = |arguments: &str| run_in(&PLANTED, with_program(&folder.path()), arguments);
    let save = "baseline save main tetra:2 --quick --size 8 --rounds 3 -s uniform-grid,obvhs-cwbvh \
                --instructions";
    if let Err(missing) = callgrind::version() {
        eprintln!("SKIPPED, no instruction was counted: {missing}");
        let ended = run(save);
        assert!(ended.code == 1 && ended.err.contains("install valgrind"), "{}", ended.err);
        return;
    }
    let kept = run(save);
    assert_eq!(kept.code, 0, "{}", kept.err);
    let mut json: serde_json::Value = serde_json::from_str(&folder.text("main.json")).unwrap();
    let rows = json["instructions"]["rows"].as_array_mut().unwrap();
    assert_eq!(rows.len(), 2);
    for (row, planted) in rows.iter_mut().zip([1.03, 1.0]) {
        let (build, trace) = (row["build"].as_u64().unwrap(), row["trace"].as_u64().unwrap());
        assert!(build > 1000 && trace > 10_000, "{row}");
        row["trace"] = ((trace as f64 / planted) as u64).into();
    }
    // a record of another length, which is read before anything is counted
    json["command_line"].as_array_mut().unwrap().push("--seed=1".into());
    std::fs::write(format!("{}/main.json", folder.path()), json.to_string()).unwrap();
    let found = run("check --baseline main --all");
    assert_eq!(found.code, 3, "{}{}", found.out, found.err);
    let table = found.out.split("instructions: ").nth(1).unwrap();
    let outcomes: Vec<&str> = table
        .lines()
        .filter(|l| l.starts_with("tetra:2: "))
        .take(4)
        .map(|l| l.split_whitespace().last().unwrap())
        .collect();
    assert_eq!(outcomes, ["unchanged", "regression", "unchanged", "unchanged"], "{table}");
}
