//! `rtbench render`: a picture of a scene, through any structure, with the effects it calls for; and
//! the small pictures of a report.

use std::collections::BTreeMap;
use std::path::Path;
use std::time::Duration;

use accel_core::occluders;
use accel_core::occluders::shadow_path::ShadowPath;
use accel_core::query::tracer::Tracer;
use accel_core::structures::Entry;
use renderer::effects::EFFECTS;
use renderer::{
    Effect, EffectPlan, Geometry, Image, ImageFormat, RayCounts, RenderSettings, Whitted,
    render_plan,
};
use scene_loading::Scene;

use crate::args::{RenderArgs, STRUCTURE_SHADOWS, SamplingArgs};
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use measurement::plan::DEFAULT_TRACER;
use measurement::plan::error::PlanError;
use measurement::plan::rows::Row;
use measurement::record::{RunRecord, SceneRecord};
use measurement::rounds::MeasureError;
use measurement::rounds::scene_run::light_positions;
use measurement::scenes::{KnownScene, SceneSource, titles};
use measurement::system::files::CreatedFiles;
use measurement::system::machine;
use measurement::system::pools::pool;
use measurement::system::progress::Progress;
use presentation::numbers::short;
use presentation::table::{Cell, Style, Table};
use studies::error::UnsavedImage;
use studies::images::plan_of;
use studies::run::lines::seconds;

pub fn run(context: &mut Context<'_>, args: &RenderArgs) -> Result<u8, Error> {
    let row = structure(context.registry, args.structure.as_deref())?;
    let scene = one_scene(context.scenes, &args.scene)?;
    let output = args.output.as_deref().map(|path| Ok::<_, PlanError>((path, format_of(path)?)));
    let output = output.transpose()?;
    let occluder = shadows(context, &args.shadows)?;
    let pool = pool(args.threads.map_or_else(machine::threads, usize::from))?;
    // all that was typed is valid: an unwritable path is found before a scene is loaded, and where
    // that is refused, or the structure, the file is taken back
    let mut created = CreatedFiles::default();
    if let Some((path, _)) = output {
        created.file(path)?;
    }
    let name = scene.name();
    let loaded = context.load(&*scene)?;
    context.warn_in_f32(&loaded.scene);
    let geometry = Geometry::<f32>::of(&loaded.scene)?;
    let settings = settings(args.size, &args.sampling);
    let plan = plan_of(&loaded.scene, &settings)?;
    let [width, height] = settings.resolution;
    let progress = Progress::new(context.shows_progress(), u64::from(height), None);
    let primitives = geometry.len();
    progress.message(format!("{name}: building {} over {primitives} primitives", row.label()));
    let started = context.clock.now();
    let ended = pool
        .install(|| {
            let structure = row.entry.build(geometry.prims(), &row.params)?;
            let tracer: Box<dyn Tracer<f32>> = match &occluder {
                None => structure,
                Some(occluder) => {
                    let lights = light_positions(&loaded.scene);
                    let shadows =
                        occluder.entry.build(geometry.prims(), &lights, &occluder.params)?;
                    Box::new(ShadowPath::new(structure, shadows, &lights))
                }
            };
            let table = args.plan.then(|| effect_table(&loaded.scene, &*tracer, &plan));
            progress.message(format!("{name}: rendering {width} x {height} pixels"));
            let row_done = || progress.step(Duration::ZERO);
            let image = || Whitted::planned(&loaded.scene, &plan).image(&*tracer, &row_done).image;
            Ok((table, output.is_some().then(image)))
        })
        .map_err(MeasureError::of_build(name));
    progress.finish();
    let (table, image) = ended?;
    let took = context.clock.now().saturating_sub(started).as_secs_f64();
    if let Some(table) = table {
        context.screen().write_table(context.out, &table)?;
    }
    if let (Some((path, format)), Some(image)) = (output, image) {
        let unsaved = |source| UnsavedImage { path: path.to_owned(), source };
        image.save(path, format).map_err(unsaved)?;
        let (row, took) = (row.label(), seconds(took));
        let pixels = format_args!("{width} x {height} pixels of {name} through {row}, {took}");
        context.wrote(path, pixels);
    }
    Ok(SUCCESS)
}

pub fn structure<'r>(registry: &'r [Entry], named: Option<&str>) -> Result<Row<'r>, PlanError> {
    match named {
        Some(text) => Row::parse(registry, text),
        None => {
            let default = registry.iter().find(|e| e.info.name == DEFAULT_TRACER);
            Row::defaults(default.or(registry.first()).ok_or(PlanError::NoRows)?)
        }
    }
}

/// The scene of that name, which must not be a set.
pub fn one_scene(scenes: &dyn SceneSource, name: &str) -> Result<Box<dyn KnownScene>, PlanError> {
    let mut found = scenes.resolve(&[name.to_owned()])?;
    match (found.pop(), found.is_empty()) {
        (Some(scene), true) => Ok(scene),
        _ => Err(PlanError::Malformed {
            text: name.to_owned(),
            expected: "the name of one scene, not of a set",
        }),
    }
}

fn format_of(path: &Path) -> Result<ImageFormat, PlanError> {
    ImageFormat::of(path).ok_or_else(|| PlanError::Malformed {
        text: path.display().to_string(),
        expected: "a file name that ends in .png or .exr",
    })
}

/// Converts the options to settings of the renderer.
pub fn settings(size: u32, sampling: &SamplingArgs) -> RenderSettings {
    RenderSettings {
        resolution: [size; 2],
        max_depth: sampling.depth,
        samples: sampling.wishes(),
        ..RenderSettings::default()
    }
}

