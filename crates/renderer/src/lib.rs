//! A classical ray tracer for `rtbench`: it produces the rays of a scene once, by kind, so that
//! every structure can be asked the same questions, and it renders the same image.
//!
//! Modules depend on those above them only:
//!
//! | module | what it holds |
//! | --- | --- |
//! | `camera` | rays from the eye |
//! | `geometry` | the primitives of a scene, for structures |
//! | `film` | images, their files, heat maps |
//! | `surface`, `ray_offset` | surfaces where rays meet them; rays that leave them |
//! | `rays` | kinds of rays, and the rays of a scene |
//! | `effects` | what an image simulates |
//! | `tracers` | Whitted's rays, cones, beams; recorded rays; the work of an image |

pub mod camera;
pub mod effects;
mod film;
mod geometry;
pub mod ray_offset;
mod rays;
pub mod surface;
pub mod tracers;

pub use effects::{Effect, EffectPlan, Gating, RayCounts, RenderSettings};
pub use film::{Image, ImageError, ImageFormat};
pub use geometry::{Geometry, GeometryError};
pub use rays::{RayBatches, RayKind, RaySettings, ShadowRays};
pub use tracers::generate_rays;
pub use tracers::whitted::{RenderedImage, Whitted, render_plan};
pub use tracers::work;

/// The level at which this crate is optimised. It is that of `accel_core`, too, in every profile:
/// of what is timed, as opposed to the program around it.
pub const OPT_LEVEL: Option<&str> = option_env!("RENDERER_OPT_LEVEL");
