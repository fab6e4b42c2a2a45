//! The text of every command, as users see it, with a clock and a world that are the same
//! everywhere. A difference is an error that shows it; where it is meant,
//! `RTBENCH_UPDATE_SNAPSHOTS=1 cargo test -p rtbench --test it snapshots` writes the files anew.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::common::{Folder, PLANTED, run_with};
use accel_core::structures::{Entry, REGISTRY};
use clap::CommandFactory;
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SteppingClock;
use rtbench::args::Cli;

/// A command whose text is kept; `DIR` in it is a folder of its own.
struct Snapshot {
    /// The file's name.
    name: &'static str,
    /// Commands run before, each with the milliseconds between two readings of the clock.
    before: &'static [(u64, &'static str)],
    /// Command whose text is kept.
    command: &'static str,
    /// Files in the folder that are kept as well.
    files: &'static [&'static str],
}

const fn of(name: &'static str, command: &'static str) -> Snapshot {
    Snapshot { name, before: &[], command, files: &[] }
}

/// Two runs of which the second is slower, has fewer scenes, and other rows.
const RUNS: &[(u64, &str)] = &[
    (
        1,
        "run tetra:2 tetra:1 --size 8 --rays primary -s uniform-grid,uniform-grid:density=1,hug,obvhs-cwbvh -o DIR/a",
    ),
    (
        2,
        "run tetra:2 --size 8 --rays primary -s uniform-grid,hug,hug:density=9,obvhs-cwbvh -o DIR/b",
    ),
];

/// A baseline that nothing has changed since.
const CHECKED: &[(u64, &str)] = &[(
    1,
    "baseline save main tetra:2 --size 8 --rays primary -s uniform-grid,obvhs-cwbvh --baselines DIR",
)];

/// A run in two parts.
const PARTS: &[(u64, &str)] = &[
    (1, "run tetra:2 --size 8 --rays primary -s uniform-grid,hug,obvhs-cwbvh --shard 1/2 -o DIR/1"),
    (1, "run tetra:2 --size 8 --rays primary -s uniform-grid,hug,obvhs-cwbvh --shard 2/2 -o DIR/2"),
];

/// All of them: a line each. Those named `planted-...` have a structure that gives wrong answers.
const SNAPSHOTS: &[Snapshot] = &[
    Snapshot {
        files: &["results.md", "results.csv"],
        ..of(
            "run",
            "run tetra:2 --size 16 --rounds 2 -s uniform-grid:density=1,obvhs-cwbvh,light-buffer -o DIR",
        )
    },
    of("planted-run", "run tetra:2 --size 16 --rounds 6 -s dropper,obvhs-cwbvh"),
    of("sweep", "sweep tetra:2 -s uniform-grid -p density --values 1,4 --size 16"),
    Snapshot {
        files: &["explain.csv", "explain.md"],
        ..of("explain", "explain tetra:2 --size 16 --rounds 3 -o DIR")
    },
    of("explain-mixed", "explain balls:2 --size 16 --rounds 3 -s wide-bvh:query=batch"),
    of("planted-explain", "explain tetra:2 --size 16 --rounds 3 -s dropper"),
    Snapshot {
        files: &["sweep.csv", "slopes.csv"],
        ..of(
            "sweep-sizes",
            "sweep tetra --sizes 16,60,250 -s uniform-grid,obvhs-cwbvh --size 16 --rounds 2 \
             -o DIR",
        )
    },
    of(
        "planted-sweep-sizes",
        "sweep tetra --sizes 16..64 -s dropper,obvhs-cwbvh --size 16 --rounds 1",
    ),
    Snapshot { before: RUNS, ..of("compare", "compare DIR/a DIR/b") },
    Snapshot { before: RUNS, ..of("compare-csv", "compare DIR/a DIR/b --format csv -q") },
    Snapshot {
        before: RUNS,
        ..of(
            "compare-chosen",
            "compare DIR/a DIR/b DIR/a -t 50% -f grid --format markdown -m trace,n_it",
        )
    },
    of("compare-unknown-metric", "compare DIR/a DIR/b -m rato"),
    of("list-structures", "list structures"),
    of("list-occluders", "list occluders"),
    of("list-tracers", "list tracers"),
    of("list-scenes", "list scenes"),
    of("list-animations", "list animations"),
    of("list-sets", "list sets"),
    of("list-rays", "list rays"),
    of("list-axes", "list axes"),
    of("render-plan", "render effect-all --plan"),
    of("scenes-info", "scenes info tetra:2"),
    of("scenes-validate", "scenes validate tetra:2 effect-all"),
    of("verify", "verify -j 1 --cases G1 -s uniform-grid,obvhs-cwbvh --rays 100"),
    of("planted-verify", "verify -j 1 --cases G1 -s dropper --rays 100"),
    of("accuracy", "accuracy mailbox --quick --scene tetra:2"),
    of(
        "compare-tracers",
        "compare-tracers tetra:2 --quick --size 8 --samples 1,4 --reference-samples 16",
    ),
    of("cost", "cost tetra:2 --size 8"),
    of("reproduce-havran", "reproduce havran1999 --scenes tetra --structures uniform"),
    of("reproduce-zachmann", "reproduce zachmann2007 --scenes tetra --quick --size 8"),
    Snapshot { before: CHECKED, ..of("baseline-list", "baseline list --baselines DIR") },
    Snapshot { before: CHECKED, ..of("baseline-show", "baseline show main --baselines DIR") },
    Snapshot { before: CHECKED, ..of("check", "check --baseline main --baselines DIR") },
    of("check-unknown", "check --baseline main --baselines DIR"),
    Snapshot { before: PARTS, ..of("merge", "merge DIR/1 DIR/2") },
    Snapshot { before: PARTS, ..of("merge-missing", "merge DIR/1") },
    Snapshot { before: RUNS, ..of("report", "report DIR/a --no-pictures -o - -q") },
    of("doctor", "doctor"),
    of("schema", "generate schema bencher-metric-format"),
    of("man", "generate man doctor"),
    of("usage-error", "run tetra:2 -s unifrom-grid"),
    of("help", "--help"),
];

