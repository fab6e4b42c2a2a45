//! `rtbench render`: a picture of a scene, through any structure.

use accel_core::occluders;
use accel_core::occluders::shadow_path::ShadowPath;
use renderer::{Geometry, RaySettings, render};

use crate::args::{RenderArgs, STRUCTURE_SHADOWS};
use crate::context::Context;
use crate::error::Error;
use crate::machine;
use crate::plan::{DEFAULT_BASELINE, PlanError};
use crate::pools::pool;
use crate::rows::Row;
use crate::scene_run::light_positions;
use crate::suggest;

/// Renders.
///
/// # Errors
/// [`Error`].
pub fn run(context: &mut Context<'_>, args: &RenderArgs) -> Result<(), Error> {
    let row = match &args.structure {
        Some(text) => Row::parse(context.registry, text)?,
        None => {
            let default = context.registry.iter().find(|e| e.info.name == DEFAULT_BASELINE);
            let entry = default.or(context.registry.first()).ok_or(PlanError::NoRows)?;
            Row::defaults(entry)?
        }
    };
    let occluder = shadows(context, &args.shadows)?;
    let mut scenes = context.scenes.resolve(std::slice::from_ref(&args.scene))?;
    let scene = match (scenes.pop(), scenes.is_empty()) {
        (Some(scene), true) => scene,
        _ => {
            return Err(PlanError::Malformed {
                text: args.scene.clone(),
                expected: "the name of one scene, not of a set",
            }
            .into());
        }
    };
    // An unwritable path is found before the work is done.
    let file = std::fs::OpenOptions::new()
        .create(true)
        .write(true)
        .truncate(false)
        .open(&args.output)
        .map_err(|source| Error::Write { path: args.output.clone(), source })?;
    drop(file);
    let name = scene.name();
    let loaded = scene.load()?;
    for warning in &loaded.scene.warnings {
        context.warn(format_args!("{name}: {warning}"));
    }
    let geometry = Geometry::<f32>::of(&loaded.scene)?;
    let settings =
        RaySettings { resolution: [args.size; 2], diffuse: false, ..RaySettings::default() };
    let threads = args.threads.map_or_else(machine::threads, usize::from);
    let image = pool(threads)?
        .install(|| {
            let structure = row.entry.build(geometry.prims(), &row.params)?;
            let Some(occluder) = &occluder else {
                return Ok(render(&loaded.scene, &*structure, &settings));
            };
            let lights = light_positions(&loaded.scene);
            let shadows = occluder.entry.build(geometry.prims(), &lights, &occluder.params)?;
            let path = ShadowPath::new(structure, shadows, lights);
            Ok(render(&loaded.scene, &path, &settings))
        })
        .map_err(|source| Error::Build { scene: name.to_owned(), source })?;
    image
        .save_png(&args.output)
        .map_err(|source| Error::Image { path: args.output.clone(), source })?;
    context.say(format_args!("{name} through {}: {}", row.label(), args.output.display()));
    Ok(())
}

/// The occluder that `--shadows` names; none when shadow rays stay with the structure.
fn shadows<'r>(
    context: &Context<'r>,
    text: &str,
) -> Result<Option<Row<'r, occluders::Entry>>, PlanError> {
    if text == STRUCTURE_SHADOWS {
        return Ok(None);
    }
    Row::parse(context.occluders, text).map(Some).map_err(|error| match error {
        PlanError::UnknownStructure { name, .. } => {
            let occluders = context.occluders.iter().map(|e| e.info.name);
            let names: Vec<_> = std::iter::once(STRUCTURE_SHADOWS).chain(occluders).collect();
            PlanError::UnknownStructure {
                hint: suggest::hint(&name, names.iter().copied()),
                name,
                valid: names.join(", "),
            }
        }
        other => other,
    })
}
