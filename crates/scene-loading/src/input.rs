//! Files as bytes and as text: size caps, paths that stay in a folder, gzip and zstd with a budget
//! that follows from the size of the packed file, byte order marks, ends of lines, and words that
//! stand for NaN.

use std::borrow::Cow;
use std::fs::File;
use std::io::Read;
use std::path::{Component, Path, PathBuf};

use memchr::memchr_iter;
use ruzstd::decoding::StreamingDecoder;
use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};

use crate::error::{FilePlace, LoadError};
use crate::limits::MAX_BYTES;

/// Reads a regular file of at most [`MAX_BYTES`].
///
/// # Errors
/// [`LoadError::Io`] when it cannot be read or is no regular file (`/dev/zero`, a folder),
/// [`LoadError::TooLarge`] above the cap.
pub(crate) fn read_file(path: &Path) -> Result<Vec<u8>, LoadError> {
    read_at_most(path, MAX_BYTES)
}

/// [`read_file`] with a lower cap.
pub(crate) fn read_at_most(path: &Path, limit: u64) -> Result<Vec<u8>, LoadError> {
    let fail = |source| LoadError::io(path, source);
    let info = std::fs::metadata(path).map_err(fail)?;
    if !info.is_file() {
        return Err(fail(std::io::Error::other("not a regular file")));
    }
    if info.len() > limit {
        return Err(LoadError::too_large(path, limit));
    }
    let file = File::open(path).map_err(fail)?;
    let mut bytes = Vec::new();
    let _ = bytes.try_reserve(usize::try_from(info.len()).unwrap_or(0));
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > limit {
        return Err(LoadError::too_large(path, limit));
    }
    Ok(bytes)
}

/// The file's last ending in lower case, without the dot; empty when it has none.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
}

/// [`extension`] of what a file is once it is unpacked: the one before `.gz` and `.zst`.
pub(crate) fn unpacked_extension(path: &Path) -> String {
    let name = path.to_string_lossy().to_ascii_lowercase();
    let name = name.strip_suffix(".gz").or(name.strip_suffix(".zst")).unwrap_or(&name);
    name.rsplit_once('.').map_or_else(String::new, |(_, ending)| ending.to_owned())
}

/// The file's name without folder and without its endings `.gz`, `.zst` and the one before.
pub(crate) fn scene_name(path: &Path) -> String {
    let name = path.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let name = name.strip_suffix(".gz").or(name.strip_suffix(".zst")).unwrap_or(&name);
    match name.rsplit_once('.') {
        Some((stem, _)) if !stem.is_empty() => stem.to_string(),
        _ => name.to_string(),
    }
}

/// `path` relative to `folder` when it stays below it: no absolute path, no `..`, no drive, and no
/// symbolic link that leads out.
pub(crate) fn confined(folder: &Path, path: &str) -> Option<PathBuf> {
    let path = Path::new(path);
    let below = path.components().all(|c| matches!(c, Component::Normal(_) | Component::CurDir));
    if !below || path.file_name().is_none() {
        return None;
    }
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let file = folder.join(path);
    match (here.canonicalize(), file.canonicalize()) {
        (Ok(here), Ok(real)) => real.starts_with(here).then_some(file),
        // What is not there leads nowhere; whoever opens it will say so.
        _ => Some(file),
    }
}

/// True when nothing of that name is there.
pub(crate) fn is_missing(path: &Path) -> bool {
    matches!(path.symlink_metadata(), Err(e) if e.kind() == std::io::ErrorKind::NotFound)
}

/// Unpacked size allowed for any packed file: 64 MiB; less for fuzzers, which would spend their
/// time on unpacking.
const FREE: u64 = if cfg!(fuzzing) { 64 << 10 } else { 64 << 20 };

/// Unpacked bytes allowed per packed byte beyond that. Text scenes shrink by up to about 20 times.
const MAX_RATIO: u64 = if cfg!(fuzzing) { 2 } else { 200 };

/// Undoes the compression that the file's ending names (`.gz`, `.zst`), or returns the bytes as
/// they are.
///
/// # Errors
/// [`LoadError::Decompress`] on a damaged stream, [`LoadError::Inflated`] when it unpacks to more
/// than 64 MiB and 200 times its size, [`LoadError::TooLarge`] above [`MAX_BYTES`].
pub(crate) fn decompress(path: &Path, bytes: Vec<u8>) -> Result<Vec<u8>, LoadError> {
    let packed = bytes.len() as u64;
    let budget = (FREE + MAX_RATIO * packed).min(MAX_BYTES);
    let unpacked = match extension(path).as_str() {
        "gz" => gunzip(path, &bytes, budget)?,
        "zst" => unzstd(path, &bytes, budget)?,
        _ => return Ok(bytes),
    };
    match unpacked.len() as u64 {
        length if length <= budget => Ok(unpacked),
        _ if budget == MAX_BYTES => Err(LoadError::too_large(path, budget)),
        _ => Err(LoadError::Inflated { place: FilePlace::file(path), packed, limit: budget }),
    }
}

