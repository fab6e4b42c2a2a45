//! `rtbench check` and `rtbench baseline`.

mod baselines;
mod gating;
mod judging;
mod planted;
mod valgrind;

use std::path::PathBuf;
use std::time::Duration;

use crate::common::{Ended, PLANTED};
use accel_core::structures::Entry;
use measurement::scenes::InstalledScenes;
use measurement::system::clock::{Clock, SteppingClock};
use rtbench::context::{Context, Environment};

/// A run over that registry in that environment, each interval of time a millisecond.
fn run_in(registry: &[Entry], environment: Environment, arguments: &str) -> Ended {
    run_timed(registry, environment, &SteppingClock::new(Duration::from_millis(1)), arguments)
}

pub(crate) fn run_timed(
    registry: &[Entry],
    environment: Environment,
    clock: &dyn Clock,
    arguments: &str,
) -> Ended {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let words = || std::iter::once("rtbench").chain(arguments.split_whitespace());
    let world = rtbench::program::world();
    let mut context = Context {
        command_line: words().map(str::to_owned).collect(),
        environment,
        ..Context::new(registry, &InstalledScenes, clock, &world, &mut out, &mut err)
    };
    let code = rtbench::run(&mut context, words());
    let text = |bytes| String::from_utf8(bytes).unwrap();
    Ended { code, out: text(out), err: text(err) }
}

/// The program itself, its baselines in that folder.
pub(crate) fn with_program(folder: &str) -> Environment {
    Environment { program: Some(PathBuf::from(env!("CARGO_BIN_EXE_rtbench"))), ..in_folder(folder) }
}

/// Baselines in that folder.
fn in_folder(folder: &str) -> Environment {
    Environment { baselines: Some(PathBuf::from(folder)), ..Environment::default() }
}

/// Keeps a baseline of a small run there.
fn saved(folder: &str, name: &str) {
    let arguments =
        format!("baseline save {name} tetra:2 --quick --size 16 -s uniform-grid,obvhs-cwbvh");
    let ended = run_in(&PLANTED, in_folder(folder), &arguments);
    assert_eq!((ended.code, ended.out.as_str()), (0, ""), "{}", ended.err);
}
