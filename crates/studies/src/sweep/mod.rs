//! One parameter of one structure over its values: the plan of `rtbench sweep`; [`sizes`] has that
//! over the sizes of a scene.
//!
//! Every value is a row of an ordinary [`Plan`], so that all of them are checked, interleaved and
//! timed as rows of a run are. Beside them stand rows to compare with: the parameter's default,
//! the rules of thumb for the number of voxels where the parameter decides it, and the row that
//! ratios are taken to.

pub mod judgement;
pub mod report;
pub mod sizes;
pub mod values;

use accel_core::params::{ParamKind, ParamSpec};
use accel_core::structures::Entry;

use crate::sweep::values::Range;
use measurement::plan::error::PlanError;
use measurement::plan::rows::{self, Assignments, Row};
use measurement::plan::{Plan, baseline, default_baseline};
use measurement::scenes::SceneSource;
use measurement::settings::MeasuringSettings;
use presentation::svg_plot::{Axis, Scale};

#[derive(Debug, Clone, Default)]
pub struct SweepSettings {
    /// Scenes, scene sets or scene files.
    pub scenes: Vec<String>,
    /// The structure, with its other settings if any.
    pub structure: String,
    pub parameter: String,
    pub values: Vec<String>,
    /// Values to measure instead, if the parameter is a number.
    pub range: Option<Range>,
    pub measuring: MeasuringSettings,
}

/// Parameter value that a row of the plan represents.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Line {
    /// The value of the parameter; none for rules of thumb and the row of ratios.
    pub value: Option<String>,
    /// One of the values asked for.
    pub is_swept: bool,
    /// The parameter has its default.
    pub is_default: bool,
    /// Rules of thumb that give this row.
    pub rules: Vec<&'static str>,
}

#[derive(Debug)]
pub struct Sweep<'r> {
    pub plan: Plan<'r>,
    /// Parameter value of each row of the plan.
    pub lines: Vec<Line>,
    pub structure: &'static str,
    /// Its other settings, as typed; empty for the defaults.
    pub settings: String,
    pub parameter: &'static ParamSpec,
    /// Horizontal axis of plots.
    pub axis: Axis,
    /// Rules of thumb compete with the values: all are placed by their cells per primitive.
    pub has_rules: bool,
}

impl<'r> Sweep<'r> {
    pub fn new(
        args: &SweepSettings,
        registry: &'r [Entry],
        scenes: &dyn SceneSource,
    ) -> Result<Self, PlanError> {
        let swept = SweptParameter::new(args, registry)?;
        let values = swept.values(args)?;
        let mut lines = Vec::new();
        for value in &values {
            let line = line_of(&mut lines, swept.row(value)?);
            (line.value, line.is_swept) = (Some(value.clone()), true);
        }
        let line = line_of(&mut lines, Row::of(swept.entry, &swept.settings)?);
        line.value.get_or_insert_with(|| swept.parameter.default.to_owned());
        line.is_default = true;
        let has_rules = values::rules_apply_to(swept.entry, swept.parameter);
        if has_rules {
            for (rule, settings) in values::rule_settings(&swept.settings) {
                line_of(&mut lines, Row::of(swept.entry, &settings)?).rules.push(rule);
            }
        }
        let named = args.measuring.reference.as_deref();
        let default = default_baseline(registry).ok().filter(|_| named.is_none());
        if let Some(row) = &default {
            line_of(&mut lines, row.clone());
        }
        let (mut rows, mut lines): (Vec<_>, Vec<_>) = lines.into_iter().unzip();
        let baseline = match rows.iter().position(|row| Some(row) == default.as_ref()) {
            Some(index) => index,
            None => baseline(registry, &mut rows, named)?,
        };
        lines.resize_with(rows.len(), Line::default);
        let scenes = scenes.resolve(&args.scenes)?;
        Ok(Self {
            plan: Plan::over(scenes, rows, baseline, &args.measuring, registry)?,
            axis: swept.axis(&values, &lines),
            has_rules,
            lines,
            structure: swept.entry.info.name,
            settings: swept.settings_text(),
            parameter: swept.parameter,
        })
    }
}

