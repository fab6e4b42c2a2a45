//! What the results were measured on and with, how long its threads waited for a processor, and how
//! much memory a structure may take.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::time::Instant;

use accel_core::memory::MemoryLimit;
use accel_core::query::batch::has_avx512;

use crate::record::{Load, Machine, Ticks};
use crate::system::memory;

/// SHA-256 of the program's file, where it can be read.
pub fn program_sha256() -> Option<String> {
    static HASH: OnceLock<Option<String>> = OnceLock::new();
    let hash = || {
        let program = fs::read(std::env::current_exe().ok()?).ok()?;
        Some(scene_loading::source_hash::sha256_of_bytes(&program))
    };
    HASH.get_or_init(hash).clone()
}

/// Threads the process may use.
pub fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

/// The machine, as far as /proc tells.
pub fn machine() -> Machine {
    let read = |path| fs::read_to_string(path).unwrap_or_default();
    let release = read("/etc/os-release");
    let distribution = value(&release, "PRETTY_NAME", '=').map(|v| v.trim_matches('"').to_owned());
    let kernel = read("/proc/sys/kernel/osrelease");
    let os = [Some(std::env::consts::OS.to_owned()), Some(kernel), distribution];
    let os: Vec<_> = os.iter().flatten().map(|s| s.trim()).filter(|s| !s.is_empty()).collect();
    Machine {
        cpu: value(&read("/proc/cpuinfo"), "model name", ':'),
        threads: threads(),
        memory_bytes: kibibytes(&read("/proc/meminfo"), "MemTotal"),
        os: os.join(", "),
        governor: line("/sys/devices/system/cpu/cpu0/cpufreq/scaling_governor"),
        boost: boost(Path::new("/")),
        batches_by_avx512: Some(has_avx512()),
        huge_pages: memory::huge_pages_in(&read("/sys/kernel/mm/transparent_hugepage/enabled")),
    }
}

/// Returns whether the clock may rise above its nominal rate: a file of its own, or Intel's, which
/// says the opposite.
pub fn boost(root: &Path) -> Option<bool> {
    let of = |path: &str, on: &str| line(root.join(path)).map(|state| state == on);
    of("sys/devices/system/cpu/cpufreq/boost", "1")
        .or_else(|| of("sys/devices/system/cpu/intel_pstate/no_turbo", "0"))
}

/// The text of a small file; none where the file is not there or is empty.
pub fn line(path: impl AsRef<Path>) -> Option<String> {
    let text = fs::read_to_string(path).ok()?;
    Some(text.trim().to_owned()).filter(|line| !line.is_empty())
}

pub fn load() -> Load {
    let read = |path| fs::read_to_string(path).unwrap_or_default();
    Load {
        average: read("/proc/loadavg").split_whitespace().next().and_then(|x| x.parse().ok()),
        ticks: ticks(&read("/proc/stat"), &read("/proc/self/stat")),
        pages_swapped_in: value(&read("/proc/vmstat"), "pswpin", ' ').and_then(|n| n.parse().ok()),
        swapped_bytes: kibibytes(&read("/proc/self/status"), "VmSwap"),
    }
}

/// Processor time from the texts of /proc/stat and /proc/self/stat (proc(5)).
fn ticks(all: &str, own: &str) -> Option<Ticks> {
    let numbers = |text: &str| -> Vec<u64> {
        text.split_whitespace().map_while(|n| n.parse().ok()).collect()
    };
    // user, nice, system, idle, iowait, irq, softirq, steal; guests are in user and nice already
    let times = numbers(all.lines().find_map(|line| line.strip_prefix("cpu "))?);
    let (idle, waiting) = (times.get(3)?, times.get(4)?);
    let all_ticks: u64 = times.iter().take(8).sum();
    let is_processor = |line: &&str| {
        let number = line.strip_prefix("cpu").and_then(|rest| rest.split(' ').next());
        number.is_some_and(|n| n.parse::<u32>().is_ok())
    };
    // the program's name, in parentheses, may hold anything; user and system time are the 12th and
    // 13th field behind it, those of children that have ended the 14th and 15th
    let (_, own) = own.rsplit_once(')')?;
    let mut own = own.split_whitespace().skip(11);
    let mut next = || own.next()?.parse::<u64>().ok();
    Some(Ticks {
        processors: all.lines().filter(is_processor).count() as u64,
        all: all_ticks,
        busy: all_ticks - idle - waiting,
        own: next()? + next()? + next()? + next()?,
    })
}

/// Largest resident set of the process since its start or [`reset_peak_rss`], bytes.
pub fn peak_rss() -> Option<u64> {
    kibibytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM")
}

/// Resident set of a process now, by its number or `self`, bytes.
pub fn resident(process: &str) -> Option<u64> {
    kibibytes(&fs::read_to_string(format!("/proc/{process}/status")).ok()?, "VmRSS")
}

