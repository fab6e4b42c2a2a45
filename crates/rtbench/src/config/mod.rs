//! `rtbench.toml`, and the options of sets of scenes.

mod defaults;
mod file;
mod set_defaults;
mod sets;

pub use defaults::join;
pub use file::{Config, ConfigError};
pub use set_defaults::of_set;
pub use sets::Configured;
