//! What the rays of each kind fetch from which cache: the starting half.
//!
//! Source: the manual of callgrind (see [`super`]), section on its cache simulation. It knows two
//! levels, so that a machine with three is simulated twice. A processor with vectors that valgrind does
//! not know is simulated on the path of those that it does.

use std::fs;
use std::path::Path;

use crate::callgrind::caches::AskedBatch;
use crate::callgrind::{CallgrindError, Scratch, callgrind, events_of_calls, version};
use crate::record::RunRecord;
use crate::system::child_process::{answer, arguments, without_samples};

/// A level of the data caches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CacheLevel {
    /// From 1.
    pub level: u64,
    /// Its size.
    pub bytes: u64,
    /// Lines that one place may hold.
    pub ways: u64,
    /// Bytes of a line.
    pub line: u64,
}

impl CacheLevel {
    /// As callgrind takes it, which wants a power of two of sets: that at or below the true number.
    fn option(&self) -> String {
        let sets = (self.bytes / self.ways / self.line).max(1);
        let sets = 1 << sets.ilog2();
        format!("{},{},{}", sets * self.ways * self.line, self.ways, self.line)
    }
}

/// The data caches of the first processor, as Linux tells them below `root`; at least two of them.
///
/// # Errors
/// [`CallgrindError::Caches`].
pub fn caches_below(root: &Path) -> Result<Vec<CacheLevel>, CallgrindError> {
    let folder = root.join("sys/devices/system/cpu/cpu0/cache");
    let mut found = Vec::new();
    for index in 0..8 {
        let read = |name: &str| {
            let text = fs::read_to_string(folder.join(format!("index{index}/{name}"))).ok()?;
            Some(text.trim().to_owned())
        };
        let number = |name: &str| read(name)?.parse::<u64>().ok().filter(|n| *n > 0);
        let level = || {
            Some(CacheLevel {
                level: number("level")?,
                bytes: read("size")?.strip_suffix('K')?.parse::<u64>().ok()? << 10,
                ways: number("ways_of_associativity")?,
                line: number("coherency_line_size")?,
            })
        };
        if read("type").is_some_and(|kind| kind != "Instruction") {
            found.extend(level());
        }
    }
    found.sort_by_key(|cache| cache.level);
    if found.len() < 2 {
        return Err(CallgrindError::Caches { folder, found: found.len() });
    }
    Ok(found)
}

/// What a window of a batch fetched.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fetched {
    /// Which one.
    pub batch: AskedBatch,
    /// Instructions.
    pub instructions: u64,
    /// Reads and writes of data.
    pub references: u64,
    /// Lines that each level missed, the first level first.
    pub missed: Vec<u64>,
}

/// Simulates the caches under the rows of a record, of at most so many rays of each batch.
///
/// # Errors
/// [`CallgrindError`].
pub fn simulate(
    program: Option<&Path>,
    record: &RunRecord,
    caches: &[CacheLevel],
    rays: u32,
    allow_outside: bool,
) -> Result<Vec<Fetched>, CallgrindError> {
    version()?;
    let program = program.ok_or(CallgrindError::NoProgram)?;
    let mut fetched: Vec<Fetched> = Vec::new();
    let (first, further) = match caches {
        [first, further @ ..] => (first, further),
        [] => return Ok(fetched),
    };
    for cache in further {
        let folder = Scratch::new()?;
        let mut command = callgrind(&folder);
        command
            .arg("--cache-sim=yes")
            .arg(format!("--D1={}", first.option()))
            .arg(format!("--LL={}", cache.option()))
            .arg(program)
            .args(arguments(allow_outside))
            .args(["ask-windows", "--rays"])
            .arg(rays.to_string());
        let batches: Vec<AskedBatch> = answer(&mut command, &without_samples(record))?;
        let calls = events_of_calls(&folder.0)?;
        if calls.len() != batches.len() {
            let (program, expected, found) = (program.to_owned(), batches.len(), calls.len());
            return Err(CallgrindError::Phases { program, expected, found });
        }
        let sum = |events: &super::Events, names: &[&str]| -> u64 {
            names.iter().filter_map(|name| events.get(*name)).sum()
        };
        let of_this_level = batches.into_iter().zip(&calls).map(|(batch, events)| Fetched {
            batch,
            instructions: sum(events, &["Ir"]),
            references: sum(events, &["Dr", "Dw"]),
            missed: vec![sum(events, &["D1mr", "D1mw"]), sum(events, &["DLmr", "DLmw"])],
        });
        let of_this_level: Vec<Fetched> = of_this_level.collect();
        if fetched.is_empty() {
            fetched = of_this_level;
            continue;
        }
        // the same program asks the same batches in the same order
        for (known, now) in fetched.iter_mut().zip(of_this_level) {
            known.missed.extend(now.missed.last());
        }
    }
    Ok(fetched)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planted(caches: &[(&str, &str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for (i, (level, kind, size)) in caches.iter().enumerate() {
            let folder = root.path().join(format!("sys/devices/system/cpu/cpu0/cache/index{i}"));
            fs::create_dir_all(&folder).unwrap();
            for (name, text) in [
                ("level", *level),
                ("type", *kind),
                ("size", *size),
                ("ways_of_associativity", "8"),
                ("coherency_line_size", "64"),
            ] {
                fs::write(folder.join(name), format!("{text}\n")).unwrap();
            }
        }
        root
    }

    #[test]
    fn caches_are_those_of_data() {
        let root = planted(&[
            ("1", "Data", "32K"),
            ("1", "Instruction", "64K"),
            ("3", "Unified", "32768K"),
            ("2", "Unified", "512K"),
        ]);
        let found = caches_below(root.path()).unwrap();
        let sizes: Vec<(u64, u64)> = found.iter().map(|c| (c.level, c.bytes >> 10)).collect();
        assert_eq!(sizes, [(1, 32), (2, 512), (3, 32768)]);
        assert_eq!(found[0].option(), "32768,8,64");
    }

    #[test]
    fn a_machine_that_does_not_tell_its_caches_is_an_error() {
        for caches in
            [&[][..], &[("1", "Data", "32K")], &[("1", "Data", "32K"), ("2", "Unified", "?")]]
        {
            let root = planted(caches);
            let error = caches_below(root.path()).unwrap_err().to_string();
            assert!(error.contains("cpu0/cache") && error.contains("two"), "{error}");
        }
    }

    #[test]
    fn sets_are_made_a_power_of_two() {
        let cache = CacheLevel { level: 3, bytes: 36 << 20, ways: 12, line: 64 };
        // 49152 sets become 32768
        assert_eq!(cache.option(), format!("{},12,64", 24 << 20));
    }
}
