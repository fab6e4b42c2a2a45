//! What the system's files say of things that disturb measurements (Linux: `/proc` and `/sys`).
//! Where a file is not there, the finding is `unknown`; nothing is guessed.

use std::fs;
use std::path::PathBuf;

use crate::doctor::finding::{Finding, Level};
use measurement::system::instruction_set;
use measurement::system::machine::{kibibytes, value};
use measurement::system::world::World;

/// A file system root to look at: `/`, or a test's own.
#[derive(Debug, Clone)]
pub struct System {
    /// The root.
    pub root: PathBuf,
    /// Threads that the process may use.
    pub threads: usize,
    /// What the processor has and the program was compiled without.
    pub unused: Vec<&'static str>,
}

/// Where the governors of clock frequencies are.
const CPUS: &str = "sys/devices/system/cpu";

impl System {
    /// The machine of a world.
    pub fn of(world: &dyn World) -> Self {
        let compiled = world.compiler().target_features;
        let unused = instruction_set::unused(&world.processor_features(), &compiled);
        Self { root: world.system_root(), threads: world.machine().threads, unused }
    }

    /// One finding for each thing looked at.
    pub fn findings(&self) -> Vec<Finding> {
        vec![
            self.governor(),
            self.boost(),
            self.load(),
            self.cores(),
            self.siblings(),
            self.memory(),
            self.swap(),
            self.virtual_machine(),
            self.stolen(),
            self.instruction_set(),
        ]
    }

    fn read(&self, path: &str) -> Option<String> {
        let text = fs::read_to_string(self.root.join(path)).ok()?;
        Some(text.trim().to_owned()).filter(|text| !text.is_empty())
    }

    fn governor(&self) -> Finding {
        let mut governors: Vec<String> = (0..4096)
            .map_while(|cpu| self.read(&format!("{CPUS}/cpu{cpu}/cpufreq/scaling_governor")))
            .collect();
        governors.sort();
        governors.dedup();
        let level = match governors.as_slice() {
            [] => Level::Unknown,
            all if all.iter().all(|g| g == "performance") => Level::Good,
            _ => Level::Warning,
        };
        Finding {
            name: "governor",
            level,
            value: found((!governors.is_empty()).then(|| governors.join(", "))),
            meaning: "any governor but `performance` changes the clock frequency with the load: \
                      the first rounds are slower than the rest",
            advice: advice(level, "sudo cpupower frequency-set -g performance"),
        }
    }

    fn boost(&self) -> Finding {
        let no_turbo = self.read(&format!("{CPUS}/intel_pstate/no_turbo"));
        let boost = self.read(&format!("{CPUS}/cpufreq/boost"));
        let is_on = no_turbo.map(|v| v == "0").or(boost.map(|v| v == "1"));
        let level = of(is_on.map(|on| !on));
        Finding {
            name: "boost",
            level,
            value: found(is_on.map(|on| if on { "on" } else { "off" }.to_owned())),
            meaning: "with boost the clock frequency depends on heat and on the other cores; \
                      ratios of the same round suffer least",
            advice: advice(
                level,
                "echo 0 | sudo tee /sys/devices/system/cpu/cpufreq/boost (Intel: \
                 echo 1 | sudo tee /sys/devices/system/cpu/intel_pstate/no_turbo)",
            ),
        }
    }

    fn load(&self) -> Finding {
        let text = self.read("proc/loadavg");
        let load: Option<f64> = text.and_then(|t| t.split_whitespace().next()?.parse().ok());
        // one core for the measurement, the others may work
        let free = self.threads as f64 - load.unwrap_or(0.0);
        let level = of(load.map(|load| load < 0.5 || free >= 1.5));
        Finding {
            name: "load",
            level,
            value: found(
                load.map(|load| format!("{load:.2} of {} cores, over a minute", self.threads)),
            ),
            meaning: "programs that wait for a core interrupt the measurement and share its caches",
            advice: advice(level, "end other programs, or wait until they are done"),
        }
    }

