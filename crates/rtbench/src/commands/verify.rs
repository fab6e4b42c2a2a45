//! `rtbench verify`: the hard cases against every structure.

use crate::args::{Color, VerifyArgs};
use crate::context::Context;
use crate::error::{Error, SUCCESS, WRONG_HITS};
use crate::export::files::{create, write_file};
use crate::export::text::write_table;
use crate::machine;
use crate::plan::PlanError;
use crate::pools::deep_pool;
use crate::progress::Progress;
use crate::verify::check::{PRECISIONS, Plan, Replayed, replay};
use crate::verify::registry::{find, select};
use crate::verify::replay::Replay;
use crate::verify::report::Report;
use crate::verify::subject::Subject;
use crate::verify::timing;

/// Verifies, or repeats one trial, and returns the exit code.
///
/// # Errors
/// [`Error`] for what is asked and not there, and for outputs that cannot be written.
pub fn run(context: &mut Context<'_>, args: &VerifyArgs, color: Color) -> Result<u8, Error> {
    if let Some(line) = &args.replay {
        return repeat(context, &Replay::parse(line)?);
    }
    let plan = Plan {
        cases: select(&args.cases)?,
        registry: context.registry,
        subjects: Subject::all(context.registry, &args.structures)?,
        rays: args.rays as usize,
        seed: args.seed,
    };
    let _created = create([&args.export_csv, &args.export_json])?;
    let report = checked(context, args, &plan)?;
    write_file(args.export_csv.as_deref(), || report.to_csv())?;
    write_file(args.export_json.as_deref(), || report.to_json())?;
    let colors = context.terminal.colors(color);
    write_table(context.out, &report.table(), colors)?;
    for example in report.examples() {
        writeln!(context.out, "{example}")?;
    }
    if args.timing {
        writeln!(context.out)?;
        write_table(context.out, &timing::table(&report.timing), colors)?;
    }
    context.out.flush()?;
    Ok(if report.is_failure() { WRONG_HITS } else { SUCCESS })
}

/// All cases of the plan.
fn checked(context: &mut Context<'_>, args: &VerifyArgs, plan: &Plan<'_>) -> Result<Report, Error> {
    let pool = deep_pool(args.threads.map_or_else(machine::threads, usize::from))?;
    let steps = plan.cases.len() * PRECISIONS.len();
    let progress = Progress::new(context.shows_progress(), steps as u64, None);
    let start = context.clock.now();
    let command_line = context.command_line.clone();
    let mut report = Report { command_line, seed: plan.seed, rays: plan.rays, ..Report::default() };
    for &listed in &plan.cases {
        progress.message(format!("{}: {}", listed.1.id, listed.1.summary));
        for precision in PRECISIONS {
            report.lines.extend(pool.install(|| plan.check(listed, precision))?);
            progress.step(context.clock.now());
        }
    }
    progress.finish();
    if report.lines.is_empty() {
        return Err(PlanError::NothingAsked.into());
    }
    if args.timing {
        report.timing = timing::timed(&plan.subjects, context.clock, plan.seed)?;
    }
    report.seconds = context.clock.seconds_since(start);
    Ok(report)
}

/// Repeats one trial and says what comes of it.
fn repeat(context: &mut Context<'_>, line: &Replay) -> Result<u8, Error> {
    let (_, case) = find(&line.case)?;
    let subject = Subject::parse(context.registry, &line.subject)?;
    let scene = || format!("{} round {}", case.id, line.round);
    let Replayed { question, wrong, refused } = replay(case, line, &subject)
        .map_err(|source| Error::Build { scene: scene(), source })?
        .ok_or_else(|| PlanError::Malformed {
            text: line.to_string(),
            expected: "a round that has so many rays",
        })?;
    let out = &mut *context.out;
    writeln!(out, "{}: {} (oracle: {})", case.id, case.summary, case.oracle)?;
    if let Some(question) = question {
        writeln!(out, "{question}")?;
    }
    let verdict = refused.map(|why| format!("refused: {why}")).or_else(|| wrong.clone());
    writeln!(out, "{}: {}", subject.label(), verdict.as_deref().unwrap_or("right"))?;
    out.flush()?;
    let is_failure = wrong.is_some() && subject.known_defect().is_none();
    Ok(if is_failure { WRONG_HITS } else { SUCCESS })
}
