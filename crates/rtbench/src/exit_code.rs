//! The exit codes.

pub const SUCCESS: u8 = 0;
pub const FAILURE: u8 = 1;
/// The command line makes no sense.
pub const USAGE: u8 = 2;
/// Something got worse than a baseline.
pub const REGRESSION: u8 = 3;
/// A structure gave wrong hits.
pub const WRONG_HITS: u8 = 4;
/// Something was inconclusive, or a row was missing, and `--strict` was given; or `verify` ran out
/// of time before it had asked everything.
pub const INCONCLUSIVE: u8 = 5;
/// No row was in both, or none that `check` asks about was built.
pub const NOTHING_COMPARED: u8 = 6;
/// SIGINT (Ctrl-C) ended the run; other signals as shells count them, 128 and their number.
pub const INTERRUPTED: u8 = 130;
