//! `rtbench doctor`: sources of noise on this machine, one finding per line, with advice.
//!
//! Files of `/proc` and `/sys` (Linux) say most of it. Where one is not there, the finding is
//! `unknown`; nothing is guessed.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::PathBuf;

use serde::Serialize;

use crate::args::{DoctorArgs, Format};
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use measurement::system::machine::{boost, kibibytes, line, value};
use measurement::system::memory::huge_pages_in;
use measurement::system::noise::Noise;
use measurement::system::world;
use presentation::json;
use presentation::table::Style;
use presentation::text::{Screen, painted, wrapped};

pub fn run(context: &mut Context<'_>, args: &DoctorArgs) -> Result<u8, Error> {
    let noise = Noise::measured(context.clock);
    let system = System {
        root: context.world.system_root.clone(),
        threads: (context.world.machine)().threads,
        unused: world::unused(context.world),
        noise: noise.judged(),
    };
    let diagnosis = Diagnosis { noise, findings: system.findings() };
    let screen = context.screen();
    match args.format {
        Format::Json => context.out.write_all(json::written(&diagnosis)?.as_bytes())?,
        Format::Text => write(context.out, &diagnosis.findings, screen)?,
    }
    Ok(SUCCESS)
}

fn write(out: &mut dyn Write, findings: &[Finding], screen: Screen) -> std::io::Result<()> {
    let width = findings.iter().map(|f| f.name.chars().count()).max().unwrap_or(0);
    let indent = 9 + width + 2;
    for finding in findings {
        let (level, style) = match finding.level {
            Level::Good => ("good", Style::Plain),
            Level::Warning => ("warning", Style::Bad),
            Level::Unknown => ("unknown", Style::Dim),
        };
        let level = painted(&format!("{level:<7}"), style, screen.colors);
        let text = format!("{:9}{:<width$}  {}", "", finding.name, finding.value);
        let text = wrapped(&text, screen.width, indent).join("\n");
        writeln!(out, "{level}{}", text.get(7..).unwrap_or_default())?;
        if let Some(advice) = finding.advice {
            for text in [finding.meaning, &format!("to do: {advice}")] {
                screen.write_item(out, &format!("{:indent$}{text}", ""), indent)?;
            }
        }
    }
    let warnings = findings.iter().filter(|f| f.level == Level::Warning).count();
    writeln!(out, "{warnings} of {} findings may disturb measurements", findings.len())
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
enum Level {
    Good,
    Warning,
    /// The system does not tell.
    Unknown,
}

/// A property of the machine.
#[derive(Debug, Serialize)]
struct Finding {
    name: &'static str,
    level: Level,
    value: String,
    meaning: &'static str,
    advice: Option<&'static str>,
}

#[derive(Serialize)]
struct Diagnosis {
    noise: Noise,
    findings: Vec<Finding>,
}

struct System {
    /// `/`, or a test's own.
    root: PathBuf,
    /// Threads that the process may use.
    threads: usize,
    /// Features that the processor has and the program was compiled without.
    unused: Vec<&'static str>,
    /// No file has it: it is timed.
    noise: (bool, String),
}

struct Check {
    name: &'static str,
    meaning: &'static str,
    advice: &'static str,
    /// Whether it is as it should be, and in words; none where the system does not report it.
    look: fn(&System) -> Option<(bool, String)>,
}

const HUGE_PAGES: &str = "huge pages";
const CHECKS: [Check; 11] = [
    Check {
        name: "governor",
        meaning: "the clock frequency follows the load: the first rounds are slower than the rest",
        advice: "sudo cpupower frequency-set -g performance",
        look: |system| {
            let file = |cpu| format!("sys/devices/system/cpu/cpu{cpu}/cpufreq/scaling_governor");
            let governor = |cpu| system.read(&file(cpu));
            let governors: BTreeSet<String> = (0..4096).map_while(governor).collect();
            let all = Vec::from_iter(governors).join(", ");
            (!all.is_empty()).then_some((all == "performance", all))
        },
    },
    Check {
        name: "boost",
        meaning: "the clock frequency depends on heat and other cores; ratios suffer least",
        advice: "echo 0 | sudo tee /sys/devices/system/cpu/cpufreq/boost (Intel: echo 1 | sudo tee \
                 /sys/devices/system/cpu/intel_pstate/no_turbo)",
        look: |system| boost(&system.root).map(better_off),
    },
    Check {
        name: "load",
        meaning: "programs that wait for a core interrupt the measurement and share its caches",
        advice: "end other programs, or wait until they are done",
        look: |system| {
            let load: f64 = system.read("proc/loadavg")?.split_whitespace().next()?.parse().ok()?;
            // one core for the measurement, the others may work
            let is_low = load < 0.5 || system.threads as f64 - load >= 1.5;
            Some((is_low, format!("{load:.2} of {} cores, over a minute", system.threads)))
        },
    },
    Check {
        name: "cores",
        meaning: "other programs, and other threads of our own, stop the measurement",
        advice: "use a machine with two cores or more and no quota",
        look: |system| {
            let quota = system.read("sys/fs/cgroup/cpu.max").filter(|q| !q.starts_with("max"));
            let is_good = system.threads >= 2 && quota.is_none();
            let limited = quota.map(|q| format!(", limited to {q} (microseconds of a period)"));
            Some((is_good, format!("{} usable{}", system.threads, limited.unwrap_or_default())))
        },
    },
    Check {
        name: "SMT",
        meaning: "two threads share a core: what runs on the other one halves the speed",
        advice: "keep the other threads idle, or echo off | sudo tee \
                 /sys/devices/system/cpu/smt/control",
        look: |system| Some(better_off(system.read("sys/devices/system/cpu/smt/active")? == "1")),
    },
    Check {
        name: "memory",
        meaning: "less than 1 GiB is not enough for the large scenes: the system would swap, or \
                  kill the run; pages that come back from disk are timed as if they were work",
        advice: "end other programs, then sudo swapoff -a && sudo swapon -a",
        look: |system| {
            let text = system.read("proc/meminfo")?;
            let bytes = |key| kibibytes(&text, key);
            let (total, free) = (bytes("MemTotal")? >> 20, bytes("MemAvailable")? >> 20);
            let swapped = bytes("SwapTotal")?.saturating_sub(bytes("SwapFree")?) >> 20;
            let found = format!("{free} MiB free of {total} MiB, {swapped} MiB swapped out");
            // the standard scenes need 200 MiB, those of packages 1 GiB
            Some((free >= 1 << 10 && swapped < 64, found))
        },
    },
    Check {
        name: "virtual machine",
        meaning: "neighbours that are not seen from here share cores, caches and memory",
        advice: "compare ratios of the same run and counters, never seconds of two runs",
        look: |system| {
            let info = system.read("proc/cpuinfo")?;
            let is_virtual = value(&info, "flags", ':')?.split(' ').any(|f| f == "hypervisor");
            let product = system.read("sys/class/dmi/id/product_name").filter(|_| is_virtual);
            let name = product.map(|name| format!(" ({name})")).unwrap_or_default();
            Some((!is_virtual, if is_virtual { "yes" } else { "no" }.to_owned() + &name))
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
            Some(match &*system.unused.join(", ") {
                "" => (true, "those of the processor".into()),
                names => (false, format!("compiled without {names}, which the processor has")),
            })
        },
    },
    Check {
        name: "noise",
        meaning: "times of equal work differ so much: a few rounds show no smaller differences",
        advice: "end other programs, or take more rounds (--time-budget 10m) and trust ratios and \
                 counters, not seconds",
        look: |system| Some(system.noise.clone()),
    },
    Check {
        name: HUGE_PAGES,
        meaning: "rays through many megabytes wait for translations of addresses in small pages",
        advice: "echo madvise | sudo tee /sys/kernel/mm/transparent_hugepage/enabled",
        look: |system| {
            let state = huge_pages_in(&system.read("sys/kernel/mm/transparent_hugepage/enabled")?)?;
            Some((state != "never", "off".into()))
        },
    },
];

impl System {
    fn findings(&self) -> Vec<Finding> {
        let finding = |Check { name, meaning, advice, look }: Check| {
            let (level, value, advice) = match look(self) {
                None => (Level::Unknown, "the system does not say".to_owned(), None),
                Some((true, words)) => (Level::Good, words, None),
                Some((false, words)) => (Level::Warning, words, Some(advice)),
            };
            Finding { name, level, value, meaning, advice }
        };
        // huge pages that are off are rare
        let is_shown = |f: &Finding| f.name != HUGE_PAGES || f.level == Level::Warning;
        CHECKS.into_iter().map(finding).filter(is_shown).collect()
    }

    fn read(&self, path: &str) -> Option<String> {
        line(self.root.join(path))
    }
}

fn better_off(is_on: bool) -> (bool, String) {
    (!is_on, if is_on { "on" } else { "off" }.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Files of a quiet machine, of a busy one, and of one that is only short of memory.
    const FILES: [(&str, &[&str]); 10] = [
        ("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", &["performance", "powersave"]),
        ("sys/devices/system/cpu/intel_pstate/no_turbo", &["", "0"]),
        ("sys/devices/system/cpu/cpufreq/boost", &["0", "1"]),
        ("sys/devices/system/cpu/smt/active", &["0", "1"]),
        ("proc/loadavg", &["0.10 0.2 0.3 1/100 7", "3.90 2 1 1/100 7"]),
        (
            "proc/meminfo",
            &[
                "MemTotal: 8000000 kB\nMemAvailable: 7000000 kB\nSwapTotal: 0 kB\nSwapFree: 0 kB",
                "MemTotal: 8000000 kB\nMemAvailable: 7000000 kB\nSwapTotal: 900000 kB\nSwapFree: 9 kB",
                "MemTotal: 8000000 kB\nMemAvailable: 70000 kB\nSwapTotal: 0 kB\nSwapFree: 0 kB",
            ],
        ),
        ("proc/cpuinfo", &["model name\t: X\nflags\t\t: fpu", "flags\t\t: fpu hypervisor sse"]),
        ("proc/stat", &["cpu  100 0 100 1000 0 0 0 0 0 0", "cpu  100 0 100 1000 0 0 0 100 0 0"]),
        ("sys/fs/cgroup/cpu.max", &["max 100000", "50000 100000"]),
        ("sys/kernel/mm/transparent_hugepage/enabled", &["always [madvise]", "madvise [never]"]),
    ];

    #[test]
    fn a_quiet_machine_is_good_and_a_busy_one_is_warned_of_with_advice() {
        let of = |machine: usize, unused: Vec<&'static str>| {
            let folder = tempfile::tempdir().unwrap();
            for (path, texts) in FILES {
                let path = folder.path().join(path);
                std::fs::create_dir_all(path.parent().unwrap()).unwrap();
                std::fs::write(path, format!("{}\n", texts.get(machine).unwrap_or(&texts[0])))
                    .unwrap();
            }
            let noise = (unused.is_empty(), String::new());
            System { root: folder.path().to_owned(), threads: 4, unused, noise }.findings()
        };
        for finding in of(0, Vec::new()) {
            assert_eq!((finding.level, finding.advice), (Level::Good, None), "{finding:?}");
        }
        let busy = of(1, vec!["avx2"]);
        assert_eq!(busy.last().map(|f| (f.name, &*f.value)), Some((HUGE_PAGES, "off")));
        for finding in busy {
            assert_eq!(finding.level, Level::Warning, "{finding:?}");
            assert!(finding.advice.is_some() && !finding.meaning.is_empty(), "{finding:?}");
        }
        let warned = of(2, Vec::new()).into_iter().filter(|found| found.level != Level::Good);
        assert_eq!(warned.map(|found| found.name).collect::<Vec<_>>(), ["memory"]);
    }
}
