//! Records in `results/`: the README beside each names its commit, and the warnings that the record
//! has.

use std::path::Path;

use crate::common::files_below;

/// Letters of a commit that name it.
const SHORT: usize = 7;

/// What a README does not say of its record, of which these are the tables.
fn unsaid(readme: &str, tables: &str) -> Vec<String> {
    let facts = || tables.lines().filter_map(|line| line.strip_prefix("- "));
    let program = facts().find_map(|fact| fact.strip_prefix("rtbench ")?.split_once(" at "));
    let commit = program.and_then(|(_, commit)| commit.get(..SHORT)).unwrap_or("unknown");
    let mut unsaid = Vec::new();
    if !readme.contains(commit) {
        unsaid.push(format!("commit {commit}"));
    }
    // `warning: other load: ...`; lines may break between its words
    let words: Vec<&str> = readme.split_whitespace().collect();
    let readme = words.join(" ").to_lowercase();
    let warnings = facts().filter_map(|fact| fact.strip_prefix("warning: ")?.split(':').next());
    let unsaid_ones = warnings.filter(|warning| !readme.contains(warning));
    unsaid.extend(unsaid_ones.map(|warning| format!("warning {warning}")));
    unsaid
}

#[test]
fn each_readme_names_the_commit_and_the_warnings_of_its_record() {
    let results = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../results");
    let mut found = files_below(&results);
    found.retain(|path| path.file_name().is_some_and(|name| name == "results.md"));
    assert!(!found.is_empty());
    let mut wrong = Vec::new();
    for path in &found {
        let folders = path.ancestors().skip(1).take_while(|folder| *folder != results);
        let readme = folders.map(|folder| folder.join("README.md")).find(|readme| readme.exists());
        let readme = readme.unwrap_or_else(|| panic!("{}: no README", path.display()));
        let read = |path: &Path| std::fs::read_to_string(path).unwrap();
        let unsaid = unsaid(&read(&readme), &read(path));
        if !unsaid.is_empty() {
            wrong.push(format!("{}: {}", readme.display(), unsaid.join(", ")));
        }
    }
    assert!(wrong.is_empty(), "not said of the record: {wrong:#?}");
}

#[test]
fn a_readme_that_contradicts_its_record_is_found() {
    let tables =
        "# results\n\n- rtbench 0.1.0 at 0123456789abcdef\n- warning: noisy machine: by 50%\n";
    assert_eq!(unsaid("Built at 0123456; a noisy\nmachine.", tables), Vec::<String>::new());
    // planted: nothing else was running, and another commit
    let found = unsaid("Built at 0123457, nothing else running.", tables);
    assert_eq!(found, ["commit 0123456", "warning noisy machine"]);
}
