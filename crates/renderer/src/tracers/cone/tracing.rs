//! One cone after another: gather, combine, shade, and send cones on.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984. The surface model is that of
//! [`crate::tracers::whitted`], whose functions say what light arrives.

use std::ops::ControlFlow;

use accel_core::region::Gathered;
use accel_core::{Hit, Ray};
use glam::{DVec2, DVec3};
use scene_loading::{Rgb, Scene};

use super::Settings;
use super::circular_cone::Cone;
use super::compose::{Composition, Fragment, Seen, compose};
use super::coverage::{Coverage, Forms, Left};
use super::shadows::shadow_cone;
use super::widening::{Incidence, LEAST_COSINE};
use crate::effects::{ImageColors, lights, lit_normal, shadow_ray};
use crate::leaving::{Leaving, OffsetRule};
use crate::surface::{Surfaces, reflect, refract};
use crate::tracers::Structures;
use crate::tracers::stages::{HitStage, Origin, SurfaceHit};

/// Cones that spread more than this are cut into four: half an angle of 27 degrees.
const WIDE: f64 = 0.5;

/// A surface that is seen in less than this share of a cone is not shaded.
const UNSEEN: f64 = 1e-6;

/// While candidates still arrive, so many are combined to see whether the cone is full; more are
/// combined at the end alone.
const COMBINED_EARLY: usize = 16;

/// How far from a footprint its neighbours are looked for, in its radii.
const BESIDE: f64 = 2.0;

/// What a flat surface's neighbours in its plane may be off it by rounding, in epsilons of its
/// largest coordinate.
const PLANE_SLACK: f64 = 64.0 * f64::EPSILON;

/// What was traced.
#[derive(Debug, Clone, Copy, Default)]
pub struct Counts {
    cones: u64,
    pub(super) subdivided: u64,
    pub(super) shadow_cones: u64,
    rays: u64,
    shadow_rays: u64,
}

impl Counts {
    /// With their names.
    pub fn rows(self) -> Vec<(&'static str, u64)> {
        vec![
            ("cones", self.cones),
            ("shadow cones", self.shadow_cones),
            ("cones cut into four", self.subdivided),
            ("rays", self.rays),
            ("shadow rays", self.shadow_rays),
        ]
    }
}

impl std::ops::AddAssign for Counts {
    fn add_assign(&mut self, other: Self) {
        self.cones += other.cones;
        self.subdivided += other.subdivided;
        self.shadow_cones += other.shadow_cones;
        self.rays += other.rays;
        self.shadow_rays += other.shadow_rays;
    }
}

/// What a thread needs while it traces.
#[derive(Default)]
pub struct Scratch {
    /// Memory of the candidate queries, and their cost.
    pub gathered: Gathered,
    /// What was traced.
    pub counts: Counts,
}

/// A scene made ready for cones.
pub struct Caster<'a> {
    scene: &'a Scene,
    surfaces: Surfaces<'a>,
    forms: Forms,
    leaving: Leaving,
    /// Centre, colour and radius.
    lights: Vec<(DVec3, Rgb, f64)>,
    textures: ImageColors<'a>,
    bounds: [DVec3; 2],
    max_depth: u32,
    pub(super) settings: Settings,
    over: Structures<'a>,
}

/// A bundle on its way.
enum Bundle {
    Ray(Ray<f64>),
    Cone(Cone, Option<Left>),
}

/// What a bundle will contribute, and where in the tree it is.
#[derive(Clone, Copy)]
struct Path {
    weight: Rgb,
    /// 1 for those from the eye.
    depth: u32,
    /// How often it was cut.
    level: u32,
}

/// A surface that is seen, and the cone that sees it.
struct Sight<'s> {
    hit: SurfaceHit<'s>,
    incidence: Incidence,
    right: DVec3,
    up: DVec3,
}

/// How a bundle goes on.
#[derive(Clone, Copy)]
enum Way {
    Mirrored,
    Refracted,
}

