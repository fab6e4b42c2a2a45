//! Eight rays by axis and lane, for what is derived from all of them at once.

use crate::geometry::lanes::{Eight, Lanes};
use crate::geometry::ray::Ray;
use crate::geometry::scalar::{EightOf, Scalar, Vec3, Vector};

/// Rays of a group.
pub const LANES: usize = 8;

#[derive(Debug, Clone, Copy)]
#[repr(align(32))]
pub struct RayLanes<S> {
    pub origin: [[S; LANES]; 3],
    pub direction: [[S; LANES]; 3],
    pub t_min: [S; LANES],
    pub t_max: [S; LANES],
}

impl<S: Scalar> RayLanes<S> {
    #[inline(always)]
    pub fn of(rays: &[Ray<S>; LANES]) -> Self {
        let mut rows = [[S::ZERO; LANES]; LANES];
        for (row, ray) in rows.iter_mut().zip(rays) {
            let ([x, y, z], [dx, dy, dz]) = (ray.origin.to_array(), ray.direction.to_array());
            *row = [x, y, z, dx, dy, dz, ray.t_min, ray.t_max];
        }
        let columns = EightOf::<S>::transposed(rows.map(EightOf::<S>::new));
        let [x, y, z, dx, dy, dz, t_min, t_max] = columns.map(EightOf::<S>::to_array);
        Self { origin: [x, y, z], direction: [dx, dy, dz], t_min, t_max }
    }

    #[inline(always)]
    pub fn ray(&self, lane: usize) -> Ray<S> {
        let origin = Vec3::<S>::from_array(lane_of(&self.origin, lane));
        let direction = Vec3::<S>::from_array(lane_of(&self.direction, lane));
        Ray { t_min: self.t_min[lane], t_max: self.t_max[lane], ..Ray::new(origin, direction) }
    }
}

/// What a lane has on each axis.
#[inline(always)]
pub(crate) fn lane_of<T: Copy>(columns: &[[T; LANES]; 3], lane: usize) -> [T; 3] {
    [columns[0][lane], columns[1][lane], columns[2][lane]]
}

#[cfg(test)]
pub(crate) mod tests {
    use glam::DVec3;

    use super::*;
    use crate::structures::test_scenes::Random;

    /// Rays at the unit cube: of any direction, along an axis, in planes of sixteenths, and past
    /// it; some end at 1.
    pub(crate) fn rays_at_unit_cube<S: Scalar, const N: usize>(
        random: &mut Random,
        round: usize,
    ) -> [Ray<S>; N] {
        std::array::from_fn(|lane| {
            let mut point = || {
                let point = random.point([2.0; 3]) - 0.5;
                if (round + lane).is_multiple_of(3) { (point * 16.0).round() / 16.0 } else { point }
            };
            let (from, to) = (point(), point());
            let mut d = to - from;
            match (round + lane) % 7 {
                0 => d = DVec3::X * d.x.signum(),
                1 => d.y = 0.0,
                2 => d.z = -1e-30,
                _ => {}
            }
            let mut ray = Ray::<S>::from_dvec3(from, d);
            ray.t_max = if round.is_multiple_of(4) { S::ONE } else { S::INFINITY };
            ray
        })
    }
}
