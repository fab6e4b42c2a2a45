//! What results say of the world around a run: the date, the machine, the compiler, and what else
//! kept the machine busy. Injected like the clock, so that all that is printed can be tested.

use std::path::PathBuf;
use std::time::{SystemTime, UNIX_EPOCH};

use crate::record::{Compiler, Load, Machine, Tool};
use crate::rounds::trial::{TrialBuild, TrialOutcome};
use crate::system::machine;

/// The world as far as results repeat it.
#[derive(Debug, Clone)]
pub struct World {
    pub tool: Tool,
    pub compiler: Compiler,
    /// Features of x86-64-v3 that the processor has, by rustc's names.
    pub processor_features: Vec<&'static str>,
    /// The folder that has the system's `proc` and `sys`.
    pub system_root: PathBuf,
    /// Seconds since 1970.
    pub unix_seconds: fn() -> u64,
    pub machine: fn() -> Machine,
    /// SHA-256 of the program's file, where it can be read.
    pub program_sha256: fn() -> Option<String>,
    /// Largest resident set since the start or `reset_peak_rss`, bytes.
    pub peak_rss: fn() -> Option<u64>,
    /// Begins a new peak where the system lets us.
    pub reset_peak_rss: fn(),
    pub trial_build: fn(&TrialBuild) -> TrialOutcome,
    pub load: fn() -> Load,
}

impl World {
    /// The world that the process finds.
    pub fn of_system(tool: Tool, compiler: Compiler) -> Self {
        Self {
            tool,
            compiler,
            processor_features: of_processor(),
            system_root: "/".into(),
            unix_seconds: || {
                SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
            },
            machine: machine::machine,
            program_sha256: machine::program_sha256,
            peak_rss: machine::peak_rss,
            reset_peak_rss: || {
                let _ = machine::reset_peak_rss();
            },
            trial_build: TrialBuild::run,
            load: machine::load,
        }
    }

    /// A world that is the same everywhere, for tests of what is printed.
    pub fn fixed() -> Self {
        Self {
            tool: Tool {
                name: "rtbench".into(),
                version: "0.0.0".into(),
                git_revision: Some("0".repeat(40)),
            },
            compiler: Compiler {
                rustc: Some("rustc 1.90.0".into()),
                target: Some("x86_64-unknown-linux-gnu".into()),
                target_features: vec!["avx2".into(), "fma".into()],
                profile: Some("release".into()),
                opt_level: Some("3".into()),
            },
            processor_features: vec!["avx2", "fma"],
            system_root: "/nowhere".into(),
            unix_seconds: || 1_767_225_600,
            machine: || Machine {
                cpu: Some("Test CPU".into()),
                threads: 2,
                memory_bytes: Some(4 << 30),
                os: "linux".into(),
                governor: None,
                boost: None,
                batches_by_avx512: None,
                huge_pages: None,
            },
            program_sha256: || Some("0".repeat(64)),
            peak_rss: || Some(64 << 20),
            reset_peak_rss: || {},
            trial_build: |_| TrialOutcome::Ended { peak_bytes: Some(1 << 20) },
            load: Load::default,
        }
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
pub fn unused(world: &World) -> Vec<&'static str> {
    let mut features = world.processor_features.clone();
    features.retain(|name| world.compiler.target_features.iter().all(|c| c != name));
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
            let mut world = World { processor_features, ..World::fixed() };
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
