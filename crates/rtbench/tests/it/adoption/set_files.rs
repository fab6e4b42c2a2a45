//! Set files of the folder that the program runs in: their scenes and options in whole runs.

use std::fs;
use std::process::{Command, Output};

use crate::common::Folder;

/// A folder with set files, and runs of the program in it.
struct Workplace(Folder);

impl Workplace {
    fn new() -> Self {
        let folder = Folder::new();
        fs::create_dir_all(format!("{}/scenes/sets", folder.path())).unwrap();
        Self(folder)
    }

    fn path(&self, name: &str) -> String {
        format!("{}/{name}", self.0.path())
    }

    fn write_set(&self, name: &str, rest: &str) {
        let text = format!("{{\"name\": \"{name}\", \"title\": \"A set.\", {rest}}}");
        fs::write(self.path(&format!("scenes/sets/{name}.json")), text).unwrap();
    }

    fn rtbench(&self, line: &str) -> Output {
        let mut program = Command::new(env!("CARGO_BIN_EXE_rtbench"));
        program.args(line.split_whitespace()).current_dir(self.0.path()).output().unwrap()
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[test]
fn scenes_and_options_are_those_of_the_set_file() {
    let place = Workplace::new();
    fs::write(place.path("tri.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    place.write_set(
        "mine",
        "\"scenes\": [\"tetra:1\", \"../../tri.obj\"],
         \"run\": {\"size\": 8, \"rounds\": 2, \"structures\": \"obvhs-cwbvh\"}",
    );
    let ended = place.rtbench("run mine -o out");
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    let json = fs::read_to_string(place.path("out/results.json")).unwrap();
    let record: measurement::record::RunRecord = serde_json::from_str(&json).unwrap();
    assert_eq!(record.planned, ["tetra:1", "tri"]);
    assert_eq!(record.settings.resolution, [8, 8]);
    assert_eq!(record.scenes[0].rows[0].samples.len(), 2);
    let line = record.command_line.join(" ");
    assert!(line.ends_with("--rounds=2 --size=8 --structures=obvhs-cwbvh"), "{line}");
    // what is typed goes before
    place.rtbench("run mine --rounds 3 -o typed");
    let json = fs::read_to_string(place.path("typed/results.json")).unwrap();
    let record: measurement::record::RunRecord = serde_json::from_str(&json).unwrap();
    assert_eq!(record.scenes[0].rows[0].samples.len(), 3);

    let sets = text(&place.rtbench("list sets").stdout);
    assert!(sets.lines().any(|line| line.starts_with("mine ")), "{sets}");
    let valid = text(&place.rtbench("scenes validate mine").stdout);
    assert!(valid.contains("tri: can be used"), "{valid}");
}

#[test]
fn mistakes_in_a_set_file_are_errors_that_name_it() {
    let place = Workplace::new();
    let refused = |rest: &str, code: i32, said: &str| {
        place.write_set("mine", rest);
        let ended = place.rtbench("run mine --size 4");
        let err = text(&ended.stderr);
        assert!(ended.status.code() == Some(code) && err.contains(said), "{rest}: {err}");
    };
    let scenes = "\"scenes\": [\"tetra:1\"]";
    refused(
        &format!("{scenes}, \"run\": {{\"runds\": 3}}"),
        2,
        "scenes/sets/mine.json: run: unknown option 'runds' (did you mean 'rounds'?)",
    );
    refused("\"scenes\": [\"tetrra\"]", 2, "did you mean `tetra`?");
    refused(&format!("{scenes},\n \"rnu\": {{}}"), 1, "mine.json:2:");
    refused("\"scenes\": [\"lost.obj\"]", 1, "scenes/sets/lost.obj");
}

/// A run of `mine`, and the same with shadow rays of its grid that take 15% longer: all else
/// repeats to a part in a thousand.
fn slower_shadows(place: &Workplace) {
    let ended = place.rtbench("run mine -o before");
    assert!(ended.status.success(), "{}", text(&ended.stderr));
    let json = fs::read_to_string(place.path("before/results.json")).unwrap();
    let mut record: measurement::record::RunRecord = serde_json::from_str(&json).unwrap();
    for (name, slower) in [("before", 1.0), ("after", 1.15)] {
        for row in &mut record.scenes[0].rows {
            let factor = if row.is_reference { 1.0 } else { slower };
            for (round, sample) in row.samples.iter_mut().enumerate() {
                let steady = 1e-3 * (1.0 + 0.001 * (round % 3) as f64);
                sample.build_s = steady;
                sample.reference_build_s = Some(1e-3);
                sample.trace_s = [("primary", 1.0), ("shadow", factor)]
                    .map(|(kind, by)| (kind.to_owned(), by * steady))
                    .into();
                sample.reference_by_kind =
                    ["primary", "shadow"].map(|kind| (kind.to_owned(), 1e-3)).into();
                sample.reference_trace_s = Some(2e-3);
            }
        }
        fs::write(place.path(&format!("{name}.json")), serde_json::to_string(&record).unwrap())
            .unwrap();
    }
}

const MINE: &str = "\"scenes\": [\"tetra:1\"], \"run\": {\"size\": 8, \"rounds\": 12, \
    \"rays\": [\"primary\", \"shadow\"], \
    \"structures\": [\"uniform-grid:density=4\", \"obvhs-cwbvh\"]}";

const ROWS: &str = "-s uniform-grid:density=4,obvhs-cwbvh";

#[test]
fn rows_and_kinds_of_rays_have_the_thresholds_of_the_set_file() {
    let place = Workplace::new();
    place.write_set("mine", MINE);
    slower_shadows(&place);
    let check = |thresholds: &str, options: &str| {
        place.write_set("mine", &format!("{MINE}, \"check\": [{thresholds}]"));
        let line = format!("check --baseline before.json --results after.json {options}");
        let ended = place.rtbench(&line);
        (ended.status.code(), text(&ended.stdout) + &text(&ended.stderr))
    };
    // planted: all rays together take 7.5% longer
    let grid = r#"{"row": "uniform-grid:density=4", "time-threshold": "10%"}"#;
    assert_eq!(check(grid, "").0, Some(3), "a set applies where it is named");
    let (code, said) = check(grid, "--as mine --strict");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("threshold of uniform-grid density=4: time 10%"), "{said}");
    let other = r#"{"row": "kd-tree", "time-threshold": "10%"}"#;
    assert_eq!(check(other, "--as mine").0, Some(3));
    // a kind of rays is judged where a threshold names it
    let (code, said) =
        check(&format!(r#"{grid}, {{"of": "shadow", "time-threshold": "12%"}}"#), "--as mine");
    assert_eq!(code, Some(3), "{said}");
    let found = said.lines().find(|line| line.contains(" shadow ")).unwrap_or_default();
    assert!(found.contains("1.15") && found.contains("regression"), "{said}");
    let wide = format!(r#"{grid}, {{"of": "shadow", "time-threshold": "20%"}}"#);
    assert_eq!(check(&wide, "--as mine --strict").0, Some(0));

    // two programs in turns
    place.write_set("mine", &format!("{MINE}, \"check\": [{wide}]"));
    let line = format!("check mine --against {} --rounds 2", env!("CARGO_BIN_EXE_rtbench"));
    let ended = place.rtbench(&format!("{line} --size 8 --shortest 1us {ROWS} -o out"));
    let both = text(&ended.stdout) + &text(&ended.stderr);
    let json = fs::read_to_string(place.path("out/check.json")).expect(&both);
    let report: serde_json::Value = serde_json::from_str(&json).unwrap();
    let findings = report["findings"].as_array().unwrap();
    let is_shadow = |f: &&serde_json::Value| f["quantity"] == "shadow";
    let of_grid = findings.iter().filter(is_shadow).find(|f| f["row"] == "uniform-grid density=4");
    let change = &of_grid.unwrap()["change"];
    assert!(change["median"].as_f64().is_some(), "{both}");
}

#[test]
fn mistakes_in_thresholds_are_errors_that_name_file_and_entry() {
    let place = Workplace::new();
    let refused = |entry: &str, code: i32, said: &str| {
        let good = r#"{"row": "kd-tree", "time-threshold": "3%"}"#;
        place.write_set("mine", &format!("{MINE},\n\"check\": [{good},\n{entry}]"));
        let ended = place.rtbench("check --baseline none --as mine");
        let err = text(&ended.stderr);
        assert!(ended.status.code() == Some(code) && err.contains(said), "{entry}: {err}");
    };
    let of_entry = |said: &str| format!("scenes/sets/mine.json: check, entry 2: {said}");
    for (entry, said) in [
        (r#"{"row": "kd-tere", "time-threshold": "3%"}"#, "unknown structure 'kd-tere' (did you"),
        (
            r#"{"of": "shadw", "time-threshold": "3%"}"#,
            "of: unknown 'shadw' (did you mean 'shadow'",
        ),
        (r#"{"row": "kd-tree", "time-threshold": "3"}"#, "time-threshold: expected a percentage"),
        (r#"{"row": "kd-tree"}"#, "expected a time-threshold or an instruction-threshold"),
        (r#"{"time-threshold": "3%"}"#, "expected a row or a quantity"),
        (
            r#"{"of": "shadow", "instruction-threshold": "3%"}"#,
            "instruction-threshold: instructions of shadow",
        ),
    ] {
        refused(entry, 2, &of_entry(said));
    }
    refused(r#"{"row": "kd-tree", "time": "3%"}"#, 1, "mine.json:3:");
    place.write_set("mine", MINE);
    let ended = place.rtbench("check --baseline none --as mine");
    let err = text(&ended.stderr);
    assert!(ended.status.code() == Some(2) && err.contains("set with thresholds"), "{err}");
}