impl Way {
    /// What a bundle that goes on from a surface contributes.
    fn weight(self, sight: &Sight<'_>) -> Rgb {
        let material = sight.hit.point.material;
        let share = match self {
            Self::Mirrored => material.specular,
            Self::Refracted => material.transmittance,
        };
        sight.hit.weight.map(|w| w * share)
    }
}

impl<'a> Caster<'a> {
    /// Prepares a scene.
    pub fn new(scene: &'a Scene, settings: Settings, max_depth: u32, over: Structures<'a>) -> Self {
        let bounds = scene.bounds();
        let radii = scene.lights.iter().map(|light| light.radius());
        Self {
            scene,
            surfaces: Surfaces::new(scene, false),
            forms: Forms::new(scene),
            // this rule asks for no magnitude
            leaving: Leaving::new(OffsetRule::default(), 0.0),
            lights: lights(scene).into_iter().zip(radii).map(|((p, c), r)| (p, c, r)).collect(),
            textures: ImageColors::new(scene),
            bounds: [bounds.min, bounds.max],
            max_depth,
            settings,
            over,
        }
    }

    /// The colour that a cone from the eye sees.
    pub fn look(&self, cone: Cone, scratch: &mut Scratch) -> Rgb {
        let bundle = if cone.is_ray() {
            Bundle::Ray(Ray::<f64>::new(cone.origin, cone.axis))
        } else {
            Bundle::Cone(cone, None)
        };
        let mut color = [0.0; 3];
        let path = Path { weight: [1.0; 3], depth: 1, level: 0 };
        if self.max_depth > 0 {
            self.trace(&bundle, path, &mut color, scratch);
        }
        color
    }

    /// Adds what a bundle sees.
    fn trace(&self, bundle: &Bundle, path: Path, color: &mut Rgb, scratch: &mut Scratch) {
        let sights = match bundle {
            Bundle::Ray(ray) => self.hit(ray, path, color, scratch),
            Bundle::Cone(cone, left) => {
                match self.sights(cone, left.as_ref(), path, color, scratch) {
                    Some(sights) => sights,
                    None => return self.quarter(cone, *left, path, color, scratch),
                }
            }
        };
        for sight in &sights {
            self.light(sight, path, color, scratch);
        }
        if path.depth < self.max_depth {
            self.go_on(&sights, path, color, scratch);
        }
    }

