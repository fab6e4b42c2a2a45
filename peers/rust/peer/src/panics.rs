//! Panics of a build, as a reason why it is not built.

use std::panic::{AssertUnwindSafe, PanicHookInfo, catch_unwind, set_hook, take_hook};
use std::sync::{Mutex, MutexGuard, Once, PoisonError};

/// The first panic since a build began: others follow from it, where threads are joined.
static FIRST: Mutex<Option<String>> = Mutex::new(None);

/// What `f` returns, or what it says when it panics, in whatever thread, and where.
pub(crate) fn as_reason<R>(f: impl FnOnce() -> Result<R, String>) -> Result<R, String> {
    static LISTENS: Once = Once::new();
    LISTENS.call_once(|| {
        let others = take_hook();
        set_hook(Box::new(move |panic| {
            first().get_or_insert_with(|| told(panic));
            others(panic);
        }));
    });
    // one build after the other, or a panic could be that of another
    static BUILDS: Mutex<()> = Mutex::new(());
    let _alone = BUILDS.lock().unwrap_or_else(PoisonError::into_inner);
    *first() = None;
    catch_unwind(AssertUnwindSafe(f)).unwrap_or_else(|_| {
        let told = first().take().unwrap_or_else(|| "without a word".to_owned());
        Err(format!("its build panics: {told}"))
    })
}

fn first() -> MutexGuard<'static, Option<String>> {
    FIRST.lock().unwrap_or_else(PoisonError::into_inner)
}

fn told(panic: &PanicHookInfo<'_>) -> String {
    let payload = panic.payload();
    let owned = payload.downcast_ref::<String>().map(String::as_str);
    let said = owned.or_else(|| payload.downcast_ref::<&str>().copied());
    let said = said.unwrap_or("without a word");
    match panic.location() {
        Some(at) => format!("{said} ({}:{})", in_crate(at.file()), at.line()),
        None => said.to_owned(),
    }
}

/// A file of a registry without where the registry lies.
fn in_crate(file: &str) -> &str {
    let below = file.split_once("index.crates.io").and_then(|(_, rest)| rest.split_once('/'));
    below.map_or(file, |(_, file)| file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_panic_is_the_reason() {
        let reason = as_reason(|| -> Result<(), String> {
            let first = std::thread::spawn(|| panic!("the cause")).join();
            first.map_err(|_| ()).expect("a thread ends well");
            Ok(())
        });
        let reason = reason.unwrap_err();
        assert!(reason.starts_with("its build panics: the cause (peer/src/panics.rs:"), "{reason}");
        assert_eq!(as_reason(|| Ok(7)), Ok(7));
        assert_eq!(as_reason(|| -> Result<(), _> { Err("no".into()) }), Err("no".into()));
    }

    #[test]
    fn files_are_told_by_their_crate() {
        let file = "registry/src/index.crates.io-1949cf8c/bvh-0.13.0/src/lib.rs";
        assert_eq!(in_crate(file), "bvh-0.13.0/src/lib.rs");
        assert_eq!(in_crate("src/lib.rs"), "src/lib.rs");
    }
}
