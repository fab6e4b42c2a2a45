//! `rtbench check`: measure anew, judge, print; the exit code is the verdict. What a baseline is
//! compared with is here; programs that take turns are in `check_in_turns.rs`.

use std::fs::OpenOptions;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use crate::args::{CheckArgs, ExportArgs, names_structures};
use crate::baselines::{Baseline, Store};
use crate::commands::baseline::{counted, rounds};
use crate::commands::measuring::{PlanResults, measure_quietly};
use crate::commands::run_outputs;
use crate::comparison::pairing::{MissingRow, Pairing};
use crate::comparison::renamed::{self, Renaming};
use crate::context::Context;
use crate::error::Error;
use crate::gate::report::{Report, annotations, csv, markdown};
use crate::gate::thresholds::{OF_TURNS, Thresholds};
use crate::gate::{Evidence, Finding, Instructions, ROUNDS, Times, judge, refuse, wall_clock};
use crate::outputs::Outputs;
use crate::replan::{self, ReplanError};
use crate::set_options::thresholds_of_check;
use measurement::callgrind::{self, CallgrindError, Counts};
use measurement::plan::Plan;
use measurement::plan::error::PlanError;
use measurement::plan::measured_row::select;
use measurement::record::{RowRecord, RunRecord, SceneRecord, file};
use measurement::system::files::{WriteError, write_text};
use measurement::system::interrupt::undisturbed;
use measurement::system::machine::PressureWatch;
use presentation::json;

/// The files of `-o`, beside those of the run.
pub const NAMES: [&str; 3] = ["check.json", "check.csv", "check.md"];

pub fn run(context: &mut Context<'_>, args: &CheckArgs) -> Result<u8, Error> {
    if args.older_binary().is_some() && args.against.len() > 1 {
        let text = "--against: expected one binary, or --plugin and older builds of it";
        return Err(PlanError::Invalid(text.into()).into());
    }
    let mut default = Thresholds::default();
    if args.takes_turns() {
        default.time = OF_TURNS;
    }
    default.rows = thresholds_of_check(context, args.as_set.as_deref(), &args.scenes)?;
    let thresholds = args.thresholds.over(default)?;
    let matches = matches(context, args)?;
    let baseline = open(context, args, &matches)?;
    let _created = context.created_folder(args.output.as_ref(), &NAMES)?;
    let wants_counts = match &baseline {
        _ if args.results.is_some() => false,
        Some(baseline) if !args.takes_turns() => {
            let has_counts = baseline.instructions.is_some();
            if args.instructions == Some(true) && !has_counts {
                return Err(Error::NoCounts);
            }
            args.instructions.unwrap_or(has_counts)
        }
        _ => args.instructions == Some(true),
    };
    if args.instructions == Some(true) {
        callgrind::version()?;
    }
    context.warn_of_instructions();
    let measures = |_: &&PathBuf| args.results.is_none();
    let kept = args.output.as_ref().filter(measures).cloned();
    let kept = ExportArgs { output: kept, ..ExportArgs::default() };
    run_outputs::refuse_occupied(context, &kept, None)?;
    let check = Check { args, thresholds, wants_counts, matches, kept };
    let report = match (args.takes_turns(), baseline, &args.results) {
        (_, Some(baseline), Some(results)) => check.results(context, &baseline, results)?,
        (true, baseline, _) => check.in_turns(context, baseline.as_ref())?,
        (false, Some(baseline), None) => check.against_baseline(context, &baseline)?,
        (false, None, _) => return Err(ReplanError::Empty.into()),
    };
    let screen = context.screen();
    report.write(context.out, screen, args.all)?;
    if let Some(folder) = &args.output {
        let [json_name, csv_name, markdown_name] = NAMES.map(|name| folder.join(name));
        write_text(&json_name, &json::written(&report)?)?;
        write_text(&csv_name, &csv(&report)?)?;
        write_text(&markdown_name, &markdown(&report, args.all))?;
    }
    tell_github(context, &report)?;
    Ok(report.exit_code(args.strict))
}

