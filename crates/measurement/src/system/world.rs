//! What results say of the world around a run: the date, the machine, the compiler, and what else
//! kept the machine busy. Injected like the clock, so that all that is printed can be tested.

use std::collections::VecDeque;
use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};
use std::time::{SystemTime, UNIX_EPOCH};

use crate::record::{Compiler, Load, Machine, Tool};
use crate::rounds::trial::{TrialBuild, TrialOutcome};
use crate::system::machine;

/// The world as far as results repeat it: unless a test says otherwise, the one that the process
/// finds.
pub trait World: Sync {
    fn tool(&self) -> Tool;

    fn compiler(&self) -> Compiler;

    /// Seconds since 1970.
    fn unix_seconds(&self) -> u64 {
        SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
    }

    fn machine(&self) -> Machine {
        machine::machine()
    }

    /// Features of x86-64-v3 that the processor has, by rustc's names.
    fn processor_features(&self) -> Vec<&'static str> {
        of_processor()
    }

    /// SHA-256 of the program's file, where it can be read.
    fn program_sha256(&self) -> Option<String> {
        machine::program_sha256()
    }

    /// Largest resident set since the start or [`World::reset_peak_rss`], bytes.
    fn peak_rss(&self) -> Option<u64> {
        machine::peak_rss()
    }

    /// Begins a new peak where the system lets us.
    fn reset_peak_rss(&self) {
        let _ = machine::reset_peak_rss();
    }

    fn trial_build(&self, trial: &TrialBuild) -> TrialOutcome {
        trial.run()
    }

    fn load(&self) -> Load {
        machine::load()
    }

    /// The folder that has the system's `proc` and `sys`.
    fn system_root(&self) -> PathBuf {
        "/".into()
    }
}

#[derive(Debug, Clone)]
pub struct SystemWorld {
    pub tool: Tool,
    pub compiler: Compiler,
}

impl World for SystemWorld {
    fn tool(&self) -> Tool {
        self.tool.clone()
    }

    fn compiler(&self) -> Compiler {
        self.compiler.clone()
    }
}

/// A world that is the same everywhere, for tests of what is printed.
#[derive(Debug)]
pub struct FixedWorld {
    pub machine: Machine,
    pub processor_features: Vec<&'static str>,
    pub compiler: Compiler,
    /// What the loads are, one reading after another; the last one stays.
    pub loads: Mutex<VecDeque<Load>>,
    pub trials: fn(&TrialBuild) -> TrialOutcome,
}

impl Default for FixedWorld {
    fn default() -> Self {
        Self {
            machine: Machine {
                cpu: Some("Test CPU".into()),
                threads: 2,
                memory_bytes: Some(4 << 30),
                os: "linux".into(),
                governor: None,
                boost: None,
                batches_by_avx512: None,
                huge_pages: None,
            },
            processor_features: vec!["avx2", "fma"],
            compiler: Compiler {
                rustc: Some("rustc 1.90.0".into()),
                target: Some("x86_64-unknown-linux-gnu".into()),
                target_features: vec!["avx2".into(), "fma".into()],
                profile: Some("release".into()),
                opt_level: Some("3".into()),
            },
            loads: Mutex::default(),
            trials: |_| TrialOutcome::Ended { peak_bytes: Some(1 << 20) },
        }
    }
}

impl World for FixedWorld {
    fn unix_seconds(&self) -> u64 {
        1_767_225_600
    }

    fn tool(&self) -> Tool {
        Tool { name: "rtbench".into(), version: "0.0.0".into(), git_revision: Some("0".repeat(40)) }
    }

    fn compiler(&self) -> Compiler {
        self.compiler.clone()
    }

    fn machine(&self) -> Machine {
        self.machine.clone()
    }

    fn processor_features(&self) -> Vec<&'static str> {
        self.processor_features.clone()
    }

    fn program_sha256(&self) -> Option<String> {
        Some("0".repeat(64))
    }

    fn peak_rss(&self) -> Option<u64> {
        Some(64 << 20)
    }

    fn reset_peak_rss(&self) {}

    fn trial_build(&self, trial: &TrialBuild) -> TrialOutcome {
        (self.trials)(trial)
    }

    fn load(&self) -> Load {
        let mut loads = self.loads.lock().unwrap_or_else(PoisonError::into_inner);
        if loads.len() > 1 { loads.pop_front() } else { loads.front().copied() }.unwrap_or_default()
    }

    fn system_root(&self) -> PathBuf {
        "/nowhere".into()
    }
}

/// A list of features by rustc's names, each with whether this processor has it.
#[cfg(target_arch = "x86_64")]
macro_rules! detected {
    ($($name:tt),*) => { [$(($name, std::is_x86_feature_detected!($name))),*] };
}

/// Features of x86-64-v3 that this processor has; empty on other machines.
fn of_processor() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let all = detected!("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "lzcnt", "movbe");
    #[cfg(not(target_arch = "x86_64"))]
    let all: [(&'static str, bool); 0] = [];
    all.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect()
}

/// Features of the processor that the program does not use.
pub fn unused(world: &dyn World) -> Vec<&'static str> {
    let mut features = world.processor_features();
    let compiled = world.compiler().target_features;
    features.retain(|name| compiled.iter().all(|c| c != name));
    features
}

pub const ADVICE: &str =
    "take the binary for x86-64-v3, or compile with RUSTFLAGS=\"-C target-cpu=x86-64-v3\"";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn processor_features_are_available_and_used() {
        let of = |processor: &[&'static str], compiled: &[&str]| {
            let processor_features = processor.to_vec();
            let mut world = FixedWorld { processor_features, ..FixedWorld::default() };
            world.compiler.target_features = compiled.iter().map(|&f| f.into()).collect();
            unused(&world)
        };
        assert_eq!(of(&["avx2", "bmi2", "fma"], &["sse2", "avx2", "fma"]), ["bmi2"]);
        assert_eq!((of(&["avx2"], &[]), of(&["avx2"], &["avx2"])), (vec!["avx2"], vec![]));
        if cfg!(target_feature = "avx2") {
            assert!(of_processor().contains(&"avx2"), "this test could not run");
        }
    }
}
