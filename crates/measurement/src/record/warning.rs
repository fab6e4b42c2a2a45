//! What makes the figures of a run less certain than they look. Every kind has a threshold,
//! documented where it is defined, that a machine left alone stays below, and ends in advice.

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

/// Largest interquartile range of the reference's times, as a part of their median, that is not
/// noise; of several scenes the one in the middle. Recorded runs of the standard scenes on a
/// virtual machine have 0.05 when it is quiet, 0.16 beside other work.
pub const QUIET_SPREAD: f64 = 0.15;
/// Largest change of the reference's times from the first to the second half of the rounds that is
/// not called drift, and the probability of chance below which it is.
pub const STEADY: (f64, f64) = (0.1, 0.01);
/// Largest part of the machine's processors that others may keep busy.
pub const SPARE: f64 = 0.25;
/// Most bytes of the process that may be in swap, and that all may read back during the run.
pub const SWAP_BYTES: u64 = 1 << 20;

/// Something that makes figures less certain than they look. Printed, it ends in advice.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "testing", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Warning {
    /// The reference's times are spread widely: more than [`QUIET_SPREAD`].
    NoisyMachine {
        /// Their interquartile range, as a part of the median.
        spread: f64,
    },
    /// The intervals rest on fewer than five rounds; not said of a quick run, which is a first
    /// look.
    TooFewRounds {
        /// How many there were.
        rounds: u64,
    },
    /// The reference became slower or faster from the first to the second half of the rounds, by
    /// more than [`STEADY`] allows.
    Drift {
        /// The later times over the earlier ones.
        change: f64,
        /// How the clock is governed, where that is told.
        governor: Option<String>,
    },
    /// Other programs, or other guests of the host, used more than [`SPARE`] of the machine.
    OtherLoad {
        /// Processors they kept busy, on average.
        processors: f64,
        /// Of how many.
        of: u64,
        /// Mean number of runnable processes in the run's last minute.
        load_average: Option<f64>,
    },
    /// Memory was short: more than [`SWAP_BYTES`] of the process in swap, or read back from it.
    Swap {
        /// Bytes of the process in swap at the end.
        own_bytes: u64,
        /// Bytes that all programs read back during the run.
        read_bytes: u64,
    },
    /// In some scenes the reference was not built, or is wrong, and ratios are to another row. One
    /// scene is enough.
    OtherReference {
        /// The reference of the run.
        reference: String,
        /// The row in its place, by scene.
        instead: BTreeMap<String, String>,
    },
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NoisyMachine { spread } => write!(
                f,
                "noisy machine: the reference's times vary by {:.0}% of their median; trust \
                 ratios and their intervals, not seconds, or end other programs and add --rounds",
                100.0 * spread
            ),
            Self::TooFewRounds { rounds } => {
                // the least and the largest of n samples are on one side of the median in two of
                // 2^n cases
                let held = 1.0 - 2.0 * 0.5f64.powf(*rounds as f64);
                write!(
                    f,
                    "too few rounds: the range of {rounds} holds the median in {:.0}% of all cases; \
                     use --rounds 6 or more, or --time-budget",
                    100.0 * held
                )
            }
            Self::Drift { change, governor } => {
                let how = if *change > 1.0 { "slower" } else { "faster" };
                let by = change.max(1.0 / change) - 1.0;
                let governed = governor.as_ref().map(|g| format!(" (governor: {g})"));
                write!(
                    f,
                    "drift: the reference became {:.0}% {how} from the first to the second half of \
                     the rounds, as when the clock frequency changes{}; fix the frequency, let \
                     the machine cool, or trust ratios alone",
                    100.0 * by,
                    governed.unwrap_or_default()
                )
            }
            Self::OtherLoad { processors, of, load_average } => {
                let average = load_average.map(|l| format!(" (load average {l:.2})"));
                write!(
                    f,
                    "other load: other programs or guests kept {processors:.1} of {of} processors \
                     busy{}; end them, or measure again later",
                    average.unwrap_or_default()
                )
            }
            Self::Swap { own_bytes, read_bytes } => write!(
                f,
                "swap: {} MiB of this process are swapped out, {} MiB were read back during the \
                 run; end other programs, or measure smaller scenes",
                own_bytes >> 20,
                read_bytes >> 20
            ),
            Self::OtherReference { reference, instead } => {
                let each: Vec<String> =
                    instead.iter().map(|(scene, row)| format!("{row} in {scene}")).collect();
                write!(
                    f,
                    "other reference: {reference} was not built or is wrong, so ratios are to {}; \
                     means leave these scenes out; choose a reference that works in every scene \
                     (--reference)",
                    each.join(", ")
                )
            }
        }
    }
}
