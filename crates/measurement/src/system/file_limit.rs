//! The system's limit on the size of files, `ulimit -f`. Writing beyond it ends a process without a
//! word, unless it handles the signal: then the write fails like any other.

/// From here on a write beyond the limit is an error.
///
/// # Errors
/// The system's, when the signal cannot be had.
#[cfg(unix)]
pub fn refuse_writes_beyond() -> std::io::Result<()> {
    let was_reached = std::sync::Arc::default();
    signal_hook::flag::register(signal_hook::consts::SIGXFSZ, was_reached).map(|_| ())
}

/// Elsewhere than on Unix there is none.
///
/// # Errors
/// None.
#[cfg(not(unix))]
pub fn refuse_writes_beyond() -> std::io::Result<()> {
    Ok(())
}
