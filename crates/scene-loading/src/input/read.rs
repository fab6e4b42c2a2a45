//! Reading the bytes of a scene file: size caps, paths that stay in a folder.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::LoadError;
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
}
