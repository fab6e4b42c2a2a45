//! Panics of structures and tracers, as failures that are reported and cost nothing else.
//!
//! Nothing should panic; what does is a defect of ours or of a library. It is caught at the row, or
//! at the scene, said once, and the rows that are finished stay.

use std::panic::{self, AssertUnwindSafe};
use std::sync::{Mutex, PoisonError};

/// Where the latest panic was and what it said; kept by the hook of [`keep_quiet`].
static LATEST: Mutex<Option<String>> = Mutex::new(None);

#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("panicked: {0}")]
pub struct CaughtPanic(pub String);

/// From here on panics print nothing: whoever catches one says what it said.
pub fn keep_quiet() {
    panic::set_hook(Box::new(|info| {
        let message = panic_message(info.payload());
        let place = info.location().map(|l| format!(" ({}:{})", l.file(), l.line()));
        let text = message + &place.unwrap_or_default();
        *LATEST.lock().unwrap_or_else(PoisonError::into_inner) = Some(text);
    }));
}

/// What `work` returns, or its panic. Whatever `work` was changing may be half changed then:
/// callers throw it away.
pub fn caught<T>(work: impl FnOnce() -> T) -> Result<T, CaughtPanic> {
    panic::catch_unwind(AssertUnwindSafe(work)).map_err(|payload| {
        let latest = LATEST.lock().unwrap_or_else(PoisonError::into_inner).take();
        CaughtPanic(latest.unwrap_or_else(|| panic_message(&*payload)))
    })
}

fn panic_message(payload: &(dyn std::any::Any + Send)) -> String {
    let text = payload.downcast_ref::<String>().map(String::as_str);
    text.or(payload.downcast_ref::<&str>().copied()).unwrap_or("no message").to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_is_an_error_with_its_message() {
        assert_eq!(caught(|| 7), Ok(7));
        let n = 3;
        let error = caught(|| assert!(n != 3, "tile {n}")).unwrap_err();
        assert!(error.to_string().contains("panicked: tile 3"), "{error}");
    }
}
