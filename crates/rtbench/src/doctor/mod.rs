//! Checks a machine for sources of noise: one finding per line, with its meaning and advice.
//!
//! Files of `/proc` and `/sys` (Linux) say most of it. Where one is not there, the finding is
//! `unknown`; nothing is guessed.

use std::fs;
use std::path::PathBuf;

use serde::Serialize;

use crate::doctor::noise::Noise;
use measurement::system::clock::Clock;
use measurement::system::machine::{kibibytes, value};
use measurement::system::world;
use measurement::system::world::World;

pub mod noise;

/// True if a thing that was looked at disturbs measurements.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Level {
    Good,
    Warning,
    /// The system does not tell.
    Unknown,
}

/// One thing that was looked at.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Name of the inspected property.
    pub name: &'static str,
    /// True if it disturbs measurements.
    pub level: Level,
    /// Value found, in words.
    pub value: String,
    pub meaning: &'static str,
    /// Advice; only for warnings.
    pub advice: Option<&'static str>,
}

/// All findings, and the noise that was measured.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Diagnosis {
    /// Over repeated loops of the same work.
    pub noise: Noise,
    /// One for each thing looked at.
    pub findings: Vec<Finding>,
}

/// A file system root to look at: `/`, or a test's own.
#[derive(Debug, Clone)]
pub struct System {
    pub root: PathBuf,
    /// Threads that the process may use.
    pub threads: usize,
    /// Features that the processor has and the program was compiled without.
    pub unused: Vec<&'static str>,
}

/// Looks at the system and times the loop.
pub fn diagnose(system: &System, clock: &dyn Clock) -> Diagnosis {
    let noise = noise::measure(clock);
    let mut findings = system.findings();
    findings.push(NOISE.finding(Some(noise.judged())));
    Diagnosis { noise, findings }
}

/// A thing to look at: what it is called, what it means, what to do, and how it is found: whether
/// it is as it should be, and in words; nothing where the system does not report it.
struct Check {
    name: &'static str,
    meaning: &'static str,
    advice: &'static str,
    look: fn(&System) -> Option<(bool, String)>,
}

impl Check {
    fn finding(&self, found: Option<(bool, String)>) -> Finding {
        let is_bad = found.as_ref().is_some_and(|(is_good, _)| !is_good);
        Finding {
            name: self.name,
            level: match &found {
                None => Level::Unknown,
                Some(_) if is_bad => Level::Warning,
                Some(_) => Level::Good,
            },
            value: found.map_or("the system does not say".to_owned(), |(_, words)| words),
            meaning: self.meaning,
            advice: is_bad.then_some(self.advice),
        }
    }
}

/// No file tells it: it is timed.
const NOISE: Check = Check {
    name: "noise",
    meaning: "times of the same work differ by so much: differences below it are not seen in a few \
              rounds",
    advice: "end other programs, or take more rounds (--time-budget 10m) and trust ratios and \
             counters, not seconds",
    look: |_| None,
};

