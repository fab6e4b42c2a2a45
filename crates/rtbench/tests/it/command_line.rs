//! Exit codes and messages.

use accel_core::structures::COMMON;
use std::io::{self, Write};
use std::process::{Command, Stdio};

use crate::common::{Folder, PLANTED, run, run_with};
use clap::{CommandFactory, Parser};
use measurement::scenes::InstalledScenes;
use measurement::system::clock::{SteppingClock, SystemClock};
use rtbench::args::Cli;
use rtbench::context::Context;

#[test]
fn unknown_names_are_usage_errors_that_say_what_is_valid() {
    for (arguments, said) in [
        ("run tetra:2 -s unifrom-grid", "did you mean 'uniform-grid'?"),
        ("run tetra:2 -s nothing", "obvhs-cwbvh"),
        ("run tetra:2 -s uniform-grid:densty=1", "did you mean 'density'?"),
        ("run tetra:2 -s uniform-grid:density=many", "expected a number from"),
        ("run tetra:2 --set uniform-grid.densty=1", "did you mean 'density'?"),
        ("run tetra:2 --set density=1", "uniform-grid.density=4"),
        ("run tetra:2 -s brute-force --set uniform-grid.density=1", "does not measure"),
        ("run tetra:2 --rays primery", "did you mean 'primary'?"),
        ("run tetra:2 --reference obvhs", "unknown structure 'obvhs'"),
        ("run tetrra", "tetra"),
        ("run balls:99", "sizes are whole numbers from 1 to"),
        ("run tetra:2 --rounds 0", "--rounds"),
        ("run tetra:2 --rounds 5 --time-budget 5s", "--time-budget"),
        ("run tetra:2 --time-budget soon", "500ms"),
        ("run tetra:2 -j 0", "--threads"),
        ("run tetra:2 --size 0", "--size"),
        ("run tetra:2 --color green", "auto"),
        ("walk", "unrecognized subcommand"),
        ("list everything", "structures"),
        ("render spd -o /dev/null", "one scene"),
        ("render tetra:2 -o /dev/null -s nothing", "unknown structure"),
        ("scenes info tetrra", "tetra"),
        ("", "Usage"),
    ] {
        let ended = run(arguments);
        assert_eq!(ended.code, 2, "{arguments}: {}", ended.err);
        assert!(ended.err.contains(said), "{arguments}: {}", ended.err);
        assert_eq!(ended.out, "", "{arguments}");
    }
}

#[test]
fn help_and_version_are_results() {
    for arguments in ["--help", "run --help", "--version", "list --help"] {
        let ended = run(arguments);
        assert_eq!((ended.code, ended.err.as_str()), (0, ""), "{arguments}");
        assert!(ended.out.contains("rtbench"), "{arguments}");
    }
    // the commit of the sources is in it, where there is one
    let text = run("--version").out;
    let commit = text.trim().strip_prefix(concat!("rtbench ", env!("CARGO_PKG_VERSION"), " at "));
    let is_commit = |c: &str| c.len() == 12 && c.bytes().all(|b| b.is_ascii_hexdigit());
    assert!(commit.is_some_and(is_commit) || text.contains(", commit unknown"), "{text}");
}

#[test]
fn an_unwritable_path_is_found_before_measuring() {
    let folder = Folder::new();
    for option in ["--export-bencher", "--export-github-bigger", "-o"] {
        let file = format!("{}/file", folder.path());
        std::fs::write(&file, "").unwrap();
        let path = format!("{file}/below");
        // No scene this large could be measured in the time a test has.
        let ended = run(&format!("run balls:7 {option} {path}"));
        assert_eq!(ended.code, 1, "{option}: {}", ended.err);
        assert!(ended.err.contains(&path) && ended.err.contains("cannot write"), "{}", ended.err);
        let png = run(&format!("render balls:7 -o {path}"));
        assert_eq!(png.code, 1, "{}", png.err);
    }
}

