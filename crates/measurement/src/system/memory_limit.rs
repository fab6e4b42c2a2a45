//! How much memory a structure may take where nothing is said: half of what the process may have,
//! which is the machine's memory or its control group's limit, whichever is less (cgroups(7)).

use std::fs;
use std::path::Path;

use accel_core::memory::MemoryLimit;

use crate::system::machine::kibibytes;

/// The limit for `asked` bytes, or the default.
pub fn of(asked: Option<u64>) -> MemoryLimit {
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
        assert_eq!(of(Some(5)), MemoryLimit::new(5));
        assert_ne!(of(None), MemoryLimit::new(5));
    }
}
