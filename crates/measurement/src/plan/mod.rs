//! The validated plan of a run: scenes, rows, rays, rounds.
//!
//! A benchmark refuses rather than guesses: a name that is not there is an error that lists the
//! names that are.

pub mod error;
pub mod measured_row;
pub mod part;
pub mod ray_overrides;
pub mod rows;
pub mod strides;

use std::collections::HashSet;
use std::time::Duration;

use accel_core::memory::MemoryLimit;
use accel_core::occluders;
use accel_core::structures::Entry;

use crate::plan::error::{PlanError, chosen};
use crate::plan::measured_row::MeasuredRow;
use crate::plan::rows::Row;
use crate::plan::strides::FixedStrides;
use crate::rays::order::Orders;
use crate::rounds::trial::BuildLimits;
use crate::scenes::{KnownScene, SceneSource, ViewOptions};
use crate::settings::shard::PlannedPart;
use crate::settings::{Lights, MeasuringSettings, Precision, RunSettings, quantity};
use crate::system::machine;
use renderer::{RayKind, RaySettings, ShadowRays};

/// The set that runs when no scene is named.
pub const DEFAULT_SET: &str = "spd";
/// The structure that traces when none is named: it answers all rays right.
pub const DEFAULT_TRACER: &str = "wide-bvh";
/// The reference rows when none is named, best first: structure and settings. The
/// first is a BVH as its authors use it. Its known wrong hits are no reason to take another: brute
/// force judges answers, see [`crate::answers::arbiter`].
const DEFAULT_BASELINES: [(&str, &str); 2] =
    [("obvhs-cwbvh", ""), ("obvhs-cwbvh", "adapter=robust")];
/// The structures that are asked first, as they are fast and serve every scene; see
/// [`crate::answers::reference`].
const ASKED_FIRST: [&str; 2] = ["wide-bvh", "uniform-grid"];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rounds {
    Fixed(usize),
    /// As many as fit in the time, all scenes together, but at least so many.
    Budget {
        total: Duration,
        at_least: usize,
    },
}

impl Rounds {
    pub fn at_least(self) -> usize {
        match self {
            Self::Fixed(n) | Self::Budget { at_least: n, .. } => n,
        }
    }

    pub fn budget(self) -> Option<Duration> {
        match self {
            Self::Fixed(_) => None,
            Self::Budget { total, .. } => Some(total),
        }
    }
}

/// Limits of a pass over the rays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Seconds of a timed pass of a structure that is always sampled.
    pub sampled_pass: f64,
    /// Seconds of a timed pass of any other; slower ones are timed on a sample of the rays.
    pub timed_pass: f64,
    /// Seconds of a pass below which the whole image is rendered too.
    pub render_pass: f64,
    /// Rays times primitives of checking a structure that is always sampled: its counters are of
    /// the same rays on every machine.
    pub sampled_tests: u64,
    /// Seconds (of one thread) of checking any other; slower ones are checked on a sample.
    pub checked_pass: f64,
    /// Rays of a kind that the oracle answers, at most.
    pub oracle_rays: usize,
    /// Intersection tests of the oracle for a scene, at most (but 16 rays per kind at least).
    pub oracle_tests: u64,
}

impl Limits {
    /// Defaults of a full or a quick run.
    pub fn new(quick: bool) -> Self {
        let seconds = |full: f64, first_look: f64| if quick { first_look } else { full };
        let tests = |full: u64, first_look: u64| if quick { first_look } else { full };
        Self {
            sampled_pass: seconds(0.05, 0.01),
            sampled_tests: tests(16_000_000, 4_000_000),
            timed_pass: seconds(0.2, 0.03),
            render_pass: seconds(0.4, 0.03),
            checked_pass: seconds(8.0, 0.3),
            oracle_rays: if quick { 128 } else { 512 },
            oracle_tests: tests(400_000_000, 50_000_000),
        }
    }
}

#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct OneProcess {
    /// Its number, from 0.
    pub number: u32,
    /// Its first round: those of all processes are counted through.
    pub first_round: usize,
}

#[derive(Debug)]
pub struct Plan<'r> {
    /// Scenes, in the order given, without duplicates.
    pub scenes: Vec<Box<dyn KnownScene>>,
    pub rows: Vec<MeasuredRow<'r>>,
    /// Index of the reference row.
    pub baseline: usize,
    /// No other row may take its place in any scene: ratios are joined or compared with those of
    /// others.
    pub keeps_baseline: bool,
    /// All rows are timed on the rays of the slowest: any two of them are to be compared.
    pub same_rays: bool,
    /// Structures that produce the rays and are asked first; see [`crate::answers::reference`].
    pub answers: Vec<Row<'r>>,
    pub kinds: Vec<RayKind>,
    /// In which orders rays are issued to rows.
    pub orders: Orders,
    /// Tables of each kind of ray are wanted, too.
    pub by_kind: bool,
    pub rounds: Rounds,
    pub threads: usize,
    pub seed: u64,
    pub settings: RaySettings,
    pub precision: Precision,
    pub limits: Limits,
    /// A first look only.
    pub quick: bool,
    /// The stride of each row (every k-th ray is issued to it), where an earlier record says so.
    pub strides: FixedStrides,
    pub part: Option<PlannedPart>,
    /// Processes in which each scene is built and timed: this one, and those that it starts.
    pub processes: u32,
    pub process: OneProcess,
    /// Where there is but one: a process of a copy of this program times each scene, too, for the
    /// floor below which nothing is claimed.
    pub has_copy: bool,
    /// Answers and counters alone are wanted: nothing is warned of times.
    pub is_untimed: bool,
    /// Limits of a build; `None` if builds are not tried in a process of their own first.
    pub build_limits: Option<BuildLimits>,
    /// The most memory of a structure; its rows know it.
    pub memory: MemoryLimit,
}

