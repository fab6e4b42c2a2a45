//! `rtbench list`.

use clap::{Args, ValueEnum};

#[derive(Debug, Clone, Args)]
pub struct ListArgs {
    /// What to list
    #[arg(value_enum)]
    pub what: Listed,
    /// Only those of these names
    #[arg(value_name = "NAME")]
    pub names: Vec<String>,
    /// As text or as JSON
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}

/// What can be listed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Listed {
    /// Structures with their parameters
    Structures,
    /// Occluders, which answer shadow rays, with their parameters
    Occluders,
    /// Tracers, which make images, with what each assumes and refuses
    Tracers,
    /// Scenes by name
    Scenes,
    /// Scenes that move, for `animate`
    Animations,
    /// Sets of scenes
    Sets,
    /// Kinds of rays
    Rays,
    /// Axes of accuracy
    Axes,
}

impl Listed {
    /// One of what is listed.
    pub fn singular(self) -> &'static str {
        match self {
            Self::Structures => "structure",
            Self::Occluders => "occluder",
            Self::Tracers => "tracer",
            Self::Scenes => "scene",
            Self::Animations => "animation",
            Self::Sets => "set",
            Self::Rays => "kind of rays",
            Self::Axes => "axis",
        }
    }
}

/// How to print a list.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Format {
    /// For reading
    Text,
    /// For programs
    Json,
}