/// Rows that have another name now.
fn matches(context: &Context<'_>, args: &CheckArgs) -> Result<Vec<Renaming>, Error> {
    let is_known = |text: &str| {
        let names = [text.to_owned()];
        select(context.registry, context.occluders, &names, &[]).is_ok()
    };
    let matched = args.matches.iter().map(|text| renamed::of_programs(text, &is_known));
    Ok(matched.collect::<Result<_, _>>()?)
}

/// The baseline that was named, with its rows as this program calls them.
fn open(
    context: &Context<'_>,
    args: &CheckArgs,
    matches: &[Renaming],
) -> Result<Option<Baseline>, Error> {
    let Some(name) = &args.baseline else { return Ok(None) };
    let store = Store::new(args.folder.baselines.as_ref(), &context.environment);
    let mut baseline = store.open(name)?;
    matches.iter().for_each(|renamed| renamed.apply(&mut baseline.record));
    Ok(Some(baseline))
}

/// Settings and input of a check.
pub(super) struct Check<'a> {
    pub(super) args: &'a CheckArgs,
    pub(super) thresholds: Thresholds,
    pub(super) wants_counts: bool,
    pub(super) matches: Vec<Renaming>,
    kept: ExportArgs,
}

impl Check<'_> {
    fn against_baseline(
        &self,
        context: &mut Context<'_>,
        baseline: &Baseline,
    ) -> Result<Report, Error> {
        let args = self.args;
        let whole = self.restricted(&baseline.record)?;
        let base = replan::restrict_to_known_rows(&whole, context);
        if base.scenes.is_empty() {
            let none = RunRecord { scenes: Vec::new(), ..base };
            return Err(Error::NothingCompared(Pairing::of(&whole, &none).missing()));
        }
        let of_base = u32::try_from(rounds(&base)).unwrap_or(u32::MAX).max(ROUNDS);
        let asked = args.rounds.or(args.time_budget.is_none().then_some(of_base));
        let mut plan = replan::plan(&base, asked, args.time_budget, context)?;
        plan.limits.render_pass = 0.0;
        plan.has_copy = true;
        let few = asked.and_then(|asked| {
            wall_clock::too_few_rounds(&self.thresholds, &base, [rounds(&base), asked as usize])
        });
        few.into_iter().for_each(|warning| context.warn(warning));
        let watch = PressureWatch::begin(context.environment.cpu_pressure.as_deref());
        let PlanResults { record: now, failures, .. } = self.measured(context, &plan)?;
        let cpu_pressure = [watch.share(), baseline.cpu_pressure].into_iter().flatten();
        let times = self.in_run(cpu_pressure.max_by(f64::total_cmp));
        refuse(&base, &now)?;
        let counts = if self.wants_counts { Some(self.counts(context, &base)?) } else { None };
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
            let again = measure_quietly(context, &plan, Outputs::default())?.record;
            Ok((wall_clock::STAGE.judge)(&Evidence { now: &again, ..first }))
        })?;
        let mut missing = Pairing::of(&whole, &now).missing();
        missing.extend(self.new_rows(context, &baseline.record));
        Ok(self.report(context, &first, findings, missing, failures.len()))
    }

    /// Two records that are there: nothing is measured.
    fn results(
        &self,
        context: &Context<'_>,
        baseline: &Baseline,
        results: &Path,
    ) -> Result<Report, Error> {
        let base = self.restricted(&baseline.record)?;
        let now = self.restricted(&file::read(results)?)?;
        refuse(&base, &now)?;
        let (thresholds, instructions) = (&self.thresholds, Instructions::NotAsked);
        let times = self.in_run(baseline.cpu_pressure);
        let evidence = Evidence { thresholds, base: &base, now: &now, instructions, times };
        let missing = Pairing::of(&base, &now).missing();
        let left = now.planned.len().saturating_sub(now.scenes.len());
        let failures = if now.complete { 0 } else { left };
        Ok(self.report(context, &evidence, judge(&evidence), missing, failures))
    }

    fn in_run(&self, cpu_pressure: Option<f64>) -> Times<'static> {
        Times::InRun { cpu_pressure, across_processors: self.args.across_processors }
    }

    /// Measures a plan, and keeps it where that is asked for.
    pub(super) fn measured(
        &self,
        context: &mut Context<'_>,
        plan: &Plan<'_>,
    ) -> Result<PlanResults, Error> {
        measure_quietly(context, plan, run_outputs::of_run(&self.kept)?)
    }

    /// Rows that a run without `-s` has now, where the baseline was one and lacks them.
    fn new_rows(&self, context: &Context<'_>, base: &RunRecord) -> Vec<MissingRow> {
        let is_restricted =
            !self.args.structures.is_empty() || names_structures(&base.command_line);
        let rows = select(context.registry, context.occluders, &[], &[]);
        let Some((rows, _)) = rows.ok().filter(|_| !is_restricted) else { return Vec::new() };
        let labels: Vec<String> = rows.iter().map(|row| row.label()).collect();
        let is_wanted =
            |name: &String| self.args.scenes.is_empty() || self.args.scenes.contains(name);
        let scenes = base.scenes.iter().filter(|scene| is_wanted(&scene.name));
        let of_scene = |scene: &SceneRecord| {
            let known: Vec<String> = scene.rows.iter().map(RowRecord::label).collect();
            let new = labels.iter().filter(|label| !known.contains(label)).cloned();
            let name = scene.name.clone();
            new.map(|row| MissingRow { scene: name.clone(), row, is_new: true }).collect::<Vec<_>>()
        };
        scenes.flat_map(of_scene).collect()
    }

    /// The scenes and rows of a record that are asked for.
    pub(super) fn restricted(&self, record: &RunRecord) -> Result<RunRecord, ReplanError> {
        replan::restrict(record, &self.args.scenes, &self.args.structures)
    }

    /// Instruction counts now, or why there are none: an error only where they were asked for.
    fn counts(
        &self,
        context: &mut Context<'_>,
        base: &RunRecord,
    ) -> Result<Result<Counts, String>, Error> {
        match counted(context, base) {
            Err(CallgrindError::NoValgrind(why)) if self.args.instructions != Some(true) => Ok(
                Err(format!("the baseline has instruction counts, and valgrind is missing: {why}")),
            ),
            other => Ok(Ok(other?)),
        }
    }

    /// Report of what was judged, without the rows that are allowed to be missing.
    pub(super) fn report(
        &self,
        context: &Context<'_>,
        evidence: &Evidence<'_>,
        findings: Vec<Finding>,
        mut missing: Vec<MissingRow>,
        failures: usize,
    ) -> Report {
        let args = self.args;
        let plugins = if args.takes_turns() { context.plugins.names() } else { vec![] };
        let is_asked = |row: &RowRecord| match &plugins[..] {
            [] => !row.is_reference,
            plugins => plugins.contains(&row.structure),
        };
        let allowed: Vec<String> =
            args.allow_missing.iter().map(|name| name.replace(':', " ")).collect();
        missing.retain(|row| {
            let structure = row.row.split(' ').next().unwrap_or_default();
            !allowed.iter().any(|name| *name == row.row || name == structure)
        });
        Report {
            command_line: context.command_line.clone(),
            against: args.against_in_words(),
            missing,
            failures,
            ..Report::of(evidence, findings, is_asked)
        }
    }
}

/// Findings of all stages; scenes in which times regressed are measured `again` to confirm that.
pub(super) fn confirmed(
    context: &mut Context<'_>,
    first: &Evidence<'_>,
    again: impl FnOnce(&mut Context<'_>, &[String]) -> Result<Vec<Finding>, Error>,
) -> Result<Vec<Finding>, Error> {
    let mut findings = judge(first);
    let suspects = wall_clock::suspects(&findings);
    if !suspects.is_empty() {
        context.say(format_args!("measuring again: {}", suspects.join(", ")));
        wall_clock::confirm(&mut findings, &again(context, &suspects)?);
    }
    Ok(findings)
}

/// Annotations and the job's summary, where there is a GitHub to read them.
fn tell_github(context: &mut Context<'_>, report: &Report) -> Result<(), Error> {
    if context.environment.github_actions {
        context.annotations.replace(annotations(report));
    }
    let Some(path) = &context.environment.github_step_summary else { return Ok(()) };
    let append = || -> io::Result<()> {
        let mut file = OpenOptions::new().create(true).append(true).open(path)?;
        file.write_all(markdown(report, false).as_bytes())
    };
    Ok(undisturbed(append).map_err(|source| WriteError { path: path.clone(), source })?)
}