/// The occluder that `--shadows` names; none when shadow rays stay with the structure.
fn shadows<'r>(
    context: &Context<'r>,
    text: &str,
) -> Result<Option<Row<'r, occluders::OccluderRegistry>>, PlanError> {
    if text == STRUCTURE_SHADOWS {
        return Ok(None);
    }
    Row::parse(context.occluders, text).map(Some).map_err(|error| match error {
        PlanError::UnknownName { what, name, .. } => {
            let occluders = context.occluders.iter().map(|e| e.info.name);
            PlanError::unknown(what, &name, std::iter::once(STRUCTURE_SHADOWS).chain(occluders))
        }
        other => other,
    })
}

/// Pixels of the image that rays are counted on, an axis: enough for two digits.
const PROBE: u32 = 64;

/// One row an effect, called for or not.
fn effect_table(scene: &Scene, tracer: &dyn Tracer<f32>, plan: &EffectPlan) -> Table {
    let probe = RenderSettings { resolution: [PROBE; 2], ..*plan.settings() };
    let plan = EffectPlan::of(scene, &probe);
    let counted = |plan: &EffectPlan| render_plan(scene, tracer, plan).counts;
    let all = counted(&plan);
    let mut table = Table {
        title: format!("{}: effects", scene.name),
        header: vec!["effect", "samples", "rays/pixel", "called for by"],
        ..Table::default()
    };
    for info in &EFFECTS {
        let row = match plan.called.iter().find(|c| c.info.effect == info.effect) {
            Some(called) => {
                let rays = added(info.effect, &all, || counted(&plan.clone().without(info.effect)));
                let samples = plan.factor(info.effect).to_string();
                vec![info.name.to_owned(), samples, per_pixel(rays), called.by.clone()]
            }
            None => vec![info.name.to_owned(), "-".into(), "0".into(), "nothing".into()],
        };
        let style = if plan.calls_for(info.effect) { Style::Plain } else { Style::Dim };
        table.rows.push(row.into_iter().map(|text| Cell { text, style }).collect());
    }
    let all = per_pixel(all.total());
    table.notes = vec![
        format!("all rays: {all} per pixel, counted on {PROBE} x {PROBE} pixels"),
        "rays/pixel: for shadows, mirrors and refraction, their own rays; for sampled effects, \
         all rays that the image without the effect does not need"
            .to_owned(),
    ];
    table
}

/// The rays an effect adds to an image.
fn added(effect: Effect, all: &RayCounts, without: impl FnOnce() -> RayCounts) -> u64 {
    use Effect::{Focus, Gloss, HardShadows, Mirror, Motion};
    use Effect::{Refraction, SmoothNormals, SoftShadows, Supersampling, Textures};
    match effect {
        HardShadows | Mirror | Refraction | SmoothNormals | Textures => all.effect(effect),
        SoftShadows | Gloss | Focus | Motion | Supersampling => {
            all.total().saturating_sub(without().total())
        }
    }
}

fn per_pixel(rays: u64) -> String {
    short(rays as f64 / f64::from(PROBE * PROBE))
}

/// Pixels of a side.
const SIZE: u32 = 256;
/// Larger scenes take longer to load than a report may.
const LARGEST: u64 = 300_000;

/// Renders the scenes that have no picture yet. Only what is known by its name is loaded, never a
/// file that a record names; and only the very scene that was measured is shown. What cannot be is
/// left out.
pub fn scene_pictures(
    context: &Context<'_>,
    run: &RunRecord,
    pictures: &mut BTreeMap<String, Vec<u8>>,
) -> Result<(), Error> {
    let Ok(catalogue) = context.scenes.catalogue() else { return Ok(()) };
    let is_known = |name: &str| {
        let family = name.split_once(':').map_or(name, |(family, _)| family);
        titles(&catalogue).any(|(known, _)| known == family || known == name)
    };
    let missing: Vec<&SceneRecord> = run
        .scenes
        .iter()
        .filter(|scene| scene.primitives <= LARGEST && is_known(&scene.name))
        .filter(|scene| !pictures.contains_key(&scene.name))
        .collect();
    let progress = Progress::new(context.shows_progress(), missing.len() as u64, None);
    let pool = pool(machine::threads())?;
    for scene in missing {
        progress.message(format!("picture of {}", scene.name));
        let known = one_scene(context.scenes, &scene.name);
        let row = structure(context.registry, None);
        let (Ok(known), Ok(row)) = (known, row) else { continue };
        if let Some(png) = pool.install(|| picture(&*known, &row, &scene.sha256)) {
            pictures.insert(scene.name.clone(), png);
        }
        progress.step(std::time::Duration::ZERO);
    }
    progress.finish();
    Ok(())
}

fn picture(scene: &dyn KnownScene, row: &Row<'_>, sha256: &str) -> Option<Vec<u8>> {
    let loaded = scene.load().ok()?;
    if loaded.sha256 != sha256 {
        return None;
    }
    image_of(&loaded.scene, row, SIZE)?.png().ok()
}

/// A picture of a scene with its effects, so many pixels high and wide; none where it cannot be
/// drawn.
pub fn image_of(scene: &Scene, row: &Row<'_>, size: u32) -> Option<Image> {
    let settings = RenderSettings { resolution: [size; 2], ..RenderSettings::default() };
    let plan = plan_of(scene, &settings).ok()?;
    let geometry = Geometry::<f32>::of(scene).ok()?;
    let tracer = row.entry.build(geometry.prims(), &row.params).ok()?;
    Some(render_plan(scene, &*tracer, &plan).image)
}
