//! `rtbench check`: measure anew, judge, print; the exit code is the verdict.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::Path;

use crate::args::{CheckArgs, Color};
use crate::baselines::{Baseline, Store};
use crate::commands::baseline::{counted, rounds};
use crate::commands::measuring::{measure_scenes, warn_of};
use crate::context::Context;
use crate::error::Error;
use crate::exports::outputs::{Outputs, write_file};
use crate::gate::against::{Contest, own_program};
use crate::gate::command::Commands;
use crate::gate::contest::{self, Pace, PairedTimes};
use crate::gate::report::{FIRST, GLOSSARY, Report};
use crate::gate::thresholds::Thresholds;
use crate::gate::{
    Evidence, Finding, GateError, Instructions, ROUNDS, Times, annotations, comparable, export,
    judge, wall_clock,
};
use crate::like::{self, LikeError, Narrowed};
use measurement::callgrind::{self, CallgrindError, Counts};
use measurement::plan::{Plan, Rounds};
use measurement::record::{RunRecord, Verdict, reference};
use measurement::system::created::create;
use measurement::system::files::WriteError;
use measurement::system::interrupt::undisturbed;
use measurement::system::pressure::Watch;
use measurement::system::progress::Progress;
use presentation::json;
use presentation::outside::line;

/// Checks and returns the exit code.
///
/// # Errors
/// [`Error`] for what cannot be measured or compared.
pub fn run(
    context: &mut Context<'_>,
    args: &CheckArgs,
    configured: Thresholds,
    color: Color,
) -> Result<u8, Error> {
    let thresholds = args.thresholds.over(configured).checked().map_err(GateError::from)?;
    let baseline = open(context, args)?;
    let exports = [&args.export_csv, &args.export_markdown, &args.export_json];
    let _created = create(exports)?;
    let wants_counts = match &baseline {
        _ if args.no_instructions => false,
        Some(baseline) if args.instructions && args.against.is_none() => {
            baseline.instructions.as_ref().ok_or(GateError::NoCounts)?;
            true
        }
        Some(baseline) if args.against.is_none() => baseline.instructions.is_some(),
        _ => args.instructions,
    };
    if args.instructions {
        callgrind::version().map_err(GateError::from)?;
    }
    context.warn_of_instructions();
    let check = Check { args, thresholds, wants_counts };
    let report = match (&args.against, baseline) {
        (Some(old), _) if !args.arguments.is_empty() => check.commands(context, old)?,
        (Some(old), baseline) => check.against_binary(context, old, baseline.as_ref())?,
        (None, Some(baseline)) => check.against_baseline(context, &baseline)?,
        (None, None) => return Err(GateError::from(LikeError::Empty).into()),
    };
    let screen = context.terminal.screen(color);
    for table in report.tables(args.all) {
        if table.rows.is_empty() {
            screen.write_line(context.out, &table.title)?;
            screen.write_line(context.out, &table.notes.join(" "))?;
            writeln!(context.out)?;
        } else {
            screen.write_fitted(context.out, &table, &FIRST)?;
        }
    }
    for remark in &report.remarks {
        screen.write_line(context.out, remark)?;
    }
    screen.write_notes(context.out, GLOSSARY)?;
    for improvement in report.improvements() {
        screen.write_line(context.out, &improvement)?;
    }
    // a script reads the last line
    writeln!(context.out, "{}", line(&report.verdict()))?;
    context.out.flush()?;
    write_file(args.export_csv.as_deref(), || export::csv(&report))?;
    write_file(args.export_markdown.as_deref(), || Ok(export::markdown(&report, args.all)))?;
    write_file(args.export_json.as_deref(), || json::written(&report))?;
    tell_github(context, &report)?;
    Ok(report.exit_code(args.strict))
}

