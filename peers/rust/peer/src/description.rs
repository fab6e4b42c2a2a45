//! What a plugin is, as rtbench.h wants it.

use std::ffi::{CString, c_char};

use crate::{Peer, Real, Shadows, abi, built};

/// The row of a peer.
#[derive(Debug, Clone, Copy)]
pub struct Description {
    /// Of its row: a-z, digits and hyphens, and no name of rtbench's.
    pub name: &'static str,
    /// The crate that is measured: the version of the row is that in `Cargo.lock`.
    pub library: &'static str,
    /// One line.
    pub summary: &'static str,
    /// What users can change.
    pub settings: &'static [Setting],
}

/// A setting: `-s NAME:setting=value`.
#[derive(Debug, Clone, Copy)]
pub struct Setting {
    /// a-z, digits and hyphens.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// The default, as a user would type it.
    pub initial: &'static str,
    /// What values there are.
    pub kind: Kind,
}

/// What values a setting has.
#[derive(Debug, Clone, Copy)]
pub enum Kind {
    /// Whole numbers of a closed range.
    Integer(u32, u32),
    /// Words, with blanks between.
    Choice(&'static str),
}

/// A description as C reads it; its strings live as long as the process.
pub struct Described(&'static abi::Plugin);

// SAFETY: nothing of it changes
unsafe impl Send for Described {}
// SAFETY: likewise
unsafe impl Sync for Described {}

impl Described {
    /// For `rtbench_plugin_describe`.
    pub fn as_ptr(&self) -> *const abi::Plugin {
        self.0
    }
}

/// The description of a peer.
pub fn describe<P: Peer>() -> Described {
    described::<P>(abi::Functions::NONE)
}

/// The description of a peer in both precisions.
pub fn describe_both<P: Peer, Q: Peer<f64>>() -> Described {
    described::<P>(functions::<Q, f64>())
}

fn described<P: Peer>(in_f64: abi::Functions<f64>) -> Described {
    let Description { name, library, summary, settings } = P::DESCRIPTION;
    let settings: Vec<abi::Setting> = settings.iter().map(setting).collect();
    let settings: &'static [abi::Setting] = settings.leak();
    let mut answers = abi::TRIANGLES_F32;
    for (is_there, bit) in [
        (P::SHADOWS != Shadows::None, abi::OCCLUSION),
        (P::ASKS_INDICES, abi::INDICES),
        (P::ON_DEVICE, abi::DEVICE),
        (in_f64.build.is_some(), abi::TRIANGLES_F64),
    ] {
        answers |= if is_there { bit } else { 0 };
    }
    Described(Box::leak(Box::new(abi::Plugin {
        abi_version: abi::VERSION,
        size: size_of::<abi::Plugin>() as u32,
        name: text(name),
        version: text(locked_version(P::LOCK, library).unwrap_or("unknown")),
        summary: text(summary),
        answers,
        query: if P::ANSWERS_BATCHES { abi::BATCH } else { abi::ONE_RAY },
        test: abi::OWN_TEST,
        settings_count: settings.len() as u32,
        settings: settings.as_ptr(),
        in_f32: functions::<P, f32>(),
        in_f64,
    })))
}

fn functions<P: Peer<T>, T: Real>() -> abi::Functions<T> {
    abi::Functions {
        build: Some(built::build::<P, T>),
        closest: Some(built::closest::<P, T>),
        occluded: if P::SHADOWS == Shadows::None { None } else { Some(built::occluded::<P, T>) },
        stats: Some(built::stats::<P, T>),
        count: None,
        destroy: Some(built::destroy::<P>),
    }
}

fn setting(setting: &Setting) -> abi::Setting {
    let (kind, min, max, words) = match setting.kind {
        Kind::Integer(min, max) => (abi::INTEGER, min.into(), max.into(), std::ptr::null()),
        Kind::Choice(words) => (abi::CHOICE, 0.0, 0.0, text(words)),
    };
    abi::Setting {
        name: text(setting.name),
        summary: text(setting.summary),
        initial: text(setting.initial),
        kind,
        min,
        max,
        words,
    }
}

/// For as long as the process lives.
fn text(text: &str) -> *const c_char {
    CString::new(text).unwrap_or_default().into_raw()
}

/// The version of a crate that a `Cargo.lock` names.
pub fn locked_version<'a>(lock: &'a str, library: &str) -> Option<&'a str> {
    let (_, rest) = lock.split_once(&format!("\nname = \"{library}\"\nversion = \""))?;
    rest.split_once('"').map(|(version, _)| version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn versions_are_those_of_the_lock_file() {
        let lock = include_str!("../../Cargo.lock");
        assert_eq!(locked_version(lock, "peer"), Some(env!("CARGO_PKG_VERSION")));
        assert_eq!(locked_version(lock, "no-such-crate"), None);
        for library in ["bvh", "obvhs", "parry3d", "rtbvh"] {
            let version = locked_version(lock, library).unwrap();
            assert!(version.starts_with("0.") && version.matches('.').count() == 2, "{version}");
            // one of each, or the version of a row could be that of another
            let entry = format!("\nname = \"{library}\"\n");
            assert_eq!(lock.matches(&entry).count(), 1);
            let told = format!("[`{library}`](https://crates.io/crates/{library}) | {version} |");
            assert!(include_str!("../../README.md").contains(&told), "README.md: no {told}");
        }
    }
}
