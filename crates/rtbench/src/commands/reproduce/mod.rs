//! `rtbench reproduce`: published figures beside ours, one publication a file.

mod chosen;
mod havran;
mod zachmann;

use crate::args::{Publication, ReproduceArgs};
use crate::context::Context;
use crate::error::Error;

/// Reproduces the publication and returns the exit code.
///
/// # Errors
/// [`Error`] for unknown names, unwritable files and scenes that cannot be traced.
pub fn run(context: &mut Context<'_>, args: &ReproduceArgs) -> Result<u8, Error> {
    match &args.publication {
        Publication::Havran1999(args) => havran::run(context, args),
        Publication::Zachmann2007(args) => zachmann::run(context, args),
    }
}
