//! Files that are written whole, or not at all; folders for what cannot be kept where it belongs.
//!
//! A command creates its files and folders before its work is done, so that an unwritable path or a
//! full disk is found at once; what is still empty when the command ends, because it was refused or
//! failed, is taken back.

use std::collections::BTreeMap;
use std::fs::{self, DirBuilder, File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use crate::system::interrupt::undisturbed;

/// Files and folders that were not there before. Dropped, it removes those that are still empty;
/// what was there, empty or not, stays as it was.
#[derive(Debug, Default)]
pub struct CreatedFiles {
    files: Vec<PathBuf>,
    folders: Vec<PathBuf>,
}

impl CreatedFiles {
    /// Opens a file for writing, and creates it where there is none. Its content stays.
    pub fn file(&mut self, path: &Path) -> Result<File, WriteError> {
        let error = |source| WriteError { path: path.to_owned(), source };
        let was_there = path.exists();
        let mut options = OpenOptions::new();
        let file = options.create(true).write(true).truncate(false).open(path).map_err(error)?;
        if !was_there {
            // what a link points to, and whatever the working directory is by then
            self.files.push(fs::canonicalize(path).map_err(error)?);
        }
        Ok(file)
    }

    /// Creates a folder and those that it lies in, where there are none.
    pub fn folder(&mut self, path: &Path) -> Result<(), WriteError> {
        let missing: Vec<&Path> =
            path.ancestors().take_while(|p| !p.as_os_str().is_empty() && !p.exists()).collect();
        let made = fs::create_dir_all(path);
        // those that were made before one failed, too
        let made_now = missing.into_iter().rev().filter_map(|p| fs::canonicalize(p).ok());
        self.folders.extend(made_now);
        made.map_err(|source| WriteError { path: path.to_owned(), source })
    }

    /// Nothing is taken back: what is empty is meant to be.
    pub fn keep(&mut self) {
        self.files.clear();
        self.folders.clear();
    }
}

impl Drop for CreatedFiles {
    fn drop(&mut self) {
        for file in &self.files {
            if fs::metadata(file).is_ok_and(|m| m.is_file() && m.len() == 0) {
                let _ = fs::remove_file(file);
            }
        }
        for folder in self.folders.iter().rev() {
            // refused where something is in it
            let _ = fs::remove_dir(folder);
        }
    }
}

#[derive(Debug, thiserror::Error)]
#[error("cannot write {}: {source}", path.display())]
pub struct WriteError {
    pub path: PathBuf,
    pub source: io::Error,
}

/// Writes a finished file in one step, or a pipe or a device.
pub fn write_text(path: &Path, text: &str) -> Result<(), WriteError> {
    let mut created = CreatedFiles::default();
    let stream = open(path, &mut created)?;
    let written = undisturbed(|| match stream {
        None => replace(path, text.as_bytes()),
        Some(mut stream) => stream.write_all(text.as_bytes()),
    });
    written.map_err(|source| WriteError { path: path.to_owned(), source })?;
    created.keep();
    Ok(())
}

/// Creates the file; what is no file, but a pipe or a device, stays open.
pub fn open(path: &Path, created: &mut CreatedFiles) -> Result<Option<File>, WriteError> {
    let file = created.file(path)?;
    let error = |source| WriteError { path: path.to_owned(), source };
    let is_file = file.metadata().map_err(error)?.is_file();
    Ok((!is_file).then_some(file))
}

/// Replaces a file's content in one step, so that a killed run, or a full disk, never leaves half a
/// file; in place only where the folder does not take new files.
pub fn replace(path: &Path, content: &[u8]) -> io::Result<()> {
    // Links are followed: what they point to is replaced, not the link.
    put(&fs::canonicalize(path)?, content)
}

/// Writes a file's whole content in one step, whether it was there or not.
pub fn put(path: &Path, content: &[u8]) -> io::Result<()> {
    remove_left(path);
    let mut name = path.file_name().unwrap_or_default().to_owned();
    name.push(format!(".{}{TEMPORARY}", std::process::id()));
    let temporary = path.with_file_name(name);
    let _ = fs::remove_file(&temporary);
    let mut file = match OpenOptions::new().write(true).create_new(true).open(&temporary) {
        Ok(file) => file,
        Err(e) if e.kind() == io::ErrorKind::PermissionDenied => return fs::write(path, content),
        Err(e) => return Err(e),
    };
    // so that nobody takes it for one that was left; a file system without locks has the process
    let _ = file.try_lock();
    let replaced = file.write_all(content).and_then(|()| fs::rename(&temporary, path));
    if replaced.is_err() {
        let _ = fs::remove_file(&temporary);
    }
    replaced
}

/// How the names of files end that are not yet in their place: `results.json.<process>.tmp`.
const TEMPORARY: &str = ".tmp";

/// Files in a folder that may have been left by processes that were killed: path and process.
type LeftoverFiles = Vec<(PathBuf, u32)>;

/// What a process found in the folders that it writes to, each looked through once.
static FOUND: Mutex<BTreeMap<PathBuf, LeftoverFiles>> = Mutex::new(BTreeMap::new());

/// Removes what killed processes left when they wrote this file.
fn remove_left(path: &Path) {
    let (Some(folder), Some(name)) = (path.parent(), path.file_name()) else { return };
    let mut found = FOUND.lock().unwrap_or_else(PoisonError::into_inner);
    let left = found.entry(folder.to_owned()).or_insert_with(|| left_in(folder));
    left.retain(|(temporary, process)| {
        // what is left of the name without the process and its end
        let of = temporary.with_extension("").with_extension("");
        if of.file_name() != Some(name) || is_running(*process) || is_locked(temporary) {
            return true;
        }
        let _ = fs::remove_file(temporary);
        false
    });
}

fn left_in(folder: &Path) -> LeftoverFiles {
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let left = entries.filter_map(|entry| {
        let name = entry.file_name();
        let (_, process) = name.to_str()?.strip_suffix(TEMPORARY)?.rsplit_once('.')?;
        let process = process.parse().ok().filter(|p| *p != std::process::id())?;
        entry.file_type().ok()?.is_file().then(|| (entry.path(), process))
    });
    left.collect()
}

/// Returns whether there is a process of that number, where the system says so.
fn is_running(process: u32) -> bool {
    Path::new("/proc").join(process.to_string()).exists()
}

/// Returns whether a process writes to the file.
fn is_locked(path: &Path) -> bool {
    let open = OpenOptions::new().write(true).open(path);
    open.is_ok_and(|file| matches!(file.try_lock(), Err(fs::TryLockError::WouldBlock)))
}

/// Makes a folder that was not there, which others cannot read or write.
pub fn create(within: &Path) -> io::Result<PathBuf> {
    let mut builder = DirBuilder::new();
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    let mut number = 0;
    loop {
        let path = within.join(format!("rtbench-kept-{}-{number}", std::process::id()));
        match builder.create(&path) {
            Ok(()) => return Ok(path),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists && number < 1000 => number += 1,
            Err(e) => return Err(e),
        }
    }
}

/// From here on a write beyond the limit is an error.
#[cfg(unix)]
pub fn refuse_writes_beyond() -> std::io::Result<()> {
    let was_reached = std::sync::Arc::default();
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, was_reached).map(|_| ())
}

