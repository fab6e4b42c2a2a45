//! Types the commands of README.md and docs/ at a desk of their own: a temporary folder with the
//! files that pages take for granted. What takes minutes is typed with less: smaller scenes, images
//! and numbers of rounds, the same structures, settings and options. What a page prints of counters
//! is compared with what its commands print.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use super::documents::{chapters, joined, root, text_of};
use super::parsed::{arguments, parse};
use crate::common::Folder;

/// Commands that are parsed only: a part of the line, and why.
const PARSED_ONLY: [(&str, &str); 11] = [
    ("scenes fetch", "it needs a network"),
    ("--plugin", "it needs a compiled plugin: the tests of plugins type it"),
    ("rays check", "it needs the hits of another program: the tests of plugins have them"),
    ("part-3", "it merges eight parts: the tests of shards merge what they measure"),
    ("--resume", "it needs an interrupted run: the tests of resuming have them"),
    ("--shard $", "it is a part of an array job: the tests of Slurm's scripts run it"),
    ("check --baseline", "it judges times, which a busy machine changes: the tests of check"),
    ("baselines/main.json", "as above"),
    ("--against", "it needs a minute, and an older program: the tests of check"),
    ("--processes", "it needs a minute: the tests of processes"),
    ("hagrid", "another program reads it"),
];

/// Scenes, sets and axes in the place of larger ones.
const SMALLER: [(&str, &str); 21] = [
    ("kitchen", "hare:6"),
    ("kitchen,hare", "hare:6"),
    ("teapot", "teapot:3"),
    ("balls", "balls:1"),
    ("tetra", "tetra:2"),
    ("mount", "mount:2"),
    ("pavilion", "teapot:2"),
    ("stadium:12", "hare:6"),
    ("stadium:24", "hare:6"),
    ("tree-tess", "tree-tess:3"),
    ("balls-tess", "balls-tess:1"),
    ("gears-tess", "gears-tess:1"),
    ("speed", "hare:6"),
    ("real", "hare:6"),
    ("marbles", "particles:4"),
    ("city", "particles:4"),
    ("1e3..1e6", "700,3k"),
    ("60s", "10ms"),
    ("30m", "10ms"),
    ("teapot/.*grid.*/trace", "teapot:3/.*grid.*/trace"),
    // valgrind is not everywhere
    ("--instructions", "--quick"),
];

/// Options with their values; an empty value is none.
type Options = &'static [(&'static str, &'static str)];

/// Options of a command in the place of its defaults, and what is measured where nothing is named.
const LESS: [(&str, Options, &str); 14] = [
    ("run", &[("--quick", ""), ("--size", "16")], "tetra:2"),
    ("sweep", &[("--quick", ""), ("--size", "16")], ""),
    ("explain", &[("--quick", ""), ("--size", "16")], ""),
    ("animate", &[("--quick", ""), ("--size", "16"), ("--frames", "0..1")], ""),
    ("accuracy", &[("--quick", ""), ("--size", "8"), ("--trials", "100")], "mailbox"),
    ("compare-tracers", &[("--quick", ""), ("--size", "8"), ("--samples", "1")], ""),
    ("reproduce havran1999", &[("--scenes", "tetra"), ("--structures", "uniform")], ""),
    ("reproduce", &[("--scenes", "tetra"), ("--quick", ""), ("--size", "16")], ""),
    ("cost", &[("--size", "16")], ""),
    ("render", &[("--size", "16")], ""),
    ("rays export", &[("--size", "16")], ""),
    ("verify", &[("--rays", "20")], "--cases=G1"),
    ("baseline save main", &[("--quick", ""), ("--size", "16")], ""),
    ("check", &[("--quick", "")], ""),
];

/// A folder with what pages take for granted.
fn desk() -> Folder {
    let desk = Folder::new();
    let path = PathBuf::from(desk.path());
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0.5\nv 1 1 0\nf 1 2 3\nf 2 4 3\n";
    for file in ["model.obj", "hall.obj"] {
        std::fs::write(path.join(file), triangle).unwrap();
    }
    for frame in 0..10 {
        std::fs::write(path.join(format!("frame{frame:04}.obj")), triangle).unwrap();
    }
    let ply = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n\
               property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
               end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    std::fs::write(path.join("dragon.ply"), ply).unwrap();
    std::fs::write(path.join("rays.txt"), "0 0 -1 0 0 0 1 10\n").unwrap();
    for folder in ["scenes", "out/pictures", "nights"] {
        std::fs::create_dir_all(path.join(folder)).unwrap();
    }
    for file in ["pavilion.json", "pavilion.glb"] {
        std::fs::copy(root().join("scenes").join(file), path.join("scenes").join(file)).unwrap();
    }
    for run in ["before", "after", "out", "nights/one"] {
        let line = format!("run tetra:2 teapot:3 --quick --size 16 -s wide-bvh,kd-tree -o {run}");
        let ended = typed(&path, &line.split(' ').map(str::to_owned).collect::<Vec<_>>());
        assert!(ended.status.success(), "{line}: {}", String::from_utf8_lossy(&ended.stderr));
    }
    desk
}

