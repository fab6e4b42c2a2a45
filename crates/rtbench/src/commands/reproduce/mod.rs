//! `rtbench reproduce`: published figures beside ours, one publication a file.

mod havran;
mod zachmann;

use crate::args::{Publication, ReproduceArgs};
use crate::context::Context;
use crate::error::Error;
use studies::reproduce::ReproduceError;

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

/// The names asked for, in the publication's order; all when none is.
fn chosen<'v>(
    asked: &[String],
    valid: &[&'v str],
    unknown: fn(String) -> ReproduceError,
) -> Result<Vec<&'v str>, Error> {
    if let Some(name) = asked.iter().find(|name| !valid.contains(&name.as_str())) {
        return Err(unknown(name.clone()).into());
    }
    Ok(valid
        .iter()
        .copied()
        .filter(|v| asked.is_empty() || asked.iter().any(|name| name == v))
        .collect())
}
