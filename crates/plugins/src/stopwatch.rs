//! The time of a call of a plugin.
//!
//! A run of one thread times our structures by that thread's processor time, so that waiting for a processor
//! does not count. A plugin may have threads of its own whatever it was asked for; its time is the
//! processor time of the whole process, in which nothing else has work.

use std::time::Duration;

/// When a call began.
pub struct Stopwatch {
    by_processor: bool,
    start: Duration,
}

impl Stopwatch {
    /// Starts: for one thread by processor time where the system tells it, else by time of day.
    pub fn start(threads: usize) -> Self {
        let by_processor = cfg!(unix) && threads == 1;
        Self { by_processor, start: read(by_processor) }
    }

    /// Seconds since.
    pub fn seconds(&self) -> f64 {
        read(self.by_processor).saturating_sub(self.start).as_secs_f64()
    }
}

#[cfg(unix)]
fn read(by_processor: bool) -> Duration {
    use rustix::time::{ClockId, clock_gettime};
    let clock = if by_processor { ClockId::ProcessCPUTime } else { ClockId::Monotonic };
    let time = clock_gettime(clock);
    Duration::new(u64::try_from(time.tv_sec).unwrap_or(0), u32::try_from(time.tv_nsec).unwrap_or(0))
}

#[cfg(not(unix))]
fn read(_: bool) -> Duration {
    use std::sync::OnceLock;
    use std::time::Instant;
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    BEGIN.get_or_init(Instant::now).elapsed()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_is_no_work_and_threads_are() {
        let sleep = || std::thread::sleep(Duration::from_millis(30));
        let by_day = Stopwatch::start(2);
        sleep();
        assert!(by_day.seconds() >= 0.03);
        let by_processor = Stopwatch::start(1);
        let spin = || (0..3_000_000u64).fold(1, |a: u64, b| std::hint::black_box(a ^ b));
        std::thread::spawn(spin).join().unwrap();
        assert!(by_processor.seconds() > 1e-4, "work of another thread counts");
    }
}
