//! `rtbench cost`: the lecture's product with a scene's numbers, predicted and measured; and where
//! in the image the time goes.

use renderer::work::pixel_work;
use renderer::{Geometry, RenderSettings, render_plan};
use scene_loading::Scene;

use crate::args::CostArgs;
use crate::commands::render::{one_scene, settings, structure};
use crate::commands::show::save;
use crate::context::Context;
use crate::error::{Error, SUCCESS};
use measurement::plan::rows::Row;
use measurement::rounds::MeasureError;
use measurement::system::clock::Clock;
use measurement::system::files::CreatedFiles;
use measurement::system::pools::pool;
use presentation::drawing::{HeatMap, Panel, heat_maps};
use presentation::numbers::{milliseconds, short};
use presentation::table::{Cell, Style, Table};
use studies::cost::model::seconds_per_test;
use studies::cost::model::{CountedWork, Model};
use studies::cost::{
    CostRow, Factor, TracedStructure, counted, factors, is_near, measured, rows, worst,
};
use studies::images::plan_of;

/// Scenes that the times are taken from: the first two that are not the one in question.
const CALIBRATION: [&str; 3] = ["lattice", "pavilion", "effect-mirror"];

/// The files of `--heat-maps`.
pub const MAPS: [&str; 3] = ["tests.svg", "steps.svg", "time.svg"];

/// Prints the table and draws the maps.
pub fn run(context: &mut Context<'_>, args: &CostArgs) -> Result<u8, Error> {
    let named = |text: &String| structure(context.registry, Some(text));
    let mut structures: Vec<Row<'_>> =
        args.structures.iter().map(named).collect::<Result<_, _>>()?;
    if structures.is_empty() {
        structures.push(structure(context.registry, None)?);
    }
    let scene = one_scene(context.scenes, &args.scene)?;
    let mut created = CreatedFiles::default();
    if let Some(folder) = &args.heat_maps {
        created.folder(folder)?;
    }
    let settings = settings(args.size, &args.sampling);
    let calibration: Vec<&str> =
        CALIBRATION.iter().copied().filter(|name| *name != scene.name()).take(2).collect();
    let pool = pool(usize::from(args.threads))?;
    let loaded = context.load(&*scene)?.scene;
    let plan = plan_of(&loaded, &settings)?;
    let geometry = Geometry::<f32>::of(&loaded)?;
    let mut maps: [Vec<HeatMap>; 3] = Default::default();
    let mut image: Option<Panel> = None;
    for row in &structures {
        let mut points = Vec::new();
        for name in &calibration {
            let loaded = one_scene(context.scenes, name)?.load()?.scene;
            // small images, all factors at 1
            let (resolution, max_depth) = ([192; 2], settings.max_depth);
            let settings = RenderSettings { resolution, max_depth, ..RenderSettings::default() };
            let clock = context.clock;
            let found = pool.install(|| calibrate(row, &loaded, &settings, clock))?;
            points.extend(found);
        }
        let Some(model) = Model::fitted(&points) else {
            return Err(Error::NoModel { scenes: calibration.join(", ") });
        };
        let clock = context.clock;
        let build = MeasureError::of_build(scene.name());
        let rows = pool.install(|| {
            let tracer = row.entry.build(geometry.prims(), &row.params).map_err(build)?;
            let seconds_per_test = seconds_per_test(geometry.prims(), clock);
            let traced = TracedStructure { tracer: &*tracer, seconds_per_test };
            let rows = rows(&loaded, traced, &settings, &model, clock);
            if args.heat_maps.is_some() {
                let [tests, steps, nanoseconds] =
                    pixel_work(&loaded, &*tracer, &plan, &|| clock.now());
                let microseconds = nanoseconds.iter().map(|t| t / 1e3).collect();
                let [width, _] = settings.resolution;
                image.get_or_insert_with(|| {
                    let pixels = render_plan(&loaded, &*tracer, &plan).image.rgb8();
                    Panel { name: "image".into(), pixels, width }
                });
                for (maps, values) in maps.iter_mut().zip([tests, steps, microseconds]) {
                    maps.push(HeatMap { name: row.label(), values, width });
                }
            }
            Ok::<_, Error>(rows)
        })?;
        let table = table(scene.name(), &row.label(), &rows, &model, &calibration);
        context.screen().write_table(context.out, &table)?;
    }
    if let Some(folder) = &args.heat_maps {
        let units = ["tests", "steps", "microseconds"].map(|what| format!("{what} per pixel"));
        for ((maps, name), unit) in maps.iter().zip(MAPS).zip(units) {
            let title = format!("{}: {unit}", scene.name());
            let drawing = heat_maps(&title, &unit, image.as_ref(), maps);
            save(&drawing, &folder.join(name))?;
        }
        context.wrote(folder, format_args!("heat maps {}", MAPS.join(", ")));
    }
    Ok(SUCCESS)
}

