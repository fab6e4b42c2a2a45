//! Plain words: no listed word in sources, few doc comments that only repeat a name.

use std::fs;

use super::{FLOORS, sources};
use crate::common::files_below;

/// Phrases and names that have a plain word instead.
const LISTED: [(&str, &str); 12] = [
    ("held against", "compared with"),
    ("gone on with", "resumed"),
    ("go on with", "resume"),
    ("in the place of", "instead of"),
    ("wrong way round", "min > max"),
    ("told apart", "distinguished"),
    ("without a word", "say what happened"),
    ("is_worth_a", "should_"),
    ("brought_near", "rebase_origin"),
    ("is_nowhere", "misses"),
    ("in_company", "in_batch"),
    ("match () {", "if"),
];

/// Names that no type may have: participles, pronouns, prepositions, adverbs.
const NO_TYPES: &str = "Told Said Took Unlike Reign Crowd Company From Seen Found Asked Kept Left \
                        Made Met Put Own Other Both Next Near Over Within Beside Before Below \
                        Above Around Along Across Whole Wanted Narrowed Begun Entangled Way Part \
                        Tally Timed Judged Built Placed Drawn Shown Lower Upper";

/// Limit of doc comments of at most three words; lower it when there are fewer.
const MOST_TRIVIAL: usize = 137;

/// Describes the fault of a line, if any.
fn fault(line: &str) -> Option<String> {
    let listed = LISTED.iter().find(|(word, _)| line.contains(word));
    if let Some((word, plain)) = listed {
        return Some(format!("'{word}': say '{plain}'"));
    }
    let mut words = line.split(|c: char| !c.is_alphanumeric() && c != '_');
    words.find(|word| ["struct", "enum", "trait", "type"].contains(word))?;
    let name = words.next()?;
    let is_code = !line.trim_start().starts_with("//");
    (is_code && NO_TYPES.split_whitespace().any(|no| no == name))
        .then(|| format!("type {name}: name it by a noun of the field"))
}

/// Doc comments that consist of one line of at most three words.
fn trivial(text: &str) -> usize {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let is_doc = |i: usize| lines.get(i).is_some_and(|line| line.starts_with("///"));
    let is_alone = |i: usize| is_doc(i) && !(i > 0 && is_doc(i - 1)) && !is_doc(i + 1);
    let is_short = |i: usize| (1..=3).contains(&lines[i][3..].split_whitespace().count());
    (0..lines.len()).filter(|&i| is_alone(i) && is_short(i)).count()
}

#[test]
fn sources_use_plain_words() {
    let mut faults = Vec::new();
    let mut short = 0;
    let files = FLOORS.iter().flat_map(|name| files_below(&sources(name)));
    for path in files.filter(|path| path.extension().is_some_and(|e| e == "rs")) {
        let text = fs::read_to_string(&path).unwrap();
        short += trivial(&text);
        for (line, of) in text.lines().zip(1..) {
            faults.extend(fault(line).map(|fault| format!("{}:{of}: {fault}", path.display())));
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
    assert!(
        short <= MOST_TRIVIAL,
        "{short} doc comments of at most three words, at most {MOST_TRIVIAL} may be there: delete \
         those that repeat a name"
    );
}

#[test]
fn planted_words_are_named() {
    for (line, word) in [
        ("/// The run that it is held against.", "held against"),
        ("pub(crate) struct Told {", "Told"),
        ("    enum Way<'a> {", "Way"),
        ("        if is_worth_a_fork(n) {", "is_worth_a"),
        ("    #[error(\"{0}: go on with {1}\")]", "go on with"),
    ] {
        assert!(fault(line).is_some_and(|fault| fault.contains(word)), "{line}");
    }
    for line in ["/// A struct Told by its name.", "struct Wayfinder;", "match flag {"] {
        assert_eq!(fault(line), None);
    }
    let text = "/// Its name.\na: u8,\n/// Two lines\n/// of text.\nb: u8,\n\
                /// The length in metres.\nc: u8,\n";
    assert_eq!(trivial(text), 1);
}
