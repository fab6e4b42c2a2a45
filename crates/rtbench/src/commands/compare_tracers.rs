//! `rtbench compare-tracers`: one scene by samples, by cones and by beams, against a converged
//! image.

use std::path::Path;

use accel_core::structures::frustum_queries;
use renderer::tracers::{Structures, TRACERS, whitted};
use renderer::{Geometry, Image, RenderSettings};

use crate::args::CompareTracersArgs;
use crate::commands::render::{one_scene, structure};
use crate::context::Context;
use crate::error::{Error, SUCCESS, WRONG_HITS};
use measurement::plan::error::PlanError;
use measurement::plan::rows::Row;
use measurement::rounds::MeasureError;
use measurement::system::files::write_text;
use measurement::system::machine;
use measurement::system::pools::pool;
use studies::error::UnsavedImage;
use studies::images::plan_of;
use studies::tracer_comparison::queries::{self, Rounds, pixel_frusta};
use studies::tracer_comparison::record::{ReferenceRecord, TracersRecord};
use studies::tracer_comparison::report::Report;
use studies::tracer_comparison::{
    ComparisonInput, KINDS, compare, converged, sampled_plan, without,
};

/// Longest chain of rays; eye rays have depth 1.
const MAX_DEPTH: u32 = 5;
/// Samples per pixel: those of the full comparison, and those of a first look.
const SAMPLES: [u32; 11] = [1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024];
const QUICK_SAMPLES: [u32; 5] = [1, 4, 16, 64, 256];

pub fn run(context: &mut Context<'_>, args: &CompareTracersArgs) -> Result<u8, Error> {
    let row = structure(context.registry, None)?;
    let frusta = Row::parse(frustum_queries::REGISTRY, &args.through)?;
    let tracers = tracers(&args.tracers)?;
    if let Some(word) = args.without.iter().find(|word| !KINDS.contains(&word.as_str())) {
        return Err(PlanError::unknown("kind of primitive", word, KINDS).into());
    }
    let known = one_scene(context.scenes, &args.scene)?;
    let names = ["tracers.json", "tracers.csv", "tracers.md", "tracers.svg"];
    let _created = context.created_folder(args.output.as_ref(), &names)?;
    let loaded = known.load()?;
    context.warn_in_f32(&loaded.scene);
    let scene = without(loaded.scene, &args.without);
    let choice = |given: Option<u32>, full: u32, quick: u32| {
        given.unwrap_or(if args.quick { quick } else { full })
    };
    let resolution = [choice(args.size, 64, 32); 2];
    let frame = RenderSettings { resolution, max_depth: MAX_DEPTH, ..RenderSettings::default() };
    let mut samples = args.samples.clone();
    if samples.is_empty() {
        samples = if args.quick { QUICK_SAMPLES.to_vec() } else { SAMPLES.to_vec() };
    }
    samples.sort_unstable();
    samples.dedup();
    let reference_samples = choice(args.reference_samples, 4096, 1024);
    for &n in samples.iter().chain([&reference_samples]) {
        plan_of(&scene, sampled_plan(&scene, frame, n).settings())?;
    }
    let rounds = choice(args.rounds, 5, 3);
    let build = MeasureError::of_build(&scene.name);
    let single = Geometry::<f32>::of(&scene)?;
    let double = Geometry::<f64>::of(&scene)?;
    let (threads, clock) = (usize::from(args.threads), context.clock);
    let (helpers, measured) = (pool(machine::threads())?, pool(threads)?);
    let sampler = row.entry.build(single.prims(), &row.params).map_err(build)?;
    let rays = row.entry.build(double.prims(), &row.params).map_err(build)?;
    let queries = frusta.entry.build(double.prims(), &frusta.params).map_err(build)?;
    context.say(format_args!("{}: reference of 2 x {reference_samples} samples", scene.name));
    let reference = helpers.install(|| converged(&scene, &*sampler, frame, reference_samples));
    let question = ComparisonInput {
        scene: &scene,
        sampler: &*sampler,
        structures: Structures { rays: &*rays, frusta: &*queries },
        frame,
        samples: &samples,
        tracers: &tracers,
        rounds,
    };
    let images = measured.install(|| compare(&question, &reference, clock));
    let queries = if tracers.iter().any(|name| *name != whitted::INFO.name) {
        let frusta = pixel_frusta(&scene, &*rays, frame.resolution);
        let rounds = Rounds { rounds, seed: frame.seed, primitives: scene.primitives.len() };
        queries::measure(frustum_queries::REGISTRY, double.prims(), &frusta, rounds, clock)
            .map_err(build)?
    } else {
        Vec::new()
    };
    let record = TracersRecord {
        scene: scene.name.clone(),
        primitives: scene.primitives.len(),
        resolution: frame.resolution,
        through: [row.label(), frusta.label()],
        threads,
        seed: frame.seed,
        command_line: context.command_line.clone(),
        machine: Some((context.world.machine)()),
        reference: ReferenceRecord { own_error: reference.own_error, samples: reference_samples },
        images,
        queries,
    };
    let report = Report { record, reference: reference.image };
    if let Some(folder) = &args.output {
        write_files(folder, &report)?;
    }
    let screen = context.screen();
    screen.write_table(context.out, &report.images())?;
    if let Some(table) = report.query_table() {
        screen.write_table(context.out, &table)?;
    }
    Ok(if report.is_failure() { WRONG_HITS } else { SUCCESS })
}

/// The tracers of those names, all of them where none is given.
fn tracers(names: &[String]) -> Result<Vec<&'static str>, PlanError> {
    let all: Vec<&'static str> = TRACERS.iter().map(|t| t.name).collect();
    if names.is_empty() {
        return Ok(all);
    }
    let unknown = |name: &str| PlanError::unknown("tracer", name, all.iter().copied());
    let named =
        |name: &String| all.iter().copied().find(|n| n == name).ok_or_else(|| unknown(name));
    names.iter().map(named).collect()
}

fn write_files(folder: &Path, report: &Report) -> Result<(), Error> {
    let text = |name: &str, text: String| write_text(&folder.join(name), &text);
    text("tracers.csv", report.to_csv()?)?;
    text("tracers.json", report.to_json()?)?;
    text("tracers.md", report.to_markdown())?;
    text("tracers.svg", report.to_svg())?;
    let image = |name: String, image: &Image| {
        let path = folder.join(name);
        image.save_png(&path).map_err(|source| UnsavedImage { path, source })
    };
    image("reference.png".to_owned(), &report.reference)?;
    for made in &report.record.images {
        if let Some(pixels) = made.made().and_then(|measured| measured.image.as_ref()) {
            let name = made.row.short_label().replace([' ', '='], "-");
            image(format!("{name}.png"), pixels)?;
        }
    }
    Ok(())
}
