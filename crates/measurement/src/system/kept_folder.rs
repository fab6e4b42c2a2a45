//! Folders for what cannot be kept where it belongs.

use std::fs::DirBuilder;
use std::io;
use std::path::{Path, PathBuf};

/// Makes a folder that was not there, which others cannot read or write.
///
/// # Errors
/// The system's.
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
