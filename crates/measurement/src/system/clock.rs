//! Time, injected so that everything computed from it can be tested.

use std::sync::Mutex;
use std::time::{Duration, Instant};

/// A monotonic clock.
pub trait Clock: Sync {
    /// Time since some fixed moment.
    fn now(&self) -> Duration;

    /// Seconds since `start`, an earlier answer of [`Clock::now`].
    fn seconds_since(&self, start: Duration) -> f64 {
        self.now().saturating_sub(start).as_secs_f64()
    }
}

/// The machine's monotonic clock.
#[derive(Debug)]
pub struct SystemClock {
    start: Instant,
}

impl Default for SystemClock {
    fn default() -> Self {
        Self { start: Instant::now() }
    }
}

impl Clock for SystemClock {
    fn now(&self) -> Duration {
        self.start.elapsed()
    }
}

/// A clock that goes on by the same step each time it is read: every measured interval is exactly
/// one step long.
#[derive(Debug)]
pub struct SteppingClock {
    step: Duration,
    now: Mutex<Duration>,
}

impl SteppingClock {
    /// Starts at zero.
    pub fn new(step: Duration) -> Self {
        Self { step, now: Mutex::new(Duration::ZERO) }
    }
}

impl Clock for SteppingClock {
    fn now(&self) -> Duration {
        let mut now = self.now.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
        let before = *now;
        *now = before.saturating_add(self.step);
        before
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_the_stepping_clock_are_one_step() {
        let clock = SteppingClock::new(Duration::from_millis(5));
        let start = clock.now();
        assert_eq!(clock.seconds_since(start), 0.005);
        let later = clock.now();
        assert_eq!(clock.seconds_since(later), 0.005);
    }

    #[test]
    fn the_system_clock_does_not_go_back() {
        let clock = SystemClock::default();
        let start = clock.now();
        assert!(clock.seconds_since(start) >= 0.0);
    }
}
