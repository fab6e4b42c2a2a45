//! `rtbench sweep`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use measurement::plan::error::PlanError;
use measurement::settings::MeasuringSettings;
use studies::sweep::SweepSettings;
use studies::sweep::sizes::SizeSettings;
use studies::sweep::sizes::targets::Sizes;

use crate::args::measuring::MeasuringArgs;
use crate::args::parsers::scene_name;

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
    /// Values of the parameter: none,array,hash
    #[arg(long, value_name = "VALUE", value_delimiter = ',',
          conflicts_with_all = ["from", "to", "steps", "linear"])]
    pub values: Vec<String>,
    /// First value, a number
    #[arg(long, value_name = "NUMBER", required_unless_present_any = ["values", "sizes"],
          allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Last value, a number
    #[arg(long, value_name = "NUMBER", required_unless_present_any = ["values", "sizes"],
          allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Number of values
    #[arg(long, value_name = "N", default_value_t = 9,
          value_parser = clap::value_parser!(u16).range(2..=1000))]
    pub steps: u16,
    /// Use equal steps between values [default: equal ratios]
    #[arg(long)]
    pub linear: bool,
    /// Set another parameter of the structure: resolution=woo; with --sizes, of any structure:
    /// uniform-grid.density=4
    #[arg(long = "set", value_name = "PARAM=VALUE")]
    pub settings: Vec<String>,
    /// Vary the number of primitives instead of a parameter: 1e3..1e7, or 1k,20k,1M; for each, the
    /// nearest size that the scene has
    #[arg(long, value_name = "FROM..TO|N,N,...", value_parser = Sizes::parse,
          conflicts_with_all = ["parameter", "values", "from", "to", "steps", "linear"])]
    pub sizes: Option<Sizes>,
    /// Sizes per factor of ten, if --sizes is a range
    #[arg(long, value_name = "N", default_value_t = 1, requires = "sizes",
          value_parser = clap::value_parser!(u32).range(1..=20))]
    pub per_decade: u32,
    /// Time limit of a build; slower rows are not measured, nor tried at larger sizes
    #[arg(long, value_name = "TIME", default_value = "60s", requires = "sizes",
          value_parser = measurement::settings::duration::parse)]
    pub time_limit: Duration,
    /// Memory limit of a structure; rows above it are shown as `out of memory` [default: half of
    /// the machine's memory, or of the control group's limit if that is less]; with --sizes, limit
    /// of a process that loads the scene and builds one row, shown as `over limit` [default: 8GiB]
    #[arg(long, value_name = "BYTES", value_parser = measurement::settings::quantity::bytes)]
    pub max_memory: Option<u64>,
    /// Write one CSV row per scene and value; - is standard output, instead of the tables
    #[arg(long, value_name = "FILE")]
    pub export_csv: Option<PathBuf>,
    /// Write one CSV row per slope over the sizes; or -
    #[arg(long, value_name = "FILE", requires = "sizes")]
    pub export_slopes: Option<PathBuf>,
    /// Write a plot, one panel per scene, or per quantity that grows with the size; or -
    #[arg(long, value_name = "FILE")]
    pub export_svg: Option<PathBuf>,
    /// Write the tables in Markdown; or -
    #[arg(long, value_name = "FILE")]
    pub export_markdown: Option<PathBuf>,
    /// Write everything, raw samples too, as JSON; or -
    #[arg(long, value_name = "FILE")]
    pub export_json: Option<PathBuf>,
    #[command(flatten)]
    pub measuring: MeasuringArgs,
}

impl SweepArgs {
    /// The sweep over a parameter that was typed.
    ///
    /// # Errors
    /// [`PlanError::Malformed`] for several structures.
    pub fn settings(&self) -> Result<SweepSettings, PlanError> {
        let [structure] = &self.structures[..] else {
            return Err(PlanError::Malformed {
                text: self.structures.join(","),
                expected: "one structure, whose parameter is swept",
            });
        };
        Ok(SweepSettings {
            scenes: self.scenes.clone(),
            structure: structure.clone(),
            parameter: self.parameter.clone().unwrap_or_default(),
            values: self.values.clone(),
            from: self.from,
            to: self.to,
            steps: self.steps,
            linear: self.linear,
            settings: self.settings.clone(),
            measuring: self.measuring(),
        })
    }

    /// The sweep over sizes that was typed.
    ///
    /// # Errors
    /// [`PlanError::Malformed`] for several scenes.
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
            per_decade: self.per_decade,
            structures: self.structures.clone(),
            overrides: self.settings.clone(),
            measuring: self.measuring(),
            time_limit: self.time_limit,
        })
    }

    fn measuring(&self) -> MeasuringSettings {
        MeasuringSettings { max_memory: self.max_memory, ..self.measuring.settings() }
    }
}
