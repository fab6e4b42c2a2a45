//! Workarounds that make `obvhs` 0.4 answer correctly, and their settings.
//!
//! As shipped, its CwBvh loses every hit of a ray with a -0.0 direction component and every hit
//! nearer than t = 1e-4; both of its BVHs cap 1/0 at 2^23, so that a ray parallel to a face
//! "leaves" small far boxes; neither knows of hits at negative t; a NaN box gives wrong results
//! or a panic, and tens of thousands of
//! coincident centroids a quadratic build or a stack overflow. Its lengths are absolute: long
//! directions and large scenes overflow, short ones drown in its epsilons. The robust adapter:
//! tells it everything in units of the scene's size (powers of two, so that nothing is rounded),
//! adds +0.0 to the direction, sets reciprocals itself, starts the box tests a little before the
//! ray's origin, or where an interval begins that begins before it, pads boxes, refuses what is
//! not finite, and groups primitives with the same centre: `box_ray.rs` and `items.rs`.

use crate::params::config::Config;
use crate::params::{ParamSpec, Params};
use crate::update::refitted_until;

/// Build method of binary trees that obvhs does not build.
pub(crate) const BINNED: &str = "binned";
pub(crate) const MORTON: &str = "morton";

/// Build methods of a binary tree, beside presets.
pub(crate) const BUILDS: &[&str] =
    &[BINNED, MORTON, "fastest", "very-fast", "fast", "medium", "slow", "very-slow"];

pub(crate) const PRESETS: &[&str] = BUILDS.split_at(2).1;

/// The preset, for the parameter list of whatever is built by obvhs.
pub(crate) const PRESET: ParamSpec =
    ParamSpec::choice("preset", "medium", PRESETS).about("obvhs's build preset");

/// Chooses the traversal and the tests.
pub(crate) const ADAPTER: ParamSpec =
    ParamSpec::choice("adapter", "robust", &["robust", "direct", "as-shipped"]).about(
        "robust gives right answers; direct is obvhs as its authors use it: its triangles, \
              its test, its traversal (f32, triangles alone); as-shipped has our primitive tests \
              in its traversal, rays and boxes unchanged",
    );

/// Triangles one by one, or in blocks.
pub(crate) const KERNEL: ParamSpec = ParamSpec::choice("kernel", "block", &["scalar", "block"])
    .about(
        "of adapter=robust, over triangles: block: those of a leaf (Bvh2) or of a node's \
              leaves (CwBvh) in blocks of eight, tested at once, the faster in every scene \
              measured; scalar: one by one, through their ids",
    );

/// Padding of boxes and rays; exists only with the feature `compiled-tests`, to measure its cost.
#[cfg(feature = "compiled-tests")]
pub(crate) const PADDING: ParamSpec = ParamSpec::choice("padding", "default", &["default", "none"])
    .about("for comparison: none leaves out what keeps rounding from losing boxes that hold hits");

/// Returns whether padding is left out.
pub(crate) fn is_unpadded(params: &Params) -> bool {
    params.get("padding") == Some("none")
}

/// The known defect of this setting.
pub(crate) const UNPADDED: &str = "boxes are not padded: hits at their faces are lost to rounding";

pub(crate) const VARIANTS: &[&str] = &["adapter=direct", "", "preset=fastest adapter=direct"];

/// Deviations common to both rows.
pub(crate) const DEVIATIONS: &str = "library code; our primitive tests, our robust ray setup; \
                                     nested boxes and too deep subtrees are halved at medians";

/// Settings that only the tests go through.
pub(crate) const ALSO_TESTED: &[&str] = &[
    "kernel=scalar",
    "preset=fastest",
    "preset=fastest kernel=scalar",
    "preset=very-fast",
    "preset=fast",
    "preset=slow",
    "preset=very-slow",
    "preset=very-slow adapter=direct",
    "adapter=as-shipped",
];

pub(crate) fn known_defect(params: &Params) -> Option<&'static str> {
    match params.text("adapter") {
        "robust" => is_unpadded(params).then_some(UNPADDED),
        "direct" => Some(
            "obvhs as its authors use it loses hits at edges of triangles, of rays with -0.0 \
             components, near hits, hits at negative t and far small boxes; of equal hits it takes \
             any",
        ),
        _ => Some(
            "obvhs as shipped loses hits of rays with -0.0 components, near hits, hits at negative t \
             and far small boxes",
        ),
    }
}

/// Settings of the build and of queries.
#[derive(Clone)]
pub struct AdapterConfig {
    pub(crate) preset: obvhs::BvhBuildParams,
    pub(crate) is_robust: bool,
    pub(crate) is_direct: bool,
    pub(crate) is_block: bool,
    pub(crate) is_unpadded: bool,
    pub(crate) refitted_until: Option<f64>,
}

impl Config for AdapterConfig {
    fn of(params: &Params) -> Self {
        // one that is not listed is the robust one
        let adapter = params.get(ADAPTER.name).unwrap_or(ADAPTER.default);
        let is_robust = adapter == "robust";
        Self {
            preset: preset_of(params.text(PRESET.name)),
            is_robust,
            is_direct: adapter == "direct",
            is_block: is_robust && params.get(KERNEL.name) == Some("block"),
            is_unpadded: is_unpadded(params),
            refitted_until: refitted_until(params),
        }
    }
}

pub(crate) fn preset_of(name: &str) -> obvhs::BvhBuildParams {
    use obvhs::BvhBuildParams as B;
    match name {
        "fastest" => B::fastest_build(),
        "very-fast" => B::very_fast_build(),
        "fast" => B::fast_build(),
        "slow" => B::slow_build(),
        "very-slow" => B::very_slow_build(),
        _ => B::medium_build(),
    }
}
