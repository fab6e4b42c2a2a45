//! The work counters of Havran and Sixta (1999): what no machine can change.
//!
//! | symbol | meaning |
//! | --- | --- |
//! | N_IT | ray-primitive intersection tests |
//! | N_TS | traversal steps: cells (or nodes) visited, of the hierarchy too |
//! | N_ETS | elementary steps: cells (or leaves) that hold primitives directly |
//! | N_EETS | elementary steps into empty cells |
//!
//! Beside them stands how many tests a mailbox saved.
//!
//! Counting is a type parameter. The timed pass runs with [`NoCounters`], whose methods are empty
//! and whose size is zero.

use std::ops::AddAssign;

/// Receives the events of a traversal. Default methods do nothing.
pub trait Counters: Default + Copy + Send + AddAssign {
    /// False for [`NoCounters`]: lets an adapter skip work that is only done for counting.
    const ENABLED: bool;
    /// `n` intersection tests.
    #[inline(always)]
    fn intersection_tests(&mut self, _n: usize) {}
    /// A test that a mailbox spared.
    #[inline(always)]
    fn test_saved(&mut self) {}
    /// A step into a cell or leaf that may hold primitives.
    #[inline(always)]
    fn elementary_step(&mut self, _empty: bool) {}
    /// A step in the hierarchy: an inner node, or a grid that was entered.
    #[inline(always)]
    fn inner_step(&mut self) {}
}

/// Counts nothing, costs nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct NoCounters;

impl Counters for NoCounters {
    const ENABLED: bool = false;
}

impl AddAssign for NoCounters {
    #[inline(always)]
    fn add_assign(&mut self, _: Self) {}
}

/// Sums over a batch of rays.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct WorkCounters {
    pub intersection_tests: u64,
    /// N_TS: traversal steps of every kind.
    pub traversal_steps: u64,
    pub elementary_steps: u64,
    /// N_EETS: elementary steps into empty cells.
    pub empty_elementary_steps: u64,
    /// Tests that a mailbox spared.
    pub tests_saved: u64,
}

impl Counters for WorkCounters {
    const ENABLED: bool = true;

    #[inline(always)]
    fn intersection_tests(&mut self, n: usize) {
        self.intersection_tests += n as u64;
    }
    #[inline(always)]
    fn test_saved(&mut self) {
        self.tests_saved += 1;
    }
    #[inline(always)]
    fn elementary_step(&mut self, empty: bool) {
        self.traversal_steps += 1;
        self.elementary_steps += 1;
        self.empty_elementary_steps += u64::from(empty);
    }
    #[inline(always)]
    fn inner_step(&mut self) {
        self.traversal_steps += 1;
    }
}

/// Adds such sums field by field.
macro_rules! add_fields {
    ($sums:ty: $($field:ident),*) => {
        impl std::ops::AddAssign for $sums {
            #[inline(always)]
            fn add_assign(&mut self, other: Self) {
                $(self.$field += other.$field;)*
            }
        }
    };
}
pub(crate) use add_fields;

add_fields!(WorkCounters: intersection_tests, traversal_steps, elementary_steps, empty_elementary_steps, tests_saved);
