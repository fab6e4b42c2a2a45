//! README.md and docs/: what they name lies there, the table of contents has every chapter, exercises
//! have answers, and nothing that is published names a folder of somebody's machine.

use std::path::{Path, PathBuf};

use crate::common::files_below;

/// Folders of the repository, as documents name what is in them.
const FOLDERS: [&str; 9] = [
    "crates/", "docs/", "fuzz/", "peers/", "proofs/", "results/", "scenes/", "scripts/", ".github/",
];

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The chapters, as documents are named.
pub fn chapters() -> Vec<String> {
    let files = std::fs::read_dir(root().join("docs")).unwrap();
    let names = files.map(|file| file.unwrap().file_name().into_string().unwrap());
    let mut chapters: Vec<String> =
        names.filter(|name| name.ends_with(".md")).map(|name| format!("docs/{name}")).collect();
    chapters.sort();
    chapters
}

pub fn text_of(document: &str) -> String {
    std::fs::read_to_string(root().join(document)).unwrap_or_else(|e| panic!("{document}: {e}"))
}

/// The lines of the fenced blocks of a language; of a workflow, all lines.
pub fn blocks(text: &str, language: &str) -> Vec<String> {
    let mut lines = Vec::new();
    let mut fence: Option<bool> = None;
    for line in text.lines() {
        match (line.trim_start().strip_prefix("```"), fence) {
            (Some(of), None) => fence = Some(of.trim() == language),
            (Some(_), Some(_)) => fence = None,
            (None, Some(true)) => lines.push(line.to_owned()),
            _ => {}
        }
    }
    lines
}

/// Joins lines that end in a backslash with the next.
pub fn joined(lines: &[String]) -> Vec<String> {
    lines.join("\n").replace("\\\n", " ").lines().map(str::to_owned).collect()
}

/// The files and folders of the repository that a text names.
fn named_files(text: &str) -> Vec<String> {
    let quoted = text.split('`').skip(1).step_by(2);
    let linked = text.split("](").skip(1).filter_map(|rest| rest.split(')').next());
    let in_folder = |name: &&str| FOLDERS.iter().any(|folder| name.starts_with(folder));
    let is_local = |link: &&str| !link.contains("://") && !link.starts_with('#');
    let linked = linked.filter(is_local).filter_map(|link| link.split('#').next());
    let names = quoted.filter(in_folder).chain(linked);
    names.filter(|name| !name.contains([' ', '*', '\n'])).map(str::to_owned).collect()
}

#[test]
fn files_named_in_documents_exist() {
    let others = [("README.md", 10), ("CONTRIBUTING.md", 5), ("CHANGELOG.md", 1)];
    let chapters = chapters();
    let chapters = chapters.iter().map(|chapter| (chapter.as_str(), 0));
    for (document, least) in others.into_iter().chain(chapters) {
        let folder = root().join(document).parent().unwrap().to_owned();
        let names = named_files(&text_of(document));
        assert!(names.len() >= least, "{document}: {names:?}");
        for name in names.iter().filter(|name| !name.contains("NAME")) {
            let lies_there = root().join(name).exists() || folder.join(name).exists();
            assert!(lies_there, "{document} names {name}, which is not there");
        }
    }
    let planted =
        named_files("`scripts/none.sh` [a](docs/none.md#x) [b](https://x) `run` `scenes/*`");
    assert_eq!(planted, ["scripts/none.sh", "docs/none.md"]);
}

#[test]
fn the_readme_is_short_and_the_book_has_every_chapter() {
    let readme = text_of("README.md");
    assert!(readme.lines().count() <= 150, "{} lines", readme.lines().count());
    assert!(readme.contains("](docs/README.md)"), "README.md does not link the table of contents");
    let contents = text_of("docs/README.md");
    let chapters = chapters();
    assert!(chapters.len() > 10, "{chapters:?}");
    for chapter in chapters.iter().filter_map(|c| c.strip_prefix("docs/")) {
        let is_there = chapter == "README.md" || contents.contains(&format!("]({chapter})"));
        assert!(is_there, "docs/README.md does not link {chapter}");
    }
}

/// Words that a reader has time for.
const WORDS: usize = 20_000;

/// Pictures that pages show, with what is said for those who cannot see them.
fn shown_pictures(text: &str) -> Vec<(&str, &str)> {
    let shown = text.split("![").skip(1).filter_map(|rest| rest.split_once("]("));
    shown.filter_map(|(said, rest)| Some((said, rest.split(')').next()?))).collect()
}

#[test]
fn the_book_is_short_and_shows_each_picture_in_words_too() {
    let mut pages: Vec<String> = chapters().iter().map(|chapter| text_of(chapter)).collect();
    let words: usize = pages.iter().map(|page| page.split_whitespace().count()).sum();
    assert!(words <= WORDS, "{words}");
    pages.extend(["README.md", "proofs/README.md"].map(text_of));
    let shown: Vec<(&str, &str)> = pages.iter().flat_map(|page| shown_pictures(page)).collect();
    let unsaid: Vec<_> = shown.iter().filter(|(said, _)| said.len() < 20).collect();
    assert!(unsaid.is_empty(), "{unsaid:?}");
    for file in files_below(&root().join("docs/pictures")) {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let is_shown = shown.iter().any(|(_, path)| path.rsplit('/').next() == Some(&*name));
        assert!(is_shown, "no page shows {name}");
    }
    let planted = shown_pictures("a ![A teapot](pictures/a.svg), ![](b.png)");
    assert_eq!(planted, [("A teapot", "pictures/a.svg"), ("", "b.png")]);
}

