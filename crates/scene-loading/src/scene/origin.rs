//! Rebasing: a scene far from the origin of its coordinates is moved near it, in f64, before
//! anything is rounded to f32.
//!
//! f32 has 24 bits: 5,400 km from the origin its values are half a metre apart, and boxes, which
//! are padded by 64 roundings of the largest coordinate, grow by 40 m. Readers keep f64, so nothing
//! is lost until then. [`Scene::origin`] says by how much a scene was moved; whatever speaks to
//! users adds it again ([`Scene::to_file_coordinates`], [`Scene::to_scene_coordinates`]).

use glam::DVec3;

use crate::scene::{Bounds, Scene, Warning};

/// A coordinate is rebased where the middle of the scene is more than this many extents away from
/// 0. No scene of the catalogue is that far away; what stays where it is has 20 of the 24 bits of
/// f32 left. Exact from 2.6 on (`proofs/far_scene.gappa`).
const FAR: f64 = 8.0;

/// A primitive is distorted where its longest side is less than this many roundings of f32 at its
/// place, and f32 does not hold its coordinates as they are.
const DISTORTED: f64 = 16.0;

/// Primitives drown in the padding of boxes where they are smaller than this many roundings of f32
/// at the largest coordinate of the scene: it is what most structures pad by.
const PADDING: f64 = 64.0;

/// The share of primitives that may drown. In scenes with a few large and many small ones it is
/// usual.
const MAY_DROWN: f64 = 0.9;

/// Best origin for a scene with these bounds, in the coordinates of its file; 0 along each axis
/// that is near 0 already.
///
/// Otherwise it is the roundest number within one extent of the middle, as people who cut off an
/// offset would choose: 5,411,000 for 5,411,398 and an extent of 797. Differences to it are exact
/// for all points of the scene, since they are within a factor of 2 of it (Sterbenz 1974).
pub(crate) fn origin_for(bounds: &Bounds) -> DVec3 {
    let extent = bounds.size().max_element();
    if !(extent > 0.0 && bounds.min.is_finite() && bounds.max.is_finite()) {
        return DVec3::ZERO;
    }
    let middle = bounds.min + bounds.size() * 0.5;
    middle.map(|x| if x.abs() > FAR * extent { roundest(x, extent) } else { 0.0 })
}

/// The multiple of a power of ten that is within `reach` of `x`, of the largest power that has one;
/// below 1 of powers of two, which f64 holds exactly.
fn roundest(x: f64, reach: f64) -> f64 {
    // the largest power of ten that f64 holds exactly
    let mut step = 1e22;
    loop {
        let round = (x / step).round() * step;
        if (round - x).abs() <= reach || step <= reach {
            return round;
        }
        step /= if step > 1.0 { 10.0 } else { 2.0 };
    }
}

impl Scene {
    /// Moves a scene that is far from the origin near it, and notes what is too fine for f32 even
    /// there.
    pub(crate) fn bring_near(&mut self) {
        let mut sizes = Sizes::of(self);
        let origin = origin_for(&sizes.bounds);
        if origin != DVec3::ZERO {
            self.rebase(origin);
            sizes = Sizes::of(self);
        }
        self.fine_detail = sizes.warning();
    }

    /// The same for a scene whose origin is known.
    pub(crate) fn bring_to(&mut self, origin: DVec3) {
        self.rebase(origin);
        self.fine_detail = Sizes::of(self).warning();
    }

    /// Moves the scene so that its origin is the point `origin` of its file's coordinates.
    pub fn rebase(&mut self, origin: DVec3) {
        let by = origin - self.origin;
        if by == DVec3::ZERO {
            return;
        }
        self.origin = origin;
        self.camera.from -= by;
        self.camera.at -= by;
        self.lights.iter_mut().for_each(|light| light.position -= by);
        self.vertices.iter_mut().for_each(|vertex| *vertex -= by);
        self.spheres.iter_mut().for_each(|sphere| sphere.center -= by);
        for cone in &mut self.cones {
            cone.base -= by;
            cone.apex -= by;
        }
        for instance in &mut self.instances {
            instance.placement.translation -= by;
        }
    }

    /// A point in the coordinates of the scene's file.
    pub fn to_file_coordinates(&self, point: DVec3) -> DVec3 {
        point + self.origin
    }

    /// A point of the file's coordinates where it is in the scene.
    pub fn to_scene_coordinates(&self, point: DVec3) -> DVec3 {
        point - self.origin
    }

    /// Warnings of the reader, and of details that f32 does not resolve.
    pub fn warnings_in_f32(&self) -> impl Iterator<Item = &Warning> {
        self.warnings.iter().chain(&self.fine_detail)
    }
}

/// Bounds of a scene, and how large its primitives are.
struct Sizes {
    bounds: Bounds,
    /// Primitives by the exponent of their longest side in f64. Points are not counted.
    by_exponent: Box<[u32; EXPONENTS]>,
    /// Primitives that f32 distorts.
    distorted: usize,
}

const EXPONENTS: usize = 2048;

