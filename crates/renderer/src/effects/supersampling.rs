//! Several rays for the area of a pixel, averaged by a box filter (the rays are made in
//! [`super::eye`]).
//!
//! Paper: T. Whitted 1980 and R. Cook, "Stochastic Sampling in Computer Graphics", ACM TOG 5(1),
//! 1986. Deviation: a low-discrepancy pattern instead of jitter.

use scene_loading::Scene;

use super::effect::{Effect, EffectInfo};
use super::settings::{RenderSettings, Samples};

pub static INFO: EffectInfo = EffectInfo {
    effect: Effect::Supersampling,
    name: "supersampling",
    paper: "Whitted 1980; Cook 1986",
    called_by,
};

fn called_by(scene: &Scene, settings: &RenderSettings) -> Option<String> {
    let samples = Samples::of(scene, settings).supersamples;
    let who =
        if settings.samples.supersamples.is_some() { "the command line" } else { "the scene" };
    (samples > 1).then(|| format!("{who} asks for {samples} samples of a pixel's area"))
}
