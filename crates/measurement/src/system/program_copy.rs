//! A copy of a program's file, to be run beside it: the same code, elsewhere in memory and on disk.
//!
//! On Linux the copy has no name any more as soon as it is made: it is run through the descriptor
//! that this process has of it, and whatever ends the process leaves no file behind.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// The file could not be copied.
#[derive(Debug, thiserror::Error)]
#[error("cannot copy {} into {}: {source}", program.display(), folder.display())]
pub struct CopyError {
    program: PathBuf,
    folder: PathBuf,
    source: io::Error,
}

/// The copy; it is removed with this.
#[derive(Debug)]
pub struct ProgramCopy {
    /// None where the copy has no name.
    _folder: Option<TempDir>,
    _open: Option<File>,
    path: PathBuf,
}

impl ProgramCopy {
    /// Copies the program, with its permissions, into a folder of its own within `temporary`.
    pub fn of(program: &Path, temporary: &Path) -> Result<Self, CopyError> {
        let made = || {
            let folder = tempfile::Builder::new().prefix("rtbench-copy-").tempdir_in(temporary)?;
            let name = program.file_name().unwrap_or("rtbench".as_ref());
            let path = folder.path().join(name);
            std::fs::copy(program, &path)?;
            let open = File::open(&path)?;
            Ok(match nameless(&open) {
                Some(path) => Self { _folder: None, _open: Some(open), path },
                None => Self { _folder: Some(folder), _open: None, path },
            })
        };
        let (program, folder) = (program.to_owned(), temporary.to_owned());
        made().map_err(|source| CopyError { program, folder, source })
    }

    pub fn path(&self) -> &Path {
        &self.path
    }
}

/// A path of an open file that stays when its name is removed; none where the system has no such
/// paths.
#[cfg(target_os = "linux")]
fn nameless(open: &File) -> Option<PathBuf> {
    use std::os::fd::AsRawFd;
    let path = PathBuf::from(format!("/proc/{}/fd/{}", std::process::id(), open.as_raw_fd()));
    path.exists().then_some(path)
}

#[cfg(not(target_os = "linux"))]
fn nameless(_: &File) -> Option<PathBuf> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_program_copy_is_identical_and_removed_afterwards() {
        let folder = tempfile::tempdir().unwrap();
        let program = folder.path().join("program");
        std::fs::write(&program, "code").unwrap();
        let copy = ProgramCopy::of(&program, folder.path()).unwrap();
        assert_eq!(std::fs::read(copy.path()).unwrap(), b"code");
        assert_ne!(copy.path(), program);
        let names = || std::fs::read_dir(folder.path()).unwrap().count();
        // nothing is left if this is killed
        assert!(names() == 1 || cfg!(not(target_os = "linux")));
        drop(copy);
        assert_eq!(names(), 1);
        let error = ProgramCopy::of(&folder.path().join("none"), folder.path()).unwrap_err();
        assert!(error.to_string().starts_with("cannot copy "), "{error}");
    }
}