/// Each is refused, before or after its outputs are opened: what was not there still is not, and
/// what was is as it was.
#[test]
fn refused_commands_leave_files_untouched() {
    let folder = Folder::new();
    let at = |name: &str| format!("{}/{name}", folder.path());
    std::fs::write(at("broken.nff"), "v\nfrom 1 2 three\n").unwrap();
    std::fs::write(at("file"), "").unwrap();
    let names = || {
        let entries = std::fs::read_dir(folder.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name()).collect();
        names.sort();
        names
    };
    for (arguments, is_folder) in [
        ("render tetra:2 --shadows light -o OUT.png", false),
        ("render tetra:2 -s light-buffer -o OUT.png", false),
        ("render tetra:2 -s uniform-grid:density=0 -o OUT.png", false),
        ("render tetrra -o OUT.png", false),
        ("render DIR/broken.nff -o OUT.png", false),
        ("render effect-all --samples glossy=65536,shadow=65536 -o OUT.png", false),
        ("run tetra:2 -o OUT --export-bencher DIR/file/below", true),
        ("run tetra:2 --export-bencher OUT.csv --export-github-bigger DIR/file/below", false),
        ("run tetra:2 -s unifrom-grid --export-bencher OUT.csv", false),
        ("sweep tetra:2 -s uniform-grid -p density --values 1,2x -o OUT", true),
        ("check tetra:2 --baseline none -o OUT", true),
        ("verify --cases X1 -o OUT", true),
        ("compare-tracers DIR/broken.nff -o OUT", true),
        ("reproduce havran1999 --scenes blals -o OUT", true),
    ] {
        let spelled = |out: &str| arguments.replace("OUT", &at(out)).replace("DIR", &folder.path());
        let before = names();
        let ended = run(&spelled("new"));
        assert!([1, 2].contains(&ended.code), "{arguments}: {}", ended.err);
        assert_eq!(names(), before, "{arguments}: {}", ended.err);
        if !is_folder {
            for name in ["old.png", "old.csv"] {
                std::fs::write(at(name), "what was there").unwrap();
            }
            assert!([1, 2].contains(&run(&spelled("old")).code), "{arguments}");
            for name in ["old.png", "old.csv"] {
                assert_eq!(folder.text(name), "what was there", "{arguments}");
                std::fs::remove_file(at(name)).unwrap();
            }
        }
    }
}

#[test]
fn lists_come_from_the_registries() {
    let text = run("list structures");
    assert_eq!(text.code, 0);
    let json: serde_json::Value =
        serde_json::from_str(&run("list structures --format json").out).unwrap();
    for (entry, listed) in PLANTED.iter().zip(json.as_array().unwrap()) {
        assert_eq!(listed["name"], entry.info.name);
        let params = entry.info.params.len() + COMMON.len();
        assert_eq!(listed["params"].as_array().unwrap().len(), params);
        assert!(text.out.contains(entry.info.summary) && text.out.contains(entry.info.paper));
        for p in entry.info.params {
            assert!(text.out.contains(&format!("{} = {}", p.name, p.default)), "{}", p.name);
        }
    }
    assert!(run("list rays").out.contains("diffuse"));
    assert!(run("list scenes").out.contains("teapot"));
    assert_eq!(run("list sets --format json").code, 0);
}

#[test]
fn scenes_can_be_inspected_and_checked() {
    let info = run("scenes info tetra:2");
    assert_eq!(info.code, 0);
    assert!(info.out.contains("primitives  16"), "{}", info.out);
    let checked = run("scenes validate tetra:2 balls:1");
    assert_eq!(checked.code, 0);
    assert!(checked.out.contains("tetra:2: ok"), "{}", checked.out);
    assert_eq!(run("scenes fetch tetra:2").code, 0);
}

#[test]
fn render_writes_a_png() {
    let folder = Folder::new();
    let png = format!("{}/tetra.png", folder.path());
    for structure in ["", "-s uniform-grid:density=1"] {
        let ended = run(&format!("render tetra:2 --size 16 -j 1 -o {png} --overwrite {structure}"));
        assert_eq!((ended.code, ended.out.as_str()), (0, ""), "{}", ended.err);
        assert!(std::fs::read(&png).unwrap().starts_with(b"\x89PNG"));
    }
}

