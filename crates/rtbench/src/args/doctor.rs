//! `rtbench doctor`.

use clap::Args;

use crate::args::list::Format;

#[derive(Debug, Clone, Args)]
pub struct DoctorArgs {
    /// As text or as JSON
    #[arg(long, value_enum, default_value_t = Format::Text)]
    pub format: Format,
}
