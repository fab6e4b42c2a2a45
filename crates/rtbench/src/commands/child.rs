//! What `rtbench check` starts as processes of their own: a record on standard input says what to
//! do, the answer goes to standard output as JSON. And what `rtbench sweep --sizes` starts, which needs no
//! record: see `trial_build`. And the process of a plugin's row: see [`plugins::serve`].

use std::io::Read;

use serde::de::DeserializeOwned;

use crate::args::{ChildAction, ChildArgs};
use crate::commands::measuring::measure_scenes;
use crate::commands::{accuracy, trial_build};
use crate::context::Context;
use crate::error::Error;
use crate::exit_code::{FAILURE, SUCCESS};
use crate::exports::outputs::Outputs;
use crate::like::{self, Narrowed};
use measurement::callgrind::counted::count_all;
use measurement::plan::OneProcess;
use measurement::plan::strides::FixedStrides;
use measurement::record::RunRecord;
use measurement::system::memory_layout;
use presentation::format_error::FormatError;

/// Where few answers are checked, one ray in that many of those that would be.
const LIGHTLY: usize = 16;

/// What standard input says.
fn asked<T: DeserializeOwned>() -> Result<T, Error> {
    let mut text = Vec::new();
    std::io::stdin().lock().read_to_end(&mut text)?;
    Ok(serde_json::from_slice(&text).map_err(json)?)
}

fn json(e: serde_json::Error) -> FormatError {
    FormatError { format: "JSON", message: e.to_string() }
}

/// Does what was asked and returns the exit code.
///
/// # Errors
/// [`Error`] for a record that cannot be read or measured.
pub fn run(context: &mut Context<'_>, args: &ChildArgs) -> Result<u8, Error> {
    let record = asked::<RunRecord>;
    let times = matches!(args.action, ChildAction::Measure { .. } | ChildAction::Accuracy);
    // until the answer is made, all else lies elsewhere
    let _held = times.then(memory_layout::draw);
    let (answer, failures) = match &args.action {
        ChildAction::Build(build) => return trial_build::run(context, build).map(|()| SUCCESS),
        ChildAction::Plugin(args) => {
            trial_build::end_with_parent();
            plugins::serve(&args.file, &args.socket)?;
            return Ok(SUCCESS);
        }
        ChildAction::Measure { rounds, lightly, process, first_round } => {
            let record = record()?;
            let wanted = Narrowed { rounds: Some(*rounds), ..Narrowed::default() };
            let mut plan = like::plan(&record, &wanted, context)?;
            // whole images are not compared
            plan.limits.render_pass = 0.0;
            plan.processes = 1;
            plan.process = OneProcess { number: *process, first_round: *first_round as usize };
            if *lightly {
                plan.limits.oracle_tests = 0;
                plan.strides = FixedStrides::of(&record, LIGHTLY);
            }
            let measured =
                measure_scenes(context, &plan, &mut Outputs::default(), |_, _, _| Ok(()))?;
            (serde_json::to_string(&measured.record), measured.failures)
        }
        ChildAction::Accuracy => (serde_json::to_string(&accuracy::times(context, &asked()?)?), 0),
        ChildAction::CountInstructions => {
            let plan = like::plan(&record()?, &Narrowed::default(), context)?;
            (serde_json::to_string(&count_all(&plan)?), 0)
        }
    };
    writeln!(context.out, "{}", answer.map_err(json)?)?;
    context.out.flush()?;
    Ok(if failures == 0 { SUCCESS } else { FAILURE })
}