    fn cores(&self) -> Finding {
        let level = of(Some(self.threads >= 2));
        let quota = self.read("sys/fs/cgroup/cpu.max");
        let limit = quota.filter(|q| !q.starts_with("max"));
        let limited = match &limit {
            Some(quota) => format!(", limited to {quota} (microseconds of a period)"),
            None => String::new(),
        };
        let level = if limit.is_some() { Level::Warning } else { level };
        Finding {
            name: "cores",
            level,
            value: format!("{} usable{limited}", self.threads),
            meaning: "on a single core, or with a quota, every other program and every thread of \
                      our own stops the measurement",
            advice: advice(level, "use a machine with two cores or more and no quota"),
        }
    }

    fn siblings(&self) -> Finding {
        let active = self.read(&format!("{CPUS}/smt/active")).map(|v| v == "1");
        let level = of(active.map(|active| !active));
        Finding {
            name: "SMT",
            level,
            value: found(active.map(|on| if on { "on" } else { "off" }.to_owned())),
            meaning: "two threads share a core: what runs on the other one halves the speed",
            advice: advice(
                level,
                "keep the other threads idle, or echo off | sudo tee \
                 /sys/devices/system/cpu/smt/control",
            ),
        }
    }

    fn memory(&self) -> Finding {
        let text = self.read("proc/meminfo").unwrap_or_default();
        let [total, free] = ["MemTotal", "MemAvailable"].map(|key| kibibytes(&text, key));
        // the standard scenes need 200 MiB, those of packages 1 GiB
        let level = of(free.map(|free| free >= 1 << 30));
        let said = total
            .zip(free)
            .map(|(total, free)| format!("{} MiB free of {} MiB", free >> 20, total >> 20));
        Finding {
            name: "memory",
            level,
            value: found(said),
            meaning: "less than 1 GiB is not enough for the large scenes: the system would swap, or \
                      kill the run",
            advice: advice(level, "end other programs, or measure the standard scenes only"),
        }
    }

    fn swap(&self) -> Finding {
        let text = self.read("proc/meminfo").unwrap_or_default();
        let total = kibibytes(&text, "SwapTotal");
        let used =
            total.zip(kibibytes(&text, "SwapFree")).map(|(total, free)| total.saturating_sub(free));
        let level = of(used.map(|used| used < 64 << 20));
        Finding {
            name: "swap",
            level,
            value: found(used.map(|used| format!("{} MiB used", used >> 20))),
            meaning: "memory was short: pages that come back from disk are timed as if they were \
                      work",
            advice: advice(level, "free memory, then sudo swapoff -a && sudo swapon -a"),
        }
    }

    fn virtual_machine(&self) -> Finding {
        let info = self.read("proc/cpuinfo");
        let flags = info.as_deref().and_then(|text| value(text, "flags", ':'));
        let is_virtual = flags.map(|flags| flags.split(' ').any(|flag| flag == "hypervisor"));
        let level = of(is_virtual.map(|is| !is));
        let product = self.read("sys/class/dmi/id/product_name");
        let name = product.map(|name| format!(" ({name})")).unwrap_or_default();
        Finding {
            name: "virtual machine",
            level,
            value: found(is_virtual.map(|is| if is { format!("yes{name}") } else { "no".into() })),
            meaning: "neighbours that are not seen from here share cores, caches and memory",
            advice: advice(
                level,
                "compare ratios of the same run and counters, never seconds of two runs",
            ),
        }
    }

    fn instruction_set(&self) -> Finding {
        let level = of(Some(self.unused.is_empty()));
        Finding {
            name: "instructions",
            level,
            value: match self.unused[..] {
                [] => "those of the processor".to_owned(),
                _ => {
                    format!("compiled without {}, which the processor has", self.unused.join(", "))
                }
            },
            meaning: "the program is slower than it could be, some structures more than others",
            advice: advice(level, instruction_set::ADVICE),
        }
    }

