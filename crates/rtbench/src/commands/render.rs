//! `rtbench render`: a picture of a scene, through any structure.

use renderer::{Geometry, RaySettings, render};

use crate::args::RenderArgs;
use crate::context::Context;
use crate::error::Error;
use crate::machine;
use crate::plan::{DEFAULT_BASELINE, PlanError};
use crate::pools::pool;
use crate::rows::Row;

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
            let tracer = row.entry.build(geometry.prims(), &row.params)?;
            Ok(render(&loaded.scene, &*tracer, &settings))
        })
        .map_err(|source| Error::Build { scene: name.to_owned(), source })?;
    image
        .save_png(&args.output)
        .map_err(|source| Error::Image { path: args.output.clone(), source })?;
    context.say(format_args!("{name} through {}: {}", row.label(), args.output.display()));
    Ok(())
}