/// The baseline that was named.
fn open(context: &Context<'_>, args: &CheckArgs) -> Result<Option<Baseline>, Error> {
    let Some(name) = &args.baseline else { return Ok(None) };
    let store = Store::new(args.folder.baselines.as_ref(), &context.environment);
    Ok(Some(store.open(name).map_err(GateError::from)?))
}

/// What a check goes by.
struct Check<'a> {
    args: &'a CheckArgs,
    thresholds: Thresholds,
    wants_counts: bool,
}

/// What was found, before it is a report.
struct Found<'a> {
    base: &'a RunRecord,
    now: &'a RunRecord,
    against: String,
    findings: Vec<Finding>,
    failures: usize,
    pairs: Vec<PairedTimes>,
}

impl Check<'_> {
    fn against_baseline(
        &self,
        context: &mut Context<'_>,
        baseline: &Baseline,
    ) -> Result<Report, Error> {
        let args = self.args;
        let base = like::narrowed(&baseline.record, &self.narrowed()).map_err(GateError::from)?;
        let of_base = u32::try_from(rounds(&base)).unwrap_or(u32::MAX).max(ROUNDS);
        let wanted = Narrowed {
            rounds: args.rounds.or(args.time_budget.is_none().then_some(of_base)),
            time_budget: args.time_budget,
            ..Narrowed::default()
        };
        let mut plan = like::plan(&base, &wanted, context)?;
        plan.limits.render_pass = 0.0;
        plan.has_copy = true;
        let watch = Watch::begin(context.environment.cpu_pressure.as_deref());
        let (now, failures) = measured(context, &plan)?;
        let cpu_pressure = [watch.share(), baseline.cpu_pressure].into_iter().flatten();
        let times = Times::InRun { cpu_pressure: cpu_pressure.max_by(f64::total_cmp) };
        refuse(&base, &now)?;
        let counts = match self.wants_counts {
            true => Some(self.counts(context, &base)?),
            false => None,
        };
        let of_base = baseline.instructions.as_ref().map(|c| &c.rows[..]);
        let instructions = match (&counts, of_base) {
            (Some(Ok(counts)), Some(base)) => Instructions::Counted { base, now: &counts.rows },
            (Some(Err(why)), _) => Instructions::Missing(why),
            _ => Instructions::NotAsked,
        };
        let thresholds = &self.thresholds;
        let first = Evidence { thresholds, base: &base, now: &now, instructions, times };
        let findings = confirmed(context, &first, |context, suspects| {
            plan.scenes.retain(|s| suspects.iter().any(|suspect| *suspect == s.name()));
            plan.has_copy = false;
            let (again, _) = measured(context, &plan)?;
            Ok((wall_clock::STAGE.judge)(&Evidence { now: &again, ..first }))
        })?;
        let against = format!("baseline {}", args.baseline.as_deref().unwrap_or_default());
        let pairs = Vec::new();
        Ok(self
            .report(context, Found { base: &base, now: &now, against, findings, failures, pairs }))
    }

    fn against_binary(
        &self,
        context: &mut Context<'_>,
        old: &Path,
        baseline: Option<&Baseline>,
    ) -> Result<Report, Error> {
        let args = self.args;
        let mut plan = match baseline {
            Some(baseline) => {
                let like = like::narrowed(&baseline.record, &self.narrowed());
                like::plan(&like.map_err(GateError::from)?, &Narrowed::default(), context)?
            }
            None => {
                Plan::of_run(&args.settings(), context.registry, context.occluders, context.scenes)?
            }
        };
        plan.limits.render_pass = 0.0;
        plan.rounds = Rounds::Fixed(1);
        let (now, failures) = measured(context, &plan)?;
        if now.scenes.is_empty() {
            return Err(GateError::from(LikeError::NothingMeasured).into());
        }
        let program = context.environment.program.clone();
        let new = own_program(program.as_ref()).map_err(GateError::from)?;
        let copied = context.environment.copy_of(new)?;
        let (copy, pace) = (copied.path(), self.pace(now.settings.seed));
        let (like, allow_outside) = (now.clone(), context.scenes.allows_outside());
        let mut contest = Contest { old, new, copy, like, pace, allow_outside };
        context.say(format_args!("measuring once with {}", old.display()));
        let base = contest.record_of_old().map_err(GateError::from)?;
        refuse(&base, &now)?;
        let counts = match self.wants_counts {
            true => {
                let base =
                    callgrind::count(Some(old), &now, allow_outside).map_err(GateError::from)?;
                Some((base, counted(context, &now).map_err(GateError::from)?))
            }
            false => None,
        };
        let instructions = match &counts {
            Some((base, now)) => Instructions::Counted { base: &base.rows, now: &now.rows },
            None => Instructions::NotAsked,
        };
        let pairs = raced(context, &pace, |progress| {
            contest.times(context.clock, progress).map_err(GateError::from)
        })?;
        let thresholds = &self.thresholds;
        let times = Times::Paired(&pairs);
        let first = Evidence { thresholds, base: &base, now: &now, instructions, times };
        let findings = confirmed(context, &first, |context, suspects| {
            contest.like.scenes.retain(|s| suspects.contains(&s.name));
            let times = raced(context, &pace, |progress| {
                contest.times(context.clock, progress).map_err(GateError::from)
            })?;
            Ok((wall_clock::STAGE.judge)(&Evidence { times: Times::Paired(&times), ..first }))
        })?;
        let against = format!("binary {}", old.display());
        Ok(self
            .report(context, Found { base: &base, now: &now, against, findings, failures, pairs }))
    }

    /// Two programs that print times; nothing is asked of them but these.
    fn commands(&self, context: &mut Context<'_>, old: &Path) -> Result<Report, Error> {
        let args = self.args;
        let program = args.new.as_ref().or(context.environment.program.as_ref()).cloned();
        let new = own_program(program.as_ref()).map_err(GateError::from)?;
        let copied = context.environment.copy_of(new)?;
        let seed = args.measuring.seed.unwrap_or(1);
        let pace = self.pace(seed);
        let commands = Commands { old, new, copy: copied.path(), arguments: &args.arguments, pace };
        let raced = |context: &Context<'_>| {
            raced(context, &pace, |progress| {
                commands.times(context.clock, progress).map_err(GateError::from)
            })
        };
        let pairs = raced(context)?;
        let judged = |pairs: &[PairedTimes]| wall_clock::judge_times(pairs, &self.thresholds, seed);
        let mut findings = judged(&pairs);
        if findings.iter().any(wall_clock::is_suspect) {
            context.say("measuring again");
            wall_clock::confirm(&mut findings, &judged(&raced(context)?));
        }
        Ok(Report {
            tool: context.world.tool(),
            command_line: context.command_line.clone(),
            against: format!("program {}", old.display()),
            baseline_tool: None,
            baseline_machine: context.world.machine(),
            machine: context.world.machine(),
            thresholds: self.thresholds,
            outcome: Report::worst(&findings),
            remarks: Vec::new(),
            findings,
            times: "seconds".to_owned(),
            failures: 0,
            floor: contest::floor(&pairs),
            pairs,
        })
    }

    fn pace(&self, seed: u64) -> Pace {
        Pace { rounds: self.args.rounds, time_budget: self.args.time_budget, seed }
    }

    fn narrowed(&self) -> Narrowed<'_> {
        let CheckArgs { scenes, structures, .. } = self.args;
        Narrowed { scenes, structures, ..Narrowed::default() }
    }

    /// Instruction counts now, or why there are none: an error only where they were asked for.
    fn counts(
        &self,
        context: &mut Context<'_>,
        base: &RunRecord,
    ) -> Result<Result<Counts, String>, Error> {
        match counted(context, base) {
            Err(CallgrindError::NoValgrind(why)) if !self.args.instructions => Ok(Err(format!(
                "the baseline has instruction counts, and valgrind is missing: {why}"
            ))),
            other => Ok(Ok(other.map_err(GateError::from)?)),
        }
    }

    fn report(&self, context: &Context<'_>, found: Found<'_>) -> Report {
        let Found { base, now, against, findings, failures, pairs } = found;
        let times = match self.args.against {
            Some(_) => "seconds".to_owned(),
            None => format!("ratios to {} in the same rounds", reference::in_words(now)),
        };
        Report {
            tool: now.tool.clone(),
            command_line: context.command_line.clone(),
            against,
            baseline_tool: Some(base.tool.clone()),
            baseline_machine: base.machine.clone(),
            machine: now.machine.clone(),
            thresholds: self.thresholds,
            outcome: Report::worst(&findings),
            remarks: comparable::remarks(base, now),
            findings,
            times,
            failures,
            floor: match pairs.is_empty() {
                true => now.floor.clone(),
                false => contest::floor(&pairs),
            },
            pairs,
        }
    }
}

