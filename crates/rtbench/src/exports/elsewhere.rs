//! Fallback for results whose files cannot be written: a new folder among the system's temporary
//! files.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use measurement::record::{RunRecord, file};
use measurement::system::files;
use measurement::system::files::put;
use measurement::system::interrupt::undisturbed;
use presentation::json;

/// Writes the record to a new folder in `within`, and says where.
///
/// # Errors
/// The system's; nothing is left then.
pub fn keep(within: Option<&Path>, record: &RunRecord) -> io::Result<PathBuf> {
    let text = json::written(record).map_err(io::Error::other)?;
    let folder = files::create(within.ok_or(io::ErrorKind::NotFound)?)?;
    let path = folder.join(file::NAME);
    undisturbed(|| put(&path, text.as_bytes())).inspect_err(|_| {
        let _ = fs::remove_dir(&folder);
    })?;
    Ok(path)
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::record::made_up;

    #[test]
    fn rescued_records_get_separate_folders() {
        let within = tempfile::tempdir().unwrap();
        let record = made_up::run(&[]);
        let paths = [0, 1].map(|_| keep(Some(within.path()), &record).unwrap());
        assert_ne!(paths[0], paths[1]);
        assert_eq!(file::read(&paths[1]).unwrap(), record);
        assert!(keep(Some(&within.path().join("none")), &record).is_err());
    }
}
