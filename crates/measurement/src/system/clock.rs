//! Time, injected so that everything computed from it can be tested.
//!
//! What one thread does is timed by that thread's processor time. By the time of day, a pass that
//! is a little longer than what the scheduler gives at once (4 ms where its clock has 250 Hz) is
//! interrupted in most rounds as soon as anything else wants the processor, and a shorter one in
//! few: medians then jump by 4 ms, for whole runs. That was what kd-tree on *tetra* did, at 1.66 or
//! 2.77 times the reference.

use std::sync::Mutex;
use std::time::{Duration, Instant};

pub trait Clock: Sync {
    /// Time since some fixed moment.
    fn now(&self) -> Duration;

    /// Processor time of the thread that asks, the system's work for it included; time of day where
    /// that is not told.
    fn busy(&self) -> Duration {
        self.now()
    }

    /// Seconds since `start`, an earlier answer of [`Clock::now`].
    fn seconds_since(&self, start: Duration) -> f64 {
        self.now().saturating_sub(start).as_secs_f64()
    }
}

/// What work gives, and the seconds that it takes: in a rayon pool of one thread that thread's
/// processor time, elsewhere time of day, since others may work for it.
pub fn timed<T>(clock: &dyn Clock, work: impl FnOnce() -> T) -> (T, f64) {
    let is_alone = rayon::current_thread_index().is_some() && rayon::current_num_threads() == 1;
    let read = || if is_alone { clock.busy() } else { clock.now() };
    let start = read();
    let made = work();
    let seconds = read().saturating_sub(start).as_secs_f64();
    (made, seconds)
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

    #[cfg(unix)]
    fn busy(&self) -> Duration {
        use rustix::time::{ClockId, clock_gettime};
        let time = clock_gettime(ClockId::ThreadCPUTime);
        let seconds = u64::try_from(time.tv_sec).unwrap_or(0);
        Duration::new(seconds, u32::try_from(time.tv_nsec).unwrap_or(0))
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
    fn waiting_is_not_counted_as_processor_time() {
        let clock = SystemClock::default();
        let sleep = || std::thread::sleep(Duration::from_millis(30));
        let spin = || (0..2_000_000u64).fold(1, |a: u64, b| std::hint::black_box(a ^ b));
        let (_, by_day) = timed(&clock, sleep);
        assert!(by_day >= 0.03, "{by_day}");
        let pool = |threads| crate::system::pools::pool(threads).unwrap();
        let of_two = pool(2).install(|| timed(&clock, sleep).1);
        assert!(of_two >= 0.03, "{of_two}");
        let alone = pool(1).install(|| timed(&clock, sleep).1);
        assert!(alone < 0.02 || cfg!(not(unix)), "{alone}");
        assert!(pool(1).install(|| timed(&clock, spin).1) > 0.0);
        assert_eq!(timed(&SteppingClock::new(Duration::from_millis(5)), || 7), (7, 0.005));
    }

    #[test]
    fn the_system_clock_does_not_go_back() {
        let clock = SystemClock::default();
        let start = clock.now();
        assert!(clock.seconds_since(start) >= 0.0);
    }
}
