//! The paths that a source file names, read off its text.

/// A path with its segments, `crate` or a crate's name first.
pub type Path = Vec<String>;

/// Names used in a file.
#[derive(Debug, Default)]
pub struct Imports {
    /// Paths that it uses.
    pub used: Vec<Path>,
    /// Names that a `use` makes known in it, and their paths.
    pub known_as: Vec<(String, Path)>,
    /// Paths that it gives on under a name of its own: the name and the path.
    pub given_on: Vec<(String, Path)>,
    /// The text without them, comments, strings and tests.
    pub code: String,
}

/// Reads a file's text.
pub fn read(source: &str) -> Imports {
    let text = without_tests(&plain(source));
    let mut imports = Imports::default();
    let mut rest = text.as_str();
    while let Some(at) = find_word(rest, "use") {
        let (before, from) = rest.split_at(at);
        imports.code.push_str(before);
        let (statement, after) = from.split_once(';').unwrap_or((from, ""));
        let is_given_on = before.trim_end().ends_with("pub")
            || before.trim_end().ends_with(')')
                && before
                    .rsplit("pub")
                    .next()
                    .is_some_and(|s| s.trim_end().starts_with('(') && s.trim_end().ends_with(')'));
        for (path, name) in flattened(statement.trim_start_matches("use")) {
            if is_given_on {
                imports.given_on.push((name, path));
            } else {
                imports.used.push(path.clone());
                imports.known_as.push((name, path));
            }
        }
        rest = after;
    }
    imports.code.push_str(rest);
    imports.used.extend(inline(&imports.code));
    imports
}

/// The text without comments, strings and characters.
fn plain(source: &str) -> String {
    let chars: Vec<char> = source.chars().collect();
    let at = |i: usize| chars.get(i).copied().unwrap_or('\n');
    let mut out = String::new();
    let mut i = 0;
    while i < chars.len() {
        match (at(i), at(i + 1)) {
            ('/', '/') => {
                while i < chars.len() && at(i) != '\n' {
                    i += 1
                }
            }
            ('/', '*') => {
                i += 2;
                while i < chars.len() && (at(i), at(i + 1)) != ('*', '/') {
                    i += 1
                }
                i += 2;
            }
            ('r', '"' | '#') if !out.ends_with(|c: char| c.is_alphanumeric() || c == '_') => {
                let hashes = (i + 1..).take_while(|&j| at(j) == '#').count();
                if at(i + 1 + hashes) != '"' {
                    out.push('r');
                    i += 1;
                    continue;
                }
                i += 2 + hashes;
                let is_end = |j: usize| at(j) == '"' && (1..=hashes).all(|k| at(j + k) == '#');
                while i < chars.len() && !is_end(i) {
                    i += 1
                }
                i += 1 + hashes;
                out.push_str("\"\"");
            }
            ('"', _) => {
                i += 1;
                while i < chars.len() && at(i) != '"' {
                    i += if at(i) == '\\' { 2 } else { 1 }
                }
                i += 1;
                out.push_str("\"\"");
            }
            ('\'', '\\') => {
                i += 3;
                while i < chars.len() && at(i) != '\'' {
                    i += 1
                }
                i += 1;
            }
            ('\'', _) if at(i + 2) == '\'' => i += 3,
            (other, _) => {
                out.push(other);
                i += 1;
            }
        }
    }
    out
}

/// The text without what only tests compile.
fn without_tests(text: &str) -> String {
    let Some((before, after)) = text.split_once("#[cfg(test)]") else { return text.to_owned() };
    let end = match (after.find('{'), after.find(';')) {
        (Some(open), semicolon) if semicolon.is_none_or(|s| open < s) => closed(after, open),
        (_, semicolon) => semicolon.map_or(after.len(), |s| s + 1),
    };
    format!("{before}{}", without_tests(&after[end..]))
}

/// Behind the brace that closes the one at `open`.
fn closed(text: &str, open: usize) -> usize {
    let mut depth = 0;
    for (i, c) in text.char_indices().skip_while(|(i, _)| *i < open) {
        match c {
            '{' => depth += 1,
            '}' if depth == 1 => return i + 1,
            '}' => depth -= 1,
            _ => {}
        }
    }
    text.len()
}

/// Start of a whole word.
fn find_word(text: &str, word: &str) -> Option<usize> {
    let is_part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(word).map(|(i, _)| i).find(|&i| {
        !text[..i].ends_with(is_part) && text[i + word.len()..].starts_with(char::is_whitespace)
    })
}

/// The paths of a tree like `a::{b, c::{self, d as e}}`, each with the name it is known by.
fn flattened(tree: &str) -> Vec<(Path, String)> {
    let tree = tree.trim();
    let Some(open) = tree.find('{') else {
        let (path, renamed) = match tree.split_once(" as ") {
            Some((path, name)) => (path, Some(name.trim().to_owned())),
            None => (tree, None),
        };
        let mut path: Path = path.split("::").map(|s| s.trim().to_owned()).collect();
        path.retain(|s| !s.is_empty());
        if path.len() > 1 && path.last().is_some_and(|s| s == "self" || s == "*") {
            path.pop();
        }
        let name = renamed.or_else(|| path.last().cloned()).unwrap_or_default();
        return vec![(path, name)];
    };
    let prefix = tree[..open].trim();
    let body = &tree[open + 1..closed(tree, open) - 1];
    let mut parts = vec![String::new()];
    let mut depth = 0;
    for c in body.chars() {
        match c {
            ',' if depth == 0 => parts.push(String::new()),
            _ => {
                depth += i32::from(c == '{') - i32::from(c == '}');
                parts.last_mut().expect("never empty").push(c);
            }
        }
    }
    let whole = parts.iter().map(|part| part.trim()).filter(|part| !part.is_empty());
    whole.flat_map(|part| flattened(&format!("{prefix}{part}"))).collect()
}

/// The paths within code: `crate::a::b(...)`.
fn inline(code: &str) -> Vec<Path> {
    let is_path = |c: char| c.is_alphanumeric() || c == '_' || c == ':';
    let tokens = code.split(|c| !is_path(c)).filter(|token| token.contains("::"));
    let path =
        |token: &str| token.split("::").filter(|s| !s.is_empty()).map(str::to_owned).collect();
    tokens.filter(|token| !token.starts_with(':')).map(path).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_read_off_the_text() {
        let source = r##"
            //! use crate::comment;
            use crate::a::{self, b::{C, D as E}, f};
            pub(crate) use crate::g::H;
            pub use i::*;
            const TEXT: &str = "use crate::text; {"; const RAW: &str = r#"crate::raw"#;
            fn f<'a>(x: &'a str) -> char { crate::j::k(x); std::fs::read(x); '{' }
            #[cfg(test)]
            mod tests { use crate::tests; }
        "##;
        let imports = read(source);
        let joined = |paths: &[Path]| paths.iter().map(|p| p.join("::")).collect::<Vec<_>>();
        assert_eq!(
            joined(&imports.used),
            [
                "crate::a",
                "crate::a::b::C",
                "crate::a::b::D",
                "crate::a::f",
                "crate::j::k",
                "std::fs::read"
            ]
        );
        let given: Vec<_> =
            imports.given_on.iter().map(|(n, p)| (n.as_str(), p.join("::"))).collect();
        assert_eq!(given, [("H", "crate::g::H".to_owned()), ("i", "i".to_owned())]);
        let known: Vec<&str> = imports.known_as.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(known, ["a", "C", "E", "f"]);
    }
}
