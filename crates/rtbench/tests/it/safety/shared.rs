//! Two outputs that are one file, and an output that is a result that is read: refused before
//! anything is measured.

use crate::common::{Folder, run_stepping};

#[test]
fn two_outputs_to_one_file_are_refused_before_measuring() {
    let folder = Folder::new();
    let path = folder.path();
    let run = "run tetra:1 --size 8 -s obvhs-cwbvh";
    for outputs in [
        "--export-bencher DIR/x --export-github-bigger DIR/x",
        "--export-bencher DIR/x --export-github-bigger DIR/./x",
        "--export-bencher DIR/new/x --export-github-smaller DIR/new/x",
        "-o DIR/out --export-bencher DIR/out/results.json",
        "-o DIR/out --export-github-bigger DIR/out/results.json",
        "-o DIR/out --export-bencher DIR/out/run.jsonl",
    ] {
        for more in ["", " --overwrite"] {
            let ended = run_stepping(&format!("{run} {}{more}", outputs.replace("DIR", &path)));
            assert_eq!((ended.code, ended.out.as_str()), (2, ""), "{outputs}: {}", ended.err);
            assert!(ended.err.contains("two outputs"), "{outputs}: {}", ended.err);
            assert_eq!(std::fs::read_dir(&path).unwrap().count(), 0, "{outputs}");
        }
    }
    let null = "--export-bencher /dev/null --export-github-bigger /dev/null";
    let devices = run_stepping(&format!("{run} {null}"));
    assert_eq!(devices.code, 0, "{}", devices.err);
}

#[test]
fn a_dash_is_no_file_and_a_name_is_of_one_scene() {
    let folder = Folder::new();
    let path = folder.path();
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    for place in ["a", "b"] {
        std::fs::create_dir(format!("{path}/{place}")).unwrap();
        std::fs::write(format!("{path}/{place}/hall.obj"), corners).unwrap();
    }
    for (command, said) in [
        ("run tetra:1 --size 8 -s obvhs-cwbvh --export-bencher -", "'-' is standard output"),
        ("rays export tetra:1 --size 8 -o -", "'-' is standard output"),
        ("run DIR/a/hall.obj DIR/b/hall.obj --size 8", "two scenes are named hall"),
    ] {
        let ended = run_stepping(&command.replace("DIR", &path));
        assert_eq!((ended.code, ended.out.as_str()), (2, ""), "{command}: {}", ended.err);
        assert!(ended.err.contains(said), "{command}: {}", ended.err);
    }
    let twice = "run DIR/a/hall.obj DIR/a/hall.obj --size 8 -s obvhs-cwbvh";
    let ended = run_stepping(&twice.replace("DIR", &path));
    assert_eq!(ended.code, 0, "{}", ended.err);
}

#[test]
fn no_output_destroys_a_record() {
    let folder = Folder::new();
    let path = folder.path();
    let of = |arguments: &str| run_stepping(&arguments.replace("DIR", &path));
    for name in ["a", "b"] {
        let ended = of(&format!("run tetra:1 --size 8 -s obvhs-cwbvh -o DIR/{name}"));
        assert_eq!(ended.code, 0, "{}", ended.err);
    }
    let record = folder.text("a/results.json");
    std::fs::create_dir(format!("{path}/c")).unwrap();
    std::fs::write(format!("{path}/c/check.json"), &record).unwrap();
    #[cfg(unix)]
    {
        std::fs::create_dir(format!("{path}/linked")).unwrap();
        std::os::unix::fs::symlink("../a/results.json", format!("{path}/linked/check.json"))
            .unwrap();
    }
    let mut refused = vec![
        "run --resume DIR/a --export-bencher DIR/a/results.json",
        "report DIR/a -o DIR/a/results.json",
        "check --baseline DIR/c/check.json --results DIR/a -o DIR/c",
        "check --baseline DIR/a --results DIR/c/check.json -o DIR/c",
    ];
    if cfg!(unix) {
        refused.push("check -b DIR/b --results DIR/a -o DIR/linked");
    }
    for arguments in refused {
        let ended = of(&format!("{arguments} --overwrite"));
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains("this file"), "{arguments}: {}", ended.err);
        for name in ["a/results.json", "c/check.json"] {
            assert_eq!(folder.text(name), record, "{arguments}");
        }
    }
}

#[test]
fn a_selection_of_no_series_is_an_error_before_measuring() {
    let folder = Folder::new();
    let path = folder.path();
    let run = |select: &str| {
        run_stepping(&format!(
            "run tetra:1 --size 8 -s obvhs-cwbvh --export-select {select} --export-bencher {path}/x"
        ))
    };
    let nothing = run("kd-tere");
    assert_eq!((nothing.code, nothing.out.as_str()), (2, ""), "{}", nothing.err);
    assert!(nothing.err.contains("'kd-tere' matches no series"), "{}", nothing.err);
    assert!(nothing.err.contains("tetra:1: obvhs-cwbvh / "), "{}", nothing.err);
    assert_eq!(std::fs::read_dir(&path).unwrap().count(), 0);
    assert_eq!(run("cwbvh./.mrays-primary").code, 0);
}
