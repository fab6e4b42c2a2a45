//! Every command of README.md, docs/, the workflow and the help pages can be typed: it is parsed, the
//! cheap ones are run, and the synopsis has no option that is not there.

use clap::{Command, CommandFactory, Parser};
use rtbench::args::Cli;

use super::documents::{blocks, chapters, joined, text_of};
use crate::common::run;

/// Commands that print something and measure nothing: they are run.
const CHEAP: [&str; 3] = ["list", "generate", "doctor"];

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
