//! One cone after another: query, combine, shade, and send cones on.
//!
//! Paper: J. Amanatides, "Ray Tracing with Cones", SIGGRAPH 1984. The surface model is that of
//! [`crate::tracers::whitted`], whose functions say what light arrives.

use accel_core::{Hit, Ray};
use glam::DVec3;
use scene_loading::Rgb;

use super::circular_cone::Cone;
use super::compose::VisibleSurface;
use super::widening::Incidence;
use super::{Caster, ConeTracer, Path, UNSEEN};
use crate::effects::{HitStage, Origin, SurfaceHit, lit_normal, shadow_ray};
use crate::surface::{reflect, refract};

/// Cones that spread more than this are cut into four: half an angle of 27 degrees.
const WIDE: f64 = 0.5;

enum Bundle {
    Ray(Ray<f64>),
    Cone(Cone),
}

/// A surface that is seen, and the cone that sees it.
struct Sighting<'s> {
    hit: SurfaceHit<'s>,
    incidence: Incidence,
    right: DVec3,
    up: DVec3,
}

/// How a bundle goes on.
#[derive(Clone, Copy)]
enum Continuation {
    Mirrored,
    Refracted,
}

impl Continuation {
    /// Contribution of a bundle that continues from a surface.
    fn weight(self, sight: &Sighting<'_>) -> Rgb {
        let material = sight.hit.point.material;
        let share = match self {
            Self::Mirrored => material.specular,
            Self::Refracted => material.transmittance,
        };
        sight.hit.weight.map(|w| w * share)
    }
}

