//! How busy the machine was while something was measured.
//!
//! Source: Linux's pressure stall information, Documentation/accounting/psi.rst: the line `some` of
//! /proc/pressure/cpu has the microseconds in which some thread waited for a processor.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::Instant;

pub const CPU: &str = "/proc/pressure/cpu";

/// A look at the pressure that goes on.
#[derive(Debug)]
pub struct PressureWatch {
    begin: Option<(PathBuf, u64)>,
    /// The pressure is in real time, whatever clock is injected.
    since: Instant,
}

impl PressureWatch {
    /// From now on, by that file; nothing where there is none.
    pub fn begin(path: Option<&Path>) -> Self {
        let begin = path.and_then(|path| Some((path.to_owned(), waited_us(path)?)));
        Self { begin, since: Instant::now() }
    }

    /// The share of the time since, from 0 to 1, in which some thread waited for a processor; none
    /// where the system does not report it.
    pub fn share(&self) -> Option<f64> {
        let (path, before) = self.begin.as_ref()?;
        let waited = waited_us(path)?.saturating_sub(*before);
        let elapsed = self.since.elapsed().as_secs_f64().max(1e-6);
        Some((waited as f64 / 1e6 / elapsed).min(1.0))
    }
}

fn waited_us(path: &Path) -> Option<u64> {
    let text = fs::read_to_string(path).ok()?;
    let line = text.lines().find(|line| line.starts_with("some "))?;
    line.split_whitespace().find_map(|word| word.strip_prefix("total="))?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pressure_is_the_share_since_the_start() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cpu");
        let write = |total: u64| {
            let line = format!("some avg10=0.00 avg60=0.00 avg300=0.00 total={total}\nfull x\n");
            fs::write(&path, line).unwrap();
        };
        write(1000);
        let watch = PressureWatch::begin(Some(&path));
        assert_eq!(watch.share(), Some(0.0));
        // an hour of waiting is more than has passed
        write(3_600_001_000);
        assert_eq!(watch.share(), Some(1.0));
        fs::write(&path, "nonsense").unwrap();
        assert_eq!(watch.share(), None);
        assert_eq!(PressureWatch::begin(None).share(), None);
    }
}
