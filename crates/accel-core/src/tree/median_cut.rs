//! Neighbouring primitives: sets of them, halved at the median of their centres.

use crate::geometry::aabb::Aabb;
use crate::geometry::scalar::{Scalar, Vec3, Vector};
use crate::parallel::{collect, should_parallelize};
use crate::primitives::Primitives;

/// The centres of boxes.
pub(crate) struct Centres<S>(Vec<[S; 3]>);

impl<S: Scalar> Centres<S> {
    /// Those of all primitives.
    pub(crate) fn of(prims: &dyn Primitives<S>) -> Self {
        Self(collect(prims.len(), |id| centre(&prims.bounds(id as u32))))
    }

    pub(crate) fn of_boxes(boxes: &[Aabb<S>]) -> Self {
        Self(boxes.iter().map(centre).collect())
    }

    /// Brings the `lower` ids with the lowest centres to the front, on the axis on which the
    /// centres spread most; equal centres are taken in the order of ids.
    pub(crate) fn cut(&self, ids: &mut [u32], lower: usize) {
        if lower >= ids.len() {
            return;
        }
        let axis = self.widest_axis(ids);
        let centre = |id: u32| self.0[id as usize][axis].to_f64();
        ids.select_nth_unstable_by(lower, |&a, &b| {
            centre(a).total_cmp(&centre(b)).then_with(|| a.cmp(&b))
        });
    }

    /// Puts neighbours next to each other: every `size` ids in a row are a group, the last one
    /// what is left. Ids are halved, by whole groups, until a group remains.
    pub(crate) fn group(&self, ids: &mut [u32], size: usize) {
        self.cut_again(ids, &|n| {
            let groups = n.div_ceil(size);
            (groups > 1).then(|| groups.div_ceil(2) * size)
        });
    }

    /// Cuts ids, then both parts, again and again, where `lower` says how many of so many come to
    /// the front; on all threads.
    pub(crate) fn cut_again(
        &self,
        ids: &mut [u32],
        lower: &(dyn Fn(usize) -> Option<usize> + Sync),
    ) {
        let Some(middle) = lower(ids.len()) else { return };
        self.cut(ids, middle);
        let pays = should_parallelize(ids.len());
        let (front, back) = ids.split_at_mut(middle);
        if pays {
            rayon::join(|| self.cut_again(front, lower), || self.cut_again(back, lower));
        } else {
            self.cut_again(front, lower);
            self.cut_again(back, lower);
        }
    }

    fn widest_axis(&self, ids: &[u32]) -> usize {
        let (mut lo, mut hi) = ([S::INFINITY; 3], [-S::INFINITY; 3]);
        for &id in ids {
            let centre = self.0[id as usize];
            for k in 0..3 {
                lo[k] = centre[k].lesser(lo[k]);
                hi[k] = centre[k].greater(hi[k]);
            }
        }
        let [min, max] = [lo, hi].map(Vec3::<S>::from_array);
        Aabb::<S> { min, max }.longest_axis()
    }
}

/// Half each, so that the sum cannot overflow.
fn centre<S: Scalar>(b: &Aabb<S>) -> [S; 3] {
    let half = S::from_f64(0.5);
    (b.min * half + b.max * half).to_array()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_full_and_next_to_each_other() {
        // 100 centres on a line, in a scrambled order
        let centres = Centres((0..100).map(|i| [f64::from(i * 37 % 100), 0.0, 0.0]).collect());
        for size in [1, 3, 7, 64, 100, 1000] {
            let mut ids: Vec<u32> = (0..100).collect();
            centres.group(&mut ids, size);
            let mut end = -1.0;
            for group in ids.chunks(size) {
                let mut at: Vec<f64> = group.iter().map(|&id| centres.0[id as usize][0]).collect();
                at.sort_by(f64::total_cmp);
                assert_eq!(at[0], end + 1.0, "size {size}");
                end = at[at.len() - 1];
            }
            assert_eq!(end, 99.0);
        }
    }

    #[test]
    fn equal_centres_are_cut_by_id() {
        let centres = Centres(vec![[1.0f32; 3]; 9]);
        let mut ids: Vec<u32> = (0..9).rev().collect();
        centres.cut(&mut ids, 4);
        assert!(ids[..4].iter().all(|&id| id < 4), "{ids:?}");
    }
}