/// The work of a scene's images and their seconds.
fn calibrate(
    row: &Row<'_>,
    scene: &Scene,
    settings: &RenderSettings,
    clock: &dyn Clock,
) -> Result<Vec<(CountedWork, f64)>, Error> {
    let geometry = Geometry::<f32>::of(scene)?;
    let built = row.entry.build(geometry.prims(), &row.params);
    let tracer = built.map_err(MeasureError::of_build(&scene.name))?;
    let seconds_per_test = seconds_per_test(geometry.prims(), clock);
    let traced = TracedStructure { tracer: &*tracer, seconds_per_test };
    let factors = factors(scene, settings);
    let seconds = measured(scene, &*tracer, &factors, clock);
    let work = |factor: &Factor| counted(scene, traced, &factor.plan);
    Ok(factors.iter().map(work).zip(seconds).collect())
}

fn table(scene: &str, label: &str, rows: &[CostRow], model: &Model, calibration: &[&str]) -> Table {
    let header = ["factor", "product says", "time grew", "predicted ms", "measured ms"];
    let header = [&header[..], &["pred/meas", "the product"]].concat();
    let mut table = Table {
        title: format!("{scene} through {label}: Zachmann's product of 2007, factor by factor"),
        header,
        ..Table::default()
    };
    for (i, row) in rows.iter().enumerate() {
        let grew = if i == 0 { "-".to_owned() } else { format!("x {}", short(row.grew)) };
        let style = if is_near(row.predicted, row.measured) { Style::Plain } else { Style::Bad };
        let cells = vec![
            row.name.to_owned(),
            row.says.clone(),
            grew,
            milliseconds(row.predicted),
            milliseconds(row.measured),
            format!("{:.2}", row.predicted / row.measured),
            judged(i, row),
        ];
        table.rows.push(cells.into_iter().map(|text| Cell { text, style }).collect());
    }
    let nanoseconds = |seconds: f64| short(seconds * 1e9);
    let [ray, step] = model.terms().map(nanoseconds);
    let test = nanoseconds(rows.first().map_or(0.0, |row| row.work.seconds_per_test));
    table.notes.push(format!(
        "times from {}: {ray} ns per ray with its shading, {step} per step; {test} ns per test in this \
         scene; rays, tests and steps are counted on a small image",
        calibration.join(" and ")
    ));
    if let (Some(last), Some(worst)) = (rows.last(), worst(rows)) {
        let ratio = last.predicted / last.measured;
        table.notes.push(if is_near(last.predicted, last.measured) {
            format!("predicted over measured: {ratio:.2}, within 0.5 to 2")
        } else {
            format!(
                "predicted over measured: {ratio:.2}, not within 0.5 to 2; largest error: {}",
                worst.name
            )
        });
    }
    table
}

/// Describes where the product is off.
fn judged(i: usize, row: &CostRow) -> String {
    if i == 0 {
        let per_ray = |x: f64| short(x / row.work.rays.max(1.0));
        let (tests, steps) = (per_ray(row.work.tests), per_ray(row.work.steps));
        return format!("counts every primitive; a ray tests {tests} in {steps} steps");
    }
    let ratio = row.nominal / row.grew;
    match ratio {
        r if r > 1.25 => format!("overestimates {} times", short(r)),
        r if r < 0.8 => format!("underestimates {} times", short(1.0 / r)),
        _ => "is right".to_owned(),
    }
}
