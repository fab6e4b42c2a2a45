//! What README.md and docs/ say can be typed: every command of theirs is parsed, the cheap ones are
//! run, the synopsis has no option that is not there, what they name lies there, the table of
//! contents has every chapter, exercises have answers, and nothing that is published names a folder
//! of somebody's machine.

use std::path::{Path, PathBuf};

use clap::{Command, CommandFactory, Parser};
use rtbench::args::Cli;

use crate::common::{files_below, run};

/// Commands that print something and measure nothing: they are run.
const CHEAP: [&str; 3] = ["list", "generate", "doctor"];

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

/// The words of a line as a shell sees them, without comments, redirections and what follows a
/// pipe.
fn words(line: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut quote = None;
    for c in line.chars() {
        let is_new = words.last().is_some_and(String::is_empty);
        match (c, quote) {
            ('\'' | '"', None) => quote = Some(c),
            (c, Some(q)) if c == q => quote = None,
            ('#', None) if is_new => break,
            ('|' | '>' | ';' | '&', None) if is_new => break,
            (' ', None) if is_new => {}
            (' ', None) => words.push(String::new()),
            (c, _) => words.last_mut().unwrap().push(c),
        }
    }
    words.retain(|word| !word.is_empty());
    words
}

/// The arguments of this program in a line, its name first; none where the line is about something
/// else. Variables of shells and workflows stand for 1.
pub fn arguments(line: &str) -> Option<Vec<String>> {
    let mut line = line.trim().trim_start_matches("- ").trim_start_matches("run: ").to_owned();
    while let Some((start, end)) = line.find("${{").zip(line.find("}}")) {
        line.replace_range(start..end + 2, "1");
    }
    let words: Vec<String> =
        words(&line).iter().map(|word| word.replace("$SLURM_ARRAY_TASK_ID", "1")).collect();
    let cargo = ["cargo", "run", "--release", "--"];
    let skipped = match words.first()?.rsplit('/').next() {
        Some("rtbench") => 1,
        _ if words.len() > 4 && words.iter().zip(cargo).all(|(word, of)| word == of) => 4,
        _ => return None,
    };
    let rest = words.into_iter().skip(skipped);
    Some(std::iter::once("rtbench".to_owned()).chain(rest).collect())
}

/// All commands of a document.
fn commands(document: &str) -> Vec<Vec<String>> {
    let text = text_of(document);
    let lines = if document.ends_with(".yml") {
        // folded texts are one line
        text.replace(">-\n", "").lines().fold(Vec::new(), |mut lines: Vec<String>, line| {
            match lines.last_mut() {
                Some(last) if line.trim_start().starts_with("--") => {
                    last.push(' ');
                    last.push_str(line.trim());
                }
                _ => lines.push(line.to_owned()),
            }
            lines
        })
    } else {
        [blocks(&text, "sh"), blocks(&text, "yaml")].concat()
    };
    joined(&lines).iter().filter_map(|line| arguments(line)).collect()
}

pub fn parse(arguments: &[String]) -> Result<(), String> {
    Cli::try_parse_from(arguments).map(|_| ()).map_err(|e| e.to_string())
}

#[test]
fn every_command_can_be_typed() {
    let chapters = chapters();
    let others = ["README.md", ".github/workflows/ci.yml"];
    for document in others.into_iter().chain(chapters.iter().map(String::as_str)) {
        let commands = commands(document);
        let least = if others.contains(&document) || document == "docs/ci.md" { 4 } else { 0 };
        assert!(commands.len() >= least, "{document}: {commands:?}");
        for arguments in commands {
            let name = arguments[1].as_str();
            let parsed = parse(&arguments);
            assert!(parsed.is_ok(), "{document}: {}: {parsed:?}", arguments.join(" "));
            if CHEAP.contains(&name) && !arguments.iter().any(|a| a == "--memory") {
                let ended = run(&arguments[1..].join(" "));
                assert_eq!(ended.code, 0, "{document}: {arguments:?}: {}", ended.err);
                assert!(!ended.out.is_empty(), "{document}: {arguments:?}");
            }
        }
    }
}