/// Measures a plan; what goes wrong in a scene is said.
fn measured(context: &mut Context<'_>, plan: &Plan<'_>) -> Result<(RunRecord, usize), Error> {
    let measured = measure_scenes(context, plan, &mut Outputs::default(), |context, _, scene| {
        warn_of(context, scene);
        Ok(())
    })?;
    Ok((measured.record, measured.failures))
}

/// The times of all turns, with a bar.
fn raced(
    context: &Context<'_>,
    pace: &Pace,
    times: impl FnOnce(&Progress) -> Result<Vec<PairedTimes>, GateError>,
) -> Result<Vec<PairedTimes>, Error> {
    let steps = u64::from(pace.expected());
    let progress = Progress::new(context.shows_progress(), steps, pace.time_budget);
    let pairs = times(&progress);
    progress.finish();
    Ok(pairs?)
}

/// What all stages say; scenes in which times regressed are measured `again` before that stands.
fn confirmed(
    context: &mut Context<'_>,
    first: &Evidence<'_>,
    again: impl FnOnce(&mut Context<'_>, &[String]) -> Result<Vec<Finding>, Error>,
) -> Result<Vec<Finding>, Error> {
    let mut findings = judge(first);
    let suspects = suspects(&findings);
    if !suspects.is_empty() {
        context.say(format_args!("measuring again: {}", suspects.join(", ")));
        wall_clock::confirm(&mut findings, &again(context, &suspects)?);
    }
    Ok(findings)
}

/// Scenes in which times say that something regressed.
fn suspects(findings: &[Finding]) -> Vec<String> {
    let mut scenes: Vec<String> = Vec::new();
    for finding in findings.iter().filter(|f| wall_clock::is_suspect(f)) {
        if !scenes.contains(&finding.scene) {
            scenes.push(finding.scene.clone());
        }
    }
    scenes
}

/// Refuses what cannot be compared; wrong hits are said first, whatever the settings.
fn refuse(base: &RunRecord, now: &RunRecord) -> Result<(), GateError> {
    let reasons = comparable::refusals(base, now);
    let is_wrong = now.scenes.iter().flat_map(|s| &s.rows).any(|r| r.verdict == Verdict::Wrong);
    match reasons.is_empty() || is_wrong {
        true => Ok(()),
        false => Err(GateError::NotComparable(reasons)),
    }
}

/// Annotations and the job's summary, where there is a GitHub to read them.
fn tell_github(context: &mut Context<'_>, report: &Report) -> Result<(), Error> {
    if context.environment.github_actions {
        context.annotations = annotations::of(report);
    }
    let Some(path) = &context.environment.github_step_summary else { return Ok(()) };
    let append = || -> io::Result<()> {
        let mut file = OpenOptions::new().create(true).append(true).open(path)?;
        file.write_all(export::markdown(report, false).as_bytes())
    };
    Ok(undisturbed(append).map_err(|source| WriteError { path: path.clone(), source })?)
}
