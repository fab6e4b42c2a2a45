//! `rtbench scenes`: inspect, check or fetch scenes.

use accel_core::primitives::Instances;
use scene_loading::Warning;
use scene_loading::info::SceneInfo;

use crate::args::{SceneNames, ScenesAction};
use crate::context::Context;
use crate::error::{Error, FAILURE, SUCCESS};
use measurement::scenes::{KnownScene, LoadError, LoadedScene, titles};
use presentation::outside::line;

pub fn run(context: &mut Context<'_>, action: &ScenesAction) -> Result<u8, Error> {
    match action {
        ScenesAction::Info(names) => info(context, names),
        ScenesAction::Validate(names) => validate(context, names),
        ScenesAction::Fetch(names) => fetch(context, names),
    }
}

fn named(context: &Context<'_>, names: &SceneNames) -> Result<Vec<Box<dyn KnownScene>>, Error> {
    if names.names.is_empty() {
        let catalogue = context.scenes.catalogue()?;
        let all: Vec<String> = titles(&catalogue).map(|(name, _)| name.to_owned()).collect();
        return Ok(context.scenes.resolve(&all)?);
    }
    Ok(context.scenes.resolve(&names.names)?)
}

fn info(context: &mut Context<'_>, names: &SceneNames) -> Result<u8, Error> {
    for_each_scene(context, names, |context, scene| {
        let loaded = context.load(scene)?;
        let screen = context.plain_screen();
        let out = &mut *context.out;
        writeln!(out, "{}", line(scene.name()))?;
        for text in SceneInfo::of(&loaded.scene).to_string().lines() {
            screen.write_item(out, &format!("  {text}"), 14)?;
        }
        let camera = &loaded.scene.camera;
        let [from, at] = [camera.from, camera.at].map(|p| loaded.scene.to_file_coordinates(p));
        let text = format!("  camera      from {from} at {at}, {} degrees", camera.angle);
        screen.write_item(out, &text, 14)?;
        screen.write_item(out, &format!("  source      {}", loaded.source), 14)?;
        let licence = loaded.licence.as_deref().unwrap_or("unknown");
        screen.write_item(out, &format!("  licence     {licence}"), 14)?;
        writeln!(out, "  sha256      {}", loaded.sha256)?;
        for warning in loaded.scene.warnings_in_f32() {
            screen.write_item(out, &format!("  warning     {warning}"), 14)?;
        }
        Ok(())
    })
}

fn validate(context: &mut Context<'_>, names: &SceneNames) -> Result<u8, Error> {
    for_each_scene(context, names, |context, scene| {
        let LoadedScene { scene: mut loaded, .. } = context.load(scene)?;
        renderer::Geometry::<f64>::of(&loaded)?;
        let geometry = renderer::Geometry::<f32>::of(&loaded)?;
        let copies = geometry.instances().map_or(0, Instances::copies);
        let instances = SceneInfo::of(&loaded).instances;
        let mut warnings = std::mem::take(&mut loaded.warnings);
        warnings.extend(loaded.fine_detail.take());
        warnings.extend(scene_loading::info::validate(&loaded));
        if copies < instances {
            let text = format!("{} of {instances} instances are not copies", instances - copies);
            warnings.push(Warning(text));
        }
        let screen = context.plain_screen();
        match warnings.len() {
            0 => writeln!(context.out, "{}: ok", line(scene.name()))?,
            n => writeln!(context.out, "{}: can be used, {n} warning(s)", line(scene.name()))?,
        }
        for warning in &warnings {
            screen.write_item(context.out, &format!("  {warning}"), 4)?;
        }
        let opinion = scene.known().second_opinion()?;
        for text in opinion.map(|opinion| opinion.lines()).unwrap_or_default() {
            screen.write_item(context.out, &format!("  {text}"), 4)?;
        }
        Ok(())
    })
}

fn fetch(context: &mut Context<'_>, names: &SceneNames) -> Result<u8, Error> {
    for_each_scene(context, names, |context, scene| {
        let fetched = scene.known().fetch()?.map(|path| path.display().to_string());
        let said = fetched.as_deref().unwrap_or("nothing to fetch");
        writeln!(context.out, "{}: {}", line(scene.name()), line(said))?;
        Ok(())
    })
}

/// Does the same with each scene; one that fails does not keep the others from their turn. A
/// scene that was not named and is not on this machine is no failure.
fn for_each_scene(
    context: &mut Context<'_>,
    names: &SceneNames,
    mut act: impl FnMut(&mut Context<'_>, &dyn KnownScene) -> Result<(), Error>,
) -> Result<u8, Error> {
    let mut code = SUCCESS;
    for scene in named(context, names)? {
        match act(context, &*scene) {
            Ok(()) => {}
            Err(error @ Error::Output(_)) => return Err(error),
            Err(Error::Load(error @ LoadError::NotFetched { .. })) if names.names.is_empty() => {
                context.warn(error);
            }
            Err(error) => {
                code = FAILURE;
                context.error(&error);
            }
        }
    }
    Ok(code)
}