/// Begins a new peak where the system lets us, and says whether it did; else the peak goes on from
/// the start.
pub fn reset_peak_rss() -> bool {
    fs::write("/proc/self/clear_refs", "5").is_ok()
}

/// The text after `key` and the separator on the first line that begins with them.
pub fn value(text: &str, key: &str, separator: char) -> Option<String> {
    let mut lines = text.lines().filter_map(|line| line.split_once(separator));
    let (_, value) = lines.find(|(k, _)| k.trim() == key)?;
    Some(value.trim().to_owned())
}

/// The bytes of a line in kB of a file of /proc.
pub fn kibibytes(text: &str, key: &str) -> Option<u64> {
    let value = value(text, key, ':')?;
    value.strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

pub const CPU_PRESSURE: &str = "/proc/pressure/cpu";

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

/// The limit for `asked` bytes. Where nothing is asked, half of what the process may have, which is
/// the machine's memory or its control group's limit, whichever is less (cgroups(7)).
pub fn memory_limit(asked: Option<u64>) -> MemoryLimit {
    let default = || available(Path::new("/")).map(|bytes| bytes / 2);
    asked.or_else(default).map_or(MemoryLimit::NONE, MemoryLimit::new)
}

/// Memory available to the process; `None` without a limit.
fn available(root: &Path) -> Option<u64> {
    let read = |path: &str| fs::read_to_string(root.join(path)).ok();
    let machine = read("proc/meminfo").and_then(|text| kibibytes(&text, "MemTotal"));
    let groups = read("proc/self/cgroup").unwrap_or_default();
    let of_groups = groups.lines().filter_map(|line| of_group(root, line));
    machine.into_iter().chain(of_groups).min()
}

/// The limit of a line `number:controllers:path` of /proc/self/cgroup, and of the groups around
/// that one.
fn of_group(root: &Path, line: &str) -> Option<u64> {
    let mut parts = line.splitn(3, ':').skip(1);
    let (controllers, path) = (parts.next()?, parts.next()?);
    let (mount, file) = match controllers {
        "" => ("sys/fs/cgroup", "memory.max"),
        _ if controllers.split(',').any(|c| c == "memory") => {
            ("sys/fs/cgroup/memory", "memory.limit_in_bytes")
        }
        _ => return None,
    };
    let group = Path::new(path.trim_start_matches('/'));
    // within a container the own group may be mounted as the outermost one
    let limits = group.ancestors().filter_map(|group| {
        let text = fs::read_to_string(root.join(mount).join(group).join(file)).ok()?;
        // `max` is no number: no limit
        text.trim().parse::<u64>().ok()
    });
    limits.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_of_proc_files() {
        let text = "model name\t: A CPU: fast\nVmHWM:\t    2 kB\nBad: x kB\n";
        assert_eq!(value(text, "model name", ':').as_deref(), Some("A CPU: fast"));
        assert_eq!(kibibytes(text, "VmHWM"), Some(2048));
        assert_eq!((kibibytes(text, "Bad"), kibibytes(text, "None")), (None, None));
    }

    #[test]
    fn processor_time_of_proc_files() {
        let all = "cpu  40 2 10 100 5 0 1 3 7 0\ncpu0 20 1 5 50 2 0 1 3 7 0\ncpu1 20 1 5 50 3 0 0 0\n\
                   intr 5\n";
        let own = "7 (a ) name) R 1 1 1 0 -1 4 101 0 0 0 21 4 9 9 20 0\n";
        let expected = Ticks { processors: 2, all: 161, busy: 56, own: 43 };
        assert_eq!(ticks(all, own), Some(expected));
        assert_eq!(ticks("", own), None);
        assert_eq!(ticks(all, "7 (name) R 1"), None);
    }

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

    #[test]
    fn the_least_of_machine_and_groups_counts() {
        let folder = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        };
        let found = || available(folder.path());
        assert_eq!(found(), None);
        write("proc/meminfo", "MemTotal:  1000 kB\nMemFree: 5 kB\n");
        assert_eq!(found(), Some(1_024_000));
        write("proc/self/cgroup", "0::/user/own\n");
        write("sys/fs/cgroup/user/own/memory.max", "max\n");
        assert_eq!(found(), Some(1_024_000));
        write("sys/fs/cgroup/user/memory.max", "70000\n");
        assert_eq!(found(), Some(70_000));
        // version 1
        write("proc/self/cgroup", "5:cpu,memory:/job\n3:pids:/\n");
        write("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "9223372036854771712\n");
        assert_eq!(found(), Some(1_024_000));
        write("sys/fs/cgroup/memory/job/memory.limit_in_bytes", "30000\n");
        assert_eq!(found(), Some(30_000));
    }

    #[test]
    fn requested_limits_override_the_default() {
        assert_eq!(memory_limit(Some(5)), MemoryLimit::new(5));
        assert_ne!(memory_limit(None), MemoryLimit::new(5));
    }
}