/// The structure, its settings and the parameter, as typed.
struct SweptParameter<'r, 't> {
    entry: &'r Entry,
    parameter: &'static ParamSpec,
    /// Settings of the other parameters.
    settings: Assignments<'t>,
}

impl<'r, 't> SweptParameter<'r, 't> {
    fn new(args: &'t SweepSettings, registry: &'r [Entry]) -> Result<Self, PlanError> {
        let (entry, settings) = rows::parse_settings(registry, &args.structure)?;
        let parameter = rows::find_param(entry, &args.parameter)?;
        Row::of(entry, &settings)?;
        if settings.iter().any(|(name, _)| *name == parameter.name) {
            return Err(PlanError::Invalid(format!(
                "{} is swept and cannot be set to a value at the same time",
                parameter.name
            )));
        }
        Ok(Self { entry, parameter, settings })
    }

    fn row(&self, value: &str) -> Result<Row<'r>, PlanError> {
        let mut settings = self.settings.clone();
        settings.push((self.parameter.name, value));
        Row::of(self.entry, &settings)
    }

    /// The values that the command line names or spans, in ascending order where they are numbers.
    fn values(&self, args: &SweepSettings) -> Result<Vec<String>, PlanError> {
        let Some(range) = args.range else {
            for value in &args.values {
                self.row(value)?;
            }
            return Ok(values::in_order(self.parameter.kind, &args.values));
        };
        let is_whole = match self.parameter.kind {
            ParamKind::Real { .. } => false,
            ParamKind::Integer { .. } => true,
            ParamKind::Choice(_) | ParamKind::Resolution => {
                return Err(PlanError::Invalid(format!(
                    "{}.{} has no range; give some of {} with --values",
                    self.entry.info.name, self.parameter.name, self.parameter.kind
                )));
            }
        };
        let Range { from, to, .. } = range;
        for end in [from, to] {
            self.row(&end.to_string())?;
        }
        if from >= to {
            return Err(PlanError::Invalid(format!(
                "--values {from}..{to}: the first must be below the last"
            )));
        }
        if from <= 0.0 {
            return Err(PlanError::Invalid(format!(
                "--values: equal ratios cannot start at {from}: it must be above 0; or list the \
                 values"
            )));
        }
        Ok(if is_whole { range.whole_numbers() } else { range.real_numbers() })
    }

    /// The horizontal axis for these values and lines.
    fn axis(&self, values: &[String], lines: &[Line]) -> Axis {
        let name = self.parameter.name;
        if values::rules_apply_to(self.entry, self.parameter) {
            return Axis { label: format!("cells per primitive, by {name}"), scale: Scale::Log };
        }
        let scale = match self.parameter.kind {
            ParamKind::Choice(_) | ParamKind::Resolution => {
                Scale::Words(lines.iter().filter_map(|line| line.value.clone()).collect())
            }
            _ if values::spread_by_ratios(values) => Scale::Log,
            ParamKind::Integer { .. } | ParamKind::Real { .. } => Scale::Linear,
        };
        Axis { label: name.to_owned(), scale }
    }

    fn settings_text(&self) -> String {
        let settings: Vec<_> = self.settings.iter().map(|(n, v)| format!("{n}={v}")).collect();
        settings.join(" ")
    }
}

/// The line of a row, which is added when it is not there yet.
fn line_of<'l, 'r>(lines: &'l mut Vec<(Row<'r>, Line)>, row: Row<'r>) -> &'l mut Line {
    let index = lines.iter().position(|(known, _)| *known == row).unwrap_or_else(|| {
        lines.push((row, Line::default()));
        lines.len() - 1
    });
    &mut lines[index].1
}
