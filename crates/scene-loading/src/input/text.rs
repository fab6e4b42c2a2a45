//! Text files of all formats: byte order marks, ends of lines, and words that stand for NaN.

use std::borrow::Cow;
use std::path::Path;

use memchr::memchr_iter;

use crate::error::{FilePlace, LoadError};

/// A file's bytes without the byte order mark of UTF-8.
///
/// # Errors
/// [`LoadError::Syntax`] for UTF-16 and UTF-32, with or without their marks.
pub(crate) fn without_mark<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a [u8], LoadError> {
    let is_wide = match bytes {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => true,
        // ASCII characters of two bytes each, of either order
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] => [a, b].iter().all(|c| c.is_ascii() && **c != 0),
        _ => false,
    };
    if is_wide {
        let expected = "UTF-8, or any text whose first 128 characters are ASCII's";
        return Err(LoadError::syntax(FilePlace::line(path, 1), "UTF-16 text", expected));
    }
    Ok(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes))
}

/// A file as text: without a byte order mark, its lines ended by LF or CR LF. What is not UTF-8
/// (Latin-1 comments) becomes the replacement character.
///
/// # Errors
/// As [`without_mark`].
pub(crate) fn text_of(path: &Path, mut bytes: Vec<u8>) -> Result<String, LoadError> {
    let mark = bytes.len() - without_mark(path, &bytes)?.len();
    bytes.drain(..mark);
    end_lines_with_lf(&mut bytes);
    let text = String::from_utf8(bytes);
    Ok(text.unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned()))
}

/// [`text_of`] for what is text already.
pub(crate) fn unified(text: &str) -> Cow<'_, str> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if memchr_iter(b'\r', text.as_bytes()).any(|at| is_lone(text.as_bytes(), at)) {
        text.replace("\r\n", "\n").replace('\r', "\n").into()
    } else {
        text.into()
    }
}

/// Replaces every CR that no LF follows by LF.
pub(crate) fn end_lines_with_lf(text: &mut [u8]) {
    let mut from = 0;
    while let Some(at) = memchr::memchr(b'\r', text.get(from..).unwrap_or_default()) {
        let at = from + at;
        if is_lone(text, at)
            && let Some(end) = text.get_mut(at)
        {
            *end = b'\n';
        }
        from = at + 1;
    }
}

/// True when no LF follows the CR at that place.
fn is_lone(text: &[u8], at: usize) -> bool {
    text.get(at + 1) != Some(&b'\n')
}

/// A number; also as C libraries write NaN and infinity: `-nan(ind)`, `1.#QNAN0`, `-1.#INF`.
pub(crate) fn parse_number(word: &str) -> Option<f64> {
    word.parse().ok().or_else(|| {
        let size = word.strip_prefix(['-', '+']).unwrap_or(word).to_ascii_lowercase();
        (size.starts_with("nan(") || size.starts_with("1.#")).then_some(f64::NAN)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn marks_are_stripped_and_wide_text_is_refused() {
        let path = Path::new("a.obj");
        assert_eq!(without_mark(path, b"\xef\xbb\xbfv").unwrap(), b"v");
        assert_eq!(without_mark(path, b"\xef\xbb").unwrap(), b"\xef\xbb");
        for wide in
            [&b"\xff\xfev\0"[..], b"\xfe\xff\0v", b"v\0 \x000\0", b"\0v\0 ", b"\xff\xfe\0\0"]
        {
            let error = without_mark(path, wide).unwrap_err().to_string();
            assert!(error.starts_with("a.obj:1: found `UTF-16 text`"), "{error}");
        }
    }

    #[test]
    fn all_line_ends_are_one() {
        for (text, expected) in [
            ("a\rb\r", "a\nb\n"),
            ("a\r\nb\rc", "a\r\nb\nc"),
            ("\r\r\n\r", "\n\r\n\n"),
            ("\u{feff}a", "a"),
            ("a\nb", "a\nb"),
        ] {
            assert_eq!(text_of(Path::new("a"), text.into()).unwrap(), expected);
            assert_eq!(unified(text).replace("\r\n", "\n"), expected.replace("\r\n", "\n"));
        }
        assert_eq!(text_of(Path::new("a"), b"caf\xe9".to_vec()).unwrap(), "caf\u{fffd}");
    }

    #[test]
    fn numbers_of_c_libraries() {
        assert_eq!(parse_number("-1.5e3"), Some(-1500.0));
        for nan in ["nan", "-nan(ind)", "NAN(snan)", "1.#QNAN0", "-1.#IND", "1.#INF00"] {
            assert!(parse_number(nan).is_some_and(|x| !x.is_finite()), "{nan}");
        }
        for word in ["", "-", "nano", "1.5#", "0x10", "1,5"] {
            assert_eq!(parse_number(word), None, "{word}");
        }
    }
}