impl<'r> Plan<'r> {
    /// Gives its scenes the view and the lights of a record, unless the command line said something
    /// else: then the settings differ, and whoever compares them says so.
    pub fn set_view(&mut self, view: &ViewOptions) {
        let own = self.scenes.iter_mut().map(|scene| &mut scene.known_mut().view);
        own.filter(|own| own.is_empty()).for_each(|own| own.clone_from(view));
    }

    /// Builds and times each scene in so many processes; 0 is 1.
    pub fn set_processes(&mut self, processes: u32) -> Result<(), PlanError> {
        let processes = processes.max(1);
        within("processes", processes.into(), RunSettings::MOST_PROCESSES.into())?;
        self.processes = processes;
        Ok(())
    }

    /// Validates what a run is asked for; all of it, whatever part the settings name.
    pub fn new(
        args: &RunSettings,
        registry: &'r [Entry],
        occluders: &'r [occluders::Entry],
        scenes: &dyn SceneSource,
    ) -> Result<Self, PlanError> {
        let default = [DEFAULT_SET.to_owned()];
        let names = if args.scenes.is_empty() { &default } else { args.scenes.as_slice() };
        let mut ray_settings = RaySettings::default();
        let overrides = ray_overrides::apply(&args.overrides, &mut ray_settings)?;
        let (mut rows, occluding) =
            measured_row::select(registry, occluders, &args.structures, &overrides)?;
        let reference = args.measuring.reference.as_deref();
        if rows.is_empty() && !occluding.is_empty() && reference.is_none() {
            // an occluder is compared with a structure
            rows.push(default_baseline(registry)?);
        }
        let baseline = baseline(registry, &mut rows, reference)?;
        let scenes = scenes.resolve(names)?;
        let mut plan = Self::over(scenes, rows, baseline, &args.measuring, registry)?;
        plan.settings.offset = ray_settings.offset;
        plan.by_kind = args.by_kind;
        plan.set_processes(args.processes)?;
        if plan.kinds.iter().any(|k| k.is_occlusion()) {
            let within = |row: Row<'r, _>| Row { params: row.params.within(plan.memory), ..row };
            plan.rows.extend(occluding.into_iter().map(within).map(MeasuredRow::Occluder));
        } else if let Some(row) = occluding.first()
            && !args.structures.is_empty()
            && !args.structures.iter().any(|s| s == "all")
        {
            let structure = row.structure();
            return Err(PlanError::Invalid(format!(
                "{structure} answers shadow rays only; add shadow to --rays"
            )));
        }
        Ok(plan)
    }

    /// A plan over those scenes and rows; the reference is the row at the index `baseline`.
    pub fn over(
        scenes: Vec<Box<dyn KnownScene>>,
        rows: Vec<Row<'r>>,
        baseline: usize,
        args: &MeasuringSettings,
        registry: &'r [Entry],
    ) -> Result<Self, PlanError> {
        refuse_same_names(&scenes)?;
        let kinds = chosen("kind of ray", &args.rays, &RayKind::ALL, |kind| kind.name())?;
        within("threads", args.threads.into(), MeasuringSettings::MOST_THREADS.into())?;
        within("rounds", args.rounds.unwrap_or(1).into(), MeasuringSettings::MOST_ROUNDS.into())?;
        time_within("pass-limit", args.pass_limit)?;
        time_within("time-budget", args.time_budget)?;
        within("size", args.size.unwrap_or(1).into(), MeasuringSettings::LARGEST_SIZE.into())?;
        let memory = machine::memory_limit(args.max_memory);
        let limited = |row: Row<'r>| Row { params: row.params.within(memory), ..row };
        let at_least = if args.quick { 3 } else { 5 };
        let rounds = match (args.rounds, args.time_budget) {
            (Some(n), _) => Rounds::Fixed(n as usize),
            (None, Some(total)) => Rounds::Budget { total, at_least },
            (None, None) => Rounds::Fixed(at_least),
        };
        let size = args.size.unwrap_or(if args.quick { QUICK_SIZE } else { DEFAULT_SIZE });
        let mut settings = RaySettings {
            resolution: [size; 2],
            diffuse: kinds.contains(&RayKind::Diffuse),
            seed: args.seed,
            ..RaySettings::default()
        };
        if args.lights == Lights::First {
            settings.shadows = ShadowRays::FirstLight;
            let goes_on = |kind: &RayKind| matches!(kind, RayKind::Reflected | RayKind::Refracted);
            if !kinds.iter().any(goes_on) {
                // nothing that is asked comes of what lies behind the first hit
                settings.max_depth = 1;
            }
        }
        let mut limits = Limits::new(args.quick);
        if let Some(longest) = args.pass_limit {
            limits.timed_pass = longest.as_secs_f64();
            limits.checked_pass = limits.checked_pass.max(limits.timed_pass);
        }
        Ok(Self {
            scenes,
            answers: answers(registry)?.into_iter().map(limited).collect(),
            rows: rows.into_iter().map(|row| MeasuredRow::Structure(limited(row))).collect(),
            baseline,
            keeps_baseline: false,
            same_rays: false,
            kinds,
            orders: args.order,
            by_kind: false,
            rounds,
            threads: usize::from(args.threads),
            seed: args.seed,
            settings,
            precision: args.precision,
            limits,
            quick: args.quick,
            strides: FixedStrides::default(),
            part: None,
            processes: 1,
            process: OneProcess::default(),
            has_copy: false,
            is_untimed: false,
            build_limits: None,
            memory,
        })
    }
}

