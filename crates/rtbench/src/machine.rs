//! What the results were measured on and with.

use std::fs;
use std::sync::OnceLock;

use crate::record::{Compiler, Machine, Tool};

/// The program.
pub fn tool() -> Tool {
    Tool {
        name: env!("CARGO_PKG_NAME").into(),
        version: env!("CARGO_PKG_VERSION").into(),
        git_revision: option_env!("RTBENCH_GIT_REVISION").map(Into::into),
    }
}

/// The compiler, as `build.rs` saw it.
pub fn compiler() -> Compiler {
    let features = option_env!("RTBENCH_TARGET_FEATURES").unwrap_or_default();
    Compiler {
        rustc: option_env!("RTBENCH_RUSTC").map(Into::into),
        target: option_env!("RTBENCH_TARGET").map(Into::into),
        target_features: features.split(',').filter(|f| !f.is_empty()).map(Into::into).collect(),
        profile: option_env!("RTBENCH_PROFILE").map(Into::into),
        opt_level: option_env!("RTBENCH_OPT_LEVEL").map(Into::into),
    }
}

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
    }
}

/// Largest resident set of the process since its start or [`reset_peak_rss`], bytes.
pub fn peak_rss() -> Option<u64> {
    kibibytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM")
}

/// Begins a new peak where the system lets us; else the peak goes on from the start.
pub fn reset_peak_rss() {
    let _ = fs::write("/proc/self/clear_refs", "5");
}

/// The text after `key` and the separator on the first line that begins with them.
pub(crate) fn value(text: &str, key: &str, separator: char) -> Option<String> {
    let mut lines = text.lines().filter_map(|line| line.split_once(separator));
    let (_, value) = lines.find(|(k, _)| k.trim() == key)?;
    Some(value.trim().to_owned())
}

/// The bytes of a line in kB of a file of /proc.
pub(crate) fn kibibytes(text: &str, key: &str) -> Option<u64> {
    let value = value(text, key, ':')?;
    value.strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
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
    fn build_facts_are_recorded() {
        let compiler = compiler();
        assert!(compiler.rustc.is_some_and(|v| v.starts_with("rustc ")));
        assert!(compiler.target.is_some());
    }
}
