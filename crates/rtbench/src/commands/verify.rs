//! `rtbench verify`: the hard cases against every structure.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicUsize;

use crate::args::VerifyArgs;
use crate::context::Context;
use crate::error::{Error, INCONCLUSIVE, INTERRUPTED, SUCCESS, WRONG_HITS};
use crate::outputs::refuse_files;
use measurement::plan::error::PlanError;
use measurement::rounds::MeasureError;
use measurement::system::files::{CreatedFiles, write_text};
use measurement::system::interrupt;
use measurement::system::machine;
use measurement::system::pools::deep_pool;
use measurement::system::progress::Progress;
use presentation::outside::line;
use studies::verify::catalogue::{Case, select};
use studies::verify::check::{CheckPlan, CheckWatch, PRECISIONS};
use studies::verify::replay::{Replay, ReplayOutcome};
use studies::verify::report::{Report, StopReason};
use studies::verify::shrink::shrink;
use studies::verify::subject::Subject;

/// The files of `-o`.
const NAMES: [&str; 2] = ["verify.json", "verify.csv"];

/// Verifies, or repeats one trial, and returns the exit code: for wrong hits 4, though a signal's
/// comes first; out of time without any, 5.
pub fn run(context: &mut Context<'_>, args: &VerifyArgs) -> Result<u8, Error> {
    if let Some(line) = &args.replay {
        return repeat(context, args, &Replay::parse(line)?);
    }
    let mut structures = args.structures.clone();
    context.plugins.add_rows(&mut structures);
    let plan = CheckPlan {
        cases: select(&args.cases)?,
        registry: context.registry,
        subjects: Subject::all(context.registry, &structures, args.also_tested)?,
        rays: args.rays as usize,
        seed: args.seed,
    };
    // before the files are there: a signal would leave them empty
    let signal = interrupt::flag().map_err(Error::Signals)?;
    let _created = context.created_folder(args.output.as_ref(), &NAMES)?;
    let report = checked(context, args, &plan, signal)?;
    let screen = context.screen();
    screen.write_table(context.out, &report.table())?;
    for example in report.examples() {
        // a command to copy stays in one line
        writeln!(context.out, "{}", line(&example.to_string()))?;
    }
    if let Some(folder) = &args.shrink {
        writeln!(context.out)?;
        let failures = report.lines.iter().filter_map(|line| line.examples.first());
        for example in failures {
            shrink_failure(context, folder, &example.replay)?;
        }
    }
    Ok(match report.cut {
        // as shells count them
        Some(StopReason::Interrupted(signal)) => u8::try_from(128 + signal).unwrap_or(INTERRUPTED),
        _ if report.is_failure() => WRONG_HITS,
        Some(StopReason::OutOfTime) => INCONCLUSIVE,
        None => SUCCESS,
    })
}

/// All cases of the plan, or those until it is cut short. The output files hold what is done after
/// each.
fn checked(
    context: &mut Context<'_>,
    args: &VerifyArgs,
    plan: &CheckPlan<'_>,
    signal: Arc<AtomicUsize>,
) -> Result<Report, Error> {
    let pool = deep_pool(args.threads.map_or_else(machine::threads, usize::from))?;
    let start = context.clock.now();
    let progress = Progress::new(context.shows_progress(), plan.all_rounds(), None);
    let watch = CheckWatch::new(context.clock, args.time_limit, signal, progress);
    let mut report = Report {
        command_line: context.command_line.clone(),
        seed: plan.seed,
        rays: plan.rays,
        rounds: plan.all_rounds(),
        ..Report::default()
    };
    let steps = plan.cases.iter().flat_map(|&listed| PRECISIONS.map(|p| (listed, p)));
    for (listed, precision) in steps {
        report.cut = watch.cut();
        if report.cut.is_some() {
            break;
        }
        let Case { id, summary, .. } = listed.1;
        watch.progress.message(format!("{id} {}: {summary}", precision.name()));
        let (lines, rounds) = pool.install(|| plan.check(listed, precision, &watch))?;
        report.lines.extend(lines);
        report.rounds_asked += rounds;
        report.seconds = context.clock.seconds_since(start);
        save(args, &report)?;
    }
    watch.progress.finish();
    if report.rounds_asked < report.rounds {
        report.cut = watch.cut();
    } else if report.lines.is_empty() {
        let none =
            "none of these cases applies to these structures; leave out -s, or name other cases";
        return Err(PlanError::Invalid(none.into()).into());
    }
    report.seconds = context.clock.seconds_since(start);
    save(args, &report)?;
    Ok(report)
}

fn save(args: &VerifyArgs, report: &Report) -> Result<(), Error> {
    if let Some(folder) = &args.output {
        let [json_name, csv_name] = NAMES.map(|name| folder.join(name));
        write_text(&json_name, &report.to_json()?)?;
        write_text(&csv_name, &report.to_csv()?)?;
    }
    Ok(())
}

/// Reduces a failure, prints it, and writes its files.
fn shrink_failure(context: &mut Context<'_>, folder: &Path, replay: &Replay) -> Result<(), Error> {
    let subject = Subject::parse(context.registry, &replay.subject)?;
    let pool = deep_pool(1)?;
    let Some(shrunk) = pool.install(|| shrink(replay, &subject)) else {
        let text = format!(
            "{replay}: not reduced: it has primitives other than triangles, or only the oracle of \
             its case sees it"
        );
        context.plain_screen().write_line(context.out, &text)?;
        return Ok(());
    };
    writeln!(context.out, "{}", shrunk.text())?;
    let mut created = CreatedFiles::default();
    created.folder(folder)?;
    created.keep();
    let path = |ending: &str| folder.join(format!("{}.{ending}", shrunk.name()));
    let files = shrunk.files();
    if !context.overwrite {
        refuse_files(files.iter().map(|(ending, _)| path(ending)))?;
    }
    for (ending, text) in files {
        write_text(&path(ending), &text)?;
        writeln!(context.out, "  {}", line(&path(ending).display().to_string()))?;
    }
    Ok(())
}

/// Repeats one trial and says what comes of it.
fn repeat(context: &mut Context<'_>, args: &VerifyArgs, line: &Replay) -> Result<u8, Error> {
    let case = line.round.case;
    let subject = Subject::parse(context.registry, &line.subject)?;
    let scene = || format!("{} round {}", case.id, line.round.number);
    let ReplayOutcome { question, wrong, refused } = line
        .repeat(&subject)
        .map_err(|source| MeasureError::Build { scene: scene(), source })?
        .ok_or_else(|| PlanError::Malformed {
            text: line.to_string(),
            expected: "a round with that many rays",
        })?;
    let screen = context.plain_screen();
    let out = &mut *context.out;
    screen.write_line(out, &format!("{}: {} (oracle: {})", case.id, case.summary, case.oracle))?;
    screen.write_line(out, &question)?;
    let verdict = refused.map(|why| format!("refused: {why}")).or_else(|| wrong.clone());
    let verdict = verdict.as_deref().unwrap_or("right");
    screen.write_line(out, &format!("{}: {verdict}", subject.label()))?;
    if let (Some(folder), Some(_)) = (&args.shrink, &wrong) {
        shrink_failure(context, folder, line)?;
    }
    let is_failure = wrong.is_some() && subject.known_defect().is_none();
    Ok(if is_failure { WRONG_HITS } else { SUCCESS })
}