    /// Follows what goes on from the surfaces that a bundle sees. Those that contribute little do
    /// so through the largest of them: a wide cone may see hundreds of mirrors.
    fn go_on(&self, sights: &[Sight<'_>], path: Path, color: &mut Rgb, scratch: &mut Scratch) {
        for way in [Way::Mirrored, Way::Refracted] {
            let mut little: Option<(&Sight<'_>, Rgb, f64)> = None;
            for sight in sights {
                let weight = way.weight(sight);
                let largest = weight.into_iter().fold(0.0, f64::max);
                if largest <= 0.0 {
                    continue;
                }
                if largest >= self.settings.ray_below {
                    self.follow(sight, way, weight, path, color, scratch);
                    continue;
                }
                little = Some(match little {
                    None => (sight, weight, largest),
                    Some((first, sum, most)) => {
                        let sum = std::array::from_fn(|k| sum[k] + weight[k]);
                        if largest > most { (sight, sum, largest) } else { (first, sum, most) }
                    }
                });
            }
            if let Some((sight, weight, _)) = little {
                self.follow(sight, way, weight, path, color, scratch);
            }
        }
    }

    /// Follows the bundle that goes on from one surface.
    fn follow(
        &self,
        sight: &Sight<'_>,
        way: Way,
        weight: Rgb,
        path: Path,
        color: &mut Rgb,
        scratch: &mut Scratch,
    ) {
        let Sight { hit, incidence, right, up } = sight;
        let (normal, index) = (hit.point.normal, hit.point.material.refraction_index);
        let path = Path { weight, depth: path.depth + 1, level: path.level };
        let (direction, bundle, frame) = match way {
            Way::Mirrored => {
                let frame = [reflect(*right, normal), reflect(*up, normal)];
                (reflect(hit.incoming, normal), incidence.mirrored(), frame)
            }
            Way::Refracted => {
                let Some(direction) = refract(hit.incoming, normal, index) else { return };
                let enters = hit.incoming.dot(normal) < 0.0;
                let (from, to) = if enters { (1.0, index) } else { (index, 1.0) };
                let bundle = incidence.refracted(direction.dot(normal), from, to);
                (direction, bundle, [*right, *up])
            }
        };
        let bundle = self.leaving(hit, direction, bundle, frame, path);
        self.trace(&bundle, path, color, scratch);
    }

    /// Adds what the four quarters of a cone see.
    fn quarter(
        &self,
        cone: &Cone,
        left: Option<Left>,
        path: Path,
        color: &mut Rgb,
        scratch: &mut Scratch,
    ) {
        scratch.counts.subdivided += 1;
        let path = Path { weight: path.weight.map(|w| w / 4.0), level: path.level + 1, ..path };
        for part in cone.quarters() {
            self.trace(&Bundle::Cone(part, left), path, color, scratch);
        }
    }

    /// What a ray hits.
    fn hit(
        &self,
        ray: &Ray<f64>,
        path: Path,
        color: &mut Rgb,
        scratch: &mut Scratch,
    ) -> Vec<Sight<'a>> {
        scratch.counts.rays += 1;
        let mut hit = [Hit::NONE];
        self.over.rays.closest_hits(&[*ray], &mut hit);
        let [hit] = hit;
        if !hit.is_hit() {
            add(color, path.weight, self.scene.background);
            return Vec::new();
        }
        let hit = self.surface(hit.id, ray.at(hit.t), ray.direction, path.weight);
        let incidence = Incidence { radius: 0.0, spread: 0.0, cosine: 1.0, curvatures: [0.0; 2] };
        vec![Sight { hit, incidence, right: DVec3::X, up: DVec3::Y }]
    }

    /// What a cone sees, and the background between; `None` when it must be cut into four.
    fn sights(
        &self,
        cone: &Cone,
        left: Option<&Left>,
        path: Path,
        color: &mut Rgb,
        scratch: &mut Scratch,
    ) -> Option<Vec<Sight<'a>>> {
        scratch.counts.cones += 1;
        let may_cut = path.level < self.settings.subdivisions;
        if may_cut && cone.spread.abs() > WIDE {
            return None;
        }
        let mut fragments = self.gather(cone, left, false, scratch);
        let found = self.compose(cone, left, &mut fragments);
        if may_cut && !found.is_certain {
            return None;
        }
        let mut sights = Vec::with_capacity(found.seen.len());
        let brightest = path.weight.into_iter().fold(0.0, f64::max);
        for (seen, stands_for) in together(&found.seen, self.settings.ray_below / brightest) {
            let fragment = &fragments[seen.fragment];
            let part = cone.part(seen.centroid, seen.share.sqrt());
            let ray = cone.ray(seen.centroid);
            let met = self.forms.depth(cone, fragment.id, seen.centroid, left);
            let depth = met.unwrap_or(fragment.depth);
            let mut position = ray.at(depth);
            if met.is_none() {
                // just beside it: the nearest point of it
                position = self.surfaces.at(fragment.id, position).foot.position;
            }
            let weight = path.weight.map(|w| w * stands_for);
            let hit = self.surface(fragment.id, position, part.axis, weight);
            let radius = part.radius_at(depth * ray.direction.length());
            // behind a focus it grows as fast as it shrank before
            let bundle = (radius.abs(), part.spread * radius.signum());
            let place = (position, hit.point.normal);
            let incidence =
                Incidence::measure(&self.surfaces, fragment.id, place, part.axis, bundle);
            if may_cut && incidence.turn() > self.settings.turn {
                return None;
            }
            let incidence = if self.settings.widening { incidence } else { incidence.flattened() };
            sights.push(Sight { hit, incidence, right: part.right, up: part.up });
        }
        if found.left_over > 0.0 {
            add(color, path.weight.map(|w| w * found.left_over), self.scene.background);
        }
        Some(sights)
    }

