//! `rtbench sweep`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use measurement::plan::error::PlanError;
use measurement::settings::MeasuringSettings;
use studies::sweep::SweepSettings;
use studies::sweep::sizes::{SizeSettings, Sizes};

use crate::args::measuring::RatioArgs;
use crate::args::parsers::scene_name;

/// Values of a range where no number is given.
const STEPS: u16 = 9;

/// The ends of `0.1..100`.
fn range(values: &[String]) -> Option<[f64; 2]> {
    let [only] = values else { return None };
    let (from, to) = only.split_once("..")?;
    Some([from.parse().ok()?, to.parse().ok()?])
}

#[derive(Debug, Clone, Args)]
pub struct SweepArgs {
    /// Scenes, scene sets or scene files; with --sizes one generated scene: balls, tree-tess, hare
    #[arg(value_name = "SCENE|SET", required = true, value_parser = scene_name())]
    pub scenes: Vec<String>,
    /// Structure to vary, with its other settings if any: uniform-grid:resolution=woo; with
    /// --sizes, structures and occluders to measure [default: all, with their defaults]
    #[arg(
        short,
        long,
        alias = "structure",
        value_name = "STRUCTURE",
        value_delimiter = ',',
        required_unless_present = "sizes"
    )]
    pub structures: Vec<String>,
    /// Parameter to vary
    #[arg(short, long, value_name = "PARAM", required_unless_present = "sizes")]
    pub parameter: Option<String>,
    /// Values of the parameter: none,array,hash; or a range of numbers, equal ratios apart:
    /// 0.1..100
    #[arg(
        long,
        value_name = "A,B,...|A..B",
        value_delimiter = ',',
        required_unless_present = "sizes"
    )]
    pub values: Vec<String>,
    /// Number of values of a range [default: 9]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub steps: Option<u16>,
    /// Vary the number of primitives instead of a parameter: 1e3..1e7, by factors of ten, or
    /// 1k,20k,1M; for each, the nearest size that the scene has
    #[arg(long, value_name = "FROM..TO|N,N,...", value_parser = Sizes::parse,
          conflicts_with_all = ["parameter", "values", "steps"])]
    pub sizes: Option<Sizes>,
    /// Time limit of a build; slower rows are not measured, nor tried at larger sizes
    #[arg(long, value_name = "TIME", default_value = "60s", requires = "sizes",
          value_parser = measurement::settings::quantity::duration)]
    pub time_limit: Duration,
    /// Memory limit of a structure; rows above it are shown as `out of memory` [default: half of
    /// the machine's memory, or of the control group's limit if that is less]; with --sizes, limit
    /// of a process that loads the scene and builds one row, shown as `over limit` [default: 8GiB]
    #[arg(long, value_name = "BYTES", value_parser = measurement::settings::quantity::bytes)]
    pub max_memory: Option<u64>,
    /// Write results.json, sweep.csv, sweep.md and sweep.svg to DIR; with --sizes also slopes.csv
    #[arg(short, long, value_name = "DIR")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub measuring: RatioArgs,
}

impl SweepArgs {
    /// The sweep over a parameter that was typed.
    pub fn settings(&self) -> Result<SweepSettings, PlanError> {
        let [structure] = &self.structures[..] else {
            return Err(PlanError::Malformed {
                text: self.structures.join(","),
                expected: "one structure, whose parameter is swept",
            });
        };
        let range = range(&self.values);
        if let (Some(steps), None) = (self.steps, range) {
            let text = format!("--steps {steps}");
            return Err(PlanError::Malformed { text, expected: "a range of --values: 0.1..100" });
        }
        Ok(SweepSettings {
            scenes: self.scenes.clone(),
            structure: structure.clone(),
            parameter: self.parameter.clone().unwrap_or_default(),
            values: self.values.clone(),
            range,
            steps: self.steps.unwrap_or(STEPS),
            measuring: self.measuring(),
        })
    }

    /// The sweep over sizes that was typed.
    pub fn size_settings(&self, sizes: &Sizes) -> Result<SizeSettings, PlanError> {
        let [scene] = &self.scenes[..] else {
            return Err(PlanError::Malformed {
                text: self.scenes.join(" "),
                expected: "one generated scene, like balls",
            });
        };
        Ok(SizeSettings {
            scene: scene.clone(),
            sizes: sizes.clone(),
            structures: self.structures.clone(),
            measuring: self.measuring(),
            time_limit: self.time_limit,
        })
    }

    fn measuring(&self) -> MeasuringSettings {
        MeasuringSettings { max_memory: self.max_memory, ..self.measuring.settings() }
    }
}
