//! The time of a call of a plugin.
//!
//! A run of one thread times our structures by that thread's processor time, so that waiting for a
//! processor does not count. A plugin may have threads of its own whatever it was asked for; its
//! time is the processor time of the whole process, in which nothing else has work. What threads
//! other than the one that called had of it is kept apart: threads that only wait for work, and
//! spin, make a library look slow. A device is no processor of ours: where it computes, time is the
//! time of day.

use std::ops::AddAssign;
use std::time::Duration;

use serde::{Deserialize, Serialize};

#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct CallTime {
    pub seconds: f64,
    /// Seconds used by threads other than the caller; 0 if unknown.
    pub by_others: f64,
}

impl AddAssign for CallTime {
    fn add_assign(&mut self, other: Self) {
        self.seconds += other.seconds;
        self.by_others += other.by_others;
    }
}

/// When a call began.
pub struct Stopwatch {
    by_processor: bool,
    start: Duration,
    own: Duration,
}

impl Stopwatch {
    /// Starts: by processor time if asked to, and where the system tells it; else by time of day.
    pub fn start(by_processor: bool) -> Self {
        let by_processor = cfg!(unix) && by_processor;
        let [start, own] = read(by_processor);
        Self { by_processor, start, own }
    }

    /// Time since the start; must be called by the thread that started it.
    pub fn took(&self) -> CallTime {
        let [now, own] = read(self.by_processor);
        let seconds = now.saturating_sub(self.start).as_secs_f64();
        let by_others = if self.by_processor {
            (seconds - own.saturating_sub(self.own).as_secs_f64()).max(0.0)
        } else {
            0.0
        };
        CallTime { seconds, by_others }
    }
}

/// Processor time of the process, and of the thread; or the time of day.
#[cfg(unix)]
fn read(by_processor: bool) -> [Duration; 2] {
    use rustix::time::{ClockId, clock_gettime};
    let clocks = if by_processor {
        [ClockId::ProcessCPUTime, ClockId::ThreadCPUTime]
    } else {
        [ClockId::Monotonic; 2]
    };
    clocks.map(|clock| {
        let time = clock_gettime(clock);
        let nanoseconds = u32::try_from(time.tv_nsec).unwrap_or(0);
        Duration::new(u64::try_from(time.tv_sec).unwrap_or(0), nanoseconds)
    })
}

#[cfg(not(unix))]
fn read(_: bool) -> [Duration; 2] {
    use std::sync::OnceLock;
    use std::time::Instant;
    static BEGIN: OnceLock<Instant> = OnceLock::new();
    [BEGIN.get_or_init(Instant::now).elapsed(); 2]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waiting_is_not_counted_and_other_threads_are() {
        let sleep = || std::thread::sleep(Duration::from_millis(30));
        let by_day = Stopwatch::start(false);
        sleep();
        let took = by_day.took();
        assert!(took.seconds >= 0.03 && took.by_others == 0.0, "{took:?}");
        let spin = || (0..3_000_000u64).fold(1, |a: u64, b| std::hint::black_box(a ^ b));
        let by_processor = Stopwatch::start(true);
        std::thread::spawn(spin).join().unwrap();
        let took = by_processor.took();
        assert!(took.seconds > 1e-4, "work of another thread counts");
        assert!(took.by_others > 0.5 * took.seconds, "{took:?}");
    }
}
