//! Rays traced among nearly parallel ones: a structure may share work between those.

use accel_core::{Ray, Scalar, Vec3, Vector};
use glam::DVec3;

use super::draw::{point, unit};
use statistics::random::Random;

/// Rays of a group; as many share their way at most.
const GROUP: usize = 8;

/// Rays of eights, each with one of those that are asked about.
pub struct CoherentBatch<S: Scalar> {
    pub rays: Vec<Ray<S>>,
    /// Positions of the judged rays, in their order.
    pub places: Vec<usize>,
}

impl<S: Scalar> CoherentBatch<S> {
    /// Each of these rays in a group of its own.
    pub fn of(rays: &[Ray<S>]) -> Self {
        let mut random = Random::new(rays.len() as u64, "company");
        let mut batch = Self { rays: Vec::new(), places: Vec::new() };
        for (i, ray) in rays.iter().enumerate() {
            let place = random.below(GROUP);
            batch.places.push(i * GROUP + place);
            // from a few ulps to a tenth
            let apart = 2f64.powf(-24.0 + 20.0 * unit(&mut random));
            batch.rays.extend(
                (0..GROUP).map(
                    |other| if other == place { *ray } else { beside(&mut random, ray, apart) },
                ),
            );
        }
        batch
    }
}

/// A ray whose coordinates are each off by no more than this part of them: it runs into the same
/// octant.
fn beside<S: Scalar>(random: &mut Random, ray: &Ray<S>, apart: f64) -> Ray<S> {
    let mut off = |v: Vec3<S>| {
        let factor = DVec3::ONE + point(random) * apart;
        Vec3::<S>::from_dvec3(v.to_dvec3() * factor)
    };
    Ray { origin: off(ray.origin), direction: off(ray.direction), ..*ray }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_group_rays_by_octant() {
        let mut random = Random::new(3, "company");
        let rays: Vec<Ray<f32>> = (0..400)
            .map(|_| Ray::new(point(&mut random).as_vec3(), point(&mut random).as_vec3()))
            .collect();
        let batch = CoherentBatch::of(&rays);
        assert_eq!(batch.rays.len(), GROUP * rays.len());
        let mut lanes = [0; GROUP];
        let groups = batch.rays.chunks_exact(GROUP);
        for (i, ((ray, place), group)) in rays.iter().zip(&batch.places).zip(groups).enumerate() {
            assert_eq!((place / GROUP, batch.rays[*place]), (i, *ray));
            lanes[place % GROUP] += 1;
            let like = |other: &&Ray<f32>| {
                other.direction.signum() == ray.direction.signum()
                    && other.direction.distance(ray.direction) <= 0.07 * ray.direction.length()
            };
            assert_eq!(group.iter().filter(like).count(), GROUP);
            assert!(group.iter().any(|other| other != ray));
        }
        assert!(lanes.iter().all(|&n| n > 20), "{lanes:?}");
    }
}