impl<'a> ConeTracer<'_, 'a> {
    /// The colour that a cone from the eye sees.
    pub fn look(&mut self, cone: Cone) -> Rgb {
        let bundle = if cone.is_ray() {
            Bundle::Ray(Ray::<f64>::new(cone.origin, cone.axis))
        } else {
            Bundle::Cone(cone)
        };
        self.color = [0.0; 3];
        let path = Path { weight: [1.0; 3], depth: 1, level: 0 };
        if self.on.max_depth > 0 {
            self.trace(&bundle, path);
        }
        self.color
    }

    fn trace(&mut self, bundle: &Bundle, path: Path) {
        let sights = match bundle {
            Bundle::Ray(ray) => self.hit(ray, path),
            Bundle::Cone(cone) => match self.sights(cone, path) {
                Some(sights) => sights,
                None => return self.quarter(cone, path),
            },
        };
        for sight in &sights {
            self.light(sight, path);
        }
        if path.depth < self.on.max_depth {
            self.go_on(&sights, path);
        }
    }

    /// Follows what goes on from the surfaces that a bundle sees. Those that contribute little do
    /// so through the largest of them: a wide cone may see hundreds of mirrors.
    fn go_on(&mut self, sights: &[Sighting<'_>], path: Path) {
        for way in [Continuation::Mirrored, Continuation::Refracted] {
            let mut little: Option<(&Sighting<'_>, Rgb, f64)> = None;
            for sight in sights {
                let weight = way.weight(sight);
                let largest = weight.into_iter().fold(0.0, f64::max);
                if largest <= 0.0 {
                    continue;
                }
                if largest >= self.on.settings.ray_below {
                    self.follow(sight, way, weight, path);
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
                self.follow(sight, way, weight, path);
            }
        }
    }

    /// Follows the bundle that goes on from one surface.
    fn follow(&mut self, sight: &Sighting<'_>, way: Continuation, weight: Rgb, path: Path) {
        let Sighting { hit, incidence, right, up } = sight;
        let (normal, index) = (hit.point.normal, hit.point.material.refraction_index);
        let path = Path { weight, depth: path.depth + 1, level: path.level };
        let (direction, bundle, frame) = match way {
            Continuation::Mirrored => {
                let frame = [reflect(*right, normal), reflect(*up, normal)];
                (reflect(hit.incoming, normal), incidence.mirrored(), frame)
            }
            Continuation::Refracted => {
                let Some(direction) = refract(hit.incoming, normal, index) else { return };
                let enters = hit.incoming.dot(normal) < 0.0;
                let (from, to) = if enters { (1.0, index) } else { (index, 1.0) };
                let bundle = incidence.refracted(direction.dot(normal), from, to);
                (direction, bundle, [*right, *up])
            }
        };
        let bundle = self.on.secondary_ray(hit, direction, bundle, frame, path);
        self.trace(&bundle, path);
    }

    /// Adds what the four quarters of a cone see.
    fn quarter(&mut self, cone: &Cone, path: Path) {
        self.counts.subdivided += 1;
        let path = Path { weight: path.weight.map(|w| w / 4.0), level: path.level + 1, ..path };
        for part in cone.quarters() {
            self.trace(&Bundle::Cone(part), path);
        }
    }

    fn hit(&mut self, ray: &Ray<f64>, path: Path) -> Vec<Sighting<'a>> {
        self.counts.rays += 1;
        let mut hit = [Hit::NONE];
        self.on.over.rays.closest_hits(&[*ray], &mut hit);
        let [hit] = hit;
        if !hit.is_hit() {
            self.add(path.weight, self.on.scene.background);
            return Vec::new();
        }
        let hit = self.on.surface(hit.id, ray.at(hit.t), ray.direction, path.weight);
        let incidence = Incidence { radius: 0.0, spread: 0.0, cosine: 1.0, curvatures: [0.0; 2] };
        vec![Sighting { hit, incidence, right: DVec3::X, up: DVec3::Y }]
    }

    /// Surfaces and background seen by a cone; `None` if it must be split into four.
    fn sights(&mut self, cone: &Cone, path: Path) -> Option<Vec<Sighting<'a>>> {
        self.counts.cones += 1;
        let on = self.on;
        let may_cut = path.level < on.settings.subdivisions;
        if may_cut && cone.spread.abs() > WIDE {
            return None;
        }
        let mut fragments = self.fragments(cone, false);
        let found = on.compose(cone, &mut fragments);
        if may_cut && !found.is_certain {
            return None;
        }
        let mut sights = Vec::with_capacity(found.seen.len());
        let brightest = path.weight.into_iter().fold(0.0, f64::max);
        for (seen, stands_for) in together(&found.seen, on.settings.ray_below / brightest) {
            let fragment = &fragments[seen.fragment];
            let part = cone.part(seen.centroid, seen.share.sqrt());
            let ray = cone.ray(seen.centroid);
            let met = on.forms.depth(cone, fragment.id, seen.centroid);
            let depth = met.unwrap_or(fragment.depth);
            let mut position = ray.at(depth);
            if met.is_none() {
                // just beside it: the nearest point of it
                position = on.surfaces.at(fragment.id, position).refined.position;
            }
            let weight = path.weight.map(|w| w * stands_for);
            let hit = on.surface(fragment.id, position, part.axis, weight);
            let radius = part.radius_at(depth * ray.direction.length());
            // behind a focus it grows as fast as it shrank before
            let bundle = (radius.abs(), part.spread * radius.signum());
            let place = (position, hit.point.normal);
            let incidence = Incidence::measure(&on.surfaces, fragment.id, place, part.axis, bundle);
            if may_cut && incidence.turn() > on.settings.turn {
                return None;
            }
            let incidence = if on.settings.widening { incidence } else { incidence.flattened() };
            sights.push(Sighting { hit, incidence, right: part.right, up: part.up });
        }
        if found.left_over > 0.0 {
            self.add(path.weight.map(|w| w * found.left_over), on.scene.background);
        }
        Some(sights)
    }

    /// Adds the light that arrives at a surface.
    fn light(&mut self, sight: &Sighting<'_>, path: Path) {
        let Sighting { hit, incidence, .. } = sight;
        let normal = lit_normal(hit, true);
        for &(light, color, radius) in &self.on.lights {
            let Some(shadow) = shadow_ray(hit, 0, normal, light, color, 1.0) else { continue };
            let visible = 1.0 - self.shadow(hit, incidence, (light, radius), path, shadow.light);
            self.add([visible; 3], shadow.light);
        }
    }

    fn add(&mut self, weight: Rgb, light: Rgb) {
        self.color = std::array::from_fn(|k| self.color[k] + weight[k] * light[k]);
    }
}

impl<'a> Caster<'a> {
    /// A hit as shading wants it.
    fn surface(&self, id: u32, position: DVec3, incoming: DVec3, weight: Rgb) -> SurfaceHit<'a> {
        let origin = Origin { column: 0, sample: 0, fanned: false, time: 0.0 };
        let point = self.surfaces.at(id, position);
        let mut hit = [SurfaceHit { point, id, incoming, weight, origin }];
        self.textures.apply(&mut hit);
        let [hit] = hit;
        hit
    }

    /// The bundle that leaves a surface: a cone of a radius and a spread, or a ray where that is
    /// nothing or the bundle contributes little.
    fn secondary_ray(
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
            return Bundle::Ray(self.offset.along(&hit.point, direction));
        }
        let axis = direction.normalize_or(hit.incoming);
        let cone = Cone::new(hit.point.refined.position, axis, radius, spread).across(right, up);
        Bundle::Cone(self.leaving(hit, axis, cone))
    }
}

/// Merges surfaces that cover less than `little` of the cone, in order; the largest represents them
/// with their total share. A wide cone may see hundreds.
fn together(seen: &[VisibleSurface], little: f64) -> Vec<(VisibleSurface, f64)> {
    let mut all = Vec::with_capacity(seen.len());
    let mut group: Option<(VisibleSurface, f64)> = None;
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