/// Unpacks until there is more than `budget`.
fn gunzip(path: &Path, bytes: &[u8], budget: u64) -> Result<Vec<u8>, LoadError> {
    let mut out = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes)
        .take(budget + 1)
        .read_to_end(&mut out)
        .map_err(|e| damaged(path, "gzip", &e))?;
    Ok(out)
}

/// As [`gunzip`]. A `.zst` file may hold several frames one after the other, and skippable ones
/// between them.
fn unzstd(path: &Path, bytes: &[u8], budget: u64) -> Result<Vec<u8>, LoadError> {
    let mut rest = bytes;
    let mut out = Vec::new();
    loop {
        match StreamingDecoder::new(&mut rest) {
            Ok(decoder) => {
                let room = (budget + 1).saturating_sub(out.len() as u64);
                decoder.take(room).read_to_end(&mut out).map_err(|e| damaged(path, "zstd", &e))?;
            }
            Err(FrameDecoderError::ReadFrameHeaderError(ReadFrameHeaderError::SkipFrame {
                length,
                ..
            })) => {
                let skip = usize::try_from(length).unwrap_or(usize::MAX);
                rest = rest.get(skip..).unwrap_or_default();
            }
            Err(e) => return Err(damaged(path, "zstd", &e)),
        }
        if rest.is_empty() || out.len() as u64 > budget {
            return Ok(out);
        }
    }
}

fn damaged(path: &Path, format: &'static str, error: &dyn std::fmt::Display) -> LoadError {
    LoadError::Decompress { place: FilePlace::file(path), format, message: error.to_string() }
}

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
    use std::io::Write;

    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    #[test]
    fn paths_are_confined() {
        let folder = Path::new("/scenes");
        assert_eq!(confined(folder, "a/b.bin"), Some("/scenes/a/b.bin".into()));
        for bad in ["../x", "a/../../x", "/etc/passwd", "", ".", ".."] {
            assert_eq!(confined(folder, bad), None, "{bad}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn links_are_confined_too() {
        let outside = tempfile::tempdir().unwrap();
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(outside.path().join("secret"), "x").unwrap();
        let link = |to: &Path, name: &str| {
            std::os::unix::fs::symlink(to, folder.path().join(name)).unwrap();
        };
        link(&outside.path().join("secret"), "file");
        link(outside.path(), "folder");
        std::fs::write(folder.path().join("own"), "x").unwrap();
        link(Path::new("own"), "inside");
        let is_allowed = |name: &str| confined(folder.path(), name).is_some();
        for name in ["own", "inside", "lost"] {
            assert!(is_allowed(name), "{name}");
        }
        assert!(!is_allowed("file") && !is_allowed("folder/secret"));
    }

    #[test]
    fn names_lose_their_endings() {
        assert_eq!(scene_name(Path::new("a/balls.nff.gz")), "balls");
        assert_eq!(scene_name(Path::new("kitchen.obj.zst")), "kitchen");
        assert_eq!(scene_name(Path::new("my.scene.obj")), "my.scene");
    }

    fn gz(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn gzip_is_undone() {
        let path = Path::new("x.nff.gz");
        assert_eq!(decompress(path, gz(b"hello")).unwrap(), b"hello");
        let error = decompress(path, b"not gzip".to_vec()).unwrap_err();
        assert!(matches!(error, LoadError::Decompress { format: "gzip", .. }), "{error}");
    }

    #[test]
    fn bombs_end_at_their_budget() {
        let zeros = vec![0; 96 << 20];
        let packed =
            [("gz", gz(&zeros)), ("zst", compress_to_vec(&zeros[..], CompressionLevel::Fastest))];
        for (ending, bytes) in packed {
            let path = Path::new("x.obj").with_extension(format!("obj.{ending}"));
            let found = decompress(&path, bytes.clone());
            let error = found.map(|unpacked| unpacked.len()).unwrap_err();
            assert!(matches!(error, LoadError::Inflated { .. }), "{error}");
            // ... of which no more than that was unpacked
            let budget = FREE + MAX_RATIO * bytes.len() as u64;
            let unpacked = match ending {
                "gz" => gunzip(&path, &bytes, budget),
                _ => unzstd(&path, &bytes, budget),
            };
            assert_eq!(unpacked.unwrap().len() as u64, budget + 1);
        }
    }

    #[test]
    fn zstd_frames_are_joined() {
        let path = Path::new("x.obj.zst");
        let mut bytes = compress_to_vec(&b"one "[..], CompressionLevel::Fastest);
        bytes.extend([0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 9, 9, 9]); // a skippable frame
        bytes.extend(compress_to_vec(&b"two"[..], CompressionLevel::Fastest));
        assert_eq!(decompress(path, bytes.clone()).unwrap(), b"one two");
        assert_eq!(unzstd(path, &bytes, 5).unwrap(), b"one tw");
        bytes.truncate(bytes.len() - 3);
        assert!(matches!(decompress(path, bytes), Err(LoadError::Decompress { .. })));
    }

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
