//! The checksum of a journal's line. It covers the line and the manifest of its run, so that a line
//! that was edited, or that another journal's run wrote, is found.
//!
//! A sealed line is one JSON value, `{"check":"<16 hex digits>","line":<the line>}`: the beginning
//! of the SHA-256 of the first line's checksum (of nothing, for the first line) and the line's own
//! text.

use scene_loading::source_hash::sha256_of_bytes;

/// Hex digits of a checksum.
const DIGITS: usize = 16;
const BEFORE_CHECK: &str = "{\"check\":\"";
const BEFORE_LINE: &str = "\",\"line\":";
const BEHIND_LINE: &str = "}";

const NO_CHECK: &str = "no checksum: the line is damaged, or was written by another version";
const WRONG_CHECK: &str = "wrong checksum: the line was edited, or belongs to another run";

#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Seal {
    /// The checksum of the run's first line; empty before it.
    run: String,
}

impl Seal {
    /// The seal of all lines behind a first line with that text.
    pub fn behind(first: &str) -> Self {
        Self { run: Self::default().check(first) }
    }

    /// The line with its checksum, without a line break.
    pub fn sealed(&self, text: &str) -> String {
        format!("{BEFORE_CHECK}{}{BEFORE_LINE}{text}{BEHIND_LINE}", self.check(text))
    }

    /// The text of a sealed line; what is wrong with one that is not.
    pub fn opened<'l>(&self, line: &'l str) -> Result<&'l str, &'static str> {
        let (check, text) = parts(line).ok_or(NO_CHECK)?;
        if check == self.check(text) { Ok(text) } else { Err(WRONG_CHECK) }
    }

    fn check(&self, text: &str) -> String {
        let mut check = sha256_of_bytes(format!("{}{text}", self.run).as_bytes());
        check.truncate(DIGITS);
        check
    }
}

/// Checksum and text of a sealed line.
fn parts(line: &str) -> Option<(&str, &str)> {
    let (check, rest) = line.strip_prefix(BEFORE_CHECK)?.split_at_checked(DIGITS)?;
    let text = rest.strip_prefix(BEFORE_LINE)?.trim_end_matches(['\n', '\r']);
    Some((check, text.strip_suffix(BEHIND_LINE)?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_valid_with_their_own_seal_only() {
        let seal = Seal::behind("{\"begun\":1}");
        let line = seal.sealed("{\"scene\":0}");
        assert_eq!(seal.opened(&line), Ok("{\"scene\":0}"));
        assert_eq!(seal.opened(&format!("{line}\n")), Ok("{\"scene\":0}"));
        for other in [Seal::default(), Seal::behind("{\"begun\":2}")] {
            assert_eq!(other.opened(&line), Err(WRONG_CHECK));
        }
        assert_eq!(seal.opened("{\"scene\":0}"), Err(NO_CHECK));
        assert_eq!(seal.opened(""), Err(NO_CHECK));
        serde_json::from_str::<serde_json::Value>(&line).expect("one JSON value");
    }

    #[test]
    fn every_changed_byte_is_found() {
        let seal = Seal::behind("x");
        let line = seal.sealed("{\"scene\":0}");
        for at in 0..line.len() {
            let mut edited = line.clone().into_bytes();
            edited[at] ^= 1;
            assert!(seal.opened(&String::from_utf8(edited).unwrap()).is_err(), "{at}");
        }
    }
}