    fn stolen(&self) -> Finding {
        let text = self.read("proc/stat").unwrap_or_default();
        let cpu = text.lines().find_map(|line| line.strip_prefix("cpu "));
        let times: Vec<u64> = cpu
            .map(|t| t.split_whitespace().filter_map(|n| n.parse().ok()).collect())
            .unwrap_or_default();
        let share = times.get(7).map(|&stolen| {
            // user, nice, system, idle, iowait, irq, softirq, steal; what follows is in user
            let all: u64 = times.iter().take(8).sum();
            stolen as f64 / all.max(1) as f64
        });
        let level = of(share.map(|share| share < 0.005));
        Finding {
            name: "stolen time",
            level,
            value: found(share.map(|share| format!("{:.2}% since the start", 100.0 * share))),
            meaning: "the host let other machines run while this one wanted to",
            advice: advice(level, "use a machine of your own, or measure at another hour"),
        }
    }
}

fn found(value: Option<String>) -> String {
    value.unwrap_or_else(|| "the system does not say".to_owned())
}

/// Good, bad or not known.
fn of(is_good: Option<bool>) -> Level {
    match is_good {
        Some(true) => Level::Good,
        Some(false) => Level::Warning,
        None => Level::Unknown,
    }
}

fn advice(level: Level, what: &'static str) -> Option<&'static str> {
    (level == Level::Warning).then_some(what)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A root with these files.
    fn system(files: &[(&str, &str)]) -> (tempfile::TempDir, System) {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = folder.path().join(path);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        let system = System { root: folder.path().to_owned(), threads: 4, unused: Vec::new() };
        (folder, system)
    }

    fn levels(files: &[(&str, &str)]) -> Vec<(&'static str, Level)> {
        system(files).1.findings().iter().map(|f| (f.name, f.level)).collect()
    }

    const GOVERNOR: &str = "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor";

    #[test]
    fn a_machine_that_says_nothing_is_unknown() {
        for (name, level) in levels(&[]) {
            let is_known = ["cores", "instructions"].contains(&name);
            let expected = if is_known { Level::Good } else { Level::Unknown };
            assert_eq!(level, expected, "{name}");
        }
    }

    #[test]
    fn a_quiet_machine_is_good_and_a_busy_one_is_warned_of_with_advice() {
        let quiet = [
            (GOVERNOR, "performance\n"),
            ("sys/devices/system/cpu/cpufreq/boost", "0\n"),
            ("sys/devices/system/cpu/smt/active", "0\n"),
            ("proc/loadavg", "0.10 0.2 0.3 1/100 7\n"),
            (
                "proc/meminfo",
                "MemTotal: 8000000 kB\nMemAvailable: 7000000 kB\nSwapTotal: 0 kB\nSwapFree: 0 kB\n",
            ),
            ("proc/cpuinfo", "model name\t: X\nflags\t\t: fpu sse\n"),
            ("proc/stat", "cpu  100 0 100 1000 0 0 0 0 0 0\n"),
            ("sys/fs/cgroup/cpu.max", "max 100000\n"),
        ];
        assert!(
            levels(&quiet).iter().all(|(_, level)| *level == Level::Good),
            "{:?}",
            levels(&quiet)
        );
        let busy = [
            (GOVERNOR, "powersave\n"),
            ("sys/devices/system/cpu/intel_pstate/no_turbo", "0\n"),
            ("sys/devices/system/cpu/smt/active", "1\n"),
            ("proc/loadavg", "3.90 2 1 1/100 7\n"),
            (
                "proc/meminfo",
                "MemTotal: 8000000 kB\nMemAvailable: 70000 kB\nSwapTotal: 900000 kB\nSwapFree: 9 kB\n",
            ),
            ("proc/cpuinfo", "flags\t\t: fpu hypervisor sse\n"),
            ("proc/stat", "cpu  100 0 100 1000 0 0 0 100 0 0\n"),
            ("sys/fs/cgroup/cpu.max", "50000 100000\n"),
        ];
        let (_folder, system) = system(&busy);
        let system = System { unused: vec!["avx2"], ..system };
        for finding in system.findings() {
            assert_eq!(finding.level, Level::Warning, "{finding:?}");
            assert!(finding.advice.is_some() && !finding.meaning.is_empty(), "{finding:?}");
        }
    }
}
