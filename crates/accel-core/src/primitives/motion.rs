//! How the primitives of a set move (see `moving.rs`).

use std::cmp::Reverse;

use glam::DVec3;

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};

/// How the primitives of a set move.
#[derive(Debug, Clone)]
pub(crate) struct Motion<S: Scalar> {
    /// Velocity index by id; ids beyond the end are at rest.
    which: Vec<u32>,
    /// World units per unit of time; the first is zero. What belongs together has one, so that
    /// blocks of it are known by their numbers.
    velocities: Vec<[S; 3]>,
    /// The number that most primitives have.
    usual: u32,
    /// They move from time 0 to this one.
    exposure: S,
    /// The times of which bounds hold the way: all of them, or a segment's.
    span: [S; 2],
    /// By how much the bounds of a segment are larger.
    margin: S,
}

impl<S: Scalar> Default for Motion<S> {
    fn default() -> Self {
        let (which, zero) = (Vec::new(), S::ZERO);
        let velocities = vec![[zero; 3]];
        Self { which, velocities, usual: 0, exposure: zero, span: [zero; 2], margin: zero }
    }
}

impl<S: Scalar> Motion<S> {
    /// Lets a primitive move.
    pub fn set(&mut self, id: u32, velocity: DVec3, exposure: f64) {
        let velocity = Vec3::<S>::from_dvec3(velocity).to_array();
        let number = if velocity == [S::ZERO; 3] {
            0
        } else {
            if self.velocities.len() == 1 || self.velocities.last() != Some(&velocity) {
                self.velocities.push(velocity);
            }
            self.velocities.len() as u32 - 1
        };
        self.hold(id as usize + 1);
        self.which[id as usize] = number;
        self.exposure = S::from_f64(exposure);
        self.span = [S::ZERO, self.exposure];
    }

    /// Has a number for each of so many primitives, and maybe more.
    pub fn hold(&mut self, primitives: usize) {
        self.which.resize(primitives.max(self.which.len()), 0);
    }

    /// The same, once no more are set.
    pub fn settle(&mut self, primitives: usize) {
        self.hold(primitives);
        let mut counts = vec![0_u32; self.velocities.len()];
        self.which.iter().for_each(|&number| counts[number as usize] += 1);
        let most = (0..).zip(counts).max_by_key(|&(number, count)| (count, Reverse(number)));
        self.usual = most.map_or(0, |(number, _): (u32, u32)| number);
    }

    /// From now on bounds are those of segment `k` of `n` equal ones of the exposure, a little more
    /// of it on both sides, and larger by `margin`.
    pub fn narrow_to(&mut self, k: usize, n: usize, margin: S) {
        let exposure = self.exposure.to_f64();
        let rounding = 4.0 * S::EPSILON.to_f64();
        let at = |part: f64| S::from_f64(exposure * part.clamp(0.0, 1.0));
        self.span = [at(k as f64 / n as f64 - rounding), at((k + 1) as f64 / n as f64 + rounding)];
        self.margin = margin;
    }

    /// Index of the segment, of `n` equal ones of the exposure, that contains a moment.
    #[inline(always)]
    pub(crate) fn segment(&self, time: S, n: usize) -> usize {
        // NaN and what is below 0 give 0
        let part = time.to_f64() / self.exposure.to_f64() * n as f64;
        (part as usize).min(n - 1)
    }

    /// The moment of a ray: what moves stands still before its exposure and after it.
    #[inline(always)]
    pub(crate) fn moment(&self, time: S) -> S {
        if time > self.exposure {
            self.exposure
        } else if time > S::ZERO {
            time
        } else {
            S::ZERO
        }
    }

    /// By how much bounds are larger than the way.
    pub(crate) fn margin(&self) -> S {
        self.margin
    }

    pub fn any(&self) -> bool {
        !self.which.is_empty()
    }

    /// Its velocity, zero if it is at rest.
    #[inline(always)]
    pub(crate) fn velocity_or_zero(&self, id: u32) -> &[S; 3] {
        let number = self.which.get(id as usize).map_or(0, |&number| number) as usize;
        debug_assert!(number < self.velocities.len(), "numbers are those of velocities");
        // SAFETY: the first is always there, and `set` alone gives numbers, of velocities that stay
        unsafe { self.velocities.get_unchecked(number) }
    }

    /// The velocity that most primitives have.
    #[inline(always)]
    pub(crate) fn usual_velocity(&self) -> &[S; 3] {
        &self.velocities[self.usual as usize]
    }

    /// Its velocity, unless that is the most frequent one.
    #[inline(always)]
    pub(crate) fn unusual_velocity(&self, id: u32) -> Option<&[S; 3]> {
        let number = self.which.get(id as usize).map_or(0, |&number| number);
        // SAFETY: as in `velocity_or_zero`
        (number != self.usual).then(|| unsafe { self.velocities.get_unchecked(number as usize) })
    }

    /// Returns whether all of these move alike, as far as numbers tell.
    pub(crate) fn is_one(&self, ids: &[u32]) -> bool {
        let which = |id: &u32| self.which.get(*id as usize).map_or(0, |&number| number);
        ids.windows(2).all(|two| which(&two[0]) == which(&two[1]))
    }

    /// Its velocity, if it moves.
    #[inline(always)]
    pub(crate) fn velocity(&self, id: u32) -> Option<Vec3<S>> {
        let number = *self.which.get(id as usize)? as usize;
        (number != 0).then(|| Vec3::<S>::from_array(self.velocities[number]))
    }

    /// Offsets of a primitive at both ends of the time span of its bounds.
    pub fn displacements(&self, id: u32) -> Option<[DVec3; 2]> {
        let velocity = self.velocity(id)?;
        Some(self.span.map(|time| (velocity * time).to_dvec3()))
    }

    /// Bounds of the whole way, from those at time 0. Rounding is left to the padding of boxes.
    pub fn swept(&self, id: u32, still: Aabb<S>) -> Aabb<S> {
        let Some(velocity) = self.velocity(id) else { return still };
        let [first, last] = self.span.map(|time| velocity * time);
        if !last.is_finite() {
            return Aabb { min: last, max: last };
        }
        let at = |way| Aabb { min: still.min + way, max: still.max + way };
        at(first).union(at(last))
    }

    /// Extent of the whole way along `direction`, from that at time 0.
    pub fn swept_extent(&self, id: u32, still: (f64, f64), direction: DVec3) -> (f64, f64) {
        let Some(displacements) = self.displacements(id) else { return still };
        let [first, last] = displacements.map(|way| way.dot(direction));
        (still.0 + first.min(last), still.1 + first.max(last))
    }

    /// Bytes of the velocities.
    pub fn bytes(&self) -> usize {
        size_of_val(self.which.as_slice()) + size_of_val(self.velocities.as_slice())
    }
}