/// Types a command at the desk.
fn typed(desk: &Path, arguments: &[String]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rtbench"));
    command.args(arguments).current_dir(desk).env("COLUMNS", "400");
    command.output().unwrap()
}

/// What a command says: standard output, and the texts of a drawing that it wrote.
fn said(desk: &Path, arguments: &[String], ended: &Output) -> String {
    let mut said = String::from_utf8_lossy(&ended.stdout).into_owned();
    for name in arguments.iter().filter(|word| word.ends_with(".svg")) {
        let drawing = std::fs::read_to_string(desk.join(name)).unwrap_or_default();
        let texts = drawing.lines().filter_map(|line| line.strip_suffix("</text>"));
        for text in texts.filter_map(|line| line.rsplit('>').next()) {
            said += text;
            said += "\n";
        }
    }
    said
}

/// The arguments that are typed for a line, without the program's name; none where the line is
/// parsed only.
fn with_less(line: &str, arguments: &[String]) -> Option<Vec<String>> {
    if PARSED_ONLY.iter().any(|(part, _)| line.contains(part)) {
        return None;
    }
    // as it is shown: it is small already, and its counters may be compared
    let is_small = arguments.iter().any(|word| word == "--quick") && arguments[2].contains(':');
    let is_swept = arguments.iter().any(|word| word == "--sizes");
    let small = |(before, word): (&String, &String)| {
        let is_kept = is_small || before == "--as";
        let found = SMALLER.iter().find(|(large, _)| large == word && !is_kept);
        // a scene that is swept over its sizes has none of its own
        let found = found.filter(|(large, _)| !is_swept || *large != "tree-tess");
        found.map_or(word.clone(), |(_, small)| (*small).to_owned())
    };
    let mut typed: Vec<String> = arguments.iter().zip(&arguments[1..]).map(small).collect();
    typed.dedup();
    let begun = typed.join(" ");
    let less = LESS.iter().find(|(command, ..)| begun.starts_with(command) && !is_small);
    let (options, unnamed) =
        less.map_or((&[][..], ""), |(_, options, unnamed)| (*options, *unnamed));
    for (option, value) in options {
        set(&mut typed, option, value);
    }
    let names_nothing = arguments.get(2).is_none_or(|word| word.starts_with('-'));
    if names_nothing && !unnamed.is_empty() {
        typed.push(unnamed.to_owned());
    }
    typed.push("--overwrite".into());
    Some(typed)
}

/// Gives an option that value, whether or not it was typed.
fn set(typed: &mut Vec<String>, option: &str, value: &str) {
    if let Some(place) = typed.iter().position(|word| word == option) {
        if !value.is_empty() {
            typed[place + 1] = value.to_owned();
        }
        return;
    }
    typed.push(option.to_owned());
    typed.extend((!value.is_empty()).then(|| value.to_owned()));
}

/// What a page says one after the other.
#[derive(Debug, PartialEq)]
enum Part {
    /// A line in a block of shell commands.
    Line(String),
    /// A heading or an exercise: what was printed before is not of what follows.
    Head,
    /// Lines with counters that the commands before print: a folded answer, or the table behind
    /// `<!-- counters -->`.
    Counters(Vec<String>),
}

fn parts(text: &str) -> Vec<Part> {
    let mut parts = Vec::new();
    let (mut shell, mut counters): (Option<Vec<String>>, Option<Vec<String>>) = (None, None);
    for line in text.lines() {
        match (&mut shell, &mut counters) {
            (Some(_), _) if line.trim_start().starts_with("```") => {
                let lines = joined(&shell.take().unwrap_or_default());
                parts.extend(lines.into_iter().map(Part::Line));
            }
            (Some(lines), _) => lines.push(line.to_owned()),
            (None, Some(lines))
                if line == "</details>" || line.is_empty() && !lines[0].is_empty() =>
            {
                parts.extend(counters.take().map(Part::Counters));
            }
            (None, Some(lines)) => lines.push(line.to_owned()),
            (None, None) if line.starts_with("<details>") => counters = Some(vec![String::new()]),
            (None, None) if line == "<!-- counters -->" => counters = Some(vec![line.to_owned()]),
            (None, None) if line.trim_start() == "```sh" => shell = Some(Vec::new()),
            (None, None) if line.starts_with("#") || line.starts_with("**") => {
                parts.push(Part::Head)
            }
            (None, None) => {}
        }
    }
    parts
}

