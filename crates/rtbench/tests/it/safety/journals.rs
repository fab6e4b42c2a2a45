//! A journal is a file that anybody may have edited: nothing of it is believed unseen.

use std::path::Path;

use measurement::journal::NAME;

use crate::resuming::{resealed, run, show};

const ARGUMENTS: &str = "run tetra:1 tetra:2 --size 8 --rounds 2 --seed 7 \
                         -s uniform-grid:density=1,obvhs-cwbvh";

/// The line with the first scene's record, from 1: before it are the manifest, the scene's
/// beginning, and three times those of its two rows and that they passed: checked, timed, rendered.
const FINISHED: usize = 12;

/// A run in a new folder of which the last scene is missing, and its journal.
fn broken_off(more: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let (code, _, err) = run(&format!("{ARGUMENTS} -o {} {more}", show(folder.path())));
    assert_eq!(code, 0, "{err}");
    let text = std::fs::read_to_string(folder.path().join(NAME)).unwrap();
    let kept: String = text.split_inclusive('\n').take(FINISHED).collect();
    std::fs::write(folder.path().join(NAME), &kept).unwrap();
    (folder, kept)
}

fn resumed(folder: &Path, journal: &str) -> (u8, String) {
    std::fs::write(folder.join(NAME), journal).unwrap();
    let (code, _, err) = run(&format!("run --resume {}", show(folder)));
    (code, err)
}

/// Every 97th byte of each line, one at a time: 147 of 250 such edits were resumed to exit code 0.
#[test]
fn an_edited_journal_is_an_error_that_names_the_line() {
    let (folder, journal) = broken_off("");
    let (mut edits, mut start) = (0, 0);
    for (number, line) in journal.split_inclusive('\n').enumerate() {
        for at in (0..line.len() - 1).step_by(97) {
            let mut edited = journal.clone().into_bytes();
            let byte = &mut edited[start + at];
            *byte = if byte.is_ascii_digit() { b'0' + (*byte - b'0' + 1) % 10 } else { *byte ^ 2 };
            let (code, err) = resumed(folder.path(), &String::from_utf8(edited).unwrap());
            assert_eq!(code, 1, "line {} byte {at}: {err}", number + 1);
            let place = format!("{NAME}: line {}: ", number + 1);
            assert!(err.contains(&place), "line {} byte {at}: {err}", number + 1);
            edits += 1;
        }
        start += line.len();
    }
    assert!(edits > 50, "{edits}");
    let (code, err) = resumed(folder.path(), &journal);
    assert_eq!(code, 0, "unedited: {err}");
}

/// With checksums that fit, too: the plan says what a scene must have.
#[test]
fn records_that_contradict_the_plan_are_errors_with_their_line() {
    let (folder, journal) = broken_off("");
    let row = journal.split("\"rows\":[{\"structure\":\"uniform-grid\"").nth(1);
    assert!(row.is_some(), "{journal}");
    let last_row = journal.rfind(",{\"structure\":\"obvhs-cwbvh\"").unwrap();
    let end = journal.rfind("],\"peak_rss_bytes\"").unwrap();
    let without_last = format!("{}{}", &journal[..last_row], &journal[end..]);
    for (edited, said) in [
        (journal.replace("\"name\":\"tetra:1\"", "\"name\":\"tetra:9\""), "is tetra:1, its record"),
        (
            journal.replace("\"structure\":\"uniform-grid\"", "\"structure\":\"octree\""),
            "no further row octree density=1",
        ),
        (
            journal.replace(
                "\"structure\":\"obvhs-cwbvh\",\"settings\":\"\"",
                "\"structure\":\"uniform-grid\",\"settings\":\"density=1\"",
            ),
            "no further row uniform-grid density=1",
        ),
        (journal.replace("{\"finished\":{\"scene\":0", "{\"finished\":{\"scene\":1"), "is tetra:2"),
        (
            journal.replace("{\"finished\":{\"scene\":0", "{\"finished\":{\"scene\":7"),
            "scene 7 of 2",
        ),
        (without_last, "scene tetra:1: 1 of 2 rows"),
    ] {
        assert_ne!(edited, journal, "{said}");
        let (code, err) = resumed(folder.path(), &resealed(&edited));
        assert!(
            code == 1 && err.contains(&format!("line {FINISHED}: ")) && err.contains(said),
            "{said}: {err}"
        );
    }
}

/// A line of another run has a checksum, but not of this one.
#[test]
fn lines_of_another_run_are_rejected() {
    let (folder, journal) = broken_off("");
    let (_other, other) = broken_off("--pass-limit 100ms");
    let lines = |text: &str| text.split_inclusive('\n').map(str::to_owned).collect::<Vec<_>>();
    let (ours, theirs) = (lines(&journal), lines(&other));
    let last = FINISHED - 1;
    let mixed = ours[..last].concat() + &theirs[last];
    let (code, err) = resumed(folder.path(), &mixed);
    assert!(code == 1 && err.contains(&format!("line {FINISHED}: wrong checksum")), "{err}");
}

/// An edited journal wrote where it liked: what it names is not written, what the command line
/// names is.
#[test]
fn output_files_come_from_the_command_line() {
    let out = tempfile::tempdir().unwrap();
    let (first, second) = (out.path().join("first.json"), out.path().join("second.json"));
    let (folder, journal) = broken_off(&format!("--export-bencher {}", show(&first)));
    std::fs::write(&first, "mine").unwrap();
    let (code, err) = resumed(folder.path(), &journal);
    assert_eq!(code, 0, "{err}");
    assert_eq!(std::fs::read_to_string(&first).unwrap(), "mine");
    assert!(err.contains("first.json belongs to this run but is no longer written"), "{err}");
    std::fs::write(folder.path().join(NAME), &journal).unwrap();
    let again = format!("run --resume {} --export-bencher {}", show(folder.path()), show(&second));
    let (code, _, err) = run(&again);
    assert_eq!(code, 0, "{err}");
    assert!(std::fs::read_to_string(&second).unwrap().contains("tetra:1: "));
}
