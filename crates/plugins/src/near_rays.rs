//! Rays as a plugin is asked them. Far ones are brought near, and those that are no rays are left
//! out, as they are before our structures see them (`accel_core::geometry::far_ray`); for a plugin
//! that is in no time.

use accel_core::geometry::far_ray::{self, Parameters, PlacedRay};
use accel_core::{Hit, Ray, Scalar};

/// Those rays of a batch that are asked.
pub(crate) struct NearRays<S: Scalar> {
    pub(crate) rays: Vec<Ray<S>>,
    /// For each its place in the batch, and how its parameters become those of the ray there.
    places: Vec<(usize, Parameters<S>)>,
}

impl<S: Scalar> NearRays<S> {
    /// Of a batch; none where all can be asked as they are.
    pub(crate) fn of(batch: &[Ray<S>], reach: S) -> Option<Self> {
        let place = |ray: &Ray<S>| far_ray::place(ray, reach);
        let first = batch.iter().position(|ray| !matches!(place(ray), PlacedRay::Near))?;
        let mut this = Self {
            rays: batch[..first].to_vec(),
            places: (0..first).map(|i| (i, Parameters::SAME)).collect(),
        };
        for (i, ray) in batch.iter().enumerate().skip(first) {
            let (ray, parameters) = match place(ray) {
                PlacedRay::Near => (*ray, Parameters::SAME),
                PlacedRay::Moved(ray, parameters) => (ray, parameters),
                PlacedRay::Nowhere => continue,
            };
            this.rays.push(ray);
            this.places.push((i, parameters));
        }
        Some(this)
    }

    /// Asks for closest hits. `hits` holds what counts where none is written.
    pub(crate) fn closest(
        &self,
        batch: &[Ray<S>],
        hits: &mut [Hit<S>],
        ask: impl FnOnce(&[Ray<S>], &mut [Hit<S>]),
    ) {
        let mut own: Vec<Hit<S>> = self.places.iter().map(|(i, _)| hits[*i]).collect();
        ask(&self.rays, &mut own);
        for (hit, ray) in hits.iter_mut().zip(batch) {
            *hit = Hit { t: ray.t_max, ..Hit::NONE };
        }
        for ((i, parameters), hit) in self.places.iter().zip(own) {
            if hit.is_hit() {
                hits[*i] = Hit { t: parameters.restored(hit.t), ..hit };
            }
        }
    }

    /// The same of occlusions.
    pub(crate) fn occluded(&self, blocked: &mut [bool], ask: impl FnOnce(&[Ray<S>], &mut [bool])) {
        let mut own: Vec<bool> = self.places.iter().map(|(i, _)| blocked[*i]).collect();
        ask(&self.rays, &mut own);
        blocked.fill(false);
        for ((i, _), own) in self.places.iter().zip(own) {
            blocked[*i] = own;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn far_rays_are_moved_near_and_others_unchanged() {
        let ray = |x: f32, d: f32| Ray::<f32>::new([x, 0.0, 0.0].into(), [d, 0.0, 0.0].into());
        let reach = far_ray::reach(1.0f32);
        assert!(NearRays::of(&[ray(2.0, -1.0), ray(-7.0, 1.0)], reach).is_none());
        let batch = [ray(2.0, -1.0), ray(1e6, 1.0), ray(1e6, -1.0), ray(0.0, f32::NAN)];
        let near = NearRays::of(&batch, reach).unwrap();
        assert_eq!(near.rays.len(), 2);
        let mut hits = [Hit { t: f32::NAN, id: 7 }; 4];
        near.closest(&batch, &mut hits, |rays, hits| {
            for (ray, hit) in rays.iter().zip(hits) {
                assert!(ray.origin.x.abs() < 8.0 && hit.id == 7, "{ray:?}");
                *hit = Hit { t: ray.origin.x, id: 3 };
            }
        });
        assert_eq!(hits.map(|hit| hit.is_hit()), [true, false, true, false]);
        assert!(hits[0].t == 2.0 && (hits[2].t - 1e6).abs() < 1.0, "{hits:?}");
        assert_eq!(hits[1].t, f32::INFINITY);
        // what is not written stays so, and what is not asked is a miss
        let mut hits = [Hit { t: f32::NAN, id: 7 }; 4];
        near.closest(&batch, &mut hits, |_, _| {});
        assert_eq!(hits.map(|hit| hit.id == 7), [true, false, true, false]);
        let mut blocked = [true; 4];
        near.occluded(&mut blocked, |rays, _| assert_eq!(rays.len(), 2));
        assert_eq!(blocked, [true, false, true, false]);
    }
}