/// The numbers of a text, without commas between thousands; of a page, not those below ten and not
/// percentages, which are roundings of its own.
pub fn numbers(text: &str, is_page: bool) -> Vec<String> {
    let mut numbers = Vec::new();
    let is_part = |c: char| c.is_ascii_digit() || c == '.' || c == ',';
    let mut rest = text;
    while let Some(start) = rest.find(|c: char| c.is_ascii_digit()) {
        let is_name =
            rest[..start].ends_with(|c: char| c.is_alphanumeric() || c == '_' || c == '=');
        let end = rest[start..].find(|c| !is_part(c)).map_or(rest.len(), |length| start + length);
        let number = rest[start..end].trim_end_matches(['.', ',']).replace(',', "");
        let is_exact = !rest[end..].starts_with('%') && (number.contains('.') || number.len() > 1);
        if !is_page || is_exact && !is_name {
            numbers.push(number);
        }
        rest = &rest[end..];
    }
    numbers
}

/// Numbers of a page's lines that commands did not print; those of a row of a table must stand in
/// one line.
fn unprinted(lines: &[String], printed: &str) -> Vec<String> {
    let rows: Vec<Vec<String>> = printed.lines().map(|line| numbers(line, false)).collect();
    let is_in = |row: &[String], number: &String| row.contains(number);
    let mut unprinted = Vec::new();
    for line in lines {
        let wanted = numbers(line, true);
        let is_there = if line.starts_with('|') {
            rows.iter().any(|row| wanted.iter().all(|number| is_in(row, number)))
        } else {
            wanted.iter().all(|number| rows.iter().any(|row| is_in(row, number)))
        };
        if !is_there {
            unprinted.push(line.clone());
        }
    }
    unprinted
}

/// Types the commands of a page; what is stale in it.
fn stale(document: &str, text: &str) -> Vec<String> {
    let desk = desk();
    let mut printed = String::new();
    let mut stale = Vec::new();
    for part in parts(text) {
        match part {
            Part::Head => printed.clear(),
            Part::Counters(lines) => {
                let lines = unprinted(&lines, &printed);
                stale.extend(lines.iter().map(|line| format!("{document}: not printed: {line}")));
            }
            Part::Line(line) => {
                let Some(shown) = arguments(&line) else { continue };
                if let Err(e) = parse(&shown) {
                    stale.push(format!("{document}: {line}: {e}"));
                    continue;
                }
                let Some(arguments) = with_less(&line, &shown) else { continue };
                let ended = typed(Path::new(&desk.path()), &arguments);
                printed += &said(Path::new(&desk.path()), &arguments, &ended);
                if !ended.status.success() {
                    let error = String::from_utf8_lossy(&ended.stderr);
                    let typed = arguments.join(" ");
                    stale.push(format!("{document}: {line}\n  typed: {typed}\n  {error}"));
                }
            }
        }
    }
    stale
}

/// Every second page, from the first or from the second on.
fn assert_fresh(first: usize) {
    let mut documents = chapters();
    documents.push("README.md".into());
    let documents = documents.iter().skip(first).step_by(2);
    let stale: Vec<String> = documents.flat_map(|d| stale(d, &text_of(d))).collect();
    assert!(stale.is_empty(), "{}", stale.join("\n"));
}

#[test]
fn commands_of_the_book_do_what_it_says() {
    assert_fresh(0);
}

#[test]
fn commands_of_the_other_pages_do_what_they_say() {
    assert_fresh(1);
}

#[test]
fn a_stale_page_is_found() {
    let fresh = "# Page\n\n```sh\nrtbench list rays  # kinds\n```\n";
    assert_eq!(stale("page", fresh), Vec::<String>::new());
    // planted: a scene, a structure and an option that are not there, and another counter
    let page = "# Page\n\n```sh\nrtbench explain teapot-tess -s kd-tree\nrtbench run tetra -s kd-treee\n\
                rtbench run tetra --rouns 3\nrtbench run tetra:2 --quick -s octree --columns n_v\n```\n\n\
                <details><summary>Answer</summary>\n\n12345 voxels\n</details>\n";
    let found = stale("page", page);
    assert_eq!(found.len(), 4, "{found:#?}");
    for (found, part) in found.iter().zip(["teapot-tess", "kd-treee", "--rouns", "12345"]) {
        assert!(found.contains(part), "{found}");
    }
}