/// Refuses two scenes of one name: records are compared, and files named, by it.
fn refuse_same_names(scenes: &[Box<dyn KnownScene>]) -> Result<(), PlanError> {
    let mut seen = HashSet::new();
    match scenes.iter().find(|scene| !seen.insert(scene.name())) {
        None => Ok(()),
        Some(scene) => Err(PlanError::Invalid(format!(
            "two scenes are named {}; give one another name by a scene file (docs/scenes.md)",
            scene.name()
        ))),
    }
}

/// Refuses what the command line would.
pub fn within(what: &'static str, value: u64, most: u64) -> Result<(), PlanError> {
    let error = PlanError::OutOfRange { what, value, most };
    if (1..=most).contains(&value) { Ok(()) } else { Err(error) }
}

/// The same of a time, in seconds.
pub fn time_within(what: &'static str, time: Option<Duration>) -> Result<(), PlanError> {
    let most = u64::from(quantity::LONGEST_DURATION);
    match time.filter(|time| !quantity::is_duration(*time)) {
        Some(time) => Err(PlanError::OutOfRange { what, value: time.as_secs(), most }),
        None => Ok(()),
    }
}

/// Width and height of the image of a full run.
const DEFAULT_SIZE: u32 = 128;
/// Width and height of the image of a quick run.
const QUICK_SIZE: u32 = 48;

/// How good a row is as the reference when none is named: less is better. None
/// for most.
pub fn default_rank(structure: &str, settings: &str) -> Option<usize> {
    DEFAULT_BASELINES.iter().position(|default| *default == (structure, settings))
}

/// The best row that ratios can be taken to when none is named.
pub fn default_baseline(registry: &[Entry]) -> Result<Row<'_>, PlanError> {
    let [best, next] = DEFAULT_BASELINES.map(|(structure, settings)| {
        Row::parse(registry, format!("{structure} {settings}").trim_end())
    });
    best.or(next)
}

/// Index of the reference row; a row that was asked for and is not there yet is
/// added.
pub fn baseline<'r>(
    registry: &'r [Entry],
    rows: &mut Vec<Row<'r>>,
    reference: Option<&str>,
) -> Result<usize, PlanError> {
    let Some(name) = reference else {
        let rank = |row: &Row<'_>| default_rank(row.structure(), &row.settings());
        let ranked = rows.iter().enumerate().filter_map(|(i, row)| Some((rank(row)?, i)));
        let default = ranked
            .min()
            .map(|(_, i)| i)
            .or_else(|| rows.iter().position(|r| !r.is_sampled() && r.known_defect().is_none()));
        return if rows.is_empty() { Err(PlanError::NoRows) } else { Ok(default.unwrap_or(0)) };
    };
    let wanted = Row::parse(registry, name)?;
    let bare = !name.trim().contains([':', ' ']);
    let found = rows.iter().position(|r| *r == wanted).or_else(|| {
        // A structure's name alone means its only row, whatever its settings.
        let mut own = rows.iter().enumerate().filter(|(_, r)| r.structure() == wanted.structure());
        let only = own.next().map(|(i, _)| i);
        only.filter(|_| bare && own.next().is_none())
    });
    Ok(found.unwrap_or_else(|| {
        rows.push(wanted);
        rows.len() - 1
    }))
}

/// Defaults of all structures that may be asked first, the fastest first.
fn answers<'r>(registry: &'r [Entry]) -> Result<Vec<Row<'r>>, PlanError> {
    let rank = |e: &Entry| {
        let listed = ASKED_FIRST.iter().position(|n| *n == e.info.name);
        (e.info.sampled, listed.unwrap_or(ASKED_FIRST.len()))
    };
    let mut entries: Vec<&Entry> = registry.iter().collect();
    entries.sort_by_key(|e| rank(e));
    let mut rows = entries.into_iter().map(Row::defaults).collect::<Result<Vec<_>, _>>()?;
    rows.sort_by_key(|row| row.known_defect().is_some());
    Ok(rows)
}
