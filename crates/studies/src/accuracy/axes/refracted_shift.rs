//! Exit points of refracted rays from glass, with and without an offset at their entry.
//!
//! An offset along the normal moves the ray sideways within the body, by the offset times the
//! tangent of its angle to the normal, all to the same side: it defocuses a lens (W. Jakob and
//! others, Mitsuba 3, issue 219, 2022). Everything the eye sees is taken for glass here. The rays
//! of the rules are traced in double precision, so that nothing but their start is judged.

use accel_core::query::tracer::Tracer;
use accel_core::{Hit, Ray, Vector};
use glam::DVec3;
use renderer::Geometry;
use renderer::ray_offset::OffsetRule;
use renderer::surface::{SurfacePoint, refract};

use super::secondary_rays::{Columns, Departure, GAP, RayPurpose, SecondaryRays, Ways, quantile};
use crate::accuracy::axis::*;

const INDEX: f64 = 1.5;

/// An exact ray begins so many diagonals from its refined hit: rounding in f64 is 10^6 times less.
const BEGIN: f64 = 1e-10;

/// Rays into what the eye sees, and where they leave it without an offset.
pub struct GlassEntries<'a> {
    double: Box<dyn Tracer<f64> + 'a>,
    ways: Ways<'a>,
    exact: Vec<DVec3>,
}

impl<'a> GlassEntries<'a> {
    /// Over the scene's primitives in double precision.
    pub fn new(
        stage: &Stage<'_>,
        secondary: &SecondaryRays<'a>,
        geometry: &'a Geometry<f64>,
    ) -> Result<Self, StudyError> {
        let double = stage.over(TRACER, geometry)?.tracer;
        let entering = |d: &Departure| {
            let point = secondary.point(d);
            Some((point, refracted(&point, d.incoming)?))
        };
        let entries: Vec<_> = secondary.departures.iter().filter_map(entering).collect();
        let t_min = BEGIN * secondary.diagonal;
        let rays = entries.iter().map(|(point, along)| (point.refined.position, *along));
        let rays = rays.map(|(from, along)| Ray { t_min, ..Ray::new(from, along) });
        let exact: Vec<Ray<f64>> = rays.collect();
        let exits = exits(&*double, &exact);
        // what goes into an open surface may not come out
        let inside = entries.into_iter().zip(exits);
        let (ways, exact) = inside
            .filter_map(|((point, along), exit)| Some(((point, RayPurpose::Along(along)), exit?)))
            .unzip();
        Ok(Self { double, ways, exact })
    }

    /// How far a rule moves the exits; nothing where no refracted ray leaves what it enters.
    pub fn columns(&self, secondary: &SecondaryRays<'_>, rule: OffsetRule) -> Columns {
        if self.exact.is_empty() {
            return Vec::new();
        }
        let work = secondary.work(rule, self.ways.clone());
        let made: Vec<Ray<f64>> = work.outcomes().map(|(_, ray, _)| ray.widened()).collect();
        let diagonal = secondary.diagonal;
        let found = Shifts::of(&self.exact, &exits(&*self.double, &made), GAP * diagonal);
        let shift = |share| quantile(&found.shifts, share) / diagonal * 1e9;
        let elsewhere = in_a_million(found.elsewhere, self.exact.len() as u64);
        vec![
            ("refracted rays elsewhere in 10^6", elsewhere),
            ("refracted rays moved by 10^-9 diagonals, median", shift(0.5)),
            ("refracted rays moved by 10^-9 diagonals, most", shift(1.0)),
        ]
    }

    pub fn words(&self) -> String {
        format!("{} rays into what is seen, of index {INDEX}", self.exact.len())
    }
}

/// The direction within the glass, rounded as that of a ray is; none where the shading normal sends
/// the ray back out.
fn refracted(point: &SurfacePoint<'_>, incoming: DVec3) -> Option<DVec3> {
    let along = incoming.normalize_or_zero();
    let facing = |n: DVec3| if n.dot(along) > 0.0 { -n } else { n };
    let within = refract(along, facing(point.normal), INDEX)?.as_vec3().as_dvec3();
    (within.dot(facing(point.refined.normal)) < 0.0).then_some(within)
}

