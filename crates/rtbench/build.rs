//! Records what the binary was compiled from and for; every result repeats it.

use std::env;
use std::process::Command;

fn main() {
    let rustc = env::var("RUSTC").unwrap_or_else(|_| "rustc".into());
    set("RTBENCH_RUSTC", output(&rustc, &["-V"]));
    set("RTBENCH_TARGET", env::var("TARGET").ok());
    set("RTBENCH_TARGET_FEATURES", env::var("CARGO_CFG_TARGET_FEATURE").ok());
    set("RTBENCH_PROFILE", env::var("PROFILE").ok());
    println!("cargo::rerun-if-changed=build.rs");
    let version = env!("CARGO_PKG_VERSION");
    // sources that lie unpacked inside of another repository are not of its commit
    if output("git", &["ls-files", "build.rs"]).is_none() {
        return set("RTBENCH_VERSION", Some(format!("{version}, commit unknown")));
    }
    let commit = output("git", &["rev-parse", "HEAD"]);
    let short = commit.as_deref().and_then(|commit| commit.get(..12)).unwrap_or("no commit");
    set("RTBENCH_VERSION", Some(format!("{version} at {short}")));
    set("RTBENCH_GIT_REVISION", commit);
    // The log of HEAD changes with every commit and checkout; HEAD where logs are off.
    for name in ["logs/HEAD", "HEAD"] {
        let path = output("git", &["rev-parse", "--path-format=absolute", "--git-path", name]);
        if let Some(path) = path.filter(|p| std::path::Path::new(p).exists()) {
            println!("cargo::rerun-if-changed={path}");
            break;
        }
    }
}

/// Sets a variable for `option_env!`; absent where the value is.
fn set(name: &str, value: Option<String>) {
    if let Some(value) = value {
        println!("cargo::rustc-env={name}={value}");
    }
}

/// The first line that a command prints, or nothing when it cannot run or fails.
fn output(program: &str, args: &[&str]) -> Option<String> {
    let output = Command::new(program).args(args).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    let line = text.lines().next()?.trim();
    (output.status.success() && !line.is_empty()).then(|| line.to_owned())
}