/// The examples in the help of a command and of those below it.
fn examples(command: &Command) -> Vec<Vec<String>> {
    let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
    // what they do follows behind a gap
    let own = help.lines().filter_map(|line| arguments(line.trim().split("   ").next()?));
    own.chain(command.get_subcommands().flat_map(examples)).collect()
}

#[test]
fn examples_of_help_can_be_typed() {
    let all = examples(&Cli::command());
    assert!(all.len() > 20, "{all:?}");
    for arguments in all {
        let parsed = parse(&arguments);
        assert!(parsed.is_ok(), "{}: {parsed:?}", arguments.join(" "));
    }
}

#[test]
fn a_documented_command_that_does_not_exist_is_caught() {
    for bad in [
        "rtbench rnu spd",
        "./target/release/rtbench run --round 3",
        "      - run: rtbench list scens",
        "cargo run --release -- run --shard 9/${{ matrix.shards }}",
    ] {
        let arguments = arguments(bad).unwrap_or_else(|| panic!("{bad}: not seen"));
        assert!(parse(&arguments).is_err(), "{arguments:?}");
    }
    for other in ["cargo test --workspace", "# rtbench run --bogus", "cp a rtbench", ""] {
        assert_eq!(arguments(other), None, "{other}");
    }
    let piped = arguments("rtbench run 'a b' --quick | tee log # why").unwrap();
    assert_eq!(piped, ["rtbench", "run", "a b", "--quick"]);
    assert_eq!(blocks("```sh\na\n```\nb\n```text\nc\n```\n```sh\nd\n```", "sh"), ["a", "d"]);
}

/// The options of a command and of those above it.
fn options(command: &Command, out: &mut Vec<String>) {
    for argument in command.get_arguments() {
        out.extend(argument.get_long().map(|long| format!("--{long}")));
        out.extend(argument.get_short().map(|short| format!("-{short}")));
    }
}

/// Unknown command or options in a line of a synopsis. `known` has the options of earlier lines of
/// the same command.
fn unknown_in(line: &str) -> Vec<String> {
    let mut cli = Cli::command();
    cli.build();
    let mut known = Vec::new();
    options(&cli, &mut known);
    let separators = |c: char| " []()|,".contains(c);
    let tokens: Vec<&str> = line.split(separators).filter(|t| !t.is_empty()).collect();
    let mut command = &cli;
    let mut unknown = Vec::new();
    for (place, token) in tokens.iter().enumerate().skip(1) {
        if let Some(below) = command.find_subcommand(token) {
            command = below;
            options(command, &mut known);
            continue;
        }
        // what stands behind `--` alone is for another program
        let is_option = token.starts_with('-') && *token != "--";
        let is_unknown = is_option && !known.iter().any(|option| option == token);
        if place == 1 || is_unknown {
            unknown.push((*token).to_owned());
        }
    }
    unknown
}

#[test]
fn the_synopsis_lists_existing_options_only() {
    let lines = blocks(&text_of("docs/commands.md"), "text");
    let mut synopses: Vec<String> = Vec::new();
    for line in lines {
        match synopses.last_mut() {
            Some(last) if line.starts_with(' ') => last.push_str(&line),
            _ => synopses.push(line),
        }
    }
    synopses.retain(|line| line.starts_with("rtbench "));
    assert!(synopses.len() > 10, "{synopses:?}");
    for line in &synopses {
        assert_eq!(unknown_in(line), Vec::<String>::new(), "{line}");
    }
    for command in Cli::command().get_subcommands().filter(|c| !c.is_hide_set()) {
        let start = format!("rtbench {}", command.get_name());
        let is_there = synopses.iter().any(|line| line.starts_with(&start));
        assert!(is_there, "the synopsis in docs/commands.md lacks `{start}`");
    }
    assert_eq!(unknown_in("rtbench run [SCENE]... [--round N] [-o DIR]"), ["--round"]);
    assert_eq!(unknown_in("rtbench walk [-o DIR]").first().map(String::as_str), Some("walk"));
    assert!(unknown_in("rtbench scenes info|validate [NAME]").is_empty());
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
