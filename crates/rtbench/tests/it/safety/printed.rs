//! Names and words from outside are text wherever they are printed.

use std::path::Path;

use measurement::record::RunRecord;
use presentation::outside::is_hidden;

use crate::resuming::show;
use crate::safety::{run_words, write_triangle};

/// Orders to CI jobs and terminals, as names of files.
const NAMES: [&str; 7] = [
    "::error title=x::a",
    "b\n::warning::b",
    "c\r::error::c",
    "##[error]d",
    "e\u{1b}]0;title\u{7}\u{1b}[2J\u{1b}[31m",
    "f\u{9b}2J\u{202e}f\u{2066}",
    "=g|<img src=x>`g`",
];

/// No line is an order, and nothing gives one to a terminal.
fn assert_is_text(what: &str, text: &str) {
    for line in text.lines() {
        assert!(!line.trim_start().starts_with("::"), "{what}: {line:?}");
        assert!(!line.contains("##["), "{what}: {line:?}");
        assert!(!line.contains(is_hidden), "{what}: {line:?}");
    }
    assert!(!text.contains('\r'), "{what}");
}

/// Runs, asserts that all that is printed is text, returns it.
fn printed(code: u8, arguments: &[&str]) -> String {
    let (found, out, err) = run_words(arguments);
    assert_eq!(found, code, "{arguments:?}: {err}");
    assert_is_text(&format!("{arguments:?}, standard output"), &out);
    assert_is_text(&format!("{arguments:?}, standard error"), &err);
    out + &err
}

const SMALL: [&str; 7] = ["--size", "4", "--rounds", "1", "-s", "obvhs-cwbvh,uniform-grid", "-v"];

#[test]
fn names_of_files_are_text() {
    let folder = tempfile::tempdir().unwrap();
    let paths: Vec<String> =
        NAMES.iter().map(|name| show(&folder.path().join(format!("{name}.obj")))).collect();
    paths.iter().for_each(|path| write_triangle(Path::new(path)));
    let paths: Vec<&str> = paths.iter().map(String::as_str).collect();
    let (out, missing) =
        (show(&folder.path().join("out")), show(&folder.path().join("::no\n::x.obj")));
    let told = printed(0, &[&["run", "-o", &out], &paths[..], &SMALL].concat());
    assert!(told.contains("b\\n::warning::b") && told.contains("e\\u001b]0;"), "{told}");
    printed(0, &[&["scenes", "info"], &paths[..]].concat());
    printed(0, &[&["scenes", "validate"], &paths[..]].concat());
    printed(1, &["scenes", "info", &missing]);
    printed(2, &["run", "tetra:1", "-s", "::error::x\n::y"]);
    printed(2, &["run", "tetra:1", "--rounds", "\n::error::x\u{1b}[2J"]);
    printed(2, &["\n::error::x\u{1b}[2J"]);
    printed(1, &["compare", &missing, &out]);
    printed(1, &["run", "--resume", &missing]);
    printed(1, &["run", "tetra:2", "-o", &out]);
    for format in ["text", "markdown", "csv", "json"] {
        let told = printed(0, &["compare", &out, &out, "-m", "all", "--format", format]);
        assert!(!told.contains("<img") || ["text", "csv", "json"].contains(&format), "{told}");
    }
    printed(0, &["report", &out, "-o", "-"]);
    // and in files
    let text = |name: &str| std::fs::read_to_string(Path::new(&out).join(name)).unwrap();
    for name in ["results.csv", "results.md"] {
        assert!(!text(name).lines().any(|line| line.contains(is_hidden)), "{name}");
    }
    let csv = text("results.csv");
    assert!(csv.contains("'=g|") && !csv.contains("\n=g") && !csv.contains(",=g"), "{csv}");
    let markdown = text("results.md");
    assert!(
        markdown.contains("\\|&lt;img src=x>\\`g\\`") && !markdown.contains("<img"),
        "{markdown}"
    );
}

#[test]
fn names_of_materials_are_text() {
    let folder = tempfile::tempdir().unwrap();
    let obj = folder.path().join("a.obj");
    let text = "mtllib a\u{1b}[2J.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\u{1b}]0;t\u{7}\u{9b}1m\nf 1 2 3\n";
    std::fs::write(&obj, text).unwrap();
    let told = printed(0, &["scenes", "validate", &show(&obj)]);
    assert!(told.contains("\\u001b") && told.contains("second reader: "), "{told}");
    printed(0, &[&["run", &*show(&obj)], &SMALL[..]].concat());
    printed(0, &["scenes", "info", &show(&obj)]);
}

/// Records, too, come from outside.
#[test]
fn words_of_records_are_text() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| show(&folder.path().join(name));
    printed(0, &[&["run", "tetra:1", "-o", &*at("a")], &SMALL[..]].concat());
    let path = folder.path().join("a/results.json");
    let mut record: RunRecord =
        serde_json::from_str(&std::fs::read_to_string(&path).unwrap()).unwrap();
    let order = "=x\u{1b}[2J\n::error::x##[group]|<img>\u{202e}";
    record.command_line.push(order.into());
    record.machine.cpu = Some(order.into());
    record.settings.reference = order.into();
    record.scenes[0].name = order.into();
    record.scenes[0].warnings.push(order.into());
    record.scenes[0].rows[1].settings = order.into();
    record.scenes[0].rows[1].error = Some(order.into());
    let planted = folder.path().join("b");
    std::fs::create_dir(&planted).unwrap();
    std::fs::write(planted.join("results.json"), serde_json::to_string(&record).unwrap()).unwrap();
    for format in ["text", "markdown", "csv", "json"] {
        printed(0, &["compare", &at("b"), &at("b"), "-m", "all", "--format", format]);
    }
    printed(0, &["report", &at("b"), "-o", "-"]);
    printed(0, &["baseline", "save", "x", "--from", &at("b"), "--baselines", &at("c")]);
    printed(0, &["baseline", "show", "x", "--baselines", &at("c")]);
    let (code, out, err) = run_words(&["check", "--baseline", "x", "--baselines", &at("c")]);
    assert_ne!(code, 0);
    assert_is_text("check", &(out + &err));
    let (code, out, err) = run_words(&["merge", &at("b"), &at("b")]);
    assert_eq!(code, 1);
    assert_is_text("merge", &(out + &err));
}
