//! The surfaces within a cone: candidates of the structure, near ones first, until the cone is
//! covered.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984, which tests every object.
//! Deviation: the region query ([`accel_core::query::region`]). What is missing because the search
//! ended is hidden, so that the image is the same through any structure.

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};

use super::circular_cone::Cone;
use super::compose::{Composition, Fragment, compose};
use super::coverage::Coverage;
use super::{Caster, ConeTracer, UNSEEN};

/// While candidates still arrive, so many are combined to see whether the cone is full; more are
/// combined at the end alone.
const COMBINED_EARLY: usize = 16;

/// How far from a footprint its neighbours are looked for, in its radii.
const BESIDE: f64 = 2.0;

impl ConeTracer<'_, '_> {
    /// The surfaces that cover a part of a cone. What comes after the cone is full may be missing.
    pub(super) fn fragments(&mut self, cone: &Cone, is_shadow: bool) -> Vec<Fragment> {
        let on = self.on;
        let [lo, hi] = on.bounds;
        let deepest = DVec3::select(cone.axis.cmpgt(DVec3::ZERO), hi, lo);
        let end = cone.locate(deepest).0.min(cone.end);
        let mut fragments: Vec<Fragment> = Vec::new();
        if end.is_nan() || end <= cone.begin {
            return fragments;
        }
        let frustum = cone.frustum(end);
        let (mut stop, mut sum) = (f64::INFINITY, 0.0);
        on.over.frusta.query_in_order(&frustum, &mut self.candidates, &mut |ids, depth| {
            let before = fragments.len();
            for &id in ids {
                if is_shadow && on.forms.is_clear(id) {
                    continue;
                }
                let Some(coverage) = on.forms.cover(cone, id) else { continue };
                let Coverage { overlap, far, .. } = coverage;
                if is_shadow && on.is_beside_footprint(cone, id, overlap.centroid) {
                    continue;
                }
                if overlap.share >= 1.0 {
                    if is_shadow {
                        fragments = vec![Fragment { id, depth: far, coverage }];
                        return ControlFlow::Break(());
                    }
                    stop = stop.min(far);
                }
                sum += overlap.share;
                let met = on.forms.depth(cone, id, overlap.centroid);
                let depth = met.unwrap_or_else(|| on.forms.middle(cone, id));
                fragments.push(Fragment { id, depth, coverage });
            }
            let is_new = fragments.len() > before && fragments.len() <= COMBINED_EARLY;
            if !is_shadow && is_new && stop.is_infinite() && sum >= 1.0 - UNSEEN {
                let found = on.compose(cone, &mut fragments);
                if found.is_certain && found.left_over <= UNSEEN {
                    let fars = found.seen.iter().map(|s| fragments[s.fragment].coverage.far);
                    stop = fars.fold(f64::NEG_INFINITY, f64::max);
                }
            }
            if cone.begin + depth > stop {
                ControlFlow::Break(())
            } else {
                ControlFlow::Continue(())
            }
        });
        fragments
    }
}

impl Caster<'_> {
    /// Returns whether a flat surface that a shadow cone meets at once is its neighbour in a
    /// crease: it does not come between the middle of the footprint and the light, but the
    /// footprint, which is thought round, sticks out through it.
    fn is_beside_footprint(&self, cone: &Cone, id: u32, place: DVec2) -> bool {
        let is_near = |depth: f64| depth < BESIDE * cone.radius;
        self.forms.is_flat(id)
            && self.forms.depth(cone, id, place).is_some_and(is_near)
            && self
                .forms
                .depth(cone, id, DVec2::ZERO)
                .is_none_or(|depth| depth <= 0.0 || depth >= cone.end)
    }

    /// Combines what was found.
    pub(super) fn compose(&self, cone: &Cone, fragments: &mut [Fragment]) -> Composition {
        compose(fragments, &|id: u32, place: DVec2| self.forms.depth(cone, id, place))
    }
}
