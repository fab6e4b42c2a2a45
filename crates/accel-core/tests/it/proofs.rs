//! The constants in `proofs/` are those of the code: each is read from the text that its proof
//! quotes. Gappa is not needed here; `proofs/run` needs it.

use std::fs;
use std::path::{Path, PathBuf};

/// What a proof says a source file has, and which numbers it uses.
struct Quote {
    file: String,
    text: String,
    used: Vec<f64>,
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Numbers in a piece of Rust or Gappa, not those within names such as `f32`.
fn numbers(text: &str) -> Vec<f64> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_' || c == '.';
    let words = text.split(|c: char| !is_name(c)).map(|word| word.trim_end_matches('.'));
    words.filter(|w| w.starts_with(|c: char| c.is_ascii_digit())).map(number).collect()
}

fn number(word: &str) -> f64 {
    word.parse().unwrap_or_else(|_| panic!("{word} is no number"))
}

/// Comments of a file in one line each with the code, without their marks: a quote may be wrapped.
fn joined(source: &str) -> String {
    let line = |line: &str| line.trim().trim_start_matches('/').trim_start_matches('!').to_owned();
    let lines: Vec<String> = source.lines().map(line).collect();
    lines.join(" ").split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The quotes of a proof: `# from FILE: TEXT`, marks, and definitions up to an empty line or the
/// next quote.
fn quotes(proof: &str) -> Vec<Quote> {
    let mut all: Vec<Quote> = Vec::new();
    let mut is_open = false;
    for line in proof.lines() {
        if let Some((file, text)) = line.strip_prefix("# from ").and_then(|l| l.split_once(": ")) {
            all.push(Quote { file: file.to_owned(), text: text.to_owned(), used: Vec::new() });
            is_open = true;
        } else if line.is_empty() {
            is_open = false;
        } else if is_open
            && !line.starts_with('#')
            && let (Some(quote), Some((_, value))) = (all.last_mut(), line.split_once(" = "))
        {
            quote.used.extend(numbers(value));
        }
    }
    all
}

/// What keeps a proof from being one of the code.
fn difference(proof: &str, name: &str, source: impl Fn(&str) -> String) -> Option<String> {
    let quotes = quotes(proof);
    if quotes.is_empty() {
        return Some(format!("{name} has no constant of the code"));
    }
    quotes.into_iter().find_map(|Quote { file, text, used }| {
        let source = source(&file);
        let found = joined(&source).matches(&text).count();
        let value = text.rsplit_once(" = ").map_or(text.as_str(), |(_, value)| value);
        if found != 1 {
            Some(format!("{name}: {file} has \"{text}\" {found} times"))
        } else if used.is_empty() || numbers(value) != used {
            Some(format!("{name} has {used:?} for \"{text}\""))
        } else if !source.contains(name.strip_suffix(".gappa")?) {
            Some(format!("{file} does not name {name}"))
        } else {
            None
        }
    })
}

fn proofs() -> Vec<(String, String)> {
    let entries = fs::read_dir(root().join("proofs")).unwrap().map(|entry| entry.unwrap().path());
    let files = entries.filter(|path| path.extension().is_some_and(|e| e == "gappa"));
    let name = |path: &PathBuf| path.file_name().unwrap().to_str().unwrap().to_owned();
    files.map(|path| (name(&path), fs::read_to_string(&path).unwrap())).collect()
}

/// The number that a proof gives a constant of that name.
pub fn constant(name: &str) -> f64 {
    let start = format!("{name} = ");
    let value = |line: &str| Some(number(line.strip_prefix(&start)?.strip_suffix(';')?));
    let found = proofs().iter().find_map(|(_, proof)| proof.lines().find_map(value));
    found.unwrap_or_else(|| panic!("no proof has {name}"))
}

fn source(file: &str) -> String {
    fs::read_to_string(root().join(file)).unwrap_or_else(|e| panic!("{file}: {e}"))
}

#[test]
fn the_constants_of_proofs_are_those_of_the_code() {
    let proofs = proofs();
    assert!(proofs.len() >= 16, "{}", proofs.len());
    for (name, proof) in proofs {
        assert_eq!(difference(&proof, &name, source), None);
    }
}

#[test]
fn a_constant_that_differs_is_found() {
    let numbers_of = |proof: &str| quotes(proof).into_iter().map(|q| q.used).collect::<Vec<_>>();
    let mut planted = 0;
    for (name, proof) in proofs() {
        for quote in quotes(&proof) {
            let without = |file: &str| joined(&source(file)).replace(&quote.text, "");
            assert!(difference(&proof, &name, without).is_some(), "{name}: {}", quote.text);
        }
        let definitions = proof.lines().filter(|l| !l.starts_with('#') && l.contains(" = "));
        for line in definitions {
            let changed = proof.replace(line, "CHANGED = 99;");
            if numbers_of(&changed) != numbers_of(&proof) {
                planted += 1;
                assert!(difference(&changed, &name, source).is_some(), "{name}: {line}");
            }
        }
        let unnamed = |file: &str| source(file).replace(name.trim_end_matches(".gappa"), "");
        assert!(difference(&proof, &name, unnamed).is_some(), "{name}");
    }
    assert!(planted >= 30, "{planted}");
}