#[test]
fn hints_name_the_list_that_has_it() {
    for (arguments, list) in [
        ("run tetra:2 -s unifrom-grid", Some("structures")),
        ("run tetra:2 -s uniform-grid:densty=1", Some("structures")),
        ("run tetrra", Some("scenes")),
        ("animate marbels", Some("animations")),
        ("run tetra:2 --rays primery", None),
        ("list structures kd-tre", None),
    ] {
        let ended = run(arguments);
        let hint = list.map(|list| format!("rtbench list {list}"));
        let said = ended.err.lines().find(|l| l.starts_with("To list valid names"));
        assert_eq!(said.is_some(), hint.is_some(), "{arguments}: {}", ended.err);
        assert!(
            hint.is_none_or(|hint| said.unwrap().contains(&hint)),
            "{arguments}: {}",
            ended.err
        );
    }
}

#[test]
fn lists_have_what_is_named() {
    let all = run("list structures").out;
    let one = run("list structures obvhs-bvh2 brute-force");
    assert_eq!((one.code, one.err.as_str()), (0, ""));
    assert!(
        one.out.starts_with("brute-force: ") && one.out.contains("\nobvhs-bvh2: "),
        "{}",
        one.out
    );
    assert!(!one.out.contains("uniform-grid: ") && all.contains("uniform-grid: "));
    let scene = run("list scenes teapot");
    assert_eq!(scene.out.lines().count(), 1, "{}", scene.out);
    let json: serde_json::Value =
        serde_json::from_str(&run("list rays shadow --format json").out).unwrap();
    assert_eq!(json.as_array().unwrap().len(), 1);
    let unknown = run("list tracers bean");
    assert_eq!(unknown.code, 2);
    assert!(
        unknown.err.contains("unknown tracer 'bean' (did you mean 'beam'?)"),
        "{}",
        unknown.err
    );
}

#[test]
fn examples_in_help_are_commands() {
    let mut examples = 0;
    for command in Cli::command().get_subcommands() {
        let text = command.get_after_help().map(ToString::to_string).unwrap_or_default();
        for line in text.lines().filter_map(|line| line.trim().strip_prefix("rtbench ")) {
            let typed = line.split("   ").next().unwrap().split_whitespace();
            let parsed = Cli::try_parse_from(std::iter::once("rtbench").chain(typed));
            assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
            examples += 1;
        }
    }
    assert!(examples > 10, "{examples}");
}

#[test]
fn tables_fit_and_are_sorted_by_what_was_asked() {
    let arguments = "run tetra:2 --size 16 --rounds 1 -s uniform-grid:resolution=heterogeneous:density=20,\
                     dropper,obvhs-cwbvh,brute-force,light-buffer";
    let printed = |more: &str| {
        let clock = SteppingClock::new(std::time::Duration::from_millis(1));
        run_with(&PLANTED, &InstalledScenes, &clock, &format!("{arguments} {more}")).out
    };
    let usual = printed("");
    let widest = |text: &str| text.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(widest(&usual) <= 120, "{usual}");
    let row = |text: &str, name: &str| text.lines().position(|l| l.starts_with(name)).unwrap();
    // what is wrong stands last, of shadow rays alone before it
    let named = ["obvhs-cwbvh", "light-buffer", "dropper"].map(|name| row(&usual, name));
    assert!(named.is_sorted(), "{usual}");
    let registry = printed("--sort registry");
    assert!(row(&registry, "dropper") < row(&registry, "light-buffer"), "{registry}");
    let some = printed("--columns n_it,memory");
    let head = some.lines().find(|l| l.starts_with("structure")).unwrap();
    assert_eq!(head.split_whitespace().collect::<Vec<_>>(), ["structure", "N_IT", "MiB"]);
    let unknown = run(&format!("{arguments} --columns n_its"));
    assert!(unknown.code == 2 && unknown.err.contains("did you mean 'n_it'?"), "{}", unknown.err);
}

