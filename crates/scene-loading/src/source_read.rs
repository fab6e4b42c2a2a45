//! Reading the bytes of a scene file: size caps, gzip and zstd, and text that is not UTF-8.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::{LoadError, Place};

/// The most bytes that any loader takes into memory from one file, after decompression: 2 GiB.
pub const MAX_BYTES: u64 = 2 << 30;

/// Reads a regular file of at most [`MAX_BYTES`].
///
/// # Errors
/// [`LoadError::Io`] when it cannot be read or is no regular file (`/dev/zero`, a folder),
/// [`LoadError::TooLarge`] above the cap.
pub fn read_file(path: &Path) -> Result<Vec<u8>, LoadError> {
    let fail = |source| LoadError::io(path, source);
    let info = std::fs::metadata(path).map_err(fail)?;
    if !info.is_file() {
        return Err(fail(std::io::Error::other("not a regular file")));
    }
    if info.len() > MAX_BYTES {
        return Err(LoadError::TooLarge { place: Place::file(path), limit: MAX_BYTES });
    }
    let file = File::open(path).map_err(fail)?;
    let mut bytes = Vec::new();
    let _ = bytes.try_reserve(usize::try_from(info.len()).unwrap_or(0));
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(fail)?;
    capped(path, bytes, MAX_BYTES)
}

/// Undoes the compression that the file's ending names (`.gz`, `.zst`), or returns the bytes as
/// they are.
///
/// # Errors
/// [`LoadError::Decompress`] on a damaged stream, [`LoadError::TooLarge`] when it unpacks to more
/// than `limit` bytes.
pub fn decompress(path: &Path, bytes: Vec<u8>, limit: u64) -> Result<Vec<u8>, LoadError> {
    match extension(path).as_str() {
        "gz" => gunzip(path, &bytes, limit),
        "zst" => unzstd(path, &bytes, limit),
        _ => Ok(bytes),
    }
}

fn gunzip(path: &Path, bytes: &[u8], limit: u64) -> Result<Vec<u8>, LoadError> {
    let mut out = Vec::new();
    flate2::read::MultiGzDecoder::new(bytes)
        .take(limit.saturating_add(1))
        .read_to_end(&mut out)
        .map_err(|e| damaged(path, "gzip", &e))?;
    capped(path, out, limit)
}

/// A `.zst` file may hold several frames one after the other, and skippable ones between them.
fn unzstd(path: &Path, bytes: &[u8], limit: u64) -> Result<Vec<u8>, LoadError> {
    use ruzstd::decoding::StreamingDecoder;
    use ruzstd::decoding::errors::{FrameDecoderError, ReadFrameHeaderError};

    let mut rest = bytes;
    let mut out = Vec::new();
    loop {
        match StreamingDecoder::new(&mut rest) {
            Ok(decoder) => {
                let room = limit.saturating_add(1).saturating_sub(out.len() as u64);
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
        if rest.is_empty() || out.len() as u64 > limit {
            return capped(path, out, limit);
        }
    }
}

fn damaged(path: &Path, format: &'static str, error: &dyn std::fmt::Display) -> LoadError {
    LoadError::Decompress { place: Place::file(path), format, message: error.to_string() }
}

fn capped(path: &Path, bytes: Vec<u8>, limit: u64) -> Result<Vec<u8>, LoadError> {
    if bytes.len() as u64 > limit {
        return Err(LoadError::TooLarge { place: Place::file(path), limit });
    }
    Ok(bytes)
}

/// Bytes as text; what is not UTF-8 (Latin-1 comments) becomes the replacement character.
pub(crate) fn lossy_text(bytes: Vec<u8>) -> String {
    String::from_utf8(bytes)
        .unwrap_or_else(|error| String::from_utf8_lossy(error.as_bytes()).into_owned())
}

/// The file's last ending in lower case, without the dot; empty when it has none.
pub(crate) fn extension(path: &Path) -> String {
    path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase()).unwrap_or_default()
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
    use std::path::Component;
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

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Write;

    fn gz(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn gzip_is_undone_and_capped() {
        let path = Path::new("x.nff.gz");
        assert_eq!(decompress(path, gz(b"hello"), 5).unwrap(), b"hello");
        let bomb = gz(&vec![b' '; 100_000]);
        let error = decompress(path, bomb, 1000).unwrap_err();
        assert!(matches!(error, LoadError::TooLarge { limit: 1000, .. }), "{error}");
        let error = decompress(path, b"not gzip".to_vec(), 1000).unwrap_err();
        assert!(matches!(error, LoadError::Decompress { format: "gzip", .. }), "{error}");
    }

    #[test]
    fn zstd_frames_are_joined() {
        use ruzstd::encoding::{CompressionLevel, compress_to_vec};
        let path = Path::new("x.obj.zst");
        let mut bytes = compress_to_vec(&b"one "[..], CompressionLevel::Fastest);
        bytes.extend([0x50, 0x2a, 0x4d, 0x18, 3, 0, 0, 0, 9, 9, 9]); // a skippable frame
        bytes.extend(compress_to_vec(&b"two"[..], CompressionLevel::Fastest));
        assert_eq!(decompress(path, bytes.clone(), 100).unwrap(), b"one two");
        assert!(matches!(decompress(path, bytes.clone(), 5), Err(LoadError::TooLarge { .. })));
        bytes.truncate(bytes.len() - 3);
        assert!(matches!(decompress(path, bytes, 100), Err(LoadError::Decompress { .. })));
    }

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
        for (name, is_allowed) in [
            ("own", true),
            ("inside", true),
            ("lost", true),
            ("file", false),
            ("folder/secret", false),
        ] {
            assert_eq!(confined(folder.path(), name).is_some(), is_allowed, "{name}");
        }
    }

    #[test]
    fn names_lose_their_endings() {
        assert_eq!(scene_name(Path::new("a/balls.nff.gz")), "balls");
        assert_eq!(scene_name(Path::new("kitchen.obj.zst")), "kitchen");
        assert_eq!(scene_name(Path::new("my.scene.obj")), "my.scene");
    }
}
