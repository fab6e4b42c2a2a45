//! Which of the instructions that x86-64-v3 has beyond the baseline a processor has, and a program
//! was compiled for.

/// A list of features by rustc's names, each with whether this processor has it.
#[cfg(target_arch = "x86_64")]
macro_rules! detected {
    ($($name:tt),*) => { [$(($name, std::is_x86_feature_detected!($name))),*] };
}

/// What this processor has of x86-64-v3; nothing on other machines.
pub fn of_processor() -> Vec<&'static str> {
    #[cfg(target_arch = "x86_64")]
    let all = detected!("avx", "avx2", "bmi1", "bmi2", "f16c", "fma", "lzcnt", "movbe");
    #[cfg(not(target_arch = "x86_64"))]
    let all: [(&'static str, bool); 0] = [];
    all.into_iter().filter(|(_, has)| *has).map(|(name, _)| name).collect()
}

/// Features of the processor that the program does not use.
pub fn unused(processor: &[&'static str], compiled: &[String]) -> Vec<&'static str> {
    processor.iter().copied().filter(|name| compiled.iter().all(|c| c != name)).collect()
}

/// Advice for unused features.
pub const ADVICE: &str =
    "take the binary for x86-64-v3, or compile with RUSTFLAGS=\"-C target-cpu=x86-64-v3\"";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_compiled_in_is_there_and_used() {
        let compiled = ["sse2", "avx2", "fma"].map(str::to_owned);
        assert_eq!(unused(&["avx2", "fma"], &compiled), [""; 0]);
        assert_eq!(unused(&["avx2", "bmi2", "fma"], &compiled), ["bmi2"]);
        assert_eq!(unused(&["avx2"], &[]), ["avx2"]);
        assert!(unused(&[], &[]).is_empty());
        if cfg!(target_feature = "avx2") {
            assert!(of_processor().contains(&"avx2"), "this test could not run");
        }
    }
}
