//! Finds the light of a shadow ray, for any number of lights.

use glam::DVec3;

use crate::geometry::ray::Ray;
use crate::geometry::scalar::{Scalar, Vector};

/// A direction of length 1 along which the points of no lattice that people make lie side by side.
const SWEPT: DVec3 = DVec3::new(0.546_916_3, 0.681_730_2, 0.485_900_2);

/// The places of lights, sorted along one direction: two places are no nearer to each other than
/// they are along it, so that few have to be looked at.
#[derive(Debug, Clone)]
pub struct NearestLight {
    /// Place along the direction, place, number; of lights in one place the first.
    lights: Vec<(f64, DVec3, u32)>,
    /// Upper bound of the rounding error of a position along the direction.
    rounding: f64,
}

impl NearestLight {
    /// Sorts them; a light's number is its position in `lights`.
    pub fn new(lights: &[DVec3]) -> Self {
        let along = |(&place, number): (&DVec3, u32)| (place.dot(SWEPT), place, number);
        let mut lights: Vec<_> = lights.iter().zip(0..).map(along).collect();
        lights.sort_by(|a, b| a.0.total_cmp(&b.0));
        lights.dedup_by_key(|light| light.1);
        let farthest = lights.iter().map(|light| light.1.abs().max_element()).fold(0.0, f64::max);
        Self { lights, rounding: 8.0 * f64::EPSILON * farthest }
    }

    /// The light that each ray runs to: the nearest to where it ends.
    pub fn of_each<S: Scalar>(&self, rays: &[Ray<S>]) -> Vec<u32> {
        rays.iter().map(|ray| self.of(ray)).collect()
    }

    /// The light nearest to where the ray ends, the first of several; 0 without lights, or for a
    /// ray without an end.
    fn of<S: Scalar>(&self, ray: &Ray<S>) -> u32 {
        let end = ray.at(ray.t_max).to_dvec3();
        let along = end.dot(SWEPT);
        if !along.is_finite() {
            return 0;
        }
        let (before, behind) = self.lights.split_at(self.lights.partition_point(|l| l.0 < along));
        let mut nearest = (f64::INFINITY, 0);
        self.look(before.iter().rev(), end, along, &mut nearest);
        self.look(behind.iter(), end, along, &mut nearest);
        nearest.1
    }

    /// Looks at lights ever farther along the direction, until no other can be nearer.
    fn look<'a>(
        &self,
        lights: impl Iterator<Item = &'a (f64, DVec3, u32)>,
        end: DVec3,
        along: f64,
        nearest: &mut (f64, u32),
    ) {
        let rounding = self.rounding + 8.0 * f64::EPSILON * along.abs();
        for &(of_light, place, number) in lights {
            let apart = (of_light - along).abs() - rounding;
            if apart > 0.0 && apart * apart > nearest.0 {
                return;
            }
            let found = (place.distance_squared(end), number);
            if found < *nearest {
                *nearest = found;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structures::test_scenes::Random;

    /// The first of the lights that are nearest to a place, by looking at all.
    fn by_all(lights: &[DVec3], end: DVec3) -> u32 {
        let found = lights.iter().zip(0..).map(|(l, i): (_, u32)| (l.distance_squared(end), i));
        found.min_by(|a, b| a.partial_cmp(b).expect("finite")).map_or(0, |found| found.1)
    }

    #[test]
    fn the_nearest_light_equals_a_linear_search() {
        let place = |i| DVec3::new((i % 8) as f64, (i / 8 % 8) as f64, (i / 64) as f64);
        let lattice: Vec<_> = (0..512).map(place).collect();
        let far: Vec<_> = lattice.iter().map(|&place| place * 1e-3 + 1e6).collect();
        let twice = [lattice.clone(), lattice.clone()].concat();
        for lights in [vec![], vec![DVec3::ONE], vec![DVec3::ONE; 100], lattice, far, twice] {
            let sorted = NearestLight::new(&lights);
            let mut random = Random(9);
            for i in 0..500 {
                let nearby = lights.get(i % lights.len().max(1)).copied().unwrap_or_default();
                let end =
                    nearby + (random.point([1.0; 3]) - 0.5) * [0.0, 1e-9, 0.01, 3.0, 1e4][i % 5];
                let ray = Ray { t_max: 1.0, ..Ray::new(DVec3::ZERO, end) };
                let expected = by_all(&lights, end);
                assert_eq!(sorted.of(&ray), expected, "{end} of {} lights", lights.len());
            }
        }
    }
}
