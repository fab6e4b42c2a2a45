//! How far a check has come, and whether it must end before it is done.

use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering::SeqCst};
use std::time::Duration;

use serde::Serialize;

use measurement::system::clock::Clock;
use measurement::system::progress::Progress;

/// Why a check ended before all was asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum StopReason {
    Interrupted(usize),
    OutOfTime,
}

/// Watches over a check. What is being asked when it must end is asked to its end: one structure,
/// the rays of one round.
pub struct CheckWatch<'a> {
    clock: &'a dyn Clock,
    /// A reading of the clock.
    deadline: Option<Duration>,
    /// The number of the signal that came; 0: none did.
    signal: Arc<AtomicUsize>,
    /// One step per round.
    progress: Progress,
}

impl<'a> CheckWatch<'a> {
    /// From now on; `signal` is 0 as long as none came.
    pub fn new(
        clock: &'a dyn Clock,
        limit: Option<Duration>,
        signal: Arc<AtomicUsize>,
        progress: Progress,
    ) -> Self {
        let deadline = limit.map(|limit| clock.now().saturating_add(limit));
        Self { clock, deadline, signal, progress }
    }

    /// Why the check must end, if it must.
    pub fn cut(&self) -> Option<StopReason> {
        match self.signal.load(SeqCst) {
            0 => {}
            signal => return Some(StopReason::Interrupted(signal)),
        }
        let is_late = self.deadline.is_some_and(|deadline| self.clock.now() >= deadline);
        is_late.then_some(StopReason::OutOfTime)
    }

    /// Says what is asked.
    pub fn begin(&self, what: &str) {
        self.progress.message(what);
    }

    /// A round is over.
    pub fn round(&self) {
        self.progress.step(Duration::ZERO);
    }

    pub fn finish(&self) {
        self.progress.finish();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use measurement::system::clock::SteppingClock;

    #[test]
    fn a_signal_and_the_limit_end_it() {
        let clock = SteppingClock::new(Duration::from_secs(1));
        let signal = Arc::new(AtomicUsize::new(0));
        let limit = Some(Duration::from_secs(3));
        let watch = CheckWatch::new(&clock, limit, Arc::clone(&signal), Progress::hidden());
        let cuts = [(); 3].map(|()| watch.cut());
        assert_eq!(cuts, [None, None, Some(StopReason::OutOfTime)]);
        signal.store(2, SeqCst);
        assert_eq!(watch.cut(), Some(StopReason::Interrupted(2)));
        let endless = CheckWatch::new(&clock, None, Arc::default(), Progress::hidden());
        assert_eq!(endless.cut(), None);
    }
}
