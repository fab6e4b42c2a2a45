//! `rtbench scenes`: inspect, check or fetch scenes.

use crate::args::{SceneNames, ScenesAction};
use crate::context::Context;
use crate::error::{Error, FAILURE, SUCCESS};
use crate::scene_source::{KnownScene, LoadedScene};

/// Runs and returns the exit code.
///
/// # Errors
/// [`Error`].
pub fn run(context: &mut Context<'_>, action: &ScenesAction) -> Result<u8, Error> {
    match action {
        ScenesAction::Info(names) => info(context, names),
        ScenesAction::Validate(names) => validate(context, names),
        ScenesAction::Fetch(names) => fetch(context, names),
    }
}

/// The scenes named, or all.
fn named(context: &Context<'_>, names: &SceneNames) -> Result<Vec<Box<dyn KnownScene>>, Error> {
    if names.names.is_empty() {
        let all: Vec<String> = context.scenes.scenes()?.into_iter().map(|(name, _)| name).collect();
        return Ok(context.scenes.resolve(&all)?);
    }
    Ok(context.scenes.resolve(&names.names)?)
}

fn info(context: &mut Context<'_>, names: &SceneNames) -> Result<u8, Error> {
    let mut code = SUCCESS;
    for scene in named(context, names)? {
        let name = scene.name();
        match scene.load() {
            Ok(loaded) => write_info(context, &loaded)?,
            Err(error) => {
                code = FAILURE;
                let _ = writeln!(context.err, "error: {name}: {error}");
            }
        }
    }
    context.out.flush()?;
    Ok(code)
}

fn write_info(context: &mut Context<'_>, loaded: &LoadedScene) -> Result<(), Error> {
    use scene_loading::Shape;
    let scene = &loaded.scene;
    let count = |is: fn(&Shape) -> bool| scene.primitives.iter().filter(|p| is(&p.shape)).count();
    let kinds = [
        ("triangles", count(|s| matches!(s, Shape::Triangle { .. }))),
        ("patches", count(|s| matches!(s, Shape::Patch { .. }))),
        ("polygons", count(|s| matches!(s, Shape::Polygon { .. }))),
        ("spheres", count(|s| matches!(s, Shape::Sphere(_)))),
        ("cones", count(|s| matches!(s, Shape::Cone(_)))),
    ];
    let kinds: Vec<String> =
        kinds.iter().filter(|(_, n)| *n > 0).map(|(kind, n)| format!("{n} {kind}")).collect();
    let bounds = scene.bounds();
    let out = &mut *context.out;
    writeln!(out, "{}", scene.name)?;
    writeln!(out, "  primitives: {} ({})", scene.primitives.len(), kinds.join(", "))?;
    writeln!(out, "  bounds:     {} to {}", bounds.min, bounds.max)?;
    writeln!(out, "  materials:  {}", scene.materials.len())?;
    writeln!(out, "  lights:     {}", scene.lights.len())?;
    let camera = &scene.camera;
    writeln!(out, "  camera:     from {} at {}, {} degrees", camera.from, camera.at, camera.angle)?;
    writeln!(out, "  source:     {}", loaded.source)?;
    writeln!(out, "  licence:    {}", loaded.licence.as_deref().unwrap_or("unknown"))?;
    writeln!(out, "  sha256:     {}", loaded.sha256)?;
    for warning in &scene.warnings {
        writeln!(out, "  warning:    {warning}")?;
    }
    Ok(())
}

fn validate(context: &mut Context<'_>, names: &SceneNames) -> Result<u8, Error> {
    let mut code = SUCCESS;
    for scene in named(context, names)? {
        let name = scene.name();
        let said = scene.load().map_err(Error::from).and_then(|loaded| {
            renderer::Geometry::<f64>::of(&loaded.scene)?;
            renderer::Geometry::<f32>::of(&loaded.scene)?;
            Ok(loaded.scene.warnings)
        });
        match said {
            Ok(warnings) if warnings.is_empty() => writeln!(context.out, "{name}: ok")?,
            Ok(warnings) => {
                writeln!(context.out, "{name}: ok, with {} warnings", warnings.len())?;
                for warning in &warnings {
                    writeln!(context.out, "  {warning}")?;
                }
            }
            Err(error) => {
                code = FAILURE;
                writeln!(context.out, "{name}: {error}")?;
            }
        }
    }
    context.out.flush()?;
    Ok(code)
}

fn fetch(context: &mut Context<'_>, names: &SceneNames) -> Result<u8, Error> {
    let mut code = SUCCESS;
    for scene in named(context, names)? {
        let name = scene.name();
        match scene.fetch() {
            Ok(Some(path)) => writeln!(context.out, "{name}: {}", path.display())?,
            Ok(None) => writeln!(context.out, "{name}: nothing to fetch")?,
            Err(error) => {
                code = FAILURE;
                let _ = writeln!(context.err, "error: {name}: {error}");
            }
        }
    }
    context.out.flush()?;
    Ok(code)
}