/// Elsewhere than on Unix there is none.
#[cfg(not(unix))]
pub fn refuse_writes_beyond() -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn only_new_and_empty_files_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("old"), "text").unwrap();
        fs::write(at("old and empty"), "").unwrap();
        fs::create_dir(at("old folder")).unwrap();
        let mut created = CreatedFiles::default();
        for name in ["old", "old and empty", "new"] {
            created.file(&at(name)).unwrap();
        }
        created.file(&at("filled")).unwrap().write_all(b"text").unwrap();
        for name in ["old folder", "new folder/inner", "filled folder/inner"] {
            created.folder(&at(name)).unwrap();
        }
        fs::write(at("filled folder/file"), "text").unwrap();
        assert!(at("new").exists() && at("new folder/inner").exists());
        drop(created);
        for name in ["old", "old and empty", "old folder", "filled", "filled folder/file"] {
            assert!(at(name).exists(), "{name}");
        }
        for name in ["new", "new folder", "filled folder/inner"] {
            assert!(!at(name).exists(), "{name}");
        }
        assert_eq!(fs::read_to_string(at("old")).unwrap(), "text");
    }

    #[test]
    fn folders_created_before_a_failure_are_removed() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "text").unwrap();
        let mut created = CreatedFiles::default();
        assert!(created.folder(&folder.path().join("file/inner")).is_err());
        assert!(created.file(&folder.path().join("none/file")).is_err());
        drop(created);
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    /// No process has that number: Linux counts to 4194304.
    const DEAD: u32 = 4_200_000;

    #[test]
    fn temporary_files_of_dead_processes_are_removed_and_no_others() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let kept = [
            format!("other.json.{DEAD}.tmp"),
            "results.json.1.tmp".into(),
            "results.json.mine.tmp".into(),
            format!("results.json.{DEAD}.txt"),
            format!("results.json.{}.tmp", DEAD + 1),
        ];
        for name in kept.iter().chain([&format!("results.json.{DEAD}.tmp")]) {
            fs::write(at(name), "half").unwrap();
        }
        let held = File::open(at(&kept[4])).unwrap();
        held.try_lock().unwrap();
        put(&at("results.json"), b"whole").unwrap();
        assert!(!at(&format!("results.json.{DEAD}.tmp")).exists());
        assert!(kept.iter().all(|name| at(name).exists()));
        assert_eq!(fs::read_to_string(at("results.json")).unwrap(), "whole");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), kept.len() + 1);
        drop(held);
        put(&at("results.json"), b"again").unwrap();
        assert!(!at(&kept[4]).exists());
    }

    #[cfg(unix)]
    #[test]
    fn a_planted_link_is_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let (path, mine) = (folder.path().join("a.json"), folder.path().join("mine"));
        fs::write(&mine, "mine").unwrap();
        let planted = folder.path().join(format!("a.json.{}.tmp", std::process::id()));
        std::os::unix::fs::symlink(&mine, planted).unwrap();
        put(&path, b"text").unwrap();
        assert_eq!(fs::read_to_string(&mine).unwrap(), "mine");
    }
}
