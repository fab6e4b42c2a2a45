//! Recorded runs: a folder for each study, without a day in its name, so that a new record replaces
//! the old one; tables and CSV files only; a README and a line in `results/README.md` for each; 4
//! MB.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::files_below;

/// Most bytes of all.
const MOST: u64 = 4_000_000;
/// Endings of what is kept. Raw samples, plots and images are in the history.
const KEPT: [&str; 3] = ["md", "csv", "txt"];

/// Faults of files, given by paths within `results/` and sizes, and of the index.
fn faults(files: &[(String, u64)], index: &str) -> Vec<String> {
    let mut faults = Vec::new();
    let bytes: u64 = files.iter().map(|(_, bytes)| bytes).sum();
    if bytes > MOST {
        faults.push(format!("{bytes} bytes, at most {MOST}"));
    }
    let listed: BTreeSet<&str> =
        index.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    let is_kept = |path: &str| KEPT.iter().any(|ending| path.ends_with(&format!(".{ending}")));
    faults.extend(files.iter().filter(|(path, _)| !is_kept(path)).map(|(path, _)| path.clone()));
    let folders: BTreeSet<&str> =
        files.iter().filter_map(|(path, _)| Some(path.split_once('/')?.0)).collect();
    for folder in &folders {
        if !files.iter().any(|(path, _)| *path == format!("{folder}/README.md")) {
            faults.push(format!("{folder} has no README.md"));
        }
        if folder.starts_with(|c: char| c.is_ascii_digit()) {
            faults.push(format!("{folder} has a day in its name: the next record replaces none"));
        }
    }
    faults.extend(listed.symmetric_difference(&folders).map(|name| format!("{name}: index")));
    faults
}

/// The paths of all files of a folder within it, and their sizes.
fn sizes_in(folder: &Path) -> Vec<(String, u64)> {
    let size = |path: PathBuf| {
        let within = path.strip_prefix(folder).unwrap().to_str().unwrap().replace('\\', "/");
        (within, path.metadata().unwrap().len())
    };
    files_below(folder).into_iter().map(size).collect()
}

#[test]
fn a_record_replaces_that_of_its_study() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results");
    let index = fs::read_to_string(folder.join("README.md")).unwrap();
    assert_eq!(faults(&sizes_in(&folder), &index), [""; 0]);
}

#[test]
fn planted_records_are_named() {
    let index = "| folder | what |\n| `speed` | a set |\n";
    let sound = [("README.md", 9), ("speed/README.md", 9), ("speed/results.csv", 9)];
    let with = |more: &[(&str, u64)]| {
        let files = sound.iter().chain(more).map(|(path, bytes)| ((*path).to_owned(), *bytes));
        faults(&files.collect::<Vec<_>>(), index).join("; ")
    };
    assert_eq!(with(&[]), "");
    for (path, bytes, said) in [
        ("speed/results.json", 9, "speed/results.json"),
        ("speed/plot.svg", 9, "speed/plot.svg"),
        ("speed/all.csv", MOST, "at most"),
        ("2026-11-26-speed/README.md", 9, "a day in its name"),
        ("tests/README.md", 9, "tests: index"),
        ("tests/results.csv", 9, "tests has no README.md"),
    ] {
        assert!(with(&[(path, bytes)]).contains(said), "{path}: {}", with(&[(path, bytes)]));
    }
    assert_eq!(faults(&[], index), ["speed: index"]);
}