#[test]
fn a_run_ends_with_its_answers_and_files_have_them() {
    let folder = Folder::new();
    let arguments = format!(
        "run tetra:2 tetra:1 --size 16 --rounds 6 -s dropper,uniform-grid,obvhs-cwbvh:adapter=robust,obvhs-cwbvh -o {}",
        folder.path()
    );
    let ended = run(&arguments);
    let answers = ended.out.split("Answers over 2 scenes").nth(1).expect("answers");
    let heads = ["first image", "primary rays", "shadow rays", "diffuse rays", "least memory"];
    assert!(heads.iter().all(|head| answers.contains(head)), "{answers}");
    assert_eq!(ended.out.matches("break-even").count(), 2, "one for each scene: {}", ended.out);
    let record = folder.record();
    assert_eq!(record.conclusions.len(), heads.len());
    // what is wrong, or known to be, does not lead
    let is_right = |row: &str| row != "dropper" && row != "obvhs-cwbvh";
    assert!(record.conclusions.iter().all(|c| is_right(&c.row)), "{answers}");
    assert!(record.scenes.iter().all(|scene| !scene.least_time.is_empty()));
    let markdown = folder.text("results.md");
    assert!(markdown.find("## Answers over 2 scenes") < markdown.find("## tetra:2"));
    let page = run(&format!("report {} -o -", folder.path()));
    for conclusion in &record.conclusions {
        assert!(page.out.contains(&conclusion.row), "{}", conclusion.row);
    }
}

#[test]
fn colors_only_when_asked_for() {
    let arguments = "run tetra:2 --quick --rounds 1 -s obvhs-cwbvh,dropper";
    assert!(!run(arguments).out.contains('\x1b'));
    assert!(run(&format!("{arguments} --color always")).out.contains("\x1b[31m"));
}

#[test]
fn quiet_runs_say_nothing_but_results() {
    let ended = run("run tetra:2 -q --quick --rounds 1 -s obvhs-cwbvh");
    assert_eq!((ended.code, ended.err.as_str()), (0, ""));
    assert!(ended.out.contains("Answers for tetra:2"));
}

/// An output whose reader has gone.
struct Closed;

impl Write for Closed {
    fn write(&mut self, _: &[u8]) -> io::Result<usize> {
        Err(io::ErrorKind::BrokenPipe.into())
    }
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn a_closed_pipe_ends_quietly_unless_there_was_more_to_measure() {
    for (arguments, expected, said) in [
        ("list structures", 0, ""),
        ("--help", 0, ""),
        ("run tetra:2 --quick -s obvhs-cwbvh", 1, "error: standard output was closed before"),
    ] {
        let mut err = Vec::new();
        let (clock, world, mut out) = (SystemClock::default(), rtbench::program::world(), Closed);
        let mut context =
            Context::new(&PLANTED, &InstalledScenes, &clock, &world, &mut out, &mut err);
        let arguments = std::iter::once("rtbench").chain(arguments.split_whitespace());
        assert_eq!(rtbench::run(&mut context, arguments), expected);
        let err = String::from_utf8_lossy(&err);
        assert!(err.starts_with(said) && err.is_empty() == said.is_empty(), "{err}");
    }
}

#[test]
fn the_program_survives_closed_pipes() {
    for arguments in [&["list", "structures"][..], &["--help"], &["list", "rays", "--bogus"]] {
        let mut child = Command::new(env!("CARGO_BIN_EXE_rtbench"))
            .args(arguments)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        drop(child.stdout.take());
        let ended = child.wait_with_output().unwrap();
        assert!(matches!(ended.status.code(), Some(0 | 2)), "{ended:?}");
        assert!(!String::from_utf8_lossy(&ended.stderr).contains("panicked"), "{ended:?}");
    }
}