const CHECKS: [Check; 10] = [
    Check {
        name: "governor",
        meaning: "any governor but `performance` changes the clock frequency with the load: the \
                  first rounds are slower than the rest",
        advice: "sudo cpupower frequency-set -g performance",
        look: |system| {
            let governor = |cpu| system.cpu_file(&format!("cpu{cpu}/cpufreq/scaling_governor"));
            let mut governors: Vec<String> = (0..4096).map_while(governor).collect();
            governors.sort();
            governors.dedup();
            let all = governors.join(", ");
            (!all.is_empty()).then_some((all == "performance", all))
        },
    },
    Check {
        name: "boost",
        meaning: "with boost the clock frequency depends on heat and on the other cores; ratios of \
                  the same round suffer least",
        advice: "echo 0 | sudo tee /sys/devices/system/cpu/cpufreq/boost (Intel: echo 1 | sudo tee \
                 /sys/devices/system/cpu/intel_pstate/no_turbo)",
        look: |system| {
            let no_turbo = system.cpu_file("intel_pstate/no_turbo").map(|v| v == "0");
            let boosts = no_turbo.or(system.cpu_file("cpufreq/boost").map(|v| v == "1"))?;
            Some((!boosts, on_or_off(boosts)))
        },
    },
    Check {
        name: "load",
        meaning: "programs that wait for a core interrupt the measurement and share its caches",
        advice: "end other programs, or wait until they are done",
        look: |system| {
            let text = system.read("proc/loadavg")?;
            let load: f64 = text.split_whitespace().next()?.parse().ok()?;
            // one core for the measurement, the others may work
            let is_low = load < 0.5 || system.threads as f64 - load >= 1.5;
            Some((is_low, format!("{load:.2} of {} cores, over a minute", system.threads)))
        },
    },
    Check {
        name: "cores",
        meaning: "on a single core, or with a quota, every other program and every thread of our \
                  own stops the measurement",
        advice: "use a machine with two cores or more and no quota",
        look: |system| {
            let quota = system.read("sys/fs/cgroup/cpu.max").filter(|q| !q.starts_with("max"));
            let has_quota = quota.is_some();
            let limited = quota.map(|q| format!(", limited to {q} (microseconds of a period)"));
            let found = format!("{} usable{}", system.threads, limited.unwrap_or_default());
            Some((system.threads >= 2 && !has_quota, found))
        },
    },
    Check {
        name: "SMT",
        meaning: "two threads share a core: what runs on the other one halves the speed",
        advice: "keep the other threads idle, or echo off | sudo tee \
                 /sys/devices/system/cpu/smt/control",
        look: |system| {
            let shares = system.cpu_file("smt/active")? == "1";
            Some((!shares, on_or_off(shares)))
        },
    },
    Check {
        name: "memory",
        meaning: "less than 1 GiB is not enough for the large scenes: the system would swap, or \
                  kill the run",
        advice: "end other programs, or measure the standard scenes only",
        look: |system| {
            let [total, free] = system.memory(["MemTotal", "MemAvailable"])?;
            let found = format!("{} MiB free of {} MiB", free >> 20, total >> 20);
            // the standard scenes need 200 MiB, those of packages 1 GiB
            Some((free >= 1 << 30, found))
        },
    },
    Check {
        name: "swap",
        meaning: "memory was short: pages that come back from disk are timed as if they were work",
        advice: "free memory, then sudo swapoff -a && sudo swapon -a",
        look: |system| {
            let [total, free] = system.memory(["SwapTotal", "SwapFree"])?;
            let used = total.saturating_sub(free);
            Some((used < 64 << 20, format!("{} MiB used", used >> 20)))
        },
    },
    Check {
        name: "virtual machine",
        meaning: "neighbours that are not seen from here share cores, caches and memory",
        advice: "compare ratios of the same run and counters, never seconds of two runs",
        look: |system| {
            let info = system.read("proc/cpuinfo")?;
            let is_virtual = value(&info, "flags", ':')?.split(' ').any(|f| f == "hypervisor");
            let product = system.read("sys/class/dmi/id/product_name");
            let name = product.map(|name| format!(" ({name})")).unwrap_or_default();
            Some((!is_virtual, if is_virtual { format!("yes{name}") } else { "no".into() }))
        },
    },
    Check {
        name: "stolen time",
        meaning: "the host let other machines run while this one wanted to",
        advice: "use a machine of your own, or measure at another hour",
        look: |system| {
            let text = system.read("proc/stat")?;
            let cpu = text.lines().find_map(|line| line.strip_prefix("cpu "))?;
            let times: Vec<u64> = cpu.split_whitespace().filter_map(|n| n.parse().ok()).collect();
            // user, nice, system, idle, iowait, irq, softirq, steal; what follows is in user
            let all: u64 = times.iter().take(8).sum();
            let share = *times.get(7)? as f64 / all.max(1) as f64;
            Some((share < 0.005, format!("{:.2}% since the start", 100.0 * share)))
        },
    },
    Check {
        name: "instructions",
        meaning: "the program is slower than it could be, some structures more than others",
        advice: world::ADVICE,
        look: |system| {
            let unused = system.unused.join(", ");
            Some(if unused.is_empty() {
                (true, "those of the processor".to_owned())
            } else {
                (false, format!("compiled without {unused}, which the processor has"))
            })
        },
    },
];

impl System {
    /// The machine of a world.
    pub fn of(world: &dyn World) -> Self {
        let compiled = world.compiler().target_features;
        let unused = world::unused(&world.processor_features(), &compiled);
        Self { root: world.system_root(), threads: world.machine().threads, unused }
    }

    /// One finding for each thing looked at.
    pub fn findings(&self) -> Vec<Finding> {
        CHECKS.iter().map(|check| check.finding((check.look)(self))).collect()
    }

    fn read(&self, path: &str) -> Option<String> {
        let text = fs::read_to_string(self.root.join(path)).ok()?;
        Some(text.trim().to_owned()).filter(|text| !text.is_empty())
    }

    fn cpu_file(&self, path: &str) -> Option<String> {
        self.read(&format!("sys/devices/system/cpu/{path}"))
    }

    /// Bytes that `/proc/meminfo` has for two keys.
    fn memory(&self, keys: [&str; 2]) -> Option<[u64; 2]> {
        let text = self.read("proc/meminfo")?;
        let [a, b] = keys.map(|key| kibibytes(&text, key));
        Some([a?, b?])
    }
}

fn on_or_off(is_on: bool) -> String {
    if is_on { "on" } else { "off" }.to_owned()
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
