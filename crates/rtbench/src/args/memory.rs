//! How much memory a structure may take.

use clap::Args;
use measurement::settings::quantity;

/// How much memory a structure may take.
#[derive(Debug, Clone, Args)]
pub struct MemoryArgs {
    /// Most memory of a structure; a row that would take more is shown as `out of memory` [default:
    /// half of the machine's memory, or of the control group's limit if that is less]
    #[arg(long, value_name = "BYTES", value_parser = quantity::bytes)]
    pub max_memory: Option<u64>,
}
