//! Version and compiler of this program, as recorded by `build.rs`.

use measurement::record::{Compiler, Tool};
use measurement::system::world::World;

pub fn world() -> World {
    let features = option_env!("RTBENCH_TARGET_FEATURES").unwrap_or_default();
    let tool = Tool {
        name: env!("CARGO_PKG_NAME").into(),
        version: env!("CARGO_PKG_VERSION").into(),
        git_revision: option_env!("RTBENCH_GIT_REVISION").map(Into::into),
    };
    let compiler = Compiler {
        rustc: option_env!("RTBENCH_RUSTC").map(Into::into),
        target: option_env!("RTBENCH_TARGET").map(Into::into),
        target_features: features.split(',').filter(|f| !f.is_empty()).map(Into::into).collect(),
        profile: option_env!("RTBENCH_PROFILE").map(Into::into),
        opt_level: renderer::OPT_LEVEL.map(Into::into),
    };
    World::of_system(tool, compiler)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn build_facts_are_recorded() {
        let compiler = world().compiler;
        assert!(compiler.rustc.is_some_and(|v| v.starts_with("rustc ")));
        assert!(compiler.target.is_some());
    }
}