/// Points at which rays meet a surface.
fn exits(tracer: &dyn Tracer<f64>, rays: &[Ray<f64>]) -> Vec<Option<DVec3>> {
    let mut hits = vec![Hit::NONE; rays.len()];
    tracer.closest_hits(rays, &mut hits);
    let at = |(ray, hit): (&Ray<f64>, &Hit<f64>)| {
        hit.is_hit().then(|| ray.origin.to_dvec3() + ray.direction.to_dvec3() * hit.t)
    };
    rays.iter().zip(&hits).map(at).collect()
}

/// How far points of exit moved.
#[derive(Debug, Default)]
struct Shifts {
    /// Rays that leave another surface, or none: farther than the gap.
    elsewhere: u64,
    /// Shifts of the others, in world units, ascending.
    shifts: Vec<f64>,
}

impl Shifts {
    fn of(exact: &[DVec3], exits: &[Option<DVec3>], gap: f64) -> Self {
        let mut found = Self::default();
        for (exact, exit) in exact.iter().zip(exits) {
            match exit.map(|exit| exit.distance(*exact)) {
                Some(shift) if shift <= gap => found.shifts.push(shift),
                _ => found.elsewhere += 1,
            }
        }
        found.shifts.sort_by(f64::total_cmp);
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verify::subject::with_brute_force;
    use glam::dvec3;
    use renderer::surface::Surfaces;
    use scene_loading::Scene;

    /// A pane of glass from z = 0 to z = -1, entered at the origin at 45 degrees: planted offsets
    /// into it, and what they make of the exit.
    fn through_a_pane(offset: f64, gap: f64) -> (Shifts, f64) {
        let (mut scene, material) = Scene::of_one_material("pane");
        for z in [0.0, -1.0] {
            let corners = [(-9.0, -9.0), (9.0, -9.0), (0.0, 9.0)];
            scene.push_triangle(material, corners.map(|(x, y)| dvec3(x, y, z)));
        }
        let incoming = dvec3(1.0, 0.0, -1.0).normalize();
        let point = Surfaces::new(&scene, false).at(0, DVec3::ZERO);
        let within = refracted(&point, incoming).unwrap();
        let ray = |depth: f64| Ray::<f64>::new(point.refined.position - DVec3::Z * depth, within);
        let exact = Ray { t_min: 1e-9, ..ray(0.0) };
        let geometry = Geometry::<f64>::of(&scene).unwrap();
        let found = with_brute_force(geometry.prims(), |tracer| {
            let exact: Vec<DVec3> = exits(tracer, &[exact]).into_iter().flatten().collect();
            Shifts::of(&exact, &exits(tracer, &[ray(offset)]), gap)
        });
        (found.unwrap(), within.x / -within.z)
    }

    #[test]
    fn an_offset_moves_the_exit_by_its_tangent() {
        let (found, tangent) = through_a_pane(1e-3, 0.1);
        // Snell: the sine within is that of 45 degrees over the index
        let sine = 0.5_f64.sqrt() / INDEX;
        assert!((tangent - sine / (1.0 - sine * sine).sqrt()).abs() < 1e-6);
        assert!((quantile(&found.shifts, 0.5) - 1e-3 * tangent).abs() < 1e-12);
        assert_eq!(found.elsewhere, 0);
    }

    #[test]
    fn a_self_hit_and_a_leak_come_out_elsewhere() {
        // planted: no offset and no interval, so that the ray leaves where it enters
        assert_eq!(through_a_pane(0.0, 0.1).0.elsewhere, 1);
        // planted: through the pane
        assert_eq!(through_a_pane(1.5, 0.1).0.elsewhere, 1);
        assert_eq!(through_a_pane(1e-3, 1e-4).0.elsewhere, 1);
    }
}
