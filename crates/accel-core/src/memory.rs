//! Memory limit of a structure. It is checked before allocation, so that exceeding it is an error
//! and does not end the program.
//!
//! A structure asks where its sizes come from settings and scenes:
//! [`Settings::fits`](crate::params::config::Settings::fits) for a list of known length; a
//! structure that grows in cells and references has room for both together.

use std::hint::black_box;

/// Smaller lists are not asked of the system beforehand.
const SMALL: u128 = 1 << 20;

/// The most bytes of a structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MemoryLimit(u64);

impl MemoryLimit {
    /// No limit except the system's.
    pub const NONE: Self = Self(u64::MAX);

    pub fn new(bytes: u64) -> Self {
        Self(bytes)
    }

    /// The bytes, where there is a limit.
    pub fn bytes(self) -> Option<u64> {
        (self != Self::NONE).then_some(self.0)
    }

    /// The limit that remains after reserving this many bytes.
    #[must_use]
    pub fn beside(self, bytes: u64) -> Self {
        if self == Self::NONE { self } else { Self(self.0.saturating_sub(bytes)) }
    }

    #[must_use]
    pub(crate) fn halved(self) -> Self {
        if self == Self::NONE { self } else { Self(self.0 / 2) }
    }

    /// Number of items of this size that fit.
    pub fn count(self, bytes_each: u64) -> u64 {
        if self == Self::NONE { u64::MAX } else { self.0 / bytes_each.max(1) }
    }

    /// Checks that this many bytes may be taken.
    ///
    /// # Errors
    /// [`OutOfMemory`].
    #[inline]
    pub fn allows(self, structure: &'static str, needed: u128) -> Result<(), OutOfMemory> {
        if needed <= u128::from(self.0) {
            Ok(())
        } else {
            Err(OutOfMemory { structure, needed, limit: Some(self.0) })
        }
    }

    /// Checks that this many bytes may be taken, and can be had now.
    ///
    /// # Errors
    /// [`OutOfMemory`].
    pub fn fits(self, structure: &'static str, needed: u128) -> Result<(), OutOfMemory> {
        self.allows(structure, needed)?;
        if needed > SMALL && !can_be_had(needed) {
            return Err(OutOfMemory { structure, needed, limit: None });
        }
        Ok(())
    }
}

/// Returns whether the system grants so many bytes: they are asked for, and given back untouched.
fn can_be_had(bytes: u128) -> bool {
    let mut room = Vec::<u8>::new();
    let granted = usize::try_from(bytes).is_ok_and(|n| room.try_reserve_exact(n).is_ok());
    // or the compiler leaves out what is not used
    black_box(&mut room);
    granted
}

/// A structure needs more memory than there is for it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{structure}: it would take {} of memory, {}", mebibytes(*.needed), reason(*.limit))]
pub struct OutOfMemory {
    pub structure: &'static str,
    /// Bytes that it needs, at least.
    pub needed: u128,
    /// Bytes that it may take; none where the system refuses them.
    pub limit: Option<u64>,
}

fn mebibytes(bytes: u128) -> String {
    format!("{} MiB", bytes.div_ceil(1 << 20))
}

fn reason(limit: Option<u64>) -> String {
    match limit {
        Some(limit) if limit < 1 << 20 => format!("more than the limit of {limit} bytes"),
        Some(limit) => format!("more than the limit of {} MiB", limit >> 20),
        None => "which the system refuses".to_owned(),
    }
}

/// The structure being built, and its memory limit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    pub(crate) structure: &'static str,
    pub(crate) memory: MemoryLimit,
}

impl Limits {
    /// Checks that a part of this many bytes may be taken, and can be had now.
    ///
    /// # Errors
    /// [`OutOfMemory`].
    pub fn fits(&self, bytes: u128) -> Result<(), OutOfMemory> {
        self.memory.fits(self.structure, bytes)
    }

    /// The most of what is counted that a setting allows and memory has room for.
    pub(crate) fn most(&self, counted: &CountedItem, setting: u64) -> u64 {
        setting.min(self.memory.count(counted.bytes))
    }
}

/// Something that a structure has many of.
#[derive(Debug, Clone, Copy)]
pub struct CountedItem {
    /// Name in errors, e.g. `number of cells`.
    pub what: &'static str,
    pub bytes: u64,
}

impl CountedItem {
    /// Cells of so many bytes each.
    pub const fn cells(what: &'static str, bytes: u64) -> Self {
        Self { what, bytes }
    }

    pub const fn references(what: &'static str) -> Self {
        Self { what, bytes: 4 }
    }
}

/// Asks for all cache lines of a value.
#[inline(always)]
pub(crate) fn prefetch<T>(value: &T) {
    #[cfg(target_arch = "x86_64")]
    for offset in (0..size_of::<T>()).step_by(64) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        // SAFETY: a hint, which reads nothing
        unsafe {
            _mm_prefetch::<_MM_HINT_T0>(std::ptr::from_ref(value).cast::<i8>().wrapping_add(offset))
        };
    }
    #[cfg(not(target_arch = "x86_64"))]
    let _ = value;
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_structure_over_the_limit_reports_its_bytes() {
        let limit = MemoryLimit::new(8 << 20);
        assert_eq!((limit.count(4), MemoryLimit::NONE.count(4)), (2 << 20, u64::MAX));
        assert_eq!(limit.fits("a", 8 << 20), Ok(()));
        let error = limit.fits("a", (8 << 20) + 1).unwrap_err().to_string();
        assert_eq!(error, "a: it would take 9 MiB of memory, more than the limit of 8 MiB");
        // more than any address space has
        let error = MemoryLimit::NONE.fits("a", 1 << 62).unwrap_err();
        assert_eq!(error.limit, None);
        assert!(error.to_string().ends_with("MiB of memory, which the system refuses"), "{error}");
        let small = MemoryLimit::new(5).fits("a", 6).unwrap_err().to_string();
        assert!(small.ends_with("more than the limit of 5 bytes"), "{small}");
    }
}
