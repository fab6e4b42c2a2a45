//! A classical ray tracer for `rtbench`: it produces the rays of a scene once, by kind, so that
//! every structure can be asked the same questions, and it renders the same image.

pub mod camera;
pub mod effects;
pub mod exr;
pub mod film;
pub mod foot;
pub mod geometry;
pub mod heat_map;
pub mod leaving;
pub mod rays;
pub mod surface;
pub mod tracers;
pub mod work;

pub use effects::counts::RayCounts;
pub use effects::{Effect, EffectPlan, Gating, RenderSettings, Samples};
pub use film::{Image, ImageError, ImageFormat};
pub use geometry::{Geometry, GeometryError};
pub use rays::{RayBatches, RayKind, RaySettings, ShadowRays, generate_rays};
pub use tracers::whitted::{Rendered, render, render_plan};
