//! Effects that an image must simulate, found in the scene: one line each in [`EFFECTS`], one stage
//! for those that make or change rays.
//!
//! An effect that a scene does not call for is not there: the [`plan`] picks the stages of the
//! tracer once, before the first ray, and those of other effects are not among them.

mod effect;
mod eye;
mod hits;
mod lights;
pub mod plan;
mod sampler;
mod scatter;
mod stages;

pub use effect::{EFFECTS, Effect, EffectInfo, RenderSettings};
pub(crate) use hits::ImageColors;
pub(crate) use lights::{first_light, lights, lit_normal, shadow_ray};
pub(crate) use plan::plain_stages;
pub use plan::{EffectPlan, Gating};
pub use stages::RayCounts;
pub(crate) use stages::{HitStage, Origin, ScatteredRay, ShadowRay, Stages, SurfaceHit, Wave};