impl Sizes {
    fn of(scene: &Scene) -> Self {
        let mut by_exponent = Box::new([0; EXPONENTS]);
        let mut distorted = 0;
        let bounds = scene.bounds_seen(|b| {
            let longest = b.size().max_element();
            if longest > 0.0 {
                if let Some(count) = by_exponent.get_mut(exponent(longest)) {
                    *count += 1;
                }
                let is_fine = longest < DISTORTED * f64::from(f32::EPSILON) * b.reach();
                distorted += usize::from(is_fine && is_rounded(b, longest));
            }
        });
        Self { bounds, by_exponent, distorted }
    }

    /// Warns where f64 gives what f32 cannot.
    fn warning(&self) -> Option<Warning> {
        let count = |counts: &[u32]| counts.iter().map(|&n| n as usize).sum::<usize>();
        let (largest, extent) = (self.bounds.reach(), self.bounds.size().max_element());
        let padding = PADDING * f64::from(f32::EPSILON) * largest;
        // certainly smaller: shorter than the largest power of two that is at most the padding
        let small = count(self.by_exponent.get(..exponent(padding)).unwrap_or_default());
        let all = count(&*self.by_exponent);
        let what = if self.distorted > 0 {
            format!("{} of {all} primitives are distorted by f32", self.distorted)
        } else if small as f64 > MAY_DROWN * all as f64 {
            format!("{small} of {all} primitives are smaller than the padding of boxes in f32")
        } else {
            return None;
        };
        Some(Warning(format!(
            "{what}: coordinates are up to {}, the extent is {}; --precision f64 resolves them",
            seven_digits(largest),
            seven_digits(extent)
        )))
    }
}

/// True where rounding a primitive's bounds to f32 moves them by a noticeable part of its longest
/// side. What a file has as f32 is not moved.
fn is_rounded(bounds: &Bounds, longest: f64) -> bool {
    let off = |p: DVec3| (p - p.as_vec3().as_dvec3()).abs().max_element();
    off(bounds.min).max(off(bounds.max)) > longest / 1024.0
}

/// Rounded to what f32 has.
fn seven_digits(x: f64) -> f64 {
    format!("{x:.6e}").parse().unwrap_or(x)
}

fn exponent(x: f64) -> usize {
    (x.to_bits() >> 52) as usize % EXPONENTS
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A number in [0, 1), the same for the same state.
    fn unit(state: &mut u64) -> f64 {
        *state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (*state >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Rounding error of `a - b` (Knuth's two-sum): 0 if the difference is exact.
    fn rounded_off(a: f64, b: f64) -> f64 {
        let difference = a - b;
        let part = difference - a;
        (a - (difference - part)) - (b + part)
    }

    fn bounds(min: DVec3, max: DVec3) -> Bounds {
        Bounds { min, max }
    }

    #[test]
    fn differences_to_the_origin_are_exact() {
        let mut state = 7;
        let (mut moved, mut planted) = (0, 0);
        for _ in 0..20_000 {
            let extent = 10f64.powf(unit(&mut state) * 12.0 - 6.0);
            let middle = extent * 10f64.powf(unit(&mut state) * 9.0) * (unit(&mut state) - 0.5);
            let [low, high] = [middle - extent * 0.5, middle + extent * 0.5];
            let b = bounds(DVec3::splat(low), DVec3::splat(high));
            let origin = origin_for(&b).x;
            if origin == 0.0 {
                assert!(middle.abs() < 9.0 * extent);
                continue;
            }
            moved += 1;
            assert!((origin - middle).abs() <= 1.01 * extent, "{middle} {extent} {origin}");
            let x = low + (high - low) * unit(&mut state);
            for x in [low, x, high] {
                assert_eq!(rounded_off(x, origin), 0.0, "{x} {origin}");
                // planted: a shift that is not exact
                planted += u32::from(rounded_off(x, origin / 3.0) != 0.0);
            }
        }
        assert!(moved > 5_000 && planted > 5_000, "{moved} {planted}");
    }

    #[test]
    fn the_origin_is_a_round_number() {
        let min = DVec3::new(448_000.05, 5_411_000.2, 212.4);
        let city = bounds(min, DVec3::new(448_796.52, 5_411_797.14, 240.16));
        assert_eq!(origin_for(&city), DVec3::new(448_000.0, 5_411_000.0, 0.0));
        for (middle, extent, origin) in [
            (5.4e6, 20.0, 5.4e6),
            (-5_400_049.0, 101.0, -5.4e6),
            (123.456, 0.1, 123.5),
            (8.1, 1.0, 8.0),
            (7.9, 1.0, 0.0),
            (1e60, 1e58, 1e60),
        ] {
            let [min, max] = [-0.5, 0.5].map(|k| DVec3::new(middle + extent * k, 0.0, 0.0));
            let b = bounds(min, max);
            assert_eq!(origin_for(&b).x, origin, "{middle} {extent}");
        }
        for nowhere in
            [Bounds::EMPTY, bounds(DVec3::ONE, DVec3::ONE), bounds(DVec3::NAN, DVec3::NAN)]
        {
            assert_eq!(origin_for(&nowhere), DVec3::ZERO);
        }
    }
}
