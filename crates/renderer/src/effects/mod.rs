//! Effects that an image must simulate, found in the scene: one file per effect, one line each in
//! [`EFFECTS`].
//!
//! An effect that a scene does not call for is not there: the [`plan`] picks the stages of the
//! tracer once, before the first ray, and those of other effects are not among them.

mod counts;
mod direct_light;
mod effect;
mod eye;
mod focus;
mod gloss;
mod hard_shadows;
mod mirror;
mod motion;
pub mod plan;
mod refraction;
mod sampler;
mod settings;
mod smooth_normals;
mod soft_shadows;
mod stages;
mod supersampling;
mod textures;

pub use counts::RayCounts;
pub(crate) use direct_light::{lights, lit_normal, shadow_ray};
pub use effect::{Effect, EffectInfo};
pub(crate) use hard_shadows::first_light;
pub(crate) use plan::plain_stages;
pub use plan::{EFFECTS, EffectPlan, Gating};
pub use settings::{RenderSettings, Samples};
pub(crate) use stages::{
    HitStage, Origin, ScatteredRay, ShadowRay, Stages, SurfaceHit, WavePosition,
};
pub(crate) use textures::ImageColors;
