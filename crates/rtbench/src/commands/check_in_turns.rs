//! `rtbench check --against`: the older program, or with `--plugin` the older build of the plugin,
//! measured in turns with the newer.

use std::path::{Path, PathBuf};

use crate::baselines::Baseline;
use crate::commands::baseline::counted;
use crate::commands::check::{Check, confirmed};
use crate::commands::measuring::PlanResults;
use crate::comparison::pairing::Pairing;
use crate::context::Context;
use crate::error::Error;
use crate::gate::against::TurnPlan;
use crate::gate::against::{Contest, Program};
use crate::gate::contest::PairedTimes;
use crate::gate::report::Report;
use crate::gate::{Evidence, Instructions, Times, refuse, wall_clock};
use crate::replan::{self, ReplanError};
use measurement::callgrind;
use measurement::plan::{Plan, Rounds};
use measurement::system::progress::Progress;

impl Check<'_> {
    /// Measures the programs in turns and judges the newer one.
    pub(super) fn in_turns(
        &self,
        context: &mut Context<'_>,
        baseline: Option<&Baseline>,
    ) -> Result<Report, Error> {
        let args = self.args;
        let plan = self.plan_of_turns(context, baseline)?;
        let PlanResults { record: now, failures, .. } = self.measured(context, &plan)?;
        if now.scenes.is_empty() {
            return Err(ReplanError::NothingMeasured.into());
        }
        let own = context.own_program()?;
        let copied = context.environment.copy_of(&own.path)?;
        context.say(format_args!("measuring once with {}", args.against_in_words()));
        let allow_outside = context.scenes.allows_outside();
        let pace = TurnPlan {
            rounds: args.rounds,
            time_budget: args.time_budget,
            seed: now.settings.seed,
        };
        let mut contest = Contest {
            programs: self.programs(own, copied.path()),
            like: now.clone(),
            pace,
            matches: self.matches.clone(),
            thresholds: self.thresholds.clone(),
        };
        let base = contest.record_of_old()?;
        refuse(&base, &now)?;
        let missing = Pairing::of(&base, &now).missing();
        if Pairing::of(&base, &now).rows().next().is_none() {
            return Err(Error::NothingCompared(missing));
        }
        contest.keep_common(&base);
        let counts = if self.wants_counts {
            let common = &contest.like;
            let base =
                callgrind::count(args.older_binary().map(PathBuf::as_path), common, allow_outside)?;
            Some((base, counted(context, common)?))
        } else {
            None
        };
        let instructions = match &counts {
            Some((base, now)) => Instructions::Counted { base: &base.rows, now: &now.rows },
            None => Instructions::NotAsked,
        };
        contest.thin();
        let (thresholds, looks) = (&self.thresholds, pace.max_looks());
        let times = Times::Paired { pairs: &[], looks };
        let untimed = Evidence { thresholds, base: &base, now: &now, instructions, times };
        let raced = |context: &Context<'_>, contest: &Contest| {
            let steps = u64::from(pace.expected());
            let progress = Progress::new(context.shows_progress(), steps, pace.time_budget);
            let open = |pairs: &[PairedTimes]| {
                let times = Times::Paired { pairs, looks };
                wall_clock::undecided(&Evidence { times, ..untimed })
            };
            let pairs = contest.times(context.clock, &progress, &open);
            progress.finish();
            pairs
        };
        let pairs = raced(context, &contest)?;
        let evidence = Evidence { times: Times::Paired { pairs: &pairs, looks }, ..untimed };
        let findings = confirmed(context, &evidence, |context, suspects| {
            contest.like.scenes.retain(|s| suspects.contains(&s.name));
            let again = raced(context, &contest)?;
            let times = Times::Paired { pairs: &again, looks };
            Ok((wall_clock::STAGE.judge)(&Evidence { times, ..untimed }))
        })?;
        Ok(self.report(context, &evidence, findings, missing, failures.len()))
    }

    /// One round of the rows of the baseline, or of those that were named.
    fn plan_of_turns<'c>(
        &self,
        context: &Context<'c>,
        baseline: Option<&Baseline>,
    ) -> Result<Plan<'c>, Error> {
        let mut plan = match baseline {
            Some(baseline) => {
                let like = self.restricted(&baseline.record)?;
                let like = replan::restrict_to_known_rows(&like, context);
                replan::plan(&like, None, None, context)?
            }
            None => {
                let mut settings = self.args.settings();
                context.plugins.add_rows(&mut settings.structures);
                Plan::of_run(&settings, context.registry, context.occluders, context.scenes)?
            }
        };
        plan.limits.render_pass = 0.0;
        plan.rounds = Rounds::Fixed(1);
        plan.is_untimed = true;
        Ok(plan)
    }

    /// The older program, the newer one, and a copy of the newer one.
    fn programs(&self, own: Program, copy: &Path) -> [Program; 3] {
        let args = self.args;
        let (path, plugins) = match args.older_binary() {
            Some(binary) => (binary.clone(), Vec::new()),
            None => (own.path.clone(), args.plugins.arguments_for(&args.against)),
        };
        let old = Program { path, plugins, ..own };
        let copy = Program { path: copy.to_owned(), ..own.clone() };
        [old, own, copy]
    }
}
