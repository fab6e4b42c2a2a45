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
    let typed = place.rtbench("run mine --rounds 3 --export-json -");
    let record: measurement::record::RunRecord = serde_json::from_slice(&typed.stdout).unwrap();
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
