//! Runs that are broken off and resumed, without a process: the clock goes on by the same step each
//! time it is read, so that two runs have the same times.

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use accel_core::structures::{Entry, REGISTRY};
use measurement::journal::lines::{RecoveredRun, read};
use measurement::journal::seal::Seal;
use measurement::journal::{Journal, NAME};
use measurement::record::RunRecord;
use measurement::scenes::InstalledScenes;
use measurement::system::clock::SteppingClock;
use rtbench::context::Context;

/// Runs the program over that registry: exit code, standard output, standard error.
pub fn run_in(
    registry: &[Entry],
    arguments: impl IntoIterator<Item = OsString>,
) -> (u8, String, String) {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let (clock, world) = (SteppingClock::new(Duration::from_millis(1)), rtbench::program::world());
    let mut context = Context::new(registry, &InstalledScenes, &clock, &world, &mut out, &mut err);
    let arguments = std::iter::once(OsString::from("rtbench")).chain(arguments);
    let code = rtbench::run(&mut context, arguments);
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (code, text(out), text(err))
}

/// The same over the real registry, with arguments split at spaces.
pub fn run(arguments: &str) -> (u8, String, String) {
    run_in(REGISTRY, arguments.split_whitespace().map(Into::into))
}

/// The program as a process, with its output folder.
pub fn begun(arguments: &str, folder: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rtbench"));
    command.args(arguments.split_whitespace()).arg("-o").arg(folder);
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

pub fn show(path: &Path) -> String {
    path.display().to_string()
}

pub fn journal(folder: &Path) -> RecoveredRun {
    read(&std::fs::read(folder.join(NAME)).unwrap()).unwrap()
}

/// The text of a sealed line, whatever its checksum.
pub fn unsealed(line: &str) -> &str {
    let (_, text) = line.trim_end().split_once("\"line\":").unwrap();
    text.strip_suffix('}').unwrap()
}

/// A journal that was edited by somebody who knows how lines are sealed.
pub fn resealed(journal: &str) -> String {
    let mut seal = Seal::default();
    let mut text = String::new();
    for (i, line) in journal.split_inclusive('\n').enumerate() {
        if !line.ends_with('\n') {
            return text + line;
        }
        text += &(seal.sealed(unsealed(line)) + "\n");
        if i == 0 {
            seal = Seal::behind(unsealed(line));
        }
    }
    text
}

pub fn csv(folder: &Path) -> String {
    std::fs::read_to_string(folder.join("results.csv")).unwrap()
}

pub fn record(folder: &Path) -> RunRecord {
    let text = std::fs::read_to_string(folder.join("results.json")).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// Results of a run that do not depend on time: counters and verdicts by scene and row.
pub fn outputs(folder: &Path) -> BTreeMap<(String, String), String> {
    let record = record(folder);
    let mut rows = BTreeMap::new();
    for scene in record.scenes {
        for row in scene.rows {
            let said = format!("{:?} {:?} {:?}", row.verdict, row.work, row.stats);
            let before = rows.insert((scene.name.clone(), row.label()), said);
            assert!(before.is_none(), "a row is there twice");
        }
    }
    rows
}

const ARGUMENTS: &str = "run tetra:1 tetra:2 balls:1 --size 8 --rounds 2 --seed 7 \
                         -s uniform-grid:density=1,light-buffer,obvhs-cwbvh";

/// A run in a new folder.
fn finished(arguments: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let (code, out, err) = run(&format!("{arguments} -o {}", show(folder.path())));
    assert_eq!(code, 0, "{err}");
    (folder, out)
}

/// Leaves the first lines of a journal, and the beginning of the next.
fn tear(folder: &Path, lines: usize) {
    let text = std::fs::read_to_string(folder.join(NAME)).unwrap();
    let mut kept: String = text.split_inclusive('\n').take(lines).collect();
    let next = text.split_inclusive('\n').nth(lines).unwrap_or_default();
    kept.push_str(&next[..next.len() / 2]);
    std::fs::write(folder.join(NAME), kept).unwrap();
}

/// Breaks a run off behind each line of its journal, in the middle of the next.
#[test]
fn a_resumed_run_has_the_table_of_an_unbroken_one() {
    let (whole, expected) = finished(ARGUMENTS);
    // a manifest; of each scene its beginning, three times those of its three rows and that they
    // passed (checked, timed, rendered), its record; the end
    const OF_SCENE: usize = 14;
    for lines in 1..2 + 3 * OF_SCENE {
        let (folder, _) = finished(ARGUMENTS);
        tear(folder.path(), lines);
        for output in ["results.csv", "results.md", "results.json"] {
            std::fs::remove_file(folder.path().join(output)).unwrap();
        }
        let (code, out, err) = run(&format!("run --resume {}", show(folder.path())));
        assert_eq!(code, 0, "{lines}: {err}");
        assert_eq!(out, expected, "{lines}");
        assert_eq!(csv(folder.path()), csv(whole.path()), "{lines}");
        let rows = |folder: &Path| {
            let scenes = record(folder).scenes;
            scenes.into_iter().flat_map(|scene| scene.rows).collect::<Vec<_>>()
        };
        assert_eq!(rows(folder.path()), rows(whole.path()), "{lines}");
        let found = journal(folder.path());
        assert!(found.is_complete && found.finished.len() == 3);
        // scenes that were finished were not begun again
        let text = std::fs::read_to_string(folder.path().join(NAME)).unwrap();
        let begun = text.lines().filter(|line| unsealed(line).starts_with("{\"scene\":")).count();
        assert_eq!(begun, if lines % OF_SCENE == 1 { 3 } else { 4 }, "{lines}");
    }
}

/// Everything that must not be resumed, or begun over an unfinished run.
#[test]
fn runs_with_other_settings_are_not_resumed() {
    let obj = tempfile::tempdir().unwrap();
    let path = obj.path().join("a.obj");
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let arguments = format!("run {} tetra:1 --quick --size 8 -s obvhs-cwbvh", show(&path));
    let (folder, _) = finished(&arguments);
    let here = show(folder.path());
    // of the first scene its beginning, three times that of its row and that it passed, its record
    tear(folder.path(), 9);
    let whole = std::fs::read_to_string(folder.path().join(NAME)).unwrap();
    let refused = |said: &[&str]| {
        let (code, out, err) = run(&format!("run --resume {here}"));
        assert_eq!((code, out.as_str()), (1, ""), "{err}");
        assert!(said.iter().all(|part| err.contains(part)), "{err}");
    };
    // settings, program, scenes: each is named
    for (from, to, said) in [
        ("\"seed\":1", "\"seed\":2", "settings.seed: was 2, is 1"),
        ("\"program_sha256\":\"", "\"program_sha256\":\"0", "program_sha256: was"),
        ("\"cpu\":", "\"cpu\":null,\"x\":", "machine.cpu"),
        ("\"tetra:1\"],\"structures\"", "\"tetra:2\"],\"structures\"", "scenes: was"),
        ("\"plugins\":[]", "\"plugins\":[\"hug\"]", "plugins: was [hug], is []"),
        ("\"rounds\":\"Fixed", "\"rounds\":\"Fitted", "rounds: was"),
    ] {
        assert!(whole.contains(from), "{from}: {whole}");
        std::fs::write(folder.path().join(NAME), resealed(&whole.replacen(from, to, 1))).unwrap();
        refused(&["the settings differ from those of the interrupted run", said]);
    }
    // as an earlier version wrote it, and what no command line can say
    for (from, to, said) in [
        ("\"asked\":", "\"arguments\":", "an earlier version of rtbench started this run"),
        ("\"rounds\":null", "\"rounds\":0", "rounds: 0, expected a number from 1"),
        ("\"pass_limit\":null", "\"pass_limit\":{\"secs\":0,\"nanos\":0}", "pass-limit: 0"),
        ("\"each\",\"pass_limit\"", "\"up\",\"pass_limit\"", "line 1: 'up' is not a valid value"),
        ("\"asked\":{\"scenes\"", "\"asked\":{\"scene\"", "line 1: missing field `scenes`"),
    ] {
        assert!(whole.contains(from), "{from}: {whole}");
        std::fs::write(folder.path().join(NAME), resealed(&whole.replacen(from, to, 1))).unwrap();
        let (code, out, err) = run(&format!("run --resume {here}"));
        assert!(code != 0 && out.is_empty() && err.contains(said), "{said}: {err}");
    }
    let misspelled = resealed(&whole.replacen("{\"scene\"", "{\"scone\"", 1));
    std::fs::write(folder.path().join(NAME), misspelled).unwrap();
    refused(&["line 2", "scone"]);
    std::fs::write(folder.path().join(NAME), &whole).unwrap();
    std::fs::write(&path, "v 0 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    refused(&["scene a: sha256 was"]);
    std::fs::write(&path, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    // another run begun over it, a run beside it, other arguments, no run at all
    let (code, _, err) = run(&format!("{arguments} -o {here}"));
    assert!(
        code == 1
            && err.contains("1 of 2 scenes finished; resume with")
            && err.contains("--overwrite"),
        "{err}"
    );
    let (held, _) = Journal::resume(folder.path()).unwrap();
    refused(&["another run is writing to it"]);
    drop(held);
    let (code, _, err) = run(&format!("run --resume {here} tetra:2"));
    assert!(code == 2 && err.contains("--resume"), "{err}");
    let (code, _, err) = run(&format!("run --resume {}", show(obj.path())));
    assert!(code == 1 && err.contains("no run with -o was started here"), "{err}");
    // and after all that it can be finished, and begun anew
    let (code, _, err) = run(&format!("run --resume {here}"));
    assert_eq!(code, 0, "{err}");
    let (code, _, err) = run(&format!("{arguments} -o {here}"));
    assert!(code == 1 && err.contains("2 of 2 scenes finished"), "{err}");
    let (code, _, err) = run(&format!("{arguments} -o {here} --overwrite"));
    assert_eq!(code, 0, "{err}");
}
