//! The exporters, and the schemas of what they write.

use jsonschema::Validator;
use serde_json::Value;

use crate::common::{Folder, run_stepping};

const RUN: &str = "run tetra:2 --size 12 --rounds 2 -s uniform-grid,light-buffer,obvhs-cwbvh";

fn validator(schema: &str) -> Validator {
    let printed = run_stepping(&format!("generate schema {schema}"));
    assert_eq!(printed.code, 0, "{}", printed.err);
    let schema: Value = serde_json::from_str(&printed.out).unwrap();
    jsonschema::validator_for(&schema).expect("a schema")
}

fn errors(validator: &Validator, value: &Value) -> Vec<String> {
    validator.iter_errors(value).map(|e| format!("{}: {e}", e.instance_path())).collect()
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// What such a run writes to the file of its last option.
fn exported(run: &str, code: u8) -> Value {
    let folder = Folder::new();
    let ended = run_stepping(&format!("{run} {}/file", folder.path()));
    assert_eq!(ended.code, code, "{}", ended.err);
    json(&folder.text("file"))
}

#[test]
fn a_process_records_what_to_type_and_no_folder_of_its_machine() {
    let folder = Folder::new();
    let program = env!("CARGO_BIN_EXE_rtbench");
    let output = format!("{}/out", folder.path());
    let typed = ["run", "tetra:1", "--quick", "--rounds", "1", "--size", "4", "-s", "obvhs-cwbvh"];
    let series = format!("--export-bencher={output}.json");
    let ended =
        std::process::Command::new(program).args(typed).args([&series, "-o", &output]).output();
    let ended = ended.unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    let record: Value = serde_json::from_str(&folder.text("out/results.json")).unwrap();
    let line: Vec<&str> =
        record["command_line"].as_array().unwrap().iter().filter_map(Value::as_str).collect();
    assert_eq!(
        line,
        [&["rtbench"][..], &typed[..], &["--export-bencher=out.json", "-o", "out"]].concat()
    );
    for file in ["out/results.json", "out/results.md", "out/results.csv"] {
        let text = folder.text(file);
        assert!(!text.contains(&folder.path()) && !text.contains(program), "{file}");
    }
}

#[test]
fn records_are_of_their_schema() {
    let validator = validator("run-record");
    let folder = Folder::new();
    // with a wrong row and one that cannot be built, and as a part of a run
    for (arguments, code) in [
        ("run tetra:2 --size 12 --quick -s all,light-buffer", 4),
        ("run tetra:2 tetra:1 --size 12 --quick --shard 1/2 -s obvhs-cwbvh,uniform-grid", 0),
    ] {
        let ended = run_stepping(&format!("{arguments} -o {} --overwrite", folder.path()));
        assert_eq!(ended.code, code, "{}", ended.err);
        let record = serde_json::from_str(&folder.text("results.json")).unwrap();
        assert_eq!(errors(&validator, &record), Vec::<String>::new());
    }
}

#[test]
fn invalid_records_are_caught() {
    let validator = validator("run-record");
    let folder = Folder::new();
    assert_eq!(run_stepping(&format!("{RUN} -o {}", folder.path())).code, 0);
    let whole = json(&folder.text("results.json"));
    assert_eq!(errors(&validator, &whole), Vec::<String>::new());
    let planted = |place: &str, value: Option<Value>| {
        let mut record = whole.clone();
        let (parent, name) = place.rsplit_once('/').unwrap();
        let parent = record.pointer_mut(parent).unwrap().as_object_mut().unwrap();
        assert!(parent.remove(name).is_some(), "{place}");
        if let Some(value) = value {
            parent.insert(name.to_owned(), value);
        }
        errors(&validator, &record)
    };
    for (place, value) in [
        ("/settings", None),
        ("/machine/threads", None),
        ("/scenes/0/rows/0/samples/0/build_s", None),
        ("/started_unix_s", Some("yesterday".into())),
        ("/scenes/0/rows/0/mismatches", Some((-1).into())),
        ("/scenes/0/rows/0/build_s", Some(0.5.into())),
        ("/scenes/0/rows/0/verdict", Some("fine".into())),
        ("/scenes/0/rows/0/answers", Some("no rays".into())),
        ("/summary", Some(Value::Null)),
    ] {
        let said = planted(place, value);
        assert_eq!(said.len(), 1, "{place}: {said:?}");
    }
}

#[test]
fn foreign_formats_follow_their_schemas() {
    let action = validator("github-action-benchmark");
    let smaller = exported(&format!("{RUN} --export-github-smaller"), 0);
    assert_eq!(errors(&action, &smaller), Vec::<String>::new());
    let named = |entries: &Value, name: &str| {
        let found = entries.as_array().unwrap().iter().find(|e| e["name"] == name);
        found.unwrap_or_else(|| panic!("{name} in {entries}")).clone()
    };
    let trace = named(&smaller, "tetra:2: uniform-grid / build");
    assert_eq!((&trace["unit"], &trace["value"]), (&"s".into(), &0.001.into()));
    assert_eq!(trace["range"], "1.0000e-3 to 1.0000e-3");
    let counter = named(&smaller, "tetra:2: light-buffer / memory");
    assert!(counter["unit"] == "bytes" && counter["value"].as_f64() > Some(0.0));
    assert!(counter.get("range").is_none());
    assert_eq!(named(&smaller, "tetra:2: obvhs-cwbvh / ratio")["value"], 1.0);

    let bigger = exported(&format!("{RUN} --export-github-bigger"), 0);
    assert_eq!(errors(&action, &bigger), Vec::<String>::new());
    let primary = named(&bigger, "tetra:2: uniform-grid / mrays-primary");
    assert_eq!(primary["unit"], "Mrays/s");
    assert!((primary["value"].as_f64().unwrap() - 12.0 * 12.0 / 1e-3 / 1e6).abs() < 1e-9);

    let bencher = exported(&format!("{RUN} --export-bencher"), 0);
    assert_eq!(errors(&validator("bencher-metric-format"), &bencher), Vec::<String>::new());
    let build = &bencher["tetra:2: uniform-grid"]["build"];
    assert_eq!(build["value"], 0.001);
    assert!(build["lower_value"].is_number() && build["upper_value"].is_number());
    assert!(bencher["tetra:2: light-buffer"]["mrays-shadow"]["value"].is_number());

    for bad in [r#"[{"name": "x", "unit": "s"}]"#, r#"[{"name": "x", "unit": "s", "value": "1"}]"#]
    {
        assert!(!action.is_valid(&serde_json::from_str(bad).unwrap()), "{bad}");
    }
}

#[test]
fn series_are_selected_and_each_is_of_its_direction() {
    let names = |options: &str| -> Vec<String> {
        let entries = exported(&format!("{RUN} {options}"), 0);
        let name = |entry: &Value| entry["name"].as_str().unwrap().to_owned();
        entries.as_array().unwrap().iter().map(name).collect()
    };
    let all = names("--export-github-smaller");
    assert!(all.iter().any(|name| name.ends_with("/ n_ets")), "{all:?}");
    for neither in ["saved", "n_ev", "n_eets"] {
        assert!(!all.iter().any(|name| name.ends_with(&format!("/ {neither}"))), "{neither}");
    }
    let select = "--export-select uniform-grid./.(build|trace)$ --export-github-smaller";
    let selected = names(select);
    assert_eq!(selected, ["tetra:2: uniform-grid / build", "tetra:2: uniform-grid / trace"]);
    let bigger = names("--export-select light-buffer --export-github-bigger");
    assert_eq!(bigger, ["tetra:2: light-buffer / mrays-shadow"]);
    let bad = run_stepping(&format!("{RUN} --export-select ( --export-github-smaller no-file"));
    assert!(bad.code == 2 && bad.err.contains("--export-select"), "{}", bad.err);
}

#[test]
fn rows_that_are_wrong_are_left_out_of_time_series() {
    let run = "run tetra:2 --size 12 --quick -s dropper,obvhs-cwbvh --export-bencher";
    let names: Vec<_> = exported(run, 4).as_object().unwrap().keys().cloned().collect();
    assert_eq!(names, ["tetra:2: obvhs-cwbvh"]);
}
