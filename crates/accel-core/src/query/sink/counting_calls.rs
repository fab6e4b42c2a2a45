//! Calls to the counters, as macros: a feature takes them out of the source.

/// A call to the counters. The feature `delete-counter-calls` removes it from the source, so that
/// `scripts/counter-overhead.sh` can show that disabled counters cost nothing.
macro_rules! count {
    ($call:expr) => {
        #[cfg(not(feature = "delete-counter-calls"))]
        $call;
    };
}

macro_rules! count_steps {
    () => {
        const COUNTING: bool = C::ENABLED;
        #[inline(always)]
        fn elementary_step(&mut self, _empty: bool) {
            count!(self.counters.elementary_step(_empty));
        }
        #[inline(always)]
        fn inner_step(&mut self) {
            count!(self.counters.inner_step());
        }
    };
}

pub(crate) use {count, count_steps};
