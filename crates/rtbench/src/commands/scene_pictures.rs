//! Small pictures of the scenes of a run, for its report.

use std::collections::BTreeMap;

use renderer::{Geometry, Image, RenderSettings, render_watched};
use scene_loading::Scene;

use crate::commands::render::{one_scene, structure};
use crate::context::Context;
use crate::error::Error;
use measurement::plan::rows::Row;
use measurement::record::{RunRecord, SceneRecord};
use measurement::scenes::KnownScene;
use measurement::system::machine;
use measurement::system::pools::pool;
use measurement::system::progress::Progress;
use studies::images::plan_of;

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
    let Ok(known) = context.scenes.scenes() else { return Ok(()) };
    let is_known = |name: &str| {
        let family = name.split_once(':').map_or(name, |(family, _)| family);
        known.iter().any(|(known, _)| known == family || known == name)
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
    Some(render_watched(scene, &*tracer, &plan, &|| {}).image)
}