    /// A hit as shading wants it.
    fn surface(&self, id: u32, position: DVec3, incoming: DVec3, weight: Rgb) -> SurfaceHit<'a> {
        let origin = Origin { column: 0, sample: 0, fanned: false, time: 0.0 };
        let point = self.surfaces.at(id, position);
        let mut hit = [SurfaceHit { point, id, incoming, weight, origin }];
        self.textures.apply(&mut hit);
        let [hit] = hit;
        hit
    }

    /// The surfaces that cover a part of a cone. What comes after the cone is full may be missing.
    pub(super) fn gather(
        &self,
        cone: &Cone,
        left: Option<&Left>,
        is_shadow: bool,
        scratch: &mut Scratch,
    ) -> Vec<Fragment> {
        let [lo, hi] = self.bounds;
        let deepest = DVec3::select(cone.axis.cmpgt(DVec3::ZERO), hi, lo);
        let end = cone.locate(deepest).0.min(cone.end);
        let mut fragments: Vec<Fragment> = Vec::new();
        if end.is_nan() || end <= cone.begin {
            return fragments;
        }
        let shaft = cone.shaft(end);
        let (mut stop, mut sum) = (f64::INFINITY, 0.0);
        self.over.shafts.gather_in_order(&shaft, &mut scratch.gathered, &mut |ids, depth| {
            let before = fragments.len();
            for &id in ids {
                if is_shadow && self.forms.is_clear(id) {
                    continue;
                }
                let Some(coverage) = self.forms.cover(cone, id, left) else { continue };
                let Coverage { overlap, far, .. } = coverage;
                if is_shadow && self.is_beside_footprint(cone, id, overlap.centroid) {
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
                let met = self.forms.depth(cone, id, overlap.centroid, left);
                let depth = met.unwrap_or_else(|| self.forms.middle(cone, id));
                fragments.push(Fragment { id, depth, coverage });
            }
            let is_new = fragments.len() > before && fragments.len() <= COMBINED_EARLY;
            if !is_shadow && is_new && stop.is_infinite() && sum >= 1.0 - UNSEEN {
                let found = self.compose(cone, left, &mut fragments);
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

    /// Whether a flat surface that a shadow cone meets at once is its neighbour in a crease: it does
    /// not come between the middle of the footprint and the light, but the footprint, which is
    /// thought round, sticks out through it.
    fn is_beside_footprint(&self, cone: &Cone, id: u32, place: DVec2) -> bool {
        let is_near = |depth: f64| depth < BESIDE * cone.radius;
        self.forms.is_flat(id)
            && self.forms.depth(cone, id, place, None).is_some_and(is_near)
            && self
                .forms
                .depth(cone, id, DVec2::ZERO, None)
                .is_none_or(|depth| depth <= 0.0 || depth >= cone.end)
    }

    fn compose(&self, cone: &Cone, left: Option<&Left>, fragments: &mut [Fragment]) -> Composition {
        compose(fragments, &|id: u32, place: DVec2| self.forms.depth(cone, id, place, left))
    }

    /// Adds the light that arrives at a surface.
    fn light(&self, sight: &Sight<'_>, path: Path, color: &mut Rgb, scratch: &mut Scratch) {
        let Sight { hit, incidence, .. } = sight;
        let normal = lit_normal(hit, true);
        for &(light, light_color, radius) in &self.lights {
            let Some(shadow) = shadow_ray(hit, 0, normal, light, light_color, 1.0) else {
                continue;
            };
            let to = (light, radius);
            let visible = 1.0 - self.shadow(hit, incidence, to, path, shadow.light, scratch);
            add(color, [visible; 3], shadow.light);
        }
    }

    /// The bundle that leaves a surface: a cone of a radius and a spread, or a ray where that is
    /// nothing or the bundle contributes little.
    fn leaving(
        &self,
        hit: &SurfaceHit<'_>,
        direction: DVec3,
        (radius, spread): (f64, f64),
        [right, up]: [DVec3; 2],
        path: Path,
    ) -> Bundle {
        let is_ray = radius == 0.0 && spread == 0.0;
        let largest = path.weight.into_iter().fold(0.0, f64::max);
        if is_ray || largest < self.settings.ray_below {
            return Bundle::Ray(self.leaving.along(&hit.point, direction));
        }
        let axis = direction.normalize_or(hit.incoming);
        let cone = Cone::new(hit.point.foot.position, axis, radius, spread).across(right, up);
        let left = self.left(hit, axis);
        Bundle::Cone(self.begun(cone, &left), Some(left))
    }

    /// The surface that a bundle leaves along a direction.
    fn left(&self, hit: &SurfaceHit<'_>, direction: DVec3) -> Left {
        let foot = hit.point.foot;
        let inwards = direction.dot(foot.normal) < 0.0;
        // within a convex body, all of it is on the inner side of the surface
        let is_one_sided = self.forms.is_flat(hit.id) || self.forms.is_ball(hit.id) && inwards;
        let plane = is_one_sided.then(|| {
            let normal = if inwards { -foot.normal } else { foot.normal };
            (normal, normal.dot(foot.position) + PLANE_SLACK * foot.magnitude)
        });
        Left { id: hit.id, inwards, plane }
    }

    /// The cone that leaves a flat surface begins where its edge does, before its middle.
    fn begun(&self, mut cone: Cone, left: &Left) -> Cone {
        if let Some((normal, _)) = left.plane.filter(|_| self.forms.is_flat(left.id)) {
            let cosine = cone.axis.dot(normal).clamp(LEAST_COSINE, 1.0);
            let slope = (1.0 - cosine * cosine).sqrt() / cosine;
            // the edge recedes from the axis as the cone spreads
            cone.begin = -cone.radius * slope / (1.0 + cone.spread * slope).max(0.1);
        }
        cone
    }

    /// The share of a light that is hidden from a surface.
    fn shadow(
        &self,
        hit: &SurfaceHit<'_>,
        incidence: &Incidence,
        (light, light_radius): (DVec3, f64),
        path: Path,
        arriving: Rgb,
        scratch: &mut Scratch,
    ) -> f64 {
        let is_little = arriving.into_iter().fold(0.0, f64::max) < self.settings.ray_below;
        if light_radius <= 0.0 && (incidence.radius <= 0.0 || is_little) {
            scratch.counts.shadow_rays += 1;
            let mut blocked = [false];
            self.over.rays.occlusions(&[self.leaving.to(&hit.point, light)], &mut blocked);
            return if blocked[0] { 1.0 } else { 0.0 };
        }
        let foot = hit.point.foot;
        let towards = (light - foot.position).normalize_or(foot.normal);
        // the footprint seen from the light: as on the surface, and foreshortened
        let ratio = foot.normal.dot(towards).abs() / incidence.cosine;
        let cone = shadow_cone(foot.position, incidence.radius * ratio.sqrt(), light, light_radius);
        let left = self.left(hit, towards);
        self.blocked(&self.begun(cone, &left), &left, path.level, scratch)
    }
}

/// What is seen, and the share that each stands for: surfaces that are seen in less than `little`
/// of the cone are taken together, in order, until they are as much, and the largest stands for
/// all of them. A wide cone may see hundreds.
fn together(seen: &[Seen], little: f64) -> Vec<(Seen, f64)> {
    let mut all = Vec::with_capacity(seen.len());
    let mut group: Option<(Seen, f64)> = None;
    for &one in seen.iter().filter(|seen| seen.share > UNSEEN) {
        if one.share >= little {
            all.push((one, one.share));
            continue;
        }
        let (largest, sum) = match group {
            Some((first, sum)) if first.share >= one.share => (first, sum + one.share),
            Some((_, sum)) => (one, sum + one.share),
            None => (one, one.share),
        };
        if sum < little {
            group = Some((largest, sum));
        } else {
            all.push((largest, sum));
            group = None;
        }
    }
    all.extend(group);
    all
}

fn add(color: &mut Rgb, weight: Rgb, light: Rgb) {
    for k in 0..3 {
        color[k] += weight[k] * light[k];
    }
}
