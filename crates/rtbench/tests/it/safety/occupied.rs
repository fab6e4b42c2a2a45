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
fn what_cannot_be_read_is_not_replaced_either() {
    let command = |folder: &Folder, more: &str| {
        run_here(&format!("run tetra:1 {SMALL} -o {} {more}", folder.path()))
    };
    for (name, text, said) in [
        ("results.json", "{\"mine\": 1}", "does not say of which run"),
        ("results.csv", "a,b\n", "does not say of which run"),
        ("run.jsonl", "not a journal\n", "line 1: it has no checksum"),
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
    // nothing is lost with what finished nothing
    let folder = Folder::new();
    assert_eq!(command(&folder, "").0, 0);
    let journal = folder.text("run.jsonl");
    let first: String = journal.split_inclusive('\n').take(2).collect();
    std::fs::write(format!("{}/run.jsonl", folder.path()), resealed(&first)).unwrap();
    for name in ["results.csv", "results.md", "results.json"] {
        std::fs::remove_file(format!("{}/{name}", folder.path())).unwrap();
    }
    assert_eq!(command(&folder, "").0, 0);
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
        format!("scale tetra --sizes 4,16 {SMALL} -o DIR"),
        format!("merge {0}/1 {0}/2 -o DIR", parts.path()),
        format!("baseline save x tetra:1 {SMALL} --force --baselines DIR/of -o DIR"),
        "accuracy mailbox --quick --scene tetra:1 --trials 100 --rounds 3 -o DIR".to_owned(),
        "compare-tracers tetra:1 --quick --size 4 --samples 1 --reference-samples 2 -o DIR"
            .to_owned(),
    ] {
        let folder = Folder::new();
        let command = command.replace("DIR", &folder.path());
        let first = run(&command);
        assert_eq!(first.code, 0, "{command}: {}", first.err);
        let second = run(&command);
        assert_eq!(second.code, 1, "{command}: {}", second.err);
        assert!(second.err.contains("--overwrite"), "{command}: {}", second.err);
        let third = run(&format!("{command} --overwrite"));
        assert_eq!(third.code, 0, "{command}: {}", third.err);
    }
    let alone = run("run tetra:1 --overwrite");
    assert!(alone.code == 2 && alone.err.contains("--output"), "{}", alone.err);
}
