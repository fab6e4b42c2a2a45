//! Names of what is reproduced.

use studies::reproduce::{ReproduceError, UnknownName};

/// The names asked for, in the publication's order; all when none is.
pub fn chosen<'v>(
    asked: &[String],
    valid: &[&'v str],
    unknown: fn(UnknownName) -> ReproduceError,
) -> Result<Vec<&'v str>, ReproduceError> {
    if let Some(name) = asked.iter().find(|name| !valid.contains(&name.as_str())) {
        return Err(unknown(UnknownName::new(name, valid)));
    }
    Ok(valid
        .iter()
        .copied()
        .filter(|v| asked.is_empty() || asked.iter().any(|name| name == v))
        .collect())
}