#[test]
fn outputs_of_all_commands_match_their_snapshots() {
    let mut differing = String::new();
    for snapshot in SNAPSHOTS {
        differing += &compared(snapshot);
    }
    // every subcommand is here by itself
    for command in Cli::command().get_subcommands() {
        let name: &'static str = format!("help-{}", command.get_name()).leak();
        differing += &compared(&of(name, format!("help {}", command.get_name()).leak()));
    }
    assert!(differing.is_empty(), "{differing}");
}

/// Runs, and says what differs from the file; or writes it, where that is asked for.
fn compared(snapshot: &Snapshot) -> String {
    let Snapshot { name, before, command, files } = snapshot;
    let folder = Folder::new();
    let registry: &[Entry] = if name.starts_with("planted") { &PLANTED } else { REGISTRY };
    let run = |step, command: &str| {
        let clock = SteppingClock::new(Duration::from_millis(step));
        run_with(registry, &InstalledScenes, &clock, &command.replace("DIR", &folder.path()))
    };
    for (step, command) in *before {
        let ended = run(*step, command);
        assert_eq!(ended.code, 0, "{name}: {command}: {}", ended.err);
    }
    let ended = run(1, command);
    let mut text = format!("$ rtbench {command}\nexit code {}\n", ended.code);
    let kept = files.iter().map(|file| (*file, folder.text(file)));
    let outputs = [("standard output", ended.out), ("standard error", ended.err)];
    for (title, content) in outputs.into_iter().chain(kept) {
        if !content.is_empty() {
            let _ = write!(text, "--- {title}\n{}", content.replace(&folder.path(), "DIR"));
        }
    }
    let text: String = text.lines().map(|line| format!("{}\n", line.trim_end())).collect();
    let path = file_of(name);
    if std::env::var_os("RTBENCH_UPDATE_SNAPSHOTS").is_some() {
        std::fs::write(&path, &text).expect("a snapshot that can be written");
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default();
    difference(&path, &expected, &text)
}

fn file_of(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots").join(format!("{name}.txt"))
}

/// The lines between what two texts begin and end with alike; empty where they are equal.
fn difference(path: &Path, expected: &str, found: &str) -> String {
    if expected == found {
        return String::new();
    }
    let (old, new): (Vec<&str>, Vec<&str>) = (expected.lines().collect(), found.lines().collect());
    let alike =
        |pairs: &mut dyn Iterator<Item = (&&str, &&str)>| pairs.take_while(|(a, b)| a == b).count();
    let head = alike(&mut old.iter().zip(&new));
    let tail = alike(&mut old[head..].iter().rev().zip(new[head..].iter().rev()));
    let mut text = format!("\n{}, from line {}:\n", path.display(), head + 1);
    for line in &old[head..old.len() - tail] {
        let _ = writeln!(text, "- {line}");
    }
    for line in &new[head..new.len() - tail] {
        let _ = writeln!(text, "+ {line}");
    }
    text + "RTBENCH_UPDATE_SNAPSHOTS=1 writes the files anew, if this is meant\n"
}

#[test]
fn a_planted_difference_is_shown_by_its_lines() {
    let path = Path::new("x.txt");
    assert_eq!(difference(path, "a\nb\n", "a\nb\n"), "");
    let said = difference(path, "a\nb\nc\nd\n", "a\nB\nc\nd\n");
    assert!(said.starts_with("\nx.txt, from line 2:\n- b\n+ B\nRTBENCH_UPDATE"), "{said}");
    assert!(difference(path, "a\n", "a\na\n").contains("from line 2:\n+ a\n"));
    assert!(difference(path, "", "a\n").contains("+ a\n"));
}

#[test]
fn every_file_has_its_command() {
    let mut names: Vec<String> = SNAPSHOTS.iter().map(|s| s.name.to_owned()).collect();
    names.extend(Cli::command().get_subcommands().map(|c| format!("help-{}", c.get_name())));
    for entry in std::fs::read_dir(file_of("x").parent().unwrap()).unwrap().flatten() {
        let path = entry.path();
        let name = path.file_stem().unwrap().to_string_lossy().into_owned();
        assert!(names.contains(&name), "{} is no snapshot any more", path.display());
    }
}
