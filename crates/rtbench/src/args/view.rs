//! The view and the lights that scenes are given from the command line.

use clap::Args;
use scene_loading::ViewOptions;
use scene_loading::view_options::{CameraOption, LightOption, UpOption};

/// The view and the lights that scenes are given from the command line, of every command that loads
/// scenes.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "View and lights")]
pub struct ViewArgs {
    /// Camera instead of the scenes' own, in world units and degrees: 1,2,3:0,0,0:45 [default: the
    /// scene's, or one that frames it]
    #[arg(long, global = true, value_name = "FROM:AT[:FOV]", allow_hyphen_values = true)]
    pub camera: Option<CameraOption>,
    /// Up direction of the camera [default: the scene's, or 0,1,0]
    #[arg(long, global = true, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub up: Option<UpOption>,
    /// Point light instead of the scenes' own, repeatable: 0,10,0 or 0,10,0:1,0.9,0.8 [default: the
    /// scene's, or one at the eye]
    #[arg(long, global = true, value_name = "POS[:COLOR]", allow_hyphen_values = true)]
    pub light: Vec<LightOption>,
}

impl ViewArgs {
    pub fn options(&self) -> ViewOptions {
        ViewOptions { camera: self.camera, up: self.up, lights: self.light.clone() }
    }
}
