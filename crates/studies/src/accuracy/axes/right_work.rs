//! Timed work of a step of `right-answers`: tracing eye rays, making secondary rays at their hits
//! and tracing them, tracing shadow rays; each part by itself.

use accel_core::query::tracer::Tracer;
use accel_core::registry::Buildable;
use accel_core::{Hit, Ray};
use renderer::RayKind;
use renderer::ray_offset::RayOffset;
use renderer::surface::SurfacePoint;

use super::secondary_rays::{GAP, SecondaryRays, height};
use crate::accuracy::parts::OFFSET_RAYS;
use crate::accuracy::stage::Work;
use crate::accuracy::stage::{Batches, fingerprint};
use measurement::rays::batches::{Answers, trace};

/// A tracer, its rays and its answers.
pub struct StepWork<'a, S: Buildable> {
    tracer: Box<dyn Tracer<S> + 'a>,
    batches: Batches<S>,
    offset: RayOffset,
    secondary_rays: Vec<(SurfacePoint<'a>, glam::DVec3)>,
    made: Vec<Ray<S>>,
    /// One for each batch, then those of the rays that are made.
    answers: Vec<Answers<S>>,
}

impl<'a, S: Buildable> StepWork<'a, S> {
    /// Traces `batches`, and the first `most` of the rays that leave surfaces.
    pub fn new(
        tracer: Box<dyn Tracer<S> + 'a>,
        batches: Batches<S>,
        offset: RayOffset,
        secondary: &SecondaryRays<'a>,
        most: usize,
    ) -> Self {
        let of_batches = batches.iter().map(|(kind, rays)| Answers::new(*kind, rays.len()));
        let first = secondary.departures.iter().take(most);
        let secondary_rays: Vec<_> = first.map(|d| (secondary.point(d), d.out)).collect();
        let made = Answers::new(RayKind::Diffuse, secondary_rays.len());
        let answers = of_batches.chain([made]).collect();
        let mut work = Self { tracer, batches, offset, secondary_rays, made: Vec::new(), answers };
        work.prepare();
        work.run();
        work
    }
}

/// Number of rays that hit the surface they leave, or begin beyond a sheet close above it.
pub fn wrong_departures<S: Buildable>(
    tracer: &dyn Tracer<S>,
    offset: RayOffset,
    secondary: &SecondaryRays<'_>,
    most: usize,
) -> u64 {
    let secondary_rays: Vec<_> = secondary.departures.iter().take(most).collect();
    let points: Vec<_> = secondary_rays.iter().map(|d| secondary.point(d)).collect();
    let rays: Vec<Ray<S>> =
        points.iter().zip(&secondary_rays).map(|(point, d)| offset.along(point, d.out)).collect();
    let mut hits = vec![Hit::NONE; rays.len()];
    tracer.closest_hits(&rays, &mut hits);
    let all = secondary_rays.iter().zip(&points).zip(&rays).zip(&hits);
    let is_wrong =
        |point: &SurfacePoint<'_>, ray: &Ray<S>| height(point, ray) > GAP * secondary.diagonal;
    all.filter(|(((d, point), ray), hit)| hit.id == d.id || is_wrong(point, ray)).count() as u64
}

impl<S: Buildable> Work for StepWork<'_, S> {
    fn prepare(&mut self) {
        self.answers.iter_mut().for_each(Answers::clear);
    }

    fn run(&mut self) {
        (0..self.answers.len()).for_each(|part| self.run_part(part));
    }

    fn fingerprint(&self) -> u64 {
        fingerprint(&self.answers)
    }

    fn parts(&self) -> Vec<String> {
        let kinds = self.batches.iter().map(|(kind, _)| kind.name().to_owned());
        kinds.chain([OFFSET_RAYS.to_owned()]).collect()
    }

    fn run_part(&mut self, part: usize) {
        let Some(answers) = self.answers.get_mut(part) else { return };
        let rays = match self.batches.get(part) {
            Some((_, rays)) => rays,
            None => {
                self.made.clear();
                let offset = self.offset;
                let made = self.secondary_rays.iter().map(|(point, out)| offset.along(point, *out));
                self.made.extend(made);
                &self.made
            }
        };
        trace(&*self.tracer, rays, answers);
    }
}
