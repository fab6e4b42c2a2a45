//! Every effect.

use super::effect::EffectInfo;
use super::{
    focus, gloss, hard_shadows, mirror, motion, refraction, smooth_normals, soft_shadows,
    supersampling, textures,
};

/// Every effect: one line each.
pub static EFFECTS: &[&EffectInfo] = &[
    &hard_shadows::INFO,
    &soft_shadows::INFO,
    &mirror::INFO,
    &gloss::INFO,
    &refraction::INFO,
    &smooth_normals::INFO,
    &textures::INFO,
    &focus::INFO,
    &motion::INFO,
    &supersampling::INFO,
];
