//! Records in `results/`: the README beside each names its commit, and the warnings that the record
//! has; what a page shows of a record stands there.

use std::path::Path;

use super::documents::{chapters, root, text_of};
use super::typed::numbers;
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

/// Lines that a page shows of a record, behind `<!-- record: PATH -->`: a block or a table.
fn shown_records(text: &str) -> Vec<(String, Vec<&str>)> {
    let mark = "<!-- record: ";
    let parts = text.split(mark).skip(1);
    parts
        .map(|part| {
            let (path, rest) = part.split_once(" -->\n").expect("a path");
            let is_block = rest.starts_with("```");
            let lines = rest.lines().skip(usize::from(is_block));
            let lines = lines.take_while(|line| !line.starts_with("```") && !line.is_empty());
            (path.to_owned(), lines.collect())
        })
        .collect()
}

/// Text with single spaces, without the marks of Markdown.
fn plain(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words.join(" ").replace(['`', '*', '\\'], "")
}

/// Lines of a page that its record does not have. Of a table each row must be a row of the record,
/// with all its numbers; of a block each line, with its continuations, but for the question at its
/// beginning.
fn unrecorded(lines: &[&str], record: &str) -> Vec<String> {
    if lines.first().is_some_and(|line| line.starts_with('|')) {
        let label = |row: &str| plain(row.split('|').nth(1).unwrap_or_default());
        let rows: Vec<&str> = record.lines().filter(|line| line.starts_with('|')).collect();
        let is_there = |row: &str| {
            let wanted = numbers(row, true);
            let has_all = |of: &str| {
                let there = numbers(of, false);
                wanted.iter().all(|number| there.contains(number))
            };
            rows.iter().any(|of| label(of) == label(row) && has_all(of))
        };
        let rows = lines.iter().skip(2);
        return rows.filter(|row| !is_there(row)).map(|row| (*row).to_owned()).collect();
    }
    let mut entries: Vec<String> = Vec::new();
    for line in lines {
        let indent = line.len() - line.trim_start().len();
        match entries.last_mut() {
            Some(entry) if indent > 2 => *entry += &format!(" {}", line.trim()),
            _ => entries.push(line.trim().split("  ").last().unwrap_or_default().to_owned()),
        }
    }
    let record = plain(record);
    entries.retain(|entry| !record.contains(&plain(entry)));
    entries
}

#[test]
fn what_pages_show_of_records_stands_there() {
    let mut wrong = Vec::new();
    let mut shown = 0;
    for document in chapters().into_iter().chain(["README.md".to_owned()]) {
        let text = text_of(&document);
        for (path, lines) in shown_records(&text) {
            let record = std::fs::read_to_string(root().join(&path)).expect(&path);
            shown += lines.len();
            let lines = unrecorded(&lines, &record);
            wrong.extend(lines.iter().map(|line| format!("{document}: not in {path}: {line}")));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(shown > 20, "{shown}");
}

#[test]
fn a_figure_that_is_not_in_its_record_is_found() {
    let record = "- first image: `a` 1.5 ms [1, 2]; next: b\n\n| row | x |\n| --- | --- |\n\
                  | a k=1 | 2.50 [2, 3] |\n| b | 4.5 |\n";
    let page = "<!-- record: r.md -->\n```text\n  first image  a 1.5 ms\n      [1, 2]; next: b\n```\n\
                <!-- record: r.md -->\n| row | x |\n| --- | --- |\n| `a k=1` | 2.50 |\n| b | 2.50 |\n";
    let shown = shown_records(page);
    assert_eq!(unrecorded(&shown[0].1, record), Vec::<String>::new());
    // planted: a figure of another row
    assert_eq!(unrecorded(&shown[1].1, record), ["| b | 2.50 |"]);
    // planted: an older figure
    assert_eq!(unrecorded(&["  first image  a 1.4 ms [1, 2]"], record), ["a 1.4 ms [1, 2]"]);
}