/// Names in the first column of the table below a heading.
fn first_column(text: &str, heading: &str) -> Vec<String> {
    let below = text.split(heading).nth(1).unwrap_or_default();
    let rows = below.lines().skip_while(|line| !line.starts_with('|'));
    let cells =
        rows.take_while(|line| line.starts_with('|')).filter_map(|row| row.split('|').nth(1));
    let names = cells.flat_map(|cell| cell.split('`').skip(1).step_by(2));
    names.map(str::to_owned).collect()
}

#[test]
fn the_columns_of_the_csv_are_described_in_their_order() {
    let described = first_column(&text_of("docs/reading.md"), "## Columns of the CSV");
    let columns: Vec<&str> = crate::results::HEADER.split(',').collect();
    assert_eq!(described, columns);
    let planted = "## C\n\n| column |\n| --- |\n| `a` `b` | the `c` |\n\n| `d` |\n";
    assert_eq!(first_column(planted, "## C"), ["a", "b"]);
}

#[test]
fn the_glossary_is_linked_and_whole() {
    let text = text_of("docs/reading.md");
    let glossary = text.split("## Glossary").nth(1).unwrap_or_default();
    let terms = glossary.lines().filter(|line| line.starts_with("| ")).count() - 2;
    assert!(terms >= 30, "{terms}");
    let links = chapters().iter().map(|c| text_of(c).matches("#glossary)").count()).sum::<usize>();
    assert!(links >= 5, "{links}");
}

/// Faults of the exercises of a text: one without a command, or without a folded answer.
fn unanswered(text: &str) -> Vec<String> {
    // `2.** ...`
    let is_numbered =
        |text: &str| text.split_once(".**").is_some_and(|(n, _)| n.parse::<u8>().is_ok());
    let exercises = text.split("\n**");
    let exercises = exercises.filter(|part| part.starts_with("Exercise.**") || is_numbered(part));
    let is_whole = |part: &&str| {
        let command = part.find("```sh\nrtbench ");
        let answer = part.find("<details><summary>Answer</summary>\n\n");
        let end = part.find("</details>");
        command.zip(answer).zip(end).is_some_and(|((c, a), e)| c < a && a < e)
    };
    exercises
        .filter(|part| !is_whole(part))
        .map(|part| part.lines().next().unwrap_or_default().to_owned())
        .collect()
}

#[test]
fn every_exercise_has_a_command_and_an_answer() {
    let mut exercises = 0;
    for chapter in chapters() {
        let text = text_of(&chapter);
        assert_eq!(unanswered(&text), Vec::<String>::new(), "{chapter}");
        exercises += text.matches("<summary>Answer</summary>").count();
    }
    assert!(exercises >= 15, "{exercises}");
    let planted = "\n**Exercise.** Why?\n\n```sh\nrtbench list rays\n```\n\n**2.** And?\n";
    assert_eq!(unanswered(planted), ["Exercise.** Why?", "2.** And?"]);
}

/// The examples that a script builds: what follows `--example`.
fn examples_in(script: &str) -> Vec<String> {
    let named = script.split("--example ").skip(1);
    named.filter_map(|rest| rest.split_whitespace().next()).map(str::to_owned).collect()
}

#[test]
fn scripts_build_examples_that_are_there() {
    let folders = ["renderer", "rtbench"].map(|c| root().join("crates").join(c).join("examples"));
    let mut built = 0;
    for script in std::fs::read_dir(root().join("scripts")).unwrap() {
        let path = script.unwrap().path();
        for example in examples_in(&std::fs::read_to_string(&path).unwrap()) {
            let file = format!("{example}.rs");
            let is_there = folders.iter().any(|folder| folder.join(&file).exists());
            assert!(is_there, "{}: there is no example {example}", path.display());
            built += 1;
        }
    }
    assert!(built >= 4, "{built}");
    assert_eq!(examples_in("cargo build -q --example none --features x"), ["none"]);
}

/// The folders of somebody's machine that a text names.
fn machine_paths(text: &str) -> Vec<&str> {
    let paths = ["/home/", "/root/", "/tmp/", "/work/", "/Users/"];
    paths.into_iter().filter(|path| text.contains(path)).collect()
}

#[test]
fn no_folder_of_a_machine_is_published() {
    let published =
        ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs", "results", "fuzz/seeds"];
    let mut read = 0;
    for path in published.iter().flat_map(|name| files_below(&root().join(name))) {
        let bytes = std::fs::read(&path).unwrap();
        let found = String::from_utf8_lossy(&bytes);
        let found = machine_paths(&found);
        assert!(found.is_empty(), "{}: {found:?}", path.display());
        read += 1;
    }
    assert!(read > 100, "{read}");
    assert_eq!(machine_paths("- command: `/home/me/rtbench run`"), ["/home/"]);
    assert!(machine_paths("rtbench run -o results/home-run").is_empty());
}
