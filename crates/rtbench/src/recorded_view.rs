//! The view and the lights of a record, for the scenes of a plan that is made by it.

use measurement::plan::Plan;
use measurement::record::Settings;
use scene_loading::ViewOptions;

/// Gives the scenes of a plan what the settings say of view and lights, unless the command line said
/// something else: then the settings differ, and whoever compares them says so.
///
/// # Errors
/// What is no view.
pub fn apply(settings: &Settings, plan: &mut Plan<'_>) -> Result<(), String> {
    let view = ViewOptions::from_arguments(&settings.view)?;
    for scene in &mut plan.scenes {
        if scene.view().is_empty() {
            scene.set_view(&view);
        }
    }
    Ok(())
}
